//! Models behind one trait: from rows and classes to probabilities. The boosted trees are forust-ml's, one ensemble
//! per class against the rest; unknown features stay unknown (NaN), the trees learn which side they go to.

use super::features::LastAction;
use super::row::{Row, Settings};
use crate::score::Target;
use forust_ml::Matrix;
use forust_ml::gradientbooster::GradientBooster;
use forust_ml::objective::ObjectiveType;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Rows with the class index of each.
pub struct Problem<'a> {
    /// Rows.
    pub rows: Vec<&'a Row>,
    /// Class indices.
    pub labels: Vec<usize>,
    /// Number of classes.
    pub classes: usize,
}

impl<'a> Problem<'a> {
    /// Rows whose class is not among `classes` must have been left out before.
    pub fn new(rows: Vec<&'a Row>, target: Target, classes: &[String]) -> Self {
        let index =
            |r: &&Row| r.truth.class(target).and_then(|class| classes.iter().position(|c| c == class));
        let (rows, labels) = rows.into_iter().filter_map(|r| Some((r, index(&r)?))).unzip();
        Self { rows, labels, classes: classes.len() }
    }
}

/// A model that is fitted once and then predicts probabilities.
pub trait Learner: Sized {
    /// Fits the model. Sampling weights of the rows are used.
    fn fit(problem: &Problem<'_>, settings: Settings) -> Self;
    /// One row per sample, one column per class; each row sums to 1.
    fn probabilities(&self, rows: &[Row]) -> Vec<Vec<f64>>;
}

/// Gradient-boosted trees.
#[derive(Serialize, Deserialize)]
pub struct Boosted {
    /// Per class; `None`: no sample, or every sample, belongs to it.
    ensembles: Vec<Option<GradientBooster>>,
    /// Share of each class in training: the prediction where there is no ensemble.
    shares: Vec<f64>,
}

impl Learner for Boosted {
    fn fit(problem: &Problem<'_>, settings: Settings) -> Self {
        let data = matrix(problem.rows.iter().copied());
        let n = problem.rows.len();
        let weights: Vec<f64> = problem.rows.iter().map(|r| r.weight).collect();
        let one = |class: usize| {
            let y: Vec<f64> = problem.labels.iter().map(|l| f64::from(u8::from(*l == class))).collect();
            let of_class = problem.labels.iter().filter(|l| **l == class).count();
            if of_class == 0 || of_class == n {
                return None;
            }
            let mut booster = GradientBooster::default()
                .set_objective_type(ObjectiveType::LogLoss)
                .set_iterations(settings.rounds)
                .set_learning_rate(0.15)
                .set_max_depth(4)
                .set_nbins(64)
                .set_seed(settings.seed)
                .set_parallel(false);
            // Its only errors are NaN or negative labels and weights, and settings out of range.
            booster.fit(&Matrix::new(&data, n, n_columns(&data, n)), &y, &weights, None).ok()?;
            Some(booster)
        };
        let ensembles = (0..problem.classes).into_par_iter().map(one).collect();
        Self { ensembles, shares: shares(problem.labels.iter().zip(&weights), problem.classes) }
    }

    fn probabilities(&self, rows: &[Row]) -> Vec<Vec<f64>> {
        let data = matrix(rows.iter());
        let n = rows.len();
        let columns: Vec<Option<Vec<f64>>> = self
            .ensembles
            .par_iter()
            .map(|e| e.as_ref().map(|e| e.predict(&Matrix::new(&data, n, n_columns(&data, n)), false)))
            .collect();
        let one = |i: usize| {
            let odds = columns.iter().zip(&self.shares).map(|(column, share)| match column {
                Some(log_odds) => 1.0 / (1.0 + (-log_odds[i]).exp()),
                None => *share,
            });
            normalized(odds.collect())
        };
        (0..n).map(one).collect()
    }
}

/// Column by column, as forust-ml reads it.
fn matrix<'a>(rows: impl Iterator<Item = &'a Row> + Clone) -> Vec<f64> {
    (0..super::features::NAMES.len()).flat_map(|c| rows.clone().map(move |r| r.features[c])).collect()
}

fn n_columns(data: &[f64], rows: usize) -> usize {
    data.len().checked_div(rows).unwrap_or(0)
}

fn normalized(mut row: Vec<f64>) -> Vec<f64> {
    let sum: f64 = row.iter().sum();
    let classes = row.len() as f64;
    row.iter_mut().for_each(|p| *p = if sum > 0.0 { *p / sum } else { 1.0 / classes });
    row
}

/// Weighted share of each class.
fn shares<'a>(labels: impl Iterator<Item = (&'a usize, &'a f64)>, classes: usize) -> Vec<f64> {
    let mut out = vec![0.0; classes];
    labels.for_each(|(label, weight)| out[*label] += weight);
    normalized(out)
}

/// The shares of the training split, for every sample.
#[derive(Serialize, Deserialize)]
pub struct Majority {
    shares: Vec<f64>,
}

impl Learner for Majority {
    fn fit(problem: &Problem<'_>, _: Settings) -> Self {
        let one = 1.0;
        Self { shares: shares(problem.labels.iter().map(|l| (l, &one)), problem.classes) }
    }

    fn probabilities(&self, rows: &[Row]) -> Vec<Vec<f64>> {
        vec![self.shares.clone(); rows.len()]
    }
}

/// The shares of training samples with the same last meta action; of all where it is unknown or new.
#[derive(Serialize, Deserialize)]
pub struct RepeatLast {
    by_action: Vec<(LastAction, Vec<f64>)>,
    otherwise: Majority,
}

impl Learner for RepeatLast {
    fn fit(problem: &Problem<'_>, settings: Settings) -> Self {
        let mut groups: std::collections::BTreeMap<&LastAction, Vec<usize>> =
            std::collections::BTreeMap::new();
        for (row, label) in problem.rows.iter().zip(&problem.labels) {
            groups.entry(&row.last).or_default().push(*label);
        }
        let one = 1.0;
        let by_action = groups
            .into_iter()
            .map(|(a, labels)| (a.clone(), shares(labels.iter().map(|l| (l, &one)), problem.classes)))
            .collect();
        Self { by_action, otherwise: Majority::fit(problem, settings) }
    }

    fn probabilities(&self, rows: &[Row]) -> Vec<Vec<f64>> {
        let of = |r: &Row| self.by_action.iter().find(|(a, _)| *a == r.last).map(|(_, shares)| shares);
        rows.iter().map(|r| of(r).unwrap_or(&self.otherwise.shares).clone()).collect()
    }
}
