//! `whyroad rules`: checks files with mining rules.

use super::taxonomy::lint;
use crate::output::PrintFindings;
use crate::output::reason::cannot_read;
use crate::{Global, framework_folder, output};
use anyhow::Context as _;
use clap::Subcommand;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_framework::FrameworkFiles;
use whyroad_framework::framework::utf8_text;
use whyroad_mining::rule::file::{Checked, check_file};
use whyroad_mining::rule::origin::SourceFile;
use whyroad_model::{Diagnostic, Lang, counted};
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
        None => FrameworkFiles::bundled(),
    };
    let signals = framework.texts.get("schema/signals.yaml").map(String::as_str).unwrap_or_default();
    let (catalog, of_signals) = Catalog::parse(signals);
    let found = framework.not_text.iter().cloned().chain(of_signals).collect();
    let mut found = framework_folder::placed(global.framework.as_deref(), found);
    let mut tallies = Vec::new();
    for file in &files {
        let Some(text) = read(file, &mut found)? else { continue };
        let beside = file.with_extension("cases.yaml");
        let cases = if beside.is_file() { read(&beside, &mut found)? } else { None };
        let cases = cases.map(|text| (beside.display().to_string(), text));
        let cases = cases.as_ref().map(|(name, text)| SourceFile { name, text });
        let name = file.display().to_string();
        let checked = check_file(SourceFile { name: &name, text: &text }, cases, &framework.texts, &catalog);
        tallies.push(tally(&name, &checked, global.lang));
        found.extend(checked.found);
    }
    lint::print(&found, print.format, global.lang);
    for line in tallies {
        say!("{line}");
    }
    Ok(if found.is_empty() { output::FINE } else { output::FINDINGS })
}

/// The text of a file; one that is not UTF-8 is a finding, reported once.
fn read(path: &Path, found: &mut Vec<Diagnostic>) -> anyhow::Result<Option<String>> {
    let bytes = std::fs::read(path).with_context(|| cannot_read(path.display()))?;
    let text = utf8_text(&path.display().to_string(), bytes).map_err(|finding| {
        if !found.contains(&finding) {
            found.push(*finding);
        }
    });
    Ok(text.ok())
}

fn tally(name: &str, checked: &Checked, lang: Lang) -> String {
    let (rules, cases) = (checked.rules, checked.cases);
    match lang {
        Lang::Zh => format!("{name}：{rules} 条规则，{cases} 个用例"),
        Lang::En => format!("{name}: {}, {}", counted(rules, "rule"), counted(cases, "case")),
    }
}
