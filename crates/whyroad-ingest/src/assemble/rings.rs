//! Roundabouts of a map that does not mark them: lanes that form a circle. A block of streets is a ring of lanes too,
//! but has straight sides and corners far from its middle; so has a loop road.

use crate::assemble::angles::wrap_angle;
use crate::assemble::geometry::{contains, distance};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{PI, TAU};
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Facility, Lane, LaneKind, Point3};

/// Longest ring, m: 64 m radius.
const LONGEST_M: f64 = 400.0;
/// Shortest ring: a mini-roundabout of 4 m radius.
const SHORTEST_M: f64 = 25.0;
/// On a stretch of a ring that turns by less than this, rad, it is straight: 10 deg.
const STRAIGHT_RAD: f64 = PI / 18.0;
/// The longest straight stretch, m, or as a share of the ring: on a circle 10 deg are 3 % of it.
const STRAIGHT_M: f64 = 12.0;
const STRAIGHT_SHARE: f64 = 0.12;
/// A ring all of which is about as far from its middle is round although it is drawn with straight pieces up to a
/// length, m: the least distance as a share of the greatest. A square has 0.71, a pentagon 0.81, a hexagon 0.87, a
/// block with sides of 30 m and corners of 10 m radius 0.80.
const ROUND_SHARE: f64 = 0.8;
const PIECE_M: f64 = 20.0;
/// Length by which the line of a ring is sampled, m.
const STEP_M: f64 = 1.0;
/// At least this many roads lead in: a turning loop at the end of a street has one.
const ARMS: usize = 2;
/// Lanes of a ring.
const MOST_LANES: usize = 40;

/// Adds the roundabouts that the lanes' connections show, and declares that there are no others.
pub(crate) fn add(map: &mut RoadMap) {
    if map.covers("roundabout") {
        return;
    }
    let rings = rings(&map.lanes);
    map.facilities.extend(rings);
    map.facilities.sort_by(|a, b| a.id.cmp(&b.id));
    map.complete_for.push("roundabout".to_owned());
    map.complete_for.sort();
}

/// Outlines of all roundabouts, stated or shown by the lanes.
pub(crate) fn outlines(map: &RoadMap) -> Vec<Vec<Point3>> {
    let stated = map.facilities.iter().filter(|f| f.kind == "roundabout").cloned();
    stated.chain(rings(&map.lanes)).map(|f| f.boundary).collect()
}

/// Areas of the roundabouts: the island and the ring's lanes. With several circulating lanes, the outermost is used.
fn rings(lanes: &[Lane]) -> Vec<Facility> {
    let index: BTreeMap<&str, usize> = lanes.iter().enumerate().map(|(i, l)| (l.id.as_str(), i)).collect();
    let rolls =
        |i: usize| matches!(lanes[i].kind, LaneKind::Vehicle | LaneKind::Bus) && lanes[i].center.len() > 1;
    let next = |i: usize| {
        lanes[i].successors.iter().filter_map(|id| index.get(id.as_str()).copied()).filter(|&j| rolls(j))
    };
    let length: Vec<f64> =
        lanes.iter().map(|l| l.center.windows(2).map(|w| distance(w[0], w[1])).sum::<f64>()).collect();
    let mut found: Vec<(f64, BTreeSet<usize>, Facility)> = Vec::new();
    for start in (0..lanes.len()).filter(|&i| rolls(i)) {
        if found.iter().any(|(_, ring, _)| ring.contains(&start)) {
            continue;
        }
        let Some(ring) = shortest_cycle(start, next, &length) else { continue };
        let members: BTreeSet<usize> = ring.iter().copied().collect();
        let enters = |i: usize| {
            let before = lanes[i].predecessors.iter().filter_map(|id| index.get(id.as_str()));
            before.filter(|p| !members.contains(p)).count()
        };
        let arms: usize = ring.iter().map(|&i| enters(i)).sum();
        let line: Vec<Point3> = ring.iter().flat_map(|&i| lanes[i].center.iter().copied()).collect();
        let Some(turned) = circle(&line) else { continue };
        if arms < ARMS {
            continue;
        }
        // Driven counter-clockwise the right edge is outside, clockwise the left one.
        let outside = |l: &Lane| if turned > 0.0 { l.right.clone() } else { l.left.clone() };
        let mut boundary: Vec<Point3> = ring
            .iter()
            .flat_map(|&i| {
                let edge = outside(&lanes[i]);
                if edge.is_empty() { lanes[i].center.clone() } else { edge }
            })
            .collect();
        boundary.extend(boundary.first().copied());
        let id =
            format!("roundabout_{}", ring.iter().map(|&i| lanes[i].id.as_str()).min().unwrap_or_default());
        let area = area(&boundary);
        found.push((area, members, Facility { id, kind: "roundabout".into(), boundary }));
    }
    // Lanes side by side in one ring give one roundabout: the largest at a location.
    found.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.2.id.cmp(&b.2.id)));
    let mut out: Vec<Facility> = Vec::new();
    for (_, _, facility) in found {
        let at = middle(&facility.boundary);
        if !out.iter().any(|o| contains(&o.boundary, at)) {
            out.push(facility);
        }
    }
    out
}

fn middle(ring: &[Point3]) -> Point3 {
    let n = ring.len().max(1) as f64;
    let (x, y) = ring.iter().fold((0.0, 0.0), |(x, y), p| (x + p.x / n, y + p.y / n));
    Point3 { x, y, z: f64::NAN }
}

fn area(ring: &[Point3]) -> f64 {
    (ring.windows(2).map(|w| w[0].x * w[1].y - w[1].x * w[0].y).sum::<f64>() / 2.0).abs()
}

/// The shortest way over connections from a lane back to it, as lanes in driving order.
fn shortest_cycle<I: Iterator<Item = usize>>(
    start: usize,
    next: impl Fn(usize) -> I,
    length: &[f64],
) -> Option<Vec<usize>> {
    let mut best: BTreeMap<usize, (f64, Option<usize>)> = BTreeMap::new();
    let mut open: Vec<(f64, usize, usize, Option<usize>)> = vec![(0.0, 0, start, None)];
    while let Some(nearest) = (0..open.len()).min_by(|&a, &b| open[a].0.total_cmp(&open[b].0)) {
        let (so_far, lanes, at, from) = open.swap_remove(nearest);
        if from.is_some() && at == start {
            let mut ring = Vec::new();
            let mut step = from;
            while let Some(lane) = step {
                ring.push(lane);
                step = if lane == start { None } else { best.get(&lane).and_then(|b| b.1) };
            }
            ring.reverse();
            return (so_far >= SHORTEST_M).then_some(ring);
        }
        if best.contains_key(&at) || lanes >= MOST_LANES {
            continue;
        }
        best.insert(at, (so_far, from));
        let reached = so_far + length[at];
        if reached > LONGEST_M {
            continue;
        }
        open.extend(next(at).map(|to| (reached, lanes + 1, to, Some(at))));
    }
    None
}

/// The angle that a closed line turns by if it is a circle, more or less: once round, and nowhere straight for long or
/// everywhere about as far from its middle.
fn circle(line: &[Point3]) -> Option<f64> {
    let points = sampled(line);
    let n = points.len();
    if n < 8 {
        return None;
    }
    let heading = |i: usize| {
        let (a, b) = (points[i % n], points[(i + 1) % n]);
        (b.y - a.y).atan2(b.x - a.x)
    };
    let turns: Vec<f64> = (0..n).map(|i| wrap_angle(heading(i + 1) - heading(i))).collect();
    let turned: f64 = turns.iter().sum();
    if (turned.abs() - TAU).abs() > 0.2 {
        return None;
    }
    let longest = STRAIGHT_M.max(STRAIGHT_SHARE * n as f64 * STEP_M);
    let straight = |i: usize| {
        let mut sum = 0.0;
        (1..n)
            .take_while(|k| {
                sum += turns[(i + k) % n] * turned.signum();
                sum < STRAIGHT_RAD
            })
            .count() as f64
            * STEP_M
    };
    let at_most = if is_round(&points) { longest.max(PIECE_M) } else { longest };
    (0..n).all(|i| straight(i) <= at_most).then_some(turned)
}

fn is_round(points: &[Point3]) -> bool {
    let center = middle(points);
    let (least, greatest) = points
        .iter()
        .map(|p| distance(center, *p))
        .fold((f64::MAX, 0.0), |(low, high), d| (low.min(d), d.max(high)));
    least >= ROUND_SHARE * greatest
}

/// Points every meter along a closed line.
fn sampled(line: &[Point3]) -> Vec<Point3> {
    let mut out = Vec::new();
    let mut left = 0.0;
    let closed = line.iter().chain(line.first());
    let all: Vec<Point3> = closed.copied().collect();
    for w in all.windows(2) {
        let length = distance(w[0], w[1]);
        while left < length {
            let t = left / length;
            let between = |a: f64, b: f64| a + t * (b - a);
            out.push(Point3 {
                x: between(w[0].x, w[1].x),
                y: between(w[0].y, w[1].y),
                z: between(w[0].z, w[1].z),
            });
            left += STEP_M;
        }
        left -= length;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lane(id: &str, points: Vec<(f64, f64)>, from: &[&str], to: &[&str]) -> Lane {
        let ids = |list: &[&str]| list.iter().map(|s| (*s).to_owned()).collect();
        Lane {
            id: id.into(),
            center: points.into_iter().map(|(x, y)| Point3 { x, y, z: 0.0 }).collect(),
            predecessors: ids(from),
            successors: ids(to),
            ..Lane::default()
        }
    }

    fn arc(radius: f64, from: f64, to: f64) -> Vec<(f64, f64)> {
        (0..=10)
            .map(|i| (from + (to - from) * f64::from(i) / 10.0).to_radians())
            .map(|a| (radius * a.cos(), radius * a.sin()))
            .collect()
    }

    fn map(lanes: Vec<Lane>) -> RoadMap {
        let mut map = RoadMap { lanes, ..RoadMap::default() };
        map.lanes.sort_by(|a, b| a.id.cmp(&b.id));
        map
    }

    /// Two half circles, each with a road in and a road out.
    fn roundabout(radius: f64) -> RoadMap {
        map(vec![
            lane("a", arc(radius, 0.0, 180.0), &["b", "in1"], &["b", "out1"]),
            lane("b", arc(radius, 180.0, 360.0), &["a", "in2"], &["a", "out2"]),
            lane("in1", vec![(60.0 + radius, 0.0), (radius, 0.0)], &[], &["a"]),
            lane("out1", vec![(-radius, 0.0), (-radius - 60.0, 0.0)], &["a"], &[]),
            lane("in2", vec![(-radius - 60.0, 5.0), (-radius, 0.0)], &[], &["b"]),
            lane("out2", vec![(radius, 0.0), (radius + 60.0, 5.0)], &["b"], &[]),
        ])
    }

    #[test]
    fn lanes_that_lead_round_in_a_circle_are_a_roundabout() {
        for radius in [8.0, 20.0, 50.0] {
            let mut map = roundabout(radius);
            add(&mut map);
            let [ring] = &map.facilities[..] else { panic!("radius {radius}: {:?}", map.facilities) };
            assert_eq!((ring.id.as_str(), ring.kind.as_str()), ("roundabout_a", "roundabout"));
            let expected = PI * radius * radius;
            assert!((area(&ring.boundary) - expected).abs() < 0.05 * expected);
            assert!(map.tells_all("roundabout"));
        }
    }

    /// A closed way with straight sides, in two halves, each with a road in and a road out.
    fn polygon(corners: usize, radius: f64) -> RoadMap {
        let corner = |i: usize| {
            let a = TAU * i as f64 / corners as f64;
            (radius * a.cos(), radius * a.sin())
        };
        let half = corners / 2;
        let mut map = roundabout(radius);
        let points = |from: usize, to: usize| {
            (from..=to).map(corner).map(|(x, y)| Point3 { x, y, z: 0.0 }).collect::<Vec<_>>()
        };
        map.lanes[0].center = points(0, half);
        map.lanes[1].center = points(half, corners);
        map
    }

    /// Lanes drawn with a few points: INTERACTION's map of a roundabout of 16.5 m radius has straight pieces of 18 m.
    #[test]
    fn straight_sides_that_keep_their_distance_from_the_middle_are_a_roundabout() {
        for (corners, is_one) in [(4, false), (6, true), (8, true)] {
            let mut map = polygon(corners, 18.0);
            add(&mut map);
            assert_eq!(!map.facilities.is_empty(), is_one, "{corners} corners");
        }
    }

    #[test]
    fn a_block_of_streets_is_none() {
        // Sides and the radius of the corners, m; entered from two streets.
        for (side, radius) in [(30.0, 8.0), (30.0, 10.0), (24.0, 8.0)] {
            let corner = |x: f64, y: f64, from: f64| {
                arc(radius, from, from + 90.0).into_iter().map(|(a, b)| (x + a, y + b)).collect::<Vec<_>>()
            };
            let mut points = corner(side, 0.0, -90.0);
            points.extend(corner(side, side, 0.0));
            points.extend(corner(0.0, side, 90.0));
            points.extend(corner(0.0, 0.0, 180.0));
            let (half, rest) = points.split_at(22);
            let mut second = vec![half[21]];
            second.extend(rest);
            second.push(half[0]);
            let mut map = map(vec![
                lane("a", half.to_vec(), &["b", "in1"], &["b"]),
                lane("b", second, &["a", "in2"], &["a"]),
                lane("in1", vec![(-60.0, -radius), (side, -radius)], &[], &["a"]),
                lane("in2", vec![(90.0, side + radius), (0.0, side + radius)], &[], &["b"]),
            ]);
            add(&mut map);
            assert!(map.facilities.is_empty(), "{side} m, {radius} m");
            assert!(map.tells_all("roundabout"), "it is known that there is none");
        }
    }

    #[test]
    fn a_turning_loop_at_the_end_of_a_street_is_none() {
        let mut map = roundabout(10.0);
        map.lanes.retain(|l| l.id != "in2");
        add(&mut map);
        assert!(map.facilities.is_empty());
    }
}
