//! Scores of any model on one split of a release: decisions, class, trajectory, with confidence intervals, overall and
//! by leaf, place and rarity. `docs/reference/model-evaluation.md` defines every figure.
//!
//! It runs no model: predictions come as lines of JSON ([`predictions`]), from the built-in baseline or from elsewhere.

pub mod figures;
pub mod page;
pub mod predictions;
pub mod resample;
pub mod target;
pub mod truth;

pub use target::{NO_CHANGE, Options, Target};

use crate::{DatasetError, Release, SplitName};
use figures::{ClassFigures, Figures};
use predictions::Predictions;
use serde::Serialize;
use std::collections::BTreeMap;
use truth::Truth;
use whyroad_model::{Bilingual, Diagnostic};

/// The result.
#[derive(Clone, Debug, Serialize)]
pub struct Score {
    /// Name and version of the release.
    pub release: String,
    /// Split.
    pub split: SplitName,
    /// Samples in the split.
    pub samples: usize,
    /// Samples with a prediction.
    pub predicted: usize,
    /// Drives in the split: the unit of the bootstrap.
    pub drives: usize,
    /// Bootstrap resamples.
    pub resamples: usize,
    /// Seed.
    pub seed: u64,
    /// All samples.
    pub overall: Figures,
    /// Per class of each target that the model predicts.
    pub classes: BTreeMap<Target, ClassFigures>,
    /// By `scenario_id`.
    pub by_leaf: BTreeMap<String, Figures>,
    /// By place; `unknown` where the drive states none.
    pub by_place: BTreeMap<String, Figures>,
    /// By samples of the same leaf in the training split.
    pub by_rarity: BTreeMap<Rarity, Figures>,
}

/// How many training samples have the leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum Rarity {
    /// None.
    #[serde(rename = "0")]
    Unseen,
    /// 1 to 9.
    #[serde(rename = "1-9")]
    Few,
    /// 10 to 99.
    #[serde(rename = "10-99")]
    Some,
    /// 100 and more.
    #[serde(rename = "100+")]
    Many,
}

impl Rarity {
    /// The group of a leaf with `n` training samples.
    pub fn of(n: usize) -> Self {
        match n {
            0 => Self::Unseen,
            1..=9 => Self::Few,
            10..=99 => Self::Some,
            _ => Self::Many,
        }
    }

    /// The range as text.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unseen => "0",
            Self::Few => "1-9",
            Self::Some => "10-99",
            Self::Many => "100+",
        }
    }
}

/// Scores `predictions` on a split of `release`.
///
/// # Errors
/// When the release cannot be read.
pub fn score(
    release: &Release,
    predictions: &Predictions,
    options: Options,
) -> Result<(Score, Vec<Diagnostic>), DatasetError> {
    let truth = truth::read(release, options.split)?;
    let in_training: BTreeMap<&str, usize> = release
        .manifest
        .counts
        .by_class
        .iter()
        .map(|(class, by)| (class.as_str(), by.get("train").copied().unwrap_or(0)))
        .collect();
    let name = format!("{} {}", release.manifest.name, release.manifest.version);
    Ok(score_truth(&name, &truth, &in_training, predictions, options))
}

/// The same on samples that were read already; `in_training` counts training samples by `scenario_id`.
pub fn score_truth(
    release: &str,
    truth: &[Truth],
    in_training: &BTreeMap<&str, usize>,
    predictions: &Predictions,
    options: Options,
) -> (Score, Vec<Diagnostic>) {
    let mut found = unmatched(truth, predictions, options.split);
    let rows: Vec<figures::Row<'_>> =
        truth.iter().map(|t| figures::Row::of(t, predictions.of(&t.sample_id))).collect();
    found.extend(short_trajectories(&rows));
    found.extend(unknown_decisions(truth));
    let targets: Vec<Target> =
        Target::ALL.into_iter().filter(|t| predictions.rows().any(|p| p.class(*t).is_some())).collect();
    let drawn = |rows: &[&figures::Row<'_>]| figures::of(rows, &targets, options);
    let group = |key: &dyn Fn(&figures::Row<'_>) -> String| {
        let mut groups: BTreeMap<String, Vec<&figures::Row<'_>>> = BTreeMap::new();
        rows.iter().for_each(|r| groups.entry(key(r)).or_default().push(r));
        groups.into_iter().map(|(k, rows)| (k, drawn(&rows))).collect::<BTreeMap<_, _>>()
    };
    let rarity =
        |r: &figures::Row<'_>| Rarity::of(in_training.get(r.truth.leaf.as_str()).copied().unwrap_or(0));
    let mut by_rarity: BTreeMap<Rarity, Vec<&figures::Row<'_>>> = BTreeMap::new();
    rows.iter().for_each(|r| by_rarity.entry(rarity(r)).or_default().push(r));
    let all: Vec<&figures::Row<'_>> = rows.iter().collect();
    let score = Score {
        release: release.to_owned(),
        split: options.split,
        samples: rows.len(),
        predicted: rows.iter().filter(|r| r.prediction.is_some()).count(),
        drives: truth.iter().map(|t| t.drive.as_str()).collect::<std::collections::BTreeSet<_>>().len(),
        resamples: options.resamples,
        seed: options.seed,
        overall: drawn(&all),
        classes: targets.iter().map(|t| (*t, figures::classes(&all, *t, options))).collect(),
        by_leaf: group(&|r| r.truth.leaf.clone()),
        by_place: group(&|r| r.truth.place.clone().unwrap_or_else(|| "unknown".to_owned())),
        by_rarity: by_rarity.into_iter().map(|(k, rows)| (k, drawn(&rows))).collect(),
    };
    (score, found)
}

/// Predictions for samples that are not in the split, and samples without a prediction.
fn unmatched(truth: &[Truth], predictions: &Predictions, split: SplitName) -> Vec<Diagnostic> {
    let ids: std::collections::BTreeSet<&str> = truth.iter().map(|t| t.sample_id.as_str()).collect();
    let foreign: Vec<&str> =
        predictions.rows().map(|p| p.sample_id.as_str()).filter(|id| !ids.contains(id)).collect();
    let missing: Vec<&str> = ids.iter().copied().filter(|id| predictions.of(id).is_none()).collect();
    let split = split.name();
    let mut out = Vec::new();
    if let Some(first) = foreign.first() {
        let n = foreign.len();
        out.push(
            Diagnostic::warning(
                "score.sample.unknown",
                Bilingual::new(
                    format!("{n} 条预测的样本不在 {split} 划分中，例如 {first}"),
                    format!(
                        "{n} predictions are for samples that are not in the {split} split, such as {first}"
                    ),
                ),
            )
            .with_hint(Bilingual::new("用 --split 指定划分", "name the split with --split")),
        );
    }
    if let Some(first) = missing.first() {
        let n = missing.len();
        out.push(Diagnostic::warning(
            "score.sample.missing",
            Bilingual::new(
                format!("{split} 划分中有 {n} 个样本没有预测，例如 {first}；决策与场景按错误计"),
                format!("{n} samples of the {split} split have no prediction, such as {first}; their decisions and class count as wrong"),
            ),
        ));
    }
    out
}

/// Samples whose decision is unknown.
fn unknown_decisions(truth: &[Truth]) -> Option<Diagnostic> {
    let unknown: Vec<&str> = truth
        .iter()
        .filter(|t| t.class(Target::Longitudinal).is_none())
        .map(|t| t.sample_id.as_str())
        .collect();
    let (first, n) = (unknown.first()?, unknown.len());
    Some(Diagnostic::warning(
        "score.decision.unknown",
        Bilingual::new(
            format!("{n} 个样本的决策未知，例如 {first}；它们不计入决策的指标"),
            format!(
                "the decision of {n} samples is unknown, such as {first}; they are not in the figures of decisions"
            ),
        ),
    ))
}

/// Trajectories that end before the sample's future does.
fn short_trajectories(rows: &[figures::Row<'_>]) -> Vec<Diagnostic> {
    let short: Vec<&str> = rows
        .iter()
        .filter(|r| r.prediction.is_some_and(|p| p.trajectory.is_some()))
        .filter(|r| r.truth.has_future() && r.displacement.is_none())
        .map(|r| r.truth.sample_id.as_str())
        .collect();
    let Some(first) = short.first() else { return vec![] };
    let n = short.len();
    vec![Diagnostic::warning(
        "score.trajectory.short",
        Bilingual::new(
            format!("{n} 条轨迹未覆盖样本的整个未来时段，例如 {first}；它们不计入 ADE 与 FDE"),
            format!(
                "{n} trajectories end before the sample's future does, such as {first}; they are not in ADE and FDE"
            ),
        ),
    )]
}

#[cfg(test)]
mod tests;
