//! Areas of roundabouts: the island, the ring, and the mouths of its arms up to their give-way lines, where a road's
//! lanes end or begin. That is where a car enters the roundabout and leaves it; the ring's own outer edge lies up to a
//! car's length further in.

use super::edge::Edge;
use std::collections::BTreeMap;
use whyroad_model::road_map::{Facility, Lane, Point3};

/// The area of the roundabout whose ring has these edges. Named by its first edge in alphabetical order.
pub(super) fn area(
    ring: &[String],
    edges: &BTreeMap<String, Edge>,
    lanes: &BTreeMap<String, Lane>,
    nodes: &BTreeMap<String, Vec<Point3>>,
) -> Option<Facility> {
    // In driving order: each edge begins where the one before ends.
    let mut left: Vec<&String> = ring.iter().filter(|id| edges.contains_key(*id)).collect();
    left.sort();
    let name = left.first()?.to_string();
    let mut order = vec![left.remove(0)];
    while let Some(i) = left.iter().position(|id| edges[*id].from == edges[order[order.len() - 1]].to) {
        order.push(left.remove(i));
    }
    let outer: Vec<&Lane> = order.iter().filter_map(|id| lanes.get(edges[*id].lanes.first()?)).collect();
    let center: Vec<Point3> = outer.iter().flat_map(|l| l.center.iter().copied()).collect();
    let next = center.iter().cycle().skip(1);
    let doubled_area: f64 = center.iter().zip(next).map(|(a, b)| a.x * b.y - b.x * a.y).sum();
    let n = center.len() as f64;
    let middle = (center.iter().map(|p| p.x).sum::<f64>() / n, center.iter().map(|p| p.y).sum::<f64>() / n);
    let mut boundary: Vec<Point3> = Vec::new();
    for id in &order {
        let edge = &edges[*id];
        // Driven counter-clockwise the right edge is outside, clockwise (left-hand traffic) the left one. Where traffic
        // drives on the left, lanes are counted from the left: the first is the outer one either way.
        let away = |l: &&Lane| {
            let far = l.center.iter().map(|p| (p.x - middle.0).hypot(p.y - middle.1)).sum::<f64>();
            far / l.center.len().max(1) as f64
        };
        let ends = [edge.lanes.first(), edge.lanes.last()].into_iter().flatten().filter_map(|l| lanes.get(l));
        let Some(lane) = ends.max_by(|a, b| away(a).total_cmp(&away(b))) else { continue };
        let side = if doubled_area > 0.0 { &lane.right } else { &lane.left };
        if let (Some(from), Some(to), Some(shape)) = (boundary.last(), side.first(), nodes.get(&edge.from)) {
            boundary.extend(mouth(shape, *from, *to, middle));
        }
        boundary.extend(side.iter().copied());
    }
    let (from, to) = (*boundary.last()?, *boundary.first()?);
    if let Some(shape) = nodes.get(&edges[order[0]].from) {
        boundary.extend(mouth(shape, from, to, middle));
    }
    boundary.push(to);
    (boundary.len() >= 4).then(|| Facility {
        id: format!("roundabout_{name}"),
        kind: "roundabout".into(),
        boundary,
    })
}

/// The outline of a node from its corner nearest `from` to that nearest `to`, along the outer side.
fn mouth(shape: &[Point3], from: Point3, to: Point3, middle: (f64, f64)) -> Vec<Point3> {
    let corner = |p: Point3| {
        let away = |q: &Point3| (q.x - p.x).hypot(q.y - p.y);
        (0..shape.len()).min_by(|&a, &b| away(&shape[a]).total_cmp(&away(&shape[b])))
    };
    let (Some(a), Some(b)) = (corner(from), corner(to)) else { return Vec::new() };
    let n = shape.len();
    let walk = |step: usize| -> Vec<Point3> {
        let steps = if step == 1 { (b + n - a) % n } else { (a + n - b) % n };
        (0..=steps).map(|k| shape[(a + k * step) % n]).collect()
    };
    let out = |way: &[Point3]| {
        way.iter().map(|p| (p.x - middle.0).hypot(p.y - middle.1)).sum::<f64>() / way.len() as f64
    };
    let (one, other) = (walk(1), walk(n - 1));
    if out(&one) >= out(&other) { one } else { other }
}
