//! Targets on ramps and the lanes behind them, on a hand-drawn road: lanes r0 (to x = 100 m) and r1 (to 500 m) right of
//! the ego's l0 and l1.
use crate::scene::{Table, car, drive, road};
use whyroad_model::Drive;
use whyroad_model::Tri::{False, True, Unknown};

/// The ego drives 10 m/s in the left lane; one car beside it in the right one, one ahead of it, one on the grass.
fn joined(tags: &[(&str, &str)]) -> Drive {
    let mut d = drive(150, |t| (10.0 * t, 3.5, 0.0));
    car(&mut d, "beside", |t| (10.0 * t + 20.0, 0.0, 0.0));
    car(&mut d, "ahead", |t| (10.0 * t + 20.0, 3.5, 0.0));
    car(&mut d, "grass", |t| (10.0 * t + 20.0, -20.0, 0.0));
    let mut map = road();
    for (id, tag) in tags {
        map.lanes.iter_mut().find(|l| l.id == *id).unwrap().tags.push((*tag).to_owned());
    }
    d.map = Some(map);
    d
}

#[test]
fn a_ramp_and_the_lane_that_it_leads_onto() {
    let t = Table::of(&joined(&[("r0", "ramp")]));
    // On r0 at 2 s (x = 40 m), on r1 at 12 s (x = 140 m): r1 is 400 m long and follows the ramp.
    assert_eq!([20, 120].map(|i| t.flag("beside", "target.on_ramp", i)), [True, True]);
    assert_eq!([20, 120].map(|i| t.flag("ahead", "target.on_ramp", i)), [False, False]);
    assert_eq!(t.flag("grass", "target.on_ramp", 20), Unknown);
}

#[test]
fn an_acceleration_lane_by_its_tag_alone() {
    let t = Table::of(&joined(&[("r1", "acceleration")]));
    assert_eq!([20, 120].map(|i| t.flag("beside", "target.on_ramp", i)), [False, True]);
}

#[test]
fn a_map_without_such_tags_does_not_tell() {
    let t = Table::of(&joined(&[]));
    assert!(t.0.unavailable.contains_key("target.on_ramp"));
}
