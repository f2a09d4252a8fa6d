//! Conflict and criticality of pairs, compared with motions given by formulas. Expected values are computed in the
//! comments; the ego is 4 m x 2 m, as are cars.
use crate::scene::{Table, add, add_seen, area, car, drive, map, near, road};
use std::f64::consts::{FRAC_PI_2, PI};
use whyroad_model::ObjectClass::{Bus, Car, Pedestrian};
use whyroad_model::Tri::{False, True};

#[test]
fn a_braking_lead_shortens_the_time_and_an_accelerating_one_lengthens_it() {
    // Ego 20 m/s. Leads 24 m ahead (gap 20 m), 10 m/s at time 0: one brakes at 4, one accelerates at 2, one keeps on.
    let mut d = drive(10, |t| (20.0 * t, 0.0, 0.0));
    car(&mut d, "brakes", |t| (24.0 + 10.0 * t - 2.0 * t * t, 0.0, 0.0));
    car(&mut d, "speeds", |t| (24.0 + 10.0 * t + t * t, 0.0, 0.0));
    car(&mut d, "keeps", |t| (24.0 + 10.0 * t, 0.0, 0.0));
    let t = Table::of(&d);
    // 10 t + 2 t^2 = 20: t = (sqrt 260 - 10) / 4. 10 t - t^2 = 20: t = 5 - sqrt 5. 10 t = 20.
    let expected =
        [("brakes", (260.0_f64.sqrt() - 10.0) / 4.0), ("speeds", 5.0 - 5.0_f64.sqrt()), ("keeps", 2.0)];
    for (id, time) in expected {
        near(t.num(id, "target.ttc_accel", 0), time, 1e-3);
        near(t.num(id, "target.ttc_box_accel", 0), time, 0.03);
        near(t.num(id, "target.ttc", 0), 2.0, 1e-6);
    }
    // a - dv^2 / (2 gap) = -4 - 100/40, 2 - 100/40, 0 - 100/40.
    for (id, a) in [("brakes", -6.5), ("speeds", -0.5), ("keeps", -2.5)] {
        near(t.num(id, "target.a_long_req", 0), a, 1e-3);
        near(t.num(id, "target.btn", 0), -a / 11.5, 1e-3);
    }
    // The gap of 20 m is exactly the distance covered at 10 m/s in the safety time of 2 s: nothing is left.
    assert_eq!(t.num("keeps", "target.dst", 3), f64::INFINITY);
    // Both 2 m wide, in line: 2 m to a side within 2 s: 2 * 2 / 4 = 1 m/s2, of 8.
    near(t.num("keeps", "target.stn", 0), 0.125, 1e-6);
}

#[test]
fn what_does_not_close_needs_nothing() {
    let mut d = drive(10, |t| (10.0 * t, 0.0, 0.0));
    car(&mut d, "away", |t| (24.0 + 12.0 * t, 0.0, 0.0));
    car(&mut d, "beside", |t| (24.0, 3.5 + 0.0 * t, 0.0));
    d.map = Some(road());
    let t = Table::of(&d);
    for id in ["away", "beside"] {
        assert_eq!(t.num(id, "target.ttc_accel", 5), f64::INFINITY);
        for name in
            ["target.a_long_req", "target.btn", "target.stn", "target.dst", "target.tet", "target.tit"]
        {
            assert_eq!(t.num(id, name, 5), 0.0, "{name} of {id}");
        }
    }
}

#[test]
fn deceleration_to_safety_time_by_hand() {
    // Gap 40 m, 20 against 10 m/s: 3 * 100 / (2 * (40 - 20)) = 7.5 m/s2.
    let mut d = drive(5, |t| (20.0 * t, 0.0, 0.0));
    car(&mut d, "lead", |t| (44.0 + 10.0 * t, 0.0, 0.0));
    near(Table::of(&d).num("lead", "target.dst", 0), 7.5, 1e-6);
}

#[test]
fn exposure_adds_up_while_the_time_is_short() {
    // Gap 25 - 10 t: TTC 2.5 - t, 2 s or less from 0.5 s on. At 1.4 s: ten frames of 0.1 s (0.5 .. 1.4); the sum of
    // (2 - TTC) is 0 + 0.1 + ... + 0.9 = 4.5, times 0.1 s.
    let mut d = drive(20, |t| (20.0 * t, 0.0, 0.0));
    car(&mut d, "lead", |t| (29.0 + 10.0 * t, 0.0, 0.0));
    let t = Table::of(&d);
    assert_eq!(t.num("lead", "target.tet", 4), 0.0);
    // A gap of exactly 20 m may differ by a rounding error: one frame of the ten.
    near(t.num("lead", "target.tet", 14), 1.0, 0.1 + 1e-9);
    near(t.num("lead", "target.tit", 14), 0.45, 1e-6);
}

#[test]
fn two_courses_cross() {
    // Ego 10 m/s along x from 0: front at 2. A walker (0.6 m) at x = 32 walks up at 1.5 m/s from y = -4: its front
    // end is 3.7 m away (2.4667 s); the ego's front has 30 m to go (3 s).
    let mut d = drive(60, |t| (10.0 * t, 0.0, 0.0));
    add(&mut d, "walker", Pedestrian, (0.6, 0.6), |t| (32.0, -4.0 + 1.5 * t, FRAC_PI_2));
    add(&mut d, "parallel", Pedestrian, (0.6, 0.6), |t| (32.0 + 1.5 * t, -4.0, 0.0));
    add(&mut d, "stands", Pedestrian, (0.6, 0.6), |_| (32.0, -4.0, FRAC_PI_2));
    let t = Table::of(&d);
    near(t.num("walker", "target.time_to_conflict", 0), 3.7 / 1.5, 1e-3);
    near(t.num("walker", "target.ego_time_to_conflict", 0), 3.0, 1e-3);
    assert_eq!(t.flag("walker", "target.crosses_path", 0), True);
    // It is on the line y = 0 with its body from 2.467 s to 2.867 s.
    assert_eq!(t.num("walker", "target.time_to_conflict", 26), 0.0);
    // Past it at 3 s (y = 0.5); it crossed 0.33 s ago. At 5.8 s it crossed 3.1 s ago, and the ego has passed.
    assert_eq!(t.num("walker", "target.time_to_conflict", 30), f64::INFINITY);
    assert_eq!(t.flag("walker", "target.crosses_path", 30), True);
    assert_eq!(t.flag("walker", "target.crosses_path", 58), False);
    for id in ["parallel", "stands"] {
        assert_eq!(t.num(id, "target.time_to_conflict", 0), f64::INFINITY);
        assert_eq!(t.flag(id, "target.crosses_path", 0), False, "{id}");
    }
}

#[test]
fn an_oncoming_car_leaves_a_gap_to_a_left_turn() {
    // Ego along x at 5 m/s to (40, 0), then a left quarter circle of radius 10 m to (50, 10). The oncoming car comes
    // along y = 3.5 at 10 m/s; the turn crosses y = 3.5 where 10 - 10 cos a = 3.5: cos a = 0.65, x = 40 + 10 sin a =
    // 47.6.
    let turn = |t: f64| {
        let (s, arc) = (5.0 * t, 10.0 * FRAC_PI_2);
        if s < 40.0 {
            (s, 0.0, 0.0)
        } else if s < 40.0 + arc {
            let a = (s - 40.0) / 10.0;
            (40.0 + 10.0 * a.sin(), 10.0 - 10.0 * a.cos(), a)
        } else {
            (50.0, 10.0 + s - 40.0 - arc, FRAC_PI_2)
        }
    };
    let mut d = drive(140, turn);
    car(&mut d, "oncoming", |t| (140.0 - 10.0 * t, 3.5, PI));
    car(&mut d, "same_way", |t| (20.0 + 5.0 * t, -3.5, 0.0));
    let mut m = map(vec![crate::scene::lane("far", &[(900.0, 900.0), (950.0, 900.0)], 3.5)]);
    m.junctions = vec![area("j", &[(38.0, -6.0), (56.0, -6.0), (56.0, 12.0), (38.0, 12.0)])];
    d.map = Some(m);
    let t = Table::of(&d);
    let crossing = 40.0 + 10.0 * (1.0_f64 - 0.65 * 0.65).sqrt();
    // At 5 s the car's center is at 90, its front at 88: to the crossing of the lines at 47.6.
    near(t.num("oncoming", "target.oncoming_gap", 50), (88.0 - crossing) / 10.0, 0.05);
    // At 0 s the junction is 36 m ahead of the front, but the crossing more than 85 m from the car: within 100 m.
    near(t.num("oncoming", "target.oncoming_gap", 10), (128.0 - crossing) / 10.0, 0.05);
    assert_eq!(t.num("oncoming", "target.oncoming_gap", 105), f64::INFINITY, "passed");
    assert_eq!(t.num("same_way", "target.oncoming_gap", 50), f64::INFINITY);
}

#[test]
fn room_beside_the_path_and_passing() {
    // Ego half width 1 m, bus 2.6 m wide: center 3.3 m left of the path: 3.3 - 1.3 - 1 = 1 m between them.
    let mut d = drive(60, |t| (10.0 * t, 0.0, 0.0));
    add(&mut d, "bus", Bus, (12.0, 2.6), |t| (120.0 - 10.0 * t, 3.3, PI));
    add(&mut d, "wall", Bus, (12.0, 2.6), |_| (40.0, -2.0, 0.0));
    let t = Table::of(&d);
    near(t.num("bus", "target.path_side_distance", 0), 1.0, 1e-6);
    assert_eq!(t.num("bus", "target.lateral_gap", 0), f64::INFINITY, "far ahead");
    assert_eq!(t.flag("bus", "target.passing", 0), False);
    // Fronts at 2 + 10 t and 114 - 10 t: 30 m apart at 4.1 s.
    assert_eq!(t.flag("bus", "target.passing", 40), False);
    assert_eq!(t.flag("bus", "target.passing", 42), True);
    near(t.num("bus", "target.lateral_gap", 45), 1.0, 1e-6);
    assert_eq!(t.category("bus", "target.moves_along", 0), Some("against"));
    near(t.num("bus", "target.relative_speed", 0), -20.0, 1e-6);
    // -2 + 1.3 = -0.7 is 0.3 m inside the band of 1 m.
    near(t.num("wall", "target.lateral_gap", 20), -0.3, 1e-6);
    assert_eq!(t.num("wall", "target.path_side_distance", 20), 0.0);
    assert_eq!(t.flag("wall", "target.in_band", 20), True);
    assert_eq!(t.flag("bus", "target.in_band", 20), False);
    assert_eq!(t.flag("wall", "target.passing", 20), False, "it faces the same way");
    assert_eq!(t.category("wall", "target.moves_along", 20), Some("still"));
}

#[test]
fn time_to_line_by_hand() {
    // Drifting left at 0.5 m/s from the middle of a 3.5 m lane: the side at 1 m has 0.75 m to go: 1.5 s. The car in the
    // left lane (center 3.5, side at 2.5) comes in at 0.25 m/s: 0.75 / 0.25 = 3 s.
    let mut d = drive(10, |t| (10.0 * t, 0.5 * t, 0.05_f64.atan()));
    car(&mut d, "comes", |t| (20.0 + 10.0 * t, 3.5 - 0.25 * t, 0.0));
    car(&mut d, "stays", |t| (40.0 + 10.0 * t, 3.5, 0.0));
    d.map = Some(road());
    let t = Table::of(&d);
    // The turned box reaches 0.1 m farther: 2 sin + cos = 1.0986.
    near(t.ego("ego.time_to_line", 0), (1.75 - 1.0986) / 0.5, 1e-2);
    near(t.num("comes", "target.time_to_line", 0), 3.0, 1e-2);
    assert_eq!(t.num("stays", "target.time_to_line", 0), f64::INFINITY);
}

#[test]
fn the_unknown_stays_unknown() {
    // No size: no gap. A size but no acceleration, on a collision course: no required acceleration.
    let mut d = drive(10, |t| (20.0 * t, 0.0, 0.0));
    // Observed once: its speed is stated, its acceleration cannot be estimated.
    add_seen(&mut d, "braked", Car, (4.0, 2.0), |frame| frame == 3, |t| (44.0 + 10.0 * t, 0.0, 0.0));
    add(&mut d, "point", Car, (f64::NAN, f64::NAN), |t| (44.0 + 10.0 * t, 0.0, 0.0));
    let lead = d.tracks.iter_mut().find(|t| t.id.as_str() == "braked").unwrap();
    lead.motion.accel[0] = f64::NAN;
    let t = Table::of(&d);
    for name in ["target.btn", "target.a_long_req", "target.ttc_accel", "target.ttc_box_accel"] {
        assert!(t.num("braked", name, 3).is_nan(), "{name}");
    }
    // 40 m at first, closing at 10 m/s for 0.3 s.
    near(t.num("braked", "target.ttc", 3), 3.7, 1e-6);
    for name in ["target.btn", "target.stn", "target.dst", "target.lateral_gap", "target.time_to_conflict"] {
        assert!(t.num("point", name, 3).is_nan(), "{name}");
    }
}
