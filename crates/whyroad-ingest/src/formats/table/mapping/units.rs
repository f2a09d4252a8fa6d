//! Units of other people's columns. What a column of the layout counts in is in its name (`speed_mps`); a mapping says
//! what the fleet's own column counts in.

/// What a column measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Dimension {
    Length,
    Speed,
    Acceleration,
    Angle,
    AngularSpeed,
    Time,
    Share,
    /// A sign's or a state's number: a speed for limits, else a length.
    SpeedOrLength,
}

/// A unit and its size in the unit of the SI: m, m/s, m/s², rad, rad/s, s, 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct Unit {
    pub name: &'static str,
    pub dimension: Dimension,
    pub size: f64,
}

const fn unit(name: &'static str, dimension: Dimension, size: f64) -> Unit {
    Unit { name, dimension, size }
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// Standard gravity (CGPM 1901), international foot (1959), mile and nautical mile.
const GRAVITY: f64 = 9.80665;
const FOOT: f64 = 0.3048;
const MILE: f64 = 1609.344;
const NAUTICAL_MILE: f64 = 1852.0;

const UNITS: &[Unit] = &[
    unit("m", Dimension::Length, 1.0),
    unit("cm", Dimension::Length, 0.01),
    unit("mm", Dimension::Length, 0.001),
    unit("km", Dimension::Length, 1000.0),
    unit("ft", Dimension::Length, FOOT),
    unit("in", Dimension::Length, FOOT / 12.0),
    unit("m/s", Dimension::Speed, 1.0),
    unit("cm/s", Dimension::Speed, 0.01),
    unit("km/h", Dimension::Speed, 1.0 / 3.6),
    unit("mph", Dimension::Speed, MILE / 3600.0),
    unit("kn", Dimension::Speed, NAUTICAL_MILE / 3600.0),
    unit("ft/s", Dimension::Speed, FOOT),
    unit("m/s2", Dimension::Acceleration, 1.0),
    unit("cm/s2", Dimension::Acceleration, 0.01),
    unit("ft/s2", Dimension::Acceleration, FOOT),
    unit("g", Dimension::Acceleration, GRAVITY),
    unit("rad", Dimension::Angle, 1.0),
    unit("mrad", Dimension::Angle, 0.001),
    unit("deg", Dimension::Angle, DEGREE),
    unit("rad/s", Dimension::AngularSpeed, 1.0),
    unit("mrad/s", Dimension::AngularSpeed, 0.001),
    unit("deg/s", Dimension::AngularSpeed, DEGREE),
    unit("s", Dimension::Time, 1.0),
    unit("ms", Dimension::Time, 1e-3),
    unit("us", Dimension::Time, 1e-6),
    unit("ns", Dimension::Time, 1e-9),
    unit("1", Dimension::Share, 1.0),
    unit("%", Dimension::Share, 0.01),
];

/// Other spellings.
const SPELLINGS: &[(&str, &str)] = &[
    ("kmh", "km/h"),
    ("km/hr", "km/h"),
    ("kph", "km/h"),
    ("mps", "m/s"),
    ("mi/h", "mph"),
    ("kt", "kn"),
    ("m/s^2", "m/s2"),
    ("m/s²", "m/s2"),
    ("mps2", "m/s2"),
    ("°", "deg"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("°/s", "deg/s"),
    ("dps", "deg/s"),
    ("radps", "rad/s"),
    ("µs", "us"),
    ("μs", "us"),
    ("percent", "%"),
];

impl Unit {
    pub fn named(name: &str) -> Option<Self> {
        let name = SPELLINGS.iter().find(|(spelling, _)| *spelling == name).map_or(name, |(_, name)| name);
        UNITS.iter().copied().find(|u| u.name == name)
    }
}

impl Dimension {
    /// What a column of the layout measures, and the size of the unit in its name; `None` for texts and counts.
    pub fn of_column(name: &str) -> Option<(Self, f64)> {
        Some(match name {
            "throttle" | "visible_share" | "confidence" => (Dimension::Share, 1.0),
            "value" => (Dimension::SpeedOrLength, 1.0),
            "timestamp_ns" => (Dimension::Time, 1e-9),
            _ => match name.rsplit_once('_')?.1 {
                "m" => (Dimension::Length, 1.0),
                "mps" => (Dimension::Speed, 1.0),
                "mps2" => (Dimension::Acceleration, 1.0),
                "rad" => (Dimension::Angle, 1.0),
                "deg" => (Dimension::Angle, DEGREE),
                "radps" => (Dimension::AngularSpeed, 1.0),
                "s" => (Dimension::Time, 1.0),
                _ => return None,
            },
        })
    }

    pub fn fits(self, unit: Unit) -> bool {
        let either = [Dimension::Speed, Dimension::Length].contains(&unit.dimension);
        self == unit.dimension || (self == Dimension::SpeedOrLength && either)
    }

    /// Names of its units.
    pub fn units(self) -> Vec<&'static str> {
        UNITS.iter().filter(|u| self.fits(**u)).map(|u| u.name).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Definitions: 1 mile = 1609.344 m, 1 knot = 1852 m an hour, a full turn = 360 degrees.
    #[test]
    fn units_have_their_defined_size() {
        let size = |name| Unit::named(name).map_or(f64::NAN, |u| u.size);
        let pairs = [(36.0 * size("km/h"), 10.0), (3600.0 * size("mph"), 1609.344), (size("ft"), 0.3048)];
        assert!(pairs.iter().all(|(a, b)| (a - b).abs() < 1e-9), "{pairs:?}");
        assert!((360.0 * size("deg") - std::f64::consts::TAU).abs() < 1e-12);
        assert_eq!((Unit::named("kmh"), Unit::named("furlong")), (Unit::named("km/h"), None));
        // Every spelling leads to a unit, and every dimension has one of size 1.
        assert!(SPELLINGS.iter().all(|(s, _)| Unit::named(s).is_some()));
        assert_eq!(Dimension::of_column("yaw_rate_radps").map(|d| d.0), Some(Dimension::AngularSpeed));
        assert_eq!(Dimension::of_column("track_id"), None);
    }
}
