//! Signs that apply to the ego, countdowns, and lanes of oncoming traffic.

use crate::scene::{Table, drive, near, road};
use whyroad_model::Tri::{False, True};
use whyroad_model::catalog::CategoryValue;
use whyroad_model::catalog::value::{SignProhibitionKind, SignWarningKind};
use whyroad_model::road_map::{Point3, Sign};
use whyroad_model::scene::{LightColor, LightState};
use whyroad_model::{Column, Drive};

const INF: f64 = f64::INFINITY;

fn sign(kind: &str, x: f64, y: f64, facing: Option<f64>, value: Option<f64>) -> Sign {
    let position = Point3 { x, y, z: 2.0 };
    Sign { id: format!("{kind}{x}{y}"), kind: kind.into(), position, lane_ids: vec![], value, facing }
}

/// East at 10 m/s in the right one of two lanes (y = 0); oncoming traffic comes in the lane at y = 7.
fn east(signs: Vec<Sign>) -> Drive {
    let mut d = drive(120, |t| (10.0 * t, 0.0, 0.0));
    let mut m = road();
    m.signs = signs;
    d.map = Some(m);
    d
}

fn category<C: CategoryValue>(t: &Table, name: &str, frame: usize) -> Option<C> {
    let Column::Category { codes, .. } = &t.0.frame_columns[name] else { panic!("{name} is no category") };
    C::from_code(codes[frame])
}

#[test]
fn a_board_beyond_the_oncoming_lane_is_for_those_who_come_there() {
    let t = Table::of(&east(vec![sign("warning_bend", 80.0, 10.0, None, None)]));
    assert_eq!(t.ego("sign.warning_distance", 20), INF);
    let t = Table::of(&east(vec![sign("warning_bend", 80.0, -4.0, None, None)]));
    // Frame 20: the front is at 22 m.
    near(t.ego("sign.warning_distance", 20), 58.0, 1e-9);
    assert_eq!(category::<SignWarningKind>(&t, "sign.warning_kind", 20).map(|k| k.name()), Some("bend"));
    assert_eq!(category::<SignWarningKind>(&t, "sign.warning_kind", 110).map(|k| k.name()), Some("none"));
}

#[test]
fn a_board_concerns_whom_it_faces() {
    let pi = std::f64::consts::PI;
    // On the right curb facing away from the ego, and on the left facing it.
    let t = Table::of(&east(vec![
        sign("no_entry", 60.0, -4.0, Some(0.0), None),
        sign("no_left_turn", 80.0, 10.0, Some(pi), None),
    ]));
    near(t.ego("sign.prohibition_distance", 20), 58.0, 1e-9);
    let kind = category::<SignProhibitionKind>(&t, "sign.prohibition_kind", 20);
    assert_eq!(kind.map(|k| k.name()), Some("no_left_turn"));
}

#[test]
fn a_height_under_which_the_ego_passes_easily_asks_for_nothing() {
    let limit = |value| Table::of(&east(vec![sign("height_limit", 80.0, -4.0, None, value)]));
    assert_eq!(limit(Some(4.5)).ego("sign.prohibition_distance", 20), INF);
    near(limit(Some(1.8)).ego("sign.prohibition_distance", 20), 58.0, 1e-9);
    near(limit(None).ego("sign.prohibition_distance", 20), 58.0, 1e-9);
}

#[test]
fn a_countdown_counts_down() {
    let mut d = east(vec![]);
    let start = d.times[0];
    let state = |s: f64, color, countdown_s| LightState {
        lane_id: "r0".into(),
        to_lane_id: None,
        time: start.plus_secs(s),
        color,
        countdown_s,
    };
    d.lights = Some(vec![
        state(0.0, LightColor::Red, Some(5.0)),
        state(5.0, LightColor::GreenRound, None),
        state(7.0, LightColor::GreenRound, Some(3.0)),
    ]);
    let t = Table::of(&d);
    near(t.ego("light.countdown", 20), 3.0, 1e-9);
    assert!(t.ego("light.countdown", 60).is_nan(), "this state has none");
    near(t.ego("light.countdown", 80), 2.0, 1e-9);
    // The line of lane r0 is at 100 m: the ego's center is over it from frame 100 on.
    assert_eq!(t.ego("light.countdown", 110), INF);
}

#[test]
fn a_side_over_the_middle_of_the_road_is_in_the_opposing_lane() {
    let at = |y: f64, heading: f64| {
        let mut d = drive(20, |t| (10.0 * t, y, heading));
        d.map = Some(road());
        Table::of(&d).ego_flag("ego.in_opposing_lane", 10)
    };
    // The opposing lane begins at y = 5.25; the car is 1.9 m wide or less.
    assert_eq!((at(0.0, 0.0), at(3.5, 0.0)), (False, False));
    assert_eq!((at(5.2, 0.0), at(7.0, 0.0)), (True, True));
    assert_eq!(at(7.0, std::f64::consts::PI), False, "it goes as the lane does");
}
