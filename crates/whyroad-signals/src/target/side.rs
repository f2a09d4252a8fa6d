//! Side of the ego on which a target is, adjacent lane in which it is, and its direction along the ego's path.

use crate::geometry::wrap;
use crate::table::TableBuilder;
use crate::target::gaps;
use crate::target::interaction::Interaction;
use crate::target::motion::OPPOSITE_RAD;
use crate::target::placement::Placement;
use crate::target::rows::Rows;
use std::f64::consts::{FRAC_PI_3, FRAC_PI_4};
use whyroad_model::catalog::{
    id,
    value::{TargetLaneSide, TargetMovesAlong, TargetSide},
};

/// Below this speed a target is stationary, m/s.
const STILL_MPS: f64 = 0.3;

/// The value of target.side of a target at `bearing` from the ego's heading, rad, left positive.
fn side(bearing: f64) -> TargetSide {
    match bearing.abs() {
        b if b <= FRAC_PI_4 => TargetSide::Front,
        b if b >= OPPOSITE_RAD - 1e-9 => TargetSide::Rear,
        _ if bearing > 0.0 => TargetSide::Left,
        _ => TargetSide::Right,
    }
}

/// [`side`] of a position ahead and to the left of the ego, m; `None` on the borders, within more than rounding errors
/// and tolerances.
fn clear_side(ahead: f64, aside: f64) -> Option<TargetSide> {
    const CLEAR: f64 = 1.0 + 1e-6;
    if ahead > aside.abs() * CLEAR {
        Some(TargetSide::Front)
    } else if ahead < -aside.abs() * CLEAR {
        Some(TargetSide::Rear)
    } else if aside.abs() > ahead.abs() * CLEAR {
        Some(if aside > 0.0 { TargetSide::Left } else { TargetSide::Right })
    } else {
        None
    }
}

/// The value of target.lane_side; `None` where the ego has no lane.
fn lane_side(p: &Placement) -> Option<TargetLaneSide> {
    let (at, left, right) = p.lane?;
    let same_way = wrap(p.course() - at.heading).abs() <= FRAC_PI_3;
    let width = left + right;
    Some(if p.in_way {
        TargetLaneSide::Same
    } else if !p.same_level || !p.within_reach() || !same_way {
        TargetLaneSide::Other
    } else if at.lateral > left && at.lateral <= left + width {
        TargetLaneSide::Left
    } else if at.lateral < -right && at.lateral >= -right - width {
        TargetLaneSide::Right
    } else {
        TargetLaneSide::Other
    })
}

/// The value of target.moves_along.
fn moves_along(p: &Placement) -> Option<TargetMovesAlong> {
    if p.speed().is_nan() {
        return None;
    }
    if p.speed() < STILL_MPS {
        return Some(TargetMovesAlong::Still);
    }
    let turned = wrap(p.direction() - p.path.heading).abs();
    Some(if turned <= FRAC_PI_4 {
        TargetMovesAlong::Along
    } else if turned >= OPPOSITE_RAD - 1e-9 {
        TargetMovesAlong::Against
    } else {
        TargetMovesAlong::Across
    })
}

/// Writes `target.side`, `lane_side`, `moves_along`, `relative_speed`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let rows = Rows::new(scene.drive, table);
    let (targets, ego) = (scene.targets, scene.around.ego);
    let seen = |p: &Placement| {
        let away = p.footprint.center - ego.position[p.frame];
        let forward = ego.footprint(p.frame).direction();
        let exactly = || side(wrap(away.heading() - ego.heading[p.frame]));
        clear_side(away.dot(forward), away.dot(forward.left())).unwrap_or_else(exactly)
    };
    let relative = |p: &Placement| {
        if p.speed() == 0.0 {
            -ego.forward_speed[p.frame]
        } else {
            gaps::along_signed(p) - ego.forward_speed[p.frame]
        }
    };
    let (mut sides, mut lane_sides, mut along) = (rows.column(None), rows.column(None), rows.column(None));
    let mut relative_speeds = rows.column(f64::NAN);
    rows.each_placed(targets, |row, _, p| {
        sides.0[row] = Some(seen(p));
        lane_sides.0[row] = lane_side(p);
        along.0[row] = moves_along(p);
        relative_speeds.0[row] = relative(p);
    });
    table.category(id::TARGET_SIDE, sides);
    if scene.around.lanes.is_some() {
        table.category(id::TARGET_LANE_SIDE, lane_sides);
    }
    table.category(id::TARGET_MOVES_ALONG, along);
    table.number(id::TARGET_RELATIVE_SPEED, relative_speeds);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::P2;
    use std::f64::consts::PI;

    #[test]
    fn clear_sides_are_those_of_the_angle() {
        let mut clear = 0;
        for k in 0..36_000_i32 {
            // Some at the borders, and next to them.
            let bearing = wrap(f64::from(k / 9) * PI / 1000.0 + f64::from(k % 9 - 4) * 3e-8);
            let at = P2::from_heading(bearing) * (0.01 + f64::from(k % 131));
            if let Some(found) = clear_side(at.x, at.y) {
                assert_eq!(found, side(at.heading()), "{bearing}");
                clear += 1;
            }
        }
        assert!((35_800..36_000).contains(&clear), "{clear}");
        assert_eq!(clear_side(0.0, 0.0), None);
        assert_eq!(clear_side(f64::NAN, 1.0), None);
    }
}
