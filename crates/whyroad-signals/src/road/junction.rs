//! Junctions and crosswalks along the ego's driven path, as ranges of arc length; the distance to the next one, and the
//! ego's movement through each junction.

use crate::ego::motion::EgoMotion;
use crate::geometry::{unwrap, wrap};
use crate::road::cut_traversal::rest_by_lanes;
use crate::road::doubtful::doubtful;
use crate::road::network::Road;
use crate::road::own_turns::{TURN_RAD, TURN_RADIUS_M, own_turns, steers_round, unseen_part};
use crate::road::path::DrivenPath;
use crate::road::stretch::{STEP_M, Stretch};
use crate::table::TableBuilder;
use std::f64::consts::PI;
use whyroad_model::catalog::{id, value::EgoMovement};
use whyroad_model::road_map::{LayerState, MapLayer};
use whyroad_model::{RoadMap, Tri};

/// Ranges of one kind with a smaller distance are merged, m.
pub const MERGE_M: f64 = 5.0;
/// Maximum look-ahead, m.
pub const HORIZON_M: f64 = 150.0;
/// A turn's heading begins to change slightly before the area and ends slightly behind it, m.
pub const TURN_MARGIN_M: f64 = 3.0;
/// A turn farther from the area does not belong to the junction, m.
const TURN_REACH_M: f64 = 15.0;
/// Minimum angle at which a turn has begun: 10 deg.
const BEGUN_RAD: f64 = PI / 18.0;
/// Maximum path length of a U-turn, m: half a circle of 13 m radius.
const TURN_ROUND_M: f64 = 40.0;
/// Minimum angle of a U-turn: 135 deg.
const UTURN_RAD: f64 = 3.0 * PI / 4.0;

/// The ranges of the path for which `inside` is true, in order.
pub fn stretches(
    path: &DrivenPath,
    inside: impl Fn(crate::geometry::P2) -> bool,
    merge: f64,
) -> Vec<Stretch> {
    let mut found: Vec<Stretch> = Vec::new();
    let steps = (path.line.length() / STEP_M) as usize;
    for i in 0..=steps {
        let s = i as f64 * STEP_M;
        if !inside(path.line.point_at(s)) {
            continue;
        }
        match found.last_mut() {
            Some(last) if s - last.to <= merge.max(STEP_M) + 1e-9 => last.to = s,
            _ => found.push(Stretch { from: s, to: s }),
        }
    }
    found
}

/// Distance from the front bumper to the next range, 0 from reaching it until the center has left it.
pub fn distance_to_next(stretches: &[Stretch], ego_s: f64, front: f64) -> f64 {
    if ego_s.is_nan() {
        return f64::NAN;
    }
    let next = stretches.iter().find(|x| x.to >= ego_s);
    let distance = next.map_or(f64::INFINITY, |x| (x.from - ego_s - front).max(0.0));
    if distance > HORIZON_M { f64::INFINITY } else { distance }
}

/// Change of heading over one traversal.
struct Turned {
    /// As recorded, rad.
    recorded: f64,
    /// What the recording does not show of it at least, where it begins or ends in the turn, rad.
    unseen: f64,
    /// True if the recording covers it from entry to exit.
    whole: bool,
    /// True if the recording ends while the ego steers into a turn.
    steers_on: bool,
}

/// Change of heading over one traversal. A turn that begins before the area or ends behind it is counted completely; if
/// the recording begins or ends during it, as in a slip lane before the area, only the least that it can be is known.
fn turned(stretch: Stretch, path: &DrivenPath, ego: &EgoMotion, headings: &[f64]) -> Option<Turned> {
    let s = &path.ego_s;
    let near = |&i: &usize| s[i] >= stretch.from - TURN_MARGIN_M && s[i] <= stretch.to + TURN_MARGIN_M;
    let frames: Vec<usize> = (0..headings.len()).filter(|i| headings[*i].is_finite()).filter(near).collect();
    let (first, last) = (*frames.first()?, *frames.last()?);
    let whole = path.driven.0 <= stretch.from && path.driven.1 >= stretch.to;
    let turned = headings[last] - headings[first];
    if turned.abs() < BEGUN_RAD {
        return Some(Turned { recorded: turned, unseen: 0.0, whole, steers_on: false });
    }
    let goes_on = |from: f64, to: f64, way: f64| (to - from) * turned.signum() >= way / TURN_RADIUS_M;
    let (mut begins, mut ends) = (first, last);
    for i in (0..first).rev().take_while(|&i| s[i] >= stretch.from - TURN_REACH_M) {
        let way = s[begins] - s[i];
        if way >= STEP_M && headings[i].is_finite() {
            if !goes_on(headings[i], headings[begins], way) {
                break;
            }
            begins = i;
        }
    }
    for i in (last + 1..headings.len()).take_while(|&i| s[i].is_nan() || s[i] <= stretch.to + TURN_REACH_M) {
        let way = s[i] - s[ends];
        if way >= STEP_M && headings[i].is_finite() {
            if !goes_on(headings[ends], headings[i], way) {
                break;
            }
            ends = i;
        }
    }
    let known = |i: &usize| headings[*i].is_finite() && s[*i].is_finite();
    let (edge_first, edge_last) = ((0..headings.len()).find(known)?, (0..headings.len()).rfind(known)?);
    let turns_over = |a: usize, b: usize| goes_on(headings[a], headings[b], s[b] - s[a]);
    // Whether the first and last meters of the recording are part of it.
    let after_edge = || (edge_first..=last).find(|&i| s[i] - s[edge_first] >= TURN_MARGIN_M);
    let before_edge = || (first..=edge_last).rfind(|&i| s[edge_last] - s[i] >= TURN_MARGIN_M);
    let begins_in_it =
        s[begins] - s[edge_first] < STEP_M && after_edge().is_some_and(|i| turns_over(edge_first, i));
    let ends_in_it =
        s[edge_last] - s[ends] < STEP_M && before_edge().is_some_and(|i| turns_over(i, edge_last));
    let part = |cut: bool, edge: usize| if cut { unseen_part(ego, edge, turned) } else { 0.0 };
    let unseen = part(begins_in_it, edge_first) + part(ends_in_it, edge_last);
    let recorded = headings[ends] - headings[begins];
    let steers_on = ends_in_it && steers_round(ego, edge_last, recorded);
    Some(Turned { recorded, unseen, whole: whole && !begins_in_it && !ends_in_it, steers_on })
}

/// Change of heading over one traversal as recorded, rad, and its movement. Where the recording ends inside, both are
/// completed from the lanes if all that the ego may be following make it the same movement; else the movement is the
/// turn into which the ego steers.
fn way(
    road: &Road,
    path: &DrivenPath,
    ego: &EgoMotion,
    stretch: Stretch,
    headings: &[f64],
) -> Option<(f64, Option<EgoMovement>)> {
    let Turned { recorded, unseen, whole, steers_on } = turned(stretch, path, ego, headings)?;
    let seen = movement(recorded + unseen, whole);
    if seen.is_some() {
        return Some((recorded, seen));
    }
    let rests = rest_by_lanes(road, path, (stretch.from, stretch.to));
    let by_lane = |rest: &f64| movement(recorded + rest, true);
    let nearest = rests.first().filter(|nearest| rests.iter().all(|rest| by_lane(rest) == by_lane(nearest)));
    let steered = || steers_on.then(|| turn_to(recorded));
    Some(nearest.map_or_else(|| (recorded, steered()), |rest| (recorded + rest, by_lane(rest))))
}

/// U-turns of the path outside of junctions, as at an opening of the median, where no lane makes the turn (as in a
/// hairpin): the heading changes by at least 135 deg within [`TURN_ROUND_M`].
fn turns_round(road: &Road, path: &DrivenPath) -> Vec<Stretch> {
    let steps = ((path.driven.1 - path.driven.0) / STEP_M) as usize;
    let at = |k: usize| path.driven.0 + k as f64 * STEP_M;
    let headings = unwrap(&(0..=steps).map(|k| path.heading_at(at(k))).collect::<Vec<f64>>());
    let window = (TURN_ROUND_M / STEP_M) as usize;
    let mut found: Vec<Stretch> = Vec::new();
    let mut k = 0;
    while k < steps {
        let until =
            (k + 1..=(k + window).min(steps)).find(|&j| (headings[j] - headings[k]).abs() >= UTURN_RAD);
        let Some(j) = until else {
            k += 1;
            continue;
        };
        // The turn begins where the heading has changed slightly.
        let begins = (k..j).find(|&i| (headings[i] - headings[k]).abs() >= BEGUN_RAD).unwrap_or(k);
        let middle = path.line.point_at(at((begins + j) / 2));
        let course = headings[(begins + j) / 2];
        let led_round = road.lanes_near(middle, 0.5).into_iter().any(|l| {
            let line = &road.lanes[l].center;
            let along = line.smooth_heading_at(line.project(middle).s, 2.0);
            !road.lanes[l].in_junction && wrap(along - course).abs() < TURN_RAD
        });
        if !led_round {
            found.push(Stretch { from: at(begins), to: at(j) });
        }
        k = j;
    }
    found
}

/// True if less than [`MERGE_M`] is between them.
fn touches(a: &Stretch, b: &Stretch) -> bool {
    a.to >= b.from - MERGE_M && a.from <= b.to + MERGE_M
}

/// Junction ranges and turns in one list: a turn is merged with the ranges that it touches, because its path may leave
/// the junction area and return to it.
fn with_turns(junctions: Vec<Stretch>, turns: Vec<Stretch>) -> Vec<Stretch> {
    let mut all: Vec<Stretch> = junctions;
    for turn in turns {
        let (near, mut rest): (Vec<Stretch>, Vec<Stretch>) = all.into_iter().partition(|j| touches(j, &turn));
        let joined = near.iter().fold(turn, |a, b| Stretch { from: a.from.min(b.from), to: a.to.max(b.to) });
        rest.push(joined);
        all = rest;
    }
    all.sort_by(|a, b| a.from.total_cmp(&b.from));
    all
}

fn turn_to(angle: f64) -> EgoMovement {
    if angle > 0.0 { EgoMovement::Left } else { EgoMovement::Right }
}

/// The movement of a traversal with a change of heading by `angle` (rad) that was completely recorded if `whole`.
pub fn movement(angle: f64, whole: bool) -> Option<EgoMovement> {
    if angle.abs() > UTURN_RAD {
        Some(EgoMovement::Uturn)
    } else if angle.abs() >= TURN_RAD {
        Some(turn_to(angle))
    } else {
        whole.then_some(EgoMovement::Straight)
    }
}

/// The junctions and crosswalks on the ego's path, in order.
pub struct Encounters {
    /// Junctions; those with less than 5 m between them are merged, and so are those that a turn touches. A turn
    /// outside of junctions counts as one.
    pub junctions: Vec<Stretch>,
    /// By junction: the map itself states it; false where it is derived from the lanes, or only a turn of the ego.
    pub stated: Vec<bool>,
    /// Where there may be one that the map does not show; see [`doubtful`].
    doubtful: Vec<Stretch>,
    /// Crosswalks.
    pub crosswalks: Vec<Stretch>,
    /// Change of heading across each junction, rad, and the ego's movement, if the recording or the lanes show it.
    ways: Vec<Option<(f64, Option<EgoMovement>)>>,
}

impl Encounters {
    /// Along the whole path, including its continuations. Where the map states the areas of junctions, a turn at one
    /// does not extend it: derived ones do not reach the corners.
    pub fn new(road: &Road, map: &RoadMap, path: &DrivenPath, ego: &EgoMotion) -> Self {
        let areas_are_stated = map.layer(MapLayer::Junctions) != LayerState::Derived;
        let areas = stretches(path, |p| road.in_junction(p), MERGE_M);
        let headings = unwrap(&ego.heading);
        let at_one = |turn: &Stretch| areas.iter().any(|area| touches(area, turn));
        let turns = own_turns(road, path, ego, &headings)
            .into_iter()
            .filter(|turn| !(areas_are_stated && at_one(turn)))
            .collect();
        let junctions = with_turns(with_turns(areas.clone(), turns_round(road, path)), turns);
        let holds = |j: &Stretch| areas.iter().any(|area| area.from >= j.from && area.to <= j.to);
        let stated = junctions.iter().map(|j| areas_are_stated && holds(j)).collect();
        let ways = junctions.iter().map(|&j| way(road, path, ego, j, &headings)).collect();
        let crosswalks = stretches(path, |p| road.crosswalks.iter().any(|c| c.contains(p)), 0.0);
        let doubtful = if areas_are_stated { Vec::new() } else { doubtful(road, map, path, &junctions) };
        Self { junctions, stated, doubtful, crosswalks, ways }
    }

    /// True if the ego's center at `ego_s` is in a bend that may be a junction.
    fn may_be_in_one(&self, ego_s: f64) -> bool {
        self.doubtful.iter().any(|bend| bend.from <= ego_s && ego_s <= bend.to)
    }

    /// True if what is here, or next within `reach`, may be a junction that the map does not show.
    pub fn is_in_doubt(&self, ego_s: f64, front: f64, reach: f64) -> bool {
        let from = |next: Option<&Stretch>| next.map_or(f64::INFINITY, |j| j.from);
        let bend = from(self.doubtful.iter().find(|bend| bend.to >= ego_s));
        let junction = from(self.junctions.iter().find(|j| j.to >= ego_s));
        bend < junction && bend - ego_s - front <= reach
    }

    /// The junction that contains the ego's center at `ego_s`, else the next one whose distance from its front is
    /// within `reach`.
    pub fn here_or_next(&self, ego_s: f64, front: f64, reach: f64) -> Option<usize> {
        let next = self.junctions.iter().position(|j| j.to >= ego_s)?;
        (self.junctions[next].from - ego_s - front <= reach).then_some(next)
    }

    /// Distance to the junction here or next; NaN where the map leaves it in doubt.
    pub fn distance_to_junction(&self, ego_s: f64, front: f64) -> f64 {
        match self.is_in_doubt(ego_s, front, HORIZON_M) {
            true => f64::NAN,
            false => distance_to_next(&self.junctions, ego_s, front),
        }
    }

    /// The ego's movement through junction `k`, if the recording or the lanes show it.
    pub fn movement(&self, k: usize) -> Option<EgoMovement> {
        self.ways[k].and_then(|(_, movement)| movement)
    }
}

/// Writes `ego.in_junction`, `movement`, `turn_angle`, `map.distance_to_junction`, `distance_to_crosswalk`.
pub fn write(found: &Encounters, path: &DrivenPath, ego: &EgoMotion, table: &mut TableBuilder<'_>) {
    let n = ego.len();
    let at = |i: usize| found.junctions.iter().position(|j| j.from <= path.ego_s[i] && path.ego_s[i] <= j.to);
    let angle = |i: usize| at(i).and_then(|j| found.ways[j]).map_or(f64::NAN, |(angle, _)| angle);
    let known = |i: usize| path.ego_s[i].is_finite();
    table.flag(
        id::EGO_IN_JUNCTION,
        (0..n)
            .map(|i| match known(i) && !found.may_be_in_one(path.ego_s[i]) {
                true => Tri::from(at(i).is_some()),
                false => Tri::Unknown,
            })
            .collect(),
    );
    table.number(id::EGO_TURN_ANGLE, (0..n).map(angle).collect());
    table.category(id::EGO_MOVEMENT, (0..n).map(|i| at(i).and_then(|j| found.movement(j))));
    let front = ego.front();
    table.number(
        id::MAP_DISTANCE_TO_JUNCTION,
        path.ego_s.iter().map(|&s| found.distance_to_junction(s, front)).collect(),
    );
    let to_crosswalk = |&s: &f64| distance_to_next(&found.crosswalks, s, front);
    table.number(id::MAP_DISTANCE_TO_CROSSWALK, path.ego_s.iter().map(to_crosswalk).collect());
}
