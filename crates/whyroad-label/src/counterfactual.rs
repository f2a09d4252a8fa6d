//! Estimates what the ego would have done without one object. The recorded scene is simulated from the keyframe on with
//! a car-following and yielding model that is fitted to the ego's own history; each object (and the light) is removed
//! in turn, and the objects are ranked by how much farther the ego would have driven.
//!
//! Pure functions of a drive and a frame. The model follows the path that the ego really drove and predicts only its
//! speed: it has no lane changes, nudges or turns, and other road users keep to their recorded tracks.

mod idm;
mod scene;

pub use idm::Driver;
pub use scene::{Constraint, Scene};

use whyroad_model::{Drive, SignalTable, TrackId};

/// Duration of the simulation, s.
pub const HORIZON_S: f64 = 8.0;
/// Maximum number of objects that are removed one by one: those that can reach the path first.
pub const MOST_RELEVANT: usize = 10;
/// Step of the model, s.
const STEP_S: f64 = 0.1;

/// Something that can be removed from the scene.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Removed {
    /// A road user.
    Object(TrackId),
    /// The light of the ego's lane: as if it were green.
    Light,
}

/// Effect of removing one thing.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// The removed thing.
    pub removed: Removed,
    /// Additional distance that the ego drives within the horizon, m; never negative.
    pub distance_m: f64,
    /// Reduction of the strongest braking, m/s2; never negative.
    pub braking_mps2: f64,
}

impl Effect {
    /// The ego drives as it would with the thing present.
    pub fn is_none(&self) -> bool {
        self.distance_m < 1.0 && self.braking_mps2 < 0.3
    }

    /// The effect is large: the ego would not have had to respond as it did.
    pub fn is_plain(&self) -> bool {
        self.distance_m > 4.0 || self.braking_mps2 > 1.0
    }
}

/// The scene with everything, and the effect of each thing, largest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Counterfactual {
    /// The fitted driver.
    pub driver: Driver,
    /// Distance that the ego drives with all things present, m.
    pub distance_m: f64,
    /// Effects, largest first; equal ones in the order of ids.
    pub effects: Vec<Effect>,
}

impl Counterfactual {
    /// What holds the ego instead of the things `named`: without any of these it would drive as it does, and without
    /// that one plainly farther. Only what `was_seen` by then can be a cause.
    pub fn instead_of(&self, named: &[Removed], was_seen: impl Fn(&Removed) -> bool) -> Option<&Effect> {
        let is_named = |e: &Effect| named.contains(&e.removed);
        if self.effects.iter().any(|e| is_named(e) && !e.is_none()) {
            return None;
        }
        self.effects.iter().find(|e| !is_named(e) && e.is_plain() && was_seen(&e.removed))
    }
}

/// Simulates the scene from `frame` on. `None` where the ego's poses or speed are unknown.
pub fn counterfactual(drive: &Drive, signals: &SignalTable, frame: usize) -> Option<Counterfactual> {
    let scene = Scene::at(drive, signals, frame)?;
    let driver = Driver::fitted(drive, signals, frame)?;
    let with = run(&scene, &driver, None);
    let mut effects: Vec<Effect> = scene
        .things()
        .into_iter()
        .map(|removed| {
            let without = run(&scene, &driver, Some(&removed));
            Effect {
                removed,
                distance_m: (without.distance_m - with.distance_m).max(0.0),
                braking_mps2: (without.least_accel - with.least_accel).max(0.0),
            }
        })
        .collect();
    effects.sort_by(|a, b| {
        b.distance_m
            .total_cmp(&a.distance_m)
            .then_with(|| b.braking_mps2.total_cmp(&a.braking_mps2))
            .then_with(|| a.removed.cmp(&b.removed))
    });
    Some(Counterfactual { driver, distance_m: with.distance_m, effects })
}

/// One simulation of the scene.
struct Run {
    distance_m: f64,
    least_accel: f64,
}

fn run(scene: &Scene, driver: &Driver, removed: Option<&Removed>) -> Run {
    let (mut s, mut v) = (0.0_f64, scene.speed_mps);
    let mut least = 0.0_f64;
    let steps = (HORIZON_S / STEP_S) as usize;
    for step in 0..steps {
        let t = step as f64 * STEP_S;
        let free = driver.free(v);
        let accel = scene
            .constraints(t, s, v, driver)
            .filter(|c| removed.is_none_or(|r| c.by != *r))
            .map(|c| driver.behind(v, c.gap_m, c.speed_mps))
            .fold(free, f64::min);
        let accel = accel.max(-driver.strongest_mps2);
        least = least.min(accel);
        let next = (v + accel * STEP_S).max(0.0);
        s += 0.5 * (v + next) * STEP_S;
        v = next;
    }
    Run { distance_m: s, least_accel: least }
}

#[cfg(test)]
mod tests;
