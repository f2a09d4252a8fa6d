//! Time of the checks of a label against its drive, with the drive loaded: `cargo bench -p whyroad-label --bench
//! motion`. The drive is generated here: an ego behind a lead, with cars beside it and crossing people, so that the ten
//! most relevant objects are among many.
#![allow(clippy::print_stdout)] // printing is what a bench is for

use std::collections::BTreeMap;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;
use whyroad_framework::Framework;
use whyroad_framework::check::{Document, Origin};
use whyroad_label::check::{Checker, Recorded, Recordings};
use whyroad_label::counterfactual::counterfactual;

use whyroad_model::scene::{Ego, Motion, Track};
use whyroad_model::signal::TargetSpan;
use whyroad_model::time::FrameRange;
use whyroad_model::{Column, Drive, Nanos, ObjectClass, SignalTable, Tri};

const LABEL: &str = include_str!("../../../examples/cutin_urgent_example.en.json");
const HZ: f64 = 10.0;
/// 60 s before and after the keyframe.
const FRAMES: usize = 1200;
const KEYFRAME: usize = 600;

/// Straight on along x at `speed`, `y` to the left; a crossing object moves along y instead.
fn motion(x: f64, y: f64, speed: f64, crosses: bool) -> Motion {
    let mut m = Motion::unknown(FRAMES);
    for f in 0..FRAMES {
        let t = (f as f64 - KEYFRAME as f64) / HZ;
        // Drivers vary their speed slightly; the model is fitted to this.
        let way = speed * t + 0.4 * (0.5 * t).sin();
        (m.x[f], m.y[f]) = if crosses { (x, y + way) } else { (x + way, y) };
        (m.vx[f], m.vy[f]) = if crosses { (0.0, speed) } else { (speed + 0.2 * (0.5 * t).cos(), 0.0) };
        m.heading[f] = if crosses { std::f64::consts::FRAC_PI_2 } else { 0.0 };
    }
    m
}

fn recorded(objects: usize, keyframe: Nanos) -> Recorded {
    let ego = motion(0.0, 0.0, 10.0, false);
    let times: Vec<Nanos> =
        (0..FRAMES).map(|f| keyframe.plus_secs((f as f64 - KEYFRAME as f64) / HZ)).collect();
    let tracks: Vec<Track> = (0..objects)
        .map(|i| {
            let far = 12.0 + 6.0 * (i / 4) as f64;
            let (class, motion) = match i % 4 {
                0 => (ObjectClass::Car, motion(far, 0.0, 8.0, false)),
                1 => (ObjectClass::Car, motion(far - 20.0, 3.5, 11.0, false)),
                2 => (ObjectClass::Truck, motion(far - 10.0, -3.5, 9.0, false)),
                _ => (ObjectClass::Pedestrian, motion(30.0 + far, -4.0, 1.2, true)),
            };
            let (length, width) = if class == ObjectClass::Pedestrian { (0.4, 0.5) } else { (4.5, 1.8) };
            Track {
                id: format!("o{i}").as_str().into(),
                class,
                frames: (0..FRAMES as u32).collect(),
                motion,
                length_m: vec![length; FRAMES],
                width_m: vec![width; FRAMES],
                height_m: vec![1.6; FRAMES],
                ..Track::default()
            }
        })
        .collect();
    let of_ego = |value: &dyn Fn(usize) -> f64| Column::Number((0..FRAMES).map(value).collect());
    let of_targets = |value: &dyn Fn(&Track, usize) -> f64| {
        Column::Number(tracks.iter().flat_map(|t| (0..FRAMES).map(move |f| value(t, f))).collect())
    };
    let frame_columns = BTreeMap::from([
        ("ego.speed".to_owned(), of_ego(&|f| ego.speed(f))),
        ("lead.exists".to_owned(), Column::Flag(vec![Tri::True; FRAMES])),
        ("lead.gap".to_owned(), of_ego(&|f| tracks[0].motion.x[f] - ego.x[f] - 4.5)),
    ]);
    let target_columns = BTreeMap::from([
        ("target.distance".to_owned(), of_targets(&|t, f| (t.motion.x[f] - ego.x[f]).hypot(t.motion.y[f]))),
        ("target.lateral".to_owned(), of_targets(&|t, f| t.motion.y[f])),
        ("target.path_lateral".to_owned(), of_targets(&|t, f| t.motion.y[f])),
        ("target.speed".to_owned(), of_targets(&|t, f| t.motion.speed(f))),
    ]);
    let targets = tracks
        .iter()
        .enumerate()
        .map(|(i, t)| TargetSpan {
            id: t.id.clone(),
            class: t.class,
            first_row: i * FRAMES,
            frames: FrameRange { start: 0, end: FRAMES },
        })
        .collect();
    let signals = SignalTable {
        times: times.clone(),
        frame_columns,
        targets,
        target_columns,
        ..SignalTable::default()
    };
    let ego = Ego { length_m: 4.6, width_m: 1.9, motion: ego, ..Ego::default() };
    let drive = Drive { times, ego: Some(ego), tracks, ..Drive::default() };
    Recorded { drive: Arc::new(drive), signals: Arc::new(signals), episodes: Vec::new() }
}

struct One(Arc<Recorded>);

impl Recordings for One {
    fn of_clip(&self, _: &str) -> Option<Arc<Recorded>> {
        Some(Arc::clone(&self.0))
    }
}

/// Milliseconds per call: the median and the slowest of `calls`.
fn timed(calls: usize, mut f: impl FnMut()) -> (f64, f64) {
    let mut all: Vec<f64> = (0..calls)
        .map(|_| {
            let start = Instant::now();
            f();
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    all.sort_by(f64::total_cmp);
    (all[calls / 2], all[calls - 1])
}

fn main() {
    let calls = if std::env::args().any(|a| a == "--test") { 2 } else { 500 };
    let Ok(mut label) = serde_json::from_str::<serde_json::Value>(LABEL) else { return };
    label["critical_components"][0]["linked_objects"] = serde_json::json!(["o1"]);
    let text = label.to_string();
    let Some(keyframe) = label["keyframe"]["timestamp"].as_str().and_then(|t| Nanos::parse_iso(t).ok())
    else {
        return;
    };
    for objects in [10, 50, 200] {
        let recorded = Arc::new(recorded(objects, keyframe));
        let (drive, signals) = (&recorded.drive, &recorded.signals);
        let Some(found) = counterfactual(drive, signals, KEYFRAME) else { return };
        let removed = found.effects.len();
        let model = timed(calls, || {
            black_box(counterfactual(black_box(drive), signals, KEYFRAME));
        });
        let (plain, with) = (
            Checker::new(Framework::bundled()),
            Checker::new(Framework::bundled()).with_recordings(Arc::new(One(Arc::clone(&recorded)))),
        );
        let check = |checker: &Checker<'_>| {
            let mut found = Vec::new();
            let document = Document { origin: Origin::start(), bytes: black_box(text.as_bytes()) };
            black_box(checker.check(&document, &mut found));
            found.len()
        };
        let findings = check(&with);
        let texts_only = timed(calls, || {
            check(&plain);
        });
        let all = timed(calls, || {
            check(&with);
        });
        println!(
            "motion/{objects} objects: counterfactual of {removed} things {:.3} ms (slowest {:.3}); \
             whole check with the drive {:.3} ms (slowest {:.3}), {findings} findings; without it {:.3} ms",
            model.0, model.1, all.0, all.1, texts_only.0
        );
    }
}
