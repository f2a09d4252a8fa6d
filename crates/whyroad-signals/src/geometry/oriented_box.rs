//! Oriented rectangles: corners, overlap, distance, and the time until two moving ones touch.

use super::P2;
use super::polyline::segment_distance2;

/// A rectangle with a heading: the footprint of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedBox {
    /// Centre, m.
    pub centre: P2,
    /// Direction of the length, rad.
    pub heading: f64,
    /// m.
    pub length: f64,
    /// m.
    pub width: f64,
}

impl OrientedBox {
    /// Corners counter-clockwise: front left, rear left, rear right, front right.
    pub fn corners(&self) -> [P2; 4] {
        self.corners_along(P2::from_heading(self.heading))
    }

    /// The corners of a box whose heading is that of the unit vector `direction`.
    fn corners_along(&self, direction: P2) -> [P2; 4] {
        let (forward, left) = (direction * (self.length / 2.0), direction.left() * (self.width / 2.0));
        let c = self.centre;
        [c + forward + left, c - forward + left, c - forward - left, c + forward - left]
    }

    /// Radius of the circle around the box.
    pub fn radius(&self) -> f64 {
        self.length.hypot(self.width) / 2.0
    }

    /// True when the two share at least a point.
    pub fn overlaps(&self, other: &OrientedBox) -> bool {
        (other.centre - self.centre).norm() <= self.radius() + other.radius()
            && self.overlaps_along(other, P2::from_heading(self.heading), P2::from_heading(other.heading))
    }

    /// [`OrientedBox::overlaps`] of two boxes that are near each other, with the unit vectors of their headings.
    fn overlaps_along(&self, other: &OrientedBox, own: P2, their: P2) -> bool {
        axes(own, their).into_iter().all(|axis| {
            let (a, b) = (self.extent(own, axis), other.extent(their, axis));
            a.0 <= b.1 && b.0 <= a.1
        })
    }

    /// Shortest distance between the two, 0 when they overlap, m.
    pub fn distance(&self, other: &OrientedBox) -> f64 {
        let (own, their) = (P2::from_heading(self.heading), P2::from_heading(other.heading));
        let near = (other.centre - self.centre).norm() <= self.radius() + other.radius();
        if near && self.overlaps_along(other, own, their) {
            return 0.0;
        }
        let (a, b) = (self.corners_along(own), other.corners_along(their));
        let mut d2 = f64::INFINITY;
        for i in 0..4 {
            for j in 0..4 {
                // Apart, the shortest way between convex shapes ends at a corner of one of them.
                d2 = d2.min(segment_distance2(a[i], b[j], b[(j + 1) % 4]));
                d2 = d2.min(segment_distance2(b[i], a[j], a[(j + 1) % 4]));
            }
        }
        d2.sqrt()
    }

    /// True when the shortest distance between the two is greater than `reach`, m.
    pub fn is_farther(&self, other: &OrientedBox, reach: f64) -> bool {
        // Beyond what rounding can do, the circles around them tell.
        let least = (other.centre - self.centre).norm() - self.radius() - other.radius();
        least > reach + 1e-6 || self.distance(other) > reach
    }

    /// Seconds until the two first touch when each keeps its velocity (m/s) and heading: 0 when they overlap
    /// now, infinity when they never touch. On each separating axis the shadows overlap during one interval;
    /// the boxes touch where all intervals do.
    pub fn time_to_contact(&self, velocity: P2, other: &OrientedBox, other_velocity: P2) -> f64 {
        let relative = other_velocity - velocity;
        let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
        let (own, their) = (P2::from_heading(self.heading), P2::from_heading(other.heading));
        for axis in axes(own, their) {
            let (a, b) = (self.extent(own, axis), other.extent(their, axis));
            let v = relative.dot(axis);
            // Shadows: [b0 + v t, b1 + v t] against [a0, a1].
            if v.abs() < 1e-9 {
                if a.0 > b.1 || b.0 > a.1 {
                    return f64::INFINITY;
                }
                continue;
            }
            let (t0, t1) = ((a.0 - b.1) / v, (a.1 - b.0) / v);
            enter = enter.max(t0.min(t1));
            leave = leave.min(t0.max(t1));
        }
        if enter <= leave { enter } else { f64::INFINITY }
    }

    /// Shadow on an axis; `forward` is the unit vector of the heading.
    fn extent(&self, forward: P2, axis: P2) -> (f64, f64) {
        let half = (forward.dot(axis) * self.length).abs() / 2.0
            + (forward.left().dot(axis) * self.width).abs() / 2.0;
        let centre = self.centre.dot(axis);
        (centre - half, centre + half)
    }
}

/// Directions on which boxes with these directions can be separate.
fn axes(a: P2, b: P2) -> [P2; 4] {
    [a, a.left(), b, b.left()]
}

/// A box of the given size at the origin, for tests of this crate.
#[cfg(test)]
pub(crate) fn box_at(x: f64, y: f64, heading: f64, length: f64, width: f64) -> OrientedBox {
    OrientedBox { centre: P2 { x, y }, heading, length, width }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::p2;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    #[test]
    fn distances_by_hand() {
        let a = box_at(0.0, 0.0, 0.0, 4.0, 2.0);
        // Bumpers at x = 2 and x = 8.
        assert!((a.distance(&box_at(10.0, 0.0, 0.0, 4.0, 2.0)) - 6.0).abs() < 1e-12);
        // Corner (2, 1) to corner (5, 5): 3-4-5.
        assert!((a.distance(&box_at(6.0, 6.0, FRAC_PI_2, 2.0, 2.0)) - 5.0).abs() < 1e-12);
        // A square on its tip, half diagonal sqrt 2: tip at 4 - sqrt 2, side at 2.
        let tip = box_at(4.0, 0.0, FRAC_PI_4, 2.0, 2.0);
        assert!((a.distance(&tip) - (2.0 - 2.0_f64.sqrt())).abs() < 1e-12);
        assert_eq!(a.distance(&box_at(1.0, 1.0, 0.3, 4.0, 2.0)), 0.0);
        // A plus sign: they overlap though no corner is inside the other.
        assert_eq!(box_at(0.0, 0.0, 0.0, 10.0, 1.0).distance(&box_at(0.0, 0.0, FRAC_PI_2, 10.0, 1.0)), 0.0);
    }

    #[test]
    fn contact_times_by_hand() {
        let ego = box_at(0.0, 0.0, 0.0, 4.0, 2.0);
        let still = p2(0.0, 0.0);
        let lead = box_at(24.0, 0.0, 0.0, 4.0, 2.0);
        // Gap 20 m closed at 10 m/s.
        assert!((ego.time_to_contact(p2(15.0, 0.0), &lead, p2(5.0, 0.0)) - 2.0).abs() < 1e-12);
        assert_eq!(ego.time_to_contact(p2(5.0, 0.0), &lead, p2(6.0, 0.0)), f64::INFINITY);
        assert_eq!(ego.time_to_contact(still, &lead, still), f64::INFINITY);
        // Next lane: parallel and 3.5 m beside, never.
        let beside = box_at(24.0, 3.5, 0.0, 4.0, 2.0);
        assert_eq!(ego.time_to_contact(p2(15.0, 0.0), &beside, still), f64::INFINITY);
        // From the right at a right angle, 2 x 1 m walker: its top edge at y = -9 reaches y = -1 after 8 s at 1 m/s,
        // and is over the ego's length then.
        let walker = box_at(0.0, -10.0, FRAC_PI_2, 2.0, 1.0);
        assert!((ego.time_to_contact(still, &walker, p2(0.0, 1.0)) - 8.0).abs() < 1e-12);
        // The ego drives out of the way first: rear at x = -2 passes the walker's right edge x = 0.5 after 1.25 s.
        assert_eq!(ego.time_to_contact(p2(2.0, 0.0), &walker, p2(0.0, 1.0)), f64::INFINITY);
        assert_eq!(ego.time_to_contact(still, &box_at(1.0, 0.0, 0.0, 4.0, 2.0), p2(9.0, 0.0)), 0.0);
    }
}
