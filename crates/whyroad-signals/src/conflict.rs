//! Conflicts between the ego and a target: time and acceleration measures.

pub mod criticality;
pub mod pet;
pub mod point;
pub mod time_to_line;
pub mod ttc;
pub mod ttc_accel;
pub mod ttc_lane;

use crate::table::TableBuilder;
use crate::target::interaction::Interaction;

/// Writes the families on conflicts of pairs.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    ttc_accel::write(scene, table);
    criticality::write(scene, table);
    point::write(scene, table);
    time_to_line::write(scene, table);
}
