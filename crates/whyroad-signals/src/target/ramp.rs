//! Whether a target drives where traffic joins the main road: on a ramp, or on the acceleration lane. From the map's
//! tags and the lanes to which they lead; the ego's position is handled in `merging`.

use crate::road::network::Road;
use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use crate::target::rows::Rows;
use whyroad_model::Tri;
use whyroad_model::catalog::id;
use whyroad_model::road_map::RoadMap;

/// Maximum length of an acceleration lane behind a ramp, m (as for `map.merge_zone`).
const ZONE_M: f64 = 500.0;

/// Lanes from which traffic joins: ramps, acceleration lanes, and short lanes onto which a ramp leads, directly or over
/// one more piece.
fn joining(road: &Road, map: &RoadMap) -> Vec<bool> {
    let tagged = |l: usize, tag: &str| map.lane(&road.lanes[l].id).is_some_and(|lane| lane.is_tagged(tag));
    let after_ramp = |l: usize| {
        let before = &road.lanes[l].predecessors;
        let further = before.iter().flat_map(|&p| road.lanes[p].predecessors.iter());
        before.iter().chain(further).any(|&p| tagged(p, "ramp"))
    };
    (0..road.lanes.len())
        .map(|l| {
            let short = road.lanes[l].center.length() < ZONE_M && !road.lanes[l].in_junction;
            tagged(l, "ramp") || tagged(l, "acceleration") || (short && after_ramp(l))
        })
        .collect()
}

/// True when the map has data on ramps.
fn covers(map: &RoadMap) -> bool {
    map.complete_for.iter().any(|k| k == "ramp")
        || map.lanes.iter().any(|l| ["ramp", "acceleration", "deceleration"].iter().any(|t| l.is_tagged(t)))
}

/// Writes `target.on_ramp`; leaves it unavailable where the map has no data on ramps.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let (Some(map), Some(road), Some(lanes)) = (&scene.drive.map, scene.around.road, scene.lanes()) else {
        return;
    };
    if !covers(map) {
        return;
    }
    let joining = joining(road, map);
    let rows = Rows::new(scene.drive, table);
    let on_one =
        |k: usize, r: usize| lanes.at(k, r).map_or(Tri::Unknown, |place| Tri::from(joining[place.lane]));
    table.flag(id::TARGET_ON_RAMP, rows.spread(scene.targets, Tri::Unknown, |k, r, _| on_one(k, r)));
}
