//! Lanelets: a left and a right bound each. Which lanelets follow or lie beside each other is not written in the file:
//! those that share the end points of their bounds follow, those that share a bound lie beside each other.

use super::document::{Document, MemberKind, Relation, Tags};
use super::ground::Ground;
use crate::assemble::geometry::{between, center_line, edges_oppose};
use crate::maps::{MapReading, signs};
use std::collections::{BTreeMap, HashMap};
use whyroad_model::road_map::{Area, Lane, LaneKind, LaneMark, Point3, TurnKind};

/// A lanelet as it is driven: those for both directions occur twice.
pub(super) struct Lanelet {
    pub relation: i64,
    pub lane: Lane,
    /// Ways of the left and right bound.
    bounds: [i64; 2],
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
                Ok(b) => match kind(relation) {
                    None => out.count.set_aside("not_a_road_user_lane", 1),
                    Some(kind) => {
                        out.count.keep("lane", 1);
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
    ways: [i64; 2],
    nodes: [Vec<i64>; 2],
    /// Whether each way was turned round.
    turned: [bool; 2],
}

impl Bounds {
    /// The same lanelet, driven the other way.
    fn reversed(&self) -> Self {
        let mut out = self.clone();
        std::mem::swap(&mut out.left, &mut out.right);
        out.ways.reverse();
        out.nodes.reverse();
        out.turned.reverse();
        out.turn_round();
        out
    }

    fn turn_round(&mut self) {
        self.left.reverse();
        self.right.reverse();
        self.nodes.iter_mut().for_each(|n| n.reverse());
        self.turned = self.turned.map(|t| !t);
    }
}

fn bounds(document: &Document, ground: &mut Ground, relation: &Relation) -> Result<Bounds, String> {
    let mut side = |role: &str| {
        let mut ids = relation.members(MemberKind::Way, role);
        let (Some(id), None) = (ids.next(), ids.next()) else {
            return Err(format!("it does not have one {role} bound"));
        };
        let way = document.ways.get(&id).ok_or_else(|| format!("way {id} is not in the file"))?;
        let line = ground.line(&way.nodes).ok_or_else(|| format!("way {id} has nodes without a position"))?;
        if line.len() < 2 {
            return Err(format!("way {id} has fewer than two nodes"));
        }
        Ok((id, way.nodes.clone(), line))
    };
    let ((left_way, left_nodes, left), (right_way, right_nodes, right)) = (side("left")?, side("right")?);
    let mut out = Bounds {
        left,
        right,
        ways: [left_way, right_way],
        nodes: [left_nodes, right_nodes],
        turned: [false; 2],
    };
    // Ways are shared by neighbors and may run either way: first both the same way, then forward.
    if edges_oppose(&out.left, &out.right) {
        out.right.reverse();
        out.nodes[1].reverse();
        out.turned[1] = true;
    }
    let ring = between(&out.left, &out.right);
    let area: f64 = ring.windows(2).map(|w| w[0].x * w[1].y - w[1].x * w[0].y).sum();
    // Left forward, right back: clockwise.
    if area > 0.0 {
        out.turn_round();
    }
    Ok(out)
}

fn lanelet(
    relation_id: i64,
    id: &str,
    relation: &Relation,
    kind: LaneKind,
    b: Bounds,
    document: &Document,
) -> Lanelet {
    let mark = |side: usize| {
        let way = document.ways.get(&b.ways[side]);
        way.map_or(LaneMark::Unknown, |w| mark(&w.tags, b.turned[side]))
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
        speed_limit_mps: signs::speed(relation.tag("speed_limit")),
        left: b.left,
        right: b.right,
        ..Lane::default()
    };
    let ends = |last: bool| -> [i64; 2] {
        std::array::from_fn(|i| *(if last { b.nodes[i].last() } else { b.nodes[i].first() }).unwrap_or(&0))
    };
    Lanelet { relation: relation_id, lane, bounds: b.ways, begin: ends(false), end: ends(true) }
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
    match relation.tag("subtype") {
        "road" | "highway" | "play_street" if may("vehicle") == Some(false) => by_users(),
        "road" | "highway" | "play_street" => Some(LaneKind::Vehicle),
        "bus_lane" => Some(LaneKind::Bus),
        "bicycle_lane" => Some(LaneKind::Bike),
        "walkway" | "shared_walkway" | "stairs" | "pedestrian_lane" => Some(LaneKind::Sidewalk),
        "emergency_lane" | "road_shoulder" | "shoulder" => Some(LaneKind::Shoulder),
        "rail" | "subway" => None,
        "" => by_users(),
        _ => by_users().or(Some(LaneKind::Other)),
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
        l.bounds.iter().for_each(|way| with_bound.entry(*way).or_default().push(i));
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
                let all_others = with_bound.get(&l.bounds[side]).into_iter().flatten().copied();
                all_others.filter(|&j| all[j].relation != l.relation && walks(&all[j]) == walks(l)).take(64)
            };
            // One that goes the same way has the bound on its other side.
            let same = others().find(|&j| all[j].bounds[1 - side] == l.bounds[side]);
            same.or_else(|| others().find(|&j| all[j].bounds[side] == l.bounds[side]))
                .map(|j| all[j].lane.id.clone())
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
