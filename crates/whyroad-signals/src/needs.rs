//! The data that signals need and a log lacks.

use crate::estimate::{footprint, usual_size};
use std::collections::BTreeSet;
use whyroad_model::road_map::{Lane, LaneMark, MapLayer};
use whyroad_model::scene::{FrameOfReference, Track};
use whyroad_model::vocabulary::{FACILITY_KINDS, SIGN_KINDS};
use whyroad_model::{Drive, Need, ObjectClass};

/// The data that this log lacks.
pub fn missing(drive: &Drive) -> BTreeSet<Need> {
    let mut missing = BTreeSet::new();
    let ego = drive.ego.as_ref().filter(|e| e.motion.x.iter().any(|x| x.is_finite()));
    if ego.is_none() || drive.meta.frame_of_reference == FrameOfReference::Ego {
        missing.insert(Need::EgoPose);
    }
    if drive.map.as_ref().is_none_or(|m| m.lanes.is_empty()) {
        missing.insert(Need::Map);
    }
    if drive.lights.is_none() {
        missing.insert(Need::TrafficLights);
    }
    if !drive.meta.can && ego.is_none_or(|e| !has_bus(&e.bus)) {
        missing.insert(Need::VehicleBus);
    }
    // Objects that were not recorded, or could not be read, are no empty road; a radar is where some logs have them.
    if [Need::Objects, Need::Radar].iter().any(|need| drive.meta.missing.contains(need)) {
        missing.insert(Need::Objects);
    }
    // In a log without tracks no size can be missing.
    let sized = |t: &Track| t.length_m.iter().any(|l| l.is_finite());
    let ego_sized = ego.is_none_or(|e| e.length_m.is_finite() && e.width_m.is_finite());
    if !ego_sized || (!drive.tracks.is_empty() && !drive.tracks.iter().any(sized)) {
        missing.insert(Need::ObjectSizes);
    }
    // A radar gives no classes: "no target is a vehicle" would be unfounded.
    if !drive.tracks.is_empty() && drive.tracks.iter().all(|t| t.class == ObjectClass::Unknown) {
        missing.insert(Need::ObjectClasses);
    }
    // Where every motor vehicle may be of any kind, "no target is a large vehicle" would be unfounded.
    let mut vehicles = drive.tracks.iter().map(|t| t.class).filter(|c| c.is_vehicle()).peekable();
    if vehicles.peek().is_some() && vehicles.all(|c| c == ObjectClass::Vehicle) {
        missing.insert(Need::VehicleKinds);
    }
    if !drive.tracks.iter().any(|t| !t.turn_signal.is_empty()) {
        missing.insert(Need::TurnSignals);
    }
    if !drive.tracks.iter().any(|t| t.interior_points.iter().any(|n| n.is_finite())) {
        missing.insert(Need::Visibility);
    }
    missing.extend(missing_of_road(drive));
    missing.extend(missing_layers(drive));
    missing.extend(missing_context(drive));
    missing
}

/// Data that this log has of some kinds of objects only: sizes of people, who are all of much the same size, beside
/// vehicles without any. Nothing that is [`missing`] altogether.
pub fn missing_in_part(drive: &Drive, without_boxes: &BTreeSet<ObjectClass>) -> Option<Need> {
    let mut others = drive.tracks.iter().map(|t| t.class).filter(|c| usual_size(*c).is_none()).peekable();
    (others.peek().is_some() && others.all(|c| without_boxes.contains(&c))).then_some(Need::ObjectSizes)
}

/// Classes of objects of which no box is known in any row.
pub fn without_boxes(drive: &Drive) -> BTreeSet<ObjectClass> {
    let has_box = |t: &&Track| (0..t.frames.len()).any(|row| footprint(t, row).is_known());
    let boxed: BTreeSet<ObjectClass> = drive.tracks.iter().filter(has_box).map(|t| t.class).collect();
    drive.tracks.iter().map(|t| t.class).filter(|c| !boxed.contains(c)).collect()
}

/// Layers that the map does not have.
fn missing_layers(drive: &Drive) -> impl Iterator<Item = Need> {
    let absent = |layer: &MapLayer| drive.map.as_ref().is_some_and(|m| !m.has(*layer));
    MapLayer::ALL.into_iter().filter(absent).filter_map(MapLayer::need)
}

/// Missing data of the map, the heights and the route.
fn missing_of_road(drive: &Drive) -> impl Iterator<Item = Need> {
    let map = drive.map.as_ref();
    let ego_z = drive.ego.iter().any(|e| e.motion.z.iter().any(|z| z.is_finite()));
    let road_z = map.is_some_and(|m| m.lanes.iter().any(|l| l.center.iter().any(|p| p.z.is_finite())));
    let routed = drive.ego.iter().any(|e| e.bus.route_command.iter().any(Option::is_some))
        || states(drive, "route_distance");
    let tracked_signs = drive.tracks.iter().any(|t| t.source_class.eq_ignore_ascii_case("stop_sign"));
    let marked = |l: &Lane| l.left_mark != LaneMark::Unknown || l.right_mark != LaneMark::Unknown;
    let marks = states(drive, "lane_marks") || map.is_some_and(|m| m.lanes.iter().any(marked));
    [
        (Need::Elevation, ego_z || road_z),
        (Need::Routing, routed),
        (Need::LaneMarks, marks),
        (Need::Signs, map.is_some_and(|m| SIGN_KINDS.iter().any(|k| m.covers(k))) || tracked_signs),
        (Need::Facilities, map.is_some_and(|m| FACILITY_KINDS.iter().any(|k| m.covers(k)))),
    ]
    .into_iter()
    .filter_map(|(need, there)| (!there).then_some(need))
}

/// Needs that one kind of context state satisfies each; a log that never states the kind lacks it.
const CONTEXT_NEEDS: [(Need, &str); 10] = [
    (Need::Weather, "weather"),
    (Need::Surface, "surface"),
    (Need::Lighting, "lighting"),
    (Need::RoadType, "road_type"),
    (Need::ConstructionState, "construction"),
    (Need::AccidentState, "accident"),
    (Need::WarningLight, "warning_light"),
    (Need::GateState, "gate"),
    (Need::NavigationLimit, "nav_speed_limit"),
    (Need::Pavement, "pavement"),
];

fn missing_context(drive: &Drive) -> impl Iterator<Item = Need> {
    // Data that another kind of state, or the lanes' tags, also state.
    let also = |need: Need| match need {
        Need::Weather => states(drive, "visibility"),
        Need::Pavement => drive.map.iter().flat_map(|m| &m.lanes).any(|l| l.is_tagged("unpaved")),
        _ => false,
    };
    let lacks = move |(need, kind): (Need, &str)| (!states(drive, kind) && !also(need)).then_some(need);
    CONTEXT_NEEDS.into_iter().filter_map(lacks)
}

/// True when the log states `kind` at least once.
fn states(drive: &Drive, kind: &str) -> bool {
    drive.context.iter().flatten().any(|s| s.kind == kind)
}

fn has_bus(bus: &whyroad_model::scene::EgoBus) -> bool {
    !(bus.brake.is_empty() && bus.turn_signal.is_empty() && bus.aeb.is_empty() && bus.steering.is_empty())
}
