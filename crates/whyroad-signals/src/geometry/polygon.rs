//! Simple polygons in either winding: containment and distance.

use super::P2;
use super::polyline::segment_distance2;

/// A simple polygon, closed by its first corner, with its bounding box.
#[derive(Clone, Debug)]
pub struct Polygon {
    corners: Vec<P2>,
    low: P2,
    high: P2,
}

impl Polygon {
    /// The polygon with these corners (a repeated first corner at the end is accepted); `None` under three corners.
    pub fn new(corners: impl IntoIterator<Item = P2>) -> Option<Self> {
        let mut corners: Vec<P2> = corners.into_iter().filter(|p| p.is_finite()).collect();
        if corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        if corners.len() < 3 {
            return None;
        }
        let fold = |f: fn(f64, f64) -> f64, start: f64| {
            corners.iter().fold(P2 { x: start, y: start }, |acc, p| P2 { x: f(acc.x, p.x), y: f(acc.y, p.y) })
        };
        let (low, high) = (fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY));
        Some(Self { corners, low, high })
    }

    /// Lower left and upper right corner of the bounding box.
    pub fn bounds(&self) -> (P2, P2) {
        (self.low, self.high)
    }

    /// The corners.
    pub fn corners(&self) -> &[P2] {
        &self.corners
    }

    /// True when `p` is inside (even-odd rule; points exactly on the edge may fall on either side).
    pub fn contains(&self, p: P2) -> bool {
        if p.x < self.low.x || p.x > self.high.x || p.y < self.low.y || p.y > self.high.y {
            return false;
        }
        let mut inside = false;
        let mut b = self.corners[self.corners.len() - 1];
        for &a in &self.corners {
            if (a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x {
                inside = !inside;
            }
            b = a;
        }
        inside
    }

    /// A lower bound for the distance of `p`, m: that of its bounding box, minus possible rounding errors.
    pub fn least_distance(&self, p: P2) -> f64 {
        let more = |a: f64, b: f64| if a > b { a } else { b };
        let x = more(self.low.x - p.x, p.x - self.high.x);
        let y = more(self.low.y - p.y, p.y - self.high.y);
        more(more(x, y) * (1.0 - 1e-9) - 1e-6, 0.0)
    }

    /// Distance of `p`, 0 inside, m.
    pub fn distance(&self, p: P2) -> f64 {
        if self.contains(p) {
            return 0.0;
        }
        let n = self.corners.len();
        let d2 = (0..n)
            .map(|i| segment_distance2(p, self.corners[i], self.corners[(i + 1) % n]))
            .fold(f64::INFINITY, f64::min);
        d2.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::p2;

    #[test]
    fn inside_and_distance_of_a_square() {
        let ring = [p2(0.0, 0.0), p2(4.0, 0.0), p2(4.0, 4.0), p2(0.0, 4.0), p2(0.0, 0.0)];
        let mut backwards = ring;
        backwards.reverse();
        for corners in [ring, backwards] {
            let square = Polygon::new(corners).unwrap();
            assert!(square.contains(p2(1.0, 3.0)) && !square.contains(p2(5.0, 3.0)));
            assert_eq!(square.distance(p2(2.0, 2.0)), 0.0);
            assert_eq!(square.distance(p2(7.0, 8.0)), 5.0);
        }
        assert!(Polygon::new([p2(0.0, 0.0), p2(1.0, 0.0)]).is_none());
    }
}
