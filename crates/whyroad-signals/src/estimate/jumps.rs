//! Lateral steps that no vehicle can make: a simulator's lane change in one step, a swapped id. The motion before and
//! the motion after are smoothed separately, because one smooth path through both would oscillate for seconds.

use super::MAX_SIDE_STEP_M;
use super::bicycle::REAR_TO_CENTER;
use super::noise::LogNoise;
use super::objects::Measured;
use super::smoother::MotionModel;
use crate::geometry::wrap;
use std::f64::consts::{FRAC_PI_2, SQRT_2};
use std::ops::Range;

/// Slower logs: a step over a longer time may be larger by at most this factor. A lane change in one second, 1.75 m in
/// 0.5 s, is motion; one of 3 m in 0.5 s is not.
const MOST_STEPS: f64 = 2.0;
/// Rows further apart than this are not checked for jumps, s.
const LONGEST_S: f64 = 0.55;
/// Standard deviations of the noise below which there is no jump.
const DEVIATIONS: f64 = 4.0;

/// The parts of `run` between jumps; the whole run if there is none, or if the object can move in any direction.
pub(super) fn between_jumps(
    measured: &Measured,
    run: Range<usize>,
    model: MotionModel,
    noise: &LogNoise,
) -> Vec<Range<usize>> {
    let MotionModel::Bicycle(bicycle) = model else { return vec![run] };
    let half = 0.5 * bicycle.rear_to_center_m / REAR_TO_CENTER;
    let front = |i: usize| {
        let (sin, cos) = measured.heading[i].sin_cos();
        (measured.x[i] + half * cos, measured.y[i] + half * sin)
    };
    let jumps = |a: usize, b: usize| {
        let (dt, turned) =
            (measured.times[b] - measured.times[a], wrap(measured.heading[b] - measured.heading[a]));
        // A reversed box is another error: the same position with front and rear exchanged.
        if dt > LONGEST_S || turned.is_nan() || turned.abs() > FRAC_PI_2 {
            return false;
        }
        let moved = (measured.x[b] - measured.x[a]).abs() + (measured.y[b] - measured.y[a]).abs();
        if moved + half.abs() * turned.abs() < MAX_SIDE_STEP_M {
            // The front moved no further than that, in any direction.
            return false;
        }
        let (from, to) = (front(a), front(b));
        let (sin, cos) = (measured.heading[a] + 0.5 * turned).sin_cos();
        let aside = (to.1 - from.1) * cos - (to.0 - from.0) * sin;
        let of_noise = DEVIATIONS
            * (SQRT_2 * noise.position.deviation())
                .hypot((to.0 - from.0).hypot(to.1 - from.1) * noise.heading.deviation());
        aside.abs() > MAX_SIDE_STEP_M * (dt / 0.1).clamp(1.0, MOST_STEPS) + of_noise
    };
    let mut parts = Vec::new();
    let (mut start, mut last) = (run.start, None);
    for i in run.clone().filter(|&i| measured.x[i].is_finite()) {
        if last.is_some_and(|l| jumps(l, i)) {
            parts.push(start..i);
            start = i;
        }
        last = Some(i);
    }
    parts.push(start..run.end);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::bicycle::Bicycle;
    use crate::estimate::noise::Noise;

    const CAR: MotionModel = MotionModel::Bicycle(Bicycle { rear_to_center_m: 1.3 });

    /// A car at 15 m/s along x, with one row every `step` tenths of a second, that moves 3.2 m to the left from `at` s
    /// on within `lasts` s.
    fn car(step: usize, at: f64, lasts: f64) -> Measured {
        let times: Vec<f64> = (0..80).map(|i| i as f64 / 10.0).collect();
        let sampled = |v: fn(f64, f64, f64) -> f64| -> Vec<f64> {
            let value = |(i, t): (usize, &f64)| if i % step == 0 { v(*t, at, lasts) } else { f64::NAN };
            times.iter().enumerate().map(value).collect()
        };
        Measured {
            frames: (0..80).collect(),
            source: (0..80).map(Some).collect(),
            x: sampled(|t, _, _| 15.0 * t),
            y: sampled(|t, at, lasts| 3.2 * ((t - at) / lasts.max(1e-9)).clamp(0.0, 1.0)),
            heading: sampled(|_, _, _| 0.0),
            vx: Vec::new(),
            vy: Vec::new(),
            forward: Vec::new(),
            times,
        }
    }

    /// All rows in one part.
    const WHOLE: &[Range<usize>] = std::slice::from_ref(&(0..80));

    fn parts(of: &Measured, noise: &LogNoise) -> Vec<Range<usize>> {
        between_jumps(of, 0..of.times.len(), CAR, noise)
    }

    #[test]
    fn a_lane_in_one_step_parts_the_motion_at_every_rate() {
        let exact = LogNoise::default();
        for step in [1, 2, 5] {
            // The sample at 4 s is the first in the new lane.
            assert_eq!(parts(&car(step, 3.95, 0.0), &exact), [0..40, 40..80], "every {step}");
            assert_eq!(parts(&car(step, 3.0, 2.0), &exact), WHOLE, "two seconds are a change of lane");
        }
        let noisy = LogNoise { position: Noise { white: 0.2, ..Noise::default() }, ..exact };
        assert_eq!(parts(&car(1, 3.95, 0.0), &noisy), [0..40, 40..80]);
        let worse = LogNoise { position: Noise { white: 1.0, ..Noise::default() }, ..exact };
        assert_eq!(parts(&car(1, 3.95, 0.0), &worse), WHOLE, "within its noise nothing is known to jump");
    }

    #[test]
    fn a_bend_and_a_box_turned_round_are_no_jumps() {
        let mut bend = car(5, 99.0, 0.0);
        for (i, t) in bend.times.iter().enumerate().filter(|(i, _)| i % 5 == 0) {
            // Round a circle of 20 m at 8 m/s.
            let turned = 0.4 * t;
            (bend.x[i], bend.y[i], bend.heading[i]) =
                (20.0 * turned.sin(), 20.0 - 20.0 * turned.cos(), wrap(turned));
        }
        assert_eq!(parts(&bend, &LogNoise::default()), WHOLE);
        let mut round = car(1, 99.0, 0.0);
        round.heading[30] = std::f64::consts::PI;
        assert_eq!(parts(&round, &LogNoise::default()), WHOLE);
    }
}
