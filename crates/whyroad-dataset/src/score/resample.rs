//! Bootstrap over drives: samples of one drive resemble each other, so whole drives are drawn with replacement, not
//! samples. Seeded; the same input gives the same interval on every machine.

use serde::Serialize;
use whyroad_model::random::SplitMix64;

/// A figure with the middle 95 % of its bootstrap distribution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The figure on all samples.
    pub value: f64,
    /// 2.5 % quantile; `None` with fewer than two drives.
    pub low: Option<f64>,
    /// 97.5 % quantile.
    pub high: Option<f64>,
    /// Samples in it.
    pub samples: usize,
}

/// A stream of random numbers.
#[derive(Clone, Debug)]
pub struct Random(SplitMix64);

impl Random {
    /// A separate stream per `name`.
    pub fn new(seed: u64, name: &str) -> Self {
        let hash = blake3::hash(name.as_bytes());
        let first = hash.as_bytes().iter().take(8).fold(0u64, |n, b| n << 8 | u64::from(*b));
        Self(SplitMix64::new(seed ^ first))
    }

    /// A number from 0 to `n - 1`; 0 for `n = 0`.
    pub fn below(&mut self, n: usize) -> usize {
        // The high 64 bits of the product: uniform up to 2^-64 * n.
        ((u128::from(self.0.bits()) * n as u128) >> 64) as usize
    }

    /// A number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0.unit()
    }
}

/// The figure that `figure` computes from drives, with its interval. `drives` has one part per drive; `figure` gets the
/// drawn parts and returns `None` where the figure is not defined.
pub fn estimate<P>(
    drives: &[P],
    samples: usize,
    resamples: usize,
    mut random: Random,
    figure: impl Fn(&[&P]) -> Option<f64>,
) -> Option<Estimate> {
    let all: Vec<&P> = drives.iter().collect();
    let value = figure(&all)?;
    let mut drawn: Vec<f64> = Vec::with_capacity(resamples);
    if drives.len() > 1 {
        let mut parts = Vec::with_capacity(drives.len());
        for _ in 0..resamples {
            parts.clear();
            parts.extend((0..drives.len()).map(|_| &drives[random.below(drives.len())]));
            drawn.extend(figure(&parts));
        }
    }
    drawn.sort_by(f64::total_cmp);
    let quantile = |q: f64| {
        let last = drawn.len().checked_sub(1)?;
        Some(drawn[(q * last as f64).round() as usize])
    };
    Some(Estimate { value, low: quantile(0.025), high: quantile(0.975), samples })
}
