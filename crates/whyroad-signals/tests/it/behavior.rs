//! Behavior of targets and the ego over time, traffic and the light's history, compared with motions given by formulas.
//! Expected values are computed in the comments.
use crate::scene::{Table, add, add_seen, car, drive, lane, map, near, road};
use std::f64::consts::PI;
use whyroad_model::Nanos;
use whyroad_model::ObjectClass::Truck;
use whyroad_model::Tri::{False, True, Unknown};
use whyroad_model::road_map::{Point3, StopLine};
use whyroad_model::scene::{LightColor, LightState};

/// 3.5 m to the left between 4 and 8 s, as a cosine.
fn shift(t: f64) -> f64 {
    1.75 * (1.0 - (PI * ((t - 4.0).clamp(0.0, 4.0)) / 4.0).cos())
}

/// Frames in which a flag of the ego is true: first and last.
fn when(t: &Table, name: &str, frames: usize) -> Option<(usize, usize)> {
    let on: Vec<usize> = (0..frames).filter(|&i| t.ego_flag(name, i) == True).collect();
    Some((*on.first()?, *on.last()?))
}

fn when_of(t: &Table, target: &str, name: &str, frames: usize) -> Option<(usize, usize)> {
    let on: Vec<usize> = (0..frames).filter(|&i| t.flag(target, name, i) == True).collect();
    Some((*on.first()?, *on.last()?))
}

#[test]
fn off_the_usual_line_and_a_jerk_of_the_wheel() {
    let mut d = drive(120, |t| (12.0 * t, 0.2 + shift(t), 0.0));
    d.map = Some(road());
    let t = Table::of(&d);
    assert!(t.ego("ego.lateral_deviation", 5).is_nan(), "half a second is no habit");
    near(t.ego("ego.lateral_deviation", 39), 0.0, 1e-6);
    // Half way over: 1.75 m from the usual line, although it is in another lane.
    near(t.ego("ego.lateral_deviation", 60), 1.75, 0.03);
    assert_eq!(when(&t, "ego.swerve", 120), None);
    // 15 m/s, yaw rate 0.25 rad/s from 5 to 5.6 s on a straight road: 3.75 m/s2.
    let h = |t: f64| 0.25 * ((t - 5.0).clamp(0.0, 0.6) - (t - 5.6).clamp(0.0, 0.6));
    let mut d = drive(100, move |t| (15.0 * t, 0.0, h(t)));
    d.map = Some(road());
    let (first, last) = when(&Table::of(&d), "ego.swerve", 100).unwrap();
    assert!((50..=51).contains(&first) && (60..=63).contains(&last), "{first} {last}");
}

/// Stop and go: 6 m/s for 5 s, stands 3 s, and again, three times.
fn stop_and_go(t: f64) -> f64 {
    let (whole, part) = ((t / 8.0).floor(), t.rem_euclid(8.0));
    30.0 * whole + 6.0 * part.min(5.0)
}

#[test]
fn stops_are_counted() {
    let mut d = drive(240, |t| (stop_and_go(t), 0.0, 0.0));
    car(&mut d, "lead", |t| (8.0 + stop_and_go(t), 0.0, 0.0));
    let t = Table::of(&d);
    assert_eq!(t.ego("ego.stop_count", 40), 0.0);
    assert_eq!(t.ego("ego.stop_count", 60), 1.0);
    assert_eq!(t.ego("ego.stop_count", 200), 2.0);
    assert_eq!(t.ego_flag("ego.stop_and_go", 100), False);
    assert_eq!(t.ego_flag("ego.stop_and_go", 145), True, "second stop at 13 s");
    near(t.ego("ego.time_standing", 70), 2.0, 0.11);
    assert_eq!(t.ego("ego.time_standing", 30), 0.0);
    let (first, _) = when(&t, "ego.moves_off", 100).unwrap();
    assert!((80..=81).contains(&first), "{first}");
    assert_eq!(t.ego_flag("ego.moves_off", 92), False, "for a second");
    // Of the 20 s before 16 s, 16 are known: 60 m.
    near(t.ego("ego.mean_speed", 160), 60.0 / 16.0, 0.1);
    assert!(t.ego("ego.mean_speed", 5).is_nan());
    near(t.ego("lead.stopped_time", 70), 2.0, 0.11);
}

#[test]
fn a_change_of_mind_with_an_effect() {
    // 10 m/s, from 4 s on braking at 1 m/s2 for 3 s: 3 m/s less. The meta action changes within 0.4 s of that.
    let mut d = drive(120, |t| {
        let b = (t - 4.0).clamp(0.0, 3.0);
        (10.0 * t - 0.5 * b * b - 3.0 * (t - 7.0).max(0.0), 0.0, 0.0)
    });
    d.map = Some(road());
    let t = Table::of(&d);
    let (first, _) = when(&t, "ego.responds", 60).unwrap();
    assert!((37..=44).contains(&first), "{first}");
    // At 7 s it continues at a constant speed: a change of action, but without an effect.
    assert_eq!(t.ego_flag("ego.responds", 72), False);
    // The same for a speed that varies by 0.4 m/s either way, although its acceleration of 0.8 m/s2 is a change of
    // action.
    let mut d = drive(120, |t| (10.0 * t + 0.2 * (2.0 * t).sin(), 0.0, 0.0));
    d.map = Some(road());
    assert_eq!(when(&Table::of(&d), "ego.responds", 80), None);
}

#[test]
fn what_targets_do() {
    let mut d = drive(150, |t| (5.0 * t, 0.0, 0.0));
    // Stands for 7 s, then backs at 1 m/s for 3 s.
    car(&mut d, "backs", |t| (40.0 - (t - 7.0).clamp(0.0, 3.0), 3.5, 0.0));
    // 0.2 m/s and 1.5 m/s more or less every 4 s: its box goes back by 1.5 m at a time.
    car(&mut d, "rocks", |t| (20.0 + 0.2 * t - 3.0 / PI * (PI * t / 2.0).cos(), 3.5, 0.0));
    // Stationary, and from 6 s on its box slides back by 2 m and returns to its position, all within 4 s.
    car(&mut d, "slides", |t| (50.0 - (1.0 - (PI / 2.0 * (t - 6.0).clamp(0.0, 4.0)).cos()), 3.5, 0.0));
    // The same from 12 s on: the recording ends when it is half way back. And one that stays where it went.
    let late = |t: f64| 2.0 * (1.0 - (PI / 2.0 * t.clamp(0.0, 4.0)).cos()) / 2.0;
    car(&mut d, "slides late", move |t| (90.0 - late(t - 12.0), 3.5, 0.0));
    car(&mut d, "backs late", move |t| (100.0 - late((t - 12.0).min(2.0)), 3.5, 0.0));
    // A truck at 5 m/s whose box runs ahead at 10 m/s for a second from 8 s on; a car may speed up that fast.
    let jump = |t: f64| (60.0 + 5.0 * t + 5.0 * (t - 8.0).clamp(0.0, 1.0), -3.5, 0.0);
    add(&mut d, "lorry", Truck, (8.0, 2.5), jump);
    car(&mut d, "sprints", jump);
    // 12 m/s, brakes at 5 m/s2 from 4 s: stands at 6.4 s.
    car(&mut d, "brakes", |t| {
        let b = (t - 4.0).clamp(0.0, 2.4);
        (60.0 + 12.0 * t.min(6.4) - 2.5 * b * b, 3.5, 0.0)
    });
    // 1 m to either side every 4 s at 10 m/s: four swings of 2 m in 8 s.
    car(&mut d, "weaves", |t| (30.0 + 10.0 * t, 3.5 + (PI * t / 2.0).sin(), 0.0));
    car(&mut d, "changes", |t| (20.0 + 10.0 * t, 3.5 - shift(t), 0.0));
    car(&mut d, "wrong", |t| (150.0 - 8.0 * t, 3.5, PI));
    car(&mut d, "oncoming", |t| (150.0 - 8.0 * t, 7.0, PI));
    d.map = Some(road());
    d.meta.place = Some("Singapore, one-north".to_owned());
    let t = Table::of(&d);
    assert_eq!(t.ego_category("map.driving_side", 3), Some("left"));
    let (from, to) = when_of(&t, "backs", "target.reverses", 150).unwrap();
    assert!((70..=71).contains(&from) && (98..=100).contains(&to), "{from} {to}");
    assert_eq!(when_of(&t, "brakes", "target.reverses", 150), None);
    assert_eq!(when_of(&t, "slides", "target.reverses", 150), None, "it stands where it stood");
    assert_eq!(when_of(&t, "slides late", "target.reverses", 150), None, "whether it returns is not known");
    let (from, to) = when_of(&t, "backs late", "target.reverses", 150).unwrap();
    assert!((121..=124).contains(&from) && (136..=140).contains(&to), "{from} {to}");
    // Between two periods of forward motion; its motion at the end of the recording is unknown.
    assert_eq!(when_of(&t, "rocks", "target.reverses", 140), None);
    let (from, to) = when_of(&t, "lorry", "target.box_jumps", 150).unwrap();
    assert!((78..=84).contains(&from) && (115..=125).contains(&to), "{from} {to}, 3 s after it");
    assert_eq!(when_of(&t, "sprints", "target.box_jumps", 150), None, "a car");
    near(t.num("backs", "target.time_standing", 60), 6.0, 1e-6);
    let (from, to) = when_of(&t, "backs", "target.starts", 150).unwrap();
    assert!((70..=71).contains(&from) && to == from + 9, "{from} {to}");
    // It was stationary when first observed: for 5 s the start is unknown.
    assert_eq!(t.flag("backs", "target.was_parked", 40), Unknown);
    assert_eq!(t.flag("backs", "target.was_parked", 55), True);
    assert_eq!(t.flag("backs", "target.was_parked", 90), True, "until 2 s ago");
    assert_eq!(t.flag("brakes", "target.was_parked", 20), False);
    let (from, to) = when_of(&t, "brakes", "target.sudden_brake", 150).unwrap();
    // The mean over 0.2 s either side reaches -4; at the end it is slower than 1 m/s from 6.2 s on.
    assert!((39..=42).contains(&from) && (58..=62).contains(&to), "{from} {to}");
    let (from, _) = when_of(&t, "weaves", "target.weaves", 150).unwrap();
    // From the middle up by 1 m at 1 s, down by 2 m at 3 s, up again: the third swing is 0.5 m wide at 3.67 s.
    assert!((35..=38).contains(&from), "{from}");
    assert_eq!(when_of(&t, "changes", "target.weaves", 150), None, "a lane change is one swing");
    assert_eq!(t.flag("wrong", "target.wrong_way", 30), True);
    assert_eq!(t.flag("oncoming", "target.wrong_way", 30), False, "its lane runs that way");
}

#[test]
fn sides_and_lanes() {
    let mut d = drive(20, |t| (10.0 * t, 0.0, 0.0));
    for (id, x, y) in [("ahead", 20.0, 0.0), ("left", 4.0, 3.5), ("rear", -20.0, 3.5), ("right", 1.0, -3.5)] {
        car(&mut d, id, move |t| (x + 10.0 * t, y, 0.0));
    }
    d.map = Some(road());
    let t = Table::of(&d);
    // 41 deg to the left is still in front of the ego; 4 m ahead and 3.5 m left is 41.2 deg.
    for (id, side, lane) in [
        ("ahead", "front", "same"),
        ("left", "front", "left"),
        ("rear", "rear", "left"),
        ("right", "right", "right"),
    ] {
        assert_eq!(t.category(id, "target.side", 5), Some(side), "{id}");
        // There is no lane to the right, but within one lane's width beyond the edge it is beside.
        assert_eq!(t.category(id, "target.lane_side", 5), Some(lane), "{id}");
    }
}

#[test]
fn slower_traffic_is_overtaken() {
    // 10 m/s faster, from 24 m behind: wholly ahead until its rear is at the ego's front (2.0 s), wholly behind at
    // 2.8 s.
    let mut d = drive(60, |t| (20.0 * t, 0.0, 0.0));
    car(&mut d, "slow", |t| (24.0 + 10.0 * t, 3.5, 0.0));
    car(&mut d, "parked", |_| (60.0, 3.5, 0.0));
    car(&mut d, "oncoming", |t| (100.0 - 10.0 * t, 3.5, PI));
    let t = Table::of(&d);
    let (from, to) = when_of(&t, "slow", "target.overtaken", 60).unwrap();
    assert!((28..=29).contains(&from) && to == from + 19, "{from} {to}");
    assert_eq!(when(&t, "ego.passed_slower", 60), Some((from, to)));
    for id in ["parked", "oncoming"] {
        assert_eq!(when_of(&t, id, "target.overtaken", 60), None, "{id}");
    }
}

#[test]
fn the_queue_before_the_line() {
    // Stop line at 60. Two cars stand at 56 and 50 (centers), one stands beyond the line at 70; the ego comes to
    // stand with its front at 46. They move off at 8 and 9 s, the ego at 10 s.
    let goes = |from: f64, at: f64| move |t: f64| (from + 1.0 * (t - at).max(0.0).powi(2), 0.0, 0.0);
    let mut d = drive(130, |t| (20.0 + 8.0 * t.min(3.0) + (t - 10.0).max(0.0).powi(2), 0.0, 0.0));
    car(&mut d, "first", goes(56.0, 8.0));
    car(&mut d, "second", goes(50.0, 9.0));
    car(&mut d, "beyond", |_| (70.0, 0.0, 0.0));
    car(&mut d, "beside", |_| (54.0, 3.5, 0.0));
    let mut m = road();
    let line = vec![Point3 { x: 60.0, y: 0.0, z: 0.0 }];
    m.stop_lines = vec![StopLine { id: "s".into(), line, lane_ids: vec!["r0".into()] }];
    d.map = Some(m);
    let t = Table::of(&d);
    assert_eq!(t.ego("traffic.queue_position", 10), 2.0);
    assert_eq!(t.ego("traffic.queue_position", 60), 2.0);
    // Both have gone, but it was third when it was stationary.
    assert_eq!(t.ego("traffic.queue_position", 105), 2.0);
    assert_eq!(t.ego("traffic.density", 60), 4.0);
}

#[test]
fn congestion_is_slow_company() {
    let run = |speed: f64, cars: usize| {
        let mut d = drive(60, move |t| (speed * t, 0.0, 0.0));
        for k in 0..cars {
            car(&mut d, &format!("c{k}"), move |t| (10.0 + 10.0 * k as f64 + speed * t, 0.0, 0.0));
        }
        car(&mut d, "parked", |_| (30.0, 8.0, 0.0));
        let t = Table::of(&d);
        (t.ego_flag("traffic.congested", 50), t.ego("traffic.mean_speed", 20))
    };
    assert_eq!(run(5.0, 3).0, True);
    assert_eq!(run(9.0, 3).0, False, "32 km/h");
    assert_eq!(run(5.0, 2).0, False, "two are no traffic");
    // Vehicles parked off the road do not reduce the mean.
    near(run(5.0, 3).1, 5.0, 1e-6);
    assert!(run(5.0, 0).1.is_nan());
}

#[test]
fn the_light_remembers_its_change() {
    let mut d = drive(120, |t| (5.0 * t, 0.0, 0.0));
    let mut m = road();
    let line = vec![Point3 { x: 70.0, y: 0.0, z: 0.0 }];
    m.stop_lines = vec![StopLine { id: "s".into(), line, lane_ids: vec!["r0".into()] }];
    d.map = Some(m);
    let at = |s: i64, color| LightState {
        lane_id: "r0".into(),
        to_lane_id: None,
        time: Nanos(1_000_000_000 + s * 1_000_000_000),
        color,
        countdown_s: None,
    };
    d.lights = Some(vec![at(0, LightColor::Green), at(8, LightColor::Yellow), at(11, LightColor::Red)]);
    let t = Table::of(&d);
    // Green since before the recording: unknown for 5 s, then at least as long as observed.
    assert!(t.ego("light.time_since_change", 30).is_nan());
    near(t.ego("light.time_since_change", 60), 6.0, 1e-6);
    assert_eq!(t.ego_category("light.previous", 60), None);
    near(t.ego("light.time_since_change", 95), 1.5, 1e-6);
    assert_eq!(t.ego_category("light.previous", 95), Some("green"));
    near(t.ego("light.time_since_change", 112), 0.2, 1e-6);
    assert_eq!(t.ego_category("light.previous", 112), Some("yellow"));
    // At 4 s: front at 22, line at 70, 5 m/s.
    near(t.ego("light.time_to_stop_line", 40), 48.0 / 5.0, 1e-3);
}

#[test]
fn the_lead_leaves_and_is_what_it_is() {
    // A truck ahead that changes to the left lane between 4 and 8 s and brakes at 3.5 m/s2 from 9 s.
    let mut d = drive(120, |t| (10.0 * t, 0.0, 0.0));
    let x = |t: f64| 30.0 + 10.0 * t - 1.75 * (t - 9.0).max(0.0).powi(2);
    add(&mut d, "truck", Truck, (8.0, 2.5), move |t| (x(t), shift(t), 0.0));
    car(&mut d, "ahead", move |t| (50.0 + x(t), 0.0, 0.0));
    d.map = Some(road());
    let t = Table::of(&d);
    assert_eq!(t.ego_category("lead.class", 20), Some("truck"));
    assert_eq!(t.ego_flag("lead.large", 20), True);
    assert_eq!(t.ego_flag("lead.changes_lane", 20), False);
    assert_eq!(t.ego_flag("lead.changes_lane", 50), True);
    // Its center is over the line at 6 s: the car ahead is the lead then.
    let (from, to) = when(&t, "lead.left_lane", 120).unwrap();
    assert!((60..=61).contains(&from) && (9..=10).contains(&(to - from)), "{from} {to}");
    assert_eq!(t.ego_category("lead.class", 70), Some("car"));
    assert_eq!(t.ego_flag("lead.braking", 70), False);
    assert_eq!(t.ego_flag("lead.braking", 100), True);
    let alone = Table::of(&drive(20, |t| (10.0 * t, 0.0, 0.0)));
    assert_eq!(alone.ego_category("lead.class", 5), Some("none"));
    assert_eq!((alone.ego_flag("lead.braking", 5), alone.ego("lead.stopped_time", 5)), (False, 0.0));
}

#[test]
fn a_target_turns_by_its_heading() {
    let mut d = drive(140, |t| (-30.0 + 0.5 * t, 30.0, 0.0));
    // Along x at 8 m/s, in the junction from x = 40: a quarter circle to the right, radius 10 m; another straight on.
    car(&mut d, "right", |t| {
        let (s, arc) = (8.0 * t, 5.0 * PI);
        let a = ((s - 40.0) / 10.0).clamp(0.0, PI / 2.0);
        let on = (s - 40.0 - arc).max(0.0);
        (s.min(40.0) + 10.0 * a.sin(), -10.0 + 10.0 * a.cos() - on, -a)
    });
    car(&mut d, "straight", |t| (8.0 * t, 3.5, 0.0));
    let mut m = map(vec![lane("far", &[(900.0, 900.0), (950.0, 900.0)], 3.5)]);
    m.junctions = vec![crate::scene::area("j", &[(39.0, -11.0), (56.0, -11.0), (56.0, 8.0), (39.0, 8.0)])];
    d.map = Some(m);
    let t = Table::of(&d);
    assert_eq!(t.category("right", "target.turns", 30), Some("none"));
    assert_eq!(t.category("right", "target.turns", 60), Some("right"));
    assert_eq!(t.category("straight", "target.turns", 60), Some("straight"));
}

#[test]
fn lanes_that_shift_to_and_fro_make_nobody_weave() {
    // The road itself swings by 3 m to either side every 80 m, with corners; a vehicle on its center line does not
    // weave, one that swings by 1 m about it does.
    let kink = |x: f64| 3.0 * (1.0 - ((x / 40.0).rem_euclid(2.0) - 1.0).abs() * 2.0);
    let points: Vec<(f64, f64)> = (0..=8).map(|i| (f64::from(i) * 40.0, kink(f64::from(i) * 40.0))).collect();
    let mut d = drive(150, |t| (10.0 * t, kink(10.0 * t), 0.0));
    let heading = move |x: f64| ((kink(x + 1.0) - kink(x - 1.0)) / 2.0).atan();
    car(&mut d, "keeps", move |t| (30.0 + 10.0 * t, kink(30.0 + 10.0 * t), heading(30.0 + 10.0 * t)));
    car(&mut d, "swings", move |t| {
        (20.0 + 10.0 * t, kink(20.0 + 10.0 * t) + (PI * t / 2.0).sin(), heading(20.0 + 10.0 * t))
    });
    d.map = Some(map(vec![lane("only", &points, 3.5)]));
    let t = Table::of(&d);
    assert_eq!(when_of(&t, "keeps", "target.weaves", 150), None);
    assert!(when_of(&t, "swings", "target.weaves", 150).is_some());
}

#[test]
fn who_rounds_the_corners_of_a_drawn_loop_does_not_weave() {
    // A loop of straight pieces of 25 m, 40 degrees between them. A truck of 12 m has both ends on the line: at each
    // corner its center swings 2 m inwards and back.
    let turn = 40_f64.to_radians();
    let mut points = vec![(0.0, 0.0)];
    for i in 0..8 {
        let (x, y) = points[i];
        let along = turn * i as f64;
        points.push((x + 25.0 * along.cos(), y + 25.0 * along.sin()));
    }
    let line = points.clone();
    let at = move |s: f64| {
        let i = ((s / 25.0) as usize).min(7);
        let along = turn * i as f64;
        (line[i].0 + (s - 25.0 * i as f64) * along.cos(), line[i].1 + (s - 25.0 * i as f64) * along.sin())
    };
    let rounds = at.clone();
    let lorry = move |t: f64| {
        let (front, rear) = (rounds(22.0 + 10.0 * t), rounds(10.0 + 10.0 * t));
        let (dx, dy) = (front.0 - rear.0, front.1 - rear.1);
        ((front.0 + rear.0) / 2.0, (front.1 + rear.1) / 2.0, dy.atan2(dx))
    };
    // Behind it on the line, pointing in its direction of motion.
    let mut d = drive(150, move |t| {
        let (a, b) = (at(3.0 + 10.0 * t), at(5.0 + 10.0 * t));
        ((a.0 + b.0) / 2.0, (a.1 + b.1) / 2.0, (b.1 - a.1).atan2(b.0 - a.0))
    });
    add(&mut d, "lorry", Truck, (12.0, 2.5), lorry);
    d.map = Some(map(vec![lane("loop", &points, 4.0)]));
    assert_eq!(when_of(&Table::of(&d), "lorry", "target.weaves", 150), None);
}

/// The car ahead is recorded for 1 s, then the source of objects is silent for 2 s: whether there is a lead is unknown,
/// and the road is not empty. Its own motion is known as before.
#[test]
fn where_objects_are_not_observed_there_is_no_empty_road() {
    let mut d = drive(30, |t| (10.0 * t, 0.0, 0.0));
    add_seen(&mut d, "ahead", Truck, (8.0, 2.5), |i| i < 10, |t| (20.0 + 10.0 * t, 0.0, 0.0));
    d.map = Some(road());
    let silent = Table::of(&d);
    assert_eq!((silent.ego_flag("lead.exists", 5), silent.ego_flag("lead.exists", 25)), (True, False));
    d.meta.objects_unknown = vec![[d.times[10], d.times[29]]];
    let t = Table::of(&d);
    assert_eq!(t.ego_flag("lead.exists", 5), True);
    for frame in [10, 25, 29] {
        assert_eq!(t.ego_flag("lead.exists", frame), Unknown, "{frame}");
        assert!(t.ego("lead.gap", frame).is_nan() && t.ego("traffic.density", frame).is_nan(), "{frame}");
        near(t.ego("ego.speed", frame), 10.0, 0.1);
    }
}
