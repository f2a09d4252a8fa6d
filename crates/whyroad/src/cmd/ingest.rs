//! `whyroad ingest`: recorded drives into a lake, with a report of what was read, kept and lost.

mod arguments;
mod meta;
mod report;

use crate::output::reason::stop;
use crate::output::{DataFormat, render_text};
use crate::{Global, output};
pub(crate) use arguments::Args;
use report::{json_report, text_report};
use std::process::ExitCode;
use std::time::{Duration, Instant};
use whyroad_ingest::SourceReport;
use whyroad_lake::{Lake, LakeError};
use whyroad_model::{Diagnostic, Severity};

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (sources, mut problems) = whyroad_ingest::find_sources_with(args.format, &args.paths, &args.options);
    if args.options.drive_id.is_some() && sources.len() > 1 {
        let n = sources.len();
        return Err(stop(
            format!("--drive-id 只能指定一个行程，而来源有 {n} 个"),
            format!("--drive-id names one drive, but there are {n} sources"),
        ));
    }
    print_diagnostics(global, &problems);
    if sources.is_empty() {
        return Ok(output::FINDINGS);
    }
    let facts = args.meta.as_deref().map(meta::read).transpose()?;
    let lake = match Lake::create_or_open(&args.lake) {
        Ok(lake) => lake,
        Err(e) => {
            tell!("{}", render_text(&e.diagnostic(), global.lang));
            return Ok(output::FINDINGS);
        }
    };

    whyroad_engine::memory::keep_freed();
    let mut published = Instant::now();
    let bar = output::progress(sources.len());
    let mut reports = Vec::with_capacity(sources.len());
    for batch in whyroad_ingest::batches(&sources) {
        bar.set_message(batch[0].path.file_name().unwrap_or_default().to_string_lossy().into_owned());
        let last = bar.position() + batch.len() as u64;
        whyroad_ingest::ingest_each(batch, &args.options, &lake, &mut |report| {
            bar.suspend(|| print_diagnostics(global, &report.diagnostics));
            reports.push(report);
            // A simulation has several drives; it is finished with the last one.
            bar.set_position((bar.position() + 1).min(last - 1));
        });
        bar.set_position(last);
        // Published drives are not lost with the process. An error here is reported at the end if it persists.
        if published.elapsed() >= PUBLISH_EVERY {
            let conflict = lake.publish().err().filter(is_conflict).map(|e| e.diagnostic());
            bar.suspend(|| print_diagnostics(global, conflict.as_slice()));
            problems.extend(conflict);
            published = Instant::now();
        }
    }
    bar.finish_and_clear();

    match args.print {
        DataFormat::Text => output::put(&text_report(&reports, global.lang)),
        DataFormat::Json => output::put_json(&json_report(&reports, global.lang))?,
    }
    if let Some(facts) = facts {
        let found = meta::state(&lake, facts)?;
        for d in &found {
            tell!("{}", render_text(d, global.lang));
        }
        problems.extend(found);
    }
    if let Err(e) = lake.publish() {
        problems.push(e.diagnostic());
        tell!("{}", render_text(&e.diagnostic(), global.lang));
        if !is_conflict(&e) {
            return Ok(output::FINDINGS);
        }
    }
    Ok(exit_code(&reports, &problems))
}

/// Time between two publications into an object store.
const PUBLISH_EVERY: Duration = Duration::from_secs(20);

/// Another process has written the same drive; all others are published.
fn is_conflict(e: &LakeError) -> bool {
    matches!(e, LakeError::ChangedMeanwhile { .. })
}

/// Diagnostics to stderr; notes only with `--verbose`.
fn print_diagnostics(global: &Global, diagnostics: &[Diagnostic]) {
    let shown = diagnostics.iter().filter(|d| global.verbose || d.severity != Severity::Note);
    shown.for_each(|d| tell!("{}", render_text(d, global.lang)));
}

/// 1 when nothing was written to the lake, 3 when something was written and some input was lost.
fn exit_code(reports: &[SourceReport], problems: &[Diagnostic]) -> ExitCode {
    if reports.iter().all(|r| r.outcome.is_none()) {
        return output::FINDINGS;
    }
    let lost = reports.iter().any(SourceReport::lost_input)
        || problems.iter().any(|d| d.severity == Severity::Error);
    if lost { output::lost_input() } else { output::FINE }
}
