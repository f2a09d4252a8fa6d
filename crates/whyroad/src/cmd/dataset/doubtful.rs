//! `whyroad dataset doubtful`.

use super::{print, refused, score};
use crate::cmd::tasks::import_lines;
use crate::output::{self, DataFormat};
use crate::{Global, framework_folder, store_args};
use anyhow::bail;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use whyroad_dataset::baseline::{self, Settings, folds};
use whyroad_dataset::doubtful::{DoubtfulLabels, find};
use whyroad_dataset::score::Target;
use whyroad_dataset::score::predictions::Predictions;
use whyroad_dataset::{DatasetError, Release};
use whyroad_model::Lang;

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
    /// Create review tasks in this project, with the doubtful labels as drafts
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
        let Some(lake) = &a.lake else { bail!("--to-tasks needs --lake") };
        let lines = match labels(&release, &found) {
            Ok(lines) => lines,
            Err(e) => return Ok(refused(global, &e)),
        };
        let made = import_lines(global, &a.store, lake, project, &lines)?;
        for lost in &made.lost {
            say!("{}", lost.text.get(global.lang));
        }
        let (new, known, failed) = (made.tasks, made.known, made.lost.len() + made.more as usize);
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
        if failed > 0 {
            return Ok(output::lost_input());
        }
    }
    Ok(if lost.is_empty() { output::FINE } else { output::lost_input() })
}

/// The labels as lines, in the order of `found`.
fn labels(release: &Release, found: &DoubtfulLabels) -> Result<String, DatasetError> {
    let ids: BTreeSet<&str> = found.labels.iter().map(|d| d.sample_id.as_str()).collect();
    let mut by_id = std::collections::BTreeMap::new();
    for sample in release.samples(None) {
        let sample = sample?;
        if ids.contains(sample.sample_id.as_str()) {
            by_id.insert(sample.sample_id, sample.label_json);
        }
    }
    let lines = found.labels.iter().filter_map(|d| by_id.get(&d.sample_id));
    Ok(lines.fold(String::new(), |out, line| out + line + "\n"))
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
