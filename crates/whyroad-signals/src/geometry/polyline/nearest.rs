//! The point of a polyline that is nearest to a position. Segments are first compared to within rounding, without
//! division, block by block; only those that can be the nearest are computed exactly, so that the result equals a
//! search of all segments.
#![allow(
    clippy::needless_range_loop,
    reason = "several arrays go by one index, and are kept in registers so"
)]

use crate::geometry::P2;
use std::ops::Range;

/// Number of segments per block.
pub(super) const BLOCK: usize = 16;

/// Maximum number of segments that are compared together.
pub(super) const MOST: usize = 2 * BLOCK;

/// The search from segment to segment requires segments of at least this length, m: the segments that it skips are then
/// farther by more than rounding errors.
const LEAST_LENGTH_M: f64 = 0.1;
/// That search finds the nearest segment up to this distance to the inner side of each bend, as a share of its radius:
/// from the center of a bend all of it is equally near. Up to a half, the slope of the squared distance cannot decrease
/// at a bend by more than half of what it increases along either segment, so that no two minima are further apart than
/// on adjacent segments. On the outer side it only increases.
pub(super) const MOST_BENT: f64 = 0.45;
/// A foot point that is this far inside its segment is on no other segment, m.
const INSIDE_M: f64 = 0.02;

/// Consecutive segments of a polyline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    pub(super) first: usize,
    pub(super) end: usize,
}

/// Consecutive segments of a polyline, for several searches from positions in one circle.
#[derive(Clone, Copy, Debug)]
pub struct Nearby {
    window: Window,
    /// See [`Segments::bent`].
    pub(super) bent: f64,
}

impl Nearby {
    /// The segment in the middle.
    pub fn middle(&self) -> usize {
        (self.window.first + self.window.end) / 2
    }
}

/// Position of a point along and beside a polyline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Arc length of the foot point, m; negative before the start, beyond the length after the end.
    pub s: f64,
    /// Signed distance, left positive, m.
    pub lateral: f64,
    /// The segment used.
    pub segment: usize,
}

/// The segments in the layout for the search: coordinates in separate arrays, so that several are compared at once.
#[derive(Clone, Debug, Default)]
pub(super) struct Segments {
    /// Circles around each [`BLOCK`] of them.
    pub blocks: Vec<Block>,
    /// Arc length at each point.
    s: Vec<f64>,
    /// Start points.
    from_x: Vec<f64>,
    from_y: Vec<f64>,
    /// Vectors from the first to the second point.
    along_x: Vec<f64>,
    along_y: Vec<f64>,
    /// One divided by its squared length.
    inverse: Vec<f64>,
    /// The line's bend at the beginning of each; see [`bend`]. Its coordinates and its length.
    bend_x: Vec<f64>,
    bend_y: Vec<f64>,
    sharpness: Vec<f64>,
}

impl Segments {
    /// Segments between these points with these arc lengths, and of these lengths.
    pub fn new(points: &[P2], s: &[f64], lengths: &[f64]) -> Self {
        let last = points.len() - 1;
        let blocks = (0..last).step_by(BLOCK).map(|i| Block::around(&points[i..=(i + BLOCK).min(last)]));
        let room = || Vec::with_capacity(last);
        let mut out = Self {
            blocks: blocks.collect(),
            s: s.to_vec(),
            from_x: room(),
            from_y: room(),
            along_x: room(),
            along_y: room(),
            inverse: room(),
            bend_x: room(),
            bend_y: room(),
            sharpness: room(),
        };
        for (ends, s) in points.windows(2).zip(s.windows(2)) {
            let (along, length) = (ends[1] - ends[0], s[1] - s[0]);
            out.from_x.push(ends[0].x);
            out.from_y.push(ends[0].y);
            out.along_x.push(along.x);
            out.along_y.push(along.y);
            out.inverse.push(1.0 / (length * length));
        }
        for i in 0..last {
            let at = |i: usize| bend(&points[i - 1..=i + 1], lengths[i - 1], lengths[i]);
            let (bend, sharpness) = if i == 0 { Default::default() } else { at(i) };
            out.bend_x.push(bend.x);
            out.bend_y.push(bend.y);
            out.sharpness.push(sharpness);
        }
        out
    }

    /// Squared distances of `p` from these segments, to within rounding, without division. The first segment is
    /// extended straight before its beginning, the last one beyond its end.
    fn about(&self, p: P2, range: Range<usize>, about: &mut [f64]) {
        let some = range.clone();
        let (from_x, from_y) = (&self.from_x[some.clone()], &self.from_y[some.clone()]);
        let (along_x, along_y) = (&self.along_x[some.clone()], &self.along_y[some.clone()]);
        let inverse = &self.inverse[some];
        // One length for all, so that no index check is needed.
        let n = about.len().min(inverse.len());
        let about = &mut about[..n];
        let (from_x, from_y, along_x, along_y) = (&from_x[..n], &from_y[..n], &along_x[..n], &along_y[..n]);
        for i in 0..n {
            let to = (p.x - from_x[i], p.y - from_y[i]);
            about[i] = squared(to, (&along_x[i], &along_y[i]), inverse[i], 0.0, 1.0);
        }
        let last = self.inverse.len() - 1;
        for i in [0, last] {
            if range.contains(&i) {
                let (low, high) = self.ends(i);
                let to = (p.x - self.from_x[i], p.y - self.from_y[i]);
                let along = (&self.along_x[i], &self.along_y[i]);
                about[i - range.start] = squared(to, along, self.inverse[i], low, high);
            }
        }
    }
}

/// Change of direction at the middle one of three points: the difference of unit vectors per meter of the shorter
/// segment, which points to the inner side, and its length. The length is infinite where a segment is shorter than
/// [`LEAST_LENGTH_M`].
fn bend(points: &[P2], from_length: f64, to_length: f64) -> (P2, f64) {
    let (from, to) = (points[1] - points[0], points[2] - points[1]);
    let shorter = from_length.min(to_length);
    if shorter < LEAST_LENGTH_M {
        return (P2::default(), f64::INFINITY);
    }
    let bend = (to * (1.0 / to_length) - from * (1.0 / from_length)) * (1.0 / shorter);
    (bend, bend.norm())
}

/// Squared distance, to within rounding, of a position `to` from the beginning of a segment; its foot point is at a
/// share of the segment between `low` and `high`.
fn squared(to: (f64, f64), along: (&f64, &f64), inverse: f64, low: f64, high: f64) -> f64 {
    let share = (to.0 * along.0 + to.1 * along.1) * inverse;
    let share = if share < low { low } else { share };
    let share = if share > high { high } else { share };
    let away = (to.0 - along.0 * share, to.1 - along.1 * share);
    away.0 * away.0 + away.1 * away.1
}

/// A circle around some segments: a position that is farther from it than from another segment need not check these.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub center: P2,
    pub radius: f64,
}

impl Block {
    pub fn around(points: &[P2]) -> Self {
        let (first, last) = (points[0], points[points.len() - 1]);
        let center = (first + last) * 0.5;
        let radius = points.iter().map(|p| (*p - center).norm()).fold(0.0, f64::max);
        Self { center, radius }
    }

    /// Squared distance of `p` from its center.
    pub fn away2(&self, p: P2) -> f64 {
        let away = p - self.center;
        away.dot(away)
    }

    /// True when one of its segments can be at most `distance` from `p`. May be true although none is: foot points are
    /// rounded, too, and the nearest one must not be skipped.
    pub fn may_be_within(&self, p: P2, distance: f64) -> bool {
        let reach = (self.radius + distance) * (1.0 + 1e-8) + 1e-5;
        self.away2(p) <= reach * reach
    }
}

/// The nearest foot point of a position among some segments, with the data for starting the next search.
#[derive(Clone, Copy, Debug)]
pub struct Foot {
    /// Where it is.
    pub at: Projection,
    d2: f64,
    window: Window,
}

impl Foot {
    fn none(window: Window) -> Self {
        Self { d2: f64::INFINITY, at: Projection { s: 0.0, lateral: 0.0, segment: window.first }, window }
    }
}

impl Segments {
    /// Nearest foot point of `p` among these segments; the search begins near `before`, the foot point of an earlier
    /// position nearby. The result does not depend on it.
    pub fn foot(&self, p: P2, window: Window, before: Option<&Foot>) -> Foot {
        let Window { first, end } = window;
        let mut best = Foot::none(window);
        if end - first <= MOST {
            self.look(p, first..end, &mut best);
            return best;
        }
        // The nearest block first: its result excludes most of the others.
        let blocks = first / BLOCK..end.div_ceil(BLOCK);
        let segments = |b: usize| (b * BLOCK).max(first)..((b + 1) * BLOCK).min(end);
        let begin = before.map(|foot| foot.at.segment / BLOCK).filter(|b| blocks.contains(b));
        let begin = begin.unwrap_or_else(|| {
            let mut nearest = (f64::INFINITY, blocks.start);
            for b in blocks.clone() {
                let away2 = self.blocks[b].away2(p);
                if away2 < nearest.0 {
                    nearest = (away2, b);
                }
            }
            nearest.1
        });
        self.look(p, segments(begin), &mut best);
        let mut distance = best.d2.sqrt();
        for b in blocks {
            if b != begin && (self.is_open(b, p) || self.blocks[b].may_be_within(p, distance)) {
                self.look(p, segments(b), &mut best);
                distance = best.d2.sqrt();
            }
        }
        best
    }

    /// True if `p` is beyond the end of the line in this block: the end is extended straight, out of the block's
    /// circle.
    fn is_open(&self, b: usize, p: P2) -> bool {
        let (is_first, is_last) = (b == 0, b + 1 == self.blocks.len());
        (is_first && self.along(p, 0) < 0.0)
            || (is_last && self.share(p, self.inverse.len() - 1) > 1.0 - 1e-9)
    }

    /// [`Segments::foot`] of the position `p` whose foot point was `before`, now among other segments: only segments
    /// that were not among the earlier ones are searched.
    pub fn foot_again(&self, p: P2, window: Window, before: &Foot) -> Foot {
        let (Window { first, end }, known) = (window, before.window);
        if before.d2.is_infinite() || !(first..end).contains(&before.at.segment) {
            return self.foot(p, window, Some(before));
        }
        let mut best = Foot { window, ..*before };
        for new in [first..known.first.max(first), known.end.min(end)..end] {
            for start in new.clone().step_by(MOST) {
                self.look(p, start..(start + MOST).min(new.end), &mut best);
            }
        }
        best
    }

    /// Searches these segments, at most [`MOST`], for a nearer foot point; of equally near ones the first on the line
    /// is used.
    fn look(&self, p: P2, segments: Range<usize>, best: &mut Foot) {
        // Without division, to within rounding: the segments that can be the nearest.
        let mut about = [f64::INFINITY; MOST];
        self.about(p, segments.clone(), &mut about);
        let filled = segments.len().next_multiple_of(4).min(MOST);
        let least = least_of(&about[..filled]).min(best.d2);
        let enough = least * (1.0 + 1e-9) + 1e-8;
        for i in segments.clone() {
            if about[i - segments.start] <= enough {
                self.take_if_nearer(p, i, best);
            }
        }
    }

    /// Uses the foot point of `p` on this segment if it is nearer; of equally near ones the first on the line.
    fn take_if_nearer(&self, p: P2, i: usize, best: &mut Foot) {
        let a = P2 { x: self.from_x[i], y: self.from_y[i] };
        let ab = P2 { x: self.along_x[i], y: self.along_y[i] };
        let length = self.s[i + 1] - self.s[i];
        let mut along = (p - a).dot(ab) / length;
        // The first and last segment are extended straight; between them the foot point stays on the segment.
        if i > 0 {
            along = along.max(0.0);
        }
        if i + 1 < self.inverse.len() {
            along = along.min(length);
        }
        let foot = a + ab * (along / length);
        let away = p - foot;
        let d2 = away.dot(away);
        if d2 < best.d2 || (d2 == best.d2 && i < best.at.segment) {
            let side = if ab.cross(p - a) >= 0.0 { 1.0 } else { -1.0 };
            best.at = Projection { s: self.s[i] + along, lateral: side * d2.sqrt(), segment: i };
            best.d2 = d2;
        }
    }

    /// These segments, for several searches from positions that are no farther than `radius` from `center`.
    pub fn nearby(&self, window: Window, center: P2, radius: f64) -> Nearby {
        Nearby { window, bent: self.bent(window, center, radius) }
    }

    /// Nearest foot point of `p`, which is in the circle of `nearby`, among these segments, equal to the result of
    /// [`Segments::foot`]; the search begins at segment `near`. If the line hardly bends as seen from the circle, it
    /// goes from segment to segment: along the line the distance first decreases and then increases, except for
    /// adjacent segments.
    pub fn foot_nearby(&self, p: P2, nearby: &Nearby, near: usize) -> Projection {
        let Nearby { window: Window { first, end }, bent } = *nearby;
        let mut k = near.clamp(first, end - 1);
        if bent > MOST_BENT {
            return self.foot(p, nearby.window, None).at;
        }
        let mut share = self.share(p, k);
        while share > 1.0 && k + 1 < end {
            k += 1;
            share = self.share(p, k);
        }
        while share < 0.0 && k > first {
            k -= 1;
            share = self.share(p, k);
            if share > 1.0 {
                break;
            }
        }
        let mut best = Foot::none(nearby.window);
        let length = self.s[k + 1] - self.s[k];
        if share.min(1.0 - share) * length > INSIDE_M + bent * length {
            self.take_if_nearer(p, k, &mut best);
        } else {
            for i in k.saturating_sub(1).max(first)..(k + 2).min(end) {
                self.take_if_nearer(p, i, &mut best);
            }
        }
        best.at
    }

    /// Maximum distance of the circle's points to the inner side of a bend between these segments, as a share of the
    /// bend's radius; 0 if all of them are on the outer sides.
    fn bent(&self, Window { first, end }: Window, center: P2, radius: f64) -> f64 {
        // More than nothing, so that an infinite sharpness counts.
        let radius = radius + INSIDE_M;
        if !(center.is_finite() && radius.is_finite()) {
            return f64::INFINITY;
        }
        let inner = first + 1..end;
        let n = inner.len();
        let (from_x, from_y) = (&self.from_x[inner.clone()][..n], &self.from_y[inner.clone()][..n]);
        let (bend_x, bend_y) = (&self.bend_x[inner.clone()][..n], &self.bend_y[inner.clone()][..n]);
        let sharpness = &self.sharpness[inner][..n];
        let mut most = 0.0;
        for i in 0..n {
            let (x, y) = (center.x - from_x[i], center.y - from_y[i]);
            let bent = x * bend_x[i] + y * bend_y[i] + radius * sharpness[i];
            most = if bent > most { bent } else { most };
        }
        most
    }

    /// Share of a segment at which the foot point of `p` on its line is, to within rounding.
    #[inline]
    fn share(&self, p: P2, i: usize) -> f64 {
        self.along(p, i) * self.inverse[i]
    }

    /// Product of a segment and the vector from its beginning to `p`: negative before the beginning.
    #[inline]
    fn along(&self, p: P2, i: usize) -> f64 {
        let to = (p.x - self.from_x[i], p.y - self.from_y[i]);
        to.0 * self.along_x[i] + to.1 * self.along_y[i]
    }

    /// Range of shares of a segment in which a foot point on it can be: the first and the last are extended straight.
    fn ends(&self, i: usize) -> (f64, f64) {
        let low = if i == 0 { f64::NEG_INFINITY } else { 0.0 };
        let high = if i + 1 == self.inverse.len() { f64::INFINITY } else { 1.0 };
        (low, high)
    }
}

/// The minimum of some values, whose number is a multiple of four.
fn least_of(values: &[f64]) -> f64 {
    // In groups of four: no value waits for the one before it.
    let mut least = [f64::INFINITY; 4];
    for four in values.chunks_exact(4) {
        for k in 0..4 {
            least[k] = if four[k] < least[k] { four[k] } else { least[k] };
        }
    }
    least.into_iter().fold(f64::INFINITY, f64::min)
}
