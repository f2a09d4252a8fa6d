//! `whyroad taxonomy`: init, list, show, lint, diff, migrate, docs, schemas. One file each.

mod diff;
mod generate;
mod init;
pub(crate) mod lint;
mod list;
mod migrate;
mod reference;
mod show;

use crate::Global;
use crate::output::{Print, PrintFindings};
use clap::{Subcommand, ValueEnum};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `whyroad taxonomy`.
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write the built-in framework to a folder, to edit it there
    ///
    /// Then `--framework DIR`, or WHYROAD_FRAMEWORK, makes every command read that folder.
    Init {
        /// A folder without schema/, scenarios/ and prompts/; it is made
        dir: PathBuf,
    },
    /// List all classes, or those of one L1
    List {
        /// Only this L1 and what is below it
        #[arg(long, value_name = "ID")]
        l1: Option<String>,
        /// How to print the result
        #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
        format: ListingFormat,
    },
    /// Show one class: meaning, decisions, rules against its neighbors, how it is labeled
    Show {
        /// Full id (reactive_agent.cutin.urgent), prefix (reactive_agent.cutin) or a short id that only one class has
        /// (urgent)
        id: String,
        /// How to print the result
        #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
        format: ListingFormat,
    },
    /// Check the framework, a taxonomy file (.yaml), or the numbers and classes of a TAXONOMY.md
    ///
    /// Without FILE: classes, decisions, labeling specs and their expressions, mining rules, signals, order of
    /// precedence. Exit code 1 when anything is found.
    Lint {
        /// A .yaml or .md file; the whole framework when absent
        file: Option<PathBuf>,
        #[command(flatten)]
        print: PrintFindings,
    },
    /// Compare two frameworks or taxonomies, and print whether the step is major, minor or patch
    ///
    /// A and B are framework folders or the word `bundled`: classes, labeling specs and mining rules are compared.
    /// With a .yaml or .md file on either side only the classes are.
    /// Exit code 1 when a version that B states is too low for its changes.
    Diff {
        /// The earlier one
        a: PathBuf,
        /// The later one
        b: PathBuf,
        #[command(flatten)]
        print: Print,
    },
    /// Migrate labels, tasks and releases when classes are renamed, merged or split
    ///
    /// A mapping file states the change of each class. Nothing is guessed: if a label does not decide its class, it is
    /// listed and its task is returned to its author. Originals are kept in the history of the task and in the old
    /// files.
    Migrate(migrate::Args),
    /// Write the generated pages of docs/: classes, leaves, signals, labeling tables, diagnostics index
    ///
    /// Pages go to docs/ in the framework folder. SPEC.md, the diagnostics index and the book's SUMMARY.md are brought
    /// up to date only where they exist.
    Docs {
        /// Write nothing; exit code 1 when a file is not up to date
        #[arg(long)]
        check: bool,
        /// Write only the page of all classes, to this file, and bring a SPEC.md beside it up to date
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
    },
    /// Write the JSON Schemas of all messages and of the labeling specs
    Schemas {
        /// Write nothing; exit code 1 when a file is not up to date
        #[arg(long)]
        check: bool,
        /// Folder to write to
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
}

/// How classes are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum ListingFormat {
    /// For people
    #[default]
    Text,
    /// One JSON document
    Json,
    /// One YAML document
    Yaml,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    match args.command {
        Command::Init { dir } => init::run(global, &dir),
        Command::List { l1, format } => list::run(global, l1.as_deref(), format),
        Command::Show { id, format } => show::run(global, &id, format),
        Command::Lint { file, print } => lint::run(global, file.as_deref(), print.format),
        Command::Diff { a, b, print } => diff::run(global, &a, &b, print),
        Command::Migrate(args) => migrate::run(global, &args),
        Command::Docs { check, out } => {
            generate::docs(global, generate::Action::from_flag(check), out.as_deref())
        }
        Command::Schemas { check, out } => {
            generate::schemas(global, generate::Action::from_flag(check), out.as_deref())
        }
    }
}
