//! The path between the samples of an exact log that is slower than the frames of the lake. Nothing is smoothed: a
//! smooth motion model oscillates for seconds after a step in the samples. Between two samples the path is the cubic
//! with their positions and velocities (Hermite); across the heading it never exceeds the samples (Fritsch and Carlson
//! 1980).

use super::join::MAX_AWAY_S;
use super::objects::Measured;
use crate::geometry::wrap;
use whyroad_model::scene::Motion;

/// Positions, velocities, headings and yaw rates of `motion`, one row for each of `measured`, from the samples. `given`
/// is the source's motion: its stated yaw rates are kept. Rows before the first sample are kept; those after the last
/// one [`go_on`] from it.
pub(super) fn follow(measured: &Measured, given: &Motion, motion: &mut Motion) {
    let rows: Vec<usize> = (0..measured.x.len())
        .filter(|&i| measured.x[i].is_finite() && measured.heading[i].is_finite())
        .collect();
    let slope = |a: usize, b: usize| {
        let dt = measured.times[b] - measured.times[a];
        let joined = dt <= MAX_AWAY_S;
        joined.then(|| ((measured.x[b] - measured.x[a]) / dt, (measured.y[b] - measured.y[a]) / dt))
    };
    let turn = |a: usize, b: usize| {
        wrap(measured.heading[b] - measured.heading[a]) / (measured.times[b] - measured.times[a])
    };
    let stated_turn = |i: usize| measured.source[i].is_some_and(|r| given.yaw_rate[r].is_finite());
    let velocities: Vec<Option<(f64, f64)>> = (0..rows.len())
        .map(|k| {
            let before = k.checked_sub(1).and_then(|p| slope(rows[p], rows[k]));
            let after = rows.get(k + 1).and_then(|&next| slope(rows[k], next));
            velocity(measured, rows[k], before, after)
        })
        .collect();
    for (k, pair) in rows.windows(2).enumerate() {
        let (a, b) = (pair[0], pair[1]);
        let (Some(v), Some(w)) = (velocities[k], velocities[k + 1]) else { continue };
        let dt = measured.times[b] - measured.times[a];
        if dt > MAX_AWAY_S {
            continue;
        }
        for i in a..=b {
            let share = (measured.times[i] - measured.times[a]) / dt;
            let (x, vx) = hermite((measured.x[a], v.0), (measured.x[b], w.0), dt, share);
            let (y, vy) = hermite((measured.y[a], v.1), (measured.y[b], w.1), dt, share);
            (motion.x[i], motion.y[i], motion.vx[i], motion.vy[i]) = (x, y, vx, vy);
            motion.heading[i] = wrap(measured.heading[a] + share * dt * turn(a, b));
            if !stated_turn(i) {
                motion.yaw_rate[i] = turn(a, b);
            }
        }
    }
    for three in rows.windows(3) {
        let (a, b, c) = (three[0], three[1], three[2]);
        if !stated_turn(b) && slope(a, b).is_some() && slope(b, c).is_some() {
            motion.yaw_rate[b] = 0.5 * (turn(a, b) + turn(b, c));
        }
    }
    if let Some(&last) = rows.last() {
        go_on(measured, given, motion, last);
    }
}

/// After the row `last` the motion goes on as at it, at constant speed and yaw rate, if that is for at most
/// [`MAX_AWAY_S`]. The motion model would not: it may still doubt a sample that no later one has confirmed, and its
/// heading is that of the path, from which a stated one may differ.
pub(super) fn go_on(measured: &Measured, given: &Motion, motion: &mut Motion, last: usize) {
    let (x, y, heading) = (motion.x[last], motion.y[last], motion.heading[last]);
    let (vx, vy, rate) = (motion.vx[last], motion.vy[last], motion.yaw_rate[last]);
    let known = [x, y, heading, vx, vy, rate].iter().all(|v| v.is_finite());
    let is_near = measured.times.last().is_some_and(|end| end - measured.times[last] <= MAX_AWAY_S);
    if !known || !is_near {
        return;
    }
    for i in last + 1..measured.x.len() {
        let dt = measured.times[i] - measured.times[last];
        let turned = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            (vx * cos - vy * sin, vx * sin + vy * cos)
        };
        let (to_x, to_y) = turned(0.5 * rate * dt);
        (motion.x[i], motion.y[i]) = (x + to_x * dt, y + to_y * dt);
        (motion.vx[i], motion.vy[i]) = turned(rate * dt);
        motion.heading[i] = wrap(heading + rate * dt);
        if !measured.source[i].is_some_and(|row| given.yaw_rate[row].is_finite()) {
            motion.yaw_rate[i] = rate;
        }
    }
}

/// Velocity at a sample: the stated one; else along the heading the mean of the slopes on either side, and across it
/// one that exceeds neither neighbor.
fn velocity(
    measured: &Measured,
    row: usize,
    before: Option<(f64, f64)>,
    after: Option<(f64, f64)>,
) -> Option<(f64, f64)> {
    let at = |v: &[f64]| v.get(row).copied().filter(|v| v.is_finite());
    if let (Some(vx), Some(vy)) = (at(&measured.vx), at(&measured.vy)) {
        return Some((vx, vy));
    }
    let (before, after) = (before.or(after)?, after.or(before)?);
    let (sin, cos) = measured.heading[row].sin_cos();
    let along = |v: (f64, f64)| v.0 * cos + v.1 * sin;
    let across = |v: (f64, f64)| v.1 * cos - v.0 * sin;
    let forward = at(&measured.forward).unwrap_or(0.5 * (along(before) + along(after)));
    let (l, r) = (across(before), across(after));
    let aside = if l * r > 0.0 { 2.0 * l * r / (l + r) } else { 0.0 };
    Some((forward * cos - aside * sin, forward * sin + aside * cos))
}

/// Value and rate of the cubic with these values and rates at its ends, `dt` s apart, at the fraction `share`.
fn hermite((p, v): (f64, f64), (q, w): (f64, f64), dt: f64, share: f64) -> (f64, f64) {
    let (s, rest) = (share, 1.0 - share);
    let value =
        rest * rest * (1.0 + 2.0 * s) * p + s * s * (3.0 - 2.0 * s) * q + dt * s * rest * (rest * v - s * w);
    let rate = 6.0 * s * rest * (q - p) / dt + rest * (1.0 - 3.0 * s) * v + s * (3.0 * s - 2.0) * w;
    (value, rate)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A car at 15 m/s along x that moves 3.2 m to the left within half a second from 4 s on, without turning, as
    /// simulators change lanes; sampled every `step` tenths of a second, with the stated speed.
    fn estimated(step: usize) -> (Measured, Motion) {
        let n = 101;
        let times: Vec<f64> = (0..n).map(|i| i as f64 / 10.0).collect();
        let sampled = |v: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let value = |(i, t): (usize, &f64)| if i % step == 0 { v(*t) } else { f64::NAN };
            times.iter().enumerate().map(value).collect()
        };
        let measured = Measured {
            frames: (0..n as u32).collect(),
            source: (0..n).map(Some).collect(),
            x: sampled(&|t| 15.0 * t),
            y: sampled(&left),
            heading: sampled(&|_| 0.0),
            vx: vec![f64::NAN; n],
            vy: vec![f64::NAN; n],
            forward: sampled(&|_| 15.0),
            times,
        };
        let mut motion = Motion::unknown(n);
        follow(&measured, &Motion::unknown(n), &mut motion);
        (measured, motion)
    }

    /// Lateral position of the car, left positive, m.
    fn left(t: f64) -> f64 {
        3.2 * ((t - 4.0) / 0.5).clamp(0.0, 1.0)
    }

    #[test]
    fn a_step_aside_leaves_no_swing_behind() {
        for step in [2, 5] {
            let (measured, motion) = estimated(step);
            let aside = 0.1 * step as f64;
            for (i, &t) in measured.times.iter().enumerate() {
                assert!(
                    (motion.x[i] - 15.0 * t).abs() < 1e-9 && (motion.vx[i] - 15.0).abs() < 1e-9,
                    "at {t}"
                );
                // One sample away from the step the motion is unchanged.
                if t < 4.0 - aside || t > 4.5 + aside {
                    assert!((motion.y[i] - left(t)).abs() < 1e-9 && motion.vy[i].abs() < 1e-9, "at {t}");
                }
                assert!((-1e-9..=3.2 + 1e-9).contains(&motion.y[i]), "it passes neither lane, at {t}");
            }
        }
    }

    #[test]
    fn what_follows_the_last_sample_goes_on_from_it() {
        // By hand, as between key frames of nuScenes: 6.7 m/s, then 10.7 m/s up to the last sample at 1 s, which is at
        // 8.7 m. At 10.7 m/s it is at 9.77, 10.84, ... m a tenth of a second later each.
        let times: Vec<f64> = (0..15).map(|i| i as f64 / 10.0).collect();
        let n = times.len();
        let only = |values: [f64; 3]| {
            let mut out = vec![f64::NAN; n];
            for (k, value) in values.into_iter().enumerate() {
                out[5 * k] = value;
            }
            out
        };
        let measured = Measured {
            frames: (0..n as u32).collect(),
            source: (0..n).map(Some).collect(),
            x: only([0.0, 3.35, 8.7]),
            y: only([0.0; 3]),
            heading: only([0.0; 3]),
            vx: vec![f64::NAN; n],
            vy: vec![f64::NAN; n],
            forward: Vec::new(),
            times,
        };
        let mut motion = Motion::unknown(n);
        follow(&measured, &Motion::unknown(n), &mut motion);
        for i in 11..n {
            let expected = 8.7 + 1.07 * (i - 10) as f64;
            assert!(
                (motion.x[i] - expected).abs() < 1e-9 && motion.y[i].abs() < 1e-9,
                "{i}: {}",
                motion.x[i]
            );
            assert!((motion.vx[i] - 10.7).abs() < 1e-9 && motion.yaw_rate[i] == 0.0, "{i}");
        }
    }

    #[test]
    fn a_bend_is_followed() {
        // 10 m/s round a circle of 30 m, sampled twice a second without velocities: the chord is off by
        // 30 (1 - cos(2.5 / 30)) = 0.10 m.
        let n = 61;
        let times: Vec<f64> = (0..n).map(|i| i as f64 / 10.0).collect();
        let turned = |t: f64| t / 3.0;
        let sampled = |v: fn(f64) -> f64| -> Vec<f64> {
            let value = |(i, t): (usize, &f64)| if i % 5 == 0 { v(turned(*t)) } else { f64::NAN };
            times.iter().enumerate().map(value).collect()
        };
        let none = vec![f64::NAN; n];
        let measured = Measured {
            frames: (0..n as u32).collect(),
            source: (0..n).map(Some).collect(),
            x: sampled(|a| 30.0 * a.sin()),
            y: sampled(|a| 30.0 - 30.0 * a.cos()),
            heading: sampled(|a| a),
            vx: none.clone(),
            vy: none.clone(),
            forward: Vec::new(),
            times,
        };
        let mut motion = Motion::unknown(n);
        follow(&measured, &Motion::unknown(n), &mut motion);
        for i in 5..n - 5 {
            let a = turned(measured.times[i]);
            let off = (motion.x[i] - 30.0 * a.sin()).hypot(motion.y[i] - 30.0 + 30.0 * a.cos());
            assert!(off < 0.03 && (motion.yaw_rate[i] - 1.0 / 3.0).abs() < 1e-9, "{i}: {off}");
            assert!((motion.vx[i].hypot(motion.vy[i]) - 10.0).abs() < 0.3, "{i}");
        }
    }
}
