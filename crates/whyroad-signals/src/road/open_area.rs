//! Whether the ego is where there are no lanes by design: a car park, a yard, a square.

use crate::geometry::{Polygon, p2};
use crate::road::on_road::OnRoad;
use crate::table::TableBuilder;
use whyroad_model::Tri;
use whyroad_model::catalogue::id;
use whyroad_model::road_map::LaneKind;

/// A lane this near makes it a roadside, m: a parking strip and a lane beside it are narrower.
const LANE_NEAR_M: f64 = 5.0;

/// Writes `map.open_area`; nothing for maps that state neither car parks nor where one can drive.
pub fn write(on: &OnRoad<'_>, table: &mut TableBuilder<'_>) {
    if on.road.drivable.is_empty() && !on.map.covers("parking") {
        return;
    }
    let parks = on.map.facilities.iter().filter(|f| f.kind == "parking");
    let mut areas: Vec<Polygon> =
        parks.filter_map(|f| Polygon::new(f.boundary.iter().map(|p| p2(p.x, p.y)))).collect();
    areas.extend(on.road.drivable.iter().cloned());
    let open = |frame: usize| {
        let at = on.ego.position[frame];
        let lane_near = || {
            let near = on.road.lanes_near(at, LANE_NEAR_M);
            near.into_iter().any(|l| {
                let lane = &on.road.lanes[l];
                lane.kind != LaneKind::Sidewalk
                    && lane.area.as_ref().map_or(lane.centre.distance(at), |a| a.distance(at)) < LANE_NEAR_M
            })
        };
        Tri::from(areas.iter().any(|a| a.contains(at)) && !lane_near())
    };
    table.flag(id::MAP_OPEN_AREA, on.flags(open));
}
