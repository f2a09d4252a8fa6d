//! Hand-made motions; expected decisions from LABELING.md 2 and the classes' typical decisions.

mod agree;
mod claims;
mod lights;
mod maneuver;
mod motion;
mod others;
mod supported;
mod written;

use super::*;
use crate::fixture;
use std::sync::Arc;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::messages::Uncertainty;
use whyroad_model::{Column, Tri};

const META: [&str; 4] = ["stop", "gentle_decelerate", "maintain_speed", "gentle_accelerate"];

/// One meta action per frame, by index into [`META`]; the ego is stationary wherever it is `stop`. The speed follows:
/// from 10 m/s on it changes by 1.5 m/s2, down to walking pace at minimum.
fn with_motion(signals: &mut SignalTable, meta: impl Fn(usize) -> u16) {
    let codes: Vec<u16> = (0..fixture::FRAMES).map(meta).collect();
    let speed = codes.iter().scan(10.0_f64, |v, code| {
        *v = match code {
            0 => 0.0,
            1 => (*v - 0.15).max(0.5),
            3 => *v + 0.15,
            _ => *v,
        };
        Some(*v)
    });
    signals.frame_columns.insert("ego.speed".into(), Column::Number(speed.collect()));
    let standing = codes.iter().map(|&c| Tri::from(c == 0)).collect();
    let names: Arc<[String]> = META.iter().map(|s| (*s).to_owned()).collect();
    signals.frame_columns.insert("ego.meta_longitudinal".into(), Column::Category { codes, names });
    signals.frame_columns.insert("ego.standstill".into(), Column::Flag(standing));
}

fn category(names: &[&str], codes: Vec<u16>) -> Column {
    Column::Category { codes, names: names.iter().map(|s| (*s).to_owned()).collect() }
}

/// Where the ego turns by its movement, its heading changes by 0.3 rad/s, by a quarter of a circle at most.
fn turn_with(drive: &mut Drive, signals: &SignalTable) {
    let Some(column) = signals.frame_columns.get("ego.movement") else { return };
    let rate = |f: usize| match column.category(f) {
        Some("left" | "uturn") => 0.03,
        Some("right") => -0.03,
        _ => 0.0,
    };
    let heading = (0..fixture::FRAMES).scan(0.0_f64, |at, f| {
        *at = (*at + rate(f)).clamp(-1.57, 1.57);
        Some(*at)
    });
    drive.ego.as_mut().unwrap().motion.heading = heading.collect();
}

/// The ego turns to `side`, from 2 s after the keyframe on.
fn turns(signals: &mut SignalTable, side: &str) {
    let codes = (0..fixture::FRAMES).map(|f| if f < 60 { u16::MAX } else { 0 }).collect();
    signals.frame_columns.insert("ego.movement".into(), category(&[side], codes));
}

/// The draft of an episode of `leaf` with its keyframe at frame 40.
fn draft_of(leaf: &str, change: impl FnOnce(&mut SignalTable)) -> Draft {
    let mut drive = fixture::drive("d");
    let mut signals = fixture::signals(&drive);
    change(&mut signals);
    turn_with(&mut drive, &signals);
    let mut episode = fixture::episode(&drive);
    episode.scenario_id = leaf.parse().unwrap();
    draft(Framework::bundled(), &drive, &signals, &episode, Lang::Zh)
}

/// Speeds by frame, m/s, the accelerations between them, and the matching meta actions.
fn with_speed(signals: &mut SignalTable, speed: impl Fn(usize) -> f64) {
    let speeds: Vec<f64> = (0..fixture::FRAMES).map(speed).collect();
    let accel = |f: usize| (speeds[(f + 1).min(fixture::FRAMES - 1)] - speeds[f]) * 10.0;
    let meta = |f: usize| match accel(f) {
        _ if speeds[f] < 0.3 => 0,
        a if a < -0.5 => 1,
        a if a > 0.5 => 3,
        _ => 2,
    };
    with_motion(signals, meta);
    let accels = (0..fixture::FRAMES).map(accel).collect();
    signals.frame_columns.insert("ego.accel".into(), Column::Number(accels));
    signals.frame_columns.insert("ego.speed".into(), Column::Number(speeds));
}

/// A column of the only target, the same in every row.
fn of_target(signals: &mut SignalTable, name: &str, value: f64) {
    signals.target_columns.insert(name.into(), Column::Number(vec![value; fixture::FRAMES]));
}

/// Flags of the only target and of the ego, the same in every frame.
fn flag(signals: &mut SignalTable, name: &str, value: bool) {
    let column = Column::Flag(vec![Tri::from(value); fixture::FRAMES]);
    let columns =
        if name.starts_with("target.") { &mut signals.target_columns } else { &mut signals.frame_columns };
    columns.insert(name.into(), column);
}

/// The label of an episode of `leaf` whose rule names no target; the only track is the lead, its center `ahead` m in
/// front of the center of the ego. The ego is 4.8 m long, the lead 4.5 m: the gap is 4.65 m less.
fn behind_lead(leaf: &str, ahead: f64, change: impl FnOnce(&mut SignalTable)) -> CocLabel {
    let mut drive = fixture::drive("d");
    let mut signals = fixture::signals(&drive);
    flag(&mut signals, "target.is_lead", true);
    of_target(&mut signals, "target.longitudinal", ahead);
    of_target(&mut signals, "target.lateral", 0.0);
    of_target(&mut signals, "target.heading_difference", 0.0);
    change(&mut signals);
    turn_with(&mut drive, &signals);
    let mut episode = fixture::episode(&drive);
    episode.scenario_id = leaf.parse().unwrap();
    episode.target_id = None;
    draft(Framework::bundled(), &drive, &signals, &episode, Lang::Zh).label
}

/// Number of numbers in a text: runs of digits.
fn numbers(text: &str) -> usize {
    text.split(|c: char| !c.is_ascii_digit()).filter(|run| !run.is_empty()).count()
}

/// A column of the only target by frame.
fn by_frame(signals: &mut SignalTable, name: &str, value: impl Fn(usize) -> f64) {
    let values = (0..fixture::FRAMES).map(value).collect();
    signals.target_columns.insert(name.into(), Column::Number(values));
}
