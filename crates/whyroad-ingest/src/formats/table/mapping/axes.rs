//! Axes and headings of other people's tables, and their turn into those of the layout: x east, y north, z up, headings
//! counter-clockwise from east.

use crate::assemble::angles::wrap_angle;
use std::f64::consts::FRAC_PI_2;

/// Where x, y and z point. `East` and `north` stand for any two perpendicular directions on the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in super::super) enum Axes {
    /// x east, y north, z up: as in the layout.
    #[default]
    EastNorthUp,
    /// x north, y east, z down: navigation.
    NorthEastDown,
    /// x north, y east, z up: left-handed, as simulators and surveyors have it.
    NorthEastUp,
    /// x north, y west, z up.
    NorthWestUp,
}

/// What headings count from, and in which sense.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Headings {
    CounterclockwiseFromEast,
    ClockwiseFromNorth,
    CounterclockwiseFromNorth,
}

impl Axes {
    pub const IDS: &[&str] = &["east_north_up", "north_east_down", "north_east_up", "north_west_up"];

    pub fn from_id(id: &str) -> Option<Self> {
        Some(match id {
            "east_north_up" | "enu" => Axes::EastNorthUp,
            "north_east_down" | "ned" => Axes::NorthEastDown,
            "north_east_up" | "neu" => Axes::NorthEastUp,
            "north_west_up" | "nwu" => Axes::NorthWestUp,
            _ => return None,
        })
    }

    /// The headings that go with the axes: from x towards y.
    pub fn headings(self) -> Headings {
        match self {
            Axes::EastNorthUp => Headings::CounterclockwiseFromEast,
            Axes::NorthEastDown | Axes::NorthEastUp => Headings::ClockwiseFromNorth,
            Axes::NorthWestUp => Headings::CounterclockwiseFromNorth,
        }
    }

    /// A point or vector in the axes of the layout.
    pub fn turned(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Axes::EastNorthUp => [x, y, z],
            Axes::NorthEastDown => [y, x, -z],
            Axes::NorthEastUp => [y, x, z],
            Axes::NorthWestUp => [-y, x, z],
        }
    }
}

impl Headings {
    pub const IDS: &[&str] =
        &["counterclockwise_from_east", "clockwise_from_north", "counterclockwise_from_north"];

    pub fn from_id(id: &str) -> Option<Self> {
        Some(match id {
            "counterclockwise_from_east" => Headings::CounterclockwiseFromEast,
            "clockwise_from_north" => Headings::ClockwiseFromNorth,
            "counterclockwise_from_north" => Headings::CounterclockwiseFromNorth,
            _ => return None,
        })
    }

    /// A heading, rad, counted as in the layout.
    pub fn turned(self, heading: f64) -> f64 {
        match self {
            Headings::CounterclockwiseFromEast => heading,
            Headings::ClockwiseFromNorth => wrap_angle(FRAC_PI_2 - heading),
            Headings::CounterclockwiseFromNorth => wrap_angle(FRAC_PI_2 + heading),
        }
    }

    /// -1 where turns to the right are positive.
    pub fn turn_sign(self) -> f64 {
        if self == Headings::ClockwiseFromNorth { -1.0 } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: something 3 m to the north-east side (north 3, east 4, up 5) of the origin.
    #[test]
    fn a_point_is_the_same_in_all_axes() {
        let forms = [
            (Axes::EastNorthUp, [4.0, 3.0, 5.0]),
            (Axes::NorthEastDown, [3.0, 4.0, -5.0]),
            (Axes::NorthEastUp, [3.0, 4.0, 5.0]),
            (Axes::NorthWestUp, [3.0, -4.0, 5.0]),
        ];
        assert!(forms.iter().all(|(axes, point)| axes.turned(*point) == [4.0, 3.0, 5.0]));
    }

    /// A car that drives north-west: 135 degrees from east, 315 on the compass, 45 to the left of north.
    #[test]
    fn a_heading_is_the_same_in_all_senses() {
        let forms = [
            (Headings::CounterclockwiseFromEast, 135.0_f64),
            (Headings::ClockwiseFromNorth, 315.0),
            (Headings::CounterclockwiseFromNorth, 45.0),
        ];
        let turned = forms.map(|(headings, degrees)| headings.turned(degrees.to_radians()).to_degrees());
        assert!(turned.iter().all(|h| (h - 135.0).abs() < 1e-9), "{turned:?}");
    }
}
