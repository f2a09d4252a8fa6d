//! What the ego's lane is, allows and is bounded by: kind, turns at the next junction, speed limits, marks, the lanes beside it.
//! What the map does not state is unknown.

use crate::context::Channels;
use crate::geometry::wrap;
use crate::junction::{HORIZON_M, LEFT, RIGHT, STRAIGHT, UTURN};
use crate::on_road::{OnRoad, within_horizon};
use crate::road::Road;
use crate::table::TableBuilder;
use crate::way::Way;
use std::collections::BTreeSet;
use whyroad_model::Tri;
use whyroad_model::road_map::{Lane, LaneKind, LaneMark, TurnKind};

/// Limits that differ by less are one: 30 km/h is written as 8.33 or 8.34 m/s.
const SAME_LIMIT_MPS: f64 = 0.1;
/// A lane shorter than this can be a joint between two roads, without a limit of its own, m.
const JOINT_M: f64 = 20.0;
/// A junction's lanes lead across it over no more links than this.
const MOST_LINKS: usize = 8;

// Indices into the catalogue's values of map.lane_turns; a test holds them to the names.
const ANY: u16 = 0;

/// Index of a set of turns among the values of `map.lane_turns`; `None` when there is no turn at all.
fn turns_code(turns: &BTreeSet<u16>) -> Option<u16> {
    let has = |t: u16| turns.contains(&t);
    Some(match (has(STRAIGHT), has(LEFT), has(RIGHT)) {
        (true, true, true) => ANY,
        (true, true, false) => 6,
        (true, false, true) => 7,
        (false, true, true) => 8,
        (true, false, false) => 1,
        (false, true, false) if has(UTURN) => 5,
        (false, true, false) => 2,
        (false, false, true) => 3,
        (false, false, false) if has(UTURN) => 4,
        (false, false, false) => return None,
    })
}

/// Turns (as in `ego.movement`) that junction lane `lane` leads to: as the map states, else by the heading that it changes by.
fn turns_of(on: &OnRoad<'_>, lane: usize, entry: f64, left: usize, found: &mut BTreeSet<u16>) {
    if let Some(turn) = on.lane(lane).and_then(|l| l.turn) {
        found.insert(match turn {
            TurnKind::Straight => STRAIGHT,
            TurnKind::Left => LEFT,
            TurnKind::Right => RIGHT,
            TurnKind::Uturn => UTURN,
        });
        return;
    }
    let shape = &on.road.lanes[lane];
    let onward: Vec<usize> =
        shape.successors.iter().copied().filter(|&l| on.road.lanes[l].in_junction && left > 0).collect();
    if onward.is_empty() {
        // As the road behind the junction goes; some maps draw the lanes inside as straight lines.
        let behind = shape.successors.first().map(|&l| heading_near(on.road, l, 0.0));
        let exit = behind.unwrap_or_else(|| heading_near(on.road, lane, shape.centre.length()));
        let turned = wrap(exit - entry).to_degrees();
        // The bounds of `ego.movement`.
        found.insert(match turned {
            a if a.abs() > 135.0 => UTURN,
            a if a >= 45.0 => LEFT,
            a if a <= -45.0 => RIGHT,
            _ => STRAIGHT,
        });
    }
    for next in onward {
        turns_of(on, next, entry, left - 1, found);
    }
}

/// Direction of a lane near arc length `s`, from within it.
fn heading_near(road: &Road, lane: usize, s: f64) -> f64 {
    let line = &road.lanes[lane].centre;
    line.smooth_heading_at(s.clamp(1.0, (line.length() - 1.0).max(1.0)), 1.0)
}

/// Direction in which the lanes that lead to junction lane `lane` enter the junction.
fn entry_heading(road: &Road, lane: usize) -> f64 {
    let mut at = lane;
    for _ in 0..MOST_LINKS {
        let Some(&before) = road.lanes[at].predecessors.first() else { break };
        if !road.lanes[before].in_junction {
            return heading_near(road, before, road.lanes[before].centre.length());
        }
        at = before;
    }
    heading_near(road, at, 0.0)
}

/// What the lane allows at the junction here or next within `reach` of the front bumper; `None` without one. Empty where the
/// ego's lane ends before it.
pub fn turns_ahead(on: &OnRoad<'_>, way: &Way, front: f64, reach: f64) -> Option<BTreeSet<u16>> {
    let here = way.step_at(front - on.ego.front());
    let mut found = BTreeSet::new();
    if on.road.lanes[way.steps[here].lane].in_junction {
        let lane = way.steps[here].lane;
        turns_of(on, lane, entry_heading(on.road, lane), MOST_LINKS, &mut found);
        return Some(found);
    }
    let inside = |k: &usize| on.road.lanes[way.steps[*k].lane].in_junction;
    let next = (here + 1..way.steps.len()).find(inside).filter(|&k| way.steps[k].from - front <= reach)?;
    if way.steps[here + 1..=next].iter().any(|s| s.hopped) {
        return Some(found);
    }
    let approach = way.steps[next - 1].lane;
    let entry = heading_near(on.road, approach, on.road.lanes[approach].centre.length());
    for &lane in &on.road.lanes[approach].successors {
        if on.road.lanes[lane].in_junction && on.road.lanes[lane].kind != LaneKind::Sidewalk {
            turns_of(on, lane, entry, MOST_LINKS, &mut found);
        }
    }
    Some(found)
}

fn kind_code(lane: &Lane) -> u16 {
    if lane.is_tagged("tidal") {
        return 6;
    }
    if lane.is_tagged("variable") {
        return 7;
    }
    match lane.kind {
        LaneKind::Vehicle => 0,
        LaneKind::Bus => 1,
        LaneKind::Bike => 2,
        LaneKind::Shoulder => 3,
        LaneKind::Sidewalk => 4,
        LaneKind::Other => 5,
    }
}

fn mark_code(mark: LaneMark) -> Option<u16> {
    Some(match mark {
        LaneMark::Unknown => return None,
        LaneMark::None => 0,
        LaneMark::Dashed => 1,
        LaneMark::Solid => 2,
        LaneMark::DoubleDashed => 3,
        LaneMark::DoubleSolid => 4,
        LaneMark::SolidDashed => 5,
        LaneMark::DashedSolid => 6,
    })
}

/// The lane beside the ego's; unknown where the map names one that it does not have.
fn beside_code(on: &OnRoad<'_>, index: usize, side: usize) -> Option<u16> {
    let own = on.lane(index)?;
    let Some(id) = [&own.left_neighbour, &own.right_neighbour][side] else { return Some(0) };
    let other = on.map.lane(id)?;
    let same = on.road.lanes[index].neighbours[side].is_some();
    Some(match (other.kind, same) {
        (LaneKind::Bike, _) => 4,
        (LaneKind::Shoulder, _) => 5,
        (LaneKind::Sidewalk | LaneKind::Other, _) => 0,
        (_, false) => 2,
        (LaneKind::Bus, true) => 3,
        (LaneKind::Vehicle, true) => 1,
    })
}

/// The limit here: the lane's own; a lane inside a junction has that of the lane that led to it.
fn limits(on: &OnRoad<'_>) -> Vec<Option<f64>> {
    let stated = |lane: usize| on.lane(lane).and_then(|l| l.speed_limit_mps);
    let mut before = None;
    (0..on.frames())
        .map(|i| {
            let lane = on.lanes.at(i)?.lane;
            let from = || {
                let shape = &on.road.lanes[lane];
                // As does a short piece that only joins two roads.
                if !shape.in_junction && shape.centre.length() > JOINT_M {
                    return None;
                }
                before.or_else(|| shape.predecessors.iter().find_map(|&p| stated(p)))
            };
            let here = stated(lane).or_else(from);
            before = here.or(before);
            here
        })
        .collect()
}

/// The next other limit on the way and the distance to it from the front bumper.
fn next_limit(on: &OnRoad<'_>, way: &Way, front: f64, here: f64) -> Option<(f64, f64)> {
    let own = way.step_at(front - on.ego.front());
    way.steps[own + 1..].iter().find_map(|step| {
        let limit = on.lane(step.lane)?.speed_limit_mps?;
        let distance = (step.from - front).max(0.0);
        ((limit - here).abs() > SAME_LIMIT_MPS && distance <= HORIZON_M).then_some((limit, distance))
    })
}

fn write_limits(on: &OnRoad<'_>, table: &mut TableBuilder<'_>) {
    let limits = limits(on);
    let next = |i: usize, way: &Way, front| next_limit(on, way, front, limits[i]?);
    table.number("map.speed_limit", limits.iter().map(|l| l.unwrap_or(f64::NAN)).collect());
    let ahead =
        |i: usize, way: &Way, front| next(i, way, front).map(|n| n.0).or(limits[i]).unwrap_or(f64::NAN);
    table.number("map.speed_limit_ahead", on.ahead(ahead));
    let distance = |i: usize, way: &Way, front| match limits[i] {
        None => f64::NAN,
        Some(_) => within_horizon(next(i, way, front).map_or(f64::INFINITY, |n| n.1)),
    };
    table.number("map.distance_to_limit_change", on.ahead(distance));
}

/// Whether both edges of the lane are marked, as the map has it.
fn marked(lane: &Lane) -> Tri {
    let of = |m: LaneMark| match m {
        LaneMark::Unknown => Tri::Unknown,
        m => Tri::from(m != LaneMark::None),
    };
    match (of(lane.left_mark), of(lane.right_mark)) {
        (Tri::False, _) | (_, Tri::False) => Tri::False,
        (Tri::True, Tri::True) => Tri::True,
        _ => Tri::Unknown,
    }
}

/// On a lane inside a junction one of whose edges is drawn.
fn guided(on: &OnRoad<'_>, frame: usize) -> Tri {
    let Some(at) = on.lanes.at(frame) else { return Tri::Unknown };
    if !on.road.lanes[at.lane].in_junction {
        return Tri::False;
    }
    let Some(lane) = on.lane(at.lane) else { return Tri::Unknown };
    let drawn = |m: LaneMark| !matches!(m, LaneMark::Unknown | LaneMark::None);
    match (lane.left_mark, lane.right_mark) {
        (l, r) if drawn(l) || drawn(r) => Tri::True,
        (LaneMark::None, LaneMark::None) => Tri::False,
        _ => Tri::Unknown,
    }
}

/// Writes `map.lane_marked`: as the channel says, else the map.
pub fn write_marked(on: &OnRoad<'_>, channels: &Channels<'_>, table: &mut TableBuilder<'_>) {
    let stated = channels.values("lane_marks");
    let drawn = |i: usize| match stated[i] {
        Some("missing") => Tri::False,
        Some("normal" | "faded" | "wrong") => Tri::True,
        _ => on.own_lane(i).map_or(Tri::Unknown, marked),
    };
    table.flag("map.lane_marked", on.flags(drawn));
}

/// Writes `map.lane_kind`, `lane_turns`, `left_mark`, `right_mark`, `left_lane`, `right_lane`, `on_guidance` and the limits.
pub fn write(on: &OnRoad<'_>, table: &mut TableBuilder<'_>) {
    write_limits(on, table);
    let frames = || 0..on.frames();
    table.category("map.lane_kind", frames().map(|i| on.own_lane(i).map(kind_code)));
    table.category("map.left_mark", frames().map(|i| on.own_lane(i).and_then(|l| mark_code(l.left_mark))));
    table.category("map.right_mark", frames().map(|i| on.own_lane(i).and_then(|l| mark_code(l.right_mark))));
    for (side, name) in ["map.left_lane", "map.right_lane"].into_iter().enumerate() {
        table.category(name, frames().map(|i| on.lanes.at(i).and_then(|at| beside_code(on, at.lane, side))));
    }
    let turns = |i: usize| {
        let (way, s) = on.ways.at(i)?;
        turns_ahead(on, way, s + on.ego.front(), HORIZON_M).map_or(Some(ANY), |t| turns_code(&t))
    };
    table.category("map.lane_turns", frames().map(turns));
    table.flag("map.on_guidance", on.flags(|i| guided(on, i)));
}
