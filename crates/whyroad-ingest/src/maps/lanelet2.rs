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
use lanelets::{Lanelets, MAX_PIECES};
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
        let Some(rings) = outer(document, relation) else {
            out.invalid.push(format!("multipolygon {id}: its outer ways make no ring"));
            continue;
        };
        for (k, nodes) in rings.iter().enumerate() {
            if let Some(boundary) = ring(ground, nodes) {
                let id = if k == 0 { format!("area_{id}") } else { format!("area_{id}_{k}") };
                out.map.facilities.push(Facility { id, kind: kind.into(), boundary });
            }
        }
    }
}

/// The rings of the outer ways of a multipolygon, the nodes of each in order. The ways come in any order and run either
/// way. `None` where one is missing, or where some meet no other.
///
/// Source: OpenStreetMap wiki, Relation:multipolygon.
fn outer(document: &Document, relation: &Relation) -> Option<Vec<Vec<i64>>> {
    let ways = relation.members(MemberKind::Way, "outer").map(|id| {
        let nodes = document.ways.get(&id)?.nodes.as_slice();
        (!nodes.is_empty()).then_some(nodes)
    });
    let mut ways: Vec<&[i64]> = ways.collect::<Option<_>>()?;
    if ways.is_empty() || ways.len() > MAX_PIECES || ways.iter().map(|w| w.len()).sum::<usize>() > MAX_POINTS
    {
        return None;
    }
    if let [only] = ways[..] {
        // A file that leaves out the closing node means a ring nevertheless.
        return (only.len() >= 3).then(|| vec![only.to_vec()]);
    }
    let mut rings = Vec::new();
    while !ways.is_empty() {
        let mut nodes = ways.remove(0).to_vec();
        while nodes.first() != nodes.last() {
            let end = nodes.last();
            let Some(next) = ways.iter().position(|way| way.first() == end || way.last() == end) else {
                // As of a single way: nothing is left that could close it.
                if ways.is_empty() {
                    break;
                }
                return None;
            };
            append(&mut nodes, ways.remove(next))?;
        }
        if nodes.len() < 3 {
            return None;
        }
        rings.push(nodes);
    }
    Some(rings)
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
