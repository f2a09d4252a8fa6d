//! Confidence intervals: percentile intervals of a seeded bootstrap over episodes (B. Efron, "Bootstrap methods:
//! another look at the jackknife", The Annals of Statistics 7, 1979).

use serde::Serialize;
use whyroad_model::random::SplitMix64;

/// Samples of a bootstrap.
const SAMPLES: usize = 1000;
/// Share of the samples below and above the interval.
const TAIL: f64 = 0.025;

/// A value with its 95 % interval; each is `None` where it is not defined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Estimate {
    /// Of all units.
    pub value: Option<f64>,
    /// Lower bound.
    pub low: Option<f64>,
    /// Upper bound.
    pub high: Option<f64>,
}

/// `value` of the units, and of samples drawn from them with replacement. The same seed gives the same interval.
pub fn bootstrap<U: Clone>(units: &[U], seed: u64, value: impl Fn(&[U]) -> Option<f64>) -> Estimate {
    let own = value(units);
    if units.len() < 2 || own.is_none() {
        return Estimate { value: own, low: None, high: None };
    }
    let mut random = SplitMix64::new(seed);
    // The bias of the remainder is below n / 2^64.
    let mut any = || (random.bits() % units.len() as u64) as usize;
    let mut drawn: Vec<U> = Vec::with_capacity(units.len());
    let mut values: Vec<f64> = (0..SAMPLES)
        .filter_map(|_| {
            drawn.clear();
            drawn.extend((0..units.len()).map(|_| units[any()].clone()));
            value(&drawn)
        })
        .collect();
    values.sort_by(f64::total_cmp);
    // Samples in which the value is not defined are left out; if few others remain, there is no interval.
    let at = |share: f64| {
        let last = values.len().checked_sub(1)?;
        (values.len() * 2 > SAMPLES).then(|| values[(share * last as f64).round() as usize])
    };
    Estimate { value: own, low: at(TAIL), high: at(1.0 - TAIL) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(values: &[f64]) -> Option<f64> {
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    }

    #[test]
    fn the_interval_of_a_mean_is_about_that_of_the_normal_distribution() {
        // 400 zeros and ones, half each: standard error 0.025, so 0.5 -/+ 0.049.
        let values: Vec<f64> = (0..400).map(|i| f64::from(i % 2)).collect();
        let e = bootstrap(&values, 1, mean);
        assert_eq!(e.value, Some(0.5));
        assert!((e.low.unwrap() - 0.451).abs() < 0.01 && (e.high.unwrap() - 0.549).abs() < 0.01, "{e:?}");
        assert_eq!(e, bootstrap(&values, 1, mean));
        assert_ne!(e, bootstrap(&values, 2, mean));
    }

    #[test]
    fn one_unit_has_no_interval() {
        assert_eq!(bootstrap(&[1.0], 0, mean), Estimate { value: Some(1.0), low: None, high: None });
        assert_eq!(bootstrap(&[], 0, mean), Estimate::default());
    }
}
