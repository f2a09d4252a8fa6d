//! `whyroad other`: moments that no class explains, grouped by similarity, with the nearest classes.

pub(super) mod moments;

use crate::arguments::share;
use crate::cmd::tasks::import_lines;
use crate::output::reason::{cannot_read, cannot_write};
use crate::output::{Print, render_text};
use crate::{Global, framework_folder, output, store_args};
use anyhow::Context as _;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_dataset::similar::{self, EpisodeDescriptor};
use whyroad_engine::drives::map_drives;
use whyroad_engine::mine::signals_of;
use whyroad_framework::Framework;
use whyroad_lake::mined::MinedFile;
use whyroad_lake::{Lake, LakeError, MinedFolder};
use whyroad_mining::RuleSet;
use whyroad_mining::rule::OTHER;
use whyroad_mining::rule::Rule;
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{Bilingual, Diagnostic, Drive, DriveId, Lang};
use whyroad_render::birds_eye;
use whyroad_render::markup::Markup;
use whyroad_report::coverage::class_title;
use whyroad_report::unexplained::{Unexplained, UnexplainedMoment, page, render};
use whyroad_signals::Catalog;

/// Arguments of `whyroad other`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Folder that `whyroad mine` wrote, with the rules of the framework
    #[arg(long, value_name = "DIR")]
    episodes: PathBuf,
    /// Lake that was mined
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Minimum similarity of moments of one group with its example, 0 to 1 (docs/reference/release.md)
    #[arg(long, value_name = "SHARE", default_value_t = 0.6, value_parser = share)]
    similarity: f64,
    /// Maximum number of groups, the largest first
    #[arg(long, value_name = "N")]
    limit: Option<usize>,
    /// Also write a page with the scene of each group
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
    /// Make a labeling task of each group's example, as an episode of the nearest class, in this project
    #[arg(long, value_name = "PROJECT")]
    to_tasks: Option<String>,
    /// Number of drives processed at once [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    #[command(flatten)]
    store: store_args::StoreArgs,
    #[command(flatten)]
    print: Print,
}

/// A moment, its source, and its descriptor.
struct Found {
    moment: UnexplainedMoment,
    record: EpisodeRecord,
    descriptor: Option<EpisodeDescriptor>,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let (catalog, _) = Catalog::parse(&framework.signals_yaml);
    let (rules, faults) = RuleSet::of_framework(&framework, &catalog);
    let faults = framework_folder::placed(global.framework.as_deref(), faults);
    faults.iter().for_each(|d| tell!("{}", render_text(d, global.lang)));
    let lake = match Lake::open(&args.lake) {
        Ok(lake) => lake,
        Err(e) => {
            tell!("{}", render_text(&e.diagnostic(), global.lang));
            return Ok(output::FINDINGS);
        }
    };
    let (by_drive, mut lost) = unexplained(&args.episodes)?;
    // Signals derived on demand are not stored, and no rule of a class uses them.
    let rules: Vec<Rule> = rules.rules.into_iter().filter(|r| r.on_demand().is_none()).collect();
    let ids: Vec<DriveId> = by_drive.keys().cloned().collect();
    let one = |id: &DriveId| of_drive(&lake, id, &by_drive[id], &rules, &framework);
    let mut found: Vec<Found> = Vec::new();
    map_drives(&ids, args.jobs.map(usize::from), one, |of_drive| {
        match of_drive {
            Ok(moments) => found.extend(moments),
            Err(e) => lost.push(e.diagnostic()),
        }
        anyhow::Ok(())
    })?;
    let moments: Vec<UnexplainedMoment> = found.iter().map(|f| f.moment.clone()).collect();
    let descriptors: Vec<_> = found.iter().map(|f| f.descriptor.clone()).collect();
    let groups = similar::groups(&descriptors, args.similarity);
    let groups: Vec<(usize, Vec<usize>)> = groups.into_iter().map(|g| (g.center, g.members)).collect();
    let mut result = Unexplained::new(&moments, &groups, |id| class_title(&framework.taxonomy, id));
    result.groups.truncate(args.limit.unwrap_or(usize::MAX));
    args.print.put(&result, || render(&result, global.lang))?;
    if let Some(file) = &args.page {
        std::fs::write(file, page(&result, &scenes(&lake, &result), global.lang))
            .with_context(|| cannot_write(file.display()))?;
        say!("{}", file.display());
    }
    for d in &lost {
        tell!("{}", render_text(d, global.lang));
    }
    let mut complete = lost.is_empty();
    if let Some(project) = &args.to_tasks {
        let records: BTreeMap<&str, &EpisodeRecord> =
            found.iter().map(|f| (f.record.episode_id.as_str(), &f.record)).collect();
        complete &= propose(global, &args, project, &result, &records)?;
    }
    Ok(if complete { output::FINE } else { output::lost_input() })
}

/// Episodes by drive.
type ByDrive = BTreeMap<DriveId, Vec<EpisodeRecord>>;

/// The episodes of `other` of a mined folder, and the unreadable lines.
fn unexplained(dir: &Path) -> anyhow::Result<(ByDrive, Vec<Diagnostic>)> {
    let mined =
        MinedFolder::open(dir).with_context(|| cannot_read(MinedFile::Episodes.path(dir).display()))?;
    let (mut by_drive, mut lost) = (ByDrive::new(), Vec::new());
    for line in mined.episodes()? {
        match line {
            Ok(e) if e.scenario_id.l1 == OTHER => by_drive.entry(e.drive_id.clone()).or_default().push(e),
            Ok(_) => {}
            Err(d) => lost.push(*d),
        }
    }
    Ok((by_drive, lost))
}

fn of_drive(
    lake: &Lake,
    id: &DriveId,
    records: &[EpisodeRecord],
    rules: &[Rule],
    framework: &Framework,
) -> Result<Vec<Found>, LakeError> {
    let table = signals_of(lake, id)?;
    let drive = whyroad_engine::estimated(lake.read_drive(id)?);
    let descriptors = similar::describe(framework, &drive, records);
    let one = |(record, descriptor): (&EpisodeRecord, Option<EpisodeDescriptor>)| {
        let moment = moments::of_record(record, &record.clip_id, rules, &table);
        Found { moment, record: record.clone(), descriptor }
    };
    Ok(records.iter().zip(descriptors).map(one).collect())
}

/// The scene of each group's example.
fn scenes(lake: &Lake, of: &Unexplained) -> Vec<Markup> {
    let mut last: Option<(DriveId, Drive)> = None;
    let mut scene = |id: &DriveId, moment: &UnexplainedMoment| -> Option<Markup> {
        if last.as_ref().is_none_or(|(known, _)| known != id) {
            last = Some((id.clone(), whyroad_engine::estimated(lake.read_drive(id).ok()?)));
        }
        let (_, drive) = last.as_ref()?;
        let frame = drive.times.partition_point(|t| *t < moment.keyframe);
        let target = moment.nearest.first().and_then(|c| c.target_id.as_ref());
        Some(birds_eye::render(drive, frame, target))
    };
    let one = |g: &whyroad_report::unexplained::UnexplainedGroup| {
        scene(&g.example.drive_id, &g.example).unwrap_or_default()
    };
    of.groups.iter().map(one).collect()
}

/// A task for each group's example: an episode of the nearest class, which the annotator may change.
fn propose(
    global: &Global,
    args: &Args,
    project: &str,
    of: &Unexplained,
    records: &BTreeMap<&str, &EpisodeRecord>,
) -> anyhow::Result<bool> {
    let mut lines = String::new();
    for g in &of.groups {
        let Some(near) = g.example.nearest.first() else { continue };
        let Some(record) = records.get(g.example.episode_id.as_str()) else { continue };
        let proposed = EpisodeRecord {
            scenario_id: near.scenario_id.clone(),
            target_id: near.target_id.clone(),
            is_primary: true,
            primary_episode_id: None,
            keyframe_rule: Bilingual::new(
                format!(
                    "没有类别能解释此刻；最接近 {}（{} 个条件中 {} 个成立）",
                    near.scenario_id, near.conditions, near.held
                ),
                format!(
                    "no class explains this moment; nearest is {} ({} of {} conditions)",
                    near.scenario_id, near.held, near.conditions
                ),
            ),
            ..(*record).clone()
        };
        lines += &format!("{}\n", serde_json::to_string(&proposed)?);
    }
    let made = import_lines(global, &args.store, (&args.lake, None), project, &lines)?;
    for lost in &made.lost {
        say!("{}", lost.text.get(global.lang));
    }
    let failed = made.lost.len() + made.more as usize;
    let (new, known) = (made.tasks, made.known);
    match global.lang {
        Lang::Zh => say!("项目 {project}：新建 {new} 个任务；已有 {known}；{failed} 个无法建任务"),
        Lang::En => {
            say!(
                "project {project}: {new} tasks created; {known} already present; {failed} could not be created"
            )
        }
    }
    Ok(failed == 0)
}
