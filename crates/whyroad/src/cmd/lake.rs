//! `whyroad lake`: work on a whole lake.

mod audit;
mod compact;
mod delete;
mod holders;
mod list;
mod upgrade;

use crate::Global;
use crate::output::render_text;
use std::path::Path;
use std::process::ExitCode;
use whyroad_lake::Lake;

/// Arguments of `whyroad lake`.
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// List drives: id, time, size, place; by place, format or time
    List(list::Args),
    /// Pack drives into few large files: for lakes of many thousand drives
    Compact(compact::Args),
    /// Check that every drive has the layout that this version reads; otherwise print how to upgrade
    Upgrade(upgrade::Args),
    /// Delete drives: tables, signals, findings, images, mined episodes, tasks, caches. Releases and backups that hold
    /// them are listed and not changed
    Delete(delete::Args),
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    match args.what {
        What::List(args) => list::run(global, &args),
        What::Compact(args) => compact::run(global, &args),
        What::Upgrade(args) => upgrade::run(global, &args),
        What::Delete(args) => delete::run(global, args),
    }
}

/// The lake in a folder; `None` after reporting why it cannot be opened.
fn opened(dir: &Path, global: &Global) -> Option<Lake> {
    Lake::open(dir).map_err(|e| tell!("{}", render_text(&e.diagnostic(), global.lang))).ok()
}
