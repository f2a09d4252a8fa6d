//! Which targets are in the ego's path ahead, and the clear distance to them: from the ego's front bumper to the
//! target's nearest corner, along the driven path.

use crate::placement::Placement;

/// The ego's path is this much wider than the ego on either side, m.
const PATH_MARGIN_M: f64 = 0.3;
/// A target that moves across the lane faster than this towards its centre is coming in, m/s.
const COMING_IN_MPS: f64 = 0.1;

/// Whether the target is ahead in the ego's path. In path is: its centre in the ego's lane; or its footprint in
/// the band that the ego sweeps along its driven path; or part of it over the line into the lane and moving in.
/// A car parked with one wheel in the lane, which the ego passes, is none of these.
pub fn in_path_ahead(p: &Placement, ego_width: f64) -> bool {
    if !p.same_level || !p.within_reach() || p.ahead <= 0.0 {
        return false;
    }
    let band = ego_width / 2.0 + PATH_MARGIN_M;
    let in_band = p.path.low < band && p.path.high > -band;
    let coming_in = p.intrusion().is_some_and(|d| d > 0.0) && lane_lateral_speed(p).is_some_and(|v| v >= COMING_IN_MPS);
    p.centre_in_way() || in_band || coming_in
}

/// Velocity across the ego's lane, towards its centre line positive, m/s. `None` without a lane.
pub fn lane_lateral_speed(p: &Placement) -> Option<f64> {
    let (at, _, _) = p.lane?;
    let across = p.velocity.dot(crate::geometry::P2::from_heading(at.heading).left());
    Some(if at.lateral > 0.0 { -across } else { across })
}

/// The gap of a target: bumper to bumper along the path, negative when overlapping, infinite when known not to be
/// ahead in path, NaN when its size is unknown.
pub fn gap(p: &Placement, ego_length: f64, ego_width: f64) -> f64 {
    if !p.is_sized() {
        f64::NAN
    } else if in_path_ahead(p, ego_width) {
        p.near - ego_length / 2.0
    } else {
        f64::INFINITY
    }
}
