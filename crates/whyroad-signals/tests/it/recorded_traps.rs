//! Errors found on recorded drives: swerves against turns, detours against a bent lane, U-turns, turns that extend
//! beyond their junction, and post-encroachment time where paths merge. Paths are given by formulas; expected values
//! are computed in the comments.
use crate::scene::{EGO_LENGTH, Table, add, car, drive, lane, map, near};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI};
use whyroad_model::ObjectClass::Car;
use whyroad_model::Tri::{False, True};

/// Straight along x to 0, then an arc of this radius to the left by `angle`, then straight on; `s` is the way from x =
/// 0.
fn arc(s: f64, radius: f64, angle: f64) -> (f64, f64, f64) {
    if s <= 0.0 {
        return (s, 0.0, 0.0);
    }
    let turned = (s / radius).min(angle);
    let (x, y) = (radius * turned.sin(), radius * (1.0 - turned.cos()));
    let beyond = (s - radius * angle).max(0.0);
    (x + beyond * turned.cos(), y + beyond * turned.sin(), turned)
}

#[test]
fn a_swerve_comes_back_and_a_turn_does_not() {
    // 10 m/s; heading 0.2 rad between 4 and 4.5 s, then back.
    let swerve = |t: f64| {
        let h = if (4.0..4.5).contains(&t) { 0.2 } else { 0.0 };
        (10.0 * t, 2.0 * (t - 4.0).clamp(0.0, 0.5), h)
    };
    near(Table::of(&drive(100, swerve)).ego("ego.net_turn", 42), 0.0, 1e-9);
    // A left turn of 90 deg at a radius of 10 m and 5 m/s takes pi s from 4 s on: from 3.5 s to 7.5 s it is whole.
    let turn = |t: f64| arc(5.0 * (t - 4.0), 10.0, FRAC_PI_2);
    near(Table::of(&drive(100, turn)).ego("ego.net_turn", 45), FRAC_PI_2, 0.03);
    let t = Table::of(&drive(50, turn));
    assert!(t.ego("ego.net_turn", 45).is_nan(), "0.4 s are recorded after it");
}

#[test]
fn a_path_bulges_away_from_what_it_goes_round() {
    // 0.6 m to the left as a raised cosine, 15 m either side of x = 100.
    let bump = |x: f64| {
        if (x - 100.0).abs() < 15.0 { 0.3 * (1.0 + (PI * (x - 100.0) / 15.0).cos()) } else { 0.0 }
    };
    let mut d = drive(250, |t| (10.0 * t, bump(10.0 * t), 0.0));
    add(&mut d, "right", Car, (4.0, 2.0), |_| (100.0, -2.5, 0.0));
    add(&mut d, "left", Car, (4.0, 2.0), |_| (100.0, 3.0, 0.0));
    add(&mut d, "later", Car, (4.0, 2.0), |_| (180.0, -2.5, 0.0));
    let t = Table::of(&d);
    // With points 20 and 40 m away the bump is all there is.
    near(t.num("right", "target.detour", 80), 0.6, 0.03);
    // The path comes nearer to the other: at best the points 8 m away show 0.24 m of it.
    assert!(t.num("left", "target.detour", 80) < 0.0);
    near(t.num("later", "target.detour", 150), 0.0, 0.02);
    // A bend of 200 m is no detour: the remainder of its curvature is far below the 0.25 m that rules require.
    let mut d = drive(250, |t| arc(10.0 * t - 50.0, 200.0, PI));
    let (x, y, _) = arc(80.0, 197.0, PI);
    add(&mut d, "inside", Car, (4.0, 2.0), move |_| (x, y + 3.0, 0.4));
    near(Table::of(&d).num("inside", "target.detour", 110), 0.0, 0.125);
}

#[test]
fn a_u_turn_through_an_opening_of_the_median_is_one() {
    // 5 m/s along y = 0 to x = 50, half a circle of 5 m radius, back along y = 10.
    let pose = |t: f64| {
        let (x, y, h) = arc(5.0 * t - 50.0, 5.0, PI);
        (x + 50.0, y, h)
    };
    let mut d = drive(250, pose);
    d.map = Some(map(vec![
        lane("east", &[(-50.0, 0.0), (40.0, 0.0), (200.0, 0.0)], 3.5),
        lane("west", &[(200.0, 10.0), (40.0, 10.0), (-50.0, 10.0)], 3.5),
    ]));
    let t = Table::of(&d);
    // Half way round after 10 s and half of 3.1 s.
    assert_eq!(t.ego_category("ego.movement", 115), Some("uturn"));
    assert_eq!(t.ego_flag("ego.in_junction", 115), True);
    assert_eq!(t.ego_flag("ego.in_junction", 60), False);
    // Where the lane itself makes the turn, it is a hairpin.
    let fine: Vec<(f64, f64)> = (0..=120)
        .map(|i| {
            let (x, y, _) = arc(f64::from(i) - 60.0, 5.0, PI);
            (x + 50.0, y)
        })
        .collect();
    d.map = Some(map(vec![lane("hairpin", &fine, 3.5)]));
    assert_eq!(Table::of(&d).ego_flag("ego.in_junction", 115), False);
}

#[test]
fn a_turn_that_goes_on_behind_its_junction_counts_whole() {
    // 60 deg at a radius of 15 m are 15.7 m of way, of which the junction holds 6 m: 23 deg.
    let place = |s: f64| {
        let (x, y, _) = arc(s, 15.0, FRAC_PI_3);
        (x, y)
    };
    let line = |from: f64, to: f64| -> Vec<(f64, f64)> {
        let steps = (to - from).round() as i32;
        (0..=steps).map(|i| place(from + f64::from(i))).collect()
    };
    let mut d = drive(200, |t| arc(5.0 * t - 40.0, 15.0, FRAC_PI_3));
    let mut inside = lane("b", &line(0.0, 6.0), 3.5);
    inside.in_junction = true;
    d.map = Some(map(vec![lane("a", &line(-60.0, 0.0), 3.5), inside, lane("c", &line(6.0, 70.0), 3.5)]));
    let t = Table::of(&d);
    // In the junction from 8 to 9.2 s.
    assert_eq!(t.ego_category("ego.movement", 85), Some("left"));
    near(t.ego("ego.turn_angle", 85), FRAC_PI_3, 0.1);
}

#[test]
fn where_ways_join_the_time_between_the_boxes_counts() {
    // The other comes up from the south, turns into the ego's road at x = 0 after 2 s and drives on at 10 m/s; the ego
    // passes x = 0 after 7.9 s at 10 m/s. At any place its front is there 5.9 s less half of both lengths after the
    // other's center, so after its rear has left: 5.9 s - (4.0 m + ego's length) / 2 / 10 m/s.
    let mut d = drive(160, |t| (10.0 * t - 79.0, 0.0, 0.0));
    car(&mut d, "other", |t| {
        let s = 10.0 * (t - 2.0);
        if s < 0.0 { (0.0, s, FRAC_PI_2) } else { (s, 0.0, 0.0) }
    });
    let t = Table::of(&d);
    near(t.num("other", "target.pet", 80), 5.9 - (4.0 + EGO_LENGTH) / 20.0, 0.25);
}
