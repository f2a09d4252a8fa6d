//! Traffic around the ego: density, speed, congestion, and the queue before the ego's stop line.

use crate::geometry::{P2, p2};
use crate::road::ego_lane::OnCorridor;
use crate::road::network::Road;
use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use crate::target::lanes::drives;
use crate::target::placement::{MOVING_MPS, Placement};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_4;
use whyroad_model::catalog::id;
use whyroad_model::{RoadMap, Tri};

/// Vehicles within this distance of the ego count for the density, m.
const DENSITY_REACH_M: f64 = 50.0;
/// Vehicles within these distances along and beside the path count for the flow, m.
const FLOW_REACH_M: (f64, f64) = (80.0, 12.0);
/// A stationary vehicle farther beside the path than this is parked, m.
const PARKED_BESIDE_M: f64 = 6.0;
/// Maximum mean speed of congestion: 30 km/h (LABELING.md 4).
const CONGESTED_MPS: f64 = 30.0 / 3.6;
/// Minimum number of vehicles of a flow.
const CONGESTED_LEAST: usize = 3;
/// Maximum distance of a stop line with a queue for the ego, m.
const LINE_REACH_M: f64 = 100.0;
/// The queue position is kept for this long after the ego moved off, s.
const QUEUE_HELD_S: f64 = 5.0;

/// The target belongs to the same traffic flow as the ego.
fn flows(p: &Placement) -> bool {
    let beside = p.path.lateral.abs();
    let near = p.ahead.abs() <= FLOW_REACH_M.0 && beside <= FLOW_REACH_M.1 && p.same_level;
    let same_way = p.turned() <= FRAC_PI_4;
    near && same_way && (p.speed() >= MOVING_MPS || p.in_way || beside <= PARKED_BESIDE_M)
}

/// The center of each stop line of the map, by lane.
fn stop_lines(map: &RoadMap) -> BTreeMap<&str, P2> {
    let mut found = BTreeMap::new();
    for line in map.stop_lines.iter().filter(|l| !l.line.is_empty()) {
        let share = 1.0 / line.line.len() as f64;
        let middle = line.line.iter().fold(p2(0.0, 0.0), |sum, p| sum + p2(p.x, p.y) * share);
        found.extend(line.lane_ids.iter().map(|id| (id.as_str(), middle)));
    }
    found
}

/// Distance from the ego's front bumper to the next stop line of its lane, or to the junction if none is drawn, m.
fn next_line(road: &Road, lines: &BTreeMap<&str, P2>, on: OnCorridor<'_>, front: f64) -> Option<f64> {
    let corridor = on.corridor;
    let ahead = |s: f64| Some(s - on.s - front).filter(|d| *d > -front && *d <= LINE_REACH_M);
    for (k, &(lane, start)) in corridor.lanes.iter().enumerate() {
        let end = corridor.lane_end(k);
        if end < on.s {
            continue;
        }
        if road.lanes[lane].in_junction {
            if start > on.s {
                return ahead(start);
            }
            continue;
        }
        let drawn = lines.get(road.lanes[lane].id.as_str());
        let s = drawn.map(|&p| corridor.line.project_between(p, start - 5.0, end + 5.0).s);
        if let Some(s) = s.filter(|s| *s >= on.s) {
            return ahead(s);
        }
    }
    None
}

/// Number of stationary vehicles, including bicycles, between the ego and its line in each frame; NaN where the ego has
/// no lane.
fn queue(scene: &Interaction<'_>, road: &Road, map: &RoadMap) -> Vec<f64> {
    let ego = scene.around.ego;
    let front = ego.length / 2.0;
    let lines = stop_lines(map);
    let ahead = |i: usize| -> Option<f64> {
        let on = scene.around.lanes.and_then(|l| l.at(i))?;
        Some(next_line(road, &lines, on, front).unwrap_or(f64::NEG_INFINITY))
    };
    let distance: Vec<Option<f64>> = (0..ego.len()).map(ahead).collect();
    let mut count: Vec<f64> = distance.iter().map(|d| if d.is_some() { 0.0 } else { f64::NAN }).collect();
    for target in scene.targets.iter().filter(|t| drives(t.track.class)) {
        for p in target.places.iter().flatten() {
            let to_line = distance[p.frame].unwrap_or(f64::NEG_INFINITY);
            let between = p.ahead > 0.0 && p.near - front <= to_line;
            if between && p.blocks_way() && p.speed() < MOVING_MPS {
                count[p.frame] += 1.0;
            }
        }
    }
    hold(&mut count, &ego.standstill, scene.times);
    count
}

/// During a standstill, and shortly after it, the maximum count of that standstill is kept.
fn hold(count: &mut [f64], standstill: &[Tri], times: &[f64]) {
    let mut i = 0;
    while i < count.len() {
        if !standstill[i].is_true() {
            i += 1;
            continue;
        }
        let end = (i..count.len()).find(|&j| !standstill[j].is_true()).unwrap_or(count.len());
        let most = count[i..end].iter().copied().fold(f64::NAN, f64::max);
        let until = times[end - 1] + QUEUE_HELD_S;
        let held = (end..count.len()).take_while(|&j| times[j] <= until && !standstill[j].is_true()).last();
        let last = held.map_or(end, |j| j + 1);
        for value in count[i..last].iter_mut().filter(|v| !v.is_nan()) {
            *value = most;
        }
        i = last;
    }
}

/// Writes `traffic.density`, `mean_speed`, `congested`, `queue_position`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let ego = scene.around.ego;
    let n = ego.len();
    let (mut density, mut flow) = (vec![0.0; n], vec![(0_usize, 0.0); n]);
    for target in scene.targets.iter().filter(|t| t.track.class.is_vehicle()) {
        for p in target.places.iter().flatten() {
            if (p.footprint.center - ego.position[p.frame]).is_within(DENSITY_REACH_M) {
                density[p.frame] += 1.0;
            }
            if flows(p) && p.speed().is_finite() {
                flow[p.frame].0 += 1;
                flow[p.frame].1 += p.speed();
            }
        }
    }
    let known = |i: usize| ego.is_known(i);
    table.number(id::TRAFFIC_DENSITY, (0..n).map(|i| if known(i) { density[i] } else { f64::NAN }).collect());
    let mean: Vec<f64> =
        flow.iter().map(|&(count, sum)| if count > 0 { sum / count as f64 } else { f64::NAN }).collect();
    let own = table.numbers(id::EGO_MEAN_SPEED).map_or_else(|| vec![f64::NAN; n], <[f64]>::to_vec);
    let congested = |i: usize| match (known(i), flow[i].0 >= CONGESTED_LEAST && mean[i] < CONGESTED_MPS) {
        (false, _) => Tri::Unknown,
        (true, false) => Tri::False,
        (true, true) if own[i].is_nan() => Tri::Unknown,
        (true, true) => Tri::from(own[i] < CONGESTED_MPS),
    };
    table.flag(id::TRAFFIC_CONGESTED, (0..n).map(congested).collect());
    table.number(id::TRAFFIC_MEAN_SPEED, mean);
    if let (Some(road), Some(map)) = (scene.around.road, &scene.drive.map) {
        table.number(id::TRAFFIC_QUEUE_POSITION, queue(scene, road, map));
    }
}
