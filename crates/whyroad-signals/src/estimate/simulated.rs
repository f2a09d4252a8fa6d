//! Ground truth for the tests of this folder: motion by integration in steps of a millisecond, and seeded noise.

use crate::geometry::wrap;
use whyroad_model::random::SplitMix64;

/// The real motion of a car, at 10 Hz.
#[derive(Default)]
pub struct Truth {
    pub times: Vec<f64>,
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    pub heading: Vec<f64>,
    pub speed: Vec<f64>,
    pub accel: Vec<f64>,
}

impl Truth {
    /// 12 m/s, a left bend from 5 s to 9 s, braking with 3 m/s2 from 12 s to standstill, moving off at 21 s with 2
    /// m/s2.
    pub fn car(seconds: f64) -> Self {
        let mut out = Self::default();
        let (mut x, mut y, mut heading, mut v) = (0.0, 0.0, 0.4, 12.0);
        let (lever, dt) = (1.3, 0.001);
        for k in 0..(seconds * 1000.0) as usize {
            let t = k as f64 * dt;
            let a = match t {
                t if t < 12.0 => 0.0,
                t if t < 21.0 && v > 0.0 => -3.0,
                t if t < 21.0 => 0.0,
                t if t < 26.0 => 2.0,
                _ => 0.0,
            };
            let w = if (5.0..9.0).contains(&t) { 0.15 * ((t - 5.0).min(9.0 - t)).min(1.0) } else { 0.0 };
            if k % 100 == 0 {
                out.times.push(t);
                // The pose is that of the box center, ahead of the rear axle.
                out.x.push(x + lever * f64::cos(heading));
                out.y.push(y + lever * f64::sin(heading));
                out.heading.push(wrap(heading));
                out.speed.push(f64::hypot(v, lever * w));
                out.accel.push(a);
            }
            x += v * f64::cos(heading) * dt;
            y += v * f64::sin(heading) * dt;
            heading += w * dt;
            v = f64::max(v + a * dt, 0.0);
        }
        out
    }
}

/// Independent noise.
pub fn white(seed: u64, n: usize, sd: f64) -> Vec<f64> {
    let mut random = SplitMix64::new(seed);
    (0..n).map(|_| sd * random.normal()).collect()
}

/// Noise at 10 Hz that is correlated over one second.
pub fn correlated(seed: u64, n: usize, sd: f64) -> Vec<f64> {
    let mut random = SplitMix64::new(seed);
    let kept = (-0.1f64).exp();
    let mut value = sd * random.normal();
    let mut out = Vec::with_capacity(n);
    for _ in 0..n {
        out.push(value);
        value = kept * value + sd * (1.0 - kept * kept).sqrt() * random.normal();
    }
    out
}
