//! How near the samples of one split are to those of another: a hidden leak of random splits.

use crate::item::{Item, Position, SplitName};
use crate::place::Grid;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

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
    /// Samples with a position.
    pub samples: usize,
    /// Samples closer than that to a sample of the other split.
    pub near: usize,
    /// Their share; `None` when no sample has a position.
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
    let near = points.par_iter().filter(|p| is_near(p)).count();
    let samples = points.len();
    Distance { of, to, within_m, samples, near, share: (samples > 0).then(|| near as f64 / samples as f64) }
}
