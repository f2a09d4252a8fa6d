//! Simple polygons in either winding: containment and distance.

use super::P2;
use super::polyline::segment_distance2;
use std::ops::RangeInclusive;

/// A simple polygon, closed by its first corner, with its bounding box.
#[derive(Clone, Debug)]
pub struct Polygon {
    corners: Vec<P2>,
    low: P2,
    high: P2,
    /// `None` where it has few corners.
    bands: Option<Bands>,
}

/// Up to this number of corners all sides are asked whether they are beside a position.
const FEW_CORNERS: usize = 8;
/// Maximum number of bands.
const MOST_BANDS: usize = 128;
/// Maximum number of sides in all bands, per side.
const MOST_SIDES: usize = 8;

/// The sides by bands of y: only those in the band of a position can be beside it.
#[derive(Clone, Debug)]
struct Bands {
    low: f64,
    per_m: f64,
    /// Index of the first side of each band; one more at the end.
    starts: Vec<u32>,
    /// Begin and end of each.
    sides: Vec<[P2; 2]>,
}

impl Bands {
    /// `None` if most sides are in many bands.
    fn new(corners: &[P2], low: f64, high: f64) -> Option<Self> {
        let count = (corners.len() / 2).clamp(1, MOST_BANDS);
        let (per_m, starts) = (count as f64 / (high - low), vec![0; count + 1]);
        let mut out = Self { low, per_m, starts, sides: Vec::new() };
        let sides =
            || std::iter::once(corners[corners.len() - 1]).chain(corners.iter().copied()).zip(corners);
        for (from, to) in sides() {
            for band in out.touched(from.y, to.y) {
                out.starts[band + 1] += 1;
            }
        }
        for band in 0..count {
            out.starts[band + 1] += out.starts[band];
        }
        let all = out.starts[count] as usize;
        if all > MOST_SIDES * corners.len() {
            return None;
        }
        out.sides = vec![[P2::default(); 2]; all];
        let mut next = out.starts.clone();
        for (from, to) in sides() {
            for band in out.touched(from.y, to.y) {
                out.sides[next[band] as usize] = [from, *to];
                next[band] += 1;
            }
        }
        Some(out)
    }

    /// The band of `y`, the nearest one if it is outside. Despite rounding it never decreases when `y` grows.
    fn of(&self, y: f64) -> usize {
        (((y - self.low) * self.per_m) as usize).min(self.starts.len() - 2)
    }

    fn touched(&self, a: f64, b: f64) -> RangeInclusive<usize> {
        self.of(a.min(b))..=self.of(a.max(b))
    }

    /// The sides in the band of `y`.
    fn sides_at(&self, y: f64) -> &[[P2; 2]] {
        let band = self.of(y);
        &self.sides[self.starts[band] as usize..self.starts[band + 1] as usize]
    }
}

/// True when the line from `p` towards greater x crosses the side.
fn is_crossed(p: P2, [from, to]: [P2; 2]) -> bool {
    (to.y > p.y) != (from.y > p.y) && p.x < (from.x - to.x) * (p.y - to.y) / (from.y - to.y) + to.x
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
        let bands = if corners.len() > FEW_CORNERS { Bands::new(&corners, low.y, high.y) } else { None };
        Some(Self { corners, low, high, bands })
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
        if let Some(bands) = &self.bands {
            return bands.sides_at(p.y).iter().fold(false, |inside, side| inside ^ is_crossed(p, *side));
        }
        let (mut inside, mut from) = (false, self.corners[self.corners.len() - 1]);
        for &to in &self.corners {
            inside ^= is_crossed(p, [from, to]);
            from = to;
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
        let mut d2 = f64::INFINITY;
        let mut from = self.corners[self.corners.len() - 1];
        for &to in &self.corners {
            d2 = d2.min(segment_distance2(p, from, to));
            from = to;
        }
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

    #[test]
    fn inside_by_bands_is_inside_by_all_sides() {
        // Stars, some with many corners at one height, and combs whose teeth go over the whole height.
        let star = |k: i32| {
            let n = 9 + k * 7;
            let corner = move |i: i32| {
                let reach = if i % 2 == 0 { 20.0 } else { 20.0 / f64::from(1 + k % 4) };
                P2::from_heading(f64::from(i) * 2.0 * std::f64::consts::PI / f64::from(n)) * reach
            };
            (0..n).map(corner).map(|p| if k % 3 == 0 { p2(p.x, p.y.round()) } else { p }).collect::<Vec<P2>>()
        };
        let comb =
            |n: i32| (0..n).map(|i| p2(f64::from(i), f64::from(i % 2 * 9))).chain([p2(5.0, -30.0)]).collect();
        let (mut inside, mut asked) = (0, 0);
        for corners in (0..12).map(star).chain([comb(12), comb(400)]) {
            let polygon = Polygon::new(corners.clone()).unwrap();
            let by_all = Polygon { bands: None, ..polygon.clone() };
            let grid =
                (0..61).flat_map(|i| (0..61).map(move |j| p2(f64::from(i) - 30.0, f64::from(j) - 30.0)));
            let beside = corners.iter().flat_map(|c| [*c, *c + p2(0.3, 0.0), *c + p2(-0.3, 1e-9)]);
            for p in grid.chain(beside).chain([p2(f64::NAN, 0.0), p2(0.0, f64::NAN)]) {
                assert_eq!(polygon.contains(p), by_all.contains(p), "{p:?} of {}", corners.len());
                (inside, asked) = (inside + usize::from(by_all.contains(p)), asked + 1);
            }
        }
        assert!(inside > asked / 20 && inside < asked / 2, "{inside} of {asked}");
    }
}
