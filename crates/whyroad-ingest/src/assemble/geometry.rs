//! Geometry that every map adapter needs: lines by arc length, center lines, lines beside lines, unions of areas.

use geo::algorithm::bool_ops::unary_union;
use geo::{Coord, LineString, Polygon};
use whyroad_model::road_map::Point3;

/// Spacing of the points of a center line that is made from edges, m.
pub const CENTER_SPACING_M: f64 = 1.0;

/// Distance in the ground plane, m.
pub fn distance(a: Point3, b: Point3) -> f64 {
    (b.x - a.x).hypot(b.y - a.y)
}

/// Length of a line in the ground plane, m.
pub fn length(line: &[Point3]) -> f64 {
    line.windows(2).map(|w| distance(w[0], w[1])).sum()
}

fn mix(a: Point3, b: Point3, share: f64) -> Point3 {
    let at = |a: f64, b: f64| a + (b - a) * share;
    Point3 { x: at(a.x, b.x), y: at(a.y, b.y), z: at(a.z, b.z) }
}

/// Least and greatest coordinates of a line in the ground plane, m; not numbers for a line without points.
pub struct Bounds {
    low: [f64; 2],
    high: [f64; 2],
}

impl Bounds {
    pub fn of(line: &[Point3]) -> Self {
        let fold = |with: fn(f64, f64) -> f64| {
            line.iter().fold([f64::NAN; 2], |[x, y], p| [with(x, p.x), with(y, p.y)])
        };
        Bounds { low: fold(f64::min), high: fold(f64::max) }
    }

    /// True if no point within one is nearer than `reach_m` to a point within the other, in x or in y.
    pub fn are_apart(&self, other: &Bounds, reach_m: f64) -> bool {
        (0..2).any(|k| self.low[k] > other.high[k] + reach_m || other.low[k] > self.high[k] + reach_m)
    }
}

/// `count` points at equal shares of the line's length, ends included. An empty line stays empty.
pub fn resample(line: &[Point3], count: usize) -> Vec<Point3> {
    let (Some(&first), Some(&last)) = (line.first(), line.last()) else { return Vec::new() };
    if count < 2 || line.len() < 2 {
        return vec![first; count];
    }
    let total = length(line);
    let mut out = Vec::with_capacity(count);
    let (mut segment, mut done) = (0, 0.0);
    for i in 0..count - 1 {
        let wanted = total * i as f64 / (count - 1) as f64;
        let mut here = distance(line[segment], line[segment + 1]);
        while done + here < wanted && segment + 2 < line.len() {
            done += here;
            segment += 1;
            here = distance(line[segment], line[segment + 1]);
        }
        let share = if here > 0.0 { ((wanted - done) / here).clamp(0.0, 1.0) } else { 0.0 };
        out.push(mix(line[segment], line[segment + 1], share));
    }
    out.push(last);
    out
}

/// The line half way between a lane's edges: both are resampled at equal shares of their own length.
pub fn center_line(left: &[Point3], right: &[Point3]) -> Vec<Point3> {
    let longer = length(left).max(length(right));
    let count = ((longer / CENTER_SPACING_M).ceil().min(1999.0) as usize + 1).max(2);
    resample(left, count).into_iter().zip(resample(right, count)).map(|(l, r)| mix(l, r, 0.5)).collect()
}

/// True when the two edges of a lane run against each other.
pub fn edges_oppose(left: &[Point3], right: &[Point3]) -> bool {
    match (left.first(), left.last(), right.first(), right.last()) {
        (Some(&l0), Some(&l1), Some(&r0), Some(&r1)) => {
            distance(l0, r1) + distance(l1, r0) < distance(l0, r0) + distance(l1, r1)
        }
        _ => false,
    }
}

/// The line `offset_m` to the left of `line` (negative: right), mitred at the corners. Mitres are cut off at
/// twice the offset, as a hairpin's would run away.
pub fn beside(line: &[Point3], offset_m: f64) -> Vec<Point3> {
    let n = line.len();
    let normal = |a: Point3, b: Point3| {
        let d = distance(a, b);
        (d > 1e-9).then(|| (-(b.y - a.y) / d, (b.x - a.x) / d))
    };
    (0..n)
        .map(|i| {
            let before = (0..i).rev().find_map(|k| normal(line[k], line[i]));
            let after = (i + 1..n).find_map(|k| normal(line[i], line[k]));
            let (nx, ny) = match (before, after) {
                (Some(a), Some(b)) => {
                    let (sx, sy) = (a.0 + b.0, a.1 + b.1);
                    let half = (sx * sx + sy * sy) / 2.0;
                    let scale = if half > 0.5 { 1.0 / half } else { 2.0 };
                    (sx * scale, sy * scale)
                }
                (Some(n), None) | (None, Some(n)) => n,
                (None, None) => (0.0, 0.0),
            };
            Point3 { x: line[i].x + nx * offset_m, y: line[i].y + ny * offset_m, z: line[i].z }
        })
        .collect()
}

/// The polygon between a lane's edges: left forward, right back, closed.
pub fn between(left: &[Point3], right: &[Point3]) -> Vec<Point3> {
    let mut ring: Vec<Point3> = left.iter().chain(right.iter().rev()).copied().collect();
    ring.extend(left.first());
    ring
}

/// Union of polygons, holes filled: one closed outline for each connected part. Heights are those of the nearest corner
/// given.
pub fn union_outlines(polygons: &[Vec<Point3>]) -> Vec<Vec<Point3>> {
    let shapes: Vec<Polygon> = polygons
        .iter()
        .map(|p| Polygon::new(p.iter().map(|q| Coord { x: q.x, y: q.y }).collect::<LineString>(), vec![]))
        .collect();
    let corners = Corners::of(polygons);
    let height_at = |c: &Coord| corners.nearest_height(c.x, c.y).unwrap_or(0.0);
    let mut outlines: Vec<Vec<Point3>> = unary_union(&shapes)
        .into_iter()
        .map(|p| p.exterior().coords().map(|c| Point3 { x: c.x, y: c.y, z: height_at(c) }).collect())
        .collect();
    // The union's own order is not promised.
    outlines.sort_by(|a: &Vec<Point3>, b: &Vec<Point3>| {
        let key = |v: &[Point3]| {
            v.iter().map(|p| (p.x, p.y)).fold((f64::MAX, f64::MAX), |m, p| if p < m { p } else { m })
        };
        key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal)
    });
    outlines
}

/// Corners by ascending x, so that the search to either side can stop at the distance of the nearest one so far.
struct Corners {
    /// Index in the given order, which decides between corners equally near, and the corner.
    by_x: Vec<(usize, Point3)>,
}

impl Corners {
    fn of(polygons: &[Vec<Point3>]) -> Self {
        let mut by_x: Vec<(usize, Point3)> = polygons.iter().flatten().copied().enumerate().collect();
        by_x.sort_by(|a, b| a.1.x.total_cmp(&b.1.x));
        Self { by_x }
    }

    /// Height of the corner nearest to `(x, y)` in the ground plane, m; `None` without corners.
    fn nearest_height(&self, x: f64, y: f64) -> Option<f64> {
        let here = Point3 { x, y, z: 0.0 };
        let middle = self.by_x.partition_point(|(_, p)| p.x < x);
        let (before, after) = self.by_x.split_at(middle);
        let mut best: Option<(f64, usize, f64)> = None;
        let mut look = |&(place, p): &(usize, Point3)| {
            // Corners further off along x alone, and all that follow them, cannot be nearer.
            if best.is_some_and(|(reach, ..)| (p.x - x).abs() > reach) {
                return false;
            }
            let reach = distance(p, here);
            if best.is_none_or(|(r, at, _)| reach.total_cmp(&r).then(place.cmp(&at)).is_lt()) {
                best = Some((reach, place, p.z));
            }
            true
        };
        let _ = after.iter().all(&mut look);
        let _ = before.iter().rev().all(&mut look);
        best.map(|(.., z)| z)
    }
}

/// True when `p` lies inside the closed polygon (even-odd rule).
pub fn contains(polygon: &[Point3], p: Point3) -> bool {
    polygon.windows(2).fold(false, |inside, w| {
        let crosses = (w[0].y > p.y) != (w[1].y > p.y);
        if crosses && p.x < w[0].x + (p.y - w[0].y) / (w[1].y - w[0].y) * (w[1].x - w[0].x) {
            !inside
        } else {
            inside
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(points: &[(f64, f64)]) -> Vec<Point3> {
        points.iter().map(|&(x, y)| Point3 { x, y, z: 0.0 }).collect()
    }

    #[test]
    fn center_of_a_straight_lane_is_half_way_whatever_the_corners() {
        // Left edge at y = 4 with a needless corner near its start, right edge at y = 0: the center is y = 2.
        let c = center_line(&line(&[(0.0, 4.0), (0.5, 4.0), (10.0, 4.0)]), &line(&[(0.0, 0.0), (10.0, 0.0)]));
        assert_eq!(c.len(), 11);
        for (i, p) in c.iter().enumerate() {
            assert!((p.x - i as f64).abs() < 1e-12 && (p.y - 2.0).abs() < 1e-12, "{p:?}");
        }
    }

    #[test]
    fn the_line_beside_a_corner_keeps_its_distance() {
        // East then north: 1 m to the left is the inner corner (9, 1).
        let inner = beside(&line(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)]), 1.0);
        let expected = line(&[(0.0, 1.0), (9.0, 1.0), (9.0, 10.0)]);
        for (a, b) in inner.iter().zip(&expected) {
            assert!(distance(*a, *b) < 1e-12, "{inner:?}");
        }
    }

    #[test]
    fn edges_of_impossible_length_have_a_center_line_of_bounded_size() {
        // Found by the fuzz target `av2-map`.
        for far in [1e300, f64::INFINITY, f64::NAN] {
            let center = center_line(&line(&[(0.0, 0.0), (far, 0.0)]), &line(&[(0.0, 2.0), (far, 2.0)]));
            assert!((2..=2000).contains(&center.len()), "{far}: {}", center.len());
        }
    }

    #[test]
    fn union_joins_what_touches_and_keeps_apart_what_does_not() {
        let square = |x: f64| line(&[(x, 0.0), (x + 2.0, 0.0), (x + 2.0, 2.0), (x, 2.0), (x, 0.0)]);
        let outlines = union_outlines(&[square(0.0), square(1.0), square(10.0)]);
        assert_eq!(outlines.len(), 2);
        let inside = |x: f64| outlines.iter().filter(|o| contains(o, Point3 { x, y: 1.0, z: 0.0 })).count();
        assert_eq!([inside(0.5), inside(2.5), inside(5.0), inside(11.0)], [1, 1, 0, 1]);
    }

    #[test]
    fn the_nearest_corner_is_the_one_that_asking_all_of_them_gives() {
        // A coarse grid, so that many corners are equally near and the first given must win; their heights differ.
        let mut state = 7_u64;
        let mut next = |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) % n) as f64
        };
        let corners: Vec<Point3> =
            (0..300).map(|i| Point3 { x: next(20), y: next(20), z: f64::from(i) }).collect();
        let polygons: Vec<Vec<Point3>> = corners.chunks(7).map(<[Point3]>::to_vec).collect();
        let index = Corners::of(&polygons);
        for _ in 0..500 {
            let here = Point3 { x: next(48) / 2.0 - 2.0, y: next(48) / 2.0 - 2.0, z: 0.0 };
            let all = corners.iter().min_by(|a, b| distance(**a, here).total_cmp(&distance(**b, here)));
            assert_eq!(index.nearest_height(here.x, here.y), all.map(|p| p.z), "{here:?}");
        }
        assert_eq!(Corners::of(&[]).nearest_height(0.0, 0.0), None);
    }

    #[test]
    fn edges_that_run_against_each_other_are_seen() {
        let left = line(&[(0.0, 4.0), (10.0, 4.0)]);
        assert!(!edges_oppose(&left, &line(&[(0.0, 0.0), (10.0, 0.0)])));
        assert!(edges_oppose(&left, &line(&[(10.0, 0.0), (0.0, 0.0)])));
    }
}
