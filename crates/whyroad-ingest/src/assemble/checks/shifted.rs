//! A map that does not fit the road that is driven: the ways of the vehicles against the center lines of the lanes.
//!
//! Where most of them drive in lanes that run the other way, the map is that of the other side of the road, and is not
//! used. Else the map is searched for the shift with which the vehicles drive in its lanes. A shift by whole lanes is
//! not seen, and neither is one along a road that runs one way only.

use super::warning;
use crate::assemble::geometry::Bounds;
use whyroad_model::road_map::{LaneKind, Point3};
use whyroad_model::scene::{Drive, Motion};
use whyroad_model::{Bilingual, Diagnostic, Need, ObjectClass, RoadMap};

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

/// At least this share of the positions are in lanes that run the other way only: within this of a center line, m, with
/// this cosine of the angle (160 deg).
const AGAINST_SHARE: f64 = 0.8;
const IN_LANE_M: f64 = 2.0;
/// Farther than this from every center line is in no lane, and farther than that where the map has no road, m.
const NEAR_LANE_M: f64 = 3.5;
const BESIDE_LANE_M: f64 = 15.0;
const OTHER_WAY: f64 = -0.939_7;

/// Removes a map whose lanes run against the traffic, and reports one that fits better when it is moved.
pub(super) fn check(drive: &mut Drive) -> Option<Diagnostic> {
    let map = drive.map.as_ref()?;
    let moments = moments(drive)?;
    if let Some((against, of)) = against(&moments, map) {
        (drive.map, drive.lights, drive.meta.map_ref) = (None, None, None);
        for need in [Need::Map, Need::TrafficLights] {
            drive.meta.lacks(need);
        }
        return Some(runs_against(against, of));
    }
    if let Some((outside, of)) = outside(&moments, map) {
        return Some(lies_beside(outside, of));
    }
    shifted(&passages(&moments, map)?)
}

/// How many of the positions in or beside lanes are in none; `None` where they are not most. Others are where the map
/// has no roads.
fn outside(moments: &[Vec<Moment>], map: &RoadMap) -> Option<(usize, usize)> {
    let lanes = lanes(map);
    let (mut outside, mut of) = (0, 0);
    for moment in moments.iter().flatten() {
        let mut nearest = f64::INFINITY;
        moment.each_near(&lanes, BESIDE_LANE_M, &mut |start, unit, length| {
            nearest = nearest.min(distance_to(moment.at, start, unit, length));
        });
        of += usize::from(nearest <= BESIDE_LANE_M);
        outside += usize::from(nearest <= BESIDE_LANE_M && nearest > NEAR_LANE_M);
    }
    (of >= LEAST && outside as f64 >= AGAINST_SHARE * of as f64).then_some((outside, of))
}

fn lies_beside(outside: usize, of: usize) -> Diagnostic {
    warning(
        "ingest.map.shifted",
        format!("地图可能偏移：行驶车辆的 {of} 个位置中有 {outside} 个不在任何车道内；车道、变道与停止线的结果可能有误"),
        format!(
            "the map seems to be shifted: {outside} of {of} positions of moving vehicles lie in no lane; lanes, lane changes \
             and stop lines may be wrong"
        ),
    )
    .with_hint(Bilingual::new(
        "检查地图与位姿的原点、投影与基准；`--map-offset X,Y` 平移地图",
        "check origin, projection and datum of the map and of the poses; `--map-offset X,Y` moves the map",
    ))
}

/// How many positions are in lanes that run the other way only, and of how many; `None` where they are not most.
fn against(moments: &[Vec<Moment>], map: &RoadMap) -> Option<(usize, usize)> {
    let lanes = lanes(map);
    let (mut against, mut of) = (0, 0);
    for moment in moments.iter().flatten() {
        let mut ways = [false; 2];
        moment.each_near(&lanes, IN_LANE_M, &mut |start, unit, length| {
            let along = unit[0] * moment.unit[0] + unit[1] * moment.unit[1];
            let is_in = distance_to(moment.at, start, unit, length) <= IN_LANE_M;
            ways[0] |= is_in && along > OTHER_WAY;
            ways[1] |= is_in && along <= OTHER_WAY;
        });
        against += usize::from(ways == [false, true]);
        of += usize::from(ways != [false; 2]);
    }
    (of >= LEAST && against as f64 >= AGAINST_SHARE * of as f64).then_some((against, of))
}

fn runs_against(against: usize, of: usize) -> Diagnostic {
    let message = Bilingual::new(
        format!("地图的车道与行驶方向相反：{of} 个位置中有 {against} 个只在反向车道内；不使用此地图"),
        format!(
            "the lanes of the map run against the traffic: {against} of {of} positions lie in lanes of the other direction \
             only; the map is not used"
        ),
    );
    Diagnostic::error("ingest.map.against", message).with_hint(Bilingual::new(
        "检查车道线的点序、左侧或右侧通行（OpenDRIVE 的 rule），以及坐标轴是否镜像",
        "check the order of the points of lanes, the side of traffic (`rule` in OpenDRIVE), and whether an axis is mirrored",
    ))
}

fn shifted(passages: &[Passage]) -> Option<Diagnostic> {
    let none = mean_distance(passages, [0.0; 2]);
    if none < APART_M {
        return None;
    }
    let (shift, left) = best_shift(passages);
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
        let at = [self.at[0] + dx, self.at[1] + dy];
        let distances =
            self.pieces.iter().map(|(start, unit, length)| distance_to(at, *start, *unit, *length));
        distances.fold(f64::INFINITY, f64::min)
    }
}

/// Distance from a piece of a line that begins at `start`, m.
fn distance_to(at: [f64; 2], start: [f64; 2], unit: [f64; 2], length: f64) -> f64 {
    let (x, y) = (at[0] - start[0], at[1] - start[1]);
    let along = (x * unit[0] + y * unit[1]).clamp(0.0, length);
    (x - along * unit[0]).hypot(y - along * unit[1])
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

/// Where the vehicles drive, of each; `None` where there is too little.
fn moments(drive: &Drive) -> Option<Vec<Vec<Moment>>> {
    let start = *drive.times.first()?;
    let seconds: Vec<f64> = drive.times.iter().map(|t| t.seconds_since(start)).collect();
    let ego = drive.ego.iter().map(|e| driven(&e.motion, &seconds));
    let others = drive.tracks.iter().filter(|t| drives_in_lanes(t.class)).map(|t| {
        let times: Vec<f64> =
            t.frames.iter().map(|&f| seconds.get(f as usize).copied().unwrap_or(f64::NAN)).collect();
        driven(&t.motion, &times)
    });
    let vehicles: Vec<Vec<Moment>> = ego.chain(others).filter(|v| !v.is_empty()).collect();
    (vehicles.iter().map(Vec::len).sum::<usize>() >= LEAST).then_some(vehicles)
}

/// Lanes that vehicles drive in.
fn lanes(map: &RoadMap) -> Vec<(&[Point3], Bounds)> {
    let driven = map.lanes.iter().filter(|l| matches!(l.kind, LaneKind::Vehicle | LaneKind::Bus));
    driven.map(|l| (l.center.as_slice(), Bounds::of(&l.center))).collect()
}

/// The positions of vehicles in or beside lanes; `None` where there are too few.
fn passages(vehicles: &[Vec<Moment>], map: &RoadMap) -> Option<Vec<Passage>> {
    let lanes = lanes(map);
    let all: usize = vehicles.iter().map(Vec::len).sum();
    let stride = all.div_ceil(MOST);
    let mut of_vehicles = 0;
    let (mut out, mut count) = (Vec::new(), 0_usize);
    for vehicle in vehicles {
        let before = out.len();
        for moment in vehicle {
            count += 1;
            if count.is_multiple_of(stride) {
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
    /// Calls `each` with start, direction and length of the pieces of lanes within `reach`, m, and some beyond.
    fn each_near(
        &self,
        lanes: &[(&[Point3], Bounds)],
        reach: f64,
        each: &mut dyn FnMut([f64; 2], [f64; 2], f64),
    ) {
        let [x, y] = self.at;
        let here = Bounds::of(&[Point3 { x, y, z: 0.0 }]);
        for (line, _) in lanes.iter().filter(|(_, bounds)| !bounds.are_apart(&here, reach)) {
            for w in line.windows(2) {
                let (dx, dy) = (w[1].x - w[0].x, w[1].y - w[0].y);
                let length = dx.hypot(dy);
                if length > 1e-3 {
                    each([w[0].x, w[0].y], [dx / length, dy / length], length);
                }
            }
        }
    }

    /// With the lanes that can be meant; `None` where none is near.
    fn passage(&self, lanes: &[(&[Point3], Bounds)]) -> Option<Passage> {
        let mut pieces = Vec::new();
        self.each_near(lanes, REACH_M + FARTHEST_M, &mut |start, unit, length| {
            if unit[0] * self.unit[0] + unit[1] * self.unit[1] >= SAME_WAY {
                pieces.push((start, unit, length));
            }
        });
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
