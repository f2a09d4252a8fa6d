//! The part of a box inside the band that the ego sweeps along its path.

use crate::geometry::{Nearby, OrientedBox, P2, Projection};
use crate::road::path::DrivenPath;
use crate::target::on_lines::{Beside, around_foot};

/// Margin of the band on either side of the ego, m.
pub const PATH_MARGIN_M: f64 = 0.3;
/// Maximum distance of points around a footprint, m.
const BAND_STEP_M: f64 = 0.5;
/// Maximum preallocated number of points, however long a box is.
const MOST_ROOM: usize = 1024;
/// More than the rounding error of a distance, m.
const ROUNDED_M: f64 = 1e-6;

/// The band while the ego's center is at an arc length of its path.
#[derive(Clone, Copy)]
pub struct Band<'a> {
    /// The path.
    pub path: &'a DrivenPath,
    /// Arc length of the ego's center, m.
    pub ego_s: f64,
    /// m.
    pub ego_length: f64,
    /// m.
    pub ego_width: f64,
}

/// Points around a footprint, from its last corner on. Their positions on the path are computed when needed; for a
/// stationary object the same points are needed frame after frame.
#[derive(Default)]
pub struct Outline {
    points: Vec<P2>,
    on_path: Vec<Option<Projection>>,
    nearby: Option<Nearby>,
}

impl Outline {
    /// Clears the box.
    pub fn clear(&mut self) {
        self.nearby = None;
    }

    fn begin(&mut self, path: &DrivenPath, footprint: &OrientedBox, at: &Projection) {
        if self.nearby.is_some() {
            return;
        }
        self.nearby = Some(around_foot(path, footprint, at));
        let corners = footprint.corners();
        self.points.clear();
        let most = (2.0 * (footprint.length + footprint.width) / BAND_STEP_M) as usize;
        self.points.reserve(most.min(MOST_ROOM) + 9);
        self.points.push(corners[3]);
        for (i, &a) in corners.iter().enumerate() {
            let from = corners[(i + 3) % 4];
            let steps = ((a - from).norm() / BAND_STEP_M).ceil().max(1.0);
            self.points.extend((1..=steps as usize).map(|k| from + (a - from) * (k as f64 / steps)));
        }
        self.on_path.clear();
        self.on_path.resize(self.points.len(), None);
    }

    /// Position of point `k` on the path.
    fn at(&mut self, path: &DrivenPath, k: usize) -> Option<Projection> {
        if self.on_path[k].is_none() {
            let nearby = self.nearby.as_ref()?;
            let before = k.checked_sub(1).and_then(|k| self.on_path[k]);
            let near = before.map_or(nearby.middle(), |at| at.segment);
            self.on_path[k] = Some(path.line.project_nearby(self.points[k], nearby, near));
        }
        self.on_path[k]
    }
}

impl Band<'_> {
    /// First and last arc length of the points around a footprint that are in the band; `at` and `beside` state the
    /// footprint's position relative to the path. Points, not only corners: where the path bends away, a car beside the
    /// ego can have corners on both sides of it and still be outside. Beside the ego's own body the band has no margin.
    pub fn part_of(
        &self,
        footprint: &OrientedBox,
        at: &Projection,
        beside: &Beside,
        outline: &mut Outline,
    ) -> Option<(f64, f64)> {
        let half = self.ego_width / 2.0;
        // Slightly more than the corners give, for parts between them.
        let widest = half + PATH_MARGIN_M + 1.0;
        if beside.low > widest || beside.high < -widest {
            return None;
        }
        outline.begin(self.path, footprint, at);
        // Distance inside the band (negative: outside).
        let depth = |on: &Projection| {
            let margin = if (on.s - self.ego_s).abs() <= self.ego_length / 2.0 { 0.0 } else { PATH_MARGIN_M };
            half + margin - on.lateral.abs()
        };
        let mut extent: Option<(f64, f64)> = None;
        let mut include = |s: f64| {
            let (low, high) = extent.unwrap_or((s, s));
            extent = Some((low.min(s), high.max(s)));
        };
        let (mut k, mut was_inside) = (0, false);
        while k < outline.points.len() {
            let now = outline.at(self.path, k)?;
            let inside = depth(&now) >= 0.0;
            if k > 0 && inside {
                include(now.s);
            }
            if k > 0 && inside != was_inside {
                // Point where the side leaves the band, between two points.
                let before = outline.at(self.path, k - 1)?;
                let (from, to) = (depth(&before), depth(&now));
                include(before.s + (now.s - before.s) * (from / (from - to)));
            }
            was_inside = inside;
            // If a point is outside by more than the distance to the next points, these are outside, too.
            let outside = now.lateral.abs() - half - PATH_MARGIN_M - ROUNDED_M;
            let here = outline.points[k];
            k += 1;
            while outside > 0.0 && outline.points.get(k).is_some_and(|p| (*p - here).is_within(outside)) {
                k += 1;
            }
        }
        extent
    }
}
