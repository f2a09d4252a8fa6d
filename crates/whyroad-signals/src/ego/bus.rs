//! What the ego's vehicle bus says: indicators, brake, automatic emergency braking. Copied, never guessed.

use crate::table::TableBuilder;
use whyroad_model::Tri;
use whyroad_model::catalogue::id;
use whyroad_model::catalogue::value::EgoTurnSignal;
use whyroad_model::scene::{EgoBus, TurnSignal};

/// Writes `ego.turn_signal`, `ego.brake`, `ego.aeb`; a channel that the bus lacks is unknown throughout.
pub fn write(bus: &EgoBus, frames: usize, table: &mut TableBuilder<'_>) {
    let flag = |v: &[Option<bool>]| (0..frames).map(|i| Tri::from(v.get(i).copied().flatten())).collect();
    table.flag(id::EGO_BRAKE, flag(&bus.brake));
    table.flag(id::EGO_AEB, flag(&bus.aeb));
    let indicator = |i: usize| bus.turn_signal.get(i).copied().flatten().map(turn_signal);
    table.category(id::EGO_TURN_SIGNAL, (0..frames).map(indicator));
}

/// The value of `ego.turn_signal` and `target.turn_signal`.
pub fn turn_signal(signal: TurnSignal) -> EgoTurnSignal {
    match signal {
        TurnSignal::Off => EgoTurnSignal::Off,
        TurnSignal::Left => EgoTurnSignal::Left,
        TurnSignal::Right => EgoTurnSignal::Right,
        TurnSignal::Hazard => EgoTurnSignal::Hazard,
    }
}
