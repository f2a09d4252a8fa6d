//! Position of each target in each frame, computed once for all signals: in the ego's axes, along and beside the ego's
//! driven path, and along and beside the ego's lane.

use crate::ego::motion::{EgoMotion, STANDSTILL_RELEASE_MPS, STANDSTILL_SET_MPS, given_or_slope};
use crate::estimate::{Deviations, footprint};
use crate::geometry::{LastPlace, OrientedBox, P2, p2, wrap};
use crate::road::ego_lane::EgoLane;
use crate::road::network::{DEFAULT_HALF_WIDTH_M, Road};
use crate::road::path::DrivenPath;
use crate::series::below_with_hysteresis;
use crate::target::band::{Band, Outline, PATH_MARGIN_M};
use crate::target::on_lines::{EgoOnLines, OnLines, extents};
use std::cell::OnceCell;
use whyroad_model::Tri;
use whyroad_model::scene::{Motion, Track};

pub use crate::target::on_lines::Beside;

/// Minimum speed of a moving target, m/s.
pub const MOVING_MPS: f64 = 0.5;

/// One target over its observed rows.
pub struct Target<'a> {
    /// The track.
    pub track: &'a Track,
    /// Seconds of its rows.
    pub times: Vec<f64>,
    /// Speed over ground, m/s.
    pub speed: Vec<f64>,
    /// Velocity along its heading, m/s, negative in reverse.
    pub forward_speed: Vec<f64>,
    /// Forward acceleration, m/s2.
    pub accel: Vec<f64>,
    /// As [`EgoMotion::standstill`].
    pub standstill: Vec<Tri>,
    /// One entry per row of the track; `None` where the ego's or the target's pose is unknown.
    pub places: Vec<Option<Placement>>,
    /// Standard deviations of its states; `None` where they are exact.
    pub sd: Option<&'a Deviations>,
    /// See [`Target::is_in_junction`].
    in_junction: OnceCell<Vec<bool>>,
}

impl Target<'_> {
    /// True if its center is in a junction in a row of its track. Several families ask this of all rows; it is computed
    /// for all of them when the first one does.
    pub fn is_in_junction(&self, road: &Road, row: usize) -> bool {
        let of_all = || {
            let (m, last) = (&self.track.motion, LastPlace::new());
            let at = |row: usize| p2(m.x[row], m.y[row]);
            (0..m.len()).map(|row| last.at(at(row), || road.in_junction(at(row)))).collect()
        };
        self.in_junction.get_or_init(of_all)[row]
    }
}

/// Position of a target in one frame.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// The frame.
    pub frame: usize,
    /// Box on the ground; sizes may be NaN.
    pub footprint: OrientedBox,
    /// Velocity over ground, m/s, world.
    pub velocity: P2,
    /// Arc length from the ego's center to the target's along the path, forward positive, m.
    pub ahead: f64,
    /// The same to its nearest corner, m; the center where sizes are unknown.
    pub near: f64,
    /// The same to its farthest corner, m.
    pub far: f64,
    /// Beside the driven path.
    pub path: Beside,
    /// Beside the ego's lane, with the distances to its left and right edge; `None` while the ego has none.
    pub lane: Option<(Beside, f64, f64)>,
    /// Arc length from the ego's center to the target's along the ego's lane, m; NaN while the ego has none.
    pub lane_ahead: f64,
    /// Velocity across the ego's lane, towards its center line positive, m/s; NaN while the ego has none.
    pub lane_lateral_speed: f64,
    /// Nearest and farthest arc length (from the ego's center) of the part of the footprint inside the band that the
    /// ego sweeps along its path, m; `None` if no part is.
    pub band: Option<(f64, f64)>,
    /// In the ego's lane or way, see [`Placement::center_in_way`]; inside junctions, where no lines are drawn, a target
    /// that was in the lane stays in it until its whole footprint has left.
    pub in_way: bool,
    /// In a junction, where drivers cut the bends of the lanes: on the way that the ego drives, beside its lane.
    pub cuts_lane: bool,
    /// The ego can pass it within its lane, or no lane is known.
    pub leaves_room: bool,
    /// Height, m; NaN if it is unknown.
    pub z: f64,
    /// At the height of the ego's path.
    pub same_level: bool,
    /// Direction of the path at the ego's position, rad.
    pub heading_at_ego: f64,
    /// Shortest distance between the boxes of the ego and the target, m; NaN where the target's box is unknown.
    pub distance: f64,
    /// Beside the ego: apart from its box, with an end that is not ahead of its front. False where the target's size is
    /// unknown.
    pub beside_ego: bool,
    /// Gap and closing speed, by [`crate::target::approach::place`].
    pub approach: Approach,
    going: Going,
}

/// Gap and closing speed of one row.
#[derive(Clone, Copy, Debug)]
pub struct Approach {
    /// From [`crate::target::gaps::gap`], m; NaN where it is unknown.
    pub gap: f64,
    /// Closing speed along the path, m/s; 0 if the two will not meet there.
    pub closing: f64,
}

/// Motion of a target in one frame, which many signals use in every row.
#[derive(Clone, Copy, Debug)]
struct Going {
    speed: f64,
    direction: f64,
    course: f64,
    turned: f64,
}

impl Going {
    fn new(velocity: P2, heading: f64, path_heading: f64) -> Self {
        let (speed, direction) = (velocity.norm(), velocity.heading());
        let course = if speed >= MOVING_MPS { direction } else { heading };
        Self { speed, direction, course, turned: wrap(course - path_heading).abs() }
    }
}

impl Placement {
    /// True when the box is known: its size and its heading.
    pub fn is_sized(&self) -> bool {
        self.footprint.is_known()
    }

    /// In the ego's lane, and not stationary at its side with room for the ego to pass within the lane: lanes with room
    /// for parking are drawn as wide lanes. A stationary target in the center of a lane blocks it, even if the ego
    /// changes lanes later.
    pub fn blocks_way(&self) -> bool {
        let may_pass = self.leaves_room && self.band.is_none();
        self.in_way && (!may_pass || self.speed() >= MOVING_MPS)
    }

    /// Speed over ground, m/s.
    pub fn speed(&self) -> f64 {
        self.going.speed
    }

    /// Direction of its velocity, rad.
    pub fn direction(&self) -> f64 {
        self.going.direction
    }

    /// The ego's lane if there is one and the target does not cut it, else a band along the driven path: position and
    /// edges.
    pub fn way(&self) -> (Beside, f64, f64) {
        let lane = self.lane.filter(|_| !self.cuts_lane);
        lane.unwrap_or((self.path, DEFAULT_HALF_WIDTH_M, DEFAULT_HALF_WIDTH_M))
    }

    /// True when the center is between the edges of [`Placement::way`], on its level and within reach.
    fn center_in_way(&self) -> bool {
        let (at, left, right) = self.way();
        let inside = at.lateral <= left && at.lateral >= -right;
        self.same_level && self.within_reach() && inside && self.is_as_far_by_lane()
    }

    /// False for a target that is beside the path here and in the ego's lane only where the lane comes back, as behind
    /// a U-turn: oncoming traffic. True if there is no lane.
    fn is_as_far_by_lane(&self) -> bool {
        let detour = (self.lane_ahead - self.ahead).abs();
        self.cuts_lane || detour.is_nan() || detour <= MOST_DETOUR_M + MOST_DETOUR * self.ahead.abs()
    }

    /// True within 150 m ahead and 100 m behind: farther targets have no relation to the ego.
    pub fn within_reach(&self) -> bool {
        self.near <= 150.0 && self.far >= -100.0
    }

    /// Distance of the innermost side over the edge into the ego's lane, never negative, m. `None` without a lane or a
    /// size.
    pub fn intrusion(&self) -> Option<f64> {
        let (at, left, right) = self.lane?;
        if !self.is_sized() {
            return None;
        }
        let depth = if at.lateral > 0.0 { left - at.low } else { right + at.high };
        let there = self.same_level && self.within_reach();
        Some(if there { depth.max(0.0) } else { 0.0 })
    }

    /// Direction of the target's motion: of its velocity if it moves, else of its box, rad.
    pub fn course(&self) -> f64 {
        self.going.course
    }

    /// Angle between its course and the path at its position, 0 to pi.
    pub fn turned(&self) -> f64 {
        self.going.turned
    }
}

/// Rows of its track in which a target is placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlacedRows {
    /// In all.
    All,
    /// In the last one.
    Last,
    /// In none: for signals that need no placement.
    None,
}

/// Input of a placement.
pub struct Surroundings<'a> {
    /// The ego.
    pub ego: &'a EgoMotion,
    /// Its path.
    pub path: &'a DrivenPath,
    /// Its lanes, when there is a map.
    pub lanes: Option<&'a EgoLane>,
    /// The road, when there is a map.
    pub road: Option<&'a Road>,
    /// By frame: the first of the frames up to it in which all of the ego's state has the same bits.
    still_since: Vec<usize>,
    /// By frame: the ego on its path and its lane; `None` while its pose is unknown.
    own: Vec<Option<EgoOnLines<'a>>>,
}

/// Velocity along the heading and speed of each row, m/s.
fn speeds(m: &Motion) -> (Vec<f64>, Vec<f64>) {
    let state = |row: usize| [m.heading[row], m.vx[row], m.vy[row]].map(f64::to_bits);
    let mut last: Option<([u64; 3], (f64, f64))> = None;
    let each = (0..m.len()).map(|row| {
        // What stands mostly has the state of the row before.
        let known = last.filter(|(same, _)| *same == state(row)).map(|(_, speeds)| speeds);
        let speeds = known.unwrap_or_else(|| (m.forward_speed(row), m.speed(row)));
        last = Some((state(row), speeds));
        speeds
    });
    each.unzip()
}

/// Results of a row, with which the next one starts.
#[derive(Default)]
struct Before<'a> {
    on: Option<OnLines<'a>>,
    outline: Outline,
    /// The row of the track, and its placement.
    place: Option<(usize, Placement)>,
}

/// Maximum difference between the lengths of a lane and of the driven path that follows it, m, and as a factor of the
/// distance: lines drawn with corners, lanes on the outside of bends.
const MOST_DETOUR_M: f64 = 15.0;
const MOST_DETOUR: f64 = 0.25;
/// Minimum half width of a car, m.
const LEAST_HALF_WIDTH_M: f64 = 0.75;

impl<'a> Surroundings<'a> {
    /// Around the ego on its path.
    pub fn new(
        ego: &'a EgoMotion,
        path: &'a DrivenPath,
        lanes: Option<&'a EgoLane>,
        road: Option<&'a Road>,
    ) -> Self {
        let state = |frame: usize| {
            let at = ego.position[frame];
            let own = [at.x, at.y, ego.heading[frame], path.ego_s[frame], path.ego_heading[frame]];
            let lane = lanes.and_then(|l| l.at(frame));
            (own.map(f64::to_bits), lane.map(|on| (std::ptr::from_ref(on.corridor), on.s.to_bits())))
        };
        let mut still_since: Vec<usize> = (0..ego.len()).collect();
        for frame in 1..ego.len() {
            if state(frame) == state(frame - 1) {
                still_since[frame] = still_since[frame - 1];
            }
        }
        let on_lines = |frame| EgoOnLines::new(path, lanes, frame, ego.footprint(frame).radius());
        let own = (0..ego.len()).map(|frame| ego.is_known(frame).then(|| on_lines(frame))).collect();
        Self { ego, path, lanes, road, still_since, own }
    }

    /// Places `track` in these of its rows, without gaps and closing speeds, which [`crate::target::approach::place`]
    /// adds; `times` in seconds by frame.
    pub(super) fn place<'t>(&self, track: &'t Track, times: &[f64], rows: PlacedRows) -> Target<'t> {
        let m = &track.motion;
        let times: Vec<f64> = track.frames.iter().map(|&f| times[f as usize]).collect();
        let (forward_speed, speed) = speeds(m);
        let places = match rows {
            PlacedRows::All => self.all_rows(track),
            PlacedRows::Last => self.last_row(track),
            PlacedRows::None => vec![None; m.len()],
        };
        let accel = given_or_slope(&m.accel, &times, &forward_speed);
        let standstill = below_with_hysteresis(&speed, STANDSTILL_SET_MPS, STANDSTILL_RELEASE_MPS);
        Target {
            track,
            times,
            speed,
            forward_speed,
            accel,
            standstill,
            places,
            sd: None,
            in_junction: OnceCell::new(),
        }
    }

    fn all_rows(&self, track: &Track) -> Vec<Option<Placement>> {
        let mut before = Before::default();
        let mut places: Vec<Option<Placement>> =
            (0..track.motion.len()).map(|row| self.at(track, row, &mut before)).collect();
        let mut was_in_way = false;
        for p in places.iter_mut().flatten() {
            p.in_way = p.center_in_way() || (was_in_way && self.is_held_in_way(p));
            was_in_way = p.in_way;
        }
        places
    }

    /// The last of [`Surroundings::all_rows`]; the others are `None`. Earlier rows are only used to determine whether
    /// the target was in the ego's way.
    fn last_row(&self, track: &Track) -> Vec<Option<Placement>> {
        let mut places = vec![None; track.motion.len()];
        let mut before = Before::default();
        let mut rows = (0..places.len()).rev();
        let Some(mut last) = rows.next().and_then(|row| self.at(track, row, &mut before)) else {
            return places;
        };
        last.in_way = last.center_in_way();
        let mut held = !last.in_way && self.is_held_in_way(&last);
        while held && let Some(row) = rows.next() {
            // A row without a position changes nothing.
            if let Some(p) = self.at(track, row, &mut before) {
                last.in_way = p.center_in_way();
                held = !last.in_way && self.is_held_in_way(&p);
            }
        }
        if let Some(place) = places.last_mut() {
            *place = Some(last);
        }
        places
    }

    /// Inside junctions, where no lines are drawn, a target that was in the ego's way stays in it until its whole
    /// footprint has left.
    fn is_held_in_way(&self, p: &Placement) -> bool {
        p.intrusion().is_some_and(|d| d > 0.0) && self.road.is_some_and(|r| r.in_junction(p.footprint.center))
    }

    /// The band that the ego sweeps while its center is at `ego_s`.
    fn band(&self, ego_s: f64) -> Band<'_> {
        Band { path: self.path, ego_s, ego_length: self.ego.length, ego_width: self.ego.width }
    }

    /// True when the target, at constant velocity, is in the swept band at the ego's position after `seconds`.
    pub fn meets(&self, p: &Placement, seconds: f64) -> bool {
        let ego_s = self.path.ego_s[p.frame] + self.ego.forward_speed[p.frame] * seconds;
        let footprint = p.footprint.moved_to(p.footprint.center + p.velocity * seconds);
        let at = self.path.project_near(footprint.center, ego_s);
        let (_, _, beside) = extents(self.path, &footprint, &at);
        let front = ego_s + self.ego.length / 2.0;
        // A tolerance of one meter: the gap was closed along the path, which is not exactly the target's path.
        self.band(ego_s)
            .part_of(&footprint, &at, &beside, &mut Outline::default())
            .is_some_and(|(near, far)| near <= front + 1.0 && far >= ego_s - self.ego.length / 2.0)
    }

    /// [`Placement::distance`] of `track` in a row, without placing it; NaN where it has no placement.
    pub fn distance(&self, track: &Track, row: usize) -> f64 {
        let (frame, footprint) = (track.frames[row] as usize, footprint(track, row));
        if self.ego.is_known(frame) && footprint.center.is_finite() {
            self.distance_of(frame, &footprint)
        } else {
            f64::NAN
        }
    }

    /// Distance of the ego's box and another one, m; NaN where the other one is unknown.
    fn distance_of(&self, frame: usize, footprint: &OrientedBox) -> f64 {
        if footprint.is_known() { self.ego.footprint(frame).distance(footprint) } else { f64::NAN }
    }

    /// `before` is the result for the row before, and then for this one.
    fn at(&self, track: &Track, row: usize, before: &mut Before<'a>) -> Option<Placement> {
        let frame = track.frames[row] as usize;
        let m = &track.motion;
        let center = p2(m.x[row], m.y[row]);
        let own = self.own[frame].as_ref().filter(|_| center.is_finite())?;
        if let Some((same, place)) = &before.place
            && self.stand(track, (*same, place.frame), (row, frame))
        {
            return Some(Placement { frame, ..*place });
        }
        let footprint = footprint(track, row);
        let sized = footprint.is_known();
        let velocity = p2(m.vx[row], m.vy[row]);
        let found = OnLines::new(self.path, own, (footprint, sized), velocity, before.on.as_ref());
        if !before.on.as_ref().is_some_and(|before| before.is_where(&found)) {
            before.outline.clear();
        }
        let on = &*before.on.insert(found);
        let (ego_s, on_path) = (self.path.ego_s[frame], on.foot.at);
        let (near, far, beside) = on.extents;
        let part = || self.band(ego_s).part_of(&footprint, &on_path, &beside, &mut before.outline);
        let band = sized.then(part).flatten();
        let lane = on.lane.as_ref().map(|lane| lane.beside);
        let lane_ahead = match (&on.lane, &own.lane) {
            (Some(lane), Some((own, _))) => lane.foot.at.s - own.s,
            _ => f64::NAN,
        };
        let (z, path_z) = (m.z[row], self.path.z_at(on_path.s));
        let off_level = (z - path_z).abs() > self.path.level_at(on_path.s);
        let needed = self.ego.width + 2.0 * PATH_MARGIN_M;
        // Minimum width of an object whose width is unknown.
        let side = if sized { 0.0 } else { LEAST_HALF_WIDTH_M };
        let leaves_room = lane.is_none_or(|(at, left, right)| {
            let room = (left - at.high).max(right + at.low) - side;
            room.is_nan() || room >= needed
        });
        let beside_lane = lane.is_some_and(|(at, left, right)| at.lateral > left || at.lateral < -right);
        let cuts_lane = beside_lane
            && on_path.lateral.abs() <= DEFAULT_HALF_WIDTH_M
            && self.road.is_some_and(|road| road.in_junction(center));
        let lane_lateral_speed = on.lane.as_ref().map_or(f64::NAN, |lane| lane.lateral_speed);
        let distance = self.distance_of(frame, &footprint);
        let place = Placement {
            frame,
            footprint,
            velocity,
            going: Going::new(velocity, footprint.heading, beside.heading),
            ahead: on_path.s - ego_s,
            near: near - ego_s,
            far: far - ego_s,
            path: beside,
            lane,
            lane_ahead,
            lane_lateral_speed,
            band: band.map(|(low, high)| (low - ego_s, high - ego_s)),
            in_way: false,
            cuts_lane,
            distance,
            beside_ego: distance > 0.0 && near - ego_s <= self.ego.length / 2.0,
            approach: Approach { gap: f64::NAN, closing: f64::NAN },
            leaves_room,
            z,
            same_level: !off_level,
            heading_at_ego: self.path.ego_heading[frame],
        };
        before.place = Some((row, place));
        Some(place)
    }

    /// True if the states of the target and of the ego have the same bits in two rows and their frames: then the
    /// placements are equal.
    fn stand(&self, track: &Track, a: (usize, usize), b: (usize, usize)) -> bool {
        let m = &track.motion;
        let columns = [&m.x, &m.y, &m.z, &m.heading, &m.vx, &m.vy, &track.length_m, &track.width_m];
        self.still_since[a.1] == self.still_since[b.1]
            && columns.iter().all(|column| column[a.0].to_bits() == column[b.0].to_bits())
    }
}
