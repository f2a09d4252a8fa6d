//! What a target does by itself along its own way: reversing, standing, moving off, braking.

use crate::behavior::stops::Standing;
use crate::series::smooth;
use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use crate::target::rows::Rows;
use whyroad_model::Tri;
use whyroad_model::catalogue::id;

/// Below this forward speed a vehicle reverses, m/s (as `ego.meta_longitudinal`).
const REVERSE_MPS: f64 = -0.3;
/// A stand of at least this long is parking or waiting, s.
const PARKED_S: f64 = 5.0;
/// ... and counts for this long after its end, s.
const PARKED_WITHIN_S: f64 = 10.0;
/// Braking from this on is sudden, m/s2.
const SUDDEN_MPS2: f64 = -4.0;
/// Minimum speed for sudden braking, m/s.
const SUDDEN_LEAST_MPS: f64 = 1.0;
/// Half width of the mean over the acceleration, s.
const MEAN_REACH_S: f64 = 0.2;

fn reverses(is_vehicle: bool, forward_speed: f64) -> Tri {
    if !is_vehicle {
        Tri::False
    } else if forward_speed.is_nan() {
        Tri::Unknown
    } else {
        Tri::from(forward_speed < REVERSE_MPS)
    }
}

fn was_parked(standing: &Standing, r: usize) -> Tri {
    match standing.last[r] {
        _ if standing.time[r].is_nan() => Tri::Unknown,
        None => Tri::False,
        Some((_, ended, _)) if ended > PARKED_WITHIN_S => Tri::False,
        Some((lasted, _, _)) if lasted >= PARKED_S - 1e-6 => Tri::True,
        // It stood when it was first seen: the start is unknown.
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

/// Writes `target.reverses`, `starts`, `time_standing`, `was_parked`, `sudden_brake`.
pub fn write(scene: &Interaction<'_>, standing: &[Standing], table: &mut TableBuilder<'_>) {
    let rows = Rows::new(scene.drive, table);
    let targets = scene.targets;
    let mean_accel: Vec<Vec<f64>> = targets
        .iter()
        .map(|t| {
            let times: Vec<f64> = t.track.frames.iter().map(|&f| scene.times[f as usize]).collect();
            smooth(&times, &t.accel, MEAN_REACH_S)
        })
        .collect();
    table.flag(
        id::TARGET_REVERSES,
        rows.flags(|t, r| reverses(t.class.is_vehicle(), t.motion.forward_speed(r))),
    );
    table.flag(id::TARGET_STARTS, rows.spread(targets, Tri::Unknown, |k, r, _| standing[k].moves_off[r]));
    table.number(id::TARGET_TIME_STANDING, rows.spread(targets, f64::NAN, |k, r, _| standing[k].time[r]));
    table.flag(
        id::TARGET_WAS_PARKED,
        rows.spread(targets, Tri::Unknown, |k, r, _| was_parked(&standing[k], r)),
    );
    let sudden = |k: usize, r: usize| brakes_suddenly(targets[k].track.motion.speed(r), mean_accel[k][r]);
    table.flag(id::TARGET_SUDDEN_BRAKE, rows.spread(targets, Tri::Unknown, |k, r, _| sudden(k, r)));
}
