//! `.net.xml`: lanes, crossings, junction areas, lights' stop lines.
//!
//! Lane edges are the lane's shape moved by half its width to either side. Lanes inside junctions are SUMO's internal
//! lanes; walking areas and tracks of rails are left out. A node counts as a junction when it joins three or more
//! other nodes: a node that only bends a road or changes its number of lanes is not one, nor is one where one-way roads
//! merge or part at small angles (ramps of a motorway). SUMO has no lane marks (unknown) and its limit on internal
//! lanes is a turning speed, not the law (left out).

use super::border::Border;
use super::edge::Edge;
use super::{ramps, roundabouts};
use crate::assemble::geometry::{beside, between, distance};
use crate::assemble::layers;
use crate::encodings::input::Input;
use crate::encodings::xml::{Element, Tag, for_each_tag};
use crate::report::RowCount;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::RoadMap;
use whyroad_model::road_map::{
    Area, Facility, Lane, LaneKind, LayerState, MapLayer, Point3, StopLine, TurnKind,
};
use whyroad_model::vocabulary::BUS_LANES;

/// SUMO's width of a lane that states none, m.
const DEFAULT_WIDTH_M: f64 = 3.2;
/// Opposite lanes are neighbors when their left edges are at most this far apart, m.
const OPPOSITE_GAP_M: f64 = 1.0;

/// One movement that a light controls.
#[derive(Clone, Debug)]
pub(super) struct LightLink {
    pub tls: String,
    pub index: usize,
    pub lane: String,
    /// First lane behind the light.
    pub to_lane: String,
}

/// A network.
#[derive(Default)]
pub(super) struct Net {
    pub map: RoadMap,
    pub count: RowCount,
    pub links: Vec<LightLink>,
    /// Ends of links that name no lane of the network.
    pub dangling: Vec<String>,
    pub broken: Option<String>,
    /// First lane that could not be used.
    pub invalid_example: Option<String>,
}

struct Connection {
    from: String,
    to: String,
    via: Option<String>,
    turn: Option<TurnKind>,
    light: Option<(String, usize)>,
}

#[derive(Default)]
struct Raw {
    edges: BTreeMap<String, Edge>,
    lanes: BTreeMap<String, Lane>,
    crossings: Vec<Area>,
    nodes: BTreeMap<String, Vec<Point3>>,
    border: Border,
    /// Left-hand traffic: lanes are numbered from the left.
    left_hand: bool,
    connections: Vec<Connection>,
    /// Junctions with lights.
    lit: BTreeSet<String>,
    /// Edges of each roundabout.
    roundabouts: Vec<Vec<String>>,
}

/// Reads the network as far as it can be read. `Err` when the file is not a network.
pub(super) fn read(input: Input<'_>) -> Result<Net, String> {
    let mut net = Net { count: RowCount::new("map"), ..Net::default() };
    let mut raw = Raw::default();
    let (mut is_net, mut edge_id) = (false, String::new());
    let end = for_each_tag(input, |tag| {
        let Tag::Open(e) = tag else { return };
        match e.name() {
            "net" => {
                is_net = true;
                raw.left_hand = matches!(e.get("lefthand").as_deref(), Some("1" | "true"));
            }
            "edge" => {
                edge_id = e.text("id").unwrap_or_default();
                let text = |n: &str| e.text(n).unwrap_or_default();
                let edge = Edge {
                    from: text("from"),
                    to: text("to"),
                    function: text("function"),
                    kind: text("type"),
                    lanes: Vec::new(),
                };
                raw.edges.insert(edge_id.clone(), edge);
            }
            "lane" => add_lane(&e, &edge_id, &mut raw, &mut net),
            "junction" => {
                raw.border.add(&e);
                if let (Some(id), Some(shape)) = (e.text("id"), e.get("shape"))
                    && !matches!(e.get("type").as_deref(), Some("internal" | "dead_end"))
                {
                    if e.get("type").is_some_and(|t| t.starts_with("traffic_light")) {
                        raw.lit.insert(id.clone());
                    }
                    raw.nodes.insert(id, points(&shape));
                }
            }
            "connection" => raw.connections.extend(connection(&e)),
            "roundabout" => {
                let edges = e.get("edges").unwrap_or_default();
                raw.roundabouts.push(edges.split_whitespace().map(str::to_owned).collect());
            }
            _ => {}
        }
    });
    if !is_net {
        return Err(end.err().unwrap_or_else(|| "it has no <net>".to_owned()));
    }
    net.broken = end.err();
    assemble(raw, &mut net);
    Ok(net)
}

pub(super) fn points(shape: &str) -> Vec<Point3> {
    shape
        .split_whitespace()
        .filter_map(|p| {
            let mut c = p.split(',').map(|v| v.parse::<f64>().ok().filter(|v| v.is_finite()));
            Some(Point3 { x: c.next()??, y: c.next()??, z: c.next().flatten().unwrap_or(0.0) })
        })
        .collect()
}

fn add_lane(e: &Element, edge_id: &str, raw: &mut Raw, net: &mut Net) {
    net.count.read += 1;
    let id = e.text("id").unwrap_or_default();
    let center = points(e.get("shape").as_deref().unwrap_or(""));
    let width = e.number("width").filter(|w| *w > 0.0).unwrap_or(DEFAULT_WIDTH_M);
    let Some(edge) = raw.edges.get_mut(edge_id) else { return net.count.drop_rows("invalid", 1) };
    let kind = lane_kind(e.get("allow").as_deref(), e.get("disallow").as_deref());
    let (Some(kind), false) = (kind, edge.function == "walkingarea") else {
        return net.count.set_aside("not_a_road_user_lane", 1);
    };
    if center.len() < 2 || id.is_empty() {
        net.invalid_example.get_or_insert_with(|| format!("lane '{id}' has fewer than two points"));
        return net.count.drop_rows("invalid", 1);
    }
    let (left, right) = (beside(&center, width / 2.0), beside(&center, -width / 2.0));
    if edge.function == "crossing" {
        net.count.keep("crosswalk", 1);
        raw.crossings.push(Area { id, boundary: between(&left, &right) });
        return;
    }
    net.count.keep("lane", 1);
    edge.lanes.push(id.clone());
    let internal = edge.function == "internal";
    let fast = matches!(e.get("acceleration").as_deref(), Some("1" | "true"));
    let tags = [("ramp", ramps::is_link_type(&edge.kind)), ("acceleration", fast)];
    let lane = Lane {
        id: id.clone(),
        tags: tags.into_iter().filter(|(_, holds)| *holds).map(|(tag, _)| tag.to_owned()).collect(),
        left,
        right,
        center,
        kind,
        speed_limit_mps: e.number("speed").filter(|_| !internal),
        width_m: Some(width),
        ..Lane::default()
    };
    raw.lanes.insert(id, lane);
}

/// Who a lane is for, from the classes that may use it; `None` for rails, water and the like.
fn lane_kind(allow: Option<&str>, disallow: Option<&str>) -> Option<LaneKind> {
    let Some(allow) = allow.filter(|a| !a.is_empty()) else {
        let barred: BTreeSet<&str> = disallow.unwrap_or("").split_whitespace().collect();
        let open = |class: &str| !barred.contains(class) && !barred.contains("all");
        // A lane closed to cars is for those of these classes that may use it.
        let kinds = [
            ("passenger", LaneKind::Vehicle),
            ("bus", LaneKind::Bus),
            ("bicycle", LaneKind::Bike),
            ("pedestrian", LaneKind::Sidewalk),
        ];
        return kinds.into_iter().find(|(class, _)| open(class)).map(|(_, kind)| kind);
    };
    let classes: BTreeSet<&str> = allow.split_whitespace().collect();
    let has = |c: &[&str]| c.iter().any(|c| classes.contains(c));
    if has(&["passenger", "private", "all", "truck", "delivery"]) {
        Some(LaneKind::Vehicle)
    } else if has(&["bus", "coach", "taxi"]) {
        Some(LaneKind::Bus)
    } else if has(&["bicycle"]) {
        Some(LaneKind::Bike)
    } else if has(&["pedestrian"]) {
        Some(LaneKind::Sidewalk)
    } else if has(&["emergency", "authority"]) {
        Some(LaneKind::Shoulder)
    } else if classes
        .iter()
        .all(|c| c.contains("rail") || ["tram", "subway", "ship", "cable_car"].contains(c))
    {
        None
    } else {
        Some(LaneKind::Other)
    }
}

fn connection(e: &Element) -> Option<Connection> {
    let lane = |edge: &str, index: &str| Some(format!("{}_{}", e.get(edge)?, e.get(index)?));
    let turn = match e.get("dir").as_deref() {
        Some("s") => Some(TurnKind::Straight),
        Some("l" | "L") => Some(TurnKind::Left),
        Some("r" | "R") => Some(TurnKind::Right),
        Some("t" | "T") => Some(TurnKind::Uturn),
        _ => None,
    };
    let light = e.text("tl").zip(e.get("linkIndex").and_then(|i| i.parse().ok()));
    Some(Connection {
        from: lane("from", "fromLane")?,
        to: lane("to", "toLane")?,
        via: e.text("via"),
        turn,
        light,
    })
}

fn assemble(raw: Raw, net: &mut Net) {
    let Raw { edges, mut lanes, crossings, nodes, border, left_hand, connections, lit, roundabouts: rings } =
        raw;
    let branches = branches(&edges);
    let movements: BTreeSet<(&str, &str)> =
        connections.iter().filter_map(|c| Some((edge_of(&c.from)?, edge_of(&c.to)?))).collect();
    let meetings = ramps::meetings(&branches, &movements);
    let junctions = real_junctions(&meetings, &lanes);

    for edge in edges.values() {
        // Lanes are numbered from the roadside to the middle; SUMO writes them in that order.
        for pair in edge.lanes.windows(2) {
            set(&mut lanes, &pair[0], |l| *towards_middle(l, left_hand) = Some(pair[1].clone()));
            set(&mut lanes, &pair[1], |l| *towards_middle(l, !left_hand) = Some(pair[0].clone()));
        }
    }
    for (id, edge) in &edges {
        let node = if edge.function == "internal" { internal_node(id) } else { Some(edge.to.as_str()) };
        let Some(node) = node.filter(|n| junctions.contains(n)) else { continue };
        for lane in &edge.lanes {
            set(&mut lanes, lane, |l| {
                l.in_junction = edge.function == "internal";
                l.junction_id = Some(node.to_owned());
            });
        }
    }
    join_opposites(&edges, &mut lanes, left_hand);
    for c in connections {
        let next = c.via.clone().unwrap_or_else(|| c.to.clone());
        let missing = [&c.from, &next].into_iter().find(|id| !lanes.contains_key(*id)).cloned();
        if let Some(missing) = missing {
            // Walking areas and crossings are connected too; only lanes of the road are meant here.
            if !edges.contains_key(missing.rsplit_once('_').map_or("", |p| p.0)) {
                net.dangling.push(format!("{} -> {missing}", c.from));
            }
            continue;
        }
        set(&mut lanes, &c.from, |l| push_new(&mut l.successors, &next));
        set(&mut lanes, &next, |l| push_new(&mut l.predecessors, &c.from));
        let behind = if c.via.is_some() { &next } else { &c.from };
        if behind.starts_with(':') {
            set(&mut lanes, behind, |l| l.turn = l.turn.or(c.turn));
        }
        if let Some((tls, index)) = c.light {
            net.links.push(LightLink { tls, index, lane: c.from, to_lane: next });
        }
    }
    let typed_ramps = lanes.values().any(|l| l.is_tagged("ramp"));
    // Where types name the ramps, an edge of another type that leads into acceleration lanes is a carriageway.
    let may_feed = |e: &&Edge| e.function.is_empty() && (!typed_ramps || e.kind.is_empty());
    let feeders: Vec<&Vec<String>> = edges.values().filter(may_feed).map(|e| &e.lanes).collect();
    ramps::tag_feeders(&feeders, &mut lanes);
    if !typed_ramps {
        ramps::tag_branches(&meetings, &mut lanes);
    }
    ramps::tag_joints(&mut lanes);
    let exits = border.exits();
    for edge in edges.values().filter(|e| e.function.is_empty() && exits.contains(&e.to.as_str())) {
        for lane in &edge.lanes {
            set(&mut lanes, lane, |l| l.successors.push(format!("beyond:{}", edge.to)));
        }
    }
    let stops: BTreeSet<&str> = net.links.iter().map(|l| l.lane.as_str()).collect();
    net.map.stop_lines = stops
        .into_iter()
        .filter_map(|id| {
            let l = lanes.get(id)?;
            let line = vec![*l.left.last()?, *l.right.last()?];
            Some(StopLine { id: format!("stop_{id}"), line, lane_ids: vec![id.to_owned()] })
        })
        .collect();
    net.map.facilities = rings.iter().filter_map(|r| roundabouts::area(r, &edges, &lanes, &nodes)).collect();
    net.map.facilities.extend(nodes.iter().filter(|(id, shape)| lit.contains(*id) && shape.len() >= 3).map(
        |(id, shape)| {
            let boundary = shape.iter().chain(shape.first()).copied().collect();
            Facility { id: format!("lights_{id}"), kind: "traffic_light".into(), boundary }
        },
    ));
    net.map.facilities.sort_by(|a, b| a.id.cmp(&b.id));
    // netconvert marks every roundabout that it finds; a network has all ramps, acceleration lanes, bus lanes and
    // lights that its vehicles use.
    net.map.complete_for =
        ["acceleration", BUS_LANES, "ramp", "roundabout", "traffic_light"].map(str::to_owned).into();
    net.map.lanes = lanes.into_values().collect();
    net.map.crosswalks = crossings;
    net.map.crosswalks.sort_by(|a, b| a.id.cmp(&b.id));
    net.map.junctions = nodes
        .into_iter()
        .filter(|(id, shape)| junctions.contains(id.as_str()) && shape.len() >= 3)
        .map(|(id, mut boundary)| {
            boundary.extend(boundary.first().copied());
            Area { id, boundary }
        })
        .collect();
    // A network has everything that its vehicles obey: a simulation has no other lights, limits or crossings. Paint it
    // never has.
    let complete = [
        MapLayer::Connections,
        MapLayer::Junctions,
        MapLayer::Neighbors,
        MapLayer::Crosswalks,
        MapLayer::Lights,
        MapLayer::SpeedLimits,
    ];
    let mut stated = complete.map(|layer| (layer, LayerState::Complete)).to_vec();
    stated.push((MapLayer::Ramps, if typed_ramps { LayerState::Complete } else { LayerState::Derived }));
    layers::declare(&mut net.map, &stated);
}

/// Edges outside junctions as [`ramps::tag_branches`] asks for them.
fn branches(edges: &BTreeMap<String, Edge>) -> Vec<ramps::Branch<'_>> {
    let outside = edges.iter().filter(|(_, e)| e.function.is_empty() && !e.lanes.is_empty());
    outside.map(|(id, e)| ramps::Branch { id, from: &e.from, to: &e.to, lanes: &e.lanes }).collect()
}

fn set(lanes: &mut BTreeMap<String, Lane>, id: &str, change: impl FnOnce(&mut Lane)) {
    if let Some(l) = lanes.get_mut(id) {
        change(l);
    }
}

fn push_new(list: &mut Vec<String>, id: &str) {
    if !list.iter().any(|x| x == id) {
        list.push(id.to_owned());
    }
}

/// The node of an internal edge `:node_index`.
fn internal_node(edge_id: &str) -> Option<&str> {
    edge_id.strip_prefix(':')?.rsplit_once('_').map(|p| p.0)
}

/// The edge of a lane `edge_index`.
fn edge_of(lane: &str) -> Option<&str> {
    lane.rsplit_once('_').map(|p| p.0)
}

/// Nodes that join three or more other nodes by edges that have lanes, except those at which roads only merge or part,
/// or pass roads of the other direction.
fn real_junctions<'e>(
    meetings: &BTreeMap<&'e str, Vec<ramps::Meeting<'e>>>,
    lanes: &BTreeMap<String, Lane>,
) -> BTreeSet<&'e str> {
    let is_real = |meetings: &[ramps::Meeting<'_>]| {
        let ends =
            meetings.iter().flat_map(|m| m.ins.iter().map(|e| e.from).chain(m.outs.iter().map(|e| e.to)));
        let passes = |(i, m): (usize, &ramps::Meeting<'_>)| meetings[..i].iter().all(|o| m.passes(o, lanes));
        let only_flows =
            meetings.iter().all(|m| m.runs_together(lanes)) && meetings.iter().enumerate().all(passes);
        ends.collect::<BTreeSet<_>>().len() >= 3 && !only_flows
    };
    meetings.iter().filter(|(_, here)| is_real(here)).map(|(node, _)| *node).collect()
}

/// The neighbor on the side of the road's middle: on the left in right-hand traffic.
fn towards_middle(lane: &mut Lane, left_hand: bool) -> &mut Option<String> {
    if left_hand { &mut lane.right_neighbor } else { &mut lane.left_neighbor }
}

/// The innermost lanes of an edge and of the one that runs the other way are neighbors where they touch.
fn join_opposites(edges: &BTreeMap<String, Edge>, lanes: &mut BTreeMap<String, Lane>, left_hand: bool) {
    let inner = |l: &Lane, at: fn(&[Point3]) -> Option<&Point3>| {
        at(if left_hand { &l.right } else { &l.left }).copied()
    };
    let by_ends: BTreeMap<(&str, &str), &Edge> = edges
        .values()
        .filter(|e| e.function.is_empty())
        .map(|e| ((e.from.as_str(), e.to.as_str()), e))
        .collect();
    for edge in by_ends.values() {
        let Some(back) = by_ends.get(&(edge.to.as_str(), edge.from.as_str())) else { continue };
        let (Some(own), Some(other)) = (edge.lanes.last(), back.lanes.last()) else { continue };
        let touch = match (lanes.get(own), lanes.get(other)) {
            (Some(a), Some(b)) => match (inner(a, <[_]>::first), inner(b, <[_]>::last)) {
                (Some(p), Some(q)) => distance(p, q) <= OPPOSITE_GAP_M,
                _ => false,
            },
            _ => false,
        };
        if touch {
            set(lanes, own, |l| *towards_middle(l, left_hand) = Some(other.clone()));
        }
    }
}
