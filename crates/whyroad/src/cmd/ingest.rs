//! `whyroad ingest`: recorded drives into a lake, with a report of what was read, kept and lost.

use crate::output::render_text;
use crate::{Global, output};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;
use std::process::ExitCode;
use whyroad_ingest::report::reason_text;
use whyroad_ingest::sumo::{Egos, Occlusion, Sensing};
use whyroad_ingest::{Format, Options, RowCount, SourceReport};
use whyroad_lake::{Lake, WriteOutcome};
use whyroad_model::diagnostic::render_json;
use whyroad_model::{Bilingual, Diagnostic, DriveId, Lang, Nanos, Severity};

/// Arguments of `whyroad ingest`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Format (av2, av2-motion, comma2k19, mcap, nuscenes, scenarionet, sumo, table, waymo-motion; left out: recognised by the files), then log folders, files, or folders of such
    #[arg(required = true, value_name = "[FORMAT] PATH")]
    inputs: Vec<String>,
    /// Lake to write into; made when it is not there
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Id of the drive; only with a single source
    #[arg(long, value_name = "ID")]
    drive_id: Option<String>,
    /// SUMO: a vehicle that is an ego (may be given more than once; each becomes a drive; default: ego)
    #[arg(long, value_name = "ID")]
    ego: Vec<String>,
    /// SUMO: draw this share of all motor vehicles as egos, 0 to 1
    #[arg(long, value_name = "SHARE", conflicts_with = "ego", value_parser = share)]
    ego_share: Option<f64>,
    /// SUMO: another seed draws other egos
    #[arg(long, value_name = "N", default_value_t = 0, requires = "ego_share")]
    seed: u64,
    /// SUMO: how far the ego's sensor sees, m (left out: everything)
    #[arg(long, value_name = "METRES", value_parser = range)]
    sensor_range: Option<f64>,
    /// SUMO: leave out what other vehicles hide from the ego
    #[arg(long)]
    occlusion: bool,
    /// Time of the source's zero, for sources without a clock
    #[arg(long, value_name = "TIME", default_value = "2026-01-01T00:00:00Z", value_parser = Nanos::parse_iso)]
    start_time: Nanos,
    /// SUMO: the network, when it is not beside the FCD file
    #[arg(long, value_name = "FILE")]
    net: Option<PathBuf>,
    /// SUMO: files with vehicle types, when they are not beside the FCD file or one folder up
    #[arg(long, value_name = "FILE")]
    types: Vec<PathBuf>,
    /// SUMO: the lights' states, when they are not beside the FCD file
    #[arg(long, value_name = "FILE")]
    lights: Option<PathBuf>,
    /// comma2k19: the DBC of the car, which says what its raw CAN messages mean
    #[arg(long, value_name = "FILE")]
    dbc: Option<PathBuf>,
    /// MCAP: which topics are what
    #[arg(long, value_name = "FILE")]
    mapping: Option<PathBuf>,
    /// Licence of the data (SPDX id), for sources that do not say
    #[arg(long, value_name = "ID")]
    licence: Option<String>,
    /// How to print the report
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    format: ReportFormat,
}

/// How the report is printed.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum ReportFormat {
    Text,
    Json,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (format, paths) = match Format::from_name(&args.inputs[0]) {
        Some(f) => (Some(f), &args.inputs[1..]),
        None => (None, &args.inputs[..]),
    };
    if paths.is_empty() {
        anyhow::bail!("name at least one path after the format");
    }
    let paths: Vec<PathBuf> = paths.iter().map(PathBuf::from).collect();
    let (sources, problems) = whyroad_ingest::find_sources(format, &paths);
    if args.drive_id.is_some() && sources.len() > 1 {
        anyhow::bail!("--drive-id names one drive, but there are {} sources", sources.len());
    }
    let options = Options {
        drive_id: args.drive_id.map(DriveId::from),
        egos: match args.ego_share {
            Some(share) => Egos::Share { share, seed: args.seed },
            None if args.ego.is_empty() => Egos::default(),
            None => Egos::Named(args.ego),
        },
        sensing: Sensing {
            range_m: args.sensor_range,
            occlusion: if args.occlusion { Occlusion::ByBoxes } else { Occlusion::Ignored },
        },
        start: args.start_time,
        net: args.net,
        types: args.types,
        lights: args.lights,
        dbc: args.dbc,
        mapping: args.mapping,
        licence: args.licence,
    };
    for d in &problems {
        tell!("{}", render_text(d, global.lang));
    }
    if sources.is_empty() {
        return Ok(output::FINDINGS);
    }
    let lake = Lake::create_or_open(&args.lake)?;

    let bar = progress(sources.len());
    let mut reports = Vec::with_capacity(sources.len());
    for batch in whyroad_ingest::batches(&sources) {
        bar.set_message(batch[0].path.file_name().unwrap_or_default().to_string_lossy().into_owned());
        let last = bar.position() + batch.len() as u64;
        whyroad_ingest::ingest_each(batch, &options, &lake, &mut |report| {
            bar.suspend(|| {
                for d in &report.diagnostics {
                    tell!("{}", render_text(d, global.lang));
                }
            });
            reports.push(report);
            // A simulation has more drives than one; it is done when the last is.
            bar.set_position((bar.position() + 1).min(last - 1));
        });
        bar.set_position(last);
    }
    bar.finish_and_clear();

    match args.format {
        ReportFormat::Text => output::put(&text_report(&reports, global.lang)),
        ReportFormat::Json => output::put(&format!("{:#}\n", json_report(&reports, global.lang))),
    }
    Ok(exit_code(&reports, &problems))
}

fn share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok().filter(|s: &f64| (0.0..=1.0).contains(s));
    share.ok_or_else(|| "a share is a number from 0 to 1".to_owned())
}

fn range(text: &str) -> Result<f64, String> {
    let range = text.parse().ok().filter(|r: &f64| r.is_finite() && *r > 0.0);
    range.ok_or_else(|| "a range is a number of metres above 0".to_owned())
}

fn progress(sources: usize) -> ProgressBar {
    // Draws on stderr, and only on a terminal.
    let bar = ProgressBar::new(sources as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed} {msg}") {
        bar.set_style(style);
    }
    bar
}

/// 1 when nothing came into the lake, 3 when something did and something was lost.
fn exit_code(reports: &[SourceReport], problems: &[Diagnostic]) -> ExitCode {
    if reports.iter().all(|r| r.outcome.is_none()) {
        return output::FINDINGS;
    }
    let lost = reports.iter().any(SourceReport::lost_input)
        || problems.iter().any(|d| d.severity == Severity::Error);
    if lost { output::lost_input() } else { output::FINE }
}

fn outcome_text(outcome: Option<WriteOutcome>, lang: Lang) -> String {
    let text = match outcome {
        Some(WriteOutcome::Written) => Bilingual::new("已写入", "written"),
        Some(WriteOutcome::Unchanged) => Bilingual::new("未变（内容相同）", "unchanged (same content)"),
        Some(WriteOutcome::Replaced) => Bilingual::new("已替换", "replaced"),
        None => Bilingual::new("未导入", "not ingested"),
    };
    text.get(lang).to_owned()
}

fn text_report(reports: &[SourceReport], lang: Lang) -> String {
    let mut out = String::new();
    for r in reports {
        let name = r.drive_id.as_ref().map_or(r.source.as_str(), |id| id.as_str());
        out += &format!("{name}: {}", outcome_text(r.outcome, lang));
        if r.drive_id.is_some() {
            out += &match lang {
                Lang::Zh => format!("，{} 帧，{:.1} 秒，{} 条轨迹", r.frames, r.duration_s, r.tracks),
                Lang::En => format!(", {} frames, {:.1} s, {} tracks", r.frames, r.duration_s, r.tracks),
            };
        }
        out.push('\n');
        for t in &r.tables {
            out += &format!("  {}\n", table_line(t, lang));
        }
        if !r.missing.is_empty() {
            let label = Bilingual::new("日志中没有", "not in the log");
            out += &format!(
                "  {}: {}\n",
                label.get(lang),
                whyroad_ingest::report::missing_text(&r.missing, lang)
            );
        }
    }
    let kept = reports.iter().filter(|r| r.outcome.is_some()).count();
    let dropped: usize = reports.iter().flat_map(|r| &r.tables).map(RowCount::dropped_total).sum();
    out += &match lang {
        Lang::Zh => format!("{} 个来源中 {kept} 个已在数据湖中，丢弃 {dropped} 行\n", reports.len()),
        Lang::En => format!("{kept} of {} sources are in the lake, {dropped} rows dropped\n", reports.len()),
    };
    out
}

fn table_line(t: &RowCount, lang: Lang) -> String {
    let list = |counts: &whyroad_ingest::report::Counts| {
        let parts: Vec<String> =
            counts.iter().map(|(k, n)| format!("{} {n}", reason_text(k).get(lang))).collect();
        parts.join(", ")
    };
    let (read, kept, aside, dropped) = match lang {
        Lang::Zh => ("读取", "保留", "不采用", "丢弃"),
        Lang::En => ("read", "kept", "left out", "dropped"),
    };
    let mut line = format!("{:<12} {read} {:>7}   {kept} {:>7}", t.table, t.read, t.kept_total());
    if t.kept.len() > 1 {
        line += &format!(" ({})", list(&t.kept));
    }
    for (label, counts) in [(aside, &t.set_aside), (dropped, &t.dropped)] {
        if !counts.is_empty() {
            line += &format!("   {label} {} ({})", counts.values().sum::<usize>(), list(counts));
        }
    }
    line
}

fn json_report(reports: &[SourceReport], lang: Lang) -> serde_json::Value {
    let one = |r: &SourceReport| {
        let tables: Vec<_> = r
            .tables
            .iter()
            .map(|t| {
                serde_json::json!({
                    "table": t.table, "read": t.read, "kept": t.kept, "left_out": t.set_aside, "dropped": t.dropped,
                })
            })
            .collect();
        let outcome = r.outcome.map(|o| match o {
            WriteOutcome::Written => "written",
            WriteOutcome::Unchanged => "unchanged",
            WriteOutcome::Replaced => "replaced",
        });
        serde_json::json!({
            "source": r.source, "drive_id": r.drive_id, "outcome": outcome, "frames": r.frames,
            "duration_s": r.duration_s, "tracks": r.tracks, "tables": tables, "missing": r.missing,
            "diagnostics": render_json(&r.diagnostics, lang),
        })
    };
    serde_json::Value::Array(reports.iter().map(one).collect())
}
