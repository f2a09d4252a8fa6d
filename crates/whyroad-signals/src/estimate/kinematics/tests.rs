//! Expected values are the analytic derivatives of the motions.

use super::*;
use std::f64::consts::PI;

/// Frame times with the jitter of a real log: 0.100196 s on average, one pair 1 ns closer.
fn jittered(n: usize) -> Vec<f64> {
    (0..n).map(|i| i as f64 * 0.100_196 + [0.0, 0.003, -0.0036, 1e-9][i % 4]).collect()
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

fn sample(t: &[f64], f: impl Fn(f64) -> f64) -> Vec<f64> {
    t.iter().map(|&t| f(t)).collect()
}

#[test]
fn constant_velocity_is_exact_in_a_city_frame() {
    let t = jittered(30);
    let d = derive(
        &t,
        &sample(&t, |t| 5280.0 + 7.0 * t),
        &sample(&t, |t| 2350.0 - 3.0 * t),
        &vec![0.0; 30],
        |_| false,
    );
    for i in 0..30 {
        assert!(close(d.vx[i], 7.0, 1e-7) && close(d.vy[i], -3.0, 1e-7), "row {i}: {} {}", d.vx[i], d.vy[i]);
        assert!(close(d.accel[i], 0.0, 1e-5) && close(d.yaw_rate[i], 0.0, 1e-12), "row {i}: {}", d.accel[i]);
    }
}

#[test]
fn constant_acceleration_is_exact_to_the_ends_and_not_late() {
    let t = jittered(20);
    // 10 m/s, braking with 3 m/s2 along x; the heading is x.
    let d = derive(&t, &sample(&t, |t| 10.0 * t - 1.5 * t * t), &[0.0; 20], &[0.0; 20], |_| false);
    for (i, t) in t.iter().enumerate() {
        assert!(close(d.vx[i], 10.0 - 3.0 * t, 1e-9), "row {i}");
        assert!(close(d.accel[i], -3.0, 1e-9), "row {i}");
    }
    // The same in reverse (heading reversed): braking is an acceleration along the heading.
    let back = derive(&t, &sample(&t, |t| 10.0 * t - 1.5 * t * t), &[0.0; 20], &[PI; 20], |_| false);
    assert!(close(back.accel[7], 3.0, 1e-9));
}

#[test]
fn a_circle_has_its_speed_its_yaw_rate_and_no_acceleration_along_the_heading() {
    // Radius 20 m at 8 m/s: 0.4 rad/s; 80 frames pass the heading through +-pi.
    let (r, v) = (20.0, 8.0);
    let w = v / r;
    let t = jittered(80);
    let heading = sample(&t, |t| wrap(w * t + FRAC_PI_2 + 0.5));
    assert!(heading.windows(2).any(|h| h[1] - h[0] < -PI), "the test must cross the wrap");
    let d = derive(
        &t,
        &sample(&t, |t| r * (w * t + 0.5).cos()),
        &sample(&t, |t| r * (w * t + 0.5).sin()),
        &heading,
        |_| false,
    );
    for i in 0..80 {
        // Third derivative v w^2 = 1.28 m/s3 is what a parabola misses: v error < 1.28 * 0.3^2 / 6 inside, more at the
        // ends.
        let tolerance = if (2..78).contains(&i) { 0.03 } else { 0.06 };
        assert!(close(d.vx[i].hypot(d.vy[i]), v, tolerance), "row {i}: {}", d.vx[i].hypot(d.vy[i]));
        assert!(close(d.yaw_rate[i], w, 1e-9), "row {i}: {}", d.yaw_rate[i]);
        let along = if (3..77).contains(&i) { 0.01 } else { 0.45 };
        assert!(close(d.accel[i], 0.0, along), "row {i}: {}", d.accel[i]);
    }
}

#[test]
fn nothing_is_derived_across_a_gap_or_a_break() {
    // 10 m/s, unobserved for 1 s, then stationary 50 m farther: the jump of 50 m must not become a speed.
    let t: Vec<f64> = (0..10).chain(20..30).map(|i| f64::from(i) * 0.1).collect();
    let x: Vec<f64> = (0..20).map(|i| if i < 10 { f64::from(i) } else { 60.0 }).collect();
    let d = derive(&t, &x, &[0.0; 20], &[0.0; 20], |_| false);
    assert!((0..10).all(|i| close(d.vx[i], 10.0, 1e-9)) && (10..20).all(|i| close(d.vx[i], 0.0, 1e-9)));

    let steady: Vec<f64> = (0..20).map(|i| f64::from(i) * 0.1).collect();
    let d = derive(&steady, &x, &[0.0; 20], &[0.0; 20], |i| i == 10);
    assert!((0..10).all(|i| close(d.vx[i], 10.0, 1e-9)) && (10..20).all(|i| close(d.vx[i], 0.0, 1e-9)));
}

#[test]
fn too_few_rows_are_unknown_and_unknown_rows_stay_unknown() {
    let d = derive(&[0.0], &[1.0], &[1.0], &[0.0], |_| false);
    assert!(d.vx[0].is_nan() && d.accel[0].is_nan() && d.yaw_rate[0].is_nan());
    let d = derive(&[0.0, 0.1], &[0.0, 0.5], &[0.0; 2], &[0.0; 2], |_| false);
    assert!(close(d.vx[0], 5.0, 1e-12) && d.accel[0].is_nan());
    let d = derive(&[0.0, 0.1, 0.2, 0.3], &[0.0, f64::NAN, 2.0, 3.0], &[0.0; 4], &[0.0; 4], |_| false);
    assert!(d.vx[1].is_nan() && close(d.vx[3], 10.0, 1e-9));
}

#[test]
fn a_heading_that_flips_is_not_a_turn() {
    // Parked; the annotator swapped front and rear at row 5.
    let t: Vec<f64> = (0..10).map(|i| f64::from(i) * 0.1).collect();
    let heading: Vec<f64> = (0..10).map(|i| if i < 5 { 0.1 } else { 0.1 - PI }).collect();
    let d = derive(&t, &[0.0; 10], &[0.0; 10], &heading, |_| false);
    assert!(d.yaw_rate.iter().all(|w| close(*w, 0.0, 1e-12)), "{:?}", d.yaw_rate);
}
