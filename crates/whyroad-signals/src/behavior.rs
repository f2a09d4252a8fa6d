//! Behavior of the ego and others over time: stops, lane changes, passing, traffic, responses.

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
use crate::target::interaction::{Family, Interaction, write_asked};
use crate::wanted;

const BEFORE_LEAD: &[Family] = &[
    (wanted::PASSING, passing::write),
    (wanted::OVERTAKING, overtaking::write),
    (wanted::TRAFFIC, traffic::write),
];

const AFTER_LEAD: &[Family] = &[
    (wanted::LANE_CHANGE_PHASE, lane_change_phase::write),
    (wanted::SWERVE, swerve::write),
    (wanted::TURNING, turning::write),
    (wanted::FAIR_SPEED, fair_speed::write),
    (wanted::RESPONDS, responds::write),
];

/// Writes the signals of all families in this folder.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    write_asked(&[(wanted::STOPS, stops::write)], scene, table);
    let by_themselves = table.asks(wanted::TARGETS_BY_THEMSELVES);
    let of_lead = table.asks(wanted::LEAD_BEHAVIOR);
    let standing = if by_themselves || of_lead { stops::targets_standing(scene) } else { Vec::new() };
    if by_themselves {
        target::write(scene, &standing, table);
    }
    write_asked(BEFORE_LEAD, scene, table);
    if of_lead {
        lead::write(scene, &standing, table);
    }
    write_asked(AFTER_LEAD, scene, table);
}
