//! `whyroad rules`: checks files with mining rules.

use super::taxonomy::lint;
use crate::output::PrintFindings;
use crate::output::reason::cannot_read;
use crate::{Global, framework_folder, output};
use anyhow::Context as _;
use clap::Subcommand;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_framework::Framework;
use whyroad_mining::rule::file::{Checked, check_file};
use whyroad_mining::rule::origin::SourceFile;
use whyroad_model::{Lang, counted};
use whyroad_signals::Catalog;

/// Arguments of `whyroad rules`.
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Check rule files and run the cases beside them
    ///
    /// A scenarios/<l1>/<l2>.yaml is checked instead of the framework's own; `<l2>.cases.yaml` beside it is run.
    /// A file with only a `mining:` block is checked as one rule. Exit code 1 if there are findings.
    Check {
        /// Rule files (.yaml)
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
        #[command(flatten)]
        print: PrintFindings,
    },
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let Command::Check { files, print } = args.command;
    let framework = match &global.framework {
        Some(dir) => framework_folder::read_folder(dir)?,
        None => Framework::bundled_files(),
    };
    let signals = framework.get("schema/signals.yaml").map(String::as_str).unwrap_or_default();
    let (catalog, found) = Catalog::parse(signals);
    let mut found = framework_folder::placed(global.framework.as_deref(), found);
    let mut tallies = Vec::new();
    for file in &files {
        let text = read(file)?;
        let beside = file.with_extension("cases.yaml");
        let cases =
            if beside.is_file() { Some((beside.display().to_string(), read(&beside)?)) } else { None };
        let cases = cases.as_ref().map(|(name, text)| SourceFile { name, text });
        let name = file.display().to_string();
        let checked = check_file(SourceFile { name: &name, text: &text }, cases, &framework, &catalog);
        tallies.push(tally(&name, &checked, global.lang));
        found.extend(checked.found);
    }
    lint::print(&found, print.format, global.lang);
    for line in tallies {
        say!("{line}");
    }
    Ok(if found.is_empty() { output::FINE } else { output::FINDINGS })
}

fn read(path: &Path) -> anyhow::Result<String> {
    std::fs::read_to_string(path).with_context(|| cannot_read(path.display()))
}

fn tally(name: &str, checked: &Checked, lang: Lang) -> String {
    let (rules, cases) = (checked.rules, checked.cases);
    match lang {
        Lang::Zh => format!("{name}：{rules} 条规则，{cases} 个用例"),
        Lang::En => format!("{name}: {}, {}", counted(rules, "rule"), counted(cases, "case")),
    }
}
