//! An extended Kalman filter and its fixed-interval smoother (Rauch, Tung and Striebel 1965) over any motion model of
//! fixed size. Observations are single components of the state, so that no matrix is inverted on the way forward.

use super::matrix::{Matrix, difference, product, solve, sum, symmetric, transposed};
use crate::geometry::wrap;
use std::f64::consts::PI;

/// How a state moves.
pub trait Model<const N: usize> {
    /// Component that is an angle: its innovations are taken the shorter way round.
    const ANGLE: Option<usize>;

    /// The state `dt` seconds later, and the derivatives of that by the state.
    fn predict(&self, state: &[f64; N], dt: f64) -> ([f64; N], Matrix<N>);

    /// Covariance that `dt` seconds add, equal to its own transpose to the bit.
    fn noise(&self, state: &[f64; N], dt: f64) -> Matrix<N>;

    /// The product of a matrix of derivatives, as [`Model::predict`] gives it, and `matrix`.
    fn moved(derivatives: &Matrix<N>, matrix: &Matrix<N>) -> Matrix<N> {
        product(derivatives, matrix)
    }
}

/// A measurement of one component.
#[derive(Clone, Copy, Debug, Default)]
pub struct Observation {
    /// The component.
    pub index: usize,
    /// Its measured value.
    pub value: f64,
    /// Variance of the measurement.
    pub variance: f64,
}

/// States with their variances, one per row.
#[derive(Clone, Debug, Default)]
pub struct Smoothed<const N: usize> {
    /// The states.
    pub states: Vec<[f64; N]>,
    /// Variance of each component.
    pub variances: Vec<[f64; N]>,
}

/// Measurements further than this from what is expected count less (standard deviations): a jump or a swapped id moves
/// the estimate, but does not drag it along at once.
const GATE: f64 = 4.0;
/// So many rows in a row that are that far off are no faults of measurement: what moves did what the model holds for
/// impossible, as on a drawn corner of a road, and what was known of that component no longer holds. Else the estimate
/// would go its own way for good, since what is farther off counts less.
const PATIENCE: usize = 3;
/// An angle this far off is a box turned round, rad.
const TURNED_ROUND_RAD: f64 = 0.75 * PI;

struct Step<const N: usize> {
    transition: Matrix<N>,
    predicted: ([f64; N], Matrix<N>),
    filtered: ([f64; N], Matrix<N>),
}

/// Smooths the rows at `times` (s, ascending). `observe` puts what was measured in a row into the list; a row without
/// observations is bridged.
pub fn smooth<const N: usize, M: Model<N>>(
    model: &M,
    times: &[f64],
    first: ([f64; N], Matrix<N>),
    mut observe: impl FnMut(usize, &mut Vec<Observation>),
) -> Smoothed<N> {
    let n = times.len();
    let mut steps: Vec<Step<N>> = Vec::with_capacity(n);
    let mut seen = Vec::with_capacity(8);
    let (mut state, mut covariance) = first;
    let mut rows_off = [0; N];
    for row in 0..n {
        let mut transition = [[0.0; N]; N];
        if row > 0 {
            let dt = times[row] - times[row - 1];
            let noise = model.noise(&state, dt);
            (state, transition) = model.predict(&state, dt);
            // The transpose of F P F', with the mostly empty F on the left both times; what is made symmetric next
            // need not be turned back.
            let moved = M::moved(&transition, &transposed(&M::moved(&transition, &covariance)));
            covariance = symmetric(&sum(&moved, &noise));
        }
        seen.clear();
        observe(row, &mut seen);
        for o in &seen {
            let off = innovation(&state, o, M::ANGLE);
            let beyond = off.abs() > GATE * (covariance[o.index][o.index] + o.variance).sqrt();
            let turned_round = M::ANGLE == Some(o.index) && off.abs() > TURNED_ROUND_RAD;
            rows_off[o.index] = if beyond && !turned_round { rows_off[o.index] + 1 } else { 0 };
            if rows_off[o.index] >= PATIENCE {
                covariance[o.index][o.index] += off * off;
            }
        }
        let predicted = (state, covariance);
        for o in &seen {
            update(&mut state, &mut covariance, o, M::ANGLE);
        }
        steps.push(Step { transition, predicted, filtered: (state, covariance) });
    }
    let mut out = Smoothed { states: vec![[0.0; N]; n], variances: vec![[0.0; N]; n] };
    let Some(last) = steps.last() else { return out };
    let (mut state, mut covariance) = last.filtered;
    for row in (0..n).rev() {
        if row + 1 < n {
            let (here, next) = (&steps[row], &steps[row + 1]);
            // G' = P_predicted^-1 F P_filtered, so G = P_filtered F' P_predicted^-1.
            let turned_gain = solve(&next.predicted.1, &M::moved(&next.transition, &here.filtered.1));
            let gain = transposed(&turned_gain);
            let mut back = here.filtered.0;
            for (value, weights) in back.iter_mut().zip(&gain) {
                for k in 0..N {
                    let mut off = state[k] - next.predicted.0[k];
                    if M::ANGLE == Some(k) {
                        off = wrap(off);
                    }
                    *value += weights[k] * off;
                }
            }
            let off = difference(&covariance, &next.predicted.1);
            covariance = symmetric(&sum(&here.filtered.1, &product(&product(&gain, &off), &turned_gain)));
            state = back;
        }
        out.states[row] = state;
        for k in 0..N {
            out.variances[row][k] = covariance[k][k].max(0.0);
        }
    }
    out
}

/// How far the measurement is from what is expected.
fn innovation<const N: usize>(state: &[f64; N], o: &Observation, angle: Option<usize>) -> f64 {
    let off = o.value - state[o.index];
    if angle == Some(o.index) { wrap(off) } else { off }
}

fn update<const N: usize>(
    state: &mut [f64; N],
    covariance: &mut Matrix<N>,
    o: &Observation,
    angle: Option<usize>,
) {
    let k = o.index;
    let innovation = innovation(state, o, angle);
    let spread = covariance[k][k] + o.variance;
    let beyond = innovation * innovation / (GATE * GATE);
    let total = spread.max(beyond);
    let mut column = [0.0; N];
    for i in 0..N {
        column[i] = covariance[i][k];
    }
    for i in 0..N {
        let gain = column[i] / total;
        state[i] += gain * innovation;
        for j in 0..N {
            covariance[i][j] -= gain * column[j];
        }
    }
}
