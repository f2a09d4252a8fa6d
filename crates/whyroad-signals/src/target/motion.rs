//! Identity and motion of a target, and its position in the ego's axes (x forward, y left of the ego's box center). In
//! logs without an ego pose, positions are relative to the log's own ego reference point.

use crate::ego::bus::turn_signal;
use crate::ego::motion::EgoMotion;
use crate::geometry::{P2, angle_between_lines, p2, wrap};
use crate::table::TableBuilder;
use crate::target::placement::Target;
use crate::target::rows::Rows;
use whyroad_model::Tri;
use whyroad_model::catalog::{CategoryValue, id, value::TargetClass};
use whyroad_model::scene::Drive;

/// Minimum difference of headings of a target with the opposite direction: 135 deg (RefAV).
pub const OPPOSITE_RAD: f64 = 135.0 * std::f64::consts::PI / 180.0;
/// Minimum speed for a direction of motion, m/s.
const DIRECTION_LEAST_SPEED_MPS: f64 = 0.3;

/// Writes signals that need no ego pose: identity, visibility, indicators, position and heading relative to the ego.
/// Without `ego` the positions of the drive are already relative to it.
pub fn write_relative(drive: &Drive, ego: Option<&EgoMotion>, table: &mut TableBuilder<'_>) {
    let rows = Rows::new(drive, table);
    table.flag(id::TARGET_OBSERVED, rows.per_track(Tri::False, |_| Tri::True));
    table.category(id::TARGET_CLASS, rows.per_track(None, |t| TargetClass::from_name(t.class.id())));
    table.flag(id::TARGET_LARGE_VEHICLE, rows.per_track(Tri::Unknown, |t| t.class.large_vehicle()));
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
    let [ahead, aside, turned] = rows.columns(|_, r, t| {
        let at = relative(t, r);
        [at.x, at.y, turned(t, r)]
    });
    // A tolerance: exactly 135 deg must not depend on rounding.
    let opposite =
        |d: &f64| if d.is_nan() { Tri::Unknown } else { Tri::from(d.abs() >= OPPOSITE_RAD - 1e-9) };
    table.number(id::TARGET_LONGITUDINAL, ahead);
    table.number(id::TARGET_LATERAL, aside);
    table.flag(id::TARGET_OPPOSITE_DIRECTION, turned.map(opposite));
    table.number(id::TARGET_HEADING_DIFFERENCE, turned);
}

/// Writes the targets' motion over ground, which needs no placement.
pub fn write_speeds(drive: &Drive, targets: &[Target<'_>], table: &mut TableBuilder<'_>) {
    let rows = Rows::new(drive, table);
    let [speed, accel] = rows.columns(|k, r, _| [targets[k].speed[r], targets[k].accel[r]]);
    table.number(id::TARGET_SPEED, speed);
    table.number(id::TARGET_ACCEL, accel);
    let standstill = |k: usize, r: usize| targets[k].standstill[r];
    table.flag(id::TARGET_STANDSTILL, rows.spread(targets, Tri::Unknown, |k, r, _| standstill(k, r)));
}

/// Writes the targets' motion over ground and their positions along the ego's path.
pub fn write(drive: &Drive, targets: &[Target<'_>], table: &mut TableBuilder<'_>) {
    let rows = Rows::new(drive, table);
    write_speeds(drive, targets, table);
    let [ahead, aside, crossing] = rows.placed_columns(targets, |_, _, p| {
        let moves = p.speed() >= DIRECTION_LEAST_SPEED_MPS;
        let crossing = if moves { angle_between_lines(p.direction(), p.path.heading) } else { f64::NAN };
        [p.ahead, p.path.lateral, crossing]
    });
    table.number(id::TARGET_PATH_LONGITUDINAL, ahead);
    table.number(id::TARGET_PATH_LATERAL, aside);
    table.number(id::TARGET_CROSSING_ANGLE, crossing);
}
