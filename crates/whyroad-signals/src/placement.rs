//! Where each target is in each frame, once for all signals that ask: in the ego's axes, along and beside the
//! ego's driven path, and along and beside the ego's lane.

use crate::ego_lane::{EgoLane, lateral_extent};
use crate::ego_motion::{EgoMotion, given_or_slope};
use crate::geometry::{OrientedBox, P2, p2, wrap};
use crate::path::DrivenPath;
use crate::road::{DEFAULT_HALF_WIDTH_M, LEVEL_M};
use whyroad_model::scene::Track;

/// One target over its observed rows.
pub struct Target<'a> {
    /// The track.
    pub track: &'a Track,
    /// Forward acceleration, m/s2.
    pub accel: Vec<f64>,
    /// One entry a row of the track; `None` where the ego's or the target's pose is unknown.
    pub places: Vec<Option<Placement>>,
}

/// A place beside a line: signed distances, left positive, m.
#[derive(Clone, Copy, Debug)]
pub struct Beside {
    /// Of the centre.
    pub lateral: f64,
    /// Of the rightmost corner.
    pub low: f64,
    /// Of the leftmost corner.
    pub high: f64,
    /// Direction of the line there, rad.
    pub heading: f64,
}

/// Where a target is in one frame.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// The frame.
    pub frame: usize,
    /// Box on the ground; sizes may be NaN.
    pub footprint: OrientedBox,
    /// Velocity over ground, m/s, world.
    pub velocity: P2,
    /// Arc length from the ego's centre to the target's along the path, forward positive, m.
    pub ahead: f64,
    /// The same to its nearest corner, m; the centre where sizes are unknown.
    pub near: f64,
    /// The same to its farthest corner, m.
    pub far: f64,
    /// Beside the driven path.
    pub path: Beside,
    /// Beside the ego's lane, with the distances to its left and right edge; `None` while the ego has none.
    pub lane: Option<(Beside, f64, f64)>,
    /// At the height of the ego's path.
    pub same_level: bool,
    /// Direction of the path where the ego is, rad.
    pub heading_at_ego: f64,
}

impl Placement {
    /// True when the box's size is known.
    pub fn is_sized(&self) -> bool {
        self.footprint.length.is_finite() && self.footprint.width.is_finite()
    }

    /// Speed over ground, m/s.
    pub fn speed(&self) -> f64 {
        self.velocity.norm()
    }

    /// The ego's lane where there is one, else a band along the driven path: place and edges.
    pub fn way(&self) -> (Beside, f64, f64) {
        self.lane.unwrap_or((self.path, DEFAULT_HALF_WIDTH_M, DEFAULT_HALF_WIDTH_M))
    }

    /// True when the centre is between the edges of [`Placement::way`], on its level and within reach.
    pub fn centre_in_way(&self) -> bool {
        let (at, left, right) = self.way();
        self.same_level && self.within_reach() && at.lateral <= left && at.lateral >= -right
    }

    /// True within 150 m ahead and 100 m behind: farther targets are known to be out of relation.
    pub fn within_reach(&self) -> bool {
        self.near <= 150.0 && self.far >= -100.0
    }

    /// How far the innermost side has come over the edge into the ego's lane, never negative, m. `None` without
    /// a lane or a size.
    pub fn intrusion(&self) -> Option<f64> {
        let (at, left, right) = self.lane?;
        if !self.is_sized() {
            return None;
        }
        let depth = if at.lateral > 0.0 { left - at.low } else { right + at.high };
        let there = self.same_level && self.within_reach();
        Some(if there { depth.max(0.0) } else { 0.0 })
    }

    /// Direction in which the target goes: of its velocity when it moves, else of its box, rad.
    pub fn course(&self) -> f64 {
        if self.speed() >= 0.5 { self.velocity.heading() } else { self.footprint.heading }
    }
}

/// What a placement is made from.
pub struct Surroundings<'a> {
    /// The ego.
    pub ego: &'a EgoMotion,
    /// Its path.
    pub path: &'a DrivenPath,
    /// Its lanes, when there is a map.
    pub lanes: Option<&'a EgoLane>,
}


fn corner_reach(footprint: &OrientedBox) -> f64 {
    footprint.radius() + 3.0
}

impl Surroundings<'_> {
    /// Places `track` in all its rows; `times` in seconds by frame.
    pub fn place<'t>(&self, track: &'t Track, times: &[f64]) -> Target<'t> {
        let m = &track.motion;
        let row_times: Vec<f64> = track.frames.iter().map(|&f| times[f as usize]).collect();
        let forward: Vec<f64> = (0..m.len()).map(|r| m.forward_speed(r)).collect();
        let places = (0..m.len()).map(|row| self.at(track, row)).collect();
        Target { track, accel: given_or_slope(&m.accel, &row_times, &forward), places }
    }

    fn at(&self, track: &Track, row: usize) -> Option<Placement> {
        let frame = track.frames[row] as usize;
        let m = &track.motion;
        let centre = p2(m.x[row], m.y[row]);
        if !self.ego.is_known(frame) || !centre.is_finite() {
            return None;
        }
        let footprint =
            OrientedBox { centre, heading: wrap(m.heading[row]), length: track.length_m[row], width: track.width_m[row] };
        let sized = footprint.length.is_finite() && footprint.width.is_finite() && footprint.heading.is_finite();
        let ego_s = self.path.ego_s[frame];
        let on_path = self.path.project_near(centre, ego_s);
        let (mut near, mut far) = (on_path.s, on_path.s);
        let mut beside = Beside {
            lateral: on_path.lateral,
            low: on_path.lateral,
            high: on_path.lateral,
            heading: self.path.heading_at(on_path.s),
        };
        if sized {
            let reach = corner_reach(&footprint);
            for corner in footprint.corners() {
                let at = self.path.line.project_between(corner, on_path.s - reach, on_path.s + reach);
                near = near.min(at.s);
                far = far.max(at.s);
                beside.low = beside.low.min(at.lateral);
                beside.high = beside.high.max(at.lateral);
            }
        }
        let lane = self.lanes.and_then(|l| l.at(frame)).map(|on| {
            let at = on.corridor.line.project_between(centre, on.s - 105.0, on.s + 155.0);
            let (low, high) =
                if sized { lateral_extent(on.corridor, &footprint, at.s) } else { (at.lateral, at.lateral) };
            let heading = on.corridor.line.smooth_heading_at(at.s, 2.0);
            let (left, right) = on.corridor.widths_at(at.s);
            (Beside { lateral: at.lateral, low, high, heading }, left, right)
        });
        let (z, path_z) = (m.z[row], self.path.z_at(on_path.s));
        // Where the path is only continued, the road may climb: 6 % over the distance beyond what was driven.
        let beyond = (on_path.s - self.path.driven.1).max(self.path.driven.0 - on_path.s).max(0.0);
        let off_level = (z - path_z).abs() > LEVEL_M + 0.06 * beyond;
        Some(Placement {
            frame,
            footprint,
            velocity: p2(m.vx[row], m.vy[row]),
            ahead: on_path.s - ego_s,
            near: near - ego_s,
            far: far - ego_s,
            path: beside,
            lane,
            same_level: !off_level,
            heading_at_ego: self.path.heading_at(ego_s),
        })
    }
}
