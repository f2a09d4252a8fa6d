//! The ranges of a path beside which something is located: it affects passing traffic even if the path does not lead
//! over or through it.

use crate::geometry::{P2, Polygon, p2};
use crate::road::path::DrivenPath;
use crate::road::stretch::Stretch;
use whyroad_model::road_map::Facility;

/// Sampling step along the path, m.
const STEP_M: f64 = 0.5;

/// Whether two segments have a point in common.
fn meet(a: P2, b: P2, c: P2, d: P2) -> bool {
    let (r, s) = (b - a, d - c);
    let across = r.cross(s);
    if across.abs() < 1e-12 {
        return false;
    }
    let (t, u) = ((c - a).cross(s) / across, (c - a).cross(r) / across);
    (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u)
}

/// The area beside one step of the path, on both sides.
fn strip(path: &DrivenPath, s: f64, reach: f64) -> [P2; 4] {
    let end = |s: f64| {
        let side = P2::from_heading(path.line.heading_at(s)).left() * reach;
        (path.line.point_at(s) + side, path.line.point_at(s) - side)
    };
    let (here, next) = (end(s), end(s + STEP_M));
    [here.0, here.1, next.1, next.0]
}

fn touches(edge: &(P2, P2), strip: &[P2; 4]) -> bool {
    let inside = || Polygon::new(strip.iter().copied()).is_some_and(|q| q.contains(edge.0));
    (0..4).any(|i| meet(edge.0, edge.1, strip[i], strip[(i + 1) % 4])) || inside()
}

/// Ranges of the path inside the facility or with a part of it directly beside them, at most `reach` m away. Accuracy:
/// half a meter.
pub fn parts(path: &DrivenPath, facility: &Facility, reach: f64) -> Vec<Stretch> {
    let corners: Vec<P2> = facility.boundary.iter().map(|p| p2(p.x, p.y)).collect();
    let n = corners.len();
    let edges: Vec<(P2, P2)> =
        if n < 2 { Vec::new() } else { (0..n).map(|i| (corners[i], corners[(i + 1) % n])).collect() };
    let area = Polygon::new(corners.iter().copied());
    let fold = |f: fn(f64, f64) -> f64, start: f64| {
        corners.iter().fold(p2(start, start), |acc, p| p2(f(acc.x, p.x), f(acc.y, p.y)))
    };
    let (low, high) = (fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY));
    let mut found: Vec<Stretch> = Vec::new();
    for k in 0..=(path.line.length() / STEP_M) as usize {
        let s = k as f64 * STEP_M;
        let at = path.line.point_at(s);
        if at.x < low.x - reach || at.x > high.x + reach || at.y < low.y - reach || at.y > high.y + reach {
            continue;
        }
        let within = area.as_ref().is_some_and(|area| area.contains(at));
        if !within && !edges.iter().any(|edge| touches(edge, &strip(path, s, reach))) {
            continue;
        }
        match found.last_mut().filter(|x| s - x.to < 1.5 * STEP_M) {
            Some(last) => last.to = s,
            None => found.push(Stretch { from: s, to: s }),
        }
    }
    found
}
