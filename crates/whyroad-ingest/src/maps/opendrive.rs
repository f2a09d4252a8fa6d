//! OpenDRIVE maps (ASAM OpenDRIVE 1.4 to 1.8, `.xodr`): roads, lanes, junctions, objects and signals.
//!
//! Lanes of all kinds that traffic uses are placed along the reference line of their road; each lane section is a
//! lane of its own. Not read: crossfall and shapes of the surface, heights of single lanes, repeated objects,
//! railways, the geographic reference, junction boundaries.

mod cubic;
mod document;
mod features;
mod junctions;
mod lanes;
mod links;
mod marks;
mod plan_view;
mod spans;

use super::MapReading;
use crate::assemble::layers;
use crate::encodings::input::Input;
use crate::report::RowCount;
use document::{Document, RoadLink};
use lanes::{Budget, LaneKey};
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Lane, LaneKind, LayerState, MapLayer};

/// Longest sum of all roads, m.
const MAX_TOTAL_M: f64 = 1e7;

/// Reads a map as far as it can be read. `Err` when the file is not OpenDRIVE.
pub(super) fn read<'a>(input: impl Into<Input<'a>>) -> Result<MapReading, String> {
    let document = document::read(input.into())?;
    let mut out = MapReading { count: RowCount::new("map"), ..MapReading::default() };
    out.name = Some(document.name.clone()).filter(|n| !n.is_empty());
    out.broken.clone_from(&document.broken);
    let mut lanes: BTreeMap<LaneKey, Lane> = BTreeMap::new();
    let (mut budget, mut total) = (Budget::default(), 0.0);
    let mut sound = Vec::with_capacity(document.roads.len());
    for (index, road) in document.roads.iter().enumerate() {
        let count: usize = road.sections.iter().map(|s| s.lanes.iter().filter(|l| l.id != 0).count()).sum();
        out.count.read += count;
        let sum = total + road.length.unwrap_or(0.0);
        let fault = lanes::fault(road)
            .or_else(|| (sum > MAX_TOTAL_M).then(|| "its roads are longer than a map's".to_owned()));
        sound.push(fault.is_none());
        if let Some(fault) = fault {
            out.count.drop_rows("invalid", count);
            out.invalid.push(fault);
            continue;
        }
        total = sum;
        let placed = lanes::place(index, road, &mut budget);
        out.count.keep("lane", placed.lanes.len());
        out.count.set_aside("not_a_road_user_lane", placed.set_aside);
        out.count.drop_rows("invalid", placed.invalid.len());
        let kept = placed.lanes.len() + placed.set_aside + placed.invalid.len();
        // The same number twice in a section.
        out.count.drop_rows("duplicate", count.saturating_sub(kept));
        out.invalid.extend(placed.invalid);
        lanes.extend(placed.lanes);
    }
    let index = links::Index::of(&document);
    out.dangling = links::join(&document, &index, &mut lanes);
    out.map.junctions = junctions::mark(&document, &mut lanes);
    leave_map(&document, &mut lanes);
    let found = features::add(&document, &lanes, &sound, &mut out.map);
    out.invalid.extend(found.invalid);
    if found.count.read > 0 {
        out.features = Some(found.count);
    }
    out.map.lanes = lanes.into_values().collect();
    out.map.lanes.sort_by(|a, b| a.id.cmp(&b.id));
    declare(&mut out.map);
    Ok(out)
}

/// A lane at the unconnected end of a road leaves the map: it does not end on the road.
fn leave_map(document: &Document, lanes: &mut BTreeMap<LaneKey, Lane>) {
    let known: BTreeSet<&str> = document.roads.iter().map(|r| r.id.as_str()).collect();
    for (key, lane) in lanes.iter_mut().filter(|(_, l)| l.successors.is_empty()) {
        let road = &document.roads[key.road];
        let doc = road.sections.get(key.section).and_then(|s| s.lanes.iter().find(|l| l.id == key.lane));
        let forward = doc.is_some_and(|l| lanes::goes_forward(road, l));
        let (last, link) = if forward {
            (key.section + 1 == road.sections.len(), &road.successor)
        } else {
            (key.section == 0, &road.predecessor)
        };
        let open = match link {
            None => true,
            Some(RoadLink::Road(id, _)) => !known.contains(id.as_str()),
            Some(RoadLink::Junction(_)) => false,
        };
        if last && open {
            lane.successors.push(format!("beyond:{}", lane.id));
        }
    }
}

fn declare(map: &mut RoadMap) {
    let limited = |l: &&Lane| l.kind == LaneKind::Vehicle && !l.in_junction;
    let all_limited = map.lanes.iter().filter(limited).all(|l| l.speed_limit_mps.is_some());
    // The format states lanes beside each other, and links and junctions, or it is not a network; all else depends on
    // who made the map.
    let mut stated = vec![(MapLayer::Neighbors, LayerState::Complete)];
    if map.lanes.iter().any(|l| l.successors.iter().any(|s| !s.starts_with("beyond:"))) {
        stated.push((MapLayer::Connections, LayerState::Complete));
        stated.push((MapLayer::Junctions, LayerState::Complete));
    }
    if all_limited && map.lanes.iter().any(|l| l.speed_limit_mps.is_some()) {
        stated.push((MapLayer::SpeedLimits, LayerState::Complete));
    }
    stated.extend(map.layers.iter().map(|(layer, state)| (*layer, *state)));
    layers::declare(map, &stated);
}

#[cfg(test)]
mod tests;
