//! Roads that merge or part, and which lanes of a network are ramps: OpenStreetMap's word for them is an edge type that
//! ends in `_link`; a network that was drawn has none, but marks the lanes on which traffic from a ramp gains speed
//! (`acceleration="1"`).

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::FRAC_PI_3;
use whyroad_model::road_map::{Lane, LaneKind, Point3};

/// Roads whose directions at a node differ by less than this run together there, rad: 60 deg.
const TOGETHER_RAD: f64 = FRAC_PI_3;

/// Direction from one point to another, rad.
fn heading(a: Point3, b: Point3) -> f64 {
    (b.y - a.y).atan2(b.x - a.x)
}

/// The roads at a node: whence, whither, and their directions there (rad).
#[derive(Default)]
pub(super) struct Flows<'e> {
    from: BTreeSet<&'e str>,
    to: BTreeSet<&'e str>,
    headings: Vec<f64>,
}

impl<'e> Flows<'e> {
    /// A road that begins here and leads to node `to`.
    pub fn leaves(&mut self, to: &'e str, lane: &Lane) {
        self.to.insert(to);
        self.headings.extend(lane.centre.windows(2).next().map(|w| heading(w[0], w[1])));
    }

    /// A road that comes from node `from` and ends here.
    pub fn comes(&mut self, from: &'e str, lane: &Lane) {
        self.from.insert(from);
        self.headings.extend(lane.centre.windows(2).last().map(|w| heading(w[0], w[1])));
    }

    /// True where one-way roads merge or part: none leads back where one comes from, one side is a single road, and all
    /// of them go one way.
    pub fn run_together(&self) -> bool {
        let apart = |a: f64, b: f64| crate::assemble::angles::wrap_angle(a - b).abs();
        self.from.is_disjoint(&self.to)
            && (self.from.len() == 1 || self.to.len() == 1)
            && self.headings.iter().all(|&a| self.headings.iter().all(|&b| apart(a, b) < TOGETHER_RAD))
    }
}

/// True for the type of a ramp's edge: `highway.motorway_link`.
pub(super) fn is_link_type(edge_type: &str) -> bool {
    edge_type.split('|').any(|t| t.ends_with("_link"))
}

/// Tags the lanes of edges that lead into nothing but acceleration lanes, and the junction lanes on the way, as ramps.
/// `edges` are the lanes of each edge that is not inside a junction.
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
    for id in ramps {
        if let Some(l) = lanes.get_mut(&id)
            && !l.is_tagged("ramp")
        {
            l.tags.push("ramp".to_owned());
        }
    }
}

/// An edge outside junctions.
pub(super) struct Branch<'e> {
    pub from: &'e str,
    pub to: &'e str,
    pub lanes: &'e [String],
}

/// Speed limit from which on a road is one that has ramps, m/s: 70 km/h.
const RAMP_ROAD_MPS: f64 = 19.4;
/// A side road is this much slower than the main road, m/s, or has fewer lanes.
const SLOWER_MPS: f64 = 2.0;

/// Tags exits and entries of networks that name no ramps: where a fast one-way road parts into two that go the same way
/// (or two merge into one), the slower one, or the one with fewer lanes, is a ramp, with what leads on from it alone
/// (or to it alone).
pub(super) fn tag_branches(edges: &[Branch<'_>], lanes: &mut BTreeMap<String, Lane>) {
    let mut leaving = BTreeMap::<&str, Vec<&Branch<'_>>>::new();
    let mut coming = BTreeMap::<&str, Vec<&Branch<'_>>>::new();
    for edge in edges {
        leaving.entry(edge.from).or_default().push(edge);
        coming.entry(edge.to).or_default().push(edge);
    }
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
    let empty = Vec::new();
    let nodes: BTreeSet<&str> = leaving.keys().chain(coming.keys()).copied().collect();
    for node in nodes {
        let (into, out) = (coming.get(node).unwrap_or(&empty), leaving.get(node).unwrap_or(&empty));
        let (one, two, parts) = match (&into[..], &out[..]) {
            ([one], [a, b]) => (*one, (*a, *b), true),
            ([a, b], [one]) => (*one, (*a, *b), false),
            _ => continue,
        };
        let mut flows = Flows::default();
        for e in into {
            e.lanes.first().and_then(|id| lanes.get(id)).into_iter().for_each(|l| flows.comes(e.from, l));
        }
        for e in out {
            e.lanes.first().and_then(|id| lanes.get(id)).into_iter().for_each(|l| flows.leaves(e.to, l));
        }
        if !flows.run_together() || speed(one) < RAMP_ROAD_MPS {
            continue;
        }
        let Some(first_is_less) = lesser(two.0, two.1) else { continue };
        let mut edge: &Branch<'_> = if first_is_less { two.0 } else { two.1 };
        // On along the ramp while it is the only way.
        for _ in 0..32 {
            ramps.extend(edge.lanes.iter().map(String::as_str));
            let at = if parts { edge.to } else { edge.from };
            let (into, out) = (coming.get(at).unwrap_or(&empty), leaving.get(at).unwrap_or(&empty));
            edge = match (&into[..], &out[..]) {
                ([_], [next]) if parts => *next,
                ([before], [_]) if !parts => *before,
                _ => break,
            };
        }
    }
    let ramps: Vec<String> = ramps.into_iter().map(str::to_owned).collect();
    for id in ramps {
        if let Some(lane) = lanes.get_mut(&id).filter(|l| !l.is_tagged("ramp")) {
            lane.tags.push("ramp".to_owned());
        }
    }
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
    for id in joints {
        if let Some(l) = lanes.get_mut(&id) {
            l.tags.push("ramp".to_owned());
        }
    }
}
