//! Time until a side of the ego reaches the edge of its lane, or a target outside reaches the ego's lane, when each
//! keeps its speed across the lane.

use crate::geometry::P2;
use crate::road::ego_lane::{OVER_LINE_M, lateral_extent};
use crate::table::TableBuilder;
use crate::target::gaps::lane_lateral_speed;
use crate::target::interaction::Interaction;
use crate::target::on_lines::LATERAL_LEAST_MPS;
use crate::target::placement::Placement;
use crate::target::rows::Rows;
use whyroad_model::catalog::id;

/// Seconds to cover `distance` at `speed`; infinite when not approaching, 0 when there.
fn time_over(distance: f64, speed: f64) -> f64 {
    if distance <= 0.0 {
        0.0
    } else if speed < LATERAL_LEAST_MPS {
        f64::INFINITY
    } else {
        distance / speed
    }
}

fn of_ego(scene: &Interaction<'_>, frame: usize) -> f64 {
    let (ego, Some(road)) = (scene.around.ego, scene.around.road) else { return f64::NAN };
    let Some(on) = scene.around.lanes.and_then(|l| l.at(frame)) else { return f64::NAN };
    if road.lanes[on.lane].in_junction {
        return f64::INFINITY;
    }
    let speed =
        ego.velocity[frame].dot(P2::from_heading(on.corridor.line.smooth_heading_at(on.s, 2.0)).left());
    let (low, high) = lateral_extent(on.corridor, &ego.footprint(frame), on.s);
    let (left, right) = on.corridor.widths_at(on.s);
    if (low + high + speed).is_nan() {
        return f64::NAN;
    }
    if high > left + OVER_LINE_M || low < -right - OVER_LINE_M {
        return 0.0;
    }
    // If it touches the line but is not over it, it crosses at once if it moves that way, else not at all.
    let sides = [(left - high, speed), (low + right, -speed)];
    sides
        .into_iter()
        .filter(|&(_, v)| v >= LATERAL_LEAST_MPS)
        .map(|(d, v)| time_over(d, v))
        .fold(f64::INFINITY, f64::min)
}

fn of_target(p: &Placement) -> f64 {
    let (Some((at, left, right)), Some(depth), Some(speed)) = (p.lane, p.intrusion(), lane_lateral_speed(p))
    else {
        return f64::NAN;
    };
    if !p.same_level || !p.within_reach() {
        return f64::INFINITY;
    }
    let distance = if at.lateral > 0.0 { at.low - left } else { -at.high - right };
    if p.in_way || depth > 0.0 {
        0.0
    } else if speed.is_nan() {
        f64::NAN
    } else {
        time_over(distance, speed)
    }
}

/// Writes `ego.time_to_line`, `target.time_to_line`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    if scene.around.lanes.is_none() {
        return;
    }
    let rows = Rows::new(scene.drive, table);
    table.number(id::EGO_TIME_TO_LINE, (0..scene.times.len()).map(|i| of_ego(scene, i)).collect());
    table.number(id::TARGET_TIME_TO_LINE, rows.placed(scene.targets, f64::NAN, of_target));
}
