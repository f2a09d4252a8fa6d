//! What the ego and others do to each other: the families on conflict, traffic, manoeuvres and RefAV's questions, in
//! order. Everything that they share is found once, before, by `derive`.

use crate::placement::{Surroundings, Target};
use crate::relations::Neighbours;
use crate::table::TableBuilder;
use crate::target_lanes::TargetLanes;
use crate::{
    conflict_point, criticality, lane_change_phase, lead, overtaking, passing, refav, responds, stops,
    swerve, target_behaviour, target_lanes, target_ramp, target_side, target_turns, time_to_line, traffic,
    ttc_accel,
};
use whyroad_model::Drive;

/// One drive with all that was found before.
pub struct Interaction<'a> {
    /// The scene tables.
    pub drive: &'a Drive,
    /// Seconds by frame.
    pub times: &'a [f64],
    /// The ego, its path, its lanes, the road.
    pub around: &'a Surroundings<'a>,
    /// Targets in the table's order.
    pub targets: &'a [Target<'a>],
    /// Lead and follower by frame.
    pub near: &'a Neighbours,
    /// Lanes of the targets by row; `None` without a map.
    pub lanes: Option<&'a TargetLanes>,
}

/// Writes all families of this part. `table` must hold the ego's meta actions already.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    ttc_accel::write(scene, table);
    criticality::write(scene, table);
    conflict_point::write(scene, table);
    stops::write(scene, table);
    let standing = stops::targets_standing(scene);
    target_behaviour::write(scene, &standing, table);
    target_lanes::write(scene, table);
    target_ramp::write(scene, table);
    target_side::write(scene, table);
    target_turns::write(scene, table);
    passing::write(scene, table);
    overtaking::write(scene, table);
    traffic::write(scene, table);
    lead::write(scene, &standing, table);
    time_to_line::write(scene, table);
    lane_change_phase::write(scene, table);
    swerve::write(scene, table);
    responds::write(scene, table);
    refav::write(scene, table);
}
