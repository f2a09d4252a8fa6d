//! The targets: their rows, their placement around the ego, its path and its lanes, and what each does by itself.

pub mod approach;
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
use interaction::Interaction;

/// Writes the families on lanes, sides and turns of targets.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    if table.asks(wanted::LANE_CHANGES) {
        lane_changes::write(scene, table);
    }
    if table.asks(wanted::RAMP) {
        ramp::write(scene, table);
    }
    if table.asks(wanted::SIDE) {
        side::write(scene, table);
    }
    if table.asks(wanted::TURNS) {
        turns::write(scene, table);
    }
    if table.asks(wanted::DETOUR) {
        detour::write(scene, table);
    }
}
