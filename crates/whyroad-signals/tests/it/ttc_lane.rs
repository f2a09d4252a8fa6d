//! TTC along the lane in a bend and beside the ego, by hand geometry: the lane is an arc of 60 m radius, driven
//! counter-clockwise. The ego (4 m x 2 m) goes along it with 10 m/s.
use crate::scene::{Table, add, car, drive, lane, map, near};
use std::f64::consts::PI;
use whyroad_model::{Drive, ObjectClass};

const RADIUS_M: f64 = 60.0;

/// A position `s` meters along the lane, `d` left of its center, heading along it.
fn at(s: f64, d: f64) -> (f64, f64, f64) {
    let angle = s / RADIUS_M;
    ((RADIUS_M - d) * angle.sin(), RADIUS_M - (RADIUS_M - d) * angle.cos(), angle)
}

/// The ego moves 1.6 m to the side between 1.5 and 3.5 s: it evades what is ahead.
fn out(t: f64) -> f64 {
    0.8 * (1.0 - (PI * ((t - 1.5).clamp(0.0, 2.0)) / 2.0).cos())
}

fn bend() -> Drive {
    let center: Vec<(f64, f64)> = (-30..160).map(|s| at(f64::from(s), 0.0)).map(|(x, y, _)| (x, y)).collect();
    let mut d = drive(50, |t| at(10.0 * t, out(t)));
    d.map = Some(map(vec![lane("bend", &center, 3.5)]));
    d
}

#[test]
fn it_follows_the_bend_and_not_the_way_round() {
    let mut d = bend();
    // A cyclist of 1.8 m x 0.6 m rides 40 m ahead in the lane's middle with 4 m/s.
    add(&mut d, "cyclist", ObjectClass::Bicyclist, (1.8, 0.6), |t| at(40.0 + 4.0 * t, 0.0));
    // Another keeps 1.5 m to the right: 0.2 m beside the ego's course, although in its lane.
    add(&mut d, "aside", ObjectClass::Bicyclist, (1.8, 0.6), |t| at(40.0 + 4.0 * t, -1.5));
    let t = Table::of(&d);
    assert_eq!(t.num("aside", "target.ttc_lane", 0), f64::INFINITY);
    assert!(t.num("aside", "target.ttc", 0).is_finite(), "in the lane is in path");
    // 40 m less 2 m and 0.9 m, closing with 6 m/s.
    near(t.num("cyclist", "target.ttc_lane", 0), 37.1 / 6.0, 0.05);
    near(t.num("cyclist", "target.ttc_lane", 12), (37.1 - 1.2 * 6.0) / 6.0, 0.05);
    // Boxes at constant velocity diverge in the bend.
    assert_eq!(t.num("cyclist", "target.ttc_box", 0), f64::INFINITY);
    // Out by 1.6 m its right side is 0.6 m left of the middle, beyond the cyclist's 0.3 m.
    assert_eq!(t.num("cyclist", "target.ttc_lane", 36), f64::INFINITY);
}

#[test]
fn who_is_beside_behind_or_drives_away_is_not_closed_on() {
    let mut d = bend();
    car(&mut d, "beside", |t| at(20.0 + 4.0 * t, 3.0));
    car(&mut d, "behind", |t| at(-20.0 + 10.0 * t, 0.0));
    car(&mut d, "away", |t| at(20.0 + 12.0 * t, 0.0));
    // For an oncoming target both speeds add up: 60 m less 2 m and 2 m, closing with 15 m/s.
    car(&mut d, "oncoming", |t| {
        let (x, y, heading) = at(60.0 - 5.0 * t, 0.0);
        (x, y, heading + PI)
    });
    // Crosses from 6 m right to left with 3 m/s, 20 m ahead: in 1.7 s it is 0.9 m right of the center, in the ego's
    // path by then, although not now.
    add(&mut d, "crosses", ObjectClass::Pedestrian, (0.6, 0.6), |t| {
        let (x, y, heading) = at(20.0, -6.0 + 3.0 * t);
        (x, y, heading + PI / 2.0)
    });
    let t = Table::of(&d);
    for id in ["beside", "behind", "away", "crosses"] {
        assert_eq!(t.num(id, "target.ttc_lane", 0), f64::INFINITY, "{id}");
    }
    near(t.num("oncoming", "target.ttc_lane", 0), 56.0 / 15.0, 0.05);
    // At 1.9 s the pedestrian is 0.3 m right of the center and the ego's front is at 21 m, past it.
    near(t.num("crosses", "target.ttc_lane", 19), 0.0, 1e-9);
}

#[test]
fn without_a_map_it_is_not_known() {
    let mut d = bend();
    d.map = None;
    car(&mut d, "a", |t| at(20.0 + 4.0 * t, 0.0));
    assert!(Table::of(&d).0.unavailable.contains_key("target.ttc_lane"));
}
