//! A displayed number: a stored value (base unit) together with its display unit, so that a value is never shown with
//! the wrong unit.

use crate::units::Unit;

/// A number in a named unit. Made from a value in the dimension's base unit; both parts change together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displayed {
    value: f64,
    unit: &'static Unit,
}

impl Displayed {
    /// `base`, a value in the base unit of `unit`'s dimension, in `unit`.
    pub fn of_base(base: f64, unit: &'static Unit) -> Self {
        Self { value: unit.of_base(base), unit }
    }

    /// The value in [`Displayed::unit`].
    pub fn value(self) -> f64 {
        self.value
    }

    /// The unit.
    pub fn unit(self) -> &'static Unit {
        self.unit
    }

    /// The value without its unit, with at most `digits` decimals.
    pub fn number(self, digits: usize) -> String {
        number(self.value, digits)
    }

    /// The value and its unit with at most `digits` decimals: `8.3 m/s`. A pure number has no unit.
    pub fn text(self, digits: usize) -> String {
        match self.unit.symbol {
            "" => self.number(digits),
            "%" => format!("{}%", self.number(digits)),
            symbol => format!("{} {symbol}", self.number(digits)),
        }
    }
}

/// A number with at most `digits` decimals: no trailing zeros, no negative zero; infinity and NaN as symbols.
pub fn number(value: f64, digits: usize) -> String {
    if value.is_nan() {
        return "–".to_owned();
    }
    if value.is_infinite() {
        return if value > 0.0 { "∞" } else { "-∞" }.to_owned();
    }
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_in_the_base_unit_is_displayed_in_its_unit() {
        let deg = Unit::parse("deg").unwrap();
        // A right angle.
        let angle = Displayed::of_base(std::f64::consts::FRAC_PI_2, deg);
        assert!((angle.value() - 90.0).abs() < 1e-9);
        assert_eq!(angle.text(1), "90 deg");
        // 10 m/s = 36 km/h.
        assert_eq!(Displayed::of_base(10.0, Unit::parse("km/h").unwrap()).text(2), "36 km/h");
        assert_eq!(Displayed::of_base(0.25, Unit::parse("%").unwrap()).text(0), "25%");
        assert_eq!(Displayed::of_base(0.5, Unit::parse("").unwrap()).text(2), "0.5");
        assert_eq!(Displayed::of_base(f64::INFINITY, deg).text(2), "∞ deg");
        assert_eq!(number(-0.001, 2), "0");
    }
}
