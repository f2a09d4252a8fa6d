//! `whyroad compare A B`: what changed between two mined folders.

use crate::output::{self, Print};
use crate::{Global, framework_folder};
use anyhow::{Context as _, bail};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_lake::MinedFolder;
use whyroad_model::messages::{CocLabel, EpisodeRecord};
use whyroad_model::{DriveId, ScenarioId};
use whyroad_report::comparison::{AcceptedMoment, compare, render};

/// Arguments of `whyroad compare`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Mined folder before the change
    #[arg(value_name = "A")]
    before: PathBuf,
    /// Mined folder after the change
    #[arg(value_name = "B")]
    after: PathBuf,
    /// Accepted labels (JSON Lines, from `tasks export`) that judge the changes
    #[arg(long, value_name = "FILE")]
    labels: Option<PathBuf>,
    /// Only this class: an L1, L2 or leaf
    #[arg(long, value_name = "ID")]
    scenario: Option<String>,
    /// Name changed episodes, up to five per class and change
    #[arg(long)]
    examples: bool,
    #[command(flatten)]
    print: Print,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let class = match &args.scenario {
        Some(text) => match framework.taxonomy.resolve(text) {
            whyroad_framework::Resolution::Found(id) => Some(id),
            _ => bail!("class '{text}' not found; `whyroad taxonomy list` shows all classes"),
        },
        None => None,
    };
    let (drives_before, before) = read(&args.before, class.as_ref())?;
    let (drives_after, after) = read(&args.after, class.as_ref())?;
    let accepted = args.labels.as_deref().map(|file| accepted(file, &drives_before)).transpose()?;
    let comparison = compare((&drives_before, &before), (&drives_after, &after), accepted.as_deref());
    args.print.put(&comparison, || render(&comparison, global.lang, args.examples))?;
    Ok(output::FINE)
}

/// Drives that were searched, and the episodes of a class (all classes where none is named).
fn read(dir: &Path, class: Option<&ScenarioId>) -> anyhow::Result<(Vec<DriveId>, Vec<EpisodeRecord>)> {
    let folder = MinedFolder::open(dir)
        .with_context(|| format!("{} is not a folder of `whyroad mine --out DIR`", dir.display()))?;
    let coverage = match folder.coverage() {
        Ok(coverage) => coverage,
        Err(d) => bail!("{}", output::render_text(&d, whyroad_model::Lang::En)),
    };
    let mut episodes = Vec::new();
    for episode in folder.episodes().map_err(|e| anyhow::anyhow!("{e}"))? {
        match episode {
            Ok(e) if class.is_none_or(|c| e.scenario_id.is_within(c)) => episodes.push(e),
            Ok(_) => {}
            Err(d) => bail!("{}", output::render_text(&d, whyroad_model::Lang::En)),
        }
    }
    Ok((coverage.drives, episodes))
}

/// Accepted labels of a file, by the drive that their clip belongs to.
fn accepted(file: &Path, drives: &[DriveId]) -> anyhow::Result<Vec<AcceptedMoment>> {
    let text = std::fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
    let mut out = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()) {
        let label: CocLabel =
            serde_json::from_str(line).with_context(|| format!("{}:{}", file.display(), i + 1))?;
        let of = &label.scenario;
        let id =
            [Some(&of.l1), Some(&of.l2), of.l3.as_ref()].into_iter().flatten().cloned().collect::<Vec<_>>();
        // A clip is named by its drive and a number: <drive>_000.
        let drive = label.clip_id.rsplit_once('_').map(|(drive, _)| DriveId::from(drive));
        if let (Some(drive), Ok(scenario)) = (drive.filter(|d| drives.contains(d)), id.join(".").parse()) {
            out.push(AcceptedMoment { drive, scenario, keyframe: label.keyframe.timestamp });
        }
    }
    Ok(out)
}
