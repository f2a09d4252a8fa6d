//! Curvature of the road, here and ahead: of the ego's lane if there is one, else of its driven path. Computed from
//! geometry, so that it is known at standstill and before the ego gets there.

use crate::geometry::Polyline;
use crate::road::ego_lane::EgoLane;
use crate::road::path::DrivenPath;
use crate::table::TableBuilder;
use whyroad_model::catalog::id;

/// Length of the chords whose directions are compared, m.
const REACH_M: f64 = 5.0;
/// Look-ahead distance, m.
const AHEAD_M: f64 = 50.0;
/// Sampling step of the look-ahead, m.
const STEP_M: f64 = 2.0;

fn at(line: &Polyline, s: f64) -> f64 {
    line.curvature_at(s, REACH_M).abs()
}

/// Writes `map.curvature` and `map.curvature_ahead`.
pub fn write(path: &DrivenPath, lanes: Option<&EgoLane>, table: &mut TableBuilder<'_>) {
    let frames = 0..path.ego_s.len();
    let line = |i: usize| match lanes.and_then(|l| l.at(i)) {
        Some(on) => (&on.corridor.line, on.s),
        None => (&path.line, path.ego_s[i]),
    };
    let here = |i: usize| {
        let (line, s) = line(i);
        if s.is_nan() { s } else { at(line, s) }
    };
    let ahead = |i: usize| {
        let (line, s) = line(i);
        if s.is_nan() {
            return s;
        }
        let steps = (AHEAD_M / STEP_M) as usize;
        line.greatest_curvature((0..=steps).map(|k| s + k as f64 * STEP_M), REACH_M).abs()
    };
    table.number(id::MAP_CURVATURE, frames.clone().map(here).collect());
    table.number(id::MAP_CURVATURE_AHEAD, frames.map(ahead).collect());
}
