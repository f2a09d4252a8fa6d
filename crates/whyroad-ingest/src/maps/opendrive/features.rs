//! Crosswalks, lights, stop lines, signs and facilities, from the objects and signals of roads.

use super::document::{Corner, Document, Object, Road, Signal};
use super::lanes::{LaneKey, goes_forward, range};
use super::plan_view::{Pose, poses};
use crate::maps::signs;
use crate::report::RowCount;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Area, Facility, Lane, LayerState, MapLayer, Point3, Sign, StopLine};

/// Half the width of a light, m.
const HALF_LIGHT_M: f64 = 0.5;

/// Results from signals and objects.
#[derive(Default)]
pub(super) struct Found {
    /// Lanes that stop for lights, which no stop line names.
    stops: BTreeSet<LaneKey>,
    pub count: RowCount,
    pub invalid: Vec<String>,
}

/// Adds the features of all roads.
pub(super) fn add(
    document: &Document,
    lanes: &BTreeMap<LaneKey, Lane>,
    sound: &[bool],
    map: &mut RoadMap,
) -> Found {
    let mut out = Found { count: RowCount::new("map_features"), ..Found::default() };
    let standing: HashMap<&str, &Signal> =
        document.roads.iter().flat_map(|r| &r.signals).map(|s| (s.id.as_str(), s)).collect();
    for (index, road) in document.roads.iter().enumerate().filter(|(i, _)| sound[*i]) {
        let at = OnRoad { index, road, lanes };
        at.objects(map, &mut out);
        at.signals(map, &mut out);
        for reference in &road.references {
            if let Some(signal) = standing.get(reference.id.as_str()).filter(|s| is_light(s)) {
                let signal = Signal {
                    s: reference.s,
                    orientation: reference.orientation.clone(),
                    validity: reference.validity.clone(),
                    ..(*signal).clone()
                };
                out.stops.extend(at.concerned(&signal));
            }
        }
        at.structures(map);
    }
    add_stop_lines(&out.stops, lanes, map);
    map.crosswalks.sort_by(|a, b| a.id.cmp(&b.id));
    map.stop_lines.sort_by(|a, b| a.id.cmp(&b.id));
    map.signs.sort_by(|a, b| a.id.cmp(&b.id));
    map.facilities.sort_by(|a, b| a.id.cmp(&b.id));
    out
}

/// Where the file draws no stop line, lanes that a light concerns stop at their end before the junction.
fn add_stop_lines(stops: &BTreeSet<LaneKey>, lanes: &BTreeMap<LaneKey, Lane>, map: &mut RoadMap) {
    if !map.stop_lines.is_empty() {
        return;
    }
    let by_id: HashMap<&str, &Lane> = lanes.values().map(|l| (l.id.as_str(), l)).collect();
    let mut before: BTreeMap<&str, &Lane> = BTreeMap::new();
    for lane in stops.iter().filter_map(|key| lanes.get(key)) {
        let own = std::slice::from_ref(&lane.id);
        let ids = if lane.in_junction { &lane.predecessors[..] } else { own };
        before.extend(ids.iter().filter_map(|id| by_id.get_key_value(id.as_str())).map(|(id, l)| (*id, *l)));
    }
    for (id, lane) in before.into_iter().filter(|(_, l)| l.junction_id.is_some() && !l.in_junction) {
        if let (Some(&left), Some(&right)) = (lane.left.last(), lane.right.last()) {
            let (id, lane_ids) = (format!("stop_{id}"), vec![id.to_owned()]);
            map.stop_lines.push(StopLine { id, line: vec![left, right], lane_ids });
        }
    }
    if !map.stop_lines.is_empty() {
        map.layers.insert(MapLayer::StopLines, LayerState::Derived);
    }
}

/// A road with its placed lanes.
struct OnRoad<'d> {
    index: usize,
    road: &'d Road,
    lanes: &'d BTreeMap<LaneKey, Lane>,
}

impl OnRoad<'_> {
    /// Poses of the reference line at stations in any order.
    fn poses(&self, stations: impl Iterator<Item = f64>) -> BTreeMap<u64, Pose> {
        let mut all: Vec<f64> = stations.filter(|s| s.abs() < 1e6).collect();
        all.sort_by(f64::total_cmp);
        let poses = poses(&self.road.line, &all);
        all.into_iter().map(f64::to_bits).zip(poses).collect()
    }

    fn height(&self, s: f64) -> f64 {
        self.road.elevation.at(s)
    }

    fn objects(&self, map: &mut RoadMap, out: &mut Found) {
        let corners = |o: &Object| -> Vec<f64> {
            o.corners
                .iter()
                .filter_map(|c| if let Corner::Road([s, ..]) = c { Some(*s) } else { None })
                .collect()
        };
        let stations = self.road.objects.iter().flat_map(|o| corners(o).into_iter().chain([o.s]));
        let poses = self.poses(stations);
        for object in &self.road.objects {
            out.count.read += 1;
            let Some(what) = object_kind(object) else {
                out.count.set_aside("scenery", 1);
                continue;
            };
            let boundary = self.outline(object, &poses).filter(|b| b.len() >= 2);
            let Some(boundary) = boundary.filter(|b| b.iter().all(|p| p.x.is_finite() && p.y.is_finite()))
            else {
                out.count.drop_rows("no_line", 1);
                out.invalid.push(format!("object '{}' of road '{}' has no outline", object.id, self.road.id));
                continue;
            };
            let id = if object.id.is_empty() {
                format!("{}_{}", self.road.id, out.count.read)
            } else {
                object.id.clone()
            };
            match what {
                "crosswalk" => {
                    out.count.keep("crosswalk", 1);
                    map.crosswalks.push(Area { id, boundary });
                }
                "stop_line" => {
                    out.count.keep("stop_line", 1);
                    let lane_ids = self.lanes_at(object.s, &object.validity, "");
                    let lane_ids =
                        lane_ids.iter().filter_map(|k| Some(self.lanes.get(k)?.id.clone())).collect();
                    map.stop_lines.push(StopLine { id, line: across(&boundary), lane_ids });
                }
                kind => {
                    out.count.keep("facility", 1);
                    map.facilities.push(Facility { id, kind: kind.into(), boundary });
                }
            }
        }
    }

    /// The first outline, closed, else the box of length and width.
    fn outline(&self, object: &Object, poses: &BTreeMap<u64, Pose>) -> Option<Vec<Point3>> {
        let own = poses.get(&object.s.to_bits())?;
        let z = self.height(object.s);
        let center = own.beside(object.t, z);
        let (sin, cos) = (own.heading + object.heading).sin_cos();
        let local = |u: f64, v: f64, dz: f64| Point3 {
            x: center.x + u * cos - v * sin,
            y: center.y + u * sin + v * cos,
            z: z + dz,
        };
        let mut ring: Vec<Point3> = if object.corners.is_empty() {
            let (l, w) = (object.length? / 2.0, object.width? / 2.0);
            [(l, w), (-l, w), (-l, -w), (l, -w)].map(|(u, v)| local(u, v, 0.0)).into()
        } else {
            let corner = |c: &Corner| match c {
                Corner::Local([u, v, dz]) => Some(local(*u, *v, *dz)),
                Corner::Road([s, t, dz]) => Some(poses.get(&s.to_bits())?.beside(*t, self.height(*s) + dz)),
            };
            object.corners.iter().map(corner).collect::<Option<_>>()?
        };
        if ring.first() != ring.last() {
            ring.extend(ring.first().copied());
        }
        Some(ring)
    }

    fn signals(&self, map: &mut RoadMap, out: &mut Found) {
        let poses = self.poses(self.road.signals.iter().map(|s| s.s));
        for signal in &self.road.signals {
            out.count.read += 1;
            let Some(pose) = poses.get(&signal.s.to_bits()).filter(|_| signal.t.is_finite()) else {
                out.count.drop_rows("no_position", 1);
                out.invalid
                    .push(format!("signal '{}' of road '{}' has no position", signal.id, self.road.id));
                continue;
            };
            let keys = self.concerned(signal);
            let lane_ids: Vec<String> =
                keys.iter().filter_map(|k| Some(self.lanes.get(k)?.id.clone())).collect();
            let position = pose.beside(signal.t, self.height(signal.s) + signal.height);
            if is_light(signal) {
                out.count.keep("light", 1);
                let boundary =
                    [HALF_LIGHT_M, -HALF_LIGHT_M].map(|d| pose.beside(signal.t + d, position.z)).into();
                let id = format!("light_{}", signal.id);
                map.facilities.push(Facility { id, kind: "traffic_light".into(), boundary });
                out.stops.extend(keys);
                continue;
            }
            match signs::kind(&signal.country, &signal.kind) {
                Some("stop_line") => {
                    out.count.keep("stop_line", 1);
                    let edges = keys.iter().filter_map(|k| self.lanes.get(k));
                    if let Some(line) = line_across(edges, position) {
                        map.stop_lines.push(StopLine { id: signal.id.clone(), line, lane_ids });
                    }
                }
                Some(kind) => {
                    out.count.keep("sign", 1);
                    let value = if kind == "speed_limit" { speed(signal) } else { signal.value };
                    map.signs.push(Sign {
                        id: signal.id.clone(),
                        kind: kind.into(),
                        position,
                        lane_ids,
                        value,
                        facing: None,
                    });
                }
                None => out.count.set_aside("unknown_word", 1),
            }
        }
    }

    /// Lanes that a signal concerns: those that it names, driven in its direction.
    fn concerned(&self, signal: &Signal) -> Vec<LaneKey> {
        self.lanes_at(signal.s, &signal.validity, &signal.orientation)
    }

    fn lanes_at(&self, s: f64, validity: &[(i32, i32)], orientation: &str) -> Vec<LaneKey> {
        let road = self.road;
        let holds = |section: usize, left: bool| {
            range(road, section, left).is_some_and(|(from, to)| {
                (from <= s && s < to) || (s >= to && Some(to) == road.length) || (s < from && from == 0.0)
            })
        };
        let mut out = Vec::new();
        for (section, lanes) in road.sections.iter().enumerate() {
            for lane in lanes.lanes.iter().filter(|l| l.id != 0 && holds(section, l.id > 0)) {
                let key = LaneKey { road: self.index, section, lane: lane.id };
                let named = validity.is_empty() || validity.iter().any(|(a, b)| (*a..=*b).contains(&lane.id));
                let along = match orientation {
                    "+" => goes_forward(road, lane),
                    "-" => !goes_forward(road, lane),
                    _ => true,
                };
                if named && along && self.lanes.get(&key).is_some_and(|lane| lane.kind.is_driven_on()) {
                    out.push(key);
                }
            }
        }
        out
    }

    fn structures(&self, map: &mut RoadMap) {
        for structure in &self.road.structures {
            let (from, to) = (structure.s, structure.s + structure.length);
            // The area of the lanes that lie in it, as whole sections: enough to know who is inside.
            let inside = self.lanes.range(LaneKey { road: self.index, section: 0, lane: i32::MIN }..);
            let inside = inside.take_while(|(k, _)| k.road == self.index).filter(|(k, l)| {
                let overlaps = |(a, b): (f64, f64)| a < to && b > from;
                l.kind.is_driven_on() && range(self.road, k.section, k.lane > 0).is_some_and(overlaps)
            });
            for (n, (_, lane)) in inside.enumerate() {
                let boundary = crate::assemble::geometry::between(&lane.left, &lane.right);
                let id = format!("{}_{}_{n}", structure.kind, structure.id);
                map.facilities.push(Facility { id, kind: structure.kind.into(), boundary });
            }
        }
    }
}

/// The longer middle line of a box.
fn across(ring: &[Point3]) -> Vec<Point3> {
    let [a, b, c, d, ..] = ring else { return ring.to_vec() };
    let half =
        |p: &Point3, q: &Point3| Point3 { x: (p.x + q.x) / 2.0, y: (p.y + q.y) / 2.0, z: (p.z + q.z) / 2.0 };
    let distance = crate::assemble::geometry::distance;
    if distance(*a, *b) < distance(*b, *c) {
        vec![half(a, b), half(c, d)]
    } else {
        vec![half(b, c), half(d, a)]
    }
}

/// From the leftmost to the rightmost edge of lanes, through the foot of `position`.
fn line_across<'l>(lanes: impl Iterator<Item = &'l Lane>, position: Point3) -> Option<Vec<Point3>> {
    let mut ends: Vec<Point3> = Vec::new();
    for lane in lanes {
        let near = |edge: &[Point3]| {
            let reach = |p: &&Point3| crate::assemble::geometry::distance(**p, position);
            edge.iter().min_by(|a, b| reach(a).total_cmp(&reach(b))).copied()
        };
        ends.extend([near(&lane.left)?, near(&lane.right)?]);
    }
    let far =
        |p: &Point3| ends.iter().map(|q| crate::assemble::geometry::distance(*p, *q)).fold(0.0, f64::max);
    let first = ends.iter().max_by(|a, b| far(a).total_cmp(&far(b)))?;
    let last = ends.iter().max_by(|a, b| {
        let reach = |p: &&Point3| crate::assemble::geometry::distance(**p, *first);
        reach(a).total_cmp(&reach(b))
    })?;
    Some(vec![*first, *last])
}

/// Lights for vehicles, by the numbers of ASAM's list (country `OpenDRIVE`): all of the thousands but those for
/// pedestrians and bicycles.
fn is_light(signal: &Signal) -> bool {
    let others = ["1000002", "1000003", "1000007", "1000013", "1000014"];
    signal.dynamic && signal.kind.starts_with("10000") && !others.contains(&signal.kind.as_str())
}

fn object_kind(object: &Object) -> Option<&'static str> {
    let says = |word: &str| {
        let plain = |text: &str| text.to_lowercase().replace(['_', ' ', '-'], "");
        [&object.kind, &object.subtype, &object.name].iter().any(|t| plain(t) == word)
    };
    let kinds = [
        ("crosswalk", "crosswalk"),
        ("stopline", "stop_line"),
        ("signalline", "stop_line"),
        ("parkingspace", "parking"),
        ("building", "building"),
        ("speedbump", "speed_bump"),
        ("gantry", ""),
    ];
    kinds.into_iter().find(|(word, _)| says(word)).map(|(_, kind)| kind).filter(|k| !k.is_empty())
}

/// The number on a speed limit, m/s: the value in its unit, or the subtype in km/h (Germany).
fn speed(signal: &Signal) -> Option<f64> {
    let value = signal.value.filter(|v| *v > 0.0);
    match (value, signal.unit.as_str()) {
        (Some(v), "km/h") => Some(v / 3.6),
        (Some(v), "mph") => Some(v * 0.447_04),
        (Some(v), "m/s") => Some(v),
        (Some(v), "") if !signal.country.starts_with("US") => Some(v / 3.6),
        _ => None,
    }
}
