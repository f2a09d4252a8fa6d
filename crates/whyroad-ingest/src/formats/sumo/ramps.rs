//! Roads that merge or part, and which lanes of a network are ramps: OpenStreetMap's word for them is an edge type that
//! ends in `_link`; a network that was drawn has none, but marks the lanes on which traffic from a ramp gains speed
//! (`acceleration="1"`).

use crate::assemble::layers::crossing;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{FRAC_PI_3, PI};
use whyroad_model::road_map::{Lane, LaneKind, Point3};

/// Roads whose directions at a node differ by less than this run together there, rad: 60 deg.
const TOGETHER_RAD: f64 = FRAC_PI_3;

/// Direction from one point to another, rad.
fn heading(a: Point3, b: Point3) -> f64 {
    (b.y - a.y).atan2(b.x - a.x)
}

/// An edge outside junctions.
#[derive(Clone, Copy)]
pub(super) struct Branch<'e> {
    pub id: &'e str,
    pub from: &'e str,
    pub to: &'e str,
    pub lanes: &'e [String],
}

/// Edges at a node that its connections join; edges of one node without a connection between them meet apart, such as
/// the two carriageways of a road. Turning back is not a connection.
pub(super) struct Meeting<'e> {
    /// Edges that end at the node.
    pub ins: Vec<Branch<'e>>,
    /// Edges that begin there.
    pub outs: Vec<Branch<'e>>,
}

/// The meetings of every node. `movements` are the pairs of edges that a connection joins.
pub(super) fn meetings<'e>(
    edges: &[Branch<'e>],
    movements: &BTreeSet<(&str, &str)>,
) -> BTreeMap<&'e str, Vec<Meeting<'e>>> {
    let mut at = BTreeMap::<&str, Meeting<'e>>::new();
    for edge in edges {
        let empty = || Meeting { ins: Vec::new(), outs: Vec::new() };
        at.entry(edge.to).or_insert_with(empty).ins.push(*edge);
        at.entry(edge.from).or_insert_with(empty).outs.push(*edge);
    }
    let joined = |a: &Branch<'_>, b: &Branch<'_>| a.from != b.to && movements.contains(&(a.id, b.id));
    at.into_iter()
        .map(|(node, mut all)| {
            let mut found = Vec::new();
            while let Some(first) = all.ins.pop() {
                let mut one = Meeting { ins: vec![first], outs: Vec::new() };
                loop {
                    let (new, rest): (Vec<_>, Vec<_>) =
                        all.outs.iter().copied().partition(|o| one.ins.iter().any(|i| joined(i, o)));
                    all.outs = rest;
                    one.outs.extend(new);
                    let (new, rest): (Vec<_>, Vec<_>) =
                        all.ins.iter().copied().partition(|i| one.outs.iter().any(|o| joined(i, o)));
                    all.ins = rest;
                    if new.is_empty() {
                        break;
                    }
                    one.ins.extend(new);
                }
                found.push(one);
            }
            found.extend(all.outs.into_iter().map(|o| Meeting { ins: Vec::new(), outs: vec![o] }));
            (node, found)
        })
        .collect()
}

impl Meeting<'_> {
    /// Directions of the roads at the node, rad.
    fn headings(&self, lanes: &BTreeMap<String, Lane>) -> Vec<f64> {
        let lane = |e: &Branch<'_>| e.lanes.first().and_then(|id| lanes.get(id));
        let ends = self.ins.iter().filter_map(lane).filter_map(|l| l.center.windows(2).last());
        let begins = self.outs.iter().filter_map(lane).filter_map(|l| l.center.windows(2).next());
        ends.chain(begins).map(|w| heading(w[0], w[1])).collect()
    }

    /// True where one-way roads merge or part: none leads back where one comes from, one side is a single road, and all
    /// of them go one way.
    pub fn runs_together(&self, lanes: &BTreeMap<String, Lane>) -> bool {
        let from: BTreeSet<&str> = self.ins.iter().map(|e| e.from).collect();
        let to: BTreeSet<&str> = self.outs.iter().map(|e| e.to).collect();
        let headings = self.headings(lanes);
        from.is_disjoint(&to)
            && (from.len() == 1 || to.len() == 1)
            && headings.iter().all(|&a| headings.iter().all(|&b| apart(a, b) < TOGETHER_RAD))
    }

    /// The ways through the node, from the end of each road that ends there to the beginning of each that begins.
    fn ways(&self, lanes: &BTreeMap<String, Lane>) -> Vec<[Point3; 2]> {
        let all = |roads: &[Branch<'_>]| -> Vec<&Lane> {
            roads.iter().flat_map(|e| e.lanes.iter()).filter_map(|id| lanes.get(id)).collect()
        };
        let (ins, outs) = (all(&self.ins), all(&self.outs));
        let ends = ins.iter().filter_map(|l| l.center.last());
        ends.flat_map(|end| outs.iter().filter_map(|l| Some([*end, *l.center.first()?]))).collect()
    }

    /// True where the roads of `other` go in the opposite direction and pass these without crossing them; the two
    /// carriageways of a diverging diamond interchange cross.
    pub fn passes(&self, other: &Meeting<'_>, lanes: &BTreeMap<String, Lane>) -> bool {
        let theirs = other.headings(lanes);
        let ways = other.ways(lanes);
        self.headings(lanes).iter().all(|&a| theirs.iter().all(|&b| apart(a, b) > PI - TOGETHER_RAD))
            && !self.ways(lanes).iter().any(|a| ways.iter().any(|b| crossing(a, b).is_some()))
    }
}

fn apart(a: f64, b: f64) -> f64 {
    crate::assemble::angles::wrap_angle(a - b).abs()
}

/// True for the type of a ramp's edge: `highway.motorway_link`.
pub(super) fn is_link_type(edge_type: &str) -> bool {
    edge_type.split('|').any(|t| t.ends_with("_link"))
}

/// Tags the lanes of edges that lead into nothing but acceleration lanes, and the junction lanes on the way, as ramps.
/// `edges` are the lanes of each edge outside junctions that may be a ramp.
pub(super) fn tag_feeders(edges: &[&Vec<String>], lanes: &mut BTreeMap<String, Lane>) {
    let fast = |id: &String| lanes.get(id).is_some_and(|l| l.is_tagged("acceleration"));
    let mut ramps: BTreeSet<String> = BTreeSet::new();
    for edge in edges {
        let mut inside: Vec<String> = Vec::new();
        let mut ends: Vec<String> = Vec::new();
        for next in edge.iter().filter_map(|id| lanes.get(id)).flat_map(|l| &l.successors) {
            // A junction's lane leads on; its end is what counts.
            match lanes.get(next) {
                Some(l) if next.starts_with(':') => {
                    inside.push(next.clone());
                    ends.extend(l.successors.iter().cloned());
                }
                _ => ends.push(next.clone()),
            }
        }
        let own_is_fast = edge.iter().any(&fast);
        if !own_is_fast && !ends.is_empty() && ends.iter().all(&fast) {
            ramps.extend(edge.iter().cloned());
            ramps.extend(inside);
        }
    }
    tag(ramps, lanes);
}

/// Tags lanes as ramps.
fn tag(ids: impl IntoIterator<Item = String>, lanes: &mut BTreeMap<String, Lane>) {
    for id in ids {
        if let Some(lane) = lanes.get_mut(&id).filter(|l| !l.is_tagged("ramp")) {
            lane.tags.push("ramp".to_owned());
        }
    }
}

/// Roads from this speed limit up have ramps, m/s: 70 km/h.
const RAMP_ROAD_MPS: f64 = 19.4;
/// A side road is this much slower than the main road, m/s, or has fewer lanes.
const SLOWER_MPS: f64 = 2.0;

/// Tags exits and entries of networks that name no ramps: where a fast road parts into two that go the same way (or two
/// merge into one), the slower one, or the one with fewer lanes, is a ramp, with what leads on from it alone (or to it
/// alone). A road that can also be driven the other way is not a ramp.
pub(super) fn tag_branches(meetings: &BTreeMap<&str, Vec<Meeting<'_>>>, lanes: &mut BTreeMap<String, Lane>) {
    let all = || meetings.values().flatten();
    let ends: BTreeSet<(&str, &str)> = all().flat_map(|m| &m.outs).map(|e| (e.from, e.to)).collect();
    let two_way = |e: &Branch<'_>| ends.contains(&(e.to, e.from));
    // Pairs of roads of which one leads into the other alone.
    let pairs = || {
        all().filter_map(|m| match (&m.ins[..], &m.outs[..]) {
            ([before], [next]) => Some((*before, *next)),
            _ => None,
        })
    };
    let onward: BTreeMap<&str, Branch<'_>> = pairs().map(|(before, next)| (before.id, next)).collect();
    let back: BTreeMap<&str, Branch<'_>> = pairs().map(|(before, next)| (next.id, before)).collect();
    let rolling = |e: &Branch<'_>| {
        let of = |id: &&String| lanes.get(*id).is_some_and(|l| l.kind == LaneKind::Vehicle);
        e.lanes.iter().filter(of).count()
    };
    let speed =
        |e: &Branch<'_>| e.lanes.iter().filter_map(|id| lanes.get(id)?.speed_limit_mps).fold(0.0, f64::max);
    // The lesser of two roads, if one is.
    let lesser = |a: &'_ Branch<'_>, b: &'_ Branch<'_>| -> Option<bool> {
        let (va, vb, na, nb) = (speed(a), speed(b), rolling(a), rolling(b));
        if (va - vb).abs() > SLOWER_MPS {
            return Some(va < vb);
        }
        (na != nb).then_some(na < nb)
    };
    let mut ramps: BTreeSet<&str> = BTreeSet::new();
    for meeting in all() {
        let (one, two, parts) = match (&meeting.ins[..], &meeting.outs[..]) {
            ([one], [a, b]) => (one, (a, b), true),
            ([a, b], [one]) => (one, (a, b), false),
            _ => continue,
        };
        if !meeting.runs_together(lanes) || speed(one) < RAMP_ROAD_MPS {
            continue;
        }
        let Some(first_is_less) = lesser(two.0, two.1) else { continue };
        let mut edge = if first_is_less { *two.0 } else { *two.1 };
        // On along the ramp while it is the only way.
        for _ in 0..32 {
            if two_way(&edge) {
                break;
            }
            ramps.extend(edge.lanes.iter().map(String::as_str));
            let further = if parts { onward.get(edge.id) } else { back.get(edge.id) };
            edge = match further {
                Some(further) => *further,
                None => break,
            };
        }
    }
    tag(ramps.into_iter().map(str::to_owned), lanes);
}

/// Tags the pieces of lane inside a node that lie between ramps and nothing else: a node may cut a ramp in two, and the
/// piece in it has no type of its own. A vehicle on it has not been on the main road in between.
pub(super) fn tag_joints(lanes: &mut BTreeMap<String, Lane>) {
    let is_ramp = |id: &String| lanes.get(id).is_some_and(|l| l.is_tagged("ramp"));
    let between = |l: &Lane| {
        let ends = || l.predecessors.iter().chain(&l.successors);
        !l.predecessors.is_empty() && !l.successors.is_empty() && ends().all(is_ramp)
    };
    let joints: Vec<String> = lanes
        .iter()
        .filter(|(id, l)| id.starts_with(':') && !l.in_junction && !l.is_tagged("ramp") && between(l))
        .map(|(id, _)| id.clone())
        .collect();
    tag(joints, lanes);
}
