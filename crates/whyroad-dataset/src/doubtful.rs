//! Labels that are probably wrong, by confident learning (Northcutt, Jiang, Chuang: Confident Learning, JAIR 2021) on
//! probabilities of a model that was trained without the sample. The result is that of cleanlab's `find_label_issues`
//! with its defaults on the same numbers ([`confident`]).
//!
//! It changes no label: people review its findings.

pub mod confident;

use crate::score::Target;
use crate::score::predictions::Predictions;
use crate::score::truth::Truth;
use serde::Serialize;
use std::collections::BTreeMap;
use whyroad_model::{Bilingual, Diagnostic};

/// A label that a person should look at again.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Doubtful {
    /// Sample.
    pub sample_id: String,
    /// Drive.
    pub drive_id: String,
    /// The label's class; `no_change` for a null decision.
    pub given: String,
    /// The class with the greatest probability.
    pub suggested: String,
    /// Probability of the label's class: smaller is more doubtful.
    pub given_probability: f64,
    /// Probability of the suggested class.
    pub suggested_probability: f64,
}

/// Doubtful labels of one target, most doubtful first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DoubtfulLabels {
    /// Which field of the label.
    pub target: Target,
    /// Samples with probabilities.
    pub samples: usize,
    /// Estimated share of wrong labels; `None` without samples.
    pub noise: Option<f64>,
    /// The labels.
    pub labels: Vec<Doubtful>,
}

/// Finds the doubtful labels of `truth` by the probabilities of `predictions`. A class that a prediction does not
/// name has probability 0; samples without probabilities are left out and reported.
pub fn find(truth: &[Truth], predictions: &Predictions, target: Target) -> (DoubtfulLabels, Vec<Diagnostic>) {
    let of = |t: &Truth| predictions.of(&t.sample_id).and_then(|p| p.probabilities.get(&target)).cloned();
    // Nothing can be doubted about a class that is unknown.
    let known: Vec<(&Truth, &str)> = truth.iter().filter_map(|t| Some((t, t.class(target)?))).collect();
    let rows: Vec<(&Truth, &str, BTreeMap<String, f64>)> =
        known.iter().filter_map(|(t, class)| Some((*t, *class, of(t)?))).collect();
    let mut index: BTreeMap<&str, usize> = BTreeMap::new();
    for (_, given, by) in &rows {
        for class in by.keys().map(String::as_str).chain([*given]) {
            index.insert(class, 0);
        }
    }
    index.values_mut().enumerate().for_each(|(i, at)| *at = i);
    let names: Vec<&str> = index.keys().copied().collect();
    let labels: Vec<usize> = rows.iter().map(|(_, given, _)| index[given]).collect();
    let probabilities: Vec<Vec<f64>> = rows
        .iter()
        .map(|(_, _, by)| names.iter().map(|n| by.get(*n).copied().unwrap_or(0.0)).collect())
        .collect();
    let issues = confident::find_label_issues(&labels, &probabilities);
    let doubtful = issues.ranked.iter().map(|&i| {
        let best = confident::greatest(&probabilities[i]);
        Doubtful {
            sample_id: rows[i].0.sample_id.clone(),
            drive_id: rows[i].0.drive.clone(),
            given: names[labels[i]].to_owned(),
            suggested: names[best].to_owned(),
            given_probability: probabilities[i][labels[i]],
            suggested_probability: probabilities[i][best],
        }
    });
    let off: usize = issues.joint.iter().enumerate().map(|(i, row)| row.iter().sum::<usize>() - row[i]).sum();
    let found = DoubtfulLabels {
        target,
        samples: rows.len(),
        noise: (!rows.is_empty()).then(|| off as f64 / rows.len() as f64),
        labels: doubtful.collect(),
    };
    let missing = known.len() - rows.len();
    let lost = (missing > 0).then(|| {
        let name = target.name();
        Diagnostic::warning(
            "doubtful.probability.missing",
            Bilingual::new(
                format!("{missing} 个样本没有 {name} 的概率，未检查"),
                format!("{missing} samples have no probabilities of {name} and are not checked"),
            ),
        )
    });
    (found, lost.into_iter().collect())
}

#[cfg(test)]
mod tests;
