//! Whether the ego's driven path goes around a target: lateral deviation of the path away from it where the ego passes
//! it.
//!
//! It is measured on the driven path alone, so that neither an inaccurate lane nor a bend of the road looks like a
//! detour: the path where it is level with the target, compared with the curve of constant curvature through its points
//! before and behind.

use crate::geometry::{LastPlace, P2, p2};
use crate::road::path::DrivenPath;
use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use crate::target::placement::Placement;
use crate::target::rows::Rows;
use whyroad_model::catalog::id;

/// Distances of the points before and behind from the level position (the outer ones at twice the distance), m.
const REACHES_M: [f64; 6] = [8.0, 12.0, 20.0, 30.0, 45.0, 60.0];

/// Lateral deviation of the path at arc length `s`, where it is `here`, over points `reach` apart, left positive, m:
/// the fourth difference, which is zero for a line and a curve of constant curvature. `None` if the points were not all
/// driven.
fn bulge(path: &DrivenPath, (s, here): (f64, P2), reach: f64) -> Option<f64> {
    let inside = s - 2.0 * reach >= path.driven.0 && s + 2.0 * reach <= path.driven.1;
    if !inside {
        return None;
    }
    let at = |k: f64| path.line.point_at(s + k * reach);
    let (first, last) = (at(-2.0), at(2.0));
    let left = P2::from_heading((last - first).heading()).left();
    let height = |p: P2| (p - first).dot(left);
    let inner = (height(at(-1.0)) + height(at(1.0))) * (4.0 / 6.0);
    let outer = height(last) / 6.0;
    Some(height(here) - (inner - outer))
}

/// Lateral deviation of the path at arc length `s`, to the left (`away` 1) or to the right (-1), m.
fn bulges(path: &DrivenPath, s: f64, away: f64) -> f64 {
    let here = path.line.point_at(s);
    let found = REACHES_M.iter().filter_map(|&reach| bulge(path, (s, here), reach)).map(|b| b * away);
    found.fold(f64::NAN, f64::max)
}

/// Writes `target.detour`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let rows = Rows::new(scene.drive, table);
    let path = scene.around.path;
    // While both are stationary, they are level at the same position.
    let last = LastPlace::new();
    let value = |p: &Placement| {
        if !p.within_reach() {
            return 0.0;
        }
        let s = path.ego_s[p.frame] + p.ahead;
        let away = if p.path.lateral > 0.0 { -1.0 } else { 1.0 };
        last.at(p2(s, away), || bulges(path, s, away))
    };
    table.number(id::TARGET_DETOUR, rows.placed(scene.targets, f64::NAN, value));
}
