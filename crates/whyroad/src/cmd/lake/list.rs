//! `whyroad lake list`: the drives, from the catalog; tables are not opened.

use super::delete::moment;
use crate::output::{Print, render_text};
use crate::{Global, output};
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use whyroad_lake::DriveEntry;
use whyroad_model::scene::FRAME_RATE_HZ;
use whyroad_model::{Lang, Nanos, counted};

/// Arguments of `whyroad lake list`.
#[derive(clap::Args)]
pub(super) struct Args {
    /// Lake
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Only drives of this place
    #[arg(long, value_name = "PLACE")]
    place: Option<String>,
    /// Only drives from logs of this format
    #[arg(long, value_name = "FORMAT")]
    source_format: Option<String>,
    /// Only drives that end at or after this time (2026-01-01, or an age such as 180d); none without a date
    #[arg(long, value_name = "TIME", value_parser = moment)]
    since: Option<Nanos>,
    /// Only drives that begin before this time; none without a date
    #[arg(long, value_name = "TIME", value_parser = moment)]
    until: Option<Nanos>,
    #[command(flatten)]
    print: Print,
}

pub(super) fn run(global: &Global, args: &Args) -> anyhow::Result<ExitCode> {
    let Some(lake) = super::opened(&args.lake, global) else { return Ok(output::FINDINGS) };
    let (mut found, mut undated, mut unreadable) = (Vec::new(), 0, false);
    for (_, entry) in lake.entries() {
        if entry.as_ref().is_ok_and(|e| !args.asks_for(e)) {
            continue;
        }
        match entry.and_then(|e| Ok(DriveEntry { dated: Some(lake.is_dated(&e)?), ..e })) {
            // Its times count from an invented start.
            Ok(entry) if args.asks_for_a_time() && entry.dated == Some(false) => undated += 1,
            Ok(entry) if !args.is_within(&entry) => {}
            Ok(entry) => found.push(entry),
            Err(e) => {
                tell!("{}", render_text(&e.diagnostic(), global.lang));
                unreadable = true;
            }
        }
    }
    if undated > 0 {
        match global.lang {
            Lang::Zh => tell!("{undated} 个行程没有日期，未列出\n"),
            Lang::En => tell!("{} without a date not listed\n", counted(undated, "drive")),
        }
    }
    args.print.put(&found, || found.iter().map(line).collect())?;
    Ok(if unreadable { output::lost_input() } else { output::FINE })
}

impl Args {
    fn asks_for(&self, entry: &DriveEntry) -> bool {
        self.place.as_ref().is_none_or(|p| entry.place.as_ref() == Some(p))
            && self.source_format.as_ref().is_none_or(|f| entry.format == *f)
    }

    fn asks_for_a_time(&self) -> bool {
        self.since.is_some() || self.until.is_some()
    }

    fn is_within(&self, entry: &DriveEntry) -> bool {
        self.since.is_none_or(|t| entry.end >= t) && self.until.is_none_or(|t| entry.start < t)
    }
}

/// Id, start (`-` without a date), recorded seconds, rows of objects, format, place and pack, separated by tabs.
fn line(e: &DriveEntry) -> String {
    let start = if e.dated == Some(false) { "-".to_owned() } else { e.start.to_string() };
    // Recorded: gaps of the log do not count.
    let seconds = e.frames as f64 / FRAME_RATE_HZ;
    let (place, pack) = (e.place.as_deref().unwrap_or("-"), e.pack.as_deref().unwrap_or("-"));
    let mut line = String::new();
    let _ = writeln!(
        line,
        "{}\t{start}\t{seconds:.1} s\t{}\t{}\t{place}\t{pack}",
        e.drive_id, e.object_rows, e.format
    );
    line
}
