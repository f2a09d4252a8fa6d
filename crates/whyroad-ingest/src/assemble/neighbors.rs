//! Lanes beside each other, from center lines: for maps that do not state them. How wide the lanes are does not follow:
//! lines that run together or part are nearer than that.

use crate::assemble::angles::wrap_angle;
use crate::assemble::geometry::{Bounds, length, resample};
use std::f64::consts::PI;
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Lane, Point3, STRAIGHT_OVER_RAD};

/// Places of a lane at which others are looked for are this far apart, m.
const SPACING_M: f64 = 4.0;
/// Distance between the center lines of neighbors, m: of the narrowest lanes, and of the widest beside another's edge.
const BESIDE_M: std::ops::RangeInclusive<f64> = 2.3..=5.0;
/// Neighbors are parallel within this, rad (20 deg), or opposite within it.
const PARALLEL_RAD: f64 = PI / 9.0;
/// Neighbors run beside each other for at least this share of the stretch along which both exist, and for at least
/// this, m: a lane that branches off is beside the other only at first.
const BESIDE_SHARE: f64 = 0.6;
const LEAST_M: f64 = 12.0;
/// Lanes whose heights differ by more pass over each other, m.
const LEVEL_M: f64 = 2.5;

/// Fills in the neighbors of all lanes but those that turn inside junctions. False if there is no lane that could have
/// any.
pub(crate) fn derive(map: &mut RoadMap) -> bool {
    let lines: Vec<Option<Line>> = map.lanes.iter().map(line).collect();
    let name = |j: usize| map.lanes[j].id.clone();
    let found: Vec<Option<[Option<String>; 2]>> =
        lines.iter().map(|own| Some(nearest(own.as_ref()?, &lines).map(|side| side.map(name)))).collect();
    let any = found.iter().any(Option::is_some);
    for (lane, sides) in map.lanes.iter_mut().zip(found) {
        if let Some(sides) = sides {
            [lane.left_neighbor, lane.right_neighbor] = sides;
        }
    }
    any
}

/// The nearest of the lines to the left and to the right of `own`.
fn nearest(own: &Line, others: &[Option<Line>]) -> [Option<usize>; 2] {
    let mut sides: [Option<(usize, f64)>; 2] = [None, None];
    for (j, other) in others.iter().enumerate() {
        let Some(other) = other else { continue };
        if std::ptr::eq(own, other) || own.bounds.are_apart(&other.bounds, *BESIDE_M.end()) {
            continue;
        }
        let Some(lateral) = beside(own, other) else { continue };
        let side = &mut sides[usize::from(lateral < 0.0)];
        if side.is_none_or(|(_, before)| lateral.abs() < before) {
            *side = Some((j, lateral.abs()));
        }
    }
    sides.map(|side| side.map(|(j, _)| j))
}

/// A center line.
struct Line<'a> {
    center: &'a [Point3],
    places: Vec<Place>,
    bounds: Bounds,
}

/// A point of a line and its direction there, rad.
struct Place {
    at: Point3,
    heading: f64,
}

fn line(lane: &Lane) -> Option<Line<'_>> {
    let total = length(&lane.center);
    if !lane.kind.is_driven_on() || lane.center.len() < 2 || total < LEAST_M {
        return None;
    }
    let points = resample(&lane.center, (total / SPACING_M).ceil() as usize + 1);
    let places = (0..points.len())
        .map(|i| {
            let (a, b) = (points[i.saturating_sub(1)], points[(i + 1).min(points.len() - 1)]);
            Place { at: points[i], heading: (b.y - a.y).atan2(b.x - a.x) }
        })
        .collect::<Vec<Place>>();
    let turn = wrap_angle(places.last()?.heading - places.first()?.heading);
    let turns = lane.in_junction && turn.abs() >= STRAIGHT_OVER_RAD;
    (!turns).then(|| Line { center: &lane.center, places, bounds: Bounds::of(&lane.center) })
}

impl Line<'_> {
    /// Distance of a place from this line, to the left of the place positive, m, and the line's direction there, rad;
    /// `None` before the line's start and behind its end.
    fn distance_at(&self, place: &Place) -> Option<(f64, f64)> {
        let (sin, cos) = place.heading.sin_cos();
        let found = self.center.windows(2).filter_map(|w| {
            // In the frame of the place: x along its direction, y to its left.
            let local = |p: Point3| {
                let (dx, dy) = (p.x - place.at.x, p.y - place.at.y);
                (dx * cos + dy * sin, dy * cos - dx * sin)
            };
            let ((ax, ay), (bx, by)) = (local(w[0]), local(w[1]));
            if (ax > 0.0) == (bx > 0.0) {
                return None;
            }
            let level = (w[0].z - place.at.z).abs();
            let lateral = ay + (by - ay) * (-ax / (bx - ax));
            (level.is_nan() || level <= LEVEL_M).then(|| (lateral, (w[1].y - w[0].y).atan2(w[1].x - w[0].x)))
        });
        found.min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
    }
}

/// How far `other` runs beside `own`, to the left positive, m; `None` if it does not.
fn beside(own: &Line, other: &Line) -> Option<f64> {
    let seen: Vec<(f64, f64)> = (own.places.iter())
        .filter_map(|place| {
            let (lateral, heading) = other.distance_at(place)?;
            let turned = wrap_angle(heading - place.heading).abs();
            Some((lateral, turned.min(PI - turned)))
        })
        .collect();
    let mut parallel: Vec<f64> = (seen.iter())
        .filter(|(lateral, turned)| BESIDE_M.contains(&lateral.abs()) && *turned <= PARALLEL_RAD)
        .map(|(lateral, _)| *lateral)
        .collect();
    // A line that comes from, or goes far to the side is compared where it is in reach only.
    let near = seen.iter().filter(|(lateral, _)| lateral.abs() <= 2.0 * BESIDE_M.end()).count();
    let long = parallel.len() as f64 * SPACING_M >= LEAST_M;
    if !long || (parallel.len() as f64) < BESIDE_SHARE * near as f64 {
        return None;
    }
    parallel.sort_by(f64::total_cmp);
    Some(parallel[parallel.len() / 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lane(id: &str, points: &[(f64, f64)]) -> Lane {
        let center = points.iter().map(|&(x, y)| Point3 { x, y, z: 0.0 }).collect();
        Lane { id: id.into(), center, ..Lane::default() }
    }

    fn neighbors(map: &RoadMap, id: &str) -> [Option<String>; 2] {
        let lane = map.lanes.iter().find(|lane| lane.id == id).unwrap();
        [lane.left_neighbor.clone(), lane.right_neighbor.clone()]
    }

    fn some(id: &str) -> Option<String> {
        Some(id.to_owned())
    }

    #[test]
    fn parallel_lanes_are_neighbors() {
        let mut map = RoadMap {
            lanes: vec![
                lane("a", &[(0.0, 0.0), (60.0, 0.0)]),
                lane("b", &[(0.0, 3.4), (60.0, 3.4)]),
                lane("oncoming", &[(60.0, 7.2), (0.0, 7.2)]),
                lane("across a median", &[(60.0, 16.0), (0.0, 16.0)]),
                lane("alone", &[(0.0, -90.0), (60.0, -90.0)]),
            ],
            ..RoadMap::default()
        };
        assert!(derive(&mut map));
        assert_eq!(neighbors(&map, "a"), [some("b"), None]);
        assert_eq!(neighbors(&map, "b"), [some("oncoming"), some("a")]);
        // Seen in its own direction, the lane against which it runs is to its left.
        assert_eq!(neighbors(&map, "oncoming"), [some("b"), None]);
        assert_eq!(neighbors(&map, "across a median"), [None, None]);
        assert_eq!(neighbors(&map, "alone"), [None, None]);
    }

    #[test]
    fn lanes_that_cross_branch_off_or_pass_over_are_no_neighbors() {
        let mut over = lane("over", &[(0.0, 3.5), (60.0, 3.5)]);
        over.center.iter_mut().for_each(|p| p.z = 6.0);
        let mut map = RoadMap {
            lanes: vec![
                lane("main", &[(0.0, 0.0), (60.0, 0.0)]),
                // 1 m to the side on every 2 m: beside the main lane for 5 m only.
                lane("exit", &[(0.0, 0.0), (60.0, -30.0)]),
                lane("cross", &[(30.0, -40.0), (30.0, 40.0)]),
                over,
            ],
            ..RoadMap::default()
        };
        assert!(derive(&mut map));
        assert!(map.lanes.iter().all(|l| l.left_neighbor.is_none() && l.right_neighbor.is_none()));
    }

    #[test]
    fn inside_a_junction_only_lanes_straight_over_it_are_neighbors() {
        // Both turning lanes are quarters of circles about (0, 30), 3.5 m apart.
        let arc = |radius: f64| -> Vec<(f64, f64)> {
            (0..=9)
                .map(|i| f64::from(i * 10).to_radians())
                .map(|a| (radius * a.sin(), 30.0 - radius * a.cos()))
                .collect()
        };
        let mut map = RoadMap {
            lanes: vec![
                lane("left over it", &[(0.0, 3.5), (20.0, 3.5)]),
                lane("right over it", &[(0.0, 0.0), (20.0, 0.0)]),
                lane("inner turn", &arc(20.0)),
                lane("outer turn", &arc(23.5)),
            ],
            ..RoadMap::default()
        };
        map.lanes.iter_mut().for_each(|lane| lane.in_junction = true);
        assert!(derive(&mut map));
        assert_eq!(neighbors(&map, "right over it"), [some("left over it"), None]);
        assert_eq!(neighbors(&map, "inner turn"), [None, None]);
        assert_eq!(neighbors(&map, "outer turn"), [None, None]);
    }

    #[test]
    fn a_lane_that_opens_beside_another_is_its_neighbor() {
        // A turn bay: from the lane to the side within 20 m, then parallel for 40 m.
        let mut map = RoadMap {
            lanes: vec![
                lane("main", &[(0.0, 0.0), (60.0, 0.0)]),
                lane("bay", &[(0.0, 0.0), (20.0, 3.2), (60.0, 3.2)]),
            ],
            ..RoadMap::default()
        };
        assert!(derive(&mut map));
        assert_eq!(neighbors(&map, "main"), [some("bay"), None]);
        assert_eq!(neighbors(&map, "bay"), [None, some("main")]);
    }
}
