//! The road ahead of the ego on hand-drawn roads: grade, widths, lanes that end, limits, ramps, free space. Expected
//! values are computed in the comments. The ego is 4 m x 2 m, so its front bumper is 2 m ahead of its pose.
use crate::scene::{Table, add, car, drive, lane, map, near, road};
use std::f64::consts::PI;
use whyroad_model::Need;
use whyroad_model::ObjectClass::{Car, Pedestrian};
use whyroad_model::Tri::{False, True, Unknown};
use whyroad_model::road_map::{Lane, LaneKind, LaneMark, Point3};

const INF: f64 = f64::INFINITY;

fn straight(id: &str, from: f64, to: f64, y: f64) -> Lane {
    lane(id, &[(from, y), ((from + to) / 2.0, y), (to, y)], 3.5)
}

fn link(lanes: &mut [Lane], from: &str, to: &str) {
    lanes.iter_mut().find(|l| l.id == from).unwrap().successors.push(to.into());
    lanes.iter_mut().find(|l| l.id == to).unwrap().predecessors.push(from.into());
}

fn beside(lanes: &mut [Lane], left: &str, right: &str) {
    lanes.iter_mut().find(|l| l.id == left).unwrap().right_neighbor = Some(right.into());
    lanes.iter_mut().find(|l| l.id == right).unwrap().left_neighbor = Some(left.into());
}

fn tag(lanes: &mut [Lane], id: &str, tag: &str) {
    lanes.iter_mut().find(|l| l.id == id).unwrap().tags.push(tag.into());
}

#[test]
fn a_ramp_of_five_percent() {
    // Flat to x = 100, then up 5 m on 100 m, then flat.
    let height = |x: f64| (x.clamp(100.0, 200.0) - 100.0) * 0.05;
    let mut hill = lane("a", &(-5..=40).map(|i| (f64::from(i) * 10.0, 0.0)).collect::<Vec<_>>(), 3.5);
    hill.center.iter_mut().for_each(|p| p.z = height(p.x));
    let mut d = drive(200, |t| (10.0 * t, 0.0, 0.0));
    let ego = d.ego.as_mut().unwrap();
    for (z, x) in ego.motion.z.iter_mut().zip(&ego.motion.x) {
        *z = height(*x) + 0.8;
    }
    let mut with_map = d.clone();
    with_map.map = Some(map(vec![hill]));
    let t = Table::of(&with_map);
    near(t.ego("map.grade", 20), 0.0, 1e-9);
    near(t.ego("map.grade", 150), 0.05, 1e-9);
    // At x = 100 the chord from 95 to 105 rises 0.25 m.
    near(t.ego("map.grade", 100), 0.025, 1e-9);
    // From x = 20 the look-ahead extends to 80; from x = 50 to 110, where the chord is completely on the slope.
    near(t.ego("map.grade_ahead", 20), 0.0, 1e-9);
    near(t.ego("map.grade_ahead", 50), 0.05, 1e-9);
    // Down the other way: the same with the other sign.
    let mut back = with_map.clone();
    let lane = &mut back.map.as_mut().unwrap().lanes[0];
    [&mut lane.center, &mut lane.left, &mut lane.right].into_iter().for_each(|l| l.reverse());
    std::mem::swap(&mut lane.left, &mut lane.right);
    let ego = back.ego.as_mut().unwrap();
    ego.motion.x.reverse();
    ego.motion.z.reverse();
    ego.motion.heading.fill(PI);
    ego.motion.vx.iter_mut().for_each(|v| *v = -*v);
    // Frame 49 is at x = 150.
    near(Table::of(&back).ego("map.grade", 49), -0.05, 1e-9);
    // Without stated heights there is no grade, not a flat road.
    let mut flat = with_map;
    flat.ego.as_mut().unwrap().motion.z.fill(f64::NAN);
    flat.map.as_mut().unwrap().lanes[0].center.iter_mut().for_each(|p: &mut Point3| p.z = f64::NAN);
    assert_eq!(Table::of(&flat).0.unavailable["map.grade"], [Need::Elevation]);
}

/// Three lanes to the east: right r (y = 0) that ends at x = 100, middle m, left l; then m2 and l2.
fn lane_drop() -> Vec<Lane> {
    let mut lanes = vec![
        straight("r", -100.0, 100.0, 0.0),
        straight("m", -100.0, 100.0, 3.5),
        straight("m2", 100.0, 500.0, 3.5),
        straight("l", -100.0, 100.0, 7.0),
        straight("l2", 100.0, 500.0, 7.0),
    ];
    for (left, right) in [("m", "r"), ("l", "m"), ("l2", "m2")] {
        beside(&mut lanes, left, right);
    }
    for (from, to) in [("m", "m2"), ("l", "l2")] {
        link(&mut lanes, from, to);
    }
    lanes
}

#[test]
fn a_lane_that_ends_beside_others_that_go_on() {
    let in_right = |t: f64| (10.0 * t, 0.0, 0.0);
    let mut d = drive(80, in_right);
    d.map = Some(map(lane_drop()));
    let t = Table::of(&d);
    // At 2 s the front is at 22, the end at 100.
    near(t.ego("map.lane_ends", 20), 78.0, 1e-9);
    near(t.ego("map.distance_to_merge", 20), 78.0, 1e-9);
    assert_eq!(t.ego_category("map.merge_zone", 20), Some("lane_drop"));
    // 100 m ahead of x = 22 there are two lanes; here three.
    assert_eq!((t.ego("map.lane_count", 20), t.ego("map.lane_count_ahead", 20)), (3.0, 2.0));
    assert_eq!(t.ego("map.dead_end_distance", 20), INF);
    let mut d = drive(80, |t| (10.0 * t, 3.5, 0.0));
    d.map = Some(map(lane_drop()));
    let t = Table::of(&d);
    assert_eq!((t.ego("map.lane_ends", 20), t.ego_category("map.merge_zone", 20)), (INF, Some("none")));
    assert_eq!(t.ego_category("map.left_lane", 20), Some("same"));
}

#[test]
fn an_acceleration_lane_that_becomes_one_with_its_neighbor() {
    // The ramp (from the right) becomes the added lane a, which bends into m2 at its end as SUMO's maps have it.
    let mut lanes = lane_drop();
    lanes[0] = lane("r", &[(-100.0, 0.0), (80.0, 0.0), (100.0, 3.5)], 3.5);
    beside(&mut lanes, "m", "r");
    link(&mut lanes, "r", "m2");
    lanes.push(lane("ramp", &[(-300.0, -60.0), (-100.0, 0.0)], 3.5));
    link(&mut lanes, "ramp", "r");
    tag(&mut lanes, "ramp", "ramp");
    let slope: f64 = 60.0 / 200.0;
    // 10 m a second in x: on the ramp until x = -100, at 10 s; changes to the middle lane between 15 and 18 s.
    let pose = |t: f64| {
        let x = -200.0 + 10.0 * t;
        let ramp = (x + 100.0).min(0.0) * slope;
        let shift = 1.75 * (1.0 - (PI * ((t - 15.0) / 3.0).clamp(0.0, 1.0)).cos());
        (x, ramp + shift, if x < -100.0 { slope.atan() } else { 0.0 })
    };
    let mut d = drive(260, pose);
    d.map = Some(map(lanes.clone()));
    let t = Table::of(&d);
    assert_eq!((t.ego_flag("map.on_ramp", 50), t.ego_flag("map.on_ramp", 130)), (True, False));
    assert_eq!(t.ego_category("map.merge_zone", 50), Some("none"));
    assert_eq!(t.ego_category("map.merge_zone", 130), Some("acceleration"));
    // Frame 149: x = -51, front at -49. To its end at x = 100 the lane has 129 + hypot(20, 3.5) m left, just within
    // 150 m.
    let left = 80.0 + 49.0 + 20.0_f64.hypot(3.5);
    near(t.ego("map.lane_ends", 149), left, 0.01);
    near(t.ego("map.distance_to_merge", 149), left, 0.01);
    assert_eq!(t.ego("map.lane_ends", 148), INF);
    // With a tag on the added lane, the change to the main road is where the ego changes out of it, not where the
    // ramp ends.
    let mut tagged = lanes;
    tag(&mut tagged, "r", "acceleration");
    d.map = Some(map(tagged));
    let t = Table::of(&d);
    let (first, last) = t.span("map.facility_change", "ramp_to_main").unwrap();
    // It changes lanes half way, at 16.5 s, with a tolerance for the hysteresis; reported for 1 s on either side.
    assert!((150..=162).contains(&first) && last - first == 20, "{first} {last}");
    assert!(t.span("map.facility_change", "main_to_ramp").is_none());
    // A map without tags does not show its ramps.
    d.map = Some(map(lane_drop()));
    assert!(Table::of(&d).0.unavailable.contains_key("map.on_ramp"));
}

#[test]
fn an_exit_and_a_fork() {
    // r leads to the exit e, m and l go on.
    let mut lanes = lane_drop();
    lanes.push(lane("e", &[(100.0, 0.0), (300.0, -40.0)], 3.5));
    link(&mut lanes, "r", "e");
    tag(&mut lanes, "e", "ramp");
    let mut d = drive(80, |t| (10.0 * t, 3.5, 0.0));
    d.map = Some(map(lanes));
    let t = Table::of(&d);
    // Frame 30: front at 32.
    near(t.ego("map.distance_to_split", 30), 68.0, 1e-9);
    assert_eq!((t.ego("map.lane_ends", 30), t.ego("map.distance_to_merge", 30)), (INF, INF));
    let mut plain = drive(80, |t| (10.0 * t, 3.5, 0.0));
    plain.map = Some(map(lane_drop()));
    assert_eq!(Table::of(&plain).ego("map.distance_to_split", 30), INF);
}

/// The exit lane r, which leads through a joint of 15 m to the ramp e, with m and m2 beside it; the road is there
/// before x = -100 as well, as two lanes.
fn exit() -> Vec<Lane> {
    let mut lanes = lane_drop();
    lanes.push(Lane { in_junction: true, ..straight("j", 100.0, 115.0, 0.0) });
    lanes.push(lane("e", &[(115.0, 0.0), (315.0, -40.0)], 3.5));
    lanes.push(straight("m0", -400.0, -100.0, 3.5));
    for (from, to) in [("r", "j"), ("j", "e"), ("m0", "m")] {
        link(&mut lanes, from, to);
    }
    tag(&mut lanes, "e", "ramp");
    lanes
}

#[test]
fn a_deceleration_lane_begins_beside_a_through_lane_and_leads_to_the_ramp_only() {
    let zone = |lanes: Vec<Lane>| {
        let mut d = drive(80, |t| (10.0 * t, 0.0, 0.0));
        d.map = Some(map(lanes));
        Table::of(&d).ego_category("map.merge_zone", 20).map(str::to_owned)
    };
    assert_eq!(zone(exit()).as_deref(), Some("deceleration"));
    // From lane r one may stay on the main road too.
    let mut either = exit();
    either.push(straight("r2", 100.0, 500.0, 0.0));
    link(&mut either, "r", "r2");
    assert_eq!(zone(either).as_deref(), Some("none"));
    // All lanes begin at x = -100: there the map does.
    let mut cut = exit();
    cut.retain(|l| l.id != "m0");
    cut.iter_mut().for_each(|l| l.predecessors.retain(|p| p != "m0"));
    assert_eq!(zone(cut).as_deref(), Some("none"));
}

#[test]
fn an_exit_begins_where_the_ego_leaves_the_main_road() {
    // 10 m/s along r, which its center leaves at 10 s, through the joint until 11.5 s, and on along the ramp.
    let slope = 40.0_f64 / 200.0;
    let mut d = drive(150, |t| {
        let x = 10.0 * t;
        (x, -(x - 115.0).max(0.0) * slope, if x < 115.0 { 0.0 } else { -slope.atan() })
    });
    d.map = Some(map(exit()));
    let (first, last) = Table::of(&d).span("map.facility_change", "main_to_ramp").unwrap();
    // Reported from 1 s before until 1 s after, with a tolerance of one frame.
    assert!((89..=91).contains(&first) && (124..=126).contains(&last), "{first} {last}");
}

#[test]
fn the_end_of_the_road_and_the_end_of_the_map() {
    let mut d = drive(60, |t| (10.0 * t, 0.0, 0.0));
    d.map = Some(map(vec![straight("a", -50.0, 100.0, 0.0)]));
    near(Table::of(&d).ego("map.dead_end_distance", 20), 78.0, 1e-9);
    let mut leaves = straight("a", -50.0, 100.0, 0.0);
    leaves.successors = vec!["beyond".into()];
    d.map = Some(map(vec![leaves.clone()]));
    assert!(Table::of(&d).ego("map.dead_end_distance", 20).is_nan(), "the map ends, the road does not");
    // The look-ahead is 150 m: from x = -152 the end is farther.
    leaves.successors.clear();
    let mut far = drive(10, |t| (-48.0 + t, 0.0, 0.0));
    leaves.center[2].x = 200.0;
    far.map = Some(map(vec![leaves]));
    assert_eq!(Table::of(&far).ego("map.dead_end_distance", 0), INF);
}

#[test]
fn limits_kinds_and_marks_are_the_maps() {
    let mut m = road();
    for (id, limit) in [("r0", 13.89), ("r1", 8.33), ("l0", 13.89), ("l1", 8.33)] {
        m.lanes.iter_mut().find(|l| l.id == id).unwrap().speed_limit_mps = Some(limit);
    }
    m.lanes[3].left_mark = LaneMark::Dashed;
    m.lanes[3].right_mark = LaneMark::Solid;
    m.lanes[0].kind = LaneKind::Bus;
    let mut d = drive(150, |t| (10.0 * t, 0.0, 0.0));
    d.map = Some(m);
    let t = Table::of(&d);
    near(t.ego("map.speed_limit", 50), 13.89, 1e-12);
    near(t.ego("map.speed_limit_ahead", 50), 8.33, 1e-12);
    // The joint is at 100, the front at 52.
    near(t.ego("map.distance_to_limit_change", 50), 48.0, 1e-9);
    near(t.ego("map.speed_limit_ahead", 120), 8.33, 1e-12);
    assert_eq!(t.ego("map.distance_to_limit_change", 120), INF);
    assert_eq!(t.ego_category("map.left_lane", 50), Some("bus"));
    assert_eq!(t.ego_category("map.right_lane", 50), Some("none"));
    assert_eq!(t.ego_category("map.left_mark", 50), Some("dashed"));
    assert_eq!((t.ego_flag("map.lane_marked", 50), t.ego_flag("map.lane_marked", 120)), (True, Unknown));
    assert_eq!(t.ego_category("map.left_mark", 120), None, "not stated is not unmarked");
    assert_eq!(t.ego_category("map.lane_kind", 50), Some("vehicle"));
    // A map with a bus lane tells bus lanes; nothing tells tidal and variable ones.
    assert_eq!(t.ego_flag("map.bus_lane", 50), False);
    assert!(
        !t.0.frame_columns.contains_key("map.tidal_lane")
            && !t.0.frame_columns.contains_key("map.variable_lane")
    );
    // The left lane's left neighbor is the oncoming one.
    let mut d = drive(100, |t| (10.0 * t, 3.5, 0.0));
    d.map = Some(road());
    let t = Table::of(&d);
    assert_eq!(t.ego_category("map.left_lane", 50), Some("opposite"));
    assert!(t.ego("map.speed_limit", 50).is_nan() && t.ego("map.speed_limit_ahead", 50).is_nan());
    near(t.ego("map.lane_width_ahead", 50), 3.5, 1e-9);
}

#[test]
fn a_lane_that_narrows() {
    // 3.5 m wide to x = 100, then from 100 to 120 down to 2.5 m.
    let mut a = lane("a", &[(-50.0, 0.0), (100.0, 0.0), (120.0, 0.0), (300.0, 0.0)], 3.5);
    for (i, half) in [1.75, 1.75, 1.25, 1.25].into_iter().enumerate() {
        (a.left[i].y, a.right[i].y) = (half, -half);
    }
    let mut d = drive(150, |t| (10.0 * t, 0.0, 0.0));
    d.map = Some(map(vec![a]));
    let t = Table::of(&d);
    // 50 m from the front (x + 2): from x = 40 to 92, from x = 90 to 142.
    // Widths are the least distances to the edges: near the slant a millimeter less than across.
    near(t.ego("map.lane_width_ahead", 40), 3.5, 2e-3);
    near(t.ego("map.lane_width_ahead", 90), 2.5, 2e-3);
}

#[test]
fn room_between_two_boxes() {
    // Lanes at y = 0 and 3.5 (and one oncoming at 7): the road's edges are at -1.75 and 8.75.
    let mut d = drive(80, |t| (10.0 * t, 0.0, 0.0));
    d.map = Some(road());
    let t = Table::of(&d);
    // The ego's sides are at 1 and -1. On the left 7.75 m, on the right 0.75 m; together with its width 10.5 m.
    near(t.ego("map.free_width_left", 20), 7.75, 0.02);
    near(t.ego("map.free_width_right", 20), 0.75, 0.02);
    near(t.ego("map.free_width_ahead", 20), 10.5, 0.03);

    // Parked on the left at x = 60 (58 to 62), its right side at 2.2; something on the right of 0.5 m width at -1.4.
    car(&mut d, "left", |_| (60.0, 3.2, 0.0));
    add(&mut d, "right", Pedestrian, (0.5, 0.5), |_| (60.0, -1.65, 0.0));
    // Far ahead, and moving along: neither narrows the way at x = 20.
    car(&mut d, "along", |t| (40.0 + 10.0 * t, 1.9, 0.0));
    // Oncoming on the left, right side at 3.5 - 1: narrows it as long as it is within 40 m ahead.
    car(&mut d, "oncoming", |t| (200.0 - 10.0 * t, 3.5, PI));
    let t = Table::of(&d);
    // Between 2.2 and -1.4.
    near(t.ego("map.free_width_ahead", 30), 3.6, 1e-6);
    // At 6 s the ego is beside both: 1.2 m and 0.4 m from its sides.
    near(t.ego("map.free_width_left", 60), 1.2, 1e-6);
    near(t.ego("map.free_width_right", 60), 0.4, 1e-6);
    // At 7 s they are behind; the oncoming car is at 130, 56 m ahead of the front at 72: free again.
    near(t.ego("map.free_width_ahead", 70), 10.5, 0.03);
    // Frame 78: ego front at 80, the car at 122 with its near end at 120: its side 2.5 left, the edge 1.75 right.
    near(t.ego("map.free_width_ahead", 78), 4.25, 0.03);
    // For a meeting only stationary objects count: the same two at 30, the whole road at 78, where only the oncoming
    // car is ahead.
    near(t.ego("map.meeting_width_ahead", 30), 3.6, 1e-6);
    near(t.ego("map.meeting_width_ahead", 78), 10.5, 0.03);

    // A car across the path where it was really driven had left before the ego came.
    let mut d = drive(80, |t| (10.0 * t, 0.0, 0.0));
    d.map = Some(road());
    add(&mut d, "crosses", Car, (4.0, 2.0), |t| (60.0, -8.0 + 4.0 * t, PI / 2.0));
    near(Table::of(&d).ego("map.free_width_ahead", 20), 10.5, 0.03);
    assert_eq!(Table::of(&d).ego_flag("map.crosswalk_signalised", 20), False);
}

/// A weaving lane w from x = 0 to 300 to the right of the main lane m, which goes on from -300 to 600; a ramp comes
/// onto w and another leaves it.
fn weaving() -> Vec<Lane> {
    let mut lanes = vec![
        lane("before", &[(-300.0, 3.5), (0.0, 3.5)], 3.5),
        lane("m", &[(0.0, 3.5), (300.0, 3.5)], 3.5),
        lane("after", &[(300.0, 3.5), (600.0, 3.5)], 3.5),
        lane("w", &[(0.0, 0.0), (300.0, 0.0)], 3.5),
        lane("on", &[(-200.0, -40.0), (0.0, 0.0)], 3.5),
        lane("off", &[(300.0, 0.0), (500.0, -40.0)], 3.5),
    ];
    beside(&mut lanes, "m", "w");
    for (a, b) in [("before", "m"), ("m", "after"), ("on", "w"), ("w", "off")] {
        link(&mut lanes, a, b);
    }
    tag(&mut lanes, "on", "ramp");
    tag(&mut lanes, "off", "ramp");
    lanes
}

#[test]
fn a_weaving_lane_is_the_ramps_for_who_joins_or_leaves_by_it() {
    // 10 m a second from x = -100 to 500; y by where it drives.
    let side = |x: f64| match x {
        x if x < 0.0 => 0.2 * x,
        x if x > 300.0 => -0.2 * (x - 300.0),
        _ => 0.0,
    };
    let over = |x: f64, from: f64| 3.5 * ((x - from) / 40.0).clamp(0.0, 1.0);
    let changes = |y: &dyn Fn(f64) -> f64| {
        let heading = |x: f64| ((y(x + 0.5) - y(x - 0.5)) / 1.0).atan();
        let mut d = drive(600, |t| (-100.0 + 10.0 * t, y(-100.0 + 10.0 * t), heading(-100.0 + 10.0 * t)));
        d.map = Some(map(weaving()));
        let t = Table::of(&d);
        (t.span("map.facility_change", "ramp_to_main"), t.span("map.facility_change", "main_to_ramp"))
    };
    // Joins half way through the lane, at x = 150 or 25 s; leaves likewise; from ramp to ramp; aside and back.
    let (joins, leaves) = changes(&|x| if x < 130.0 { side(x) } else { over(x, 130.0) });
    assert!(joins.is_some_and(|(a, b)| a > 230 && b < 270) && leaves.is_none(), "{joins:?} {leaves:?}");
    let (joins, leaves) = changes(&|x| if x < 170.0 { 3.5 - over(x, 130.0) } else { side(x) });
    assert!(joins.is_none() && leaves.is_some_and(|(a, b)| a > 230 && b < 270), "{joins:?} {leaves:?}");
    assert_eq!(changes(&side), (None, None), "it never was on the main road");
    assert_eq!(changes(&|x| 3.5 - over(x, 60.0) + over(x, 200.0)), (None, None), "it never was on a ramp");
}

/// Whoever stands before a junction when the log ends goes straight on, as far as anybody knows: not into a turn whose
/// first piece is straight (SUMO splits turns where vehicles wait), nor into a bicycle lane that is straighter.
#[test]
fn a_way_that_is_not_driven_any_more_goes_straight_on() {
    let way = |id: &str, line: &[(f64, f64)], kind: LaneKind, in_junction: bool| Lane {
        kind,
        in_junction,
        ..lane(id, line, 3.5)
    };
    let mut lanes = vec![
        way("in", &[(-100.0, 0.0), (-50.0, 0.0), (0.0, 0.0)], LaneKind::Vehicle, false),
        way("cycle", &[(0.0, 0.0), (16.0, 0.0)], LaneKind::Bike, true),
        way("cycles_left", &[(16.0, 0.0), (20.0, 4.0), (20.0, 60.0)], LaneKind::Bike, false),
        way("right_1", &[(0.0, 0.0), (1.8, 0.0)], LaneKind::Vehicle, true),
        way("right_2", &[(1.8, 0.0), (6.0, -2.0), (8.0, -6.0)], LaneKind::Vehicle, true),
        way("south", &[(8.0, -6.0), (8.0, -80.0)], LaneKind::Vehicle, false),
        // Straight on is 0.4 m aside.
        way("straight", &[(0.0, 0.0), (8.0, 0.1), (16.0, 0.4)], LaneKind::Vehicle, true),
        way("east", &[(16.0, 0.4), (100.0, 0.4)], LaneKind::Vehicle, false),
    ];
    for (from, to) in [
        ("in", "cycle"),
        ("cycle", "cycles_left"),
        ("in", "right_1"),
        ("right_1", "right_2"),
        ("right_2", "south"),
        ("in", "straight"),
        ("straight", "east"),
    ] {
        link(&mut lanes, from, to);
    }
    let mut d = drive(50, |_| (-6.0, 0.0, 0.0));
    d.map = Some(map(lanes));
    // Somebody who crosses the road to the south, 5 m behind its begin, and one on the road to the east.
    add(&mut d, "south", Pedestrian, (0.5, 0.5), |t| (4.0 + t, -11.0, 0.0));
    car(&mut d, "east", |_| (40.0, 0.4, 0.0));
    let t = Table::of(&d);
    near(t.num("east", "target.path_lateral", 20), 0.0, 0.5);
    assert!(t.num("south", "target.path_lateral", 20).abs() > 9.0);
    assert!(t.ego("map.curvature_ahead", 20) < 0.02, "{}", t.ego("map.curvature_ahead", 20));
}
