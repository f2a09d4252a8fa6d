//! TTC along the lane: how soon the ego would be at a target if it went on in its lane as it is now. The driven path
//! knows that the ego will go round a cyclist, TTC along it counts who rides at the lane's side though the ego would
//! slip by, and boxes at constant velocity leave a bend: none gives the moment when the cyclist began to concern the
//! ego.

use crate::conflict::ttc::CLOSING_LEAST_MPS;
use crate::geometry::{OrientedBox, P2, wrap};
use crate::road::ego_lane::lateral_extent;
use crate::table::TableBuilder;
use crate::target::placement::{Placement, Surroundings, Target};
use crate::target::rows::Rows;
use std::f64::consts::FRAC_PI_4;
use whyroad_model::catalogue::id;
use whyroad_model::scene::Drive;

/// Half the length that a box takes up along a direction, m.
fn reach_along(footprint: &OrientedBox, heading: f64) -> f64 {
    let angle = wrap(footprint.heading - heading);
    (footprint.length * angle.cos().abs() + footprint.width * angle.sin().abs()) / 2.0
}

/// Seconds; infinite where the ego does not come up to the target, 0 beside it, NaN without a lane or a size.
fn ttc_lane(p: &Placement, around: &Surroundings<'_>) -> f64 {
    let on = around.lanes.and_then(|l| l.at(p.frame));
    let (Some((at, _, _)), Some(on), true) = (p.lane, on, p.is_sized()) else { return f64::NAN };
    let own = around.ego.footprint(p.frame);
    let forward = around.ego.forward_speed[p.frame];
    if !own.length.is_finite() || !own.width.is_finite() || !forward.is_finite() || !p.velocity.is_finite() {
        return f64::NAN;
    }
    if !p.same_level || !p.within_reach() {
        return f64::INFINITY;
    }
    let (low, high) = lateral_extent(on.corridor, &own, on.s);
    let meets = |shift: f64| at.low + shift < high && at.high + shift > low;
    let reaches = reach_along(&own, on.corridor.line.smooth_heading_at(on.s, 2.0))
        + reach_along(&p.footprint, at.heading);
    if !meets(0.0) || p.lane_ahead < -reaches {
        return f64::INFINITY;
    }
    let gap = p.lane_ahead - reaches;
    if gap <= 0.0 {
        return 0.0;
    }
    let direction = P2::from_heading(at.heading);
    let closing = forward - p.velocity.dot(direction);
    if closing <= CLOSING_LEAST_MPS {
        return f64::INFINITY;
    }
    let time = gap / closing;
    // What goes across, or towards the ego, must still be before it by then.
    let across = wrap(p.course() - at.heading).abs() > FRAC_PI_4;
    if across && !meets(p.velocity.dot(direction.left()) * time) { f64::INFINITY } else { time }
}

/// Writes `target.ttc_lane`, where there is a map.
pub fn write(drive: &Drive, around: &Surroundings<'_>, targets: &[Target<'_>], table: &mut TableBuilder<'_>) {
    if around.lanes.is_none() {
        return;
    }
    let rows = Rows::new(drive, table);
    table.number(id::TARGET_TTC_LANE, rows.placed(targets, f64::NAN, |p: &Placement| ttc_lane(p, around)));
}
