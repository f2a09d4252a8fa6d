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
use whyroad_lake::{Lake, LakeError, WriteOutcome};
use whyroad_model::{Diagnostic, DriveId, Severity};

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
    // How many of the reports are about drives of an earlier publication.
    let mut settled = 0;
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
            match lake.publish() {
                Ok(()) => settled = reports.len(),
                Err(e) if is_conflict(&e) => {
                    not_published(&mut reports, settled, &e);
                    settled = reports.len();
                    bar.suspend(|| print_diagnostics(global, &[e.diagnostic()]));
                    problems.push(e.diagnostic());
                }
                Err(_) => {}
            }
            published = Instant::now();
        }
    }
    bar.finish_and_clear();

    let stated = facts.map(|facts| meta::state(&lake, facts));
    // Before the report: what is not published is in no lake.
    if let Err(e) = lake.publish() {
        not_published(&mut reports, settled, &e);
        problems.push(e.diagnostic());
        tell!("{}", render_text(&e.diagnostic(), global.lang));
    }
    match args.print {
        DataFormat::Text => output::put(&text_report(&reports, global.lang)),
        DataFormat::Json => output::put_json(&json_report(&reports, global.lang))?,
    }
    let found = stated.transpose()?.unwrap_or_default();
    for d in &found {
        tell!("{}", render_text(d, global.lang));
    }
    problems.extend(found);
    Ok(exit_code(&reports, &problems))
}

/// Takes back the outcome of drives that were written and could not be published: those that another process changed
/// at the same time, or all after the first `settled` ones.
fn not_published(reports: &mut [SourceReport], settled: usize, e: &LakeError) {
    let is_lost = |id: &DriveId| match e {
        LakeError::ChangedMeanwhile { what, .. } if is_conflict(e) => what.contains(&format!("drives/{id}")),
        _ => true,
    };
    for report in &mut reports[settled..] {
        let was_written = matches!(report.outcome, Some(WriteOutcome::Written | WriteOutcome::Replaced));
        if was_written && report.drive_id.as_ref().is_some_and(is_lost) {
            report.outcome = None;
        }
    }
}

/// Time between two publications into an object store.
const PUBLISH_EVERY: Duration = Duration::from_secs(20);

/// Another process has written the same drive; all others are published.
fn is_conflict(e: &LakeError) -> bool {
    // Without a put of the manifest nothing is published.
    matches!(e, LakeError::ChangedMeanwhile { what, .. } if what.iter().all(|w| w != "manifest.json"))
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

#[cfg(test)]
mod tests {
    use super::*;

    /// As `Lake::publish` documents its errors.
    #[test]
    fn only_published_drives_count_as_in_the_lake() {
        let report = |id: &str, outcome| SourceReport {
            drive_id: Some(DriveId::from(id)),
            outcome: Some(outcome),
            ..SourceReport::new(id.to_owned())
        };
        let all = || {
            vec![
                report("early", WriteOutcome::Written),
                report("a", WriteOutcome::Written),
                report("b", WriteOutcome::Replaced),
                report("c", WriteOutcome::Unchanged),
            ]
        };
        let left = |what: &[&str]| {
            let mut reports = all();
            let what = what.iter().map(|w| (*w).to_owned()).collect();
            not_published(&mut reports, 1, &LakeError::ChangedMeanwhile { url: "s3://b/l".to_owned(), what });
            let there = reports.iter().filter(|r| r.outcome.is_some());
            there.map(|r| r.source.clone()).collect::<Vec<_>>()
        };
        // Another process wrote one of them: the rest is published.
        assert_eq!(left(&["drives/b"]), ["early", "a", "c"]);
        // The manifest could not be put: nothing since the last publication is.
        assert_eq!(left(&["manifest.json"]), ["early", "c"]);
    }
}
