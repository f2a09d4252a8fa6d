//! Visible distance along the ego's path. Writes `map.sight_distance` and `map.curve_hidden`.

use super::obstacles::{ObstacleKind, Obstacles};
use super::profile::Profile;
use super::scene::Scene;
use super::view::{Owner, View};
use crate::geometry::P2;
use crate::table::TableBuilder;
use whyroad_model::Tri;
use whyroad_model::catalog::id;

/// Maximum look-ahead, m.
const HORIZON_M: f64 = 150.0;
/// Sampling step along the path, m.
const STEP_M: f64 = 1.0;
/// Maximum distance of a bend, and of the end of sight, m.
const CURVE_M: f64 = 50.0;
/// Minimum curvature of a bend, 1/m (a radius of 100 m).
const CURVE_PER_M: f64 = 0.01;
/// Length of the chords by which curvature is measured, m; as for `map.curvature`.
const CHORD_M: f64 = 5.0;
/// An object within this distance of the center of the path is on it, not beside it, m: half a car plus a margin.
const ON_PATH_M: f64 = 1.5;

/// Sight along the path by frame.
pub struct Ahead<'a> {
    scene: &'a Scene<'a>,
    profile: &'a Profile,
    obstacles: &'a Obstacles<'a>,
    distance: Vec<f64>,
    curve_hidden: Vec<Tri>,
}

impl<'a> Ahead<'a> {
    /// Before the first frame.
    pub fn new(scene: &'a Scene<'a>, profile: &'a Profile, obstacles: &'a Obstacles<'a>) -> Self {
        Self { scene, profile, obstacles, distance: Vec::new(), curve_hidden: Vec::new() }
    }

    /// Processes one frame; frames come in order.
    pub fn look(&mut self, frame: usize, view: Option<&View>) {
        let s = self.scene.path.ego_s[frame];
        let Some(view) = view.filter(|_| s.is_finite()) else {
            self.distance.push(f64::NAN);
            self.curve_hidden.push(Tri::Unknown);
            return;
        };
        let counts = |owner: Owner| match self.obstacles.kind(owner) {
            ObstacleKind::Building | ObstacleKind::LargeVehicle => true,
            ObstacleKind::Vehicle => self.obstacles.moves(owner, frame) == Some(false),
            ObstacleKind::Vru | ObstacleKind::Object => false,
        };
        let counting = view.counting(counts);
        let steps = (HORIZON_M / STEP_M) as usize;
        let first = (1..=steps).find_map(|i| {
            let ahead = i as f64 * STEP_M;
            Some((ahead, counting.before(self.scene.path.line.point_at(s + ahead))?))
        });
        let flat = first.map_or(HORIZON_M, |(hidden, _)| hidden - STEP_M);
        let over = self.profile.sight(s).hidden_at;
        self.distance.push(flat.min(over).min(HORIZON_M));
        let curve = self.curve(s, first.filter(|(hidden, _)| *hidden <= CURVE_M), frame);
        self.curve_hidden.push(curve);
    }

    /// Whether `cut`, the first hidden position and the object that hides it, is caused by something on the inner side
    /// of a bend ahead.
    fn curve(&self, s: f64, cut: Option<(f64, Owner)>, frame: usize) -> Tri {
        let path = &self.scene.path.line;
        let along = (0..=(CURVE_M / 2.0) as usize).map(|i| s + 2.0 * i as f64);
        let bend = path.greatest_curvature(along, CHORD_M);
        if bend.abs() < CURVE_PER_M {
            return Tri::False;
        }
        match cut {
            // Sight lines in a bend are on its inner side: an object that blocks one off the path is there.
            Some((_, owner)) => Tri::from(self.side(owner, s, frame).is_none_or(|side| side * bend > 0.0)),
            // No known object; but if the map has no data, there may be a hedge or a house.
            None if self.obstacles.covers_buildings => Tri::False,
            None => Tri::Unknown,
        }
    }

    /// Lateral distance of a target's box from the path ahead, left positive, 0 on it; `None` for a building.
    fn side(&self, owner: Owner, s: f64, frame: usize) -> Option<f64> {
        let Owner::Target(k) = owner else { return None };
        let target = &self.scene.targets[k];
        let place = target.places[target.track.row_at(frame)?].as_ref()?;
        let center: P2 = place.footprint.center;
        let lateral = self.scene.path.line.project_between(center, s, s + CURVE_M + 10.0).lateral;
        Some(if lateral.abs() <= ON_PATH_M { 0.0 } else { lateral })
    }

    /// Writes the signals of this file.
    pub fn write(self, table: &mut TableBuilder<'_>) {
        table.number(id::MAP_SIGHT_DISTANCE, self.distance);
        table.flag(id::MAP_CURVE_HIDDEN, self.curve_hidden);
    }
}
