//! Per check: a drive with one impossible value, and the same drive without it.

use super::*;
use std::f64::consts::PI;
use whyroad_model::ObjectClass;
use whyroad_model::scene::{DriveMeta, Ego, LightColor, LightState, Track};

/// Eastwards at 10 m/s for 5 s, a car 20 m ahead; velocities stated.
fn drive() -> Drive {
    let n = 50;
    let motion = |x0: f64| Motion {
        x: (0..n).map(|i| x0 + i as f64).collect(),
        y: vec![0.0; n],
        heading: vec![0.0; n],
        vx: vec![10.0; n],
        vy: vec![0.0; n],
        accel: vec![0.0; n],
        ..Motion::unknown(n)
    };
    Drive {
        meta: DriveMeta::default(),
        times: (0..n).map(|i| Nanos(1_700_000_000_000_000_000 + i as i64 * 100_000_000)).collect(),
        ego: Some(Ego { length_m: 4.8, width_m: 1.9, motion: motion(0.0), ..Ego::default() }),
        tracks: vec![Track {
            id: "a".into(),
            class: ObjectClass::Car,
            frames: (0..n as u32).collect(),
            motion: motion(20.0),
            length_m: vec![4.5; n],
            width_m: vec![1.8; n],
            height_m: vec![1.5; n],
            interior_points: vec![f64::NAN; n],
            ..Track::default()
        }],
        ..Drive::default()
    }
}

fn lane(id: &str, points: &[(f64, f64, f64)]) -> Lane {
    Lane {
        id: id.into(),
        center: points.iter().map(|&(x, y, z)| Point3 { x, y, z }).collect(),
        ..Lane::default()
    }
}

fn codes(drive: &mut Drive) -> Vec<&'static str> {
    check(drive).iter().map(|d| d.code).collect()
}

#[test]
fn a_plausible_drive_is_left_as_it_is() {
    let mut d = drive();
    d.map = Some(RoadMap {
        lanes: vec![lane("l", &[(-50.0, 0.0, 0.0), (300.0, 0.0, 0.0)])],
        ..RoadMap::default()
    });
    let before = format!("{d:?}");
    assert!(codes(&mut d).is_empty());
    assert_eq!(format!("{d:?}"), before);
}

#[test]
fn swapped_sizes_are_repaired_and_a_bad_box_is_unknown() {
    let mut d = drive();
    let ego = d.ego.as_mut().unwrap();
    (ego.length_m, ego.width_m) = (1.73, 4.08);
    (d.tracks[0].length_m[3], d.tracks[0].width_m[3]) = (0.4, 1.1);
    let found = check(&mut d);
    assert_eq!(found.iter().map(|d| d.code).collect::<Vec<_>>(), ["ingest.size.swapped"]);
    // 50 rows of the ego and one of the track.
    assert!(found[0].message.en.starts_with("51 boxes of 2 vehicles "), "{}", found[0].message.en);
    let ego = d.ego.as_ref().unwrap();
    assert_eq!((ego.length_m, ego.width_m), (4.08, 1.73));
    assert!(d.tracks[0].length_m[3].is_nan() && d.tracks[0].length_m[4] == 4.5);
}

#[test]
fn a_last_velocity_of_zero_is_unknown_and_a_stop_is_not() {
    let mut d = drive();
    d.ego.as_mut().unwrap().motion.vx[49] = 0.0;
    // From 10 m/s to a stop in 4.9 s: x = 10 t - 10 t^2 / 9.8.
    d.tracks[0].motion.vx = (0..50).map(|i| 10.0 - 10.0 * i as f64 / 49.0).collect();
    d.tracks[0].motion.x =
        (0..50).map(|i| i as f64 / 10.0).map(|t| 20.0 + 10.0 * t - 10.0 * t * t / 9.8).collect();
    assert_eq!(codes(&mut d), ["ingest.velocity.last_zero"]);
    assert!(d.ego.unwrap().motion.vx[49].is_nan());
    assert_eq!(d.tracks[0].motion.vx[49], 0.0);
}

#[test]
fn accelerations_and_positions_that_cannot_be_are_unknown() {
    let mut d = drive();
    d.ego.as_mut().unwrap().motion.accel[7] = -40.0;
    d.tracks[0].motion.x[9] = 1e9;
    assert_eq!(codes(&mut d), ["ingest.position.far", "ingest.accel.impossible"]);
    assert!(d.ego.unwrap().motion.accel[7].is_nan());
    assert!(d.tracks[0].motion.x[9].is_nan() && d.tracks[0].motion.x[8] == 28.0);
}

/// The last poses of scene-0655 of nuScenes as its ScenarioNet pickle has them: along the road, rounded to 1 cm.
#[test]
fn poses_behind_a_step_back_are_unknown() {
    let scene_0655 = [0.0, 0.90, 1.79, 2.67, 3.57, 1.66, 2.55, 3.44, 4.33];
    let mut d = drive();
    let m = &mut d.ego.as_mut().unwrap().motion;
    for (i, x) in scene_0655.into_iter().enumerate() {
        m.x[41 + i] = 41.0 + x;
    }
    // The difference of the poses around it, as the converter has it.
    m.vx[45] = -19.09;
    assert_eq!(codes(&mut d), ["ingest.pose.impossible"]);
    let x = &d.ego.as_ref().unwrap().motion.x;
    assert!(x[..46].iter().all(|x| x.is_finite()) && x[46..].iter().all(|x| x.is_nan()), "{x:?}");
    let vx = &d.ego.as_ref().unwrap().motion.vx;
    assert!(vx[..45].iter().all(|v| v.is_finite()) && vx[45..].iter().all(|v| v.is_nan()), "{vx:?}");
}

/// One pose 1 m behind is left out; a correction of the localization by 3 m is left out for its first second only.
#[test]
fn one_bad_pose_and_a_lasting_correction() {
    let unknown = |displace: &dyn Fn(usize) -> f64| {
        let mut d = drive();
        let m = &mut d.ego.as_mut().unwrap().motion;
        (0..50).for_each(|i| m.x[i] += displace(i));
        check(&mut d);
        let x = d.ego.unwrap().motion.x;
        (0..50).filter(|&i| x[i].is_nan()).collect::<Vec<_>>()
    };
    assert_eq!(unknown(&|i| if i == 20 { -2.0 } else { 0.0 }), [20]);
    let lasting = unknown(&|i| if i >= 20 { -3.0 } else { 0.0 });
    // Braking at 9.81 m/s2 explains 2.95 m after 0.78 s.
    assert_eq!(lasting, (20..27).collect::<Vec<_>>());
    // Ahead of where it can be: the poses behind it are no steps back from it.
    assert_eq!(unknown(&|i| if i == 20 { 2.5 } else { 0.0 }), [20]);
    assert_eq!(unknown(&|i| if i >= 20 { 3.0 } else { 0.0 }), (20..27).collect::<Vec<_>>());
}

/// A detector that takes the rear for the front: at 10 m/s nobody reverses. At 3 m/s somebody may.
#[test]
fn a_heading_against_fast_motion_is_unknown() {
    let turned = |speed: f64| {
        let mut d = drive();
        let m = &mut d.tracks[0].motion;
        (0..50).for_each(|i| m.x[i] = 20.0 + speed * i as f64 / 10.0);
        m.vx.fill(speed);
        m.heading.fill(3.1);
        let found = check(&mut d);
        let unknown = d.tracks[0].motion.heading.iter().filter(|h| h.is_nan()).count();
        (found.iter().any(|d| d.code == "ingest.heading.backwards"), unknown)
    };
    // Over half a second.
    assert_eq!((turned(10.0), turned(3.0)), ((true, 45), (false, 0)));
}

#[test]
fn degrees_gravity_and_other_units_are_reported_and_not_used() {
    // 10 m/s eastwards at 48 degrees north are 0.000135 degrees per second.
    let mut d = drive();
    for m in d.ego.iter_mut().map(|e| &mut e.motion).chain(d.tracks.iter_mut().map(|t| &mut t.motion)) {
        m.x.iter_mut().for_each(|x| *x = 11.5 + *x * 1.35e-5);
        m.y.fill(48.1);
    }
    assert_eq!(codes(&mut d), ["ingest.position.degrees"]);
    assert!(d.ego.unwrap().motion.x[7].is_nan() && d.tracks[0].motion.x[7].is_nan());
    // Who stands is no degree.
    let mut d = drive();
    let m = &mut d.ego.as_mut().unwrap().motion;
    m.x.fill(11.5);
    m.vx.fill(0.0);
    assert!(codes(&mut d).is_empty());

    let mut d = drive();
    let ego = d.ego.as_mut().unwrap();
    (ego.motion.yaw_rate, ego.bus.vertical_accel) = (vec![2.0; 50], vec![9.7; 50]);
    assert_eq!(codes(&mut d), ["ingest.vertical_accel.gravity", "ingest.yaw_rate.contradicts"]);
    let ego = d.ego.unwrap();
    assert!(ego.motion.yaw_rate[3].is_nan() && ego.bus.vertical_accel.is_empty());
}

#[test]
fn limits_in_another_unit_are_unknown() {
    let limited = |limits: &[f64]| {
        let mut d = drive();
        let lanes = limits.iter().enumerate().map(|(i, v)| Lane {
            speed_limit_mps: Some(*v),
            ..lane(&i.to_string(), &[(-50.0, 0.0, 0.0), (300.0, 0.0, 0.0)])
        });
        d.map = Some(RoadMap { lanes: lanes.collect(), ..RoadMap::default() });
        let found = codes(&mut d);
        (found, d.map.unwrap().lanes.iter().filter(|l| l.speed_limit_mps.is_some()).count())
    };
    // 160 km/h, the highest limit there is.
    assert_eq!(limited(&[13.9, 44.4]), (vec![], 2));
    assert_eq!(limited(&[50.0, 30.0, 120.0]), (vec!["ingest.limit.impossible"], 0));
    // One wrong value among many is no unit.
    let mut many = vec![13.9; 20];
    many.push(60.0);
    assert_eq!(limited(&many), (vec!["ingest.limit.impossible"], 20));
}

#[test]
fn lights_of_no_lane_or_no_time_are_unknown() {
    let lit = |lane_id: &str, seconds: f64| {
        let mut d = drive();
        let lanes = vec![lane("l", &[(-50.0, 0.0, 0.0), (300.0, 0.0, 0.0)])];
        d.map = Some(RoadMap { lanes, ..RoadMap::default() });
        d.lights = Some(vec![LightState {
            lane_id: lane_id.into(),
            to_lane_id: None,
            time: d.times[0].plus_secs(seconds),
            color: LightColor::Red,
            countdown_s: None,
        }]);
        let found = codes(&mut d);
        (found, d.lights.is_some(), d.meta.missing.contains(&Need::TrafficLights))
    };
    assert_eq!(lit("l", 1.0), (vec![], true, false));
    for (lane_id, seconds) in [("other", 1.0), ("l", 1e9)] {
        assert_eq!(lit(lane_id, seconds), (vec!["ingest.lights.unused"], false, true));
    }
}

/// The ego and the car ahead drive eastwards; the only lane runs westwards.
#[test]
fn a_map_that_runs_against_the_traffic_is_not_used() {
    let on = |from: f64, to: f64| {
        let mut d = drive();
        // Four more cars, so that there is enough to go by.
        let car = d.tracks[0].clone();
        d.tracks = (0..4).map(|i| Track { id: i.to_string().as_str().into(), ..car.clone() }).collect();
        let lanes = vec![lane("l", &[(from, 0.0, 0.0), (to, 0.0, 0.0)])];
        d.map = Some(RoadMap { lanes, ..RoadMap::default() });
        (codes(&mut d), d.map.is_some())
    };
    assert_eq!(on(-50.0, 300.0), (vec![], true));
    assert_eq!(on(300.0, -50.0), (vec!["ingest.map.against"], false));
}

/// An emergency stop at 1 g, then backwards at 0.5 m/s2.
#[test]
fn braking_hard_and_then_reversing_is_possible() {
    let mut d = drive();
    let m = &mut d.ego.as_mut().unwrap().motion;
    for i in 0..50 {
        let t = i as f64 * 0.1;
        let (stops, t2) = (10.0 / 9.81, (t - 10.0 / 9.81).max(0.0));
        let t1 = t.min(stops);
        m.x[i] = 10.0 * t1 - 0.5 * 9.81 * t1 * t1 - 0.25 * t2 * t2;
        m.vx[i] = 10.0 - 9.81 * t1 - 0.5 * t2;
    }
    assert!(!codes(&mut d).contains(&"ingest.pose.impossible"));
}

#[test]
fn a_projected_frame_is_no_fault() {
    let mut d = drive();
    let motions = d.ego.iter_mut().map(|e| &mut e.motion).chain(d.tracks.iter_mut().map(|t| &mut t.motion));
    motions.for_each(|m| m.y.iter_mut().for_each(|y| *y += 5_400_000.0));
    assert!(codes(&mut d).is_empty());
}

#[test]
fn headings_stored_as_heights_are_found() {
    let mut d = drive();
    // One bend per line: the third coordinate is the direction to the next point.
    let bend = |id: &str, y: f64| {
        let points: Vec<(f64, f64)> =
            (0..20).map(|i| (10.0 * f64::from(i), y + 0.05 * f64::from(i * i))).collect();
        let heading = |i: usize| {
            let (a, b) = (points[i.min(18)], points[i.min(18) + 1]);
            (b.1 - a.1).atan2(b.0 - a.0)
        };
        lane(id, &(0..20).map(|i| (points[i].0, points[i].1, heading(i))).collect::<Vec<_>>())
    };
    d.map =
        Some(RoadMap { lanes: vec![bend("a", 0.0), bend("b", 3.5), bend("c", 7.0)], ..RoadMap::default() });
    assert_eq!(codes(&mut d), ["ingest.height.heading"]);
    let map = d.map.unwrap();
    assert!(map.lanes[0].center[5].z.is_nan() && !map.has(MapLayer::Heights));
}

#[test]
fn a_map_of_another_place_is_not_used() {
    let mut d = drive();
    let far = lane("l", &[(5000.0, 900.0, 0.0), (5300.0, 900.0, 0.0)]);
    d.map = Some(RoadMap { lanes: vec![far], ..RoadMap::default() });
    d.lights = Some(vec![]);
    assert_eq!(codes(&mut d), ["ingest.map.off"]);
    assert!(d.map.is_none() && d.lights.is_none());
    assert_eq!(d.meta.missing, [Need::Map, Need::TrafficLights]);
}

#[test]
fn a_default_limit_inside_a_junction_is_unknown() {
    let limit = |id: &str, x: f64, limit: f64, links: (&[&str], &[&str])| Lane {
        speed_limit_mps: Some(limit),
        predecessors: links.0.iter().map(|s| (*s).to_owned()).collect(),
        successors: links.1.iter().map(|s| (*s).to_owned()).collect(),
        in_junction: id == "b",
        ..lane(id, &[(x, 0.0, 0.0), (x + 50.0, 0.0, 0.0)])
    };
    let mut d = drive();
    let lanes = vec![
        limit("a", 0.0, 16.7, (&[], &["b"])),
        limit("b", 50.0, 8.9, (&["a"], &["c"])),
        limit("c", 100.0, 13.9, (&["b"], &[])),
    ];
    d.map = Some(RoadMap { lanes, ..RoadMap::default() });
    assert_eq!(codes(&mut d), ["ingest.limit.connector"]);
    let limits: Vec<Option<f64>> = d.map.unwrap().lanes.iter().map(|l| l.speed_limit_mps).collect();
    assert_eq!(limits, [Some(16.7), None, Some(13.9)]);
}

#[test]
fn a_clock_that_begins_in_1980_states_no_date() {
    let mut d = drive();
    d.times.iter_mut().for_each(|t| t.0 -= 1_384_033_746_339_643_000);
    assert_eq!(codes(&mut d), ["ingest.date.implausible"]);
    assert_eq!(d.meta.missing, [Need::Date]);
}

/// The drive goes 10 m/s by its positions: 36 in the column of speeds is km/h, 22.37 is mph.
#[test]
fn speeds_in_another_unit_are_not_used() {
    let mut d = drive();
    d.ego.as_mut().unwrap().motion.vx.fill(36.0);
    let found = check(&mut d);
    assert_eq!(found.iter().map(|d| d.code).collect::<Vec<_>>(), ["ingest.speed.contradicts"]);
    assert!(
        found[0].message.en.contains("3.60 times") && found[0].hint.as_ref().unwrap().en.contains("km/h")
    );
    assert!(d.ego.as_ref().unwrap().motion.vx.iter().all(|v| v.is_nan()) && d.tracks[0].motion.vx[0] == 10.0);
    let mut d = drive();
    let m = &mut d.tracks[0].motion;
    (m.forward, m.vx) = (vec![22.37; m.len()], vec![f64::NAN; m.len()]);
    d.ego.as_mut().unwrap().bus.speed_mps = vec![36.0; 50];
    assert_eq!(codes(&mut d), ["ingest.speed.contradicts"; 2]);
    assert!(d.tracks[0].motion.forward.is_empty() && d.ego.unwrap().bus.speed_mps.is_empty());
}

/// Ten seconds with two cars and a person beside them: places by time, and stated speeds.
fn with_walker(place: impl Fn(f64) -> f64, stated: impl Fn(f64) -> f64, walks_mps: f64) -> Drive {
    let mut d = drive();
    let n = 100;
    let motion = |y: f64, place: &dyn Fn(f64) -> f64, stated: &dyn Fn(f64) -> f64| Motion {
        x: (0..n).map(|i| place(i as f64 / 10.0)).collect(),
        y: vec![y; n],
        vx: (0..n).map(|i| stated(i as f64 / 10.0)).collect(),
        vy: vec![0.0; n],
        ..Motion::unknown(n)
    };
    d.times = (0..n).map(|i| Nanos(1_700_000_000_000_000_000 + i as i64 * 100_000_000)).collect();
    d.ego.as_mut().unwrap().motion = motion(0.0, &|t| 10.0 * t, &|_| 10.0);
    let track = |id: &str, class, motion| Track {
        id: id.into(),
        class,
        frames: (0..n as u32).collect(),
        motion,
        length_m: vec![f64::NAN; n],
        width_m: vec![f64::NAN; n],
        height_m: vec![f64::NAN; n],
        interior_points: vec![f64::NAN; n],
        ..Track::default()
    };
    d.tracks = vec![
        track("a", ObjectClass::Car, motion(10.0, &place, &stated)),
        track("b", ObjectClass::Car, motion(20.0, &place, &stated)),
        track("p", ObjectClass::Pedestrian, motion(30.0, &|t| 1.4 * t, &|_| walks_mps)),
    ];
    d
}

/// Two cars go 2 m/s for 5 s and then speed up at 1.5 m/s2; a filter with a time constant of 2 s is behind by
/// 1.5 * 2 * (1 - exp(-t / 2)): at 3.5 to 8 m/s it states 0.62 to 0.68 of the speed. That is a lag and no other unit,
/// which would be the same at 2 m/s, and says nothing about who walks.
#[test]
fn the_lag_of_a_filter_is_no_other_unit() {
    let after = |t: f64| (t - 5.0).max(0.0);
    let place = |t: f64| 2.0 * t + 0.75 * after(t).powi(2);
    let stated = |t: f64| 2.0 + 1.5 * after(t) - 3.0 * (1.0 - (-after(t) / 2.0).exp());
    let mut d = with_walker(place, stated, 1.4);
    assert!(codes(&mut d).is_empty());
    assert!(d.tracks.iter().all(|t| t.motion.vx.iter().all(|v| v.is_finite())));
}

/// A wrong unit of one kind of object (mph: 2.237) leaves the right speeds of the others, and one of people is found.
#[test]
fn each_kind_of_object_is_judged_by_its_own() {
    let lost = |d: &Drive| d.tracks.iter().map(|t| t.motion.vx[50].is_nan()).collect::<Vec<_>>();
    let mut d = with_walker(|t| 8.0 * t, |_| 8.0 * 2.237, 1.4);
    let found = check(&mut d);
    assert!(found.len() == 1 && found[0].message.en.contains("the vehicles"), "{found:?}");
    assert_eq!(lost(&d), [true, true, false]);
    let mut d = with_walker(|t| 8.0 * t, |_| 8.0, 1.4 * 3.6);
    let found = check(&mut d);
    assert!(found.len() == 1 && found[0].message.en.contains("the people"), "{found:?}");
    assert_eq!(lost(&d), [false, false, true]);
    // A cone moves too little to be compared: it shares the fault of all.
    for (walks, shared) in [(1.4, false), (1.4 * 2.237, true)] {
        let mut d = with_walker(|t| 8.0 * t, |_| 8.0 * 2.237, walks);
        d.tracks.push(Track { id: "c".into(), class: ObjectClass::Cone, ..d.tracks[2].clone() });
        check(&mut d);
        assert_eq!(lost(&d)[3], shared);
    }
}

/// A speedometer is a few percent off, and a car that turns or drives backwards heads elsewhere than it goes.
#[test]
fn speeds_and_headings_that_differ_a_little_are_used() {
    let mut d = drive();
    let ego = d.ego.as_mut().unwrap();
    ego.bus.speed_mps = vec![10.6; 50];
    d.tracks[0].motion.heading.fill(0.3);
    assert!(codes(&mut d).is_empty());
}

/// 90 degrees stored as radians are 2.04 rad (90 - 28 pi), that is 117 or, backwards, 63 degrees from the way.
#[test]
fn headings_in_degrees_are_not_used() {
    let mut d = drive();
    let turn = 2.0 * PI;
    d.tracks[0].motion.heading.fill(90.0 - 14.0 * turn);
    let found = check(&mut d);
    assert_eq!(found.iter().map(|d| d.code).collect::<Vec<_>>(), ["ingest.heading.contradicts"]);
    assert!(found[0].message.en.contains("63 degrees"), "{}", found[0].message.en);
    assert!(d.tracks[0].motion.heading.iter().all(|h| h.is_nan()));
    assert!(d.ego.unwrap().motion.heading[0] == 0.0);
}

/// A car that heads west, its angles averaged linearly over 180 degrees: pi, -0.1, pi. Only the wrong heading is lost.
#[test]
fn a_heading_that_jumps_and_comes_back_is_lost_alone() {
    let mut d = drive();
    for m in [&mut d.ego.as_mut().unwrap().motion, &mut d.tracks[0].motion] {
        m.x.iter_mut().for_each(|x| *x = -*x);
        m.vx.fill(-10.0);
        m.heading.fill(PI);
        (m.heading[20], m.heading[21]) = (-0.1, 1.6);
    }
    let found = check(&mut d);
    assert_eq!(found.iter().map(|d| d.code).collect::<Vec<_>>(), ["ingest.heading.impossible"]);
    assert!(found[0].message.en.starts_with("4 headings of 2 objects"), "{}", found[0].message.en);
    let m = &d.ego.unwrap().motion;
    assert!(m.heading[20].is_nan() && m.heading[21].is_nan() && m.heading[22] == PI);
    assert!(m.x.iter().all(|x| x.is_finite()));
}

/// A heading that is corrected for good is taken after a second; one of a standing car may be anything.
#[test]
fn a_new_heading_that_stays_is_taken() {
    let mut d = drive();
    d.tracks.clear();
    d.ego.as_mut().unwrap().motion.heading[30..].fill(2.0);
    check(&mut d);
    let lost = d.ego.unwrap().motion.heading.iter().filter(|h| h.is_nan()).count();
    assert!((9..=11).contains(&lost), "{lost}");
}

/// A circle to the left (radius 20 m, 5 m/s): velocities in the axes of the car are (5, 0) all the way round.
#[test]
fn velocities_in_the_axes_of_the_car_are_not_used() {
    let mut d = drive();
    d.tracks.clear();
    let m = &mut d.ego.as_mut().unwrap().motion;
    for i in 0..50 {
        let a = 0.25 * i as f64 / 10.0 + 1.0;
        (m.x[i], m.y[i], m.heading[i]) = (20.0 * a.sin(), -20.0 * a.cos(), a);
        (m.vx[i], m.vy[i]) = (5.0, 0.0);
    }
    let found = check(&mut d);
    assert_eq!(found.iter().map(|d| d.code).collect::<Vec<_>>(), ["ingest.speed.contradicts"]);
    assert!(found[0].hint.as_ref().unwrap().en.contains("axes"));
    assert!(d.ego.unwrap().motion.vx.iter().all(|v| v.is_nan()));
}

/// Sizes in millimeters, and the ego's own box among the objects.
#[test]
fn sizes_in_another_unit_and_the_ego_among_the_objects() {
    let mut d = drive();
    d.tracks[0].length_m.fill(4500.0);
    d.tracks[0].width_m.fill(1800.0);
    let mut own = d.tracks[0].clone();
    (own.id, own.motion) = ("me".into(), d.ego.as_ref().unwrap().motion.clone());
    d.tracks.push(own);
    assert_eq!(codes(&mut d), ["ingest.ego.among_objects", "ingest.size.impossible"]);
    assert!(d.tracks.len() == 1 && d.tracks[0].length_m[0].is_nan() && d.ego.unwrap().length_m == 4.8);
}

/// A source that counts braking as positive, or turns to the right; and in g. By hand: v = 10 + 2 t for 2.5 s, then
/// braking again; a bend of 0.3 rad/s.
#[test]
fn accelerations_and_yaw_rates_of_another_sign_or_unit_are_unknown() {
    let with = |accel: f64, yaw: f64| {
        let mut d = drive();
        let ego = d.ego.as_mut().unwrap();
        let m = &mut ego.motion;
        m.yaw_rate = vec![0.3 * yaw; 50];
        let (mut x, mut y) = (0.0, 0.0);
        for i in 0..50 {
            let t = i as f64 / 10.0;
            let speed = 10.0 + 2.0 * (2.5 - (t - 2.5).abs());
            m.heading[i] = 0.3 * t;
            (m.vx[i], m.vy[i]) = (speed * m.heading[i].cos(), speed * m.heading[i].sin());
            m.accel[i] = accel * if t < 2.5 { 2.0 } else { -2.0 };
            (x, y) = (x + 0.1 * m.vx[i], y + 0.1 * m.vy[i]);
            (m.x[i], m.y[i]) = (x, y);
        }
        let found = check(&mut d);
        let m = d.ego.unwrap().motion;
        let hints = found.iter().map(|d| d.hint.clone().unwrap().en).collect::<Vec<_>>().join("; ");
        let codes: Vec<&str> = found.iter().map(|d| d.code).collect();
        (codes, m.accel[3].is_nan(), m.yaw_rate[3].is_nan(), hints)
    };
    assert_eq!(with(1.0, 1.0), (vec![], false, false, String::new()));
    // Measured a fifth too high, or with a filter.
    assert_eq!(with(1.2, 0.8).0, Vec::<&str>::new());
    let (codes, accel, yaw, hints) = with(-1.0, -1.0);
    assert_eq!(
        (codes, accel, yaw),
        (vec!["ingest.accel.contradicts", "ingest.yaw_rate.contradicts"], true, true)
    );
    assert!(hints.contains("braking negative") && hints.contains("turning left is positive"), "{hints}");
    let (codes, _, _, hints) = with(1.0 / 9.806_65, 1.0);
    assert!(codes == ["ingest.accel.contradicts"] && hints.contains("1 g"), "{codes:?} {hints}");
}

/// Coordinates of UTM are no fault; one row at the origin of the plane, 5400 km away, is.
#[test]
fn positions_of_a_projected_frame_are_compared_with_its_start() {
    let mut d = drive();
    for m in d.ego.iter_mut().map(|e| &mut e.motion).chain(d.tracks.iter_mut().map(|t| &mut t.motion)) {
        m.x.iter_mut().for_each(|x| *x += 500_000.0);
        m.y.iter_mut().for_each(|y| *y += 5_400_000.0);
    }
    let mut right = d.clone();
    assert!(codes(&mut right).is_empty());
    (d.tracks[0].motion.x[9], d.tracks[0].motion.y[9]) = (0.0, 0.0);
    assert_eq!(codes(&mut d), ["ingest.position.far"]);
    assert!(d.tracks[0].motion.x[9].is_nan() && d.tracks[0].motion.x[8] == 500_028.0);
}

/// The rear axle stands at (30, 0) from 3 s on and its heading goes round, so that the middle of the car does: 1.4 m
/// ahead of the axle. With the heading at which it stopped it is at (31.4, 0).
#[test]
fn a_heading_that_turns_at_rest_is_the_one_before() {
    let standing = |spin: f64, creep: f64| {
        let mut d = drive();
        let ego = d.ego.as_mut().unwrap();
        ego.reference_to_centre_m = 1.4;
        let m = &mut ego.motion;
        (m.vx, m.vy) = (vec![f64::NAN; 50], vec![f64::NAN; 50]);
        for i in 0..50 {
            let t = i as f64 / 10.0;
            let rest = (t - 3.0_f64).max(0.0);
            m.heading[i] = wrap_angle(spin * rest);
            let axle = 10.0 * t.min(3.0) + creep * rest;
            (m.x[i], m.y[i]) = (axle + 1.4 * m.heading[i].cos(), 1.4 * m.heading[i].sin());
        }
        let found = codes(&mut d);
        (found, d.ego.unwrap().motion)
    };
    let (found, m) = standing(1.5, 0.0);
    assert_eq!(found, ["ingest.heading.standing"]);
    assert!(m.heading.iter().all(|h| h.abs() < 0.11), "{:?}", m.heading);
    assert!((m.x[45] - 31.4).abs() < 1e-9 && m.y[45].abs() < 1e-9, "{} {}", m.x[45], m.y[45]);
    // A few degrees are an error of the sensor, and a car that creeps round a corner at 1 m/s moves.
    assert!(standing(0.04, 0.0).0.is_empty());
    assert!(standing(0.35, 1.0).0.is_empty());
}

/// Two streets that cross, two lanes each, cars in the middle of lanes; the map is moved by 10 m, or turned about the
/// first place of the ego.
#[test]
fn a_map_far_beside_or_turned_is_reported() {
    let with = |change: &dyn Fn(f64, f64) -> (f64, f64)| {
        let mut d = drive();
        let n = 50;
        // Both ways on both streets, at different speeds and beginnings.
        let ways = [(0.0, -1.75), (PI, 1.75), (PI / 2.0, 1.75), (-PI / 2.0, -1.75)];
        d.tracks = (0..8)
            .map(|k| {
                let (heading, side) = ways[k % 4];
                let speed = 8.0 + k as f64;
                let mut m = Motion { heading: vec![heading; n], ..Motion::unknown(n) };
                for i in 0..n {
                    let along = -40.0 + 7.0 * k as f64 + speed * i as f64 / 10.0;
                    let (s, c) = heading.sin_cos();
                    (m.x[i], m.y[i]) = if k % 4 < 2 { (along * c, side) } else { (side, along * s) };
                }
                Track { id: format!("t{k}").as_str().into(), motion: m, ..d.tracks[0].clone() }
            })
            .collect();
        let ego = d.ego.as_mut().unwrap();
        ego.motion.y = vec![-1.75; n];
        let line = |points: [(f64, f64); 2]| {
            points.map(|(x, y)| {
                let (x, y) = change(x, y);
                (x, y, f64::NAN)
            })
        };
        d.map = Some(RoadMap {
            lanes: vec![
                lane("e", &line([(-150.0, -1.75), (150.0, -1.75)])),
                lane("w", &line([(150.0, 1.75), (-150.0, 1.75)])),
                lane("n", &line([(1.75, -150.0), (1.75, 150.0)])),
                lane("s", &line([(-1.75, 150.0), (-1.75, -150.0)])),
            ],
            ..RoadMap::default()
        });
        check(&mut d)
    };
    let said = |found: &[Diagnostic]| found.iter().map(|d| d.code).collect::<Vec<_>>();
    assert!(with(&|x, y| (x, y)).is_empty());
    let found = with(&|x, y| (x + 8.0, y - 6.0));
    assert_eq!(said(&found), ["ingest.map.shifted"]);
    let hint = &found[0].hint.as_ref().unwrap().en;
    assert!(hint.contains("--map-offset -8.00,6.00"), "{hint}");
    for degrees in [3.0_f64, -6.0] {
        let (s, c) = degrees.to_radians().sin_cos();
        let found = with(&|x, y| (c * x - s * y, s * x + c * y));
        assert_eq!(said(&found), ["ingest.map.turned"], "{degrees}");
        let (amount, way) = (degrees.abs(), if degrees > 0.0 { "counter-clockwise" } else { "clockwise" });
        assert!(found[0].message.en.contains(&format!("about {amount:.1} degrees {way}")), "{:?}", found[0]);
    }
}

/// Without poses the ego is the origin: cars parked on the right, headed as it is, go backwards at 10 m/s relative to
/// it. Over ground they would be wrong; relative to the ego they are not.
#[test]
fn what_a_moving_ego_passes_does_not_drive_backwards() {
    let passed = |frame: FrameOfReference| {
        let mut d = drive();
        d.meta.frame_of_reference = frame;
        let m = &mut d.tracks[0].motion;
        m.x = (0..m.len()).map(|i| 30.0 - i as f64).collect();
        m.vx.fill(f64::NAN);
        m.vy.fill(f64::NAN);
        if frame == FrameOfReference::Ego {
            d.ego = None;
        }
        d
    };
    let mut relative = passed(FrameOfReference::Ego);
    assert!(codes(&mut relative).is_empty());
    assert!(relative.tracks[0].motion.heading.iter().all(|h| *h == 0.0));
    assert_eq!(codes(&mut passed(FrameOfReference::World)), ["ingest.heading.backwards"]);
}

/// Beijing, 10 m/s: a degree of latitude is 111 km (GRS 80: 110.6 to 111.7), of longitude that times cos(latitude). No
/// speed is stated. A circle of 100 m radius, and on the straight two cars 20 m and 40 m ahead.
#[test]
fn degrees_without_a_speed_are_found_by_the_turn_or_by_the_other_vehicles() {
    let degrees = |d: &mut Drive, at: &dyn Fn(f64) -> (f64, f64, f64)| {
        let put = |m: &mut Motion, ahead: f64| {
            for i in 0..m.len() {
                let (x, y, heading) = at(i as f64 + ahead);
                (m.x[i], m.y[i], m.heading[i]) =
                    (116.3 + x / 111_000.0 / 39.9f64.to_radians().cos(), 39.9 + y / 111_000.0, heading);
            }
            m.vx.fill(f64::NAN);
            m.vy.fill(f64::NAN);
            m.accel.fill(f64::NAN);
        };
        put(&mut d.ego.as_mut().unwrap().motion, 0.0);
        for (k, track) in d.tracks.iter_mut().enumerate() {
            put(&mut track.motion, 20.0 * (k + 1) as f64);
        }
    };
    let mut turning = drive();
    turning.tracks.clear();
    degrees(&mut turning, &|s| (100.0 * (s / 100.0).sin(), 100.0 - 100.0 * (s / 100.0).cos(), s / 100.0));
    let ego = turning.ego.as_mut().unwrap();
    ego.reference_to_centre_m = 1.4;
    for i in 0..50 {
        ego.motion.x[i] += 1.4 * ego.motion.heading[i].cos();
        ego.motion.y[i] += 1.4 * ego.motion.heading[i].sin();
    }
    assert_eq!(codes(&mut turning), ["ingest.position.degrees"]);
    assert!(turning.ego.unwrap().motion.x.iter().all(|x| x.is_nan()));
    let mut straight = drive();
    straight.tracks.push(Track { id: "b".into(), ..straight.tracks[0].clone() });
    degrees(&mut straight, &|s| (s, 0.0, 0.0));
    // The pose is that of the rear axle: adapters add the way to the center of the car, in meters.
    let ego = straight.ego.as_mut().unwrap();
    ego.reference_to_centre_m = 1.4;
    ego.motion.x.iter_mut().for_each(|x| *x += 1.4);
    assert_eq!(codes(&mut straight), ["ingest.position.degrees"]);
    // At rest, with a heading that drifts by a degree per frame, beside two parked cars.
    let mut parked = drive();
    parked.tracks.push(Track { id: "b".into(), ..parked.tracks[0].clone() });
    let motions =
        parked.ego.iter_mut().map(|e| &mut e.motion).chain(parked.tracks.iter_mut().map(|t| &mut t.motion));
    for (k, m) in motions.enumerate() {
        m.x.fill(5.0 * k as f64);
        m.vx.fill(0.0);
        m.heading = (0..m.len()).map(|i| (i as f64).to_radians()).collect();
    }
    assert!(!codes(&mut parked).contains(&"ingest.position.degrees"));
}
