//! The figures: accuracy, macro F1, displacement errors; each with an interval.

use super::predictions::{PredictedTrajectory, Prediction};
use super::resample::{Estimate, Random, estimate};
use super::target::{Options, Target};
use super::truth::Truth;
use serde::Serialize;
use std::collections::BTreeMap;

/// Name of the stream by which drives are drawn.
const DRAWS: &str = "drives";

/// A sample with its prediction.
pub struct Row<'a> {
    pub(super) truth: &'a Truth,
    pub(super) prediction: Option<&'a Prediction>,
    pub(super) displacement: Option<Displacement>,
}

/// Distances between the predicted and the driven path, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Displacement {
    pub average_m: f64,
    pub final_m: f64,
}

impl<'a> Row<'a> {
    pub(super) fn of(truth: &'a Truth, prediction: Option<&'a Prediction>) -> Self {
        let trajectory = prediction.and_then(|p| p.trajectory.as_ref()).filter(|_| truth.has_future());
        Self { truth, prediction, displacement: trajectory.and_then(|t| displacement(truth, t)) }
    }

    /// Whether the prediction is right; `None` where the truth is unknown.
    fn right(&self, target: Target) -> Option<bool> {
        let truth = self.truth.class(target)?;
        Some(self.prediction.and_then(|p| p.class(target)) == Some(truth))
    }
}

/// Mean and last distance over the steps of the truth; `None` when the prediction ends earlier.
fn displacement(truth: &Truth, predicted: &PredictedTrajectory) -> Option<Displacement> {
    let mut sum = 0.0;
    let mut last = 0.0;
    for [t, x, y] in &truth.future {
        let (px, py) = at(predicted, f64::from(*t))?;
        last = (px - f64::from(*x)).hypot(py - f64::from(*y));
        sum += last;
    }
    Some(Displacement { average_m: sum / truth.future.len() as f64, final_m: last })
}

/// The predicted position at `t`, linear between its points; it starts at the origin at t0.
fn at(p: &PredictedTrajectory, t: f64) -> Option<(f64, f64)> {
    // Half a step of 10 Hz data may be missing at the end: rounding of times in other programs.
    const ROUNDING_S: f64 = 1e-3;
    let end = *p.t_s.last()?;
    if t > end + ROUNDING_S {
        return None;
    }
    let i = p.t_s.partition_point(|s| *s < t).min(p.t_s.len() - 1);
    let (t0, x0, y0) = if i == 0 { (0.0, 0.0, 0.0) } else { (p.t_s[i - 1], p.x[i - 1], p.y[i - 1]) };
    let share = ((t - t0) / (p.t_s[i] - t0)).clamp(0.0, 1.0);
    Some((x0 + share * (p.x[i] - x0), y0 + share * (p.y[i] - y0)))
}

/// Figures of a group of samples; `None`: the model does not predict it, or no sample has it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// Samples.
    pub samples: usize,
    /// With a prediction.
    pub predicted: usize,
    /// Share with the right longitudinal decision.
    pub longitudinal: Option<Estimate>,
    /// Share with the right lateral decision.
    pub lateral: Option<Estimate>,
    /// Share with both decisions right.
    pub decisions: Option<Estimate>,
    /// Share with the right `scenario_id`.
    pub leaf: Option<Estimate>,
    /// Share with the right L2.
    pub l2: Option<Estimate>,
    /// Average displacement error, m.
    pub ade_m: Option<Estimate>,
    /// Final displacement error, m.
    pub fde_m: Option<Estimate>,
}

/// Sum and count of one drive.
type Part = (f64, usize);

/// The figures of `rows`. Drives are drawn alike for every figure and group: groups of the same samples have the same
/// intervals.
pub(super) fn of(rows: &[&Row<'_>], targets: &[Target], options: Options) -> Figures {
    let mean = |value: &dyn Fn(&Row<'_>) -> Option<f64>| {
        let mut drives: BTreeMap<&str, Part> = BTreeMap::new();
        for row in rows {
            if let Some(v) = value(row) {
                let part = drives.entry(&row.truth.drive).or_default();
                *part = (part.0 + v, part.1 + 1);
            }
        }
        let parts: Vec<Part> = drives.into_values().collect();
        let samples = parts.iter().map(|p| p.1).sum();
        let random = Random::new(options.seed, DRAWS);
        estimate(&parts, samples, options.resamples, random, |parts| {
            let (sum, n) = parts.iter().fold((0.0, 0), |a, p| (a.0 + p.0, a.1 + p.1));
            (n > 0).then(|| sum / n as f64)
        })
    };
    let has = |t: Target| targets.contains(&t);
    let share = |wanted: bool, right: &dyn Fn(&Row<'_>) -> Option<bool>| {
        wanted.then(|| mean(&|r| right(r).map(|right| f64::from(u8::from(right))))).flatten()
    };
    let both = has(Target::Longitudinal) && has(Target::Lateral);
    Figures {
        samples: rows.len(),
        predicted: rows.iter().filter(|r| r.prediction.is_some()).count(),
        longitudinal: share(has(Target::Longitudinal), &|r| r.right(Target::Longitudinal)),
        lateral: share(has(Target::Lateral), &|r| r.right(Target::Lateral)),
        decisions: share(both, &|r| Some(r.right(Target::Longitudinal)? && r.right(Target::Lateral)?)),
        leaf: share(has(Target::Leaf), &|r| r.right(Target::Leaf)),
        l2: share(has(Target::Leaf), &|r| {
            Some(r.prediction.and_then(|p| p.class(Target::Leaf)).map(l2) == Some(l2(&r.truth.leaf)))
        }),
        ade_m: mean(&|r| r.displacement.map(|d| d.average_m)),
        fde_m: mean(&|r| r.displacement.map(|d| d.final_m)),
    }
}

/// `l1.l2` of a class.
fn l2(id: &str) -> &str {
    id.match_indices('.').nth(1).map_or(id, |(end, _)| &id[..end])
}

/// One target, class by class.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClassFigures {
    /// Mean F1 over the classes that occur in the split.
    pub macro_f1: Option<Estimate>,
    /// By class, those that occur or are predicted.
    pub by_class: BTreeMap<String, ClassCounts>,
}

/// Counts of one class.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ClassCounts {
    /// Samples of the class.
    pub samples: usize,
    /// Predicted as the class.
    pub predicted: usize,
    /// Both.
    pub right: usize,
    /// Share of predictions that are right; `None` without predictions.
    pub precision: Option<f64>,
    /// Share of samples that are found; `None` without samples.
    pub recall: Option<f64>,
    /// Harmonic mean: 2 right / (samples + predicted); `None` without both.
    pub f1: Option<f64>,
}

/// Samples, predictions and hits by class index.
type Confusion = Vec<[usize; 3]>;

/// Precision, recall and F1 by class, and macro F1 with its interval; over the samples whose class is known.
pub(super) fn classes(rows: &[&Row<'_>], target: Target, options: Options) -> ClassFigures {
    let rows: Vec<(&str, &Row<'_>)> =
        rows.iter().filter_map(|r| Some((r.truth.class(target)?, *r))).collect();
    let mut index: BTreeMap<&str, usize> = BTreeMap::new();
    for (truth, row) in &rows {
        let predicted = row.prediction.and_then(|p| p.class(target));
        for class in predicted.into_iter().chain([*truth]) {
            let next = index.len();
            index.entry(class).or_insert(next);
        }
    }
    let mut drives: BTreeMap<&str, Confusion> = BTreeMap::new();
    for (truth, row) in &rows {
        let counts = drives.entry(&row.truth.drive).or_insert_with(|| vec![[0; 3]; index.len()]);
        counts[index[truth]][0] += 1;
        if let Some(class) = row.prediction.and_then(|p| p.class(target)) {
            counts[index[class]][1] += 1;
            counts[index[truth]][2] += usize::from(class == *truth);
        }
    }
    let parts: Vec<Confusion> = drives.into_values().collect();
    let sum = |parts: &[&Confusion]| {
        let mut all: Confusion = vec![[0; 3]; index.len()];
        for part in parts {
            for (a, p) in all.iter_mut().zip(part.iter()) {
                (0..3).for_each(|i| a[i] += p[i]);
            }
        }
        all
    };
    let all = sum(&parts.iter().collect::<Vec<_>>());
    let random = Random::new(options.seed, DRAWS);
    let macro_f1 = estimate(&parts, rows.len(), options.resamples, random, |parts| {
        let f1: Vec<f64> = sum(parts).iter().filter(|c| c[0] > 0).filter_map(|c| counts(c).f1).collect();
        (!f1.is_empty()).then(|| f1.iter().sum::<f64>() / f1.len() as f64)
    });
    let by_class = index.iter().map(|(class, i)| ((*class).to_owned(), counts(&all[*i]))).collect();
    ClassFigures { macro_f1, by_class }
}

fn counts(&[samples, predicted, right]: &[usize; 3]) -> ClassCounts {
    let ratio = |of: usize, by: usize| (by > 0).then(|| of as f64 / by as f64);
    ClassCounts {
        samples,
        predicted,
        right,
        precision: ratio(right, predicted),
        recall: ratio(right, samples),
        f1: ratio(2 * right, samples + predicted),
    }
}
