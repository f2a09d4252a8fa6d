//! Crosswalks that are drawn as painted lines (`type=pedestrian_marking`) and not as lanelets: two lines beside each
//! other bound one. INTERACTION's maps draw them so.

use super::document::{Document, MemberKind};
use super::ground::Ground;
use crate::assemble::geometry::{between, contains, distance, edges_oppose, length};
use crate::maps::MapReading;
use std::collections::BTreeSet;
use std::f64::consts::PI;
use whyroad_model::road_map::{Area, Point3};

/// Distance of the two lines of a crosswalk, m.
const WIDTH_M: std::ops::RangeInclusive<f64> = 1.2..=8.0;
/// Shortest line, m.
const SHORTEST_M: f64 = 2.0;
/// Lines that differ more in direction, rad, are not those of one crosswalk: 20 deg.
const PARALLEL_RAD: f64 = PI / 9.0;
/// The lines lie beside each other along this share of the shorter one, at least.
const BESIDE_SHARE: f64 = 0.6;
/// More lines are not compared with each other.
const MAX_LINES: usize = 2000;

/// Adds the crosswalks between lines that no crosswalk lanelet has.
pub(super) fn add(document: &Document, ground: &mut Ground, out: &mut MapReading) {
    let of_lanelets: BTreeSet<i64> = document
        .relations
        .values()
        .filter(|r| r.tag("type") == "lanelet" && r.tag("subtype") == "crosswalk")
        .flat_map(|r| r.members.iter().filter(|m| m.kind == MemberKind::Way).map(|m| m.id))
        .collect();
    let drawn = document
        .ways
        .iter()
        .filter(|(id, w)| w.tag("type") == "pedestrian_marking" && !of_lanelets.contains(id));
    let mut lines: Vec<(i64, Vec<Point3>)> = Vec::new();
    for (id, way) in drawn.take(MAX_LINES) {
        if let Some(line) = ground.line(&way.nodes).filter(|l| length(l) >= SHORTEST_M) {
            lines.push((*id, line));
        }
    }
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for j in 1..lines.len() {
        pairs.extend((0..j).filter_map(|i| Some((width(&lines[i].1, &lines[j].1)?, i, j))));
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut used = BTreeSet::new();
    for (_, i, j) in pairs {
        if used.contains(&i) || used.contains(&j) {
            continue;
        }
        let ((a, left), (b, right)) = (&lines[i], &lines[j]);
        let mut right = right.clone();
        if edges_oppose(left, &right) {
            right.reverse();
        }
        let boundary = between(left, &right);
        let [p, q] = [left, &right].map(|l| l[l.len() / 2]);
        let middle = Point3 { x: (p.x + q.x) / 2.0, y: (p.y + q.y) / 2.0, z: f64::NAN };
        used.extend([i, j]);
        if !out.map.crosswalks.iter().any(|c| contains(&c.boundary, middle)) {
            out.map.crosswalks.push(Area { id: format!("crosswalk_{a}_{b}"), boundary });
        }
    }
}

/// Distance between two lines, m, if they can be the two of one crosswalk.
fn width(a: &[Point3], b: &[Point3]) -> Option<f64> {
    let chord = |line: &[Point3]| {
        let (first, last) = (line[0], line[line.len() - 1]);
        let d = distance(first, last);
        (d > 0.0).then(|| (first, (last.x - first.x) / d, (last.y - first.y) / d, d))
    };
    let ((origin, ux, uy, long), (_, vx, vy, other)) = (chord(a)?, chord(b)?);
    if (ux * vy - uy * vx).abs() > PARALLEL_RAD.sin() {
        return None;
    }
    let along = |p: &Point3| (p.x - origin.x) * ux + (p.y - origin.y) * uy;
    let across = |p: &Point3| (p.y - origin.y) * ux - (p.x - origin.x) * uy;
    let [from, to] = [&b[0], &b[b.len() - 1]];
    let (low, high) = (along(from).min(along(to)), along(from).max(along(to)));
    let overlap = high.min(long) - low.max(0.0);
    let apart = ((across(from) + across(to)) / 2.0).abs();
    (overlap >= BESIDE_SHARE * long.min(other) && WIDTH_M.contains(&apart)).then_some(apart)
}
