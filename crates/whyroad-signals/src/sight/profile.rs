//! The road's heights along the driven path and the visible distance over crests. Writes `map.crest_ahead`.
//!
//! Heights are the ego's own where it drove; beyond the recording's end they continue with the map's, aligned with the
//! ego's at the joint. Only differences count, so the height of the box's center over the road does not matter.

use super::scene::Scene;
use crate::geometry::{P2, p2};
use crate::table::TableBuilder;
use whyroad_model::Tri;
use whyroad_model::catalog::id;
use whyroad_model::road_map::{Point3, RoadMap};

/// Height of the driver's eye over the road, m (AASHTO Green Book: 1.08; RASt: 1.0; a van's 1.2).
const EYE_M: f64 = 1.2;
/// Height of the object to be seen over the road, m: a car's tail light (AASHTO Green Book: 0.60).
const OBJECT_M: f64 = 0.6;
/// Distance between points along the path, m.
const STEP_M: f64 = 2.0;
/// Maximum look-ahead, m.
const HORIZON_M: f64 = 150.0;
/// Maximum distance of a crest for `map.crest_ahead`, m.
const CREST_M: f64 = 60.0;
/// Maximum distance of a lane's center line that gives the height, m.
const MAP_REACH_M: f64 = 4.0;

/// Heights by arc length of the path.
pub struct Profile {
    first: f64,
    heights: Vec<f64>,
}

/// Visible distance over the profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverCrest {
    /// Distance of the first position that is not visible; infinite if there is none, m.
    pub hidden_at: f64,
    /// Distance up to which heights are known, m.
    pub known_to: f64,
}

impl Profile {
    /// Along the scene's path; all unknown where the log has no heights.
    pub fn new(scene: &Scene<'_>) -> Self {
        let path = scene.path;
        let (first, driven_to) = path.driven;
        let count = ((path.line.length() - first) / STEP_M).max(0.0) as usize + 1;
        let at_end = path.z_at(driven_to);
        let lanes = scene.road.and(scene.drive.map.as_ref()).map(Lanes::new);
        let map_z =
            |s: f64| lanes.as_ref().map_or(f64::NAN, |lanes| lanes.height_at(path.line.point_at(s), at_end));
        let offset = at_end - map_z(driven_to);
        let height = |i: usize| {
            let s = first + i as f64 * STEP_M;
            if s <= driven_to { path.z_at(s) } else { map_z(s) + offset }
        };
        Self { first, heights: (0..count).map(height).collect() }
    }

    fn at(&self, s: f64) -> f64 {
        let x = (s - self.first) / STEP_M;
        if x.is_nan() || x < 0.0 {
            return f64::NAN;
        }
        let (i, share) = (x as usize, x.fract());
        match (self.heights.get(i), self.heights.get(i + 1)) {
            (Some(a), Some(b)) => a + (b - a) * share,
            (Some(a), None) if share < 1e-9 => *a,
            _ => f64::NAN,
        }
    }

    /// Visible distance from arc length `s`.
    pub fn sight(&self, s: f64) -> OverCrest {
        let eye = self.at(s) + EYE_M;
        let mut steepest = f64::NEG_INFINITY;
        let mut distance = STEP_M;
        while distance <= HORIZON_M {
            let road = self.at(s + distance);
            if road.is_nan() || eye.is_nan() {
                return OverCrest { hidden_at: f64::INFINITY, known_to: distance - STEP_M };
            }
            // The line from the eye to the object is blocked where the road between them has a larger elevation angle.
            if (road + OBJECT_M - eye) / distance < steepest - 1e-9 {
                return OverCrest { hidden_at: distance, known_to: distance };
            }
            steepest = steepest.max((road - eye) / distance);
            distance += STEP_M;
        }
        OverCrest { hidden_at: f64::INFINITY, known_to: HORIZON_M }
    }

    /// Writes `map.crest_ahead`.
    pub fn write(&self, scene: &Scene<'_>, table: &mut TableBuilder<'_>) {
        let crest = |s: &f64| {
            let over = self.sight(*s);
            if over.hidden_at <= CREST_M {
                return Tri::True;
            }
            if over.known_to >= CREST_M { Tri::False } else { Tri::Unknown }
        };
        table.flag(id::MAP_CREST_AHEAD, scene.path.ego_s.iter().map(crest).collect());
    }
}

/// The lanes of the map, each with the bounding box of its center line.
struct Lanes<'a> {
    map: &'a RoadMap,
    bounds: Vec<(P2, P2)>,
}

impl<'a> Lanes<'a> {
    fn new(map: &'a RoadMap) -> Self {
        let bounds = map.lanes.iter().map(|lane| {
            let around = |f: fn(f64, f64) -> f64, start: f64| {
                let fold = |acc: P2, p: &Point3| p2(f(acc.x, p.x), f(acc.y, p.y));
                lane.center.iter().fold(p2(start, start), fold)
            };
            (around(f64::min, f64::INFINITY), around(f64::max, f64::NEG_INFINITY))
        });
        Self { map, bounds: bounds.collect() }
    }

    /// Height of the nearest lane's center line at `p`; with several levels the one nearest to `about`. NaN if there is
    /// none.
    fn height_at(&self, p: P2, about: f64) -> f64 {
        // Slightly more than the reach: rounding must not exclude a lane.
        let reach = MAP_REACH_M + 1e-3;
        let near = |(low, high): &(P2, P2)| {
            p.x >= low.x - reach && p.x <= high.x + reach && p.y >= low.y - reach && p.y <= high.y + reach
        };
        let lanes = self.map.lanes.iter().zip(&self.bounds).filter(|(_, bounds)| near(bounds));
        let heights = lanes.flat_map(|(l, _)| l.center.windows(2)).filter_map(|w| near_segment(w, p));
        heights.min_by(|a, b| (a - about).abs().total_cmp(&(b - about).abs())).unwrap_or(f64::NAN)
    }
}

/// Height of the segment's point nearest to `p`, if it is near enough.
fn near_segment(w: &[Point3], p: P2) -> Option<f64> {
    let (a, b) = (w[0], w[1]);
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let length2 = dx * dx + dy * dy;
    let share =
        if length2 > 0.0 { (((p.x - a.x) * dx + (p.y - a.y) * dy) / length2).clamp(0.0, 1.0) } else { 0.0 };
    let away = p2(a.x + dx * share - p.x, a.y + dy * share - p.y);
    let z = a.z + (b.z - a.z) * share;
    (away.is_within(MAP_REACH_M) && z.is_finite()).then_some(z)
}
