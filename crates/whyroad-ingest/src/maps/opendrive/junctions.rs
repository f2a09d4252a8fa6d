//! Which junctions of the file are junctions: OpenDRIVE also calls places so at which one-way roads only merge or part,
//! or at which a road goes on with another number of lanes. Those are left out, as SUMO's are.

use super::document::Document;
use super::lanes::LaneKey;
use crate::assemble::angles::wrap_angle;
use crate::assemble::geometry::{between, distance, union_outlines};
use crate::assemble::layers;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::f64::consts::{FRAC_PI_3, FRAC_PI_4, PI};
use whyroad_model::road_map::{Area, Lane, Point3};

/// Roads whose directions at a junction differ by less than this run together there, rad: 60 deg.
const TOGETHER_RAD: f64 = FRAC_PI_3;
/// A road that ends at a junction and one that begins there are the two sides of one street when they run against each
/// other and are this near, m.
const STREET_M: f64 = 25.0;

/// Where a road meets a junction.
struct Arm {
    road: usize,
    point: Point3,
    /// Driving direction there, rad.
    heading: f64,
    /// Traffic comes to the junction here.
    comes: bool,
}

/// Marks the lanes inside junctions and those that lead there; gives the areas.
pub(super) fn mark(document: &Document, lanes: &mut BTreeMap<LaneKey, Lane>) -> Vec<Area> {
    let by_id: HashMap<String, LaneKey> = lanes.iter().map(|(key, l)| (l.id.clone(), *key)).collect();
    let mut inside: BTreeMap<&str, Vec<LaneKey>> = BTreeMap::new();
    for (key, lane) in lanes.iter_mut() {
        if let Some(junction) = document.roads[key.road].junction.as_deref()
            && lane.kind.is_driven_on()
        {
            // Also where a street only turns back at its end, which is not a junction.
            lane.turn = layers::turn(&lane.center);
            inside.entry(junction).or_default().push(*key);
        }
    }
    let real: Vec<(&str, Vec<LaneKey>)> =
        inside.into_iter().filter(|(_, keys)| is_junction(document, keys, lanes, &by_id)).collect();
    let mut areas = Vec::new();
    for (id, keys) in real {
        let shapes: Vec<Vec<Point3>> =
            keys.iter().map(|k| between(&lanes[k].left, &lanes[k].right)).collect();
        let outlines = union_outlines(&shapes);
        let size =
            |o: &Vec<Point3>| o.windows(2).map(|w| w[0].x * w[1].y - w[1].x * w[0].y).sum::<f64>().abs();
        let largest = outlines.into_iter().max_by(|a, b| size(a).total_cmp(&size(b)));
        areas.extend(largest.map(|boundary| Area { id: id.to_owned(), boundary }));
        let before: BTreeSet<LaneKey> =
            keys.iter().flat_map(|k| &lanes[k].predecessors).filter_map(|p| by_id.get(p).copied()).collect();
        for key in before {
            lanes.entry(key).and_modify(|l| l.junction_id = Some(id.to_owned()));
        }
        for key in keys {
            lanes.entry(key).and_modify(|l| (l.in_junction, l.junction_id) = (true, Some(id.to_owned())));
        }
    }
    areas.sort_by(|a, b| a.id.cmp(&b.id));
    areas
}

/// Driving direction at the first or last point of a lane.
fn heading(lane: &Lane, last: bool) -> Option<f64> {
    let mut steps = lane.center.windows(2).filter(|w| distance(w[0], w[1]) > 1e-6);
    let w = if last { steps.next_back()? } else { steps.next()? };
    Some((w[1].y - w[0].y).atan2(w[1].x - w[0].x))
}

/// True where three or more streets meet that do not only merge or part.
fn is_junction(
    document: &Document,
    keys: &[LaneKey],
    lanes: &BTreeMap<LaneKey, Lane>,
    by_id: &HashMap<String, LaneKey>,
) -> bool {
    let mut arms: Vec<Arm> = Vec::new();
    let own: BTreeSet<usize> = keys.iter().map(|k| k.road).collect();
    for key in keys {
        let lane = &lanes[key];
        for (ids, comes) in [(&lane.predecessors, true), (&lane.successors, false)] {
            for other in ids.iter().filter_map(|id| by_id.get(id)).filter(|k| !own.contains(&k.road)) {
                let there = &lanes[other];
                let point = if comes { there.center.last() } else { there.center.first() };
                let seen = arms.iter().any(|a| a.road == other.road && a.comes == comes);
                if let (Some(&point), Some(heading), false) = (point, heading(there, comes), seen) {
                    arms.push(Arm { road: other.road, point, heading, comes });
                }
            }
        }
    }
    // Streets: roads that are one, and pairs that run against each other.
    let mut street: Vec<usize> = (0..arms.len()).collect();
    for i in 0..arms.len() {
        for j in 0..i {
            let (a, b) = (&arms[i], &arms[j]);
            let against = (wrap_angle(a.heading - b.heading).abs() - PI).abs() < FRAC_PI_4;
            let beside = a.comes != b.comes && against && distance(a.point, b.point) <= STREET_M;
            if a.road == b.road || beside {
                let (from, to) = (street[i], street[j]);
                street.iter_mut().filter(|s| **s == from).for_each(|s| *s = to);
            }
        }
    }
    let of = |comes: bool| -> BTreeSet<usize> {
        (0..arms.len()).filter(|&i| arms[i].comes == comes).map(|i| street[i]).collect()
    };
    let (from, to) = (of(true), of(false));
    let apart = |a: &Arm, b: &Arm| wrap_angle(a.heading - b.heading).abs();
    let together = from.is_disjoint(&to)
        && (from.len() == 1 || to.len() == 1)
        && arms.iter().all(|a| arms.iter().all(|b| apart(a, b) < TOGETHER_RAD));
    let named = keys.first().and_then(|k| document.roads[k.road].junction.as_deref());
    named.is_some() && from.union(&to).count() >= 3 && !together
}
