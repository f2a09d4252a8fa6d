//! Oriented rectangles: corners, overlap, distance, and the time until two moving ones touch.
#![allow(
    clippy::needless_range_loop,
    reason = "several arrays go by one index, and are kept in registers so"
)]

use super::P2;
use super::polyline::segment_distance2;

/// A rectangle with a heading: the footprint of an object. Its direction and its radius are computed once at its
/// creation, because they are used many times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedBox {
    /// Center, m.
    pub center: P2,
    /// Direction of the length, rad; NaN where it is unknown, also of a nearly round box.
    pub heading: f64,
    /// m.
    pub length: f64,
    /// m.
    pub width: f64,
    direction: P2,
    radius: f64,
}

/// A box with sides of at most this, m, which differ by at most that, m, is nearly round, as that of a person: where
/// its heading is unknown, any will do. A square of 0.5 m reaches 0.10 m further at its corners than at its sides.
const SMALL_M: f64 = 1.0;
const ROUND_M: f64 = 0.3;

impl OrientedBox {
    /// A box; sizes in m, `heading` in rad. Unknown values are NaN.
    pub fn new(center: P2, heading: f64, length: f64, width: f64) -> Self {
        let is_round = length.max(width) <= SMALL_M && (length - width).abs() <= ROUND_M;
        let along = if heading.is_nan() && is_round { 0.0 } else { heading };
        let (direction, radius) = (P2::from_heading(along), length.hypot(width) / 2.0);
        Self { center, heading, length, width, direction, radius }
    }

    /// A box without extent.
    pub fn point(center: P2) -> Self {
        Self { center, heading: 0.0, length: 0.0, width: 0.0, direction: P2 { x: 1.0, y: 0.0 }, radius: 0.0 }
    }

    /// True when size and heading are known, or the size is that of a nearly round box.
    pub fn is_known(&self) -> bool {
        self.length.is_finite() && self.width.is_finite() && self.direction.x.is_finite()
    }

    /// True for equal bits, so that all results computed from either are equal.
    pub fn has_bits_of(&self, other: &OrientedBox) -> bool {
        let bits = |b: &OrientedBox| [b.heading, b.length, b.width].map(f64::to_bits);
        self.center.has_bits_of(other.center) && bits(self) == bits(other)
    }

    /// The same box at another position.
    pub fn moved_to(&self, center: P2) -> Self {
        Self { center, ..*self }
    }

    /// Unit vector of the heading.
    pub fn direction(&self) -> P2 {
        self.direction
    }

    /// Corners counter-clockwise: front left, rear left, rear right, front right.
    pub fn corners(&self) -> [P2; 4] {
        let (forward, left) =
            (self.direction * (self.length / 2.0), self.direction.left() * (self.width / 2.0));
        let c = self.center;
        [c + forward + left, c - forward + left, c - forward - left, c + forward - left]
    }

    /// Radius of the circle around the box, m.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// True when the two have a point in common.
    pub fn overlaps(&self, other: &OrientedBox) -> bool {
        (other.center - self.center).is_within(self.radius + other.radius) && self.shadows_overlap(other)
    }

    /// [`OrientedBox::overlaps`] for two boxes that are near each other.
    fn shadows_overlap(&self, other: &OrientedBox) -> bool {
        axes(self.direction, other.direction).into_iter().all(|axis| {
            let (a, b) = (self.shadow(axis), other.shadow(axis));
            a.0 <= b.1 && b.0 <= a.1
        })
    }

    /// Shortest distance between the two, 0 if they overlap, m.
    pub fn distance(&self, other: &OrientedBox) -> f64 {
        if self.overlaps(other) {
            return 0.0;
        }
        let (a, b) = (self.corners(), other.corners());
        // The shortest line between separate convex shapes ends at a corner of one of them. First computed to within
        // rounding, without division, corner by corner; exactly only for corners that can be nearest.
        let about = [other.about_distances2(&a), self.about_distances2(&b)];
        let least = about.as_flattened().iter().copied().fold(f64::INFINITY, f64::min);
        // The rounding error of corners depends on their coordinates.
        let size = |b: &OrientedBox| b.center.x.abs() + b.center.y.abs() + b.length.abs() + b.width.abs();
        let enough = (least.sqrt() * (1.0 + 1e-9) + 1e-6 + 1e-14 * (size(self) + size(other))).powi(2);
        let mut d2 = f64::INFINITY;
        for (about, corners, sides) in [(about[0], &a, &b), (about[1], &b, &a)] {
            for i in 0..4 {
                // Unknown values are kept.
                if about[i] > enough {
                    continue;
                }
                for j in 0..4 {
                    d2 = d2.min(segment_distance2(corners[i], sides[j], sides[(j + 1) % 4]));
                }
            }
        }
        d2.sqrt()
    }

    /// Squared distances of these corners from the box, to within rounding; 0 for those inside.
    fn about_distances2(&self, corners: &[P2; 4]) -> [f64; 4] {
        let (forward, left) = (self.direction, self.direction.left());
        let (half_length, half_width) = (0.5 * self.length, 0.5 * self.width);
        let mut out = [0.0; 4];
        for i in 0..4 {
            let to = corners[i] - self.center;
            let ahead = (to.dot(forward).abs() - half_length).max(0.0);
            let aside = (to.dot(left).abs() - half_width).max(0.0);
            out[i] = ahead * ahead + aside * aside;
        }
        out
    }

    /// Seconds until the two first touch when each keeps its velocity (m/s) and heading: 0 if they overlap now,
    /// infinity if they never touch. On each separating axis the projections overlap during one interval; the boxes
    /// touch where all intervals do.
    pub fn time_to_contact(&self, velocity: P2, other: &OrientedBox, other_velocity: P2) -> f64 {
        let relative = other_velocity - velocity;
        let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
        for axis in axes(self.direction, other.direction) {
            let (a, b) = (self.shadow(axis), other.shadow(axis));
            let v = relative.dot(axis);
            // Projections: [b0 + v t, b1 + v t] against [a0, a1].
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

    /// Lowest and highest position on an axis of length 1, m.
    pub fn shadow(&self, axis: P2) -> (f64, f64) {
        let (half, center) = (self.half_along(axis), self.center.dot(axis));
        (center - half, center + half)
    }

    /// Half its extent on an axis of length 1, m.
    pub fn half_along(&self, axis: P2) -> f64 {
        (self.direction.dot(axis) * self.length).abs() / 2.0
            + (self.direction.left().dot(axis) * self.width).abs() / 2.0
    }
}

/// Directions on which boxes with these directions can be separate.
fn axes(a: P2, b: P2) -> [P2; 4] {
    [a, a.left(), b, b.left()]
}

/// A box of the given size at the origin, for tests of this crate.
#[cfg(test)]
pub(crate) fn box_at(x: f64, y: f64, heading: f64, length: f64, width: f64) -> OrientedBox {
    OrientedBox::new(P2 { x, y }, heading, length, width)
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
        // A square standing on its corner, half diagonal sqrt 2: corner at 4 - sqrt 2, side at 2.
        let tip = box_at(4.0, 0.0, FRAC_PI_4, 2.0, 2.0);
        assert!((a.distance(&tip) - (2.0 - 2.0_f64.sqrt())).abs() < 1e-12);
        assert_eq!(a.distance(&box_at(1.0, 1.0, 0.3, 4.0, 2.0)), 0.0);
        // A plus sign: they overlap although no corner is inside the other.
        assert_eq!(box_at(0.0, 0.0, 0.0, 10.0, 1.0).distance(&box_at(0.0, 0.0, FRAC_PI_2, 10.0, 1.0)), 0.0);
    }

    #[test]
    fn distances_are_those_of_all_corners_and_sides() {
        let all = |x: &OrientedBox, y: &OrientedBox| {
            let (a, b) = (x.corners(), y.corners());
            let each = (0..16).flat_map(|k| {
                let (i, j) = (k / 4, k % 4);
                let of_a = segment_distance2(a[i], b[j], b[(j + 1) % 4]);
                [of_a, segment_distance2(b[i], a[j], a[(j + 1) % 4])]
            });
            each.fold(f64::INFINITY, f64::min).sqrt()
        };
        let far = P2 { x: 682_312.7, y: 3_412_990.3 };
        let mut apart = 0;
        for k in 0..3000_u32 {
            let (turn, step) = (f64::from(k) * 0.37, f64::from(k % 83) * 0.21);
            let of = |center: P2| OrientedBox::new(center + far, turn, 0.4 + step, 0.5 * f64::from(k % 5));
            let a = OrientedBox::new(far, f64::from(k % 7) * FRAC_PI_4, 4.7, 1.9);
            let b = of(p2(f64::from(k % 29) - 14.0, f64::from(k % 31) * 2.0 - 30.0));
            if a.overlaps(&b) {
                assert_eq!(a.distance(&b), 0.0);
            } else {
                assert_eq!(a.distance(&b).to_bits(), all(&a, &b).to_bits());
                apart += 1;
            }
        }
        assert!(apart > 1500, "{apart}");
    }

    /// A person of 0.5 m whose heading is unknown, 3 m before a bumper at x = 2; of a car it would matter.
    #[test]
    fn a_nearly_round_box_needs_no_heading() {
        let person = box_at(5.25, 0.0, f64::NAN, 0.5, 0.5);
        assert!(person.is_known() && person.heading.is_nan());
        assert!((box_at(0.0, 0.0, 0.0, 4.0, 2.0).distance(&person) - 3.0).abs() < 1e-12);
        assert!(!box_at(5.0, 0.0, f64::NAN, 4.0, 2.0).is_known());
        assert!(!box_at(5.0, 0.0, f64::NAN, 1.89, 0.5).is_known());
        assert!(!box_at(5.0, 0.0, f64::NAN, f64::NAN, f64::NAN).is_known());
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
        // From the right at a right angle, a pedestrian of 2 x 1 m: its top edge at y = -9 reaches y = -1 after 8 s at
        // 1 m/s, and is within the ego's length then.
        let walker = box_at(0.0, -10.0, FRAC_PI_2, 2.0, 1.0);
        assert!((ego.time_to_contact(still, &walker, p2(0.0, 1.0)) - 8.0).abs() < 1e-12);
        // The ego drives away first: its rear at x = -2 passes the pedestrian's right edge x = 0.5 after 1.25 s.
        assert_eq!(ego.time_to_contact(p2(2.0, 0.0), &walker, p2(0.0, 1.0)), f64::INFINITY);
        assert_eq!(ego.time_to_contact(still, &box_at(1.0, 0.0, 0.0, 4.0, 2.0), p2(9.0, 0.0)), 0.0);
    }
}
