//! `whyroad lake upgrade`: whether a lake has the layout that this version reads. Layouts with and without packs are
//! both readable. Version 1 cannot be converted: its derived speeds cannot be distinguished from measured ones; the
//! commands that ingest the sources again are printed.

use crate::output::{Print, render_text};
use crate::{Global, output};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use whyroad_lake::LakeError;
use whyroad_model::Lang;

/// Arguments of `whyroad lake upgrade`.
#[derive(clap::Args)]
pub(super) struct Args {
    /// Lake
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    #[command(flatten)]
    print: Print,
}

/// The result.
#[derive(Serialize)]
struct Checked {
    current: usize,
    packed: usize,
    outdated: usize,
    unreadable: usize,
}

pub(super) fn run(global: &Global, args: &Args) -> anyhow::Result<ExitCode> {
    let Some(lake) = super::opened(&args.lake, global) else { return Ok(output::FINDINGS) };
    let mut checked = Checked { current: 0, packed: 0, outdated: 0, unreadable: 0 };
    // One message per version and format, which names the command.
    let mut outdated = BTreeMap::new();
    for (_, entry) in lake.entries() {
        match entry {
            Ok(entry) => {
                checked.current += 1;
                checked.packed += usize::from(entry.pack.is_some());
            }
            Err(e @ LakeError::Version { .. }) => {
                checked.outdated += 1;
                let LakeError::Version { found, formats, .. } = &e else { continue };
                outdated.entry((*found, formats.clone())).or_insert(e);
            }
            Err(e) => {
                checked.unreadable += 1;
                tell!("{}", render_text(&e.diagnostic(), global.lang));
            }
        }
    }
    for e in outdated.values() {
        tell!("{}", render_text(&e.diagnostic(), global.lang));
    }
    args.print.put(&checked, || text(&checked, global.lang))?;
    Ok(if checked.outdated + checked.unreadable == 0 { output::FINE } else { output::FINDINGS })
}

fn text(c: &Checked, lang: Lang) -> String {
    let Checked { current, packed, outdated, unreadable } = c;
    match (lang, outdated + unreadable) {
        (Lang::Zh, 0) => format!("{current} 个行程均为当前版本（{packed} 个在包中），无需操作\n"),
        (Lang::En, 0) => {
            format!("{current} drives are current ({packed} of them packed); no action needed\n")
        }
        (Lang::Zh, _) => {
            format!("{current} 个行程为当前版本，{outdated} 个须重新导入，{unreadable} 个无法读取\n")
        }
        (Lang::En, _) => {
            format!(
                "{current} drives are current, {outdated} have to be ingested again, {unreadable} cannot be read\n"
            )
        }
    }
}
