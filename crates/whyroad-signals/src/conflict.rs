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
use crate::wanted;

/// Writes the families on conflicts of pairs.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    if table.asks(wanted::TTC_ACCEL) {
        ttc_accel::write(scene, table);
    }
    if table.asks(wanted::CRITICALITY) {
        criticality::write(scene, table);
    }
    if table.asks(wanted::CONFLICT_POINT) {
        point::write(scene, table);
    }
    if table.asks(wanted::TIME_TO_LINE) {
        time_to_line::write(scene, table);
    }
}
