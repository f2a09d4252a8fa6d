//! Simulated objects with known truth and noise, made here by plain integration in small steps and not by the models.

use super::*;
use crate::estimate::noise::{self, Noise};
use crate::estimate::simulated::{Truth, correlated, white};

const CAR: MotionModel = MotionModel::Bicycle(Bicycle { rear_to_center_m: 1.3 });

fn rms(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
}

fn speeds(s: &States) -> Vec<f64> {
    s.vx.iter().zip(&s.vy).map(|(x, y)| x.hypot(*y)).collect()
}

fn noise_of(position: f64, over: f64, heading: f64) -> LogNoise {
    LogNoise {
        position: Noise { white: position, correlated: over, negligible: 0.015 },
        heading: Noise { white: heading, correlated: 0.0, negligible: 0.005 },
        velocity: Noise { negligible: 0.05, ..Noise::default() },
    }
}

/// A car that goes, turns left, brakes, stands for 5 s and drives off, seen with white noise of 0.2 m and 2 degrees.
#[test]
fn a_noisy_car_is_near_the_truth_and_its_deviations_say_how_near() {
    let truth = Truth::car(40.0);
    let n = truth.times.len();
    let (ex, ey, eh) = (white(1, n, 0.2), white(2, n, 0.2), white(3, n, 0.035));
    let add = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect::<Vec<_>>();
    let (x, y, heading) = (add(&truth.x, &ex), add(&truth.y, &ey), add(&truth.heading, &eh));
    let rows = Rows { times: &truth.times, x: &x, y: &y, heading: &heading, vx: &[], vy: &[], forward: &[] };
    let s = smooth(rows, CAR, &noise_of(0.2, 0.0, 0.035));
    assert!(
        rms(&s.x, &truth.x) < 0.12 && rms(&s.y, &truth.y) < 0.12,
        "{} {}",
        rms(&s.x, &truth.x),
        rms(&s.y, &truth.y)
    );
    let off = rms(&speeds(&s), &truth.speed);
    assert!(off < 0.3, "speed {off}");
    assert!(rms(&s.accel, &truth.accel) < 0.6, "acceleration {}", rms(&s.accel, &truth.accel));
    let turned: Vec<f64> = s.heading.iter().zip(&truth.heading).map(|(a, b)| wrap(a - b)).collect();
    assert!(rms(&turned, &vec![0.0; n]) < 0.02);
    // The deviations are neither far too small nor far too large.
    let share = speeds(&s)
        .into_iter()
        .zip(&truth.speed)
        .zip(&s.sd.speed)
        .filter(|((a, b), sd)| (*a - **b).abs() < 2.0 * **sd);
    let share = share.count() as f64 / n as f64;
    assert!(share > 0.8, "{share} within two deviations");
    let typical = s.sd.speed.iter().sum::<f64>() / n as f64;
    assert!(typical < 2.0 * off.max(0.05), "{typical} stated, {off} true");
    // It stands where it stands.
    let still = (0..n).filter(|&i| truth.speed[i] == 0.0).collect::<Vec<_>>();
    let found = still.iter().filter(|&&i| speeds(&s)[i] == 0.0).count();
    assert!(still.len() > 40 && found * 10 >= still.len() * 7, "{found} of {}", still.len());
}

#[test]
fn exact_measurements_are_the_estimate() {
    let truth = Truth::car(40.0);
    let rows = Rows {
        times: &truth.times,
        x: &truth.x,
        y: &truth.y,
        heading: &truth.heading,
        vx: &[],
        vy: &[],
        forward: &[],
    };
    let s = smooth(rows, CAR, &noise_of(0.0, 0.0, 0.0));
    assert_eq!(s.x, truth.x);
    assert_eq!(s.y, truth.y);
    assert!(rms(&speeds(&s), &truth.speed) < 0.06, "{}", rms(&speeds(&s), &truth.speed));
    assert!(s.sd.position.iter().chain(&s.sd.heading).all(|d| *d == 0.0));
}

#[test]
fn a_parked_car_stands_whatever_the_noise() {
    let times: Vec<f64> = (0..300).map(|i| f64::from(i) * 0.1).collect();
    for (seed, over) in [(5, false), (6, true), (7, true), (8, true)] {
        let e = |k| if over { correlated(seed + k, 300, 0.2) } else { white(seed + k, 300, 0.2) };
        let (x, y, h) = (e(0), e(10), white(seed + 20, 300, 0.035));
        let rows = Rows { times: &times, x: &x, y: &y, heading: &h, vx: &[], vy: &[], forward: &[] };
        let noise = if over { noise_of(0.0, 0.2, 0.035) } else { noise_of(0.2, 0.0, 0.035) };
        let s = smooth(rows, CAR, &noise);
        let fastest = speeds(&s).into_iter().fold(0.0, f64::max);
        assert!(fastest < 0.3, "seed {seed}: {fastest}");
    }
}

#[test]
fn a_gap_is_bridged_along_the_curve() {
    let truth = Truth::car(40.0);
    let n = truth.times.len();
    let hole = 150..160;
    let cut = |v: &[f64]| (0..n).map(|i| if hole.contains(&i) { f64::NAN } else { v[i] }).collect::<Vec<_>>();
    let (x, y, heading) = (cut(&truth.x), cut(&truth.y), cut(&truth.heading));
    let rows = Rows { times: &truth.times, x: &x, y: &y, heading: &heading, vx: &[], vy: &[], forward: &[] };
    let s = smooth(rows, CAR, &noise_of(0.0, 0.0, 0.0));
    for i in hole {
        let off = (s.x[i] - truth.x[i]).hypot(s.y[i] - truth.y[i]);
        assert!(off < 0.25 && s.sd.position[i] > 0.0, "row {i}: {off}");
    }
}

#[test]
fn a_walker_is_smoothed_without_a_heading() {
    let times: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.1).collect();
    let line: Vec<f64> = times.iter().map(|t| 1.4 * t).collect();
    let (ex, ey) = (white(31, 200, 0.2), white(32, 200, 0.2));
    let x: Vec<f64> = line.iter().zip(&ex).map(|(a, b)| a + b).collect();
    let heading = vec![f64::NAN; 200];
    let rows = Rows { times: &times, x: &x, y: &ey, heading: &heading, vx: &[], vy: &[], forward: &[] };
    let s = smooth(rows, MotionModel::ConstantVelocity, &noise_of(0.2, 0.0, 0.0));
    assert!(rms(&s.vx, &vec![1.4; 200]) < 0.2, "{}", rms(&s.vx, &vec![1.4; 200]));
    assert!(s.heading.iter().all(|h| h.is_nan()), "unknown stays unknown");
}

/// The noise that was added is the noise that is found.
#[test]
fn noise_is_found_from_residuals() {
    let truth = Truth::car(40.0);
    let n = truth.times.len();
    for over in [false, true] {
        let e = |seed| if over { correlated(seed, n, 0.2) } else { white(seed, n, 0.2) };
        let noisy: Vec<(Vec<f64>, Vec<f64>, Vec<f64>)> = (0..8)
            .map(|k| {
                let (ex, ey, eh) = (e(3 * k + 1), e(3 * k + 2), white(3 * k + 50, n, 0.035));
                let add = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect::<Vec<_>>();
                (add(&truth.x, &ex), add(&truth.y, &ey), add(&truth.heading, &eh))
            })
            .collect();
        let rows = noisy.iter().map(|(x, y, heading)| Rows {
            times: &truth.times,
            x,
            y,
            heading,
            vx: &[],
            vy: &[],
            forward: &[],
        });
        let found = noise::estimate(rows);
        let (white, correlated) = if over { (0.0, 0.2) } else { (0.2, 0.0) };
        assert!((found.position.white - white).abs() < 0.04, "{over}: {:?}", found.position);
        assert!((found.position.correlated - correlated).abs() < 0.06, "{over}: {:?}", found.position);
        assert!((found.heading.white - 0.035).abs() < 0.006, "{:?}", found.heading);
        assert_eq!(found.velocity.deviation(), 0.0, "no velocities");
    }
    let exact = [0; 4].map(|_| Rows {
        times: &truth.times,
        x: &truth.x,
        y: &truth.y,
        heading: &truth.heading,
        vx: &[],
        vy: &[],
        forward: &[],
    });
    let found = noise::estimate(exact.iter().copied());
    assert!(found.position.is_negligible() && found.heading.is_negligible(), "{found:?}");
}

/// The corner of a road drawn without a bend: 87 degrees in 0.4 s at 8 m/s, which no vehicle drives. By the model it is
/// impossible; behind it the estimate has to be where the car is, and before it nothing is to swing.
#[test]
fn a_drawn_corner_does_not_lead_the_estimate_astray() {
    let (n, speed, corner) = (150, 8.0, 50);
    let times: Vec<f64> = (0..n).map(|i| i as f64 * 0.1).collect();
    let heading: Vec<f64> =
        (0..n).map(|i| 87f64.to_radians() * ((i as f64 - 50.0) / 4.0).clamp(0.0, 1.0)).collect();
    let (mut x, mut y) = (vec![0.0], vec![0.0]);
    for i in 1..n {
        x.push(x[i - 1] + 0.1 * speed * heading[i].cos());
        y.push(y[i - 1] + 0.1 * speed * heading[i].sin());
    }
    let noisy =
        |a: &[f64], seed| a.iter().zip(white(seed, n, 0.08)).map(|(a, b)| a + b).collect::<Vec<f64>>();
    let (seen_x, seen_y) = (noisy(&x, 1), noisy(&y, 2));
    let forward = noisy(&vec![speed; n], 3);
    let rows = Rows {
        times: &times,
        x: &seen_x,
        y: &seen_y,
        heading: &heading,
        vx: &[],
        vy: &[],
        forward: &forward,
    };
    let noise = LogNoise { velocity: Noise { white: 0.15, ..Noise::default() }, ..noise_of(0.08, 0.0, 0.0) };
    let s = smooth(rows, CAR, &noise);
    for i in (0..corner - 5).chain(corner + 15..n) {
        let off = (s.x[i] - x[i]).hypot(s.y[i] - y[i]);
        assert!(off < 0.5, "{off} m off at {} s", times[i]);
        assert!((speeds(&s)[i] - speed).abs() < 1.0, "{} m/s at {} s", speeds(&s)[i], times[i]);
    }
}
