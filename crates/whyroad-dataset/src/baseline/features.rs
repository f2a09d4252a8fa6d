//! The state known at t0, as numbers: the ego's motion and last meta actions, the objects around it, lights, map and
//! route. Nothing after t0 is read, nor anything from the label (`named` objects, components). NaN is unknown.

use crate::sample::{MapElement, Object, Sample, Trajectory};
use serde::{Deserialize, Serialize};

/// The values, in the order of [`NAMES`].
pub type Features = Vec<f64>;

/// The ego's last meta actions; `None`: unknown.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct LastAction {
    /// Longitudinal.
    pub longitudinal: Option<String>,
    /// Lateral.
    pub lateral: Option<String>,
}

/// Names of the features. Speeds in m/s, distances in m, times in s, angles in rad.
pub const NAMES: &[&str] = &[
    "speed_0",
    "speed_0.5",
    "speed_1",
    "speed_2",
    "accel_0",
    "accel_0.5",
    "accel_1",
    "yaw_rate_0",
    "yaw_rate_0.5",
    "yaw_rate_1",
    "heading_1",
    "heading_2",
    "y_1",
    "meta_stop",
    "meta_decelerate",
    "meta_accelerate",
    "meta_left",
    "meta_right",
    "lead_gap",
    "lead_y",
    "lead_speed",
    "lead_closing",
    "lead_ttc",
    "lead_closing_1",
    "front_left_x",
    "front_left_y",
    "front_left_vy",
    "front_left_closing",
    "front_right_x",
    "front_right_y",
    "front_right_vy",
    "front_right_closing",
    "vru_x",
    "vru_y",
    "vru_vy",
    "oncoming_x",
    "oncoming_y",
    "rear_x",
    "rear_closing",
    "crossing_x",
    "crossing_y",
    "crossing_vy",
    "objects_30",
    "vru_30",
    "large_30",
    "light_red",
    "light_yellow",
    "light_green",
    "light_since",
    "stop_line_x",
    "crosswalk_x",
    "junction_x",
    "speed_limit",
    "over_limit",
    "lanes",
    "route_left",
    "route_right",
    "route_straight",
    "route_uturn",
    "route_exit",
];

/// An object counts as seen at t0 when its last observation is at most this old, s.
const FRESH_S: f32 = 0.35;
/// Half the width of the corridor of the lead, m.
const CORRIDOR_M: f64 = 1.8;

/// The features of a sample.
pub fn of(sample: &Sample) -> Features {
    let mut out = Vec::with_capacity(NAMES.len());
    let h = &sample.history;
    let speed = at(h, &h.speed, 0.0);
    out.extend([0.0, 0.5, 1.0, 2.0].map(|t| at(h, &h.speed, t)));
    out.extend([0.0, 0.5, 1.0].map(|t| at(h, &h.accel, t)));
    out.extend([0.0, 0.5, 1.0].map(|t| at(h, &h.yaw_rate, t)));
    out.extend([1.0, 2.0].map(|t| at(h, &h.heading, t)));
    out.push(at(h, &h.y, 1.0));
    actions(&mut out, &last_action(sample));
    objects(&mut out, sample, speed);
    surroundings(&mut out, sample, speed);
    debug_assert_eq!(out.len(), NAMES.len());
    out
}

/// The meta actions at the last step of the history.
pub fn last_action(sample: &Sample) -> LastAction {
    let h = &sample.history;
    let last = |values: &[Option<String>]| {
        h.t_s.iter().rposition(|t| *t <= 0.0).and_then(|i| values.get(i)?.clone())
    };
    LastAction { longitudinal: last(&h.meta_longitudinal), lateral: last(&h.meta_lateral) }
}

/// The value `ago` seconds before t0; NaN without a step within 0.15 s of it.
fn at(h: &Trajectory, values: &[Option<f32>], ago: f32) -> f64 {
    let steps = h.t_s.iter().enumerate().filter(|(_, t)| **t <= 0.0).map(|(i, t)| (i, (t + ago).abs()));
    match steps.min_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((i, off)) if off <= 0.15 => known(values.get(i).copied().flatten()),
        _ => f64::NAN,
    }
}

fn known(v: Option<f32>) -> f64 {
    v.map_or(f64::NAN, f64::from)
}

/// 1 or 0; NaN when it cannot be known.
fn flag(v: Option<bool>) -> f64 {
    v.map_or(f64::NAN, |b| f64::from(u8::from(b)))
}

fn actions(out: &mut Features, last: &LastAction) {
    let has = |action: &Option<String>, word: &str| flag(action.as_ref().map(|a| a.contains(word)));
    out.extend(["stop", "decelerate", "accelerate"].map(|w| has(&last.longitudinal, w)));
    // `decelerate` contains no `accelerate`; the lateral actions name their side.
    out.extend(["left", "right"].map(|w| has(&last.lateral, w)));
}

/// The last observation of an object before or at t0.
#[derive(Clone, Copy)]
struct Seen {
    x: f64,
    y: f64,
    vx: f64,
    vy: f64,
    half_length: f64,
    earlier_vx: f64,
    vru: bool,
    large: bool,
}

fn seen(o: &Object) -> Option<Seen> {
    let row = o.t_s.iter().rposition(|t| *t <= 0.0)?;
    if o.t_s[row] < -FRESH_S {
        return None;
    }
    let earlier = o.t_s.iter().rposition(|t| *t <= -0.9);
    let get = |values: &[Option<f32>], i: usize| known(values.get(i).copied().flatten());
    let (x, y) = (get(&o.x, row), get(&o.y, row));
    let is = |words: &[&str]| words.contains(&o.class.as_str());
    (x.is_finite() && y.is_finite()).then(|| Seen {
        x,
        y,
        vx: get(&o.vx, row),
        vy: get(&o.vy, row),
        half_length: o.length_m.map_or(0.0, f64::from) / 2.0,
        earlier_vx: earlier.map_or(f64::NAN, |i| get(&o.vx, i)),
        vru: is(&["pedestrian", "wheeled_pedestrian", "bicycle", "bicyclist", "cyclist", "e_bike", "animal"]),
        large: is(&["truck", "bus", "large_vehicle", "trailer", "construction_vehicle"]),
    })
}

fn objects(out: &mut Features, sample: &Sample, speed: f64) {
    let all: Vec<Seen> = sample.objects.iter().filter_map(seen).collect();
    let front = sample.ego.reference_to_centre_m + sample.ego.length_m.unwrap_or(0.0) / 2.0;
    let front = f64::from(front);
    let nearest = |keep: &dyn Fn(&Seen) -> bool| {
        all.iter().filter(|o| keep(o)).min_by(|a, b| a.x.hypot(a.y).total_cmp(&b.x.hypot(b.y))).copied()
    };
    let field = |o: Option<Seen>, get: &dyn Fn(Seen) -> f64| o.map_or(f64::NAN, get);
    let lead = nearest(&|o| o.x > 0.0 && o.y.abs() < CORRIDOR_M && !o.vru);
    let gap = |o: Seen| o.x - o.half_length - front;
    out.push(field(lead, &gap));
    out.push(field(lead, &|o| o.y));
    out.push(field(lead, &|o| o.vx));
    out.push(field(lead, &|o| speed - o.vx));
    out.push(field(lead, &|o| if speed - o.vx > 0.1 { (gap(o) / (speed - o.vx)).min(60.0) } else { 60.0 }));
    out.push(field(lead, &|o| o.vx - o.earlier_vx));
    for side in [1.0, -1.0] {
        let beside = nearest(&|o| {
            o.x > -2.0
                && o.y * side >= CORRIDOR_M
                && o.y * side < 6.0
                && !o.vru
                && (o.vx.is_nan() || o.vx >= -1.0)
        });
        out.push(field(beside, &|o| o.x));
        out.push(field(beside, &|o| o.y));
        out.push(field(beside, &|o| o.vy));
        out.push(field(beside, &|o| speed - o.vx));
    }
    let vru = nearest(&|o| o.x > 0.0 && o.vru);
    out.push(field(vru, &|o| o.x));
    out.push(field(vru, &|o| o.y));
    out.push(field(vru, &|o| o.vy));
    let oncoming = nearest(&|o| o.x > 0.0 && o.vx < -1.0 && o.vx.abs() > o.vy.abs());
    out.push(field(oncoming, &|o| o.x));
    out.push(field(oncoming, &|o| o.y));
    let rear = nearest(&|o| o.x < -2.0 && o.y.abs() < CORRIDOR_M);
    out.push(field(rear, &|o| o.x));
    out.push(field(rear, &|o| o.vx - speed));
    let crossing = nearest(&|o| o.x > 0.0 && o.vy.abs() > 1.0 && o.vy.abs() > o.vx.abs() && o.y * o.vy < 0.0);
    out.push(field(crossing, &|o| o.x));
    out.push(field(crossing, &|o| o.y));
    out.push(field(crossing, &|o| o.vy));
    let within =
        |keep: &dyn Fn(&Seen) -> bool| all.iter().filter(|o| o.x.hypot(o.y) < 30.0 && keep(o)).count() as f64;
    out.extend([within(&|_| true), within(&|o| o.vru), within(&|o| o.large)]);
}

fn surroundings(out: &mut Features, sample: &Sample, speed: f64) {
    let lit =
        |color: &str| flag(sample.lights.as_ref().map(|l| l.iter().any(|l| l.color.starts_with(color))));
    out.extend(["red", "yellow", "green"].map(lit));
    let since = sample.lights.iter().flatten().map(|l| f64::from(l.since_s)).fold(f64::NAN, f64::max);
    out.push(since);
    let map = sample.map.as_deref();
    let ahead = |kind: &str| map.map_or(f64::NAN, |m| nearest_ahead(m, kind));
    out.extend(["stop_line", "crosswalk", "junction"].map(ahead));
    let own = map.and_then(own_lane);
    let limit = own.and_then(|l| l.speed_limit_mps).map_or(f64::NAN, f64::from);
    out.extend([limit, speed - limit]);
    out.push(map.map_or(f64::NAN, |m| m.iter().filter(|e| e.kind.ends_with("lane")).count() as f64));
    let route = |word: &str| flag(sample.route.as_ref().map(|r| r == word));
    out.extend(["left", "right", "straight", "uturn", "exit"].map(route));
}

/// Distance along x to the nearest element of this kind ahead, near the ego's axis; NaN: none.
fn nearest_ahead(map: &[MapElement], kind: &str) -> f64 {
    let points = map.iter().filter(|e| e.kind == kind).flat_map(|e| e.x.iter().zip(&e.y));
    let ahead = points.filter(|(x, y)| **x > 0.0 && y.abs() < 8.0).map(|(x, _)| f64::from(*x));
    ahead.fold(f64::NAN, f64::min)
}

/// The lane whose center line comes nearest to the ego.
fn own_lane(map: &[MapElement]) -> Option<&MapElement> {
    let near = |e: &MapElement| e.x.iter().zip(&e.y).map(|(x, y)| x.hypot(*y)).fold(f32::INFINITY, f32::min);
    map.iter().filter(|e| e.kind.ends_with("lane")).min_by(|a, b| near(a).total_cmp(&near(b)))
}
