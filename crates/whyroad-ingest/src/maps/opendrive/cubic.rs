//! Values along a road as OpenDRIVE writes them: cubic polynomials, each from a station on.

use crate::encodings::xml::Element;

/// `a + b d + c d^2 + d d^3`, `d` counted from `start`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cubic {
    /// Station from which it holds, m.
    pub start: f64,
    pub coefficients: [f64; 4],
}

/// The value of a polynomial, lowest power first.
pub(super) fn polynomial(c: [f64; 4], x: f64) -> f64 {
    c[0] + x * (c[1] + x * (c[2] + x * c[3]))
}

/// Its derivative.
pub(super) fn slope(c: [f64; 4], x: f64) -> f64 {
    c[1] + x * (2.0 * c[2] + x * 3.0 * c[3])
}

impl Cubic {
    /// From the attributes `a` to `d`; `None` where the constant is not stated.
    pub fn of(e: &Element<'_>, start: &str) -> Option<Self> {
        let rest = |name| e.number(name).unwrap_or(0.0);
        Some(Self {
            start: e.number(start)?,
            coefficients: [e.number("a")?, rest("b"), rest("c"), rest("d")],
        })
    }

    fn is_straight(&self) -> bool {
        self.coefficients[2] == 0.0 && self.coefficients[3] == 0.0
    }
}

/// Cubics, by ascending station once sorted.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Profile(Vec<Cubic>);

impl Profile {
    /// Adds a record; [`Profile::sort`] when all are there.
    pub fn push(&mut self, cubic: Cubic) {
        self.0.push(cubic);
    }

    pub fn sort(&mut self) {
        self.0.sort_by(|a, b| a.start.total_cmp(&b.start));
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// True when it is the same everywhere.
    pub fn is_flat(&self) -> bool {
        let flat = |c: &Cubic| c.coefficients[1..].iter().all(|v| *v == 0.0);
        self.0.iter().all(|c| flat(c) && c.coefficients[0] == self.0[0].coefficients[0])
    }

    /// The value at a station; 0 where nothing is stated.
    pub fn at(&self, station: f64) -> f64 {
        let record = self.0.partition_point(|c| c.start <= station).saturating_sub(1);
        self.0.get(record).map_or(0.0, |c| polynomial(c.coefficients, station - c.start))
    }

    /// Stations at which a record begins.
    pub fn starts(&self) -> impl Iterator<Item = f64> {
        self.0.iter().map(|c| c.start)
    }

    /// True when the record that holds between two neighboring stations is a straight line.
    pub fn is_straight(&self, from: f64) -> bool {
        let record = self.0.partition_point(|c| c.start <= from + 1e-9).saturating_sub(1);
        self.0.get(record).is_none_or(Cubic::is_straight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_record_that_holds_is_the_last_one_begun() {
        let mut p = Profile::default();
        p.push(Cubic { start: 10.0, coefficients: [5.0, 0.0, 0.0, 0.0] });
        p.push(Cubic { start: 0.0, coefficients: [1.0, 2.0, 0.5, 0.25] });
        p.sort();
        // 1 + 2*2 + 0.5*4 + 0.25*8 = 9.
        assert_eq!([p.at(2.0), p.at(10.0), p.at(99.0)], [9.0, 5.0, 5.0]);
        assert!(!p.is_straight(3.0) && p.is_straight(10.0) && !p.is_flat());
        // 2 + 2*0.5*2 + 3*0.25*4 = 7.
        assert_eq!(slope([1.0, 2.0, 0.5, 0.25], 2.0), 7.0);
        assert_eq!(Profile::default().at(3.0), 0.0);
    }
}
