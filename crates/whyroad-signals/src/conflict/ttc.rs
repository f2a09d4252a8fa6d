//! Time and effort until contact: TTC along the path, TTC of oriented boxes, headway, DRAC. A pair that is known
//! not to close has an infinite time, never an unknown or a zero one.

use crate::ego::motion::EgoMotion;
use crate::geometry::{P2, wrap};
use crate::table::TableBuilder;
use crate::target::gaps::{self, gap};
use crate::target::placement::{Placement, Surroundings, Target};
use crate::target::rows::Rows;
use std::f64::consts::PI;
use whyroad_model::ObjectClass;
use whyroad_model::catalogue::{Number, PerTarget, Signal, id};
use whyroad_model::scene::Drive;

/// Closing slower than this is not closing, m/s: it is within what differentiated positions can tell.
pub const CLOSING_LEAST_MPS: f64 = 0.1;
/// Below this speed the ego is at standstill, and has no headway, m/s.
const HEADWAY_LEAST_SPEED_MPS: f64 = 0.1;
/// Motion within this of the path's direction is along it: 45 deg (RefAV).
const ALONG_RAD: f64 = PI / 4.0;
/// An oncoming target meets the ego head-on only where both are aligned to within this: 20 deg.
const HEAD_ON_RAD: f64 = 20.0 * PI / 180.0;
/// Maximum distance of boxes tested for contact, m.
const BOX_REACH_M: f64 = 150.0;

/// How a target goes relative to the ego's path where it is.
#[derive(Clone, Copy, PartialEq)]
pub enum Course {
    /// With it, to within 45 deg.
    Along,
    /// Against it, nearly in line with the ego.
    HeadOn,
    /// Everything else.
    Across,
}

/// How `p` goes.
pub fn course_of(p: &Placement) -> Course {
    let turned = wrap(p.course() - p.path.heading).abs();
    let straight = wrap(p.path.heading - p.heading_at_ego).abs() < HEAD_ON_RAD;
    if turned <= ALONG_RAD {
        Course::Along
    } else if turned > PI - HEAD_ON_RAD && straight {
        // A car of the same direction that backs up goes against the path as well.
        Course::HeadOn
    } else {
        Course::Across
    }
}

/// The same for what can be closed on: what goes across recedes at best.
pub fn along(p: &Placement) -> f64 {
    let along = gaps::along_signed(p);
    if course_of(p) == Course::Across { along.max(0.0) } else { along }
}

/// Closing speed of an in-path pair along the path, m/s; 0 when the two will not meet there. A target that goes
/// across recedes at best: its sideways motion brings it out of the path, not nearer along it. Whatever does not go
/// along the path must still be in it when the ego gets there: a car that passes the mouth of the ego's left turn, or
/// a walker who has crossed by then, is on no collision course along the path (`target.ttc_box` and `target.pet`
/// look at those). Most targets are not in the path: of an infinite gap nothing is asked.
pub fn closing(p: &Placement, gap: f64, around: &Surroundings<'_>) -> f64 {
    if gap.is_infinite() {
        return 0.0;
    }
    let speed = around.ego.forward_speed[p.frame] - along(p);
    let meets =
        course_of(p) == Course::Along || speed <= CLOSING_LEAST_MPS || around.meets(p, gap.max(0.0) / speed);
    if meets || gap.is_nan() { speed } else { 0.0 }
}

/// TTC along the path, s.
pub fn ttc(gap: f64, closing: f64) -> f64 {
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

/// Contact time of the boxes at constant velocity and heading, s. Vehicles roll where they point: the sideways part
/// of their velocity is the annotation's, and is left out.
fn ttc_box(p: &Placement, class: ObjectClass, ego: &EgoMotion) -> f64 {
    let own = ego.footprint(p.frame);
    if !p.is_sized() || !p.velocity.is_finite() || !ego.velocity[p.frame].is_finite() {
        return f64::NAN;
    }
    if !p.same_level || (own.centre - p.footprint.centre).norm() > BOX_REACH_M {
        return f64::INFINITY;
    }
    let forward = P2::from_heading(p.footprint.heading);
    let theirs = if class.is_vehicle() { forward * p.velocity.dot(forward) } else { p.velocity };
    own.time_to_contact(ego.velocity[p.frame], &p.footprint, theirs)
}

/// Writes `target.distance`, `gap`, `ttc`, `ttc_box`, `thw`, `drac`.
pub fn write(drive: &Drive, around: &Surroundings<'_>, targets: &[Target<'_>], table: &mut TableBuilder<'_>) {
    let rows = Rows::new(drive, table);
    let ego = around.ego;
    let gap_of = |p: &Placement| gap(p, ego.length);
    let mut number = |id: Signal<PerTarget, Number>, value: &dyn Fn(&Placement) -> f64| {
        table.number(id, rows.placed(targets, f64::NAN, value));
    };
    number(id::TARGET_DISTANCE, &|p| {
        if p.is_sized() { ego.footprint(p.frame).distance(&p.footprint) } else { f64::NAN }
    });
    number(id::TARGET_GAP, &gap_of);
    number(id::TARGET_TTC, &|p| ttc(gap_of(p), closing(p, gap_of(p), around)));
    number(id::TARGET_DRAC, &|p| drac(gap_of(p), closing(p, gap_of(p), around)));
    number(id::TARGET_THW, &|p| thw(gap_of(p), ego.forward_speed[p.frame]));
    let boxes = |k: usize, p: Option<&Placement>| {
        p.map_or(f64::NAN, |p: &Placement| ttc_box(p, targets[k].track.class, ego))
    };
    table.number(id::TARGET_TTC_BOX, rows.spread(targets, f64::NAN, |k, _, p| boxes(k, p)));
}
