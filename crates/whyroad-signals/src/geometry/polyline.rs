//! A polyline by arc length: the driven path, a lane's centre line, an edge. Beyond its ends it goes on straight.

use super::P2;
use std::ops::Range;

/// A polyline with the arc length at each point.
#[derive(Clone, Debug, Default)]
pub struct Polyline {
    points: Vec<P2>,
    s: Vec<f64>,
    blocks: Vec<Block>,
    segments: Vec<Segment>,
    /// Unit vectors of the segments.
    directions: Vec<P2>,
    places: Places,
}

/// Where to begin to look for an arc length: as many stretches of one length as there are points.
#[derive(Clone, Debug, Default)]
struct Places {
    per_m: f64,
    /// By stretch, the number of points before it; one more at the end.
    before: Vec<u32>,
}

impl Places {
    fn new(s: &[f64]) -> Self {
        let length = s.last().copied().unwrap_or(0.0);
        let per_m = s.len() as f64 / length;
        let begin = |k: usize| s.partition_point(|&v| v * per_m <= k as f64) as u32;
        Self { per_m, before: (0..=s.len()).map(begin).collect() }
    }

    /// Points among which the first one beyond arc length `s` is, to within rounding.
    fn about(&self, s: f64) -> Range<usize> {
        let stretch = ((s * self.per_m) as usize).min(self.before.len() - 2);
        self.before[stretch] as usize..self.before[stretch + 1] as usize
    }
}

/// A segment as the search for the nearest one reads it.
#[derive(Clone, Copy, Debug)]
struct Segment {
    from: P2,
    /// From its first point to its second.
    along: P2,
    /// One divided by its squared length.
    inverse: f64,
    /// Shares of the segment between which a foot point can be: the first and the last segment go on straight.
    low: f64,
    high: f64,
}

impl Segment {
    /// Squared distance of `p`, to within rounding: without division.
    fn about(&self, p: P2) -> f64 {
        let to = p - self.from;
        let share = to.dot(self.along) * self.inverse;
        let share = if share < self.low { self.low } else { share };
        let share = if share > self.high { self.high } else { share };
        let away = to - self.along * share;
        away.dot(away)
    }
}

/// Number of segments per block.
const BLOCK: usize = 16;

/// Up to this number of segments are looked at together.
const MOST: usize = 2 * BLOCK;

/// Some segments of a polyline, one after another.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    first: usize,
    end: usize,
}

/// A circle around some segments: who is farther from it than from a segment elsewhere need not look at these.
#[derive(Clone, Copy, Debug)]
struct Block {
    centre: P2,
    radius: f64,
}

impl Block {
    fn around(points: &[P2]) -> Self {
        let (first, last) = (points[0], points[points.len() - 1]);
        let centre = (first + last) * 0.5;
        let radius = points.iter().map(|p| (*p - centre).norm()).fold(0.0, f64::max);
        Self { centre, radius }
    }

    /// Not more than the squared distance of `p` from any of the segments. A little less than it could be: the foot
    /// points are rounded too, and one that is left out must not have been the nearest.
    fn least2(&self, p: P2) -> f64 {
        let away = p - self.centre;
        let apart = (away.dot(away).sqrt() * (1.0 - 1e-9) - self.radius * (1.0 + 1e-9) - 1e-6).max(0.0);
        apart * apart
    }
}

/// A straight way from a point, up to some distance.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it begins.
    pub from: P2,
    /// Its direction, of length 1.
    pub direction: P2,
    /// How far it goes, m.
    pub reach: f64,
}

impl Ray {
    /// False where it surely does not touch the circle: by more than rounding can do.
    fn may_touch(&self, block: &Block) -> bool {
        let to = block.centre - self.from;
        let (along, radius) = (to.dot(self.direction), block.radius + 1e-3);
        self.direction.cross(to).abs() <= radius && along >= -radius && along <= self.reach + radius
    }
}

/// Where a point lies along and beside a polyline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Arc length of the foot point, m; negative before the start, beyond the length after the end.
    pub s: f64,
    /// Signed distance, left positive, m.
    pub lateral: f64,
    /// The segment used.
    pub segment: usize,
}

impl Polyline {
    /// A polyline through `points`, repeated ones dropped; `None` when fewer than two distinct points are left.
    pub fn new(points: impl IntoIterator<Item = P2>) -> Option<Self> {
        let mut kept: Vec<P2> = Vec::new();
        let mut s = Vec::new();
        for p in points {
            match (kept.last(), s.last()) {
                (Some(&q), Some(&at)) => {
                    let d = (p - q).norm();
                    // A millimetre: shorter segments have no usable direction.
                    if d > 1e-3 {
                        kept.push(p);
                        s.push(at + d);
                    }
                }
                _ if p.is_finite() => {
                    kept.push(p);
                    s.push(0.0);
                }
                _ => {}
            }
        }
        if kept.len() < 2 {
            return None;
        }
        let last = kept.len() - 1;
        let blocks = (0..last).step_by(BLOCK).map(|i| Block::around(&kept[i..=(i + BLOCK).min(last)]));
        let segment = |i: usize| {
            let length = s[i + 1] - s[i];
            let low = if i > 0 { 0.0 } else { f64::NEG_INFINITY };
            let high = if i + 1 < last { 1.0 } else { f64::INFINITY };
            let (from, along) = (kept[i], kept[i + 1] - kept[i]);
            Segment { from, along, inverse: 1.0 / (length * length), low, high }
        };
        let segments = (0..last).map(segment).collect();
        let unit = |w: &[P2]| {
            let d = w[1] - w[0];
            d * (1.0 / d.norm())
        };
        let directions = kept.windows(2).map(unit).collect();
        let (blocks, places) = (blocks.collect(), Places::new(&s));
        Some(Self { blocks, segments, points: kept, s, directions, places })
    }

    /// The points.
    pub fn points(&self) -> &[P2] {
        &self.points
    }

    /// Arc length at each point.
    pub fn arc_lengths(&self) -> &[f64] {
        &self.s
    }

    /// Length, m.
    pub fn length(&self) -> f64 {
        self.s.last().copied().unwrap_or(0.0)
    }

    /// Number of points up to arc length `s`, those at it included; none where it is not known.
    fn points_up_to(&self, s: f64) -> usize {
        let about = self.places.about(s);
        let mut count = about.start + self.s[about].partition_point(|&v| v <= s);
        while self.s.get(count).is_some_and(|&v| v <= s) {
            count += 1;
        }
        while count > 0 && (self.s[count - 1] > s || s.is_nan()) {
            count -= 1;
        }
        count
    }

    fn segment_at(&self, s: f64) -> usize {
        self.points_up_to(s).clamp(1, self.points.len() - 1) - 1
    }

    /// Linear interpolation at arc length `s` of `values`, of which there is one per point; constant beyond the ends.
    pub fn interpolate(&self, values: &[f64], s: f64) -> f64 {
        between(&self.s, values, s, self.points_up_to(s))
    }

    /// The point at arc length `s`, on the straight continuation outside.
    pub fn point_at(&self, s: f64) -> P2 {
        let i = self.segment_at(s);
        self.points[i] + self.directions[i] * (s - self.s[i])
    }

    /// Direction of the segment at `s`, rad.
    pub fn heading_at(&self, s: f64) -> f64 {
        self.directions[self.segment_at(s)].heading()
    }

    /// Direction of the chord from `s - reach` to `s + reach`, rad: bends drawn with few points do not jump.
    pub fn smooth_heading_at(&self, s: f64, reach: f64) -> f64 {
        let chord = self.point_at(s + reach) - self.point_at(s - reach);
        if chord.norm() > 1e-6 { chord.heading() } else { self.heading_at(s) }
    }

    /// Nearest foot point of `p` over the whole line.
    pub fn project(&self, p: P2) -> Projection {
        self.project_segments(p, 0, self.points.len() - 1)
    }

    /// Nearest foot point of `p` among the segments that touch arc lengths `from..=to`. Keeps lines that cross
    /// themselves (a loop, a roundabout) unambiguous.
    pub fn project_between(&self, p: P2, from: f64, to: f64) -> Projection {
        self.project_within(p, self.window(from, to))
    }

    /// The segments that touch arc lengths `from..=to`.
    pub fn window(&self, from: f64, to: f64) -> Window {
        Window { first: self.segment_at(from.min(to)), end: self.segment_at(to.max(from)) + 1 }
    }

    /// Nearest foot point of `p` among these segments.
    pub fn project_within(&self, p: P2, window: Window) -> Projection {
        self.project_segments(p, window.first, window.end)
    }

    fn project_segments(&self, p: P2, first: usize, end: usize) -> Projection {
        let mut best = Nearest::none(first);
        if end - first <= MOST {
            self.look(p, first..end, &mut best);
            return best.at;
        }
        // The block that is nearest first: with what is found there, most of the others need no look.
        let blocks = first / BLOCK..end.div_ceil(BLOCK);
        let segments = |b: usize| (b * BLOCK).max(first)..((b + 1) * BLOCK).min(end);
        let mut nearest = (f64::INFINITY, blocks.start);
        for b in blocks.clone() {
            let least2 = self.blocks[b].least2(p);
            if least2 < nearest.0 {
                nearest = (least2, b);
            }
        }
        self.look(p, segments(nearest.1), &mut best);
        // The ends go on beyond their blocks.
        let open = |b: usize| b == 0 || b + 1 == self.blocks.len();
        for b in blocks.filter(|b| *b != nearest.1) {
            if open(b) || self.blocks[b].least2(p) <= best.d2 {
                self.look(p, segments(b), &mut best);
            }
        }
        best.at
    }

    /// Looks for a nearer foot point on these segments, at most [`MOST`]; of equally near ones the first on the line is
    /// taken.
    fn look(&self, p: P2, segments: Range<usize>, best: &mut Nearest) {
        let n = self.points.len() - 1;
        // Without division, to within rounding: which segments can be the nearest.
        let mut about = [f64::INFINITY; MOST];
        let mut least = best.d2;
        for (segment, about) in self.segments[segments.clone()].iter().zip(&mut about) {
            *about = segment.about(p);
            if *about < least {
                least = *about;
            }
        }
        let enough = least * (1.0 + 1e-9) + 1e-8;
        for (i, _) in segments.zip(&about).filter(|(_, about)| **about <= enough) {
            let Segment { from: a, along: ab, .. } = self.segments[i];
            let length = self.s[i + 1] - self.s[i];
            let mut along = (p - a).dot(ab) / length;
            // The first and last segment go on straight; between them the foot stays on the segment.
            if i > 0 {
                along = along.max(0.0);
            }
            if i + 1 < n {
                along = along.min(length);
            }
            let foot = a + ab * (along / length);
            let away = p - foot;
            let d2 = away.dot(away);
            if d2 < best.d2 || (d2 == best.d2 && i < best.at.segment) {
                let side = if ab.cross(p - a) >= 0.0 { 1.0 } else { -1.0 };
                let at = Projection { s: self.s[i] + along, lateral: side * d2.sqrt(), segment: i };
                *best = Nearest { d2, at };
            }
        }
    }

    /// The segments from `first` on that the ray can meet, and some more, ascending.
    pub fn segments_met(&self, ray: Ray, first: usize) -> impl Iterator<Item = usize> {
        let n = self.points.len() - 1;
        let blocks = (first / BLOCK..self.blocks.len()).filter(move |b| ray.may_touch(&self.blocks[*b]));
        blocks.flat_map(move |b| (b * BLOCK).max(first)..((b + 1) * BLOCK).min(n))
    }

    /// Smallest distance of `p` from the line itself (not its continuation), m.
    pub fn distance(&self, p: P2) -> f64 {
        let d2 =
            self.points.windows(2).map(|w| segment_distance2(p, w[0], w[1])).fold(f64::INFINITY, f64::min);
        d2.sqrt()
    }

    /// Signed curvature at `s` from the change of direction over `reach` either side, 1/m, left positive.
    pub fn curvature_at(&self, s: f64, reach: f64) -> f64 {
        let before = self.point_at(s) - self.point_at(s - reach);
        let after = self.point_at(s + reach) - self.point_at(s);
        // Each chord stands for the direction half way along it: the two are `reach` apart.
        super::wrap(after.heading() - before.heading()) / reach
    }
}

/// Linear interpolation of `values` over ascending `at`, constant outside.
pub fn interpolate(at: &[f64], values: &[f64], s: f64) -> f64 {
    between(at, values, s, at.partition_point(|&v| v <= s))
}

/// Between the values before and at `i`, the first of `at` that is greater than `s`.
fn between(at: &[f64], values: &[f64], s: f64, i: usize) -> f64 {
    if i == 0 {
        return values[0];
    }
    if i >= at.len() {
        return values[values.len() - 1];
    }
    let t = (s - at[i - 1]) / (at[i] - at[i - 1]);
    values[i - 1] + t * (values[i] - values[i - 1])
}

/// The nearest foot point so far.
struct Nearest {
    d2: f64,
    at: Projection,
}

impl Nearest {
    fn none(segment: usize) -> Self {
        Self { d2: f64::INFINITY, at: Projection { s: 0.0, lateral: 0.0, segment } }
    }
}

/// Squared distance of `p` from the segment `a b`.
pub(super) fn segment_distance2(p: P2, a: P2, b: P2) -> f64 {
    let ab = b - a;
    let l2 = ab.dot(ab);
    let t = if l2 > 0.0 { ((p - a).dot(ab) / l2).clamp(0.0, 1.0) } else { 0.0 };
    let d = p - (a + ab * t);
    d.dot(d)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::p2;

    fn l_shape() -> Polyline {
        Polyline::new([p2(0.0, 0.0), p2(10.0, 0.0), p2(10.0, 0.0), p2(10.0, 10.0)]).unwrap()
    }

    #[test]
    fn projection_by_hand() {
        let line = l_shape();
        assert_eq!(line.length(), 20.0);
        let at = line.project(p2(4.0, 2.0));
        assert_eq!((at.s, at.lateral), (4.0, 2.0));
        let at = line.project(p2(12.0, 5.0));
        assert_eq!((at.s, at.lateral), (15.0, -2.0));
        let outer_corner = line.project(p2(13.0, -4.0));
        assert_eq!((outer_corner.s, outer_corner.lateral), (10.0, -5.0));
    }

    #[test]
    fn the_ends_go_on_straight() {
        let line = l_shape();
        assert_eq!(line.project(p2(-3.0, -1.0)), Projection { s: -3.0, lateral: -1.0, segment: 0 });
        assert_eq!(line.project(p2(11.0, 30.0)).s, 40.0);
        assert_eq!(line.point_at(-2.0), p2(-2.0, 0.0));
        assert_eq!(line.point_at(25.0), p2(10.0, 15.0));
    }

    #[test]
    fn a_window_keeps_the_right_branch() {
        // Out along y = 0, back along y = 4: the point is nearer to the way back, but asked on the way out.
        let line = Polyline::new([p2(0.0, 0.0), p2(50.0, 0.0), p2(50.0, 4.0), p2(0.0, 4.0)]).unwrap();
        assert_eq!(line.project_between(p2(20.0, 3.0), 0.0, 40.0).s, 20.0);
        assert!(line.project(p2(20.0, 3.0)).s > 80.0);
    }

    /// Every segment, with the divisions that the definition has.
    fn one_by_one(line: &Polyline, p: P2, segments: Range<usize>) -> Projection {
        let n = line.points.len() - 1;
        let mut best = Nearest::none(segments.start);
        for i in segments {
            let (a, length) = (line.points[i], line.s[i + 1] - line.s[i]);
            let ab = line.points[i + 1] - a;
            let along = (p - a).dot(ab) / length;
            let along = along.clamp(
                if i > 0 { 0.0 } else { f64::NEG_INFINITY },
                if i + 1 < n { length } else { f64::INFINITY },
            );
            let away = p - (a + ab * (along / length));
            let d2 = away.dot(away);
            if d2 < best.d2 {
                let side = if ab.cross(p - a) >= 0.0 { 1.0 } else { -1.0 };
                let at = Projection { s: line.s[i] + along, lateral: side * d2.sqrt(), segment: i };
                best = Nearest { d2, at };
            }
        }
        best.at
    }

    #[test]
    fn a_long_line_is_searched_as_a_short_one() {
        // Loops and straights, with points that are equally near to several segments: leaving blocks out changes
        // nothing.
        let wave = |i: usize| {
            let t = i as f64 * 0.05;
            p2(30.0 * t.cos() + 3.0 * t, 20.0 * (1.3 * t).sin())
        };
        let lines = [
            Polyline::new((0..900).map(wave)).unwrap(),
            Polyline::new((0..400).map(|i| p2(f64::from(i), 0.0))).unwrap(),
            Polyline::new((0..400).map(|i| p2(f64::from(i % 20), f64::from(i / 20)))).unwrap(),
            // In the coordinates of a country, with steps of a few millimetres.
            Polyline::new((0..900).map(|i| wave(i) * 0.01 + p2(682_312.7, 3_412_990.3))).unwrap(),
            Polyline::new((0..20).map(wave)).unwrap(),
        ];
        for line in &lines {
            let n = line.points.len() - 1;
            for k in 0..2000u32 {
                let p = p2(f64::from(k % 71) * 3.5 - 80.0, f64::from(k % 37) * 2.5 - 40.0);
                let p = if line.points[0].x > 1e5 { p * 0.02 + line.points[0] } else { p };
                let (a, b) = ((k as usize * 7) % n, (k as usize * 13) % n);
                for (first, end) in [(0, n), (a.min(b), a.max(b) + 1)] {
                    assert_eq!(
                        line.project_segments(p, first, end),
                        one_by_one(line, p, first..end),
                        "{p:?} {first}..{end}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_ray_meets_no_segment_that_was_left_out() {
        let wave =
            |i: usize| p2(30.0 * (i as f64 * 0.05).cos() + i as f64 * 0.15, 20.0 * (i as f64 * 0.065).sin());
        let line = Polyline::new((0..900).map(wave)).unwrap();
        let (points, mut met, mut looked_at) = (&line.points, 0, 0);
        for k in 0..400u32 {
            let from = p2(f64::from(k % 71) * 3.5 - 80.0, f64::from(k % 37) * 2.5 - 40.0);
            let ray = Ray { from, direction: P2::from_heading(f64::from(k) * 0.37), reach: 60.0 };
            let first = (k as usize * 7) % 800;
            let kept: Vec<usize> = line.segments_met(ray, first).collect();
            looked_at += kept.len();
            for i in first..points.len() - 1 {
                let (segment, to) = (points[i + 1] - points[i], points[i] - from);
                let across = ray.direction.cross(segment);
                let (x, share) = (to.cross(segment) / across, to.cross(ray.direction) / across);
                if (0.0..=1.0).contains(&share) && (0.0..=ray.reach).contains(&x) {
                    assert!(kept.contains(&i));
                    met += 1;
                }
            }
        }
        assert!(met > 300 && looked_at < 400 * 300, "{met} {looked_at}");
    }

    #[test]
    fn places_are_those_of_asking_every_point() {
        // Steps of a millimetre beside steps of a kilometre.
        let steps = |i: u32| if i % 50 == 49 { 1000.0 } else { 0.002 + f64::from(i % 7) };
        let mut x = 0.0;
        let points = (0..300).map(|i| {
            x += steps(i);
            p2(x, 0.0)
        });
        let line = Polyline::new(points).unwrap();
        let values: Vec<f64> = (0..300).map(|i| f64::from(i * i)).collect();
        let around = line.s.iter().flat_map(|s| [*s, s.next_down(), s.next_up(), s + 0.3, -s]);
        for s in around.chain([f64::NAN, f64::INFINITY, f64::NEG_INFINITY]) {
            assert_eq!(line.points_up_to(s), line.s.partition_point(|&v| v <= s), "{s}");
            let (by_line, plain) = (line.interpolate(&values, s), interpolate(&line.s, &values, s));
            assert_eq!(by_line.to_bits(), plain.to_bits(), "{s}");
        }
    }

    #[test]
    fn curvature_of_a_circle() {
        // Radius 25 m, left: 1/25.
        let line = Polyline::new((0..=100).map(|i| {
            let a = f64::from(i) * 0.02;
            p2(25.0 * a.sin(), 25.0 - 25.0 * a.cos())
        }))
        .unwrap();
        assert!((line.curvature_at(25.0, 5.0) - 0.04).abs() < 2e-4);
        assert!(Polyline::new([p2(1.0, 1.0), p2(1.0, 1.0)]).is_none());
    }
}
