//! `whyroad evaluate`: evaluates episodes against independent ground truth.

mod scenario_mining;

use crate::output::reason::{cannot_read, no_class, reason, stop};
use crate::output::{DataFormat, Print, render_text};
use crate::{Global, framework_folder, output};
use anyhow::Context as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_lake::MinedFolder;
use whyroad_lake::mined::MinedFile;
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{Lang, ScenarioId};
use whyroad_report::evaluation::truth::TruthSet;
use whyroad_report::evaluation::{Evaluation, evaluate, render};
use whyroad_report::verdicts;

/// Arguments of `whyroad evaluate`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Ground truth, JSON Lines (docs/reference/evaluation.md); may be given several times
    #[arg(long, value_name = "FILE", required_unless_present = "verdicts", num_args = 1..)]
    truth: Vec<PathBuf>,
    /// Verdicts on mined episodes instead of ground truth: prints the share that is right, by class and by score
    #[arg(long, value_name = "FILE", conflicts_with_all = ["truth", "episodes", "predictions"])]
    verdicts: Option<PathBuf>,
    /// Folder that `whyroad mine` wrote
    #[arg(long, value_name = "DIR", required_unless_present_any = ["predictions", "verdicts"])]
    episodes: Option<PathBuf>,
    /// Which figures
    #[arg(long, value_enum, default_value_t = Metric::Episodes)]
    metric: Metric,
    /// Sequences to compare with the truth's sequences, instead of episodes (av2-scenario-mining)
    #[arg(long, value_name = "FILE", conflicts_with = "episodes")]
    predictions: Option<PathBuf>,
    /// Lake that was mined: source of all positions (av2-scenario-mining)
    #[arg(long, value_name = "DIR")]
    lake: Option<PathBuf>,
    /// Write truth and predictions as sequences into this folder (av2-scenario-mining)
    #[arg(long, value_name = "DIR")]
    write: Option<PathBuf>,
    /// Region of interest: objects outside of this raster (.npy, bool) do not count (av2-scenario-mining)
    #[arg(long, value_name = "FILE", requires = "region_transform")]
    region: Option<PathBuf>,
    /// How city coordinates become cells of --region: a *_img_Sim2_city.json
    #[arg(long, value_name = "FILE", requires = "region")]
    region_transform: Option<PathBuf>,
    /// Only this class: an L1, L2 or leaf
    #[arg(long, value_name = "ID")]
    scenario: Option<ScenarioId>,
    /// Fail when the macro F1 is below this
    #[arg(long, value_name = "F1")]
    min_f1: Option<f64>,
    /// Fail when the F1 of any class that occurs is below this
    #[arg(long, value_name = "F1")]
    min_class_f1: Option<f64>,
    /// Fail when the median keyframe error is above this many seconds
    #[arg(long, value_name = "S")]
    max_keyframe_error: Option<f64>,
    /// Name every entry that was missed and every episode that is false
    #[arg(long)]
    details: bool,
    #[command(flatten)]
    print: Print,
}

/// Families of figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Metric {
    /// Precision, recall, F1 and keyframe error by class
    Episodes,
    /// HOTA-Temporal, HOTA-Track, balanced accuracy by timestamp and by log
    Av2ScenarioMining,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    if let Some(file) = &args.verdicts {
        return calibration(global, &args, file);
    }
    if let Some(predictions) = &args.predictions {
        if args.metric != Metric::Av2ScenarioMining {
            return Err(stop(
                "--predictions 需要 --metric av2-scenario-mining",
                "--predictions needs --metric av2-scenario-mining",
            ));
        }
        return scenario_mining::from_files(global, &args, predictions);
    }
    let (framework, _) = framework_folder::load(global)?;
    let is_class = |id: &ScenarioId| {
        framework.taxonomy.leaves().any(|(l1, l2, l3)| ScenarioId::leaf(&l1.id, &l2.id, &l3.id).is_within(id))
    };
    let mut truth = TruthSet::default();
    let mut lost = Vec::new();
    for path in &args.truth {
        lost.extend(truth.read(&read(path)?, &path.display().to_string(), &is_class));
    }
    let dir = args.episodes.as_deref().context(reason("缺少 --episodes", "--episodes is missing"))?;
    let mined =
        MinedFolder::open(dir).with_context(|| cannot_read(MinedFile::Episodes.path(dir).display()))?;
    let wanted =
        |e: &EpisodeRecord| args.scenario.as_ref().is_none_or(|class| e.scenario_id.is_within(class));
    let mut episodes = Vec::new();
    for line in mined.episodes()? {
        match line {
            Ok(episode) if wanted(&episode) => episodes.push(episode),
            Ok(_) => {}
            Err(d) => lost.push(*d),
        }
    }
    if let Some(class) = &args.scenario {
        if !is_class(class) {
            return Err(no_class(class));
        }
        truth.entries.retain(|e| e.scenario_id.is_within(class));
    }
    if args.metric == Metric::Av2ScenarioMining {
        return scenario_mining::from_lake(global, &args, &truth, &episodes, lost);
    }
    let evaluation = evaluate(&truth, &episodes);
    args.print.put(&evaluation, || render(&evaluation, global.lang))?;
    if args.details && args.print.format == DataFormat::Text {
        output::put(&details(&evaluation, global.lang));
    }
    for d in &lost {
        tell!("{}", render_text(d, global.lang));
    }
    let failures = shortfalls(&evaluation, &args, global.lang);
    for failure in &failures {
        say!("{failure}");
    }
    Ok(if !failures.is_empty() {
        output::FINDINGS
    } else if lost.is_empty() {
        output::FINE
    } else {
        output::lost_input()
    })
}

/// `evaluate --verdicts`.
fn calibration(global: &Global, args: &Args, file: &Path) -> anyhow::Result<ExitCode> {
    let (mut verdicts, problems) = verdicts::read(&read(file)?, &file.display().to_string());
    if let Some(class) = &args.scenario {
        verdicts.retain(|v| v.scenario_id.is_within(class));
    }
    let classes = verdicts::calibrate(&verdicts);
    args.print.put(&classes, || verdicts::render(&classes, global.lang))?;
    for d in &problems {
        tell!("{}", render_text(d, global.lang));
    }
    Ok(if problems.is_empty() { output::FINE } else { output::lost_input() })
}

fn read(path: &Path) -> anyhow::Result<String> {
    std::fs::read_to_string(path).with_context(|| cannot_read(path.display()))
}

/// Figures worse than their thresholds. A figure without a value does not reach its threshold.
fn shortfalls(e: &Evaluation, args: &Args, lang: Lang) -> Vec<String> {
    let mut out = Vec::new();
    let zh = lang == Lang::Zh;
    let shown = |v: Option<f64>| {
        let unknown = if zh { "未知" } else { "unknown" };
        v.map_or(unknown.to_owned(), |v| format!("{v:.3}"))
    };
    if let Some(least) = args.min_f1
        && e.macro_f1.is_none_or(|f| f < least)
    {
        let f1 = shown(e.macro_f1);
        out.push(match zh {
            true => format!("宏平均 F1 为 {f1}，低于 {least}"),
            false => format!("macro F1 is {f1}, under {least}"),
        });
    }
    if let Some(least) = args.min_class_f1 {
        for (id, c) in e.classes.iter().filter(|(_, c)| c.truth > 0 && c.f1.is_none_or(|f| f < least)) {
            let f1 = shown(c.f1);
            out.push(match zh {
                true => format!("{id}：F1 为 {f1}，低于 {least}"),
                false => format!("{id}: F1 is {f1}, under {least}"),
            });
        }
    }
    if let Some(most) = args.max_keyframe_error
        && e.keyframe_error_median_s.is_none_or(|s| s > most)
    {
        let error = shown(e.keyframe_error_median_s);
        out.push(match zh {
            true => format!("关键帧误差的中位数为 {error} s，超过 {most} s"),
            false => format!("median keyframe error is {error} s, over {most} s"),
        });
    }
    out
}

fn details(e: &Evaluation, lang: Lang) -> String {
    let (missed, spurious) = if lang == Lang::Zh { ("漏检", "误检") } else { ("missed", "false") };
    let mut out = String::from("\n");
    for m in &e.missed {
        let target = m.target_id.as_ref().map_or(String::new(), |t| format!(" {t}"));
        let instead: Vec<String> = m.found_instead.iter().map(ToString::to_string).collect();
        out += &format!(
            "{missed}  {} {} {}{target}  [{}]\n",
            m.scenario_id,
            m.drive_id,
            m.keyframe,
            instead.join(", ")
        );
    }
    for s in &e.spurious {
        out += &format!("{spurious}  {} {} {}\n", s.scenario_id, s.episode_id, s.keyframe);
    }
    out
}
