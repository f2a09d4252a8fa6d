//! Bends of the path that may be turns at a junction, where junctions are only derived from the lanes: a lane that
//! leads round tightly on its own, as at the border of a map or where the other arms are not in it. Whether the ego
//! turns there, or its road bends, the lanes do not tell.

use crate::geometry::{P2, Polygon, p2, unwrap, wrap};
use crate::road::network::Road;
use crate::road::own_turns::{TURN_RAD, TURN_RADIUS_M, follows_a_lane};
use crate::road::path::DrivenPath;
use crate::road::stretch::{STEP_M, Stretch};
use std::f64::consts::PI;
use whyroad_model::RoadMap;

/// Parts of a bend with at most this between them are one, m.
const GAP_M: f64 = 3.0;
/// Curvature is taken over this distance to both sides, m.
const REACH_M: f64 = 2.0;
/// The oncoming lane of a road that bends is at most this far from the ego's, m, and oncoming within this: 25 deg.
const ONCOMING_M: f64 = 10.0;
const ONCOMING_RAD: f64 = 25.0 * PI / 180.0;

/// The bends of the path; those that touch one of the `junctions` are not among them.
pub fn doubtful(road: &Road, map: &RoadMap, path: &DrivenPath, junctions: &[Stretch]) -> Vec<Stretch> {
    let steps = (path.line.length() / STEP_M) as usize;
    let at = |k: usize| k as f64 * STEP_M;
    let courses = unwrap(&(0..=steps).map(|k| path.heading_at(at(k))).collect::<Vec<f64>>());
    let rings: Vec<Polygon> = (map.facilities.iter())
        .filter(|f| f.kind == "roundabout")
        .filter_map(|f| Polygon::new(f.boundary.iter().map(|p| p2(p.x, p.y))))
        .collect();
    let follows = |s: f64| follows_a_lane(road, path, s, path.heading_at(s));
    let bends = |&(from, to): &(usize, usize)| (courses[to] - courses[from]).abs() >= TURN_RAD;
    let tells_nothing = |bend: &Stretch| {
        let middle = (bend.from + bend.to) / 2.0;
        let place = path.line.point_at(middle);
        let has_oncoming = [bend.from, middle, bend.to].into_iter().all(|s| oncoming(road, path, s));
        follows(middle)
            && !has_oncoming
            && !on_a_ramp(road, map, place)
            && !rings.iter().any(|ring| ring.contains(place))
            && !junctions.iter().any(|j| bend.to >= j.from && bend.from <= j.to)
    };
    let stretch = |(from, to)| Stretch { from: at(from), to: at(to) };
    runs(&courses).into_iter().filter(bends).map(stretch).filter(tells_nothing).collect()
}

/// First and last steps of the parts that bend to one side on a radius of at most [`TURN_RADIUS_M`].
fn runs(courses: &[f64]) -> Vec<(usize, usize)> {
    let (reach, gap) = ((REACH_M / STEP_M) as usize, (GAP_M / STEP_M) as usize);
    let last = courses.len() - 1;
    let mut found: Vec<(usize, usize, f64)> = Vec::new();
    for k in 0..=last {
        let (a, b) = (k.saturating_sub(reach), (k + reach).min(last));
        let turned = courses[b] - courses[a];
        if turned.abs() < (b - a) as f64 * STEP_M / TURN_RADIUS_M {
            continue;
        }
        match found.last_mut() {
            Some((_, end, side)) if *side == turned.signum() && k - *end <= gap => *end = k,
            _ => found.push((k, k, turned.signum())),
        }
    }
    found.into_iter().map(|(from, to, _)| (from, to)).collect()
}

/// True if a lane runs beside the path against it.
fn oncoming(road: &Road, path: &DrivenPath, s: f64) -> bool {
    let (place, course) = (path.line.point_at(s), path.heading_at(s));
    road.lanes_near(place, ONCOMING_M).into_iter().filter(|&l| road.lanes[l].kind.is_driven_on()).any(|l| {
        let line = &road.lanes[l].center;
        let on = line.project(place);
        let against = PI - wrap(line.smooth_heading_at(on.s, REACH_M) - course).abs() <= ONCOMING_RAD;
        against && on.lateral.abs() <= ONCOMING_M && (0.0..=line.length()).contains(&on.s)
    })
}

fn on_a_ramp(road: &Road, map: &RoadMap, place: P2) -> bool {
    let is_ramp = |l: usize| map.lane(&road.lanes[l].id).is_some_and(|lane| lane.is_tagged("ramp"));
    road.lanes_near(place, 1.0).into_iter().any(is_ramp)
}
