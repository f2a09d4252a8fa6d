//! A hand-made recorded drive, in two versions that are equal up to the keyframe and differ in everything after it;
//! with signals and drafts that depend on *all* of the given drive, so that a missing cut is detected.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use whyroad_label::check::Recorded as CheckedDrive;
use whyroad_model::messages::{
    CocLabel, CriticalComponent, DrivingDecision, EpisodeCursor, EpisodeFilter, EpisodePage, EpisodeRecord,
    Keyframe, KeyframeType, MatchedCondition, ScenarioLabel, TimeRange,
};
use whyroad_model::road_map::{Area, Lane, Point3, StopLine};
use whyroad_model::scene::{
    ContextState, DriveMeta, Ego, EgoBus, LightColor, LightState, MediaFrame, Motion, Track, TurnSignal,
};
use whyroad_model::signal::TargetSpan;
use whyroad_model::{
    Bilingual, Column, Drive, DriveId, FrameRange, Lang, Nanos, ObjectClass, RoadMap, SignalTable,
};
use whyroad_server::domain::scene::{SignalAbout, SignalKind};
use whyroad_server::recordings::Recordings;

/// 2026-01-15T10:30:00Z.
const START: i64 = 1_768_473_000_000_000_000;
/// Frame of the keyframe: 10:30:09.400.
pub const KEYFRAME: usize = 94;
const FRAMES: usize = 200;
pub const LEAF: &str = "reactive_agent.cutin.urgent";

/// The part after the keyframe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Future {
    /// The ego brakes, a pedestrian crosses, the light turns green.
    Brakes,
    /// It drives on, nobody comes, the light turns yellow, the drive ends earlier.
    DrivesOn,
}

pub fn at(frame: usize) -> Nanos {
    Nanos(START + frame as i64 * 100_000_000)
}

/// `drive1`, `drive2`, ... are all equal.
pub fn drive(id: &DriveId, future: Future) -> Drive {
    let frames = if future == Future::Brakes { FRAMES } else { FRAMES - 20 };
    let brakes = future == Future::Brakes;
    let mut ego = Motion::unknown(frames);
    let (mut x, mut speed) = (0.0, 10.0);
    for f in 0..frames {
        let after = f > KEYFRAME;
        if after && brakes {
            speed = (speed - 0.3_f64).max(0.0);
        }
        x += speed * 0.1;
        (ego.x[f], ego.y[f], ego.z[f], ego.heading[f]) =
            (x, if after && !brakes { 0.5 } else { 0.0 }, 0.0, 0.0);
        (ego.vx[f], ego.vy[f], ego.yaw_rate[f]) = (speed, 0.0, 0.0);
        ego.accel[f] = if after && brakes { -3.0 } else { 0.0 };
    }
    let bus = EgoBus {
        steering: (0..frames).map(|f| if f > KEYFRAME && brakes { 0.3 } else { 0.01 }).collect(),
        turn_signal: (0..frames)
            .map(|f| Some(if f > KEYFRAME && brakes { TurnSignal::Left } else { TurnSignal::Off }))
            .collect(),
        ..EgoBus::default()
    };
    let ego = Ego {
        length_m: 4.8,
        width_m: 1.9,
        height_m: 1.6,
        reference_to_centre_m: 1.4,
        motion: ego,
        bus,
        ..Ego::default()
    };
    let mut tracks = vec![track("a", 0..frames, brakes), track("b", 50..90, brakes)];
    tracks.push(recognized_later(frames, brakes));
    tracks.push(measured_later(frames, brakes));
    if brakes {
        tracks.push(track("secret_pedestrian", KEYFRAME + 1..frames, brakes));
    }
    let light = |s: f64, color| LightState {
        lane_id: "lane1".into(),
        to_lane_id: None,
        time: Nanos(START).plus_secs(s),
        color,
        countdown_s: None,
    };
    let after = if brakes { LightColor::Green } else { LightColor::Yellow };
    let state = |s: f64, value: &str| ContextState {
        time: Nanos(START).plus_secs(s),
        kind: "weather".into(),
        value: value.into(),
        source: "test".into(),
        confidence: None,
    };
    Drive {
        meta: DriveMeta {
            drive_id: id.clone(),
            format: "test".into(),
            content_hash: format!("{future:?}"),
            // A camera whose first image comes late, or never.
            video: if brakes { vec!["roof".into(), "front left".into()] } else { vec!["front left".into()] },
            ..DriveMeta::default()
        },
        times: (0..frames).map(at).collect(),
        ego: Some(ego),
        tracks,
        map: Some(map()),
        lights: Some(vec![light(1.0, LightColor::Red), light(9.9, after)]),
        context: Some(vec![state(0.0, "clear"), state(10.0, if brakes { "rain" } else { "fog" })]),
        media: Some((0..frames).map(picture).collect()),
    }
}

fn picture(f: usize) -> MediaFrame {
    MediaFrame { camera: "front left".into(), time: at(f), uri: format!("front/{f}.jpg"), index: f as u32 }
}

fn track(id: &str, frames: std::ops::Range<usize>, brakes: bool) -> Track {
    let n = frames.len();
    let mut motion = Motion::unknown(n);
    for (row, f) in frames.clone().enumerate() {
        let after = f > KEYFRAME && brakes;
        motion.x[row] = 20.0 + 0.8 * f as f64 + if after { 3.0 } else { 0.0 };
        motion.y[row] = if after { 0.0 } else { 3.0 };
        (motion.heading[row], motion.vx[row], motion.vy[row]) = (0.0, 8.0, if after { -1.0 } else { 0.0 });
    }
    Track {
        id: id.into(),
        class: if id.starts_with("secret") { ObjectClass::Pedestrian } else { ObjectClass::Car },
        source_class: "car".into(),
        frames: frames.clone().map(|f| f as u32).collect(),
        motion,
        length_m: frames.map(|f| if f > KEYFRAME && brakes { 12.0 } else { 4.5 }).collect(),
        width_m: vec![1.8; n],
        height_m: vec![1.5; n],
        ..Track::default()
    }
}

/// An object that is recognized after the keyframe: as a pedestrian, or never.
fn recognized_later(frames: usize, brakes: bool) -> Track {
    let mut t = track("c", 0..frames, brakes);
    t.motion.y.iter_mut().for_each(|y| *y += 6.0);
    t.state_classes((0..frames).map(|f| {
        if f > KEYFRAME && brakes {
            (ObjectClass::Pedestrian, "person")
        } else {
            (ObjectClass::Unknown, "thing")
        }
    }));
    t
}

/// An object whose pose is measured every ten frames, and interpolated between: at the keyframe from a later one.
fn measured_later(frames: usize, brakes: bool) -> Track {
    let mut t = track("d", 0..frames, brakes);
    let of = |f: usize| f / 10 * 10..f.div_ceil(10) * 10;
    let x = |f: usize| 30.0 + 0.8 * f as f64 + if f > KEYFRAME && brakes { 9.0 } else { 0.0 };
    for f in 0..frames {
        let (a, b) = (of(f).start, of(f).end);
        let w = (f - a) as f64 / 10.0;
        t.motion.x[f] = x(a) * (1.0 - w) + x(b) * w;
        t.motion.y[f] = -3.0;
    }
    t.known_at = (0..frames).map(|f| at(of(f).end)).collect();
    t
}

fn map() -> RoadMap {
    let point = |x: f64, y: f64| Point3 { x, y, z: 0.0 };
    let line = |y: f64| (-10..40).map(|i| point(f64::from(i) * 20.0, y)).collect::<Vec<_>>();
    let square = |x: f64| vec![point(x, -5.0), point(x + 10.0, -5.0), point(x + 10.0, 5.0), point(x, -5.0)];
    RoadMap {
        lanes: vec![Lane {
            id: "lane1".into(),
            left: line(1.75),
            right: line(-1.75),
            center: line(0.0),
            ..Lane::default()
        }],
        crosswalks: vec![
            Area { id: "here".into(), boundary: square(120.0) },
            Area { id: "far_ahead".into(), boundary: square(600.0) },
        ],
        stop_lines: vec![StopLine { id: "s".into(), line: square(118.0)[..2].to_vec(), lane_ids: vec![] }],
        ..RoadMap::default()
    }
}

/// Episode `n` of `drive`; its data about the time after the keyframe depends on the future.
pub fn episode(drive: &str, n: usize, future: Future) -> EpisodeRecord {
    let end = if future == Future::Brakes { 130 } else { 112 };
    EpisodeRecord {
        episode_id: format!("{drive}_e{n}"),
        scenario_id: LEAF.parse().unwrap(),
        drive_id: drive.into(),
        clip_id: format!("{drive}_000").into(),
        target_id: Some("a".into()),
        roles: BTreeMap::new(),
        time_range: TimeRange {
            start_timestamp: at(74),
            end_timestamp: at(end),
            start_frame_idx: Some(74),
            end_frame_idx: Some(end as u32),
        },
        keyframe: Keyframe {
            timestamp: at(KEYFRAME),
            frame_idx: KEYFRAME as u32,
            kind: KeyframeType::Reactive,
            range_start: None,
            range_end: None,
        },
        second_keyframe: (future == Future::Brakes).then(|| Keyframe {
            timestamp: at(120),
            frame_idx: 120,
            kind: KeyframeType::Reactive,
            range_start: None,
            range_end: None,
        }),
        score: if future == Future::Brakes { 0.9 } else { 0.7 },
        is_primary: true,
        primary_episode_id: None,
        ego_response: None,
        margin_score: None,
        calibrated: None,
        keyframe_rule: Bilingual::new("越线", "crosses the line"),
        conditions_matched: conditions(future),
        signals: vec!["ego.mean_speed".into(), "target.gap".into()],
        rule_version: None,
    }
}

fn conditions(future: Future) -> Vec<MatchedCondition> {
    let condition = serde_json::json!({
        "condition": "least gap", "actual_value": if future == Future::Brakes { 1.0 } else { 9.0 },
    });
    vec![serde_json::from_value(condition).unwrap()]
}

/// The recordings of a test.
pub struct Recorded {
    pub future: Future,
    /// A file used for every image, with its name by frame.
    pub pictures: PathBuf,
}

impl Recordings for Recorded {
    fn drive(&self, id: &DriveId) -> Result<Arc<Drive>, Bilingual> {
        if id.as_str().starts_with("drive") {
            Ok(Arc::new(drive(id, self.future)))
        } else {
            Err(Bilingual::new("没有这个行程", "no such drive"))
        }
    }

    /// Each signal depends on all frames.
    fn signals(&self, drive: &Drive) -> SignalTable {
        let n = drive.times.len();
        let ego = &drive.ego.as_ref().unwrap().motion;
        let mean = ego.vx.iter().sum::<f64>() / n as f64;
        let number = |v: Vec<f64>| Column::Number(v);
        let a = drive.track(&"a".into()).unwrap();
        let gap = a.motion.y.iter().fold(f64::INFINITY, |g, y| g.min(*y)) + 5.0;
        let words: Arc<[String]> = ["gentle decelerate".to_owned(), "maintain speed".to_owned()].into();
        let slows = ego.accel.iter().any(|a| *a < -1.0);
        let codes = vec![u16::from(!slows); n];
        SignalTable {
            drive_id: drive.meta.drive_id.clone(),
            times: drive.times.clone(),
            frame_columns: [
                ("ego.mean_speed".to_owned(), number(vec![mean; n])),
                ("ego.forward_speed".to_owned(), number(ego.vx.clone())),
                ("ego.accel".to_owned(), number(ego.accel.clone())),
                ("ego.meta_longitudinal".to_owned(), Column::Category { codes, names: words }),
            ]
            .into(),
            targets: vec![TargetSpan {
                id: "a".into(),
                class: ObjectClass::Car,
                first_row: 0,
                frames: FrameRange::new(0, n),
            }],
            target_columns: [("target.gap".to_owned(), number(vec![gap; n]))].into(),
            unavailable: BTreeMap::new(),
            partial: BTreeMap::new(),
            without_boxes: BTreeSet::new(),
            pairs: None,
        }
    }

    fn about(&self, name: &str) -> Option<SignalAbout> {
        let unit = match name {
            "ego.mean_speed" => "m/s",
            "target.gap" => "m",
            _ => return None,
        };
        let title = Bilingual::new("信号", "a signal");
        let meaning = title.clone();
        Some(SignalAbout { kind: SignalKind::Number, unit: Some(unit.to_owned()), title, meaning })
    }

    fn draft(
        &self,
        drive: &Drive,
        signals: &SignalTable,
        e: &EpisodeRecord,
        _: Lang,
        _: Option<&[CriticalComponent]>,
    ) -> CocLabel {
        let gap = signals.target_columns["target.gap"].number(0).unwrap();
        let seen = e.conditions_matched.len();
        CocLabel {
            version: Some("2.1.0".into()),
            clip_id: e.clip_id.to_string(),
            scenario: ScenarioLabel {
                l1: e.scenario_id.l1.clone(),
                l2: e.scenario_id.l2.clone().unwrap_or_default(),
                l3: e.scenario_id.l3.clone(),
                full_id: Some(e.scenario_id.to_string()),
            },
            time_range: e.time_range.clone(),
            keyframe: e.keyframe.clone(),
            driving_decision: DrivingDecision { longitudinal: None, lateral: None, lateral_direction: None },
            critical_components: vec![CriticalComponent {
                category: Some("critical_objects".into()),
                description: format!(
                    "a car, least gap {gap} m in {} frames, {seen} conditions",
                    drive.times.len()
                ),
                uncertainty: None,
                id: Some("c1".into()),
                evidence_times: vec![e.keyframe.timestamp],
                linked_objects: vec!["a".into()],
            }],
            coc_trace: format!(
                "[DRAFT] it then goes {} m",
                drive.ego.as_ref().unwrap().motion.x.last().unwrap()
            ),
            records: BTreeMap::new(),
            causes: None,
            second_keyframe: e.second_keyframe.clone(),
            secondary_scenarios: vec![],
            safety_filter: None,
            provenance: None,
        }
    }

    fn mined(&self) -> Vec<String> {
        vec!["week1".into()]
    }

    fn episode_count(&self, name: &str, filter: &EpisodeFilter) -> Option<Result<u64, Bilingual>> {
        self.episodes(name, filter, None, usize::MAX).map(|page| Ok(page?.episodes.len() as u64))
    }

    fn episodes(
        &self,
        name: &str,
        filter: &EpisodeFilter,
        after: Option<EpisodeCursor>,
        limit: usize,
    ) -> Option<Result<EpisodePage, Bilingual>> {
        let mut all = [episode("drive1", 1, self.future), episode("drive2", 1, self.future)];
        // Of the first moment of this folder no class is known.
        if name == "unexplained" {
            all[0].scenario_id = "other".parse().unwrap();
        }
        let from = after.map_or(0, |c| c.0 as usize);
        let mut wanted = (0..).zip(all).skip(from).filter(|(_, e)| filter.accepts(e));
        let episodes = wanted.by_ref().take(limit).map(|(_, e)| e).collect();
        let next = wanted.next().map(|(row, _)| EpisodeCursor(row));
        ["week1", "unexplained"].contains(&name).then_some(Ok(EpisodePage { episodes, next }))
    }

    /// The similarity of the other drive's episode is 0.5.
    fn similar(
        &self,
        name: &str,
        episode: &EpisodeRecord,
        _: usize,
    ) -> Option<Result<whyroad_server::recordings::Similar, Bilingual>> {
        let all = self.episodes(name, &EpisodeFilter::default(), None, 10)?.ok()?.episodes;
        let others = all.into_iter().filter(|e| e.episode_id != episode.episode_id);
        let nearest: Vec<_> = others.map(|e| (e, 0.5)).collect();
        let compared = nearest.len() as u64;
        Some(Ok(whyroad_server::recordings::Similar { nearest, compared }))
    }

    fn media(&self, _: &DriveId, frame: &MediaFrame) -> Option<PathBuf> {
        let file = self.pictures.join(frame.uri.replace('/', "_"));
        std::fs::write(&file, format!("picture of frame {}", frame.index)).ok()?;
        Some(file)
    }
}

/// These drives, with a hook before each derivation of signals, and the clips whose recording the checker asked for.
pub struct Watched {
    pub drives: Recorded,
    pub before_signals: fn(),
    pub clips: Arc<Mutex<Vec<String>>>,
}

impl Recordings for Watched {
    fn drive(&self, id: &DriveId) -> Result<Arc<Drive>, Bilingual> {
        self.drives.drive(id)
    }
    fn signals(&self, drive: &Drive) -> SignalTable {
        (self.before_signals)();
        self.drives.signals(drive)
    }
    fn about(&self, name: &str) -> Option<SignalAbout> {
        self.drives.about(name)
    }
    fn draft(
        &self,
        drive: &Drive,
        signals: &SignalTable,
        episode: &EpisodeRecord,
        lang: Lang,
        listed: Option<&[CriticalComponent]>,
    ) -> CocLabel {
        self.drives.draft(drive, signals, episode, lang, listed)
    }
    fn recorded(&self, clip_id: &str) -> Option<Arc<CheckedDrive>> {
        self.clips.lock().unwrap().push(clip_id.to_owned());
        None
    }
    fn mined(&self) -> Vec<String> {
        self.drives.mined()
    }
    fn episode_count(&self, name: &str, filter: &EpisodeFilter) -> Option<Result<u64, Bilingual>> {
        self.drives.episode_count(name, filter)
    }
    fn episodes(
        &self,
        name: &str,
        filter: &EpisodeFilter,
        after: Option<EpisodeCursor>,
        limit: usize,
    ) -> Option<Result<EpisodePage, Bilingual>> {
        self.drives.episodes(name, filter, after, limit)
    }
    fn media(&self, drive: &DriveId, frame: &MediaFrame) -> Option<PathBuf> {
        self.drives.media(drive, frame)
    }
}

/// Reports the number of tasks that it was given: the content of the page is the caller's.
pub struct Counted;

impl whyroad_server::reports::Reports for Counted {
    fn analytics(
        &self,
        project: &whyroad_server::domain::project::Project,
        tasks: &[whyroad_label::facts::TaskFacts],
        _: Nanos,
        utc_offset_h: i8,
    ) -> Result<String, Bilingual> {
        match project.name.as_str() {
            "broken" => Err(Bilingual::new("没有挖掘结果", "no mined folder")),
            name => Ok(format!("<p>{name} {} {utc_offset_h}</p>", tasks.len())),
        }
    }
}
