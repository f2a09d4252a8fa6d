//! A map that lies beside the road that is driven: the ways of the vehicles against the center lines of the lanes.
//!
//! The map is searched for the shift with which the vehicles drive in its lanes. A shift by whole lanes is not seen,
//! and neither is one along a road that runs one way only.

use super::warning;
use crate::assemble::geometry::Bounds;
use whyroad_model::road_map::{LaneKind, Point3};
use whyroad_model::scene::{Drive, Motion};
use whyroad_model::{Bilingual, Diagnostic, ObjectClass, RoadMap};

/// A direction of motion is taken over this time, s, of those who move at this speed, m/s.
const SPAN_S: f64 = 0.5;
const MOVING_MPS: f64 = 3.0;
/// One position of a vehicle per this time, s, and at most this many of a vehicle and of all.
const EVERY_S: f64 = 1.0;
const PER_VEHICLE: usize = 20;
const MOST: usize = 150;
/// Fewer vehicles or positions are no evidence: they may all drive beside the middle of their lanes.
const LEAST_VEHICLES: usize = 5;
const LEAST: usize = 25;
/// A lane that runs within this angle of the motion, as its cosine (20 deg), can be the one that is driven.
const SAME_WAY: f64 = 0.939_7;
/// Who is farther from every lane is not in one, m; greater distances do not weigh more than [`OUT_M`].
const REACH_M: f64 = 6.0;
const OUT_M: f64 = 1.5;
/// Shifts that are tried: up to this, m, at these steps, first coarse, then fine.
const FARTHEST_M: f64 = 4.0;
const COARSE_M: f64 = 0.5;
const FINE_M: f64 = 0.25;
/// Of shifts whose mean distances differ by no more, the least is taken, m.
const EQUAL_M: f64 = 0.05;
/// A map is shifted when vehicles are on average this far from the middle of lanes, m, when the best shift leaves at
/// most this share of it, and when it is at least this far, m. Of 40 recordings whose maps are right, none reaches both
/// figures; with a shift of 1.6 m three quarters do.
const APART_M: f64 = 0.75;
const SHARE: f64 = 0.65;
const LEAST_SHIFT_M: f64 = 0.75;

/// Reports a map whose lanes fit the ways of the vehicles better when it is moved.
pub(super) fn check(drive: &Drive) -> Option<Diagnostic> {
    let map = drive.map.as_ref()?;
    let passages = passages(drive, map)?;
    let none = mean_distance(&passages, [0.0; 2]);
    if none < APART_M {
        return None;
    }
    let (shift, left) = best_shift(&passages);
    let far = shift[0].hypot(shift[1]);
    if left > SHARE * none || far < LEAST_SHIFT_M {
        return None;
    }
    // The map has to move the other way than the vehicles.
    let [x, y] = shift.map(|v| 0.0 - v);
    let d = warning(
        "ingest.map.shifted",
        format!(
            "地图可能偏移：车辆平均偏离车道中心线 {none:.1} m；把地图平移 ({x:.2}, {y:.2}) m 后为 {left:.1} m；车道、变道与停止线的结果可能有误"
        ),
        format!(
            "the map seems to be shifted: vehicles drive {none:.1} m beside the middle of its lanes on average, and \
             {left:.1} m when it is moved by ({x:.2}, {y:.2}) m; lanes, lane changes and stop lines may be wrong"
        ),
    );
    Some(d.with_hint(Bilingual::new(
        format!("检查地图与位姿的原点、投影与基准；仍有偏移时用 `--map` 与 `--map-offset {x:.2},{y:.2}` 重新导入"),
        format!(
            "check origin, projection and datum of the map and of the poses; if they are right, ingest again with `--map` \
             and `--map-offset {x:.2},{y:.2}`"
        ),
    )))
}

/// A position of a moving vehicle with the pieces of lanes that it can be in: their start, direction and length.
struct Passage {
    at: [f64; 2],
    pieces: Vec<([f64; 2], [f64; 2], f64)>,
}

impl Passage {
    /// Distance of the moved position from the nearest lane, m; infinite without one.
    fn distance(&self, [dx, dy]: [f64; 2]) -> f64 {
        let distances = self.pieces.iter().map(|(start, unit, length)| {
            let (x, y) = (self.at[0] + dx - start[0], self.at[1] + dy - start[1]);
            let along = (x * unit[0] + y * unit[1]).clamp(0.0, *length);
            (x - along * unit[0]).hypot(y - along * unit[1])
        });
        distances.fold(f64::INFINITY, f64::min)
    }
}

fn mean_distance(passages: &[Passage], shift: [f64; 2]) -> f64 {
    passages.iter().map(|p| p.distance(shift).min(OUT_M)).sum::<f64>() / passages.len() as f64
}

/// The least shift of the vehicles that puts them into lanes, m, and their mean distance then.
fn best_shift(passages: &[Passage]) -> ([f64; 2], f64) {
    let steps = (FARTHEST_M / COARSE_M) as i32;
    let coarse: Vec<([f64; 2], f64)> = around([0.0; 2], COARSE_M, steps)
        .filter(|s| s[0].hypot(s[1]) <= FARTHEST_M)
        .map(|s| (s, mean_distance(passages, s)))
        .collect();
    let least = coarse.iter().map(|(_, left)| *left).fold(f64::INFINITY, f64::min);
    let equal = coarse.into_iter().filter(|(_, left)| *left <= least + EQUAL_M).map(|(s, _)| s);
    let near = equal.min_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1]))).unwrap_or_default();
    let fine = around(near, FINE_M, 1).map(|s| (s, mean_distance(passages, s)));
    fine.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((near, least))
}

/// Points of a square grid around one.
fn around([x, y]: [f64; 2], step: f64, steps: i32) -> impl Iterator<Item = [f64; 2]> {
    (-steps..=steps)
        .flat_map(move |i| (-steps..=steps).map(move |j| [x + f64::from(i) * step, y + f64::from(j) * step]))
}

/// Positions of vehicles that drive in or beside lanes; `None` where there are too few.
fn passages(drive: &Drive, map: &RoadMap) -> Option<Vec<Passage>> {
    let start = *drive.times.first()?;
    let seconds: Vec<f64> = drive.times.iter().map(|t| t.seconds_since(start)).collect();
    let ego = drive.ego.iter().map(|e| driven(&e.motion, &seconds));
    let others = drive.tracks.iter().filter(|t| drives_in_lanes(t.class)).map(|t| {
        let times: Vec<f64> =
            t.frames.iter().map(|&f| seconds.get(f as usize).copied().unwrap_or(f64::NAN)).collect();
        driven(&t.motion, &times)
    });
    let vehicles: Vec<Vec<Moment>> = ego.chain(others).filter(|v| !v.is_empty()).collect();
    if vehicles.len() < LEAST_VEHICLES || vehicles.iter().map(Vec::len).sum::<usize>() < LEAST {
        return None;
    }
    let lanes: Vec<(&[Point3], Bounds)> = map
        .lanes
        .iter()
        .filter(|l| matches!(l.kind, LaneKind::Vehicle | LaneKind::Bus))
        .map(|l| (l.center.as_slice(), Bounds::of(&l.center)))
        .collect();
    let all: usize = vehicles.iter().map(Vec::len).sum();
    let stride = all.div_ceil(MOST);
    let mut of_vehicles = 0;
    let (mut out, mut count) = (Vec::new(), 0_usize);
    for vehicle in &vehicles {
        let before = out.len();
        for moment in vehicle {
            count += 1;
            if count % stride == 0 {
                out.extend(moment.passage(&lanes));
            }
        }
        of_vehicles += usize::from(out.len() > before);
    }
    (of_vehicles >= LEAST_VEHICLES && out.len() >= LEAST).then_some(out)
}

/// Two-wheelers drive anywhere in a lane.
fn drives_in_lanes(class: ObjectClass) -> bool {
    let rides = matches!(class, ObjectClass::Motorcycle | ObjectClass::Motorcyclist | ObjectClass::Tricycle);
    class.is_vehicle() && !rides
}

/// Where a vehicle is and the direction in which it moves.
struct Moment {
    at: [f64; 2],
    unit: [f64; 2],
}

impl Moment {
    /// With the lanes that can be meant; `None` where none is near.
    fn passage(&self, lanes: &[(&[Point3], Bounds)]) -> Option<Passage> {
        let [x, y] = self.at;
        let here = Bounds::of(&[Point3 { x, y, z: 0.0 }]);
        let mut pieces = Vec::new();
        for (line, bounds) in lanes {
            if bounds.are_apart(&here, REACH_M + FARTHEST_M) {
                continue;
            }
            for w in line.windows(2) {
                let (dx, dy) = (w[1].x - w[0].x, w[1].y - w[0].y);
                let length = dx.hypot(dy);
                let unit = [dx / length, dy / length];
                if length > 1e-3 && unit[0] * self.unit[0] + unit[1] * self.unit[1] >= SAME_WAY {
                    pieces.push(([w[0].x, w[0].y], unit, length));
                }
            }
        }
        let passage = Passage { at: self.at, pieces };
        (passage.distance([0.0; 2]) <= REACH_M).then_some(passage)
    }
}

/// Moments of a motion whose rows are at these times, s: one in [`EVERY_S`] while it moves.
fn driven(m: &Motion, seconds: &[f64]) -> Vec<Moment> {
    let mut out = Vec::new();
    let (mut end, mut next) = (0, f64::NEG_INFINITY);
    for i in 0..m.len().min(seconds.len()) {
        while end < seconds.len() && seconds[end] < seconds[i] + SPAN_S - 1e-3 {
            end += 1;
        }
        if end >= seconds.len().min(m.len()) || out.len() >= PER_VEHICLE {
            break;
        }
        let took = seconds[end] - seconds[i];
        let (dx, dy) = (m.x[end] - m.x[i], m.y[end] - m.y[i]);
        let length = dx.hypot(dy);
        // A comparison with what is not known is false.
        let moves = took <= 2.0 * SPAN_S && length >= MOVING_MPS * took && length > 0.0;
        if seconds[i] >= next && moves {
            let at = [f64::midpoint(m.x[i], m.x[end]), f64::midpoint(m.y[i], m.y[end])];
            out.push(Moment { at, unit: [dx / length, dy / length] });
            next = seconds[i] + EVERY_S;
        }
    }
    out
}
