//! Attributes of the ego's lane: kind, turns at the next junction, speed limits, markings, adjacent lanes. Values that
//! the map does not state are unknown.

use crate::geometry::wrap;
use crate::road::context::Channels;
use crate::road::junction::HORIZON_M;
use crate::road::network::Road;
use crate::road::on_road::{OnRoad, within_horizon};
use crate::road::way::Way;
use crate::table::TableBuilder;
use std::collections::BTreeSet;
use whyroad_model::Tri;
use whyroad_model::catalog::{
    Flag, PerFrame, Signal, id,
    value::{EgoMovement, MapLaneKind, MapLaneTurns, MapLeftLane, MapLeftMark},
};
use whyroad_model::road_map::{Lane, LaneKind, LaneMark, TurnKind};
use whyroad_model::vocabulary::BUS_LANES;

/// Limits that differ by less are equal: 30 km/h is written as 8.33 or 8.34 m/s.
const SAME_LIMIT_MPS: f64 = 0.1;
/// A lane shorter than this may be a joint between two roads, without a limit of its own, m.
const JOINT_M: f64 = 20.0;
/// Maximum number of links across a junction.
const MOST_LINKS: usize = 8;

/// The value of `map.lane_turns` for a set of turns; `None` if the set is empty.
fn turns_value(turns: &BTreeSet<EgoMovement>) -> Option<MapLaneTurns> {
    let has = |t: EgoMovement| turns.contains(&t);
    Some(match (has(EgoMovement::Straight), has(EgoMovement::Left), has(EgoMovement::Right)) {
        (true, true, true) => MapLaneTurns::Any,
        (true, true, false) => MapLaneTurns::StraightLeft,
        (true, false, true) => MapLaneTurns::StraightRight,
        (false, true, true) => MapLaneTurns::LeftRight,
        (true, false, false) => MapLaneTurns::Straight,
        (false, true, false) if has(EgoMovement::Uturn) => MapLaneTurns::LeftUturn,
        (false, true, false) => MapLaneTurns::Left,
        (false, false, true) => MapLaneTurns::Right,
        (false, false, false) if has(EgoMovement::Uturn) => MapLaneTurns::Uturn,
        (false, false, false) => return None,
    })
}

/// Turns (as in `ego.movement`) to which junction lane `lane` leads: as stated in the map, else from its change of
/// heading.
fn turns_of(on: &OnRoad<'_>, lane: usize, entry: f64, left: usize, found: &mut BTreeSet<EgoMovement>) {
    if let Some(turn) = on.lane(lane).and_then(|l| l.turn) {
        found.insert(match turn {
            TurnKind::Straight => EgoMovement::Straight,
            TurnKind::Left => EgoMovement::Left,
            TurnKind::Right => EgoMovement::Right,
            TurnKind::Uturn => EgoMovement::Uturn,
        });
        return;
    }
    let shape = &on.road.lanes[lane];
    let onward: Vec<usize> =
        shape.successors.iter().copied().filter(|&l| on.road.lanes[l].in_junction && left > 0).collect();
    if onward.is_empty() {
        // In the direction of the road behind the junction; some maps draw the lanes inside as straight lines.
        let behind = shape.successors.first().map(|&l| heading_near(on.road, l, 0.0));
        let exit = behind.unwrap_or_else(|| heading_near(on.road, lane, shape.center.length()));
        let turned = wrap(exit - entry).to_degrees();
        // The thresholds of `ego.movement`.
        found.insert(match turned {
            a if a.abs() > 135.0 => EgoMovement::Uturn,
            a if a >= 45.0 => EgoMovement::Left,
            a if a <= -45.0 => EgoMovement::Right,
            _ => EgoMovement::Straight,
        });
    }
    for next in onward {
        turns_of(on, next, entry, left - 1, found);
    }
}

/// Direction of a lane near arc length `s`, measured inside it.
fn heading_near(road: &Road, lane: usize, s: f64) -> f64 {
    let line = &road.lanes[lane].center;
    line.smooth_heading_at(s.clamp(1.0, (line.length() - 1.0).max(1.0)), 1.0)
}

/// Direction in which the lanes that lead to junction lane `lane` enter the junction.
fn entry_heading(road: &Road, lane: usize) -> f64 {
    let mut at = lane;
    for _ in 0..MOST_LINKS {
        let Some(&before) = road.lanes[at].predecessors.first() else { break };
        if !road.lanes[before].in_junction {
            return heading_near(road, before, road.lanes[before].center.length());
        }
        at = before;
    }
    heading_near(road, at, 0.0)
}

/// Turns that the lane allows at the current or next junction within `reach` of the front bumper; `None` without one.
/// Empty if the ego's lane ends before it.
pub fn turns_ahead(on: &OnRoad<'_>, way: &Way, front: f64, reach: f64) -> Option<BTreeSet<EgoMovement>> {
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
    let entry = heading_near(on.road, approach, on.road.lanes[approach].center.length());
    for &lane in &on.road.lanes[approach].successors {
        if on.road.lanes[lane].in_junction && on.road.lanes[lane].kind != LaneKind::Sidewalk {
            turns_of(on, lane, entry, MOST_LINKS, &mut found);
        }
    }
    Some(found)
}

fn kind_value(lane: &Lane) -> MapLaneKind {
    match lane.kind {
        LaneKind::Vehicle => MapLaneKind::Vehicle,
        LaneKind::Bus => MapLaneKind::Bus,
        LaneKind::Bike => MapLaneKind::Bike,
        LaneKind::Shoulder => MapLaneKind::Shoulder,
        LaneKind::Sidewalk => MapLaneKind::Sidewalk,
        LaneKind::Other => MapLaneKind::Other,
    }
}

fn mark_value(mark: LaneMark) -> Option<MapLeftMark> {
    Some(match mark {
        LaneMark::Unknown => return None,
        LaneMark::None => MapLeftMark::None,
        LaneMark::Dashed => MapLeftMark::Dashed,
        LaneMark::Solid => MapLeftMark::Solid,
        LaneMark::DoubleDashed => MapLeftMark::DoubleDashed,
        LaneMark::DoubleSolid => MapLeftMark::DoubleSolid,
        LaneMark::SolidDashed => MapLeftMark::SolidDashed,
        LaneMark::DashedSolid => MapLeftMark::DashedSolid,
    })
}

/// The lane beside the ego's; unknown if the map refers to one that it does not contain.
fn beside_value(on: &OnRoad<'_>, index: usize, side: usize) -> Option<MapLeftLane> {
    let own = on.lane(index)?;
    let Some(id) = [&own.left_neighbor, &own.right_neighbor][side] else { return Some(MapLeftLane::None) };
    let other = on.map.lane(id)?;
    let same = on.road.lanes[index].neighbors[side].is_some();
    Some(match (other.kind, same) {
        (LaneKind::Bike, _) => MapLeftLane::Bike,
        (LaneKind::Shoulder, _) => MapLeftLane::Shoulder,
        (LaneKind::Sidewalk | LaneKind::Other, _) => MapLeftLane::None,
        (_, false) => MapLeftLane::Opposite,
        (LaneKind::Bus, true) => MapLeftLane::Bus,
        (LaneKind::Vehicle, true) => MapLeftLane::Same,
    })
}

/// The limit here: the lane's own; a lane inside a junction has the limit of the lane before it.
fn limits(on: &OnRoad<'_>) -> Vec<Option<f64>> {
    let stated = |lane: usize| on.lane(lane).and_then(|l| l.speed_limit_mps);
    let mut before = None;
    (0..on.frames())
        .map(|i| {
            let lane = on.lanes.at(i)?.lane;
            let from = || {
                let shape = &on.road.lanes[lane];
                // A short lane that only joins two roads does, too.
                if !shape.in_junction && shape.center.length() > JOINT_M {
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

/// The next different limit along the way and its distance from the front bumper.
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
    table.number(id::MAP_SPEED_LIMIT, limits.iter().map(|l| l.unwrap_or(f64::NAN)).collect());
    let ahead =
        |i: usize, way: &Way, front| next(i, way, front).map(|n| n.0).or(limits[i]).unwrap_or(f64::NAN);
    table.number(id::MAP_SPEED_LIMIT_AHEAD, on.ahead(ahead));
    let distance = |i: usize, way: &Way, front| match limits[i] {
        None => f64::NAN,
        Some(_) => within_horizon(next(i, way, front).map_or(f64::INFINITY, |n| n.1)),
    };
    table.number(id::MAP_DISTANCE_TO_LIMIT_CHANGE, on.ahead(distance));
}

/// Whether both edges of the lane are marked, according to the map.
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

/// On a lane inside a junction with a marking on at least one edge.
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

/// Writes `map.lane_marked`: from the channel, else from the map.
pub fn write_marked(on: &OnRoad<'_>, channels: &Channels<'_>, table: &mut TableBuilder<'_>) {
    let stated = channels.values("lane_marks");
    let drawn = |i: usize| match stated[i] {
        Some("missing") => Tri::False,
        Some("normal" | "faded" | "wrong") => Tri::True,
        _ => on.own_lane(i).map_or(Tri::Unknown, marked),
    };
    table.flag(id::MAP_LANE_MARKED, on.flags(drawn));
}

/// Writes whether the ego's lane is one of those of `kind`; leaves it unavailable where the map does not tell them.
fn write_special(
    on: &OnRoad<'_>,
    table: &mut TableBuilder<'_>,
    (id, kind): (Signal<PerFrame, Flag>, &str),
    is_special: impl Fn(&Lane) -> bool,
) {
    if on.map.tells_all(kind) || on.map.lanes.iter().any(&is_special) {
        let own = |i: usize| on.own_lane(i).map_or(Tri::Unknown, |lane| Tri::from(is_special(lane)));
        table.flag(id, on.flags(own));
    }
}

/// Writes `map.bus_lane`, `tidal_lane`, `variable_lane`, `lane_kind`, `lane_turns`, `left_mark`, `right_mark`,
/// `left_lane`, `right_lane`, `on_guidance` and the limits.
pub fn write(on: &OnRoad<'_>, table: &mut TableBuilder<'_>) {
    write_limits(on, table);
    let frames = || 0..on.frames();
    write_special(on, table, (id::MAP_BUS_LANE, BUS_LANES), |lane| lane.kind == LaneKind::Bus);
    write_special(on, table, (id::MAP_TIDAL_LANE, "tidal"), |lane| lane.is_tagged("tidal"));
    write_special(on, table, (id::MAP_VARIABLE_LANE, "variable"), |lane| lane.is_tagged("variable"));
    table.category(id::MAP_LANE_KIND, frames().map(|i| on.own_lane(i).map(kind_value)));
    table.category(id::MAP_LEFT_MARK, frames().map(|i| on.own_lane(i).and_then(|l| mark_value(l.left_mark))));
    table.category(
        id::MAP_RIGHT_MARK,
        frames().map(|i| on.own_lane(i).and_then(|l| mark_value(l.right_mark))),
    );
    for (side, id) in [id::MAP_LEFT_LANE, id::MAP_RIGHT_LANE].into_iter().enumerate() {
        table.category(id, frames().map(|i| on.lanes.at(i).and_then(|at| beside_value(on, at.lane, side))));
    }
    let turns = |i: usize| {
        let (way, s) = on.ways.at(i)?;
        turns_ahead(on, way, s + on.ego.front(), HORIZON_M)
            .map_or(Some(MapLaneTurns::Any), |t| turns_value(&t))
    };
    table.category(id::MAP_LANE_TURNS, frames().map(turns));
    table.flag(id::MAP_ON_GUIDANCE, on.flags(|i| guided(on, i)));
}
