//! Signals of the ego's vehicle bus: indicators, brake, automatic emergency braking, cruise control and takeovers by
//! the driver. Copied, never guessed.

use crate::table::TableBuilder;
use whyroad_model::Tri;
use whyroad_model::catalog::id;
use whyroad_model::catalog::value::EgoTurnSignal;
use whyroad_model::scene::{EgoBus, TurnSignal};

/// The driver takes over when the brake is pressed within this many frames of the end of cruise control.
const TAKES_OVER_FRAMES: usize = 5;
/// A takeover is reported for this long, frames.
const REPORTED_FRAMES: usize = 10;

/// Writes `ego.turn_signal`, `ego.brake`, `ego.aeb`, `ego.cruise`, `ego.takeover`; a channel that the bus lacks is
/// always unknown.
pub fn write(bus: &EgoBus, frames: usize, table: &mut TableBuilder<'_>) {
    let flag = |v: &[Option<bool>]| (0..frames).map(|i| Tri::from(v.get(i).copied().flatten())).collect();
    table.flag(id::EGO_BRAKE, flag(&bus.brake));
    table.flag(id::EGO_AEB, flag(&bus.aeb));
    table.flag(id::EGO_CRUISE, flag(&bus.cruise));
    table.flag(id::EGO_TAKEOVER, takeovers(bus, frames));
    let indicator = |i: usize| bus.turn_signal.get(i).copied().flatten().map(turn_signal);
    table.category(id::EGO_TURN_SIGNAL, (0..frames).map(indicator));
}

/// True for one second from where cruise control ends with the driver's brake on. Unknown without either channel.
fn takeovers(bus: &EgoBus, frames: usize) -> Vec<Tri> {
    let cruise = |i: usize| bus.cruise.get(i).copied().flatten();
    let brake = |i: usize| bus.brake.get(i).copied().flatten();
    let taken = |i: usize| {
        let ends = i > 0 && cruise(i - 1) == Some(true) && cruise(i) == Some(false);
        let near = i.saturating_sub(TAKES_OVER_FRAMES)..=i + TAKES_OVER_FRAMES;
        ends && near.into_iter().any(|j| brake(j) == Some(true))
    };
    let since = |i: usize| (i.saturating_sub(REPORTED_FRAMES - 1)..=i).any(taken);
    let known = |i: usize| cruise(i).is_some() && brake(i).is_some();
    (0..frames).map(|i| if known(i) { Tri::from(since(i)) } else { Tri::Unknown }).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_brake_ends_cruise_control() {
        let bus = |braked: usize| EgoBus {
            cruise: (0..40).map(|i| Some(i < 20)).collect(),
            brake: (0..40).map(|i| Some(i >= braked)).collect(),
            ..EgoBus::default()
        };
        let at = |braked: usize, i: usize| takeovers(&bus(braked), 40)[i];
        assert_eq!((at(18, 19), at(18, 20), at(18, 29), at(18, 30)), {
            (Tri::False, Tri::True, Tri::True, Tri::False)
        });
        assert_eq!(at(35, 25), Tri::False, "switched off by hand");
        assert_eq!(takeovers(&EgoBus::default(), 2), [Tri::Unknown; 2]);
    }
}
