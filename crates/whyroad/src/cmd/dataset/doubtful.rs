//! `whyroad dataset doubtful`.

use super::{print, refused, score};
use crate::cmd::tasks::import_lines;
use crate::output::reason::stop;
use crate::output::{self, DataFormat};
use crate::{Global, framework_folder, store_args};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_dataset::baseline::{self, Settings, folds};
use whyroad_dataset::doubtful::{Doubtful, DoubtfulLabels, find};
use whyroad_dataset::score::Target;
use whyroad_dataset::score::predictions::Predictions;
use whyroad_dataset::{DatasetError, Release};
use whyroad_model::Lang;
use whyroad_server::service::review::{self, Doubt, Review};
use whyroad_server::store::StoreLocation;

/// Arguments of `whyroad dataset doubtful`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// The release
    #[arg(value_name = "RELEASE")]
    release: PathBuf,
    /// Field of the label to check
    #[arg(long, value_enum, default_value = "leaf")]
    target: TargetArg,
    /// Out-of-fold probabilities of another model, JSON Lines [default: those of the baseline]
    #[arg(long, value_name = "FILE")]
    probabilities: Option<PathBuf>,
    /// Folds of the baseline; whole drives are held out
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u8).range(2..=100))]
    folds: u8,
    /// Seed of the baseline
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Maximum number of labels, most doubtful first
    #[arg(long, value_name = "N")]
    limit: Option<usize>,
    /// Send the labels back for review: a label of the store goes to rework in its own task; for every other one this
    /// project gets a new task with the label as its draft
    #[arg(long, value_name = "PROJECT", requires = "lake")]
    to_tasks: Option<String>,
    /// Lake that has the drives (with --to-tasks)
    #[arg(long, value_name = "DIR")]
    lake: Option<PathBuf>,
    #[command(flatten)]
    store: store_args::StoreArgs,
    /// How to print the result
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    format: DataFormat,
}

/// A field of the label.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum TargetArg {
    /// Longitudinal decision
    Longitudinal,
    /// Lateral decision
    Lateral,
    /// Class
    Leaf,
}

impl From<TargetArg> for Target {
    fn from(target: TargetArg) -> Self {
        match target {
            TargetArg::Longitudinal => Self::Longitudinal,
            TargetArg::Lateral => Self::Lateral,
            TargetArg::Leaf => Self::Leaf,
        }
    }
}

pub(super) fn run(global: &Global, a: &Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let (release, rows) = match Release::open(&a.release).and_then(|r| Ok((baseline::rows(&r, None)?, r))) {
        Ok((rows, release)) => (release, rows),
        Err(e) => return Ok(refused(global, &e)),
    };
    let target = a.target.into();
    let (probabilities, mut lost): (Predictions, _) = match &a.probabilities {
        Some(path) => score::read(path, &framework)?,
        None => {
            let settings = Settings { seed: a.seed, ..Settings::default() };
            (folds::out_of_fold(&rows, target, a.folds.into(), settings), vec![])
        }
    };
    let truth: Vec<_> = rows.into_iter().map(|r| r.truth).collect();
    let (mut found, missing) = find(&truth, &probabilities, target);
    lost.extend(missing);
    print(global, &lost);
    let all = found.labels.len();
    found.labels.truncate(a.limit.unwrap_or(all));
    output::put(&match a.format {
        DataFormat::Json => format!("{}\n", serde_json::to_string_pretty(&found)?),
        DataFormat::Text => text(&found, all, global.lang),
    });
    if let Some(project) = &a.to_tasks {
        let Some(lake) = &a.lake else {
            return Err(stop("--to-tasks 需要 --lake", "--to-tasks needs --lake"));
        };
        return send_back(global, a, &release, &found, (project, lake), lost.is_empty());
    }
    Ok(if lost.is_empty() { output::FINE } else { output::lost_input() })
}

/// Labels that came from a task of the store go to rework there; the others become drafts of new tasks.
fn send_back(
    global: &Global,
    a: &Args,
    release: &Release,
    found: &DoubtfulLabels,
    (project, lake): (&str, &Path),
    complete: bool,
) -> anyhow::Result<ExitCode> {
    let doubts = match doubts(release, found) {
        Ok(doubts) => doubts,
        Err(e) => return Ok(refused(global, &e)),
    };
    let has_store = match a.store.location() {
        StoreLocation::File(path) => path.is_file(),
        StoreLocation::Server(_) => true,
    };
    let done = if has_store {
        let store = a.store.open_existing(global.lang)?;
        review::ask(&store, &doubts, now_ms()).map_err(|p| store_args::error(&p, global.lang))?
    } else {
        vec![Review::Unknown; doubts.len()]
    };
    let count = |what: Review| done.iter().filter(|d| **d == what).count();
    let (reopened, in_work) = (count(Review::Reopened), count(Review::InWork));
    let (changed, left_out) = (count(Review::Changed), count(Review::LeftOut));
    match global.lang {
        Lang::Zh => say!(
            "{reopened} 条标注退回原任务返工；{in_work} 个任务正在处理；{changed} 条在发布后已修改；{left_out} 个任务已跳过或拒绝"
        ),
        Lang::En => say!(
            "{reopened} labels sent to rework in their tasks; {in_work} tasks already in work; {changed} labels changed since the release; {left_out} tasks skipped or rejected"
        ),
    }
    let new = doubts.iter().zip(&done).filter(|(_, d)| **d == Review::Unknown);
    let lines: String = new.map(|(d, _)| format!("{}\n", d.label)).collect();
    let mut failed = 0;
    if !lines.is_empty() {
        let made = import_lines(global, &a.store, (lake, None), project, &lines)?;
        for lost in &made.lost {
            say!("{}", lost.text.get(global.lang));
        }
        failed = made.lost.len() + made.more as usize;
        let (new, known) = (made.tasks, made.known);
        match global.lang {
            Lang::Zh => {
                say!("项目 {project}：新建 {new} 个复核任务；已有 {known}；{failed} 条标签无法建任务")
            }
            Lang::En => {
                say!(
                    "project {project}: {new} review tasks created; {known} already present; {failed} labels without a task"
                )
            }
        }
    }
    Ok(if complete && failed == 0 { output::FINE } else { output::lost_input() })
}

/// Milliseconds since 1970.
fn now_ms() -> i64 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    since.map_or(0, |d| i64::try_from(d.as_millis()).unwrap_or(i64::MAX))
}

/// The doubtful labels with their tasks, in the order of `found`.
fn doubts(release: &Release, found: &DoubtfulLabels) -> Result<Vec<Doubt>, DatasetError> {
    let by_id: BTreeMap<&str, &Doubtful> = found.labels.iter().map(|d| (d.sample_id.as_str(), d)).collect();
    let mut out = BTreeMap::new();
    for sample in release.samples(None) {
        let sample = sample?;
        let Some(d) = by_id.get(sample.sample_id.as_str()) else { continue };
        let note = format!(
            "doubtful {}: {} has probability {:.3}, {} has {:.3} (release {} {}, sample {})",
            found.target.name(),
            d.given,
            d.given_probability,
            d.suggested,
            d.suggested_probability,
            release.manifest.name,
            release.manifest.version,
            d.sample_id
        );
        let label =
            serde_json::from_str(&sample.label_json).map_err(|e| DatasetError::broken(release.dir(), e))?;
        out.insert(sample.sample_id, Doubt { task: sample.lineage.task_id.unwrap_or_default(), label, note });
    }
    Ok(found.labels.iter().filter_map(|d| out.remove(&d.sample_id)).collect())
}

fn text(found: &DoubtfulLabels, all: usize, lang: Lang) -> String {
    let (samples, target) = (found.samples, found.target.name());
    let share = found.noise.map_or("-".to_owned(), |n| format!("{:.1} %", n * 100.0));
    let mut out = match lang {
        Lang::Zh => format!("{target}：检查 {samples} 个样本，{all} 个标签存疑；估计错误率 {share}\n"),
        Lang::En => format!(
            "{target}: {samples} samples checked, {all} doubtful labels; estimated error rate {share}\n"
        ),
    };
    for d in &found.labels {
        let _ = writeln!(
            out,
            "  {}  {:.3} {} -> {:.3} {}  {}",
            d.sample_id, d.given_probability, d.given, d.suggested_probability, d.suggested, d.drive_id
        );
    }
    out
}
