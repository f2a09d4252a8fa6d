//! `whyroad draft`: labels to start from, one JSON line per episode: by rule, or by a model behind `--model`.

use crate::language_model::image_kind;
use crate::model_args::{ModelArgs, cache_beside, cost, tell_all};
use crate::output::Print;
use crate::output::reason::{cannot_read, cannot_write, no_class, stop};
use crate::{Global, framework_folder, output};
use anyhow::Context as _;
use rayon::prelude::*;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use whyroad_chat::draft::{Drafter, NoDraft};
use whyroad_chat::scene::Images;
use whyroad_chat::{Client, ImageKind};
use whyroad_engine::label_drives::LabelDrives;
use whyroad_engine::recordings::LakeRecordings;
use whyroad_framework::{Framework, Resolution};
use whyroad_label::check::{Checker, Recordings as _};
use whyroad_label::draft::{Doubt, MISSING_RECORD, draft_with_seed, errors};
use whyroad_lake::{Lake, MinedFolder};
use whyroad_model::label_fields::pointer;
use whyroad_model::messages::{CocLabel, EpisodeFilter, EpisodeRecord};
use whyroad_model::scene::MediaFrame;
use whyroad_model::{Bilingual, Diagnostic, Drive, Lang, Location, counted};

/// Arguments of `whyroad draft`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Lake with the drives
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Folder that `whyroad mine` wrote
    #[arg(long, value_name = "DIR")]
    from: PathBuf,
    /// File to write (JSON Lines), for `tasks import`, `validate` and `dataset build --drafts`, there beside the mined
    /// folder, which has the scores and ids of the episodes
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Only this class (L1, L2 or leaf; full or unambiguous short id)
    #[arg(long, value_name = "ID")]
    scenario: Option<String>,
    /// Maximum number of episodes that are drafted
    #[arg(long, value_name = "N")]
    limit: Option<usize>,
    /// Language of the drafts' texts [default: that of --lang]
    #[arg(long, value_name = "LANG", value_parser = crate::arguments::lang)]
    texts: Option<Lang>,
    /// Seed of the phrasings of drafts by rule: the same one gives the same texts
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Draft by the model at this address (OpenAI-compatible, https://host/v1) instead of by rule
    #[arg(long, value_name = "URL")]
    model: Option<String>,
    /// Episodes drafted at once by a model
    #[arg(long, value_name = "N", default_value_t = 4, requires = "model",
          value_parser = clap::value_parser!(u16).range(1..=64))]
    jobs: u16,
    /// Replace FILE where it holds other drafts; without it, they are kept: a person may have corrected them
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    how: ModelArgs,
    #[command(flatten)]
    print: Print,
}

/// One episode's draft with the findings of the checks, or why it has no draft.
type Made = Result<(CocLabel, Vec<Diagnostic>), Left>;

/// Further phrasings that are tried where the checks object to a draft by rule.
const OTHER_PHRASINGS: u64 = 3;

/// Why an episode has no draft.
enum Left {
    /// The observations do not support the class.
    Doubt(Doubt),
    /// It could not be read or requested.
    Lost(Vec<Diagnostic>),
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let lake = Lake::open(&args.lake).with_context(|| cannot_read(args.lake.display()))?;
    let episodes = episodes(&args, &framework)?;
    let texts = args.texts.unwrap_or(global.lang);
    let drives = Arc::new(LabelDrives::new(lake.clone(), &framework));
    let (made, client) = match &args.model {
        None => (by_rule(&framework, &drives, &episodes, texts, args.seed), None),
        Some(url) => {
            let client = args.how.client(url, cache_beside(&args.out), global.lang)?;
            let made = by_model(&framework, &lake, &drives, &episodes, &client, texts, args.jobs)?;
            (made, Some(client))
        }
    };
    let mut lines = String::new();
    let (mut written, mut with_findings, mut incomplete, mut left_out) = (0_usize, 0_usize, 0_usize, 0_usize);
    let mut doubts: BTreeMap<Doubt, usize> = BTreeMap::new();
    for one in made {
        match one {
            // A program's label with errors is no start for anyone: it would not validate.
            Ok((label, findings)) if errors(&findings).next().is_some() => {
                *doubts.entry(Doubt::Checks).or_default() += 1;
                let of = format!("{} @ {}", label.clip_id, label.keyframe.timestamp);
                let placed: Vec<_> = errors(&findings).map(|d| unwritten(d, &of)).collect();
                tell_all(&placed, global.lang);
            }
            Ok((label, findings)) => {
                written += 1;
                // A record that the drive does not show is no fault of the draft.
                let (open, findings): (Vec<_>, Vec<_>) =
                    findings.into_iter().partition(|d| d.code == MISSING_RECORD);
                incomplete += usize::from(!open.is_empty());
                with_findings += usize::from(!findings.is_empty());
                lines.push_str(&serde_json::to_string(&label)?);
                lines.push('\n');
                let placed: Vec<_> = findings.into_iter().map(|d| in_line(d, &args.out, written)).collect();
                tell_all(&placed, global.lang);
            }
            Err(Left::Doubt(doubt)) => *doubts.entry(doubt).or_default() += 1,
            Err(Left::Lost(found)) => {
                left_out += 1;
                tell_all(&found, global.lang);
            }
        }
    }
    let is_other = |found: Vec<u8>| !found.is_empty() && found != lines.as_bytes();
    if !args.force && std::fs::read(&args.out).is_ok_and(is_other) {
        let out = args.out.display();
        return Err(stop(
            format!("{out} 中是另外的草稿，未作改动；请用 --out 指定另一个文件，或用 --force 覆盖"),
            format!(
                "{out} holds other drafts and is left as it was; name another file with --out, or replace it with --force"
            ),
        ));
    }
    std::fs::write(&args.out, &lines).with_context(|| cannot_write(args.out.display()))?;
    let spent = client.as_ref().map(Client::spent);
    let by = client.as_ref().map_or("rule", |c| c.model());
    let report = json!({
        "episodes": episodes.len(), "written": written, "with_findings": with_findings, "incomplete": incomplete,
        "left_out": left_out, "doubts": doubts, "by": by, "out": args.out, "spent": spent,
    });
    args.print.put(&report, || {
        let line = match global.lang {
            Lang::Zh => format!(
                "{} 个事件：写出 {written} 个草稿（未经人工检查，作者：{by}），其中 {with_findings} 个有检查提示，{incomplete} 个缺少须由人填写的记录项；{left_out} 个因错误没有写出\n",
                episodes.len()
            ),
            Lang::En => format!(
                "{}: {} written (by {by}, not yet checked by a person), {with_findings} with findings, {incomplete} without a record that a person has to fill in; {left_out} failed\n",
                counted(episodes.len(), "episode"),
                counted(written, "draft"),
            ),
        };
        let line = line + &in_words(&doubts, global.lang);
        spent.map_or(line.clone(), |s| format!("{line}{}\n", cost(&s, global.lang)))
    })?;
    Ok(match (written, left_out) {
        (_, 0) => output::FINE,
        (0, _) => output::FINDINGS,
        _ => output::lost_input(),
    })
}

/// The finding in the line of `out` that holds the draft, as `whyroad validate` prints it.
fn in_line(mut d: Diagnostic, out: &Path, line: usize) -> Diagnostic {
    d.location.line = Some(line);
    d.in_file(out.display().to_string())
}

/// The finding in a draft that is not written: its text has no place in any file.
fn unwritten(d: &Diagnostic, of: &str) -> Diagnostic {
    let location = Location { pointer: d.location.pointer.clone(), ..Location::default() };
    Diagnostic { location, ..d.clone() }.in_file(of.to_owned())
}

/// Number of episodes without a draft because of the observations, by reason; nothing where there are none.
fn in_words(doubts: &BTreeMap<Doubt, usize>, lang: Lang) -> String {
    let all: usize = doubts.values().sum();
    let mut lines = match (all, lang) {
        (0, _) => return String::new(),
        (_, Lang::Zh) => format!("{all} 个事件没有写草稿，原因：\n"),
        (1, Lang::En) => "1 episode has no draft, because:\n".to_owned(),
        (_, Lang::En) => format!("{all} episodes have no draft, because:\n"),
    };
    for (doubt, n) in doubts {
        lines += &format!("  {n:>5}  {}\n", doubt.text().get(lang));
    }
    lines
}

/// The requested primary episodes, in the order of drive and keyframe.
fn episodes(args: &Args, framework: &Framework) -> anyhow::Result<Vec<EpisodeRecord>> {
    let Some(folder) = MinedFolder::open(&args.from) else {
        return Err(stop(
            format!("{} 中没有挖掘出的事件；用 `whyroad mine --out DIR` 生成", args.from.display()),
            format!("{} holds no mined episodes; `whyroad mine --out DIR` writes them", args.from.display()),
        ));
    };
    let scenario = match args.scenario.as_deref().map(|text| (text, framework.taxonomy.resolve(text))) {
        None => None,
        Some((_, Resolution::Found(id))) => Some(id),
        Some((text, _)) => return Err(no_class(text)),
    };
    // Its files belong together: a draft that replaces one of them would make the folder unreadable.
    let folder_of_out = args.out.parent().map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p });
    let is_inside = folder_of_out
        .zip(args.from.canonicalize().ok())
        .is_some_and(|(out, from)| out.canonicalize().is_ok_and(|out| out == from) && args.out.exists());
    if is_inside {
        let out = args.out.display();
        return Err(stop(
            format!("{out} 是挖掘结果的一部分，不能覆盖；用 --out 指定另一个文件"),
            format!("{out} is a part of the mined folder and is not replaced; name another file with --out"),
        ));
    }
    let filter = EpisodeFilter { scenario, primary_only: true, ..EpisodeFilter::default() };
    let mut all = folder.index()?.page(&filter, None, usize::MAX)?.episodes;
    all.retain(|e| e.scenario_id.l2.is_some());
    all.truncate(args.limit.unwrap_or(usize::MAX));
    Ok(all)
}

/// Codes of findings that other words of the trace may remove, besides those that point to the trace.
const OF_WORDS: [&str; 3] = ["label.text.class", "label.decision.unchanged", "label.cause.proximate"];

/// Other words of the trace may remove the finding: it is not only about the decision, the components or the records,
/// which are the same in every phrasing.
fn is_of_words(d: &Diagnostic) -> bool {
    d.location.pointer.as_deref() == Some(pointer::COC_TRACE) || OF_WORDS.contains(&d.code)
}

fn by_rule(
    framework: &Framework,
    drives: &Arc<LabelDrives>,
    episodes: &[EpisodeRecord],
    texts: Lang,
    seed: u64,
) -> Vec<Made> {
    let checker = Checker::new(framework).with_recordings(Arc::clone(drives) as Arc<_>);
    let one = |episode: &EpisodeRecord| -> Made {
        let recorded = drives.of_clip(episode.clip_id.as_str());
        let recorded = recorded.ok_or_else(|| Left::Lost(vec![no_drive(episode)]))?;
        is_of_drive(episode, &recorded.drive)?;
        let checked = |seed| -> Made {
            let made = draft_with_seed(framework, &recorded.drive, &recorded.signals, episode, texts, seed);
            if let Some(doubt) = made.doubt {
                return Err(Left::Doubt(doubt));
            }
            let findings = checker.check_text(&serde_json::to_string(&made.label).unwrap_or_default());
            Ok((made.label, findings))
        };
        let first = checked(seed)?;
        if !first.1.iter().any(is_of_words) {
            return Ok(first);
        }
        let mut others = (1..=OTHER_PHRASINGS).filter_map(|n| checked(seed.wrapping_add(n)).ok());
        Ok(others.find(|(_, found)| !found.iter().any(is_of_words)).unwrap_or(first))
    };
    let bar = output::progress(episodes.len());
    let made = episodes.iter().map(|episode| {
        let made = one(episode);
        bar.inc(1);
        made
    });
    let made = made.collect();
    bar.finish_and_clear();
    made
}

fn by_model(
    framework: &Framework,
    lake: &Lake,
    drives: &Arc<LabelDrives>,
    episodes: &[EpisodeRecord],
    client: &Client,
    texts: Lang,
    jobs: u16,
) -> anyhow::Result<Vec<Made>> {
    let checker = Checker::new(framework).with_recordings(Arc::clone(drives) as Arc<_>);
    let images = LakeImages(LakeRecordings::open(lake.clone(), &[], &[])?);
    let drafter = Drafter { client, framework, checker: &checker, images: &images, lang: texts };
    // After an error that ends the run the others are not tried: each would fail in the same way.
    let ended = AtomicBool::new(false);
    let bar = output::progress(episodes.len());
    let one = |episode: &EpisodeRecord| -> Option<Made> {
        if ended.load(Ordering::Relaxed) {
            return None;
        }
        let made = (|| {
            let measured = images.0.drive(&episode.drive_id).ok();
            let recorded = drives.of_clip(episode.clip_id.as_str());
            let Some((measured, recorded)) = measured.zip(recorded) else {
                return Err(Left::Lost(vec![no_drive(episode)]));
            };
            is_of_drive(episode, &recorded.drive)?;
            match drafter.draft(&measured, &recorded, episode) {
                Ok(made) => Ok((made.label, made.findings)),
                Err(why) => {
                    if matches!(&why, NoDraft::Chat(e) if e.ends_the_run()) {
                        ended.store(true, Ordering::Relaxed);
                    }
                    Err(Left::Lost(of_episode(why, episode)))
                }
            }
        })();
        bar.inc(1);
        Some(made)
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(jobs)).build()?;
    let made: Vec<Option<Made>> = pool.install(|| episodes.par_iter().with_max_len(1).map(one).collect());
    bar.finish_and_clear();
    Ok(made.into_iter().map(|m| m.unwrap_or_else(|| Err(Left::Lost(Vec::new())))).collect())
}

/// Findings without a location belong to the episode.
fn of_episode(why: NoDraft, episode: &EpisodeRecord) -> Vec<Diagnostic> {
    let place = |d: Diagnostic| match &d.location.file {
        Some(_) => d,
        None => d.in_file(format!("{} @ {}", episode.clip_id, episode.keyframe.timestamp)),
    };
    let ends = matches!(&why, NoDraft::Chat(e) if e.ends_the_run());
    let found = why.diagnostics().into_iter();
    if ends { found.collect() } else { found.map(place).collect() }
}

fn no_drive(episode: &EpisodeRecord) -> Diagnostic {
    let (id, drive) = (&episode.episode_id, &episode.drive_id);
    let message = Bilingual::new(
        format!("事件 {id}：数据湖中没有行程 {drive}，或无法读取"),
        format!("episode {id}: the lake has no drive {drive}, or it cannot be read"),
    );
    Diagnostic::error("draft.drive", message)
}

/// An error where the drive does not have what the episode is about: it was replaced after it was mined.
fn is_of_drive(episode: &EpisodeRecord, drive: &Drive) -> Result<(), Left> {
    let at = episode.keyframe.timestamp;
    let is_within =
        drive.times.first().is_some_and(|t| *t <= at) && drive.times.last().is_some_and(|t| at <= *t);
    let (id, of) = (&episode.episode_id, &episode.drive_id);
    let message = match &episode.target_id {
        _ if !is_within => Bilingual::new(
            format!("事件 {id}：关键帧 {at} 不在行程 {of} 内"),
            format!("episode {id}: its keyframe, {at}, is not in drive {of}"),
        ),
        Some(target) if drive.track(target).is_none() => Bilingual::new(
            format!("事件 {id}：行程 {of} 中没有目标 {target}"),
            format!("episode {id}: drive {of} has no object {target}"),
        ),
        _ => return Ok(()),
    };
    let hint = Bilingual::new(
        "行程在挖掘之后被替换：重新运行 `whyroad mine`",
        "the drive was replaced after it was mined: run `whyroad mine` again",
    );
    Err(Left::Lost(vec![Diagnostic::error("draft.drive", message).with_hint(hint)]))
}

/// Camera images of a lake.
pub(super) struct LakeImages(pub LakeRecordings);

impl Images for LakeImages {
    fn image(&self, drive: &Drive, frame: &MediaFrame) -> Option<(ImageKind, Vec<u8>)> {
        let id = &drive.meta.drive_id;
        let Some(path) = self.0.media(id, frame) else {
            let stored = self.0.stored_image(id, frame).ok()??;
            let kind = image_kind(Path::new(&stored.media.key))?;
            return Some((kind, stored.store.read(&stored.media).ok()??));
        };
        let kind = image_kind(&path)?;
        Some((kind, std::fs::read(path).ok()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(code: &'static str, pointer: &str) -> Diagnostic {
        let location = Location {
            line: Some(1),
            column: Some(9),
            pointer: Some(pointer.to_owned()),
            ..Location::default()
        };
        Diagnostic::warning(code, Bilingual::new("", "")).at(location)
    }

    #[test]
    fn other_phrasings_are_tried_only_where_they_may_help() {
        assert!(is_of_words(&finding("label.cause.circular", pointer::COC_TRACE)));
        assert!(is_of_words(&finding("label.text.class", pointer::SCENARIO)));
        for (code, at) in [
            ("label.cause.no_effect", pointer::CAUSES_LONGITUDINAL),
            ("label.motion.contradicts", pointer::DRIVING_DECISION_LONGITUDINAL),
            ("label.object.position", "/critical_components/0/description"),
        ] {
            assert!(!is_of_words(&finding(code, at)), "{code}");
        }
    }

    #[test]
    fn a_finding_is_in_the_line_of_its_draft() {
        let d = in_line(finding("label.cause.circular", pointer::COC_TRACE), Path::new("d.jsonl"), 7);
        let Location { file, line, column, .. } = d.location;
        assert_eq!((file.as_deref(), line, column), (Some("d.jsonl"), Some(7), Some(9)));
    }

    #[test]
    fn one_is_not_said_in_the_plural() {
        let doubts = |n| in_words(&[(Doubt::Words, n)].into(), Lang::En);
        assert!(doubts(1).starts_with("1 episode has no draft"), "{}", doubts(1));
        assert!(doubts(2).starts_with("2 episodes have no draft"), "{}", doubts(2));
    }
}
