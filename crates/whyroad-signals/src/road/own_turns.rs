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
struct Place {
    frame: usize,
    s: f64,
    heading: f64,
}

/// What a recording at least does not show of a turn in which it begins or ends, in frame `edge`, having `seen` so much
/// of it, rad.
pub fn unseen_part(ego: &EgoMotion, edge: usize, seen: f64) -> f64 {
    let rate = ego.yaw_rate[edge];
    if rate * seen > 0.0 { rate * STEERING_S } else { 0.0 }
}

/// The turns outside of `junctions`, or touching them. `headings`: unwrapped, rad, by frame.
pub fn own_turns(
    road: &Road,
    path: &DrivenPath,
    ego: &EgoMotion,
    headings: &[f64],
    junctions: &[Stretch],
) -> Vec<Stretch> {
    let places = places(path, headings);
    let (Some(first), Some(last)) = (places.first(), places.last()) else { return Vec::new() };
    let angle = |(from, to): &(usize, usize)| {
        let seen = places[*to].heading - places[*from].heading;
        let before = if *from == 0 { unseen_part(ego, first.frame, seen) } else { 0.0 };
        let after = if *to == places.len() - 1 { unseen_part(ego, last.frame, seen) } else { 0.0 };
        seen + before + after
    };
    let on_a_lane = |place: &Place| follows_a_lane(road, path, place.s, place.heading);
    let known = |i: &usize| ego.is_known(*i);
    let (begins, ends) = ((0..ego.len()).find(known), (0..ego.len()).rfind(known));
    let stands = |frame: Option<usize>| frame.is_some_and(|i| ego.speed[i] < STAND_MPS);
    runs(&places)
        .into_iter()
        .filter(|run| angle(run).abs() >= TURN_RAD)
        .filter(|&(from, to)| {
            let half = (places[from].heading + places[to].heading) / 2.0;
            let is_half = |k: &usize| (places[*k].heading - half).abs();
            let middle = (from..=to).min_by(|a, b| is_half(a).total_cmp(&is_half(b))).unwrap_or(from);
            let beside_a_lane =
                [from, to].into_iter().any(|k| is_beside_a_lane(road, path.line.point_at(places[k].s)));
            let near_junction = junctions
                .iter()
                .any(|j| j.from <= places[to].s + AT_JUNCTION_M && j.to >= places[from].s - AT_JUNCTION_M);
            let parks = |edge: &Place, frame: Option<usize>, turn: &Place| {
                (edge.s - turn.s).abs() < PARKING_M && stands(frame) && !on_a_lane(edge)
            };
            let parking = parks(first, begins, &places[from]) || parks(last, ends, &places[to]);
            beside_a_lane && !on_a_lane(&places[middle]) && (near_junction || !parking)
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

fn places(path: &DrivenPath, headings: &[f64]) -> Vec<Place> {
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
fn runs(places: &[Place]) -> Vec<(usize, usize)> {
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
fn follows_a_lane(road: &Road, path: &DrivenPath, s: f64, course: f64) -> bool {
    let place = path.line.point_at(s);
    road.lanes_near(place, ON_LANE_M).into_iter().filter(|&l| !road.lanes[l].in_junction).any(|l| {
        let line = &road.lanes[l].center;
        let on = line.project(place);
        let covers = (-STEP_M..=line.length() + STEP_M).contains(&on.s);
        let along = wrap(line.smooth_heading_at(on.s, 2.0) - course).abs() <= ALONG_RAD;
        covers && on.lateral.abs() <= ON_LANE_M && along && road.lanes[l].kind.is_driven_on()
    })
}
