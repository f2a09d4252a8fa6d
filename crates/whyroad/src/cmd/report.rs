//! `whyroad report`: what mining found, as one self-contained page.

use crate::output::{Print, render_text};
use crate::{Global, framework_folder, output};
use anyhow::{Context as _, bail};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_engine::drives::{map_drives, signals_of};
use whyroad_framework::Framework;
use whyroad_lake::mined::MinedFile;
use whyroad_lake::{Lake, LakeError, MinedFolder};
use whyroad_model::messages::Coverage;
use whyroad_model::{Diagnostic, DriveId, Lang, SignalTable};
use whyroad_report::report::{
    CardChoice, ChosenEpisodes, DrivePart, ReportBuilder, ReportContext, SignalInfo,
};
use whyroad_signals::Catalogue;

/// Arguments of `whyroad report`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Lake that was mined
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Folder that `whyroad mine` wrote
    #[arg(long, value_name = "DIR")]
    mined: PathBuf,
    /// The page
    #[arg(long, value_name = "FILE", default_value = "report.html")]
    out: PathBuf,
    /// Maximum number of episodes with an image, primary ones first; the rest is counted
    #[arg(long, value_name = "N", default_value_t = MAX_CARDS)]
    max_episodes: usize,
    #[command(flatten)]
    print: Print,
}

/// About 30 kB per episode: what a browser still scrolls smoothly.
pub(crate) const MAX_CARDS: usize = 400;

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, faults) = framework_folder::load(global)?;
    let lake = match Lake::open(&args.lake) {
        Ok(lake) => lake,
        Err(e) => return Ok(refuse(&e.diagnostic(), global.lang)),
    };
    let Some(mined) = MinedFolder::open(&args.mined) else {
        bail!(
            "{} has no {}; `whyroad mine --out DIR` writes it",
            args.mined.display(),
            MinedFile::Episodes.name()
        );
    };
    let coverage = match mined.coverage() {
        Ok(coverage) => coverage,
        Err(d) => return Ok(refuse(&d, global.lang)),
    };
    let mut lost = Vec::new();
    let readable = mined.episodes()?.filter_map(|line| line.map_err(|d| lost.push(*d)).ok());
    let chosen = CardChoice::new(args.max_episodes).choose_all(readable);
    let found = Found { framework: &framework, lake: &lake, coverage: &coverage, chosen: &chosen };
    lost.extend(write_page(&found, &args.out, global.lang)?);
    for d in &lost {
        tell!("{}", render_text(d, global.lang));
    }
    let written = json!({ "page": args.out, "drives": coverage.drives.len(), "unreadable": lost.len() });
    args.print.put(&written, || format!("{}\n", args.out.display()))?;
    Ok(if !lost.is_empty() {
        output::lost_input()
    } else if faults.is_empty() {
        output::FINE
    } else {
        output::FINDINGS
    })
}

fn refuse(d: &Diagnostic, lang: Lang) -> ExitCode {
    tell!("{}", render_text(d, lang));
    output::FINDINGS
}

/// What a page is made of.
#[derive(Clone, Copy)]
pub(crate) struct Found<'a> {
    pub framework: &'a Framework,
    pub lake: &'a Lake,
    pub coverage: &'a Coverage,
    pub chosen: &'a BTreeMap<DriveId, ChosenEpisodes>,
}

/// Writes the page, drives on all cores; a drive that cannot be read is named, and is not in it.
pub(crate) fn write_page(found: &Found<'_>, out: &Path, lang: Lang) -> anyhow::Result<Vec<Diagnostic>> {
    let (catalogue, _) = Catalogue::parse(&found.framework.signals_yaml);
    let signals: BTreeMap<String, SignalInfo> = catalogue
        .iter()
        .map(|d| {
            let info = SignalInfo { unit: d.unit, meaning: d.meaning.clone(), scale: d.scale };
            (d.name.clone(), info)
        })
        .collect();
    let (framework, coverage) = (found.framework, found.coverage);
    let context = ReportContext { framework, coverage, signals: &signals, lang };
    let part = |id: &DriveId| -> Result<DrivePart, LakeError> {
        let drive = whyroad_engine::estimated(found.lake.read_drive(id)?);
        let none = ChosenEpisodes::default();
        let chosen = found.chosen.get(id).unwrap_or(&none);
        // Only cards show signals.
        let signals = match chosen.cards.is_empty() {
            true => SignalTable::default(),
            false => signals_of(found.lake, id)?,
        };
        Ok(DrivePart::new(&context, &drive, &signals, chosen))
    };
    let mut page = ReportBuilder::new(context);
    let mut lost = Vec::new();
    map_drives(&coverage.drives, None, part, |part| {
        match part {
            Ok(part) => page.add(part),
            Err(e) => lost.push(e.diagnostic()),
        }
        anyhow::Ok(())
    })?;
    if let Some(dir) = out.parent().filter(|d| !d.as_os_str().is_empty()) {
        std::fs::create_dir_all(dir).with_context(|| format!("cannot make {}", dir.display()))?;
    }
    std::fs::write(out, page.finish()).with_context(|| format!("cannot write {}", out.display()))?;
    Ok(lost)
}
