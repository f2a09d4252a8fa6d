//! Calibration: one temperature per target (Guo et al., On Calibration of Modern Neural Networks, ICML 2017), and how
//! well stated probabilities agree with the observed accuracy.

use serde::Serialize;

/// Probabilities under a temperature: `p^(1/T)`, normalized. T above 1 makes them less certain.
pub fn scaled(row: &[f64], temperature: f64) -> Vec<f64> {
    let logs: Vec<f64> = row.iter().map(|p| p.max(1e-12).ln() / temperature).collect();
    let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let powers: Vec<f64> = logs.iter().map(|l| (l - most).exp()).collect();
    let sum: f64 = powers.iter().sum();
    powers.into_iter().map(|p| p / sum).collect()
}

/// The temperature with the least log loss; 1 without samples. Golden-section search on its logarithm, 0.1 to 10.
pub fn temperature(probabilities: &[Vec<f64>], labels: &[usize]) -> f64 {
    if labels.is_empty() {
        return 1.0;
    }
    let loss = |log_t: f64| {
        let each = probabilities.iter().zip(labels).map(|(p, l)| -scaled(p, log_t.exp())[*l].max(1e-12).ln());
        each.sum::<f64>()
    };
    let ratio = (5f64.sqrt() - 1.0) / 2.0;
    let (mut low, mut high) = (0.1f64.ln(), 10f64.ln());
    for _ in 0..40 {
        let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
        if loss(a) <= loss(b) {
            high = b;
        } else {
            low = a;
        }
    }
    ((low + high) / 2.0).exp()
}

/// Predictions whose greatest probability lies in one tenth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Bin {
    /// Samples.
    pub samples: usize,
    /// Mean stated probability; `None` without samples.
    pub stated: Option<f64>,
    /// Share that is right; `None` without samples.
    pub right: Option<f64>,
}

/// Reliability of one target.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reliability {
    /// Ten bins: 0 to 0.1, ..., 0.9 to 1.
    pub bins: Vec<Bin>,
    /// Expected calibration error: mean of |right - stated| weighted by samples; `None` without samples.
    pub error: Option<f64>,
}

/// Of the greatest probabilities (`stated`) and whether that class was right.
pub fn reliability(predictions: impl IntoIterator<Item = (f64, bool)>) -> Reliability {
    let mut sums = [(0usize, 0.0f64, 0usize); 10];
    for (stated, right) in predictions {
        let bin = &mut sums[((stated * 10.0) as usize).min(9)];
        *bin = (bin.0 + 1, bin.1 + stated, bin.2 + usize::from(right));
    }
    let n: usize = sums.iter().map(|s| s.0).sum();
    let ratio = |v: f64, by: usize| (by > 0).then(|| v / by as f64);
    let bins: Vec<Bin> = sums
        .iter()
        .map(|(n, stated, right)| Bin {
            samples: *n,
            stated: ratio(*stated, *n),
            right: ratio(*right as f64, *n),
        })
        .collect();
    let gaps: f64 = sums.iter().map(|(_, stated, right)| (*right as f64 - stated).abs()).sum();
    Reliability { bins, error: ratio(gaps, n) }
}
