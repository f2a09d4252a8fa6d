//! `map_features`: lanes by center line, painted lines, curbs, crosswalks, signs.

use crate::assemble::feature_map::{Boundary, Built, CenterLane, Feature, Neighbor, build, mean_width};
use crate::encodings::pickle::Value;
use std::collections::BTreeMap;
use whyroad_model::road_map::{Lane, LaneKind, LaneMark, Point3, RoadMap};

const MPS_PER_KMH: f64 = 1.0 / 3.6;
const MPS_PER_MPH: f64 = 0.44704;

/// The map; `None` when the scenario has no features.
pub(super) fn read(features: Value<'_>, stops: &BTreeMap<String, Point3>) -> Option<Built> {
    let all: Vec<_> = features
        .entries()?
        .filter_map(|(key, f)| {
            let kind = f.get("type").and_then(|v| v.text()).unwrap_or_default().into_owned();
            Some((key.id().unwrap_or_default(), feature(f, &kind)?))
        })
        .collect();
    (!all.is_empty()).then(|| build(all, stops))
}

/// Leaves the heights of all lanes open: the third column of nuScenes' polylines is a heading.
pub(super) fn forget_heights(map: &mut RoadMap) {
    for lane in &mut map.lanes {
        let points = lane.center.iter_mut().chain(&mut lane.left).chain(&mut lane.right);
        points.for_each(|p| p.z = f64::NAN);
    }
}

/// `None` for features that are not part of a road map here (buildings, ground).
fn feature(f: Value<'_>, kind: &str) -> Option<Result<Feature, String>> {
    let points = |key: &str| f.get(key).and_then(points).ok_or_else(|| format!("{kind} without {key}"));
    let area = || points("polygon").or_else(|_| points("polyline"));
    Some(match kind {
        _ if kind.starts_with("LANE_") => {
            points("polyline").map(|center| Feature::Lane(Box::new(lane(f, kind, center))))
        }
        _ if kind.starts_with("ROAD_LINE_")
            || kind.starts_with("ROAD_EDGE_")
            || kind == "UNKNOWN_LINE"
            || kind == "UNKNOWN" =>
        {
            area().map(Feature::Line)
        }
        "GUARDRAIL" => area().map(Feature::Line),
        "CROSSWALK" => area().map(Feature::Crosswalk),
        "SPEED_BUMP" => area().map(|p| Feature::Facility("speed_bump", p)),
        "DRIVEWAY" => area().map(|p| Feature::Facility("driveway", p)),
        "STOP_SIGN" => {
            let position = f.get("position").and_then(|v| v.column()).filter(|p| p.len() >= 2);
            position.ok_or_else(|| "STOP_SIGN without position".to_owned()).map(|p| Feature::StopSign {
                position: Point3 { x: p[0], y: p[1], z: p.get(2).copied().unwrap_or(0.0) },
                lanes: ids(f, "lane"),
            })
        }
        _ => return None,
    })
}

fn points(v: Value<'_>) -> Option<Vec<Point3>> {
    let point = |r: &Vec<f64>| match r[..] {
        [x, y] => Some(Point3 { x, y, z: 0.0 }),
        [x, y, z, ..] => Some(Point3 { x, y, z }),
        _ => None,
    };
    v.rows()?.iter().map(point).collect()
}

fn ids(f: Value<'_>, key: &str) -> Vec<String> {
    let Some(v) = f.get(key) else { return Vec::new() };
    match (v.items(), v.column()) {
        (Some(items), _) => items.filter_map(|v| v.id()).collect(),
        (None, Some(numbers)) => numbers.iter().map(|n| format!("{n:.0}")).collect(),
        (None, None) => v.id().into_iter().collect(),
    }
}

fn lane(f: Value<'_>, kind: &str, center: Vec<Point3>) -> CenterLane {
    let number = |key: &str| f.get(key).and_then(|v| v.number()).filter(|v| *v > 0.0);
    let limit = number("speed_limit_kmh")
        .map(|v| v * MPS_PER_KMH)
        .or(number("speed_limit_mph").map(|v| v * MPS_PER_MPH));
    // Waymo's connecting lanes are marked as made between two others; nuScenes' have their own type.
    let connecting = f.get("interpolating").and_then(|v| v.truth()) == Some(true) && kind != "LANE_FREEWAY";
    let width_m = f.get("polygon").and_then(points).and_then(|outline| mean_width(&outline, &center));
    CenterLane {
        lane: Lane {
            center,
            kind: if kind == "LANE_BIKE_LANE" { LaneKind::Bike } else { LaneKind::Vehicle },
            in_junction: connecting || kind == "LANE_SURFACE_UNSTRUCTURE",
            speed_limit_mps: limit,
            width_m,
            successors: ids(f, "exit_lanes"),
            predecessors: ids(f, "entry_lanes"),
            ..Lane::default()
        },
        boundaries: ["left_boundaries", "right_boundaries"].map(|key| boundaries(f, key)),
        neighbors: ["left_neighbor", "right_neighbor"].map(|key| neighbors(f, key)),
    }
}

/// An index, which ScenarioNet writes as text.
fn index(v: Value<'_>, key: &str) -> Option<usize> {
    v.get(key)?.id()?.parse().ok()
}

fn boundaries(f: Value<'_>, key: &str) -> Vec<Boundary> {
    let Some(items) = f.get(key).and_then(|v| v.items()) else { return Vec::new() };
    let one = |b: Value<'_>| {
        Some(Boundary {
            start: index(b, "lane_start_index")?,
            end: index(b, "lane_end_index")?,
            feature: b.get("boundary_feature_id")?.id()?,
            mark: mark(&b.get("boundary_type").and_then(|v| v.text()).unwrap_or_default()),
        })
    };
    items.filter_map(one).collect()
}

fn neighbors(f: Value<'_>, key: &str) -> Vec<Neighbor> {
    let Some(items) = f.get(key).and_then(|v| v.items()) else { return Vec::new() };
    let one = |n: Value<'_>| {
        // nuPlan's and nuScenes' neighbors are bare ids, along the whole lane.
        if let Some(lane) = n.id() {
            return Some(Neighbor { start: 0, end: 0, lane });
        }
        let (start, end) = (index(n, "self_start_index")?, index(n, "self_end_index")?);
        Some(Neighbor { start, end, lane: n.get("feature_id")?.id()? })
    };
    items.filter_map(one).collect()
}

/// MetaDrive's line types, color left out. They do not state which side of a passing line is solid.
fn mark(name: &str) -> LaneMark {
    let kind = name.trim_start_matches("ROAD_LINE_");
    match kind.rsplit_once('_').map_or(kind, |(kind, _color)| kind) {
        "BROKEN_SINGLE" => LaneMark::Dashed,
        "SOLID_SINGLE" => LaneMark::Solid,
        "SOLID_DOUBLE" => LaneMark::DoubleSolid,
        "BROKEN_DOUBLE" => LaneMark::DoubleDashed,
        _ => LaneMark::Unknown,
    }
}
