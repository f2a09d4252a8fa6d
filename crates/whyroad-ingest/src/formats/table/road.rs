//! `lanes` and `areas`: the road. A line is one cell, `x y; x y; ...` or `x y z; ...`, in meters of the drive's frame.

use super::problems::Problems;
use super::reader::Reader;
use super::sheet::{Sheet, list};
use super::signs;
use super::words::UnknownWords;
use crate::assemble::geometry::center_line;
use crate::assemble::junctions;
use crate::assemble::layers::Declared;
use crate::report::RowCount;
use std::collections::BTreeSet;
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Area, Facility, Lane, Point3, StopLine};
use whyroad_model::vocabulary::{FACILITY_KINDS, LANE_TAGS};

/// Kinds of areas that are not facilities.
const ROAD_KINDS: &[&str] = &["crosswalk", "junction", "drivable_area", "stop_line"];
const LINE: &str = "a line 'x y; x y; ...' or 'x y z; ...'";
const MARKS: &str =
    "one of unknown, none, dashed, solid, double_dashed, double_solid, solid_dashed, dashed_solid";

/// The map; `None` when there is none of its tables.
pub(super) fn read(declared: &Declared, reader: &mut Reader) -> Option<RoadMap> {
    let lanes = reader.sheet("lanes", &[&["lane_id"], &["centre_xyz_m", "left_xyz_m"]]);
    let areas = reader.sheet("areas", &[&["area_id"], &["kind"], &["boundary_xyz_m"]]);
    let mut map = RoadMap::default();
    let signs = signs::read(&mut map, reader);
    if lanes.is_none() && areas.is_none() && !signs {
        return None;
    }
    if let Some(sheet) = lanes {
        read_lanes(&sheet, &mut map, reader);
    }
    if let Some(sheet) = areas {
        read_areas(&sheet, &mut map, reader);
    }
    if map.junctions.is_empty() {
        junctions::add(&mut map);
    }
    if *declared != Declared::default() {
        declared.apply(&mut map);
    }
    Some(map)
}

fn line(text: &str) -> Option<Vec<Point3>> {
    text.split(';')
        .filter(|p| !p.trim().is_empty())
        .map(|point| {
            let v: Option<Vec<f64>> =
                point.split_whitespace().map(|n| n.parse().ok().filter(|v: &f64| v.is_finite())).collect();
            match v?[..] {
                [x, y] => Some(Point3 { x, y, z: f64::NAN }),
                [x, y, z] => Some(Point3 { x, y, z }),
                _ => None,
            }
        })
        .collect()
}

fn read_lanes(sheet: &Sheet, map: &mut RoadMap, reader: &mut Reader) {
    let (mut problems, mut words) = (Problems::default(), UnknownWords::default());
    let p = &mut problems;
    let [ids, left_neighbor, right_neighbor, successors, predecessors, junction] =
        ["lane_id", "left_neighbour", "right_neighbour", "successors", "predecessors", "junction_id"]
            .map(|n| sheet.texts(n));
    let [center, left, right] =
        ["centre_xyz_m", "left_xyz_m", "right_xyz_m"].map(|n| sheet.parsed(n, LINE, p, line));
    let [left_mark, right_mark] = ["left_mark", "right_mark"].map(|n| sheet.words(n, MARKS, p));
    let kind = sheet.words("kind", "one of vehicle, bus, bike, sidewalk, shoulder, other", p);
    let turn = sheet.words("turn", "one of straight, left, right, uturn", p);
    let tags = sheet.texts("tags");
    let in_junction = sheet.flags("in_junction", p);
    let (limit, width) = (sheet.numbers("speed_limit_mps", p), sheet.numbers("width_m", p));

    let mut count = RowCount { read: sheet.rows, ..RowCount::new("lanes") };
    let mut seen = BTreeSet::new();
    for i in 0..sheet.rows {
        let row = sheet.first_row + i;
        let Some(id) = ids[i].clone() else {
            problems.row("no_id", row, &mut count);
            continue;
        };
        let edge = |e: &Option<Vec<Point3>>| e.clone().filter(|l| l.len() >= 2).unwrap_or_default();
        let (left, right, stated) = (edge(&left[i]), edge(&right[i]), edge(&center[i]));
        let both = !left.is_empty() && !right.is_empty();
        let center = if stated.is_empty() && both { center_line(&left, &right) } else { stated };
        if center.is_empty() {
            problems.row("no_line", row, &mut count);
            continue;
        }
        if !seen.insert(id.clone()) {
            problems.row("duplicate", row, &mut count);
            continue;
        }
        count.keep("lane", 1);
        map.lanes.push(Lane {
            id,
            center,
            left: if both { left } else { Vec::new() },
            right: if both { right } else { Vec::new() },
            left_mark: left_mark[i].unwrap_or_default(),
            right_mark: right_mark[i].unwrap_or_default(),
            left_neighbor: left_neighbor[i].clone(),
            right_neighbor: right_neighbor[i].clone(),
            successors: list(&successors[i]),
            predecessors: list(&predecessors[i]),
            kind: kind[i].unwrap_or_default(),
            in_junction: in_junction[i].unwrap_or(false),
            speed_limit_mps: Some(limit[i]).filter(|v| v.is_finite()),
            width_m: Some(width[i]).filter(|v| v.is_finite()),
            junction_id: junction[i].clone(),
            turn: turn[i],
            tags: list(&tags[i]).iter().filter_map(|t| words.check("tags", t, LANE_TAGS)).collect(),
        });
    }
    map.lanes.sort_by(|a, b| a.id.cmp(&b.id));
    reader.report.diagnostics.extend(problems.diagnostics(&sheet.label));
    reader.report.diagnostics.extend(words.diagnostics(&sheet.label));
    reader.report.tables.push(count);
}

fn read_areas(sheet: &Sheet, map: &mut RoadMap, reader: &mut Reader) {
    let (mut problems, mut words) = (Problems::default(), UnknownWords::default());
    let known: Vec<&'static str> = ROAD_KINDS.iter().chain(FACILITY_KINDS).copied().collect();
    let [ids, kinds, lanes] = ["area_id", "kind", "lane_ids"].map(|n| sheet.texts(n));
    let boundaries = sheet.parsed("boundary_xyz_m", LINE, &mut problems, line);
    let mut count = RowCount { read: sheet.rows, ..RowCount::new("areas") };
    let mut seen = BTreeSet::new();
    for (i, boundary) in boundaries.into_iter().enumerate() {
        let row = sheet.first_row + i;
        let (Some(id), Some(kind)) = (ids[i].clone(), kinds[i].clone()) else {
            problems.row("no_id", row, &mut count);
            continue;
        };
        let Some(kind) = words.check("kind", &kind, &known) else {
            problems.row("unknown_word", row, &mut count);
            continue;
        };
        // Two points are a line (a stop line, a speed bump across the road); an area needs three.
        let is_area = matches!(kind.as_str(), "crosswalk" | "junction" | "drivable_area");
        let Some(mut boundary) = boundary.filter(|b| b.len() >= if is_area { 3 } else { 2 }) else {
            problems.row("no_line", row, &mut count);
            continue;
        };
        if !seen.insert((kind.clone(), id.clone())) {
            problems.row("duplicate", row, &mut count);
            continue;
        }
        if boundary.len() > 2 && kind != "stop_line" && boundary.first() != boundary.last() {
            boundary.extend(boundary.first().copied());
        }
        match kind.as_str() {
            "crosswalk" => map.crosswalks.push(Area { id, boundary }),
            "junction" => map.junctions.push(Area { id, boundary }),
            "drivable_area" => map.drivable_areas.push(Area { id, boundary }),
            "stop_line" => map.stop_lines.push(StopLine { id, line: boundary, lane_ids: list(&lanes[i]) }),
            _ => map.facilities.push(Facility { id, kind: kind.clone(), boundary }),
        }
        count.keep(
            match kind.as_str() {
                "crosswalk" => "crosswalk",
                "junction" => "junction",
                "drivable_area" => "drivable_area",
                "stop_line" => "stop_line",
                _ => "facility",
            },
            1,
        );
    }
    for list in [&mut map.crosswalks, &mut map.junctions, &mut map.drivable_areas] {
        list.sort_by(|a, b| a.id.cmp(&b.id));
    }
    map.stop_lines.sort_by(|a, b| a.id.cmp(&b.id));
    map.facilities.sort_by(|a, b| a.id.cmp(&b.id));
    reader.report.diagnostics.extend(problems.diagnostics(&sheet.label));
    reader.report.diagnostics.extend(words.diagnostics(&sheet.label));
    reader.report.tables.push(count);
}
