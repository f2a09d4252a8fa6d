//! Angles in radians: differences are wrapped, interpolation needs them unwrapped.

use std::f64::consts::{PI, TAU};

/// `angle` in (-pi, pi].
pub fn wrap_angle(angle: f64) -> f64 {
    let a = (angle + PI).rem_euclid(TAU) - PI;
    if a == -PI { PI } else { a }
}

/// The same angles without jumps of a full turn. What is not known stays unknown; the next known angle goes on from the
/// one before.
pub(crate) fn unwrapped(angles: &[f64]) -> Vec<f64> {
    let mut out = Vec::with_capacity(angles.len());
    let mut last: Option<(f64, f64)> = None;
    for &a in angles {
        let next = last.map_or(a, |(raw, steady)| steady + wrap_angle(a - raw));
        if a.is_finite() {
            last = Some((a, next));
        }
        out.push(next);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_angle_costs_itself_only() {
        let out = unwrapped(&[3.0, f64::NAN, -3.0, -2.9]);
        // From 3.0 to -3.0 over pi is 2 pi - 6.
        assert!(out[1].is_nan());
        for (got, want) in [(out[0], 3.0), (out[2], TAU - 3.0), (out[3], TAU - 2.9)] {
            assert!((got - want).abs() < 1e-12, "{out:?}");
        }
    }

    #[test]
    fn wrapping_keeps_pi_and_never_gives_minus_pi() {
        assert_eq!(wrap_angle(PI), PI);
        assert_eq!(wrap_angle(-PI), PI);
        let turned = wrap_angle(179f64.to_radians() - -179f64.to_radians());
        assert!((turned - -2f64.to_radians()).abs() < 1e-12);
    }
}
