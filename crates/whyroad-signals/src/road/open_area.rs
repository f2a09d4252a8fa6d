//! Whether the ego is in an area that has no lanes by design: a car park, a yard, a square.

use crate::geometry::{P2, Polygon, p2};
use crate::road::on_road::OnRoad;
use crate::table::TableBuilder;
use std::f64::consts::PI;
use whyroad_model::Tri;
use whyroad_model::catalog::id;
use whyroad_model::road_map::LaneKind;

/// A position within this distance of a lane is a roadside, m: a parking strip and the lane beside it are narrower.
const LANE_NEAR_M: f64 = 5.0;

/// Maximum distance of lanes that continue in lanes outside of the map, m: a wide junction for which the map has the
/// arms on one side only.
const CUT_NEAR_M: f64 = 40.0;

/// Ends of the map's lanes that continue in, or come from, lanes outside of the map.
fn cut_ends(on: &OnRoad<'_>) -> Vec<P2> {
    let mut ends = Vec::new();
    for (i, lane) in on.road.lanes.iter().enumerate() {
        let (Some(given), Some(first), Some(last)) =
            (on.lane(i), lane.center.points().first(), lane.center.points().last())
        else {
            continue;
        };
        if !given.successors.is_empty() && lane.successors.is_empty() {
            ends.push(*last);
        }
        if !given.predecessors.is_empty() && lane.predecessors.is_empty() {
            ends.push(*first);
        }
    }
    ends
}

/// Whether the map ends before this position: its lanes are far away, and all of them are on one side.
fn beyond_all_lanes(on: &OnRoad<'_>, at: P2) -> bool {
    if !on.road.lanes_near(at, CUT_NEAR_M).is_empty() {
        return false;
    }
    let points = on.road.lanes.iter().flat_map(|lane| lane.center.points());
    let mut directions: Vec<f64> = points.map(|&p| (p - at).heading()).collect();
    directions.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (directions.first(), directions.last()) else { return false };
    let round = first + 2.0 * PI - last;
    directions.windows(2).map(|pair| pair[1] - pair[0]).fold(round, f64::max) > PI
}

/// Writes `map.open_area`; nothing for maps that state neither car parks nor drivable areas.
pub fn write(on: &OnRoad<'_>, table: &mut TableBuilder<'_>) {
    if on.road.drivable.is_empty() && !on.map.covers("parking") {
        return;
    }
    let parks = on.map.facilities.iter().filter(|f| f.kind == "parking");
    let mut areas: Vec<Polygon> =
        parks.filter_map(|f| Polygon::new(f.boundary.iter().map(|p| p2(p.x, p.y)))).collect();
    areas.extend(on.road.drivable.iter().cloned());
    // The ego's last lane continues in lanes outside of the map.
    let mut cut = false;
    let cut_off: Vec<bool> = (0..on.frames())
        .map(|frame| {
            if let Some(at) = on.lanes.places[frame] {
                let leads_out = on.lane(at.lane).is_some_and(|l| !l.successors.is_empty());
                cut = leads_out && on.road.lanes[at.lane].successors.is_empty();
            }
            cut
        })
        .collect();
    let ends = cut_ends(on);
    let open = |frame: usize| {
        let at = on.ego.position[frame];
        let cut_near = || ends.iter().any(|end| (*end - at).norm() < CUT_NEAR_M);
        let beyond = || cut_off[frame] || cut_near() || beyond_all_lanes(on, at);
        if !on.map.covers("parking") && beyond() {
            return Tri::Unknown;
        }
        let lane_near = || {
            let near = on.road.lanes_near(at, LANE_NEAR_M);
            near.into_iter().any(|l| {
                let lane = &on.road.lanes[l];
                lane.kind != LaneKind::Sidewalk
                    && lane.area.as_ref().map_or(lane.center.distance(at), |a| a.distance(at)) < LANE_NEAR_M
            })
        };
        Tri::from(areas.iter().any(|a| a.contains(at)) && !lane_near())
    };
    table.flag(id::MAP_OPEN_AREA, on.flags(open));
}
