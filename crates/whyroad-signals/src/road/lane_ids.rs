//! The lane that the lane signals use, by its id in the map: for tests and tools that compare lane assignment with
//! another source. This is not a signal, because its values are ids of the map and no rule may use one.

use crate::ego::motion::EgoMotion;
use crate::road::ego_lane::EgoLane;
use crate::road::network::Road;
use crate::series::seconds;
use whyroad_model::Drive;

/// The ego's lane in each frame of `drive`; `None` where it has none, or the drive has no map or no ego pose.
pub fn ego_lane_ids(drive: &Drive) -> Vec<Option<String>> {
    let times = seconds(drive);
    let (Some(map), Some(ego)) = (&drive.map, &drive.ego) else { return vec![None; times.len()] };
    let road = Road::new(map);
    let lanes = EgoLane::new(&road, &EgoMotion::new(ego, &times));
    lanes.places.iter().map(|p| p.as_ref().map(|p| road.lanes[p.lane].id.clone())).collect()
}
