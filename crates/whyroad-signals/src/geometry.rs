//! Plane geometry that the signals share: angles, points, polylines by arc length, polygons, oriented boxes.
//! Independent of driving.

mod angle;
mod box_grid;
mod last_place;
mod near_areas;
mod oriented_box;
mod polygon;
mod polyline;

pub use angle::{angle_between_lines, unwrap, wrap};
pub use box_grid::BoxGrid;
pub use last_place::LastPlace;
pub use near_areas::NearAreas;
pub use oriented_box::OrientedBox;
pub use polygon::Polygon;
pub use polyline::{Foot, Nearby, Polyline, Projection, Ray, Window, interpolate};

use std::ops::{Add, Mul, Sub};

/// A point or vector in the plane of the world frame, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct P2 {
    /// m.
    pub x: f64,
    /// m.
    pub y: f64,
}

/// The point `(x, y)`.
pub const fn p2(x: f64, y: f64) -> P2 {
    P2 { x, y }
}

impl P2 {
    /// Unit vector with this heading (rad).
    pub fn from_heading(heading: f64) -> P2 {
        let (y, x) = heading.sin_cos();
        P2 { x, y }
    }
    /// Scalar product.
    pub fn dot(self, o: P2) -> f64 {
        self.x * o.x + self.y * o.y
    }
    /// z of the cross product: positive when `o` is counter-clockwise of `self`.
    pub fn cross(self, o: P2) -> f64 {
        self.x * o.y - self.y * o.x
    }
    /// Length.
    pub fn norm(self) -> f64 {
        self.x.hypot(self.y)
    }
    /// True when its length is at most `reach`: `norm() <= reach`, mostly decided by the square of the length.
    pub fn is_within(self, reach: f64) -> bool {
        let (length2, reach2) = (self.dot(self), reach * reach);
        if length2 < reach2 * (1.0 - 1e-12) {
            reach > 0.0
        } else if length2 > reach2 * (1.0 + 1e-12) {
            false
        } else {
            self.norm() <= reach
        }
    }
    /// True for equal bits, so that all results computed from either are equal.
    pub fn has_bits_of(self, o: P2) -> bool {
        self.x.to_bits() == o.x.to_bits() && self.y.to_bits() == o.y.to_bits()
    }
    /// Turned left by a right angle.
    pub fn left(self) -> P2 {
        p2(-self.y, self.x)
    }
    /// Direction, rad in (-pi, pi].
    pub fn heading(self) -> f64 {
        self.y.atan2(self.x)
    }
    /// True when both numbers are finite.
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite()
    }
}

impl Add for P2 {
    type Output = P2;
    fn add(self, o: P2) -> P2 {
        p2(self.x + o.x, self.y + o.y)
    }
}
impl Sub for P2 {
    type Output = P2;
    fn sub(self, o: P2) -> P2 {
        p2(self.x - o.x, self.y - o.y)
    }
}
impl Mul<f64> for P2 {
    type Output = P2;
    fn mul(self, k: f64) -> P2 {
        p2(self.x * k, self.y * k)
    }
}
