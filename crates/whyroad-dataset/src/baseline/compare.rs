//! The trained model against the majority class and the last meta action on one split, and its reliability.

use super::calibration::{Reliability, reliability};
use super::{Method, Model, Row};
use crate::score::predictions::{Prediction, Predictions};
use crate::score::{Options, Score, Target, score_truth};
use serde::Serialize;
use std::collections::BTreeMap;

/// The result.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Scores by method.
    pub methods: BTreeMap<Method, Score>,
    /// Reliability of the boosted trees' greatest probability.
    pub reliability: BTreeMap<Target, Reliability>,
}

/// Scores all methods on `rows`. `in_training` counts training samples by `scenario_id`; `release` is its name and
/// version.
pub fn compare(
    model: &Model,
    release: &str,
    rows: &[Row],
    in_training: &BTreeMap<&str, usize>,
    options: Options,
) -> (Comparison, Vec<Prediction>) {
    let truth: Vec<_> = rows.iter().map(|r| r.truth.clone()).collect();
    let predicted = model.predict(rows, Method::Boosted);
    let score = |method: Method| {
        let rows = match method {
            Method::Boosted => predicted.clone(),
            _ => model.predict(rows, method),
        };
        score_truth(release, &truth, in_training, &Predictions::new(rows), options).0
    };
    let methods = Method::ALL.map(|m| (m, score(m))).into();
    let of = |target: Target| {
        reliability(rows.iter().zip(&predicted).filter_map(|(row, p)| {
            let class = p.class(target)?;
            let stated = *p.probabilities.get(&target)?.get(class)?;
            Some((stated, class == row.truth.class(target)?))
        }))
    };
    let reliability = Target::ALL.map(|t| (t, of(t))).into();
    (Comparison { methods, reliability }, predicted)
}
