//! How many episodes of a class more driving would bring: the predictive distribution of a count, with the scatter
//! between drives taken from the drives themselves.
//!
//! Counts are Poisson with an unknown rate under Jeffreys' prior, so a coming count is negative binomial (J. Aitchison
//! and I. R. Dunsmore, "Statistical Prediction Analysis", 1975). Episodes come in clusters; the dispersion, Pearson's
//! chi-squared over its degrees of freedom, widens the interval as in quasi-likelihood (P. McCullagh and J. A. Nelder,
//! "Generalized Linear Models", 1989). Both work without any find so far: then the interval shows what may still be
//! found.

use super::unseen::Estimate;

/// Quantile of the normal distribution for an interval of 95 %.
const Z95: f64 = 1.959_963_984_540_054;
/// Means above which the normal approximation of a negative binomial is used.
const LARGE: f64 = 400.0;

/// Dispersion of counts over drives of different lengths, at least 1: hours and finds of each drive. 1 for a single
/// drive, whose scatter is unknown.
pub fn dispersion(drives: &[(f64, u64)]) -> f64 {
    let hours: f64 = drives.iter().map(|d| d.0).sum();
    let finds: u64 = drives.iter().map(|d| d.1).sum();
    if drives.len() < 2 || finds == 0 || hours <= 0.0 {
        return 1.0;
    }
    let rate = finds as f64 / hours;
    let chi: f64 = drives
        .iter()
        .filter(|d| d.0 > 0.0)
        .map(|(h, n)| {
            let expected = rate * h;
            (*n as f64 - expected).powi(2) / expected
        })
        .sum();
    (chi / (drives.len() - 1) as f64).max(1.0)
}

/// Episodes that `more` hours would bring after `finds` in `hours`, 95 %. `None` where nothing was searched.
pub fn coming(finds: u64, hours: f64, more: f64, dispersion: f64) -> Option<Estimate> {
    if hours <= 0.0 || more < 0.0 {
        return None;
    }
    let phi = dispersion.max(1.0);
    let shape = finds as f64 / phi + 0.5;
    let ratio = more / hours;
    let value = finds as f64 * ratio;
    let mean = shape * ratio;
    let (low, high) = if mean > LARGE {
        let deviation = (mean * (1.0 + ratio)).sqrt();
        ((mean - Z95 * deviation).max(0.0), mean + Z95 * deviation)
    } else {
        (quantile(shape, ratio, 0.025), quantile(shape, ratio, 0.975))
    };
    let (low, high) = (low * phi, high * phi);
    Some(Estimate { value, low: low.min(value), high: high.max(value) })
}

/// The least `k` with `P(K <= k) >= p` of the negative binomial whose mean is `shape * ratio`.
fn quantile(shape: f64, ratio: f64, p: f64) -> f64 {
    let success = ratio / (1.0 + ratio);
    // In logarithms: P(K = 0) may be too small for a number.
    let mut log_term = -shape * (1.0 + ratio).ln();
    let (mut below, mut k) = (log_term.exp(), 0.0);
    while below < p && k < 1e7 {
        log_term += ((shape + k) / (k + 1.0) * success).ln();
        below += log_term.exp();
        k += 1.0;
    }
    k
}

/// Hours of more driving until `wanted` episodes more are expected: from the rate so far. `None` without a find.
pub fn hours_for(wanted: u64, finds: u64, hours: f64) -> Option<f64> {
    (finds > 0 && hours > 0.0).then(|| wanted as f64 * hours / finds as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_is_that_of_the_negative_binomial() {
        // Quantiles of NB(10.5, 0.5), summed term by term outside: 3 and 21; 10 finds in 50 h, 50 h more.
        let e = coming(10, 50.0, 50.0, 1.0).unwrap();
        assert_eq!((e.value, e.low, e.high), (10.0, 3.0, 21.0));
        // NB(0.5, 0.5): 0.7071 + 0.1768 + 0.0663 + 0.0276 = 0.9778 >= 0.975, so 3: nothing found, as much
        // driving again.
        let none = coming(0, 50.0, 50.0, 1.0).unwrap();
        assert_eq!((none.value, none.low, none.high), (0.0, 0.0, 3.0));
        assert_eq!(coming(3, 0.0, 100.0, 1.0), None);
    }

    #[test]
    fn clusters_widen_the_interval() {
        // All finds in one of four equal drives: chi2 = (12-3)^2/3 + 3*3 = 36 over 3 degrees of freedom.
        let drives = [(1.0, 12), (1.0, 0), (1.0, 0), (1.0, 0)];
        assert!((dispersion(&drives) - 12.0).abs() < 1e-12);
        let (plain, wide) =
            (coming(12, 4.0, 4.0, 1.0).unwrap(), coming(12, 4.0, 4.0, dispersion(&drives)).unwrap());
        assert!(wide.high > plain.high && wide.low <= plain.low, "{plain:?} {wide:?}");
        // Evenly spread finds are never treated as more certain than Poisson.
        assert_eq!(dispersion(&[(1.0, 3), (1.0, 3)]), 1.0);
        assert_eq!(dispersion(&[(1.0, 9)]), 1.0);
    }

    #[test]
    fn large_counts_are_about_normal() {
        let e = coming(10_000, 100.0, 100.0, 1.0).unwrap();
        // sqrt(2 * 10000) = 141.4; 95 %: 277.
        assert!((e.high - e.value - 277.0).abs() < 2.0, "{e:?}");
    }

    #[test]
    fn hours_follow_from_the_rate() {
        assert_eq!(hours_for(10, 5, 20.0), Some(40.0));
        assert_eq!(hours_for(10, 0, 20.0), None);
    }
}
