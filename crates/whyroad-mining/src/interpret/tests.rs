//! Small signal tables by hand; expected truths from the definitions in `docs/reference/rules.md`.

mod lasting;
mod objects;

use super::*;
use crate::language::{Checker, parse};
use std::collections::BTreeMap;
use whyroad_model::{FrameRange, Nanos, ObjectClass};
use whyroad_signals::Catalog;

const N: f64 = f64::NAN;

fn at(seconds: f64) -> Nanos {
    Nanos(1_700_000_000_000_000_000).plus_secs(seconds)
}

fn table(times: &[f64], speed: &[f64]) -> SignalTable {
    SignalTable {
        drive_id: "d".into(),
        times: times.iter().map(|t| at(*t)).collect(),
        frame_columns: BTreeMap::from([("ego.speed".to_owned(), Column::Number(speed.to_vec()))]),
        ..SignalTable::default()
    }
}

fn tenths(n: usize) -> Vec<f64> {
    (0..n).map(|i| i as f64 / 10.0).collect()
}

/// `1`, `0` or `?` per row.
fn truths(text: &str, table: &SignalTable, target: Option<usize>) -> String {
    let mut checker = Checker::new(Catalog::bundled());
    let id = checker.condition(&parse::parse(text).unwrap()).unwrap();
    let mut evaluator = Evaluator::new(&checker.program, table);
    let mut pass = evaluator.pass(target.map(|t| &table.targets[t]));
    let Series::Truths(t) = evaluator.series(id, &mut pass).as_ref().clone() else { panic!("{text}") };
    text_of(text, &t)
}

/// `1`, `0` or `?` per row, after a check of the margins.
fn text_of(text: &str, t: &Truths) -> String {
    for (v, m) in t.value.iter().zip(&t.margin) {
        let agrees = match v {
            Tri::True => *m >= 0.0,
            Tri::False => *m <= 0.0,
            Tri::Unknown => m.is_nan(),
        };
        assert!(agrees && (m.is_nan() || m.abs() <= MARGIN_LIMIT), "{text}: {v:?} with margin {m}");
    }
    t.value
        .iter()
        .map(|t| match t {
            Tri::True => '1',
            Tri::False => '0',
            Tri::Unknown => '?',
        })
        .collect()
}

fn of_speeds(text: &str, speed: &[f64]) -> String {
    truths(text, &table(&tenths(speed.len()), speed), None)
}

#[test]
fn unknown_is_neither_true_nor_false() {
    let v = [1.0, N, 9.0];
    assert_eq!(of_speeds("ego.speed > 5 m/s", &v), "0?1");
    assert_eq!(of_speeds("not ego.speed > 5 m/s", &v), "1?0");
    assert_eq!(of_speeds("ego.speed > 5 m/s or ego.speed <= 5 m/s", &v), "1?1");
    assert_eq!(of_speeds("ego.speed > 5 m/s and false", &v), "000");
    assert_eq!(of_speeds("ego.speed is known", &v), "101");
    assert_eq!(of_speeds("ego.speed is unknown", &v), "010");
    assert_eq!(of_speeds("ego.accel > 0 m/s2", &v), "???", "a signal that the log lacks");
    assert_eq!(of_speeds("ego.lane_change == left", &v), "???");
}

#[test]
fn bounds_are_closed_where_they_say_so() {
    assert_eq!(of_speeds("ego.speed > 5 m/s", &[5.0]), "0");
    assert_eq!(of_speeds("ego.speed >= 5 m/s", &[5.0]), "1");
    assert_eq!(of_speeds("2 m/s < ego.speed <= 5 m/s", &[2.0, 3.0, 5.0, 6.0]), "0110");
}

#[test]
fn an_edge_needs_the_frame_before_it() {
    assert_eq!(of_speeds("rises(ego.speed > 5 m/s)", &[9.0, 1.0, 9.0, 9.0, N, 9.0]), "?0100?");
    assert_eq!(of_speeds("falls(ego.speed > 5 m/s)", &[1.0, 9.0, 1.0, 1.0]), "?010");
    assert_eq!(of_speeds("rises(ego.speed > 5 m/s)", &[1.0, 9.0]), "01");
}

#[test]
fn for_marks_the_whole_run() {
    // Half a second is five frames at 10 Hz: a frame lasts until the next one.
    let run = |n: usize| [vec![0.0; 3], vec![9.0; n], vec![0.0; 3]].concat();
    assert_eq!(of_speeds("ego.speed > 5 m/s for 0.5 s", &run(5)), "00011111000");
    assert_eq!(of_speeds("ego.speed > 5 m/s for 0.5 s", &run(4)), "0000000000");
    // At the edges of the drive the run may have been longer than recorded.
    assert_eq!(of_speeds("ego.speed > 5 m/s for 0.5 s", &[9.0, 9.0, 0.0, 9.0]), "??0?");
    // An unknown frame may or may not have joined two runs.
    assert_eq!(of_speeds("ego.speed > 5 m/s for 0.5 s", &[0.0, 9.0, 9.0, N, 9.0, 9.0, 0.0]), "0?????0");
    assert_eq!(of_speeds("ego.speed > 5 m/s for 0.5 s", &[0.0, 9.0, 9.0, N, 9.0, 0.0, 0.0]), "0000000");
}

#[test]
fn frame_clocks_may_jitter() {
    // AV2: 0.100196 s on average; a little less now and then must not break a duration.
    let times = [0.0, 0.1, 0.1999, 0.2997, 0.3996, 0.4995, 0.6, 0.7];
    let speed = [0.0, 9.0, 9.0, 9.0, 9.0, 9.0, 0.0, 0.0];
    assert_eq!(truths("ego.speed > 5 m/s for 0.5 s", &table(&times, &speed), None), "01111100");
}

#[test]
fn a_gap_in_the_log_is_unknown_time() {
    // Two frames lost after 0.1 s: the row in the middle is the gap.
    let t = table(&[0.0, 0.1, 0.4, 0.5, 0.6], &[9.0, 9.0, 9.0, 9.0, 0.0]);
    assert_eq!(truths("ego.speed > 5 m/s", &t, None), "11?110");
    assert_eq!(
        truths("rises(ego.speed > 5 m/s)", &t, None),
        "?00?00",
        "after a gap, nothing is known of the frame before"
    );
    let t = table(&[0.0, 0.1, 0.4, 0.5, 0.6], &[0.0, 9.0, 9.0, 9.0, 0.0]);
    assert_eq!(
        truths("ego.speed > 5 m/s for 0.5 s", &t, None),
        "0????0",
        "0.1 s to 0.6 s, if it held in the gap"
    );
    assert_eq!(truths("ego.speed > 5 m/s for 0.7 s", &t, None), "000000");
}

#[test]
fn windows_are_closed_and_unknown_beyond_the_recording() {
    let v = [0.0, 0.0, 9.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    assert_eq!(of_speeds("ego.speed > 5 m/s within 0.2 s", &v), "111000??");
    assert_eq!(of_speeds("previously(ego.speed > 5 m/s, 0.2 s)", &v), "??011000");
    assert_eq!(of_speeds("previously(ego.speed > 5 m/s)", &v), "???11111");
    assert_eq!(of_speeds("ego.speed > 5 m/s then ego.speed < 1 m/s within 0.2 s", &v), "??011000");
    assert_eq!(of_speeds("max(ego.speed, 0.1 s) > 5 m/s", &v), "?0110000");
    assert_eq!(of_speeds("share(ego.speed > 5 m/s, 0.1 s) >= 50 %", &v), "?0110000");
    assert_eq!(
        of_speeds("max(ego.speed, 0.1 s) > 5 m/s", &[N, 9.0, 9.0]),
        "??1",
        "a part of the window is unknown"
    );
}

#[test]
fn what_is_not_of_the_target_is_judged_over_the_whole_drive() {
    let speed = [9.0, 9.0, 9.0, 9.0, 9.0, 9.0, 9.0];
    let mut t = table(&tenths(7), &speed);
    t.targets.push(TargetSpan {
        id: "a".into(),
        class: ObjectClass::Car,
        first_row: 0,
        frames: FrameRange::new(4, 6),
    });
    t.target_columns.insert("target.gap".to_owned(), Column::Number(vec![3.0, N]));
    // The target is seen for 0.2 s only, the ego was fast for 0.5 s and more.
    assert_eq!(truths("ego.speed > 5 m/s for 0.5 s", &t, Some(0)), "11");
    assert_eq!(truths("target.gap < 5 m and (ego.speed > 5 m/s for 0.5 s)", &t, Some(0)), "1?");
    // Before it was seen, nothing is known of the target.
    assert_eq!(truths("rises(target.gap < 5 m)", &t, Some(0)), "?0");
}

#[test]
fn margins_are_in_typical_magnitudes() {
    // ego.speed has scale 5 m/s in the catalog.
    let mut checker = Checker::new(Catalog::bundled());
    let id = checker.condition(&parse::parse("ego.speed > 5 m/s").unwrap()).unwrap();
    let t = table(&tenths(3), &[10.0, 2.5, 500.0]);
    let mut evaluator = Evaluator::new(&checker.program, &t);
    let mut pass = evaluator.pass(None);
    let Series::Truths(t) = evaluator.series(id, &mut pass).as_ref().clone() else { panic!() };
    assert_eq!(t.margin, [1.0, -0.5, MARGIN_LIMIT]);
}
