//! `whyroad explain`: why a class was found in a clip or not, condition by condition over time.

mod svg;
mod text;

use super::inspect::drive_of;
use crate::{Global, framework_folder, output};
use anyhow::{Context as _, bail};
use std::path::PathBuf;
use std::process::ExitCode;
use whyroad_framework::taxonomy::{Resolution, class_ambiguous, class_not_found};
use whyroad_lake::Lake;
use whyroad_mining::RuleSet;
use whyroad_mining::explain::{Explanation, explain};
use whyroad_model::diagnostic::render_text;
use whyroad_model::scene::FRAME_RATE_HZ;
use whyroad_model::{ScenarioId, TrackId};
use whyroad_signals::Catalogue;

/// Arguments of `whyroad explain`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Leaf, or L2 with a rule of its own; full or unambiguous short id
    #[arg(value_name = "CLASS")]
    class: String,
    /// Lake that holds the clip
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Clip to look at
    #[arg(long, value_name = "ID")]
    clip: String,
    /// Track id of the target; the one that came nearest unless said
    #[arg(long, value_name = "ID")]
    target: Option<String>,
    /// Also draw it into this file
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
}

/// What both forms of output show.
struct Shown<'a> {
    class: &'a ScenarioId,
    clip: &'a str,
    explanation: &'a Explanation,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let (catalogue, _) = Catalogue::parse(&framework.signals_yaml);
    let class = match framework.taxonomy.resolve(&args.class) {
        Resolution::Found(id) => id,
        Resolution::Ambiguous(ids) => {
            tell!("{}", render_text(&class_ambiguous(&args.class, &ids), global.lang));
            return Ok(output::FINDINGS);
        }
        Resolution::Unknown(near) => {
            let near: Vec<String> = near.iter().map(ToString::to_string).collect();
            tell!("{}", render_text(&class_not_found(&args.class, &near), global.lang));
            return Ok(output::FINDINGS);
        }
    };
    let (rules, _) = RuleSet::of_framework(&framework, &catalogue);
    let Some(rule) = rules.rules.iter().find(|r| r.scenario == class) else {
        bail!("{class} has no mining rule");
    };
    let lake = match Lake::open(&args.lake) {
        Ok(lake) => lake,
        Err(e) => {
            tell!("{}", render_text(&e.diagnostic(), global.lang));
            return Ok(output::FINDINGS);
        }
    };
    let Some(drive) = drive_of(&lake, &args.clip) else {
        bail!("there is no clip '{}' in the lake; `whyroad inspect --lake DIR` lists the clips", args.clip);
    };
    let drive = match lake.read_drive(&drive) {
        Ok(drive) => drive,
        Err(e) => {
            tell!("{}", render_text(&e.diagnostic(), global.lang));
            return Ok(output::FINDINGS);
        }
    };
    let index = args.clip.rsplit_once('_').and_then(|(_, i)| i.parse::<usize>().ok()).unwrap_or_default();
    let clip = drive.clips().get(index).copied().unwrap_or_default();
    let wanted = args.target.as_deref().map(TrackId::from);
    if let Some(id) = wanted.as_ref().filter(|id| !drive.tracks.iter().any(|t| t.id == **id)) {
        bail!("the drive has no track '{id}'");
    }
    let table = whyroad_signals::derive(&drive);
    let explanation = explain(rule, &table, clip, wanted.as_ref());
    let shown = Shown { class: &class, clip: &args.clip, explanation: &explanation };
    output::put(&text::render(&shown, global.lang));
    if let Some(file) = &args.svg {
        std::fs::write(file, svg::render(&shown, global.lang))
            .with_context(|| format!("cannot write {}", file.display()))?;
    }
    Ok(output::FINE)
}

/// Seconds from the start of a clip.
fn seconds(frame: usize) -> f64 {
    frame as f64 / FRAME_RATE_HZ
}
