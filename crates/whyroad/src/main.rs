//! The `whyroad` binary: arguments in, printing out; no domain logic. One file per command in `cmd/`.
#![allow(clippy::print_stdout, clippy::print_stderr)] // printing is what this crate is for

#[macro_use]
mod output;

mod analytics;
mod arguments;
mod cmd;
mod framework_folder;
mod help;
mod language_model;
mod model_args;
mod recordings;
mod store_args;
mod text_table;

use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

/// The open data engine for Chain-of-Causation driving data.
#[derive(Parser)]
#[command(name = "whyroad", version, propagate_version = true, max_term_width = 110)]
struct Cli {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    command: Command,
}

/// Options that every command understands.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct Global {
    /// Read schema/ and scenarios/ from this folder instead of the built-in framework
    #[arg(long, global = true, value_name = "DIR", env = "WHYROAD_FRAMEWORK")]
    pub framework: Option<PathBuf>,
    /// Language of messages
    #[arg(long, global = true, value_name = "LANG", default_value = "en", env = "WHYROAD_LANG",
        value_parser = arguments::lang)]
    pub lang: whyroad_model::Lang,
    /// Print notes too: messages that need no action
    #[arg(long, global = true)]
    pub verbose: bool,
    /// Format of messages on stderr: text, or one JSON object per line, for log collectors
    #[arg(
        long,
        global = true,
        value_name = "FORMAT",
        value_enum,
        default_value_t,
        env = "WHYROAD_LOG_FORMAT"
    )]
    pub log_format: output::log::LogFormat,
    /// Colors in messages: on a terminal, always or never; NO_COLOR turns them off
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto", value_parser = output::color_choice)]
    pub color: anstream::ColorChoice,
}

#[derive(Subcommand)]
enum Command {
    /// List, show, lint, compare, migrate and document the taxonomy
    Taxonomy(cmd::taxonomy::Args),
    /// Check labels and other messages
    Validate(cmd::validate::Args),
    /// Bring recorded drives into a lake
    Ingest(cmd::ingest::Args),
    /// Show what a lake holds
    Inspect(cmd::inspect::Args),
    /// Pack, list and upgrade a lake, or delete drives from it and from everything derived from them
    Lake(cmd::lake::Args),
    /// Attach camera pictures to a drive of a lake
    Media(cmd::media::Args),
    /// List and show the signals that rules can use
    Signals(cmd::signals::Args),
    /// Find episodes
    Mine(cmd::mine::Args),
    /// Merge the parts of several workers into one mined folder
    Merge(cmd::merge::Args),
    /// Show why a class was found in a clip, or why not
    Explain(cmd::explain::Args),
    /// Group moments that no class explains, and list the nearest classes
    Other(cmd::other::Args),
    /// Check mining rules while they are being written
    Rules(cmd::rules::Args),
    /// Convert a question to a mining rule with a language model, and run it
    Ask(cmd::ask::Args),
    /// Perturb a lake and report the agreement of mining with itself
    Robustness(cmd::robustness::Args),
    /// Evaluate episodes against ground truth: precision, recall, keyframe error by class
    Evaluate(cmd::evaluate::Args),
    /// Make scores comparable: the share of episodes that is right, by class, from ground truth or verdicts
    Calibrate(cmd::calibrate::Args),
    /// Compare two mined folders, two frameworks over one lake, or two releases
    Compare(cmd::compare::Args),
    /// Run the labeling service: the page and its API
    Serve(Box<cmd::serve::Args>),
    /// Make, list, export and import labeling tasks
    Tasks(cmd::tasks::Args),
    /// Import causal texts of other tools as drafts of labels
    Labels(cmd::labels::Args),
    /// Draft labels of mined episodes, by rule or by a language model
    Draft(cmd::draft::Args),
    /// Ask a language model true/false questions about labels; people answer a share of them
    Judge(cmd::judge::Args),
    /// Agreement of annotators, or of a judge with people, beyond chance
    Agreement(cmd::agreement::Args),
    /// Convert labels of older layouts to the current format, or back to 2.0
    Migrate(cmd::migrate::Args),
    /// List the accounts of the labeling service, and give one a new password
    Accounts(cmd::accounts::Args),
    /// Write the store of the labeling service into one file
    Backup(cmd::backup::BackupArgs),
    /// Read a backup into an empty store
    Restore(cmd::backup::RestoreArgs),
    /// Build, check, compare and show data sets
    Dataset(cmd::dataset::Args),
    /// Train and evaluate a model from the history alone, which any other model should beat
    Baseline(cmd::baseline::Args),
    /// Write the report: classes by stage, shortfalls, quality, coverage, episodes
    Report(cmd::report::Args),
    /// Run everything on sample drives and write a report
    Demo(cmd::demo::Args),
    /// Print a completion script for a shell
    Completions(cmd::shell::CompletionsArgs),
    /// Write manual pages, one per command
    Man(cmd::shell::ManArgs),
}

/// The command line with the examples of every command.
pub(crate) fn command_line() -> clap::Command {
    help::with_examples(Cli::command())
}

fn main() -> ExitCode {
    let lang = output::usage::lang_of(std::env::args_os(), std::env::var_os("WHYROAD_LANG").as_deref());
    output::reason::set_lang(lang);
    let parsed = command_line().try_get_matches().and_then(|matches| Cli::from_arg_matches(&matches));
    let cli = match (parsed, lang) {
        (Ok(cli), _) => cli,
        (Err(e), whyroad_model::Lang::En) => e.exit(),
        (Err(e), whyroad_model::Lang::Zh) => e.apply::<output::usage::Chinese>().exit(),
    };
    cli.global.color.write_global();
    output::log::set(cli.global.log_format);
    let result = match cli.command {
        Command::Taxonomy(a) => cmd::taxonomy::run(&cli.global, a),
        Command::Validate(a) => cmd::validate::run(&cli.global, a),
        Command::Ingest(a) => cmd::ingest::run(&cli.global, a),
        Command::Inspect(a) => cmd::inspect::run(&cli.global, a),
        Command::Lake(a) => cmd::lake::run(&cli.global, a),
        Command::Media(a) => cmd::media::run(&cli.global, a),
        Command::Signals(a) => cmd::signals::run(&cli.global, a),
        Command::Mine(a) => cmd::mine::run(&cli.global, a),
        Command::Merge(a) => cmd::merge::run(&cli.global, a),
        Command::Explain(a) => cmd::explain::run(&cli.global, a),
        Command::Other(a) => cmd::other::run(&cli.global, a),
        Command::Rules(a) => cmd::rules::run(&cli.global, a),
        Command::Robustness(a) => cmd::robustness::run(&cli.global, a),
        Command::Evaluate(a) => cmd::evaluate::run(&cli.global, a),
        Command::Calibrate(a) => cmd::calibrate::run(&cli.global, a),
        Command::Compare(a) => cmd::compare::run(&cli.global, a),
        Command::Serve(a) => cmd::serve::run(&cli.global, *a),
        Command::Tasks(a) => cmd::tasks::run(&cli.global, a),
        Command::Labels(a) => cmd::labels::run(&cli.global, a),
        Command::Draft(a) => cmd::draft::run(&cli.global, a),
        Command::Judge(a) => cmd::judge::run(&cli.global, a),
        Command::Agreement(a) => cmd::agreement::run(&cli.global, a),
        Command::Ask(a) => cmd::ask::run(&cli.global, a),
        Command::Migrate(a) => cmd::migrate::run(&cli.global, a),
        Command::Accounts(a) => cmd::accounts::run(&cli.global, a),
        Command::Backup(a) => cmd::backup::run_backup(&cli.global, a),
        Command::Restore(a) => cmd::backup::run_restore(&cli.global, a),
        Command::Dataset(a) => cmd::dataset::run(&cli.global, a),
        Command::Baseline(a) => cmd::baseline::run(&cli.global, a),
        Command::Report(a) => cmd::report::run(&cli.global, a),
        Command::Demo(a) => cmd::demo::run(&cli.global, a),
        Command::Completions(a) => cmd::shell::completions(a),
        Command::Man(a) => cmd::shell::man(a),
    };
    let code = result.unwrap_or_else(|e| {
        let told = output::reason::told(&e, lang);
        match lang {
            whyroad_model::Lang::Zh => say!("错误：{told}"),
            whyroad_model::Lang::En => say!("error: {told}"),
        }
        output::FINDINGS
    });
    if code == output::FINE && framework_folder::is_faulty() {
        framework_folder::tell_faults_of_rules(lang);
        return output::lost_input();
    }
    code
}
