//! How near the samples of one split are to those of another: a hidden leak of random splits.

use crate::item::{Item, Position, SplitName};
use crate::place::Grid;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Distances that are reported, m.
const REPORTED_M: [f64; 4] = [1.0, 5.0, 20.0, 100.0];

/// Share of samples of one split that are near a sample of another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distance {
    /// The split whose samples are counted.
    pub of: SplitName,
    /// The split that they are compared with.
    pub to: SplitName,
    /// m.
    pub within_m: f64,
    /// Samples with a position that can be compared with one of the other split.
    pub samples: usize,
    /// Samples closer than that to a sample of the other split.
    pub near: usize,
    /// Their share; `None` when no position can be compared.
    pub share: Option<f64>,
}

/// All pairs of splits and all reported distances, over the kept items.
pub(crate) fn distances(items: &[Item]) -> Vec<Distance> {
    let of = |split: SplitName| -> Vec<&Position> {
        let in_split = items.iter().filter(|i| i.kept() && i.split == Some(split));
        in_split.filter_map(|i| i.cut.as_ref()?.position.as_ref()).collect()
    };
    let pairs = [
        (SplitName::Val, SplitName::Train),
        (SplitName::Test, SplitName::Train),
        (SplitName::Test, SplitName::Val),
    ];
    let mut out = Vec::new();
    for (a, b) in pairs {
        for within_m in REPORTED_M {
            out.push(between((a, &of(a)), (b, &of(b)), within_m));
        }
    }
    out
}

pub(crate) fn between(
    (of, points): (SplitName, &[&Position]),
    (to, others): (SplitName, &[&Position]),
    within_m: f64,
) -> Distance {
    let grid = Grid::new(others.iter().map(|p| Some(*p)).collect(), within_m);
    let is_near = |p: &&Position| {
        let mut found = false;
        grid.near(p, |_| {
            found = true;
            false
        });
        found
    };
    let frames: BTreeSet<&str> = others.iter().map(|p| p.frame.as_str()).collect();
    let near = points.par_iter().filter(|p| is_near(p)).count();
    let samples = points.iter().filter(|p| frames.contains(p.frame.as_str())).count();
    Distance { of, to, within_m, samples, near, share: (samples > 0).then(|| near as f64 / samples as f64) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_that_cannot_be_compared_are_not_far_apart() {
        let at = |frame: &str, x: f64| Position { frame: frame.into(), p: [x, 0.0, 0.0], plane: [x, 0.0] };
        let (train, val) = ([at("map:a", 0.0)], [at("geo", 0.0), at("geo", 9.0)]);
        let of = |points: &[Position], others: &[Position]| {
            let (points, others): (Vec<_>, Vec<_>) = (points.iter().collect(), others.iter().collect());
            let found = between((SplitName::Val, &points), (SplitName::Train, &others), 5.0);
            (found.samples, found.near, found.share)
        };
        assert_eq!(of(&val, &train), (0, 0, None));
        assert_eq!(of(&val, &[]), (0, 0, None), "an empty split is near to nothing");
        assert_eq!(of(&val, &[at("geo", 1.0), train[0].clone()]), (2, 1, Some(0.5)));
    }
}
