//! What stands around one eye in one frame, by the angles that it fills, and what of a place or a box is seen past it.
//! Plane geometry: heights play no part.
//!
//! Everything that can hide something is cut into convex pieces: boxes as they are, buildings by their walls. Two
//! convex pieces that do not overlap are never before one another on one sight line and behind on another, so which
//! of the two is nearer is decided on one line, and the visible share of a box is exact: one minus the union of the
//! angles of the pieces before it. Nothing is sampled.

use crate::geometry::{OrientedBox, P2, wrap};

/// Angles smaller than this are none, rad (negligible at 80 m).
const LEAST_ANGLE_RAD: f64 = 1e-9;

/// What can hide something, as the rest of the family sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Owner {
    /// Index of a target.
    Target(usize),
    /// Index of a building.
    Building(usize),
}

/// Directions around the eye are divided into this number of ranges, so that a line meets few pieces.
const RANGES: usize = 64;
/// What a sector is widened by before its ranges are told, rad: more than rounding and [`Sector::contains`] allow.
const RANGE_SLACK_RAD: f64 = 1e-5;

/// Which of the ranges a direction is in: by a number that grows with the angle and costs no trigonometry.
fn range_of(direction: P2) -> usize {
    let around = direction.x.abs() + direction.y.abs();
    let share = direction.y / around;
    let turned = match (direction.x >= 0.0, direction.y >= 0.0) {
        (true, true) => share,
        (false, _) => 2.0 - share,
        (true, false) => 4.0 + share,
    };
    ((turned * (RANGES as f64 / 4.0)) as usize).min(RANGES - 1)
}

/// Angles around the eye: `mid` in (-pi, pi] and as much either side, rad.
#[derive(Clone, Copy, Debug)]
struct Sector {
    mid: f64,
    half: f64,
    direction: P2,
    least_cosine: f64,
    ranges: Ranges,
}

/// First range that a sector touches, and how many.
type Ranges = (usize, usize);

impl Sector {
    /// The angles under which a convex shape is seen from the origin, which is outside of it.
    fn of(corners: &[P2]) -> Self {
        let first = corners[0].heading();
        let (mut low, mut high) = ((0.0, corners[0]), (0.0, corners[0]));
        for c in &corners[1..] {
            let turned = wrap(c.heading() - first);
            if turned < low.0 {
                low = (turned, *c);
            }
            if turned > high.0 {
                high = (turned, *c);
            }
        }
        let ((low, from), (high, to)) = (low, high);
        let (mid, half) = (wrap(first + (low + high) / 2.0), (high - low) / 2.0);
        // A line along the very edge counts as within.
        let (direction, least_cosine) = (P2::from_heading(mid), half.cos() - 1e-12);
        Self { mid, half, direction, least_cosine, ranges: ranges(half, from, to) }
    }

    /// The part of `other` in this sector, relative to this one's middle.
    fn shared(&self, other: &Sector) -> Option<(f64, f64)> {
        let turned = wrap(other.mid - self.mid);
        let (low, high) = ((turned - other.half).max(-self.half), (turned + other.half).min(self.half));
        (high - low > LEAST_ANGLE_RAD).then_some((low, high))
    }

    fn contains(&self, direction: P2) -> bool {
        self.direction.dot(direction) >= self.least_cosine
    }
}

/// The ranges from one corner to the other, which are seen twice `half` apart.
fn ranges(half: f64, from: P2, to: P2) -> Ranges {
    if half.is_nan() || half + RANGE_SLACK_RAD >= std::f64::consts::FRAC_PI_2 {
        return (0, RANGES);
    }
    // Turned by a small angle, almost: a little of the vector across is added.
    let (from, to) = (from - from.left() * RANGE_SLACK_RAD, to + to.left() * RANGE_SLACK_RAD);
    let (from, to) = (range_of(from), range_of(to));
    (from, (to + RANGES - from) % RANGES + 1)
}

/// Something convex that hides, relative to the eye.
#[derive(Clone, Copy, Debug)]
enum Outline {
    Wall([P2; 2]),
    Box([P2; 4]),
}

impl Outline {
    fn corners(&self) -> &[P2] {
        match self {
            Outline::Wall(corners) => corners,
            Outline::Box(corners) => corners,
        }
    }
}

/// A convex piece of something that hides.
#[derive(Clone, Copy, Debug)]
struct Piece {
    owner: Owner,
    outline: Outline,
    sector: Sector,
    reach: Reach,
    footprint: Option<OrientedBox>,
}

/// Between which distances from the eye a shape is, m.
#[derive(Clone, Copy, Debug)]
struct Reach {
    nearest: f64,
    farthest: f64,
}

impl Reach {
    fn of(corners: &[P2]) -> Self {
        Self { nearest: nearest_point(corners), farthest: farthest_corner(corners) }
    }

    /// True where all of this is nearer than any of `other`, by more than rounding can do.
    fn is_before(&self, other: &Reach) -> bool {
        self.farthest * (1.0 + 1e-9) + 1e-6 < other.nearest
    }
}

/// Where a line from the origin with this direction first meets the shape; infinite when it misses, m.
fn entry(corners: &[P2], direction: P2) -> f64 {
    let n = corners.len();
    let sides = if n == 2 { 1 } else { n };
    let mut nearest = f64::INFINITY;
    for i in 0..sides {
        let (a, b) = (corners[i], corners[(i + 1) % n]);
        let along = b - a;
        let turn = direction.cross(along);
        if turn == 0.0 {
            continue;
        }
        let (distance, share) = (a.cross(along) / turn, a.cross(direction) / turn);
        if distance >= 0.0 && (0.0..=1.0).contains(&share) {
            nearest = nearest.min(distance);
        }
    }
    nearest
}

fn nearest_point(corners: &[P2]) -> f64 {
    let n = corners.len();
    let to_origin = |a: P2, b: P2| {
        let along = b - a;
        let length2 = along.dot(along);
        let share = if length2 > 0.0 { (-a.dot(along) / length2).clamp(0.0, 1.0) } else { 0.0 };
        a + along * share
    };
    let mut nearest = [P2::default(); 4];
    for (i, nearest) in nearest[..n].iter_mut().enumerate() {
        *nearest = to_origin(corners[i], corners[(i + 1) % n]);
    }
    // A root only of what can be the least.
    let least = nearest[..n].iter().map(|p| p.dot(*p)).fold(f64::INFINITY, f64::min) * (1.0 + 1e-12);
    nearest[..n].iter().filter(|p| p.dot(**p) <= least).map(|p| p.norm()).fold(f64::INFINITY, f64::min)
}

/// Distance of the farthest corner from the origin.
fn farthest_corner(corners: &[P2]) -> f64 {
    let most = corners.iter().map(|c| c.dot(*c)).fold(0.0, f64::max) * (1.0 - 1e-12);
    corners.iter().filter(|c| c.dot(**c) >= most).map(|c| c.norm()).fold(0.0, f64::max)
}

/// How much of a box is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Visible share, 0 to 1.
    pub share: f64,
    /// What hides most of it, the nearest one of equals; `None` when nothing hides any of it.
    pub occluder: Option<Owner>,
}

/// Everything that hides, around one eye.
#[derive(Clone, Debug)]
pub struct View {
    eye: P2,
    pieces: Vec<Piece>,
    /// For each 64 pieces, by range of directions, which of them are there.
    ranges: Vec<[u64; RANGES]>,
    /// By range of directions, how near the nearest of them is, m; infinite where there is none.
    nearest: [f64; RANGES],
}

impl View {
    /// An empty view from `eye`, with room for this number of pieces.
    pub fn from(eye: P2, pieces: usize) -> Self {
        let ranges = Vec::with_capacity(pieces.div_ceil(64));
        Self { eye, pieces: Vec::with_capacity(pieces), ranges, nearest: [f64::INFINITY; RANGES] }
    }

    /// Adds the box of a target. A box around the eye hides nothing: it is the ego's own trailer, or an error.
    pub fn add_box(&mut self, owner: Owner, footprint: OrientedBox) {
        let corners = footprint.corners().map(|c| c - self.eye);
        let about = OrientedBox::point(self.eye);
        if !footprint.overlaps(&about) {
            self.push(owner, Outline::Box(corners), Some(footprint));
        }
    }

    /// Adds a wall of a building.
    pub fn add_wall(&mut self, owner: Owner, a: P2, b: P2) {
        self.push(owner, Outline::Wall([a - self.eye, b - self.eye]), None);
    }

    fn push(&mut self, owner: Owner, outline: Outline, footprint: Option<OrientedBox>) {
        let reach = Reach::of(outline.corners());
        if reach.nearest > 0.0 {
            let sector = Sector::of(outline.corners());
            let (k, (first, count)) = (self.pieces.len(), sector.ranges);
            if k % 64 == 0 {
                self.ranges.push([0; RANGES]);
            }
            for range in (first..first + count).map(|range| range % RANGES) {
                self.ranges[k / 64][range] |= 1 << (k % 64);
                if reach.nearest < self.nearest[range] {
                    self.nearest[range] = reach.nearest;
                }
            }
            self.pieces.push(Piece { owner, sector, outline, reach, footprint });
        }
    }

    /// The pieces that some direction in these ranges may meet, in their order.
    fn pieces_in(&self, (first, count): Ranges) -> impl Iterator<Item = &Piece> {
        let words = self.ranges.iter().enumerate();
        let set = words.map(move |(k, by_range)| {
            (k, (first..first + count).fold(0, |set, range| set | by_range[range % RANGES]))
        });
        set.flat_map(move |(k, mut left)| {
            std::iter::from_fn(move || {
                let bit = left.trailing_zeros() as usize;
                (left != 0).then(|| {
                    left &= left - 1;
                    &self.pieces[64 * k + bit]
                })
            })
        })
    }

    /// How much of `target`'s box is seen past everything but itself. A box that overlaps it (a rider and the bicycle)
    /// hides nothing of it. `None` when the eye is inside.
    pub fn sight(&self, own: Option<Owner>, target: &OrientedBox) -> Option<Sight> {
        let corners = target.corners().map(|c| c - self.eye);
        let (sector, reach) = match self.piece_of(own, target) {
            Some(piece) => (piece.sector, piece.reach),
            None if target.overlaps(&OrientedBox::point(self.eye)) => return None,
            None => (Sector::of(&corners), Reach::of(&corners)),
        };
        let mut hidden: Vec<(Owner, f64, (f64, f64))> = Vec::new();
        let around = self.pieces_in(sector.ranges);
        for piece in around.filter(|p| Some(p.owner) != own && p.reach.nearest < reach.farthest) {
            let Some((low, high)) = sector.shared(&piece.sector) else { continue };
            // Most are apart in distance: then no line tells which is nearer, and they do not overlap.
            let is_before = piece.reach.is_before(&reach) || {
                let direction = P2::from_heading(sector.mid + (low + high) / 2.0);
                entry(piece.outline.corners(), direction) < entry(&corners, direction)
                    && piece.footprint.is_none_or(|f| !f.overlaps(target))
            };
            if is_before {
                hidden.push((piece.owner, piece.reach.nearest, (low, high)));
            }
        }
        if hidden.is_empty() {
            return Some(Sight { share: 1.0, occluder: None });
        }
        let covered = union(hidden.iter().map(|h| h.2).collect());
        let share = (1.0 - covered / (2.0 * sector.half)).clamp(0.0, 1.0);
        Some(Sight { share, occluder: most_hiding(hidden) })
    }

    /// The piece of this view that the box itself is, which is not around the eye. Targets are mostly added in the
    /// order of their numbers: where they are not, it may not be found.
    fn piece_of(&self, own: Option<Owner>, target: &OrientedBox) -> Option<&Piece> {
        let at = self.pieces.binary_search_by_key(&own?, |piece| piece.owner).ok()?;
        let piece = &self.pieces[at];
        (piece.footprint == Some(*target)).then_some(piece)
    }

    /// The first thing for which `counts` holds that stands before `place` as seen from the eye.
    pub fn before(&self, place: P2, counts: impl Fn(Owner) -> bool) -> Option<Owner> {
        let to = place - self.eye;
        // To within rounding, without a root.
        let reach = to.dot(to) * (1.0 + 1e-9);
        let near = |nearest: f64| nearest * nearest < reach;
        let range = range_of(to);
        // Most places are before everything or before an open sky: then nothing more is worked out.
        if !near(self.nearest[range]) {
            return None;
        }
        let distance = to.norm();
        let direction = to * (1.0 / distance.max(1e-9));
        self.pieces_in((range, 1))
            .filter(|p| near(p.reach.nearest))
            .filter(|p| p.reach.nearest < distance && p.sector.contains(direction) && counts(p.owner))
            .map(|p| (entry(p.outline.corners(), direction), p.owner))
            .filter(|(at, _)| *at < distance)
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, owner)| owner)
    }
}

/// Length of the union of intervals.
fn union(mut intervals: Vec<(f64, f64)>) -> f64 {
    intervals.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut covered, mut reached) = (0.0, f64::NEG_INFINITY);
    for (low, high) in intervals {
        covered += (high - low.max(reached)).max(0.0);
        reached = reached.max(high);
    }
    covered
}

/// The owner whose pieces together hide the greatest angle; of equals the nearest.
fn most_hiding(mut hidden: Vec<(Owner, f64, (f64, f64))>) -> Option<Owner> {
    hidden.sort_by_key(|h| h.0);
    hidden
        .chunk_by(|a, b| a.0 == b.0)
        .map(|of_one| {
            let nearest = of_one.iter().map(|h| h.1).fold(f64::INFINITY, f64::min);
            (union(of_one.iter().map(|h| h.2).collect()), nearest, of_one[0].0)
        })
        .max_by(|a, b| {
            let same = (a.0 - b.0).abs() <= LEAST_ANGLE_RAD;
            if same { b.1.total_cmp(&a.1) } else { a.0.total_cmp(&b.0) }
        })
        .map(|(_, _, owner)| owner)
}

#[cfg(test)]
mod tests;
