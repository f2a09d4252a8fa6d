//! Rigid motions in three dimensions, as much as poses need: quaternion (scalar first, as AV2 writes it) and
//! translation.

/// Rotation then translation: maps points of the moving frame into the fixed one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Se3 {
    /// Unit quaternion w, x, y, z.
    pub q: [f64; 4],
    /// m.
    pub t: [f64; 3],
}

/// A quaternion further from unit length than this is not a rotation with rounding errors.
const MAX_NORM_ERROR: f64 = 0.01;

/// The unit quaternion meant by `q`, or `None` when it is not a rotation (NaN, zero, far from unit length).
pub(crate) fn unit(q: [f64; 4]) -> Option<[f64; 4]> {
    let norm = q.iter().map(|v| v * v).sum::<f64>().sqrt();
    // Written so that NaN fails.
    ((norm - 1.0).abs() <= MAX_NORM_ERROR).then(|| q.map(|v| v / norm))
}

impl Se3 {
    /// The point in the fixed frame.
    pub fn apply(&self, p: [f64; 3]) -> [f64; 3] {
        let r = rotate(self.q, p);
        [r[0] + self.t[0], r[1] + self.t[1], r[2] + self.t[2]]
    }

    /// Between `self` (share 0) and `other` (share 1): translation linear, rotation on the shorter great circle
    /// (slerp).
    pub fn between(&self, other: &Se3, share: f64) -> Se3 {
        let t = std::array::from_fn(|i| self.t[i] + (other.t[i] - self.t[i]) * share);
        Se3 { q: slerp(self.q, other.q, share), t }
    }
}

/// `v` turned by `q`: v + 2 w (u x v) + 2 u x (u x v).
pub(crate) fn rotate(q: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let (w, u) = (q[0], [q[1], q[2], q[3]]);
    let uv = cross(u, v);
    let uuv = cross(u, uv);
    std::array::from_fn(|i| v[i] + 2.0 * (w * uv[i] + uuv[i]))
}

/// Direction of the frame's x axis in the ground plane, rad counter-clockwise from x.
pub(crate) fn heading(q: [f64; 4]) -> f64 {
    let x = rotate(q, [1.0, 0.0, 0.0]);
    crate::assemble::angles::wrap_angle(x[1].atan2(x[0]))
}

/// `a` after `b`: the rotation that turns by `b` first.
pub(crate) fn compose(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Between two rotations (share 0: `a`, 1: `b`) on the shorter great circle.
pub(crate) fn slerp(a: [f64; 4], b: [f64; 4], share: f64) -> [f64; 4] {
    let dot: f64 = a.iter().zip(&b).map(|(x, y)| x * y).sum();
    // q and -q are the same rotation; the nearer one gives the shorter way.
    let (b, dot) = if dot < 0.0 { (b.map(|v| -v), -dot) } else { (b, dot) };
    let angle = dot.min(1.0).acos();
    let (ka, kb) = if angle < 1e-6 {
        (1.0 - share, share)
    } else {
        (((1.0 - share) * angle).sin() / angle.sin(), (share * angle).sin() / angle.sin())
    };
    let q: [f64; 4] = std::array::from_fn(|i| ka * a[i] + kb * b[i]);
    unit(q).unwrap_or(a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_4;

    fn yaw(a: f64) -> [f64; 4] {
        [(a / 2.0).cos(), 0.0, 0.0, (a / 2.0).sin()]
    }

    #[test]
    fn a_quarter_turn_left_takes_forward_to_left() {
        let p = Se3 { q: yaw(2.0 * FRAC_PI_4), t: [10.0, 20.0, 1.0] }.apply([3.0, 0.0, 0.5]);
        for (got, want) in p.iter().zip([10.0, 23.0, 1.5]) {
            assert!((got - want).abs() < 1e-12, "{p:?}");
        }
    }

    #[test]
    fn half_way_between_two_headings_across_pi() {
        // From 170 to -170 degrees the half way is 180, not 0; with either sign of the second quaternion.
        let (a, b) = (yaw(170f64.to_radians()), yaw(-170f64.to_radians()));
        for b in [b, b.map(|v| -v)] {
            assert!((heading(slerp(a, b, 0.5)).abs() - std::f64::consts::PI).abs() < 1e-12);
        }
    }

    #[test]
    fn composed_rotations_turn_one_after_the_other() {
        assert!((heading(compose(yaw(0.5), yaw(0.25))) - 0.75).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_rotation_is_refused() {
        assert!(
            unit([0.0; 4]).is_none()
                && unit([f64::NAN, 0.0, 0.0, 1.0]).is_none()
                && unit([2.0, 0.0, 0.0, 0.0]).is_none()
        );
        assert!(unit([0.999, 0.0, 0.0, 0.0]).is_some());
    }
}
