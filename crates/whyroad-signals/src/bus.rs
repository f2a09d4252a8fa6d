//! What the ego's vehicle bus says: indicators, brake, automatic emergency braking. Copied, never guessed.

use crate::table::TableBuilder;
use crate::target_motion::turn_signal_code;
use whyroad_model::Tri;
use whyroad_model::scene::EgoBus;

/// Writes `ego.turn_signal`, `ego.brake`, `ego.aeb`; a channel that the bus lacks is unknown throughout.
pub fn write(bus: &EgoBus, frames: usize, table: &mut TableBuilder<'_>) {
    let flag = |v: &[Option<bool>]| (0..frames).map(|i| Tri::from(v.get(i).copied().flatten())).collect();
    table.flag("ego.brake", flag(&bus.brake));
    table.flag("ego.aeb", flag(&bus.aeb));
    let indicator = |i: usize| bus.turn_signal.get(i).copied().flatten().map(turn_signal_code);
    table.category("ego.turn_signal", (0..frames).map(indicator));
}
