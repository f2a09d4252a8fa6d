//! Lanes of different arms that meet or part without crossing another: slip lanes, corners of streets, mouths of
//! accesses. One of the two bends tightly beside the place where they meet, while the other leads elsewhere.
//!
//! What is no junction: lanes that bend together (a lane that ends or is added in a bend), ramps (their bends are wide,
//! or end far from the merge), and the entries and exits of roundabouts.

use crate::assemble::angles::wrap_angle;
use crate::assemble::geometry::{contains, distance, length, resample};
use crate::assemble::rings;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Lane, Point3};

/// Arms differ by this at least, and so much does a lane bend, rad: 45 deg, as for a turn.
const TURN_RAD: f64 = PI / 4.0;
/// Maximum mean radius of such a bend, m: slip lanes have 20 to 35 m, loops of motorway ramps 45 m and more.
const RADIUS_M: f64 = 40.0;
/// At a place with a greater radius there is no bend, m.
const STRAIGHT_RADIUS_M: f64 = 60.0;
/// Maximum length of the lane between the bend and the place where the lanes meet, m: from a ramp's bend to the road
/// there is an acceleration lane.
const STRAIGHT_M: f64 = 15.0;
/// Lanes are followed for this distance from the place, m: a quarter of the widest circle and what is between.
const REACH_M: f64 = 80.0;
/// Spacing of the places on a lane, and half the length over which a course is taken, m.
const STEP_M: f64 = 1.0;
const COURSE_STEPS: usize = 2;
/// Parts of a bend with at most this between them are one, in steps.
const GAP: usize = 3;
/// A lane is inside if the bend, with what is between it and the place, is at least this share of it.
const OWN_SHARE: f64 = 0.5;
/// Maximum length of the other lane for it to be inside as well, m.
const OTHER_LANE_M: f64 = 40.0;
/// Lanes that meet this near to the outline of a roundabout enter or leave it, m.
const AT_RING_M: f64 = 6.0;
/// Lanes with these tags belong to grade-separated roads.
const RAMPS: [&str; 3] = ["ramp", "acceleration", "deceleration"];

/// A way from the place where lanes meet, along one of them and on: the lane of each step, and the course there, rad.
struct Way {
    lanes: Vec<usize>,
    courses: Vec<f64>,
}

/// Lanes inside junctions of this kind. `may`: lanes that can be inside one.
pub(crate) fn inside(map: &RoadMap, may: &[bool]) -> BTreeSet<usize> {
    let lanes = &map.lanes;
    let index: BTreeMap<&str, usize> = lanes.iter().enumerate().map(|(i, l)| (l.id.as_str(), i)).collect();
    let rings = rings::outlines(map);
    let mut found = BTreeSet::new();
    for joint in 0..lanes.len() {
        // Against the direction of driving from where lanes merge, along it from where they part.
        for against in [true, false] {
            let arms = linked(lanes, &index, joint, against);
            let place = if against { lanes[joint].center.first() } else { lanes[joint].center.last() };
            let Some(&place) = place else { continue };
            let passable =
                |&i: &usize| lanes[i].kind.is_driven_on() && !RAMPS.iter().any(|t| lanes[i].is_tagged(t));
            if arms.len() < 2 || !arms.iter().all(passable) || rings.iter().any(|ring| is_at(ring, place)) {
                continue;
            }
            let ways: Vec<Way> = arms.iter().map(|&arm| way(lanes, &index, arm, against)).collect();
            for (a, one) in ways.iter().enumerate() {
                let Some(end) = bend(one) else { continue };
                let parts = |other: &Way| {
                    let there = other.courses[end.min(other.courses.len() - 1)];
                    wrap_angle(one.courses[end] - there).abs() >= TURN_RAD
                };
                let others: Vec<usize> = (0..ways.len()).filter(|&b| b != a && parts(&ways[b])).collect();
                if others.is_empty() {
                    continue;
                }
                let own = one.lanes[..=end].iter().copied().collect::<BTreeSet<_>>();
                let covered =
                    |i: usize| one.lanes[..=end].iter().filter(|&&l| l == i).count() as f64 * STEP_M;
                found.extend(
                    own.into_iter().filter(|&i| may[i] && covered(i) >= OWN_SHARE * length(&lanes[i].center)),
                );
                let short = |i: &usize| may[*i] && length(&lanes[*i].center) <= OTHER_LANE_M;
                found.extend(others.into_iter().map(|b| arms[b]).filter(short));
            }
        }
    }
    found
}

/// The lanes that lead to a lane (`against` the direction of driving) or on from it.
fn linked(lanes: &[Lane], index: &BTreeMap<&str, usize>, lane: usize, against: bool) -> Vec<usize> {
    let ids = if against { &lanes[lane].predecessors } else { &lanes[lane].successors };
    let found: BTreeSet<usize> = ids.iter().filter_map(|id| index.get(id.as_str()).copied()).collect();
    found.into_iter().filter(|&i| i != lane && lanes[i].center.len() > 1).collect()
}

fn is_at(ring: &[Point3], place: Point3) -> bool {
    contains(ring, place) || ring.iter().any(|p| distance(*p, place) <= AT_RING_M)
}

/// The way from the end of `lane` (its start, if not `against`) along it, and on as long as one lane only follows.
fn way(lanes: &[Lane], index: &BTreeMap<&str, usize>, lane: usize, against: bool) -> Way {
    let (mut points, mut on): (Vec<Point3>, Vec<usize>) = (Vec::new(), Vec::new());
    let (mut at, mut passed) = (lane, BTreeSet::new());
    while passed.insert(at) && (points.len() as f64) * STEP_M < REACH_M {
        let center = &lanes[at].center;
        let count = (length(center) / STEP_M).round().max(1.0) as usize + 1;
        let mut steps = resample(center, count);
        if against {
            steps.reverse();
        }
        // The first point is the last one of the lane before.
        let new = steps.into_iter().skip(usize::from(!points.is_empty()));
        points.extend(new);
        on.resize(points.len(), at);
        match linked(lanes, index, at, against)[..] {
            [next] => at = next,
            _ => break,
        }
    }
    let last = points.len() - 1;
    let courses = (0..points.len())
        .map(|i| {
            let (a, b) = (points[i.saturating_sub(COURSE_STEPS)], points[(i + COURSE_STEPS).min(last)]);
            (b.y - a.y).atan2(b.x - a.x)
        })
        .collect();
    Way { lanes: on, courses }
}

/// The step at which a bend of the way ends, seen from the place where the lanes meet: to one side by [`TURN_RAD`].
fn bend(way: &Way) -> Option<usize> {
    let courses = &way.courses;
    let last = courses.len() - 1;
    let curvature = |i: usize| {
        let (a, b) = (i.saturating_sub(COURSE_STEPS), (i + COURSE_STEPS).min(last));
        wrap_angle(courses[b] - courses[a]) / ((b - a).max(1) as f64 * STEP_M)
    };
    let turned = |from: usize, to: usize| {
        let angle = (from..to).map(|i| wrap_angle(courses[i + 1] - courses[i])).sum::<f64>().abs();
        angle >= TURN_RAD && angle >= (to - from) as f64 * STEP_M / RADIUS_M
    };
    let mut open: Option<(usize, usize, f64)> = None;
    for i in 0..=last {
        let k = curvature(i);
        if k.abs() < 1.0 / STRAIGHT_RADIUS_M {
            continue;
        }
        open = match open {
            Some((from, to, side)) if side == k.signum() && i - to <= GAP => Some((from, i, side)),
            Some((from, to, _)) if turned(from, to) => return Some(to),
            _ if i as f64 * STEP_M <= STRAIGHT_M => Some((i, i, k.signum())),
            _ => return None,
        };
    }
    open.filter(|&(from, to, _)| turned(from, to)).map(|(_, to, _)| to)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assemble::layers::{declare, derive_absent};

    fn line(id: &str, points: impl IntoIterator<Item = (f64, f64)>) -> Lane {
        let center = points.into_iter().map(|(x, y)| Point3 { x, y, z: 0.0 }).collect();
        Lane { id: id.into(), center, ..Lane::default() }
    }

    /// A quarter of a circle of this radius that comes from the north and ends at (0, 0), eastwards: a left turn.
    fn quarter(radius: f64) -> Vec<(f64, f64)> {
        let at = |k: usize| PI + PI / 2.0 * k as f64 / 30.0;
        (0..=30).map(|k| (radius * at(k).cos(), radius + radius * at(k).sin())).collect()
    }

    /// A road to the east, and a lane from the north that leads into it at (0, 0) after a straight of this length;
    /// `mirrored` for traffic on the other side of the road.
    fn slip(radius: f64, straight: f64, mirrored: bool) -> Vec<String> {
        let corner = quarter(radius);
        let (x, y) = corner[0];
        let mut lanes = vec![
            line("a_in", [(-100.0, 0.0), (-30.0, 0.0)]),
            line("a_on", [(-30.0, 0.0), (0.0, 0.0)]),
            line("a_out", [(0.0, 0.0), (100.0, 0.0)]),
            line("b_in", [(x - straight, y + 60.0), (x - straight, y)]),
            line("b_turn", corner.into_iter().map(|(x, y)| (x - straight, y))),
        ];
        if straight > 0.0 {
            lanes.push(line("b_run", [(-straight, 0.0), (0.0, 0.0)]));
        }
        lanes.sort_by(|a, b| a.id.cmp(&b.id));
        if mirrored {
            lanes.iter_mut().flat_map(|l| &mut l.center).for_each(|p| p.y = -p.y);
        }
        let mut map = RoadMap { lanes, ..RoadMap::default() };
        declare(&mut map, &[]);
        derive_absent(&mut map);
        map.lanes.iter().filter(|l| l.in_junction).map(|l| l.id.clone()).collect()
    }

    #[test]
    fn a_slip_lane_that_leads_into_a_road_of_another_arm_is_inside_a_junction() {
        assert_eq!(slip(25.0, 0.0, false), ["a_on", "b_turn"]);
        assert_eq!(slip(25.0, 0.0, true), ["a_on", "b_turn"]);
        assert_eq!(slip(25.0, 12.0, false), ["a_on", "b_run", "b_turn"]);
    }

    #[test]
    fn ramps_are_no_junctions() {
        // RAL: loop ramps of 30 m radius are the least and have an acceleration lane; AASHTO has 47 m at 40 km/h.
        assert_eq!(slip(47.0, 0.0, false), [""; 0]);
        assert_eq!(slip(30.0, 100.0, false), [""; 0]);
    }

    #[test]
    fn a_lane_that_ends_in_a_bend_is_no_junction() {
        let outer: Vec<(f64, f64)> = quarter(25.0);
        let inner = quarter(21.5).into_iter().enumerate().map(|(k, (x, y))| {
            // Half of it runs beside the outer lane, then it comes over.
            let share = (k as f64 / 15.0 - 1.0).max(0.0);
            let (u, v) = outer[k];
            (x + (u - x) * share, y + 3.5 + (v - y - 3.5) * share)
        });
        let inner: Vec<(f64, f64)> = inner.collect();
        let lanes = vec![
            line("a_in", [(outer[0].0, 90.0), outer[0]]),
            line("a_turn", outer.clone()),
            line("b_in", [(inner[0].0, 90.0), inner[0]]),
            line("b_turn", inner),
            line("out", [(0.0, 0.0), (100.0, 0.0)]),
        ];
        let mut map = RoadMap { lanes, ..RoadMap::default() };
        declare(&mut map, &[]);
        derive_absent(&mut map);
        assert_eq!(map.lane("b_turn").unwrap().successors, ["out"]);
        assert!(map.lanes.iter().all(|l| !l.in_junction), "{:?}", map.junctions);
    }

    #[test]
    fn a_way_that_turns_off_a_road_is_inside_a_junction() {
        let off = quarter(10.0).into_iter().map(|(x, y)| (-x, -y));
        let mut off: Vec<(f64, f64)> = off.collect();
        off.reverse();
        let lanes = vec![
            line("in", [(-100.0, 0.0), (0.0, 0.0)]),
            line("off", off),
            line("off_on", [(10.0, -10.0), (10.0, -60.0)]),
            line("on", [(0.0, 0.0), (20.0, 0.0)]),
            line("out", [(20.0, 0.0), (120.0, 0.0)]),
        ];
        let mut map = RoadMap { lanes, ..RoadMap::default() };
        declare(&mut map, &[]);
        derive_absent(&mut map);
        let inside: Vec<&str> = map.lanes.iter().filter(|l| l.in_junction).map(|l| l.id.as_str()).collect();
        assert_eq!(inside, ["off", "on"]);
    }
}
