//! `whyroad completions` and `whyroad man`: descriptions of the command line for shells and `man`.

use crate::output::reason::{cannot_make, cannot_write};
use crate::{command_line, output};
use anyhow::Context as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `whyroad completions`.
#[derive(clap::Args)]
pub(crate) struct CompletionsArgs {
    /// Shell
    #[arg(value_name = "SHELL")]
    shell: clap_complete::Shell,
}

/// Arguments of `whyroad man`.
#[derive(clap::Args)]
pub(crate) struct ManArgs {
    /// Folder for the pages; created if missing
    #[arg(long, value_name = "DIR", default_value = "man")]
    out: PathBuf,
}

pub(crate) fn completions(args: CompletionsArgs) -> anyhow::Result<ExitCode> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command_line(), "whyroad", &mut script);
    output::put(&String::from_utf8(script)?);
    Ok(output::FINE)
}

pub(crate) fn man(args: ManArgs) -> anyhow::Result<ExitCode> {
    std::fs::create_dir_all(&args.out).with_context(|| cannot_make(args.out.display()))?;
    let mut command = command_line().disable_help_subcommand(true);
    command.build();
    let pages = pages(command, "whyroad".to_owned(), &args.out)?;
    say!("{pages} pages in {}", args.out.display());
    Ok(output::FINE)
}

/// Writes the page of a command and those of its subcommands; `whyroad-taxonomy-list.1` for `whyroad taxonomy list`.
fn pages(command: clap::Command, name: String, out: &Path) -> anyhow::Result<usize> {
    let mut count = 1;
    for sub in command.get_subcommands().filter(|s| !s.is_hide_set()) {
        count += pages(sub.clone(), format!("{name}-{}", sub.get_name()), out)?;
    }
    let path = out.join(format!("{name}.1"));
    let mut page = Vec::new();
    // clap_mangen takes the page's title from the command's name.
    let titled: &'static str = name.leak();
    clap_mangen::Man::new(command.name(titled)).render(&mut page)?;
    std::fs::write(&path, page).with_context(|| cannot_write(path.display()))?;
    Ok(count)
}
