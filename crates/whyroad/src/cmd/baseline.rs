//! `whyroad baseline`: a model from the history alone that any other model should beat.

use crate::cmd::dataset::score::{SplitArg, text};
use crate::output::reason::{cannot_write, stop};
use crate::output::{self, DataFormat, Print};
use crate::{Global, framework_folder};
use anyhow::Context as _;
use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use whyroad_dataset::baseline::compare::compare;
use whyroad_dataset::baseline::{Method, Model, Settings, page, rows};
use whyroad_dataset::score::{Options, Target};
use whyroad_dataset::{DatasetError, Release, SplitName};
use whyroad_model::Lang;

/// Arguments of `whyroad baseline`.
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// Train on the training split and calibrate on the validation split
    Train(Train),
    /// Compare a trained model with the majority class and with repeating the last action
    Evaluate(Evaluate),
}

#[derive(clap::Args)]
struct Train {
    /// The release
    #[arg(value_name = "RELEASE")]
    release: PathBuf,
    /// Model file to write (JSON)
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Trees per class
    #[arg(long, value_name = "N", default_value_t = 60)]
    rounds: usize,
    /// Seed
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
}

#[derive(clap::Args)]
struct Evaluate {
    /// The release
    #[arg(value_name = "RELEASE")]
    release: PathBuf,
    /// Model file of `whyroad baseline train`
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// Split to evaluate on
    #[arg(long, value_enum, default_value = "test")]
    split: SplitArg,
    /// Write the predictions (JSON Lines, for `whyroad dataset score`)
    #[arg(long, value_name = "FILE")]
    predictions: Option<PathBuf>,
    /// Write a page with reliability diagrams
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
    /// Bootstrap resamples behind the intervals
    #[arg(long, value_name = "N", default_value_t = 1000)]
    resamples: usize,
    /// Seed of the bootstrap
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    print: Print,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    framework_folder::load(global)?;
    match args.what {
        What::Train(a) => train(global, &a),
        What::Evaluate(a) => evaluate(global, &a),
    }
}

fn failed(global: &Global, e: &DatasetError) -> ExitCode {
    for d in e.diagnostics() {
        tell!("{}", output::render_text(&d, global.lang));
    }
    output::FINDINGS
}

fn named(release: &Release) -> String {
    format!("{} {}", release.manifest.name, release.manifest.version)
}

fn train(global: &Global, a: &Train) -> anyhow::Result<ExitCode> {
    let read = || {
        let release = Release::open(&a.release)?;
        let train = rows(&release, Some(SplitName::Train))?;
        let val = rows(&release, Some(SplitName::Val))?;
        Ok((release, train, val))
    };
    let (release, train, val) = match read() {
        Ok(read) => read,
        Err(e) => return Ok(failed(global, &e)),
    };
    if train.is_empty() {
        return Err(stop(
            format!("{} 没有训练样本", a.release.display()),
            format!("{} has no training samples", a.release.display()),
        ));
    }
    let model = Model::train(&named(&release), &train, &val, Settings { rounds: a.rounds, seed: a.seed });
    let text = match model.to_json() {
        Ok(text) => text,
        Err(e) => return Ok(failed(global, &e)),
    };
    std::fs::write(&a.out, text).with_context(|| cannot_write(a.out.display()))?;
    let (n, m) = (train.len(), val.len());
    match global.lang {
        Lang::Zh => say!("用 {n} 个样本训练，{m} 个样本校准：{}", a.out.display()),
        Lang::En => say!("trained on {n} samples, calibrated on {m}: {}", a.out.display()),
    }
    Ok(output::FINE)
}

fn evaluate(global: &Global, a: &Evaluate) -> anyhow::Result<ExitCode> {
    let split: SplitName = a.split.into();
    let read = || {
        let release = Release::open(&a.release)?;
        let rows = rows(&release, Some(split))?;
        Ok((release, rows, Model::read(&a.model)?))
    };
    let (release, rows, model) = match read() {
        Ok(read) => read,
        Err(e) => return Ok(failed(global, &e)),
    };
    let counts = &release.manifest.counts.by_class;
    let in_training: BTreeMap<&str, usize> =
        counts.iter().map(|(class, by)| (class.as_str(), by.get("train").copied().unwrap_or(0))).collect();
    let options = Options { split, resamples: a.resamples, seed: a.seed };
    let (c, predictions) = compare(&model, &named(&release), &rows, &in_training, options);
    match a.print.format {
        DataFormat::Json => output::put_json(&c)?,
        DataFormat::Text => {
            for method in Method::ALL {
                if let Some(score) = c.methods.get(&method) {
                    let title = method.title();
                    output::put(&format!("# {}\n{}\n", title.get(global.lang), text(score, global.lang)));
                }
            }
            for target in Target::ALL {
                let error = c.reliability.get(&target).and_then(|r| r.error);
                let error = error.map_or("-".to_owned(), |e| format!("{:.1} %", e * 100.0));
                let title = target.title();
                output::put(&match global.lang {
                    Lang::Zh => format!("期望校准误差 ECE（{}）：{error}\n", title.zh),
                    Lang::En => format!("ECE {}: {error}\n", title.en),
                });
            }
        }
    }
    if let Some(path) = &a.predictions {
        let mut out = Vec::new();
        for p in &predictions {
            writeln!(out, "{}", serde_json::to_string(p)?)?;
        }
        std::fs::write(path, out).with_context(|| cannot_write(path.display()))?;
    }
    if let Some(path) = &a.page {
        std::fs::write(path, page::page(&c, global.lang)).with_context(|| cannot_write(path.display()))?;
    }
    Ok(output::FINE)
}
