//! Conflicts between the ego and a target: time and acceleration measures.

pub mod criticality;
pub mod pet;
pub mod point;
pub mod time_to_line;
pub mod ttc;
pub mod ttc_accel;
pub mod ttc_lane;

use crate::table::TableBuilder;
use crate::target::interaction::{Family, Interaction, write_asked};
use crate::wanted;

const FAMILIES: &[Family] = &[
    (wanted::TTC_ACCEL, ttc_accel::write),
    (wanted::CRITICALITY, criticality::write),
    (wanted::CONFLICT_POINT, point::write),
    (wanted::TIME_TO_LINE, time_to_line::write),
];

/// Writes the signals about conflicts of pairs.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    write_asked(FAMILIES, scene, table);
}
