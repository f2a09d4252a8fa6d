//! `map/log_map_archive_*.json`: AV2's vector map of the log's surroundings, in the city frame.
//!
//! What AV2 does not have is derived or left out: center lines come from the edges, junction areas are the outlines
//! (holes filled) of the union of the lanes marked `is_intersection`, and there are no stop lines, signs or speed
//! limits. Sensor maps list successors fully and predecessors only in part, so each link is completed from its
//! other end. Maps are local crops: ids of lanes beyond the border are kept, though no such lane is there.

use crate::assemble::geometry::{between, center_line, edges_oppose};
use crate::assemble::{junctions, layers};
use crate::report::RowCount;
use geo::{ConvexHull, Coord, LineString, MultiPoint, Point};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Area, Lane, LaneKind, LaneMark, LayerState, MapLayer, Point3};
use whyroad_model::vocabulary::BUS_LANES;

/// A link to a lane that is not there is put down to the map's border when the lane ends this near to it, m.
const BORDER_M: f64 = 25.0;

#[derive(Deserialize)]
struct LaneSegment {
    id: i64,
    is_intersection: bool,
    lane_type: String,
    left_lane_boundary: Vec<Point3>,
    right_lane_boundary: Vec<Point3>,
    /// Motion forecasting maps only.
    #[serde(default)]
    centerline: Vec<Point3>,
    #[serde(default)]
    left_lane_mark_type: String,
    #[serde(default)]
    right_lane_mark_type: String,
    #[serde(default)]
    successors: Vec<i64>,
    #[serde(default)]
    predecessors: Vec<i64>,
    left_neighbor_id: Option<i64>,
    right_neighbor_id: Option<i64>,
}

#[derive(Deserialize)]
struct Crossing {
    id: i64,
    edge1: Vec<Point3>,
    edge2: Vec<Point3>,
}

#[derive(Deserialize)]
struct DrivableArea {
    id: i64,
    area_boundary: Vec<Point3>,
}

/// A link to a lane that is not in the map.
pub(super) struct Dangling {
    /// `successors`, `predecessors`, `left_neighbor_id` or `right_neighbor_id`.
    pub field: &'static str,
    pub lane: String,
    pub missing: String,
    /// The lane ends at the map's border, where such links are to be expected.
    pub at_border: bool,
}

/// The map, and what was found on the way.
#[derive(Default)]
pub(super) struct MapReading {
    pub map: RoadMap,
    pub count: RowCount,
    pub dangling: Vec<Dangling>,
    /// Links that only one of their two lanes stated.
    pub completed_links: usize,
    /// Lanes whose edges ran against each other; the right one was turned round.
    pub turned_edges: usize,
    /// Description of the first feature that could not be used.
    pub invalid_example: Option<String>,
}

/// The features of a map in which each of them is whole.
#[derive(Deserialize)]
struct Whole {
    lane_segments: BTreeMap<String, LaneSegment>,
    #[serde(default)]
    pedestrian_crossings: BTreeMap<String, Crossing>,
    #[serde(default)]
    drivable_areas: BTreeMap<String, DrivableArea>,
}

/// Features of one kind in the order of their keys; one that cannot be read is an error of its own.
type Features<T> = Vec<(String, serde_json::Result<T>)>;

/// Reads the map. `Err` when the text is not a map at all; a single bad feature is counted and left out.
pub(super) fn read(text: &str) -> Result<MapReading, String> {
    // Nearly all maps are whole: they are read without values of JSON in between.
    if let Ok(all) = serde_json::from_str::<Whole>(text) {
        fn each<T>(all: BTreeMap<String, T>) -> Features<T> {
            all.into_iter().map(|(key, feature)| (key, Ok(feature))).collect()
        }
        return Ok(reading(
            each(all.lane_segments),
            each(all.pedestrian_crossings),
            each(all.drivable_areas),
        ));
    }
    read_singly(text)
}

/// [`read`] feature by feature.
fn read_singly(text: &str) -> Result<MapReading, String> {
    fn each<T: DeserializeOwned>(root: &Value, key: &str) -> Features<T> {
        let all = root.get(key).and_then(Value::as_object).into_iter().flatten();
        all.map(|(key, value)| (key.clone(), T::deserialize(value))).collect()
    }
    let root: Value = serde_json::from_str(text).map_err(|e| e.to_string())?;
    if !root.get("lane_segments").is_some_and(Value::is_object) {
        return Err("object 'lane_segments' is missing".to_owned());
    }
    Ok(reading(
        each(&root, "lane_segments"),
        each(&root, "pedestrian_crossings"),
        each(&root, "drivable_areas"),
    ))
}

fn reading(
    segments: Features<LaneSegment>,
    crossings: Features<Crossing>,
    areas: Features<DrivableArea>,
) -> MapReading {
    let mut r = MapReading { count: RowCount::new("map"), ..MapReading::default() };
    let segments = usable(segments, "lane_segments", &mut r, |s| {
        s.left_lane_boundary.len() >= 2 && s.right_lane_boundary.len() >= 2
    });
    r.count.keep("lane", segments.len());
    r.map.lanes = segments.into_iter().map(|s| lane(s, &mut r.turned_edges)).collect();
    let crossings =
        usable(crossings, "pedestrian_crossings", &mut r, |c| c.edge1.len() >= 2 && c.edge2.len() >= 2);
    r.count.keep("crosswalk", crossings.len());
    r.map.crosswalks = crossings.into_iter().map(crosswalk).collect();
    let areas = usable(areas, "drivable_areas", &mut r, |a| a.area_boundary.len() >= 3);
    r.count.keep("drivable_area", areas.len());
    r.map.drivable_areas = areas.into_iter().map(drivable_area).collect();

    r.map.lanes.sort_by(|a, b| a.id.cmp(&b.id));
    r.map.crosswalks.sort_by(|a, b| a.id.cmp(&b.id));
    r.map.drivable_areas.sort_by(|a, b| a.id.cmp(&b.id));
    // AV2's maps have all lanes, crossings and paint around a drive, and say which lanes are for buses; limits, lights,
    // stop lines and ramps they never have.
    r.map.complete_for.push(BUS_LANES.to_owned());
    let complete = [
        MapLayer::Connections,
        MapLayer::Junctions,
        MapLayer::Neighbors,
        MapLayer::Crosswalks,
        MapLayer::Marks,
        MapLayer::Heights,
    ];
    layers::declare(&mut r.map, &complete.map(|layer| (layer, LayerState::Complete)));
    r.dangling = dangling_links(&r.map.lanes);
    r.completed_links = complete_links(&mut r.map.lanes);
    junctions::add(&mut r.map);
    r
}

/// The features that are usable, in their order; the others are counted.
fn usable<T>(all: Features<T>, kind: &str, r: &mut MapReading, usable: impl Fn(&T) -> bool) -> Vec<T> {
    let mut out = Vec::with_capacity(all.len());
    for (id, feature) in all {
        r.count.read += 1;
        let reason = match feature {
            Ok(feature) if usable(&feature) => {
                out.push(feature);
                continue;
            }
            Ok(_) => "too few points".to_owned(),
            Err(e) => e.to_string(),
        };
        r.count.drop_rows("invalid", 1);
        r.invalid_example.get_or_insert_with(|| format!("{kind} {id}: {reason}"));
    }
    out
}

fn lane(s: LaneSegment, turned_edges: &mut usize) -> Lane {
    let left = s.left_lane_boundary;
    let mut right = s.right_lane_boundary;
    if edges_oppose(&left, &right) {
        right.reverse();
        *turned_edges += 1;
    }
    let texts = |ids: Vec<i64>| ids.iter().map(i64::to_string).collect::<Vec<_>>();
    Lane {
        id: s.id.to_string(),
        center: if s.centerline.len() >= 2 { s.centerline } else { center_line(&left, &right) },
        left,
        right,
        left_mark: mark(&s.left_lane_mark_type),
        right_mark: mark(&s.right_lane_mark_type),
        left_neighbor: s.left_neighbor_id.map(|id| id.to_string()),
        right_neighbor: s.right_neighbor_id.map(|id| id.to_string()),
        successors: texts(s.successors),
        predecessors: texts(s.predecessors),
        kind: match s.lane_type.as_str() {
            "VEHICLE" => LaneKind::Vehicle,
            "BIKE" => LaneKind::Bike,
            "BUS" => LaneKind::Bus,
            _ => LaneKind::Other,
        },
        in_junction: s.is_intersection,
        ..Lane::default()
    }
}

/// AV2's mark types, color left out (Wilson et al. 2021; `LaneMarkType` of the AV2 map API).
fn mark(name: &str) -> LaneMark {
    match name {
        "NONE" => LaneMark::None,
        "SOLID_WHITE" | "SOLID_YELLOW" | "SOLID_BLUE" => LaneMark::Solid,
        "DASHED_WHITE" | "DASHED_YELLOW" => LaneMark::Dashed,
        "DOUBLE_SOLID_WHITE" | "DOUBLE_SOLID_YELLOW" => LaneMark::DoubleSolid,
        "DOUBLE_DASH_WHITE" | "DOUBLE_DASH_YELLOW" => LaneMark::DoubleDashed,
        "SOLID_DASH_WHITE" | "SOLID_DASH_YELLOW" => LaneMark::SolidDashed,
        "DASH_SOLID_WHITE" | "DASH_SOLID_YELLOW" => LaneMark::DashedSolid,
        _ => LaneMark::Unknown,
    }
}

/// The two edges run the same way across the road, so the polygon is one forward and the other back; where they run
/// against each other they are joined unchanged.
fn crosswalk(c: Crossing) -> Area {
    let mut edge2 = c.edge2;
    if edges_oppose(&c.edge1, &edge2) {
        edge2.reverse();
    }
    Area { id: c.id.to_string(), boundary: between(&c.edge1, &edge2) }
}

fn drivable_area(a: DrivableArea) -> Area {
    let mut boundary = a.area_boundary;
    if boundary.first() != boundary.last() {
        boundary.extend(boundary.first().copied());
    }
    Area { id: a.id.to_string(), boundary }
}

/// No coordinate of a city is greater, m.
const EARTH_M: f64 = 1e8;

fn dangling_links(lanes: &[Lane]) -> Vec<Dangling> {
    let known = |id: &String| lanes.binary_search_by(|l| l.id.cmp(id)).is_ok();
    let edges = lanes.iter().flat_map(|l| l.left.iter().chain(&l.right));
    // The hull is computed by products of differences, and panics where they are not numbers.
    let on_earth = edges.filter(|p| p.x.abs() < EARTH_M && p.y.abs() < EARTH_M);
    let corners: MultiPoint = on_earth.map(|p| Point::new(p.x, p.y)).collect();
    let hull = corners.convex_hull();
    let mut out = Vec::new();
    for l in lanes {
        let ends = [l.center.first(), l.center.last()].map(|p| p.copied().unwrap_or_default());
        let links: [(&'static str, &[String], Point3); 4] = [
            ("successors", &l.successors, ends[1]),
            ("predecessors", &l.predecessors, ends[0]),
            ("left_neighbor_id", l.left_neighbor.as_slice(), ends[0]),
            ("right_neighbor_id", l.right_neighbor.as_slice(), ends[0]),
        ];
        for (field, ids, place) in links {
            for missing in ids.iter().filter(|id| !known(id)) {
                let at_border = distance_to_ring(hull.exterior(), place) <= BORDER_M;
                out.push(Dangling { field, lane: l.id.clone(), missing: missing.clone(), at_border });
            }
        }
    }
    out
}

fn distance_to_ring(ring: &LineString, p: Point3) -> f64 {
    let to_segment = |a: Coord, b: Coord| {
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let share = (((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy).max(1e-12)).clamp(0.0, 1.0);
        (p.x - a.x - share * dx).hypot(p.y - a.y - share * dy)
    };
    ring.lines().map(|l| to_segment(l.start, l.end)).fold(f64::INFINITY, f64::min)
}

/// Adds to each lane the links that only their other end states; the number added.
fn complete_links(lanes: &mut [Lane]) -> usize {
    let index: HashMap<String, usize> = lanes.iter().enumerate().map(|(i, l)| (l.id.clone(), i)).collect();
    let mut wanted: Vec<(usize, bool, String)> = Vec::new();
    for l in lanes.iter() {
        wanted.extend(l.successors.iter().filter_map(|s| Some((*index.get(s)?, false, l.id.clone()))));
        wanted.extend(l.predecessors.iter().filter_map(|p| Some((*index.get(p)?, true, l.id.clone()))));
    }
    let mut added = 0;
    for (lane, forward, id) in wanted {
        let list = if forward { &mut lanes[lane].successors } else { &mut lanes[lane].predecessors };
        if !list.contains(&id) {
            list.push(id);
            added += 1;
        }
    }
    added
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_beyond_the_earth_do_not_break_the_border() {
        // Found by the fuzz target `av2-map`: a corner at x = -1e308.
        let line = |y: f64, far: f64| {
            let point = |x: f64| format!(r#"{{"x": {x:?}, "y": {y:?}, "z": 0.0}}"#);
            format!("[{}]", [0.0, 20.0, far, 60.0].map(point).join(", "))
        };
        for far in [40.0, 1e308, -1e308] {
            let text = format!(
                r#"{{"lane_segments": {{"1": {{"id": 1, "is_intersection": false, "lane_type": "VEHICLE",
                "left_lane_boundary": {}, "right_lane_boundary": {}, "left_lane_mark_type": "NONE",
                "right_lane_mark_type": "NONE", "successors": [7], "predecessors": [], "left_neighbor_id": null,
                "right_neighbor_id": null}}}}, "pedestrian_crossings": {{}}, "drivable_areas": {{}}}}"#,
                line(1.8, far),
                line(-1.8, far)
            );
            let reading = read(&text).unwrap();
            assert_eq!((reading.map.lanes.len(), reading.dangling.len()), (1, 1), "{far}");
            // A whole map is read as one with a broken feature is; NaN is not equal to itself.
            let same = |map: &RoadMap| format!("{map:?}") == format!("{:?}", reading.map);
            assert!(same(&read_singly(&text).unwrap().map), "{far}");
            let broken = text.replacen(r#"_segments": {"#, r#"_segments": {"0": {"id": "x"},"#, 1);
            let broken = read(&broken).unwrap();
            assert_eq!((broken.count.read, same(&broken.map)), (2, true), "{far}");
            assert!(broken.invalid_example.is_some_and(|e| e.starts_with("lane_segments 0: ")));
        }
    }
}
