//! TTC along the lane: time until the ego would reach a target if it continued in its lane as it is now. The driven
//! path already contains the evasion of a cyclist, TTC along it counts a cyclist at the lane's side although the ego
//! would pass, and boxes at constant velocity leave a bend: none of these gives the time when the cyclist became
//! relevant for the ego.

use crate::geometry::{OrientedBox, P2, wrap};
use crate::road::ego_lane::lateral_extent;
use crate::table::TableBuilder;
use crate::target::approach::CLOSING_LEAST_MPS;
use crate::target::placement::{Placement, Surroundings, Target};
use crate::target::rows::Rows;
use std::f64::consts::FRAC_PI_4;
use whyroad_model::catalog::id;
use whyroad_model::scene::Drive;

/// Half the extent of a box along a direction, m.
fn reach_along(footprint: &OrientedBox, heading: f64) -> f64 {
    footprint.half_along(P2::from_heading(heading))
}

/// The ego in its lane in one frame, computed once for all targets.
#[derive(Clone, Copy)]
struct Own {
    /// Lateral extent of its box, left positive, m.
    extent: (f64, f64),
    /// Half its extent along the lane, m.
    reach: f64,
    /// m/s.
    forward_speed: f64,
}

impl Own {
    /// `None` without a lane, a size or a speed.
    fn new(around: &Surroundings<'_>, frame: usize) -> Option<Self> {
        let on = around.lanes.and_then(|l| l.at(frame))?;
        let (footprint, forward_speed) = (around.ego.footprint(frame), around.ego.forward_speed[frame]);
        if !footprint.length.is_finite() || !footprint.width.is_finite() || !forward_speed.is_finite() {
            return None;
        }
        let reach = reach_along(&footprint, on.corridor.line.smooth_heading_at(on.s, 2.0));
        Some(Self { extent: lateral_extent(on.corridor, &footprint, on.s), reach, forward_speed })
    }
}

/// Seconds; infinite where the ego does not approach the target, 0 beside it, NaN without a lane or a size.
fn ttc_lane(p: &Placement, own: Option<Own>) -> f64 {
    let (Some((at, _, _)), Some(own), true) = (p.lane, own, p.is_sized()) else { return f64::NAN };
    if !p.velocity.is_finite() {
        return f64::NAN;
    }
    if !p.same_level || !p.within_reach() {
        return f64::INFINITY;
    }
    let (low, high) = own.extent;
    let meets = |shift: f64| at.low + shift < high && at.high + shift > low;
    if !meets(0.0) {
        return f64::INFINITY;
    }
    let reaches = own.reach + reach_along(&p.footprint, at.heading);
    if p.lane_ahead < -reaches {
        return f64::INFINITY;
    }
    let gap = p.lane_ahead - reaches;
    if gap <= 0.0 {
        return 0.0;
    }
    let direction = P2::from_heading(at.heading);
    let closing = own.forward_speed - p.velocity.dot(direction);
    if closing <= CLOSING_LEAST_MPS {
        return f64::INFINITY;
    }
    let time = gap / closing;
    // A target that moves across, or towards the ego, must still be ahead of it by then.
    let across = wrap(p.course() - at.heading).abs() > FRAC_PI_4;
    if across && !meets(p.velocity.dot(direction.left()) * time) { f64::INFINITY } else { time }
}

/// Writes `target.ttc_lane`, where there is a map.
pub fn write(drive: &Drive, around: &Surroundings<'_>, targets: &[Target<'_>], table: &mut TableBuilder<'_>) {
    if around.lanes.is_none() {
        return;
    }
    let own: Vec<Option<Own>> = (0..around.ego.len()).map(|i| Own::new(around, i)).collect();
    let rows = Rows::new(drive, table);
    table.number(id::TARGET_TTC_LANE, rows.placed(targets, f64::NAN, |p| ttc_lane(p, own[p.frame])));
}
