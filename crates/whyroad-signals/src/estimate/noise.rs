//! Noise of a log, estimated from its own residuals: the remainder of positions, headings and velocities after smooth
//! motion is removed. Differences of third order (second order for headings and velocities) remove constant velocity
//! and constant acceleration; their median is not affected by maneuvers. White noise gives the same variance at every
//! stride, noise that is correlated over [`CORRELATION_S`] a variance that grows with the stride: two strides
//! distinguish them.

use crate::geometry::wrap;

/// In a maneuver, correlated noise counts as that of at most this many rows. Of 1, 3, 6, 10 and 20, 6 gives the
/// smallest errors of speed and acceleration with correct deviations (speeds of simulated drives, noise correlated over
/// a second).
const MANEUVER_ROWS: f64 = 6.0;
/// Assumed correlation time of correlated noise, s (first-order Gauss-Markov).
pub const CORRELATION_S: f64 = 1.0;
/// Strides at which differences are taken, rows.
const STRIDES: [usize; 2] = [1, 4];
/// Minimum ratio of the variance at the longer stride to that at the shorter one; below it the noise counts as white.
const LEAST_GROWTH: f64 = 1.2;
/// Minimum number of differences for an estimate.
const LEAST_SAMPLES: usize = 40;
/// Maximum number of differences that are used.
const MOST_SAMPLES: usize = 40_000;
/// Median of the square of a standard normal variable.
const MEDIAN_OF_SQUARE: f64 = 0.454_936;
/// Variance of a third-order difference of white noise of variance 1.
const OF_WHITE_THIRD: f64 = 20.0;
/// Negative covariance of two neighboring differences.
const OF_WHITE_THIRD_NEXT: f64 = 15.0;
/// Steps further apart in time than this are not neighbors, s.
const MAX_STEP_S: f64 = 1.1;

/// Noise of one measured quantity, standard deviations in its unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Independent from row to row.
    pub white: f64,
    /// Correlated over [`CORRELATION_S`].
    pub correlated: f64,
    /// Below this value the quantity counts as exact.
    pub negligible: f64,
}

impl Noise {
    /// True when the noise is too small to be smoothed: the measurement is the estimate.
    pub fn is_negligible(&self) -> bool {
        self.white <= self.negligible && self.correlated <= 4.0 * self.negligible
    }

    /// Variance of white noise, one value per `dt` seconds, with the same effect on slow motion as this noise.
    pub fn variance(&self, dt: f64) -> f64 {
        let kept = (-dt / CORRELATION_S).exp();
        let floor = 0.5 * self.negligible;
        self.white.powi(2) + self.correlated.powi(2) * (1.0 + kept) / (1.0 - kept).max(1e-6) + floor * floor
    }

    /// The same for motion that changes within a second, such as a maneuver: noise that is correlated over a second has
    /// less effect on it.
    pub fn variance_in_maneuvers(&self, dt: f64) -> f64 {
        let kept = (-dt / CORRELATION_S).exp();
        let floor = 0.5 * self.negligible;
        let times = ((1.0 + kept) / (1.0 - kept).max(1e-6)).min(MANEUVER_ROWS);
        self.white.powi(2) + self.correlated.powi(2) * times + floor * floor
    }

    /// Standard deviation of one measurement.
    pub fn deviation(&self) -> f64 {
        self.white.hypot(self.correlated)
    }
}

/// Noise of the measured quantities of one kind of object.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LogNoise {
    /// Of a coordinate, m.
    pub position: Noise,
    /// rad.
    pub heading: Noise,
    /// Of a component of the velocity, m/s; zero where the log has no velocities.
    pub velocity: Noise,
}

impl LogNoise {
    /// The same where places and velocities are known not to be exact.
    pub fn noticeable(self) -> Self {
        let raised = |of: Noise| Noise { white: of.white.max(1.5 * of.negligible), ..of };
        Self { position: raised(self.position), velocity: raised(self.velocity), ..self }
    }

    /// True when all measurements in the log are exact.
    pub fn is_negligible(&self) -> bool {
        self.position.is_negligible() && self.heading.is_negligible() && self.velocity.is_negligible()
    }
}

/// Rows of one object: values at times (s), NaN is unknown.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rows<'a> {
    /// s, ascending.
    pub times: &'a [f64],
    /// m.
    pub x: &'a [f64],
    /// m.
    pub y: &'a [f64],
    /// rad.
    pub heading: &'a [f64],
    /// m/s, empty or NaN where the log has none.
    pub vx: &'a [f64],
    /// m/s.
    pub vy: &'a [f64],
    /// m/s along the heading, where the log states a speed and no velocity; empty or NaN where it does not.
    pub forward: &'a [f64],
}

/// Noise below these values counts as exact: 1.5 cm, 0.3 degrees, 5 cm/s.
const NEGLIGIBLE: [f64; 3] = [0.015, 0.005, 0.05];
/// Contribution of smooth motion itself per `dt` to the power of the order: jerk, yaw acceleration, jerk.
const OF_MOTION: [f64; 3] = [0.5, 0.05, 0.5];

/// No vehicle changes its speed by this much to one side and by as much to the other in two successive steps, m/s2.
const THERE_AND_BACK_MPS2: f64 = 7.0;
/// Nor by this much in the last step, of which nobody knows yet whether it is taken back: tires hold 1.1 g or so, m/s2.
const LAST_STEP_MPS2: f64 = 12.0;

/// True when a vehicle's speed jumps and returns: single rows of a log that is exact otherwise are of another time or
/// place than they say. The speed is the stated one, which is what is used where it is there; else that of the
/// positions.
pub fn jumps_and_returns(rows: Rows<'_>) -> bool {
    let along = |i: usize, (x, y): (f64, f64)| {
        let (sin, cos) = rows.heading[i].sin_cos();
        x * cos + y * sin
    };
    let stated = |i: usize| {
        let at = |v: &[f64]| v.get(i).copied().unwrap_or(f64::NAN);
        let forward = at(rows.forward);
        if forward.is_nan() { along(i, (at(rows.vx), at(rows.vy))) } else { forward }
    };
    let step = |i: usize| rows.times[i] - rows.times[i - 1];
    let moved = |i: usize| along(i, (rows.x[i] - rows.x[i - 1], rows.y[i] - rows.y[i - 1])) / step(i);
    let last = rows.times.len().saturating_sub(1);
    let is_impossible = |at: usize, speeds: [f64; 3], steps: [f64; 2]| {
        let [up, down] = [(speeds[1] - speeds[0]) / steps[0], (speeds[2] - speeds[1]) / steps[1]];
        let returns = up * down < 0.0 && up.abs().min(down.abs()) > THERE_AND_BACK_MPS2;
        returns || (at == last && down.abs() > LAST_STEP_MPS2)
    };
    let is_near = |i: usize| rows.times[i] - rows.times[i - 3] <= 3.0 * MAX_STEP_S;
    let states_speeds = (0..rows.times.len()).any(|i| stated(i).is_finite());
    (3..rows.times.len()).filter(|i| is_near(*i)).any(|i| {
        let middle = |i: usize| 0.5 * (step(i) + step(i - 1));
        if states_speeds {
            is_impossible(i, [stated(i - 2), stated(i - 1), stated(i)], [step(i - 1), step(i)])
        } else {
            is_impossible(i, [moved(i - 2), moved(i - 1), moved(i)], [middle(i - 1), middle(i)])
        }
    })
}

/// The noise of objects of one kind, estimated from all of them together. Zero where there are too few rows.
pub fn estimate<'a>(objects: impl Iterator<Item = Rows<'a>> + Clone) -> LogNoise {
    let step = median_step(objects.clone());
    let velocity = if stated(objects.clone()) { VELOCITY } else { SPEED };
    LogNoise {
        position: noise_in(POSITION, objects.clone(), step),
        heading: noise_in(HEADING, objects.clone(), step),
        velocity: noise_in(velocity, objects, step),
    }
}

/// [`LogNoise::position`] of one object alone, if its deviation is greater than `least`, m.
pub fn of_positions_above(rows: Rows<'_>, least: f64) -> Option<Noise> {
    let step = median_step(std::iter::once(rows));
    // Most objects have far less noise: then the median itself is not needed.
    let mut squares = Vec::new();
    Order::Third.squares(rows.times, [rows.x, rows.y], STRIDES[0], step, &mut squares);
    let most = most_of_median(step, least);
    if 2 * squares.iter().filter(|square| **square <= most).count() > squares.len() + 1 {
        return None;
    }
    Some(noise_in(POSITION, std::iter::once(rows), step)).filter(|noise| noise.deviation() > least)
}

/// Up to this median of the squares at the shortest stride, the deviation of positions is at most `deviation`: a part
/// of the variance counts least where it is correlated.
fn most_of_median(step: f64, deviation: f64) -> f64 {
    let stride = STRIDES[0] as f64 * step;
    let own = OF_MOTION[POSITION.index] * stride.powi(Order::Third.power());
    let of_variance = Order::Third.of_correlated(stride).min(OF_WHITE_THIRD);
    (of_variance * deviation * deviation + own * own) * MEDIAN_OF_SQUARE * (1.0 - 1e-9)
}

/// A measured quantity.
#[derive(Clone, Copy)]
struct Quantity {
    /// Index in [`OF_MOTION`] and [`NEGLIGIBLE`].
    index: usize,
    order: Order,
    values: for<'a> fn(Rows<'a>) -> [&'a [f64]; 2],
}

const POSITION: Quantity = Quantity { index: 0, order: Order::Third, values: |r| [r.x, r.y] };
const HEADING: Quantity = Quantity { index: 1, order: Order::SecondOfAngles, values: |r| [r.heading, &[]] };
const VELOCITY: Quantity = Quantity { index: 2, order: Order::Second, values: |r| [r.vx, r.vy] };
const SPEED: Quantity = Quantity { index: 2, order: Order::Second, values: |r| [r.forward, &[]] };

/// The noise of one quantity; `step` is the median time from row to row, s.
fn noise_in<'a>(of: Quantity, objects: impl Iterator<Item = Rows<'a>> + Clone, step: f64) -> Noise {
    let Quantity { index, order, values } = of;
    let variances = STRIDES.map(|stride| {
        let mut squares = Vec::new();
        for rows in objects.clone() {
            if squares.len() >= MOST_SAMPLES {
                break;
            }
            order.squares(rows.times, values(rows), stride, step, &mut squares);
        }
        let own = OF_MOTION[index] * (stride as f64 * step).powi(order.power());
        robust_variance(&mut squares).map(|v| (v - own * own).max(0.0))
    });
    order.split(variances, step, NEGLIGIBLE[index])
}

/// Sum of squares, and number, of the deviations of one object's positions from smooth motion, in m of one coordinate
/// along the path: not the median, because the worst of few rows is the one that looks like a maneuver.
pub fn residuals(rows: Rows<'_>) -> (f64, f64) {
    let step = median_step(std::iter::once(rows));
    let mut squares = Vec::new();
    Order::Third.squares(rows.times, [rows.x, rows.y], 1, step, &mut squares);
    // Each coordinate has its own difference: the path runs along one direction.
    (squares.iter().sum::<f64>() / OF_WHITE_THIRD, 0.5 * squares.len() as f64)
}

/// The variance, m2, by which one object's positions alternate about smooth motion, and the number of pairs used. For
/// independent noise neighboring third-order differences have opposite signs (covariance -15 of 20); for motion they do
/// not, however hard the braking, if it lasts for two rows. Zero and less: nothing alternates.
pub fn alternation(rows: Rows<'_>) -> (f64, usize) {
    let step = median_step(std::iter::once(rows));
    let ascending = rows.times.windows(5).enumerate();
    let even = ascending.filter(|(_, w)| (w[4] - w[0] - 4.0 * step).abs() <= 0.2 * step);
    let (mut sum, mut pairs) = (0.0, 0_u32);
    for (i, _) in even {
        for v in [rows.x, rows.y] {
            let third = |k: usize| v[k + 3] - 3.0 * v[k + 2] + 3.0 * v[k + 1] - v[k];
            sum += third(i) * third(i + 1);
        }
        pairs += 1;
    }
    (-sum / OF_WHITE_THIRD_NEXT / f64::from(pairs.max(1)), pairs as usize)
}

/// True when the log states a velocity, and not only a speed.
fn stated<'a>(mut objects: impl Iterator<Item = Rows<'a>>) -> bool {
    objects.any(|rows| rows.vx.iter().any(|v| v.is_finite()))
}

/// Median time between rows, s; 0.1 if there are none.
fn median_step<'a>(objects: impl Iterator<Item = Rows<'a>>) -> f64 {
    let mut steps: Vec<f64> = Vec::new();
    for rows in objects {
        steps.reserve(rows.times.len());
        steps.extend(rows.times.windows(2).map(|w| w[1] - w[0]).filter(|s| *s <= MAX_STEP_S));
        if steps.len() > 5000 {
            break;
        }
    }
    let middle = steps.len() / 2;
    if steps.is_empty() { 0.1 } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

#[derive(Clone, Copy, PartialEq)]
enum Order {
    Third,
    Second,
    SecondOfAngles,
}

impl Order {
    fn power(self) -> i32 {
        if self == Self::Third { 3 } else { 2 }
    }

    /// Squares of the differences over equal steps of `stride` rows.
    fn squares(self, times: &[f64], values: [&[f64]; 2], stride: usize, step: f64, out: &mut Vec<f64>) {
        let reach = stride * self.power() as usize;
        let span = step * reach as f64;
        let known = values.iter().filter(|v| !v.is_empty()).count();
        // Most logs have no velocities.
        if values.iter().all(|v| v.iter().all(|x| x.is_nan())) {
            return;
        }
        out.reserve(known * times.len().saturating_sub(reach));
        // Objects that a source keeps still, such as parked cars, do not show the noise of moving ones.
        let still = |v: &[f64], end: usize| match self {
            Self::Third => v.get(end).is_none_or(|x| *x == v[end - stride]),
            Self::Second => v.get(end).is_none_or(|x| *x == 0.0 && v[end - stride] == 0.0),
            Self::SecondOfAngles => false,
        };
        for end in reach..times.len() {
            let uneven = (times[end] - times[end - reach] - span).abs() > 0.2 * step;
            if uneven || (still(values[0], end) && still(values[1], end)) {
                continue;
            }
            for v in values.into_iter().filter(|v| !v.is_empty()) {
                let at = |k: usize| v[end - k * stride];
                let difference = match self {
                    Self::Third => at(0) - 3.0 * at(1) + 3.0 * at(2) - at(3),
                    Self::Second => at(0) - 2.0 * at(1) + at(2),
                    Self::SecondOfAngles => wrap(wrap(at(0) - at(1)) - wrap(at(1) - at(2))),
                };
                if !difference.is_nan() {
                    out.push(difference * difference);
                }
            }
        }
    }

    /// Contribution of one unit of correlated variance to a difference at this stride.
    fn of_correlated(self, stride: f64) -> f64 {
        let kept = |k: f64| (-k * stride / CORRELATION_S).exp();
        if self == Self::Third {
            20.0 - 30.0 * kept(1.0) + 12.0 * kept(2.0) - 2.0 * kept(3.0)
        } else {
            6.0 - 8.0 * kept(1.0) + 2.0 * kept(2.0)
        }
    }

    fn split(self, variances: [Option<f64>; 2], step: f64, negligible: f64) -> Noise {
        let none = Noise { negligible, ..Noise::default() };
        let Some(near) = variances[0] else { return none };
        let of_white = if self == Self::Third { OF_WHITE_THIRD } else { 6.0 };
        let [k_near, k_far] = STRIDES.map(|s| self.of_correlated(s as f64 * step));
        let far = variances[1].filter(|far| *far > LEAST_GROWTH * near);
        let correlated = far.map_or(0.0, |far| ((far - near) / (k_far - k_near)).clamp(0.0, near / k_near));
        let white = ((near - k_near * correlated) / of_white).max(0.0);
        Noise { white: white.sqrt(), correlated: correlated.sqrt(), negligible }
    }
}

fn robust_variance(squares: &mut [f64]) -> Option<f64> {
    (squares.len() >= LEAST_SAMPLES).then(|| median(squares) / MEDIAN_OF_SQUARE)
}

/// Up to this number of squares are not counted first.
const FEW_SQUARES: usize = 4000;
/// Leading bits of a square by which it is counted: the sign, the exponent and three of the mantissa.
const COUNTED_BITS: u32 = 15;

/// The middle one in the order of these squares, of which there is at least one. Many are counted by their leading bits
/// first, which have the same order, and only those that begin as the median does are compared.
fn median(squares: &mut [f64]) -> f64 {
    let mut middle = squares.len() / 2;
    if squares.len() <= FEW_SQUARES {
        return *squares.select_nth_unstable_by(middle, f64::total_cmp).1;
    }
    let class = |square: f64| (square.to_bits() >> (u64::BITS - COUNTED_BITS)) as usize;
    let mut counts = vec![0_u32; 1 << COUNTED_BITS];
    squares.iter().for_each(|square| counts[class(*square)] += 1);
    let mut wanted = 0;
    while counts[wanted] as usize <= middle {
        middle -= counts[wanted] as usize;
        wanted += 1;
    }
    let mut alike: Vec<f64> = squares.iter().copied().filter(|square| class(*square) == wanted).collect();
    *alike.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A car along x with two rows per second: its positions, m.
    fn residual(x: &[f64]) -> f64 {
        let times: Vec<f64> = (0..x.len()).map(|i| i as f64 / 2.0).collect();
        let y = vec![0.0; x.len()];
        let (sum, count) = residuals(Rows { times: &times, x, y: &y, ..Rows::default() });
        (sum / count).sqrt()
    }

    #[test]
    fn the_median_of_many_squares_is_that_of_the_sorted_ones() {
        for n in [FEW_SQUARES, FEW_SQUARES + 1, 3 * FEW_SQUARES] {
            // Squares over forty powers of two, some of them equal, and zeros.
            let square = |i: usize| {
                if i.is_multiple_of(7) { 0.0 } else { 0.5_f64.powi((i * 37 % 41) as i32) * (i % 501) as f64 }
            };
            let mut squares: Vec<f64> = (0..n).map(square).collect();
            let mut sorted = squares.clone();
            sorted.sort_by(f64::total_cmp);
            assert_eq!(median(&mut squares).to_bits(), sorted[n / 2].to_bits(), "{n}");
        }
    }

    #[test]
    fn noise_above_a_bound_is_the_noise_of_the_object() {
        let times: Vec<f64> = (0..200).map(|i| 0.1 * f64::from(i)).collect();
        for scale in [0.001, 0.02, 0.05, 0.1, 0.4] {
            // A car at 8 m/s whose positions are off by numbers without a pattern.
            let off = |i: u32, k: u32| scale * (f64::from((i * 7919 + k * 104_729) % 1009) / 504.0 - 1.0);
            let x: Vec<f64> = (0..200).map(|i| 0.8 * f64::from(i) + off(i, 1)).collect();
            let y: Vec<f64> = (0..200).map(|i| off(i, 5)).collect();
            let rows = Rows { times: &times, x: &x, y: &y, ..Rows::default() };
            let all = noise_in(POSITION, std::iter::once(rows), median_step(std::iter::once(rows)));
            for least in [0.01, 0.03, 0.06, 0.1, 0.2, 0.3] {
                let expected = (all.deviation() > least).then_some(all);
                assert_eq!(of_positions_above(rows, least), expected, "{scale} {least}");
            }
        }
    }

    #[test]
    fn places_that_jump_are_told_from_braking() {
        let steady: Vec<f64> = (0..8).map(|i| 5.0 * f64::from(i)).collect();
        assert!(residual(&steady) < 1e-9);
        // From 10 m/s with 4 m/s2 to a stop: differences of third order of 1 m where it begins and ends.
        let stop = [0.0, 5.0, 10.0, 14.5, 18.0, 20.5, 22.0, 22.5, 22.5, 22.5];
        assert!(residual(&stop) < 0.12, "{}", residual(&stop));
        // The same mean speed, with one position 1.2 m off.
        let mut jumps = steady;
        jumps[4] += 1.2;
        assert!(residual(&jumps) > 0.3, "{}", residual(&jumps));
    }

    #[test]
    fn what_alternates_is_noise_and_what_brakes_is_not() {
        let of = |x: &[f64]| {
            let times: Vec<f64> = (0..x.len()).map(|i| i as f64 / 2.0).collect();
            let y = vec![0.0; x.len()];
            alternation(Rows { times: &times, x, y: &y, ..Rows::default() })
        };
        // From 12 m/s with 8 m/s2 to a stop: differences -1, -1, 0, 1, 1, 0 m, neighbors agree: -(1 + 1) / 15 / 5.
        let stop = [0.0, 6.0, 12.0, 17.0, 20.0, 21.0, 21.0, 21.0, 21.0];
        assert!((of(&stop).0 + 2.0 / 75.0).abs() < 1e-9, "{}", of(&stop).0);
        // 6 m per row, every second position 0.3 m off: differences of 1.2 m of alternating sign, 1.2^2 / 15.
        let weaves: Vec<f64> =
            (0..9).map(|i| 6.0 * f64::from(i) + if i % 2 == 0 { 0.3 } else { 0.0 }).collect();
        let (variance, pairs) = of(&weaves);
        assert!((variance - 1.44 / 15.0).abs() < 1e-9, "{variance}");
        assert_eq!(pairs, 5);
    }
}
