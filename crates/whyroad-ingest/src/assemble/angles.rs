//! Angles in radians: differences are wrapped, interpolation needs them unwrapped.

use std::f64::consts::{PI, TAU};

/// `angle` in (-pi, pi].
pub fn wrap_angle(angle: f64) -> f64 {
    let a = (angle + PI).rem_euclid(TAU) - PI;
    if a == -PI { PI } else { a }
}

/// The same angles without jumps of a full turn.
pub(crate) fn unwrapped(angles: &[f64]) -> Vec<f64> {
    let mut out = Vec::with_capacity(angles.len());
    let mut last: Option<(f64, f64)> = None;
    for &a in angles {
        let next = last.map_or(a, |(raw, steady)| steady + wrap_angle(a - raw));
        last = Some((a, next));
        out.push(next);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrapping_keeps_pi_and_never_gives_minus_pi() {
        assert_eq!(wrap_angle(PI), PI);
        assert_eq!(wrap_angle(-PI), PI);
        let turned = wrap_angle(179f64.to_radians() - -179f64.to_radians());
        assert!((turned - -2f64.to_radians()).abs() < 1e-12);
    }
}
