//! Expected values are computed by hand from the motions.

use super::*;
use std::f64::consts::FRAC_PI_2;
use whyroad_model::Nanos;
use whyroad_model::scene::{DriveMeta, Ego, FrameOfReference, Track};

/// 20 frames at 10 Hz.
fn times() -> Vec<f64> {
    (0..20).map(|i| f64::from(i) / 10.0).collect()
}

fn drive(ego: Motion, tracks: Vec<Track>) -> Drive {
    Drive {
        times: times().into_iter().map(Nanos::from_secs_f64).collect(),
        ego: Some(Ego { motion: ego, length_m: 4.8, ..Ego::default() }),
        tracks,
        ..Drive::default()
    }
}

fn along(x: impl Fn(f64) -> f64) -> Motion {
    let n = times().len();
    let x = times().into_iter().map(x).collect();
    Motion { x, y: vec![0.0; n], heading: vec![0.0; n], ..Motion::unknown(n) }
}

fn track(id: &str, class: ObjectClass, motion: Motion) -> Track {
    let n = motion.len();
    Track {
        id: id.into(),
        class,
        frames: (0..n as u32).collect(),
        length_m: vec![4.5; n],
        width_m: vec![1.8; n],
        height_m: vec![1.5; n],
        interior_points: vec![f64::NAN; n],
        motion,
        ..Track::default()
    }
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-6
}

#[test]
fn positions_give_velocity_and_acceleration() {
    let braking = |t: f64| 10.0 * t - t * t;
    let log = drive(along(braking), vec![track("a", ObjectClass::Car, along(|t| 20.0 + braking(t)))]);
    let full = estimate(&log);
    for m in [&full.ego.as_ref().unwrap().motion, &full.tracks[0].motion] {
        assert!(close(m.vx[19], 10.0 - 2.0 * 1.9) && close(m.accel[0], -2.0) && close(m.yaw_rate[5], 0.0));
    }
    assert!(log.tracks[0].motion.vx[0].is_nan(), "the log stays as it is");
}

#[test]
fn what_the_log_states_stays_and_what_it_does_not_is_completed_row_by_row() {
    let n = times().len();
    // The log's velocity is 1 % low, and unknown in the last row.
    let mut vx = vec![9.9; n];
    vx[n - 1] = f64::NAN;
    let stated = Motion { vx, vy: vec![0.0; n], yaw_rate: vec![0.2; n], ..along(|t| 10.0 * t) };
    let full = estimate(&drive(stated, vec![])).into_owned().ego.unwrap().motion;
    assert!(full.vx[..n - 1].iter().all(|v| *v == 9.9) && close(full.vx[n - 1], 10.0));
    assert!(full.yaw_rate.iter().all(|w| *w == 0.2));
    assert!(close(full.accel[5], 0.0));
}

#[test]
fn a_speed_along_the_heading_is_kept_and_the_positions_add_what_goes_sideways() {
    let n = times().len();
    // Northwards at 10 m/s in the log, 9.8 m/s by the positions, drifting 0.5 m/s to the right (east).
    let moving = Motion {
        x: times().iter().map(|t| 0.5 * t).collect(),
        y: times().iter().map(|t| 9.8 * t).collect(),
        heading: vec![FRAC_PI_2; n],
        forward: vec![10.0; n],
        ..Motion::unknown(n)
    };
    let full = estimate(&drive(moving.clone(), vec![])).into_owned().ego.unwrap().motion;
    assert!(close(full.vx[10], 0.5) && close(full.vy[10], 10.0) && close(full.accel[10], 0.0));
    // A single row does not show lateral motion.
    let once = track("a", ObjectClass::Car, moving.rows(0, 1));
    let full = estimate(&drive(moving, vec![once])).into_owned().tracks.remove(0).motion;
    assert!(close(full.vy[0], 10.0) && close(full.vx[0], 0.0));
}

#[test]
fn speeds_that_cannot_be_are_unknown() {
    let sprint = |t: f64| 16.7 * t;
    let of = |class| estimate(&drive(along(sprint), vec![track("a", class, along(sprint))])).into_owned();
    assert!(of(ObjectClass::Pedestrian).tracks[0].motion.vx.iter().all(|v| v.is_nan()));
    assert!(of(ObjectClass::Car).tracks[0].motion.vx.iter().all(|v| close(*v, 16.7)));
}

#[test]
fn a_sideways_jump_is_no_motion() {
    // A simulator moves a car to the next lane, 3.2 m to the side, from one frame to the next.
    let motion =
        Motion { y: (0..20).map(|i| if i < 10 { 0.0 } else { 3.2 }).collect(), ..along(|t| 10.0 * t) };
    let full = estimate(&drive(motion, vec![])).into_owned().ego.unwrap().motion;
    assert!(full.vy.iter().all(|v| close(*v, 0.0)), "{:?}", full.vy);
}

#[test]
fn nothing_is_estimated_relative_to_a_moving_ego() {
    let mut log = drive(along(|t| 10.0 * t), vec![track("a", ObjectClass::Car, along(|_| 12.0))]);
    log.meta = DriveMeta { frame_of_reference: FrameOfReference::Ego, ..DriveMeta::default() };
    assert!(estimate(&log).tracks[0].motion.vx[3].is_nan());
}

#[test]
fn a_cut_drive_is_estimated_from_itself_alone() {
    // Equal for a second, then one brakes.
    let steady = drive(along(|t| 10.0 * t), vec![]);
    let brakes = drive(along(|t| 10.0 * t - if t > 1.0 { 4.0 * (t - 1.0).powi(2) } else { 0.0 }), vec![]);
    let seen = |d: &Drive| format!("{:?}", estimate(&d.until_frame(11)).ego);
    assert_eq!(seen(&steady), seen(&brakes));
}

#[test]
fn what_was_cut_between_two_measurements_is_predicted_until_the_next_is_due() {
    // Measured every half second and interpolated in between: 10 m/s, the object 20 m ahead.
    let known_at: Vec<Nanos> = (0..20_i64).map(|i| Nanos((i + 4) / 5 * 500_000_000)).collect();
    let mut object = track("a", ObjectClass::Car, along(|t| 20.0 + 10.0 * t));
    object.known_at = known_at.clone();
    let mut log = drive(along(|t| 10.0 * t), vec![object]);
    log.ego.as_mut().unwrap().known_at = known_at;
    let cut = log.until_frame(9);
    assert_eq!((cut.tracks[0].frames.len(), cut.ego.as_ref().unwrap().motion.x[8].is_nan()), (6, true));
    let full = estimate(&cut).into_owned();
    let (ego, a) = (&full.ego.unwrap().motion, &full.tracks[0]);
    assert!(close(ego.x[8], 8.0) && close(ego.vx[8], 10.0));
    assert_eq!((a.frames.len(), a.length_m.len(), a.motion.len()), (9, 9, 9));
    assert!(close(a.motion.x[8], 28.0));
}
