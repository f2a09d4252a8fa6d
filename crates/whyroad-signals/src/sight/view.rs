//! The surroundings of one eye point in one frame, by the angles that they occupy, and the visible part of a position
//! or a box behind them. Plane geometry without heights.
//!
//! Everything that can hide something is divided into convex pieces: boxes as they are, buildings by their walls. Of
//! two convex pieces that do not overlap, the same one is in front on all common sight lines, so one line is enough to
//! determine which is nearer, and the visible share of a box is exact: one minus the union of the angles of the pieces
//! in front of it. Nothing is sampled.

use crate::geometry::{OrientedBox, P2, wrap};
use std::cell::RefCell;

/// Smaller angles are ignored, rad (negligible at 80 m).
const LEAST_ANGLE_RAD: f64 = 1e-9;

/// An object that can hide something, for the rest of the family.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Owner {
    /// Index of a target.
    Target(usize),
    /// Index of a building.
    Building(usize),
}

/// Number of ranges into which the directions around the eye are divided, so that a line meets few pieces.
const RANGES: usize = 64;
/// Margin added to a sector before its ranges are determined, rad: more than rounding and [`Sector::contains`] allow.
const RANGE_SLACK_RAD: f64 = 1e-5;

/// Range of a direction, from a number that increases with the angle and needs no trigonometry.
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

/// Angles around the eye: `mid` in (-pi, pi] and the same angle on either side, rad.
#[derive(Clone, Copy, Debug)]
struct Sector {
    mid: f64,
    half: f64,
    direction: P2,
    least_cosine: f64,
    ranges: Ranges,
}

/// First range that a sector touches, and their number.
type Ranges = (usize, usize);

impl Sector {
    /// The angles at which a convex shape outside of the origin is seen from it.
    fn of(corners: &[P2]) -> Self {
        let first = corners[0].heading();
        let (mut low, mut high) = ((0.0, corners[0]), (0.0, corners[0]));
        let (right, left) = outermost(corners);
        for c in &corners[1..] {
            // No angle is needed of a corner that is between two others by more than rounding errors.
            if is_left_of(*c, right) && is_left_of(left, *c) {
                continue;
            }
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
        // A line along the edge counts as inside.
        let (direction, least_cosine) = (P2::from_heading(mid), half.cos() - 1e-12);
        Self { mid, half, direction, least_cosine, ranges: ranges(half, from, to) }
    }

    /// The part of another sector, with this middle and half, in this one, relative to this one's center.
    fn shared(&self, mid: f64, half: f64) -> Option<(f64, f64)> {
        let turned = wrap(mid - self.mid);
        let (low, high) = ((turned - half).max(-self.half), (turned + half).min(self.half));
        (high - low > LEAST_ANGLE_RAD).then_some((low, high))
    }

    fn contains(&self, direction: P2) -> bool {
        self.direction.dot(direction) >= self.least_cosine
    }
}

/// The rightmost and the leftmost corner of a convex shape, as seen from the origin outside of it, to within rounding.
fn outermost(corners: &[P2]) -> (P2, P2) {
    let (mut right, mut left) = (corners[0], corners[0]);
    for c in &corners[1..] {
        right = if right.cross(*c) < 0.0 { *c } else { right };
        left = if left.cross(*c) > 0.0 { *c } else { left };
    }
    (right, left)
}

/// True if the direction of `a` is to the left of that of `b` by more than rounding errors.
fn is_left_of(a: P2, b: P2) -> bool {
    b.cross(a) > 1e-12 * (a.dot(a) + b.dot(b))
}

/// The ranges from one corner to the other, which are seen at an angle of twice `half`.
fn ranges(half: f64, from: P2, to: P2) -> Ranges {
    if half.is_nan() || half + RANGE_SLACK_RAD >= std::f64::consts::FRAC_PI_2 {
        return (0, RANGES);
    }
    // Rotated by a small angle, approximately: a small part of the perpendicular vector is added.
    let (from, to) = (from - from.left() * RANGE_SLACK_RAD, to + to.left() * RANGE_SLACK_RAD);
    let (from, to) = (range_of(from), range_of(to));
    (from, (to + RANGES - from) % RANGES + 1)
}

/// A convex occluder, relative to the eye.
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

/// A convex occluder with the angles and distances at which it is seen.
#[derive(Clone, Copy, Debug)]
struct Shape {
    outline: Outline,
    sector: Sector,
    reach: Reach,
}

impl Shape {
    /// `None` around the eye.
    fn of(outline: Outline) -> Option<Self> {
        let reach = Reach::of(outline.corners());
        (reach.nearest > 0.0).then(|| Self { outline, sector: Sector::of(outline.corners()), reach })
    }
}

/// A box as it was seen from an eye point: while neither moves, it is seen in the same way.
#[derive(Clone, Debug)]
pub struct SeenBox {
    eye: P2,
    footprint: OrientedBox,
    shape: Option<Shape>,
}

impl SeenBox {
    /// A box around the eye has no shape: it is the ego's own trailer, or an error.
    fn new(eye: P2, footprint: OrientedBox) -> Self {
        let is_around = footprint.overlaps(&OrientedBox::point(eye));
        let corners = || footprint.corners().map(|c| c - eye);
        let shape = if is_around { None } else { Shape::of(Outline::Box(corners())) };
        Self { eye, footprint, shape }
    }

    fn is_of(&self, eye: P2, footprint: &OrientedBox) -> bool {
        self.eye.has_bits_of(eye) && self.footprint.has_bits_of(footprint)
    }
}

/// A convex piece of an occluder.
#[derive(Clone, Copy, Debug)]
struct Piece {
    owner: Owner,
    outline: Outline,
    sector: Sector,
    reach: Reach,
    footprint: Option<OrientedBox>,
}

/// What the search for pieces in front of a box reads of each: the others are far apart in memory.
#[derive(Clone, Copy, Debug)]
struct Glance {
    owner: Owner,
    /// [`Reach::nearest`].
    nearest: f64,
    /// [`Sector::mid`].
    mid: f64,
    /// [`Sector::half`].
    half: f64,
}

/// Range of distances of a shape from the eye, m.
#[derive(Clone, Copy, Debug)]
struct Reach {
    nearest: f64,
    farthest: f64,
}

impl Reach {
    fn of(corners: &[P2]) -> Self {
        Self { nearest: nearest_point(corners), farthest: farthest_corner(corners) }
    }

    /// True if all of this is nearer than any of `other`, by more than rounding errors.
    fn is_before(&self, other: &Reach) -> bool {
        self.farthest * (1.0 + 1e-9) + 1e-6 < other.nearest
    }
}

/// The corner after corner `i` of `n`, without a division.
fn next_of(i: usize, n: usize) -> usize {
    if i + 1 == n { 0 } else { i + 1 }
}

/// Distance at which a line from the origin with this direction first meets the shape; infinite if it misses, m.
fn entry(corners: &[P2], direction: P2) -> f64 {
    let n = corners.len();
    let sides = if n == 2 { 1 } else { n };
    let mut nearest = f64::INFINITY;
    for i in 0..sides {
        let (a, b) = (corners[i], corners[next_of(i, n)]);
        let along = b - a;
        let (turn, across) = (direction.cross(along), a.cross(direction));
        // Most sides are beside the line by more than rounding errors: nothing is divided for them.
        if turn == 0.0 || across * turn < 0.0 || across.abs() > turn.abs() * (1.0 + 1e-12) {
            continue;
        }
        let (distance, share) = (a.cross(along) / turn, across / turn);
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
        *nearest = to_origin(corners[i], corners[next_of(i, n)]);
    }
    // A square root only for candidates for the minimum.
    let least = nearest[..n].iter().map(|p| p.dot(*p)).fold(f64::INFINITY, f64::min) * (1.0 + 1e-12);
    nearest[..n].iter().filter(|p| p.dot(**p) <= least).map(|p| p.norm()).fold(f64::INFINITY, f64::min)
}

/// Distance of the farthest corner from the origin.
fn farthest_corner(corners: &[P2]) -> f64 {
    let most = corners.iter().map(|c| c.dot(*c)).fold(0.0, f64::max) * (1.0 - 1e-12);
    corners.iter().filter(|c| c.dot(**c) >= most).map(|c| c.norm()).fold(0.0, f64::max)
}

/// Visibility of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Visible share, 0 to 1.
    pub share: f64,
    /// The object that hides most of it, the nearest one if equal; `None` if nothing hides any of it.
    pub occluder: Option<Owner>,
}

/// All occluders around one eye point.
#[derive(Clone, Debug)]
pub struct View {
    eye: P2,
    pieces: Vec<Piece>,
    /// By piece.
    glances: Vec<Glance>,
    /// For each 64 pieces, by range of directions, the pieces in the range.
    ranges: Vec<[u64; RANGES]>,
    /// By range of directions, the distance of the nearest piece, m; infinite if there is none.
    nearest: [f64; RANGES],
    /// Room for what hides a box, kept from one question to the next.
    room: RefCell<Room>,
}

/// Which of 64 pieces a direction in these ranges may meet.
fn in_ranges(by_range: &[u64; RANGES], (first, count): Ranges) -> u64 {
    (first..first + count).fold(0, |set, range| set | by_range[range % RANGES])
}

/// What hides a box, and the hidden angles of some of it.
#[derive(Clone, Debug, Default)]
struct Room {
    hidden: Vec<Hidden>,
    angles: Vec<(f64, f64)>,
}

/// What hides a part of a box: its owner, the distance of its nearest point, m, and the hidden angles.
type Hidden = (Owner, f64, (f64, f64));

impl View {
    /// An empty view from `eye`, with room for this number of pieces.
    pub fn from(eye: P2, pieces: usize) -> Self {
        let ranges = Vec::with_capacity(pieces.div_ceil(64));
        let (glances, nearest) = (Vec::with_capacity(pieces), [f64::INFINITY; RANGES]);
        Self { eye, pieces: Vec::with_capacity(pieces), glances, ranges, nearest, room: RefCell::default() }
    }

    /// Adds the box of a target; `last` is how it was seen before, and then now.
    pub fn add_box(&mut self, owner: Owner, footprint: OrientedBox, last: &mut Option<SeenBox>) {
        let known = last.take().filter(|seen| seen.is_of(self.eye, &footprint));
        let seen = last.insert(known.unwrap_or_else(|| SeenBox::new(self.eye, footprint)));
        if let Some(shape) = seen.shape {
            self.push(owner, shape, Some(footprint));
        }
    }

    /// Adds a wall of a building.
    pub fn add_wall(&mut self, owner: Owner, a: P2, b: P2) {
        if let Some(shape) = Shape::of(Outline::Wall([a - self.eye, b - self.eye])) {
            self.push(owner, shape, None);
        }
    }

    fn push(&mut self, owner: Owner, shape: Shape, footprint: Option<OrientedBox>) {
        let Shape { outline, sector, reach } = shape;
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
        self.glances.push(Glance { owner, nearest: reach.nearest, mid: sector.mid, half: sector.half });
        self.pieces.push(Piece { owner, sector, outline, reach, footprint });
    }

    /// Visible share of `target`'s box behind all pieces except itself. A box that overlaps it (a rider and the
    /// bicycle) hides nothing of it. `None` if the eye is inside.
    pub fn sight(&self, own: Option<Owner>, target: &OrientedBox) -> Option<Sight> {
        let corners = target.corners().map(|c| c - self.eye);
        let (sector, reach) = match self.piece_of(own, target) {
            Some(piece) => (piece.sector, piece.reach),
            None if target.overlaps(&OrientedBox::point(self.eye)) => return None,
            None => (Sector::of(&corners), Reach::of(&corners)),
        };
        let mut room = self.room.take();
        let Room { hidden, angles } = &mut room;
        hidden.clear();
        for (k, by_range) in self.ranges.iter().enumerate() {
            let mut left = in_ranges(by_range, sector.ranges);
            while left != 0 {
                let at = 64 * k + left.trailing_zeros() as usize;
                left &= left - 1;
                let Glance { owner, nearest, mid, half } = self.glances[at];
                let may_hide = nearest < reach.farthest && Some(owner) != own;
                let shared = if may_hide { sector.shared(mid, half) } else { None };
                let Some((low, high)) = shared else { continue };
                let piece = &self.pieces[at];
                // Most are separate in distance: then no sight line is needed to determine which is nearer, and they
                // do not overlap.
                let is_before = piece.reach.is_before(&reach) || {
                    let direction = P2::from_heading(sector.mid + (low + high) / 2.0);
                    entry(piece.outline.corners(), direction) < entry(&corners, direction)
                        && piece.footprint.is_none_or(|f| !f.overlaps(target))
                };
                if is_before {
                    hidden.push((owner, nearest, (low, high)));
                }
            }
        }
        let (covered, occluder) = match hidden[..] {
            [] => (0.0, None),
            [(owner, _, (low, high))] => ((high - low).max(0.0), Some(owner)),
            _ => (union(hidden, angles), most_hiding(hidden, angles)),
        };
        self.room.replace(room);
        let share = match occluder {
            None => 1.0,
            Some(_) => (1.0 - covered / (2.0 * sector.half)).clamp(0.0, 1.0),
        };
        Some(Sight { share, occluder })
    }

    /// The piece of this view for the box itself, if it is not around the eye. Targets are usually added in the order
    /// of their numbers; otherwise it may not be found.
    fn piece_of(&self, own: Option<Owner>, target: &OrientedBox) -> Option<&Piece> {
        let at = self.glances.binary_search_by_key(&own?, |glance| glance.owner).ok()?;
        let piece = &self.pieces[at];
        (piece.footprint == Some(*target)).then_some(piece)
    }

    /// Only the pieces whose owners meet `counts`, for many positions.
    pub fn counting(&self, counts: impl Fn(Owner) -> bool) -> Counting<'_> {
        let mut counted =
            Counting { view: self, pieces: vec![0; self.ranges.len()], nearest: [f64::INFINITY; RANGES] };
        for (k, piece) in self.pieces.iter().enumerate().filter(|(_, piece)| counts(piece.owner)) {
            counted.pieces[k / 64] |= 1 << (k % 64);
            let (first, count) = piece.sector.ranges;
            for range in (first..first + count).map(|range| range % RANGES) {
                if piece.reach.nearest < counted.nearest[range] {
                    counted.nearest[range] = piece.reach.nearest;
                }
            }
        }
        counted
    }
}

/// Those pieces of a view that count, as seen from its eye.
pub struct Counting<'v> {
    view: &'v View,
    /// For each 64 pieces, those that count.
    pieces: Vec<u64>,
    /// By range of directions, the distance of the nearest of them, m; infinite if there is none.
    nearest: [f64; RANGES],
}

impl Counting<'_> {
    /// The first object in front of `place` as seen from the eye.
    pub fn before(&self, place: P2) -> Option<Owner> {
        let to = place - self.view.eye;
        // To within rounding, without a square root.
        let reach = to.dot(to) * (1.0 + 1e-9);
        let near = |nearest: f64| nearest * nearest < reach;
        let range = range_of(to);
        // Most positions are in front of everything, or nothing is in that direction: then nothing more is computed.
        if !near(self.nearest[range]) {
            return None;
        }
        let distance = to.norm();
        let direction = to * (1.0 / distance.max(1e-9));
        let (mut first, mut beyond): (Option<(f64, Owner)>, f64) = (None, f64::INFINITY);
        for (k, (by_range, counted)) in self.view.ranges.iter().zip(&self.pieces).enumerate() {
            let mut left = by_range[range] & counted;
            while left != 0 {
                let piece = &self.view.pieces[64 * k + left.trailing_zeros() as usize];
                left &= left - 1;
                // Of a piece that is behind the first one by more than rounding errors, no point is the first.
                if !near(piece.reach.nearest)
                    || piece.reach.nearest >= distance.min(beyond)
                    || !piece.sector.contains(direction)
                {
                    continue;
                }
                let at = entry(piece.outline.corners(), direction);
                if at < distance && first.is_none_or(|(least, _)| at.total_cmp(&least).is_lt()) {
                    first = Some((at, piece.owner));
                    beyond = at * (1.0 + 1e-9) + 1e-6;
                }
            }
        }
        first.map(|(_, owner)| owner)
    }
}

/// Length of the union of the hidden angles; `angles` is room for them.
fn union(hidden: &[Hidden], angles: &mut Vec<(f64, f64)>) -> f64 {
    angles.clear();
    angles.extend(hidden.iter().map(|h| h.2));
    angles.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut covered, mut reached) = (0.0, f64::NEG_INFINITY);
    for &mut (low, high) in angles {
        covered += (high - low.max(reached)).max(0.0);
        reached = reached.max(high);
    }
    covered
}

/// The owner whose pieces together hide the largest angle; if equal, the nearest.
fn most_hiding(hidden: &mut [Hidden], angles: &mut Vec<(f64, f64)>) -> Option<Owner> {
    hidden.sort_by_key(|h| h.0);
    hidden
        .chunk_by(|a, b| a.0 == b.0)
        .map(|of_one| {
            let nearest = of_one.iter().map(|h| h.1).fold(f64::INFINITY, f64::min);
            (union(of_one, angles), nearest, of_one[0].0)
        })
        .max_by(|a, b| {
            let same = (a.0 - b.0).abs() <= LEAST_ANGLE_RAD;
            if same { b.1.total_cmp(&a.1) } else { a.0.total_cmp(&b.0) }
        })
        .map(|(_, _, owner)| owner)
}

#[cfg(test)]
mod tests;
