//! Facilities on the ego's path: tunnels, toll stations, gates, roundabouts and the like. A kind for which the map has
//! no data stays unavailable: a map without speed bumps does not show that the road has none.

use crate::geometry::{P2, Polygon, p2};
use crate::road::beside_path;
use crate::road::context::Channels;
use crate::road::ego_lane::lane_count;
use crate::road::junction::distance_to_next;
use crate::road::network::{heights, is_on_level};
use crate::road::on_road::{OnRoad, time_to};
use crate::road::path::DrivenPath;
use crate::road::stretch::Stretch;
use crate::table::TableBuilder;
use whyroad_model::Tri;
use whyroad_model::catalog::{
    Number, PerFrame, Signal, id,
    value::{ContextConstruction, GateState, MapTollKind},
};
use whyroad_model::road_map::Facility;

/// Maximum distance of a gate whose state is reported, m.
const GATE_REACH_M: f64 = 100.0;

/// Who drives round an island stays beyond this share of the roundabout's radius from its middle; ours: of the rings of
/// six simulated groups, who drives round is at 0.57 of it and more, who drives through at 0.15 and less.
const THROUGH: f64 = 0.3;

/// Distance signals, with the kinds of facilities that they measure.
const DISTANCES: &[(Signal<PerFrame, Number>, &[&str])] = &[
    (id::MAP_DISTANCE_TO_TUNNEL, &["tunnel"]),
    (id::MAP_DISTANCE_TO_SPEED_BUMP, &["speed_bump"]),
    (id::MAP_DISTANCE_TO_GATE, &["gate"]),
    (id::MAP_DISTANCE_TO_WAITING_AREA, &["waiting_area"]),
    (id::MAP_DISTANCE_TO_CONSTRUCTION, &["construction"]),
    (id::MAP_DISTANCE_TO_BARRIER_GAP, &["barrier_gap"]),
    (id::MAP_DISTANCE_TO_ACCIDENT, &["accident"]),
    (id::MAP_DISTANCE_TO_DRIVEWAY, &["driveway"]),
    (id::MAP_DISTANCE_TO_ROUNDABOUT, &["roundabout"]),
];
/// Kinds of toll facilities; the last one, a plaza, contains booths.
const TOLLS: &[&str] = &["toll_etc", "toll_manual", "toll_plaza"];
/// The values of `map.toll_kind` in the same order.
const TOLL_KINDS: [MapTollKind; 3] = [MapTollKind::Etc, MapTollKind::Manual, MapTollKind::Plaza];

/// Arc lengths at which the path crosses the line through `corners`.
pub fn line_crossings(path: &DrivenPath, corners: &[P2]) -> Vec<f64> {
    let (points, at) = (path.line.points(), path.line.arc_lengths());
    let mut found = Vec::new();
    for edge in corners.windows(2) {
        let along = edge[1] - edge[0];
        for i in 0..points.len() - 1 {
            let step = points[i + 1] - points[i];
            let across = step.cross(along);
            if across.abs() < 1e-12 {
                continue;
            }
            let from = edge[0] - points[i];
            let (t, u) = (from.cross(along) / across, from.cross(step) / across);
            if (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u) {
                found.push(at[i] + t * (at[i + 1] - at[i]));
            }
        }
    }
    found.sort_by(f64::total_cmp);
    found
}

/// The ranges of the path inside a facility; a line gives a range without length.
fn parts(path: &DrivenPath, facility: &Facility) -> Vec<Stretch> {
    let mut corners: Vec<P2> = facility.boundary.iter().map(|p| p2(p.x, p.y)).collect();
    if corners.len() == 2 {
        return line_crossings(path, &corners).into_iter().map(|s| Stretch { from: s, to: s }).collect();
    }
    let Some(area) = Polygon::new(corners.iter().copied()) else { return Vec::new() };
    if corners.first() != corners.last() {
        corners.extend(corners.first().copied());
    }
    let mut bounds = vec![0.0];
    bounds.extend(line_crossings(path, &corners));
    bounds.push(path.line.length());
    let pairs = bounds.windows(2).filter(|w| w[1] > w[0]);
    pairs
        .filter(|w| area.contains(path.line.point_at((w[0] + w[1]) / 2.0)))
        .map(|w| Stretch { from: w[0], to: w[1] })
        .collect()
}

/// Maximum distance beside the path at which a facility of this kind affects traffic there, m. Road works and crashes
/// use space from the edge of a lane, half of which is 1.75 m; behind an opening in the barrier a person may stand,
/// which counts within 7 m of the path (taxonomy, blind_spot_slowdown). The path leads over or through the others.
fn reach_beside(kind: &str) -> f64 {
    match kind {
        "construction" | "accident" => 3.0,
        "barrier_gap" => 7.0,
        _ => 0.0,
    }
}

/// The stretches of the path in a facility, for some kinds also beside it; not above or below it: a motorway leads
/// under the roundabout above it.
fn stretches(path: &DrivenPath, facility: &Facility) -> Vec<Stretch> {
    let mut all = match reach_beside(&facility.kind) {
        reach if reach > 0.0 => beside_path::parts(path, facility, reach),
        _ => parts(path, facility),
    };
    let height = heights(&facility.boundary);
    all.retain(|stretch| {
        let middle = (stretch.from + stretch.to) / 2.0;
        is_on_level(path.z_at(middle), height, path.level_at(middle))
    });
    if facility.kind == "roundabout" {
        all.retain(|stretch| !cuts_through(path, facility, *stretch));
    }
    all
}

/// Whether the path leads through the middle of a ring, as a road does that passes through its island: it drives round
/// nothing there.
fn cuts_through(path: &DrivenPath, facility: &Facility, stretch: Stretch) -> bool {
    let corners: Vec<P2> = facility.boundary.iter().map(|p| p2(p.x, p.y)).collect();
    let (mut doubled, mut x, mut y) = (0.0, 0.0, 0.0);
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let c = a.cross(*b);
        doubled += c;
        x += c * (a.x + b.x);
        y += c * (a.y + b.y);
    }
    let middle = p2(x / (3.0 * doubled), y / (3.0 * doubled));
    let radius = (doubled.abs() / 2.0 / std::f64::consts::PI).sqrt();
    let steps = (stretch.to - stretch.from).ceil().max(1.0);
    let at = |k: f64| path.line.point_at(stretch.from + (stretch.to - stretch.from) * k / steps);
    (0..=steps as usize).map(|k| at(k as f64)).any(|p| (p - middle).norm() < THROUGH * radius)
}

/// Facilities of these kinds on the path, in order of their beginning; for some kinds also beside it.
fn on_path(on: &OnRoad<'_>, kinds: &[&str]) -> Vec<Stretch> {
    let wanted = on.map.facilities.iter().filter(|f| kinds.contains(&f.kind.as_str()));
    let mut found: Vec<Stretch> = wanted.flat_map(|f| stretches(on.path, f)).collect();
    found.sort_by(|a, b| a.from.total_cmp(&b.from).then(a.to.total_cmp(&b.to)));
    found
}

/// The map has data on one of these kinds.
fn covers(on: &OnRoad<'_>, kinds: &[&str]) -> bool {
    kinds.iter().any(|k| on.map.covers(k))
}

fn inside(on: &OnRoad<'_>, stretches: &[Stretch], frame: usize) -> Tri {
    let s = on.path.ego_s[frame];
    Tri::from(stretches.iter().any(|x| x.from <= s && s <= x.to))
}

fn distances(on: &OnRoad<'_>, stretches: &[Stretch]) -> Vec<f64> {
    (0..on.frames()).map(|i| next(on, stretches, i)).collect()
}

/// Distance to the nearest of the stretches that is not behind the ego.
fn next(on: &OnRoad<'_>, stretches: &[Stretch], frame: usize) -> f64 {
    let ahead = |x: &Stretch| distance_to_next(std::slice::from_ref(x), on.path.ego_s[frame], on.ego.front());
    if on.path.ego_s[frame].is_nan() {
        return f64::NAN;
    }
    // One may be inside another (a booth in its plaza): the first that begins is not always the next one.
    stretches.iter().map(ahead).fold(f64::INFINITY, f64::min)
}

/// The kind of the next toll facility and the distance to it, for the same one of them.
fn write_tolls(on: &OnRoad<'_>, table: &mut TableBuilder<'_>) {
    let by_kind: Vec<Vec<Stretch>> = TOLLS.iter().map(|k| on_path(on, &[k])).collect();
    let toll = |i: usize| {
        let distance: Vec<f64> = by_kind.iter().map(|s| next(on, s, i)).collect();
        // A booth on the path is more specific than the plaza around it.
        let booth = (0..2).filter(|&k| distance[k].is_finite());
        let nearest = booth.min_by(|&a, &b| distance[a].total_cmp(&distance[b]));
        let found = nearest.or_else(|| distance[2].is_finite().then_some(2));
        found.map_or((MapTollKind::None, distance[2]), |k| (TOLL_KINDS[k], distance[k]))
    };
    let tolls: Vec<(MapTollKind, f64)> = (0..on.frames()).map(toll).collect();
    table.number(id::MAP_DISTANCE_TO_TOLL, tolls.iter().map(|t| t.1).collect());
    let kinds = tolls.iter().enumerate().map(|(i, t)| on.ego.is_known(i).then_some(t.0));
    table.category(id::MAP_TOLL_KIND, kinds);
}

/// Circulating lanes of each roundabout on the path with its stretches, in order.
fn roundabouts(on: &OnRoad<'_>) -> Vec<(Stretch, f64)> {
    let mut found = Vec::new();
    for facility in on.map.facilities.iter().filter(|f| f.kind == "roundabout") {
        let Some(area) = Polygon::new(facility.boundary.iter().map(|p| p2(p.x, p.y))) else { continue };
        let within = |l: &usize| {
            let line = &on.road.lanes[*l].center;
            [0.25, 0.5, 0.75].iter().all(|t| area.contains(line.point_at(t * line.length())))
        };
        let lanes: Vec<usize> = (0..on.road.lanes.len()).filter(within).collect();
        let (outside, inside): (Vec<usize>, Vec<usize>) =
            lanes.into_iter().partition(|&l| !on.road.lanes[l].in_junction);
        let ring = if outside.is_empty() { inside } else { outside };
        let count = ring.into_iter().map(|l| lane_count(on.road, l)).fold(f64::NAN, f64::max);
        found.extend(stretches(on.path, facility).into_iter().map(|s| (s, count)));
    }
    found.sort_by(|a, b| a.0.from.total_cmp(&b.0.from));
    found
}

fn write_roundabouts(on: &OnRoad<'_>, table: &mut TableBuilder<'_>) {
    let found = roundabouts(on);
    let stretches: Vec<Stretch> = found.iter().map(|f| f.0).collect();
    table.flag(id::MAP_IN_ROUNDABOUT, on.flags(|i| inside(on, &stretches, i)));
    let lanes = |i: usize| {
        let s = on.path.ego_s[i];
        if s.is_nan() {
            return f64::NAN;
        }
        let ahead = found.iter().find(|(x, _)| x.to >= s);
        let near = ahead.filter(|(x, _)| distance_to_next(&[*x], s, on.ego.front()).is_finite());
        near.map_or(0.0, |(_, lanes)| *lanes)
    };
    table.number(id::MAP_ROUNDABOUT_LANES, (0..on.frames()).map(lanes).collect());
}

fn write_gate(on: &OnRoad<'_>, channels: &Channels<'_>, table: &mut TableBuilder<'_>) {
    let known = covers(on, &["gate"]);
    let gates = on_path(on, &["gate"]);
    let stated: Vec<Option<GateState>> = channels.categories("gate");
    let near = |i: usize| !known || next(on, &gates, i) <= GATE_REACH_M;
    table.category(
        id::GATE_STATE,
        (0..on.frames()).map(|i| if near(i) { stated[i] } else { Some(GateState::None) }),
    );
}

/// Writes the signals about facilities for which the map has data, or for road works and gates the context.
pub fn write(on: &OnRoad<'_>, channels: &Channels<'_>, table: &mut TableBuilder<'_>) {
    for (id, kinds) in DISTANCES.iter().filter(|(_, kinds)| covers(on, kinds)) {
        table.number(*id, distances(on, &on_path(on, kinds)));
    }
    if covers(on, &["barrier_gap"]) {
        let gaps = distances(on, &on_path(on, &["barrier_gap"]));
        let time = gaps.iter().enumerate().map(|(i, d)| time_to(*d, on.ego.forward_speed[i]));
        table.number(id::MAP_TIME_TO_BARRIER_GAP, time.collect());
    }
    if covers(on, &["tunnel"]) {
        let tunnels = on_path(on, &["tunnel"]);
        table.flag(id::MAP_IN_TUNNEL, on.flags(|i| inside(on, &tunnels, i)));
    }
    if covers(on, &["roundabout"]) {
        write_roundabouts(on, table);
    }
    if covers(on, TOLLS) {
        write_tolls(on, table);
    }
    if covers(on, &["waiting_area"]) || on.map.lanes.iter().any(|l| l.is_tagged("waiting_area")) {
        let areas = on_path(on, &["waiting_area"]);
        let tagged = |i: usize| on.own_lane(i).is_some_and(|l| l.is_tagged("waiting_area"));
        table.flag(
            id::MAP_IN_WAITING_AREA,
            on.flags(|i| if tagged(i) { Tri::True } else { inside(on, &areas, i) }),
        );
    }
    if channels.has("gate") {
        write_gate(on, channels, table);
    }
    let sites = covers(on, &["construction"]).then(|| on_path(on, &["construction"]));
    if sites.is_some() || channels.has("construction") {
        let stated: Vec<Option<ContextConstruction>> = channels.categories("construction");
        let here = |i: usize| {
            let drawn = sites.as_ref().map_or(Tri::Unknown, |s| inside(on, s, i));
            match (drawn, stated[i]) {
                (Tri::True, _) | (_, Some(ContextConstruction::Here)) => Tri::True,
                (Tri::Unknown, None) => Tri::Unknown,
                _ => Tri::False,
            }
        };
        table.flag(id::MAP_IN_CONSTRUCTION, on.flags(here));
    }
}
