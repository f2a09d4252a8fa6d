//! `whyroad demo`.

use crate::{Global, output};
use std::process::ExitCode;

/// Arguments of `whyroad demo`.
#[derive(clap::Args)]
pub(crate) struct Args {}

pub(crate) fn run(_global: &Global, _args: Args) -> anyhow::Result<ExitCode> {
    let _ = (output::FINE, output::lost_input());
    anyhow::bail!("not built yet")
}
