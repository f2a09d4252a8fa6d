//! Errors of shares: expected calibration error (Naeini, Cooper and Hauskrecht 2015) and Brier score (1950).

use super::{JudgedEpisode, fit};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_framework::Calibration;
use whyroad_model::DriveId;

/// Parts into which drives are divided; each is judged with a table made from the others.
const FOLDS: usize = 5;
/// Tenths of the predicted share.
const BINS: usize = 10;

/// Predicted shares against actual shares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CalibrationError {
    /// Episodes of calibrated classes.
    pub episodes: usize,
    /// Mean distance of predicted and actual share over the tenths of the predicted share, by episodes.
    pub expected: f64,
    /// Mean square of prediction and outcome.
    pub brier: f64,
    /// Mean predicted share.
    pub predicted: f64,
    /// Share that was right.
    pub right: f64,
}

/// Error of these predictions, each with whether it was right; `None` without any.
pub fn measure(predictions: &[(f64, bool)]) -> Option<CalibrationError> {
    let n = predictions.len() as f64;
    if predictions.is_empty() {
        return None;
    }
    let outcome = |right: bool| f64::from(u8::from(right));
    let mut bins: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
    for (share, right) in predictions {
        let bin = bins.entry(((share * BINS as f64) as usize).min(BINS - 1)).or_default();
        *bin = (bin.0 + share, bin.1 + outcome(*right));
    }
    let mean = |of: &dyn Fn(f64, bool) -> f64| predictions.iter().map(|(s, r)| of(*s, *r)).sum::<f64>() / n;
    Some(CalibrationError {
        episodes: predictions.len(),
        expected: bins.values().map(|(predicted, right)| (predicted - right).abs()).sum::<f64>() / n,
        brier: mean(&|s, r| (s - outcome(r)).powi(2)),
        predicted: mean(&|s, _| s),
        right: mean(&|_, r| outcome(r)),
    })
}

/// Error of the shares on held-out drives: drives in the order of their ids, every fifth in one of five parts. Also the
/// error of the margin scores, taken as shares, on the same episodes.
pub fn held_out(
    judged: &[JudgedEpisode],
    earlier: Option<&Calibration>,
) -> Option<(CalibrationError, CalibrationError)> {
    let drives: BTreeSet<&DriveId> = judged.iter().map(|e| &e.drive_id).collect();
    let fold: BTreeMap<&DriveId, usize> =
        drives.into_iter().enumerate().map(|(i, d)| (d, i % FOLDS)).collect();
    let (mut shares, mut margins) = (Vec::new(), Vec::new());
    for part in 0..FOLDS {
        let (test, train): (Vec<_>, Vec<_>) = judged.iter().cloned().partition(|e| fold[&e.drive_id] == part);
        let table = fit(&train, earlier, Vec::new());
        for e in test {
            if let Some(share) = table.share(&e.scenario_id, e.margin_score) {
                shares.push((share, e.right));
                margins.push((e.margin_score, e.right));
            }
        }
    }
    Some((measure(&shares)?, measure(&margins)?))
}
