//! The targets: their rows, their placement around the ego, its path and its lanes, and the motion of each.

pub mod approach;
pub mod band;
pub mod crosswalk;
pub mod detour;
pub mod free_width;
pub mod gaps;
pub mod interaction;
pub mod lane_changes;
pub mod lanes;
pub mod line_crossing;
pub mod motion;
pub mod on_lines;
pub mod placement;
pub mod ramp;
pub mod relations;
pub mod rows;
pub mod side;
pub mod turns;

use crate::table::TableBuilder;
use crate::wanted;
use interaction::{Family, Interaction, write_asked};

const FAMILIES: &[Family] = &[
    (wanted::LANE_CHANGES, lane_changes::write),
    (wanted::RAMP, ramp::write),
    (wanted::SIDE, side::write),
    (wanted::TURNS, turns::write),
    (wanted::DETOUR, detour::write),
];

/// Writes the families on lanes, sides and turns of targets.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    write_asked(FAMILIES, scene, table);
}
