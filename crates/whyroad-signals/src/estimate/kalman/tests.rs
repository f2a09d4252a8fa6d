//! The smoothed states are those of the joint distribution of all rows, given all measurements: computed here without
//! recursion over rows, by conditioning one dense normal distribution on one measurement after another.

use super::*;
use crate::estimate::bicycle::{Bicycle, HEADING, X, Y};
use crate::estimate::matrix::diagonal;
use crate::estimate::walker::WALKER;

/// Mean and covariance of several numbers.
struct Normal {
    mean: Vec<f64>,
    covariance: Vec<Vec<f64>>,
}

impl Normal {
    /// States of all rows before any measurement, with derivatives and noise along `states`: row by row the prediction
    /// from the row before.
    fn of_rows<const N: usize, M: Model<N>>(
        model: &M,
        times: &[f64],
        along: &[[f64; N]],
        first: ([f64; N], Matrix<N>),
    ) -> Self {
        let size = N * times.len();
        let mut out = Self { mean: vec![0.0; size], covariance: vec![vec![0.0; size]; size] };
        for i in 0..N {
            out.mean[i] = first.0[i];
            out.covariance[i][..N].copy_from_slice(&first.1[i]);
        }
        for row in 1..times.len() {
            let dt = times[row] - times[row - 1];
            let (at, before) = (row * N, (row - 1) * N);
            let (next, f) = model.predict(&along[row - 1], dt);
            let noise = model.noise(&along[row - 1], dt);
            for i in 0..N {
                let off = (0..N).map(|k| f[i][k] * (out.mean[before + k] - along[row - 1][k])).sum::<f64>();
                out.mean[at + i] = next[i] + off;
                // With all earlier rows.
                for j in 0..at {
                    let value = (0..N).map(|k| f[i][k] * out.covariance[before + k][j]).sum::<f64>();
                    (out.covariance[at + i][j], out.covariance[j][at + i]) = (value, value);
                }
            }
            for i in 0..N {
                for j in 0..N {
                    let value = (0..N).map(|k| f[j][k] * out.covariance[at + i][before + k]).sum::<f64>();
                    out.covariance[at + i][at + j] = value + noise[i][j];
                }
            }
        }
        out
    }

    /// Conditions on the measurement of number `k`.
    fn measure(&mut self, k: usize, value: f64, variance: f64) {
        let column: Vec<f64> = self.covariance.iter().map(|row| row[k]).collect();
        let (off, spread) = (value - self.mean[k], column[k] + variance);
        for i in 0..column.len() {
            self.mean[i] += column[i] * off / spread;
            for j in 0..column.len() {
                self.covariance[i][j] -= column[i] * column[j] / spread;
            }
        }
    }
}

fn assert_near(smoothed: f64, joint: f64, what: &str) {
    assert!((smoothed - joint).abs() < 1e-9 * (1.0 + joint.abs()), "{what}: {smoothed} {joint}");
}

/// The states of all rows are those of `joint`, given the measurements `measured` of each row.
fn assert_is_joint<const N: usize>(
    smoothed: &Smoothed<N>,
    mut joint: Normal,
    measured: impl Fn(usize) -> Vec<Observation>,
) {
    for row in 0..smoothed.states.len() {
        for o in measured(row) {
            joint.measure(N * row + o.index, o.value, o.variance);
        }
    }
    for row in 0..smoothed.states.len() {
        for k in 0..N {
            let at = N * row + k;
            assert_near(smoothed.states[row][k], joint.mean[at], "state");
            assert_near(smoothed.variances[row][k], joint.covariance[at][at], "variance");
        }
    }
}

#[test]
fn a_walker_is_smoothed_as_by_the_joint_distribution() {
    let times = [0.0, 0.1, 0.2, 0.35, 0.8, 0.9, 1.0, 1.1];
    let first = ([2.0, 1.1], diagonal([25.0, 9.0]));
    // Positions near 2 + 1.3 t with small noise; two rows without, one row with two.
    let measured = |row: usize| -> Vec<Observation> {
        let value = 2.0 + 1.3 * times[row] + 0.05 * (7.0 * row as f64).sin();
        let place = Observation { index: 0, value, variance: 0.01 };
        match row {
            3 | 4 => vec![],
            6 => vec![place, Observation { index: 1, value: 1.25, variance: 0.04 }],
            _ => vec![place],
        }
    };
    let smoothed = Filter::new(&WALKER, &times, first, |row, seen| seen.extend(measured(row))).smoothed();
    // The model is linear: the states used for linearization do not matter.
    let joint = Normal::of_rows(&WALKER, &times, &[[0.0; 2]; 8], first);
    assert_is_joint(&smoothed, joint, measured);
}

#[test]
fn a_vehicle_is_smoothed_as_by_the_joint_distribution() {
    // A bend at 8 m/s and 0.3 rad/s that speeds up; every fifth row is missing.
    let times: Vec<f64> = (0..12).map(|i| 0.1 * f64::from(i)).collect();
    let bicycle = Bicycle { rear_to_center_m: 1.3 };
    let first = ([0.0, 0.0, 0.2, 8.0, 0.3, 0.5], diagonal([25.0, 25.0, 0.5, 25.0, 0.1, 4.0]));
    let mut driven = vec![first.0];
    for w in times.windows(2) {
        driven.push(bicycle.predict(&driven[driven.len() - 1], w[1] - w[0]).0);
    }
    let measured = |row: usize| -> Vec<Observation> {
        if row % 5 == 3 {
            return vec![];
        }
        let noise = |k: usize| 0.02 * (3.0 * row as f64 + 5.0 * k as f64).sin();
        let of = |index, variance| Observation { index, value: driven[row][index] + noise(index), variance };
        vec![of(X, 0.01), of(Y, 0.01), of(HEADING, 0.001)]
    };
    let filter = Filter::new(&bicycle, &times, first, |row, seen| seen.extend(measured(row)));
    let smoothed = filter.smoothed();
    for k in 0..6 {
        // One component alone is the same to the bit.
        let of = |all: &[[f64; 6]]| all.iter().map(|v| v[k]).collect::<Vec<_>>();
        assert_eq!(filter.smoothed_component(k), (of(&smoothed.states), of(&smoothed.variances)), "{k}");
    }
    // Derivatives are taken at the same states as in the filter: the estimate of each row from the rows up to it. For
    // each row these are the states of a smoother that ends there.
    let filtered: Vec<[f64; 6]> = (0..times.len())
        .map(|last| {
            let part = Filter::new(&bicycle, &times[..=last], first, |row, seen| seen.extend(measured(row)));
            part.smoothed().states[last]
        })
        .collect();
    let joint = Normal::of_rows(&bicycle, &times, &filtered, first);
    assert_is_joint(&smoothed, joint, measured);
}

#[test]
fn rows_filtered_again_are_those_of_filtering_once() {
    let times: Vec<f64> = (0..40).map(|i| 0.1 * f64::from(i)).collect();
    let first = ([0.0, 0.0], diagonal([25.0, 9.0]));
    // A jump that is far off for a few rows, before and after the row from which on the rate is measured too.
    let measured = |row: usize, from: usize| {
        let jump = if (17..24).contains(&row) { 4.0 } else { 0.0 };
        let place = Observation { index: 0, value: 0.1 * row as f64 + jump, variance: 0.01 };
        let rate = Observation { index: 1, value: 0.9, variance: 0.04 };
        if row < from { vec![place] } else { vec![place, rate] }
    };
    for from in [0, 1, 18, 19, 20, 30, 40] {
        let mut again = Filter::new(&WALKER, &times, first, |row, seen| seen.extend(measured(row, 40)));
        again.filter_from(from, |row, seen| seen.extend(measured(row, from)));
        let once = Filter::new(&WALKER, &times, first, |row, seen| seen.extend(measured(row, from)));
        let (again, once) = (again.smoothed(), once.smoothed());
        assert_eq!((again.states, again.variances), (once.states, once.variances), "{from}");
    }
}
