//! Angles in radians. A heading is a point on a circle: differences are wrapped, rates need unwrapping.

use std::f64::consts::PI;

/// The same direction in (-pi, pi]; exactly opposite is +pi, from either side.
pub fn wrap(angle: f64) -> f64 {
    const TURN: f64 = 2.0 * PI;
    // Nearly all angles are within one turn: there the remainder is the angle itself, and division is slow.
    let a = if (0.0..TURN).contains(&angle) {
        angle
    } else if angle < 0.0 && angle > -TURN {
        angle + TURN
    } else {
        angle.rem_euclid(TURN)
    };
    if a > PI { a - 2.0 * PI } else { a }
}

/// Headings without jumps: each value differs from the last known one by less than half a turn. NaN stays NaN.
pub fn unwrap(headings: &[f64]) -> Vec<f64> {
    let mut last: Option<f64> = None;
    headings
        .iter()
        .map(|&h| {
            if h.is_nan() {
                return h;
            }
            let value = last.map_or(h, |l| l + wrap(h - l));
            last = Some(value);
            value
        })
        .collect()
}

/// Angle between two undirected lines with these directions, 0 to pi/2.
pub fn angle_between_lines(a: f64, b: f64) -> f64 {
    let d = wrap(a - b).abs();
    d.min(PI - d)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrapping_at_pi() {
        // By hand: 179 deg to -179 deg is a turn of 2 deg to the left, not of 358 to the right.
        let d = wrap((-179.0_f64).to_radians() - 179.0_f64.to_radians());
        assert!((d - 2.0_f64.to_radians()).abs() < 1e-12);
        assert_eq!(wrap(PI), PI);
        assert_eq!(wrap(-PI), PI);
        assert_eq!(wrap(3.0 * PI), PI);
        assert!((angle_between_lines(0.0, PI) - 0.0).abs() < 1e-12, "oncoming is parallel");
        assert!((angle_between_lines(0.1, 0.1 - PI / 2.0) - PI / 2.0).abs() < 1e-12);
    }

    #[test]
    fn the_short_way_gives_the_same_bits() {
        let slow = |angle: f64| {
            let a = angle.rem_euclid(2.0 * PI);
            if a > PI { a - 2.0 * PI } else { a }
        };
        let mut angles: Vec<f64> = (-20_000..20_000).map(|i| f64::from(i) * 0.000_731).collect();
        for edge in [0.0, PI, 2.0 * PI, 1e-300, 1e9, f64::INFINITY, f64::NAN] {
            angles.extend([
                edge,
                -edge,
                edge.next_up(),
                edge.next_down(),
                -edge.next_up(),
                -edge.next_down(),
            ]);
        }
        for a in angles {
            assert!(wrap(a).to_bits() == slow(a).to_bits() || (wrap(a).is_nan() && slow(a).is_nan()), "{a}");
        }
    }

    #[test]
    fn unwrapping_a_constant_turn() {
        let h: Vec<f64> = (0..100).map(|i| wrap(0.1 * f64::from(i))).collect();
        let u = unwrap(&h);
        assert!(u.iter().enumerate().all(|(i, v)| (v - 0.1 * i as f64).abs() < 1e-9));
        assert!(unwrap(&[3.0, f64::NAN, -3.0])[2] > 3.0, "unknown rows do not break the chain");
    }
}
