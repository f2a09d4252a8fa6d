//! Units of measure as rule texts and signal catalogs name them. Every value inside the system is in the
//! dimension's base unit (m, s, m/s, m/s2, m/s3, rad, rad/s, 1/m, ratio); conversion happens where text is read.

/// What kind of quantity a number is. Two numbers compare only when their dimensions are equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Dimension {
    /// A pure number, a ratio or a count.
    Ratio,
    /// Base unit meter.
    Length,
    /// Base unit second.
    Time,
    /// Base unit m/s.
    Speed,
    /// Base unit m/s2.
    Acceleration,
    /// Base unit m/s3.
    Jerk,
    /// Base unit radian.
    Angle,
    /// Base unit rad/s.
    AngularSpeed,
    /// Base unit 1/m.
    Curvature,
}

/// A named unit: its dimension and the factor that turns a value in it into the base unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// As written.
    pub symbol: &'static str,
    /// Kind of quantity.
    pub dimension: Dimension,
    /// `base = value * to_base`.
    pub to_base: f64,
}

const fn unit(symbol: &'static str, dimension: Dimension, to_base: f64) -> Unit {
    Unit { symbol, dimension, to_base }
}

/// All units, base units first within each dimension.
pub const UNITS: &[Unit] = &[
    unit("", Dimension::Ratio, 1.0),
    unit("%", Dimension::Ratio, 0.01),
    unit("m", Dimension::Length, 1.0),
    unit("cm", Dimension::Length, 0.01),
    unit("km", Dimension::Length, 1000.0),
    unit("s", Dimension::Time, 1.0),
    unit("ms", Dimension::Time, 1e-3),
    unit("min", Dimension::Time, 60.0),
    unit("m/s", Dimension::Speed, 1.0),
    unit("km/h", Dimension::Speed, 1.0 / 3.6),
    // International mile: 1609.344 m.
    unit("mph", Dimension::Speed, 0.44704),
    unit("m/s2", Dimension::Acceleration, 1.0),
    // Standard gravity, CGPM 1901.
    unit("g", Dimension::Acceleration, 9.80665),
    unit("m/s3", Dimension::Jerk, 1.0),
    unit("rad", Dimension::Angle, 1.0),
    unit("deg", Dimension::Angle, std::f64::consts::PI / 180.0),
    unit("rad/s", Dimension::AngularSpeed, 1.0),
    unit("deg/s", Dimension::AngularSpeed, std::f64::consts::PI / 180.0),
    unit("1/m", Dimension::Curvature, 1.0),
];

impl Unit {
    /// A number in this unit as displayed: `30 km/h`, `20°`, `3 m/s²`.
    pub fn of(&self, number: &str) -> String {
        match self.symbol {
            "" => number.to_owned(),
            "%" => format!("{number}%"),
            "deg" => format!("{number}°"),
            "deg/s" => format!("{number}°/s"),
            "m/s2" => format!("{number} m/s²"),
            "m/s3" => format!("{number} m/s³"),
            symbol => format!("{number} {symbol}"),
        }
    }

    /// The unit written as `symbol`, if there is one.
    pub fn parse(symbol: &str) -> Option<&'static Unit> {
        UNITS.iter().find(|u| u.symbol == symbol)
    }

    /// The unit in which people read values of this one: degrees for radians, otherwise the same.
    pub fn displayed(&'static self) -> &'static Unit {
        let symbol = match self.symbol {
            "rad" => "deg",
            "rad/s" => "deg/s",
            same => same,
        };
        Unit::parse(symbol).unwrap_or(self)
    }

    /// A value in this unit as a value in `other`, which has the same dimension.
    pub fn convert(&self, value: f64, other: &Unit) -> f64 {
        if self == other { value } else { value * self.to_base / other.to_base }
    }

    /// `base`, a value in the dimension's base unit, in this unit.
    pub fn of_base(&self, base: f64) -> f64 {
        base / self.to_base
    }
}

impl Dimension {
    /// The unit that values of this dimension are stored in.
    pub fn base(self) -> &'static Unit {
        // Every dimension has a base unit in the table; the first entry is the fallback for `Ratio`.
        UNITS.iter().find(|u| u.dimension == self && u.to_base == 1.0).unwrap_or(&UNITS[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixty_kmh_is_sixteen_and_two_thirds() {
        let u = Unit::parse("km/h").unwrap();
        assert!((60.0 * u.to_base - 16.666_666_666_666_668).abs() < 1e-12);
        assert_eq!(u.dimension.base().symbol, "m/s");
    }

    #[test]
    fn people_read_angles_in_degrees() {
        let unit = |symbol| Unit::parse(symbol).unwrap();
        assert_eq!(unit("rad").displayed().symbol, "deg");
        assert_eq!(unit("rad/s").displayed().symbol, "deg/s");
        assert_eq!(unit("km/h").displayed().symbol, "km/h");
        let right_angle = unit("rad").convert(std::f64::consts::FRAC_PI_2, unit("deg"));
        assert!((right_angle - 90.0).abs() < 1e-12, "{right_angle}");
    }
}
