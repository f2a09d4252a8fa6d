//! Post-encroachment time from the recorded motion of both parties: the shortest time between one box leaving a
//! position and the other overlapping the same position. Entries and exits are half way between frames, so the accuracy
//! is one frame.

use crate::ego::motion::EgoMotion;
use crate::geometry::{OrientedBox, P2, wrap};
use crate::road::network::LEVEL_M;
use crate::target::placement::{Placement, Target};
use rstar::primitives::GeomWithData;
use rstar::{AABB, RTree};
use std::collections::BTreeSet;

/// Maximum time between both parties at one position of an encounter, s.
const LONGEST_S: f64 = 10.0;
/// A target that moves less than this over the drive crosses no path, m.
const LEAST_TRAVEL_M: f64 = 1.0;
/// Poses nearer than this are one position, m.
const STAND_M: f64 = 0.1;
/// Paths whose directions never differ by more than this follow one another: 15 deg.
const FOLLOWING_RAD: f64 = 15.0 * std::f64::consts::PI / 180.0;

/// A period in one position.
#[derive(Clone, Copy)]
struct Stand {
    footprint: OrientedBox,
    /// Height, m; NaN where it is not known.
    z: f64,
    /// First and last time at this position, half way to the adjacent frames, s.
    from: f64,
    until: f64,
}

/// Time between one party leaving a position and the other reaching it, s; negative if both are there at once.
fn apart(one: &Stand, other: &Stand) -> f64 {
    (other.from - one.until).max(one.from - other.until)
}

/// Poses in order of time; those at one position are joined.
fn stands(poses: impl Iterator<Item = (f64, f64, OrientedBox)>) -> Vec<Stand> {
    let mut found: Vec<Stand> = Vec::new();
    for (t, z, footprint) in poses {
        match found.last_mut() {
            Some(last) if (footprint.center - last.footprint.center).norm() < STAND_M => last.until = t,
            _ => found.push(Stand { footprint, z, from: t, until: t }),
        }
    }
    for i in 1..found.len() {
        let middle = (found[i - 1].until + found[i].from) / 2.0;
        (found[i - 1].until, found[i].from) = (middle, middle);
    }
    found
}

/// One encounter with a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encounter {
    /// s, not negative.
    pub pet: f64,
    /// First entry of either party, s.
    pub from: f64,
    /// Last exit of either party, s.
    pub until: f64,
}

/// The ego's swept area, computed once for all targets.
pub struct EgoSweep {
    stands: Vec<Stand>,
    tree: RTree<GeomWithData<[f64; 2], usize>>,
    radius: f64,
}

impl EgoSweep {
    /// From the ego's recorded poses; `times` in seconds.
    pub fn new(ego: &EgoMotion, times: &[f64]) -> Self {
        let known = (0..ego.len()).filter(|&i| ego.is_known(i));
        let stands = stands(known.map(|i| (times[i], ego.z[i], ego.footprint(i))));
        let points = stands.iter().enumerate();
        let tree = RTree::bulk_load(
            points.map(|(i, s)| GeomWithData::new([s.footprint.center.x, s.footprint.center.y], i)).collect(),
        );
        Self { radius: ego.length.hypot(ego.width) / 2.0, stands, tree }
    }

    fn near(&self, p: P2, reach: f64) -> impl Iterator<Item = usize> + '_ {
        let around = AABB::from_corners([p.x - reach, p.y - reach], [p.x + reach, p.y + reach]);
        self.tree.locate_in_envelope(&around).map(|e| e.data)
    }

    /// All encounters with a target.
    fn encounters(&self, theirs: &[Stand]) -> Vec<Encounter> {
        let mut pairs: Vec<(usize, usize)> = Vec::new();
        for (j, other) in theirs.iter().enumerate() {
            let reach = self.radius + other.footprint.radius();
            pairs.extend(
                self.near(other.footprint.center, reach)
                    // Under or on a bridge the paths do not meet.
                    .filter(|&i| {
                        let apart = (self.stands[i].z - other.z).abs();
                        apart.is_nan() || apart <= LEVEL_M
                    })
                    // Who comes to a position later than this does not meet the other there: two that drive along one
                    // road would meet all along it.
                    .filter(|&i| apart(&self.stands[i], other) <= LONGEST_S)
                    .filter(|&i| self.stands[i].footprint.overlaps(&other.footprint))
                    .map(|i| (i, j)),
            );
        }
        let own: BTreeSet<usize> = pairs.iter().map(|&(i, _)| i).collect();
        let mut found = Vec::new();
        for (first, last) in runs(own) {
            let here: Vec<(usize, usize)> =
                pairs.iter().copied().filter(|&(i, _)| i >= first && i <= last).collect();
            for (their_first, their_last) in runs(here.iter().map(|&(_, j)| j).collect()) {
                let (a, b) = (&self.stands[first], &self.stands[last]);
                let (c, d) = (&theirs[their_first], &theirs[their_last]);
                let met: Vec<(usize, usize)> =
                    here.iter().copied().filter(|&(_, j)| j >= their_first && j <= their_last).collect();
                let touched = met.iter().any(|&(i, j)| {
                    self.stands[i].from.max(theirs[j].from) < self.stands[i].until.min(theirs[j].until)
                });
                let crossed = met.iter().any(|&(i, j)| {
                    let turned = self.stands[i].footprint.heading - theirs[j].footprint.heading;
                    wrap(turned).abs() > FOLLOWING_RAD
                });
                // From box to box: the shortest time between one party leaving a position and the other reaching the
                // same position. Where paths merge, the whole area that both sweep does not show how near they came.
                let gaps = met.iter().map(|&(i, j)| apart(&self.stands[i], &theirs[j]));
                let pet = if touched { 0.0 } else { gaps.fold(f64::INFINITY, f64::min).max(0.0) };
                if crossed || touched {
                    found.push(Encounter { pet, from: a.from.min(c.from), until: b.until.max(d.until) });
                }
            }
        }
        found
    }

    /// PET of `target` for each of its rows: the minimum of the encounters in progress, infinite outside, NaN where its
    /// size is unknown.
    pub fn pet(&self, target: &Target<'_>, times: &[f64]) -> Vec<f64> {
        let known: Vec<_> = target.places.iter().flatten().filter(|p| p.is_sized()).collect();
        let traveled = known.first().is_some_and(|first| {
            let away = |p: &&Placement| p.footprint.center - first.footprint.center;
            // The square shows of most that they are nearer.
            let may_be = |away: P2| away.dot(away) >= LEAST_TRAVEL_M * LEAST_TRAVEL_M * (1.0 - 1e-9);
            known.iter().map(away).any(|away| may_be(away) && away.norm() >= LEAST_TRAVEL_M)
        });
        let encounters = if traveled {
            self.encounters(&stands(known.iter().map(|p| (times[p.frame], p.z, p.footprint))))
        } else {
            Vec::new()
        };
        let at = |t: f64| encounters.iter().filter(move |e| e.from <= t && t <= e.until).map(|e| e.pet);
        let value = |p: &Placement| at(times[p.frame]).fold(f64::INFINITY, f64::min);
        target.places.iter().map(|p| p.as_ref().filter(|p| p.is_sized()).map_or(f64::NAN, value)).collect()
    }
}

/// Uninterrupted runs of indices; breaks of one index are bridged.
fn runs(indices: BTreeSet<usize>) -> Vec<(usize, usize)> {
    let mut found: Vec<(usize, usize)> = Vec::new();
    for i in indices {
        match found.last_mut() {
            Some((_, last)) if i - *last <= 2 => *last = i,
            _ => found.push((i, i)),
        }
    }
    found
}
