//! Input of the families on road, map parts, signs and route: the drive with its map, the ego on its lane, on its
//! driven path and on its way over the lanes ahead.

use crate::ego::motion::EgoMotion;
use crate::road::ego_lane::EgoLane;
use crate::road::junction::{Encounters, HORIZON_M};
use crate::road::network::Road;
use crate::road::path::DrivenPath;
use crate::road::way::{Way, Ways};
use whyroad_model::road_map::Lane;
use whyroad_model::{Drive, RoadMap, Tri};

/// A drive on its map.
pub struct OnRoad<'a> {
    /// The drive.
    pub drive: &'a Drive,
    /// Its map.
    pub map: &'a RoadMap,
    /// The prepared map.
    pub road: &'a Road,
    /// The ego's path.
    pub path: &'a DrivenPath,
    /// Its motion.
    pub ego: &'a EgoMotion,
    /// Its lanes.
    pub lanes: &'a EgoLane,
    /// Junctions and crosswalks on its path.
    pub encounters: &'a Encounters,
    /// Seconds since the first frame.
    pub times: &'a [f64],
    /// Its ways.
    pub ways: Ways,
    /// The map's entry of each lane of the road, which frames ask for again and again.
    pub entries: Vec<Option<&'a Lane>>,
}

impl<'a> OnRoad<'a> {
    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.ego.len()
    }

    /// The map's entry of a lane of [`Road::lanes`].
    pub fn lane(&self, index: usize) -> Option<&'a Lane> {
        self.entries[index]
    }

    /// The map's entry of the ego's lane in `frame`.
    pub fn own_lane(&self, frame: usize) -> Option<&'a Lane> {
        self.lane(self.lanes.at(frame)?.lane)
    }

    /// A number per frame from the way ahead and the arc length of the ego's front bumper on it; NaN where it has no
    /// lane.
    pub fn ahead(&self, value: impl Fn(usize, &Way, f64) -> f64) -> Vec<f64> {
        let front = self.ego.front();
        (0..self.frames())
            .map(|i| self.ways.at(i).map_or(f64::NAN, |(way, s)| value(i, way, s + front)))
            .collect()
    }

    /// A flag per frame; unknown where the ego's pose is unknown.
    pub fn flags(&self, value: impl Fn(usize) -> Tri) -> Vec<Tri> {
        (0..self.frames()).map(|i| if self.ego.is_known(i) { value(i) } else { Tri::Unknown }).collect()
    }
}

/// `distance` from the front bumper, 0 where it is behind it, infinite beyond the horizon.
pub fn within_horizon(distance: f64) -> f64 {
    if distance > HORIZON_M { f64::INFINITY } else { distance.max(0.0) }
}

/// Seconds until the ego has driven `distance` at its forward speed: 0 there, infinite at standstill, NaN where
/// unknown.
pub fn time_to(distance: f64, forward_speed: f64) -> f64 {
    if distance.is_nan() || forward_speed.is_nan() {
        f64::NAN
    } else if distance <= 0.0 {
        0.0
    } else if forward_speed < LEAST_SPEED_MPS {
        f64::INFINITY
    } else {
        distance / forward_speed
    }
}

/// Below this forward speed no point is reached: the threshold of standstill, m/s.
const LEAST_SPEED_MPS: f64 = crate::ego::motion::STANDSTILL_SET_MPS;
