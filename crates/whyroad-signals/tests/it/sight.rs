//! Sight with geometry by hand: every expected value is trigonometry of the scene, or a formula of road design that the
//! test names.
use crate::scene::{Table, add, add_seen, area, car, drive, lane, map, near};
use std::f64::consts::{FRAC_PI_2, PI};
use whyroad_model::ObjectClass::{Bus, Car, Cone, Pedestrian, Truck};
use whyroad_model::Tri::{False, True};
use whyroad_model::road_map::{Facility, RoadMap};
use whyroad_model::{Drive, ObjectClass};
use whyroad_signals::Occluder;

/// A stationary ego at the origin, with its heading along x, for 6 s.
fn standing() -> Drive {
    drive(60, |_| (0.0, 0.0, 0.0))
}

fn building(corners: &[(f64, f64)]) -> Facility {
    Facility { id: "b".into(), kind: "building".into(), boundary: area("b", corners).boundary }
}

#[test]
fn half_of_a_car_behind_another() {
    let mut d = standing();
    // The near car's left side lies on the line of sight to the middle of the far one: half is hidden.
    car(&mut d, "near", |_| (10.0, -1.0, 0.0));
    car(&mut d, "far", |_| (30.0, 0.0, 0.0));
    car(&mut d, "beside", |_| (30.0, 8.0, 0.0));
    add(&mut d, "cone", Cone, (0.4, 0.4), |_| (20.0, 5.35, 0.0));
    let t = Table::of(&d);
    near(t.num("far", "target.visible_share", 10), 0.5, 1e-9);
    assert_eq!(t.category("far", "target.occluder", 10), Some("vehicle"));
    assert_eq!(t.flag("far", "target.occluder_moving", 10), False);
    near(t.num("near", "target.visible_share", 10), 1.0, 0.0);
    assert_eq!(t.category("near", "target.occluder", 10), Some("none"));
    // The scene's objects are 1.6 m high, the cone too: it stands before the car beside.
    assert_eq!(t.category("beside", "target.occluder", 10), Some("object"));
    for track in d.tracks.iter_mut().filter(|t| t.id.as_str() == "cone") {
        track.height_m.fill(0.75);
    }
    near(Table::of(&d).num("beside", "target.visible_share", 10), 1.0, 0.0);
}

#[test]
fn who_hides_a_target_is_told_by_id() {
    let mut d = standing();
    // As above: half of the far car is behind the near one. The walker at (40, 8) is behind the building.
    car(&mut d, "near", |_| (10.0, -1.0, 0.0));
    car(&mut d, "far", |_| (30.0, 0.0, 0.0));
    add(&mut d, "walker", Pedestrian, (0.6, 0.6), |_| (40.0, 8.0, 0.0));
    let mut m = map(vec![lane("a", &[(-200.0, 0.0), (300.0, 0.0)], 7.0)]);
    m.facilities = vec![building(&[(19.0, 3.0), (21.0, 3.0), (21.0, 5.0), (19.0, 5.0)])];
    d.map = Some(m);
    let found = whyroad_signals::occluders(&d);
    let of = |id: &str| found.get(&id.into()).cloned().unwrap_or_default();
    assert_eq!(of("far"), (0..60).map(|i| (i, Occluder::Track("near".into()))).collect::<Vec<_>>());
    assert_eq!(of("walker"), (0..60).map(|i| (i, Occluder::Facility("b".into()))).collect::<Vec<_>>());
    assert_eq!(of("near"), []);
}

#[test]
fn each_kind_of_occluder_has_its_name() {
    let with = |class: Option<ObjectClass>| {
        let mut d = standing();
        let mut m = map(vec![lane("a", &[(-200.0, 0.0), (300.0, 0.0)], 7.0)]);
        // Before the walker at (40, -8) and beside the path: x from 19 to 21, y from -3 to -5.
        match class {
            Some(class) => add(&mut d, "occluder", class, (2.0, 2.0), |_| (20.0, -4.0, 0.0)),
            None => m.facilities = vec![building(&[(19.0, -5.0), (21.0, -5.0), (21.0, -3.0), (19.0, -3.0)])],
        }
        d.map = Some(m);
        add(&mut d, "walker", Pedestrian, (0.6, 0.6), |_| (40.0, -8.0, 0.0));
        let t = Table::of(&d);
        near(t.num("walker", "target.visible_share", 0), 0.0, 0.0);
        let beside = t.ego_category("map.hidden_beside_by", 0).unwrap().to_owned();
        (t.category("walker", "target.occluder", 0).unwrap().to_owned(), beside)
    };
    let names = |a: &str, b: &str| (a.to_owned(), b.to_owned());
    assert_eq!(with(Some(Car)), names("vehicle", "vehicle"));
    assert_eq!(with(Some(Truck)), names("large_vehicle", "large_vehicle"));
    assert_eq!(with(Some(ObjectClass::Bicyclist)), names("vru", "none"));
    assert_eq!(with(Some(ObjectClass::StaticObject)), names("object", "object"));
    assert_eq!(with(None), names("building", "building"));
}

/// A parked van (x from 17 to 23, y from 2 to 4) and a pedestrian who walks out from behind it at 1.5 m/s, observed in
/// `seen`.
fn dash_out(seen: impl Fn(usize) -> bool) -> Drive {
    let mut d = standing();
    add(&mut d, "van", Car, (6.0, 2.0), |_| (20.0, 3.0, 0.0));
    add_seen(&mut d, "walker", Pedestrian, (0.6, 0.6), seen, |t| (24.5, 5.0 - 1.5 * t, -FRAC_PI_2));
    d
}

/// Visible share of the walker: what is below the line past the van's far right corner (23, 2).
fn walker_share(frame: usize) -> f64 {
    let y = 5.0 - 0.15 * frame as f64;
    let (x_low, x_high) = (if y > 0.3 { 24.8 } else { 24.2 }, if y > -0.3 { 24.2 } else { 24.8 });
    let (low, high) = (((y - 0.3) / x_low).atan(), ((y + 0.3) / x_high).atan());
    (((2.0_f64 / 23.0).atan() - low) / (high - low)).clamp(0.0, 1.0)
}

#[test]
fn a_parked_van_hides_a_walker_until_he_steps_out() {
    let t = Table::of(&dash_out(|_| true));
    for frame in 0..60 {
        near(t.num("walker", "target.visible_share", frame), walker_share(frame), 1e-9);
    }
    let hidden = (0..60).rfind(|&f| walker_share(f) < 0.1).unwrap();
    let out = (0..60).find(|&f| walker_share(f) >= 0.2).unwrap();
    assert_eq!(t.category("walker", "target.occluder", hidden), Some("vehicle"));
    for frame in 0..60 {
        let emerges = frame >= out && frame <= hidden + 10;
        assert_eq!(t.flag("walker", "target.emerges", frame), emerges.into(), "{frame}");
        let held = if frame >= out && frame <= out + 30 { "static" } else { "none" };
        assert_eq!(t.category("walker", "target.emergence", frame), Some(held), "{frame}");
        assert_eq!(t.flag("walker", "target.hidden_by_lead", frame), False);
        assert_eq!(t.flag("van", "target.emerges", frame), False);
    }
}

#[test]
fn who_was_never_seen_before_came_from_where_he_must_have_been() {
    let out = (0..60).find(|&f| walker_share(f) >= 0.2).unwrap();
    let hidden = (0..60).rfind(|&f| walker_share(f) < 0.1).unwrap();
    let t = Table::of(&dash_out(|f| f >= out));
    for frame in out..60 {
        assert_eq!(t.flag("walker", "target.emerges", frame), (frame <= hidden + 10).into(), "{frame}");
    }
    assert_eq!(t.category("walker", "target.emergence", out), Some("static"));
    // A pedestrian who is first observed long after coming out does not emerge then.
    let late = Table::of(&dash_out(|f| f >= hidden + 12));
    assert_eq!(late.flag("walker", "target.emerges", hidden + 12), False);
}

#[test]
fn a_passing_bus_uncovers_someone_who_stands() {
    let mut d = standing();
    // The bus drives along y = 4; its rear left corner (x - 6, 5.25) frees the sight line to (30, 10).
    add(&mut d, "bus", Bus, (12.0, 2.5), |t| (4.0 + 5.0 * t, 4.0, 0.0));
    add(&mut d, "walker", Pedestrian, (0.6, 0.6), |_| (30.0, 10.0, 0.0));
    let t = Table::of(&d);
    let before = t.num("walker", "target.visible_share", 20);
    near(before, 0.0, 0.0);
    assert_eq!(t.category("walker", "target.occluder", 20), Some("large_vehicle"));
    assert_eq!(t.flag("walker", "target.occluder_moving", 20), True);
    // The ray through (30, 10) has y = 2.75 at x = 8.25, the bus's near side: it leaves the bus when the rear passes
    // the far side's crossing x = 15.75 at y = 5.25, that is x - 6 = 15.75, at 3.55 s.
    let out = (0..60).find(|&f| t.flag("walker", "target.emerges", f) == True).unwrap();
    assert!((35..=38).contains(&out), "{out}");
    assert_eq!(t.category("walker", "target.emergence", out), Some("dynamic"));
}

#[test]
fn a_lead_that_moves_over_uncovers_what_stands_before_it() {
    let shift = |t: f64| 1.75 * (1.0 - (PI * ((t - 2.0).clamp(0.0, 2.0)) / 2.0).cos());
    let mut d = drive(60, |t| (10.0 * t, 0.0, 0.0));
    d.map = Some(crate::scene::road());
    car(&mut d, "lead", move |t| (18.0 + 10.0 * t, shift(t), (shift(t + 0.01) - shift(t - 0.01)).atan2(0.2)));
    add(&mut d, "obstacle", Car, (4.0, 1.8), |_| (70.0, 0.0, 0.0));
    let t = Table::of(&d);
    near(t.num("obstacle", "target.visible_share", 15), 0.0, 0.0);
    assert_eq!(t.flag("obstacle", "target.hidden_by_lead", 15), True);
    let out = (20..60).find(|&f| t.flag("obstacle", "target.emerges", f) == True).unwrap();
    assert_eq!(t.flag("obstacle", "target.hidden_by_lead", out), True);
    assert_eq!(t.category("obstacle", "target.emergence", out), Some("dynamic"));
    assert_eq!(t.flag("obstacle", "target.hidden_by_lead", out + 15), False);
}

#[test]
fn what_the_source_tells_goes_first() {
    let mut d = standing();
    car(&mut d, "near", |_| (10.0, -1.0, 0.0));
    car(&mut d, "far", |_| (30.0, 0.0, 0.0));
    let far = d.tracks.iter_mut().find(|t| t.id.as_str() == "far").unwrap();
    far.visible_share = vec![0.25; 60];
    far.visible_share[1] = f64::NAN;
    far.occluder = vec![None; 60];
    far.occluder[2] = Some("a vehicle never seen".into());
    let t = Table::of(&d);
    near(t.num("far", "target.visible_share", 0), 0.25, 0.0);
    near(t.num("far", "target.visible_share", 1), 0.5, 1e-9);
    assert_eq!(t.category("far", "target.occluder", 2), Some("vehicle"));
    let at_100 = |d: &mut Drive| car(d, "remote", |_| (100.0, 9.0, 0.0));
    at_100(&mut d);
    assert!(Table::of(&d).num("remote", "target.visible_share", 0).is_nan(), "nothing is said beyond 80 m");
}

/// A road along x that meets one along y at (50, 0); the junction is from 40 to 60.
fn crossing() -> RoadMap {
    let mut lanes = vec![
        lane("a0", &[(-200.0, 0.0), (40.0, 0.0)], 7.0),
        lane("a1", &[(40.0, 0.0), (60.0, 0.0)], 7.0),
        lane("a2", &[(60.0, 0.0), (300.0, 0.0)], 7.0),
        lane("c", &[(50.0, -100.0), (50.0, 100.0)], 7.0),
    ];
    lanes[0].successors = vec!["a1".into()];
    lanes[1].successors = vec!["a2".into()];
    RoadMap {
        junctions: vec![area("j", &[(40.0, -10.0), (60.0, -10.0), (60.0, 10.0), (40.0, 10.0)])],
        ..map(lanes)
    }
}

#[test]
fn the_corner_of_a_house_limits_the_view_into_the_cross_road() {
    // At 10 m/s from x = -40: at frame f the eye is at x = f - 40.
    let mut d = drive(100, |t| (10.0 * t - 40.0, 0.0, 0.0));
    let mut m = crossing();
    m.facilities = vec![building(&[(0.0, 7.0), (38.0, 7.0), (38.0, 30.0), (0.0, 30.0)])];
    d.map = Some(m);
    let t = Table::of(&d);
    for frame in [50, 60, 70] {
        // The line past the corner (38, 7), where it meets the arm's middle x = 50 beyond the junction's edge.
        let eye = frame as f64 - 40.0;
        near(t.ego("map.sight_angle", frame), (7.0 / (38.0 - eye)).atan(), 0.01);
    }
    // Still too far away: the front bumper is at least 62 m from the junction.
    assert_eq!(t.ego("map.sight_angle", 14), f64::INFINITY);
    // Level with the corner the arm is seen to its end.
    near(t.ego("map.sight_angle", 80), FRAC_PI_2, 1e-9);
    assert_eq!(t.ego("map.sight_angle", 95), f64::INFINITY, "past its middle it is behind");
    // The house is beside a straight road: it hides nothing of the road itself.
    near(t.ego("map.sight_distance", 60), 150.0, 0.0);
    assert_eq!(t.ego_flag("map.curve_hidden", 60), False);
}

#[test]
fn without_buildings_a_free_view_is_unknown_and_a_parked_lorry_still_cuts_it() {
    let mut d = drive(100, |t| (10.0 * t - 40.0, 0.0, 0.0));
    d.map = Some(crossing());
    assert!(Table::of(&d).ego("map.sight_angle", 60).is_nan());
    d.map.as_mut().unwrap().complete_for = vec!["building".into()];
    near(Table::of(&d).ego("map.sight_angle", 60), FRAC_PI_2, 1e-9);
    d.map.as_mut().unwrap().complete_for.clear();
    // Front right corner at (38, -7), as far out as the house was; 30 m long, so that it hides the arm to its end.
    add(&mut d, "lorry", Truck, (37.0, 20.0), |_| (19.5, -17.0, 0.0));
    near(Table::of(&d).ego("map.sight_angle", 60), (7.0_f64 / 18.0).atan(), 0.01);
    // Without any junction there is none to look into.
    d.map = Some(map(vec![lane("a", &[(-200.0, 0.0), (300.0, 0.0)], 7.0)]));
    assert_eq!(Table::of(&d).ego("map.sight_angle", 60), f64::INFINITY);
}

/// A drive along a straight road over a crest of this radius, highest at x = 100; 20 m/s from x = 0.
fn over_crest(radius: f64) -> Drive {
    let mut d = drive(150, |t| (20.0 * t, 0.0, 0.0));
    let motion = &mut d.ego.as_mut().unwrap().motion;
    motion.z = motion.x.iter().map(|x| 0.8 - (x - 100.0) * (x - 100.0) / (2.0 * radius)).collect();
    d.map = Some(map(vec![lane("a", &[(-200.0, 0.0), (600.0, 0.0)], 7.0)]));
    d
}

#[test]
fn sight_over_a_crest_is_that_of_road_design() {
    // AASHTO Green Book 3.4: on a crest longer than the sight distance, S = sqrt(2 R) (sqrt(h1) + sqrt(h2)), with an
    // eye height of 1.2 m and an object of 0.6 m: 52.9 m for R = 400 m, 118.3 m for R = 2000 m.
    for (radius, crest) in [(400.0_f64, True), (2000.0, False)] {
        let t = Table::of(&over_crest(radius));
        let expected = (2.0 * radius).sqrt() * (1.2_f64.sqrt() + 0.6_f64.sqrt());
        // Looked at in steps of 2 m.
        near(t.ego("map.sight_distance", 30), expected + 1.0, 2.0);
        assert_eq!(t.ego_flag("map.crest_ahead", 30), crest);
    }
}

/// A left bend of 50 m radius with a wall `inside` meters inside of the ego's path all along it.
fn bend(inside: f64) -> Drive {
    let at = |s: f64, r: f64| ((r * (s / 50.0).sin()), 50.0 - r * (s / 50.0).cos());
    let mut d = drive(60, |t| {
        let s = 10.0 * t;
        (at(s, 50.0).0, at(s, 50.0).1, s / 50.0)
    });
    let center: Vec<(f64, f64)> = (0..150).map(|i| at(f64::from(i) - 10.0, 50.0)).collect();
    let wall: Vec<(f64, f64)> = (0..280).map(|i| at(f64::from(i) * 0.5 - 5.0, 50.0 - inside)).collect();
    let back: Vec<(f64, f64)> = (0..280).rev().map(|i| at(f64::from(i) * 0.5 - 5.0, 49.0 - inside)).collect();
    let mut m = map(vec![lane("a", &center, 3.5)]);
    m.facilities = vec![building(&[wall, back].concat())];
    d.map = Some(m);
    d
}

#[test]
fn a_wall_on_the_inside_of_a_bend_cuts_sight() {
    // Where the chord touches the wall: 2 R acos(1 - M / R) along the path, the middle ordinate formula of road design.
    for (inside, hidden) in [(5.0_f64, True), (8.0, False)] {
        let t = Table::of(&bend(inside));
        let expected = 2.0 * 50.0 * (1.0 - inside / 50.0).acos();
        near(t.ego("map.sight_distance", 20), expected, 1.5);
        assert_eq!(t.ego_flag("map.curve_hidden", 20), hidden, "{inside}");
    }
}

#[test]
fn a_lead_cuts_sight_only_when_it_stands_or_is_large() {
    let behind = |class: ObjectClass, speed: f64| {
        let mut d = drive(30, |t| (10.0 * t, 0.0, 0.0));
        d.map = Some(map(vec![lane("a", &[(-200.0, 0.0), (600.0, 0.0)], 7.0)]));
        add(&mut d, "lead", class, (4.0, 2.0), move |t| (40.0 + speed * t, 0.0, 0.0));
        Table::of(&d).ego("map.sight_distance", 0)
    };
    near(behind(Car, 10.0), 150.0, 0.0);
    // Rear ends at 38 m, places a meter apart.
    near(behind(Car, 0.0), 38.0, 1.0);
    near(behind(Truck, 10.0), 38.0, 1.0);
}

#[test]
fn a_parked_lorry_hides_ground_beside_the_path() {
    let mut d = standing();
    add(&mut d, "lorry", Truck, (10.0, 2.5), |_| (12.0, -3.5, 0.0));
    let t = Table::of(&d);
    // The strip: x from 2 to 32, y from -1.3 to -5.3. A place is hidden when some part of the line to it is within the
    // lorry, x from 7 to 17 and y from -2.25 to -4.75.
    let hidden = |x: f64, y: f64| {
        let (from, to) = ((7.0 / x).max(2.25 / -y), (17.0 / x).min(4.75 / -y).min(1.0));
        from < to
    };
    let (mut count, n) = (0, 400);
    for i in 0..n {
        for j in 0..n {
            let (x, y) =
                (2.0 + 30.0 * (f64::from(i) + 0.5) / 400.0, -1.3 - 4.0 * (f64::from(j) + 0.5) / 400.0);
            count += usize::from(hidden(x, y));
        }
    }
    near(t.ego("map.hidden_beside", 0), count as f64 / f64::from(n * n), 0.03);
    assert_eq!(t.ego_category("map.hidden_beside_by", 0), Some("large_vehicle"));
    let empty = Table::of(&standing());
    near(empty.ego("map.hidden_beside", 0), 0.0, 0.0);
    // A lorry whose rear is 60 m before the front bumper, beside the path: at 10 m/s 6 s away, to 2 m.
    let mut drives = drive(100, |t| (10.0 * t, 0.0, 0.0));
    add(&mut drives, "lorry", Truck, (10.0, 2.5), |_| (67.0, -3.8, 0.0));
    let t = Table::of(&drives);
    near(t.ego("map.time_to_hidden_beside", 0), 6.0, 0.2);
    near(t.ego("map.time_to_hidden_beside", 40), 2.0, 0.1);
    near(t.ego("map.time_to_hidden_beside", 62), 0.0, 0.0);
    assert_eq!(t.ego("map.time_to_hidden_beside", 85), f64::INFINITY, "it is behind");
    assert_eq!(empty.ego("map.time_to_hidden_beside", 0), f64::INFINITY);
    assert_eq!(empty.ego_category("map.hidden_beside_by", 0), Some("none"));
}
