//! `whyroad lake`: work on a whole lake.

mod audit;
mod delete;
mod holders;

use crate::Global;
use std::process::ExitCode;

/// Arguments of `whyroad lake`.
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// Delete drives: tables, signals, findings, images, mined episodes, tasks, caches. Releases and backups that hold
    /// them are listed and not changed
    Delete(delete::Args),
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    match args.what {
        What::Delete(args) => delete::run(global, args),
    }
}
