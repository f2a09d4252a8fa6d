//! Junctions and crosswalks along the ego's driven path, as stretches of arc length; the distance to the next one,
//! and the way that the ego takes across each junction.

use crate::ego::motion::EgoMotion;
use crate::geometry::unwrap;
use crate::road::network::Road;
use crate::road::path::DrivenPath;
use crate::table::TableBuilder;
use std::f64::consts::PI;
use whyroad_model::Tri;
use whyroad_model::catalogue::{id, value::EgoMovement};

/// Step in which the path is probed, m.
const STEP_M: f64 = 0.5;
/// Stretches of one kind with less than this between them are one, m.
pub const MERGE_M: f64 = 5.0;
/// Farther ahead than this there is none, m.
pub const HORIZON_M: f64 = 150.0;
/// A turn's heading begins to change a little before the area and ends a little behind it, m.
pub const TURN_MARGIN_M: f64 = 3.0;
/// From this angle on a traversal is a turn: 45 deg (RefAV).
const TURN_RAD: f64 = PI / 4.0;
/// From this angle on it is a U-turn: 135 deg.
const UTURN_RAD: f64 = 3.0 * PI / 4.0;

/// Part of the path, arc lengths in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Where it begins.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
}

/// The stretches of the path for which `inside` holds, in order.
pub fn stretches(
    path: &DrivenPath,
    inside: impl Fn(crate::geometry::P2) -> bool,
    merge: f64,
) -> Vec<Stretch> {
    let mut found: Vec<Stretch> = Vec::new();
    let steps = (path.line.length() / STEP_M) as usize;
    for i in 0..=steps {
        let s = i as f64 * STEP_M;
        if !inside(path.line.point_at(s)) {
            continue;
        }
        match found.last_mut() {
            Some(last) if s - last.to <= merge.max(STEP_M) + 1e-9 => last.to = s,
            _ => found.push(Stretch { from: s, to: s }),
        }
    }
    found
}

/// Distance from the front bumper to the next stretch, 0 from reaching it until the centre has left it.
pub fn distance_to_next(stretches: &[Stretch], ego_s: f64, front: f64) -> f64 {
    if ego_s.is_nan() {
        return f64::NAN;
    }
    let next = stretches.iter().find(|x| x.to >= ego_s);
    let distance = next.map_or(f64::INFINITY, |x| (x.from - ego_s - front).max(0.0));
    if distance > HORIZON_M { f64::INFINITY } else { distance }
}

/// Heading turned over one traversal and whether the recording holds it from entry to exit.
fn turned(stretch: Stretch, path: &DrivenPath, headings: &[f64]) -> Option<(f64, bool)> {
    let near = |&i: &usize| {
        let s = path.ego_s[i];
        s >= stretch.from - TURN_MARGIN_M && s <= stretch.to + TURN_MARGIN_M
    };
    let frames: Vec<usize> = (0..headings.len()).filter(|i| headings[*i].is_finite()).filter(near).collect();
    let (first, last) = (*frames.first()?, *frames.last()?);
    let whole = path.driven.0 <= stretch.from && path.driven.1 >= stretch.to;
    Some((headings[last] - headings[first], whole))
}

/// The movement of a traversal that turned by `angle` (rad) and was seen as a `whole`.
pub fn movement(angle: f64, whole: bool) -> Option<EgoMovement> {
    if angle.abs() > UTURN_RAD {
        Some(EgoMovement::Uturn)
    } else if angle.abs() >= TURN_RAD {
        Some(if angle > 0.0 { EgoMovement::Left } else { EgoMovement::Right })
    } else {
        whole.then_some(EgoMovement::Straight)
    }
}

/// The junctions and crosswalks on the ego's path, in order.
pub struct Encounters {
    /// Junctions; those with less than 5 m between them are one.
    pub junctions: Vec<Stretch>,
    /// Crosswalks.
    pub crosswalks: Vec<Stretch>,
    /// Heading turned across each junction, rad, and whether the recording holds it from entry to exit.
    ways: Vec<Option<(f64, bool)>>,
}

impl Encounters {
    /// Along the whole path, its continuations included.
    pub fn new(road: &Road, path: &DrivenPath, ego: &EgoMotion) -> Self {
        let junctions = stretches(path, |p| road.in_junction(p), MERGE_M);
        let headings = unwrap(&ego.heading);
        let ways = junctions.iter().map(|&j| turned(j, path, &headings)).collect();
        let crosswalks = stretches(path, |p| road.crosswalks.iter().any(|c| c.contains(p)), 0.0);
        Self { junctions, crosswalks, ways }
    }

    /// The junction in which the ego's centre is at `ego_s`, else the next whose distance from its front is within
    /// `reach`.
    pub fn here_or_next(&self, ego_s: f64, front: f64, reach: f64) -> Option<usize> {
        let next = self.junctions.iter().position(|j| j.to >= ego_s)?;
        (self.junctions[next].from - ego_s - front <= reach).then_some(next)
    }

    /// How the ego crosses junction `k`, if the recording shows it.
    pub fn movement(&self, k: usize) -> Option<EgoMovement> {
        self.ways[k].and_then(|(angle, whole)| movement(angle, whole))
    }
}

/// Writes `ego.in_junction`, `movement`, `turn_angle`, `map.distance_to_junction`, `distance_to_crosswalk`.
pub fn write(found: &Encounters, path: &DrivenPath, ego: &EgoMotion, table: &mut TableBuilder<'_>) {
    let n = ego.len();
    let at = |i: usize| found.junctions.iter().position(|j| j.from <= path.ego_s[i] && path.ego_s[i] <= j.to);
    let angle = |i: usize| at(i).and_then(|j| found.ways[j]).map_or(f64::NAN, |(angle, _)| angle);
    let known = |i: usize| path.ego_s[i].is_finite();
    table.flag(
        id::EGO_IN_JUNCTION,
        (0..n).map(|i| if known(i) { Tri::from(at(i).is_some()) } else { Tri::Unknown }).collect(),
    );
    table.number(id::EGO_TURN_ANGLE, (0..n).map(angle).collect());
    table.category(id::EGO_MOVEMENT, (0..n).map(|i| at(i).and_then(|j| found.movement(j))));
    let front = ego.front();
    let ahead = |x: &[Stretch]| (0..n).map(|i| distance_to_next(x, path.ego_s[i], front)).collect();
    table.number(id::MAP_DISTANCE_TO_JUNCTION, ahead(&found.junctions));
    table.number(id::MAP_DISTANCE_TO_CROSSWALK, ahead(&found.crosswalks));
}
