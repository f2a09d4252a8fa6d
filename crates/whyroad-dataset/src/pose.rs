//! The pose of the ego's reference point, and transforms into its frame.

/// The ego's reference point at t0 in the world.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pose {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub heading: f64,
}

impl Pose {
    /// A world point in the frame of this pose.
    pub fn local(&self, x: f64, y: f64) -> (f64, f64) {
        let (s, c) = self.heading.sin_cos();
        let (dx, dy) = (x - self.x, y - self.y);
        (dx * c + dy * s, -dx * s + dy * c)
    }

    /// A world vector in the axes of this pose.
    pub fn turned(&self, vx: f64, vy: f64) -> (f64, f64) {
        let (s, c) = self.heading.sin_cos();
        (vx * c + vy * s, -vx * s + vy * c)
    }

    /// A world heading relative to this pose, in (-pi, pi].
    pub fn relative(&self, heading: f64) -> f64 {
        wrap(heading - self.heading)
    }
}

pub(crate) fn wrap(a: f64) -> f64 {
    let t = std::f64::consts::TAU;
    let w = a.rem_euclid(t);
    if w > std::f64::consts::PI { w - t } else { w }
}

/// A known number, narrowed; `None` for NaN.
pub(crate) fn known(v: f64) -> Option<f32> {
    v.is_finite().then_some(v as f32)
}
