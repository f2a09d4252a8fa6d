//! The reference line of a road in the ground plane: lines, arcs, spirals, cubic and parametric cubic curves (ASAM
//! OpenDRIVE 1.8, section 9). Points are integrated one after the other, so that a road costs its length.

use super::cubic::{polynomial, slope};
use whyroad_model::road_map::Point3;

/// Curves tighter than this are not roads, 1/m.
const MAX_CURVATURE: f64 = 10.0;
/// Longer stretches are not roads, m.
const MAX_LENGTH_M: f64 = 1e5;
/// Longest panel of the integration, m, and its greatest change of heading, rad.
const PANEL_M: f64 = 1.0;
const PANEL_RAD: f64 = 0.5;
/// Nodes and weights of Gauss-Legendre on [0, 1], five points.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_5),
    (0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
    (0.5, 0.284_444_444_444_444_4),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
    (0.953_089_922_969_332, 0.118_463_442_528_094_5),
];

/// Shape of a stretch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    Line,
    /// 1/m, left positive.
    Arc(f64),
    /// Curvature at its start and end, 1/m.
    Spiral(f64, f64),
    /// v over u.
    Cubic([f64; 4]),
    /// u and v over a parameter that runs from 0 to `end`.
    Parametric {
        u: [f64; 4],
        v: [f64; 4],
        end: f64,
    },
}

/// A stretch of the reference line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Geometry {
    /// Station at which it begins, m.
    pub start: f64,
    pub x: f64,
    pub y: f64,
    /// rad
    pub heading: f64,
    /// m
    pub length: f64,
    pub shape: Shape,
}

/// A point of the reference line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Pose {
    pub x: f64,
    pub y: f64,
    /// rad
    pub heading: f64,
}

impl Pose {
    /// The point `t` m to the left, at height `z`.
    pub fn beside(&self, t: f64, z: f64) -> Point3 {
        let (sin, cos) = self.heading.sin_cos();
        Point3 { x: self.x - t * sin, y: self.y + t * cos, z }
    }

    fn ahead(&self, d: f64) -> Self {
        Self { x: self.x + d * self.heading.cos(), y: self.y + d * self.heading.sin(), ..*self }
    }
}

impl Geometry {
    /// True for what can be a road.
    pub fn is_sound(&self) -> bool {
        let finite = |c: [f64; 4]| c.iter().all(|v| v.abs() < 1e9);
        let place = [self.start, self.x, self.y, self.heading].iter().all(|v| v.abs() < 1e9);
        let shape = match self.shape {
            Shape::Line => true,
            Shape::Arc(k) => k.abs() <= MAX_CURVATURE,
            Shape::Spiral(a, b) => a.abs().max(b.abs()) <= MAX_CURVATURE,
            Shape::Cubic(c) => finite(c),
            Shape::Parametric { u, v, end } => finite(u) && finite(v) && end > 0.0 && end < 1e9,
        };
        place && shape && (0.0..=MAX_LENGTH_M).contains(&self.length)
    }

    /// In the axes of its start: heading `d` m along a curve of changing curvature.
    fn turned(&self, d: f64) -> f64 {
        match self.shape {
            Shape::Arc(k) => k * d,
            Shape::Spiral(a, b) if self.length > 0.0 => a * d + (b - a) * d * d / (2.0 * self.length),
            _ => 0.0,
        }
    }

    /// Poses at ascending distances from its start.
    fn along(&self, distances: &[f64], out: &mut Vec<Pose>) {
        let (mut done, mut at) = (0.0, (0.0, 0.0));
        for &d in distances {
            let local = match self.shape {
                Shape::Line => (d, 0.0, 0.0),
                Shape::Arc(_) | Shape::Spiral(..) => {
                    at = self.integrate(at, done, d);
                    (at.0, at.1, self.turned(d))
                }
                Shape::Cubic(c) => {
                    at.0 = abscissa(c, at.0, d - done);
                    (at.0, polynomial(c, at.0), slope(c, at.0).atan())
                }
                Shape::Parametric { u, v, end } => {
                    let p = if self.length > 0.0 { d / self.length * end } else { 0.0 };
                    (polynomial(u, p), polynomial(v, p), direction(u, v, p, end))
                }
            };
            done = d;
            let (sin, cos) = self.heading.sin_cos();
            out.push(Pose {
                x: self.x + local.0 * cos - local.1 * sin,
                y: self.y + local.0 * sin + local.1 * cos,
                heading: self.heading + local.2,
            });
        }
    }

    /// From the point at `from` to the one at `to`, in the axes of the start.
    fn integrate(&self, at: (f64, f64), from: f64, to: f64) -> (f64, f64) {
        let span = to - from;
        let curvature = match self.shape {
            Shape::Spiral(a, b) => a.abs().max(b.abs()),
            Shape::Arc(k) => k.abs(),
            _ => 0.0,
        };
        let panels = (span / PANEL_M).max(curvature * span / PANEL_RAD).ceil().max(1.0);
        let step = span / panels;
        let (mut x, mut y) = at;
        for panel in 0..panels as usize {
            for (node, weight) in GAUSS {
                let angle = self.turned(from + (panel as f64 + node) * step);
                x += weight * step * angle.cos();
                y += weight * step * angle.sin();
            }
        }
        (x, y)
    }
}

/// Direction of a parametric curve; where its speed is zero, that of the neighboring point.
fn direction(u: [f64; 4], v: [f64; 4], p: f64, end: f64) -> f64 {
    let (du, dv) = (slope(u, p), slope(v, p));
    if du.hypot(dv) > 1e-9 {
        return dv.atan2(du);
    }
    let beside = if p < end / 2.0 { p + 1e-4 * end } else { p - 1e-4 * end };
    slope(v, beside).atan2(slope(u, beside))
}

/// u after `span` m more along v(u): the arc length integrated with the classic Runge-Kutta method.
fn abscissa(c: [f64; 4], mut u: f64, span: f64) -> f64 {
    let steps = (span / PANEL_M).ceil().max(1.0);
    let h = span / steps;
    let rate = |u: f64| 1.0 / slope(c, u).hypot(1.0);
    for _ in 0..steps as usize {
        let k1 = rate(u);
        let k2 = rate(u + h / 2.0 * k1);
        let k3 = rate(u + h / 2.0 * k2);
        let k4 = rate(u + h * k3);
        u += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    u
}

/// Poses at ascending stations of a reference line whose stretches are in order; beyond its ends it runs straight on.
pub(super) fn poses(line: &[Geometry], stations: &[f64]) -> Vec<Pose> {
    let mut out = Vec::with_capacity(stations.len());
    let mut next = 0;
    for (i, geometry) in line.iter().enumerate() {
        let end = line.get(i + 1).map_or(f64::INFINITY, |g| g.start);
        let from = next;
        while stations.get(next).is_some_and(|s| *s < end) {
            next += 1;
        }
        let inside: Vec<f64> =
            stations[from..next].iter().map(|s| (s - geometry.start).clamp(0.0, geometry.length)).collect();
        let first = out.len();
        geometry.along(&inside, &mut out);
        for (pose, station) in out[first..].iter_mut().zip(&stations[from..next]) {
            let d = station - geometry.start;
            *pose = pose.ahead(if i + 1 == line.len() { (d - geometry.length).max(0.0) } else { 0.0 });
            *pose = pose.ahead(if i == 0 { d.min(0.0) } else { 0.0 });
        }
    }
    out
}

#[cfg(test)]
mod tests;
