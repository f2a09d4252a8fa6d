//! Krippendorff's alpha: agreement of any number of raters; a rater may have no value for some units.
//!
//! Source: K. Krippendorff, "Computing Krippendorff's Alpha-Reliability" (2011): 1 - observed / expected disagreement,
//! over the coincidences of pairable values.

use std::collections::BTreeMap;

/// Alpha of categories; each unit has the values of its raters. `None` where no unit has two values, or where all
/// values are equal.
pub fn alpha_nominal<C: Ord>(units: &[Vec<C>]) -> Option<f64> {
    let mut index: BTreeMap<&C, usize> = BTreeMap::new();
    for value in units.iter().flatten() {
        let next = index.len();
        index.entry(value).or_insert(next);
    }
    let coded: Vec<Vec<usize>> = units.iter().map(|u| u.iter().map(|v| index[v]).collect()).collect();
    alpha(&coded, |a, b| if a == b { 0.0 } else { 1.0 })
}

/// Alpha of numbers with an interval scale. `None` as for [`alpha_nominal`].
pub fn alpha_interval(units: &[Vec<f64>]) -> Option<f64> {
    alpha(units, |a, b| (a - b) * (a - b))
}

fn alpha<V: Copy>(units: &[Vec<V>], difference: impl Fn(V, V) -> f64) -> Option<f64> {
    let pairable: Vec<&Vec<V>> = units.iter().filter(|u| u.len() > 1).collect();
    let values: Vec<V> = pairable.iter().flat_map(|u| u.iter().copied()).collect();
    let n = values.len() as f64;
    let both_ways = |values: &[V]| -> f64 {
        let mut sum = 0.0;
        for (i, a) in values.iter().enumerate() {
            for b in &values[i + 1..] {
                sum += 2.0 * difference(*a, *b);
            }
        }
        sum
    };
    let observed: f64 = pairable.iter().map(|u| both_ways(u) / (u.len() - 1) as f64).sum::<f64>() / n;
    let expected = both_ways(&values) / (n * (n - 1.0));
    (n > 1.0 && expected > 0.0).then(|| 1.0 - observed / expected)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four observers, twelve units, some left out: Krippendorff (2011), example C.
    const OBSERVERS: [[u8; 12]; 4] = [
        [1, 2, 3, 3, 2, 1, 4, 1, 2, 0, 0, 0],
        [1, 2, 3, 3, 2, 2, 4, 1, 2, 5, 0, 3],
        [0, 3, 3, 3, 2, 3, 4, 2, 2, 5, 1, 0],
        [1, 2, 3, 3, 2, 4, 4, 1, 2, 5, 1, 0],
    ];

    fn units() -> Vec<Vec<u8>> {
        (0..12).map(|u| OBSERVERS.iter().map(|o| o[u]).filter(|v| *v > 0).collect()).collect()
    }

    #[test]
    fn alpha_is_that_of_the_krippendorff_package() {
        // krippendorff 0.9.0 (PyPI), krippendorff.alpha(reliability_data=..., level_of_measurement=...), absent as NaN.
        let nominal = alpha_nominal(&units()).unwrap();
        assert!((nominal - 0.743_421_052_631_579).abs() < 1e-12, "{nominal}");
        let numbers: Vec<Vec<f64>> =
            units().into_iter().map(|u| u.into_iter().map(f64::from).collect()).collect();
        let interval = alpha_interval(&numbers).unwrap();
        assert!((interval - 0.849_107_142_857_142_8).abs() < 1e-12, "{interval}");
    }

    #[test]
    fn two_raters_of_keyframes() {
        // krippendorff 0.9.0, level_of_measurement="interval".
        let a = [4.0, 3.5, 10.2, 7.7, 12.0, 5.5, 9.1, 2.4, 15.0, 6.3];
        let b = [4.1, 3.5, 10.9, 7.2, 12.0, 5.9, 9.1, 4.4, 14.6, 6.3];
        let units: Vec<Vec<f64>> = a.iter().zip(b).map(|(a, b)| vec![*a, b]).collect();
        assert!((alpha_interval(&units).unwrap() - 0.982_256_106_658_611_1).abs() < 1e-12);
    }

    #[test]
    fn without_pairs_or_differences_there_is_no_alpha() {
        assert_eq!(alpha_nominal::<u8>(&[]), None);
        assert_eq!(alpha_nominal(&[vec![1], vec![2]]), None);
        assert_eq!(alpha_nominal(&[vec![1, 1], vec![1, 1]]), None);
        assert_eq!(alpha_nominal(&[vec![1, 1], vec![2, 2]]), Some(1.0));
    }
}
