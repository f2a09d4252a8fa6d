//! Which signals of a make's DBC hold the states of the car.

/// Which signal of a make's DBC holds a state, and how long one message is valid: cars repeat them at different rates.
pub(super) struct StateSource {
    pub message: &'static str,
    pub signal: &'static str,
    pub holds_s: f64,
}

/// Messages of Toyota's 2017 DBC (opendbc). Brake light and brake pedal messages come 30 times a second or more, gear
/// and cruise once a second, indicators every 8.5 s and at each change; each holds for a good two periods.
pub(super) const BRAKE: StateSource =
    StateSource { message: "PCM_CRUISE_2", signal: "BRAKE_PRESSED", holds_s: 0.25 };
pub(super) const BRAKE_LIGHT: StateSource =
    StateSource { message: "VSC1S07", signal: "BRKON", holds_s: 0.25 };
pub(super) const CRUISE: StateSource =
    StateSource { message: "PCM_CRUISE_SM", signal: "CRUISE_CONTROL_STATE", holds_s: 2.5 };
pub(super) const GEAR: StateSource = StateSource { message: "GEAR_PACKET", signal: "GEAR", holds_s: 2.5 };
pub(super) const TURN: StateSource =
    StateSource { message: "BLINKERS_STATE", signal: "TURN_SIGNALS", holds_s: 20.0 };
pub(super) const HAZARD: StateSource =
    StateSource { message: "BLINKERS_STATE", signal: "HAZARD_LIGHT", holds_s: 20.0 };

/// The wanted states, as text for messages.
pub(super) fn looked_for() -> String {
    let names: Vec<String> =
        [&BRAKE_LIGHT, &BRAKE, &CRUISE, &GEAR, &TURN].map(|s| format!("{}.{}", s.message, s.signal)).into();
    names.join(", ")
}
