//! The traffic light for the ego's own movement: the next one on its lane's continuation that the log knows.

use crate::ego_lane::{EgoLane, OnCorridor};
use crate::ego_motion::EgoMotion;
use crate::geometry::p2;
use crate::road::Road;
use crate::table::TableBuilder;
use std::collections::BTreeMap;
use whyroad_model::scene::{LightColour, LightState};
use whyroad_model::{Nanos, RoadMap};

/// Lights farther ahead do not concern the ego yet, m.
const REACH_M: f64 = 100.0;

/// Index in the catalogue's values of light.state when no light is ahead.
const NONE: u16 = 0;

/// Index in the catalogue's values; `None` for what the log could not tell.
fn code(colour: LightColour) -> Option<u16> {
    Some(match colour {
        LightColour::Red => 1,
        LightColour::Yellow => 2,
        LightColour::Green => 3,
        LightColour::GreenYield => 4,
        LightColour::RedYellow => 5,
        LightColour::FlashingYellow => 6,
        LightColour::Off => 7,
        LightColour::Unknown => return None,
    })
}

struct Lights<'a> {
    by_lane: BTreeMap<&'a str, Vec<&'a LightState>>,
    stop_lines: BTreeMap<&'a str, crate::geometry::P2>,
}

impl<'a> Lights<'a> {
    fn new(states: &'a [LightState], map: &'a RoadMap) -> Self {
        let mut by_lane: BTreeMap<&str, Vec<&LightState>> = BTreeMap::new();
        for state in states {
            by_lane.entry(state.lane_id.as_str()).or_default().push(state);
        }
        let mut stop_lines = BTreeMap::new();
        for line in map.stop_lines.iter().filter(|l| !l.line.is_empty()) {
            let n = line.line.len() as f64;
            let middle = line.line.iter().fold(p2(0.0, 0.0), |acc, p| acc + p2(p.x, p.y) * (1.0 / n));
            stop_lines.extend(line.lane_ids.iter().map(|id| (id.as_str(), middle)));
        }
        Self { by_lane, stop_lines }
    }

    /// The latest state at `time` of the light on `lane` that concerns a way over the lanes `onward`.
    fn state(&self, lane: &str, onward: &[&str], time: Nanos) -> Option<LightColour> {
        let concerns = |s: &&&LightState| s.to_lane_id.as_deref().is_none_or(|to| onward.contains(&to));
        let states = self.by_lane.get(lane)?.iter().filter(concerns).filter(|s| s.time <= time);
        states.max_by_key(|s| s.time).map(|s| s.colour)
    }

    /// The next light on the corridor: its colour, when known at `time`, and the distance of its stop line from
    /// the ego's front bumper, m.
    fn next(
        &self,
        road: &Road,
        on: OnCorridor<'_>,
        front: f64,
        time: Nanos,
    ) -> Option<(Option<LightColour>, f64)> {
        let chain = &on.corridor.lanes;
        for (k, &(lane, start)) in chain.iter().enumerate() {
            let id = road.lanes[lane].id.as_str();
            let end = on.corridor.lane_end(k);
            if end < on.s || !self.by_lane.contains_key(id) {
                continue;
            }
            // A light on a junction's lane is met at its beginning, one on an approach at its end.
            let drawn = self
                .stop_lines
                .get(id)
                .map(|&p| on.corridor.line.project_between(p, start - 5.0, end + 5.0).s);
            let stop = drawn.unwrap_or(if road.lanes[lane].in_junction { start } else { end });
            if stop < on.s {
                continue;
            }
            if stop - on.s > REACH_M {
                return None;
            }
            let onward: Vec<&str> = chain[k..].iter().map(|&(l, _)| road.lanes[l].id.as_str()).collect();
            return Some((self.state(id, &onward, time), (stop - on.s - front).max(0.0)));
        }
        None
    }
}

/// Writes `light.state` and `light.distance_to_stop_line`.
pub fn write(
    states: &[LightState],
    map: &RoadMap,
    road: &Road,
    lanes: &EgoLane,
    ego: &EgoMotion,
    times: &[Nanos],
    table: &mut TableBuilder<'_>,
) {
    let lights = Lights::new(states, map);
    let front = if ego.length.is_finite() { ego.length / 2.0 } else { 0.0 };
    let (mut codes, mut distances) = (Vec::with_capacity(ego.len()), Vec::with_capacity(ego.len()));
    for (i, &time) in times.iter().enumerate() {
        let (state, distance) = match lanes.at(i) {
            None => (None, f64::NAN),
            Some(on) => match lights.next(road, on, front, time) {
                None => (Some(NONE), f64::INFINITY),
                Some((colour, distance)) => (colour.and_then(code), distance),
            },
        };
        codes.push(state);
        distances.push(distance);
    }
    table.category("light.state", codes);
    table.number("light.distance_to_stop_line", distances);
}
