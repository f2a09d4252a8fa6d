//! `whyroad judge`: true/false questions about labels, answered by a model; people answer them for a share of the
//! labels.

use super::draft::LakeImages;
use crate::arguments::share;
use crate::model_args::{ModelArgs, cache_beside, cost, tell_all};
use crate::output::Print;
use crate::output::reason::{cannot_read, cannot_write};
use crate::{Global, framework_folder, output};
use anyhow::Context as _;
use rayon::prelude::*;
use serde_json::json;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use whyroad_chat::judge::{Judge, JudgedLabel, QuestionKind, is_for_people};
use whyroad_engine::label_drives::{LabelDrives, drive_of_clip};
use whyroad_engine::recordings::LakeRecordings;
use whyroad_label::check::Recordings as _;
use whyroad_lake::Lake;
use whyroad_model::messages::CocLabel;
use whyroad_model::{Bilingual, Diagnostic, Lang};

/// Arguments of `whyroad judge`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Labels: JSON Lines of `tasks export`, `draft` or `labels import`
    #[arg(value_name = "FILE")]
    labels: PathBuf,
    /// Lake with the drives
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// The model at this address (OpenAI-compatible, https://host/v1)
    #[arg(long, value_name = "URL")]
    model: String,
    /// File to write (JSON Lines): the questions with the model's answers
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// File to write for people: the same questions about a share of the labels, without answers; `answer` is to be
    /// filled in with true or false, and `whyroad agreement` compares
    #[arg(long, value_name = "FILE")]
    people: Option<PathBuf>,
    /// Share of the labels for which people answer, 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = 0.1, value_parser = share)]
    people_share: f64,
    /// Seed of the choice of these labels
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Maximum number of labels
    #[arg(long, value_name = "N")]
    limit: Option<usize>,
    /// Language of the questions [default: that of --lang]
    #[arg(long, value_name = "LANG")]
    texts: Option<Lang>,
    /// Labels judged at once
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=64))]
    jobs: u16,
    #[command(flatten)]
    how: ModelArgs,
    #[command(flatten)]
    print: Print,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let lake = Lake::open(&args.lake).with_context(|| cannot_read(args.lake.display()))?;
    let (mut labels, faults) = labels(&args)?;
    tell_all(&faults, global.lang);
    labels.truncate(args.limit.unwrap_or(usize::MAX));
    let client = args.how.client(&args.model, cache_beside(&args.out), global.lang)?;
    let drives = LabelDrives::new(lake.clone(), &framework);
    let images = LakeImages(LakeRecordings::open(lake, &[], &[])?);
    let texts = args.texts.unwrap_or(global.lang);
    let judge = Judge { client: &client, framework: &framework, images: &images, lang: texts };
    let ended = AtomicBool::new(false);
    let bar = output::progress(labels.len());
    let one = |label: &CocLabel| -> Result<JudgedLabel, Vec<Diagnostic>> {
        if ended.load(Ordering::Relaxed) {
            return Err(Vec::new());
        }
        let place = format!("{} @ {}", label.clip_id, label.keyframe.timestamp);
        let measured = drive_of_clip(&label.clip_id).and_then(|id| images.0.drive(&id).ok());
        let recorded = drives.of_clip(&label.clip_id);
        let Some((measured, recorded)) = measured.zip(recorded) else {
            return Err(vec![no_drive().in_file(place)]);
        };
        let for_people = is_for_people(label, args.people_share, args.seed);
        let judged = judge.judge(&measured, &recorded, label, for_people);
        bar.inc(1);
        match judged {
            Ok(Some(judged)) => Ok(judged),
            Ok(None) => Err(vec![no_drive().in_file(place)]),
            Err(e) => {
                if e.ends_the_run() {
                    ended.store(true, Ordering::Relaxed);
                }
                Err(vec![e.diagnostic().in_file(place)])
            }
        }
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(args.jobs)).build()?;
    let made: Vec<_> = pool.install(|| labels.par_iter().with_max_len(1).map(one).collect());
    bar.finish_and_clear();
    let (mut judged, mut lost) = (Vec::new(), faults.len());
    for one in made {
        match one {
            Ok(j) => judged.push(j),
            Err(found) => {
                lost += 1;
                tell_all(&found, global.lang);
            }
        }
    }
    write(&args.out, judged.iter())?;
    let people: Vec<JudgedLabel> = judged.iter().filter(|j| j.for_people).map(JudgedLabel::blank).collect();
    if let Some(path) = &args.people {
        write(path, people.iter())?;
    }
    let summary = Summary { judged: &judged, for_people: people.len(), lost };
    let spent = client.spent();
    let report = json!({
        "labels": labels.len(), "judged": judged.len(), "not_judged": lost, "for_people": people.len(),
        "passed": summary.passed(), "kinds": summary.kinds(), "model": client.model(), "out": args.out,
        "spent": spent,
    });
    args.print.put(&report, || format!("{}{}\n", summary.text(global.lang), cost(&spent, global.lang)))?;
    Ok(match (judged.len(), lost) {
        (_, 0) => output::FINE,
        (0, _) => output::FINDINGS,
        _ => output::lost_input(),
    })
}

/// The labels of a file; a line that is not a label is reported. Lines of tasks hold their label in `draft`.
fn labels(args: &Args) -> anyhow::Result<(Vec<CocLabel>, Vec<Diagnostic>)> {
    let name = args.labels.display().to_string();
    let text = std::fs::read_to_string(&args.labels).with_context(|| cannot_read(&name))?;
    let (mut labels, mut faults) = (Vec::new(), Vec::new());
    for (i, line) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()) {
        let value: Result<serde_json::Value, _> = serde_json::from_str(line);
        let label = value.and_then(|v| {
            let label = v.pointer("/task/draft").cloned().unwrap_or(v);
            serde_json::from_value::<CocLabel>(label)
        });
        match label {
            Ok(label) => labels.push(label),
            Err(e) => {
                let message = Bilingual::new(format!("不是标注：{e}"), format!("not a label: {e}"));
                faults.push(Diagnostic::error("judge.label", message).in_file(format!("{name}:{}", i + 1)));
            }
        }
    }
    Ok((labels, faults))
}

fn no_drive() -> Diagnostic {
    let message = Bilingual::new(
        "数据湖中没有该标注的行程，或关键帧时刻没有自车位姿",
        "the lake does not have the drive of the label, or no pose of the ego at its keyframe",
    );
    Diagnostic::error("judge.label", message)
}

fn write<'j>(path: &std::path::Path, judged: impl Iterator<Item = &'j JudgedLabel>) -> anyhow::Result<()> {
    let mut lines = String::new();
    for j in judged {
        lines.push_str(&serde_json::to_string(j)?);
        lines.push('\n');
    }
    std::fs::write(path, lines).with_context(|| cannot_write(path.display()))
}

/// Counts for the report.
struct Summary<'j> {
    judged: &'j [JudgedLabel],
    for_people: usize,
    lost: usize,
}

impl Summary<'_> {
    fn passed(&self) -> usize {
        self.judged.iter().filter(|j| j.passed == Some(true)).count()
    }

    /// By kind: statements, and those whose answer differs from that of a correct label.
    fn kinds(&self) -> BTreeMap<&'static str, serde_json::Value> {
        let count = |kind: QuestionKind| {
            let all = self.judged.iter().flat_map(|j| &j.questions).filter(|q| q.kind == kind);
            all.fold((0, 0), |(n, failed), q| (n + 1, failed + usize::from(q.passed() == Some(false))))
        };
        let rows = QuestionKind::ALL.map(|kind| (kind.id(), count(kind)));
        rows.into_iter().map(|(id, (n, failed))| (id, json!({ "questions": n, "failed": failed }))).collect()
    }

    fn text(&self, lang: Lang) -> String {
        let mut out = String::new();
        for (kind, counts) in self.kinds() {
            let (n, failed) = (&counts["questions"], &counts["failed"]);
            let _ = match lang {
                Lang::Zh => writeln!(out, "{kind:<16} {n:>5} 题，{failed} 题不符"),
                Lang::En => writeln!(out, "{kind:<16} {n:>5} questions, {failed} failed"),
            };
        }
        let (n, passed, people, lost) = (self.judged.len(), self.passed(), self.for_people, self.lost);
        let _ = match lang {
            Lang::Zh => writeln!(
                out,
                "{n} 个标注已判定，{passed} 个全部通过；{lost} 个未判定；{people} 个交由人工复核。结果只是模型的回答，须与人工对照后才可使用"
            ),
            Lang::En => writeln!(
                out,
                "{n} labels judged, {passed} without a fault; {lost} not judged; {people} for people. These are a model's answers: compare them with people's before use"
            ),
        };
        out
    }
}
