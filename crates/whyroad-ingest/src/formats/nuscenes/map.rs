//! The map expansion (1.3): `maps/expansion/<location>.json`. Lanes and lane connectors by their arc-line paths, lane
//! dividers, crossings, stop lines; only what lies near the drive. Connectors are the paths across junctions.
//!
//! Not read: drivable areas, road segments and blocks, walkways, car parks, traffic lights (places without states).

use crate::assemble::feature_map::{Boundary, Built, CenterLane, Feature, build, mean_width};
use crate::assemble::geometry::distance;
use serde::Deserialize;
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::PI;
use whyroad_model::road_map::{Lane, LaneKind, LaneMark, Point3, StopLine};

/// Features farther from the ego's path than this are left out, m.
const REACH_M: f64 = 200.0;
/// Spacing of the points of center lines, m.
const SPACING_M: f64 = 1.0;

#[derive(Deserialize)]
struct Node {
    token: String,
    x: f64,
    y: f64,
}

#[derive(Deserialize)]
struct Polygon {
    token: String,
    exterior_node_tokens: Vec<String>,
}

#[derive(Deserialize)]
struct Divider {
    node_token: String,
    segment_type: String,
}

#[derive(Deserialize)]
struct LaneRow {
    token: String,
    #[serde(default)]
    polygon_token: Option<String>,
    #[serde(default)]
    lane_type: Option<String>,
    #[serde(default)]
    left_lane_divider_segments: Vec<Divider>,
    #[serde(default)]
    right_lane_divider_segments: Vec<Divider>,
}

#[derive(Deserialize)]
struct AreaRow {
    token: String,
    polygon_token: String,
}

#[derive(Deserialize)]
struct Arc {
    /// x, y, heading
    start_pose: [f64; 3],
    /// Three of `L`, `S`, `R`.
    shape: String,
    radius: f64,
    segment_length: [f64; 3],
}

#[derive(Deserialize)]
struct Links {
    #[serde(default)]
    incoming: Vec<String>,
    #[serde(default)]
    outgoing: Vec<String>,
}

#[derive(Deserialize)]
struct City {
    node: Vec<Node>,
    polygon: Vec<Polygon>,
    lane: Vec<LaneRow>,
    #[serde(default)]
    lane_connector: Vec<LaneRow>,
    #[serde(default)]
    ped_crossing: Vec<AreaRow>,
    #[serde(default)]
    stop_line: Vec<AreaRow>,
    #[serde(default)]
    arcline_path_3: HashMap<String, Vec<Arc>>,
    #[serde(default)]
    connectivity: HashMap<String, Links>,
}

/// Points along one arc-line path.
fn along(arc: &Arc, out: &mut Vec<Point3>) {
    let [mut x, mut y, mut heading] = arc.start_pose;
    let point = |x: f64, y: f64| Point3 { x, y, z: 0.0 };
    out.push(point(x, y));
    for (turn, &length) in arc.shape.chars().zip(&arc.segment_length) {
        let curvature = match turn {
            'L' => 1.0 / arc.radius,
            'R' => -1.0 / arc.radius,
            _ => 0.0,
        };
        let steps = (length / SPACING_M).ceil().clamp(0.0, 1000.0);
        for _ in 0..steps as usize {
            // A step on a circle runs along its chord, in the direction half way.
            let (step, bend) = (length / steps, curvature * length / steps);
            let chord = if bend.abs() < 1e-9 { step } else { step * (bend / 2.0).sin() / (bend / 2.0) };
            x += chord * (heading + bend / 2.0).cos();
            y += chord * (heading + bend / 2.0).sin();
            heading += bend;
            out.push(point(x, y));
        }
    }
}

/// nuScenes' divider types, color left out; `NIL` is not a line.
fn mark(name: &str) -> LaneMark {
    match name.rsplit_once('_').map_or(name, |(kind, _color)| kind) {
        "NIL" => LaneMark::None,
        "SINGLE_SOLID" | "SINGLE_ZIGZAG" => LaneMark::Solid,
        "DOUBLE_SOLID" => LaneMark::DoubleSolid,
        "SINGLE_DASHED" => LaneMark::Dashed,
        "DOUBLE_DASHED" => LaneMark::DoubleDashed,
        _ => LaneMark::Unknown,
    }
}

/// The map around the ego's positions. `Err` when the text is not such a map.
pub(super) fn read(text: &[u8], places: &[Point3]) -> Result<Built, String> {
    let city: City = serde_json::from_slice(text).map_err(|e| e.to_string())?;
    let nodes: HashMap<&str, Point3> =
        city.node.iter().map(|n| (n.token.as_str(), Point3 { x: n.x, y: n.y, z: 0.0 })).collect();
    let polygons: HashMap<&str, &Polygon> = city.polygon.iter().map(|p| (p.token.as_str(), p)).collect();
    let outline = |token: &str| -> Vec<Point3> {
        let tokens = polygons.get(token).map(|p| p.exterior_node_tokens.as_slice()).unwrap_or_default();
        tokens.iter().filter_map(|t| nodes.get(t.as_str()).copied()).collect()
    };
    // Every fifth position is half a second of driving: much shorter than the reach.
    let near =
        |line: &[Point3]| line.iter().any(|p| places.iter().step_by(5).any(|e| distance(*p, *e) <= REACH_M));
    let mut features = Vec::new();
    let all = city.lane.iter().map(|l| (l, false)).chain(city.lane_connector.iter().map(|l| (l, true)));
    for (row, connector) in all {
        let mut center = Vec::new();
        for arc in city.arcline_path_3.get(&row.token).into_iter().flatten().filter(|a| a.radius.abs() > 1e-6)
        {
            along(arc, &mut center);
        }
        center.dedup_by(|b, a| distance(*a, *b) < 1e-3);
        if !near(&center) {
            continue;
        }
        let mut side = |name: &str, dividers: &[Divider]| {
            let line: Vec<Point3> =
                dividers.iter().filter_map(|d| nodes.get(d.node_token.as_str()).copied()).collect();
            if line.len() < 2 {
                return Vec::new();
            }
            let id = format!("{}-{name}", row.token);
            features.push((id.clone(), Ok(Feature::Line(line))));
            // The last divider's type belongs to no segment; a lane's marks rarely change along it.
            let marks = dividers.iter().take(dividers.len() - 1).map(|d| mark(&d.segment_type));
            let last = center.len().saturating_sub(1);
            marks.map(|mark| Boundary { start: 0, end: last, feature: id.clone(), mark }).collect()
        };
        let boundaries =
            [side("left", &row.left_lane_divider_segments), side("right", &row.right_lane_divider_segments)];
        let links = city.connectivity.get(&row.token);
        let width_m = row.polygon_token.as_deref().and_then(|t| mean_width(&outline(t), &center));
        let lane = Lane {
            center,
            kind: if row.lane_type.as_deref() == Some("BIKE") { LaneKind::Bike } else { LaneKind::Vehicle },
            in_junction: connector,
            width_m,
            successors: links.map(|l| l.outgoing.clone()).unwrap_or_default(),
            predecessors: links.map(|l| l.incoming.clone()).unwrap_or_default(),
            ..Lane::default()
        };
        let lane = CenterLane { lane, boundaries, neighbors: [Vec::new(), Vec::new()] };
        features.push((row.token.clone(), Ok(Feature::Lane(Box::new(lane)))));
    }
    for row in &city.ped_crossing {
        let boundary = outline(&row.polygon_token);
        if near(&boundary) {
            features.push((row.token.clone(), Ok(Feature::Crosswalk(boundary))));
        }
    }
    let mut built = build(features, &BTreeMap::new());
    for row in &city.stop_line {
        let area = outline(&row.polygon_token);
        if !near(&area) {
            continue;
        }
        built.count.read += 1;
        match stop_line(&area, &built.map.lanes) {
            Some((line, lane_ids)) => {
                built.count.keep("stop_line", 1);
                built.map.stop_lines.push(StopLine { id: row.token.clone(), line, lane_ids });
            }
            // Areas for yielding inside junctions and the like: no lane ends in them.
            None => built.count.set_aside("no_lane_ends_there", 1),
        }
    }
    built.map.stop_lines.sort_by(|a, b| a.id.cmp(&b.id));
    Ok(built)
}

/// nuScenes draws stop lines as areas. The line lies across the lanes that end inside the area, from the leftmost to
/// the rightmost end, half a lane farther on each side.
fn stop_line(area: &[Point3], lanes: &[Lane]) -> Option<(Vec<Point3>, Vec<String>)> {
    let mut ring = area.to_vec();
    ring.extend(area.first().copied());
    let ending: Vec<(&Lane, Point3)> = lanes
        .iter()
        .filter(|l| !l.in_junction)
        .filter_map(|l| Some((l, *l.center.last()?)))
        .filter(|(_, end)| crate::assemble::geometry::contains(&ring, *end))
        .collect();
    let (lane, end) = *ending.first()?;
    let before = lane.center[lane.center.len().saturating_sub(2)];
    let across = (end.y - before.y).atan2(end.x - before.x) + PI / 2.0;
    let (s, c) = across.sin_cos();
    let offsets = ending.iter().map(|(_, p)| (p.x - end.x) * c + (p.y - end.y) * s);
    let (low, high) = offsets.fold((0.0f64, 0.0f64), |(a, b), v| (a.min(v), b.max(v)));
    let half = lane.width_m.unwrap_or(3.5) / 2.0;
    let at = |d: f64| Point3 { x: end.x + d * c, y: end.y + d * s, z: end.z };
    Some((vec![at(high + half), at(low - half)], ending.iter().map(|(l, _)| l.id.clone()).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_circle_to_the_left_ends_where_geometry_says() {
        // 10 m straight along x, then a quarter of a circle of radius 20 m: it ends at (30, 20).
        let quarter = 20.0 * PI / 2.0;
        let arc = Arc {
            start_pose: [0.0, 0.0, 0.0],
            shape: "SLS".into(),
            radius: 20.0,
            segment_length: [10.0, quarter, 0.0],
        };
        let mut line = Vec::new();
        along(&arc, &mut line);
        let last = line[line.len() - 1];
        assert!((last.x - 30.0).abs() < 1e-9 && (last.y - 20.0).abs() < 1e-9, "{last:?}");
    }
}
