//! The recording vehicle's box in its own frame. AV2 states poses of the rear axle's center; scene tables want the box
//! center.
//!
//! AV2 documents no box for its car (a Ford Fusion Hybrid). Some copies of the annotations carry one as
//! `EGO_VEHICLE`, 4.877 x 2.000 x 1.473 m, with its center *at the origin*, that is on the rear axle: the box would
//! then extend half a meter too far behind the car and lack 1.3 m in front. Its size is used, its position is not. The
//! offset from axle to center, 1.339 m forward and 0.438 m up, is what py123d measured from the car's drawing and AV2's
//! own lidar returns; with 2.850 m of wheelbase it leaves overhangs of 1.100 m and 0.927 m.

/// A box and where its center is in the ego frame (origin rear axle, x forward, y left, z up), m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EgoBox {
    pub length_m: f64,
    pub width_m: f64,
    pub height_m: f64,
    pub center: [f64; 3],
}

/// The car of all AV2 logs.
pub(crate) const FORD_FUSION: EgoBox =
    EgoBox { length_m: 4.877, width_m: 2.0, height_m: 1.473, center: [1.339, 0.0, 0.438] };

/// A stated center nearer to the origin than this is the axle, not a box center, m.
const AT_ORIGIN_M: f64 = 0.05;

/// What the log's own `EGO_VEHICLE` row says, with the center corrected when it is on the axle (second value: it was).
pub(crate) fn from_row(size: [f64; 3], center: [f64; 3]) -> (EgoBox, bool) {
    let size_known = size.iter().all(|v| *v > 0.0);
    let [length_m, width_m, height_m] =
        if size_known { size } else { [FORD_FUSION.length_m, FORD_FUSION.width_m, FORD_FUSION.height_m] };
    // Written so that NaN counts as not stated.
    let stated = center[0].hypot(center[1]) > AT_ORIGIN_M;
    (
        EgoBox { length_m, width_m, height_m, center: if stated { center } else { FORD_FUSION.center } },
        !stated,
    )
}
