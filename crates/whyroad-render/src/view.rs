//! The frame of a bird's-eye image: ego at the origin, its heading up, and only what lies inside the window.
//! Image coordinates are meters, x to the right and y down.

use crate::markup::Markup;
use whyroad_model::road_map::Point3;

/// A point of the image, m.
pub type Spot = (f64, f64);

/// Pose and extent of the image.
#[derive(Clone, Copy, Debug)]
pub struct View {
    origin: (f64, f64),
    heading: f64,
    /// Meters shown in front of the origin.
    pub ahead_m: f64,
    /// Meters shown behind it.
    pub behind_m: f64,
    /// Meters shown on either side.
    pub side_m: f64,
}

impl View {
    /// A window 60 m long around a pose, longer where something at `must_see` (world, m) would be cut off,
    /// up to 110 m.
    pub fn around(x: f64, y: f64, heading: f64, must_see: Option<(f64, f64)>) -> Self {
        let mut view = Self { origin: (x, y), heading, ahead_m: 38.0, behind_m: 22.0, side_m: 30.0 };
        if let Some((tx, ty)) = must_see {
            let (right, down) = view.spot(tx, ty);
            let margin = 8.0;
            view.ahead_m = view.ahead_m.max((-down + margin).min(72.0));
            view.behind_m = view.behind_m.max((down + margin).min(72.0));
            let reach = view.side_m.max((right.abs() + margin).min(55.0));
            view.side_m = reach.max((view.ahead_m + view.behind_m) / 2.0);
        }
        view
    }

    /// A world point in the image.
    pub fn spot(&self, x: f64, y: f64) -> Spot {
        let (s, c) = self.heading.sin_cos();
        let (dx, dy) = (x - self.origin.0, y - self.origin.1);
        (dx * s - dy * c, -(dx * c + dy * s))
    }

    /// `left, top, width, height` in meters.
    pub fn bounds(&self) -> (f64, f64, f64, f64) {
        (-self.side_m, -self.ahead_m, 2.0 * self.side_m, self.ahead_m + self.behind_m)
    }

    fn spots(&self, points: &[Point3]) -> Vec<Spot> {
        points.iter().map(|p| self.spot(p.x, p.y)).collect()
    }

    /// The part of an area inside the window; empty when there is none.
    pub fn area(&self, points: &[Point3]) -> Vec<Spot> {
        let (left, top, w, h) = self.bounds();
        let mut polygon = self.spots(points);
        // Sutherland-Hodgman against the four sides: inside is where the side's function is not negative.
        let sides: [&dyn Fn(Spot) -> f64; 4] =
            [&|p| p.0 - left, &|p| left + w - p.0, &|p| p.1 - top, &|p| top + h - p.1];
        for side in sides {
            let mut kept = Vec::with_capacity(polygon.len() + 4);
            for (i, &b) in polygon.iter().enumerate() {
                let a = polygon[(i + polygon.len() - 1) % polygon.len()];
                let (da, db) = (side(a), side(b));
                if (da < 0.0) != (db < 0.0) {
                    let t = da / (da - db);
                    kept.push((a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1)));
                }
                if db >= 0.0 {
                    kept.push(b);
                }
            }
            polygon = kept;
        }
        if polygon.len() < 3 { Vec::new() } else { polygon }
    }

    /// The parts of a line inside the window, thinned to 5 cm.
    pub fn lines(&self, points: &[Point3]) -> Vec<Vec<Spot>> {
        self.cut(&self.spots(points))
    }

    /// The parts of a line in the image that are inside the window, thinned to 5 cm.
    pub fn cut(&self, spots: &[Spot]) -> Vec<Vec<Spot>> {
        let mut out: Vec<Vec<Spot>> = Vec::new();
        let mut open = false;
        for pair in spots.windows(2) {
            match self.segment(pair[0], pair[1]) {
                Some((a, b)) => {
                    let joins = open && out.last().and_then(|l| l.last()) == Some(&a);
                    match out.last_mut() {
                        Some(line) if joins => line.push(b),
                        _ => out.push(vec![a, b]),
                    }
                    open = b == pair[1];
                }
                None => open = false,
            }
        }
        out.iter().map(|line| thin(line, 0.05)).collect()
    }

    /// Liang-Barsky: the part of a segment inside the window.
    fn segment(&self, a: Spot, b: Spot) -> Option<(Spot, Spot)> {
        let (left, top, w, h) = self.bounds();
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let (mut t0, mut t1) = (0.0_f64, 1.0_f64);
        for (p, q) in [(-dx, a.0 - left), (dx, left + w - a.0), (-dy, a.1 - top), (dy, top + h - a.1)] {
            if p == 0.0 {
                if q < 0.0 {
                    return None;
                }
            } else if p < 0.0 {
                t0 = t0.max(q / p);
            } else {
                t1 = t1.min(q / p);
            }
        }
        let at = |t: f64| (a.0 + t * dx, a.1 + t * dy);
        // The ends are kept as they are, so that a whole segment joins its neighbors exactly.
        let from = if t0 == 0.0 { a } else { at(t0) };
        let to = if t1 == 1.0 { b } else { at(t1) };
        (t0 <= t1).then_some((from, to))
    }
}

/// Ramer-Douglas-Peucker: leaves out points that lie within `tolerance` of the line between their neighbors.
fn thin(line: &[Spot], tolerance: f64) -> Vec<Spot> {
    let (Some(&a), Some(&b)) = (line.first(), line.last()) else { return Vec::new() };
    let length = (b.0 - a.0).hypot(b.1 - a.1);
    let off = |p: Spot| {
        if length == 0.0 {
            (p.0 - a.0).hypot(p.1 - a.1)
        } else {
            ((b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0)).abs() / length
        }
    };
    let inner = 1..line.len().saturating_sub(1);
    let farthest = inner.map(|i| (i, off(line[i]))).max_by(|x, y| x.1.total_cmp(&y.1));
    match farthest {
        Some((i, d)) if d > tolerance => {
            let mut out = thin(&line[..=i], tolerance);
            out.pop();
            out.extend(thin(&line[i..], tolerance));
            out
        }
        _ => vec![a, b],
    }
}

/// Writes path data in decimeters.
pub fn path(m: &mut Markup, spots: &[Spot], end: &'static str) {
    for (i, (x, y)) in spots.iter().enumerate() {
        m.raw(if i == 0 { "M" } else { "L" }).num(x * 10.0, 0).raw(" ").num(y * 10.0, 0);
    }
    m.raw(end);
}

#[cfg(test)]
mod tests;
