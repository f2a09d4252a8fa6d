//! Lane assignment on hand-drawn roads.

use super::*;
use crate::geometry::p2;
use std::f64::consts::PI;
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Lane, Point3};

fn lane(id: &str, center: &[(f64, f64)], successors: &[&str]) -> Lane {
    Lane {
        id: id.into(),
        center: center.iter().map(|&(x, y)| Point3 { x, y, z: 0.0 }).collect(),
        width_m: Some(3.5),
        successors: successors.iter().map(|s| (*s).to_owned()).collect(),
        ..Lane::default()
    }
}

/// Lane a (y = 0) and its left neighbor b (y = 3.5), both to x = 50; a goes on into a junction where "left" bends
/// away and "on" goes straight, both beginning at the same place; c follows "on".
fn road() -> Road {
    let bend: Vec<(f64, f64)> = (0..=10)
        .map(|i| f64::from(i) * PI / 20.0)
        .map(|a| (50.0 + 20.0 * a.sin(), 20.0 - 20.0 * a.cos()))
        .collect();
    let mut lanes = vec![
        lane("a", &[(0.0, 0.0), (50.0, 0.0)], &["left", "on"]),
        lane("b", &[(0.0, 3.5), (50.0, 3.5)], &[]),
        lane("c", &[(70.0, 0.0), (120.0, 0.0)], &[]),
        lane("left", &bend, &[]),
        lane("on", &[(50.0, 0.0), (70.0, 0.0)], &["c"]),
    ];
    lanes[0].left_neighbor = Some("b".into());
    lanes[1].right_neighbor = Some("a".into());
    (lanes[3].in_junction, lanes[4].in_junction) = (true, true);
    Road::new(&RoadMap { lanes, ..RoadMap::default() })
}

fn ids(road: &Road, rows: &[(P2, f64, f64)]) -> Vec<String> {
    let places = assign(road, rows, Tether::VEHICLE);
    places.iter().map(|p| p.map_or("-".into(), |p| road.lanes[p.lane].id.clone())).collect()
}

fn eastward(y: impl Fn(usize) -> f64) -> Vec<(P2, f64, f64)> {
    (0..100).map(|i| (p2(i as f64, y(i)), f64::NAN, 0.0)).collect()
}

#[test]
fn straight_through_a_junction_stays_off_the_bend_that_begins_with_it() {
    let road = road();
    let found = ids(&road, &eastward(|_| 0.2));
    let mut order = found.clone();
    order.dedup();
    assert_eq!(order, ["a", "on", "c"], "{found:?}");
}

#[test]
fn a_turning_actor_is_in_the_bend_from_its_first_meter() {
    let road = road();
    let rows: Vec<(P2, f64, f64)> = (0..70)
        .map(|i| {
            let s = i as f64;
            let a = ((s - 50.0) / 20.0).max(0.0);
            let p = if s < 50.0 { p2(s, 0.0) } else { p2(50.0 + 20.0 * a.sin(), 20.0 - 20.0 * a.cos()) };
            (p, f64::NAN, a)
        })
        .collect();
    let mut order = ids(&road, &rows);
    order.dedup();
    assert_eq!(order, ["a", "left"]);
}

#[test]
fn a_short_swing_over_the_line_changes_nothing_and_a_long_stay_does() {
    let road = road();
    // The line is at 1.75: 0.15 m over it for half a second.
    let swing = ids(&road, &eastward(|i| if (20..25).contains(&i) { 1.9 } else { 1.6 })[..50]);
    assert!(swing.iter().all(|l| l == "a"), "{swing:?}");
    let change = ids(&road, &eastward(|i| if i < 20 { 0.0 } else { 3.5 })[..50]);
    assert_eq!((change[19].as_str(), change[20].as_str()), ("a", "b"));
}

#[test]
fn off_the_road_against_it_and_above_it_there_is_no_lane() {
    let road = road();
    let none = |rows: &[(P2, f64, f64)]| ids(&road, rows).iter().all(|l| l == "-");
    // The edge is at -1.75: parked 0.75 m beside it.
    assert!(none(&eastward(|_| -2.5)[..50]));
    let against: Vec<_> = eastward(|_| 0.0)[..50].iter().map(|r| (r.0, r.1, PI)).collect();
    assert!(none(&against));
    let above: Vec<_> = eastward(|_| 0.0)[..50].iter().map(|r| (r.0, 9.0, 0.0)).collect();
    assert!(none(&above));
    let lost: Vec<_> = eastward(|_| f64::NAN)[..50].to_vec();
    assert!(none(&lost));
}
