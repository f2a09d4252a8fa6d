//! Motion of a target along its own path: reversing, standing, moving off, braking.

use crate::behavior::stops::Standing;
use crate::series::smooth;
use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use crate::target::rows::Rows;
use whyroad_model::Tri;
use whyroad_model::catalog::id;

/// Below this forward speed a vehicle reverses, m/s (as `ego.meta_longitudinal`).
const REVERSE_MPS: f64 = -0.3;
/// A target that drives forward faster than this, m/s,
const FORWARD_MPS: f64 = 2.0;
/// less than this long before or after does not reverse: its box jumps, s.
const CHANGE_OF_GEAR_S: f64 = 1.0;
/// The same where it drives forward faster than this both before and after, m/s.
const ROCKING_MPS: f64 = 1.0;
/// A stationary box that slides back returns to its position after at most this long, s,
const SLIDES_BACK_S: f64 = 5.0;
/// to within this distance, m.
const SAME_PLACE_M: f64 = 0.3;
/// A shorter distance backwards is a tracker's jitter or a car that rocks as it stops, m.
const REVERSE_LEAST_M: f64 = 1.0;
/// A vehicle that gains more speed than this, m/s,
const HEAVY_GAIN_MPS: f64 = 3.0;
/// in this time is neither a loaded truck (1 m/s in a second) nor a bus (1.5 m/s), s.
const HEAVY_GAIN_S: f64 = 2.0;
/// Boxes that jump do so again within this time, s: the interval of such jumps in recorded drives.
const JUMPS_AGAIN_S: f64 = 3.0;
/// Minimum duration of a standstill that is parking or waiting, s.
const PARKED_S: f64 = 5.0;
/// ... which counts for this long after its end, s.
const PARKED_WITHIN_S: f64 = 10.0;
/// Braking at least this hard is sudden, m/s2.
const SUDDEN_MPS2: f64 = -4.0;
/// Minimum speed for sudden braking, m/s.
const SUDDEN_LEAST_MPS: f64 = 1.0;
/// Half width of the mean of the acceleration, s.
const MEAN_REACH_S: f64 = 0.2;

/// Whether a target that was stationary before frame `start` and moved backwards until frame `end` is soon stationary
/// at its old position: its box slid, or it only made room for another road user. Unknown where the track ends in this
/// time, on its way back there.
fn slides(times: &[f64], forward_speed: &[f64], start: usize, end: usize) -> Tri {
    let stands = |i: usize| forward_speed[i].abs() < -REVERSE_MPS;
    let just_before = (0..start).rev().take_while(|&i| times[start] - times[i] <= CHANGE_OF_GEAR_S);
    if start == 0 || !just_before.into_iter().all(stands) {
        return Tri::False;
    }
    let (mut way, mut farthest) = (0.0_f64, 0.0_f64);
    for i in start..forward_speed.len() - 1 {
        if i >= end && (forward_speed[i].is_nan() || times[i] - times[end - 1] > SLIDES_BACK_S) {
            return Tri::False;
        }
        if i >= end && stands(i) && way > -SAME_PLACE_M {
            return Tri::True;
        }
        way += forward_speed[i] * (times[i + 1] - times[i]);
        farthest = farthest.min(way);
    }
    if way > farthest + SAME_PLACE_M { Tri::Unknown } else { Tri::False }
}

/// By row, whether a vehicle reverses: for at least [`REVERSE_LEAST_M`] without interruption. A shorter distance that
/// is cut off by the beginning or the end of the track is unknown.
fn reverses(is_vehicle: bool, times: &[f64], forward_speed: &[f64]) -> Vec<Tri> {
    let n = forward_speed.len();
    if !is_vehicle {
        return vec![Tri::False; n];
    }
    let mut out: Vec<Tri> =
        forward_speed.iter().map(|v| if v.is_nan() { Tri::Unknown } else { Tri::False }).collect();
    let mut start = 0;
    while start < n {
        let back = |i: &usize| forward_speed[*i] < REVERSE_MPS;
        let end = (start..n).find(|i| !back(i)).unwrap_or(n);
        if end > start {
            let step = |i: usize| -forward_speed[i] * (times[(i + 1).min(n - 1)] - times[i]);
            let far = (start..end).map(step).sum::<f64>() >= REVERSE_LEAST_M;
            let cut =
                start == 0 || end == n || forward_speed[start - 1].is_nan() || forward_speed[end].is_nan();
            let near = |i: &usize| {
                let away = if *i < start { times[start] - times[*i] } else { times[*i] - times[end - 1] };
                away <= CHANGE_OF_GEAR_S
            };
            let before = || (0..start).filter(near).map(|i| forward_speed[i]);
            let after = || (end..n).filter(near).map(|i| forward_speed[i]);
            let rocks = before().any(|v| v > ROCKING_MPS) && after().any(|v| v > ROCKING_MPS);
            let jumps = rocks || before().chain(after()).any(|v| v > FORWARD_MPS);
            let slides = slides(times, forward_speed, start, end);
            out[start..end].fill(if jumps || slides == Tri::True {
                Tri::False
            } else if far && slides == Tri::False {
                Tri::True
            } else if far || cut {
                Tri::Unknown
            } else {
                Tri::False
            });
        }
        start = end + 1;
    }
    out
}

/// By row, whether a long vehicle's box jumped along the road just before: it gained speed as no such vehicle can.
fn box_jumps(is_large: bool, times: &[f64], speed: &[f64]) -> Vec<Tri> {
    if !is_large {
        return vec![Tri::False; speed.len()];
    }
    let within = |i: usize, time: f64| (0..=i).rev().take_while(move |&j| times[i] - times[j] <= time + 1e-6);
    let gains = |i: usize| within(i, HEAVY_GAIN_S).any(|j| speed[i] - speed[j] > HEAVY_GAIN_MPS);
    let gained: Vec<bool> = (0..speed.len()).map(gains).collect();
    let of = |i: usize| match within(i, JUMPS_AGAIN_S).any(|j| gained[j]) {
        true => Tri::True,
        false if speed[i].is_nan() => Tri::Unknown,
        false => Tri::False,
    };
    (0..speed.len()).map(of).collect()
}

fn was_parked(standing: &Standing, r: usize) -> Tri {
    match standing.last[r] {
        _ if standing.time[r].is_nan() => Tri::Unknown,
        None => Tri::False,
        Some((_, ended, _)) if ended > PARKED_WITHIN_S => Tri::False,
        Some((lasted, _, _)) if lasted >= PARKED_S - 1e-6 => Tri::True,
        // It was stationary when it was first observed: the start is unknown.
        Some((_, _, true)) => Tri::Unknown,
        Some(_) => Tri::False,
    }
}

fn brakes_suddenly(speed: f64, accel: f64) -> Tri {
    if speed < SUDDEN_LEAST_MPS {
        Tri::False
    } else if speed.is_nan() || accel.is_nan() {
        Tri::Unknown
    } else {
        Tri::from(accel <= SUDDEN_MPS2)
    }
}

/// Writes `target.reverses`, `starts`, `time_standing`, `was_parked`, `sudden_brake`, `box_jumps`.
pub fn write(scene: &Interaction<'_>, standing: &[Standing], table: &mut TableBuilder<'_>) {
    let rows = Rows::new(scene.drive, table);
    let targets = scene.targets;
    let mean_accel: Vec<Vec<f64>> =
        targets.iter().map(|t| smooth(&t.times, &t.accel, MEAN_REACH_S)).collect();
    let backwards: Vec<Vec<Tri>> =
        targets.iter().map(|t| reverses(t.track.class.is_vehicle(), &t.times, &t.forward_speed)).collect();
    table.flag(id::TARGET_REVERSES, rows.spread(targets, Tri::Unknown, |k, r, _| backwards[k][r]));
    table.flag(id::TARGET_STARTS, rows.spread(targets, Tri::Unknown, |k, r, _| standing[k].moves_off[r]));
    table.number(id::TARGET_TIME_STANDING, rows.spread(targets, f64::NAN, |k, r, _| standing[k].time[r]));
    table.flag(
        id::TARGET_WAS_PARKED,
        rows.spread(targets, Tri::Unknown, |k, r, _| was_parked(&standing[k], r)),
    );
    let sudden = |k: usize, r: usize| brakes_suddenly(targets[k].speed[r], mean_accel[k][r]);
    table.flag(id::TARGET_SUDDEN_BRAKE, rows.spread(targets, Tri::Unknown, |k, r, _| sudden(k, r)));
    let jumps: Vec<Vec<Tri>> =
        targets.iter().map(|t| box_jumps(t.track.class.is_large_vehicle(), &t.times, &t.speed)).collect();
    table.flag(id::TARGET_BOX_JUMPS, rows.spread(targets, Tri::Unknown, |k, r, _| jumps[k][r]));
}
