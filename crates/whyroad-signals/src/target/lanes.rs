//! The lanes of the targets, assigned once for all families that use them.

use crate::geometry::{P2, p2};
use crate::road::lanes::{LanePlace, Tether, assign};
use crate::road::network::Road;
use crate::target::placement::Target;
use whyroad_model::ObjectClass;

/// True for objects that drive in lanes.
pub fn drives(class: ObjectClass) -> bool {
    class.is_vehicle() || matches!(class, ObjectClass::Bicycle | ObjectClass::Bicyclist | ObjectClass::EBike)
}

/// Lanes of all targets: by target, then by row of its track. Empty for objects that do not drive in lanes.
pub struct TargetLanes {
    /// Assigned positions.
    pub places: Vec<Vec<Option<LanePlace>>>,
}

impl TargetLanes {
    /// Assigns the lanes of `targets`.
    pub fn new(road: &Road, targets: &[Target<'_>]) -> Self {
        let places = targets.iter().map(|target| {
            let tether = match target.track.class {
                class if class.is_vehicle() => Tether::VEHICLE,
                class if drives(class) => Tether::BICYCLE,
                _ => return Vec::new(),
            };
            let m = &target.track.motion;
            let rows: Vec<(P2, f64, f64)> =
                (0..m.len()).map(|r| (p2(m.x[r], m.y[r]), m.z[r], m.heading[r])).collect();
            assign(road, &rows, tether)
        });
        Self { places: places.collect() }
    }

    /// The position of target `k` in its row `r`.
    pub fn at(&self, k: usize, r: usize) -> Option<&LanePlace> {
        self.places[k].get(r)?.as_ref()
    }
}
