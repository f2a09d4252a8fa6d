//! Whole drives: a car with the motion of `simulated`, observed by a stationary one.

use super::*;
use crate::estimate::simulated::{Truth, white};
use crate::geometry::wrap;
use whyroad_model::{Nanos, TrackId};

/// The car of the truth under `id`, rows `range`, with noise of these sizes.
fn seen(truth: &Truth, id: &str, range: std::ops::Range<usize>, place: f64, turn: f64) -> Track {
    let n = truth.times.len();
    let noisy = |v: &[f64], seed, sd| {
        let e = white(seed, n, sd);
        range.clone().map(|i| v[i] + e[i]).collect::<Vec<_>>()
    };
    let m = range.len();
    Track {
        id: id.into(),
        class: ObjectClass::Car,
        frames: range.clone().map(|i| i as u32).collect(),
        motion: Motion {
            x: noisy(&truth.x, 11, place),
            y: noisy(&truth.y, 12, place),
            z: vec![0.0; m],
            heading: noisy(&truth.heading, 13, turn),
            ..Motion::unknown(m)
        },
        length_m: vec![4.8; m],
        width_m: vec![1.8; m],
        height_m: vec![1.5; m],
        interior_points: vec![f64::NAN; m],
        ..Track::default()
    }
}

fn drive(truth: &Truth, tracks: Vec<Track>) -> Drive {
    let n = truth.times.len();
    let motion = Motion {
        x: vec![-30.0; n],
        y: vec![-8.0; n],
        z: vec![0.0; n],
        heading: vec![0.0; n],
        ..Motion::unknown(n)
    };
    Drive {
        times: truth.times.iter().map(|t| Nanos::from_secs_f64(*t)).collect(),
        ego: Some(Ego { motion, length_m: 4.5, width_m: 1.8, ..Ego::default() }),
        tracks,
        ..Drive::default()
    }
}

fn off(track: &Track, truth: &Truth, frame: usize) -> f64 {
    let row = track.row_at(frame).unwrap();
    (track.motion.x[row] - truth.x[frame]).hypot(track.motion.y[row] - truth.y[frame])
}

#[test]
fn signals_of_a_noisy_log_have_deviations_and_those_of_an_exact_one_have_none() {
    let truth = Truth::car(40.0);
    let n = truth.times.len();
    let exact = crate::derive(&drive(&truth, vec![seen(&truth, "a", 0..n, 0.0, 0.0)]));
    let deviations = |t: &SignalTable| t.target_columns.keys().filter(|k| k.ends_with(".sd")).count();
    assert_eq!(deviations(&exact), 0);
    let noisy = crate::derive(&drive(&truth, vec![seen(&truth, "a", 0..n, 0.2, 0.035)]));
    assert!(deviations(&noisy) > 3);
    let column = |name: &str, row| noisy.target_columns[name].number(row).unwrap();
    // At 8 s it drives at 12 m/s; at 20 s it is stationary.
    assert!((column("target.speed", 80) - 12.0).abs() < 4.0 * column("target.speed.sd", 80));
    assert!(column("target.speed", 200) == 0.0 && column("target.speed.sd", 200) < 0.1);
    assert!(
        noisy.frame_columns.keys().all(|k| !k.starts_with("ego.") || !k.ends_with(".sd")),
        "the ego is exact"
    );
}

#[test]
fn lost_rows_are_bridged_and_marked() {
    let truth = Truth::car(40.0);
    let n = truth.times.len();
    let mut lossy = seen(&truth, "a", 0..n, 0.0, 0.0);
    let kept: Vec<usize> = (0..n).filter(|i| !(60..65).contains(i) && !(300..330).contains(i)).collect();
    lossy.frames = kept.iter().map(|&i| i as u32).collect();
    let whole = lossy.motion.clone();
    for (to, from) in [
        (&mut lossy.motion.x, &whole.x),
        (&mut lossy.motion.y, &whole.y),
        (&mut lossy.motion.z, &whole.z),
        (&mut lossy.motion.heading, &whole.heading),
        (&mut lossy.motion.vx, &whole.vx),
        (&mut lossy.motion.vy, &whole.vy),
        (&mut lossy.motion.accel, &whole.accel),
        (&mut lossy.motion.yaw_rate, &whole.yaw_rate),
    ] {
        *to = kept.iter().map(|&i| from[i]).collect();
    }
    for column in [&mut lossy.length_m, &mut lossy.width_m, &mut lossy.height_m, &mut lossy.interior_points] {
        column.truncate(kept.len());
    }
    let log = drive(&truth, vec![lossy]);
    let found = estimated(&log);
    assert_eq!(found.bridged[0], [60, 61, 62, 63, 64]);
    let track = &found.drive.tracks[0];
    assert!((60..65).all(|f| off(track, &truth, f) < 0.1), "on the bend");
    assert!(off(track, &truth, 100) == 0.0, "what was measured exactly stays");
    assert!(track.row_at(310).is_none(), "three seconds are not bridged");
    let table = crate::derive(&log);
    let observed = |f: usize| table.target_columns["target.observed"].flag(table.targets[0].row(f).unwrap());
    assert!(observed(59).is_true() && observed(62) == Tri::False && observed(310) == Tri::False);
    assert!(table.target_columns["target.speed"].is_known(62));
}

#[test]
fn a_broken_id_keeps_its_first_name() {
    let truth = Truth::car(40.0);
    let n = truth.times.len();
    let log = drive(
        &truth,
        vec![
            seen(&truth, "a", 0..70, 0.2, 0.035),
            seen(&truth, "b", 73..180, 0.2, 0.035),
            seen(&truth, "c", 182..n, 0.2, 0.035),
        ],
    );
    let found = estimated(&log);
    assert_eq!(found.drive.tracks.len(), 1);
    let first = TrackId::from("a");
    assert_eq!(found.joined.values().collect::<Vec<_>>(), [&first, &first]);
    let track = &found.drive.tracks[0];
    assert_eq!(track.frames, (0..n as u32).collect::<Vec<_>>());
    assert_eq!(found.bridged[0], [70, 71, 72, 180, 181]);
    assert!(off(track, &truth, 71) < 0.5);
}

#[test]
fn rows_between_samples_are_no_measurements() {
    // 2 Hz: the bend is cut at the corners by interpolation, and found by the estimator.
    let truth = Truth::car(40.0);
    let n = truth.times.len();
    let mut slow = seen(&truth, "a", 0..n, 0.0, 0.0);
    let at = |i: usize| Nanos::from_secs_f64(truth.times[i]);
    for i in 0..n {
        let (a, b) = (i / 5 * 5, (i.div_ceil(5) * 5).min(n - 1));
        let share = if b > a { (i - a) as f64 / (b - a) as f64 } else { 0.0 };
        for (column, from) in [(&mut slow.motion.x, &truth.x), (&mut slow.motion.y, &truth.y)] {
            column[i] = from[a] + share * (from[b] - from[a]);
        }
        slow.motion.heading[i] = truth.heading[a] + share * wrap(truth.heading[b] - truth.heading[a]);
        slow.known_at.push(at(b));
    }
    let interpolated = slow.clone();
    let log = drive(&truth, vec![slow]);
    let found = estimated(&log);
    let track = &found.drive.tracks[0];
    let worst = |t: &Track| (60..80).map(|f| off(t, &truth, f)).fold(0.0, f64::max);
    assert!(worst(track) < worst(&interpolated).min(0.05), "{} of {}", worst(track), worst(&interpolated));
    let speed = track.motion.speed(140);
    assert!((speed - truth.speed[140]).abs() < 0.3, "{speed} of {}", truth.speed[140]);
}

/// A camera as the ego's pose, turned by 0.0155 rad against the car (comma2k19), 28 m/s along x, one row each 0.1 s, of
/// which the last rests on a later measurement. By hand: it goes on from the row before, at 2.8 m per row.
#[test]
fn a_row_that_is_not_known_yet_goes_on_from_the_last_one() {
    let n = 31;
    let nan_at_end = |f: &dyn Fn(usize) -> f64| -> Vec<f64> {
        (0..n).map(|i| if i + 1 < n { f(i) } else { f64::NAN }).collect()
    };
    let motion = Motion {
        x: nan_at_end(&|i| 2.8 * i as f64),
        y: nan_at_end(&|_| 0.0),
        z: nan_at_end(&|_| 1.5),
        heading: nan_at_end(&|_| 0.0155),
        ..Motion::unknown(n)
    };
    let drive = Drive {
        times: (0..n).map(|i| Nanos(i as i64 * 100_000_000)).collect(),
        ego: Some(Ego { motion, length_m: 4.5, width_m: 1.8, ..Ego::default() }),
        ..Drive::default()
    };
    let ego = crate::estimate::estimate(&drive).ego.as_ref().unwrap().motion.clone();
    let last = n - 1;
    assert!((ego.x[last] - 2.8 * last as f64).abs() < 0.01, "{}", ego.x[last]);
    assert!((ego.heading[last] - 0.0155).abs() < 1e-6 && ego.y[last].abs() < 0.01, "{}", ego.heading[last]);
    assert_eq!(ego.z[last], 1.5);
}

/// A log whose rows are 0.1 s apart by their times and now and then 0.12 s apart by their poses, as ego poses of
/// nuScenes in ScenarioNet pickles are, with the velocities that follow from both. By hand: 8 m/s, slowing by 0.5
/// m/s2; a row that is 0.02 s late reads 1.6 m/s too fast. Cut at each such row, as for Stage I.
#[test]
fn a_row_of_another_time_is_no_burst_of_speed() {
    let late = [17, 26, 50, 54];
    for n in late.map(|row: usize| row + 1) {
        let at = |i: usize| 0.1 * i as f64 + 0.02 * late.iter().filter(|row| **row <= i).count() as f64;
        let x: Vec<f64> = (0..n).map(|i| 8.0 * at(i) - 0.25 * at(i).powi(2)).collect();
        let vx: Vec<f64> = (0..n).map(|i| (x[i.max(1)] - x[i.max(1) - 1]) / 0.1).collect();
        let zero = vec![0.0; n];
        let motion = Motion {
            x,
            vx,
            vy: zero.clone(),
            y: zero.clone(),
            z: zero.clone(),
            heading: zero,
            ..Motion::unknown(n)
        };
        let drive = Drive {
            times: (0..n).map(|i| Nanos(i as i64 * 100_000_000)).collect(),
            ego: Some(Ego { motion, length_m: 4.5, width_m: 1.8, ..Ego::default() }),
            ..Drive::default()
        };
        let found = estimated(&drive);
        let ego = &found.drive.ego.as_ref().unwrap().motion;
        for i in 0..n {
            let speed = 8.0 - 0.5 * at(i);
            assert!((ego.vx[i] - speed).abs() < 0.5, "row {i} of {n}: {} m/s, not {speed}", ego.vx[i]);
            assert!(ego.accel[i].abs() < 3.0, "row {i} of {n}: {} m/s2", ego.accel[i]);
        }
        assert!(found.ego.is_some(), "what was smoothed has deviations");
    }
}
