//! What a target is and does by itself, and where it is in the ego's axes (x forward, y left of the ego's box
//! centre). In logs without an ego pose, positions are given relative to the log's own ego reference point.

use crate::ego::bus::turn_signal;
use crate::ego::motion::{EgoMotion, STANDSTILL_RELEASE_MPS, STANDSTILL_SET_MPS};
use crate::geometry::{P2, angle_between_lines, p2, wrap};
use crate::series::below_with_hysteresis;
use crate::table::TableBuilder;
use crate::target::placement::Target;
use crate::target::rows::Rows;
use whyroad_model::catalogue::{CategoryValue, id, value::TargetClass};
use whyroad_model::scene::Drive;
use whyroad_model::{ObjectClass, Tri};

/// From this difference of headings on the target goes the opposite way: 135 deg (RefAV).
pub const OPPOSITE_RAD: f64 = 135.0 * std::f64::consts::PI / 180.0;
/// Below this speed a direction of motion means nothing, m/s.
const DIRECTION_LEAST_SPEED_MPS: f64 = 0.3;

/// Writes what needs no ego pose: identity, visibility, indicators, position and heading relative to the ego.
/// Without `ego` the positions of the drive are taken as relative to it already.
pub fn write_relative(drive: &Drive, ego: Option<&EgoMotion>, table: &mut TableBuilder<'_>) {
    let rows = Rows::new(drive, table);
    table.flag(id::TARGET_OBSERVED, rows.flags_or(Tri::False, |_, _| Tri::True));
    table.category(id::TARGET_CLASS, rows.values(|t, _| TargetClass::from_name(t.class.id())));
    table.flag(id::TARGET_LARGE_VEHICLE, rows.flags(|t, _| known_class(t.class, t.class.is_large_vehicle())));
    table.flag(
        id::TARGET_VISIBLE,
        rows.flags(|t, r| Tri::from(t.interior_points.get(r).filter(|n| !n.is_nan()).map(|&n| n > 0.0))),
    );
    table.category(
        id::TARGET_TURN_SIGNAL,
        rows.values(|t, r| t.turn_signal.get(r).copied().flatten().map(turn_signal)),
    );
    let relative = |t: &whyroad_model::scene::Track, r: usize| -> P2 {
        let (p, frame) = (p2(t.motion.x[r], t.motion.y[r]), t.frames[r] as usize);
        let Some(ego) = ego else { return p };
        let forward = ego.footprint(frame).direction();
        let d = p - ego.position[frame];
        p2(d.dot(forward), d.dot(forward.left()))
    };
    let turned = |t: &whyroad_model::scene::Track, r: usize| {
        let own = ego.map_or(0.0, |e| e.heading[t.frames[r] as usize]);
        let d = t.motion.heading[r] - own;
        if d.is_nan() { d } else { wrap(d) }
    };
    table.number(id::TARGET_LONGITUDINAL, rows.numbers(|t, r| relative(t, r).x));
    table.number(id::TARGET_LATERAL, rows.numbers(|t, r| relative(t, r).y));
    table.number(id::TARGET_HEADING_DIFFERENCE, rows.numbers(turned));
    table.flag(
        id::TARGET_OPPOSITE_DIRECTION,
        rows.flags(|t, r| {
            let d = turned(t, r);
            // A tolerance: exactly 135 deg must not depend on rounding.
            if d.is_nan() { Tri::Unknown } else { Tri::from(d.abs() >= OPPOSITE_RAD - 1e-9) }
        }),
    );
}

fn known_class(class: ObjectClass, value: bool) -> Tri {
    if class == ObjectClass::Unknown { Tri::Unknown } else { Tri::from(value) }
}

/// Writes the targets' motion over ground and their place along the ego's path.
pub fn write(drive: &Drive, targets: &[Target<'_>], table: &mut TableBuilder<'_>) {
    let rows = Rows::new(drive, table);
    table.number(id::TARGET_SPEED, rows.numbers(|t, r| t.motion.speed(r)));
    let mut standstill = Vec::with_capacity(targets.len());
    for target in targets {
        let m = &target.track.motion;
        let speeds: Vec<f64> = (0..m.len()).map(|r| m.speed(r)).collect();
        standstill.push(below_with_hysteresis(&speeds, STANDSTILL_SET_MPS, STANDSTILL_RELEASE_MPS));
    }
    table.flag(id::TARGET_STANDSTILL, rows.spread(targets, Tri::Unknown, |k, r, _| standstill[k][r]));
    table.number(id::TARGET_ACCEL, rows.spread(targets, f64::NAN, |k, r, _| targets[k].accel[r]));
    table.number(id::TARGET_PATH_LONGITUDINAL, rows.placed(targets, f64::NAN, |p| p.ahead));
    table.number(id::TARGET_PATH_LATERAL, rows.placed(targets, f64::NAN, |p| p.path.lateral));
    table.number(
        id::TARGET_CROSSING_ANGLE,
        rows.placed(targets, f64::NAN, |p| {
            if p.speed() >= DIRECTION_LEAST_SPEED_MPS {
                angle_between_lines(p.direction(), p.path.heading)
            } else {
                f64::NAN
            }
        }),
    );
}
