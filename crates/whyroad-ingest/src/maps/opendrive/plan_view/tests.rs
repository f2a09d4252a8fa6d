//! Expected values by hand, from the definitions of the curves.

use super::*;
use std::f64::consts::{FRAC_PI_2, PI};

fn end_of(shape: Shape, length: f64) -> Pose {
    let g = Geometry { start: 0.0, x: 0.0, y: 0.0, heading: 0.0, length, shape };
    assert!(g.is_sound());
    // Also by many points on the way: the integration goes on where it was.
    let stations: Vec<f64> = (0..=40).map(|i| length * f64::from(i) / 40.0).collect();
    let (all, one) = (poses(&[g], &stations), poses(&[g], &[length]));
    let last = all[40];
    assert!((last.x - one[0].x).abs() < 1e-6 && (last.y - one[0].y).abs() < 1e-6);
    one[0]
}

fn near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

#[test]
fn a_quarter_circle_to_the_left_and_to_the_right() {
    let left = end_of(Shape::Arc(0.1), 5.0 * PI);
    assert!(near(left.x, 10.0, 1e-9) && near(left.y, 10.0, 1e-9) && near(left.heading, FRAC_PI_2, 1e-12));
    let right = end_of(Shape::Arc(-0.1), 5.0 * PI);
    assert!(near(right.x, 10.0, 1e-9) && near(right.y, -10.0, 1e-9));
}

#[test]
fn a_clothoid_ends_where_the_fresnel_integrals_say() {
    // With curvature k s / L, x = a C(L/a), y = a S(L/a) and a = sqrt(pi L / k). For a = 100 m, L = 100 m the curvature
    // at the end is pi / 100, and C(1) = 0.7798934004, S(1) = 0.4382591474 (Abramowitz and Stegun, table 7.7).
    let end = end_of(Shape::Spiral(0.0, PI / 100.0), 100.0);
    assert!(near(end.x, 77.989_340_04, 1e-7) && near(end.y, 43.825_914_74, 1e-7), "{end:?}");
    assert!(near(end.heading, FRAC_PI_2, 1e-12));
    // C(0.5) = 0.4923442259, S(0.5) = 0.0647324329: half way along the same clothoid.
    let half = end_of(Shape::Spiral(0.0, PI / 200.0), 50.0);
    assert!(near(half.x, 49.234_422_59, 1e-7) && near(half.y, 6.473_243_29, 1e-7), "{half:?}");
    // Run backwards it comes to the mirror image of its start.
    let back = end_of(Shape::Spiral(PI / 100.0, 0.0), 100.0);
    let (s, c) = FRAC_PI_2.sin_cos();
    let want = (end.x * c + end.y * s, end.x * s - end.y * c);
    assert!(near(back.x, want.0, 1e-7) && near(back.y, want.1, 1e-7), "{back:?} {want:?}");
}

#[test]
fn a_cubic_is_as_long_as_its_arc() {
    // v = u^2 / 20: the arc from 0 to u has length (u r + 10 asinh(u / 10)) / 2 with r = sqrt(1 + u^2 / 100).
    let u: f64 = 10.0;
    let length = (u * 2.0_f64.sqrt() + 10.0 * 1.0_f64.asinh()) / 2.0;
    let end = end_of(Shape::Cubic([0.0, 0.0, 0.05, 0.0]), length);
    assert!(
        near(end.x, 10.0, 1e-6) && near(end.y, 5.0, 1e-6) && near(end.heading, PI / 4.0, 1e-7),
        "{end:?}"
    );
}

#[test]
fn a_parametric_cubic_in_both_ranges() {
    // The Bezier curve (0,0) (10,0) (20,10) (20,20): u = 30 p - 10 p^3... in power form u = 30p + 0p^2 - 10p^3,
    // v = 0 + 30p^2 - 10p^3, which ends at (20, 20) heading north.
    let (u, v) = ([0.0, 30.0, 0.0, -10.0], [0.0, 0.0, 30.0, -10.0]);
    let end = end_of(Shape::Parametric { u, v, end: 1.0 }, 29.0);
    assert!(near(end.x, 20.0, 1e-9) && near(end.y, 20.0, 1e-9) && near(end.heading, FRAC_PI_2, 1e-9));
    // u = 0, v = 10 p^2 has zero speed at its start, and still heads north.
    let still = Shape::Parametric { u: [0.0; 4], v: [0.0, 0.0, 10.0, 0.0], end: 1.0 };
    let g = Geometry { start: 0.0, x: 0.0, y: 0.0, heading: 0.0, length: 10.0, shape: still };
    assert!(near(poses(&[g], &[0.0])[0].heading, FRAC_PI_2, 1e-9));
    // A line of 50 m over its own length.
    let end = end_of(Shape::Parametric { u: [0.0, 0.6, 0.0, 0.0], v: [0.0, 0.8, 0.0, 0.0], end: 50.0 }, 50.0);
    assert!(near(end.x, 30.0, 1e-9) && near(end.y, 40.0, 1e-9));
}

#[test]
fn stretches_follow_each_other_and_ends_run_straight_on() {
    let line = Geometry { start: 0.0, x: 5.0, y: 0.0, heading: 0.0, length: 10.0, shape: Shape::Line };
    let arc = Geometry { start: 10.0, x: 15.0, length: 5.0 * PI, shape: Shape::Arc(0.1), ..line };
    let at = poses(&[line, arc], &[-2.0, 0.0, 10.0, 10.0 + 5.0 * PI, 12.0 + 5.0 * PI]);
    let want = [(3.0, 0.0), (5.0, 0.0), (15.0, 0.0), (25.0, 10.0), (25.0, 12.0)];
    for (pose, (x, y)) in at.iter().zip(want) {
        assert!(near(pose.x, x, 1e-9) && near(pose.y, y, 1e-9), "{pose:?} {x} {y}");
    }
    // 3 m to the left of a point that heads north is 3 m to the west.
    let beside = at[4].beside(3.0, 1.0);
    assert!(near(beside.x, 22.0, 1e-9) && near(beside.y, 12.0, 1e-9) && beside.z == 1.0);
}

#[test]
fn what_is_no_road_is_not_sound() {
    let g = Geometry { start: 0.0, x: 0.0, y: 0.0, heading: 0.0, length: 10.0, shape: Shape::Arc(1e300) };
    assert!(!g.is_sound() && !Geometry { length: f64::INFINITY, shape: Shape::Line, ..g }.is_sound());
    assert!(!Geometry { length: -1.0, shape: Shape::Line, ..g }.is_sound());
}
