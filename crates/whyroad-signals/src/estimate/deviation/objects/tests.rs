//! Two cars with known paths and noise of known size: the errors of the signals of pairs must match the standard
//! deviations. Expected values are geometry.

use crate::estimate::simulated::{Truth, white};
use crate::geometry::wrap;
use crate::{Objects, WithPairs, derive_objects};
use whyroad_model::scene::{Ego, Motion, Track};
use whyroad_model::{Drive, Nanos, ObjectClass, SignalTable};

/// Position of the stationary ego: m, m, rad.
const BESIDE: (f64, f64, f64) = (30.0, -10.0, 0.0);

/// A car with the motion `truth`, measured with noise of these sizes, and an exact stationary ego.
fn drive(truth: &Truth, ego: (f64, f64, f64), place: f64, turn: f64) -> Drive {
    let n = truth.times.len();
    let noisy =
        |v: &[f64], seed, sd| -> Vec<f64> { v.iter().zip(white(seed, n, sd)).map(|(v, e)| v + e).collect() };
    let motion = Motion {
        x: noisy(&truth.x, 1, place),
        y: noisy(&truth.y, 2, place),
        z: vec![0.0; n],
        heading: noisy(&truth.heading, 3, turn),
        ..Motion::unknown(n)
    };
    let still = Motion {
        x: vec![ego.0; n],
        y: vec![ego.1; n],
        z: vec![0.0; n],
        heading: vec![ego.2; n],
        ..Motion::unknown(n)
    };
    let same = |v: f64| vec![v; n];
    let car = Track {
        id: "a".into(),
        class: ObjectClass::Car,
        frames: (0..n as u32).collect(),
        motion,
        length_m: same(4.8),
        width_m: same(1.8),
        height_m: same(1.5),
        interior_points: same(f64::NAN),
        ..Track::default()
    };
    Drive {
        times: truth.times.iter().map(|t| Nanos::from_secs_f64(*t)).collect(),
        ego: Some(Ego { motion: still, length_m: 4.5, width_m: 1.8, ..Ego::default() }),
        tracks: vec![car],
        ..Drive::default()
    }
}

fn table(drive: &Drive) -> SignalTable {
    let names =
        ["object.speed", "pair.forward", "pair.lateral", "pair.bearing", "pair.closing", "pair.ttc_box"];
    derive_objects(drive, &names.map(str::to_owned).into(), Objects::WithEgo, WithPairs::Yes)
}

#[test]
fn errors_are_of_the_size_that_the_deviations_say() {
    let truth = Truth::car(40.0);
    let noisy = table(&drive(&truth, BESIDE, 0.2, 0.035));
    let pairs = noisy.pairs.as_ref().unwrap();
    // The car is the first object, the ego the second.
    let span = &pairs.spans[pairs.find(0, 1).unwrap()];
    let expected = |frame: usize| {
        let (dx, dy) = (BESIDE.0 - truth.x[frame], BESIDE.1 - truth.y[frame]);
        let (sin, cos) = truth.heading[frame].sin_cos();
        (dx * cos + dy * sin, dy * cos - dx * sin)
    };
    let (mut forward, mut lateral, mut bearing) = (Vec::new(), Vec::new(), Vec::new());
    for (row, frame) in span.rows().zip(span.frames.start..).filter(|(row, _)| pairs.near[*row]) {
        let at = |name: &str| pairs.columns[name].number(row).unwrap();
        let (x, y) = expected(frame);
        forward.push((at("pair.forward") - x, at("pair.forward.sd")));
        lateral.push((at("pair.lateral") - y, at("pair.lateral.sd")));
        bearing.push((wrap(at("pair.bearing") - y.atan2(x)), at("pair.bearing.sd")));
        assert!(at("pair.closing.sd") > 0.0);
    }
    assert!(forward.len() > 30, "near each other for more than three seconds");
    for (name, errors) in [("forward", forward), ("lateral", lateral), ("bearing", bearing)] {
        let within = errors.iter().filter(|(e, sd)| e.abs() <= 3.0 * sd).count();
        assert!(within * 100 >= errors.len() * 95, "{name}: {within} of {}", errors.len());
        let mean = |f: fn(&(f64, f64)) -> f64| errors.iter().map(f).sum::<f64>() / errors.len() as f64;
        let (error, sd) = (mean(|(e, _)| e * e).sqrt(), mean(|(_, sd)| sd * sd).sqrt());
        assert!(sd < 4.0 * error, "{name}: stated {sd:.3}, found {error:.3}");
    }
    // At 8 s it goes 12 m/s.
    let speed = |name: &str| noisy.target_columns[name].number(80).unwrap();
    assert!((speed("object.speed") - 12.0).abs() < 4.0 * speed("object.speed.sd"));
    let of_ego = noisy.targets[1].first_row;
    assert_eq!(noisy.target_columns["object.speed.sd"].number(of_ego), Some(0.0), "the ego is exact");
}

#[test]
fn the_time_to_a_collision_is_as_uncertain_as_it_says() {
    let truth = Truth::car(40.0);
    // 55 m straight ahead of the car's start, in its direction: it drives at 12 m/s there.
    let ego = (truth.x[0] + 55.0 * 0.4f64.cos(), truth.y[0] + 55.0 * 0.4f64.sin(), 0.4);
    let noisy = table(&drive(&truth, ego, 0.2, 0.035));
    let pairs = noisy.pairs.as_ref().unwrap();
    let span = &pairs.spans[pairs.find(0, 1).unwrap()];
    let mut known = 0;
    for (row, frame) in span.rows().zip(span.frames.start..).filter(|(_, f)| (10..35).contains(f)) {
        let at = |name: &str| pairs.columns[name].number(row).unwrap();
        let away = (ego.0 - truth.x[frame]).hypot(ego.1 - truth.y[frame]);
        // Bumper to bumper.
        let expected = (away - 0.5 * (4.8 + 4.5)) / 12.0;
        let (ttc, sd) = (at("pair.ttc_box"), at("pair.ttc_box.sd"));
        assert!(sd > 0.0 && sd < 0.5 && (ttc - expected).abs() < 4.0 * sd, "{frame}: {ttc} {sd} {expected}");
        known += 1;
    }
    assert_eq!(known, 25);
}

#[test]
fn exact_logs_have_none() {
    let truth = Truth::car(40.0);
    let exact = table(&drive(&truth, BESIDE, 0.0, 0.0));
    let names = exact.target_columns.keys().chain(exact.pairs.as_ref().unwrap().columns.keys());
    assert!(names.into_iter().all(|name| !name.ends_with(".sd")));
}
