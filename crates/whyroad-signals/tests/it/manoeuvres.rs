//! The ego's own motion, lanes, lane changes and turns, compared with motions given by formulas. Expected values are
//! computed in the comments.
use crate::scene::{Table, add, area, car, drive, lane, map, near, road};
use std::f64::consts::{FRAC_PI_2, PI};
use whyroad_model::Need;
use whyroad_model::ObjectClass::Pedestrian;
use whyroad_model::RoadMap;
use whyroad_model::Tri::{False, True, Unknown};
use whyroad_model::road_map::Area;
use whyroad_model::scene::FrameOfReference;

#[test]
fn a_constant_turn_through_pi_has_a_constant_rate() {
    // Radius 50 m at 10 m/s from heading 2.5 rad: passes pi after 3.2 s.
    let circle = |t: f64| {
        let h = 2.5 + 0.2 * t;
        (50.0 * (h - FRAC_PI_2).cos(), 50.0 * (h - FRAC_PI_2).sin(), h)
    };
    let mut d = drive(100, circle);
    for given in [true, false] {
        if !given {
            d.ego.as_mut().unwrap().motion.yaw_rate.fill(f64::NAN);
        }
        let t = Table::of(&d);
        for i in 0..100 {
            near(t.ego("ego.yaw_rate", i), 0.2, 1e-6);
            near(t.ego("ego.curvature", i), 0.02, 1e-5);
            near(t.ego("ego.lateral_accel", i), 2.0, 1e-3);
            let h = t.ego("ego.heading", i);
            assert!(h > -PI && h <= PI);
            assert_eq!(t.ego_category("ego.meta_lateral", i), Some("steer_left"), "0.2 rad/s is 11.5 deg/s");
        }
    }
}

#[test]
fn from_179_to_minus_179_degrees_is_straight() {
    // Westbound through a junction, heading swinging by 2 deg across the wrap.
    let pose = |t: f64| (-10.0 * t, 0.0, PI + (1.0_f64.to_radians()) * (t - 5.0).clamp(-1.0, 1.0));
    let mut d = drive(100, pose);
    let line: Vec<(f64, f64)> = vec![(50.0, 0.0), (-40.0, 0.0)];
    let mut inner = lane("b", &[(-40.0, 0.0), (-60.0, 0.0)], 3.5);
    inner.in_junction = true;
    d.map = Some(map(vec![lane("a", &line, 3.5), inner, lane("c", &[(-60.0, 0.0), (-200.0, 0.0)], 3.5)]));
    car(&mut d, "other", |t| (-30.0 - 10.0 * t, 0.0, -179.0_f64.to_radians()));
    let t = Table::of(&d);
    assert_eq!(t.ego_category("ego.movement", 50), Some("straight"));
    near(t.ego("ego.turn_angle", 50), 2.0_f64.to_radians(), 1e-3);
    // Ego at 179 deg, other at -179 deg: 2 deg to the left.
    near(t.num("other", "target.heading_difference", 0), 2.0_f64.to_radians(), 1e-9);
    assert_eq!(t.flag("other", "target.opposite_direction", 0), False);
    assert_eq!(t.flag("other", "target.is_lead", 0), True);
}

#[test]
fn kinematics_meta_actions_and_standstill() {
    // 8 m/s braking at 2.5 m/s2 from 2 s: stands at 5.2 s.
    let pose = |t: f64| {
        let b = (t - 2.0).clamp(0.0, 3.2);
        (8.0 * t.min(5.2) - 1.25 * b * b, 0.0, 0.0)
    };
    let t = Table::of(&drive(80, pose));
    near(t.ego("ego.speed", 30), 5.5, 1e-3);
    near(t.ego("ego.accel", 30), -2.5, 1e-2);
    near(t.ego("ego.jerk", 30), 0.0, 0.1);
    assert_eq!(t.ego_category("ego.meta_longitudinal", 10), Some("maintain_speed"));
    assert_eq!(t.ego_category("ego.meta_longitudinal", 30), Some("strong_decelerate"));
    assert_eq!(t.ego_category("ego.meta_longitudinal", 60), Some("stop"));
    // 0.3 m/s is reached 3.08 s into braking, at 5.08 s.
    assert_eq!((0..80).find(|&i| t.ego_flag("ego.standstill", i) == True), Some(51));
    let back = Table::of(&drive(40, |t| (-2.0 * t, 0.0, 0.0)));
    near(back.ego("ego.forward_speed", 20), -2.0, 1e-6);
    near(back.ego("ego.speed", 20), 2.0, 1e-6);
    assert_eq!(back.ego_category("ego.meta_longitudinal", 20), Some("reverse"));
}

#[test]
fn at_the_end_of_the_record_braking_is_no_acceleration() {
    // 5 m/s, 1.2 m/s2 from 1 s on, braking at 2.6 m/s2 from 3 s on. The record ends 0.3 s later, as Stage I at a
    // keyframe: the run is shorter than 0.5 s, and nothing is known of how it goes on.
    let pose = |t: f64| {
        let (up, down) = ((t - 1.0).clamp(0.0, 2.0), (t - 3.0).max(0.0));
        (5.0 * t + 0.6 * up * up + 2.4 * down - 1.3 * down * down, 0.0, 0.0)
    };
    let t = Table::of(&drive(34, pose));
    assert_eq!(t.ego_category("ego.meta_longitudinal", 20), Some("gentle_accelerate"));
    let last = t.ego_category("ego.meta_longitudinal", 33);
    assert!(matches!(last, None | Some("gentle_decelerate" | "strong_decelerate")), "{last:?}");
    // A longer run is known as before: strong from 2 m/s2 on.
    let later = Table::of(&drive(45, pose));
    assert_eq!(later.ego_category("ego.meta_longitudinal", 44), Some("strong_decelerate"));
    // One frame after the change the mean is still that of the time before.
    let one = Table::of(&drive(32, pose));
    let last = one.ego_category("ego.meta_longitudinal", 31);
    assert!(one.ego("ego.accel", 31) > -0.4 || !matches!(last, Some("gentle_accelerate")), "{last:?}");
    // Weak and strong braking are one side: the last 0.3 s of strong braking join the weak braking before.
    let harder = |t: f64| {
        let (weak, strong) = ((t - 1.0).clamp(0.0, 2.0), (t - 3.0).max(0.0));
        (15.0 * t - 0.5 * weak * weak - 2.0 * strong - 2.0 * strong * strong, 0.0, 0.0)
    };
    let t = Table::of(&drive(34, harder));
    assert_eq!(t.ego_category("ego.meta_longitudinal", 33), Some("gentle_decelerate"));
}

/// 3.5 m to the left between 4 and 8 s, as a cosine.
fn shift(t: f64) -> f64 {
    1.75 * (1.0 - (PI * ((t - 4.0).clamp(0.0, 4.0)) / 4.0).cos())
}

#[test]
fn a_lane_change_lasts_from_leaving_one_center_to_resting_on_the_other() {
    let mut d = drive(120, |t| (12.0 * t, shift(t), 0.0));
    d.map = Some(road());
    let t = Table::of(&d);
    // Lateral speed 1.374 sin(pi (t-4)/4) reaches 0.1 m/s at 4.093 s and falls under it at 7.907 s; the first frame
    // after that is 8.0 s.
    assert_eq!(t.span("ego.lane_change", "left"), Some((41, 80)));
    assert_eq!(t.span("ego.lane_change", "right"), None);
    near(t.ego("ego.lateral_speed", 60), 1.75 * PI / 4.0, 1e-3);
    near(t.ego("ego.lane_offset", 20), 0.0, 1e-6);
    near(t.ego("ego.lane_width", 20), 3.5, 1e-6);
    let mut center_lines = d.clone();
    for lane in center_lines.map.iter_mut().flat_map(|m| &mut m.lanes) {
        lane.width_m = None;
        lane.left.clear();
        lane.right.clear();
    }
    assert!(Table::of(&center_lines).ego("ego.lane_width", 20).is_nan(), "nothing states how wide it is");
    near(t.ego("map.lane_count", 20), 2.0, 0.0);
    // Before the middle it is left of the old center, after it right of the new one: shift(5) = 0.5126.
    near(t.ego("ego.lane_offset", 50), 0.5126, 1e-3);
    near(t.ego("ego.lane_offset", 70), -0.5126, 1e-3);
    assert_eq!(t.ego_flag("ego.wheel_over_line", 60), True);
    assert_eq!(t.ego_flag("ego.wheel_over_line", 20), False);
}

#[test]
fn a_lane_change_begins_when_it_goes_the_right_way() {
    // First 0.4 m to the right between 2.5 and 4 s, then 3.9 m to the left between 4 and 8 s: the beginning is where
    // the lateral speed 1.95 pi/4 sin(pi (t-4)/4) to the left reaches 0.1 m/s, at 4.083 s.
    let y = |t: f64| {
        let half = |from: f64, over: f64| (1.0 - (PI * (t - from).clamp(0.0, over) / over).cos()) / 2.0;
        -0.4 * half(2.5, 1.5) + 3.9 * half(4.0, 4.0)
    };
    let mut d = drive(120, move |t| (12.0 * t, y(t), 0.0));
    d.map = Some(road());
    assert_eq!(Table::of(&d).span("ego.lane_change", "left").unwrap().0, 41);
}

#[test]
fn swinging_out_and_back_or_driving_on_is_no_lane_change() {
    // 1.2 m out and back: over the line with the wheels, never with the center.
    let mut swing =
        drive(120, |t| (12.0 * t, 0.6 * (1.0 - (PI * (t - 4.0).clamp(0.0, 4.0) / 2.0).cos()), 0.0));
    swing.map = Some(road());
    let t = Table::of(&swing);
    assert_eq!(t.span("ego.lane_change", "left"), None);
    assert_eq!(t.ego_flag("ego.wheel_over_line", 60), True);
    // Over the joint at x = 100 (8.3 s) straight on.
    let mut on = drive(120, |t| (12.0 * t, 0.1, 0.0));
    on.map = Some(road());
    let t = Table::of(&on);
    assert_eq!(t.span("ego.lane_change", "none"), Some((0, 119)));
    near(t.ego("ego.lane_offset", 90), 0.1, 1e-6);
}

/// A crossing of two roads at (50, 0): straight on along x, and a quarter circle of radius 10 m to the left.
fn crossing() -> RoadMap {
    let arc: Vec<(f64, f64)> = (0..=20)
        .map(|i| (f64::from(i) / 20.0) * FRAC_PI_2)
        .map(|a| (40.0 + 10.0 * a.sin(), 10.0 - 10.0 * a.cos()))
        .collect();
    let mut lanes = vec![
        lane("in", &[(-100.0, 0.0), (0.0, 0.0), (40.0, 0.0)], 3.5),
        lane("left", &arc, 3.5),
        lane("on", &[(40.0, 0.0), (60.0, 0.0)], 3.5),
        lane("out_ahead", &[(60.0, 0.0), (200.0, 0.0)], 3.5),
        lane("out_left", &[(50.0, 10.0), (50.0, 200.0)], 3.5),
    ];
    for (i, j) in [(0, 1), (0, 2), (1, 4), (2, 3)] {
        let (a, b) = (lanes[i].id.clone(), lanes[j].id.clone());
        lanes[i].successors.push(b);
        lanes[j].predecessors.push(a);
    }
    lanes[1].in_junction = true;
    lanes[2].in_junction = true;
    let mut m = map(lanes);
    m.crosswalks = vec![area("zebra", &[(34.0, -3.0), (38.0, -3.0), (38.0, 3.0), (34.0, 3.0)])];
    m
}

/// Along x to the junction at x = 40, then the left arc, then along y; `s` is the distance driven from x = 0.
fn left_turn(s: f64) -> (f64, f64, f64) {
    let arc = 10.0 * FRAC_PI_2;
    if s < 40.0 {
        (s, 0.0, 0.0)
    } else if s < 40.0 + arc {
        let a = (s - 40.0) / 10.0;
        (40.0 + 10.0 * a.sin(), 10.0 - 10.0 * a.cos(), a)
    } else {
        (50.0, 10.0 + s - 40.0 - arc, FRAC_PI_2)
    }
}

#[test]
fn turns_by_integrated_heading() {
    let mut d = drive(120, |t| left_turn(8.0 * t));
    d.map = Some(crossing());
    let t = Table::of(&d);
    // In the junction from s = 40 (5.0 s) to s = 55.7 (6.96 s).
    assert_eq!(t.ego_category("ego.movement", 60), Some("left"));
    near(t.ego("ego.turn_angle", 60), FRAC_PI_2, 0.01);
    assert_eq!(t.ego_flag("ego.in_junction", 45), False);
    assert_eq!(t.ego_flag("ego.in_junction", 60), True);
    assert_eq!(t.ego_flag("ego.in_junction", 75), False);
    assert_eq!(t.ego_category("ego.movement", 20), None, "unknown outside");
    // At 2 s: center at 16, front bumper at 18; junction at 40, crosswalk at 34.
    near(t.ego("map.distance_to_junction", 20), 22.0, 0.6);
    near(t.ego("map.distance_to_crosswalk", 20), 16.0, 0.6);
    assert_eq!(t.ego("map.distance_to_junction", 60), 0.0);
    // The bend's curvature 1/10, seen 24 m ahead; here the road is straight.
    near(t.ego("map.curvature_ahead", 20), 0.1, 0.005);
    near(t.ego("map.curvature", 20), 0.0, 1e-9);
    assert_eq!(t.span("ego.lane_change", "left"), None, "a turn is no lane change");

    let mut d = drive(120, |t| (8.0 * t, 0.0, 0.0));
    d.map = Some(crossing());
    assert_eq!(Table::of(&d).ego_category("ego.movement", 60), Some("straight"));
    // The recording ends in the junction after 0.3 m: the movement is unknown.
    let mut d = drive(52, |t| (8.0 * t, 0.0, 0.0));
    d.map = Some(crossing());
    let t = Table::of(&d);
    assert_eq!((t.ego_flag("ego.in_junction", 51), t.ego_category("ego.movement", 51)), (True, None));
}

#[test]
fn lanes_of_the_junction_complete_a_way_that_the_record_cuts() {
    // Of two lanes from x = 40, one straight on for 20 m, one a left arc of 15.7 m: 9 m on they are 3.5 m apart.
    let movement = |way: fn(f64) -> (f64, f64, f64), frames: usize| {
        let mut d = drive(frames, |t| way(8.0 * t));
        d.map = Some(crossing());
        let t = Table::of(&d);
        let inside = (0..frames).find(|&i| t.ego_flag("ego.in_junction", i) == True).unwrap();
        (t.ego_category("ego.movement", inside).map(str::to_owned), t.ego("ego.turn_angle", inside))
    };
    let ahead = |s: f64| (s, 0.0, 0.0);
    assert_eq!(movement(ahead, 66).0.as_deref(), Some("straight"), "ends at x = 52");
    assert_eq!(movement(ahead, 57).0, None, "ends at x = 44.8, where either lane may be the ego's");
    // At s = 48.8 it heads 50 deg to the left: that is a left turn, however far it goes.
    let (way, angle) = movement(left_turn, 62);
    assert_eq!(way.as_deref(), Some("left"), "ends at s = 48.8");
    near(angle, 0.88, 0.1);
}

#[test]
fn who_steers_into_a_turn_where_the_record_ends_turns() {
    // Straight on, then a circle of `radius` to the left from the junction at x = 40 on, whose lanes lead elsewhere.
    let movement = |radius: f64, degrees: f64| {
        let (speed, arc) = (8.0, radius * degrees.to_radians());
        let way = move |s: f64| {
            let a = ((s - 40.0) / radius).max(0.0);
            (s.min(40.0) + radius * a.sin(), radius * (1.0 - a.cos()), a)
        };
        let frames = ((40.0 + arc) / (speed * 0.1)) as usize;
        let mut d = drive(frames, |t| way(speed * t));
        let mut m = map(vec![lane("road", &[(-50.0, 0.0), (40.0, 0.0)], 3.5)]);
        m.junctions = vec![area("j", &[(40.0, -20.0), (80.0, -20.0), (80.0, 20.0), (40.0, 20.0)])];
        d.map = Some(m);
        let t = Table::of(&d);
        assert_eq!(t.ego_flag("ego.in_junction", frames - 1), True);
        t.ego_category("ego.movement", frames - 1).map(str::to_owned)
    };
    assert_eq!(movement(15.0, 22.0).as_deref(), Some("left"));
    assert_eq!(movement(15.0, 12.0), None, "a lane change in the junction turns by as much");
    assert_eq!(movement(32.0, 22.0), None, "a bend of the road is as wide");
}

#[test]
fn how_far_a_turn_goes_is_unknown_where_the_record_begins_in_it() {
    // Part of a circle of 20 m to the left, from (0, 0); the junction is what lies beyond 6 m of the arc.
    let junction = area("j", &[(5.9, -5.0), (18.0, -5.0), (18.0, 20.0), (5.9, 20.0)]);
    let movement = |degrees: f64, before: f64| {
        let angle = degrees.to_radians();
        let (arc, sin, cos) = (20.0 * angle, angle.sin(), angle.cos());
        let way = move |s: f64| {
            let a = (s / 20.0).clamp(0.0, angle);
            let after = (s - arc).max(0.0);
            (s.min(0.0) + 20.0 * a.sin() + after * cos, 20.0 * (1.0 - a.cos()) + after * sin, a)
        };
        let place = 9.0;
        let mut d = drive(120, |t| way(4.0 * t - before));
        let mut m = map(vec![lane("far", &[(900.0, 900.0), (950.0, 900.0)], 3.5)]);
        m.junctions = vec![junction.clone()];
        d.map = Some(m);
        let t = Table::of(&d);
        let frame = ((place + before) / 0.4) as usize;
        assert_eq!(t.ego_flag("ego.in_junction", frame), True);
        t.ego_category("ego.movement", frame).map(str::to_owned)
    };
    assert_eq!(movement(30.0, 0.0), None, "as in a slip lane, of which the record holds the last part");
    let whole = "the record holds the straight road before it";
    assert_eq!(movement(30.0, 20.0).as_deref(), Some("straight"), "{whole}");
    // 11.5 deg/s where the record begins: steering there took a second at least, and so 5.7 deg more than 43 deg.
    assert_eq!(movement(43.0, 0.0).as_deref(), Some("left"));
    assert_eq!(movement(43.0, 20.0).as_deref(), Some("straight"), "{whole}");
}

#[test]
fn a_turn_out_of_an_access_is_one_where_the_map_has_no_junction() {
    // A road of two lanes along x. Out of the access up to y = -8, then a quarter of a circle of 8 m (12.6 m) to the
    // right onto the near lane; 4 m/s.
    let two_lanes = || {
        let lanes = [("r", [(-100.0, 0.0), (200.0, 0.0)]), ("o", [(200.0, 3.5), (-100.0, 3.5)])];
        map(lanes.map(|(id, line)| lane(id, &line, 3.5)).to_vec())
    };
    let out_of_it = |s: f64| {
        let a = ((s - 17.0) / 8.0).clamp(0.0, FRAC_PI_2);
        let (x, y) = (8.0 - 8.0 * a.cos(), -8.0 + 8.0 * a.sin());
        (x + (s - 17.0 - 4.0 * PI).max(0.0), y + (s - 17.0).min(0.0), FRAC_PI_2 - a)
    };
    let table = |frames: usize, roads, way: &dyn Fn(f64) -> (f64, f64, f64)| {
        let mut d = drive(frames, |t| way(4.0 * t));
        d.map = Some(roads);
        Table::of(&d)
    };
    let t = table(120, two_lanes(), &out_of_it);
    assert_eq!(
        (t.ego_flag("ego.in_junction", 58), t.ego_category("ego.movement", 58)),
        (True, Some("right"))
    );
    near(t.ego("ego.turn_angle", 58), -FRAC_PI_2, 0.05);
    assert_eq!((t.ego_flag("ego.in_junction", 30), t.ego_flag("ego.in_junction", 85)), (False, False));
    // The record ends after 40 deg, at 29 deg/s.
    let t = table(57, two_lanes(), &out_of_it);
    assert_eq!(t.ego_category("ego.movement", 56), Some("right"));
    // The record begins at rest beside its lane, 5 m before the turn: it may leave a parking space. Within 15 m of a
    // junction it does not.
    let from_rest = |t: f64| out_of_it(14.0 + 0.8 * t * t);
    let movement = |junctions: Vec<Area>| {
        let mut d = drive(70, from_rest);
        d.map = Some(RoadMap { junctions, ..two_lanes() });
        Table::of(&d).ego_category("ego.movement", 30).map(str::to_owned)
    };
    let square = |x: f64| area("j", &[(x, -5.0), (x + 10.0, -5.0), (x + 10.0, 5.0), (x, 5.0)]);
    assert_eq!(movement(vec![square(-40.0)]), None);
    assert_eq!(movement(vec![square(-20.0)]).as_deref(), Some("right"));
    // A lane that makes the same bend leads it round.
    let bend: Vec<(f64, f64)> =
        (0..40).map(|i| out_of_it(f64::from(i) * 2.0 - 20.0)).map(|(x, y, _)| (x, y)).collect();
    let t = table(120, map(vec![lane("bend", &bend, 3.5)]), &out_of_it);
    assert!((0..120).all(|i| t.ego_category("ego.movement", i).is_none()));
    // From the lane to the right with 5 m into a bay, where it stands 2 m behind the turn.
    let into_a_bay = |s: f64| {
        let s = s.min(20.0 + 2.5 * PI + 2.0);
        let a = ((s - 20.0) / 5.0).clamp(0.0, FRAC_PI_2);
        let (x, y) = (5.0 * a.sin(), -5.0 + 5.0 * a.cos());
        (20.0 + x + (s - 20.0).min(0.0), y - (s - 20.0 - 2.5 * PI).max(0.0), -a)
    };
    let t = table(120, two_lanes(), &into_a_bay);
    assert!((0..120).all(|i| t.ego_category("ego.movement", i).is_none()));
}

#[test]
fn a_u_turn_is_one_whichever_way_the_wrap_goes() {
    // Half circle of radius 6 m at 4 m/s from heading 0 or from just under pi, left: 180 deg in 4.7 s.
    for start in [0.0, 3.0] {
        let pose = move |t: f64| {
            let (s, arc) = (4.0 * t - 20.0, 6.0 * PI);
            let a = (s / 6.0).clamp(0.0, PI);
            let (x, y) = if s < 0.0 {
                (s, 0.0)
            } else if s < arc {
                (6.0 * a.sin(), 6.0 - 6.0 * a.cos())
            } else {
                (arc - s, 12.0)
            };
            let (sin, cos) = f64::sin_cos(start);
            (x * cos - y * sin, x * sin + y * cos, start + a)
        };
        let mut d = drive(150, pose);
        let (sin, cos) = f64::sin_cos(start);
        let turned = |x: f64, y: f64| (x * cos - y * sin, x * sin + y * cos);
        let mut m = map(vec![lane("far", &[(900.0, 900.0), (950.0, 900.0)], 3.5)]);
        m.junctions =
            vec![area("j", &[turned(-2.0, -3.0), turned(9.0, -3.0), turned(9.0, 15.0), turned(-2.0, 15.0)])];
        d.map = Some(m);
        let t = Table::of(&d);
        assert_eq!(t.ego_category("ego.movement", 70), Some("uturn"), "from {start}");
        near(t.ego("ego.turn_angle", 70), PI, 0.02);
    }
}

#[test]
fn a_standing_ego_looks_along_its_lane_and_a_blind_one_straight_on() {
    // Standing 5 m before the left bend; only the left lane goes on. A car stands 20 m ahead along it.
    let mut d = drive(30, |_| left_turn(35.0));
    car(&mut d, "round_the_bend", |_| left_turn(60.0));
    let t = Table::of(&d);
    assert_eq!(
        t.flag("round_the_bend", "target.is_lead", 10),
        False,
        "without a map the way ahead is straight"
    );
    let mut m = crossing();
    m.lanes[0].successors = vec!["left".into()];
    assert_eq!(m.lanes[0].id, "in");
    d.map = Some(m);
    let t = Table::of(&d);
    assert_eq!(t.flag("round_the_bend", "target.is_lead", 10), True);
    // 25 m between centers along the lane, half lengths 2 m each; the continuation is drawn in 2 m steps.
    near(t.num("round_the_bend", "target.gap", 10), 21.0, 0.3);
}

#[test]
fn crosswalks_and_the_road_by_place() {
    let mut d = drive(20, |t| (5.0 * t, 0.0, 0.0));
    d.map = Some(crossing());
    add(&mut d, "on", Pedestrian, (0.6, 0.6), |t| (36.0, -2.0 + t, FRAC_PI_2));
    add(&mut d, "edge", Pedestrian, (0.6, 0.6), |t| (38.9, -2.0 + t, FRAC_PI_2));
    add(&mut d, "away", Pedestrian, (0.6, 0.6), |t| (42.0, -6.0 + t, FRAC_PI_2));
    let t = Table::of(&d);
    assert_eq!(t.flag("on", "target.on_crosswalk", 0), True);
    assert_eq!(t.flag("edge", "target.on_crosswalk", 0), True, "0.9 m beside it");
    assert_eq!(t.flag("away", "target.on_crosswalk", 0), False);
    // From (42, -6) to the corner (38, -3): 3-4-5.
    near(t.num("away", "target.distance_to_crosswalk", 0), 5.0, 1e-9);
    assert_eq!(t.flag("on", "target.on_road", 10), True);
    assert_eq!(t.flag("away", "target.on_road", 0), False);
    near(t.num("on", "target.path_lateral", 0), -2.0, 1e-6);
}

#[test]
fn what_a_log_lacks_is_named_and_never_given() {
    let mut d = drive(20, |t| (10.0 * t, 0.0, 0.0));
    car(&mut d, "lead", |t| (20.0 + 10.0 * t, 0.5, 0.0));
    let t = Table::of(&d);
    assert_eq!(t.0.unavailable["target.wheel_over_line"], [Need::Map]);
    assert_eq!(t.0.unavailable["light.state"], [Need::Map, Need::TrafficLights]);
    assert_eq!(t.0.unavailable["ego.brake"], [Need::VehicleBus]);
    assert_eq!(t.flag("lead", "target.is_lead", 5), True, "without a map the driven path serves as lane");

    // A bus that reports the brake but not emergency braking: a car that does not brake has no emergency braking.
    d.ego.as_mut().unwrap().bus.brake = vec![Some(false); 20];
    let t = Table::of(&d);
    assert_eq!(t.ego_flag("ego.brake", 3), False);
    assert_eq!(t.ego_flag("ego.aeb", 3), False);
    assert_eq!(t.0.unavailable["ego.cruise"], [Need::VehicleBus]);

    // Positions relative to the ego, no ego pose.
    d.ego = None;
    d.meta.frame_of_reference = FrameOfReference::Ego;
    let t = Table::of(&d);
    near(t.num("lead", "target.longitudinal", 0), 20.0, 1e-9);
    near(t.num("lead", "target.lateral", 0), 0.5, 1e-9);
    assert_eq!(t.0.unavailable["target.speed"], [Need::EgoPose]);
    assert!(!t.0.target_columns.contains_key("target.gap"));

    // Sizes unknown: no gap, but a position.
    let mut d = drive(20, |t| (10.0 * t, 0.0, 0.0));
    add(&mut d, "point", whyroad_model::ObjectClass::Car, (f64::NAN, f64::NAN), |t| {
        (20.0 + 10.0 * t, 0.0, 0.0)
    });
    let t = Table::of(&d);
    assert_eq!(t.0.unavailable["target.gap"], [Need::ObjectSizes]);
    near(t.num("point", "target.path_longitudinal", 5), 20.0, 1e-6);
    assert_eq!(t.flag("point", "target.in_ego_lane", 5), True);

    // A radar gives no classes: it is unknown whether the object ahead is a vehicle, so it is unknown that there is no
    // lead.
    let mut d = drive(20, |t| (10.0 * t, 0.0, 0.0));
    add(&mut d, "blip", whyroad_model::ObjectClass::Unknown, (4.0, 1.8), |t| (20.0 + 10.0 * t, 0.0, 0.0));
    let t = Table::of(&d);
    for name in ["lead.gap", "lead.exists", "target.is_lead", "target.class", "traffic.density"] {
        assert_eq!(t.0.unavailable[name], [Need::ObjectClasses], "{name}");
    }
    assert_eq!(t.flag("blip", "target.in_ego_lane", 5), True);
    // One known class, and the log has classes: there is a lead, and whether it is the car depends on what is before
    // it.
    car(&mut d, "lead", |t| (40.0 + 10.0 * t, 0.0, 0.0));
    let t = Table::of(&d);
    assert_eq!(
        (t.flag("lead", "target.is_lead", 5), t.flag("blip", "target.is_lead", 5)),
        (Unknown, Unknown)
    );
    assert_eq!(t.ego_flag("lead.exists", 5), True);
    assert!(t.ego("lead.gap", 5).is_nan());

    // An ego whose pose is lost for a second: unknown then, known again after.
    let mut d = drive(40, |t| (10.0 * t, 0.0, 0.0));
    car(&mut d, "lead", |t| (20.0 + 10.0 * t, 0.0, 0.0));
    let m = &mut d.ego.as_mut().unwrap().motion;
    for v in [&mut m.x, &mut m.y, &mut m.heading, &mut m.vx, &mut m.vy] {
        v[10..20].fill(f64::NAN);
    }
    let t = Table::of(&d);
    assert_eq!(t.flag("lead", "target.is_lead", 15), Unknown);
    assert_eq!(t.ego_flag("lead.exists", 15), Unknown);
    near(t.num("lead", "target.gap", 25), 16.0, 1e-6);
}

#[test]
fn out_to_pass_and_back_at_once_are_two_changes() {
    // From y = 0 to 3.5 and back in one cosine of 6 s, from 4 to 10 s: farthest over at 7 s, over the line half of the
    // way there, at 5.5 s, and half of the way back, at 8.5 s.
    let mut d = drive(140, |t| {
        let a = ((t - 4.0) / 6.0).clamp(0.0, 1.0) * 2.0 * PI;
        let aside = if a > 0.0 && a < 2.0 * PI { 1.75 * 2.0 * PI / 6.0 * a.sin() } else { 0.0 };
        (20.0 * t, 1.75 * (1.0 - a.cos()), aside.atan2(20.0))
    });
    d.map = Some(road());
    let t = Table::of(&d);
    let ((out, over), (back, done)) =
        (t.span("ego.lane_change", "left").unwrap(), t.span("ego.lane_change", "right").unwrap());
    assert!((40..=43).contains(&out) && (68..=72).contains(&over), "{out} {over}");
    assert!((68..=73).contains(&back) && (96..=100).contains(&done), "{back} {done}");
}

#[test]
fn a_change_of_lane_goes_on_where_the_lanes_lead_straight_over_a_junction() {
    // Two lanes along x, inside a junction from x = 60 to 75; 20 m/s. Half a cosine 3.5 m to the left from 1.5 to 4.5 s
    // has its middle at 3 s, at x = 60, and moves faster than 0.1 m/s until 0.08 s before its end.
    let line = |from: f64, to: f64, y: f64| [(from, y), ((from + to) / 2.0, y), (to, y)];
    let parts = [("0", -100.0, 60.0), ("1", 60.0, 75.0), ("2", 75.0, 300.0)];
    let lanes = |side: &str, y: f64| {
        parts.map(|(part, from, to)| {
            let mut lane = lane(&format!("{side}{part}"), &line(from, to, y), 3.5);
            let other = if side == "l" { &mut lane.right_neighbor } else { &mut lane.left_neighbor };
            *other = Some(format!("{}{part}", if side == "l" { "r" } else { "l" }));
            lane.in_junction = part == "1";
            lane.successors = ["1", "2"]
                .iter()
                .filter(|next| **next > part)
                .take(1)
                .map(|n| format!("{side}{n}"))
                .collect();
            lane
        })
    };
    let mut d = drive(80, |t| {
        let a = ((t - 1.5) / 3.0).clamp(0.0, 1.0) * PI;
        let aside = if a > 0.0 && a < PI { 1.75 * PI / 3.0 * a.sin() } else { 0.0 };
        (20.0 * t, 1.75 * (1.0 - a.cos()), aside.atan2(20.0))
    });
    d.map = Some(map(lanes("l", 3.5).into_iter().chain(lanes("r", 0.0)).collect()));
    let (first, last) = Table::of(&d).span("ego.lane_change", "left").unwrap();
    assert!((15..=17).contains(&first) && (43..=46).contains(&last), "{first} {last}");
}
