//! The current or next junction on the ego's path: lights, arms, exits; and whether the next crosswalk belongs to a
//! junction with lights.

use crate::road::beside_path;
use crate::road::junction::{HORIZON_M, distance_to_next};
use crate::road::junction_arms::{JunctionArms, groups};
use crate::road::network::Road;
use crate::road::on_road::{OnRoad, time_to};
use crate::road::path::DrivenPath;
use crate::road::stretch::Stretch;
use crate::road::way::beside;
use crate::table::TableBuilder;
use std::collections::BTreeSet;
use whyroad_model::Tri;
use whyroad_model::catalog::id;

/// Maximum distance of a junction whose lights are considered, m.
const LIGHTS_REACH_M: f64 = 100.0;
/// Maximum distance between a crosswalk and the junction on the path to which it belongs, m.
const CROSSWALK_REACH_M: f64 = 15.0;
/// Maximum distance of a light in the map beside the path, and before or behind its junction, m.
const LIGHT_REACH_M: f64 = 10.0;
/// Sampling step of the path inside a junction, m.
const STEP_M: f64 = 1.0;

/// A junction on the path.
struct Crossing {
    arms: JunctionArms,
    lights: Tri,
}

/// The group of junction lanes of which the path crosses most between two arc lengths.
fn group_on_path(road: &Road, path: &DrivenPath, groups: &[Vec<usize>], from: f64, to: f64) -> Vec<usize> {
    let steps = ((to - from) / STEP_M) as usize;
    let mut hits = vec![0usize; groups.len()];
    for k in 0..=steps {
        let near = road.lanes_near(path.line.point_at(from + k as f64 * STEP_M), 0.5);
        for (hits, group) in hits.iter_mut().zip(groups) {
            *hits += near.iter().filter(|l| group.binary_search(l).is_ok()).count();
        }
    }
    let best = (0..groups.len()).rev().max_by_key(|&k| hits[k]).filter(|&k| hits[k] > 0);
    best.map(|k| groups[k].clone()).unwrap_or_default()
}

/// Ranges where the path passes lights in the map; `None` if the map has none.
fn drawn_lights(on: &OnRoad<'_>) -> Option<Vec<Stretch>> {
    let lights = on.map.facilities.iter().filter(|f| f.kind == "traffic_light");
    on.map
        .covers("traffic_light")
        .then(|| lights.flat_map(|f| beside_path::parts(on.path, f, LIGHT_REACH_M)).collect())
}

fn crossings(on: &OnRoad<'_>) -> Vec<Crossing> {
    let groups = groups(on.road, |lane| on.lane(lane).and_then(|l| l.junction_id.clone()));
    let controlled: Option<BTreeSet<&str>> =
        on.drive.lights.as_ref().map(|states| states.iter().map(|s| s.lane_id.as_str()).collect());
    let drawn = drawn_lights(on);
    let stretches = on.encounters.junctions.iter();
    stretches
        .map(|j| {
            let arms = JunctionArms::new(on.road, group_on_path(on.road, on.path, &groups, j.from, j.to));
            let mut lanes = arms.inside.iter().chain(&arms.entries);
            let lights =
                controlled.as_ref().map(|c| lanes.any(|&l| c.contains(on.road.lanes[l].id.as_str())));
            let near = |l: &Stretch| l.to >= j.from - LIGHT_REACH_M && l.from <= j.to + LIGHT_REACH_M;
            let shown = lights == Some(true) || drawn.as_ref().is_some_and(|d| d.iter().any(near));
            // Only a log with light states, or a map with all lights, shows that there is none.
            let lights = match shown {
                true => Tri::True,
                false if lights.is_some() || on.map.tells_all("traffic_light") => Tri::False,
                false => Tri::Unknown,
            };
            Crossing { arms, lights }
        })
        .collect()
}

/// Lanes of the approach by which the ego enters junction `crossing`: its last lane before it and the adjacent ones.
fn approach(on: &OnRoad<'_>, crossing: &Crossing, frame: usize) -> Option<Vec<usize>> {
    let (way, s) = on.ways.at(frame)?;
    let here = way.step_at(s);
    let inside = |lane: usize| crossing.arms.inside.binary_search(&lane).is_ok();
    let last = if inside(way.steps[here].lane) {
        // Already inside: the lane from which its lane leads.
        let mut lane = way.steps[here].lane;
        for _ in 0..8 {
            let Some(&before) = on.road.lanes[lane].predecessors.first().filter(|_| inside(lane)) else {
                break;
            };
            lane = before;
        }
        lane
    } else {
        let first = (here + 1..way.steps.len()).find(|&k| inside(way.steps[k].lane))?;
        way.steps[first - 1].lane
    };
    Some(std::iter::once(last).chain(beside(on.road, last)).collect())
}

/// The lane by which the ego leaves junction `crossing`, as far as the drive shows.
fn exit(on: &OnRoad<'_>, crossing: &Crossing, frame: usize) -> Option<usize> {
    let (way, s) = on.ways.at(frame)?;
    let inside = |k: &usize| crossing.arms.inside.binary_search(&way.steps[*k].lane).is_ok();
    let first = (way.step_at(s)..way.steps.len()).find(inside)?;
    (first..way.steps.len()).find(|k| !inside(k)).map(|k| way.steps[k].lane)
}

fn crosswalk_lights(on: &OnRoad<'_>, crossings: &[Crossing], frame: usize) -> Tri {
    let (s, front) = (on.path.ego_s[frame], on.ego.front());
    let ahead =
        on.encounters.crosswalks.iter().find(|c| c.to >= s).filter(|c| c.from - s - front <= HORIZON_M);
    let Some(walk) = ahead else { return Tri::False };
    let near = on
        .encounters
        .junctions
        .iter()
        .position(|j| j.from - CROSSWALK_REACH_M <= walk.to && walk.from <= j.to + CROSSWALK_REACH_M);
    // Not at a junction: its own light would be one of a lane that it crosses, which maps do not state.
    near.map_or(Tri::False, |k| crossings[k].lights)
}

/// Writes `map.time_to_junction`, `time_to_crosswalk`, `junction_signalised`, `junction_stated`, `junction_arms`,
/// `junction_irregular`, `junction_exits`, `opposing_arm`, `crosswalk_signalised`.
pub fn write(on: &OnRoad<'_>, table: &mut TableBuilder<'_>) {
    let (found, front) = (on.encounters, on.ego.front());
    let crossings = crossings(on);
    let frames = || 0..on.frames();
    let s = |i: usize| on.path.ego_s[i];
    let time = |i: usize, distance: f64| time_to(distance, on.ego.forward_speed[i]);
    let to_junction = |i: usize| time(i, found.distance_to_junction(s(i), front));
    let to_crosswalk = |i: usize| time(i, distance_to_next(&found.crosswalks, s(i), front));
    table.number(id::MAP_TIME_TO_JUNCTION, frames().map(to_junction).collect());
    table.number(id::MAP_TIME_TO_CROSSWALK, frames().map(to_crosswalk).collect());
    let within = |i: usize, reach: f64| found.here_or_next(s(i), front, reach).map(|k| &crossings[k]);
    let flags = |reach: f64, value: &dyn Fn(usize) -> Tri| {
        on.flags(|i| if found.is_in_doubt(s(i), front, reach) { Tri::Unknown } else { value(i) })
    };
    let lights = |i: usize| within(i, LIGHTS_REACH_M).map_or(Tri::False, |c| c.lights);
    table.flag(id::MAP_JUNCTION_SIGNALISED, flags(LIGHTS_REACH_M, &lights));
    let stated = |i: usize| found.here_or_next(s(i), front, HORIZON_M).is_some_and(|k| found.stated[k]);
    table.flag(id::MAP_JUNCTION_STATED, flags(HORIZON_M, &|i| Tri::from(stated(i))));
    let number = |value: &dyn Fn(usize, &Crossing) -> f64| -> Vec<f64> {
        let is_known = |i: usize| on.ego.is_known(i) && !found.is_in_doubt(s(i), front, HORIZON_M);
        let of = |i: usize| within(i, HORIZON_M).map_or(0.0, |c| value(i, c));
        frames().map(|i| if is_known(i) { of(i) } else { f64::NAN }).collect()
    };
    // The arms of a junction area without lanes inside are unknown.
    let known = |c: &Crossing, value: usize| if c.arms.inside.is_empty() { f64::NAN } else { value as f64 };
    table.number(id::MAP_JUNCTION_ARMS, number(&|_, c| known(c, c.arms.count())));
    let exits = |i: usize, c: &Crossing| {
        approach(on, c, i).map_or(f64::NAN, |lanes| known(c, c.arms.reached(on.road, &lanes)))
    };
    table.number(id::MAP_JUNCTION_EXITS, number(&exits));
    let irregular = |c: &Crossing| {
        if c.arms.inside.is_empty() { Tri::Unknown } else { Tri::from(c.arms.is_irregular()) }
    };
    let irregular = |i: usize| within(i, HORIZON_M).map_or(Tri::False, irregular);
    table.flag(id::MAP_JUNCTION_IRREGULAR, flags(HORIZON_M, &irregular));
    let opposed = |i: usize, c: &Crossing| match approach(on, c, i).and_then(|lanes| lanes.first().copied()) {
        Some(lane) if !c.arms.inside.is_empty() => {
            Tri::from(c.arms.is_opposed(on.road, lane, exit(on, c, i)))
        }
        _ => Tri::Unknown,
    };
    let opposed = |i: usize| within(i, HORIZON_M).map_or(Tri::False, |c| opposed(i, c));
    table.flag(id::MAP_OPPOSING_ARM, flags(HORIZON_M, &opposed));
    table.flag(id::MAP_CROSSWALK_SIGNALISED, on.flags(|i| crosswalk_lights(on, &crossings, i)));
}
