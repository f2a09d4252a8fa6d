//! Objects that come near each other. Two objects whose bounding boxes over all their positions are never near are not
//! compared frame by frame.

use super::body::Body;
use crate::geometry::{P2, p2};
use std::collections::BTreeSet;
use whyroad_model::pair::{PAIR_REACH_M, PairSpan};
use whyroad_model::{FrameRange, ObjectClass};

/// Classes between which pairs are required: one object of `first` and one of `second`, in either order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PairClasses {
    /// Classes of the object of a rule.
    pub first: BTreeSet<ObjectClass>,
    /// Classes of the objects that the rule searches near it.
    pub second: BTreeSet<ObjectClass>,
}

/// The pairs in the order of a pair table, and by row whether they are near. Without classes: pairs of all objects.
pub fn pairs(bodies: &[Body], between: Option<&PairClasses>) -> (Vec<PairSpan>, Vec<bool>) {
    let outlines: Vec<Outline> = bodies.iter().map(|b| Outline::new(b, between)).collect();
    // First object, second object, frames in which they are near; and the same in reverse order.
    let mut met: Vec<(usize, usize, usize)> = Vec::new();
    let mut frames: Vec<Vec<usize>> = Vec::new();
    for i in 0..bodies.len() {
        for k in i + 1..bodies.len() {
            let (a, b) = (&outlines[i], &outlines[k]);
            let asked = (a.is_first && b.is_second) || (b.is_first && a.is_second);
            if !asked || a.is_far(b) {
                continue;
            }
            let of = meetings((&bodies[i], a), (&bodies[k], b));
            if !of.is_empty() {
                met.extend([(i, k, frames.len()), (k, i, frames.len())]);
                frames.push(of);
            }
        }
    }
    met.sort_unstable();
    let (mut spans, mut near) = (Vec::with_capacity(met.len()), Vec::new());
    for (first, second, of) in met {
        let of = &frames[of];
        let (Some(&start), Some(&last)) = (of.first(), of.last()) else { continue };
        let span =
            PairSpan { first, second, first_row: near.len(), frames: FrameRange::new(start, last + 1) };
        near.resize(near.len() + span.frames.len(), false);
        for frame in of {
            near[span.first_row + frame - start] = true;
        }
        spans.push(span);
    }
    (spans, near)
}

/// Data of an object for the comparison with each other one.
struct Outline {
    is_first: bool,
    is_second: bool,
    /// Distance from the box center to a corner by frame, m; 0 where a size is unknown.
    radius: Vec<f64>,
    /// The minimum and maximum position of a box, with its radius.
    least: P2,
    greatest: P2,
}

impl Outline {
    fn new(body: &Body, between: Option<&PairClasses>) -> Self {
        let admits = |classes: fn(&PairClasses) -> &BTreeSet<ObjectClass>| {
            between.is_none_or(|c| classes(c).contains(&body.class))
        };
        let radius: Vec<f64> = (0..body.length.len()).map(|i| radius_of(body, i)).collect();
        let (mut least, mut greatest) =
            (p2(f64::INFINITY, f64::INFINITY), p2(f64::NEG_INFINITY, f64::NEG_INFINITY));
        for (p, r) in body.position.iter().zip(&radius).filter(|(p, _)| p.is_finite()) {
            least = p2(least.x.min(p.x - r), least.y.min(p.y - r));
            greatest = p2(greatest.x.max(p.x + r), greatest.y.max(p.y + r));
        }
        Self { is_first: admits(|c| &c.first), is_second: admits(|c| &c.second), radius, least, greatest }
    }

    /// True if no box of one can be near one of the other at any time.
    fn is_far(&self, other: &Self) -> bool {
        let apart = |a: f64, b: f64| a - b > PAIR_REACH_M + 1e-6;
        apart(other.least.x, self.greatest.x)
            || apart(self.least.x, other.greatest.x)
            || apart(other.least.y, self.greatest.y)
            || apart(self.least.y, other.greatest.y)
    }
}

/// The frames in which two objects are near, in their order.
fn meetings((a, of_a): (&Body, &Outline), (b, of_b): (&Body, &Outline)) -> Vec<usize> {
    let both = a.frames.intersect(b.frames);
    let (from_a, from_b) = (both.start.wrapping_sub(a.frames.start), both.start.wrapping_sub(b.frames.start));
    let near = |n: &usize| {
        let (i, k) = (from_a + n, from_b + n);
        let apart = b.position[k] - a.position[i];
        // False where one of the two is not observed.
        let squared = apart.dot(apart);
        let farthest = PAIR_REACH_M + of_a.radius[i] + of_b.radius[k];
        squared <= farthest * farthest * (1.0 + 1e-9)
            && is_near((a, i, of_a.radius[i]), (b, k, of_b.radius[k]))
    };
    (0..both.len()).filter(near).map(|n| both.start + n).collect()
}

fn radius_of(body: &Body, i: usize) -> f64 {
    let radius = body.footprint(i).radius();
    if radius.is_finite() { radius } else { 0.0 }
}

/// Distance of the boxes within reach; of the centers where a size is unknown.
fn is_near((a, i, of_a): (&Body, usize, f64), (b, k, of_b): (&Body, usize, f64)) -> bool {
    let apart = b.position[k] - a.position[i];
    if apart.dot(apart) <= PAIR_REACH_M * PAIR_REACH_M * (1.0 - 1e-9) {
        return true;
    }
    let centers = apart.norm();
    if centers <= PAIR_REACH_M {
        return true;
    }
    if centers - of_a - of_b > PAIR_REACH_M {
        return false;
    }
    a.footprint(i).distance(&b.footprint(k)) <= PAIR_REACH_M
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn body(track: usize, class: ObjectClass, start: usize, positions: Vec<Option<P2>>, size: f64) -> Body {
        let n = positions.len();
        Body {
            track: Some(track),
            class,
            frames: FrameRange::new(start, start + n),
            position: positions.into_iter().map(|p| p.unwrap_or(p2(f64::NAN, f64::NAN))).collect(),
            z: vec![0.0; n],
            heading: vec![0.3; n],
            velocity: vec![p2(0.0, 0.0); n],
            accel: vec![0.0; n],
            length: vec![size; n],
            width: vec![if size > 10.0 { f64::NAN } else { 2.0 }; n],
        }
    }

    fn any_body() -> impl Strategy<Value = (bool, usize, Vec<Option<P2>>, f64)> {
        let point = (-80.0..80.0_f64, -10.0..10.0_f64).prop_map(|(x, y)| p2(x, y));
        let seen = prop::option::weighted(0.8, point);
        (any::<bool>(), 0_usize..5, prop::collection::vec(seen, 1..8), 1.0..12.0_f64)
    }

    proptest! {
        #[test]
        fn pairs_are_those_of_asking_every_two_in_every_frame(
            all in prop::collection::vec(any_body(), 0..7),
        ) {
            let class = |car| if car { ObjectClass::Car } else { ObjectClass::Pedestrian };
            let bodies: Vec<Body> = all
                .into_iter()
                .enumerate()
                .map(|(i, (car, start, at, size))| body(i, class(car), start, at, size))
                .collect();
            let is_near = |i: usize, k: usize, frame: usize| {
                let (a, b) = (&bodies[i], &bodies[k]);
                let Some((m, n)) = a.at(frame).zip(b.at(frame)) else { return false };
                let centers = (b.position[n] - a.position[m]).norm();
                centers <= PAIR_REACH_M || a.footprint(m).distance(&b.footprint(n)) <= PAIR_REACH_M
            };
            let cars = PairClasses {
                first: [ObjectClass::Car].into(),
                second: [ObjectClass::Pedestrian].into(),
            };
            for between in [None, Some(&cars)] {
                let (spans, near) = pairs(&bodies, between);
                let mut expected = Vec::new();
                for i in 0..bodies.len() {
                    for k in (0..bodies.len()).filter(|k| *k != i) {
                        let other = bodies[i].class != bodies[k].class;
                        if between.is_some() && !other {
                            continue;
                        }
                        let frames: Vec<usize> = (0..20).filter(|f| is_near(i, k, *f)).collect();
                        if !frames.is_empty() {
                            expected.push((i, k, frames));
                        }
                    }
                }
                let found: Vec<(usize, usize, Vec<usize>)> = spans
                    .iter()
                    .map(|s| {
                        let rows = s.rows().zip(s.frames.start..);
                        (s.first, s.second, rows.filter(|(r, _)| near[*r]).map(|(_, f)| f).collect())
                    })
                    .collect();
                prop_assert_eq!(found, expected);
            }
        }
    }
}
