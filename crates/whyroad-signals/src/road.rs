//! The road: the prepared map, the lanes, the ego's path on it, and the map's data beside and ahead of it.

pub mod beside_path;
pub mod context;
pub mod corridor;
pub mod crossroads;
pub mod curvature;
pub mod cut_traversal;
pub mod doubtful;
pub mod ego_lane;
pub mod facilities;
pub mod junction;
pub mod junction_arms;
pub mod lane_change;
pub mod lane_ids;
pub mod lane_rules;
pub mod lanes;
pub mod lights;
pub mod merging;
pub mod network;
pub mod on_road;
pub mod open_area;
pub mod own_shift;
pub mod own_turns;
pub mod path;
pub mod profile;
pub mod proven_turns;
pub mod roadside;
pub mod route;
pub mod stretch;
pub mod terrain;
pub mod way;

use crate::table::TableBuilder;
use context::Channels;
use on_road::OnRoad;
use whyroad_model::catalog::{id, value::MapDrivingSide};
use whyroad_model::scene::DrivingSide;

/// Writes the signals about road, map parts, signs and route.
pub fn write(on: &OnRoad<'_>, table: &mut TableBuilder<'_>) {
    let channels = Channels::new(on.drive);
    profile::write(on, table);
    lane_rules::write(on, table);
    lane_rules::write_marked(on, &channels, table);
    merging::write(on, table);
    crossroads::write(on, table);
    roadside::write(on, table);
    open_area::write(on, table);
    facilities::write(on, &channels, table);
    route::write_fit(on, table);
    let side = on.drive.driving_side().map(|side| match side {
        DrivingSide::Right => MapDrivingSide::Right,
        DrivingSide::Left => MapDrivingSide::Left,
    });
    table.category(id::MAP_DRIVING_SIDE, vec![side; on.frames()]);
    if on.map.lanes.iter().any(|l| l.is_tagged("unpaved")) {
        let unpaved: Vec<Option<bool>> =
            (0..on.frames()).map(|i| on.own_lane(i).map(|l| l.is_tagged("unpaved"))).collect();
        context::write_pavement(&channels, &unpaved, table);
    }
}
