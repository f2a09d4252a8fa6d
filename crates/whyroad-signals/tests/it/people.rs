//! People in logs that state only where they are. Expected values by hand: the ego is 4 m x 2 m and drives along x at 5
//! m/s, a person is 0.5 m x 0.5 m.

use crate::scene::{Pose, Table, add, car, drive, near};
use std::collections::BTreeSet;
use whyroad_model::{Drive, Need, ObjectClass};

/// An object of which the log has only its places.
fn place_only(drive: &mut Drive, id: &str, class: ObjectClass, pose: impl Fn(f64) -> Pose) {
    add(drive, id, class, (f64::NAN, f64::NAN), pose);
    let track = drive.tracks.iter_mut().find(|t| t.id.as_str() == id).unwrap();
    let m = &mut track.motion;
    for column in [&mut m.heading, &mut m.vx, &mut m.vy, &mut m.accel, &mut m.yaw_rate] {
        column.fill(f64::NAN);
    }
}

/// One stands at x = 30, one walks to the left across x = 30 at 1.4 m/s, from y = -7; nobody else is there.
fn two_people() -> Drive {
    let mut d = drive(20, |t| (5.0 * t, 0.0, 0.0));
    place_only(&mut d, "stands", ObjectClass::Pedestrian, |_| (30.0, 0.0, 0.0));
    place_only(&mut d, "walks", ObjectClass::Pedestrian, |t| (30.0, 1.4 * t - 7.0, 0.0));
    d
}

#[test]
fn places_alone_give_people_boxes_and_headings() {
    let t = Table::of(&two_people());
    assert!(
        !t.0.unavailable.contains_key("target.gap") && t.0.partial.is_empty() && t.0.without_boxes.is_empty()
    );
    // From the bumper at x = 2 to the side at x = 29.75, closed at 5 m/s.
    near(t.num("stands", "target.gap", 0), 27.75, 1e-6);
    near(t.num("stands", "target.ttc", 0), 27.75 / 5.0, 1e-6);
    assert!(t.num("stands", "target.heading_difference", 0).is_nan(), "nobody knows where it looks");
    near(t.num("walks", "target.heading_difference", 10).abs(), std::f64::consts::FRAC_PI_2, 1e-6);
    near(t.num("walks", "target.speed", 10), 1.4, 1e-6);
    // Its front is at y = -5.35.
    near(t.num("walks", "target.time_to_conflict", 10), 5.35 / 1.4, 1e-6);
    near(t.num("walks", "target.visible_share", 10), 1.0, 1e-6);
}

/// Whether a car somewhere has a size says nothing about people.
#[test]
fn the_size_of_a_person_does_not_depend_on_other_objects() {
    let (alone, mut beside) = (Table::of(&two_people()), two_people());
    car(&mut beside, "parked", |_| (-40.0, 20.0, 0.0));
    let beside = Table::of(&beside);
    for name in ["target.gap", "target.ttc", "target.time_to_conflict", "target.path_side_distance"] {
        for frame in 0..20 {
            let (a, b) = (alone.num("walks", name, frame), beside.num("walks", name, frame));
            assert!(a == b || (a.is_nan() && b.is_nan()), "{name} in {frame}: {a}, {b}");
        }
    }
}

/// Beside a car without a size what needs sizes is known of people, and partial as a whole.
#[test]
fn a_car_without_a_size_has_none_from_people() {
    let mut d = two_people();
    add(&mut d, "car", ObjectClass::Car, (f64::NAN, f64::NAN), |t| (60.0 + 5.0 * t, 0.0, 0.0));
    let t = Table::of(&d);
    assert_eq!(t.0.without_boxes, BTreeSet::from([ObjectClass::Car]));
    assert!(t.num("car", "target.gap", 0).is_nan());
    near(t.num("stands", "target.gap", 0), 27.75, 1e-6);
    for name in ["target.gap", "lead.gap"] {
        assert_eq!(t.0.partial[name], [Need::ObjectSizes], "{name}");
    }
    assert!(!t.0.partial.contains_key("target.speed"));
}

/// An animal may be of any size, and heads where it goes.
#[test]
fn an_animal_has_a_heading_and_no_size() {
    let mut d = drive(20, |t| (5.0 * t, 0.0, 0.0));
    place_only(&mut d, "dog", ObjectClass::Animal, |t| (30.0, 2.0 * t - 7.0, 0.0));
    car(&mut d, "car", |_| (-40.0, 20.0, 0.0));
    let t = Table::of(&d);
    near(t.num("dog", "target.heading_difference", 10).abs(), std::f64::consts::FRAC_PI_2, 1e-6);
    assert!(t.num("dog", "target.gap", 10).is_nan() && t.0.without_boxes.contains(&ObjectClass::Animal));
}
