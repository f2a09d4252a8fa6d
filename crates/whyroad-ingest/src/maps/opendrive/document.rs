//! An OpenDRIVE file as it is written: roads, lanes, junctions, objects, signals, before anything is placed. Attributes
//! that are absent stay absent; unknown elements are skipped.

use super::cubic::{Cubic, Profile};
use super::plan_view::{Geometry, Shape};
use crate::encodings::input::Input;
use crate::encodings::xml::{Element, Tag, for_each_tag};

/// Which end of a road, by ascending station.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum End {
    Start,
    End,
}

/// What a road leads into.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum RoadLink {
    /// Id, and the end at which it is entered.
    Road(String, End),
    Junction(String),
}

#[derive(Clone, Debug, Default)]
pub(super) struct Mark {
    /// m from the section's start.
    pub offset: f64,
    /// `solid`, `broken`, `solid broken`, ...
    pub kind: String,
}

#[derive(Clone, Debug, Default)]
pub(super) struct DocLane {
    pub id: i32,
    pub kind: String,
    /// `reversed` where traffic runs against the side's own direction.
    pub direction: String,
    pub predecessors: Vec<i32>,
    pub successors: Vec<i32>,
    pub widths: Profile,
    pub borders: Profile,
    pub marks: Vec<Mark>,
    /// m from the section's start, m/s.
    pub speeds: Vec<(f64, Option<f64>)>,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Section {
    pub start: f64,
    pub single_side: bool,
    /// All lanes, the one in the middle (0) included.
    pub lanes: Vec<DocLane>,
}

/// A corner of an object's outline.
#[derive(Clone, Copy, Debug)]
pub(super) enum Corner {
    /// In the axes of the object: u, v, z.
    Local([f64; 3]),
    /// Station, t, height over the road.
    Road([f64; 3]),
}

#[derive(Clone, Debug, Default)]
pub(super) struct Object {
    pub id: String,
    pub kind: String,
    pub subtype: String,
    pub name: String,
    pub s: f64,
    pub t: f64,
    pub heading: f64,
    pub length: Option<f64>,
    pub width: Option<f64>,
    /// The first outline.
    pub corners: Vec<Corner>,
    outlines: usize,
    pub validity: Vec<(i32, i32)>,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Signal {
    pub id: String,
    pub s: f64,
    pub t: f64,
    pub height: f64,
    /// `+`, `-`, `none`
    pub orientation: String,
    pub dynamic: bool,
    pub country: String,
    pub kind: String,
    pub value: Option<f64>,
    pub unit: String,
    pub validity: Vec<(i32, i32)>,
}

/// A signal located elsewhere that also applies to this road.
#[derive(Clone, Debug, Default)]
pub(super) struct SignalReference {
    pub id: String,
    pub s: f64,
    pub orientation: String,
    pub validity: Vec<(i32, i32)>,
}

/// A stretch of a road in a tunnel or on a bridge.
#[derive(Clone, Debug)]
pub(super) struct Structure {
    pub id: String,
    /// `tunnel`, `bridge`
    pub kind: &'static str,
    pub s: f64,
    pub length: f64,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Road {
    pub id: String,
    pub length: Option<f64>,
    /// Id of the junction that it is part of.
    pub junction: Option<String>,
    pub left_hand: bool,
    pub predecessor: Option<RoadLink>,
    pub successor: Option<RoadLink>,
    /// Speed limit by station, m/s; `None` where a type without one begins.
    pub limits: Vec<(f64, Option<f64>)>,
    pub line: Vec<Geometry>,
    /// A stretch whose shape is not known, or not stated.
    pub shapeless: bool,
    pub elevation: Profile,
    pub superelevation: Profile,
    pub lane_offset: Profile,
    pub sections: Vec<Section>,
    pub objects: Vec<Object>,
    pub structures: Vec<Structure>,
    pub signals: Vec<Signal>,
    pub references: Vec<SignalReference>,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Connection {
    pub incoming: String,
    /// The road over the junction; in a direct junction, the one that is entered.
    pub connecting: String,
    pub contact: Option<End>,
    /// Lanes from, to.
    pub lanes: Vec<(i32, i32)>,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Junction {
    pub id: String,
    pub connections: Vec<Connection>,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Document {
    pub name: String,
    pub roads: Vec<Road>,
    pub junctions: Vec<Junction>,
    /// Why reading stopped before the end.
    pub broken: Option<String>,
}

/// Reads the file as far as it can be read. `Err` when it is not OpenDRIVE.
pub(super) fn read(input: Input<'_>) -> Result<Document, String> {
    let mut state = State::default();
    let end = for_each_tag(input, |tag| match tag {
        Tag::Open(e) => state.open(&e),
        Tag::Close(name) => state.close(name),
    });
    if !state.is_open_drive {
        return Err(end.err().unwrap_or_else(|| "it has no <OpenDRIVE>".to_owned()));
    }
    // Elements that were begun before a break are kept.
    state.end_road();
    state.document.junctions.extend(state.junction.take());
    state.document.broken = end.err();
    Ok(state.document)
}

fn end_of(e: &Element<'_>) -> Option<End> {
    match e.get("contactPoint")?.as_ref() {
        "start" => Some(End::Start),
        "end" => Some(End::End),
        _ => None,
    }
}

fn integer(e: &Element<'_>, name: &str) -> Option<i32> {
    e.get(name)?.trim().parse().ok()
}

/// A limit in m/s; `None` for `no limit`, `undefined` and units that are not known.
fn limit(e: &Element<'_>) -> Option<f64> {
    let to_mps = match e.get("unit").as_deref().unwrap_or("m/s") {
        "m/s" => 1.0,
        "km/h" => 1.0 / 3.6,
        "mph" => 0.447_04,
        _ => return None,
    };
    e.number("max").filter(|v| *v > 0.0).map(|v| v * to_mps)
}

fn validity(e: &Element<'_>) -> Option<(i32, i32)> {
    let (a, b) = (integer(e, "fromLane")?, integer(e, "toLane")?);
    Some((a.min(b), a.max(b)))
}

/// What is being read.
#[derive(Default)]
struct State {
    document: Document,
    is_open_drive: bool,
    road: Option<Road>,
    junction: Option<Junction>,
    lane: bool,
    geometry: bool,
    object: bool,
    signal: Option<bool>,
}

impl State {
    fn open(&mut self, e: &Element<'_>) {
        let text = |name: &str| e.text(name).unwrap_or_default();
        match e.name() {
            "OpenDRIVE" => self.is_open_drive = true,
            "header" => self.document.name = text("name"),
            "road" => {
                self.road = Some(Road {
                    id: text("id"),
                    length: e.number("length"),
                    junction: e.text("junction").filter(|j| j != "-1" && !j.is_empty()),
                    left_hand: e.get("rule").as_deref() == Some("LHT"),
                    ..Road::default()
                });
            }
            "junction" if self.road.is_none() => {
                self.junction = Some(Junction { id: text("id"), ..Junction::default() });
            }
            name => match (&mut self.road, &mut self.junction) {
                (Some(_), _) => self.in_road(name, e),
                (None, Some(junction)) => in_junction(junction, name, e),
                _ => {}
            },
        }
    }

    fn in_road(&mut self, name: &str, e: &Element<'_>) {
        let Some(road) = &mut self.road else { return };
        let text = |name: &str| e.text(name).unwrap_or_default();
        match name {
            "predecessor" | "successor" if self.lane => {
                let Some(lane) = road.sections.last_mut().and_then(|s| s.lanes.last_mut()) else { return };
                let list = if name == "predecessor" { &mut lane.predecessors } else { &mut lane.successors };
                list.extend(integer(e, "id"));
            }
            "predecessor" | "successor" => {
                let id = text("elementId");
                let link = match e.get("elementType").as_deref() {
                    Some("junction") => Some(RoadLink::Junction(id)),
                    Some("road") => end_of(e).map(|end| RoadLink::Road(id, end)),
                    _ => None,
                };
                *(if name == "predecessor" { &mut road.predecessor } else { &mut road.successor }) = link;
            }
            "type" => road.limits.push((e.number("s").unwrap_or(0.0), None)),
            "speed" if self.lane => {
                let Some(lane) = road.sections.last_mut().and_then(|s| s.lanes.last_mut()) else { return };
                lane.speeds.push((e.number("sOffset").unwrap_or(0.0), limit(e)));
            }
            "speed" => {
                if let Some(last) = road.limits.last_mut() {
                    last.1 = limit(e);
                }
            }
            "geometry" => {
                let number = |name| e.number(name);
                let known = (number("s"), number("x"), number("y"), number("hdg"), number("length"));
                // The one before has no shape that is known.
                road.shapeless |= self.geometry;
                match known {
                    (Some(start), Some(x), Some(y), Some(heading), Some(length)) => {
                        road.line.push(Geometry { start, x, y, heading, length, shape: Shape::Line });
                    }
                    _ => road.shapeless = true,
                }
                self.geometry = true;
            }
            "line" | "arc" | "spiral" | "poly3" | "paramPoly3" => {
                let Some(g) = road.line.last_mut().filter(|_| self.geometry) else { return };
                match shape(name, e, g.length) {
                    Some(shape) => g.shape = shape,
                    None => road.shapeless = true,
                }
                self.geometry = false;
            }
            "elevation" => road.elevation.extend(e, "s"),
            "superelevation" => road.superelevation.extend(e, "s"),
            "laneOffset" => road.lane_offset.extend(e, "s"),
            "laneSection" => road.sections.push(Section {
                start: e.number("s").unwrap_or(f64::NAN),
                single_side: e.get("singleSide").as_deref() == Some("true"),
                lanes: Vec::new(),
            }),
            "lane" => {
                let (Some(section), Some(id)) = (road.sections.last_mut(), integer(e, "id")) else { return };
                let (kind, direction) = (text("type"), text("direction"));
                section.lanes.push(DocLane { id, kind, direction, ..DocLane::default() });
                self.lane = true;
            }
            "width" | "border" | "roadMark" if self.lane => {
                let Some(lane) = road.sections.last_mut().and_then(|s| s.lanes.last_mut()) else { return };
                match name {
                    "width" => lane.widths.extend(e, "sOffset"),
                    "border" => lane.borders.extend(e, "sOffset"),
                    _ => {
                        lane.marks
                            .push(Mark { offset: e.number("sOffset").unwrap_or(0.0), kind: text("type") });
                    }
                }
            }
            "object" => {
                let number = |name| e.number(name);
                road.objects.push(Object {
                    id: text("id"),
                    kind: text("type"),
                    subtype: text("subtype"),
                    name: text("name"),
                    s: number("s").unwrap_or(f64::NAN),
                    t: number("t").unwrap_or(f64::NAN),
                    heading: number("hdg").unwrap_or(0.0),
                    length: number("length"),
                    width: number("width"),
                    ..Object::default()
                });
                self.object = true;
            }
            "outline" if self.object => {
                road.objects.last_mut().into_iter().for_each(|o| o.outlines += 1);
            }
            "cornerLocal" | "cornerRoad" if self.object => {
                let number = |name| e.number(name).unwrap_or(0.0);
                let corner = match name {
                    "cornerLocal" => Corner::Local([number("u"), number("v"), number("z")]),
                    _ => Corner::Road([number("s"), number("t"), number("dz")]),
                };
                let first = road.objects.last_mut().filter(|o| o.outlines <= 1);
                first.into_iter().for_each(|o| o.corners.push(corner));
            }
            "tunnel" | "bridge" => {
                let kind = if name == "tunnel" { "tunnel" } else { "bridge" };
                if let (Some(s), Some(length)) = (e.number("s"), e.number("length")) {
                    road.structures.push(Structure { id: text("id"), kind, s, length });
                }
            }
            "signal" => {
                road.signals.push(Signal {
                    id: text("id"),
                    s: e.number("s").unwrap_or(f64::NAN),
                    t: e.number("t").unwrap_or(f64::NAN),
                    height: e.number("zOffset").unwrap_or(0.0),
                    orientation: text("orientation"),
                    dynamic: e.get("dynamic").as_deref() == Some("yes"),
                    country: text("country").to_uppercase(),
                    kind: text("type"),
                    value: e.number("value"),
                    unit: text("unit"),
                    validity: Vec::new(),
                });
                self.signal = Some(true);
            }
            "signalReference" => {
                road.references.push(SignalReference {
                    id: text("id"),
                    s: e.number("s").unwrap_or(f64::NAN),
                    orientation: text("orientation"),
                    validity: Vec::new(),
                });
                self.signal = Some(false);
            }
            "validity" => {
                let list = match self.signal {
                    Some(true) => road.signals.last_mut().map(|s| &mut s.validity),
                    Some(false) => road.references.last_mut().map(|s| &mut s.validity),
                    None if self.object => road.objects.last_mut().map(|o| &mut o.validity),
                    None => None,
                };
                list.into_iter().for_each(|list| list.extend(validity(e)));
            }
            _ => {}
        }
    }

    fn end_road(&mut self) {
        let Some(mut road) = self.road.take() else { return };
        road.shapeless |= std::mem::take(&mut self.geometry);
        let of_lanes = road.sections.iter_mut().flat_map(|s| &mut s.lanes);
        let of_lanes = of_lanes.flat_map(|l| [&mut l.widths, &mut l.borders]);
        let of_road = [&mut road.elevation, &mut road.superelevation, &mut road.lane_offset];
        of_lanes.chain(of_road).for_each(Profile::sort);
        self.document.roads.push(road);
    }

    fn close(&mut self, name: &str) {
        match name {
            "road" => self.end_road(),
            "junction" if self.road.is_none() => self.document.junctions.extend(self.junction.take()),
            "lane" => self.lane = false,
            "object" => self.object = false,
            "signal" | "signalReference" => self.signal = None,
            _ => {}
        }
    }
}

impl Profile {
    fn extend(&mut self, e: &Element<'_>, start: &str) {
        Cubic::of(e, start).into_iter().for_each(|c| self.push(c));
    }
}

fn shape(name: &str, e: &Element<'_>, length: f64) -> Option<Shape> {
    let number = |name: &'static str| e.number(name);
    Some(match name {
        "line" => Shape::Line,
        "arc" => Shape::Arc(number("curvature")?),
        "spiral" => Shape::Spiral(number("curvStart")?, number("curvEnd")?),
        "poly3" => Shape::Cubic([number("a")?, number("b")?, number("c")?, number("d")?]),
        _ => {
            let four =
                |n: [&'static str; 4]| Some([number(n[0])?, number(n[1])?, number(n[2])?, number(n[3])?]);
            let end = if e.get("pRange").as_deref() == Some("arcLength") { length } else { 1.0 };
            Shape::Parametric { u: four(["aU", "bU", "cU", "dU"])?, v: four(["aV", "bV", "cV", "dV"])?, end }
        }
    })
}

fn in_junction(junction: &mut Junction, name: &str, e: &Element<'_>) {
    match name {
        "connection" => {
            let road = e.text("connectingRoad").or_else(|| e.text("linkedRoad"));
            junction.connections.push(Connection {
                incoming: e.text("incomingRoad").unwrap_or_default(),
                connecting: road.unwrap_or_default(),
                contact: end_of(e),
                lanes: Vec::new(),
            });
        }
        "laneLink" => {
            if let (Some(c), Some(from), Some(to)) =
                (junction.connections.last_mut(), integer(e, "from"), integer(e, "to"))
            {
                c.lanes.push((from, to));
            }
        }
        _ => {}
    }
}
