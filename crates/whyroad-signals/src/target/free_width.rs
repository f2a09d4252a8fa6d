//! Free space beside the ego and ahead of it: to the edge of the road and to tracked objects. Lateral means across the
//! ego's box for the space beside it, across its driven path for the space ahead.

use crate::ego::motion::EgoMotion;
use crate::geometry::{OrientedBox, P2, Polygon};
use crate::road::network::{LaneShape, Road};
use crate::road::on_road::OnRoad;
use crate::road::path::DrivenPath;
use crate::table::TableBuilder;
use crate::target::placement::{MOVING_MPS, Placement, Target};
use std::cell::Cell;
use std::f64::consts::FRAC_PI_3;
use whyroad_model::catalog::id;
use whyroad_model::road_map::LaneKind;

/// Maximum free space to one side that is measured, m.
const FREE_M: f64 = 10.0;
/// Sampling step of the ground, lateral and along the path, m.
const PROBE_M: f64 = 0.25;
const STATION_M: f64 = 1.0;
/// Length of the corridor ahead from the front bumper, m.
const AHEAD_M: f64 = 40.0;

/// Distances from the path to the road's edges, left then right, at stations along it; NaN where the path is off the
/// road, and where the ego is never near.
struct Edges {
    stations: Vec<[f64; 2]>,
}

/// The ground that counts as road: drivable areas, junctions, lanes for all wheeled traffic, shoulders.
struct Ground<'a> {
    road: &'a Road,
    /// The area that contained the last position: it usually contains the next one, too.
    last: Cell<Option<&'a Polygon>>,
}

impl Ground<'_> {
    fn is_road(&self, p: P2) -> bool {
        if self.last.get().is_some_and(|area| area.contains(p)) {
            return true;
        }
        let counts = |lane: &LaneShape| {
            matches!(lane.kind, LaneKind::Vehicle | LaneKind::Bus | LaneKind::Bike | LaneKind::Shoulder)
        };
        let road = self.road;
        let area = road.drivable_at(p).or_else(|| road.junction_at(p)).or_else(|| road.lane_at(p, counts));
        if area.is_some() {
            self.last.set(area);
        }
        area.is_some()
    }
}

/// Distance that the road continues from `p` in direction `across`, at most [`FREE_M`] beyond `within`, m.
fn edge(ground: &Ground<'_>, p: P2, across: P2, within: f64) -> f64 {
    let steps = ((FREE_M + within) / PROBE_M) as usize;
    let off = |k: usize| !ground.is_road(p + across * (k as f64 * PROBE_M));
    // Two consecutive samples: between separately drawn lanes there are seams.
    let Some(k) = (1..=steps).find(|&k| off(k) && off(k + 1)) else { return FREE_M + within };
    // Between the last sample on the road and the first off it; as accurate as positions are, so that no step is
    // visible.
    let (mut on, mut out) = ((k - 1) as f64 * PROBE_M, k as f64 * PROBE_M);
    while out - on > 1e-6 {
        let middle = (on + out) / 2.0;
        if ground.is_road(p + across * middle) { on = middle } else { out = middle }
    }
    on
}

impl Edges {
    /// From the ego's rear at its first position on the path to [`AHEAD_M`] before its front bumper at the last one.
    fn new(road: &Road, path: &DrivenPath, ego: &EgoMotion) -> Self {
        let (half_width, front) = (ego.width / 2.0, ego.front());
        let count = (path.line.length() / STATION_M) as usize + 1;
        let ground = Ground { road, last: Cell::new(None) };
        let known = || path.ego_s.iter().copied().filter(|s| s.is_finite());
        let from = known().fold(f64::INFINITY, f64::min) - front - STATION_M;
        let to = known().fold(f64::NEG_INFINITY, f64::max) + front + AHEAD_M + STATION_M;
        let at = |k: usize| {
            let s = k as f64 * STATION_M;
            // Queries beyond the ends use the first or the last station.
            let is_asked_for = (from..=to).contains(&s) || k == 0 || k + 1 == count;
            let p = path.line.point_at(s);
            if !is_asked_for || !ground.is_road(p) {
                return [f64::NAN; 2];
            }
            let left = P2::from_heading(path.heading_at(s)).left();
            [edge(&ground, p, left, half_width), edge(&ground, p, left * -1.0, half_width)]
        };
        Self { stations: (0..count).map(at).collect() }
    }

    /// Stations between two arc lengths; at least one.
    fn between(&self, from: f64, to: f64) -> std::ops::Range<usize> {
        let last = self.stations.len() - 1;
        let first = ((from / STATION_M).ceil().max(0.0) as usize).min(last);
        first..((to / STATION_M).floor().max(0.0) as usize).clamp(first, last) + 1
    }
}

/// The part of `other` beside the ego's box: minimum distance from the side of the ego, left then right, m. A part that
/// overlaps the ego's box has distance 0 on the side of its center.
fn beside(ego: &OrientedBox, other: &OrientedBox) -> [f64; 2] {
    let (forward, left) = (ego.direction(), ego.direction().left());
    let half = ego.length / 2.0;
    // Clips the footprint to the extent of the ego's box.
    let mut ring: Vec<P2> = other
        .corners()
        .map(|c| P2 { x: (c - ego.center).dot(forward), y: (c - ego.center).dot(left) })
        .into();
    for sign in [1.0, -1.0] {
        let depth = |p: &P2| half - sign * p.x;
        let mut kept = Vec::new();
        for (i, a) in ring.iter().enumerate() {
            let b = &ring[(i + 1) % ring.len()];
            if depth(a) >= 0.0 {
                kept.push(*a);
            }
            if (depth(a) >= 0.0) != (depth(b) >= 0.0) {
                kept.push(*a + (*b - *a) * (depth(a) / (depth(a) - depth(b))));
            }
        }
        ring = kept;
        if ring.is_empty() {
            return [f64::INFINITY; 2];
        }
    }
    let (low, high) =
        ring.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.y), h.max(p.y)));
    if low + high >= 0.0 {
        [(low - ego.width / 2.0).max(0.0), f64::INFINITY]
    } else {
        [f64::INFINITY, (-high - ego.width / 2.0).max(0.0)]
    }
}

/// Moves along the path: it will be elsewhere when the ego gets there.
fn moves_along(p: &Placement) -> bool {
    p.speed() >= MOVING_MPS && p.turned() < FRAC_PI_3
}

/// By frame, the placements that are near the ego's box or along the corridor ahead of it.
fn by_frame<'t>(on: &OnRoad<'_>, targets: &'t [Target<'_>]) -> Vec<Vec<&'t Placement>> {
    let mut found: Vec<Vec<&Placement>> = vec![Vec::new(); on.frames()];
    for p in targets.iter().flat_map(|t| t.places.iter().flatten()) {
        if p.same_level && p.is_sized() && (is_in_corridor(on, p) || is_beside(on, p)) {
            found[p.frame].push(p);
        }
    }
    found
}

/// Near enough to limit the space beside the ego.
fn is_beside(on: &OnRoad<'_>, p: &Placement) -> bool {
    let ego = on.ego.footprint(p.frame);
    (p.footprint.center - ego.center).is_within(ego.radius() + FREE_M + p.footprint.radius())
}

fn room_beside(on: &OnRoad<'_>, edges: &Edges, near: &[&Placement], frame: usize) -> [f64; 2] {
    let ego = on.ego.footprint(frame);
    let s = on.path.ego_s[frame];
    let mut room = [FREE_M; 2];
    for k in edges.between(s - ego.length / 2.0, s + ego.length / 2.0) {
        // NaN, where the path is off the road, must be kept: `min` would ignore it.
        let edge = edges.stations[k].map(|e| (e - ego.width / 2.0).clamp(0.0, FREE_M));
        room = [0, 1].map(|i| if edge[i] < room[i] || edge[i].is_nan() { edge[i] } else { room[i] });
    }
    for p in near.iter().filter(|p| is_beside(on, p)) {
        let free = beside(&ego, &p.footprint);
        room = [0, 1].map(|i| if free[i] < room[i] { free[i] } else { room[i] });
    }
    room
}

/// Arc lengths of the ego's center and of its front bumper, where the corridor ahead begins.
fn corridor_ahead(on: &OnRoad<'_>, frame: usize) -> (f64, f64) {
    let s = on.path.ego_s[frame];
    (s, s + on.ego.front())
}

/// Along the corridor ahead.
fn is_in_corridor(on: &OnRoad<'_>, p: &Placement) -> bool {
    let (s, from) = corridor_ahead(on, p.frame);
    let beyond = s + p.far < from || s + p.near > from + AHEAD_M;
    !beyond
}

/// Minimum width of the corridor ahead between the road's edges and the objects that meet `counts`.
fn room_ahead(
    on: &OnRoad<'_>,
    edges: &Edges,
    near: &[&Placement],
    frame: usize,
    counts: fn(&Placement) -> bool,
) -> f64 {
    let (s, from) = corridor_ahead(on, frame);
    let range = edges.between(from, from + AHEAD_M);
    let mut room: Vec<[f64; 2]> =
        edges.stations[range.clone()].iter().map(|e| e.map(|d| d.min(FREE_M))).collect();
    for p in near.iter().filter(|p| counts(p)) {
        let (first, last) = (s + p.near, s + p.far);
        if last < from || first > from + AHEAD_M {
            continue;
        }
        let covered = edges.between(first.max(from).floor(), last.min(from + AHEAD_M).ceil());
        // Where the path was really driven, an object across it was gone when the ego came; beyond that, the wider side
        // remains.
        let across = p.path.low <= 0.0 && p.path.high >= 0.0;
        if across && first <= on.path.driven.1 {
            continue;
        }
        for k in covered.filter(|k| range.contains(k)) {
            let side = &mut room[k - range.start];
            if across {
                let (left, right) = (side[0] - p.path.high, side[1] + p.path.low);
                *side = [left.max(right).max(0.0), 0.0];
            } else if p.path.low > 0.0 {
                side[0] = if p.path.low < side[0] { p.path.low } else { side[0] };
            } else {
                side[1] = if -p.path.high < side[1] { -p.path.high } else { side[1] };
            }
        }
    }
    // Where the path leaves the road, its width is unknown.
    room.iter()
        .map(|r| r[0] + r[1])
        .fold(f64::INFINITY, |least, w| if least.is_nan() || w.is_nan() { f64::NAN } else { least.min(w) })
}

/// Writes `map.free_width_left`, `free_width_right`, `free_width_ahead`, `meeting_width_ahead`.
pub fn write(on: &OnRoad<'_>, targets: &[Target<'_>], table: &mut TableBuilder<'_>) {
    if !on.ego.length.is_finite() || !on.ego.width.is_finite() {
        return;
    }
    let edges = Edges::new(on.road, on.path, on.ego);
    let near = by_frame(on, targets);
    let frames = || 0..on.frames();
    let beside =
        |i: usize| if on.ego.is_known(i) { room_beside(on, &edges, &near[i], i) } else { [f64::NAN; 2] };
    let room: Vec<[f64; 2]> = frames().map(beside).collect();
    table.number(id::MAP_FREE_WIDTH_LEFT, room.iter().map(|r| r[0]).collect());
    table.number(id::MAP_FREE_WIDTH_RIGHT, room.iter().map(|r| r[1]).collect());
    let ahead = |i: usize| {
        if !on.ego.is_known(i) {
            return (f64::NAN, f64::NAN);
        }
        let along: Vec<&Placement> = near[i].iter().copied().filter(|p| is_in_corridor(on, p)).collect();
        let room = |counts: fn(&Placement) -> bool| room_ahead(on, &edges, &along, i, counts);
        (room(|p| !moves_along(p)), room(|p| p.speed() < MOVING_MPS))
    };
    let (free, meeting): (Vec<f64>, Vec<f64>) = frames().map(ahead).unzip();
    table.number(id::MAP_FREE_WIDTH_AHEAD, free);
    table.number(id::MAP_MEETING_WIDTH_AHEAD, meeting);
}
