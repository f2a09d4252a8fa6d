//! `whyroad lake compact`: loose drives into packs.

use crate::output::{Print, render_text};
use crate::{Global, output};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use whyroad_lake::{Compaction, CompactionOptions};
use whyroad_model::Lang;

/// Arguments of `whyroad lake compact`.
#[derive(clap::Args)]
pub(super) struct Args {
    /// Lake
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Maximum size of a pack, MB
    #[arg(long, value_name = "MB", default_value_t = 400, value_parser = clap::value_parser!(u64).range(1..))]
    size: u64,
    /// Maximum number of drives in a pack
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u64).range(1..=65_536))]
    drives: u64,
    /// Leave out stored signals: they are derived again when a new rule needs them
    #[arg(long)]
    drop_signals: bool,
    #[command(flatten)]
    print: Print,
}

/// The result, as JSON.
#[derive(Serialize)]
struct Done {
    packed: usize,
    drives: usize,
    packs: usize,
    bytes: u64,
    packs_written: usize,
    packs_removed: usize,
    left_loose: Vec<String>,
}

pub(super) fn run(global: &Global, args: &Args) -> anyhow::Result<ExitCode> {
    let Some(lake) = super::opened(&args.lake, global) else { return Ok(output::FINDINGS) };
    let options = CompactionOptions {
        pack_bytes: args.size * 1_000_000,
        pack_drives: usize::try_from(args.drives)?,
        keep_signals: !args.drop_signals,
    };
    let (bar, shown) = (output::progress(100), AtomicUsize::new(0));
    let done = |drives: usize, of: usize| {
        let percent = drives * 100 / of.max(1);
        let before = shown.fetch_max(percent, Ordering::Relaxed);
        (before..percent).for_each(|_| bar.inc(1));
    };
    let compacted = match lake.compact(&options, done) {
        Ok(done) => done,
        Err(e) => {
            bar.finish_and_clear();
            tell!("{}", render_text(&e.diagnostic(), global.lang));
            return Ok(output::FINDINGS);
        }
    };
    bar.finish_and_clear();
    for (_, e) in &compacted.left {
        tell!("{}", render_text(&e.diagnostic(), global.lang));
    }
    args.print.put(&of(&compacted), || text(&compacted, global.lang))?;
    Ok(if compacted.left.is_empty() { output::FINE } else { output::lost_input() })
}

fn of(c: &Compaction) -> Done {
    Done {
        packed: c.packed,
        drives: c.drives,
        packs: c.packs,
        bytes: c.bytes,
        packs_written: c.written,
        packs_removed: c.removed,
        left_loose: c.left.iter().map(|(id, _)| id.to_string()).collect(),
    }
}

fn text(c: &Compaction, lang: Lang) -> String {
    let (mb, left) = (c.bytes / 1_000_000, c.left.len());
    let mut text = match lang {
        Lang::Zh => format!(
            "已打包 {} 个行程；共 {} 个行程在 {} 个包中，{mb} MB（写入 {} 个包，删除 {} 个）\n",
            c.packed, c.drives, c.packs, c.written, c.removed
        ),
        Lang::En => format!(
            "packed {} drives; {} drives in {} packs, {mb} MB ({} packs written, {} removed)\n",
            c.packed, c.drives, c.packs, c.written, c.removed
        ),
    };
    if left > 0 {
        text += &match lang {
            Lang::Zh => format!("{left} 个行程无法读取，仍为单独的文件夹\n"),
            Lang::En => format!("{left} drives cannot be read and keep their folders\n"),
        };
    }
    text
}
