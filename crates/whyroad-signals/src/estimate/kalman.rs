//! An extended Kalman filter and its fixed-interval smoother for any motion model of fixed size. Observations are
//! single components of the state, so that no matrix is inverted, in the forward or the backward pass.
//!
//! The backward pass is that of Bierman (1973, "Fixed interval smoothing with discrete measurements"), often called the
//! modified Bryson-Frazier smoother: it carries the information of later rows as the vector and the matrix of
//! [`Later`], not as a smoothed state. Except for rounding the result is that of Rauch, Tung and Striebel (1965), which
//! solves for one matrix per row.

use super::matrix::{Matrix, product, sum, symmetric, transposed, zero};
use crate::geometry::wrap;
use std::f64::consts::PI;

/// Motion model of a state.
pub trait Model<const N: usize> {
    /// Component that is an angle: its innovations are taken the shorter way round.
    const ANGLE: Option<usize>;

    /// What is kept of a matrix of derivatives for the backward pass: where most are zero, the others. The steps of a
    /// track are more than a processor keeps near.
    type Kept: Copy;

    /// Of a matrix of derivatives from [`Model::predict`].
    fn kept(derivatives: &Matrix<N>) -> Self::Kept;

    /// The matrix of which this was kept.
    fn derivatives(kept: &Self::Kept) -> Matrix<N>;

    /// The state `dt` seconds later, and its derivatives with respect to the state.
    fn predict(&self, state: &[f64; N], dt: f64) -> ([f64; N], Matrix<N>);

    /// Covariance that `dt` seconds add, exactly symmetric.
    fn noise(&self, state: &[f64; N], dt: f64) -> Matrix<N>;

    /// The product of a matrix of derivatives, from [`Model::predict`], and `matrix`.
    fn moved(derivatives: &Matrix<N>, matrix: &Matrix<N>) -> Matrix<N> {
        product(derivatives, matrix)
    }

    /// The product of the transpose of a matrix of derivatives, from [`Model::predict`], and `matrix`.
    fn moved_back(derivatives: &Matrix<N>, matrix: &Matrix<N>) -> Matrix<N> {
        product(&transposed(derivatives), matrix)
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

/// Measurements further than this from the expected value have less weight (standard deviations): a jump or a swapped
/// id shifts the estimate, but not at once.
const GATE: f64 = 4.0;
/// If this many consecutive rows are that far off, it is no measurement error: the motion contradicts the model, as at
/// a drawn corner of a road, and the earlier knowledge about that component is discarded. Otherwise the estimate would
/// diverge permanently, because distant measurements have less weight.
const PATIENCE: u8 = 3;
/// An angle error of at least this is a reversed box, rad.
const TURNED_ROUND_RAD: f64 = 0.75 * PI;

/// A row after filtering.
struct Step<const N: usize, K> {
    /// Derivatives of the predicted state with respect to that of the row before; unused in the first row.
    transition: K,
    state: [f64; N],
    covariance: Matrix<N>,
    /// Number of observations up to and including this row.
    taken: usize,
    /// For each component, the number of consecutive rows up to this one whose measurements were far off, at most
    /// [`PATIENCE`].
    rows_off: [u8; N],
}

/// An observation after filtering.
struct Taken<const N: usize> {
    index: usize,
    /// Change of the state per unit of innovation.
    gain: [f64; N],
    /// Measured minus expected value.
    innovation: f64,
    /// Variance of the innovation, as used.
    variance: f64,
}

/// The forward pass over some rows, and the start of the backward pass.
pub struct Filter<'a, const N: usize, M: Model<N>> {
    model: &'a M,
    /// s, ascending.
    times: &'a [f64],
    /// The state before the first row, and its covariance.
    first: ([f64; N], Matrix<N>),
    steps: Vec<Step<N, M::Kept>>,
    taken: Vec<Taken<N>>,
}

impl<'a, const N: usize, M: Model<N>> Filter<'a, N, M> {
    /// Filters the rows at `times`. `observe` adds the measurements of a row to the list; a row without observations is
    /// bridged.
    pub fn new(
        model: &'a M,
        times: &'a [f64],
        first: ([f64; N], Matrix<N>),
        observe: impl FnMut(usize, &mut Vec<Observation>),
    ) -> Self {
        let (steps, taken) = (Vec::with_capacity(times.len()), Vec::with_capacity(4 * times.len()));
        let mut filter = Self { model, times, first, steps, taken };
        filter.filter_from(0, observe);
        filter
    }

    /// Filters the rows from `start` on, again if they were filtered before with other measurements.
    pub fn filter_from(&mut self, start: usize, mut observe: impl FnMut(usize, &mut Vec<Observation>)) {
        self.steps.truncate(start);
        self.taken.truncate(self.steps.last().map_or(0, |step| step.taken));
        let mut seen = Vec::with_capacity(8);
        let ((mut state, mut covariance), mut rows_off) = match self.steps.last() {
            Some(step) => ((step.state, step.covariance), step.rows_off),
            None => (self.first, [0; N]),
        };
        for row in start..self.times.len() {
            let mut transition = [[0.0; N]; N];
            if row > 0 {
                let dt = self.times[row] - self.times[row - 1];
                let noise = self.model.noise(&state, dt);
                (state, transition) = self.model.predict(&state, dt);
                // The transpose of F P F', with the sparse F on the left both times; the matrix is made symmetric next,
                // so it need not be transposed back.
                let moved = M::moved(&transition, &transposed(&M::moved(&transition, &covariance)));
                covariance = symmetric(&sum(&moved, &noise));
            }
            seen.clear();
            observe(row, &mut seen);
            for o in &seen {
                let off = innovation(&state, o, M::ANGLE);
                let beyond = off.abs() > GATE * (covariance[o.index][o.index] + o.variance).sqrt();
                let turned_round = M::ANGLE == Some(o.index) && off.abs() > TURNED_ROUND_RAD;
                rows_off[o.index] =
                    if beyond && !turned_round { (rows_off[o.index] + 1).min(PATIENCE) } else { 0 };
                if rows_off[o.index] >= PATIENCE {
                    covariance[o.index][o.index] += off * off;
                }
            }
            for o in &seen {
                self.taken.push(update(&mut state, &mut covariance, o, M::ANGLE));
            }
            let (transition, taken) = (M::kept(&transition), self.taken.len());
            self.steps.push(Step { transition, state, covariance, taken, rows_off });
        }
    }

    /// The states of all rows, given all measurements.
    pub fn smoothed(&self) -> Smoothed<N> {
        let n = self.steps.len();
        let mut out = Smoothed { states: vec![[0.0; N]; n], variances: vec![[0.0; N]; n] };
        self.back(|row, step, later| {
            (out.states[row], out.variances[row]) = later.applied(&step.state, &step.covariance);
        });
        out
    }

    /// Of [`Filter::smoothed`] one component alone: its values and their variances.
    pub fn smoothed_component(&self, component: usize) -> (Vec<f64>, Vec<f64>) {
        let mut out = (vec![0.0; self.steps.len()], vec![0.0; self.steps.len()]);
        self.back(|row, step, later| {
            (out.0[row], out.1[row]) = later.applied_to(component, &step.state, &step.covariance);
        });
        out
    }

    /// The states after filtering, one per row.
    pub fn filtered(&self) -> impl Iterator<Item = &[f64; N]> {
        self.steps.iter().map(|step| &step.state)
    }

    /// Visits the rows from the last one back, each with the information of the rows after it.
    fn back(&self, mut visit: impl FnMut(usize, &Step<N, M::Kept>, &Later<N>)) {
        let steps = &self.steps;
        let mut later = Later::nothing();
        for (row, step) in steps.iter().enumerate().rev() {
            visit(row, step, &later);
            if row > 0 {
                let taken = &self.taken[steps[row - 1].taken..step.taken];
                taken.iter().rev().for_each(|taken| later.take(taken));
                later.step_back::<M>(&M::derivatives(&step.transition));
            }
        }
    }
}

/// Information of later measurements about a state that the filter estimates as `x` with covariance `P`: the smoothed
/// state is `x - P gradient`, its covariance `P - P information P`.
struct Later<const N: usize> {
    gradient: [f64; N],
    information: Matrix<N>,
}

impl<const N: usize> Later<N> {
    /// There are no later measurements.
    fn nothing() -> Self {
        Self { gradient: [0.0; N], information: zero() }
    }

    /// The smoothed state, and the variance of each component.
    fn applied(&self, state: &[f64; N], covariance: &Matrix<N>) -> ([f64; N], [f64; N]) {
        let (mut smoothed, mut variances) = (*state, [0.0; N]);
        let weighted = product(covariance, &self.information);
        for i in 0..N {
            let (mut change, mut known) = (0.0, 0.0);
            for j in 0..N {
                change += covariance[i][j] * self.gradient[j];
                // The covariance is symmetric: its row is its column.
                known += weighted[i][j] * covariance[i][j];
            }
            smoothed[i] -= change;
            variances[i] = (covariance[i][i] - known).max(0.0);
        }
        (smoothed, variances)
    }

    /// One component of [`Later::applied`].
    fn applied_to(&self, i: usize, state: &[f64; N], covariance: &Matrix<N>) -> (f64, f64) {
        let mut weighted = [0.0; N];
        for k in 0..N {
            for j in 0..N {
                weighted[j] += covariance[i][k] * self.information[k][j];
            }
        }
        let (mut change, mut known) = (0.0, 0.0);
        for j in 0..N {
            change += covariance[i][j] * self.gradient[j];
            known += weighted[j] * covariance[i][j];
        }
        (state[i] - change, (covariance[i][i] - known).max(0.0))
    }

    /// From the state after an observation to the state before it: with `A = I - gain h'` and `h` the unit vector of
    /// the component, `A' gradient - h innovation / variance` and `A' information A + h h' / variance`. Only one row
    /// and one column change.
    fn take(&mut self, taken: &Taken<N>) {
        let (k, gain) = (taken.index, &taken.gain);
        let (mut along, mut change) = ([0.0; N], taken.innovation / taken.variance);
        for i in 0..N {
            for j in 0..N {
                along[j] += gain[i] * self.information[i][j];
            }
            change += gain[i] * self.gradient[i];
        }
        self.gradient[k] -= change;
        let mut corner = self.information[k][k] - 2.0 * along[k] + 1.0 / taken.variance;
        for i in 0..N {
            corner += gain[i] * along[i];
            let changed = self.information[k][i] - along[i];
            (self.information[k][i], self.information[i][k]) = (changed, changed);
        }
        self.information[k][k] = corner;
    }

    /// From a row to the row before it, from which it was predicted: `F' gradient` and `F' information F`.
    fn step_back<M: Model<N>>(&mut self, transition: &Matrix<N>) {
        let mut gradient = [0.0; N];
        for i in 0..N {
            for j in 0..N {
                gradient[j] += transition[i][j] * self.gradient[i];
            }
        }
        self.gradient = gradient;
        let half = M::moved_back(transition, &self.information);
        self.information = symmetric(&M::moved_back(transition, &transposed(&half)));
    }
}

/// Difference between the measurement and the expected value.
fn innovation<const N: usize>(state: &[f64; N], o: &Observation, angle: Option<usize>) -> f64 {
    let off = o.value - state[o.index];
    if angle == Some(o.index) { wrap(off) } else { off }
}

/// Updates a state and its covariance with an observation.
fn update<const N: usize>(
    state: &mut [f64; N],
    covariance: &mut Matrix<N>,
    o: &Observation,
    angle: Option<usize>,
) -> Taken<N> {
    let k = o.index;
    let innovation = innovation(state, o, angle);
    let spread = covariance[k][k] + o.variance;
    let beyond = innovation * innovation / (GATE * GATE);
    let variance = spread.max(beyond);
    let (mut column, mut gain) = ([0.0; N], [0.0; N]);
    for i in 0..N {
        column[i] = covariance[i][k];
        gain[i] = column[i] / variance;
    }
    for i in 0..N {
        state[i] += gain[i] * innovation;
        for j in 0..N {
            covariance[i][j] -= gain[i] * column[j];
        }
    }
    Taken { index: k, gain, innovation, variance }
}

#[cfg(test)]
mod tests;
