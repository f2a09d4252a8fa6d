//! The object that hides a target, by its id: `target.occluder` only states its kind. For pictures and for evidence in
//! labels. This is not a signal: a category has the same closed set of values in all drives, but each drive has its own
//! tracks; no rule may use it.

use crate::derive::{EgoStage, PlacedStage, RoadStage};
use crate::road::network::Road;
use crate::sight::{Occluder, hidden_by};
use crate::target::placement::PlacedRows;
use std::collections::BTreeMap;
use whyroad_model::{Drive, TrackId};

/// For each track the frames in which something hides a part of it, ascending, with the object that hides most. Empty
/// if the drive has no ego pose.
pub fn occluders(drive: &Drive) -> BTreeMap<TrackId, Vec<(usize, Occluder)>> {
    let Some(own) = &drive.ego else { return BTreeMap::new() };
    let ego = EgoStage::of(drive, own);
    let road = drive.map.as_ref().map(Road::new);
    let Some(on_road) = RoadStage::new(&ego, road.as_ref()) else { return BTreeMap::new() };
    let placed = PlacedStage::new(&on_road, PlacedRows::All);
    let found = hidden_by(&placed.scene()).into_iter().zip(&placed.targets);
    found.filter(|(rows, _)| !rows.is_empty()).map(|(rows, t)| (t.track.id.clone(), rows)).collect()
}
