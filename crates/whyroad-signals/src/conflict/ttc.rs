//! Time and effort until contact: TTC along the path, TTC of oriented boxes, headway, DRAC. A pair that is known not to
//! close has an infinite time, not an unknown or zero one.

use crate::ego::motion::EgoMotion;
use crate::table::TableBuilder;
use crate::target::approach::CLOSING_LEAST_MPS;
use crate::target::placement::{Approach, Placement, Surroundings, Target};
use crate::target::rows::Rows;
use whyroad_model::ObjectClass;
use whyroad_model::catalog::id;
use whyroad_model::scene::Drive;

/// Below this speed the ego is at standstill, and has no headway, m/s.
const HEADWAY_LEAST_SPEED_MPS: f64 = 0.1;
/// Maximum distance of boxes tested for contact, m.
const BOX_REACH_M: f64 = 150.0;

/// TTC along the path, s.
pub fn ttc(Approach { gap, closing }: Approach) -> f64 {
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
fn drac(Approach { gap, closing }: Approach) -> f64 {
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

/// Contact time of the boxes at constant velocity and heading, s. Vehicles move in the direction of their heading: the
/// lateral part of their velocity comes from the annotation, and is ignored.
fn ttc_box(p: &Placement, class: ObjectClass, ego: &EgoMotion) -> f64 {
    let own = ego.footprint(p.frame);
    if !p.is_sized() || !p.velocity.is_finite() || !ego.velocity[p.frame].is_finite() {
        return f64::NAN;
    }
    if !p.same_level || !(own.center - p.footprint.center).is_within(BOX_REACH_M) {
        return f64::INFINITY;
    }
    let forward = p.footprint.direction();
    let theirs = if class.is_vehicle() { forward * p.velocity.dot(forward) } else { p.velocity };
    own.time_to_contact(ego.velocity[p.frame], &p.footprint, theirs)
}

/// Writes `target.distance` alone, of targets that are not placed.
pub fn write_distance(
    drive: &Drive,
    around: &Surroundings<'_>,
    targets: &[Target<'_>],
    table: &mut TableBuilder<'_>,
) {
    let [distance] = Rows::new(drive, table).columns(|k, r, _| [around.distance(targets[k].track, r)]);
    table.number(id::TARGET_DISTANCE, distance);
}

/// Writes `target.distance`, `gap`, `ttc`, `ttc_box`, `thw`, `drac`.
pub fn write(drive: &Drive, around: &Surroundings<'_>, targets: &[Target<'_>], table: &mut TableBuilder<'_>) {
    let rows = Rows::new(drive, table);
    let ego = around.ego;
    let [distance, gap, along_path, effort, headway, boxes] = rows.placed_columns(targets, |k, _, p| {
        [
            p.distance,
            p.approach.gap,
            ttc(p.approach),
            drac(p.approach),
            thw(p.approach.gap, ego.forward_speed[p.frame]),
            ttc_box(p, targets[k].track.class, ego),
        ]
    });
    table.number(id::TARGET_DISTANCE, distance);
    table.number(id::TARGET_GAP, gap);
    table.number(id::TARGET_TTC, along_path);
    table.number(id::TARGET_DRAC, effort);
    table.number(id::TARGET_THW, headway);
    table.number(id::TARGET_TTC_BOX, boxes);
}
