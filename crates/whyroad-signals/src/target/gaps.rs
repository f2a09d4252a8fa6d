//! Targets in the ego's path ahead, and the clear distance to them: from the ego's front bumper to the target's nearest
//! corner, along the driven path.

use crate::geometry::wrap;
use crate::target::placement::Placement;

/// Minimum lateral speed towards the lane's center of a target that enters the lane, m/s.
const COMING_IN_MPS: f64 = 0.1;
/// A target that drives along with the ego: at least this fast, m/s, within this of the path's direction, rad (45 deg).
const ALONG_MPS: f64 = 0.5;
const ALONG_RAD: f64 = std::f64::consts::FRAC_PI_4;

/// Arc length from the ego's center to the near end of a target ahead in its path, m; `None` if the target is not in
/// path. In path are targets whose center is in the ego's lane; targets in the band that the ego sweeps along its
/// driven path; and targets that are partly over the line into the lane and moving in. A car parked with one wheel in
/// the lane, which the ego passes, is none of these.
///
/// The near end is that of the whole target in the lane, or of one that drives along with the ego ahead of its front
/// (else the gap to a bus that comes over at an angle would grow by its length at once); of others in the band, that of
/// the part in it: a car across the way, a truck parked askew, a bus beside the ego whose front comes over.
///
/// What is beside the ego, apart from it, does not overlap: only a part of it in the band ahead of the ego's front is
/// in path, as where the ego will turn to where an oncoming truck is now.
fn nearest_in_path(p: &Placement, ego_length: f64) -> Option<f64> {
    if !p.same_level || !p.within_reach() {
        return None;
    }
    // The whole of one that is in the lane: the part of it in the band changes where the ego swings out.
    if p.ahead > 0.0 && p.blocks_way() && !p.beside_ego {
        return Some(p.near);
    }
    let front = ego_length / 2.0;
    if let Some((near, far)) = p.band {
        if p.beside_ego {
            return (far > front).then_some(near.max(front));
        }
        let drives_along = p.speed() >= ALONG_MPS && wrap(p.direction() - p.path.heading).abs() <= ALONG_RAD;
        let near = if drives_along && p.near > front { p.near } else { near };
        return (near + far > 0.0).then_some(near);
    }
    let coming_in =
        p.intrusion().is_some_and(|d| d > 0.0) && lane_lateral_speed(p).is_some_and(|v| v >= COMING_IN_MPS);
    (p.ahead > 0.0 && coming_in && !p.beside_ego).then_some(p.near)
}

/// Velocity across the ego's lane, towards its center line positive, m/s. `None` without a lane.
pub fn lane_lateral_speed(p: &Placement) -> Option<f64> {
    p.lane.map(|_| p.lane_lateral_speed)
}

/// The gap of a target: bumper to bumper along the path, negative if overlapping, infinite if known not to be ahead in
/// path, NaN if its size is unknown.
pub fn gap(p: &Placement, ego_length: f64) -> f64 {
    if p.is_sized() {
        nearest_in_path(p, ego_length).map_or(f64::INFINITY, |near| near - ego_length / 2.0)
    } else {
        f64::NAN
    }
}

/// Velocity of a target along the path at its position, m/s, forward positive.
pub fn along_signed(p: &Placement) -> f64 {
    p.speed() * wrap(p.direction() - p.path.heading).cos()
}
