//! A polyline by arc length: the driven path, a lane's center line, an edge. It is extended straight beyond its ends.
//! The search for the point nearest to a position is in `nearest`.

mod nearest;

use super::P2;
use nearest::{BLOCK, Block, Segments};
pub use nearest::{Foot, Nearby, Projection, Window};
use std::ops::Range;

/// A polyline with the arc length at each point.
#[derive(Clone, Debug, Default)]
pub struct Polyline {
    points: Vec<P2>,
    s: Vec<f64>,
    segments: Segments,
    /// Unit vectors of the segments.
    directions: Vec<P2>,
    /// Lengths of the segments, m.
    lengths: Vec<f64>,
    places: Places,
}

/// Up to this number of points in an interval are searched linearly: usually there is one.
const FEW_POINTS: usize = 8;

/// Start of the search for an arc length: as many intervals of equal length as there are points.
#[derive(Clone, Debug, Default)]
struct Places {
    per_m: f64,
    /// By interval, the number of points before it; one more at the end.
    before: Vec<u32>,
}

impl Places {
    fn new(s: &[f64]) -> Self {
        let length = s.last().copied().unwrap_or(0.0);
        let per_m = s.len() as f64 / length;
        let begin = |k: usize| s.partition_point(|&v| v * per_m <= k as f64) as u32;
        Self { per_m, before: (0..=s.len()).map(begin).collect() }
    }

    /// Range of points that contains the first one beyond arc length `s`, to within rounding.
    fn about(&self, s: f64) -> Range<usize> {
        let stretch = ((s * self.per_m) as usize).min(self.before.len() - 2);
        self.before[stretch] as usize..self.before[stretch + 1] as usize
    }
}

/// A straight line from a point, up to some distance.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Its beginning.
    pub from: P2,
    /// Its direction, of length 1.
    pub direction: P2,
    /// Its length, m.
    pub reach: f64,
}

impl Ray {
    /// False if it certainly does not touch the circle: by more than rounding errors.
    fn may_touch(&self, block: &Block) -> bool {
        let to = block.center - self.from;
        let (along, radius) = (to.dot(self.direction), block.radius + 1e-3);
        self.direction.cross(to).abs() <= radius && along >= -radius && along <= self.reach + radius
    }
}

impl Polyline {
    /// A polyline through `points` without repeated ones; `None` if fewer than two distinct points are left.
    pub fn new(points: impl IntoIterator<Item = P2>) -> Option<Self> {
        let points = points.into_iter();
        let room = points.size_hint().0;
        let mut kept: Vec<P2> = Vec::with_capacity(room);
        let (mut s, mut lengths) = (Vec::with_capacity(room), Vec::with_capacity(room));
        for p in points {
            match (kept.last(), s.last()) {
                (Some(&q), Some(&at)) => {
                    let d = (p - q).norm();
                    // A millimeter: shorter segments have no usable direction.
                    if d > 1e-3 {
                        kept.push(p);
                        s.push(at + d);
                        lengths.push(d);
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
        let segments = Segments::new(&kept, &s, &lengths);
        let unit = |(w, length): (&[P2], &f64)| (w[1] - w[0]) * (1.0 / length);
        let directions = kept.windows(2).zip(&lengths).map(unit).collect();
        let places = Places::new(&s);
        Some(Self { segments, points: kept, s, directions, lengths, places })
    }

    /// The points.
    pub fn points(&self) -> &[P2] {
        &self.points
    }

    /// Arc length at each point.
    pub fn arc_lengths(&self) -> &[f64] {
        &self.s
    }

    /// Lengths of its segments, m.
    pub fn segment_lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// Length, m.
    pub fn length(&self) -> f64 {
        self.s.last().copied().unwrap_or(0.0)
    }

    /// Number of points up to arc length `s`, including those at it; 0 if it is unknown.
    fn points_up_to(&self, s: f64) -> usize {
        let about = self.places.about(s);
        let mut count = about.start;
        if about.len() > FEW_POINTS {
            count += self.s[about].partition_point(|&v| v <= s);
        }
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

    /// Linear interpolation at arc length `s` of `values`, one per point; constant beyond the ends.
    pub fn interpolate(&self, values: &[f64], s: f64) -> f64 {
        between(&self.s, values, s, self.points_up_to(s))
    }

    /// [`Polyline::interpolate`] of two kinds of values at the same position.
    pub fn interpolate_both(&self, values: [&[f64]; 2], s: f64) -> (f64, f64) {
        let count = self.points_up_to(s);
        (between(&self.s, values[0], s, count), between(&self.s, values[1], s, count))
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

    /// The middle of the directions of its segments, and the half of their range, rad. If that is less than pi / 2, all
    /// of its chords have directions in the range.
    pub fn range_of_directions(&self) -> (f64, f64) {
        let first = self.directions[0].heading();
        let (mut last, mut turned, mut low, mut high) = (first, 0.0_f64, 0.0_f64, 0.0_f64);
        for direction in &self.directions[1..] {
            let heading = direction.heading();
            turned += super::wrap(heading - last);
            (last, low, high) = (heading, low.min(turned), high.max(turned));
        }
        (super::wrap(first + (low + high) / 2.0), (high - low) / 2.0)
    }

    /// Direction of the chord from `s - reach` to `s + reach`, rad: bends drawn with few points cause no jumps.
    pub fn smooth_heading_at(&self, s: f64, reach: f64) -> f64 {
        let chord = self.point_at(s + reach) - self.point_at(s - reach);
        // The square is mostly sufficient to show that there is a chord.
        let known = chord.dot(chord) > 1e-11 || chord.norm() > 1e-6;
        if known { chord.heading() } else { self.heading_at(s) }
    }

    /// The same direction as a unit vector, to within rounding.
    pub fn smooth_direction_at(&self, s: f64, reach: f64) -> P2 {
        let chord = self.point_at(s + reach) - self.point_at(s - reach);
        let length2 = chord.dot(chord);
        if length2 > 1e-11 { chord * (1.0 / length2.sqrt()) } else { self.directions[self.segment_at(s)] }
    }

    /// Nearest foot point of `p` over the whole line.
    pub fn project(&self, p: P2) -> Projection {
        self.project_within(p, Window { first: 0, end: self.points.len() - 1 })
    }

    /// Nearest foot point of `p` among the segments that touch arc lengths `from..=to`. This keeps the result unique
    /// for lines that cross themselves (a loop, a roundabout).
    pub fn project_between(&self, p: P2, from: f64, to: f64) -> Projection {
        self.project_within(p, self.window(from, to))
    }

    /// The segments that touch arc lengths `from..=to`.
    pub fn window(&self, from: f64, to: f64) -> Window {
        Window { first: self.segment_at(from.min(to)), end: self.segment_at(to.max(from)) + 1 }
    }

    /// Nearest foot point of `p` among these segments.
    pub fn project_within(&self, p: P2, window: Window) -> Projection {
        self.foot(p, window, None).at
    }

    /// The segments within `reach` of arc length `s`, for several searches from positions that are no farther than
    /// `radius` from `center`.
    pub fn nearby(&self, s: f64, reach: f64, (center, radius): (P2, f64)) -> Nearby {
        self.segments.nearby(self.window(s - reach, s + reach), center, radius)
    }

    /// Nearest foot point of `p`, one of the positions of `nearby`, among its segments; the search begins at segment
    /// `near`, which does not change the result.
    pub fn project_nearby(&self, p: P2, nearby: &Nearby, near: usize) -> Projection {
        self.segments.foot_nearby(p, nearby, near)
    }

    /// [`Polyline::project_nearby`] of several positions that are near each other.
    pub fn project_each<const N: usize>(&self, places: [P2; N], nearby: &Nearby) -> [Projection; N] {
        let mut at = Projection { s: 0.0, lateral: 0.0, segment: nearby.middle() };
        let mut found = [at; N];
        // A loop: `map` is a call per position.
        for (found, p) in found.iter_mut().zip(places) {
            at = self.project_nearby(p, nearby, at.segment);
            *found = at;
        }
        found
    }

    /// Nearest foot point of `p` among these segments; the search begins near `before`, the foot point of an earlier
    /// position nearby. The result does not depend on it.
    pub fn foot(&self, p: P2, window: Window, before: Option<&Foot>) -> Foot {
        self.segments.foot(p, window, before)
    }

    /// [`Polyline::foot`] of the position `p` whose foot point was `before`, now among other segments: only segments
    /// that were not among the earlier ones are searched.
    pub fn foot_again(&self, p: P2, window: Window, before: &Foot) -> Foot {
        self.segments.foot_again(p, window, before)
    }

    /// The segments among these that the ray can meet, and some more, ascending.
    pub fn segments_met(&self, ray: Ray, among: Range<usize>) -> impl Iterator<Item = usize> {
        let blocks = among.start / BLOCK..among.end.div_ceil(BLOCK);
        let touched = blocks.filter(move |b| ray.may_touch(&self.segments.blocks[*b]));
        touched.flat_map(move |b| (b * BLOCK).max(among.start)..((b + 1) * BLOCK).min(among.end))
    }

    /// Minimum distance of `p` from the line itself (without its extension), m.
    pub fn distance(&self, p: P2) -> f64 {
        let blocks = &self.segments.blocks;
        let in_block = |b: usize| {
            let end = ((b + 1) * BLOCK).min(self.points.len() - 1);
            let sides = self.points[b * BLOCK..=end].windows(2);
            sides.map(|w| segment_distance2(p, w[0], w[1])).fold(f64::INFINITY, f64::min)
        };
        // The nearest block first: its result excludes most of the others.
        let away = |b: &usize| blocks[*b].away2(p);
        let begin = (0..blocks.len()).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(0);
        let mut d2 = in_block(begin);
        for b in (0..blocks.len()).filter(|b| *b != begin) {
            if blocks[b].may_be_within(p, d2.sqrt()) {
                d2 = d2.min(in_block(b));
            }
        }
        d2.sqrt()
    }

    /// Signed curvature at `s` from the change of direction over `reach` on either side, 1/m, left positive.
    pub fn curvature_at(&self, s: f64, reach: f64) -> f64 {
        let (before, after) = self.chords_at(s, reach);
        // Each chord represents the direction at its center: the two centers are `reach` apart.
        super::wrap(after.heading() - before.heading()) / reach
    }

    /// The chords of length `reach` before and after `s`.
    fn chords_at(&self, s: f64, reach: f64) -> (P2, P2) {
        let here = self.point_at(s);
        (here - self.point_at(s - reach), self.point_at(s + reach) - here)
    }

    /// The greatest of [`Polyline::curvature_at`] without sign at these arc lengths, with its sign, the first of equal
    /// ones; 0 if all are.
    pub fn greatest_curvature(&self, at: impl Iterator<Item = f64>, reach: f64) -> f64 {
        let mut greatest = 0.0_f64;
        for s in at {
            let (before, after) = self.chords_at(s, reach);
            // A turn is less than its tangent: where even that is less than the greatest turn by more than rounding
            // errors, no angle is needed.
            let clear = greatest.abs() * reach * (1.0 - 1e-9) - 1e-12;
            if before.cross(after).abs() < before.dot(after) * clear {
                continue;
            }
            let curvature = super::wrap(after.heading() - before.heading()) / reach;
            greatest = if curvature.abs() > greatest.abs() { curvature } else { greatest };
        }
        greatest
    }
}

/// Linear interpolation of `values` over ascending `at`, constant outside.
pub fn interpolate(at: &[f64], values: &[f64], s: f64) -> f64 {
    between(at, values, s, at.partition_point(|&v| v <= s))
}

/// Interpolates between the values before and at `i`, the first of `at` that is greater than `s`.
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
