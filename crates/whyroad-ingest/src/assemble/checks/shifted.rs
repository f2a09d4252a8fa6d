//! A map that does not fit the road that is driven: the ways of the vehicles against the center lines of the lanes.
//!
//! Where most of them drive in lanes that run the other way, the map is that of the other side of the road, and is not
//! used. Else the map is searched for the shift with which the vehicles drive in its lanes. A shift by whole lanes is
//! not seen, and neither is one along a road that runs one way only.

use super::fit::{LEAST, LaneLine, Moment, distance_to, lanes, moments};
use super::{turned, warning};
use whyroad_model::scene::Drive;
use whyroad_model::{Bilingual, Diagnostic, Need, RoadMap};

/// At most this many positions are compared.
const MOST: usize = 150;
/// Fewer vehicles are no evidence: they may all drive beside the middle of their lanes.
const LEAST_VEHICLES: usize = 5;
/// A lane that runs within this angle of the motion, as its cosine (20 deg), can be the one that is driven.
const SAME_WAY: f64 = 0.939_7;
/// Greater distances from lanes do not weigh more than this, m.
const OUT_M: f64 = 1.5;
/// Steps of the shifts that are tried last, m.
const FINE_M: f64 = 0.25;
/// Of shifts whose mean distances differ by no more, the least is taken, m.
const EQUAL_M: f64 = 0.05;
/// A map is shifted when vehicles are on average this far from the middle of lanes, m, when the best shift leaves at
/// most this share of it, and when it is at least this far, m. Of 40 recordings whose maps are right, none reaches both
/// figures; with a shift of 1.6 m three quarters do.
const APART_M: f64 = 0.75;
const SHARE: f64 = 0.65;
const LEAST_SHIFT_M: f64 = 0.75;

/// Which shifts are tried.
struct Search {
    /// Up to this, m.
    farthest_m: f64,
    /// At these steps first, m.
    coarse_m: f64,
    /// Who is farther from every lane is not on the road of the map, m.
    reach_m: f64,
    /// With the best shift vehicles are on average at most this far from the middle of lanes, m.
    left_m: f64,
}

/// Who drives in a lane is on average this near to its middle, m.
const IN_THE_MIDDLE_M: f64 = 0.5;

/// Errors of localization and of maps; other origins and datums. Among so many shifts of the second kind, one that
/// puts vehicles near lanes proves little: they have to drive in the middle.
const SEARCHES: [Search; 2] = [
    Search { farthest_m: 4.0, coarse_m: 0.5, reach_m: 6.0, left_m: f64::INFINITY },
    Search { farthest_m: 15.0, coarse_m: 1.0, reach_m: 16.0, left_m: IN_THE_MIDDLE_M },
];

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
    let shifts: Vec<Shift> = SEARCHES.iter().filter_map(|search| shift(&moments, map, search)).collect();
    if let Some(shift) = shifts.iter().find(|s| s.left_m <= IN_THE_MIDDLE_M) {
        return Some(is_shifted(shift));
    }
    if let Some(d) = turned::check(&moments, map) {
        return Some(d);
    }
    if let Some(shift) = shifts.first() {
        return Some(is_shifted(shift));
    }
    let (outside, of) = outside(&moments, map)?;
    Some(lies_beside(outside, of))
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

/// A shift of the map with which vehicles drive in its lanes.
struct Shift {
    /// Where the vehicles would have to be moved, m; the map the other way.
    of_vehicles_m: [f64; 2],
    /// Mean distance from the middle of lanes without it and with it, m.
    apart_m: f64,
    left_m: f64,
}

fn shift(moments: &[Vec<Moment>], map: &RoadMap, search: &Search) -> Option<Shift> {
    let passages = passages(moments, map, search)?;
    let apart_m = mean_distance(&passages, [0.0; 2]);
    if apart_m < APART_M {
        return None;
    }
    let (of_vehicles_m, left_m) = best_shift(&passages, search);
    let far = of_vehicles_m[0].hypot(of_vehicles_m[1]);
    let fits = left_m <= (SHARE * apart_m).min(search.left_m) && far >= LEAST_SHIFT_M;
    fits.then_some(Shift { of_vehicles_m, apart_m, left_m })
}

fn is_shifted(shift: &Shift) -> Diagnostic {
    let [x, y] = shift.of_vehicles_m.map(|v| 0.0 - v);
    let (none, left) = (shift.apart_m, shift.left_m);
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
    d.with_hint(Bilingual::new(
        format!("检查地图与位姿的原点、投影与基准；仍有偏移时用 `--map` 与 `--map-offset {x:.2},{y:.2}` 重新导入"),
        format!(
            "check origin, projection and datum of the map and of the poses; if they are right, ingest again with `--map` \
             and `--map-offset {x:.2},{y:.2}`"
        ),
    ))
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

fn mean_distance(passages: &[Passage], shift: [f64; 2]) -> f64 {
    passages.iter().map(|p| p.distance(shift).min(OUT_M)).sum::<f64>() / passages.len() as f64
}

/// The least shift of the vehicles that puts them into lanes, m, and their mean distance then.
fn best_shift(passages: &[Passage], search: &Search) -> ([f64; 2], f64) {
    let steps = (search.farthest_m / search.coarse_m) as i32;
    let coarse: Vec<([f64; 2], f64)> = around([0.0; 2], search.coarse_m, steps)
        .filter(|s| s[0].hypot(s[1]) <= search.farthest_m)
        .map(|s| (s, mean_distance(passages, s)))
        .collect();
    let least = coarse.iter().map(|(_, left)| *left).fold(f64::INFINITY, f64::min);
    let equal = coarse.into_iter().filter(|(_, left)| *left <= least + EQUAL_M).map(|(s, _)| s);
    let near = equal.min_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1]))).unwrap_or_default();
    let fine = around(near, FINE_M, (search.coarse_m / 2.0 / FINE_M).ceil() as i32)
        .map(|s| (s, mean_distance(passages, s)));
    fine.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((near, least))
}

/// Points of a square grid around one.
fn around([x, y]: [f64; 2], step: f64, steps: i32) -> impl Iterator<Item = [f64; 2]> {
    (-steps..=steps)
        .flat_map(move |i| (-steps..=steps).map(move |j| [x + f64::from(i) * step, y + f64::from(j) * step]))
}

/// The positions of vehicles in or beside lanes; `None` where there are too few.
fn passages(vehicles: &[Vec<Moment>], map: &RoadMap, search: &Search) -> Option<Vec<Passage>> {
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
                out.extend(passage(moment, &lanes, search));
            }
        }
        of_vehicles += usize::from(out.len() > before);
    }
    (of_vehicles >= LEAST_VEHICLES && out.len() >= LEAST).then_some(out)
}

/// A position with the lanes that can be meant; `None` where none is near.
fn passage(moment: &Moment, lanes: &[LaneLine<'_>], search: &Search) -> Option<Passage> {
    let mut pieces = Vec::new();
    moment.each_near(lanes, search.reach_m + search.farthest_m, &mut |start, unit, length| {
        if unit[0] * moment.unit[0] + unit[1] * moment.unit[1] >= SAME_WAY {
            pieces.push((start, unit, length));
        }
    });
    let passage = Passage { at: moment.at, pieces };
    (passage.distance([0.0; 2]) <= search.reach_m).then_some(passage)
}
