//! Lanes of a road, placed: edges and center lines in driving direction, with what the file says of them.

use super::cubic::Profile;
use super::document::{DocLane, Mark, Road, Section};
use super::marks;
use super::plan_view::{Pose, Shape, poses};
use super::spans::longest;
use std::collections::BTreeMap;
use whyroad_model::road_map::{Lane, LaneKind, Point3};

/// Longest road, m, and the most points that the lanes of a file may have.
pub(super) const MAX_ROAD_M: f64 = 1e5;
const MAX_POINTS: usize = 8_000_000;
/// Spacing of points where the road bends or changes its width or slope, m; elsewhere the corners are enough.
const STEP_M: f64 = 1.0;
/// Shorter sections and narrower lanes have no area, m.
const SHORT_M: f64 = 1e-6;
const NARROW_M: f64 = 0.1;

/// A lane of a section of a road, by their indices in the file; `lane` is the file's own number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct LaneKey {
    pub road: usize,
    pub section: usize,
    pub lane: i32,
}

/// What is left of [`MAX_POINTS`].
pub(super) struct Budget(usize);

impl Default for Budget {
    fn default() -> Self {
        Self(MAX_POINTS)
    }
}

/// Results for the lanes of a road.
#[derive(Default)]
pub(super) struct Placed {
    pub lanes: BTreeMap<LaneKey, Lane>,
    /// Lanes without road users: medians, borders, rails.
    pub set_aside: usize,
    /// Lanes that cannot be placed; a description of the first.
    pub invalid: Vec<String>,
}

/// Id of a lane: road, section from 0, lane, as in `12_0_-1`.
pub(super) fn lane_id(road: &Road, section: usize, lane: i32) -> String {
    format!("{}_{section}_{lane}", road.id)
}

/// True when traffic of the lane goes with ascending stations.
pub(super) fn goes_forward(road: &Road, lane: &DocLane) -> bool {
    ((lane.id < 0) != road.left_hand) != (lane.direction == "reversed")
}

/// Why a road cannot be placed.
pub(super) fn fault(road: &Road) -> Option<String> {
    let length = road.length.unwrap_or(f64::NAN);
    let ascending =
        |starts: Vec<f64>| starts.windows(2).all(|w| w[0] <= w[1]) && starts.iter().all(|s| *s >= 0.0);
    let why = match road {
        _ if !(SHORT_M..=MAX_ROAD_M).contains(&length) => "its length is not that of a road",
        _ if road.line.is_empty() => "it has no geometry",
        _ if road.shapeless => "a stretch of it has no known shape",
        _ if road.line.iter().any(|g| !g.is_sound()) => "a stretch of it is not a road's",
        _ if !ascending(road.line.iter().map(|g| g.start).collect()) => "its stretches are out of order",
        _ if road.sections.is_empty() => "it has no lane section",
        _ if !ascending(road.sections.iter().map(|s| s.start).collect()) => {
            "its lane sections are out of order"
        }
        _ => return None,
    };
    Some(format!("road '{}': {why}", road.id))
}

/// Stations from and to which a section holds on the left (`left`) or right side; `None` when it has no such side.
pub(super) fn range(road: &Road, section: usize, left: bool) -> Option<(f64, f64)> {
    let has = |s: &Section| !s.single_side || s.lanes.iter().any(|l| l.id != 0 && (l.id > 0) == left);
    let own = road.sections.get(section).filter(|s| has(s))?;
    let end = road.sections[section + 1..].iter().find(|s| has(s)).map_or(road.length?, |s| s.start);
    (end - own.start > SHORT_M).then_some((own.start, end))
}

/// Places all lanes of a sound road.
pub(super) fn place(index: usize, road: &Road, budget: &mut Budget) -> Placed {
    let mut out = Placed::default();
    for (number, section) in road.sections.iter().enumerate() {
        for left in [false, true] {
            let mut side: Vec<&DocLane> =
                section.lanes.iter().filter(|l| l.id != 0 && (l.id > 0) == left).collect();
            side.sort_by_key(|l| l.id.unsigned_abs());
            side.dedup_by_key(|l| l.id);
            let Some(range) = range(road, number, left) else {
                let faults = side.iter().map(|l| format!("lane {}: no length", lane_id(road, number, l.id)));
                out.invalid.extend(faults);
                continue;
            };
            let surface = Surface { road, section, range };
            surface.place(&side, (index, number), budget, &mut out);
        }
        neighbors(index, number, road, &mut out.lanes);
    }
    out
}

/// A stretch of road with one set of lanes.
struct Surface<'r> {
    road: &'r Road,
    section: &'r Section,
    range: (f64, f64),
}

impl Surface<'_> {
    fn place(
        &self,
        side: &[&DocLane],
        (road, section): (usize, usize),
        budget: &mut Budget,
        out: &mut Placed,
    ) {
        if side.is_empty() {
            return;
        }
        let id = |lane: &DocLane| lane_id(self.road, section, lane.id);
        let stations = self.stations(side, budget.0 / side.len());
        let cost = stations.len().saturating_mul(side.len() * 3);
        if stations.len() < 2 || cost > budget.0 {
            out.invalid.extend(side.iter().map(|l| format!("lane {}: the map has too many points", id(l))));
            return;
        }
        budget.0 -= cost;
        let poses = poses(&self.road.line, &stations);
        let mut inner: Vec<f64> = stations.iter().map(|s| self.at(&self.road.lane_offset, *s)).collect();
        let middle = self.section.lanes.iter().find(|l| l.id == 0);
        let mut inner_marks: &[Mark] = middle.map_or(&[], |l| &l.marks);
        // Beyond a lane without a width nothing can be placed.
        let mut lost = false;
        for lane in side {
            let outer = self.outer(lane, &stations, &inner).filter(|_| !lost);
            let Some(outer) = outer else {
                lost = true;
                out.invalid.push(format!("lane {}: its width is not stated", id(lane)));
                continue;
            };
            let widest = outer.iter().zip(&inner).map(|(o, i)| (o - i).abs()).fold(0.0, f64::max);
            match kind(&lane.kind).filter(|_| widest >= NARROW_M) {
                None => out.set_aside += 1,
                Some((kind, tag)) => {
                    let mut placed = self.lane(lane, &poses, &stations, &inner, &outer);
                    (placed.id, placed.kind) = (id(lane), kind);
                    placed.tags.extend(tag.map(str::to_owned));
                    let length = self.range.1 - self.range.0;
                    (placed.left_mark, placed.right_mark) =
                        marks::of(lane, inner_marks, goes_forward(self.road, lane), length);
                    out.lanes.insert(LaneKey { road, section, lane: lane.id }, placed);
                }
            }
            (inner, inner_marks) = (outer, &lane.marks);
        }
    }

    /// A value that holds in this section: at its end, not yet the one of the next.
    fn at(&self, profile: &Profile, station: f64) -> f64 {
        profile.at(station.min(self.range.1 - SHORT_M / 2.0))
    }

    /// Distance to the reference line of a lane's outer edge; `None` where the file does not state it.
    fn outer(&self, lane: &DocLane, stations: &[f64], inner: &[f64]) -> Option<Vec<f64>> {
        let sign = if lane.id > 0 { 1.0 } else { -1.0 };
        let local = |s: f64| (s - self.section.start).min(self.range.1 - self.section.start - SHORT_M / 2.0);
        let edge = |(s, inner): (&f64, &f64)| match () {
            () if !lane.widths.is_empty() => inner + sign * lane.widths.at(local(*s)).max(0.0),
            () => self.at(&self.road.lane_offset, *s) + lane.borders.at(local(*s)),
        };
        let stated = !lane.widths.is_empty() || !lane.borders.is_empty();
        let out: Vec<f64> = stations.iter().zip(inner).map(edge).collect();
        (stated && out.iter().all(|t| t.abs() < 1e4)).then_some(out)
    }

    /// Stations at which points are needed: where a record begins, and every meter of what is not straight; fewer than
    /// two when there would be more than `most`.
    fn stations(&self, side: &[&DocLane], most: usize) -> Vec<f64> {
        let (from, to) = self.range;
        let road = self.road;
        let own = side
            .iter()
            .flat_map(|l| l.widths.starts().chain(l.borders.starts()))
            .map(|s| s + self.section.start);
        let of_road = [&road.lane_offset, &road.elevation, &road.superelevation];
        let all =
            road.line.iter().map(|g| g.start).chain(own).chain(of_road.into_iter().flat_map(Profile::starts));
        let mut corners: Vec<f64> = all.filter(|s| *s > from + 1e-3 && *s < to - 1e-3).collect();
        corners.extend([from, to]);
        corners.sort_by(f64::total_cmp);
        corners.dedup_by(|b, a| *b - *a < 1e-3 && *b < to);
        let mut out = vec![from];
        for pair in corners.windows(2) {
            let steps =
                if self.is_straight(side, pair[0]) { 1.0 } else { ((pair[1] - pair[0]) / STEP_M).ceil() };
            if out.len() as f64 + steps > most as f64 {
                return Vec::new();
            }
            let steps = steps.max(1.0) as usize;
            let between = |i: usize| pair[0] + (pair[1] - pair[0]) * i as f64 / steps as f64;
            out.extend((1..steps).map(between));
            out.push(pair[1]);
        }
        out
    }

    fn is_straight(&self, side: &[&DocLane], from: f64) -> bool {
        let road = self.road;
        let piece = road.line.partition_point(|g| g.start <= from + 1e-6).saturating_sub(1);
        let local = from - self.section.start;
        road.line.get(piece).is_some_and(|g| g.shape == Shape::Line)
            && [&road.lane_offset, &road.elevation, &road.superelevation].iter().all(|p| p.is_straight(from))
            && side.iter().all(|l| l.widths.is_straight(local) && l.borders.is_straight(local))
    }

    fn lane(&self, lane: &DocLane, poses: &[Pose], stations: &[f64], inner: &[f64], outer: &[f64]) -> Lane {
        let line = |t: &[f64]| -> Vec<Point3> {
            (0..poses.len()).map(|i| poses[i].beside(t[i], self.height(stations[i], t[i]))).collect()
        };
        // By ascending stations, the left edge is the one with the greater t.
        let (left, right) = if lane.id > 0 { (outer, inner) } else { (inner, outer) };
        let middle: Vec<f64> = left.iter().zip(right).map(|(l, r)| (l + r) / 2.0).collect();
        let mut lines = [line(left), line(&middle), line(right)];
        if !goes_forward(self.road, lane) {
            lines.iter_mut().for_each(|l| l.reverse());
            lines.reverse();
        }
        let [left, center, right] = lines;
        let constant = !lane.widths.is_empty() && lane.widths.is_flat();
        Lane {
            left,
            center,
            right,
            width_m: constant.then(|| lane.widths.at(0.0)),
            speed_limit_mps: self.limit(lane),
            ..Lane::default()
        }
    }

    fn height(&self, station: f64, t: f64) -> f64 {
        self.at(&self.road.elevation, station) + t * self.at(&self.road.superelevation, station).tan()
    }

    /// The limit that holds over most of the section: the lane's, else the road's.
    fn limit(&self, lane: &DocLane) -> Option<f64> {
        let (from, to) = self.range;
        let own: Vec<(f64, Option<f64>)> =
            lane.speeds.iter().map(|(s, v)| (s + self.section.start, *v)).collect();
        longest(&own, from, to).or_else(|| longest(&self.road.limits, from, to)).flatten()
    }
}

/// Lanes side by side: the number one higher lies to the left by ascending stations; 0 has no width.
fn neighbors(road: usize, section: usize, doc: &Road, lanes: &mut BTreeMap<LaneKey, Lane>) {
    let first = LaneKey { road, section, lane: i32::MIN };
    let last = LaneKey { lane: i32::MAX, ..first };
    let keys: Vec<LaneKey> = lanes.range(first..=last).map(|(k, _)| *k).collect();
    let directions: BTreeMap<i32, bool> =
        doc.sections[section].lanes.iter().map(|l| (l.id, goes_forward(doc, l))).collect();
    for key in keys {
        let step = |by: i32| if key.lane == -by { by } else { key.lane.saturating_add(by) };
        let id = |lane: i32| lanes.get(&LaneKey { lane, ..key }).map(|l| l.id.clone());
        let (mut left, mut right) = (id(step(1)), id(step(-1)));
        if directions.get(&key.lane) == Some(&false) {
            std::mem::swap(&mut left, &mut right);
        }
        if let Some(lane) = lanes.get_mut(&key) {
            (lane.left_neighbor, lane.right_neighbor) = (left, right);
        }
    }
}

/// The users of a lane, and its tag; `None` for what is not part of the road.
fn kind(name: &str) -> Option<(LaneKind, Option<&'static str>)> {
    Some(match name {
        "driving" | "bidirectional" | "slipLane" => (LaneKind::Vehicle, None),
        "entry" | "mwyEntry" => (LaneKind::Vehicle, Some("acceleration")),
        "exit" | "mwyExit" => (LaneKind::Vehicle, Some("deceleration")),
        "onRamp" | "offRamp" | "connectingRamp" => (LaneKind::Vehicle, Some("ramp")),
        "bus" | "taxi" | "HOV" => (LaneKind::Bus, None),
        "biking" => (LaneKind::Bike, None),
        "sidewalk" | "walking" => (LaneKind::Sidewalk, None),
        "shoulder" | "stop" => (LaneKind::Shoulder, None),
        "parking" | "shared" => (LaneKind::Other, None),
        _ => return None,
    })
}
