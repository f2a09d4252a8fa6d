//! Signs and stop lines on the ego's path.

use crate::geometry::{P2, p2};
use crate::road::facilities::line_crossings;
use crate::road::junction::{Stretch, distance_to_next};
use crate::road::network::DEFAULT_HALF_WIDTH_M;
use crate::road::on_road::{OnRoad, time_to};
use crate::table::TableBuilder;
use std::collections::BTreeSet;
use whyroad_model::catalogue::{Number, PerFrame, Signal, id};
use whyroad_model::road_map::Sign;
use whyroad_model::vocabulary::PROHIBITIONS;

/// Signals of a distance, with the kind of sign that each is about.
const DISTANCES: [(Signal<PerFrame, Number>, &str); 6] = [
    (id::SIGN_STOP_DISTANCE, "stop"),
    (id::SIGN_YIELD_DISTANCE, "yield"),
    (id::SIGN_SPEED_LIMIT_DISTANCE, "speed_limit"),
    (id::SIGN_LANE_ARROW_DISTANCE, "lane_arrow"),
    (id::SIGN_PROHIBITION_DISTANCE, "prohibition"),
    (id::SIGN_WARNING_DISTANCE, "warning"),
];
/// A sign that names no lane concerns who passes it no farther away than this, m.
const BESIDE_M: f64 = 12.0;
/// A sign that names a lane of the ego's route stands no farther from its path than this, m.
const OF_LANE_M: f64 = 40.0;

/// Ids of the lanes that the ego is ever in, and of those ahead of its last one.
fn route(on: &OnRoad<'_>) -> BTreeSet<String> {
    let id = |lane: usize| on.road.lanes[lane].id.clone();
    let mut lanes: BTreeSet<String> =
        (0..on.frames()).filter_map(|i| on.lanes.at(i)).map(|at| id(at.lane)).collect();
    if let Some((way, _)) = (0..on.frames()).rev().find_map(|i| on.ways.at(i)) {
        lanes.extend(way.steps.iter().map(|step| id(step.lane)));
    }
    lanes
}

fn places(on: &OnRoad<'_>, wanted: impl Fn(&Sign) -> bool, route: &BTreeSet<String>) -> Vec<Stretch> {
    let mut found: Vec<Stretch> = Vec::new();
    for sign in on.map.signs.iter().filter(|s| wanted(s)) {
        let at = on.path.line.project(p2(sign.position.x, sign.position.y));
        let concerned = if sign.lane_ids.is_empty() {
            at.lateral.abs() <= BESIDE_M
        } else {
            at.lateral.abs() <= OF_LANE_M && sign.lane_ids.iter().any(|l| route.contains(l))
        };
        if concerned {
            found.push(Stretch { from: at.s, to: at.s });
        }
    }
    found.sort_by(|a, b| a.from.total_cmp(&b.from));
    found
}

/// Where the path crosses a stop line; one that is given by a point alone, where the path passes it within half a lane.
fn stop_lines(on: &OnRoad<'_>) -> Vec<Stretch> {
    let mut found: Vec<Stretch> = Vec::new();
    for line in &on.map.stop_lines {
        let corners: Vec<P2> = line.line.iter().map(|p| p2(p.x, p.y)).collect();
        if let [point] = corners[..] {
            let at = on.path.line.project(point);
            found.extend(
                (at.lateral.abs() <= DEFAULT_HALF_WIDTH_M).then_some(Stretch { from: at.s, to: at.s }),
            );
            continue;
        }
        found.extend(line_crossings(on.path, &corners).into_iter().map(|s| Stretch { from: s, to: s }));
    }
    found.sort_by(|a, b| a.from.total_cmp(&b.from));
    found
}

/// Writes `sign.*`, `map.distance_to_stop_line`, `map.time_to_stop_line`.
pub fn write(on: &OnRoad<'_>, table: &mut TableBuilder<'_>) {
    let front = on.ego.front();
    let next = |stretches: &[Stretch]| -> Vec<f64> {
        (0..on.frames()).map(|i| distance_to_next(stretches, on.path.ego_s[i], front)).collect()
    };
    let route = route(on);
    for (id, kind) in DISTANCES {
        let one = [kind];
        let kinds = if kind == "prohibition" { PROHIBITIONS } else { &one[..] };
        if kinds.iter().any(|kind| on.map.tells(kind)) {
            let found = places(on, |s| kinds.contains(&s.kind.as_str()), &route);
            table.number(id, next(&found));
        }
    }
    let lines = stop_lines(on);
    // A map without any has none drawn; that is not to say that there is none.
    let distance = if on.map.stop_lines.is_empty() { vec![f64::NAN; on.frames()] } else { next(&lines) };
    let time = distance.iter().zip(&on.ego.forward_speed).map(|(&d, &v)| time_to(d, v)).collect();
    table.number(id::MAP_DISTANCE_TO_STOP_LINE, distance);
    table.number(id::MAP_TIME_TO_STOP_LINE, time);
}
