//! Sight: the visible part of each target, the object that hides it, when it comes out; how far and how wide the ego
//! sees the road ahead and beside it. Seen from the center of the ego's box in the ground plane: heights matter only
//! for crests, for objects that are too low to hide anything, and for other levels.

mod ahead;
mod beside;
mod crossing_arms;
mod emergence;
mod obstacles;
mod occlusion;
mod profile;
mod scene;
mod view;

use crate::table::TableBuilder;
use obstacles::Obstacles;

pub use scene::{Occluder, Scene};

/// By target: the frames in which something hides a part of it, with the object that hides most.
pub fn hidden_by(scene: &Scene<'_>) -> Vec<Vec<(usize, Occluder)>> {
    let obstacles = Obstacles::new(scene);
    let mut occlusion = occlusion::Occlusion::new(scene);
    for frame in 0..scene.ego.len() {
        occlusion.look(frame, obstacles.view(frame).as_ref(), &obstacles);
    }
    let hider = |seen: &occlusion::Seen| Some((seen.frame, obstacles.id(seen.occluder?)));
    occlusion.rows.iter().map(|rows| rows.iter().filter_map(hider).collect()).collect()
}

/// Writes the signals of this family. One view per frame serves all of them.
pub fn write(scene: &Scene<'_>, table: &mut TableBuilder<'_>) {
    let obstacles = Obstacles::new(scene);
    let mut occlusion = occlusion::Occlusion::new(scene);
    let mut beside = beside::Beside::default();
    let profile = profile::Profile::new(scene);
    let mut ahead = ahead::Ahead::new(scene, &profile, &obstacles);
    let mut arms = scene.road.map(|road| crossing_arms::CrossingArms::new(scene, road, &obstacles));
    for frame in 0..scene.ego.len() {
        let view = obstacles.view(frame);
        occlusion.look(frame, view.as_ref(), &obstacles);
        beside.look(frame, view.as_ref(), scene, &obstacles);
        ahead.look(frame, view.as_ref());
        if let Some(arms) = &mut arms {
            arms.look(frame, view.as_ref());
        }
    }
    occlusion.write(&obstacles, table);
    emergence::write(scene, &occlusion, &obstacles, table);
    beside.write(table);
    profile.write(scene, table);
    if let Some(arms) = arms {
        ahead.write(table);
        arms.write(table);
    }
}
