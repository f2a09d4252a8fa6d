//! The traffic light for the ego's own movement: the next one on its lane's continuation in the log, its state and its
//! known history.

use crate::ego::motion::EgoMotion;
use crate::geometry::p2;
use crate::road::ego_lane::{EgoLane, OnCorridor};
use crate::road::network::Road;
use crate::table::TableBuilder;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::catalog::{id, value};
use whyroad_model::scene::{LightColor, LightState};
use whyroad_model::{Nanos, RoadMap};

/// Maximum distance of a light that concerns the ego, m: 6 s at 90 km/h. Rules require less where the ego is slower.
const REACH_M: f64 = 150.0;

/// A state that was observed for this long without a change has lasted at least as long, s.
const LASTED_S: f64 = 5.0;
/// A light that is not seen for this long at most shows what it showed before, s: no state ends sooner.
const UNSEEN_S: f64 = 1.0;
/// Below this speed the ego is at standstill, m/s.
const STANDS_MPS: f64 = 0.1;

/// The value of light.state; `None` if the log does not know the color.
fn shown_value(color: LightColor) -> Option<value::LightState> {
    Some(match color {
        LightColor::Red => value::LightState::Red,
        LightColor::Yellow => value::LightState::Yellow,
        LightColor::Green => value::LightState::Green,
        LightColor::GreenYield => value::LightState::GreenYield,
        LightColor::GreenRound => value::LightState::GreenRound,
        LightColor::GreenArrow => value::LightState::GreenArrow,
        LightColor::FlashingGreen => value::LightState::FlashingGreen,
        LightColor::RedYellow => value::LightState::RedYellow,
        LightColor::FlashingYellow => value::LightState::FlashingYellow,
        LightColor::Off => value::LightState::Off,
        LightColor::Unknown => return None,
    })
}

/// The state of a light, and its previous state.
#[derive(Clone, Copy)]
struct Shown {
    color: LightColor,
    /// `None` when no change was recorded.
    previous: Option<LightColor>,
    /// Time since the change, or since it was first observed, s.
    lasted_s: f64,
    /// Time until the next color, from its countdown, s; NaN without one.
    countdown_s: f64,
}

impl Shown {
    /// Time since the change, s; a lower bound if none was recorded, NaN while there is no useful bound.
    fn since_change(self) -> f64 {
        let told = self.previous.is_some() || self.lasted_s >= LASTED_S - 1e-6;
        if told && self.color != LightColor::Unknown { self.lasted_s } else { f64::NAN }
    }
}

/// Removes unknown states of a lane's lights between known ones that are at most [`UNSEEN_S`] apart: a light that is
/// hidden for some frames.
fn leave_out_short_gaps(states: &mut Vec<&LightState>) {
    states.sort_by_key(|s| s.time);
    let mut short = vec![false; states.len()];
    // The unknown states since the last known one, for each way on; none before the first known one.
    let mut hidden: BTreeMap<Option<&str>, Vec<usize>> = BTreeMap::new();
    for (k, state) in states.iter().enumerate() {
        let way = state.to_lane_id.as_deref();
        if state.color == LightColor::Unknown {
            hidden.entry(way).and_modify(|run| run.push(k));
            continue;
        }
        let run = hidden.insert(way, Vec::new()).unwrap_or_default();
        if run.first().is_some_and(|&first| state.time.seconds_since(states[first].time) <= UNSEEN_S + 1e-6) {
            run.into_iter().for_each(|k| short[k] = true);
        }
    }
    let mut short = short.into_iter();
    states.retain(|_| !short.next().unwrap_or(false));
}

struct Lights<'a> {
    by_lane: BTreeMap<&'a str, Vec<&'a LightState>>,
    stop_lines: BTreeMap<&'a str, crate::geometry::P2>,
    /// Lanes with a stop line but without a sign: they have a light, whether or not the log contains its states.
    lit: BTreeSet<&'a str>,
}

impl<'a> Lights<'a> {
    fn new(states: &'a [LightState], map: &'a RoadMap) -> Self {
        let mut by_lane: BTreeMap<&str, Vec<&LightState>> = BTreeMap::new();
        for state in states {
            by_lane.entry(state.lane_id.as_str()).or_default().push(state);
        }
        by_lane.values_mut().for_each(leave_out_short_gaps);
        let mut stop_lines = BTreeMap::new();
        for line in map.stop_lines.iter().filter(|l| !l.line.is_empty()) {
            let n = line.line.len() as f64;
            let middle = line.line.iter().fold(p2(0.0, 0.0), |acc, p| acc + p2(p.x, p.y) * (1.0 / n));
            stop_lines.extend(line.lane_ids.iter().map(|id| (id.as_str(), middle)));
        }
        let signed: BTreeSet<&str> = map
            .signs
            .iter()
            .filter(|s| matches!(s.kind.as_str(), "stop" | "yield"))
            .flat_map(|s| s.lane_ids.iter().map(String::as_str))
            .collect();
        let lit = stop_lines.keys().copied().filter(|lane| !signed.contains(lane)).collect();
        Self { by_lane, stop_lines, lit }
    }

    /// The latest state at `time` of the light on `lane` for a way over the lanes `onward`, with its history.
    fn shown(&self, lane: &str, onward: &[&str], time: Nanos) -> Option<Shown> {
        let concerns = |s: &&&LightState| s.to_lane_id.as_deref().is_none_or(|to| onward.contains(&to));
        let states =
            || self.by_lane.get(lane).into_iter().flatten().filter(concerns).filter(|s| s.time <= time);
        let latest = states().max_by_key(|s| s.time)?;
        let color = latest.color;
        let passed_s = time.seconds_since(latest.time);
        // A countdown that has ended and was not replaced is not shown.
        let countdown_s = latest.countdown_s.map(|s| s - passed_s).filter(|s| *s >= 0.0).unwrap_or(f64::NAN);
        let before = states().filter(|s| s.color != color).max_by_key(|s| s.time);
        let since = states()
            .filter(|s| s.color == color && before.is_none_or(|b| s.time > b.time))
            .map(|s| s.time)
            .min()?;
        let lasted_s = time.seconds_since(since);
        Some(Shown { color, previous: before.map(|b| b.color), lasted_s, countdown_s })
    }

    /// The next light on the corridor: its state, if known at `time`, and the distance of its stop line from the ego's
    /// front bumper, m.
    fn next(&self, road: &Road, on: OnCorridor<'_>, front: f64, time: Nanos) -> Option<(Option<Shown>, f64)> {
        let chain = &on.corridor.lanes;
        for (k, &(lane, start)) in chain.iter().enumerate() {
            let id = road.lanes[lane].id.as_str();
            let end = on.corridor.lane_end(k);
            if end < on.s || !(self.by_lane.contains_key(id) || self.lit.contains(id)) {
                continue;
            }
            // A light on a junction lane is at the lane's beginning, one on an approach at its end.
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
            return Some((self.shown(id, &onward, time), (stop - on.s - front).max(0.0)));
        }
        None
    }
}

/// Time to the stop line, s.
fn time_to_line(distance: f64, speed: f64) -> f64 {
    if distance.is_infinite() || speed < STANDS_MPS { f64::INFINITY } else { distance / speed }
}

/// Writes `light.state`, `previous`, `time_since_change`, `countdown`, `distance_to_stop_line`, `time_to_stop_line`.
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
    let (mut previous, mut since) = (Vec::with_capacity(ego.len()), Vec::with_capacity(ego.len()));
    let mut countdown = Vec::with_capacity(ego.len());
    for (i, &time) in times.iter().enumerate() {
        let (state, distance, before, lasted, left) = match lanes.at(i) {
            None => (None, f64::NAN, None, f64::NAN, f64::NAN),
            Some(on) => match lights.next(road, on, front, time) {
                None => (
                    Some(value::LightState::None),
                    f64::INFINITY,
                    Some(value::LightState::None),
                    f64::INFINITY,
                    f64::INFINITY,
                ),
                Some((shown, distance)) => (
                    shown.and_then(|s| shown_value(s.color)),
                    distance,
                    shown.and_then(|s| s.previous).and_then(shown_value),
                    shown.map_or(f64::NAN, Shown::since_change),
                    shown.map_or(f64::NAN, |s| s.countdown_s),
                ),
            },
        };
        codes.push(state);
        distances.push(distance);
        previous.push(before);
        since.push(lasted);
        countdown.push(left);
    }
    let to_line = distances.iter().zip(&ego.forward_speed).map(|(&d, &v)| time_to_line(d, v));
    table.number(id::LIGHT_TIME_TO_STOP_LINE, to_line.collect());
    table.category(id::LIGHT_PREVIOUS, previous);
    table.number(id::LIGHT_TIME_SINCE_CHANGE, since);
    table.number(id::LIGHT_COUNTDOWN, countdown);
    table.category(id::LIGHT_STATE, codes);
    table.number(id::LIGHT_DISTANCE_TO_STOP_LINE, distances);
}
