//! The route: the guidance's commands, and whether the ego's lane fits them.

use crate::road::context::Channels;
use crate::road::lane_rules::turns_ahead;
use crate::road::on_road::OnRoad;
use crate::road::way::beside;
use crate::table::TableBuilder;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::catalog::{
    CategoryValue, id,
    value::{EgoMovement, RouteCommand},
};
use whyroad_model::scene::EgoBus;
use whyroad_model::{Drive, Tri};

/// Maximum distance of a junction that requires a lane, m.
const REACH_M: f64 = 300.0;
/// Maximum distance of a fork or an exit that requires a lane, m: the position of the last sign before an exit.
const FORK_M: f64 = 500.0;
/// Maximum length of a link between roads, whose neighbors the map does not state, m.
const PIECE_M: f64 = 30.0;

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

/// Turn of the route at the next junction: from the command, else the ego's later turn.
fn turn(on: &OnRoad<'_>, frame: usize) -> Option<EgoMovement> {
    let commanded =
        on.drive.ego.as_ref().and_then(|e| command(&e.bus, frame)).and_then(EgoMovement::from_name);
    commanded.or_else(|| {
        let next = on.encounters.here_or_next(on.path.ego_s[frame], on.ego.front(), REACH_M)?;
        on.encounters.movement(next)
    })
}

/// The lanes behind the next junction to which `lane` leads without a lane change; empty if the map has no data.
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
                open.push((next, inside, length + on.road.lanes[next].center.length()));
            }
        }
    }
    found
}

/// Whether the ego's lane leads to the exit of the next junction that the ego takes later, or to an adjacent lane;
/// `None` if the map or the recording does not show it. Two exits may have the same direction.
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

/// The ego's last lane before it has driven [`FORK_M`] or reaches a junction, without links; `visits` are the first
/// frames of its stays in lanes.
fn taken(on: &OnRoad<'_>, visits: &[usize], frame: usize) -> Option<(usize, f64)> {
    let next = visits.partition_point(|&first| first <= frame);
    let driven = |i: usize| on.path.ego_s[i] - on.path.ego_s[frame];
    visits[next..]
        .iter()
        .filter_map(|&i| on.lanes.at(i).map(|place| (place.lane, driven(i))))
        .take_while(|&(lane, driven)| driven < FORK_M && !on.road.lanes[lane].in_junction)
        .filter(|&(lane, _)| on.road.lanes[lane].center.length() >= PIECE_M)
        .last()
}

/// Whether the lane leads along the road on which the ego drives later, where roads split or a lane leaves; `None` if
/// the map does not show how the lane continues. `s` is the ego's position on it.
fn leads_along(on: &OnRoad<'_>, visits: &[usize], (lane, s): (usize, f64), frame: usize) -> Option<bool> {
    let (taken, driven) = taken(on, visits, frame)?;
    let length = |lane: usize| on.road.lanes[lane].center.length();
    // Distances of the ends of the lanes to which it leads.
    let mut ends = BTreeMap::from([(lane, length(lane) - s)]);
    let mut open = vec![lane];
    while let Some(at) = open.pop().filter(|_| ends.len() < 500) {
        let from = ends[&at];
        for &next in on.road.lanes[at].successors.iter().filter(|_| from < FORK_M + PIECE_M) {
            if ends.insert(next, from + length(next)).is_none() {
                open.push(next);
            }
        }
    }
    let along = std::iter::once(taken).chain(beside(on.road, taken)).any(|l| ends.contains_key(&l));
    (along || ends.values().any(|&end| end > driven + PIECE_M)).then_some(along)
}

fn fits(on: &OnRoad<'_>, visits: &[usize], frame: usize) -> Tri {
    let Some((way, s)) = on.ways.at(frame) else { return Tri::Unknown };
    let commanded = on.drive.ego.as_ref().and_then(|e| command(&e.bus, frame)).is_some();
    let lane = way.steps[way.step_at(s)].lane;
    if !commanded && let Some(leads) = leads_to_exit(on, lane, frame) {
        return Tri::from(leads);
    }
    let on_lane = (lane, s - way.steps[way.step_at(s)].from);
    match turns_ahead(on, way, s + on.ego.front(), REACH_M) {
        None => Tri::from(leads_along(on, visits, on_lane, frame).unwrap_or(true)),
        Some(allowed) => turn(on, frame).map(|t| allowed.contains(&t)).into(),
    }
}

/// Writes `route.lane_fits`.
pub fn write_fit(on: &OnRoad<'_>, table: &mut TableBuilder<'_>) {
    let lane = |i: usize| on.lanes.at(i).map(|place| place.lane);
    let visits: Vec<usize> = (0..on.frames()).filter(|&i| i == 0 || lane(i) != lane(i - 1)).collect();
    table.flag(id::ROUTE_LANE_FITS, on.flags(|i| fits(on, &visits, i)));
}
