//! `whyroad dataset`: releases that a trainer reads, from labels and a lake.

mod build;
mod doubtful;
mod export;
pub(crate) mod query;
pub(crate) mod score;
mod show;
mod verify;

use crate::output::reason::{cannot_read, cannot_write, exists, stop};
use crate::{Global, output};
use anyhow::Context as _;
use std::path::PathBuf;
use std::process::ExitCode;
use whyroad_dataset::licence::{BUNDLED, LicenceTable};
use whyroad_dataset::{DatasetError, spec};
use whyroad_model::Diagnostic;

/// Arguments of `whyroad dataset`.
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// Write a commented spec
    Init(Init),
    /// Build a release: select, cut, split, de-duplicate, balance, freeze
    Build(build::Args),
    /// Check a release: hashes, leaks between splits, near-duplicates, licenses, labels
    Verify(verify::Args),
    /// Write a view of a release for a trainer or another tool
    Export(export::Args),
    /// Compare two releases
    Diff(show::DiffArgs),
    /// Show a sample: its label, and the drive, episode, label version and rule version that it comes from
    Show(show::Args),
    /// Score a model's predictions on a split: decisions, class, trajectory, with intervals
    Score(score::Args),
    /// List labels that are probably wrong, and send them back for review
    Doubtful(doubtful::Args),
}

#[derive(clap::Args)]
struct Init {
    /// File to write; must not exist
    #[arg(value_name = "FILE", default_value = "dataset.yaml")]
    file: PathBuf,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    match args.what {
        What::Init(a) => init(&a),
        What::Build(a) => build::run(global, a),
        What::Verify(a) => verify::run(global, &a),
        What::Export(a) => export::run(global, &a),
        What::Diff(a) => show::diff(global, &a),
        What::Show(a) => show::run(global, &a),
        What::Score(a) => score::run(global, &a),
        What::Doubtful(a) => doubtful::run(global, &a),
    }
}

fn init(a: &Init) -> anyhow::Result<ExitCode> {
    if a.file.exists() {
        return Err(exists(a.file.display()));
    }
    std::fs::write(&a.file, spec::TEMPLATE).with_context(|| cannot_write(a.file.display()))?;
    say!("{}", a.file.display());
    Ok(output::FINE)
}

/// Prints why a command failed.
fn refused(global: &Global, e: &DatasetError) -> ExitCode {
    print(global, &e.diagnostics());
    if matches!(e, DatasetError::Stopped) {
        say!("{e}");
    }
    output::FINDINGS
}

fn print(global: &Global, found: &[Diagnostic]) {
    for d in found {
        tell!("{}", output::render_text(d, global.lang));
    }
}

/// The licenses of the current framework: those of its folder, else the built-in ones.
fn licences(global: &Global) -> anyhow::Result<LicenceTable> {
    let own = global.framework.as_ref().map(|dir| dir.join("schema/licences.yaml")).filter(|p| p.is_file());
    let (text, name) = match &own {
        Some(path) => {
            let text = std::fs::read_to_string(path).with_context(|| cannot_read(path.display()))?;
            (text, path.display().to_string())
        }
        None => (BUNDLED.to_owned(), "schema/licences.yaml".to_owned()),
    };
    LicenceTable::read(&text, &name).map_err(|found| {
        print(global, &found);
        stop(format!("{name} 不可用"), format!("{name} is not usable"))
    })
}
