//! Whether a sign applies to the ego: on its route, facing it, beside its own direction of the road, and for a vehicle
//! of its size.

use crate::geometry::{p2, wrap};
use crate::road::network::Road;
use crate::road::on_road::OnRoad;
use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_3, FRAC_PI_4, PI};
use whyroad_model::road_map::{LaneKind, Sign};

/// Maximum distance of a sign without a lane from the path to which it applies, m.
const BESIDE_M: f64 = 12.0;
/// Maximum distance from the ego's path of a sign for a lane of its route, m.
const OF_LANE_M: f64 = 40.0;
/// Lanes that are farther from a sign than the nearest one by at most this may also be meant, m.
const AS_NEAR_M: f64 = 1.0;
/// A limit of height or width with this margin does not affect the ego, m.
const ROOM_M: f64 = 0.5;

/// Ids of the lanes that the ego is ever in, of short ones that it passes over between two of them, and of those ahead
/// of its last one.
pub(super) fn route(on: &OnRoad<'_>) -> BTreeSet<String> {
    let id = |lane: usize| on.road.lanes[lane].id.clone();
    let mut driven: Vec<usize> = (0..on.frames()).filter_map(|i| on.lanes.at(i)).map(|at| at.lane).collect();
    driven.dedup();
    let between = driven.windows(2).flat_map(|pair| passed_over(on.road, pair[0], pair[1]));
    let mut lanes: BTreeSet<String> = between.chain(driven.iter().copied()).map(id).collect();
    if let Some((way, _)) = (0..on.frames()).rev().find_map(|i| on.ways.at(i)) {
        lanes.extend(way.steps.iter().map(|step| id(step.lane)));
    }
    lanes
}

/// The lanes of a way of up to two lanes from `a` to another lane `b`; none where one leads directly into the other.
fn passed_over(road: &Road, a: usize, b: usize) -> Vec<usize> {
    let next = |lane: usize| road.lanes[lane].successors.iter().copied();
    let leads = |lane: usize, to: usize| road.lanes[lane].successors.contains(&to);
    if leads(a, b) {
        return Vec::new();
    }
    let one: Vec<usize> = next(a).filter(|&m| leads(m, b)).collect();
    if !one.is_empty() {
        return one;
    }
    next(a).flat_map(|m| next(m).filter(|&n| leads(n, b)).flat_map(move |n| [m, n])).collect()
}

/// Position at which the ego's path passes a sign that applies to it, m along the path.
pub(super) fn concerned(on: &OnRoad<'_>, sign: &Sign, route: &BTreeSet<String>) -> Option<f64> {
    let at = on.path.line.project(p2(sign.position.x, sign.position.y));
    let course = on.path.heading_at(at.s);
    let meant = if !sign.lane_ids.is_empty() {
        at.lateral.abs() <= OF_LANE_M && sign.lane_ids.iter().any(|l| route.contains(l))
    } else if at.lateral.abs() > BESIDE_M {
        false
    } else if let Some(facing) = sign.facing {
        wrap(facing + PI - course).abs() <= FRAC_PI_3
    } else {
        beside_own_direction(on, sign, course)
    };
    (meant && binds(on, sign)).then_some(at.s)
}

/// The lane nearest to the sign has the ego's direction: a sign beyond the oncoming lanes, or beside a road that the
/// ego only crosses, is for others. If the map has no lane there, it applies to all passing traffic.
fn beside_own_direction(on: &OnRoad<'_>, sign: &Sign, course: f64) -> bool {
    let place = p2(sign.position.x, sign.position.y);
    let near: Vec<(f64, f64)> = on
        .road
        .lanes_near(place, BESIDE_M)
        .into_iter()
        .map(|l| &on.road.lanes[l])
        .filter(|l| matches!(l.kind, LaneKind::Vehicle | LaneKind::Bus) && !l.in_junction)
        .map(|l| {
            let s = l.center.project(place).s;
            (l.center.distance(place), l.center.smooth_heading_at(s, 2.0))
        })
        .collect();
    let nearest = near.iter().map(|(distance, _)| *distance).fold(f64::INFINITY, f64::min);
    let as_near = |(distance, _): &&(f64, f64)| *distance <= nearest + AS_NEAR_M;
    near.is_empty() || near.iter().filter(as_near).any(|(_, along)| wrap(along - course).abs() <= FRAC_PI_4)
}

/// False for a limit of height or width that the ego meets with a margin.
fn binds(on: &OnRoad<'_>, sign: &Sign) -> bool {
    let own = on.drive.ego.as_ref().map_or(f64::NAN, |ego| match sign.kind.as_str() {
        "height_limit" => ego.height_m,
        "width_limit" => ego.width_m,
        _ => f64::NAN,
    });
    sign.value.is_none_or(|limit| own.is_nan() || limit < own + ROOM_M)
}
