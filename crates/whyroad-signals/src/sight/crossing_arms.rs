//! Visible distance into the crossing arms of the next junction. Writes `map.sight_angle`.
//!
//! The arms are where the road leaves a circle around the junction's center; those to the left or right of the
//! direction of approach are examined along their center line up to 40 m. The angle of a side is that of the outermost
//! visible position; an arm that is visible to its end is free (90 deg), and so is a side without an arm.

use super::obstacles::{ObstacleKind, Obstacles};
use super::scene::Scene;
use super::view::{Counting, Owner, View};
use crate::geometry::{P2, wrap};
use crate::road::junction::stretches;
use crate::road::network::Road;
use crate::road::stretch::Stretch;
use crate::table::TableBuilder;
use std::f64::consts::{FRAC_PI_2, PI};
use whyroad_model::catalog::id;

/// Maximum distance of a junction that is examined, m.
const REACH_M: f64 = 60.0;
/// Ranges of the path in junctions with a smaller distance are one junction, m; as for `map.distance_to_junction`.
const MERGE_M: f64 = 5.0;
/// Maximum distance along an arm from the junction's center, m.
const ARM_M: f64 = 40.0;
/// Distance between positions on an arm, m.
const STEP_M: f64 = 1.0;
/// Distance outside of the junction at which arms are searched, m.
const OUTSIDE_M: f64 = 8.0;
/// Number of directions tested around the junction.
const DIRECTIONS: usize = 120;
/// Arms within this angle of straight on or straight back are not crossing, rad: 30 deg.
const ALONG_RAD: f64 = PI / 6.0;

/// One junction on the path.
struct Crossing {
    stretch: Stretch,
    middle: P2,
    approach: f64,
    radius: f64,
    arms: Vec<f64>,
}

/// Sight into crossing arms by frame.
pub struct CrossingArms<'a> {
    scene: &'a Scene<'a>,
    obstacles: &'a Obstacles<'a>,
    crossings: Vec<Crossing>,
    angle: Vec<f64>,
}

impl<'a> CrossingArms<'a> {
    /// For the junctions on the scene's path.
    pub fn new(scene: &'a Scene<'a>, road: &Road, obstacles: &'a Obstacles<'a>) -> Self {
        let found = stretches(scene.path, |p| road.in_junction(p), MERGE_M);
        let crossings = found.into_iter().map(|s| crossing(scene, road, s)).collect();
        Self { scene, obstacles, crossings, angle: Vec::new() }
    }

    /// Processes the arms of the next junction in one frame; frames come in order.
    pub fn look(&mut self, frame: usize, view: Option<&View>) {
        let s = self.scene.path.ego_s[frame];
        let Some(view) = view.filter(|_| s.is_finite()) else {
            self.angle.push(f64::NAN);
            return;
        };
        let front = if self.scene.ego.length.is_finite() { self.scene.ego.length / 2.0 } else { 0.0 };
        // A junction whose center is behind the ego is not examined any more.
        let next = self.crossings.iter().find(|c| (c.stretch.from + c.stretch.to) / 2.0 >= s);
        let Some(crossing) = next.filter(|c| c.stretch.from - s - front <= REACH_M) else {
            self.angle.push(f64::INFINITY);
            return;
        };
        let eye = self.scene.ego.position[frame];
        // A pedestrian does not block the view of a road, and a vehicle in the ego's lane drives on.
        let in_way = self.obstacles.tracked(frame).iter().filter(|tracked| tracked.in_way);
        let in_way: Vec<Owner> = in_way.map(|tracked| Owner::Target(tracked.target)).collect();
        let counts = |owner: Owner| {
            !matches!(self.obstacles.kind(owner), ObstacleKind::Vru) && !in_way.contains(&owner)
        };
        let counting = view.counting(counts);
        let angles = crossing.arms.iter().map(|&arm| into(crossing, arm, eye, &counting));
        let angle = angles.fold(FRAC_PI_2, f64::min);
        let unknown = angle >= FRAC_PI_2 && !self.obstacles.covers_buildings && !crossing.arms.is_empty();
        self.angle.push(if unknown { f64::NAN } else { angle });
    }

    /// Writes `map.sight_angle`.
    pub fn write(self, table: &mut TableBuilder<'_>) {
        table.number(id::MAP_SIGHT_ANGLE, self.angle);
    }
}

/// The junction of a range: its center, the ego's approach, the crossing arms.
fn crossing(scene: &Scene<'_>, road: &Road, stretch: Stretch) -> Crossing {
    let line = &scene.path.line;
    let middle = line.point_at((stretch.from + stretch.to) / 2.0);
    let approach = line.smooth_heading_at(stretch.from - 3.0, 2.0);
    let radius = ((stretch.to - stretch.from) / 2.0 + OUTSIDE_M).min(ARM_M - 10.0);
    let on_road = |i: usize| {
        let direction = 2.0 * PI * i as f64 / DIRECTIONS as f64;
        let place = middle + P2::from_heading(direction) * radius;
        road.on_road(place)
    };
    let ring: Vec<bool> = (0..DIRECTIONS).map(on_road).collect();
    let crosses = |arm: &f64| {
        let turned = wrap(arm - approach).abs();
        turned > ALONG_RAD && turned < PI - ALONG_RAD
    };
    let arms = middles(&ring).into_iter().filter(crosses).collect();
    Crossing { stretch, middle, approach, radius, arms }
}

/// Directions of the centers of the runs of `true` around a ring. None if all or nothing is road: an open square.
fn middles(ring: &[bool]) -> Vec<f64> {
    let n = ring.len();
    let Some(gap) = ring.iter().position(|on| !on) else { return Vec::new() };
    let mut arms = Vec::new();
    let mut start = None;
    for i in gap..=gap + n {
        match (ring[i % n], start) {
            (true, None) => start = Some(i),
            (false, Some(from)) => {
                arms.push(wrap(2.0 * PI * (from + i - 1) as f64 / 2.0 / n as f64));
                start = None;
            }
            _ => {}
        }
    }
    arms
}

/// Angle from the direction of approach to the outermost visible position of an arm, rad; a right angle if its far end
/// is visible.
fn into(crossing: &Crossing, arm: f64, eye: P2, counting: &Counting<'_>) -> f64 {
    let direction = P2::from_heading(arm);
    let place = |away: f64| crossing.middle + direction * away;
    let seen = |away: f64| counting.before(place(away)).is_none();
    if seen(ARM_M) {
        return FRAC_PI_2;
    }
    let inner = crossing.radius - OUTSIDE_M;
    let steps = ((ARM_M - inner) / STEP_M) as usize;
    let Some(mut last) = (0..steps).rev().map(|i| inner + i as f64 * STEP_M).find(|&away| seen(away)) else {
        return 0.0;
    };
    let mut beyond = last + STEP_M;
    for _ in 0..6 {
        let between = (last + beyond) / 2.0;
        if seen(between) {
            last = between;
        } else {
            beyond = between;
        }
    }
    wrap((place(last) - eye).heading() - crossing.approach).abs().min(FRAC_PI_2)
}
