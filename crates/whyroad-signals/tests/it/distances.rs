//! Gaps, times to contact and relations, compared with geometry done by hand: the ego is 4 m long and 2 m wide and
//! drives along x in the right lane of `crate::scene::road`. Many are DESIGN.md's known traps.
use crate::scene::{Table, add, add_seen, car, drive, lane, map, near, road};
use std::f64::consts::{FRAC_PI_2, PI};
use whyroad_model::ObjectClass::{Bus, Car, Pedestrian, Truck};
use whyroad_model::Tri::{False, True, Unknown};

const INF: f64 = f64::INFINITY;

fn ego_at(speed: f64, frames: usize) -> whyroad_model::Drive {
    let mut d = drive(frames, move |t| (speed * t, 0.0, 0.0));
    d.map = Some(road());
    d
}

#[test]
fn gap_is_bumper_to_bumper_and_distance_is_box_to_box() {
    let mut d = ego_at(10.0, 20);
    car(&mut d, "ahead", |t| (25.0 + 5.0 * t, 0.0, 0.0));
    car(&mut d, "behind", |t| (-20.0 + 10.0 * t, 0.0, 0.0));
    let t = Table::of(&d);
    // Centers 25 m apart, half lengths 2 m each: 21 m clear, closing at 5 m/s.
    near(t.num("ahead", "target.longitudinal", 0), 25.0, 1e-6);
    near(t.num("ahead", "target.path_longitudinal", 0), 25.0, 1e-6);
    near(t.num("ahead", "target.gap", 0), 21.0, 1e-6);
    near(t.num("ahead", "target.distance", 0), 21.0, 1e-6);
    near(t.num("ahead", "target.ttc", 0), 4.2, 1e-3);
    near(t.num("ahead", "target.ttc_box", 0), 4.2, 1e-3);
    near(t.num("ahead", "target.thw", 0), 2.1, 1e-3);
    near(t.num("ahead", "target.drac", 0), 25.0 / 42.0, 1e-3);
    assert_eq!(t.category("ahead", "target.relation", 0), Some("lead"));
    // A second later: 16 m.
    near(t.num("ahead", "target.gap", 10), 16.0, 1e-6);
    near(t.ego("lead.gap", 10), 16.0, 1e-6);
    near(t.ego("lead.ttc", 10), 3.2, 1e-3);
    near(t.ego("lead.speed", 10), 5.0, 1e-6);
    // Behind: negative longitudinal, no gap, no TTC, but a follower.
    near(t.num("behind", "target.longitudinal", 0), -20.0, 1e-6);
    assert_eq!(t.num("behind", "target.gap", 0), INF);
    assert_eq!(t.num("behind", "target.ttc", 0), INF);
    assert_eq!(t.flag("behind", "target.is_follower", 0), True);
    assert_eq!(t.flag("behind", "target.is_lead", 0), False);
    // Without sizes the centers show lead and follower, but the gap is unknown.
    for track in &mut d.tracks {
        track.length_m.fill(f64::NAN);
        track.width_m.fill(f64::NAN);
    }
    let t = Table::of(&d);
    assert_eq!(t.flag("ahead", "target.is_lead", 0), True);
    assert_eq!(t.flag("behind", "target.is_follower", 0), True);
    assert!(whyroad_signals::derive(&d).unavailable.contains_key("target.gap"));
}

#[test]
fn only_closing_pairs_in_path_have_a_time_to_collision() {
    let mut d = ego_at(10.0, 10);
    car(&mut d, "next_lane", |_| (30.0, 3.5, 0.0));
    car(&mut d, "receding", |t| (30.0 + 12.0 * t, 0.0, 0.0));
    car(&mut d, "oncoming", |t| (80.0 - 10.0 * t, 7.0, PI));
    let t = Table::of(&d);
    for id in ["next_lane", "receding", "oncoming"] {
        assert_eq!(t.num(id, "target.ttc", 5), INF, "{id}");
        assert_eq!(t.num(id, "target.ttc_box", 5), INF, "{id}");
        assert_eq!(t.num(id, "target.drac", 5), 0.0, "{id}");
    }
    assert_eq!(t.num("next_lane", "target.gap", 5), INF);
    assert_eq!(t.category("next_lane", "target.relation", 5), Some("left"));
    assert_eq!(t.category("oncoming", "target.relation", 5), Some("oncoming"));
    assert_eq!(t.flag("oncoming", "target.opposite_direction", 5), True, "exactly 180 deg is opposite");
    near(t.num("oncoming", "target.crossing_angle", 5), 0.0, 1e-6);
    assert_eq!(t.flag("receding", "target.is_lead", 5), True);
}

#[test]
fn at_standstill_nothing_closes_and_nothing_is_divided_by_zero() {
    let mut d = ego_at(0.0, 20);
    car(&mut d, "stopped", |_| (10.0, 0.0, 0.0));
    let t = Table::of(&d);
    near(t.num("stopped", "target.gap", 5), 6.0, 1e-6);
    for name in ["target.ttc", "target.ttc_box", "target.thw"] {
        assert_eq!(t.num("stopped", name, 5), INF, "{name}");
    }
    assert_eq!(t.num("stopped", "target.drac", 5), 0.0);
    assert_eq!(t.flag("stopped", "target.is_lead", 5), True, "a standing ego still has the lane ahead");
    assert_eq!(t.ego_flag("ego.standstill", 5), True);
    assert!(t.ego("ego.curvature", 5).is_nan(), "no curvature without motion");
    assert!(t.num("stopped", "target.crossing_angle", 5).is_nan(), "no direction without motion");
}

#[test]
fn overlap_is_a_negative_gap_and_a_time_of_zero() {
    let mut d = ego_at(10.0, 10);
    car(&mut d, "hit", |t| (3.0 + 5.0 * t, 0.0, 0.0));
    let t = Table::of(&d);
    near(t.num("hit", "target.gap", 0), -1.0, 1e-6);
    assert_eq!(t.num("hit", "target.ttc", 0), 0.0);
    assert_eq!(t.num("hit", "target.ttc_box", 0), 0.0);
    assert_eq!(t.num("hit", "target.thw", 0), 0.0);
    assert_eq!(t.num("hit", "target.drac", 0), INF);
    assert_eq!(t.num("hit", "target.distance", 0), 0.0);
}

/// A bus of 12 m by 2.5 m comes over from the left lane at 0.35 rad, both at 5 m/s. Its center is 12 m ahead and 3.2 m
/// to the left, its rear right corner 6 cos 0.35 + 1.25 sin 0.35 = 6.065 m behind its center: 12 - 6.065 - 2 = 3.935 m
/// from the ego's front. The part in the ego's band begins 7.6 m farther on.
#[test]
fn the_gap_to_a_bus_that_comes_over_is_to_its_rear() {
    let bus = |x: f64| {
        let mut d = ego_at(5.0, 10);
        add(&mut d, "bus", Bus, (12.0, 2.5), move |t| (x + 5.0 * t, 3.2, -0.35));
        Table::of(&d).num("bus", "target.gap", 4)
    };
    near(bus(12.0), 3.935, 1e-2);
    near(bus(14.0), 5.935, 1e-2);
    // Beside the ego, with its front over the line: the part in the band counts, nothing overlaps.
    assert!(bus(4.0) > 0.0);
}

/// The ego drives straight to x = 0 and then on a circle of 8 m to the left around (0, 8), 5 m/s. A truck of 8 m by 2 m
/// comes towards it in the other lane, its near side at y = 2.1: 1.1 m beside the ego when the ego is at x = 0, with
/// its rear where the ego will turn. Its near side is in the band of 1.3 m beside the circle where it is within 6.7 m
/// of the circle's center: from x = sqrt(6.7^2 - 5.9^2) = 3.175 m on, at an arc length of 8 atan(3.175 / 5.9) = 3.950 m
/// from the ego's center, 1.950 m from its front. When the ego is there, the truck has gone.
#[test]
fn a_truck_beside_the_ego_where_it_will_turn_does_not_overlap() {
    let turn = |t: f64| {
        let s = 5.0 * (t - 1.0);
        let a = (s.max(0.0) / 8.0).min(FRAC_PI_2);
        (s.min(0.0) + 8.0 * a.sin(), 8.0 - 8.0 * a.cos(), a)
    };
    let mut d = drive(40, turn);
    add(&mut d, "truck", Truck, (8.0, 2.0), |t| (4.0 - 15.0 * (t - 1.0), 3.1, PI));
    let t = Table::of(&d);
    near(t.num("truck", "target.distance", 10), 1.1, 1e-6);
    near(t.num("truck", "target.gap", 10), 1.95, 0.05);
    for frame in 0..40 {
        assert!(t.num("truck", "target.gap", frame) >= 0.0, "frame {frame}");
        assert_eq!(t.num("truck", "target.ttc", frame), INF, "frame {frame}");
        assert_eq!(t.num("truck", "target.ttc_box", frame), INF, "frame {frame}");
    }
}

/// In a lane of 9 m, the ego at its center passes a slower car 0.8 m to its left: 2.8 - 1 - 1. The boxes are beside
/// each other while the centers are less than 4 m apart. The lead is the car ahead of both.
#[test]
fn a_car_beside_the_ego_in_a_wide_lane_is_neither_in_path_nor_the_lead() {
    let mut d = drive(20, |t| (5.0 * t, 0.0, 0.0));
    d.map = Some(map(vec![lane("wide", &[(-200.0, 0.0), (150.0, 0.0), (500.0, 0.0)], 9.0)]));
    car(&mut d, "slow", |t| (6.5 + 2.0 * t, 2.8, 0.0));
    car(&mut d, "lead", |t| (34.0 + 5.0 * t, 0.0, 0.0));
    let t = Table::of(&d);
    // Its rear is 6.5 - 3 * 0.5 - 2 = 3 m before the ego's center, 1 m before its front.
    near(t.num("slow", "target.gap", 5), 1.0, 1e-6);
    assert_eq!(t.flag("slow", "target.is_lead", 5), True);
    // 3.2 m ahead, beside the ego's front part.
    near(t.num("slow", "target.distance", 11), 0.8, 1e-6);
    assert_eq!(t.flag("slow", "target.in_ego_lane", 11), True);
    assert_eq!(t.num("slow", "target.gap", 11), INF);
    assert_eq!(t.num("slow", "target.ttc", 11), INF);
    assert_eq!(t.flag("slow", "target.is_lead", 11), False);
    assert_eq!(t.flag("lead", "target.is_lead", 11), True);
    near(t.ego("lead.gap", 11), 30.0, 1e-6);
}

#[test]
fn head_on_in_the_ego_lane_closes_with_both_speeds() {
    let mut d = ego_at(10.0, 10);
    car(&mut d, "ghost", |t| (64.0 - 10.0 * t, 0.0, PI));
    let t = Table::of(&d);
    // 60 m clear at 20 m/s.
    near(t.num("ghost", "target.ttc", 0), 3.0, 1e-3);
    assert_eq!(t.flag("ghost", "target.is_lead", 0), False, "it heads the other way");
    assert_eq!(t.category("ghost", "target.relation", 0), Some("oncoming"));
}

#[test]
fn a_car_that_passes_the_mouth_of_the_egos_turn_is_not_on_collision_course_along_it() {
    // Straight to x = 20, then a quarter circle to the left of radius 15 m at 5 m/s; the oncoming car at y = 3.5.
    let turn = |t: f64| {
        let s = 5.0 * t;
        if s < 20.0 {
            (s, 0.0, 0.0)
        } else {
            let a = ((s - 20.0) / 15.0).min(FRAC_PI_2);
            let past = (s - 20.0 - 15.0 * FRAC_PI_2).max(0.0);
            (20.0 + 15.0 * a.sin(), 15.0 - 15.0 * a.cos() + past, a)
        }
    };
    let mut d = drive(120, turn);
    car(&mut d, "oncoming", |t| (60.0 - 12.0 * t, 3.5, PI));
    let t = Table::of(&d);
    // It crosses the ego's path at 2 to 4 s, when the ego is before the turn, and is gone when the ego gets there.
    for frame in 0..60 {
        assert_eq!(t.num("oncoming", "target.ttc", frame), INF, "frame {frame}");
    }
}

#[test]
fn a_walker_in_the_path_counts_while_they_stay_in_it() {
    let mut d = ego_at(10.0, 10);
    add(&mut d, "stands", Pedestrian, (0.6, 0.6), |_| (32.0, 0.5, FRAC_PI_2));
    add(&mut d, "leaves", Pedestrian, (0.6, 0.6), |t| (32.0, 0.5 + 1.5 * t, FRAC_PI_2));
    add(&mut d, "comes", Pedestrian, (0.6, 0.6), |t| (32.0, -4.5 + 1.5 * t, FRAC_PI_2));
    let t = Table::of(&d);
    // Front bumper at 2, walker's near side at 31.7: 29.7 m at 10 m/s.
    near(t.num("stands", "target.ttc", 0), 2.97, 1e-3);
    // Over the lane's edge long before 2.97 s: no time along the path.
    assert_eq!(t.num("leaves", "target.ttc", 0), INF);
    near(t.num("leaves", "target.gap", 0), 29.7, 1e-6);
    // Not in the path yet, but the boxes meet: the upper side from -4.2 reaches the ego's right side -1 at 2.13 s,
    // the ego's front the walker at 2.97 s; then the walker is between y = -0.35 and 0.25.
    assert_eq!(t.num("comes", "target.ttc", 0), INF);
    near(t.num("comes", "target.ttc_box", 0), 2.97, 1e-3);
    near(t.num("comes", "target.crossing_angle", 0), FRAC_PI_2, 1e-6);
    assert_eq!(t.category("comes", "target.relation", 0), Some("crossing"));
}

#[test]
fn a_car_that_cuts_in_crosses_the_line_by_hand_geometry() {
    let mut d = ego_at(10.0, 70);
    // From the left lane's center at 1 s to the ego lane's at 6 s: 0.7 m/s across.
    let y = |t: f64| 3.5 - 0.7 * (t - 1.0).clamp(0.0, 5.0);
    car(&mut d, "cuts", move |t| (20.0 + 8.0 * t, y(t), 0.0));
    let t = Table::of(&d);
    let first = |name: &str, flag| (0..70).find(|&i| t.flag("cuts", name, i) == flag).unwrap();
    // The line is at 1.75. Its right side y - 1 is 0.1 m over it when y = 2.65: at 2.214 s.
    assert_eq!(first("target.wheel_over_line", True), 23);
    // The left side y + 1 is within 0.1 m of the line when y = 0.85: at 4.786 s.
    assert_eq!((23..70).find(|&i| t.flag("cuts", "target.wheel_over_line", i) == False), Some(48));
    // The center crosses at y = 1.75: exactly 3.5 s.
    assert!((35..=36).contains(&first("target.in_ego_lane", True)));
    assert!((35..=36).contains(&first("target.is_lead", True)));
    // At 3 s: y = 2.1, right side 1.1: 0.65 m in.
    near(t.num("cuts", "target.lateral_offset", 30), 0.65, 1e-6);
    near(t.num("cuts", "target.lane_centre_distance", 30), 2.1, 1e-6);
    near(t.num("cuts", "target.lane_lateral_speed", 30), 0.7, 1e-6);
    // Over the line and coming in, it is in path: center 14 m ahead, 10 m clear, closing at 2 m/s.
    near(t.num("cuts", "target.gap", 30), 10.0, 1e-6);
    near(t.num("cuts", "target.ttc", 30), 5.0, 1e-2);
    assert_eq!(t.num("cuts", "target.gap", 10), INF, "in its own lane it is not in the ego's path");
    assert_eq!(t.num("cuts", "target.lateral_offset", 10), 0.0);
    assert_eq!(t.category("cuts", "target.lane_change", 30), Some("right"));
}

#[test]
fn a_car_parked_with_a_wheel_in_the_lane_is_not_in_path() {
    let mut d = ego_at(10.0, 10);
    car(&mut d, "parked", |_| (30.0, -2.5, 0.0));
    let t = Table::of(&d);
    assert_eq!(t.flag("parked", "target.wheel_over_line", 0), True, "left side at -1.5, line at -1.75");
    near(t.num("parked", "target.lateral_offset", 0), 0.25, 1e-6);
    assert_eq!(t.num("parked", "target.gap", 0), INF);
    assert_eq!(t.flag("parked", "target.in_ego_lane", 0), False);
}

#[test]
fn far_away_on_a_bridge_and_unseen() {
    let mut d = ego_at(10.0, 30);
    car(&mut d, "far", |t| (400.0 + 10.0 * t, 0.0, 0.0));
    car(&mut d, "bridge", |_| (40.0, 0.0, 0.0));
    for z in &mut d.tracks[0].motion.z {
        *z = 8.0;
    }
    assert_eq!(d.tracks[0].id.as_str(), "bridge");
    // 1.8 s without a row: too long to be bridged (docs/explanation/estimates.md).
    add_seen(&mut d, "hidden", Bus, (12.0, 2.5), |i| !(8..26).contains(&i), |t| (30.0 + 10.0 * t, 0.0, 0.0));
    let t = Table::of(&d);
    assert_eq!(t.flag("far", "target.in_ego_lane", 0), False, "too far is known, not unknown");
    assert_eq!(t.num("far", "target.gap", 0), INF);
    assert_eq!(t.category("far", "target.relation", 0), Some("none"));
    assert_eq!(t.flag("bridge", "target.in_ego_lane", 0), False, "another level");
    assert_eq!(t.num("bridge", "target.ttc", 0), INF);
    assert_eq!(t.num("bridge", "target.ttc_box", 0), INF);
    assert_eq!(t.flag("hidden", "target.observed", 17), False);
    assert_eq!(t.flag("hidden", "target.is_lead", 17), Unknown);
    assert!(t.num("hidden", "target.gap", 17).is_nan());
    assert_eq!(t.flag("hidden", "target.is_lead", 26), True);
    assert_eq!(t.flag("hidden", "target.large_vehicle", 26), True);
    // 30 m between centers, half lengths 6 and 2.
    near(t.num("hidden", "target.gap", 26), 22.0, 1e-6);
}

#[test]
fn post_encroachment_time_by_hand() {
    let mut d = drive(120, |t| (10.0 * t, 0.0, 0.0));
    // The ego's conflict with a crossing 4 m x 2 m car at x = 50 lies between x = 49 and 51: the ego's front (2 m
    // ahead) enters at 4.7 s, its rear leaves at 5.3 s. The other's front (2 m) enters y = -1 at 7.0 s.
    car(&mut d, "later", |t| (50.0, -73.0 + 10.0 * t, FRAC_PI_2));
    // Stops 5 m before the ego's path: no encounter.
    car(&mut d, "stops", |t| (80.0, -30.0 + 5.0 * t.min(4.0), FRAC_PI_2));
    car(&mut d, "leads", |t| (30.0 + 10.0 * t, 0.0, 0.0));
    // Observed ahead for 1.5 s only, and gone before the ego drives over the same ground.
    add_seen(&mut d, "lost", Car, (4.0, 2.0), |i| i < 15, |t| (30.0 + 10.0 * t, 0.0, 0.0));
    // Meets the ego at x = 20 at 2 s.
    car(&mut d, "hits", |t| (20.0, -10.0 + 5.0 * t, FRAC_PI_2));
    // As "later", on a bridge 6 m above the ego's road.
    car(&mut d, "above", |t| (50.0, -73.0 + 10.0 * t, FRAC_PI_2));
    let bridge = d.tracks.iter_mut().find(|t| t.id.as_str() == "above").unwrap();
    bridge.motion.z.iter_mut().for_each(|z| *z += 6.0);
    let t = Table::of(&d);
    assert_eq!(t.num("above", "target.pet", 60), INF);
    // Good to a frame: 0.1 s.
    near(t.num("later", "target.pet", 60), 1.7, 0.1);
    assert_eq!(t.num("later", "target.pet", 20), INF, "before either is in the area");
    assert_eq!(t.num("later", "target.pet", 100), INF, "after both have left");
    for frame in 0..120 {
        assert_eq!(t.num("stops", "target.pet", frame), INF);
        assert_eq!(t.num("leads", "target.pet", frame), INF, "following along one way is no encroachment");
    }
    for frame in 0..15 {
        assert_eq!(
            t.num("lost", "target.pet", frame),
            INF,
            "a track that ends has not left an area across the ego's way"
        );
    }
    assert_eq!(t.num("hits", "target.pet", 20), 0.0);
}

/// A lead 11 s ahead waits at 150 m from 4 s to 9 s and then turns off the ego's way to the left, with 4 m/s on a
/// radius of 5.1 m. Before it waits, no place of its way is one that both pass within 10 s: nothing is encroached
/// there.
#[test]
fn an_encounter_begins_where_both_pass_within_ten_seconds() {
    let mut d = drive(170, |t| (10.0 * t, 0.0, 0.0));
    let radius = 4.0 / (FRAC_PI_2 / 2.0);
    car(&mut d, "turns off", |t| {
        let turned = FRAC_PI_2 / 2.0 * (t - 9.0).clamp(0.0, 2.0);
        let along = 110.0 + 10.0 * t.min(4.0) + radius * turned.sin();
        (along, radius * (1.0 - turned.cos()) + 4.0 * (t - 11.0).max(0.0), turned)
    });
    let t = Table::of(&d);
    for frame in 0..30 {
        assert_eq!(t.num("turns off", "target.pet", frame), INF, "{frame}");
    }
    // It is out of the ego's 2 m wide way at 10.3 s, 154.4 m from the start; the ego's front is there at 15.1 s.
    near(t.num("turns off", "target.pet", 100), 4.8, 0.4);
}

/// Trap: both stop before the conflict point. Neither has a time of arrival any more, and nothing encroaches.
#[test]
fn who_stops_before_the_conflict_never_meets() {
    // Both would be at (50, 0) after 5 s; the ego stops at x = 30, the other at y = -20, both from 4 s on.
    let stop = |t: f64| t.min(4.0);
    let mut d = drive(90, move |t| (-10.0 + 10.0 * stop(t), 0.0, 0.0));
    car(&mut d, "other", move |t| (50.0, -60.0 + 10.0 * stop(t), FRAC_PI_2));
    let t = Table::of(&d);
    for frame in 0..90 {
        assert_eq!(t.num("other", "target.pet", frame), INF, "{frame}");
    }
    for frame in 45..90 {
        assert_eq!(t.num("other", "target.ttc", frame), INF, "{frame}");
        assert_eq!(t.num("other", "target.ttc_box", frame), INF, "{frame}");
        assert_eq!(t.num("other", "target.drac", frame), 0.0, "{frame}");
    }
}
