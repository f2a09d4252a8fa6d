//! Maps made of center lines with references to painted lines and curbs, as the Waymo motion set has them and
//! ScenarioNet keeps them, as a [`RoadMap`].
//!
//! A lane's edges are its center line moved sideways by the distance to the line or curb that the map names for each
//! stretch; stretches without one take the width of the nearest stretch that has it. A side without a named stretch has
//! no edge, and then the lane has no edges. Neighbors are the ones along the longest stretch. A stop line is drawn
//! across a lane at the point that its light names.

use crate::assemble::geometry::{distance, length};
use crate::assemble::junctions;
use crate::report::RowCount;
use std::collections::BTreeMap;
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Area, Facility, Lane, LaneMark, Point3, Sign, StopLine};

/// A named line nearer or farther than this is not this lane's edge, m.
const HALF_WIDTH_M: std::ops::RangeInclusive<f64> = 0.5..=6.0;
/// Half a stop line where the lane has no width, m.
const NOMINAL_HALF_WIDTH_M: f64 = 1.75;

/// A stretch of a lane with one line or curb beside it.
#[derive(Clone, Debug)]
pub(crate) struct Boundary {
    /// Indices into the lane's center line, both included.
    pub start: usize,
    pub end: usize,
    /// Id of the line or curb.
    pub feature: String,
    pub mark: LaneMark,
}

/// A stretch of a lane with another beside it.
#[derive(Clone, Debug)]
pub(crate) struct Neighbor {
    pub start: usize,
    pub end: usize,
    pub lane: String,
}

/// A lane as the source describes it: `lane` has everything but edges, marks and neighbors.
#[derive(Clone, Debug, Default)]
pub(crate) struct CenterLane {
    pub lane: Lane,
    /// Left, right.
    pub boundaries: [Vec<Boundary>; 2],
    pub neighbors: [Vec<Neighbor>; 2],
}

/// One feature of the map.
#[derive(Clone, Debug)]
pub(crate) enum Feature {
    Lane(Box<CenterLane>),
    /// Painted line or curb.
    Line(Vec<Point3>),
    Crosswalk(Vec<Point3>),
    StopSign {
        position: Point3,
        lanes: Vec<String>,
    },
    /// `speed_bump`, `driveway`, ...
    Facility(&'static str, Vec<Point3>),
}

/// The map, and the findings about it.
#[derive(Debug, Default)]
pub(crate) struct Built {
    pub map: RoadMap,
    pub count: RowCount,
    /// Features that could not be used, with a description of the first.
    pub invalid_example: Option<String>,
}

/// Makes the map. `stops`: where lanes stop for a light, by lane. Features that are `Err` are counted as dropped.
pub(crate) fn build(
    features: Vec<(String, Result<Feature, String>)>,
    stops: &BTreeMap<String, Point3>,
) -> Built {
    let mut out = Built { count: RowCount::new("map"), ..Built::default() };
    let mut lines = BTreeMap::new();
    let mut lanes = Vec::new();
    for (id, feature) in features {
        out.count.read += 1;
        match feature.and_then(usable) {
            Err(reason) => {
                out.count.drop_rows("invalid", 1);
                out.invalid_example.get_or_insert_with(|| format!("{id}: {reason}"));
            }
            Ok(Feature::Lane(lane)) => {
                out.count.keep("lane", 1);
                lanes.push(CenterLane { lane: Lane { id, ..lane.lane }, ..*lane });
            }
            Ok(Feature::Line(points)) => {
                out.count.keep("line", 1);
                lines.insert(id, points);
            }
            Ok(Feature::Crosswalk(boundary)) => {
                out.count.keep("crosswalk", 1);
                out.map.crosswalks.push(Area { id, boundary: closed(boundary) });
            }
            Ok(Feature::StopSign { position, lanes }) => {
                out.count.keep("sign", 1);
                out.map.signs.push(Sign {
                    id,
                    kind: "stop".into(),
                    position,
                    lane_ids: lanes,
                    ..Sign::default()
                });
            }
            Ok(Feature::Facility(kind, boundary)) => {
                out.count.keep("facility", 1);
                out.map.facilities.push(Facility { id, kind: kind.into(), boundary: closed(boundary) });
            }
        }
    }
    let map = &mut out.map;
    map.lanes = lanes.into_iter().map(|l| finished(l, &lines)).collect();
    map.lanes.sort_by(|a, b| a.id.cmp(&b.id));
    map.crosswalks.sort_by(|a, b| a.id.cmp(&b.id));
    map.signs.sort_by(|a, b| a.id.cmp(&b.id));
    map.facilities.sort_by(|a, b| a.id.cmp(&b.id));
    for (id, &point) in stops {
        let Some(lane) = map.lane(id) else { continue };
        let line = stop_line(lane, point);
        map.stop_lines.push(StopLine { id: format!("stop_{id}"), line, lane_ids: vec![id.clone()] });
    }
    junctions::add(map);
    out
}

fn usable(feature: Feature) -> Result<Feature, String> {
    let finite =
        |points: &[Point3]| points.iter().all(|p| p.x.is_finite() && p.y.is_finite() && p.z.is_finite());
    let (points, least, what) = match &feature {
        Feature::Lane(l) => (l.lane.center.as_slice(), 2, "a lane"),
        Feature::Line(points) => (points.as_slice(), 1, "a line"),
        Feature::Crosswalk(points) => (points.as_slice(), 3, "a crosswalk"),
        Feature::Facility(_, points) => (points.as_slice(), 2, "an area"),
        Feature::StopSign { position, .. } => (std::slice::from_ref(position), 1, "a sign"),
    };
    if points.len() < least {
        return Err(format!("{what} of {} points", points.len()));
    }
    if !finite(points) {
        return Err(format!("{what} with a point that is not a number"));
    }
    Ok(feature)
}

fn closed(mut ring: Vec<Point3>) -> Vec<Point3> {
    if ring.first() != ring.last() {
        ring.extend(ring.first().copied());
    }
    ring
}

fn finished(source: CenterLane, lines: &BTreeMap<String, Vec<Point3>>) -> Lane {
    let CenterLane { mut lane, boundaries, neighbors } = source;
    let [left, right] = [0, 1].map(|side| half_widths(&lane.center, &boundaries[side], lines));
    if let (Some(left), Some(right)) = (left, right) {
        lane.left = moved(&lane.center, &left, 1.0);
        lane.right = moved(&lane.center, &right, -1.0);
    }
    lane.left_mark = longest_mark(&boundaries[0]);
    lane.right_mark = longest_mark(&boundaries[1]);
    let longest =
        |side: &[Neighbor]| side.iter().max_by_key(|n| n.end.saturating_sub(n.start)).map(|n| n.lane.clone());
    lane.left_neighbor = longest(&neighbors[0]);
    lane.right_neighbor = longest(&neighbors[1]);
    lane
}

fn longest_mark(side: &[Boundary]) -> LaneMark {
    let mut by_mark: Vec<(LaneMark, usize)> = Vec::new();
    for b in side {
        let points = b.end.saturating_sub(b.start) + 1;
        match by_mark.iter_mut().find(|(m, _)| *m == b.mark) {
            Some((_, n)) => *n += points,
            None => by_mark.push((b.mark, points)),
        }
    }
    by_mark.into_iter().max_by_key(|&(_, n)| n).map_or(LaneMark::Unknown, |(m, _)| m)
}

/// Distance from each point of the center line to the edge on one side; `None` when the side names none.
fn half_widths(
    center: &[Point3],
    side: &[Boundary],
    lines: &BTreeMap<String, Vec<Point3>>,
) -> Option<Vec<f64>> {
    let mut out = vec![f64::NAN; center.len()];
    for b in side {
        let Some(line) = lines.get(&b.feature) else { continue };
        for i in b.start..=b.end.min(center.len().saturating_sub(1)) {
            let d = distance_to(line, center[i]);
            if HALF_WIDTH_M.contains(&d) {
                out[i] = out[i].min(d);
            }
        }
    }
    let known: Vec<usize> = (0..out.len()).filter(|&i| out[i].is_finite()).collect();
    if known.is_empty() {
        return None;
    }
    Some(
        (0..out.len())
            .map(|i| {
                let after = known.partition_point(|&k| k < i).min(known.len() - 1);
                let before = after.saturating_sub(1);
                let nearest =
                    if known[after].abs_diff(i) <= known[before].abs_diff(i) { after } else { before };
                out[known[nearest]]
            })
            .collect(),
    )
}

/// Distance from a point to a line in the ground plane, m.
fn distance_to(line: &[Point3], p: Point3) -> f64 {
    let to_segment = |a: Point3, b: Point3| {
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let share = (((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy).max(1e-12)).clamp(0.0, 1.0);
        (p.x - a.x - share * dx).hypot(p.y - a.y - share * dy)
    };
    match line {
        [only] => distance(*only, p),
        _ => line.windows(2).map(|w| to_segment(w[0], w[1])).fold(f64::INFINITY, f64::min),
    }
}

/// Direction of a line at one of its points: from the point before to the point after.
fn direction(line: &[Point3], i: usize) -> (f64, f64) {
    let (a, b) = (line[i.saturating_sub(1)], line[(i + 1).min(line.len() - 1)]);
    let d = distance(a, b).max(1e-9);
    ((b.x - a.x) / d, (b.y - a.y) / d)
}

fn moved(center: &[Point3], half: &[f64], sign: f64) -> Vec<Point3> {
    (0..center.len())
        .map(|i| {
            let ((ux, uy), p, d) = (direction(center, i), center[i], sign * half[i]);
            Point3 { x: p.x - uy * d, y: p.y + ux * d, z: p.z }
        })
        .collect()
}

/// A line across the lane at `point`, left end first.
fn stop_line(lane: &Lane, point: Point3) -> Vec<Point3> {
    let nearest = (0..lane.center.len())
        .min_by(|&a, &b| distance(lane.center[a], point).total_cmp(&distance(lane.center[b], point)));
    let i = nearest.unwrap_or(0);
    let half = |edge: &[Point3]| edge.get(i).map_or(NOMINAL_HALF_WIDTH_M, |&e| distance(e, lane.center[i]));
    let (ux, uy) = direction(&lane.center, i);
    [half(&lane.left), -half(&lane.right)]
        .map(|d| Point3 { x: point.x - uy * d, y: point.y + ux * d, z: point.z })
        .into()
}

/// Mean width of a lane from its outline: area over the length of its center line, m.
pub(crate) fn mean_width(outline: &[Point3], center: &[Point3]) -> Option<f64> {
    let n = outline.len();
    let twice: f64 =
        (0..n).map(|i| outline[i].x * outline[(i + 1) % n].y - outline[(i + 1) % n].x * outline[i].y).sum();
    let width = twice.abs() / 2.0 / length(center);
    (n >= 3 && (2.0 * HALF_WIDTH_M.start()..=2.0 * HALF_WIDTH_M.end()).contains(&width)).then_some(width)
}
