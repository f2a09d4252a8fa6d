//! Hand-made scenes on a straight road: which object holds the ego is known by construction.

use super::*;
use std::collections::BTreeMap;
use std::sync::Arc;
use whyroad_model::scene::{Ego, Motion, Track};
use whyroad_model::{Column, Nanos, ObjectClass};

const FRAMES: usize = 300;
const START: usize = 100;

fn seconds(f: usize) -> f64 {
    f as f64 * 0.1
}

/// An object with the position `at` (m, along and beside the road) by time in seconds.
fn track(id: &str, class: ObjectClass, size: (f64, f64), at: impl Fn(f64) -> (f64, f64)) -> Track {
    let mut motion = Motion::unknown(FRAMES);
    for f in 0..FRAMES {
        let ((x, y), (x2, y2)) = (at(seconds(f)), at(seconds(f) + 0.1));
        (motion.x[f], motion.y[f]) = (x, y);
        (motion.vx[f], motion.vy[f]) = ((x2 - x) / 0.1, (y2 - y) / 0.1);
        motion.heading[f] =
            if motion.vx[f] == 0.0 && motion.vy[f] == 0.0 { 0.0 } else { motion.vy[f].atan2(motion.vx[f]) };
    }
    Track {
        id: id.into(),
        class,
        frames: (0..FRAMES as u32).collect(),
        motion,
        length_m: vec![size.0; FRAMES],
        width_m: vec![size.1; FRAMES],
        height_m: vec![1.6; FRAMES],
        ..Track::default()
    }
}

/// The ego drives at 12 m/s, and decelerates after the start by `slows` (m/s2).
fn scene(tracks: Vec<Track>, slows: f64, light: Option<(f64, &str)>) -> (Drive, SignalTable) {
    let mut speed = vec![12.0; FRAMES];
    let mut x = vec![0.0; FRAMES];
    for f in 1..FRAMES {
        speed[f] = if f > START { (speed[f - 1] - slows * 0.1_f64).max(0.0) } else { 12.0 };
        x[f] = x[f - 1] + 0.1 * speed[f - 1];
    }
    let motion = Motion {
        heading: vec![0.0; FRAMES],
        y: vec![0.0; FRAMES],
        vx: speed.clone(),
        vy: vec![0.0; FRAMES],
        x: x.clone(),
        ..Motion::unknown(FRAMES)
    };
    let times: Vec<Nanos> = (0..FRAMES).map(|f| Nanos(f as i64 * 100_000_000)).collect();
    let mut columns = BTreeMap::from([("ego.speed".to_owned(), Column::Number(speed))]);
    if let Some((line, state)) = light {
        let distance = x.iter().map(|x| line - x).collect();
        columns.insert("light.distance_to_stop_line".to_owned(), Column::Number(distance));
        let names: Arc<[String]> = vec![state.to_owned()].into();
        columns.insert("light.state".to_owned(), Column::Category { codes: vec![0; FRAMES], names });
    }
    let signals = SignalTable { times: times.clone(), frame_columns: columns, ..SignalTable::default() };
    let ego = Ego { length_m: 4.6, width_m: 1.9, motion, ..Ego::default() };
    (Drive { times, ego: Some(ego), tracks, ..Drive::default() }, signals)
}

fn effect<'c>(found: &'c Counterfactual, id: &str) -> &'c Effect {
    found
        .effects
        .iter()
        .find(|e| e.removed == Removed::Object(id.into()))
        .unwrap_or_else(|| panic!("{id}: {found:#?}"))
}

/// Position of the ego at the start, m.
const EGO: f64 = 12.0 * 10.0;

#[test]
fn a_slow_lead_holds_the_ego_and_a_car_beside_it_does_not() {
    let lead = track("lead", ObjectClass::Car, (4.5, 1.8), |s| (EGO + 25.0 + 5.0 * (s - 10.0), 0.0));
    let beside = track("beside", ObjectClass::Car, (4.5, 1.8), |s| (EGO + 12.0 * (s - 10.0), 3.5));
    let (drive, signals) = scene(vec![beside, lead], 1.0, None);
    let found = counterfactual(&drive, &signals, START).unwrap();
    assert_eq!(found.effects[0].removed, Removed::Object("lead".into()));
    assert!(found.effects[0].is_plain(), "{found:#?}");
    assert!(effect(&found, "beside").is_none(), "{found:#?}");
}

#[test]
fn a_pedestrian_who_crosses_holds_the_ego_and_one_on_the_pavement_does_not() {
    // Comes onto the path 3 s after the start, where the ego would be then.
    let crosses =
        track("crosses", ObjectClass::Pedestrian, (0.6, 0.6), |s| (EGO + 36.0, -6.0 + 1.5 * (s - 10.0)));
    let walks = track("walks", ObjectClass::Pedestrian, (0.6, 0.6), |s| (EGO + 20.0 + 1.2 * (s - 10.0), 5.0));
    let (drive, signals) = scene(vec![crosses, walks], 2.0, None);
    let found = counterfactual(&drive, &signals, START).unwrap();
    assert!(effect(&found, "crosses").is_plain(), "{found:#?}");
    assert!(effect(&found, "walks").is_none(), "{found:#?}");
}

#[test]
fn a_cut_in_holds_the_ego_and_the_car_that_stays_does_not() {
    let side = |s: f64| (3.5 - 1.2 * (s - 11.0).max(0.0)).max(0.0);
    let cuts = track("cuts", ObjectClass::Car, (4.5, 1.8), move |s| (EGO + 14.0 + 8.0 * (s - 10.0), side(s)));
    let stays = track("stays", ObjectClass::Car, (4.5, 1.8), |s| (EGO + 30.0 + 8.0 * (s - 10.0), -3.6));
    let (drive, signals) = scene(vec![cuts, stays], 1.0, None);
    let found = counterfactual(&drive, &signals, START).unwrap();
    assert!(effect(&found, "cuts").is_plain() && effect(&found, "stays").is_none(), "{found:#?}");
}

#[test]
fn the_light_holds_the_first_in_line_and_the_stopped_lead_holds_the_second() {
    let (drive, signals) = scene(vec![], 1.5, Some((EGO + 50.0, "red")));
    let found = counterfactual(&drive, &signals, START).unwrap();
    assert_eq!(found.effects.len(), 1);
    assert!(found.effects[0].is_plain(), "{found:#?}");
    let lead = track("lead", ObjectClass::Car, (4.5, 1.8), |_| (EGO + 46.0, 0.0));
    let (drive, signals) = scene(vec![lead], 1.5, Some((EGO + 50.0, "red")));
    let found = counterfactual(&drive, &signals, START).unwrap();
    // Without the light the lead is still there: the light changes nothing (LABELING.md 6, proximate cause).
    let light = found.effects.iter().find(|e| e.removed == Removed::Light).unwrap();
    assert!(light.is_none(), "{found:#?}");
    let (drive, signals) = scene(vec![], 0.0, Some((EGO + 50.0, "green")));
    assert_eq!(counterfactual(&drive, &signals, START).unwrap().effects, []);
}

#[test]
fn a_drive_without_speed_has_no_answer() {
    let (drive, mut signals) = scene(vec![], 0.0, None);
    signals.frame_columns.clear();
    assert_eq!(counterfactual(&drive, &signals, START), None);
}

#[test]
fn what_holds_the_ego_instead_of_what_is_named_was_seen_before() {
    let lead = track("lead", ObjectClass::Car, (4.5, 1.8), |s| (EGO + 25.0 + 5.0 * (s - 10.0), 0.0));
    let walks = track("walks", ObjectClass::Pedestrian, (0.6, 0.6), |s| (EGO + 20.0 + 1.2 * (s - 10.0), 5.0));
    let (drive, signals) = scene(vec![walks, lead], 1.0, None);
    let found = counterfactual(&drive, &signals, START).unwrap();
    let thing = |id: &str| Removed::Object(id.into());
    let other =
        |named: &str, seen: bool| found.instead_of(&[thing(named)], |_| seen).map(|e| e.removed.clone());
    assert_eq!(other("walks", true), Some(thing("lead")));
    assert_eq!((other("walks", false), other("lead", true)), (None, None));
}
