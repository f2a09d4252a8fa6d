//! Out-of-fold probabilities: every sample gets probabilities from a model that was trained without its drive, as
//! samples of one drive resemble each other.

use super::learner::{Boosted, Learner, Problem};
use super::{Row, Settings, put};
use crate::score::Target;
use crate::score::predictions::{Prediction, Predictions};
use crate::score::resample::Random;
use std::collections::{BTreeMap, BTreeSet};

/// Probabilities of each row for `target`, with `folds` models. Classes are those of all rows; a class that a fold's
/// training rows lack has probability 0 there. With fewer drives than folds, one fold per drive; with a single drive,
/// no probabilities.
pub fn out_of_fold(rows: &[Row], target: Target, folds: usize, settings: Settings) -> Predictions {
    let classes: BTreeSet<&str> = rows.iter().filter_map(|r| r.truth.class(target)).collect();
    let classes: Vec<String> = classes.into_iter().map(str::to_owned).collect();
    let fold_of = assign(rows, folds, settings.seed);
    let folds: BTreeSet<usize> = fold_of.values().copied().collect();
    let mut out = Vec::with_capacity(rows.len());
    if folds.len() < 2 {
        return Predictions::default();
    }
    for fold in folds {
        let (held_out, seen): (Vec<&Row>, Vec<&Row>) =
            rows.iter().partition(|r| fold_of[r.truth.drive.as_str()] == fold);
        let model = Boosted::fit(&Problem::new(seen, target, &classes), settings);
        let held_out: Vec<Row> = held_out.into_iter().cloned().collect();
        for (row, p) in held_out.iter().zip(model.probabilities(&held_out)) {
            let mut prediction =
                Prediction { sample_id: row.truth.sample_id.clone(), ..Prediction::default() };
            put(&mut prediction, target, &classes, &p);
            out.push(prediction);
        }
    }
    Predictions::new(out)
}

/// The fold of each drive: drives in seeded order, each to the fold with the fewest samples so far.
fn assign(rows: &[Row], folds: usize, seed: u64) -> BTreeMap<&str, usize> {
    let mut samples: BTreeMap<&str, usize> = BTreeMap::new();
    rows.iter().for_each(|r| *samples.entry(r.truth.drive.as_str()).or_default() += 1);
    let mut drives: Vec<(&str, usize)> = samples.into_iter().collect();
    let mut random = Random::new(seed, "folds");
    for i in (1..drives.len()).rev() {
        drives.swap(i, random.below(i + 1));
    }
    // Long drives first, so that the folds have similar sizes; the sort keeps the seeded order of equal ones.
    drives.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
    let mut filled = vec![0usize; folds.clamp(1, drives.len().max(1))];
    let mut out = BTreeMap::new();
    for (drive, n) in drives {
        let least = (0..filled.len()).min_by_key(|f| filled[*f]).unwrap_or(0);
        filled[least] += n;
        out.insert(drive, least);
    }
    out
}
