//! The map around the shown part. In Stage I only around the past positions of the ego: the extent of the map along the
//! road ahead would reveal where the ego goes.

use super::columns::{rounded, word};
use super::shown::{Shown, shown};
use crate::app::App;
use crate::domain::scene::{LaneView, MapView, Shape};
use crate::problem::Answer;
use crate::service::tasks::TaskRow;
use whyroad_model::road_map::{Area, Point3, RoadMap};
use whyroad_model::{Drive, FrameRange};

/// Maximum distance from the ego, m.
const REACH_M: f64 = 120.0;

/// The map of a task.
pub fn map(app: &App, t: &TaskRow) -> Answer<MapView> {
    let Shown { drive, frames } = shown(app, t)?;
    Ok(drive.map.as_ref().map_or_else(MapView::default, |map| around(map, &places(&drive, frames))))
}

/// Positions of the ego, one per second; the origin if the log has no pose.
fn places(drive: &Drive, frames: FrameRange) -> Vec<[f64; 2]> {
    let Some(ego) = &drive.ego else { return vec![[0.0, 0.0]] };
    let at = |f: usize| [ego.motion.x[f], ego.motion.y[f]];
    // Backwards from the last one: the position at the keyframe is always included.
    (frames.start..frames.end)
        .rev()
        .step_by(10)
        .map(at)
        .filter(|p| p[0].is_finite() && p[1].is_finite())
        .collect()
}

fn around(map: &RoadMap, places: &[[f64; 2]]) -> MapView {
    let near = |points: &[Point3]| is_near(points, places);
    let area = |a: &Area| Shape { id: a.id.clone(), kind: None, points: line(&a.boundary) };
    let areas = |list: &[Area]| list.iter().filter(|a| near(&a.boundary)).map(area).collect::<Vec<_>>();
    MapView {
        lanes: map
            .lanes
            .iter()
            .filter(|l| near(&l.center) || near(&l.left))
            .map(|l| LaneView {
                id: l.id.clone(),
                left: line(&l.left),
                right: line(&l.right),
                centre: line(&l.center),
                left_mark: word(&l.left_mark),
                right_mark: word(&l.right_mark),
                kind: word(&l.kind),
                in_junction: l.in_junction,
            })
            .collect(),
        crosswalks: areas(&map.crosswalks),
        stop_lines: map
            .stop_lines
            .iter()
            .filter(|s| near(&s.line))
            .map(|s| Shape { id: s.id.clone(), kind: None, points: line(&s.line) })
            .collect(),
        junctions: areas(&map.junctions),
        drivable: areas(&map.drivable_areas),
        facilities: map
            .facilities
            .iter()
            .filter(|f| near(&f.boundary))
            .map(|f| Shape { id: f.id.clone(), kind: Some(f.kind.clone()), points: line(&f.boundary) })
            .collect(),
        signs: map
            .signs
            .iter()
            .filter(|s| near(&[s.position]))
            .map(|s| Shape { id: s.id.clone(), kind: Some(s.kind.clone()), points: line(&[s.position]) })
            .collect(),
    }
}

fn line(points: &[Point3]) -> Vec<[f64; 2]> {
    points.iter().map(|p| [rounded(p.x), rounded(p.y)]).collect()
}

/// True when a part of the line is near one of the positions.
fn is_near(points: &[Point3], places: &[[f64; 2]]) -> bool {
    let reach = |a: &Point3, b: &Point3| places.iter().any(|p| distance(*p, a, b) <= REACH_M);
    match points {
        [one] => reach(one, one),
        _ => points.windows(2).any(|w| reach(&w[0], &w[1])),
    }
}

/// Distance of a point from a straight segment, m.
fn distance(p: [f64; 2], a: &Point3, b: &Point3) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let length2 = dx * dx + dy * dy;
    let along = if length2 > 0.0 { ((p[0] - a.x) * dx + (p[1] - a.y) * dy) / length2 } else { 0.0 };
    let s = along.clamp(0.0, 1.0);
    (p[0] - a.x - s * dx).hypot(p[1] - a.y - s * dy)
}
