//! What the ego and others do over time: stops, lane changes, passing, traffic, responses.

pub mod ego_offset;
pub mod fair_speed;
pub mod lane_change_intention;
pub mod lane_change_phase;
pub mod lead;
pub mod overtaking;
pub mod passing;
pub mod responds;
pub mod stops;
pub mod swerve;
pub mod target;
pub mod traffic;
pub mod turning;

use crate::table::TableBuilder;
use crate::target::interaction::Interaction;

/// Writes all families of this folder.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    stops::write(scene, table);
    let standing = stops::targets_standing(scene);
    target::write(scene, &standing, table);
    passing::write(scene, table);
    overtaking::write(scene, table);
    traffic::write(scene, table);
    lead::write(scene, &standing, table);
    lane_change_phase::write(scene, table);
    swerve::write(scene, table);
    turning::write(scene, table);
    fair_speed::write(scene, table);
    responds::write(scene, table);
}
