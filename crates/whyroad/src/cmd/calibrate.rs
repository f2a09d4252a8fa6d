//! `whyroad calibrate`: from episodes judged by ground truth or people to the shares that mining uses as scores.

use crate::output::reason::{cannot_read, cannot_write};
use crate::output::{Print, render_text};
use crate::{Global, framework_folder, output};
use anyhow::{Context as _, ensure};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_framework::Calibration;
use whyroad_framework::calibration::{CalibrationSource, SourceKind};
use whyroad_lake::MinedFolder;
use whyroad_lake::mined::MinedFile;
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{Diagnostic, Lang, ScenarioId};
use whyroad_report::calibration::{
    CalibrationError, fit, held_out, judged_by_truth, judged_by_verdicts, render, source,
};
use whyroad_report::evaluation::truth::TruthSet;
use whyroad_report::verdicts;

/// Arguments of `whyroad calibrate`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Folder that `whyroad mine` wrote; may be given several times
    #[arg(long, value_name = "DIR", required = true, num_args = 1..)]
    episodes: Vec<PathBuf>,
    /// Ground truth, JSON Lines: episodes of classes and drives that it declares complete are judged
    #[arg(long, value_name = "FILE", num_args = 1.., required_unless_present = "verdicts")]
    truth: Vec<PathBuf>,
    /// Verdicts on these episodes, as the labeling service exports them
    #[arg(long, value_name = "FILE", num_args = 1..)]
    verdicts: Vec<PathBuf>,
    /// Name of the judged data, for readers of the table
    #[arg(long, value_name = "TEXT", default_value = "")]
    name: String,
    /// Use only the newly judged episodes; by default the current table counts as at most ten episodes per class, and
    /// is kept for classes without new ones
    #[arg(long)]
    fresh: bool,
    /// Write the table: schema/calibration.yaml of a framework folder
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    print: Print,
}

/// The printed result.
#[derive(Serialize)]
struct Printed<'a> {
    calibration: &'a Calibration,
    held_out: Option<HeldOut>,
}

/// Errors on held-out drives.
#[derive(Serialize)]
struct HeldOut {
    shares: CalibrationError,
    margin_scores: CalibrationError,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let is_class = |id: &ScenarioId| framework.taxonomy.contains(id);
    let mut lost: Vec<Diagnostic> = Vec::new();
    let episodes = episodes(&args.episodes, &is_class, &mut lost)?;

    let mut truth = TruthSet::default();
    for path in &args.truth {
        lost.extend(truth.read(&read(path)?, &path.display().to_string(), &is_class));
    }
    let by_truth = judged_by_truth(&truth, &episodes);
    let mut verdict_lines = Vec::new();
    for path in &args.verdicts {
        let (lines, problems) = verdicts::read(&read(path)?, &path.display().to_string());
        verdict_lines.extend(lines);
        lost.extend(problems);
    }
    let (by_people, unmatched) = judged_by_verdicts(&verdict_lines, &episodes);

    let earlier = Some(&framework.calibration).filter(|t| !args.fresh && !t.classes.is_empty());
    let mut sources: Vec<CalibrationSource> = Vec::new();
    for (judged, kind) in [(&by_truth, SourceKind::Truth), (&by_people, SourceKind::Verdicts)] {
        if !judged.is_empty() {
            sources.push(source(&args.name, kind, judged));
        }
    }
    if let Some(table) = earlier {
        let (judged, right) = table.totals();
        let drives = table.sources.iter().map(|s| s.drives).sum();
        let names: Vec<&str> = table.sources.iter().map(|s| s.name.as_str()).collect();
        let name = names.join("; ");
        sources.push(CalibrationSource { name, kind: SourceKind::Table, drives, judged, right });
    }
    let judged = [by_truth, by_people].concat();
    ensure!(!judged.is_empty(), "{}", nothing_judged(global.lang));
    let table = fit(&judged, earlier, sources);
    let errors = held_out(&judged, earlier);
    let shown = Printed {
        calibration: &table,
        held_out: errors.map(|(shares, margin_scores)| HeldOut { shares, margin_scores }),
    };
    args.print.put(&shown, || render(&table, errors.as_ref(), global.lang))?;
    if let Some(out) = &args.out {
        std::fs::write(out, table.to_yaml()?).with_context(|| cannot_write(out.display()))?;
    }
    for d in &lost {
        tell!("{}", render_text(d, global.lang));
    }
    if !unmatched.is_empty() {
        say!("{}", without_episode(unmatched.len(), global.lang));
    }
    Ok(if lost.is_empty() && unmatched.is_empty() { output::FINE } else { output::lost_input() })
}

/// The episodes of these folders whose class is in the taxonomy.
fn episodes(
    folders: &[PathBuf],
    is_class: &dyn Fn(&ScenarioId) -> bool,
    lost: &mut Vec<Diagnostic>,
) -> anyhow::Result<Vec<EpisodeRecord>> {
    let mut out = Vec::new();
    for dir in folders {
        let mined =
            MinedFolder::open(dir).with_context(|| cannot_read(MinedFile::Episodes.path(dir).display()))?;
        for line in mined.episodes()? {
            match line {
                Ok(episode) if is_class(&episode.scenario_id) => out.push(episode),
                Ok(_) => {}
                Err(d) => lost.push(*d),
            }
        }
    }
    Ok(out)
}

fn read(path: &Path) -> anyhow::Result<String> {
    std::fs::read_to_string(path).with_context(|| cannot_read(path.display()))
}

fn nothing_judged(lang: Lang) -> &'static str {
    match lang {
        Lang::Zh => {
            "没有已判定的事件：真值文件首行须声明完整的类别和行程（complete、drives），判定须属于所给文件夹中的事件"
        }
        Lang::En => {
            "no episode is judged: the first line of a truth file must declare complete classes and drives, and \
             verdicts must be on episodes of the folders given"
        }
    }
}

fn without_episode(count: usize, lang: Lang) -> String {
    match lang {
        Lang::Zh => format!("{count} 个判定的事件不在 --episodes 的文件夹中，未使用"),
        Lang::En => {
            format!("verdicts on {count} episodes that are not in the folders of --episodes are not used")
        }
    }
}
