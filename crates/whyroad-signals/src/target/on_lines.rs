//! Position of a box along and beside the ego's path and the ego's lane. A stationary object has the same position as
//! in the row before: then only the parts of the lines that the ego has come near since are searched, and results for
//! the same foot point are reused. The result equals a complete search.

use crate::geometry::{Foot, Nearby, OrientedBox, P2, Polyline, Projection, Window};
use crate::road::corridor::Corridor;
use crate::road::ego_lane::{EgoLane, OnCorridor, lateral_extent};
use crate::road::path::DrivenPath;

/// Minimum speed across the lane for approaching its edge, m/s.
pub const LATERAL_LEAST_MPS: f64 = 0.05;
/// Where a box is farther than this beside the ego's lane and the ego, m, it has no part in them.
const CLEAR_M: f64 = 2.0;

/// A position beside a line: signed distances, left positive, m.
#[derive(Clone, Copy, Debug)]
pub struct Beside {
    /// Of the center.
    pub lateral: f64,
    /// Of the rightmost corner; a bound far beside the lane, see [`OnLane`].
    pub low: f64,
    /// Of the leftmost corner; likewise.
    pub high: f64,
    /// Direction of the line there, rad.
    pub heading: f64,
}

/// A box beside the ego's lines.
pub struct OnLines<'a> {
    footprint: OrientedBox,
    /// Foot point of its center on the path.
    pub foot: Foot,
    /// First and last arc length of the box along the path, m, and its position beside it.
    pub extents: (f64, f64, Beside),
    /// Beside the ego's lane; `None` while it has none.
    pub lane: Option<OnLane<'a>>,
}

/// A box beside the ego's lane.
pub struct OnLane<'a> {
    corridor: &'a Corridor,
    /// Foot point of its center on the lane's line.
    pub foot: Foot,
    /// Its position, and the distances from the lane's line to the left and right edge there, m. Of a box that is
    /// clear of the lane and of the ego in it, and does not move towards the lane, the corners are bounds: those of the
    /// circle around it. No signal depends on how far they are outside.
    pub beside: (Beside, f64, f64),
    /// Velocity across the lane, towards its center line positive, m/s.
    pub lateral_speed: f64,
    has_corners: bool,
}

/// The ego on its lines in one frame, and where on them targets are sought: the same for all targets.
pub struct EgoOnLines<'a> {
    /// The part of the path.
    path: Window,
    /// Its place on its lane, and the part of the lane; `None` while it has none.
    pub lane: Option<(OnCorridor<'a>, Window)>,
    /// Maximum distance of its corners from its lane's line, m.
    reach: f64,
}

impl<'a> EgoOnLines<'a> {
    /// In a frame in which the ego's pose is known; `radius` is that of its box.
    pub fn new(path: &DrivenPath, lanes: Option<&'a EgoLane>, frame: usize, radius: f64) -> Self {
        let on = lanes.and_then(|l| l.at(frame));
        let window = |on: OnCorridor<'a>| (on, on.corridor.line.window(on.s - 105.0, on.s + 155.0));
        let reach = on.map_or(0.0, |on| on.lateral.abs() + radius);
        Self { path: path.window_near(path.ego_s[frame]), lane: on.map(window), reach }
    }
}

/// The foot point of `place`; `before` is that of an earlier position.
fn foot_of(line: &Polyline, place: P2, window: Window, before: Option<(P2, &Foot)>) -> Foot {
    match before {
        Some((same, foot)) if same.has_bits_of(place) => line.foot_again(place, window, foot),
        before => line.foot(place, window, before.map(|(_, foot)| foot)),
    }
}

/// The part of the path on which parts of a footprint with this center can be.
pub fn around_foot(path: &DrivenPath, footprint: &OrientedBox, at: &Projection) -> Nearby {
    let radius = footprint.radius();
    path.line.nearby(at.s, radius + 3.0, (footprint.center, radius))
}

/// Extents of a footprint along and beside the path around its foot point: first and last arc length, and position.
pub fn extents(path: &DrivenPath, footprint: &OrientedBox, at: &Projection) -> (f64, f64, Beside) {
    let heading = path.heading_at(at.s);
    let mut beside = Beside { lateral: at.lateral, low: at.lateral, high: at.lateral, heading };
    let (mut near, mut far) = (at.s, at.s);
    let nearby = around_foot(path, footprint, at);
    for on in path.line.project_each(footprint.corners(), &nearby) {
        (near, far) = (near.min(on.s), far.max(on.s));
        (beside.low, beside.high) = (beside.low.min(on.lateral), beside.high.max(on.lateral));
    }
    (near, far, beside)
}

impl<'a> OnLines<'a> {
    /// Position of a box with this velocity; the flag states whether it has a direction and an extent. `before` is the
    /// result for the same object in another frame.
    pub fn new(
        path: &DrivenPath,
        ego: &EgoOnLines<'a>,
        (footprint, sized): (OrientedBox, bool),
        velocity: P2,
        before: Option<&OnLines<'a>>,
    ) -> Self {
        let center = footprint.center;
        let same = before.filter(|b| b.footprint.has_bits_of(&footprint));
        let foot = foot_of(&path.line, center, ego.path, before.map(|b| (b.footprint.center, &b.foot)));
        let extents = match same.filter(|b| b.foot.at == foot.at) {
            Some(before) => before.extents,
            None if sized => extents(path, &footprint, &foot.at),
            None => {
                let (s, lateral) = (foot.at.s, foot.at.lateral);
                let heading = path.heading_at(s);
                (s, s, Beside { lateral, low: lateral, high: lateral, heading })
            }
        };
        let lane = ego.lane.as_ref().map(|&(OnCorridor { corridor, .. }, window)| {
            let last = before.and_then(|b| Some((b, b.lane.as_ref()?)));
            let last = last.filter(|(_, lane)| std::ptr::eq(lane.corridor, corridor));
            let line = &corridor.line;
            let foot = foot_of(line, center, window, last.map(|(b, lane)| (b.footprint.center, &lane.foot)));
            let known = last.filter(|(_, lane)| same.is_some() && lane.foot.at == foot.at);
            let known = known.map(|(_, lane)| (lane.beside, lane.has_corners));
            let (mut beside, mut has_corners) =
                known.unwrap_or_else(|| (beside_lane(corridor, &footprint, sized, &foot), !sized));
            let lateral_speed = speed_towards(&beside.0, velocity);
            if !has_corners && !is_clear(&beside, &footprint, lateral_speed, ego.reach) {
                (beside.0.low, beside.0.high) = lateral_extent(corridor, &footprint, foot.at.s);
                has_corners = true;
            }
            OnLane { corridor, foot, beside, lateral_speed, has_corners }
        });
        OnLines { footprint, foot, extents, lane }
    }

    /// True if the same box was found at the same position on the path.
    pub fn is_where(&self, other: &OnLines<'_>) -> bool {
        self.footprint.has_bits_of(&other.footprint) && self.foot.at == other.foot.at
    }
}

/// The position beside the lane with bounds of the corners.
fn beside_lane(corridor: &Corridor, footprint: &OrientedBox, sized: bool, foot: &Foot) -> (Beside, f64, f64) {
    let (s, lateral) = (foot.at.s, foot.at.lateral);
    let radius = if sized { footprint.radius() } else { 0.0 };
    let heading = corridor.line.smooth_heading_at(s, 2.0);
    let (left, right) = corridor.widths_at(s);
    (Beside { lateral, low: lateral - radius, high: lateral + radius, heading }, left, right)
}

/// Velocity across the lane at a position, towards its center line positive, m/s.
fn speed_towards(at: &Beside, velocity: P2) -> f64 {
    let across = velocity.dot(P2::from_heading(at.heading).left());
    if at.lateral > 0.0 { -across } else { across }
}

/// True for a box that is apart from the lane, and from the ego in it, and does not come nearer to the lane: it is not
/// in the lane, not over its edge, and not in the ego's way along it, wherever its corners are.
fn is_clear(
    (at, left, right): &(Beside, f64, f64),
    footprint: &OrientedBox,
    lateral_speed: f64,
    ego_reach: f64,
) -> bool {
    let nearest = at.lateral.abs() - footprint.radius() - CLEAR_M;
    // Unknown values are not clear.
    lateral_speed < LATERAL_LEAST_MPS && nearest > *left && nearest > *right && nearest > ego_reach
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ego::motion::EgoMotion;
    use crate::geometry::p2;
    use whyroad_model::scene::{Ego, Motion};

    #[test]
    fn what_is_remembered_changes_nothing() {
        // The ego drives through two loops, at 8 m/s, and is stationary in between.
        let n = 300;
        let times: Vec<f64> = (0..n).map(|i| f64::from(i) * 0.1).collect();
        let turned: Vec<f64> = (0..n).map(|i| 0.04 * f64::from(i.min(120) + (i - 180).max(0))).collect();
        let motion = Motion {
            x: turned.iter().map(|a| 20.0 * a.sin()).collect(),
            y: turned.iter().map(|a| 20.0 - 20.0 * a.cos() + 0.5 * a).collect(),
            heading: turned.clone(),
            ..Motion::unknown(n as usize)
        };
        let ego = Ego { motion, length_m: 4.7, width_m: 1.9, ..Ego::default() };
        let ego = EgoMotion::new(&ego, &times);
        let path = DrivenPath::new(&ego, &times, None, None).unwrap();
        for k in 0..40_i32 {
            // Stationary, turns on the spot, drives off, loses its size.
            let (x, y) = (f64::from(k % 8) * 9.0 - 30.0, f64::from(k / 8) * 12.0 - 10.0);
            let mut before: Option<OnLines<'_>> = None;
            for frame in 0..n {
                let away = 0.7 * f64::from((frame - 200).max(0));
                let heading = f64::from(k) + 0.01 * f64::from((frame - 100).clamp(0, 30));
                let length = if frame == 250 { f64::NAN } else { 4.0 };
                let footprint = OrientedBox::new(p2(x + away, y), heading, length, 2.0);
                let own = EgoOnLines::new(&path, None, frame as usize, 2.5);
                let all = |before| {
                    let sized = length.is_finite();
                    let found = OnLines::new(&path, &own, (footprint, sized), P2::default(), before);
                    (format!("{:?} {:?}", found.foot.at, found.extents), found)
                };
                let (expected, _) = all(None);
                let (remembered, found) = all(before.as_ref());
                assert_eq!(remembered, expected, "{k} {frame}");
                before = Some(found);
            }
        }
    }
}
