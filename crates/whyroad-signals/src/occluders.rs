//! Who hides a target, by its id: what `target.occluder` gives the kind of. For pictures and for evidence in labels.
//! Not a signal: a category has one closed set of values in all drives, and which tracks there are each drive has its
//! own of; no rule may ask for one.

use crate::derive::{EgoStage, PlacedStage, RoadStage};
use crate::road::network::Road;
use crate::sight::{Occluder, hidden_by};
use crate::target::placement::PlacedRows;
use std::collections::BTreeMap;
use whyroad_model::{Drive, TrackId};

/// For each track the frames in which something hides a part of it, ascending, with what hides most. Nothing where the
/// drive has no ego pose.
pub fn occluders(drive: &Drive) -> BTreeMap<TrackId, Vec<(usize, Occluder)>> {
    let Some(own) = &drive.ego else { return BTreeMap::new() };
    let ego = EgoStage::of(drive, own);
    let road = drive.map.as_ref().map(Road::new);
    let Some(on_road) = RoadStage::new(&ego, road.as_ref()) else { return BTreeMap::new() };
    let placed = PlacedStage::new(&on_road, PlacedRows::All);
    let found = hidden_by(&placed.scene()).into_iter().zip(&placed.targets);
    found.filter(|(rows, _)| !rows.is_empty()).map(|(rows, t)| (t.track.id.clone(), rows)).collect()
}
