//! Positions of targets on the map: crosswalks, road, junction. Distances are to the target's box center.

use crate::geometry::{LastPlace, NearAreas, p2};
use crate::road::network::Road;
use crate::table::TableBuilder;
use crate::target::rows::Rows;
use whyroad_model::Tri;
use whyroad_model::catalog::id;
use whyroad_model::scene::{Drive, Track};

/// Maximum distance from a crosswalk's edge that counts as on it: 1 m (RefAV at_pedestrian_crossing).
const ON_CROSSWALK_M: f64 = 1.0;

/// Writes `target.on_crosswalk`, `distance_to_crosswalk`, `on_road`, `in_junction`.
pub fn write(drive: &Drive, road: &Road, table: &mut TableBuilder<'_>) {
    let rows = Rows::new(drive, table);
    let center = |t: &Track, r: usize| Some(p2(t.motion.x[r], t.motion.y[r])).filter(|p| p.is_finite());
    let (to_crosswalk, on_road, in_junction) = (LastPlace::new(), LastPlace::new(), LastPlace::new());
    let crosswalks = NearAreas::new(&road.crosswalks);
    let distance = |p| to_crosswalk.at(p, || crosswalks.distance(p));
    let distance = rows.numbers(|t, r| center(t, r).map_or(f64::NAN, distance));
    let on = distance.map(|&d| if d.is_nan() { Tri::Unknown } else { Tri::from(d <= ON_CROSSWALK_M) });
    table.flag(id::TARGET_ON_CROSSWALK, on);
    table.number(id::TARGET_DISTANCE_TO_CROSSWALK, distance);
    let on_road = |p| on_road.at(p, || road.on_road(p));
    table.flag(id::TARGET_ON_ROAD, rows.flags(|t, r| center(t, r).map(on_road).into()));
    let in_junction = |p| in_junction.at(p, || road.in_junction(p));
    table.flag(id::TARGET_IN_JUNCTION, rows.flags(|t, r| center(t, r).map(in_junction).into()));
}
