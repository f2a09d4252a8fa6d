//! Turns that the ego makes where the map has no junction: out of and into accesses and car parks, round a corner
//! beside the area of a junction, through an opening of the median.

use crate::ego::motion::EgoMotion;
use crate::geometry::{P2, wrap};
use crate::road::network::Road;
use crate::road::path::DrivenPath;
use crate::road::stretch::{STEP_M, Stretch};
use std::f64::consts::PI;

/// Minimum angle of a turn: 45 deg (RefAV).
pub const TURN_RAD: f64 = PI / 4.0;
/// Maximum radius of a continuing turn, m.
pub const TURN_RADIUS_M: f64 = 40.0;
/// Who has turned by this much within [`RADIUS_M`] where the recording ends goes on to turn: 15 deg. Of 268 recorded
/// and simulated ways through junctions of which this could be said at some moment, 242 were turns to that side.
const STEERED_RAD: f64 = PI / 12.0;
/// Maximum radius of a turn, m: AASHTO draws the turns of cars and buses at corners with 7 to 15 m; lanes bend wider.
const RADIUS_M: f64 = 25.0;
/// Curvature is taken over this distance to both sides, m.
const REACH_M: f64 = 1.5;
/// Parts of a turn with at most this between them are one turn, m.
const GAP_M: f64 = 2.0;
/// From straight on to a turn and back, steering takes a second at least, in which the heading changes half as much as
/// in a second of the turn, s.
const STEERING_S: f64 = 0.5;
/// Who follows a lane is at most this far from its middle, m, and within this of its course: 25 deg.
const ON_LANE_M: f64 = 2.0;
const ALONG_RAD: f64 = 25.0 * PI / 180.0;
/// A turn leads off or onto a lane, or goes round a corner: one that begins and ends farther from all lanes is a way
/// through a lot, m.
const BESIDE_LANE_M: f64 = 6.0;
/// Who turns this near to the area of a junction does not park, m.
const AT_JUNCTION_M: f64 = 15.0;
/// Who comes from, or comes to, a stand this near to the turn, m, and not on a lane, leaves or takes a parking space.
const PARKING_M: f64 = 6.0;
/// Slower is a stand, m/s.
const STAND_MPS: f64 = 1.0;

/// A place on the way, where the ego has moved on by [`STEP_M`] at least.
pub struct Place {
    /// Frame of the drive.
    pub frame: usize,
    /// Arc length of the path, m.
    pub s: f64,
    /// Unwrapped, rad.
    pub heading: f64,
}

/// What a recording at least does not show of a turn in which it begins or ends, in frame `edge`, having `seen` so much
/// of it, rad.
pub fn unseen_part(ego: &EgoMotion, edge: usize, seen: f64) -> f64 {
    let rate = ego.yaw_rate[edge];
    if rate * seen > 0.0 { rate * STEERING_S } else { 0.0 }
}

/// True if the recording ends in frame `edge` while the ego steers into a turn to the side to which it has turned by
/// `seen`, rad.
pub fn steers_round(ego: &EgoMotion, edge: usize, seen: f64) -> bool {
    let curvature = ego.yaw_rate[edge] / ego.speed[edge].max(STAND_MPS);
    seen.abs() >= STEERED_RAD && curvature * seen.signum() >= 1.0 / RADIUS_M
}

/// The turns outside of the areas of junctions, or touching them. `headings`: unwrapped, rad, by frame.
pub fn own_turns(road: &Road, path: &DrivenPath, ego: &EgoMotion, headings: &[f64]) -> Vec<Stretch> {
    let places = places(path, headings);
    let (Some(first), Some(last)) = (places.first(), places.last()) else { return Vec::new() };
    let place_at = |place: &Place| path.line.point_at(place.s);
    let on_a_lane = |place: &Place| follows_a_lane(road, path, place.s, place.heading);
    let is_a_turn = |(from, to): &(usize, usize)| {
        let (begin, end) = (&places[*from], &places[*to]);
        let seen = end.heading - begin.heading;
        let cut = *to == places.len() - 1;
        let before = if *from == 0 { unseen_part(ego, first.frame, seen) } else { 0.0 };
        let after = if cut { unseen_part(ego, last.frame, seen) } else { 0.0 };
        // Off its lane beside a junction; elsewhere it may park.
        let turns_off = || on_a_lane(begin) && is_near_junction(road, place_at(begin));
        let goes_on = || cut && steers_round(ego, last.frame, seen) && turns_off();
        (seen + before + after).abs() >= TURN_RAD || goes_on()
    };
    let known = |i: &usize| ego.is_known(*i);
    let (begins, ends) = ((0..ego.len()).find(known), (0..ego.len()).rfind(known));
    let stands = |frame: Option<usize>| frame.is_some_and(|i| ego.speed[i] < STAND_MPS);
    runs(&places)
        .into_iter()
        .filter(is_a_turn)
        .filter(|&(from, to)| {
            let half = (places[from].heading + places[to].heading) / 2.0;
            let is_half = |k: &usize| (places[*k].heading - half).abs();
            let middle = (from..=to).min_by(|a, b| is_half(a).total_cmp(&is_half(b))).unwrap_or(from);
            let either_end =
                |is: &dyn Fn(P2) -> bool| [from, to].into_iter().any(|k| is(place_at(&places[k])));
            let beside_a_lane = either_end(&|place| is_beside_a_lane(road, place));
            let near_junction = || either_end(&|place| is_near_junction(road, place));
            let parks = |edge: &Place, frame: Option<usize>, turn: &Place| {
                (edge.s - turn.s).abs() < PARKING_M && stands(frame) && !on_a_lane(edge)
            };
            let parking = parks(first, begins, &places[from]) || parks(last, ends, &places[to]);
            beside_a_lane && !on_a_lane(&places[middle]) && (!parking || near_junction())
        })
        .map(|(from, to)| {
            // Who stands where the turn begins has not entered it.
            let waits = ego.speed[places[from].frame] < STAND_MPS;
            let from = if waits { (places[from].s + STEP_M).min(places[to].s) } else { places[from].s };
            Stretch { from, to: places[to].s }
        })
        .collect()
}

/// True if the middle of a lane that is driven on is near.
fn is_beside_a_lane(road: &Road, place: P2) -> bool {
    road.lanes_near(place, BESIDE_LANE_M).into_iter().filter(|&l| road.lanes[l].kind.is_driven_on()).any(
        |l| {
            let line = &road.lanes[l].center;
            line.project(place).lateral.abs() <= BESIDE_LANE_M
        },
    )
}

/// True if the area or a lane of a junction is within [`AT_JUNCTION_M`].
fn is_near_junction(road: &Road, place: P2) -> bool {
    let is_near_lane = |l: usize| {
        let lane = &road.lanes[l];
        lane.in_junction && lane.kind.is_driven_on() && lane.center.distance(place) <= AT_JUNCTION_M
    };
    road.lanes_near(place, AT_JUNCTION_M).into_iter().any(is_near_lane)
        || road.junctions_near(place, AT_JUNCTION_M).any(|area| area.distance(place) <= AT_JUNCTION_M)
}

/// The places of the way, in order. `headings`: unwrapped, rad, by frame.
pub fn places(path: &DrivenPath, headings: &[f64]) -> Vec<Place> {
    let mut places: Vec<Place> = Vec::new();
    for (frame, (&s, &heading)) in path.ego_s.iter().zip(headings).enumerate() {
        let moved = places.last().is_none_or(|last| s - last.s >= STEP_M);
        if s.is_finite() && heading.is_finite() && moved {
            places.push(Place { frame, s, heading });
        }
    }
    places
}

/// First and last places of the parts of the way that bend to one side all the time.
pub fn runs(places: &[Place]) -> Vec<(usize, usize)> {
    let mut found: Vec<(usize, usize, f64)> = Vec::new();
    for (k, place) in places.iter().enumerate() {
        let from = places[..k].iter().rposition(|p| p.s < place.s - REACH_M).map_or(0, |i| i + 1);
        let to = k + places[k..].iter().take_while(|p| p.s <= place.s + REACH_M).count() - 1;
        let (a, b) = (&places[from], &places[to]);
        let curvature = (b.heading - a.heading) / (b.s - a.s).max(STEP_M);
        if curvature.abs() < 1.0 / RADIUS_M {
            continue;
        }
        match found.last_mut() {
            Some((_, end, side)) if *side == curvature.signum() && place.s - places[*end].s <= GAP_M => {
                *end = k
            }
            _ => found.push((k, k, curvature.signum())),
        }
    }
    found.into_iter().map(|(from, to, _)| (from, to)).collect()
}

/// True if a lane outside of junctions leads where the ego goes at `s`.
pub fn follows_a_lane(road: &Road, path: &DrivenPath, s: f64, course: f64) -> bool {
    let place = path.line.point_at(s);
    road.lanes_near(place, ON_LANE_M).into_iter().filter(|&l| !road.lanes[l].in_junction).any(|l| {
        let line = &road.lanes[l].center;
        let on = line.project(place);
        let covers = (-STEP_M..=line.length() + STEP_M).contains(&on.s);
        let along = wrap(line.smooth_heading_at(on.s, 2.0) - course).abs() <= ALONG_RAD;
        covers && on.lateral.abs() <= ON_LANE_M && along && road.lanes[l].kind.is_driven_on()
    })
}
