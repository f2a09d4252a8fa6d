//! `whyroad report`: what mining found, as one self-contained page.

use crate::output::render_text;
use crate::{Global, framework_folder, output};
use anyhow::Context as _;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_framework::Framework;
use whyroad_lake::Lake;
use whyroad_model::messages::{Coverage, EpisodeRecord};
use whyroad_model::{Diagnostic, Lang};
use whyroad_report::mined;
use whyroad_report::report::{ReportBuilder, ReportContext, SignalInfo};
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
    /// At most so many episodes with a picture, primary ones first; the rest is counted
    #[arg(long, value_name = "N", default_value_t = MAX_CARDS)]
    max_episodes: usize,
}

/// About 30 kB an episode: what a browser still scrolls smoothly.
pub(crate) const MAX_CARDS: usize = 400;

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, faults) = framework_folder::load(global)?;
    let lake = match Lake::open(&args.lake) {
        Ok(lake) => lake,
        Err(e) => return Ok(refuse(&e.diagnostic(), global.lang)),
    };
    let read = |name: &str| {
        let path = args.mined.join(name);
        let text = std::fs::read_to_string(&path)
            .with_context(|| format!("cannot read {}; `whyroad mine --out DIR` writes it", path.display()))?;
        anyhow::Ok((text, path.display().to_string()))
    };
    let (text, file) = read("coverage.json")?;
    let coverage = match mined::read_coverage(&text, &file) {
        Ok(coverage) => coverage,
        Err(d) => return Ok(refuse(&d, global.lang)),
    };
    let (text, file) = read("episodes.jsonl")?;
    let (episodes, mut lost) = mined::read_episodes(&text, &file);

    let found = Found { framework: &framework, lake: &lake, coverage: &coverage, episodes: &episodes };
    lost.extend(write_page(&found, &args.out, args.max_episodes, global.lang)?);
    for d in &lost {
        tell!("{}", render_text(d, global.lang));
    }
    output::put(&format!("{}\n", args.out.display()));
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
    pub episodes: &'a [EpisodeRecord],
}

/// Writes the page; a drive that cannot be read is named, and is not in it.
pub(crate) fn write_page(
    found: &Found<'_>,
    out: &Path,
    max_cards: usize,
    lang: Lang,
) -> anyhow::Result<Vec<Diagnostic>> {
    let (catalogue, _) = Catalogue::parse(&found.framework.signals_yaml);
    let signals: BTreeMap<String, SignalInfo> = catalogue
        .iter()
        .map(|d| {
            let info = SignalInfo { unit: d.unit, meaning: d.meaning.clone(), scale: d.scale };
            (d.name.clone(), info)
        })
        .collect();
    let mut page = ReportBuilder::new(ReportContext {
        framework: found.framework,
        coverage: found.coverage,
        signals: &signals,
        lang,
        max_cards,
    });
    let mut lost = Vec::new();
    for id in &found.coverage.drives {
        match found.lake.read_drive(id) {
            Ok(drive) => page.add_drive(&drive, &whyroad_signals::derive(&drive), found.episodes),
            Err(e) => lost.push(e.diagnostic()),
        }
    }
    if let Some(dir) = out.parent().filter(|d| !d.as_os_str().is_empty()) {
        std::fs::create_dir_all(dir).with_context(|| format!("cannot make {}", dir.display()))?;
    }
    std::fs::write(out, page.finish()).with_context(|| format!("cannot write {}", out.display()))?;
    Ok(lost)
}
