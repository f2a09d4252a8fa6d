//! Who hides a target, by its id: what `target.occluder` gives the kind of. For pictures and for evidence in labels. Not
//! a signal: a category has one closed set of values in all drives, and which tracks there are each drive has its own of;
//! no rule may ask for one.

use crate::derive::driven_path;
use crate::ego_lane::EgoLane;
use crate::ego_motion::EgoMotion;
use crate::placement::{Surroundings, Target};
use crate::relations;
use crate::road::Road;
use crate::rows::observed_tracks;
use crate::sight::{Scene, hidden_by};
use std::collections::BTreeMap;
use whyroad_model::{Drive, TrackId};

/// What hides a target.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Occluder {
    /// Another track.
    Track(TrackId),
    /// A building of the map, by its id there.
    Facility(String),
}

/// For each track the frames in which something hides a part of it, ascending, with what hides most. Nothing where the
/// drive has no ego pose.
pub fn occluders(drive: &Drive) -> BTreeMap<TrackId, Vec<(usize, Occluder)>> {
    let start = drive.times.first().copied().unwrap_or_default();
    let times: Vec<f64> = drive.times.iter().map(|t| t.seconds_since(start)).collect();
    let Some(ego) = drive.ego.as_ref().map(|e| EgoMotion::new(e, &times)) else { return BTreeMap::new() };
    let road = drive.map.as_ref().map(Road::new);
    let lanes = road.as_ref().map(|r| EgoLane::new(r, &ego));
    let Some(path) = driven_path(&ego, lanes.as_ref(), &times) else { return BTreeMap::new() };
    let around = Surroundings { ego: &ego, path: &path, lanes: lanes.as_ref(), road: road.as_ref() };
    let targets: Vec<Target<'_>> = observed_tracks(drive).map(|t| around.place(t, &times)).collect();
    let near = relations::neighbours(&targets, ego.len());
    let scene = Scene {
        drive,
        ego: &ego,
        path: &path,
        road: road.as_ref(),
        targets: &targets,
        near: &near,
        times: &times,
    };
    let found = hidden_by(&scene).into_iter().zip(&targets);
    found.filter(|(rows, _)| !rows.is_empty()).map(|(rows, t)| (t.track.id.clone(), rows)).collect()
}
