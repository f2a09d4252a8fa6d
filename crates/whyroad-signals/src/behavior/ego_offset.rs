//! The ego's lateral position in its lane as a continuous quantity: when it changes to the adjacent lane, the offset
//! continues instead of jumping by a lane's width.

use crate::geometry::P2;
use crate::series::GAP_S;
use crate::target::interaction::Interaction;

/// Lane offset by frame, m, left positive, continued over lane changes; NaN where the ego has no lane. The value
/// restarts (with the offset in the lane) after a gap.
pub fn unrolled(scene: &Interaction<'_>) -> Vec<f64> {
    let (ego, times) = (scene.around.ego, scene.times);
    let mut values = vec![f64::NAN; ego.len()];
    let (Some(lanes), Some(road)) = (scene.around.lanes, scene.around.road) else { return values };
    let mut last: Option<(usize, f64, usize)> = None;
    for (i, value) in values.iter_mut().enumerate() {
        let Some(on) = lanes.at(i) else {
            last = None;
            continue;
        };
        let continued = last.filter(|&(j, _, _)| times[i] - times[j] <= GAP_S).map(|(j, offset, lane)| {
            if lane == on.lane || road.lanes[lane].successors.contains(&on.lane) {
                return offset - values_at(lanes, j) + on.lateral;
            }
            // Another lane: the lateral movement of the ego counts, not the positions of the lines.
            let left = P2::from_heading(on.corridor.line.smooth_heading_at(on.s, 2.0)).left();
            offset + (ego.position[i] - ego.position[j]).dot(left)
        });
        *value = continued.unwrap_or(on.lateral);
        last = Some((i, *value, on.lane));
    }
    values
}

fn values_at(lanes: &crate::road::ego_lane::EgoLane, frame: usize) -> f64 {
    lanes.at(frame).map_or(f64::NAN, |on| on.lateral)
}
