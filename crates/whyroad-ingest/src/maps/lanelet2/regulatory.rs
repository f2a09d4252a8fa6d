//! Regulatory elements: lights, right of way, limits and signs, with the lines at which lanelets stop for them.

use super::document::{Document, MemberKind, Relation, Way};
use super::ground::Ground;
use super::lanelets::Lanelets;
use crate::assemble::geometry::distance;
use crate::maps::{MapReading, signs};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Facility, Lane, Point3, Sign, StopLine};

/// `type` of the way of a board.
const SIGN: &str = "traffic_sign";
/// More pairs of loose stop lines and lanes are not compared.
const MAX_PAIRS: usize = 100_000_000;

/// Adds what regulatory elements state.
pub(super) fn add(document: &Document, lanelets: &Lanelets, ground: &mut Ground, out: &mut MapReading) {
    let lanes = lanelets.by_relation();
    // Lanes by the elements that apply to them.
    let mut under: HashMap<i64, Vec<String>> = HashMap::new();
    for (id, relation) in document.relations.iter().filter(|(_, r)| r.tag("type") == "lanelet") {
        for element in relation.members(MemberKind::Relation, "regulatory_element") {
            if !document.relations.contains_key(&element) {
                out.dangling.push(format!("lanelet {id} -> regulatory element {element}"));
            }
            under.entry(element).or_default().extend(lanes.get(id).into_iter().flatten().cloned());
        }
    }
    let mut all = Elements {
        document,
        lanes: &lanes,
        stops: BTreeMap::new(),
        lights: BTreeSet::new(),
        signs: BTreeMap::new(),
        ended: BTreeSet::new(),
    };
    for (id, element) in document.relations.iter().filter(|(_, r)| r.tag("type") == "regulatory_element") {
        let concerned = under.get(id).cloned().unwrap_or_default();
        all.add(*id, element, concerned, ground, out);
    }
    // Boards that no element names apply to whoever passes them. Those against entering face the other way.
    let passed = |tags: &Way| tags.tag("type") == SIGN && sign_kind(tags.tag("subtype")) != Some("no_entry");
    for way in document.ways.iter().filter(|(_, w)| passed(w)).map(|(id, _)| *id) {
        all.sign(way, &[], None, ground, out);
    }
    // Lines that no element names.
    let loose =
        document.ways.iter().filter(|(id, w)| w.tag("type") == "stop_line" && !all.stops.contains_key(id));
    let loose: Vec<i64> = loose.map(|(id, _)| *id).collect();
    let unnamed = all.stops.values().filter(|lanes| lanes.is_empty()).count();
    let compare = (loose.len() + unnamed).saturating_mul(out.map.lanes.len()) <= MAX_PAIRS;
    for (way, of_lanes) in
        loose.into_iter().map(|w| (w, None)).chain(all.stops.into_iter().map(|(w, l)| (w, Some(l))))
    {
        let Some(line) = document.ways.get(&way).and_then(|w| ground.line(&w.nodes)).filter(|l| l.len() >= 2)
        else {
            out.invalid.push(format!("stop line {way} has no line"));
            continue;
        };
        let crossed =
            || out.map.lanes.iter().filter(|l| crosses(&line, &l.center)).map(|l| l.id.clone()).collect();
        let lane_ids = match of_lanes {
            Some(lanes) if !lanes.is_empty() => lanes.into_iter().collect(),
            // Also of an element that no lanelet names.
            _ if compare => crossed(),
            _ => Vec::new(),
        };
        out.map.stop_lines.push(StopLine { id: format!("stop_{way}"), line, lane_ids });
    }
}

struct Elements<'d> {
    document: &'d Document,
    lanes: &'d HashMap<i64, Vec<String>>,
    /// Lanes that stop at each way.
    stops: BTreeMap<i64, BTreeSet<String>>,
    /// Lights that were added.
    lights: BTreeSet<i64>,
    /// Where in the map signs are that were added.
    signs: BTreeMap<i64, usize>,
    /// Lanes that stop at their end.
    ended: BTreeSet<String>,
}

impl Elements<'_> {
    fn add(
        &mut self,
        id: i64,
        element: &Relation,
        concerned: Vec<String>,
        ground: &mut Ground,
        out: &mut MapReading,
    ) {
        let of_role = |role: &'static str| -> Vec<String> {
            let ids = element.members(MemberKind::Relation, role);
            ids.filter_map(|id| self.lanes.get(&id)).flatten().cloned().collect()
        };
        let who_yields = of_role("yield");
        let subtype = element.tag("subtype");
        let (refers, lines) = self.roles(element);
        let stopping = match subtype {
            "right_of_way" | "all_way_stop" => who_yields,
            _ => concerned.clone(),
        };
        let no_line = lines.is_empty();
        if no_line && matches!(subtype, "traffic_light" | "all_way_stop") {
            self.end_lines(&stopping, out);
        }
        let yields: Vec<i64> = element.members(MemberKind::Relation, "yield").collect();
        // Lanelet2's rule: the lines of an all-way stop are as many as its lanelets and in their order.
        let in_order = subtype == "all_way_stop" && lines.len() == yields.len();
        for (k, way) in lines.into_iter().enumerate() {
            let of_line = if in_order { self.lanes.get(&yields[k]) } else { Some(&stopping) };
            self.stops.entry(way).or_default().extend(of_line.into_iter().flatten().cloned());
        }
        match subtype {
            "traffic_light" => {
                for way in refers {
                    self.light(way, ground, out);
                }
            }
            "speed_limit" => {
                let ways = refers.iter().filter_map(|way| self.document.ways.get(way));
                let named = ways.map(|w| w.tag("subtype").to_owned());
                let mut names =
                    named.chain([element.tag("sign_type").to_owned(), element.tag("speed_limit").to_owned()]);
                if let Some(limit) = names.find_map(|name| limit(&name)) {
                    for id in &concerned {
                        if let Some(at) = place_of(&out.map, id) {
                            out.map.lanes[at].speed_limit_mps.get_or_insert(limit);
                        }
                    }
                }
                refers.iter().for_each(|way| self.sign(*way, &concerned, None, ground, out));
            }
            "all_way_stop" if refers.is_empty() => {
                let RoadMap { lanes, signs, .. } = &mut out.map;
                for lane in stopping.iter().filter_map(|id| lane_of(lanes, id)) {
                    signs.extend(lane.center.last().map(|p| Sign {
                        id: format!("sign_{id}_{}", lane.id),
                        kind: "stop".into(),
                        position: *p,
                        lane_ids: vec![lane.id.clone()],
                        value: None,
                        facing: None,
                    }));
                }
            }
            // A board at each arm.
            "all_way_stop" if refers.len() > 1 => {
                for (way, lanes) in self.nearest_boards(&refers, &stopping, ground, out) {
                    self.sign(way, &lanes, Some("stop"), ground, out);
                }
            }
            "right_of_way" | "all_way_stop" | "traffic_sign" => {
                let fallback = (subtype == "all_way_stop").then_some("stop");
                refers.iter().for_each(|way| self.sign(*way, &stopping, fallback, ground, out));
            }
            "speed_bump" => {
                for way in refers {
                    let nodes = self.document.ways.get(&way).map(|w| w.nodes.clone()).unwrap_or_default();
                    if let Some(boundary) = ground.line(&nodes).filter(|l| l.len() >= 2) {
                        let facility =
                            Facility { id: format!("bump_{way}"), kind: "speed_bump".into(), boundary };
                        out.map.facilities.push(facility);
                    }
                }
            }
            _ => {}
        }
    }

    /// The boards or lights of an element, and its lines. Maps mix up the two roles (INTERACTION's of
    /// DR_DEU_Roundabout_OF does): where the kind of a way contradicts its role, the kind counts.
    fn roles(&self, element: &Relation) -> (Vec<i64>, Vec<i64>) {
        let is = |way: &i64, kinds: &[&str]| {
            self.document.ways.get(way).is_some_and(|w| kinds.contains(&w.tag("type")))
        };
        let concerns_lines =
            matches!(element.tag("subtype"), "right_of_way" | "all_way_stop" | "traffic_sign");
        let swapped = |way: &i64| concerns_lines && is(way, &["stop_line", "line_thin", "line_thick"]);
        let (lines, mut refers): (Vec<i64>, Vec<i64>) =
            element.members(MemberKind::Way, "refers").partition(swapped);
        let (boards, of_line): (Vec<i64>, Vec<i64>) =
            element.members(MemberKind::Way, "ref_line").partition(|way| is(way, &[SIGN]));
        refers.extend(boards);
        (refers, of_line.into_iter().chain(lines).collect())
    }

    /// Lanes that stop where they end: Lanelet2's rule where an element has no line.
    fn end_lines(&mut self, lanes: &[String], out: &mut MapReading) {
        let RoadMap { lanes: all, stop_lines, .. } = &mut out.map;
        for lane in lanes.iter().filter_map(|id| lane_of(all, id)) {
            if let (Some(&a), Some(&b)) = (lane.left.last(), lane.right.last())
                && self.ended.insert(lane.id.clone())
            {
                let (id, lane_ids) = (format!("stop_{}", lane.id), vec![lane.id.clone()]);
                stop_lines.push(StopLine { id, line: vec![a, b], lane_ids });
            }
        }
    }

    /// The boards of an all-way stop, each with the lanes that end nearest to it.
    fn nearest_boards(
        &self,
        boards: &[i64],
        lanes: &[String],
        ground: &mut Ground,
        out: &MapReading,
    ) -> Vec<(i64, Vec<String>)> {
        let mut place = |way: &i64| ground.line(&self.document.ways.get(way)?.nodes)?.first().copied();
        let places: Vec<Option<Point3>> = boards.iter().map(&mut place).collect();
        let mut of_boards: Vec<(i64, Vec<String>)> = boards.iter().map(|way| (*way, Vec::new())).collect();
        for id in lanes {
            let end = lane_of(&out.map.lanes, id).and_then(|l| l.center.last().copied());
            let far = |k: &usize| match (places[*k], end) {
                (Some(board), Some(end)) => distance(board, end),
                _ => f64::INFINITY,
            };
            if let Some(nearest) = (0..boards.len()).min_by(|a, b| far(a).total_cmp(&far(b))) {
                of_boards[nearest].1.push(id.clone());
            }
        }
        of_boards
    }

    fn light(&mut self, way: i64, ground: &mut Ground, out: &mut MapReading) {
        let Some(found) = self.document.ways.get(&way) else {
            return out.dangling.push(format!("traffic light {way}"));
        };
        if !self.lights.insert(way) || matches!(found.tag("subtype"), "red_green" | "pedestrian") {
            return;
        }
        if let Some(boundary) = ground.line(&found.nodes).filter(|l| !l.is_empty()) {
            out.map.facilities.push(Facility {
                id: format!("light_{way}"),
                kind: "traffic_light".into(),
                boundary,
            });
        }
    }

    fn sign(
        &mut self,
        way: i64,
        lanes: &[String],
        fallback: Option<&'static str>,
        ground: &mut Ground,
        out: &mut MapReading,
    ) {
        let Some(found) = self.document.ways.get(&way) else {
            return out.dangling.push(format!("traffic sign {way}"));
        };
        // A board at a corner stands for several ways in.
        if let Some(at) = self.signs.get(&way) {
            let known = &mut out.map.signs[*at].lane_ids;
            let named: HashSet<&str> = known.iter().map(String::as_str).collect();
            let more: Vec<String> = lanes.iter().filter(|l| !named.contains(l.as_str())).cloned().collect();
            known.extend(more);
            return;
        }
        let name = found.tag("subtype");
        let kind = sign_kind(name).or(fallback).filter(|k| *k != "stop_line");
        let Some((kind, line)) = kind.zip(ground.line(&found.nodes)) else { return };
        if line.is_empty() {
            return;
        }
        let n = line.len() as f64;
        let mean = |of: fn(&Point3) -> f64| line.iter().map(of).sum::<f64>() / n;
        let position = Point3 { x: mean(|p| p.x), y: mean(|p| p.y), z: mean(|p| p.z) };
        let value = if kind == "speed_limit" { limit(name) } else { None };
        let (id, lane_ids) = (format!("sign_{way}"), lanes.to_vec());
        self.signs.insert(way, out.map.signs.len());
        out.map.signs.push(Sign { id, kind: kind.into(), position, lane_ids, value, facing: None });
    }
}

fn lane_of<'l>(lanes: &'l [Lane], id: &str) -> Option<&'l Lane> {
    lanes.binary_search_by(|l| l.id.as_str().cmp(id)).ok().map(|i| &lanes[i])
}

/// Index of the lane with this id.
fn place_of(map: &RoadMap, id: &str) -> Option<usize> {
    map.lanes.binary_search_by(|l| l.id.as_str().cmp(id)).ok()
}

/// `de206`, `usR1-1`: a country's two letters and the number in its catalog.
fn sign_kind(name: &str) -> Option<&'static str> {
    let (country, number) = name.split_at_checked(2)?;
    signs::kind(country, number)
}

/// The speed in the name of a sign: `de274-60`, or plainly `60 km/h`.
fn limit(name: &str) -> Option<f64> {
    let number = name.strip_prefix("de274").map(|rest| rest.trim_start_matches(['-', '.']));
    signs::speed(number.unwrap_or(name))
}

/// True when two lines cross in the ground plane.
fn crosses(a: &[Point3], b: &[Point3]) -> bool {
    let bounds = |line: &[Point3]| {
        line.iter().fold([f64::MAX, f64::MAX, f64::MIN, f64::MIN], |m, p| {
            [m[0].min(p.x), m[1].min(p.y), m[2].max(p.x), m[3].max(p.y)]
        })
    };
    let (u, v) = (bounds(a), bounds(b));
    if u[0] > v[2] || v[0] > u[2] || u[1] > v[3] || v[1] > u[3] {
        return false;
    }
    let side = |p: &Point3, q: &Point3, r: &Point3| (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
    a.windows(2).any(|p| {
        b.windows(2).any(|q| {
            side(&p[0], &p[1], &q[0]) * side(&p[0], &p[1], &q[1]) <= 0.0
                && side(&q[0], &q[1], &p[0]) * side(&q[0], &q[1], &p[1]) <= 0.0
        })
    })
}
