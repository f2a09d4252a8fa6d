//! The road around a drive, in the drive's world frame. Geometry only; anything computed from it is a signal.

mod layers;

pub use layers::{LayerState, MapLayer};

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A point in the world frame, m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point3 {
    /// m.
    pub x: f64,
    /// m.
    pub y: f64,
    /// m.
    pub z: f64,
}

/// Everything in the map of a drive, each list ordered by id.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RoadMap {
    /// Lanes, junction lanes included.
    pub lanes: Vec<Lane>,
    /// Pedestrian crossings.
    pub crosswalks: Vec<Area>,
    /// Junction areas.
    pub junctions: Vec<Area>,
    /// Where vehicles may drive.
    pub drivable_areas: Vec<Area>,
    /// Lines at which to stop.
    pub stop_lines: Vec<StopLine>,
    /// Signs.
    pub signs: Vec<Sign>,
    /// Toll gates, speed bumps, tunnels and the like.
    pub facilities: Vec<Facility>,
    /// Kinds of signs and facilities and tags of lanes for which the map is complete, ordered. For any other kind, its
    /// absence in the map does not mean that the road has none.
    pub complete_for: Vec<String>,
    /// How much of each layer the map has, as its adapter declares it. A layer that is not declared counts as complete:
    /// maps made by hand are complete.
    pub layers: BTreeMap<MapLayer, LayerState>,
}

/// One lane segment. Left and right are as seen when driving along it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lane {
    /// Id within the map.
    pub id: String,
    /// Left edge in driving direction; empty when the source has only a center line and no width.
    pub left: Vec<Point3>,
    /// Right edge in driving direction.
    pub right: Vec<Point3>,
    /// Center line in driving direction; made from the edges where the source has none.
    pub center: Vec<Point3>,
    /// Mark on the left edge.
    pub left_mark: LaneMark,
    /// Mark on the right edge.
    pub right_mark: LaneMark,
    /// Adjacent lane on the left; may run the other way.
    pub left_neighbor: Option<String>,
    /// Adjacent lane on the right.
    pub right_neighbor: Option<String>,
    /// Lanes that can be entered at the end.
    pub successors: Vec<String>,
    /// Lanes that lead here.
    pub predecessors: Vec<String>,
    /// The users of the lane.
    pub kind: LaneKind,
    /// Inside a junction.
    pub in_junction: bool,
    /// Legal limit, m/s.
    pub speed_limit_mps: Option<f64>,
    /// Stated width, m; where there are edges, measure those.
    pub width_m: Option<f64>,
    /// Junction that the lane belongs to or ends at, where the source states it.
    pub junction_id: Option<String>,
    /// Turn that the lane makes across a junction, where the source states it.
    pub turn: Option<TurnKind>,
    /// What else the lane is: words of [`crate::vocabulary::LANE_TAGS`].
    pub tags: Vec<String>,
}

/// The users of a lane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LaneKind {
    /// General traffic.
    #[default]
    Vehicle,
    /// Buses.
    Bus,
    /// Bicycles.
    Bike,
    /// Pedestrians.
    Sidewalk,
    /// Hard shoulder.
    Shoulder,
    /// Anything else the source names.
    Other,
}

impl LaneKind {
    /// True for lanes that vehicles, buses or bicycles drive on.
    pub fn is_driven_on(self) -> bool {
        matches!(self, LaneKind::Vehicle | LaneKind::Bus | LaneKind::Bike)
    }
}

/// Lanes inside junctions whose course changes by less lead straight over them, rad (15 deg).
pub const STRAIGHT_OVER_RAD: f64 = std::f64::consts::PI / 12.0;

/// Direction of a movement across a junction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TurnKind {
    /// Straight on.
    Straight,
    /// Left.
    Left,
    /// Right.
    Right,
    /// Back.
    Uturn,
}

/// What is painted on a lane's edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LaneMark {
    /// Not stated by the source.
    #[default]
    Unknown,
    /// Nothing.
    None,
    /// One dashed line.
    Dashed,
    /// One solid line.
    Solid,
    /// Two dashed lines.
    DoubleDashed,
    /// Two solid lines.
    DoubleSolid,
    /// Solid on the left, dashed on the right.
    SolidDashed,
    /// Dashed on the left, solid on the right.
    DashedSolid,
}

/// A polygon, closed by its first point, in either winding.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Area {
    /// Id within the map.
    pub id: String,
    /// Corners.
    pub boundary: Vec<Point3>,
}

/// A stop line across a lane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StopLine {
    /// Id within the map.
    pub id: String,
    /// The line.
    pub line: Vec<Point3>,
    /// Lanes that stop there.
    pub lane_ids: Vec<String>,
}

/// A sign beside or over the road.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sign {
    /// Id within the map.
    pub id: String,
    /// A word of [`crate::vocabulary::SIGN_KINDS`].
    pub kind: String,
    /// Position.
    pub position: Point3,
    /// Lanes that it applies to.
    pub lane_ids: Vec<String>,
    /// A number on it (a limit in m/s, a height or width in m), where there is one.
    pub value: Option<f64>,
    /// Direction of its face, towards its readers, rad counter-clockwise from x; `None` where the source does not tell.
    pub facing: Option<f64>,
}

/// A part of the road or its surroundings with a purpose: a tunnel, a toll booth, a building.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Facility {
    /// Id within the map.
    pub id: String,
    /// What it is: a word of [`crate::vocabulary::FACILITY_KINDS`].
    pub kind: String,
    /// Its area, or its line when it has two points.
    pub boundary: Vec<Point3>,
}

impl Lane {
    /// True when the source states this of the lane; `tag` is a word of [`crate::vocabulary::LANE_TAGS`].
    pub fn is_tagged(&self, tag: &str) -> bool {
        self.tags.iter().any(|t| t == tag)
    }
}

impl RoadMap {
    /// How much of `layer` the map has.
    pub fn layer(&self, layer: MapLayer) -> LayerState {
        self.layers.get(&layer).copied().unwrap_or(LayerState::Complete)
    }

    /// True when the map has information about `layer`.
    pub fn has(&self, layer: MapLayer) -> bool {
        self.layer(layer) != LayerState::Absent
    }

    /// True if the map states where there are signs or facilities of `kind`: it has one, or states that it has all.
    pub fn covers(&self, kind: &str) -> bool {
        self.complete_for.iter().any(|k| k == kind)
            || self.facilities.iter().any(|f| f.kind == kind)
            || self.signs.iter().any(|s| s.kind == kind)
    }

    /// True when the map states that it has all signs, facilities or tagged lanes of `kind`.
    pub fn tells_all(&self, kind: &str) -> bool {
        self.complete_for.iter().any(|k| k == kind)
    }

    /// The lane with this id.
    pub fn lane(&self, id: &str) -> Option<&Lane> {
        self.lanes.binary_search_by(|l| l.id.as_str().cmp(id)).ok().map(|i| &self.lanes[i])
    }
}
