//! The route: what the guidance says, and whether the ego's lane allows it.

use crate::road::context::Channels;
use crate::road::lane_rules::turns_ahead;
use crate::road::on_road::OnRoad;
use crate::road::way::beside;
use crate::table::TableBuilder;
use std::collections::BTreeSet;
use whyroad_model::catalogue::{
    CategoryValue, id,
    value::{EgoMovement, RouteCommand},
};
use whyroad_model::scene::EgoBus;
use whyroad_model::{Drive, Tri};

/// Junctions farther ahead do not ask for a lane yet, m.
const REACH_M: f64 = 300.0;

fn command(bus: &EgoBus, frame: usize) -> Option<&str> {
    bus.route_command.get(frame)?.as_deref()
}

/// Writes `route.command` and `route.distance`.
pub fn write_stated(drive: &Drive, channels: &Channels<'_>, table: &mut TableBuilder<'_>) {
    let known = |bus: &&EgoBus| bus.route_command.iter().any(Option::is_some);
    if let Some(bus) = drive.ego.as_ref().map(|e| &e.bus).filter(known) {
        let stated = |i: usize| command(bus, i).and_then(RouteCommand::from_name);
        table.category(id::ROUTE_COMMAND, (0..drive.times.len()).map(stated));
    }
    if channels.has("route_distance") {
        table.number(id::ROUTE_DISTANCE, channels.numbers("route_distance"));
    }
}

/// Turn of the route at the next junction: by the command, else as the ego then turned.
fn turn(on: &OnRoad<'_>, frame: usize) -> Option<EgoMovement> {
    let commanded =
        on.drive.ego.as_ref().and_then(|e| command(&e.bus, frame)).and_then(EgoMovement::from_name);
    commanded.or_else(|| {
        let next = on.encounters.here_or_next(on.path.ego_s[frame], on.ego.front(), REACH_M)?;
        on.encounters.movement(next)
    })
}

/// The lanes behind the next junction to which `lane` leads without a change of lane; empty where the map does not say.
fn exits(on: &OnRoad<'_>, lane: usize) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    let mut seen = BTreeSet::from([lane]);
    let mut open = vec![(lane, on.road.lanes[lane].in_junction, 0.0)];
    while let Some((at, entered, length)) = open.pop() {
        for &next in &on.road.lanes[at].successors {
            let inside = on.road.lanes[next].in_junction;
            if entered && !inside {
                found.insert(next);
            } else if length < REACH_M && seen.insert(next) {
                open.push((next, inside, length + on.road.lanes[next].centre.length()));
            }
        }
    }
    found
}

/// Whether the ego's lane leads to the exit of the next junction that the ego then takes, or to a lane beside that one;
/// `None` where the map or the recording does not tell. Two exits may lie in one direction.
fn leads_to_exit(on: &OnRoad<'_>, lane: usize, frame: usize) -> Option<bool> {
    let next = on.encounters.here_or_next(on.path.ego_s[frame], on.ego.front(), REACH_M)?;
    let behind = on.encounters.junctions[next].to;
    let taken = (frame..on.frames())
        .filter(|&i| on.path.ego_s[i] > behind)
        .find_map(|i| on.lanes.at(i).map(|place| place.lane))
        .filter(|&l| !on.road.lanes[l].in_junction)?;
    let reached = exits(on, lane);
    let road: BTreeSet<usize> = std::iter::once(taken).chain(beside(on.road, taken)).collect();
    (!reached.is_empty()).then(|| !reached.is_disjoint(&road))
}

fn fits(on: &OnRoad<'_>, frame: usize) -> Tri {
    let Some((way, s)) = on.ways.at(frame) else { return Tri::Unknown };
    let commanded = on.drive.ego.as_ref().and_then(|e| command(&e.bus, frame)).is_some();
    let lane = way.steps[way.step_at(s)].lane;
    if !commanded && let Some(leads) = leads_to_exit(on, lane, frame) {
        return Tri::from(leads);
    }
    match turns_ahead(on, way, s + on.ego.front(), REACH_M) {
        None => Tri::True,
        Some(allowed) => turn(on, frame).map(|t| allowed.contains(&t)).into(),
    }
}

/// Writes `route.lane_fits`.
pub fn write_fit(on: &OnRoad<'_>, table: &mut TableBuilder<'_>) {
    table.flag(id::ROUTE_LANE_FITS, on.flags(|i| fits(on, i)));
}
