//! Unseen classes: the share of future finds that will be of a class without any find so far (Good-Turing), and how
//! many such classes more driving would bring (Good-Toulmin, smoothed). Pure functions over counts.
//!
//! A drive counts a class at most once: finds in one drive depend on each other. The estimates apply to more drives of
//! the same kind, and only for classes that these drives can show.
//!
//! Sources: I. J. Good, "The population frequencies of species and the estimation of population parameters",
//! Biometrika 40 (1953); W. W. Esty, "A normal limit law for a nonparametric estimator of the coverage of a random
//! sample", Annals of Statistics 11 (1983); I. J. Good and G. H. Toulmin, "The number of new species, and the increase
//! in population coverage, when a sample is increased", Biometrika 43 (1956); B. Efron and R. Thisted, "Estimating the
//! number of unseen species", Biometrika 63 (1976), for the standard error; A. Orlitsky, A. T. Suresh and Y. Wu,
//! "Optimal prediction of the number of unseen species", PNAS 113 (2016), for the smoothing and its range.

use serde::Serialize;

/// Quantile of the normal distribution for an interval of 95 %.
const Z95: f64 = 1.959_963_984_540_054;

/// An estimate with its interval of 95 %.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// How many classes were found once, twice, ...: `counts[k - 1]` is the number found in exactly `k` drives.
pub fn frequencies(finds: impl Iterator<Item = u64>) -> Vec<u64> {
    let mut out: Vec<u64> = Vec::new();
    for k in finds.filter(|k| *k > 0) {
        let k = usize::try_from(k).unwrap_or(usize::MAX).min(1 << 20);
        if out.len() < k {
            out.resize(k, 0);
        }
        out[k - 1] += 1;
    }
    out
}

/// Probability that the next find is of a class that has none yet: `f1 / n` with Esty's normal interval. `None` without
/// any find.
pub fn unseen_mass(frequencies: &[u64]) -> Option<Estimate> {
    let at = |k: usize| frequencies.get(k - 1).copied().unwrap_or(0) as f64;
    let n: f64 = frequencies.iter().zip(1u32..).map(|(f, k)| *f as f64 * f64::from(k)).sum();
    if n == 0.0 {
        return None;
    }
    let (f1, f2) = (at(1), at(2));
    let value = f1 / n;
    let deviation = (f1 * (1.0 - value) + 2.0 * f2).max(0.0).sqrt() / n;
    // Without any class found once the normal interval has no width; 3/n is the 95 % bound for an event that never
    // happened in n trials.
    let high = if f1 == 0.0 { 3.0 / n } else { value + Z95 * deviation };
    Some(Estimate { value, low: (value - Z95 * deviation).max(0.0), high: high.min(1.0) })
}

/// Number of classes without a find so far that `t` times as much driving again would show: for `t` up to 1 the series
/// of Good and Toulmin, beyond that with binomial smoothing. At most `remaining` classes are left. `None` without any
/// find, and for `t` beyond [`range`], where no estimator is reliable.
pub fn new_classes(frequencies: &[u64], t: f64, remaining: u64) -> Option<Estimate> {
    let n: f64 = frequencies.iter().zip(1u32..).map(|(f, k)| *f as f64 * f64::from(k)).sum();
    if n == 0.0 || !(0.0..=range(frequencies)).contains(&t) {
        return None;
    }
    let (mut value, mut variance) = (0.0, 0.0);
    for (f, k) in frequencies.iter().zip(1i32..) {
        let weight = -(-t).powi(k) * tail(n, t, k);
        value += weight * *f as f64;
        variance += weight * weight * *f as f64;
    }
    let (deviation, most) = (variance.sqrt(), remaining as f64);
    Some(Estimate {
        value: value.clamp(0.0, most),
        low: (value - Z95 * deviation).clamp(0.0, most),
        high: (value + Z95 * deviation).clamp(0.0, most),
    })
}

/// Greatest `t` for [`new_classes`]: `ln n`, and never under 1.
pub fn range(frequencies: &[u64]) -> f64 {
    let n: f64 = frequencies.iter().zip(1u32..).map(|(f, k)| *f as f64 * f64::from(k)).sum();
    n.ln().max(1.0)
}

/// `P(L >= k)` for the smoothing's binomial `L ~ Bin(1/2 log2(n t^2 / (t - 1)), 1 / (1 + t))`; 1 where there is none.
fn tail(n: f64, t: f64, k: i32) -> f64 {
    if t <= 1.0 {
        return 1.0;
    }
    let trials = (0.5 * (n * t * t / (t - 1.0)).log2()).floor().max(1.0) as i32;
    let p = 1.0 / (1.0 + t);
    if k > trials {
        return 0.0;
    }
    // Up from P(L = 0); trials are few: the logarithm of n.
    let (mut term, mut below) = ((1.0 - p).powi(trials), 0.0);
    for i in 0..k {
        below += term;
        term *= f64::from(trials - i) / f64::from(i + 1) * p / (1.0 - p);
    }
    (1.0 - below).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corbet's butterflies of Malaya (R. A. Fisher, A. S. Corbet, C. B. Williams, 1943): species by the
    /// number of times they were caught, 1 to 24.
    const BUTTERFLIES: [u64; 24] =
        [118, 74, 44, 24, 29, 22, 20, 19, 20, 15, 12, 14, 6, 12, 6, 9, 9, 6, 10, 10, 11, 5, 3, 3];

    #[test]
    fn new_species_of_butterflies_are_those_of_the_literature() {
        // B. Efron and T. Hastie, "Computer Age Statistical Inference" (2016), table 6.3: at t = 1 75 new species with
        // standard deviation 22.4 (`(sum y)^(1/2)`); at t = 0.5 45.2 and 11.2.
        let year = new_classes(&BUTTERFLIES, 1.0, 1000).unwrap();
        assert!((year.value - 75.0).abs() < 1e-9, "{year:?}");
        assert!(((year.high - year.value) / Z95 - 22.4).abs() < 0.05, "{year:?}");
        let half = new_classes(&BUTTERFLIES, 0.5, 1000).unwrap();
        assert!((half.value - 45.2).abs() < 0.05, "{half:?}");
    }

    #[test]
    fn smoothing_keeps_a_far_extrapolation_bounded() {
        // Plain Good-Toulmin at t = 3 is of the order of 3^24; smoothed it stays within the classes that there can be.
        let far = new_classes(&BUTTERFLIES, 3.0, 1_000_000).unwrap();
        assert!(far.value > 75.0 && far.value < 1000.0, "{far:?}");
        assert!(new_classes(&BUTTERFLIES, 50.0, 1000).is_none(), "beyond ln n nothing is claimed");
        assert_eq!(new_classes(&[], 1.0, 5), None);
        let few = new_classes(&BUTTERFLIES, 1.0, 10).unwrap();
        assert!(few.value <= 10.0 && few.high <= 10.0);
    }

    #[test]
    fn unseen_mass_is_the_share_of_finds_that_are_alone() {
        // Good 1953: f1 / n. Here 2 classes once, 1 twice: 2 of 4 finds. Esty: sqrt(2 * 0.5 + 2 * 1) / 4 = 0.433.
        let mass = unseen_mass(&[2, 1]).unwrap();
        assert!((mass.value - 0.5).abs() < 1e-12);
        assert!(mass.low.abs() < 1e-12 && mass.high == 1.0, "{mass:?}");
        let many = unseen_mass(&[10, 20, 100, 200]).unwrap();
        let n = 10.0 + 40.0 + 300.0 + 800.0;
        let deviation = (10.0 * (1.0 - 10.0 / n) + 40.0f64).sqrt() / n;
        assert!((many.high - (10.0 / n + Z95 * deviation)).abs() < 1e-12);
        assert_eq!(unseen_mass(&[]), None);
        let none_alone = unseen_mass(&[0, 0, 10]).unwrap();
        assert_eq!((none_alone.value, none_alone.low), (0.0, 0.0));
        assert!((none_alone.high - 0.1).abs() < 1e-12, "{none_alone:?}");
    }

    #[test]
    fn frequencies_count_classes_by_their_finds() {
        assert_eq!(frequencies([1, 3, 0, 1, 2].into_iter()), [2, 1, 1]);
        assert!(frequencies([0, 0].into_iter()).is_empty());
    }
}
