//! Options of the SUMO adapter.

use super::egos::Egos;
use super::sensing::{Occlusion, Sensing};
use crate::options::{LICENCE, OptionSpec, OptionType, Options, START};

/// A vehicle that is an ego.
pub const EGO: OptionSpec = OptionSpec::new(
    "ego",
    OptionType::Text,
    "ID",
    "vehicle that is an ego (repeatable; each becomes a drive; default: ego)",
)
.repeatable()
.conflicts_with(&["ego-share"]);
/// Share of all motor vehicles that are egos.
pub const EGO_SHARE: OptionSpec = OptionSpec::new(
    "ego-share",
    OptionType::Number { min: 0.0, max: 1.0 },
    "SHARE",
    "draw this share of all motor vehicles as egos, 0 to 1",
);
/// Seed of the draw.
pub const SEED: OptionSpec =
    OptionSpec::new("seed", OptionType::Integer, "N", "seed of the draw (default: 0)").requires("ego-share");
/// Range of the ego's sensor, m.
pub const SENSOR_RANGE: OptionSpec = OptionSpec::new(
    "sensor-range",
    OptionType::Number { min: f64::MIN_POSITIVE, max: f64::INFINITY },
    "METRES",
    "range of the ego's sensor, m, or inf for unlimited (default: 150)",
);
/// What a car's sensors see of other traffic, m; a simulation knows all objects in the network.
const DEFAULT_RANGE_M: f64 = 150.0;
/// Whether vehicles hide others.
pub const OCCLUSION: OptionSpec =
    OptionSpec::new("occlusion", OptionType::Flag, "", "leave out what other vehicles hide from the ego");
/// The network.
pub const NET: OptionSpec =
    OptionSpec::new("net", OptionType::File, "FILE", "network, when it is not beside the FCD file");
/// Vehicle types.
pub const TYPES: OptionSpec = OptionSpec::new(
    "types",
    OptionType::File,
    "FILE",
    "file with vehicle types, when it is not beside the FCD file or one folder up (repeatable)",
)
.repeatable();
/// Light states.
pub const LIGHTS: OptionSpec = OptionSpec::new(
    "lights",
    OptionType::File,
    "FILE",
    "states of the traffic lights, when they are not beside the FCD file",
);

pub(super) const ALL: &[OptionSpec] =
    &[EGO, EGO_SHARE, SEED, SENSOR_RANGE, OCCLUSION, NET, TYPES, LIGHTS, START, LICENCE];

/// The vehicles that become egos.
pub(super) fn egos(options: &Options) -> Egos {
    match options.number(&EGO_SHARE) {
        Some(share) => Egos::Share { share, seed: options.integer(&SEED).unwrap_or(0) },
        None if options.is_set(&EGO) => Egos::Named(options.texts(&EGO)),
        None => Egos::default(),
    }
}

/// What the ego senses.
pub(super) fn sensing(options: &Options) -> Sensing {
    Sensing {
        range_m: match options.number(&SENSOR_RANGE) {
            None => Some(DEFAULT_RANGE_M),
            Some(range) => range.is_finite().then_some(range),
        },
        occlusion: if options.is_set(&OCCLUSION) { Occlusion::ByBoxes } else { Occlusion::Ignored },
    }
}
