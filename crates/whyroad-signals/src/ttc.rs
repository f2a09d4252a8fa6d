//! Time and effort until contact: TTC along the path, TTC of oriented boxes, headway, DRAC. A pair that is known
//! not to close has an infinite time, never an unknown or a zero one.

use crate::ego_motion::EgoMotion;
use crate::gaps::gap;
use crate::geometry::wrap;
use crate::placement::{Placement, Target};
use crate::rows::Rows;
use crate::table::TableBuilder;
use std::f64::consts::PI;
use whyroad_model::scene::Drive;

/// Closing slower than this is not closing, m/s: it is within what differentiated positions can tell.
const CLOSING_LEAST_MPS: f64 = 0.1;
/// Below this speed the ego stands, and has no headway, m/s.
const HEADWAY_LEAST_SPEED_MPS: f64 = 0.1;
/// Motion within this of the path's direction is along it: 45 deg (RefAV).
const ALONG_RAD: f64 = PI / 4.0;
/// An oncoming target meets the ego head-on only where both are aligned to within this: 20 deg.
const HEAD_ON_RAD: f64 = 20.0 * PI / 180.0;
/// Boxes farther apart than this are not asked for contact, m.
const BOX_REACH_M: f64 = 150.0;

/// Speed of the target along the ego's path, m/s. A crossing target recedes at best (it leaves the path before its
/// sideways motion could bring it nearer), and an oncoming one approaches only where the path is straight between
/// the two: a car that passes the mouth of the ego's left turn is not on a collision course along it.
pub fn along_path(p: &Placement) -> f64 {
    let along = p.speed() * wrap(p.velocity.heading() - p.path.heading).cos();
    let turned = wrap(p.course() - p.path.heading).abs();
    let straight = wrap(p.path.heading - p.heading_at_ego).abs() < HEAD_ON_RAD;
    let head_on = turned > PI - HEAD_ON_RAD && straight;
    // A same-direction car that backs up has a course against the path as well: that is head-on too.
    if turned <= ALONG_RAD || head_on { along } else { along.max(0.0) }
}

fn closing(p: &Placement, ego: &EgoMotion) -> f64 {
    ego.forward_speed[p.frame] - along_path(p)
}

/// TTC along the path, s.
fn ttc(gap: f64, closing: f64) -> f64 {
    if gap.is_nan() || (gap.is_finite() && closing.is_nan()) {
        f64::NAN
    } else if gap <= 0.0 {
        0.0
    } else if gap.is_infinite() || closing <= CLOSING_LEAST_MPS {
        f64::INFINITY
    } else {
        gap / closing
    }
}

/// Deceleration rate to avoid a crash, m/s2.
fn drac(gap: f64, closing: f64) -> f64 {
    if gap.is_nan() || (gap.is_finite() && closing.is_nan()) {
        f64::NAN
    } else if gap.is_infinite() || closing <= CLOSING_LEAST_MPS {
        0.0
    } else if gap <= 0.0 {
        f64::INFINITY
    } else {
        closing * closing / (2.0 * gap)
    }
}

/// Time headway, s.
fn thw(gap: f64, speed: f64) -> f64 {
    if gap.is_nan() || (gap.is_finite() && speed.is_nan()) {
        f64::NAN
    } else if gap <= 0.0 {
        0.0
    } else if gap.is_infinite() || speed < HEADWAY_LEAST_SPEED_MPS {
        f64::INFINITY
    } else {
        gap / speed
    }
}

/// Contact time of the boxes at constant velocity and heading, s.
fn ttc_box(p: &Placement, ego: &EgoMotion) -> f64 {
    let own = ego.footprint(p.frame);
    if !p.is_sized() || !p.velocity.is_finite() || !ego.velocity[p.frame].is_finite() {
        return f64::NAN;
    }
    if !p.same_level || (own.centre - p.footprint.centre).norm() > BOX_REACH_M {
        return f64::INFINITY;
    }
    own.time_to_contact(ego.velocity[p.frame], &p.footprint, p.velocity)
}

/// Writes `target.distance`, `gap`, `ttc`, `ttc_box`, `thw`, `drac`.
pub fn write(drive: &Drive, ego: &EgoMotion, targets: &[Target<'_>], table: &mut TableBuilder<'_>) {
    let rows = Rows::new(drive, table);
    let gap_of = |p: &Placement| gap(p, ego.length, ego.width);
    let mut number = |name: &str, value: &dyn Fn(&Placement) -> f64| {
        table.number(name, rows.placed(targets, f64::NAN, value));
    };
    number("target.distance", &|p| {
        if p.is_sized() { ego.footprint(p.frame).distance(&p.footprint) } else { f64::NAN }
    });
    number("target.gap", &gap_of);
    number("target.ttc", &|p| ttc(gap_of(p), closing(p, ego)));
    number("target.drac", &|p| drac(gap_of(p), closing(p, ego)));
    number("target.thw", &|p| thw(gap_of(p), ego.forward_speed[p.frame]));
    number("target.ttc_box", &|p| ttc_box(p, ego));
}
