//! `whyroad evaluate --metric av2-scenario-mining`: sequences against sequences, read from files or made from a truth,
//! the episodes and the lake.

use super::{Args, read};
use crate::output::reason::{cannot_make, cannot_read, cannot_write, reason};
use crate::output::render_text;
use crate::{Global, output};
use anyhow::Context as _;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;
use whyroad_lake::Lake;
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{Bilingual, Diagnostic, DriveId, ScenarioId};
use whyroad_report::evaluation::scenario_mining::bridge::{self, Reference};
use whyroad_report::evaluation::scenario_mining::region::Region;
use whyroad_report::evaluation::scenario_mining::sequence::{self, Sequence};
use whyroad_report::evaluation::scenario_mining::{Figures, Scores, score};
use whyroad_report::evaluation::truth::TruthSet;

/// Truth and predictions from files of sequences.
pub(super) fn from_files(global: &Global, args: &Args, predictions: &Path) -> anyhow::Result<ExitCode> {
    let mut lost = Vec::new();
    let mut sequences = |path: &Path| -> anyhow::Result<Vec<Sequence>> {
        let (sequences, problems) = sequence::read(&read(path)?, &path.display().to_string());
        lost.extend(problems);
        Ok(sequences)
    };
    let mut truth = Vec::new();
    for path in &args.truth {
        truth.extend(sequences(path)?);
    }
    let predictions = sequences(predictions)?;
    finish(global, args, &truth, &predictions, &lost)
}

/// Truth and predictions from entries and episodes; the lake gives all positions.
pub(super) fn from_lake(
    global: &Global,
    args: &Args,
    truth: &TruthSet,
    episodes: &[EpisodeRecord],
    mut lost: Vec<Diagnostic>,
) -> anyhow::Result<ExitCode> {
    let lake = args.lake.as_ref().context(reason(
        "--metric av2-scenario-mining 需要 --lake（或 --predictions）",
        "--metric av2-scenario-mining needs --lake (or --predictions)",
    ))?;
    let lake =
        Lake::open(lake).map_err(|e| anyhow::anyhow!("{}", render_text(&e.diagnostic(), global.lang)))?;
    // A class is evaluated on a drive where the truth is complete for it, or has an entry of it.
    let mut asked: BTreeSet<(DriveId, ScenarioId)> =
        truth.entries.iter().map(|e| (e.drive_id.clone(), e.scenario_id.clone())).collect();
    for c in &truth.complete {
        asked.extend(c.drives.iter().flat_map(|d| c.classes.iter().map(|k| (d.clone(), k.clone()))));
    }
    let (mut there, mut found) = (Vec::new(), Vec::new());
    let drives: BTreeSet<&DriveId> = asked.iter().map(|(d, _)| d).collect();
    for id in drives {
        let drive = match lake.read_drive(id) {
            Ok(drive) => drive,
            Err(e) => {
                lost.push(e.diagnostic());
                continue;
            }
        };
        let entries = truth.entries.iter().filter(|e| &e.drive_id == id);
        let entries: Vec<Reference> = entries.map(Reference::from).collect();
        let mined = episodes.iter().filter(|e| &e.drive_id == id);
        let mined: Vec<Reference> = mined.map(Reference::from).collect();
        for (_, class) in asked.iter().filter(|(d, _)| d == id) {
            there.push(bridge::sequence(&drive, class, &entries));
            found.push(bridge::sequence(&drive, class, &mined));
        }
    }
    if let Some(dir) = &args.write {
        std::fs::create_dir_all(dir).with_context(|| cannot_make(dir.display()))?;
        for (name, sequences) in [("truth.jsonl", &there), ("predictions.jsonl", &found)] {
            let path = dir.join(name);
            std::fs::write(&path, sequence::write(sequences)?)
                .with_context(|| cannot_write(path.display()))?;
        }
    }
    finish(global, args, &there, &found, &lost)
}

fn finish(
    global: &Global,
    args: &Args,
    truth: &[Sequence],
    predictions: &[Sequence],
    lost: &[Diagnostic],
) -> anyhow::Result<ExitCode> {
    for d in lost {
        tell!("{}", render_text(d, global.lang));
    }
    let scores = match &region(args)? {
        Some(region) => {
            let inside =
                |all: &[Sequence]| -> Vec<Sequence> { all.iter().map(|s| region.inside(s)).collect() };
            score(&inside(truth), &inside(predictions))?
        }
        None => score(truth, predictions)?,
    };
    args.print.put(&scores, || table(&scores))?;
    if scores.mean.is_none() {
        say!("{}", nothing_compared().get(global.lang));
        return Ok(output::FINDINGS);
    }
    Ok(if lost.is_empty() { output::FINE } else { output::lost_input() })
}

fn nothing_compared() -> Bilingual {
    Bilingual::new(
        "没有比较任何内容：真值中没有可用的记录",
        "nothing was compared: the truth has no usable entry",
    )
}

/// The region of interest, where one is given. One raster covers one city: evaluate logs of one city at a time.
fn region(args: &Args) -> anyhow::Result<Option<Region>> {
    let (Some(raster), Some(transform)) = (&args.region, &args.region_transform) else { return Ok(None) };
    let bytes = std::fs::read(raster).with_context(|| cannot_read(raster.display()))?;
    Ok(Some(Region::read(&bytes, &read(transform)?)?))
}

/// Percent, as the challenge reports them.
fn table(scores: &Scores) -> String {
    let width = scores.prompts.keys().map(|p| p.chars().count()).max().unwrap_or(0).max(6);
    let mut out = format!(
        "{:width$} {:>13} {:>10} {:>12} {:>7}\n",
        "prompt", "HOTA-Temporal", "HOTA-Track", "timestamp BA", "log BA"
    );
    let mut row = |name: &str, f: Option<&Figures>| {
        let of: [fn(&Figures) -> f64; 4] = [
            |f| f.hota_temporal,
            |f| f.hota_track,
            |f| f.timestamp_balanced_accuracy,
            |f| f.log_balanced_accuracy,
        ];
        let [a, b, c, d] = of.map(|v| f.map_or("-".to_owned(), |f| format!("{:.2}", v(f) * 100.0)));
        let _ = writeln!(out, "{name:width$} {a:>13} {b:>10} {c:>12} {d:>7}");
    };
    for (prompt, f) in &scores.prompts {
        row(prompt, Some(f));
    }
    row("mean", scores.mean.as_ref());
    out
}
