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

    /// Squared distance of `p` from its centre.
    fn away2(&self, p: P2) -> f64 {
        let away = p - self.centre;
        away.dot(away)
    }

    /// True when a segment of it can be as near to `p` as `distance`. Sometimes true where it is not: the foot points
    /// are rounded too, and one that is left out must not have been the nearest.
    fn may_be_within(&self, p: P2, distance: f64) -> bool {
        let reach = (self.radius + distance) * (1.0 + 1e-8) + 1e-5;
        self.away2(p) <= reach * reach
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
            let away2 = self.blocks[b].away2(p);
            if away2 < nearest.0 {
                nearest = (away2, b);
            }
        }
        self.look(p, segments(nearest.1), &mut best);
        // The ends go on beyond their blocks.
        let open = |b: usize| b == 0 || b + 1 == self.blocks.len();
        for b in blocks.filter(|b| *b != nearest.1) {
            if open(b) || self.blocks[b].may_be_within(p, best.d2.sqrt()) {
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
        for (segment, about) in self.segments[segments.clone()].iter().zip(&mut about) {
            *about = segment.about(p);
        }
        let least = least_of(&about).min(best.d2);
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

fn least_of(values: &[f64; MOST]) -> f64 {
    // Four by four: none waits for the one before it.
    let mut least = [f64::INFINITY; 4];
    for four in values.chunks_exact(4) {
        for (least, value) in least.iter_mut().zip(four) {
            if *value < *least {
                *least = *value;
            }
        }
    }
    least.into_iter().fold(f64::INFINITY, f64::min)
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
mod tests;
