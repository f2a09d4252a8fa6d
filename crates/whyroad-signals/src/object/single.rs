//! The `object.` signals: the motion of an object, and its position on the road.

use super::body::Body;
use super::scene::Scene;
use crate::ego::motion::DERIVATIVE_REACH_S;
use crate::geometry::{OrientedBox, P2, Polygon, p2, wrap};
use crate::refav::turning::turning;
use crate::road::lane_change::{self, Rows};
use crate::series::slope;
use std::f64::consts::FRAC_PI_2;
use whyroad_model::catalog::CategoryValue;
use whyroad_model::catalog::value::{EgoLaneChange, EgoRefavTurning, ObjectLaneType};
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::road_map::LaneKind;
use whyroad_model::{Column, ObjectClass, Tri};

/// Below this speed an object is stopped, m/s.
const MOVING_MPS: f64 = 0.5;
/// A track whose bounding diagonal is shorter is stationary, m.
const STATIONARY_M: f64 = 3.0;
/// Maximum distance of junctions and crosswalks that are searched, m.
const REACH_M: f64 = 50.0;
/// A stop sign applies this far in front of it, m ...
const SIGN_FORWARD_M: f64 = 10.0;
/// ... and behind it, m ...
const SIGN_BEHIND_M: f64 = 1.0;
/// ... to its right, m.
const SIGN_RIGHT_M: f64 = 7.0;

/// The column of a signal; `None` if none of its values can be known.
pub(super) fn column(scene: &Scene<'_>, name: &str) -> Option<Column> {
    let numbers =
        |f: &dyn Fn(&Body, usize) -> f64| Some(Column::Number(each(scene, f64::NAN, |_, b, i| f(b, i))));
    match name {
        "object.observed" => Some(Column::Flag(
            scene.bodies.iter().flat_map(|b| b.position.iter().map(|p| Tri::from(p.is_finite()))).collect(),
        )),
        "object.class" => {
            Some(category::<ObjectClassCode>(each(scene, None, |_, b, _| Some(ObjectClassCode(b.class)))))
        }
        "object.is_ego" => Some(flags(scene, |_, b, _| Tri::from(b.track.is_none()))),
        "object.speed" => numbers(&|b, i| b.velocity[i].norm()),
        "object.accel" => numbers(&|b, i| b.accel[i]),
        "object.length" => numbers(&|b, i| b.length[i]),
        "object.width" => numbers(&|b, i| b.width[i]),
        "object.lateral_accel" => Some(Column::Number(lateral_accel(scene))),
        "object.stopped" => Some(flags(scene, |_, b, i| below(b.velocity[i].norm(), MOVING_MPS))),
        "object.stationary" => {
            let still: Vec<Tri> = scene.bodies.iter().map(stationary).collect();
            Some(flags(scene, |k, _, _| still[k]))
        }
        "object.turning" => Some(category(turns(scene))),
        _ => on_the_map(scene, name),
    }
}

fn on_the_map(scene: &Scene<'_>, name: &str) -> Option<Column> {
    let (road, lanes) = (scene.road?, scene.lanes?);
    match name {
        "object.lane_change" => Some(category(lane_changes(scene)?)),
        "object.lane_type" => Some(category(each(scene, None, |k, _, i| {
            Some(match lanes.lanes[k][i].map(|l| road.lanes[l].kind) {
                Some(LaneKind::Vehicle) => ObjectLaneType::Vehicle,
                Some(LaneKind::Bus) => ObjectLaneType::Bus,
                Some(LaneKind::Bike) => ObjectLaneType::Bike,
                _ => ObjectLaneType::None,
            })
        }))),
        "object.in_junction" => Some(flags(scene, |_, b, i| Tri::from(road.in_junction(b.position[i])))),
        "object.on_road" => Some(flags(scene, |k, _, i| {
            Tri::from(lanes.lanes[k][i].is_some_and(|l| road.lanes[l].kind.is_driven_on()))
        })),
        "object.on_drivable_area" => (!road.drivable.is_empty()).then(|| {
            flags(scene, |_, b, i| Tri::from(road.drivable.iter().any(|d| d.contains(b.position[i]))))
        }),
        "object.junction_distance" => Some(Column::Number(each(scene, f64::NAN, |_, b, i| {
            let p = b.position[i];
            let on_lane = |l: &usize| road.lanes[*l].in_junction && road.lanes[*l].kind != LaneKind::Sidewalk;
            let of_lanes = road.lanes_near(p, REACH_M).into_iter().filter(on_lane);
            let areas = of_lanes.filter_map(|l| road.lanes[l].area.as_ref()).chain(&road.junctions);
            within_reach(areas.map(|a| a.distance(p)).fold(f64::INFINITY, f64::min))
        }))),
        "object.crosswalk_distance" => Some(Column::Number(each(scene, f64::NAN, |_, b, i| {
            let of = b.footprint(i);
            within_reach(road.crosswalks.iter().map(|c| distance_to(c, &of)).fold(f64::INFINITY, f64::min))
        }))),
        "object.at_stop_sign" => at_stop_sign(scene),
        _ => None,
    }
}

fn within_reach(distance: f64) -> f64 {
    if distance <= REACH_M { distance } else { f64::INFINITY }
}

/// A value for each row in which the object is observed.
fn each<T: Clone>(scene: &Scene<'_>, unseen: T, f: impl Fn(usize, &Body, usize) -> T) -> Vec<T> {
    let mut out = Vec::new();
    for (k, body) in scene.bodies.iter().enumerate() {
        let value = |i: usize| if body.position[i].is_finite() { f(k, body, i) } else { unseen.clone() };
        out.extend((0..body.position.len()).map(value));
    }
    out
}

fn flags(scene: &Scene<'_>, f: impl Fn(usize, &Body, usize) -> Tri) -> Column {
    Column::Flag(each(scene, Tri::Unknown, f))
}

/// A column of category values.
pub(super) fn category<C: CategoryValue>(values: Vec<Option<C>>) -> Column {
    let codes = values.into_iter().map(|v| v.map_or(UNKNOWN_CODE, C::code)).collect();
    let names: Vec<String> = C::NAMES.iter().map(|n| (*n).to_owned()).collect();
    Column::Category { codes, names: names.into() }
}

/// An object's class as a value of `object.class`, whose names are those of the classes.
#[derive(Clone, Copy, PartialEq, Eq)]
struct ObjectClassCode(ObjectClass);

impl CategoryValue for ObjectClassCode {
    const ALL: &'static [Self] = &[];
    const NAMES: &'static [&'static str] = whyroad_model::catalog::value::ObjectClass::NAMES;
    fn code(self) -> u16 {
        let at = Self::NAMES.iter().position(|n| *n == self.0.id());
        at.and_then(|i| u16::try_from(i).ok()).unwrap_or(UNKNOWN_CODE)
    }
}

/// A comparison that is unknown where the number is unknown.
fn below(x: f64, bound: f64) -> Tri {
    if x.is_nan() { Tri::Unknown } else { Tri::from(x < bound) }
}

fn stationary(body: &Body) -> Tri {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for (p, z) in body.position.iter().zip(&body.z).filter(|(p, _)| p.is_finite()) {
        for (axis, value) in [p.x, p.y, if z.is_finite() { *z } else { 0.0 }].into_iter().enumerate() {
            low[axis] = low[axis].min(value);
            high[axis] = high[axis].max(value);
        }
    }
    let diagonal = (0..3).map(|a| (high[a] - low[a]).powi(2)).sum::<f64>().sqrt();
    below(diagonal, STATIONARY_M)
}

fn times<'t>(scene: &'t Scene<'_>, body: &Body) -> &'t [f64] {
    &scene.times[body.frames.start..body.frames.end]
}

fn lateral_accel(scene: &Scene<'_>) -> Vec<f64> {
    let of = |body: &Body| {
        let along = |axis: fn(&P2) -> f64| {
            slope(times(scene, body), &body.velocity.iter().map(axis).collect::<Vec<_>>(), DERIVATIVE_REACH_S)
        };
        let (x, y) = (along(|v| v.x), along(|v| v.y));
        (0..x.len()).map(|i| body.in_axes(i, p2(x[i], y[i])).y).collect::<Vec<f64>>()
    };
    scene.bodies.iter().flat_map(of).collect()
}

fn turns(scene: &Scene<'_>) -> Vec<Option<EgoRefavTurning>> {
    scene.bodies.iter().flat_map(|b| turning(times(scene, b), &b.heading)).collect()
}

/// A turn crosses lanes without being a lane change.
fn lane_changes(scene: &Scene<'_>) -> Option<Vec<Option<EgoLaneChange>>> {
    let (road, lanes) = (scene.road?, scene.lanes?);
    let mut out = Vec::new();
    for (body, places) in scene.bodies.iter().zip(&lanes.places) {
        let seen: Vec<usize> = (0..places.len()).filter(|i| body.position[*i].is_finite()).collect();
        let all = times(scene, body);
        let rows = Rows {
            times: &seen.iter().map(|i| all[*i]).collect::<Vec<_>>(),
            position: &seen.iter().map(|i| body.position[*i]).collect::<Vec<_>>(),
            velocity: &seen.iter().map(|i| body.velocity[*i]).collect::<Vec<_>>(),
            places: &seen.iter().map(|i| places[*i]).collect::<Vec<_>>(),
            aside: &[],
        };
        let mut own = vec![None; places.len()];
        for (i, value) in seen.iter().zip(lane_change::changes(road, &rows)) {
            // Outside of all lanes there is no lane change.
            own[*i] = Some(value.unwrap_or(EgoLaneChange::None));
        }
        let turns = turning(all, &body.heading);
        for (value, turn) in own.iter_mut().zip(turns) {
            if turn.is_some_and(|t| t != EgoRefavTurning::None) && value.is_some() {
                *value = Some(EgoLaneChange::None);
            }
        }
        out.extend(own);
    }
    Some(out)
}

/// Shortest distance between an area and a box, 0 where they share a point, m.
fn distance_to(area: &Polygon, of: &OrientedBox) -> f64 {
    let (low, high) = area.bounds();
    let reach = REACH_M + of.radius();
    let c = of.center;
    if c.x < low.x - reach || c.x > high.x + reach || c.y < low.y - reach || c.y > high.y + reach {
        return f64::INFINITY;
    }
    let (corners, ring) = (of.corners(), area.corners());
    let Some(of_box) = Polygon::new(corners) else { return area.distance(c) };
    if crossing(&corners, ring) {
        return 0.0;
    }
    let to_area = corners.iter().map(|p| area.distance(*p));
    let to_box = ring.iter().map(|p| of_box.distance(*p));
    to_area.chain(to_box).fold(f64::INFINITY, f64::min)
}

/// Some edge of one ring intersects an edge of the other.
fn crossing(a: &[P2], b: &[P2]) -> bool {
    let edges = |ring: &[P2]| -> Vec<(P2, P2)> {
        (0..ring.len()).map(|i| (ring[i], ring[(i + 1) % ring.len()])).collect()
    };
    let side = |(p, q): (P2, P2), r: P2| (q - p).cross(r - p);
    let b = edges(b);
    edges(a)
        .into_iter()
        .any(|e| b.iter().any(|f| side(e, f.0) * side(e, f.1) <= 0.0 && side(*f, e.0) * side(*f, e.1) <= 0.0))
}

/// A stop sign: its position, the direction that it faces, and the lane to which it applies.
struct StopSign {
    at: P2,
    facing: f64,
    lane: usize,
}

/// Tracked stop signs, else those of the map. `None` where the log has neither.
fn at_stop_sign(scene: &Scene<'_>) -> Option<Column> {
    let (road, lanes) = (scene.road?, scene.lanes?);
    let mut signs = Vec::new();
    let mut stated = false;
    for body in scene.bodies {
        let named = |k: usize| scene.drive.tracks[k].source_class.eq_ignore_ascii_case("stop_sign");
        if !body.track.is_some_and(named) {
            continue;
        }
        stated = true;
        let at = body.position[0];
        let own = nearest_end(road, at);
        signs.extend(own.map(|lane| StopSign { at, facing: body.heading[0], lane }));
    }
    let of_map = scene.drive.map.as_ref().map(|m| m.signs.as_slice()).unwrap_or_default();
    for sign in of_map.iter().filter(|s| s.kind == "stop") {
        stated = true;
        let at = p2(sign.position.x, sign.position.y);
        for id in &sign.lane_ids {
            // Usable lanes keep the map's order: sorted by id.
            if let Ok(lane) = road.lanes.binary_search_by(|l| l.id.as_str().cmp(id)) {
                let center = &road.lanes[lane].center;
                let facing = wrap(center.smooth_heading_at(center.length(), 1.0) + std::f64::consts::PI);
                signs.push(StopSign { at, facing, lane });
            }
        }
    }
    let governs = |sign: &StopSign, k: usize, body: &Body, i: usize| {
        let facing = P2::from_heading(sign.facing);
        let seen = body.position[i] - sign.at;
        let (forward, left) = (seen.dot(facing), seen.dot(facing.left()));
        lanes.lanes[k][i] == Some(sign.lane)
            && forward > -SIGN_BEHIND_M
            && forward < SIGN_FORWARD_M
            && left < 0.0
            && left > -SIGN_RIGHT_M
            && wrap(body.heading[i] - sign.facing).abs() >= FRAC_PI_2
    };
    stated.then(|| flags(scene, |k, b, i| Tri::from(signs.iter().any(|s| governs(s, k, b, i)))))
}

/// The lane outside of junctions whose right edge ends nearest to a position, within 10 m of it.
fn nearest_end(road: &crate::road::network::Road, at: P2) -> Option<usize> {
    if !at.is_finite() {
        return None;
    }
    let end = |l: usize| {
        let lane = &road.lanes[l];
        let s = lane.center.length();
        let right = P2::from_heading(lane.center.smooth_heading_at(s, 1.0)).left() * lane.widths_at(s).1;
        (lane.center.point_at(s) - right - at).norm()
    };
    let near = road.lanes_near(at, SIGN_FORWARD_M).into_iter();
    let usable = near.filter(|l| !road.lanes[*l].in_junction && road.lanes[*l].kind != LaneKind::Sidewalk);
    usable.min_by(|a, b| end(*a).total_cmp(&end(*b)))
}
