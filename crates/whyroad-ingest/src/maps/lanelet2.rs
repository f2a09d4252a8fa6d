//! Lanelet2 maps (OSM XML, `.osm`): lanelets with their bounds, regulatory elements, crosswalks, areas.
//!
//! Coordinates are the nodes' `local_x`, `local_y` (Autoware), or degrees with the origin that the user states. Not
//! read: traffic rules that follow from a place (default limits), times and conditions of restrictions, tracks of
//! rails.

mod crosswalks;
mod document;
mod ground;
mod lanelets;
mod regulatory;

use super::options::Placement;
use super::{MapFault, MapReading};
use crate::assemble::{junctions, layers};
use crate::encodings::input::Input;
use crate::report::RowCount;
use document::{Document, MemberKind, Relation, append};
use ground::{Ground, MAX_POINTS};
use lanelets::Lanelets;
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Area, Facility, Lane, LaneKind, LayerState, MapLayer};

/// Reads a map as far as it can be read.
pub(super) fn read<'a>(input: impl Into<Input<'a>>, placement: &Placement) -> Result<MapReading, MapFault> {
    let document = document::read(input.into()).map_err(MapFault::Unreadable)?;
    let mut ground = Ground::of(&document, placement)?;
    let mut out = MapReading { count: RowCount::new("map"), ..MapReading::default() };
    out.broken.clone_from(&document.broken);
    let lanelets = Lanelets::of(&document, &mut ground, &mut out);
    out.map.lanes = lanelets.lanes();
    out.map.lanes.sort_by(|a, b| a.id.cmp(&b.id));
    out.map.lanes.dedup_by(|b, a| a.id == b.id);
    if out.map.lanes.iter().any(|l| l.in_junction) {
        junctions::add(&mut out.map);
    }
    regulatory::add(&document, &lanelets, &mut ground, &mut out);
    crosswalks::add(&document, &mut ground, &mut out);
    areas(&document, &mut ground, &mut out);
    let map = &mut out.map;
    map.crosswalks.sort_by(|a, b| a.id.cmp(&b.id));
    map.stop_lines.sort_by(|a, b| a.id.cmp(&b.id));
    map.signs.sort_by(|a, b| a.id.cmp(&b.id));
    map.facilities.sort_by(|a, b| a.id.cmp(&b.id));
    declare(map);
    Ok(out)
}

/// Parking, buildings and junction areas.
fn areas(document: &Document, ground: &mut Ground, out: &mut MapReading) {
    let kind = |tag: &str| match tag {
        "parking" | "parking_lot" | "parking_space" => Some("parking"),
        "building" => Some("building"),
        _ => None,
    };
    let ring = |ground: &mut Ground, nodes: &[i64]| {
        let mut line = ground.line(nodes).filter(|l| l.len() >= 3)?;
        if line.first() != line.last() {
            line.extend(line.first().copied());
        }
        Some(line)
    };
    for (id, way) in &document.ways {
        if let (Some(kind), "yes") = (kind(way.tag("type")), way.tag("area"))
            && let Some(boundary) = ring(ground, &way.nodes)
        {
            out.map.facilities.push(Facility { id: format!("area_{id}"), kind: kind.into(), boundary });
        }
        if way.tag("type") == "intersection_area"
            && let Some(boundary) = ring(ground, &way.nodes)
            && out.map.junctions.is_empty()
        {
            out.map.junctions.push(Area { id: format!("area_{id}"), boundary });
        }
    }
    for (id, relation) in document.relations.iter().filter(|(_, r)| r.tag("type") == "multipolygon") {
        let Some(kind) = kind(relation.tag("subtype")) else { continue };
        let Some(nodes) = outer(document, relation) else {
            out.invalid.push(format!("multipolygon {id}: its outer ways make no ring"));
            continue;
        };
        if let Some(boundary) = ring(ground, &nodes) {
            out.map.facilities.push(Facility { id: format!("area_{id}"), kind: kind.into(), boundary });
        }
    }
}

/// The nodes of the outer ways of a multipolygon, in the order in which they follow each other.
fn outer(document: &Document, relation: &Relation) -> Option<Vec<i64>> {
    let mut out: Vec<i64> = Vec::new();
    for id in relation.members(MemberKind::Way, "outer") {
        let nodes = &document.ways.get(&id).filter(|way| !way.nodes.is_empty())?.nodes;
        if out.is_empty() {
            out.extend(nodes);
        } else if append(&mut out, nodes).is_none() {
            // The first way may have been taken the wrong way round.
            out.reverse();
            append(&mut out, nodes)?;
        }
        if out.len() > MAX_POINTS {
            return None;
        }
    }
    (out.len() >= 3).then_some(out)
}

fn declare(map: &mut RoadMap) {
    // Lanelets that share an edge are beside each other: the format's own rule.
    let mut stated = vec![(MapLayer::Neighbors, LayerState::Complete)];
    // Lanelets that share their end points lead into each other: the format's own rule.
    if map.lanes.iter().any(|l| l.successors.iter().any(|s| !s.starts_with("beyond:"))) {
        stated.push((MapLayer::Connections, LayerState::Complete));
    }
    let road = |l: &&Lane| l.kind == LaneKind::Vehicle && !l.in_junction;
    let mut limits = map.lanes.iter().filter(road).map(|l| l.speed_limit_mps.is_some()).peekable();
    if limits.peek().is_some() && limits.all(|stated| stated) {
        stated.push((MapLayer::SpeedLimits, LayerState::Complete));
    }
    layers::declare(map, &stated);
}

#[cfg(test)]
mod tests;
