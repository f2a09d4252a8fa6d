//! `whyroad labels import`: causal texts of other tools as drafts of labels, one JSON line each.

mod sources;

use crate::arguments::time;
use crate::output::Print;
use crate::output::reason::{cannot_read, cannot_write, reason, stop};
use crate::{Global, framework_folder, output};
use anyhow::Context as _;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_framework::Resolution;
use whyroad_label::import::{self, Place};
use whyroad_lake::Lake;
use whyroad_model::messages::ScenarioLabel;
use whyroad_model::{Diagnostic, DriveId, Lang, Nanos, ScenarioId, Severity, counted};

/// Arguments of `whyroad labels`.
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// Read causal texts of other tools and write drafts of labels, for `tasks import` and `dataset build`
    Import(Import),
}

/// Formats of causal texts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum SourceFormat {
    /// Parquet of PhysicalAI-AV: one row per clip, events with `cot` or `coc`
    OodReasoning,
    /// Folders with cot_<us>.yaml, and meta actions as <clip>.txt
    AutoLabeler,
    /// JSON or JSON Lines with chain_of_causation
    Alpamayo2,
    /// LeRobot v3 data set: language columns, else the texts of tasks (L2D)
    Lerobot,
}

#[derive(clap::Args)]
struct Import {
    /// Format of the source
    #[arg(value_enum, value_name = "SOURCE")]
    source: SourceFormat,
    /// Files, or folders that are searched for files of the format
    #[arg(value_name = "PATH", required = true)]
    paths: Vec<PathBuf>,
    /// Lake that has the drives
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// File to write (JSON Lines)
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Class of the labels, since the sources have none of ours [default: other.other]
    #[arg(long, value_name = "ID")]
    scenario: Option<String>,
    /// Author in the provenance [default: the format]
    #[arg(long, value_name = "NAME")]
    by: Option<String>,
    /// CSV with the columns clip and drive [default: a clip is the drive of its name]
    #[arg(long, value_name = "FILE")]
    drives: Option<PathBuf>,
    /// Time of the clips' time 0 [default: that of `ingest` where the drive contains it, else its first frame]
    #[arg(long, value_name = "TIME", value_parser = time)]
    start_time: Option<Nanos>,
    #[command(flatten)]
    print: Print,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    match args.what {
        What::Import(a) => import(global, &a),
    }
}

fn import(global: &Global, a: &Import) -> anyhow::Result<ExitCode> {
    let scenario = class(global, a.scenario.as_deref())?;
    let lake = Lake::open(&a.lake).with_context(|| cannot_read(a.lake.display()))?;
    let drives = a.drives.as_deref().map(drive_names).transpose()?.unwrap_or_default();
    let format = sources::name(a.source);
    let by = a.by.as_deref().unwrap_or(format);
    let mut reading = sources::read(a.source, &a.paths);
    let mut diagnostics = std::mem::take(&mut reading.diagnostics);
    let mut times: BTreeMap<DriveId, Option<Vec<Nanos>>> = BTreeMap::new();
    let (mut lines, mut lost) = (String::new(), 0usize);
    for one in &reading.found {
        let drive = drives.get(&one.clip).cloned().unwrap_or_else(|| DriveId::from(one.clip.as_str()));
        let frames = times
            .entry(drive.clone())
            .or_insert_with(|| lake.outline(&drive).ok().map(|outline| outline.times));
        let zero = frames
            .as_deref()
            .and_then(|t| Some((t, import::time_zero(t, a.start_time, whyroad_ingest::DEFAULT_START)?)));
        let label = match zero {
            Some((times, zero)) => {
                let place = Place { drive: &drive, times, zero, scenario: &scenario, by };
                import::draft(one, &place).map_err(|d| *d)
            }
            None => Err(import::drive_unknown(&one.origin, &one.clip)),
        };
        match label {
            Ok(label) => {
                lines.push_str(&serde_json::to_string(&label)?);
                lines.push('\n');
            }
            Err(d) => {
                lost += 1;
                diagnostics.push(d);
            }
        }
    }
    std::fs::write(&a.out, &lines).with_context(|| cannot_write(a.out.display()))?;
    diagnostics.extend(import::fields(format, &reading.left_out));
    for d in &diagnostics {
        tell!("{}", output::render_text(d, global.lang));
    }
    let errors = diagnostics.iter().filter(|d: &&Diagnostic| d.severity == Severity::Error).count();
    let (found, written) = (reading.found.len(), reading.found.len() - lost);
    let counts = json!({ "read": found, "written": written, "errors": errors, "out": a.out });
    a.print.put(&counts, || match global.lang {
        Lang::Zh => format!("读到 {found} 条因果文本；写出 {written} 个标注草稿；{errors} 个错误\n"),
        Lang::En => format!(
            "{} read; {} written; {}\n",
            counted(found, "causal text"),
            counted(written, "draft"),
            counted(errors, "error")
        ),
    })?;
    Ok(match (written, errors) {
        (0, _) => output::FINDINGS,
        (_, 0) => output::FINE,
        _ => output::lost_input(),
    })
}

/// The class of all labels; `other` is the id of moments that no class explains yet.
fn class(global: &Global, text: Option<&str>) -> anyhow::Result<ScenarioLabel> {
    let id = match text {
        None => ScenarioId { l1: "other".into(), l2: Some("other".into()), l3: None },
        Some(text) => match framework_folder::load(global)?.0.taxonomy.resolve(text) {
            Resolution::Found(id) if id.l2.is_some() => id,
            _ => {
                return Err(stop(
                    format!("“{text}”不是 L3 或 L2 场景；`whyroad taxonomy list` 列出所有分类"),
                    format!("'{text}' is not a leaf or L2 class; `whyroad taxonomy list` shows all classes"),
                ));
            }
        },
    };
    let full_id = Some(id.to_string());
    Ok(ScenarioLabel { l2: id.l2.unwrap_or_default(), l1: id.l1, l3: id.l3, full_id })
}

/// The drive of each clip.
fn drive_names(file: &Path) -> anyhow::Result<BTreeMap<String, DriveId>> {
    let cannot = || cannot_read(file.display());
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(file).with_context(cannot)?;
    let header = reader.headers().with_context(cannot)?.clone();
    let column = |name: &str| {
        header.iter().position(|h| h == name).with_context(|| {
            reason(
                format!("{} 没有列“{name}”", file.display()),
                format!("{}: no column '{name}'", file.display()),
            )
        })
    };
    let (clip, drive) = (column("clip")?, column("drive")?);
    let mut out = BTreeMap::new();
    for record in reader.records() {
        let record = record.with_context(cannot)?;
        out.insert(record[clip].to_owned(), DriveId::from(&record[drive]));
    }
    Ok(out)
}
