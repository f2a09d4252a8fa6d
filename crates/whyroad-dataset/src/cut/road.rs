//! The map of a sample: lines and areas within the radius, thinned, in the frame of t0.

use crate::place::contains;
use crate::pose::Pose;
use crate::sample::MapElement;
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Lane, LaneKind, Point3};

/// Points of a line may lie this far from the thinned line, m.
const TOLERANCE_M: f64 = 0.1;

/// A drive's map, prepared once per drive.
pub(super) struct Road {
    elements: Option<Vec<Part>>,
}

/// A line or area with its bounding box.
struct Part {
    element: MapElement,
    points: Vec<Point3>,
    low: (f64, f64),
    high: (f64, f64),
    is_area: bool,
}

impl Road {
    pub fn new(map: Option<&RoadMap>) -> Self {
        let Some(map) = map else { return Self { elements: None } };
        let mut elements = Vec::new();
        for lane in &map.lanes {
            let element = MapElement {
                id: lane.id.clone(),
                kind: kind(lane).to_owned(),
                width_m: width(lane).map(|w| w as f32),
                speed_limit_mps: lane.speed_limit_mps.map(|v| v as f32),
                successors: lane.successors.clone(),
                ..MapElement::default()
            };
            elements.extend(part(element, &lane.center, false));
        }
        let named =
            |id: &str, kind: &str| MapElement { id: id.into(), kind: kind.into(), ..MapElement::default() };
        for (areas, kind) in [(&map.crosswalks, "crosswalk"), (&map.junctions, "junction")] {
            elements.extend(areas.iter().filter_map(|a| part(named(&a.id, kind), &a.boundary, true)));
        }
        elements
            .extend(map.stop_lines.iter().filter_map(|l| part(named(&l.id, "stop_line"), &l.line, false)));
        Self { elements: Some(elements) }
    }

    /// What lies within `radius` of the pose; `None` without a map.
    pub fn around(&self, pose: &Pose, radius: f64) -> Option<Vec<MapElement>> {
        let mut out = Vec::new();
        for part in self.elements.as_ref()? {
            let near = |v: f64, low: f64, high: f64| v >= low - radius && v <= high + radius;
            if !near(pose.x, part.low.0, part.high.0) || !near(pose.y, part.low.1, part.high.1) {
                continue;
            }
            let local: Vec<(f64, f64)> = part.points.iter().map(|p| pose.local(p.x, p.y)).collect();
            let inside = |p: &(f64, f64)| p.0.hypot(p.1) <= radius;
            let pieces: Vec<Vec<(f64, f64)>> = if part.is_area {
                let crossed = |(i, a): (usize, &(f64, f64))| {
                    let next = local[(i + 1) % local.len()];
                    clip(*a, next, radius).is_some()
                };
                let near = local.iter().any(inside)
                    || contains(&local, [0.0, 0.0])
                    || local.iter().enumerate().any(crossed);
                if near { vec![local] } else { vec![] }
            } else {
                pieces(&local, radius)
            };
            for piece in pieces {
                let piece = thin(&piece, TOLERANCE_M);
                let mut element = part.element.clone();
                element.x = piece.iter().map(|p| p.0 as f32).collect();
                element.y = piece.iter().map(|p| p.1 as f32).collect();
                out.push(element);
            }
        }
        Some(out)
    }
}

fn part(element: MapElement, points: &[Point3], is_area: bool) -> Option<Part> {
    let points: Vec<Point3> = points.iter().filter(|p| p.x.is_finite() && p.y.is_finite()).copied().collect();
    if points.len() < 2 {
        return None;
    }
    let fold =
        |f: fn(f64, f64) -> f64, from: f64, axis: fn(&Point3) -> f64| points.iter().map(axis).fold(from, f);
    let low = (fold(f64::min, f64::INFINITY, |p| p.x), fold(f64::min, f64::INFINITY, |p| p.y));
    let high = (fold(f64::max, f64::NEG_INFINITY, |p| p.x), fold(f64::max, f64::NEG_INFINITY, |p| p.y));
    Some(Part { element, points, low, high, is_area })
}

fn kind(lane: &Lane) -> &'static str {
    match lane.kind {
        LaneKind::Vehicle if lane.in_junction => "junction_lane",
        LaneKind::Vehicle => "lane",
        LaneKind::Bus => "bus_lane",
        LaneKind::Bike => "bike_lane",
        LaneKind::Sidewalk => "sidewalk",
        LaneKind::Shoulder | LaneKind::Other => "other_lane",
    }
}

/// The stated width, else the mean distance of the edges' ends.
fn width(lane: &Lane) -> Option<f64> {
    let between = |a: Option<&Point3>, b: Option<&Point3>| Some((a?.x - b?.x).hypot(a?.y - b?.y));
    let ends = [between(lane.left.first(), lane.right.first()), between(lane.left.last(), lane.right.last())];
    let measured = match ends {
        [Some(a), Some(b)] => Some((a + b) / 2.0),
        _ => None,
    };
    lane.width_m.filter(|w| w.is_finite()).or(measured).filter(|w| w.is_finite())
}

/// The parts of a line inside the circle, ends cut at the circle.
fn pieces(line: &[(f64, f64)], radius: f64) -> Vec<Vec<(f64, f64)>> {
    let mut out: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut open = false;
    for pair in line.windows(2) {
        let Some((from, to)) = clip(pair[0], pair[1], radius) else {
            open = false;
            continue;
        };
        match out.last_mut() {
            Some(piece) if open && from == 0.0 => piece.push(at(pair, to)),
            _ => out.push(vec![at(pair, from), at(pair, to)]),
        }
        open = to == 1.0;
    }
    out
}

fn at(pair: &[(f64, f64)], t: f64) -> (f64, f64) {
    if t == 1.0 {
        return pair[1];
    }
    (pair[0].0 + t * (pair[1].0 - pair[0].0), pair[0].1 + t * (pair[1].1 - pair[0].1))
}

/// The range of a segment's parameter inside the circle around the origin.
fn clip(a: (f64, f64), b: (f64, f64), radius: f64) -> Option<(f64, f64)> {
    let d = (b.0 - a.0, b.1 - a.1);
    let (aa, bb, cc) =
        (d.0 * d.0 + d.1 * d.1, a.0 * d.0 + a.1 * d.1, a.0 * a.0 + a.1 * a.1 - radius * radius);
    if aa == 0.0 {
        return None;
    }
    let root = bb * bb - aa * cc;
    if root <= 0.0 {
        return None;
    }
    let root = root.sqrt();
    let (from, to) = (((-bb - root) / aa).max(0.0), ((-bb + root) / aa).min(1.0));
    (from < to).then_some((from, to))
}

/// Ramer-Douglas-Peucker.
fn thin(line: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    let (Some(&a), Some(&b)) = (line.first(), line.last()) else { return Vec::new() };
    let d = (b.0 - a.0, b.1 - a.1);
    let length = d.0.hypot(d.1);
    let off = |p: (f64, f64)| {
        if length == 0.0 {
            (p.0 - a.0).hypot(p.1 - a.1)
        } else {
            (d.0 * (p.1 - a.1) - d.1 * (p.0 - a.0)).abs() / length
        }
    };
    let far = (1..line.len().saturating_sub(1)).map(|i| (i, off(line[i]))).max_by(|x, y| x.1.total_cmp(&y.1));
    match far {
        Some((i, o)) if o > tolerance => {
            let mut out = thin(&line[..=i], tolerance);
            out.pop();
            out.extend(thin(&line[i..], tolerance));
            out
        }
        _ => vec![a, b],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_area_larger_than_the_circle_is_there() {
        use whyroad_model::road_map::Area;
        let area = |id: &str, points: &[(f64, f64)]| Area {
            id: id.into(),
            boundary: points.iter().map(|(x, y)| Point3 { x: *x, y: *y, z: 0.0 }).collect(),
        };
        let map = RoadMap {
            junctions: vec![
                area("around the ego", &[(-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0)]),
                area("beside, its edge in reach", &[(5.0, -50.0), (50.0, -50.0), (50.0, 50.0), (5.0, 50.0)]),
                area("out of reach", &[(20.0, -50.0), (50.0, -50.0), (50.0, 50.0), (20.0, 50.0)]),
            ],
            ..RoadMap::default()
        };
        let found = Road::new(Some(&map)).around(&Pose::default(), 10.0).unwrap();
        let ids: Vec<&str> = found.iter().map(|e| e.id.as_str()).collect();
        assert_eq!(ids, ["around the ego", "beside, its edge in reach"]);
    }

    #[test]
    fn a_line_through_the_circle_is_cut_at_it() {
        let line = [(-100.0, 0.0), (0.0, 0.0), (100.0, 0.0), (100.0, 50.0), (0.0, 50.0)];
        let parts = pieces(&line, 60.0);
        assert_eq!(parts.len(), 2, "the line leaves and comes back");
        assert_eq!((parts[0][0], parts[0][2]), ((-60.0, 0.0), (60.0, 0.0)));
        let edge = (60.0_f64 * 60.0 - 50.0 * 50.0).sqrt();
        assert!((parts[1][0].0 - edge).abs() < 1e-9);
        assert_eq!(thin(&parts[0], 0.1), [(-60.0, 0.0), (60.0, 0.0)]);
    }
}
