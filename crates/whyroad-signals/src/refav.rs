//! RefAV's functions with its own definitions and thresholds (`refAV/atomic_functions.py`), applied to the ego, so that
//! the results of both can be compared. Its median filter over seven positions is left out, because it works along the
//! world's axes and would make a result depend on their orientation; and exactly 180 deg is opposite.

pub mod turning;

use crate::ego::motion::EgoMotion;
use crate::geometry::{NearAreas, P2, p2, wrap};
use crate::road::network::{LaneShape, Road};
use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use crate::target::placement::{Placement, Target};
use crate::target::rows::Rows;
use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_4, PI};
use whyroad_model::catalog::{
    id,
    value::{TargetRefavHeading, TargetRefavRelativeDirection},
};
use whyroad_model::road_map::LaneKind;
use whyroad_model::scene::Motion;
use whyroad_model::{ObjectClass, Tri};

/// Maximum distance of objects with a relative direction, box to box, m.
const DIRECTION_REACH_M: f64 = 50.0;
/// Maximum distance of following ahead of the front, m.
pub(crate) const FOLLOWING_M: f64 = 25.0;
/// ... and beside, m.
pub(crate) const FOLLOWING_BESIDE_M: f64 = 5.0;
/// ... and minimum cosine of the angle between directions.
pub(crate) const FOLLOWING_COS: f64 = 0.5;
/// Minimum speed at which the velocity is the direction, m/s.
pub(crate) const HEADING_SPEED_MPS: f64 = 0.5;
/// Maximum distance of crossing ahead of the front, m.
const CROSSED_AHEAD_M: f64 = 10.0;
/// ... and beside, m.
const CROSSED_BESIDE_M: f64 = 5.0;
/// ... and minimum lateral speed, m/s.
const CROSSED_MPS: f64 = 0.2;
/// A track whose bounding diagonal is shorter is stationary, m.
const STATIONARY_M: f64 = 3.0;
/// Maximum distance from a junction lane for being near an intersection, m.
const INTERSECTION_M: f64 = 5.0;
/// Minimum speed of a motion with a direction, m/s.
pub(crate) const DIRECTED_MPS: f64 = 1.0;

/// The ego's velocity by frame: its length, m/s, and its directions.
struct Own {
    speed: f64,
    /// rad.
    heading: f64,
    /// Of the ego, by [`direction`].
    way: P2,
}

impl Own {
    fn new(ego: &EgoMotion, frame: usize) -> Self {
        let velocity = ego.velocity[frame];
        let way = direction(velocity, ego.heading[frame]);
        Self { speed: velocity.norm(), heading: velocity.heading(), way }
    }
}

/// A vector of the world in the ego's axes, x forward, y left.
fn in_ego_axes(scene: &Interaction<'_>, frame: usize, v: P2) -> P2 {
    let forward = scene.around.ego.footprint(frame).direction();
    p2(v.dot(forward), v.dot(forward.left()))
}

fn seen_at(scene: &Interaction<'_>, p: &Placement) -> P2 {
    in_ego_axes(scene, p.frame, p.footprint.center - scene.around.ego.position[p.frame])
}

fn relative_direction(scene: &Interaction<'_>, p: &Placement) -> Option<TargetRefavRelativeDirection> {
    let ego = scene.around.ego;
    if !p.is_sized() {
        return None;
    }
    let (at, front, side) = (seen_at(scene, p), ego.length / 2.0, ego.width / 2.0);
    Some(if p.distance > DIRECTION_REACH_M {
        TargetRefavRelativeDirection::None
    } else if at.x > front {
        TargetRefavRelativeDirection::Front
    } else if at.x < -front {
        TargetRefavRelativeDirection::Back
    } else if at.y > side {
        TargetRefavRelativeDirection::Left
    } else if at.y < -side {
        TargetRefavRelativeDirection::Right
    } else {
        TargetRefavRelativeDirection::None
    })
}

/// Lanes of a target: the assigned one, else all that contain its center.
fn lanes_of(scene: &Interaction<'_>, road: &Road, k: usize, r: usize, center: P2) -> Vec<usize> {
    if let Some(place) = scene.lanes().and_then(|l| l.at(k, r)) {
        return vec![place.lane];
    }
    let holds = |&i: &usize| {
        let lane = &road.lanes[i];
        lane.kind != LaneKind::Sidewalk && lane.area.as_ref().is_some_and(|a| a.contains(center))
    };
    road.lanes_near(center, 0.0).into_iter().filter(holds).collect()
}

/// Direction of an object: its velocity if it moves, else its heading.
pub(crate) fn direction(velocity: P2, heading: f64) -> P2 {
    let speed = velocity.norm();
    if speed > HEADING_SPEED_MPS { velocity * (1.0 / speed) } else { P2::from_heading(heading) }
}

/// [`direction`] of a target.
fn direction_of(p: &Placement) -> P2 {
    if p.speed() > HEADING_SPEED_MPS { p.velocity * (1.0 / p.speed()) } else { p.footprint.direction() }
}

fn following(scene: &Interaction<'_>, road: &Road, way: P2, (k, r): (usize, usize), p: &Placement) -> Tri {
    let ego = scene.around.ego;
    let Some(on) = scene.around.lanes.and_then(|l| l.at(p.frame)) else { return Tri::Unknown };
    if !p.is_sized() || !p.velocity.is_finite() {
        return Tri::Unknown;
    }
    let (at, front) = (seen_at(scene, p), ego.length / 2.0);
    if at.x <= front || at.x >= FOLLOWING_M + front {
        return Tri::False;
    }
    let alike = way.dot(direction_of(p)) > FOLLOWING_COS;
    if !alike {
        return Tri::False;
    }
    let own = &road.lanes[on.lane];
    let here = lanes_of(scene, road, k, r, p.footprint.center);
    let same = here.iter().any(|&l| l == on.lane || own.successors.contains(&l));
    let beside = here.iter().any(|&l| own.neighbors.contains(&Some(l)));
    let half = p.footprint.width / 2.0;
    let reaches_in = [at.y + half, at.y - half].iter().any(|side| side.abs() <= ego.width / 2.0);
    Tri::from((same && at.y.abs() < FOLLOWING_BESIDE_M) || (beside && reaches_in))
}

/// An object in one row relative to another: the position of its center and its lateral speed (to the left), in the
/// axes of the other one, whose half length and half width are `front` and `side`; m, m/s.
pub(crate) struct Passing {
    pub row: usize,
    pub at: P2,
    pub across: f64,
    pub front: f64,
    pub side: f64,
}

/// The rows in which an object crosses in front of another one, among those in which it is observed, in order.
pub(crate) fn crossing(seen: &[Passing]) -> BTreeSet<usize> {
    let mut rows = BTreeSet::new();
    for (i, pair) in seen.windows(2).enumerate() {
        let [before, now] = pair else { continue };
        let (y0, y1) = (before.at.y, now.at.y);
        // RefAV requires both sides strictly, and so misses an object that is exactly on the line in a frame.
        let over = |line: f64| (y0 < line) != (y1 < line);
        let ahead = (now.front..=now.front + CROSSED_AHEAD_M).contains(&now.at.x);
        if !ahead || !(over(now.side) || over(-now.side)) || now.across.abs() <= CROSSED_MPS {
            continue;
        }
        let sign = (y1 - y0).signum();
        let goes_on = |p: &&Passing| sign * p.at.y < CROSSED_BESIDE_M && sign * p.across > CROSSED_MPS;
        let back = seen[..=i].iter().rev().take_while(goes_on);
        rows.extend(back.chain(seen[i + 1..].iter().take_while(goes_on)).map(|p| p.row));
    }
    rows
}

/// By row: the ego is being crossed by the target.
fn crossed_by(scene: &Interaction<'_>, target: &Target<'_>) -> Vec<Tri> {
    let ego = scene.around.ego;
    let (front, side) = (ego.length / 2.0, ego.width / 2.0);
    let known = |p: &&Placement| p.velocity.is_finite();
    let mut flags: Vec<Tri> =
        target.places.iter().map(|p| p.as_ref().filter(known).map_or(Tri::Unknown, |_| Tri::False)).collect();
    let passing: Vec<Passing> = (0..flags.len())
        .filter(|&row| flags[row] == Tri::False)
        .filter_map(|row| {
            let p = target.places[row].as_ref()?;
            let across = in_ego_axes(scene, p.frame, p.velocity).y;
            Some(Passing { row, at: seen_at(scene, p), across, front, side })
        })
        .collect();
    for row in crossing(&passing) {
        flags[row] = Tri::True;
    }
    flags
}

fn stationary(m: &Motion) -> Tri {
    let extent = |v: &[f64]| {
        let (low, high) =
            v.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| (l.min(x), h.max(x)));
        if low > high { 0.0 } else { high - low }
    };
    let known = m.x.iter().any(|x| x.is_finite());
    let diagonal = extent(&m.x).hypot(extent(&m.y)).hypot(extent(&m.z));
    if known { Tri::from(diagonal < STATIONARY_M) } else { Tri::Unknown }
}

fn is_junction(lane: &LaneShape) -> bool {
    lane.in_junction && lane.kind != LaneKind::Sidewalk
}

/// The junction lanes; for a map that draws junctions only as areas, these.
fn intersections(road: &Road) -> NearAreas<'_> {
    let mut lanes = road.lanes.iter().filter(|lane| is_junction(lane)).peekable();
    if lanes.peek().is_none() {
        return NearAreas::new(&road.junctions);
    }
    NearAreas::new(lanes.filter_map(|lane| lane.area.as_ref()))
}

/// Objects without a driver have no direction of their own.
pub(crate) fn has_free_will(class: ObjectClass) -> bool {
    use ObjectClass::{Barrier, Bicycle, Cone, StaticObject, Unknown};
    !matches!(class, Bicycle | Cone | Barrier | StaticObject | Unknown)
}

fn heading(
    scene: &Interaction<'_>,
    own: &Own,
    class: ObjectClass,
    p: &Placement,
) -> Option<TargetRefavHeading> {
    let (ego, i) = (scene.around.ego, p.frame);
    if !ego.velocity[i].is_finite() || !p.velocity.is_finite() {
        return None;
    }
    let (own_speed, their_speed) = (own.speed, p.speed());
    let (a, b) = if their_speed < DIRECTED_MPS && has_free_will(class) && own_speed > DIRECTED_MPS {
        (own.heading, p.footprint.heading)
    } else if own_speed < DIRECTED_MPS && their_speed > HEADING_SPEED_MPS {
        (ego.heading[i], p.direction())
    } else if own_speed < DIRECTED_MPS || their_speed < DIRECTED_MPS {
        return Some(TargetRefavHeading::None);
    } else {
        (own.heading, p.direction())
    };
    let turned = wrap(b - a).abs();
    // A tolerance, so that exactly 45 and 135 deg do not depend on rounding.
    Some(if turned.is_nan() {
        return None;
    } else if turned <= FRAC_PI_4 + 1e-9 {
        TargetRefavHeading::Same
    } else if turned >= PI - FRAC_PI_4 - 1e-9 {
        TargetRefavHeading::Opposite
    } else {
        TargetRefavHeading::Perpendicular
    })
}

/// Writes the `target.refav_` and `ego.refav_` signals.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let rows = Rows::new(scene.drive, table);
    let (targets, ego) = (scene.targets, scene.around.ego);
    let crossed: Vec<_> = targets.iter().map(|t| crossed_by(scene, t)).collect();
    table.flag(id::TARGET_REFAV_CROSSED_BY, rows.spread(targets, Tri::Unknown, |k, r, _| crossed[k][r]));
    let standing: Vec<Tri> = targets.iter().map(|t| stationary(&t.track.motion)).collect();
    table.flag(id::TARGET_REFAV_STATIONARY, rows.spread(targets, Tri::Unknown, |k, _, _| standing[k]));
    let turns: Vec<_> = targets.iter().map(|t| turning::turning(&t.times, &t.track.motion.heading)).collect();
    table.category(id::TARGET_REFAV_TURNING, rows.spread(targets, None, |k, r, _| turns[k][r]));
    let n = ego.len();
    let own: Vec<Own> = (0..n).map(|i| Own::new(ego, i)).collect();
    let (mut directions, mut heads) = (rows.column(None), rows.column(None));
    let mut follows = rows.column(Tri::Unknown);
    rows.each_placed(targets, |row, (k, r), p| {
        directions.0[row] = relative_direction(scene, p);
        heads.0[row] = heading(scene, &own[p.frame], targets[k].track.class, p);
        if let Some(road) = scene.around.road {
            follows.0[row] = following(scene, road, own[p.frame].way, (k, r), p);
        }
    });
    table.category(id::TARGET_REFAV_RELATIVE_DIRECTION, directions);
    table.category(id::TARGET_REFAV_HEADING, heads);
    if let Some(own) = &scene.drive.ego {
        let value = stationary(&own.motion);
        let of = |i: usize| if ego.is_known(i) { value } else { Tri::Unknown };
        table.flag(id::EGO_REFAV_STATIONARY, (0..n).map(of).collect());
    }
    table.category(id::EGO_REFAV_TURNING, turning::turning(scene.times, &ego.heading));
    let Some(road) = scene.around.road else { return };
    table.flag(id::TARGET_REFAV_FOLLOWING, follows);
    let intersections = intersections(road);
    let is_near = |p: P2| match p.is_finite() {
        true => Tri::from(intersections.is_within(p, INTERSECTION_M)),
        false => Tri::Unknown,
    };
    let near = rows.flags(|t, r| is_near(p2(t.motion.x[r], t.motion.y[r])));
    table.flag(id::TARGET_REFAV_NEAR_INTERSECTION, near);
    table.flag(id::EGO_REFAV_NEAR_INTERSECTION, (0..n).map(|i| is_near(ego.position[i])).collect());
}
