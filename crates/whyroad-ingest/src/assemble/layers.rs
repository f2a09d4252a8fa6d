//! Layers of a map: what an adapter declares, and what is derived from the geometry of the lanes where the source has
//! no data: connections, junctions, lanes beside each other, turn directions. What is derived is declared as such.

use crate::assemble::angles::wrap_angle;
use crate::assemble::geometry::{Bounds, distance, length};
use crate::assemble::{arms, junctions, neighbors};
use std::collections::BTreeSet;
use std::f64::consts::PI;
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Lane, LaneMark, LayerState, MapLayer, Point3, TurnKind};
use whyroad_model::vocabulary::{BUS_LANES, FACILITY_KINDS, LANE_TAGS, SIGN_KINDS};

/// A lane begins where another ends when they are this near, m, and point the same way within this, rad (30 deg).
const JOINT_M: f64 = 1.0;
const JOINT_RAD: f64 = PI / 6.0;
/// Connections are accepted when at least this share of lanes leads on: the others end at the map's border.
const CONNECTED_SHARE: f64 = 0.5;
/// Lanes that cross at more than this do so inside a junction, rad (15 deg), unless one of them is longer than this, m:
/// a bridge.
const CROSSING_RAD: f64 = PI / 12.0;
const CROSSING_LANE_M: f64 = 80.0;
/// Limits of the turn directions, rad: 45 and 135 deg.
const TURN_RAD: f64 = PI / 4.0;
const UTURN_RAD: f64 = 3.0 * PI / 4.0;

/// Declares layers; the adapter's other layers are inspected: a layer without an instance is absent, one with an
/// instance is partial.
pub(crate) fn declare(map: &mut RoadMap, stated: &[(MapLayer, LayerState)]) {
    for layer in MapLayer::ALL {
        let found = || if has_any(map, layer) { LayerState::Partial } else { LayerState::Absent };
        let state = stated.iter().find(|(of, _)| *of == layer).map_or_else(found, |(_, state)| *state);
        map.layers.insert(layer, state);
    }
}

/// What a map is declared to have in full: what it does not show is not on the road.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Declared {
    /// Layers.
    pub layers: Vec<MapLayer>,
    /// Kinds of signs and facilities, tags of lanes, bus lanes.
    pub kinds: BTreeSet<String>,
}

impl Declared {
    /// Layers that may be complete and empty, with the kinds that they consist of. A map without connections, limits
    /// or marks does not say that the road has none.
    const LAYERS: [(&str, MapLayer, &[&str]); 5] = [
        ("crosswalks", MapLayer::Crosswalks, &[]),
        ("junctions", MapLayer::Junctions, &[]),
        ("lights", MapLayer::Lights, &["traffic_light"]),
        ("ramps", MapLayer::Ramps, &["acceleration", "deceleration", "ramp"]),
        ("stop_lines", MapLayer::StopLines, &[]),
    ];

    /// Every word that [`Self::add`] knows.
    pub fn words() -> Vec<&'static str> {
        let layers = Self::LAYERS.iter().map(|(word, ..)| *word);
        layers
            .chain(SIGN_KINDS.iter().chain(FACILITY_KINDS).chain(LANE_TAGS).copied())
            .chain([BUS_LANES])
            .collect()
    }

    /// Adds the layer or kind of a word of [`Self::words`].
    pub fn add(&mut self, word: &str) {
        if let Some((_, layer, kinds)) = Self::LAYERS.iter().find(|(of, ..)| *of == word) {
            self.layers.push(*layer);
            self.kinds.extend(kinds.iter().map(|&kind| kind.to_owned()));
        } else {
            self.kinds.insert(word.to_owned());
        }
    }

    /// Declares it of a map.
    pub fn apply(&self, map: &mut RoadMap) {
        for kind in self.kinds.iter().filter(|kind| !map.tells_all(kind)).cloned().collect::<Vec<_>>() {
            map.complete_for.push(kind);
        }
        map.complete_for.sort();
        if map.layers.is_empty() {
            declare(map, &[]);
        }
        map.layers.extend(self.layers.iter().map(|&layer| (layer, LayerState::Complete)));
    }
}

fn has_any(map: &RoadMap, layer: MapLayer) -> bool {
    let lane = |holds: fn(&Lane) -> bool| map.lanes.iter().any(holds);
    match layer {
        MapLayer::Connections => lane(|l| !l.successors.is_empty()),
        MapLayer::Junctions => !map.junctions.is_empty() || lane(|l| l.in_junction),
        MapLayer::Neighbors => lane(|l| l.left_neighbor.is_some() || l.right_neighbor.is_some()),
        MapLayer::Crosswalks => !map.crosswalks.is_empty(),
        MapLayer::StopLines => !map.stop_lines.is_empty(),
        MapLayer::Lights => map.covers("traffic_light"),
        MapLayer::SpeedLimits => lane(|l| l.speed_limit_mps.is_some()),
        MapLayer::Marks => lane(|l| l.left_mark != LaneMark::Unknown || l.right_mark != LaneMark::Unknown),
        // A constant height is a placeholder.
        MapLayer::Heights => {
            let mut heights = map.lanes.iter().flat_map(|l| &l.center).map(|p| p.z).filter(|z| !z.is_nan());
            heights.next().is_some_and(|first| heights.any(|z| z != first))
        }
        MapLayer::Ramps => {
            let tags = ["ramp", "acceleration", "deceleration"];
            map.lanes.iter().any(|l| tags.iter().any(|t| l.is_tagged(t)))
                || tags.iter().any(|t| map.tells_all(t))
        }
    }
}

/// Derives what is absent; only lanes for vehicles, buses and bicycles take part.
pub(crate) fn derive_absent(map: &mut RoadMap) {
    if map.layers.get(&MapLayer::Connections) == Some(&LayerState::Absent) && connect(map) {
        map.layers.insert(MapLayer::Connections, LayerState::Derived);
    }
    if map.layers.get(&MapLayer::Junctions) == Some(&LayerState::Absent)
        && map.has(MapLayer::Connections)
        && !map.lanes.is_empty()
    {
        mark_junctions(map);
        map.layers.insert(MapLayer::Junctions, LayerState::Derived);
    }
    if map.layers.get(&MapLayer::Neighbors) == Some(&LayerState::Absent) && neighbors::derive(map) {
        map.layers.insert(MapLayer::Neighbors, LayerState::Derived);
    }
    for lane in map.lanes.iter_mut().filter(|l| l.in_junction && l.turn.is_none() && l.kind.is_driven_on()) {
        lane.turn = turn(&lane.center);
    }
}

/// Direction of the first (`at_end` false) or last meter of a line, rad.
fn heading(line: &[Point3], at_end: bool) -> Option<f64> {
    let order: Box<dyn Iterator<Item = &Point3>> =
        if at_end { Box::new(line.iter().rev()) } else { Box::new(line.iter()) };
    let mut order = order;
    let first = order.next()?;
    let other =
        order.find(|p| distance(**p, *first) >= 1.0).or(if at_end { line.first() } else { line.last() })?;
    let (a, b) = if at_end { (other, first) } else { (first, other) };
    (distance(*a, *b) > 0.0).then(|| (b.y - a.y).atan2(b.x - a.x))
}

/// Joins lanes where one begins at the end of another; false, and nothing is changed, when too few join.
fn connect(map: &mut RoadMap) -> bool {
    let ends: Vec<Option<(Point3, f64, Point3, f64)>> = map
        .lanes
        .iter()
        .map(|l| {
            let c = &l.center;
            l.kind
                .is_driven_on()
                .then(|| Some((*c.first()?, heading(c, false)?, *c.last()?, heading(c, true)?)))?
        })
        .collect();
    let mut joints = Vec::new();
    for (i, from) in ends.iter().enumerate() {
        let Some((_, _, end, out)) = from else { continue };
        for (j, to) in ends.iter().enumerate() {
            let Some((start, into, _, _)) = to else { continue };
            let level = (end.z - start.z).abs();
            if i != j
                && distance(*end, *start) <= JOINT_M
                && wrap_angle(out - into).abs() <= JOINT_RAD
                && (level.is_nan() || level <= 2.0)
            {
                joints.push((i, j));
            }
        }
    }
    let leading = joints.iter().map(|(i, _)| i).collect::<BTreeSet<_>>().len();
    let all = ends.iter().flatten().count();
    if all == 0 || (leading as f64) < CONNECTED_SHARE * all as f64 {
        return false;
    }
    for (i, j) in joints {
        let (from, to) = (map.lanes[i].id.clone(), map.lanes[j].id.clone());
        map.lanes[i].successors.push(to);
        map.lanes[j].predecessors.push(from);
    }
    // A lane without a successor leaves the map: it does not end on the road.
    for (i, end) in ends.iter().enumerate() {
        if end.is_some() && map.lanes[i].successors.is_empty() {
            let beyond = format!("beyond:{}", map.lanes[i].id);
            map.lanes[i].successors.push(beyond);
        }
    }
    true
}

/// Where two lines cross inside both, the angle between them there, rad.
pub(crate) fn crossing(a: &[Point3], b: &[Point3]) -> Option<f64> {
    for p in a.windows(2) {
        for q in b.windows(2) {
            let (px, py) = (p[1].x - p[0].x, p[1].y - p[0].y);
            let (qx, qy) = (q[1].x - q[0].x, q[1].y - q[0].y);
            let cross = px * qy - py * qx;
            if cross == 0.0 {
                continue;
            }
            let (dx, dy) = (q[0].x - p[0].x, q[0].y - p[0].y);
            let (s, t) = ((dx * qy - dy * qx) / cross, (dx * py - dy * px) / cross);
            if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
                let angle = wrap_angle(py.atan2(px) - qy.atan2(qx)).abs();
                return Some(angle.min(PI - angle));
            }
        }
    }
    None
}

/// Marks lanes that cross others, with those that begin or end together with them, as inside junctions, and those where
/// arms meet without a crossing.
fn mark_junctions(map: &mut RoadMap) {
    let n = map.lanes.len();
    let bounds: Vec<Bounds> = map.lanes.iter().map(|l| Bounds::of(&l.center)).collect();
    let may: Vec<bool> =
        map.lanes.iter().map(|l| l.kind.is_driven_on() && length(&l.center) <= CROSSING_LANE_M).collect();
    let mut inside = vec![false; n];
    for i in (0..n).filter(|&i| may[i]) {
        for j in (0..i).filter(|&j| may[j]) {
            let apart = bounds[i].are_apart(&bounds[j], 0.0);
            let (one, other) = (&map.lanes[i], &map.lanes[j]);
            let meet = [&one.successors, &one.predecessors]
                .into_iter()
                .zip([&other.successors, &other.predecessors])
                .any(|(x, y)| x.iter().any(|id| y.contains(id)));
            let in_line = one.successors.contains(&other.id) || other.successors.contains(&one.id);
            if apart || meet || in_line || (inside[i] && inside[j]) {
                continue;
            }
            if crossing(&one.center, &other.center).is_some_and(|angle| angle > CROSSING_RAD) {
                (inside[i], inside[j]) = (true, true);
            }
        }
    }
    // A right turn crosses nothing, but begins or ends with a lane that does.
    let crossing: Vec<usize> = (0..n).filter(|&i| inside[i]).collect();
    for i in (0..n).filter(|&i| may[i]) {
        let lane = &map.lanes[i];
        let together = |k: &usize| {
            let other = &map.lanes[*k];
            lane.predecessors.iter().any(|id| other.predecessors.contains(id))
                || lane.successors.iter().any(|id| other.successors.contains(id))
        };
        inside[i] |= crossing.iter().any(together);
    }
    arms::inside(map, &may).into_iter().for_each(|i| inside[i] = true);
    for (lane, inside) in map.lanes.iter_mut().zip(inside) {
        lane.in_junction = inside;
    }
    junctions::add(map);
}

/// The turn that a lane makes, by the heading integrated along it.
pub(crate) fn turn(center: &[Point3]) -> Option<TurnKind> {
    let headings: Vec<f64> = center
        .windows(2)
        .filter(|w| distance(w[0], w[1]) > 1e-3)
        .map(|w| (w[1].y - w[0].y).atan2(w[1].x - w[0].x))
        .collect();
    if headings.is_empty() {
        return None;
    }
    let turned: f64 = headings.windows(2).map(|h| wrap_angle(h[1] - h[0])).sum();
    Some(match turned {
        _ if turned.abs() > UTURN_RAD => TurnKind::Uturn,
        _ if turned > TURN_RAD => TurnKind::Left,
        _ if turned < -TURN_RAD => TurnKind::Right,
        _ => TurnKind::Straight,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(id: &str, points: &[(f64, f64)]) -> Lane {
        let center = points.iter().map(|&(x, y)| Point3 { x, y, z: 0.0 }).collect();
        Lane { id: id.into(), center, ..Lane::default() }
    }

    /// Two roads that cross, each with one lane, and a right turn from one into the other; no links.
    fn crossroads() -> RoadMap {
        let lanes = vec![
            line("a_in", &[(-100.0, 0.0), (-10.0, 0.0)]),
            line("a_out", &[(10.0, 0.0), (100.0, 0.0)]),
            line("a_over", &[(-10.0, 0.0), (10.0, 0.0)]),
            line("b_in", &[(0.0, 100.0), (0.0, 10.0)]),
            line("b_out", &[(0.0, -10.0), (0.0, -100.0)]),
            line("b_over", &[(0.0, 10.0), (0.0, -10.0)]),
            line("right", &[(-10.0, 0.0), (-6.0, -0.6), (-2.5, -2.5), (-0.6, -6.0), (0.0, -10.0)]),
        ];
        RoadMap { lanes, ..RoadMap::default() }
    }

    #[test]
    fn connections_junctions_and_turns_follow_from_the_lanes() {
        let mut map = crossroads();
        declare(&mut map, &[]);
        assert_eq!(map.layer(MapLayer::Connections), LayerState::Absent);
        derive_absent(&mut map);
        assert_eq!(map.layer(MapLayer::Connections), LayerState::Derived);
        assert_eq!(map.layer(MapLayer::Junctions), LayerState::Derived);
        assert_eq!(map.lane("a_in").unwrap().successors, ["a_over", "right"]);
        assert_eq!(map.lane("b_out").unwrap().predecessors, ["b_over", "right"]);
        let inside: Vec<&str> = map.lanes.iter().filter(|l| l.in_junction).map(|l| l.id.as_str()).collect();
        assert_eq!(inside, ["a_over", "b_over", "right"]);
        assert_eq!(map.junctions.len(), 1);
        assert_eq!(map.lane("right").unwrap().turn, Some(TurnKind::Right));
        assert_eq!(map.lane("a_over").unwrap().turn, Some(TurnKind::Straight));
        assert_eq!(map.lane("a_in").unwrap().turn, None);
        assert_eq!(
            map.lane("a_out").unwrap().successors,
            ["beyond:a_out"],
            "the border of the map is not a dead end"
        );
        // The input has no data for these layers.
        for layer in [MapLayer::Crosswalks, MapLayer::StopLines, MapLayer::SpeedLimits, MapLayer::Ramps] {
            assert!(!map.has(layer), "{layer:?}");
        }
    }

    #[test]
    fn lanes_that_do_not_join_stay_unconnected() {
        let mut map = crossroads();
        // Every lane is cut 3 m short: where one ends, none begins.
        map.lanes.iter_mut().for_each(|l| l.center[0].x += 3.0);
        declare(&mut map, &[]);
        derive_absent(&mut map);
        assert_eq!(map.layer(MapLayer::Connections), LayerState::Absent);
        assert_eq!(map.layer(MapLayer::Junctions), LayerState::Absent);
        assert!(map.lanes.iter().all(|l| l.successors.is_empty()));
    }

    #[test]
    fn what_the_source_states_is_not_derived() {
        let mut map = crossroads();
        map.lanes[0].successors.push("a_over".into());
        declare(&mut map, &[(MapLayer::Junctions, LayerState::Complete)]);
        derive_absent(&mut map);
        assert_eq!(map.layer(MapLayer::Connections), LayerState::Partial);
        assert_eq!(map.layer(MapLayer::Junctions), LayerState::Complete);
        assert_eq!(map.lane("b_in").unwrap().successors, Vec::<String>::new());
    }
}
