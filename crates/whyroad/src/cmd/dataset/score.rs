//! `whyroad dataset score`.

use super::{print, refused};
use crate::output::reason::{cannot_read, cannot_write};
use crate::output::{self, DataFormat};
use crate::{Global, framework_folder};
use anyhow::Context as _;
use std::fmt::Write as _;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_dataset::score::figures::Figures;
use whyroad_dataset::score::predictions::{Predictions, Vocabulary};
use whyroad_dataset::score::resample::Estimate;
use whyroad_dataset::score::{Options, Score, Target, page, score};
use whyroad_dataset::{Release, SplitName};
use whyroad_framework::Framework;
use whyroad_model::{Diagnostic, Lang};

/// Arguments of `whyroad dataset score`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// The release
    #[arg(value_name = "RELEASE")]
    release: PathBuf,
    /// Predictions, JSON Lines (docs/reference/model-evaluation.md)
    #[arg(value_name = "PREDICTIONS")]
    predictions: PathBuf,
    /// Split that the predictions are for
    #[arg(long, value_enum, default_value = "test")]
    split: SplitArg,
    /// Also write a page to open in a browser
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
    /// Bootstrap resamples behind the intervals
    #[arg(long, value_name = "N", default_value_t = 1000)]
    resamples: usize,
    /// Seed of the bootstrap
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// How to print the result
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    format: DataFormat,
}

/// A split of a release.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(crate) enum SplitArg {
    /// Training
    Train,
    /// Validation
    Val,
    /// Test
    Test,
}

impl From<SplitArg> for SplitName {
    fn from(split: SplitArg) -> Self {
        match split {
            SplitArg::Train => Self::Train,
            SplitArg::Val => Self::Val,
            SplitArg::Test => Self::Test,
        }
    }
}

pub(super) fn run(global: &Global, a: &Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let release = match Release::open(&a.release) {
        Ok(release) => release,
        Err(e) => return Ok(refused(global, &e)),
    };
    let (predictions, mut lost) = read(&a.predictions, &framework)?;
    let options = Options { split: a.split.into(), resamples: a.resamples, seed: a.seed };
    let (result, found) = match score(&release, &predictions, options) {
        Ok(scored) => scored,
        Err(e) => return Ok(refused(global, &e)),
    };
    lost.extend(found);
    print(global, &lost);
    show(global, &result, a.format, a.page.as_deref())?;
    Ok(if lost.is_empty() { output::FINE } else { output::lost_input() })
}

/// Predictions of a file, checked against the framework's classes.
pub(crate) fn read(path: &Path, framework: &Framework) -> anyhow::Result<(Predictions, Vec<Diagnostic>)> {
    let file = File::open(path).with_context(|| cannot_read(path.display()))?;
    let name = path.display().to_string();
    Predictions::read(BufReader::new(file), &name, &vocabulary(framework))
        .with_context(|| cannot_read(path.display()))
}

fn vocabulary(framework: &Framework) -> Vocabulary {
    let ids = framework.taxonomy.ids().into_iter().map(|id| id.to_string()).collect();
    let longitudinal = whyroad_model::decision::Longitudinal::ALL.iter().map(|d| d.id().to_owned()).collect();
    let lateral = whyroad_model::decision::Lateral::ALL.iter().map(|d| d.id().to_owned()).collect();
    Vocabulary([(Target::Leaf, ids), (Target::Longitudinal, longitudinal), (Target::Lateral, lateral)].into())
}

/// Prints a score, and writes its page.
pub(crate) fn show(
    global: &Global,
    result: &Score,
    format: DataFormat,
    file: Option<&Path>,
) -> anyhow::Result<()> {
    output::put(&match format {
        DataFormat::Json => format!("{}\n", serde_json::to_string_pretty(result)?),
        DataFormat::Text => text(result, global.lang),
    });
    if let Some(file) = file {
        std::fs::write(file, page::page(result, global.lang))
            .with_context(|| cannot_write(file.display()))?;
    }
    Ok(())
}

/// A score as text.
pub(crate) fn text(s: &Score, lang: Lang) -> String {
    let t = |zh: &'static str, en: &'static str| if lang == Lang::Zh { zh } else { en };
    let (samples, predicted, drives) = (s.samples, s.predicted, s.drives);
    let mut out = match lang {
        Lang::Zh => format!(
            "{} {}：{samples} 个样本，{predicted} 个有预测，{drives} 个行程\n",
            s.release,
            s.split.name()
        ),
        Lang::En => format!(
            "{} {}: {samples} samples, {predicted} with a prediction, {drives} drives\n",
            s.release,
            s.split.name()
        ),
    };
    let f = &s.overall;
    for (name, e, scale, unit) in [
        (t("纵向决策", "longitudinal decision"), &f.longitudinal, 100.0, "%"),
        (t("横向决策", "lateral decision"), &f.lateral, 100.0, "%"),
        (t("两个决策", "both decisions"), &f.decisions, 100.0, "%"),
        (t("L3 场景", "leaf"), &f.leaf, 100.0, "%"),
        ("L2", &f.l2, 100.0, "%"),
        ("ADE", &f.ade_m, 1.0, "m"),
        ("FDE", &f.fde_m, 1.0, "m"),
    ] {
        let _ = writeln!(out, "  {} {name}", figure(e.as_ref(), scale, unit));
    }
    for (target, of) in &s.classes {
        let (value, title) = (figure(of.macro_f1.as_ref(), 100.0, "%"), target.title());
        let _ = match lang {
            Lang::Zh => writeln!(out, "  {value} 宏平均 F1（{}）", title.zh),
            Lang::En => writeln!(out, "  {value} macro F1 {}", title.en),
        };
    }
    let groups = |title: &str, rows: Vec<(String, &Figures)>| {
        let mut out = format!("\n{title}\n");
        for (name, f) in rows {
            let share = |e: &Option<Estimate>| figure(e.as_ref(), 100.0, "%");
            let _ = writeln!(
                out,
                "{:>7}  {} {} {} {}  {name}",
                f.samples,
                share(&f.longitudinal),
                share(&f.lateral),
                share(&f.leaf),
                figure(f.ade_m.as_ref(), 1.0, "m")
            );
        }
        out
    };
    let named = |by: &'_ std::collections::BTreeMap<String, Figures>| by.keys().cloned().collect::<Vec<_>>();
    let columns = t("样本、纵向、横向、L3 场景、ADE", "samples, longitudinal, lateral, leaf, ADE");
    let leaf = format!("{} ({columns})", t("按 L3 场景", "by leaf"));
    out += &groups(&leaf, named(&s.by_leaf).into_iter().zip(s.by_leaf.values()).collect());
    out +=
        &groups(t("按地点", "by place"), named(&s.by_place).into_iter().zip(s.by_place.values()).collect());
    let rarity = s.by_rarity.iter().map(|(k, v)| (k.name().to_owned(), v)).collect();
    out += &groups(t("按训练集中同场景样本数", "by training samples of the leaf"), rarity);
    out
}

/// `93.2 % [90.1, 95.0]`, in a column.
fn figure(e: Option<&Estimate>, scale: f64, unit: &str) -> String {
    let text = match e {
        None => "-".to_owned(),
        Some(Estimate { value, low: Some(low), high: Some(high), .. }) => {
            format!("{:.1} {unit} [{:.1}, {:.1}]", value * scale, low * scale, high * scale)
        }
        Some(e) => format!("{:.1} {unit}", e.value * scale),
    };
    format!("{text:>24}")
}
