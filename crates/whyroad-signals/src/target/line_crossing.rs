//! A target at the edge of the ego's lane: whether it is across the line, how far it is inside, its distance from the
//! lane's center and its approach speed. All relative to the lane in the map.

use crate::road::ego_lane::OVER_LINE_M;
use crate::table::TableBuilder;
use crate::target::gaps::lane_lateral_speed;
use crate::target::placement::{Placement, Target};
use crate::target::rows::Rows;
use whyroad_model::Tri;
use whyroad_model::catalog::id;
use whyroad_model::scene::Drive;

/// Across an edge: more than a decimeter inside and more than a decimeter outside.
fn across_line(p: &Placement) -> Tri {
    let Some((at, left, right)) = p.lane else { return Tri::Unknown };
    if !p.is_sized() {
        return Tri::Unknown;
    }
    if !p.same_level || !p.within_reach() {
        return Tri::False;
    }
    let straddles = |inner: f64, outer: f64| inner > OVER_LINE_M && outer > OVER_LINE_M;
    let over_left = straddles(left - at.low, at.high - left);
    let over_right = straddles(right + at.high, -right - at.low);
    Tri::from(over_left || over_right)
}

/// Writes `target.wheel_over_line`, `lateral_offset`, `lane_centre_distance`, `lane_lateral_speed`.
pub fn write(drive: &Drive, targets: &[Target<'_>], table: &mut TableBuilder<'_>) {
    let rows = Rows::new(drive, table);
    let mut over = rows.column(Tri::Unknown);
    let [mut depth, mut from_center, mut speed] = [(); 3].map(|()| rows.column(f64::NAN));
    rows.each_placed(targets, |row, _, p| {
        over.0[row] = across_line(p);
        depth.0[row] = p.intrusion().unwrap_or(f64::NAN);
        from_center.0[row] = p.lane.map_or(f64::NAN, |(at, _, _)| at.lateral.abs());
        speed.0[row] = lane_lateral_speed(p).unwrap_or(f64::NAN);
    });
    table.flag(id::TARGET_WHEEL_OVER_LINE, over);
    table.number(id::TARGET_LATERAL_OFFSET, depth);
    table.number(id::TARGET_LANE_CENTRE_DISTANCE, from_center);
    table.number(id::TARGET_LANE_LATERAL_SPEED, speed);
}
