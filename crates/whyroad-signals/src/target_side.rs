//! On which side of the ego a target is, in which lane beside it, and which way it moves along the ego's path.

use crate::geometry::{p2, wrap};
use crate::interaction::Interaction;
use crate::placement::Placement;
use crate::rows::Rows;
use crate::table::TableBuilder;
use crate::target_motion::OPPOSITE_RAD;
use crate::ttc;
use std::f64::consts::{FRAC_PI_3, FRAC_PI_4};

/// Below this a target does not move, m/s.
const STILL_MPS: f64 = 0.3;

// Indices into the catalogue's values; a test holds them to the names.
const FRONT: u16 = 0;
const LEFT: u16 = 1;
const RIGHT: u16 = 2;
const REAR: u16 = 3;

/// Index in the values of target.side for a target seen at `bearing` from the ego's heading, rad, left positive.
fn side(bearing: f64) -> u16 {
    match bearing.abs() {
        b if b <= FRAC_PI_4 => FRONT,
        b if b >= OPPOSITE_RAD - 1e-9 => REAR,
        _ if bearing > 0.0 => LEFT,
        _ => RIGHT,
    }
}

/// Index in the values of target.lane_side (same, left, right, other); `None` where the ego has no lane.
fn lane_side(p: &Placement) -> Option<u16> {
    let (at, left, right) = p.lane?;
    let same_way = wrap(p.course() - at.heading).abs() <= FRAC_PI_3;
    let width = left + right;
    Some(if p.in_way {
        0
    } else if !p.same_level || !p.within_reach() || !same_way {
        3
    } else if at.lateral > left && at.lateral <= left + width {
        1
    } else if at.lateral < -right && at.lateral >= -right - width {
        2
    } else {
        3
    })
}

/// Index in the values of target.moves_along (still, along, against, across).
fn moves_along(p: &Placement) -> Option<u16> {
    if p.speed().is_nan() {
        return None;
    }
    if p.speed() < STILL_MPS {
        return Some(0);
    }
    let turned = wrap(p.velocity.heading() - p.path.heading).abs();
    Some(if turned <= FRAC_PI_4 {
        1
    } else if turned >= OPPOSITE_RAD - 1e-9 {
        2
    } else {
        3
    })
}

/// Writes `target.side`, `lane_side`, `moves_along`, `relative_speed`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let rows = Rows::new(scene.drive, table);
    let (targets, ego) = (scene.targets, scene.around.ego);
    let bearing = |p: &Placement| {
        let away = p.footprint.centre - ego.position[p.frame];
        let at = wrap(p2(away.x, away.y).heading() - ego.heading[p.frame]);
        Some(side(at))
    };
    table.category("target.side", rows.placed(targets, None, bearing));
    if scene.around.lanes.is_some() {
        table.category("target.lane_side", rows.placed(targets, None, lane_side));
    }
    table.category("target.moves_along", rows.placed(targets, None, moves_along));
    let relative = |p: &Placement| {
        if p.speed() == 0.0 {
            -ego.forward_speed[p.frame]
        } else {
            ttc::along_signed(p) - ego.forward_speed[p.frame]
        }
    };
    table.number("target.relative_speed", rows.placed(targets, f64::NAN, relative));
}
