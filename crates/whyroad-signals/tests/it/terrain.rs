//! Speed constraints from road geometry, compared with roads made of straights, arcs and ramps. Expected values are
//! computed in the comments.
use crate::scene::{Table, drive, lane, map, near};
use whyroad_model::Tri::{False, True, Unknown};
use whyroad_model::road_map::{Area, Facility, Lane, Point3};

const SPEED: f64 = 10.0;

/// A path of straights and arcs (length in m, curvature in 1/m), driven at 10 m/s from the origin along x.
pub fn winding(parts: &'static [(f64, f64)]) -> impl Fn(f64) -> (f64, f64, f64) {
    move |t| {
        let (mut x, mut y, mut heading, mut left) = (0.0_f64, 0.0_f64, 0.0_f64, SPEED * t);
        for (k, &(length, curvature)) in parts.iter().enumerate() {
            let ds = if k + 1 == parts.len() { left } else { left.min(length) };
            if curvature == 0.0 {
                (x, y) = (x + ds * heading.cos(), y + ds * heading.sin());
            } else {
                let after = heading + ds * curvature;
                x += (after.sin() - heading.sin()) / curvature;
                y -= (after.cos() - heading.cos()) / curvature;
                heading = after;
            }
            left -= ds;
        }
        (x, y, heading)
    }
}

#[test]
fn a_bend_asks_for_the_speed_of_2_meters_per_second_squared() {
    // 100 m straight, then a circle of 50 m radius: sqrt(2 x 50) = 10 m/s. At 0 s the bend is 100 m away.
    let d = drive(150, winding(&[(100.0, 0.0), (1000.0, 0.02)]));
    let t = Table::of(&d);
    assert_eq!(t.ego("map.bend_speed", 0), f64::INFINITY);
    near(t.ego("map.bend_speed", 130), 10.0, 0.2);
    // 2 s at 10 m/s and 100 / 6.
    near(t.ego("ego.stopping_distance", 50), 36.667, 0.05);
}

#[test]
fn bends_in_a_row_are_counted_over_500_m() {
    // Bends of 50 m radius and 40 m length at 100, 240 and 380 m, left, right, left; the third is in two arcs with 6
    // m between them, which is one bend; a fourth at 600 m. The drive is 800 m long.
    const WAY: &[(f64, f64)] = &[
        (100.0, 0.0),
        (40.0, 0.02),
        (100.0, 0.0),
        (40.0, -0.02),
        (100.0, 0.0),
        (20.0, 0.02),
        (6.0, 0.0),
        (20.0, 0.02),
        (174.0, 0.0),
        (40.0, -0.02),
        (160.0, 0.0),
    ];
    let t = Table::of(&drive(801, winding(WAY)));
    // At 100 m: the driven part extends from 0 to 350 m only, and contains two bends.
    assert!(t.ego("map.bends_around", 100).is_nan());
    // At 180 m: to 430 m, three bends, which is enough.
    near(t.ego("map.bends_around", 180), 3.0, 0.0);
    // At 300 m: 50 to 550 m.
    near(t.ego("map.bends_around", 300), 3.0, 0.0);
    // At 420 m: 170 to 670 m holds the second, third and fourth.
    near(t.ego("map.bends_around", 420), 3.0, 0.0);
    // At 548 m: 298 to 798 m holds the third and fourth.
    near(t.ego("map.bends_around", 548), 2.0, 0.0);
}

/// A road along x that climbs by `grade` between 100 m and 180 m.
fn hill(grade: f64) -> whyroad_model::Drive {
    let mut d = drive(301, |t| (SPEED * t, 0.0, 0.0));
    let points: Vec<(f64, f64)> = (-5..=40).map(|k| (f64::from(k) * 10.0, 0.0)).collect();
    let mut road = map(vec![lane("a", &points, 3.5)]);
    for p in &mut road.lanes[0].center {
        p.z = (p.x - 100.0).clamp(0.0, 80.0) * grade;
    }
    d.map = Some(road);
    d
}

#[test]
fn length_and_mean_of_a_slope() {
    let t = Table::of(&hill(0.06));
    // The grade is that of a chord of 10 m: 4 % and more where two thirds of it are on the ramp, from 101.7 to 178.3 m.
    near(t.ego("map.slope_length", 150), 76.7, 2.0);
    near(t.ego("map.slope_length", 50), 0.0, 0.0);
    near(t.ego("map.slope_length", 250), 0.0, 0.0);
    // 4.8 m of height over the 300 m that were driven, all within 250 m of the middle.
    near(t.ego("map.mean_grade", 150), 0.016, 0.0005);
    // Downhill is as long.
    near(Table::of(&hill(-0.06)).ego("map.slope_length", 150), 76.7, 2.0);
    // 3 % is no slope.
    near(Table::of(&hill(0.03)).ego("map.slope_length", 150), 0.0, 0.0);
}

#[test]
fn an_open_area_has_no_lane_near() {
    // A lane along x; a drivable yard from y = 20 to 60 m. The ego leaves the lane at right angles.
    let mut d = drive(60, |t| (50.0, SPEED * t, std::f64::consts::FRAC_PI_2));
    let square = |x0: f64, y0: f64, x1: f64, y1: f64| -> Vec<Point3> {
        [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Point3 { x, y, z: 0.0 }).to_vec()
    };
    let mut road = map(vec![lane("a", &[(0.0, 0.0), (100.0, 0.0)], 3.5)]);
    d.map = Some(road.clone());
    let unavailable = whyroad_signals::derive(&d).unavailable;
    assert!(unavailable.contains_key("map.open_area"), "the map states no areas");
    road.drivable_areas = vec![Area { id: "yard".into(), boundary: square(0.0, -2.0, 100.0, 60.0) }];
    d.map = Some(road.clone());
    let t = Table::of(&d);
    // The lane's edge is at 1.75 m; 5 m from it is 6.75 m.
    assert_eq!([0, 6, 7, 40].map(|i| t.ego_flag("map.open_area", i)), [False, False, True, True]);
    // A lane on the far side continues in lanes outside of the map: a junction of which the map has half.
    let mut cut = road.clone();
    cut.lanes.push(Lane { successors: vec!["gone".into()], ..lane("b", &[(90.0, 70.0), (50.0, 70.0)], 3.5) });
    let t = Table::of(&whyroad_model::Drive { map: Some(cut), ..d.clone() });
    assert_eq!([0, 40].map(|i| t.ego_flag("map.open_area", i)), [False, Unknown]);
    // The same yard 60 m beyond the end of a road: the map ends before it.
    let mut beyond = road.clone();
    beyond.lanes = vec![lane("a", &[(-100.0, 0.0), (-10.0, 0.0)], 3.5)];
    let t = Table::of(&whyroad_model::Drive { map: Some(beyond.clone()), ..d.clone() });
    assert_eq!(t.ego_flag("map.open_area", 40), Unknown);
    // Roads on two sides of it: it is inside the map.
    beyond.lanes.push(lane("b", &[(110.0, -100.0), (110.0, 100.0)], 3.5));
    beyond.lanes.push(lane("c", &[(0.0, 110.0), (100.0, 110.0)], 3.5));
    let t = Table::of(&whyroad_model::Drive { map: Some(beyond), ..d.clone() });
    assert_eq!(t.ego_flag("map.open_area", 40), True);
    road.drivable_areas.clear();
    let park = Facility { id: "p".into(), kind: "parking".into(), boundary: square(0.0, 20.0, 100.0, 60.0) };
    road.facilities = vec![park];
    d.map = Some(road);
    let t = Table::of(&d);
    assert_eq!([0, 15, 30].map(|i| t.ego_flag("map.open_area", i)), [False, False, True]);
}
