//! Junctions, facilities, signs, stop lines, route and context on hand-drawn maps. Expected values are computed in the
//! comments. The ego is 4 m x 2 m, so its front bumper is 2 m ahead of its pose.
use crate::scene::{Table, area, drive, lane, map, near, road};
use std::f64::consts::{FRAC_PI_2, PI};
use whyroad_model::Need;
use whyroad_model::Tri::{False, True, Unknown};
use whyroad_model::road_map::{
    Facility, Lane, LaneMark, LayerState, MapLayer, Point3, RoadMap, Sign, StopLine,
};
use whyroad_model::scene::{ContextState, Drive, LightColor, LightState};

const INF: f64 = f64::INFINITY;

/// A star of roads around (0, 0): for each bearing (deg) a lane in and a lane out, 2 m either side of the arm's axis,
/// from 15 m on; inside, a straight lane from each lane in to each lane out of another arm.
fn star(bearings: &[f64]) -> RoadMap {
    let at = |bearing: f64, r: f64, side: f64| {
        let (s, c) = bearing.to_radians().sin_cos();
        (r * c - side * s, r * s + side * c)
    };
    let mut lanes = Vec::new();
    for (i, &b) in bearings.iter().enumerate() {
        // Right-hand traffic: a vehicle that drives inwards keeps right, which is left of the arm as seen from the
        // center.
        lanes.push(lane(&format!("in{i}"), &[at(b, 150.0, 2.0), at(b, 15.0, 2.0)], 3.5));
        lanes.push(lane(&format!("out{i}"), &[at(b, 15.0, -2.0), at(b, 150.0, -2.0)], 3.5));
        for (j, &other) in bearings.iter().enumerate().filter(|(j, _)| *j != i) {
            let mut inner = lane(&format!("x{i}{j}"), &[at(b, 15.0, 2.0), at(other, 15.0, -2.0)], 3.5);
            inner.in_junction = true;
            inner.predecessors = vec![format!("in{i}")];
            inner.successors = vec![format!("out{j}")];
            lanes.push(inner);
        }
    }
    for i in 0..bearings.len() {
        let others: Vec<usize> = (0..bearings.len()).filter(|j| *j != i).collect();
        let set = |lanes: &mut Vec<Lane>, id: String, f: &dyn Fn(&mut Lane)| {
            f(lanes.iter_mut().find(|l| l.id == id).unwrap());
        };
        set(&mut lanes, format!("in{i}"), &|l| {
            l.successors = others.iter().map(|j| format!("x{i}{j}")).collect();
        });
        set(&mut lanes, format!("out{i}"), &|l| {
            l.predecessors = others.iter().map(|j| format!("x{j}{i}")).collect();
        });
    }
    map(lanes)
}

/// From the west (arm 180 deg) straight on to the east, 10 m/s, at x = -100 first; lanes in from the west are at y =
/// -2.
fn through(m: RoadMap) -> Drive {
    let mut d = drive(200, |t| (-100.0 + 10.0 * t, -2.0, 0.0));
    d.map = Some(m);
    d
}

#[test]
fn arms_and_exits_of_stars() {
    // Arms at 0, 90, 180, 270: an ordinary crossroads; from the west there are three exits.
    let t = Table::of(&through(star(&[0.0, 90.0, 180.0, 270.0])));
    assert_eq!((t.ego("map.junction_arms", 30), t.ego("map.junction_exits", 30)), (4.0, 3.0));
    assert_eq!(t.ego_flag("map.junction_irregular", 30), False);
    // Inside as before it (x = 0 at frame 100); behind it there is none within reach.
    assert_eq!((t.ego("map.junction_arms", 100), t.ego("map.junction_exits", 100)), (4.0, 3.0));
    assert_eq!((t.ego("map.junction_arms", 140), t.ego_flag("map.junction_irregular", 140)), (0.0, False));

    let t = Table::of(&through(star(&[0.0, 70.0, 130.0, 180.0, 270.0])));
    assert_eq!((t.ego("map.junction_arms", 30), t.ego("map.junction_exits", 30)), (5.0, 4.0));
    assert_eq!(t.ego_flag("map.junction_irregular", 30), True, "five arms");
    // A T: two opposite arms and right angles. A Y: none opposite. A fork: 40 deg between two arms.
    for (bearings, irregular) in
        [(&[0.0, 180.0, 270.0][..], False), (&[0.0, 120.0, 180.0 + 55.0], True), (&[0.0, 40.0, 180.0], True)]
    {
        let mut m = star(bearings);
        // The path is straight through whatever the arms are.
        m.lanes.iter_mut().for_each(|l| l.junction_id = Some("j".into()).filter(|_| l.in_junction));
        assert_eq!(Table::of(&through(m)).ego_flag("map.junction_irregular", 95), irregular, "{bearings:?}");
    }
}

#[test]
fn a_junction_that_the_map_states_and_one_that_only_its_lanes_show() {
    // At 10 m/s from x = -100: the area from -15 m on is 83 m ahead of the front at frame 0; at frame 140 (x = 40) it
    // is behind.
    let stated = |state: LayerState| {
        let mut m = star(&[0.0, 90.0, 180.0, 270.0]);
        m.layers.insert(MapLayer::Junctions, state);
        let t = Table::of(&through(m));
        [0, 100, 140].map(|frame| t.ego_flag("map.junction_stated", frame))
    };
    assert_eq!(stated(LayerState::Complete), [True, True, False]);
    assert_eq!(stated(LayerState::Partial), [True, True, False]);
    assert_eq!(stated(LayerState::Derived), [False; 3]);
}

/// From the west along y = 0 to (0, 0), a quarter of a circle of this radius to the left round (0, 15), then north: at
/// arc length `s` from (0, 0).
fn corner(radius: f64, s: f64) -> (f64, f64, f64) {
    let turned = (s / radius).clamp(0.0, FRAC_PI_2);
    let beyond = s - turned * radius;
    let (x, y) = (radius * turned.sin(), 15.0 - radius * turned.cos());
    if s < 0.0 { (s, 15.0 - radius, 0.0) } else { (x, y + beyond, turned) }
}

#[test]
fn a_bend_that_may_be_a_junction_is_none_only_where_the_road_bends() {
    let points = |radius: f64, from: i32, to: i32| -> Vec<(f64, f64)> {
        (from..=to).map(|s| corner(radius, f64::from(s))).map(|(x, y, _)| (x, y)).collect()
    };
    // At 10 m/s, 100 m before the corner at frame 0; the bend of 15 m radius is 23.6 m long.
    let signals = |with_oncoming: bool, state: LayerState| {
        let mut own = lane("own", &points(15.0, -110, 200), 3.5);
        own.successors = vec!["beyond:own".into()];
        let mut lanes = vec![own];
        if with_oncoming {
            // 3.5 m to the left, the other way.
            let mut back = points(11.5, -110, 200);
            back.reverse();
            lanes.insert(0, lane("back", &back, 3.5));
        }
        let mut m = map(lanes);
        m.layers.insert(MapLayer::Junctions, state);
        let mut d = drive(160, |t| corner(15.0, 10.0 * t - 100.0));
        d.map = Some(m);
        let t = Table::of(&d);
        let distance = |frame| t.ego("map.distance_to_junction", frame);
        let doubt = [50, 112].map(|frame| distance(frame).is_nan());
        assert!(distance(150) == INF, "behind it there is none");
        assert_eq!(t.ego_flag("ego.in_junction", 150), False);
        (doubt, t.ego_flag("ego.in_junction", 112), t.ego("map.junction_arms", 50).is_nan())
    };
    assert_eq!(signals(false, LayerState::Derived), ([true; 2], Unknown, true));
    assert_eq!(signals(true, LayerState::Derived), ([false; 2], False, false));
    // A map that states its junctions has none here.
    assert_eq!(signals(false, LayerState::Complete), ([false; 2], False, false));
}

#[test]
fn traffic_from_opposite() {
    // The ego comes from the west: an arm to the east sends traffic against it, also one at 130 deg (DESIGN.md,
    // known traps: opposing arms at 120 degrees), not one at 110 deg.
    for (bearings, opposed) in [
        (&[0.0, 90.0, 180.0, 270.0][..], True),
        (&[90.0, 180.0, 270.0], False),
        (&[40.0, 180.0], True),
        (&[50.0, 180.0], True),
        (&[70.0, 180.0], False),
    ] {
        let mut m = star(bearings);
        m.lanes.iter_mut().for_each(|l| l.junction_id = Some("j".into()).filter(|_| l.in_junction));
        let t = Table::of(&through(m));
        // Before it, and where there is none within reach any more.
        assert_eq!(
            (t.ego_flag("map.opposing_arm", 80), t.ego_flag("map.opposing_arm", 180)),
            (opposed, False),
            "{bearings:?}"
        );
    }
}

#[test]
fn turns_that_the_lane_allows_and_the_route_that_needs_them() {
    // Without stated turns, by geometry: from the west straight on (0), left (90), right (270 deg).
    let m = star(&[0.0, 90.0, 180.0, 270.0]);
    let t = Table::of(&through(m.clone()));
    assert_eq!(t.ego_category("map.lane_turns", 30), Some("any"));
    assert_eq!(t.ego_flag("route.lane_fits", 30), True);
    // A lane for left turns alone, by which the ego nevertheless goes straight on.
    let mut left_only = m;
    left_only.lanes.iter_mut().find(|l| l.id == "in2").unwrap().successors = vec!["x21".into()];
    let t = Table::of(&through(left_only.clone()));
    assert_eq!(t.ego_category("map.lane_turns", 30), Some("left"));
    assert_eq!((t.ego("map.junction_exits", 30), t.ego_flag("route.lane_fits", 30)), (1.0, False));
    // The guidance requires left: then the lane fits.
    let mut d = through(left_only);
    d.ego.as_mut().unwrap().bus.route_command = vec![Some("left".into()); 200];
    let t = Table::of(&d);
    assert_eq!(
        (t.ego_flag("route.lane_fits", 30), t.ego_category("route.command", 30)),
        (True, Some("left"))
    );
    assert!(t.0.unavailable.contains_key("route.distance"));
    // No junction within 300 m: any lane fits.
    let mut d = drive(50, |t| (10.0 * t, 0.0, 0.0));
    d.map = Some(road());
    let t = Table::of(&d);
    assert_eq!(
        (t.ego_flag("route.lane_fits", 10), t.ego_category("map.lane_turns", 10)),
        (True, Some("any"))
    );
}

/// Two lanes along x (y = 0 and 3.5) up to x = 1000, where the right one leaves as a ramp and the left one goes on.
fn parting() -> RoadMap {
    let mut lanes = vec![
        lane("l0", &[(0.0, 3.5), (1000.0, 3.5)], 3.5),
        lane("l1", &[(1000.0, 3.5), (1400.0, 3.5)], 3.5),
        lane("r0", &[(0.0, 0.0), (1000.0, 0.0)], 3.5),
        lane("ramp", &[(1000.0, 0.0), (1200.0, -30.0), (1400.0, -120.0)], 3.5),
    ];
    for (a, b) in [(0, 1), (2, 3)] {
        lanes[a].successors = vec![lanes[b].id.clone()];
        lanes[b].predecessors = vec![lanes[a].id.clone()];
    }
    lanes[0].right_neighbor = Some("r0".into());
    lanes[2].left_neighbor = Some("l0".into());
    map(lanes)
}

#[test]
fn a_lane_that_leaves_the_road_does_not_fit_who_stays_on_it() {
    // At 25 m/s in the right lane; over the line into the left one at x = 850 (t = 34 s), on it behind x = 1000.
    let stays = |t: f64| (25.0 * t, (1.75 * (t - 33.0)).clamp(0.0, 3.5), 0.0);
    let fits = |pose: &dyn Fn(f64) -> (f64, f64, f64), t: usize| {
        let mut d = drive(480, pose);
        d.map = Some(parting());
        Table::of(&d).ego_flag("route.lane_fits", t)
    };
    // 525 m before x = 1000 no lane is required yet; 475 m before, the right one does not fit, the left one does.
    assert_eq!([190, 210, 300, 360].map(|t| fits(&stays, t)), [True, False, False, True]);
    // An ego that takes the ramp fits in the right lane, and does not fit in the left one.
    let bend = |x: f64| {
        if x < 1000.0 { 0.0 } else { -0.15 * (x - 1000.0).min(200.0) - 0.45 * (x - 1200.0).max(0.0) }
    };
    let leaves = |t: f64| (25.0 * t, bend(25.0 * t), 0.0);
    assert_eq!(fits(&leaves, 300), True);
    let late = |t: f64| (25.0 * t, bend(25.0 * t) + (3.5 - 1.75 * (t - 33.0)).clamp(0.0, 3.5), 0.0);
    assert_eq!([300, 380].map(|t| fits(&late, t)), [False, True]);
}

#[test]
fn lights_stop_lines_and_times() {
    let mut m = star(&[0.0, 90.0, 180.0, 270.0]);
    let p = |x: f64, y: f64| Point3 { x, y, z: 0.0 };
    m.stop_lines = vec![StopLine {
        id: "s".into(),
        line: vec![p(-17.0, -4.0), p(-17.0, 0.0)],
        lane_ids: vec!["in2".into()],
    }];
    m.crosswalks = vec![area("c", &[(-20.0, -6.0), (-18.0, -6.0), (-18.0, 6.0), (-20.0, 6.0)])];
    let mut d = through(m);
    let t = Table::of(&d);
    // Frame 30: front at x = -68, 10 m/s.
    near(t.ego("map.distance_to_stop_line", 30), 51.0, 1e-9);
    near(t.ego("map.time_to_stop_line", 30), 5.1, 1e-6);
    near(t.ego("map.time_to_junction", 30), 5.3, 0.06);
    near(t.ego("map.time_to_crosswalk", 30), 4.8, 0.06);
    assert_eq!((t.ego("map.distance_to_stop_line", 100), t.ego("map.time_to_junction", 100)), (INF, 0.0));
    // Lights that nobody recorded may exist.
    assert_eq!(t.ego_flag("map.junction_signalised", 30), Unknown);
    assert_eq!(t.ego_flag("map.junction_signalised", 140), False, "no junction, no light");
    // A map that has all lights: this junction has none, or the one in the map.
    let mut told = d.clone();
    let map = told.map.as_mut().unwrap();
    map.complete_for = vec!["traffic_light".into()];
    assert_eq!(Table::of(&told).ego_flag("map.junction_signalised", 30), False);
    let map = told.map.as_mut().unwrap();
    map.complete_for.clear();
    map.facilities = vec![facility("traffic_light", &[(-16.0, -7.0), (-16.0, -6.0)])];
    assert_eq!(Table::of(&told).ego_flag("map.junction_signalised", 30), True);
    let state = |lane: &str| LightState {
        lane_id: lane.into(),
        to_lane_id: None,
        time: d.times[0],
        color: LightColor::Red,
        countdown_s: None,
    };
    let (here, elsewhere) = (vec![state("in0")], vec![state("far")]);
    d.lights = Some(here);
    let t = Table::of(&d);
    assert_eq!(t.ego_flag("map.junction_signalised", 30), True, "its other approach has a light");
    assert_eq!(t.ego_flag("map.crosswalk_signalised", 30), True);
    d.lights = Some(elsewhere);
    assert_eq!(Table::of(&d).ego_flag("map.junction_signalised", 30), False);
    // At standstill nothing is reached; without any stop line in the map nothing is known of them.
    let mut stands = drive(20, |_| (-60.0, -2.0, 0.0));
    stands.map = d.map;
    stands.map.as_mut().unwrap().stop_lines.clear();
    let t = Table::of(&stands);
    assert_eq!(t.ego("map.time_to_junction", 10), INF);
    assert!(t.ego("map.distance_to_stop_line", 10).is_nan() && t.ego("map.time_to_stop_line", 10).is_nan());
}

#[test]
fn guidance_lines_inside_a_junction() {
    let mut m = star(&[0.0, 90.0, 180.0, 270.0]);
    let inner = |m: &mut RoadMap, left, right| {
        let l = m.lanes.iter_mut().find(|l| l.id == "x20").unwrap();
        (l.left_mark, l.right_mark) = (left, right);
    };
    assert_eq!(Table::of(&through(m.clone())).ego_flag("map.on_guidance", 100), Unknown);
    inner(&mut m, LaneMark::None, LaneMark::Dashed);
    let t = Table::of(&through(m.clone()));
    assert_eq!((t.ego_flag("map.on_guidance", 100), t.ego_flag("map.on_guidance", 30)), (True, False));
    inner(&mut m, LaneMark::None, LaneMark::None);
    assert_eq!(Table::of(&through(m)).ego_flag("map.on_guidance", 100), False);
}

fn facility(kind: &str, corners: &[(f64, f64)]) -> Facility {
    Facility {
        id: format!("{kind}{}", corners[0].0),
        kind: kind.into(),
        boundary: area("", corners).boundary,
    }
}

fn strip(kind: &str, from: f64, to: f64) -> Facility {
    facility(kind, &[(from, -3.0), (to, -3.0), (to, 9.0), (from, 9.0)])
}

#[test]
fn facilities_on_the_path_and_those_that_nobody_drew() {
    let mut m = road();
    m.facilities = vec![
        strip("tunnel", 60.0, 90.0),
        facility("speed_bump", &[(50.0, -2.0), (50.0, 2.0)]),
        // A bump on the oncoming lane only.
        facility("speed_bump", &[(30.0, 5.0), (30.0, 9.0)]),
        strip("toll_plaza", 100.0, 140.0),
        facility("toll_etc", &[(120.0, -2.0), (120.0, 2.0)]),
        facility("toll_manual", &[(120.0, 3.0), (120.0, 5.0)]),
        strip("construction", 0.0, 10.0),
    ];
    m.complete_for = vec!["gate".into()];
    let mut d = drive(200, |t| (10.0 * t, 0.0, 0.0));
    d.map = Some(m);
    let t = Table::of(&d);
    // Frame 20: front at 22.
    near(t.ego("map.distance_to_speed_bump", 20), 28.0, 1e-9);
    near(t.ego("map.distance_to_tunnel", 20), 38.0, 1e-9);
    near(t.ego("map.distance_to_toll", 20), 98.0, 1e-9);
    assert_eq!(t.ego_category("map.toll_kind", 20), Some("etc"), "the booth in its lane, not the plaza");
    near(t.ego("map.distance_to_toll", 130), 0.0, 1e-9);
    assert_eq!(t.ego_category("map.toll_kind", 130), Some("plaza"), "the booth is behind");
    assert_eq!(t.ego_category("map.toll_kind", 150), Some("none"));
    assert_eq!((t.ego_flag("map.in_tunnel", 59), t.ego_flag("map.in_tunnel", 75)), (False, True));
    assert_eq!((t.ego("map.distance_to_tunnel", 75), t.ego("map.distance_to_tunnel", 95)), (0.0, INF));
    assert_eq!((t.ego_flag("map.in_construction", 5), t.ego_flag("map.in_construction", 15)), (True, False));
    // The map has all gates: there is none. It has no data on accidents and roundabouts.
    assert_eq!(t.ego("map.distance_to_gate", 20), INF);
    for name in ["map.distance_to_accident", "map.in_roundabout", "map.distance_to_barrier_gap"] {
        assert!(t.0.unavailable.contains_key(name), "{name}");
    }
    d.map = Some(road());
    assert_eq!(Table::of(&d).0.unavailable["map.in_tunnel"], [Need::Facilities]);
}

/// Works and crashes that leave the middle of the lane free, and an opening in the barrier, are beside the path.
#[test]
fn what_stands_beside_the_path_counts_where_it_bears_on_it() {
    let beside = |kind: &str, near: f64, far: f64| {
        facility(kind, &[(100.0, near), (120.0, near), (120.0, far), (100.0, far)])
    };
    let mut m = road();
    m.facilities = vec![
        beside("construction", -4.0, -1.5),
        beside("accident", 3.5, 6.0),
        beside("tunnel", -4.0, -1.5),
        facility("barrier_gap", &[(130.0, 6.0), (136.0, 6.0)]),
    ];
    let mut d = drive(200, |t| (10.0 * t, 0.0, 0.0));
    d.map = Some(m);
    let t = Table::of(&d);
    // Frame 20: front at 22. To half a meter.
    near(t.ego("map.distance_to_construction", 20), 78.0, 0.5);
    assert_eq!(
        (t.ego_flag("map.in_construction", 110), t.ego_flag("map.in_construction", 125)),
        (True, False)
    );
    assert_eq!(t.ego("map.distance_to_accident", 20), INF, "farther than 3 m beside the path");
    assert_eq!(t.ego("map.distance_to_tunnel", 20), INF, "nobody drives through it");
    near(t.ego("map.distance_to_barrier_gap", 20), 108.0, 0.5);
    near(t.ego("map.time_to_barrier_gap", 20), 10.8, 0.06);
}

/// The road ahead of the last row may climb, by 6 % in this test: 80 m on it is 4.8 m higher. Three times that is
/// another level.
#[test]
fn a_facility_beyond_the_last_row_may_lie_higher() {
    for (height, distance) in [(4.8, 80.0 - 2.0), (14.4, INF)] {
        let mut m = road();
        let mut bump = facility("speed_bump", &[(100.0, -2.0), (100.0, 2.0)]);
        bump.boundary.iter_mut().for_each(|p| p.z = height);
        m.facilities = vec![bump];
        let mut d = drive(21, |t| (10.0 * t, 0.0, 0.0));
        d.map = Some(m);
        assert_eq!(Table::of(&d).ego("map.distance_to_speed_bump", 20), distance, "{height} m");
    }
}

/// A ring of radius 20 m around (100, 20) that the ego enters at (100, 0) and follows for half a turn, two lanes wide.
#[test]
fn a_roundabout() {
    let ring = |r: f64| -> Vec<(f64, f64)> {
        (0..=36)
            .map(|i| f64::from(i) * PI / 36.0 - FRAC_PI_2)
            .map(|a| (100.0 + r * a.cos(), 20.0 + r * a.sin()))
            .collect()
    };
    let mut outer = lane("outer", &ring(20.0), 3.5);
    let mut inner = lane("inner", &ring(16.5), 3.5);
    outer.left_neighbor = Some("inner".into());
    inner.right_neighbor = Some("outer".into());
    let mut m = map(vec![lane("a", &[(0.0, 0.0), (100.0, 0.0)], 3.5), outer, inner]);
    m.lanes[0].successors = vec!["outer".into()];
    let circle: Vec<(f64, f64)> = (0..72)
        .map(|i| f64::from(i) * PI / 36.0)
        .map(|a| (100.0 + 22.0 * a.cos(), 20.0 + 22.0 * a.sin()))
        .collect();
    m.facilities = vec![facility("roundabout", &circle)];
    // 10 m/s along x, then around at radius 20: half a turn is 62.8 m.
    let pose = |t: f64| {
        let s = 10.0 * t;
        let a = ((s - 100.0) / 20.0).clamp(0.0, PI);
        if s < 100.0 { (s, 0.0, 0.0) } else { (100.0 + 20.0 * a.sin(), 20.0 - 20.0 * a.cos(), a) }
    };
    let mut d = drive(160, pose);
    d.map = Some(m);
    let t = Table::of(&d);
    // The outline crosses y = 0 at x = 100 - sqrt(22^2 - 20^2) = 90.83 (chords of 5 deg: a few centimeters less).
    let entry = 100.0 - 84.0_f64.sqrt();
    near(t.ego("map.distance_to_roundabout", 40), entry - 42.0, 0.1);
    assert_eq!((t.ego_flag("map.in_roundabout", 88), t.ego_flag("map.in_roundabout", 93)), (False, True));
    assert_eq!((t.ego_flag("map.in_roundabout", 130), t.ego("map.distance_to_roundabout", 130)), (True, 0.0));
    assert_eq!((t.ego("map.roundabout_lanes", 40), t.ego("map.roundabout_lanes", 130)), (2.0, 2.0));
    // One that lies above the ego's road is not on its way: the levels of an interchange are at least 5 m apart.
    for corner in &mut d.map.as_mut().unwrap().facilities[0].boundary {
        corner.z = 6.5;
    }
    let t = Table::of(&d);
    assert_eq!((t.ego_flag("map.in_roundabout", 130), t.ego("map.roundabout_lanes", 130)), (False, 0.0));
}

/// A road through the island of a ring of radius 40 m, 4 m beside its middle: who keeps to it drives round nothing.
#[test]
fn a_road_through_the_middle_of_a_roundabout() {
    let circle = |radius: f64| -> Vec<(f64, f64)> {
        (0..72)
            .map(|i| f64::from(i) * PI / 36.0)
            .map(|a| (100.0 + radius * a.cos(), 4.0 + radius * a.sin()))
            .collect()
    };
    let mut d = drive(160, |t: f64| (10.0 * t, 0.0, 0.0));
    let mut m = map(vec![lane("a", &[(0.0, 0.0), (200.0, 0.0)], 3.5)]);
    m.facilities = vec![facility("roundabout", &circle(40.0))];
    d.map = Some(m);
    let t = Table::of(&d);
    assert_eq!(
        (t.ego_flag("map.in_roundabout", 100), t.ego("map.distance_to_roundabout", 40)),
        (False, f64::INFINITY)
    );
    // Over the edge of a ring of radius 5 m, whose middle is 4 m away, it goes round that.
    d.map.as_mut().unwrap().facilities = vec![facility("roundabout", &circle(5.0))];
    assert_eq!(Table::of(&d).ego_flag("map.in_roundabout", 100), True);
}

/// A map of three lanes along x, of which the middle one is 0.6 m long, as where a stop line cuts a lane off: who
/// drives at 10 m/s is at 50 m and then at 51 m, and in no frame on it.
#[test]
fn a_sign_of_a_lane_that_the_ego_passes_over() {
    let mut m = map(vec![
        lane("a", &[(0.0, 0.0), (50.2, 0.0)], 3.5),
        lane("piece", &[(50.2, 0.0), (50.8, 0.0)], 3.5),
        lane("c", &[(50.8, 0.0), (150.0, 0.0)], 3.5),
    ]);
    for (from, to) in [(0, 1), (1, 2)] {
        let (left, right) = (m.lanes[from].id.clone(), m.lanes[to].id.clone());
        m.lanes[from].successors.push(right);
        m.lanes[to].predecessors.push(left);
    }
    let sign = |id: &str, x: f64, of: &str| Sign {
        id: id.into(),
        kind: "stop".into(),
        position: Point3 { x, y: -4.0, z: 2.0 },
        lane_ids: vec![of.into()],
        value: None,
        facing: None,
    };
    m.signs = vec![sign("1", 51.0, "piece")];
    let mut d = drive(120, |t| (10.0 * t, 0.0, 0.0));
    d.map = Some(m);
    // Frame 20: front at 22.
    near(Table::of(&d).ego("sign.stop_distance", 20), 29.0, 1e-9);
}

#[test]
fn the_next_sign_of_the_ego_s_own_lanes() {
    let sign = |id: &str, kind: &str, x: f64, y: f64, lanes: &[&str]| Sign {
        id: id.into(),
        kind: kind.into(),
        position: Point3 { x, y, z: 2.0 },
        lane_ids: lanes.iter().map(|l| (*l).into()).collect(),
        value: None,
        facing: None,
    };
    let mut m = road();
    m.signs = vec![
        sign("1", "stop", 30.0, 12.0, &["o"]),
        sign("2", "stop", 80.0, -4.0, &["r0"]),
        sign("3", "yield", 60.0, -30.0, &[]),
        sign("4", "warning", 70.0, -5.0, &[]),
        sign("5", "speed_limit", 400.0, -5.0, &["r1"]),
    ];
    let mut d = drive(120, |t| (10.0 * t, 0.0, 0.0));
    d.map = Some(m);
    let t = Table::of(&d);
    // Frame 20: front at 22. The first stop sign is for the oncoming lane; the yield sign stands on another road.
    near(t.ego("sign.stop_distance", 20), 58.0, 1e-9);
    near(t.ego("sign.warning_distance", 20), 48.0, 1e-9);
    assert_eq!((t.ego("sign.yield_distance", 20), t.ego("sign.stop_distance", 90)), (INF, INF));
    assert_eq!(t.ego("sign.speed_limit_distance", 20), INF, "more than 150 m away");
    assert!(t.0.unavailable.contains_key("sign.prohibition_distance"), "the map has none of that kind");
}

#[test]
fn context_holds_by_time_also_across_a_gap() {
    let mut d = drive(100, |t| (10.0 * t, 0.0, 0.0));
    // 4 s of frames are missing: frame 50 is at 9 s.
    d.times[50..].iter_mut().for_each(|t| *t = t.plus_secs(4.0));
    let at = |s: f64| d.times[0].plus_secs(s);
    let state = |s: f64, kind: &str, value: &str| ContextState {
        time: at(s),
        kind: kind.into(),
        value: value.into(),
        source: "log".into(),
        confidence: None,
    };
    d.context = Some(vec![
        state(-1.0, "lighting", "day"),
        // In the gap, 2 s before frame 50.
        state(7.0, "lighting", "tunnel"),
        state(12.0, "lighting", "unknown"),
        state(1.0, "weather", "rain"),
        state(0.0, "visibility", "150"),
        state(0.0, "nav_speed_limit", "16.67"),
        state(0.0, "route_distance", "320"),
        state(0.0, "warning_light", "flashing_yellow"),
        state(2.0, "construction", "here"),
    ]);
    let t = Table::of(&d);
    assert_eq!(t.ego_category("context.weather", 9), None, "before it is told it is not known");
    assert_eq!(t.ego_category("context.weather", 10), Some("rain"));
    assert_eq!(t.ego_category("context.lighting", 49), Some("day"));
    assert_eq!(t.ego_category("context.lighting", 50), Some("tunnel"));
    // The change at 7 s is reported until 10 s: frames 50 to 60. From 2 s on it is known that nothing changed.
    let change = |i: usize| t.ego_flag("context.lighting_change", i);
    assert_eq!((change(10), change(30), change(49)), (Unknown, False, False));
    assert_eq!((change(50), change(60), change(61)), (True, True, False));
    assert_eq!((t.ego_category("context.lighting", 80), change(80)), (None, Unknown));
    near(t.ego("context.visibility", 20), 150.0, 0.0);
    near(t.ego("nav.speed_limit", 20), 16.67, 0.0);
    near(t.ego("route.distance", 20), 320.0, 0.0);
    assert_eq!(t.ego_category("context.warning_light", 20), Some("flashing_yellow"));
    // Road works are reported without a map; they are known only from when they are reported.
    assert_eq!(
        (t.ego_category("context.construction", 20), t.ego_category("context.construction", 19)),
        (Some("here"), None)
    );
    for name in ["context.surface", "context.road_type", "context.pavement", "context.accident", "gate.state"]
    {
        assert!(t.0.unavailable.contains_key(name), "{name}");
    }
}
