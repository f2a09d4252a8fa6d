//! What the families about road, map parts, signs and route read in common: the drive with its map, the ego on its lane, on its
//! driven path and on its way over the lanes ahead.

use crate::context::{self, Channels};
use crate::ego_lane::EgoLane;
use crate::ego_motion::EgoMotion;
use crate::junction::{Encounters, HORIZON_M};
use crate::path::DrivenPath;
use crate::placement::Target;
use crate::road::Road;
use crate::table::TableBuilder;
use crate::way::{Way, Ways};
use crate::{
    crossroads, facilities, free_width, lane_rules, merging, open_area, road_profile, roadside, route,
};
use whyroad_model::road_map::Lane;
use whyroad_model::{Drive, RoadMap, Tri};

/// A drive on its map.
pub struct OnRoad<'a> {
    /// The drive.
    pub drive: &'a Drive,
    /// Its map.
    pub map: &'a RoadMap,
    /// The map made ready.
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
}

impl<'a> OnRoad<'a> {
    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.ego.len()
    }

    /// The map's entry of a lane of [`Road::lanes`].
    pub fn lane(&self, index: usize) -> Option<&'a Lane> {
        self.map.lane(&self.road.lanes[index].id)
    }

    /// The map's entry of the ego's lane in `frame`.
    pub fn own_lane(&self, frame: usize) -> Option<&'a Lane> {
        self.lane(self.lanes.at(frame)?.lane)
    }

    /// A number a frame from the way ahead and the arc length of the ego's front bumper on it; NaN where it has no lane.
    pub fn ahead(&self, value: impl Fn(usize, &Way, f64) -> f64) -> Vec<f64> {
        let front = self.ego.front();
        (0..self.frames())
            .map(|i| self.ways.at(i).map_or(f64::NAN, |(way, s)| value(i, way, s + front)))
            .collect()
    }

    /// A flag a frame; unknown where the ego's pose is.
    pub fn flags(&self, value: impl Fn(usize) -> Tri) -> Vec<Tri> {
        (0..self.frames()).map(|i| if self.ego.is_known(i) { value(i) } else { Tri::Unknown }).collect()
    }
}

/// Writes all signals about road, map parts, signs and route.
pub fn write(on: &OnRoad<'_>, targets: &[Target<'_>], table: &mut TableBuilder<'_>) {
    let channels = Channels::new(on.drive);
    road_profile::write(on, table);
    lane_rules::write(on, table);
    lane_rules::write_marked(on, &channels, table);
    merging::write(on, table);
    crossroads::write(on, table);
    roadside::write(on, table);
    open_area::write(on, table);
    facilities::write(on, &channels, table);
    free_width::write(on, targets, table);
    route::write_fit(on, table);
    if on.map.lanes.iter().any(|l| l.is_tagged("unpaved")) {
        let unpaved: Vec<Option<bool>> =
            (0..on.frames()).map(|i| on.own_lane(i).map(|l| l.is_tagged("unpaved"))).collect();
        context::write_pavement(&channels, &unpaved, table);
    }
}

/// `distance` from the front bumper, 0 where it is behind it, infinite beyond the horizon.
pub fn within_horizon(distance: f64) -> f64 {
    if distance > HORIZON_M { f64::INFINITY } else { distance.max(0.0) }
}

/// Seconds until the ego has driven `distance` at its forward speed: 0 there, infinite at standstill, NaN where unknown.
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

/// Under this forward speed nothing is reached: the threshold of standstill, m/s.
const LEAST_SPEED_MPS: f64 = crate::ego_motion::STANDSTILL_SET_MPS;
