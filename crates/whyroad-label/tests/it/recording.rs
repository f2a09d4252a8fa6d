//! Labels against a recording in closed form: the ego drives east and brakes, beside it a car, a bus and a crossing
//! vehicle. What is true is in the formulas; distances, sides and speeds of the texts follow from them.

use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::Arc;
use whyroad_framework::Framework;
use whyroad_label::check::{Checker, Recorded, Recordings};
use whyroad_model::scene::{Ego, Motion, Track};
use whyroad_model::signal::TargetSpan;
use whyroad_model::time::FrameRange;
use whyroad_model::{Column, Diagnostic, Drive, Nanos, ObjectClass, SignalTable};

const FRAMES: usize = 160;
/// The keyframe, 8 s after the start.
const KEYFRAME: usize = 80;
const TIME: &str = "2026-01-15T10:30:10.000Z";

fn time() -> Nanos {
    Nanos::parse_iso(TIME).unwrap()
}

/// The ego's speed, m/s: 10 up to the keyframe, then braking at 2 m/s2 to 4, or `turns` at a steady 10 m/s.
fn speed(frame: usize) -> f64 {
    (10.0 - 0.2 * frame.saturating_sub(KEYFRAME) as f64).max(4.0)
}

/// One object: class, position and heading relative to the ego at the keyframe, and speed, m, rad, m/s.
type Object = (&'static str, ObjectClass, [f64; 2], f64, f64);

/// In the order of their ids, as the tracks of a drive.
const OBJECTS: [Object; 4] = [
    ("any", ObjectClass::Vehicle, [25.0, 3.5], 0.0, 9.0),
    ("bus", ObjectClass::Bus, [40.0, 12.0], -std::f64::consts::FRAC_PI_2, 8.0),
    ("car", ObjectClass::Car, [10.0, 0.0], 0.0, 5.0),
    ("late", ObjectClass::Car, [30.0, 0.0], 0.0, 2.0),
];

/// The drive, its last `FRAMES - end` frames cut off; `late` comes into view 3 s after the keyframe. The ego's heading
/// changes by `turn_deg` in the 4 s after the keyframe.
fn recorded(end: usize, turn_deg: f64) -> Recorded {
    let times: Vec<Nanos> = (0..end).map(|f| time().plus_secs((f as f64 - KEYFRAME as f64) / 10.0)).collect();
    let mut ego = Motion::unknown(end);
    for f in 0..end {
        let turned = (f.saturating_sub(KEYFRAME) as f64 / 40.0).min(1.0);
        (ego.x[f], ego.y[f], ego.heading[f]) = (f as f64, 0.0, turned * turn_deg.to_radians());
        (ego.vx[f], ego.vy[f]) = (speed(f), 0.0);
    }
    let (mut tracks, mut targets, mut rows) = (Vec::new(), Vec::new(), 0);
    let mut columns: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for (id, class, [x, y], heading, v) in OBJECTS {
        let first = if id == "late" { KEYFRAME + 30 } else { 0 };
        if first >= end {
            continue;
        }
        let n = end - first;
        tracks.push(Track {
            id: id.into(),
            class,
            frames: (first as u32..end as u32).collect(),
            motion: Motion::unknown(n),
            ..Track::default()
        });
        targets.push(TargetSpan {
            id: id.into(),
            class,
            first_row: rows,
            frames: FrameRange { start: first, end },
        });
        rows += n;
        let values = [
            ("target.longitudinal", x),
            ("target.lateral", y),
            ("target.distance", x.hypot(y)),
            ("target.heading_difference", heading),
            ("target.speed", v),
            ("target.accel", 0.0),
        ];
        for (name, value) in values {
            columns.entry(name.to_owned()).or_default().extend(std::iter::repeat_n(value, n));
        }
    }
    let signals = SignalTable {
        times: times.clone(),
        frame_columns: BTreeMap::from([(
            "ego.speed".to_owned(),
            Column::Number((0..end).map(speed).collect()),
        )]),
        targets,
        target_columns: columns.into_iter().map(|(name, v)| (name, Column::Number(v))).collect(),
        ..SignalTable::default()
    };
    let ego = Ego { length_m: 4.6, width_m: 1.9, motion: ego, ..Ego::default() };
    let drive = Drive { times, ego: Some(ego), tracks, ..Drive::default() };
    Recorded { drive: Arc::new(drive), signals: Arc::new(signals), episodes: Vec::new() }
}

struct Lake {
    turn_deg: f64,
    /// What Stage I knew of the car's speed, m/s.
    then: f64,
}

impl Recordings for Lake {
    fn of_clip(&self, _: &str) -> Option<Arc<Recorded>> {
        Some(Arc::new(recorded(FRAMES, self.turn_deg)))
    }

    fn until(&self, _: &str, keyframe: Nanos) -> Option<Arc<Recorded>> {
        assert_eq!(keyframe, time());
        let mut cut = recorded(KEYFRAME + 1, 0.0);
        let signals = Arc::get_mut(&mut cut.signals).unwrap();
        let Some(Column::Number(speeds)) = signals.target_columns.get_mut("target.speed") else { panic!() };
        // The rows of the car, the third object.
        speeds[2 * (KEYFRAME + 1)..].fill(self.then);
        Some(Arc::new(cut))
    }
}

/// The whole drive alone, without what Stage I showed.
struct Whole;

impl Recordings for Whole {
    fn of_clip(&self, _: &str) -> Option<Arc<Recorded>> {
        Some(Arc::new(recorded(FRAMES, 0.0)))
    }
}

fn label(class: [&str; 3], decision: Value, components: &[(&str, &str)]) -> Value {
    let part = |(i, (text, id)): (usize, &(&str, &str))| {
        let own = format!("c{i}");
        json!({ "id": own, "description": text, "linked_objects": [id] })
    };
    let channel = if decision["longitudinal"].is_null() { "lateral" } else { "longitudinal" };
    let ids: Vec<String> = (0..components.len()).map(|i| format!("c{i}")).collect();
    json!({
        "version": "2.1.0",
        "clip_id": "clip_1",
        "scenario": { "l1": class[0], "l2": class[1], "l3": class[2] },
        "time_range": { "start_timestamp": TIME, "end_timestamp": "2026-01-15T10:30:15.000Z" },
        "keyframe": { "timestamp": TIME, "frame_idx": 100, "type": "reactive" },
        "driving_decision": decision,
        "critical_components": components.iter().enumerate().map(part).collect::<Vec<_>>(),
        "coc_trace": "前方的车挡在自车要走的路线上，继续前行会与它相撞，因此自车减速让行，等它过去。",
        "causes": { channel: { "components": ids } },
        "provenance": { "source": "person" },
    })
}

fn found(checker: &Checker<'_>, label: &Value, part: &str) -> Vec<(&'static str, bool)> {
    let all: Vec<Diagnostic> = checker.check_text(&label.to_string());
    let of = all.iter().filter(|d| d.code.starts_with(part));
    of.map(|d| (d.code, d.severity == whyroad_model::Severity::Error)).collect()
}

fn whole(turn_deg: f64, then: f64) -> Checker<'static> {
    Checker::new(Framework::bundled()).with_recordings(Arc::new(Lake { turn_deg, then }))
}

fn stage_one() -> Checker<'static> {
    Checker::new(Framework::bundled()).with_histories(Arc::new(Lake { turn_deg: 0.0, then: 5.0 }))
}

const CUT_IN: [&str; 3] = ["reactive_agent", "cutin", "slow"];

fn yields() -> Value {
    json!({ "longitudinal": "yield_to_agent", "lateral": null })
}

#[test]
fn components_are_compared_with_the_history_before_anything_is_locked() {
    let of =
        |text: &str, id: &str| found(&stage_one(), &label(CUT_IN, yields(), &[(text, id)]), "label.object.");
    for (text, id, codes) in [
        // The linked car is 10 m ahead in the ego's lane and drives 18 km/h.
        ("前方的卡车正在急刹", "car", vec![("label.object.class", true)]),
        ("后方的轿车正在靠近", "car", vec![("label.object.position", false)]),
        ("前方 60 m 处的轿车正在减速", "car", vec![("label.object.position", false)]),
        (
            "前方 60 m 处的卡车正在减速",
            "car",
            vec![("label.object.class", true), ("label.object.position", false)],
        ),
        ("前方的轿车停着不动", "car", vec![("label.object.state", false)]),
        ("前方的轿车以时速 50 公里行驶", "car", vec![("label.object.state", false)]),
        ("对向的轿车正在驶近", "car", vec![("label.object.position", false)]),
        ("前方没有车", "car", vec![("label.object.state", false)]),
        // The bus comes from the left, at a right angle.
        ("对向来车正在驶近", "bus", vec![("label.object.position", false)]),
        ("右侧的公交车正在横穿", "bus", vec![("label.object.position", true)]),
        // It is not in the history.
        ("前方的轿车正在减速", "late", vec![("label.object.unknown", true)]),
        ("a car crosses the junction ahead at 50 km/h", "car", vec![("label.object.state", false)]),
        ("the car is oncoming", "car", vec![("label.object.position", false)]),
        // True of them.
        ("前方 10 m 处的轿车正在慢行", "car", vec![]),
        ("前方的轿车以时速 20 公里行驶", "car", vec![]),
        ("左侧一辆公交车正在横穿前方路口", "bus", vec![]),
    ] {
        assert_eq!(of(text, id), codes, "{text}");
    }
}

/// The ego drives 36 km/h at the keyframe, the linked car is 10 m ahead.
#[test]
fn what_the_trace_states_of_the_ego_and_the_object_is_compared() {
    let of = |trace: &str| {
        let mut l = label(CUT_IN, yields(), &[("前方的轿车正在慢行", "car")]);
        l["coc_trace"] = trace.into();
        found(&whole(0.0, 5.0), &l, "label.motion.stated")
    };
    let wrong = [("label.motion.stated", false)];
    for trace in [
        "自车以每小时 80 公里行驶，前方的轿车正在慢行，因此自车减速让行。",
        "自车停在路口，前方的轿车正在慢行，因此自车减速让行。",
        "前方 80 米处的轿车正在慢行，再开就会追上它，因此自车减速让行。",
        "We are doing 80 km/h and the car ahead is rolling slowly, so we slow down.",
        // It drives, at 18 km/h.
        "前方的轿车停在路上不动，自车会追上它，因此自车减速让行。",
        "The car ahead is standing still and we would run into it, so we slow down.",
        // The same car again.
        "前方的轿车停在路上，那辆轿车马上就到眼前，因此自车减速让行。",
    ] {
        assert_eq!(of(trace), wrong, "{trace}");
    }
    for trace in [
        "自车以每小时 40 公里行驶，前方的轿车正在慢行，因此自车减速让行。",
        "前方的轿车正在慢行，再开就会追上它，因此自车停在路口。",
        // What it will do, and another of its kind.
        "前方的轿车正在慢行，马上要停下来，因此自车减速让行。",
        "前方的轿车正在慢行，更远处的轿车停着不动，因此自车减速让行。",
        "本路限速每小时 80 公里，前方的轿车正在慢行，因此自车减速让行。",
        "前方 12 米处的轿车正在慢行，因此自车减速让行。",
        "We are doing 35 km/h and the car ahead is rolling slowly, so we slow down.",
    ] {
        assert!(of(trace).is_empty(), "{trace}");
    }
}

#[test]
fn an_object_that_appears_later_is_not_seen() {
    let late = label(CUT_IN, yields(), &[("前方的轿车正在减速", "late")]);
    let checker = Checker::new(Framework::bundled()).with_recordings(Arc::new(Whole));
    assert_eq!(found(&checker, &late, "label.object."), [("label.object.unseen", true)]);
    // As in the service, which compares with the drive cut at the keyframe.
    assert_eq!(found(&whole(0.0, 5.0), &late, "label.object."), [("label.object.unseen", true)]);
}

/// A log that has objects every fifth frame, as nuScenes has at 10 Hz: a drive cut at the keyframe ends between two of
/// them, and the rows after the last one are withheld. `last`: the frame of the car's last observation.
struct Sparse {
    last: usize,
}

impl Recordings for Sparse {
    fn of_clip(&self, _: &str) -> Option<Arc<Recorded>> {
        None
    }

    fn until(&self, _: &str, _: Nanos) -> Option<Arc<Recorded>> {
        let mut cut = recorded(KEYFRAME + 1, 0.0);
        let drive = Arc::get_mut(&mut cut.drive).unwrap();
        let car = drive.tracks.iter_mut().find(|t| t.class == ObjectClass::Car).unwrap();
        car.frames.truncate(self.last + 1);
        car.motion = Motion::unknown(self.last + 1);
        // Observed at frames 1, 6, 11, ...; a row between is known with the next of them.
        let next = |frame: usize| (frame + 3) / 5 * 5 + 1;
        car.known_at = (0..=self.last).map(|f| drive.times[if f == 0 { 1 } else { next(f) }]).collect();
        Some(Arc::new(cut))
    }
}

#[test]
fn an_object_of_a_log_with_few_observations_is_seen_until_the_next_one_is_due() {
    let mut draft = label(CUT_IN, yields(), &[("前方的轿车正在减速", "car")]);
    draft["critical_components"][0]["evidence_times"] = json!([TIME]);
    let unseen = |last: usize| {
        let checker = Checker::new(Framework::bundled()).with_histories(Arc::new(Sparse { last }));
        found(&checker, &draft, "label.object.unseen")
    };
    // The next observation is due at frame 81, one after the keyframe.
    assert_eq!(unseen(KEYFRAME - 4), []);
    // It should have been observed at frame 76.
    assert_eq!(unseen(KEYFRAME - 9), [("label.object.unseen", true)]);
}

/// A vehicle of unknown kind may be any of them.
#[test]
fn a_vehicle_of_unknown_kind_has_every_name_of_a_vehicle_and_none_of_a_person() {
    let of = |text: &str| found(&stage_one(), &label(CUT_IN, yields(), &[(text, "any")]), "label.object.");
    for text in ["左侧的轿车正在切入", "左侧的卡车正在切入", "左侧的公交车正在切入", "左侧一辆机动车正在切入"]
    {
        assert!(of(text).is_empty(), "{text}");
    }
    assert_eq!(of("左侧的行人正在横穿"), [("label.object.class", true)]);
}

/// The car stood by the values of Stage I, and by the smoothed ones it drives 18 km/h.
#[test]
fn what_was_true_of_the_values_of_stage_one_is_no_fault_later() {
    let standing = label(CUT_IN, yields(), &[("前方的轿车停着不动", "car")]);
    assert_eq!(found(&whole(0.0, 5.0), &standing, "label.object."), [("label.object.state", false)]);
    assert!(found(&whole(0.0, 0.2), &standing, "label.object.").is_empty());
}

/// LABELING.md 1: the axis of classification is the trigger. The ego brakes from 36 to 14 km/h; it turns by 44 degrees,
/// which the taxonomy still calls straight (below 45).
#[test]
fn a_decision_that_the_recording_shows_is_a_doubt_about_the_class() {
    let straight = ["proactive", "turn", "straight"];
    let of = |decision: Value, turn_deg: f64| {
        let l = label(straight, decision, &[("前方的轿车正在慢行", "car")]);
        let all = found(&whole(turn_deg, 5.0), &l, "label.");
        let asked = ["label.class.motion", "label.decision.impossible"];
        all.into_iter().filter(|(code, _)| asked.contains(code)).collect::<Vec<_>>()
    };
    let turn = |side: &str| json!({ "longitudinal": null, "lateral": "turn", "lateral_direction": side });
    assert_eq!(of(yields(), 0.0), [("label.class.motion", false)]);
    assert_eq!(of(turn("right"), -44.0), [("label.class.motion", false)]);
    assert_eq!(of(turn("right"), -10.0), [("label.decision.impossible", true)]);
    assert_eq!(of(turn("left"), -44.0), [("label.decision.impossible", true)]);
}

/// The ego drives this fast, m/s, by the time from the keyframe, s.
struct Drives<F>(F);

impl<F: Fn(f64) -> f64 + Send + Sync> Recordings for Drives<F> {
    fn of_clip(&self, _: &str) -> Option<Arc<Recorded>> {
        let mut whole = recorded(FRAMES, 0.0);
        let signals = Arc::get_mut(&mut whole.signals).unwrap();
        let at = |f: usize| self.0((f as f64 - KEYFRAME as f64) / 10.0);
        let speeds = Column::Number((0..FRAMES).map(at).collect());
        signals.frame_columns.insert("ego.speed".to_owned(), speeds);
        Some(Arc::new(whole))
    }
}

/// What is said of a decision about an ego that drives this fast, m/s, by the time from the keyframe, s.
fn of_motion(
    speed: impl Fn(f64) -> f64 + Send + Sync + 'static,
    decision: Value,
) -> Vec<(&'static str, bool)> {
    let l = label(CUT_IN, decision, &[("前方的轿车正在慢行", "car")]);
    found(&Checker::new(Framework::bundled()).with_recordings(Arc::new(Drives(speed))), &l, "label.motion.")
}

/// LABELING.md 2: no change of decision is null. An ego that stands at 0.0 km/h over the whole drive decides nothing.
#[test]
fn who_goes_on_standing_neither_yields_nor_stops() {
    for decision in ["yield_to_agent", "road_speed_adaptation", "stop_for_regulation", "stop_for_obstacle"] {
        let said = of_motion(|_| 0.0, json!({ "longitudinal": decision, "lateral": null }));
        assert_eq!(said, [("label.motion.no_change", false)], "{decision}");
    }
    assert!(of_motion(|_| 0.0, json!({ "longitudinal": null, "lateral": null })).is_empty());
    // It comes to a stop 0.2 s after the keyframe, from 2 m/s2.
    let stops = json!({ "longitudinal": "stop_for_obstacle", "lateral": null });
    assert!(of_motion(|s| (0.4 - 2.0 * s).max(0.0), stops).is_empty());
}

/// LABELING.md 2: the decision is the first action after the keyframe. Speeds as in Argoverse 2 logs 3bffdcff (8.1 s)
/// and 7fab2350 (11.6 s), in straight lines.
#[test]
fn a_change_of_three_meters_per_second_is_a_decision_whatever_came_before() {
    let null = || json!({ "longitudinal": null, "lateral": null });
    let unlabelled = [("label.motion.unlabelled", false)];
    let gains_then_brakes = |s: f64| if s < 0.0 { 9.0 + 1.2 * s } else { (9.0 - 2.4 * s).max(2.0) };
    assert_eq!(of_motion(gains_then_brakes, null()), unlabelled);
    let moves_off = |s: f64| if s < -0.3 { 0.0 } else { (0.4 + 1.3 * s).clamp(0.0, 4.7) };
    assert_eq!(of_motion(moves_off, null()), unlabelled);
    // Braking, or gaining speed after a start, that was under way a second before goes on.
    assert!(of_motion(|s| (9.0 - 1.5 * s).clamp(2.0, 12.0), null()).is_empty());
    assert!(of_motion(|s| (2.0 + 1.5 * s).clamp(0.0, 9.0), null()).is_empty());
}

/// LABELING.md 2: yielding is to slow or stop to give way. An ego that stands at the keyframe has done so before; the
/// recording only makes it doubtful that this is the first action after the keyframe.
#[test]
fn who_stopped_before_the_keyframe_may_have_yielded() {
    // Steady until 0.7 s after the keyframe, then gaining 1.5 m/s2.
    let of = |speed: f64, decision: Value| of_motion(move |s| speed + 1.5 * (s - 0.7).max(0.0), decision);
    assert_eq!(of(0.1, yields()), [("label.motion.no_change", false)]);
    assert_eq!(of(5.0, yields()), [("label.motion.contradicts", true)]);
    let stops = json!({ "longitudinal": "stop_for_regulation", "lateral": null });
    assert_eq!(of(0.1, stops), [("label.motion.contradicts", true)]);
}

#[test]
fn two_linked_objects_are_two_components() {
    let twice = |a: &str, b: &str| {
        let parts = [("前方一辆车正在慢慢行驶挡住自车", a), ("前方一辆车正在慢慢行驶挡住自车", b)];
        found(&stage_one(), &label(CUT_IN, yields(), &parts), "label.component.duplicate")
    };
    assert!(twice("car", "any").is_empty());
    assert_eq!(twice("car", "car").len(), 1);
}
