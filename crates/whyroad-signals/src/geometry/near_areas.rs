//! Distance to the nearest of many areas, for one position after another: those of an object are near each other, so
//! that few areas can be the nearest, and whether one is within some distance holds for a while.

use super::{P2, Polygon};
use std::cell::RefCell;

/// Distance for which the areas that can be the nearest are kept, m.
const KEPT_M: f64 = 10.0;
/// More than the rounding error of a distance, m.
const ROUNDED_M: f64 = 1e-3;

/// Areas to which distances are asked.
pub struct NearAreas<'a> {
    all: Vec<&'a Polygon>,
    around: RefCell<Option<Around<'a>>>,
    last: RefCell<Option<Answer>>,
}

/// The areas that can be the nearest within [`KEPT_M`] of a position.
struct Around<'a> {
    place: P2,
    areas: Vec<&'a Polygon>,
}

/// Whether an area was within a distance of a position, which is the same up to `holds_m` from it.
#[derive(Clone, Copy)]
struct Answer {
    place: P2,
    reach: f64,
    is_within: bool,
    holds_m: f64,
}

impl<'a> NearAreas<'a> {
    /// Of these areas.
    pub fn new(all: impl IntoIterator<Item = &'a Polygon>) -> Self {
        Self { all: all.into_iter().collect(), around: RefCell::new(None), last: RefCell::new(None) }
    }

    /// Distance from `p` to the nearest area, 0 in it; infinite if there is none, m.
    pub fn distance(&self, p: P2) -> f64 {
        let mut around = self.around.borrow_mut();
        if let Some(around) = around.as_ref().filter(|around| (p - around.place).is_within(KEPT_M)) {
            return nearest(&around.areas, p);
        }
        let distance = nearest(&self.all, p);
        // Within that distance of `p` the nearest one is up to once as far away, and any other one that much nearer.
        let reach = distance + 2.0 * KEPT_M + ROUNDED_M;
        let areas = self.all.iter().copied().filter(|area| area.least_distance(p) <= reach).collect();
        *around = Some(Around { place: p, areas });
        distance
    }

    /// True when an area is within `reach` meters of `p`.
    pub fn is_within(&self, p: P2, reach: f64) -> bool {
        let last = *self.last.borrow();
        if let Some(last) = last.filter(|l| l.reach == reach && (p - l.place).is_within(l.holds_m)) {
            return last.is_within;
        }
        let distance = self.distance(p);
        let is_within = distance <= reach;
        let holds_m = (distance - reach).abs().min(1e6) - ROUNDED_M;
        *self.last.borrow_mut() = (holds_m > 0.0).then_some(Answer { place: p, reach, is_within, holds_m });
        is_within
    }
}

fn nearest(areas: &[&Polygon], p: P2) -> f64 {
    // The apparently nearest one excludes most of the others.
    let mut seems: (f64, Option<usize>) = (f64::INFINITY, None);
    for (k, area) in areas.iter().enumerate() {
        let least = area.least_distance(p);
        if least < seems.0 {
            seems = (least, Some(k));
        }
    }
    let mut nearest = seems.1.map_or(f64::INFINITY, |k| areas[k].distance(p));
    for (k, area) in areas.iter().enumerate() {
        // Nothing is nearer than an area around the position.
        if nearest == 0.0 {
            break;
        }
        if Some(k) != seems.1 && area.least_distance(p) <= nearest {
            nearest = nearest.min(area.distance(p));
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::p2;

    #[test]
    fn what_is_kept_changes_nothing() {
        // 400 triangles and squares at irregular positions, along walks of steps between millimeters and 30 m.
        let areas: Vec<Polygon> = (0..400_i32)
            .filter_map(|k| {
                let at = p2(f64::from(k * 37 % 401), f64::from(k * 91 % 397));
                let size = 1.0 + f64::from(k % 7);
                let corners = [at, at + p2(size, 0.3), at + p2(0.6, size), at + p2(-0.4, size * 0.5)];
                Polygon::new(corners.into_iter().take(3 + (k % 2) as usize))
            })
            .collect();
        let all: Vec<&Polygon> = areas.iter().collect();
        for step in [0.002, 0.13, 1.1, 4.0, 30.0] {
            let near = NearAreas::new(&areas);
            let (mut p, mut both) = (p2(200.0, 200.0), [0, 0]);
            for i in 0..3000 {
                p = p + P2::from_heading(f64::from(i * i % 17) * 0.4) * step;
                let expected = nearest(&all, p);
                let within = near.is_within(p, 5.0);
                assert_eq!(within, expected <= 5.0, "{step} {i}");
                assert_eq!(near.distance(p).to_bits(), expected.to_bits(), "{step} {i}");
                both[usize::from(within)] += 1;
            }
            assert!(step < 1.0 || both.iter().all(|n| *n > 0), "{both:?}");
        }
        assert_eq!(NearAreas::new([]).distance(p2(0.0, 0.0)), f64::INFINITY);
        assert!(!NearAreas::new([]).is_within(p2(0.0, 0.0), 5.0));
    }
}
