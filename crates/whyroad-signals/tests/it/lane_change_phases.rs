//! Phases of the ego's lane changes, and aborted lane changes, compared with motions given by formulas. Expected values
//! are computed in the comments.
use crate::scene::{Table, drive, lane, map, road};
use std::f64::consts::PI;
use whyroad_model::Drive;
use whyroad_model::Tri::{True, Unknown};
use whyroad_model::road_map::Lane;
use whyroad_model::scene::TurnSignal;

/// 3.5 m to the left between 4 and 8 s, as a cosine.
fn shift(t: f64) -> f64 {
    1.75 * (1.0 - (PI * ((t - 4.0).clamp(0.0, 4.0)) / 4.0).cos())
}

/// Frames in which a flag of the ego is true: first and last.
fn when(t: &Table, name: &str, frames: usize) -> Option<(usize, usize)> {
    let on: Vec<usize> = (0..frames).filter(|&i| t.ego_flag(name, i) == True).collect();
    Some((*on.first()?, *on.last()?))
}

#[test]
fn phases_of_a_lane_change() {
    let mut d = drive(120, |t| (12.0 * t, shift(t), 0.0));
    d.map = Some(road());
    // Execute from 4.1 s (as ego.lane_change); half of it is over the line at 6 s (the lane assignment may be two
    // frames late); complete to 8.0 s. A log without indicators and commands shows no intention.
    let t = Table::of(&d);
    assert_eq!(t.span("ego.lane_change_phase", "prepare"), None);
    let execute = t.span("ego.lane_change_phase", "execute").unwrap();
    assert!(execute.0 == 41 && (58..=63).contains(&execute.1), "{execute:?}");
    assert_eq!(t.span("ego.lane_change_phase", "complete"), Some((execute.1 + 1, 80)));
    assert_eq!(t.span("ego.lane_change_phase", "none"), Some((0, 119)));
    let prepares = |d: &Drive| Table::of(d).span("ego.lane_change_phase", "prepare");
    // With an indicator: from when it is on; not where it had been off in between, or shows the other side.
    let on = |from: usize, side| (0..120).map(move |i| Some(if i >= from { side } else { TurnSignal::Off }));
    let bus = |d: &mut Drive, signals: Vec<Option<TurnSignal>>| {
        d.ego.as_mut().unwrap().bus.turn_signal = signals;
    };
    bus(&mut d, on(12, TurnSignal::Left).collect());
    assert_eq!(prepares(&d), Some((12, 40)));
    let off_again = on(12, TurnSignal::Left).enumerate();
    bus(&mut d, off_again.map(|(i, s)| if i == 30 { Some(TurnSignal::Off) } else { s }).collect());
    assert_eq!(prepares(&d), Some((31, 40)));
    bus(&mut d, on(12, TurnSignal::Right).collect());
    assert_eq!(prepares(&d), None);
    // The route requires the left from 2 s on; if it did so from the beginning, the time of the command is unknown. A
    // command to the right does not count.
    let route = |from: usize, command: &str| -> Vec<Option<String>> {
        (0..120).map(|i| Some(if i >= from { command } else { "straight" }.to_owned())).collect()
    };
    for (from, command, expected) in
        [(20, "left", Some((20, 40))), (0, "left", None), (20, "right", None), (20, "exit", None)]
    {
        d.ego.as_mut().unwrap().bus.route_command = route(from, command);
        assert_eq!(prepares(&d), expected, "{command} from {from}");
    }
    // Both: the earlier one.
    d.ego.as_mut().unwrap().bus.route_command = route(20, "left");
    bus(&mut d, on(28, TurnSignal::Left).collect());
    assert_eq!(prepares(&d), Some((20, 40)));
}

#[test]
fn the_intention_of_a_change_begins_after_what_was_before() {
    // Its indicator is on all the time; inside the junction it was for the turn.
    let mut d = drive(120, |t| (12.0 * t, shift(t), 0.0));
    let junction = Lane { in_junction: true, ..lane("j", &[(-60.0, 0.0), (20.0, 0.0)], 3.5) };
    let mut lanes = vec![junction, lane("a", &[(20.0, 0.0), (500.0, 0.0)], 3.5)];
    lanes.push(lane("b", &[(20.0, 3.5), (500.0, 3.5)], 3.5));
    lanes[0].successors = vec!["a".to_owned()];
    (lanes[1].predecessors, lanes[1].left_neighbor) = (vec!["j".to_owned()], Some("b".to_owned()));
    lanes[2].right_neighbor = Some("a".to_owned());
    d.map = Some(map(lanes));
    d.ego.as_mut().unwrap().bus.turn_signal = vec![Some(TurnSignal::Left); 120];
    // It leaves the junction at 20 / 12 = 1.67 s.
    let prepare = Table::of(&d).span("ego.lane_change_phase", "prepare").unwrap();
    assert!((16..=18).contains(&prepare.0) && prepare.1 == 40, "{prepare:?}");
}

#[test]
fn a_lane_change_given_up() {
    // 1.2 m out by 6 s and back by 8 s, along a cosine: 0.6 (1 - cos(pi (t-4)/2)); within 0.3 m again where the cosine
    // is 0.5: pi (t-4)/2 = 2 pi - pi/3, t = 7.33 s.
    let out = |t: f64| 0.6 * (1.0 - (PI * (t - 4.0).clamp(0.0, 4.0) / 2.0).cos());
    let mut d = drive(120, move |t| (12.0 * t, out(t), 0.0));
    d.map = Some(road());
    let t = Table::of(&d);
    let (first, last) = when(&t, "ego.lane_change_aborted", 120).unwrap();
    // 0.05 m under the peak 0.26 s after 6 s.
    assert!((61..=64).contains(&first) && last == 73, "{first} {last}");
    // It executes from 0.3 m off the center, where the cosine is 0.5 (4.67 s), until it turns back; nothing was
    // completed.
    assert_eq!(t.span("ego.lane_change_phase", "execute"), Some((47, first - 1)));
    assert_eq!(t.span("ego.lane_change_phase", "complete"), None);
    // Nor is it known of a car of unknown width how near it came.
    let mut unsized_car = d.clone();
    unsized_car.ego.as_mut().unwrap().width_m = f64::NAN;
    assert_eq!(Table::of(&unsized_car).ego_flag("ego.lane_change_aborted", 62), Unknown);
    // 0.53 m out its side is 0.33 m from the line of a lane of 3.5 m: wandering.
    let mut d = drive(120, move |t| (12.0 * t, 0.44 * out(t), 0.0));
    d.map = Some(road());
    d.ego.as_mut().unwrap().width_m = 1.78;
    assert_eq!(when(&Table::of(&d), "ego.lane_change_aborted", 120), None);
    // There is no lane to the right: keeping away from the edge is no aborted lane change.
    let mut d = drive(120, move |t| (12.0 * t, -out(t), 0.0));
    d.map = Some(road());
    assert_eq!(when(&Table::of(&d), "ego.lane_change_aborted", 120), None);
    // Nor is a completed lane change.
    let mut d = drive(120, |t| (12.0 * t, shift(t), 0.0));
    d.map = Some(road());
    assert_eq!(when(&Table::of(&d), "ego.lane_change_aborted", 120), None);
}
