//! Lanelets: a left and a right bound each. Which lanelets follow or lie beside each other is not written in the file:
//! those that share the end points of their bounds follow, those that share a bound lie beside each other. A bound is
//! one way by the format; editors split ways, and pieces that meet end to end are taken for one bound.

use super::document::{Document, MemberKind, Relation, Tags, append};
use super::ground::{Ground, MAX_POINTS};
use crate::assemble::geometry::{between, center_line, edges_oppose};
use crate::maps::{MapReading, signs};
use std::collections::{BTreeMap, HashMap, HashSet};
use whyroad_model::road_map::{Area, Lane, LaneKind, LaneMark, Point3, TurnKind};

/// Most ways of a bound.
pub(super) const MAX_PIECES: usize = 1000;

/// A lanelet as it is driven: those for both directions occur twice.
pub(super) struct Lanelet {
    pub relation: i64,
    pub lane: Lane,
    /// Ways of the left and right bound.
    bounds: [Vec<i64>; 2],
    /// First and last nodes of the left and right bound, in driving direction.
    begin: [i64; 2],
    end: [i64; 2],
}

/// All lanelets that are lanes.
#[derive(Default)]
pub(super) struct Lanelets(Vec<Lanelet>);

impl Lanelets {
    pub fn of(document: &Document, ground: &mut Ground, out: &mut MapReading) -> Self {
        let mut all = Vec::new();
        for (id, relation) in document.relations.iter().filter(|(_, r)| r.tag("type") == "lanelet") {
            out.count.read += 1;
            match bounds(document, ground, relation) {
                Err(reason) => {
                    out.count.drop_rows("invalid", 1);
                    out.invalid.push(format!("lanelet {id}: {reason}"));
                }
                Ok(b) if relation.tag("subtype") == "crosswalk" => {
                    out.count.keep("crosswalk", 1);
                    out.map
                        .crosswalks
                        .push(Area { id: id.to_string(), boundary: between(&b.left, &b.right) });
                }
                Ok(b) => match kind_or_road(relation) {
                    None => out.count.set_aside("not_a_road_user_lane", 1),
                    Some((kind, is_stated)) => {
                        out.count.keep("lane", 1);
                        if !is_stated {
                            out.untyped.push(id.to_string());
                        }
                        let both = relation.tag("one_way") == "no" && kind != LaneKind::Sidewalk;
                        let back = both.then(|| {
                            lanelet(*id, &format!("{id}:back"), relation, kind, b.reversed(), document)
                        });
                        all.push(lanelet(*id, &id.to_string(), relation, kind, b, document));
                        all.extend(back);
                    }
                },
            }
        }
        link(&mut all);
        Self(all)
    }

    pub fn lanes(&self) -> Vec<Lane> {
        self.0.iter().map(|l| l.lane.clone()).collect()
    }

    /// Ids of the lanes of lanelets, by the ids of their relations.
    pub fn by_relation(&self) -> HashMap<i64, Vec<String>> {
        let mut out: HashMap<i64, Vec<String>> = HashMap::new();
        for l in &self.0 {
            out.entry(l.relation).or_default().push(l.lane.id.clone());
        }
        out
    }
}

/// Bounds of a lanelet in driving direction.
#[derive(Clone)]
struct Bounds {
    left: Vec<Point3>,
    right: Vec<Point3>,
    /// The ways of each bound, and whether each was turned round.
    ways: [Vec<(i64, bool)>; 2],
    nodes: [Vec<i64>; 2],
}

impl Bounds {
    /// The same lanelet, driven the other way.
    fn reversed(&self) -> Self {
        let mut out = self.clone();
        std::mem::swap(&mut out.left, &mut out.right);
        out.ways.reverse();
        out.nodes.reverse();
        out.turn_round();
        out
    }

    fn turn_round(&mut self) {
        self.left.reverse();
        self.turn_side(0);
        self.right.reverse();
        self.turn_side(1);
    }

    fn turn_side(&mut self, side: usize) {
        self.nodes[side].reverse();
        self.ways[side].iter_mut().for_each(|(_, turned)| *turned = !*turned);
    }
}

fn bounds(document: &Document, ground: &mut Ground, relation: &Relation) -> Result<Bounds, String> {
    let mut side = |role: &str| {
        let ids: Vec<i64> = relation.members(MemberKind::Way, role).collect();
        let (ways, nodes) = chain(document, &ids, role)?;
        let line =
            ground.line(&nodes).ok_or_else(|| format!("its {role} bound has nodes without a position"))?;
        if line.len() < 2 {
            return Err(format!("its {role} bound has fewer than two nodes"));
        }
        Ok((ways, nodes, line))
    };
    let ((left_ways, left_nodes, left), (right_ways, right_nodes, right)) = (side("left")?, side("right")?);
    let mut out = Bounds { left, right, ways: [left_ways, right_ways], nodes: [left_nodes, right_nodes] };
    // Ways are shared by neighbors and may run either way: first both the same way, then forward.
    if edges_oppose(&out.left, &out.right) {
        out.right.reverse();
        out.turn_side(1);
    }
    let ring = between(&out.left, &out.right);
    let area: f64 = ring.windows(2).map(|w| w[0].x * w[1].y - w[1].x * w[0].y).sum();
    // Left forward, right back: clockwise.
    if area > 0.0 {
        out.turn_round();
    }
    Ok(out)
}

/// The ways of a bound, each with whether it runs against the first one, and the nodes of all in order.
fn chain(document: &Document, ids: &[i64], role: &str) -> Result<Chain, String> {
    let way = |id: i64| document.ways.get(&id).ok_or_else(|| format!("way {id} is not in the file"));
    let Some((&first, rest)) = ids.split_first() else { return Err(format!("it has no {role} bound")) };
    if rest.len() >= MAX_PIECES {
        return Err(format!("its {role} bound has more than {MAX_PIECES} ways"));
    }
    let distinct: HashSet<i64> = ids.iter().copied().collect();
    if distinct.len() < ids.len() {
        return Err(format!("its {role} bound names a way twice"));
    }
    let mut ways = vec![(first, false)];
    let mut nodes = way(first)?.nodes.clone();
    let mut rest: Vec<(i64, &[i64])> =
        rest.iter().map(|&id| Ok((id, way(id)?.nodes.as_slice()))).collect::<Result<_, String>>()?;
    let points = rest.iter().map(|(_, piece)| piece.len()).fold(nodes.len(), usize::saturating_add);
    if points > MAX_POINTS {
        return Err(format!("its {role} bound has {points} points"));
    }
    while !rest.is_empty() {
        let meets =
            |end: Option<&i64>, piece: &[i64]| end.is_some() && (piece.first() == end || piece.last() == end);
        if let Some(k) = rest.iter().position(|(_, piece)| meets(nodes.last(), piece)) {
            let (id, piece) = rest.swap_remove(k);
            ways.extend(append(&mut nodes, piece).map(|turned| (id, turned)));
        } else if let Some(k) = rest.iter().position(|(_, piece)| meets(nodes.first(), piece)) {
            let (id, piece) = rest.swap_remove(k);
            let turned = piece.last() != nodes.first();
            ways.insert(0, (id, turned));
            let before: Vec<i64> =
                if turned { piece.iter().rev().copied().collect() } else { piece.to_vec() };
            nodes.splice(0..1, before);
        } else {
            return Err(format!("the ways of its {role} bound do not meet end to end; join or reorder them"));
        }
    }
    Ok((ways, nodes))
}

/// Ways with whether they were turned round, and their nodes.
type Chain = (Vec<(i64, bool)>, Vec<i64>);

fn lanelet(
    relation_id: i64,
    id: &str,
    relation: &Relation,
    kind: LaneKind,
    b: Bounds,
    document: &Document,
) -> Lanelet {
    // Unknown where the pieces of a bound are painted differently.
    let mark = |side: usize| {
        let mut marks = b.ways[side]
            .iter()
            .map(|(id, turned)| document.ways.get(id).map_or(LaneMark::Unknown, |w| mark(&w.tags, *turned)));
        let first = marks.next().unwrap_or(LaneMark::Unknown);
        if marks.all(|m| m == first) { first } else { LaneMark::Unknown }
    };
    let turn = match relation.tag("turn_direction") {
        "straight" => Some(TurnKind::Straight),
        "left" => Some(TurnKind::Left),
        "right" => Some(TurnKind::Right),
        _ => None,
    };
    let lane = Lane {
        id: id.to_owned(),
        center: center_line(&b.left, &b.right),
        left_mark: mark(0),
        right_mark: mark(1),
        kind,
        in_junction: turn.is_some(),
        turn,
        // OpenStreetMap's tag is used too; the format's own comes before it.
        speed_limit_mps: signs::speed(relation.tag("speed_limit"))
            .or_else(|| signs::speed(relation.tag("maxspeed"))),
        left: b.left,
        right: b.right,
        ..Lane::default()
    };
    let ends = |last: bool| -> [i64; 2] {
        std::array::from_fn(|i| *(if last { b.nodes[i].last() } else { b.nodes[i].first() }).unwrap_or(&0))
    };
    let (begin, end) = (ends(false), ends(true));
    let bounds = b.ways.map(|ways| ways.into_iter().map(|(id, _)| id).collect());
    Lanelet { relation: relation_id, lane, bounds, begin, end }
}

/// The users of a lanelet, by its subtype, else by the permitted participants.
fn kind(relation: &Relation) -> Option<LaneKind> {
    let may = |who: &str| match relation.tag(&format!("participant:{who}")) {
        "yes" | "true" => Some(true),
        "no" | "false" => Some(false),
        _ => None,
    };
    let by_users = || {
        let users = [
            ("vehicle", LaneKind::Vehicle),
            ("vehicle:car", LaneKind::Vehicle),
            ("vehicle:bus", LaneKind::Bus),
            ("bicycle", LaneKind::Bike),
            ("pedestrian", LaneKind::Sidewalk),
        ];
        users.into_iter().find(|(who, _)| may(who) == Some(true)).map(|(_, kind)| kind)
    };
    match relation.tag("subtype").to_lowercase().as_str() {
        "road" | "highway" | "play_street" if may("vehicle") == Some(false) => by_users(),
        "road" | "highway" | "play_street" => Some(LaneKind::Vehicle),
        "bus_lane" | "buslane" => Some(LaneKind::Bus),
        "bicycle_lane" | "bicyclelane" | "bikelane" | "bike_lane" | "bikeway" | "cycle_lane" | "cycleway" => {
            Some(LaneKind::Bike)
        }
        "walkway" | "sidewalk" | "footway" | "shared_walkway" | "stairs" | "pedestrian_lane" => {
            Some(LaneKind::Sidewalk)
        }
        "emergency_lane" | "road_shoulder" | "shoulder" => Some(LaneKind::Shoulder),
        "rail" | "subway" => None,
        "" => by_users(),
        _ => by_users().or(Some(LaneKind::Other)),
    }
}

/// What drives on a lanelet, and whether the file states it: one without a subtype and without participants is taken
/// for road. Maps leave the subtype out of the ways over junctions (SinD's of Tianjin does).
fn kind_or_road(relation: &Relation) -> Option<(LaneKind, bool)> {
    let stated = kind(relation);
    let is_silent = relation.tag("subtype").is_empty()
        && !relation.tags.keys().any(|key| key.starts_with("participant:"));
    match stated {
        None if is_silent => Some((LaneKind::Vehicle, false)),
        other => other.map(|kind| (kind, true)),
    }
}

/// The mark of a bound; two lines are named from left to right in the direction of the way.
fn mark(tags: &Tags, turned: bool) -> LaneMark {
    let tag = |name: &str| tags.get(name).map_or("", String::as_str);
    match (tag("type"), tag("subtype")) {
        ("virtual", _) => LaneMark::None,
        ("line_thin" | "line_thick", subtype) => match (subtype, turned) {
            ("solid", _) => LaneMark::Solid,
            ("dashed", _) => LaneMark::Dashed,
            ("solid_solid", _) => LaneMark::DoubleSolid,
            ("dashed_dashed", _) => LaneMark::DoubleDashed,
            ("solid_dashed", false) | ("dashed_solid", true) => LaneMark::SolidDashed,
            ("dashed_solid", false) | ("solid_dashed", true) => LaneMark::DashedSolid,
            _ => LaneMark::Unknown,
        },
        // Curbs, walls and the like have no paint information.
        _ => LaneMark::Unknown,
    }
}

/// Followers and neighbors.
fn link(all: &mut [Lanelet]) {
    let walks = |l: &Lanelet| l.lane.kind == LaneKind::Sidewalk;
    let mut begins: HashMap<[i64; 2], Vec<usize>> = HashMap::new();
    let mut with_bound: HashMap<i64, Vec<usize>> = HashMap::new();
    for (i, l) in all.iter().enumerate() {
        begins.entry(l.begin).or_default().push(i);
        l.bounds.iter().flatten().for_each(|way| with_bound.entry(*way).or_default().push(i));
    }
    let mut links: BTreeMap<usize, (Vec<String>, [Option<String>; 2])> = BTreeMap::new();
    let mut before: HashMap<usize, Vec<String>> = HashMap::new();
    for (i, l) in all.iter().enumerate() {
        let next = begins.get(&l.end).into_iter().flatten().copied();
        let next: Vec<usize> = next
            .filter(|&j| j != i && walks(&all[j]) == walks(l) && all[j].relation != l.relation)
            .take(64)
            .collect();
        next.iter().for_each(|j| before.entry(*j).or_default().push(l.lane.id.clone()));
        let beside = |side: usize| {
            let others = || {
                let all_others =
                    l.bounds[side].iter().filter_map(|way| with_bound.get(way)).flatten().copied();
                all_others.filter(|&j| all[j].relation != l.relation && walks(&all[j]) == walks(l)).take(64)
            };
            // One that goes the same way has the bound on its other side.
            let shares =
                |j: usize, other: usize| all[j].bounds[other].iter().any(|w| l.bounds[side].contains(w));
            let same = others().find(|&j| shares(j, 1 - side));
            same.or_else(|| others().find(|&j| shares(j, side))).map(|j| all[j].lane.id.clone())
        };
        links.insert(i, (next.iter().map(|&j| all[j].lane.id.clone()).collect(), [beside(0), beside(1)]));
    }
    for (i, (next, [left, right])) in links {
        let lane = &mut all[i].lane;
        (lane.left_neighbor, lane.right_neighbor) = (left, right);
        lane.successors = next;
        lane.predecessors = before.remove(&i).unwrap_or_default();
    }
    // A lane without a successor leaves the map: it does not end on the road.
    if all.iter().any(|l| !l.lane.successors.is_empty()) {
        for l in all.iter_mut().filter(|l| l.lane.successors.is_empty()) {
            l.lane.successors.push(format!("beyond:{}", l.lane.id));
        }
    }
}
