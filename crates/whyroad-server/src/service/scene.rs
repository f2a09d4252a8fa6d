//! The part of a drive that is shown with a task. In Stage I everything is computed from the drive *cut at the
//! keyframe*: data that is not in the cut drive cannot be in the result, whatever the code below does. In Stage II
//! everything is computed from the whole drive, as the rules read it: a curve has one origin from its start to its end.

pub mod cache;
mod columns;
mod history;
mod map;
mod shown;

pub use map::map;

use cache::SceneKey;
use shown::{Shown, shown, shown_in};

use crate::app::App;
use crate::domain::scene::{CameraFrame, CameraView, EgoView, LightView, MetaView, SceneView};
use crate::domain::workflow::Stage;
use crate::problem::{Answer, Problem};
use crate::recordings::CameraImage;
use crate::service::tasks::TaskRow;
use columns::{number, tracks, word};
use history::Ends;
use std::collections::BTreeMap;
use std::sync::Arc;
use whyroad_model::scene::{FRAME_RATE_HZ, MediaFrame, TurnSignal};
use whyroad_model::{ClipId, Column, Drive, FrameRange, Nanos, SignalTable};

/// Signals that the plots show in addition to those of the rule.
const PLOTTED: [&str; 2] = ["ego.lane_offset", "ego.jerk"];

/// The scene of a task.
pub fn scene(app: &App, t: &TaskRow) -> Answer<Arc<SceneView>> {
    let stage = t.at.state.stage();
    let drive_version = app.recordings.version(&t.drive_id.as_str().into());
    let key = SceneKey { task: t.id.clone(), stage, hides_leaf: t.hides_leaf(), drive_version };
    if let Some(scene) = app.scenes.get(&key) {
        return Ok(scene);
    }
    let mut view = derived(app, t, stage)?;
    if stage == Stage::Stage1 {
        history::withhold_uncertain(&mut view);
    }
    for (name, values) in &mut view.signals {
        if view.about.get(name).is_some_and(|a| a.unit.as_deref() == Some("rad")) {
            columns::unwrap(values);
        }
    }
    let view = Arc::new(view);
    app.scenes.put(key, &view);
    Ok(view)
}

/// The scene as derived from the part of the drive that `stage` shows.
fn derived(app: &App, t: &TaskRow, stage: Stage) -> Answer<SceneView> {
    let Shown { drive, frames } = shown_in(app, t, stage)?;
    let signals = app.recordings.signals(&drive);
    let measured = measured(&drive, frames);
    let ends = Ends { start: frames.start == 0, end: frames.end == drive.frame_count() };
    let drive = app.recordings.estimated(&drive);
    let described = |view: SceneView| {
        let about = |name: &String| Some((name.clone(), app.recordings.about(name)?));
        let about = view.signals.keys().filter_map(about).collect();
        let mut view = SceneView { about, ..view };
        history::mark_uncertain(&mut view, ends, &measured);
        view
    };
    if !t.hides_leaf() {
        return Ok(described(view(t, stage, &drive, frames, &signals)));
    }
    // The signals and the target of the rule reveal its L3 class.
    let mut bare = t.clone();
    bare.episode.signals.clear();
    bare.episode.target_id = None;
    Ok(described(view(&bare, stage, &drive, frames, &signals)))
}

/// Rates of change of the ego that the log has: they are not computed from other values.
fn measured(drive: &Drive, frames: FrameRange) -> Vec<&'static str> {
    let Some((ego, last)) = drive.ego.as_ref().zip(frames.end.checked_sub(1)) else { return vec![] };
    let m = &ego.motion;
    let rates = [
        ("ego.accel", &m.accel),
        ("ego.yaw_rate", &m.yaw_rate),
        ("ego.forward_speed", &m.vx),
        ("ego.speed", &m.vx),
    ];
    let is_measured = |values: &[f64]| values.get(last).is_some_and(|v| v.is_finite());
    rates.into_iter().filter(|(_, values)| is_measured(values)).map(|(name, _)| name).collect()
}

fn view(t: &TaskRow, stage: Stage, drive: &Drive, frames: FrameRange, signals: &SignalTable) -> SceneView {
    let keyframe = Nanos(t.keyframe_ns);
    let times = &drive.times[frames.start..frames.end];
    let clip = ClipId(t.clip_id.clone()).frames(&drive.meta.drive_id, &drive.times).map_or(0, |c| c.start);
    SceneView {
        stage,
        frame_rate: FRAME_RATE_HZ,
        times: times.iter().map(ToString::to_string).collect(),
        t_s: times.iter().map(|at| columns::rounded(at.seconds_since(keyframe))).collect(),
        clip_frames: (frames.start..frames.end).map(|f| f as i64 - clip as i64).collect(),
        keyframe_index: times.partition_point(|at| *at <= keyframe).saturating_sub(1),
        ego: ego(drive, frames, signals),
        tracks: tracks(drive, frames),
        lights: lights(drive, times),
        meta: MetaView {
            longitudinal: words(signals.frame_columns.get("ego.meta_longitudinal"), frames),
            lateral: words(signals.frame_columns.get("ego.meta_lateral"), frames),
        },
        cameras: cameras(t, stage, drive, times),
        signals: columns::signals(t, &PLOTTED, signals, frames),
        deviations: columns::deviations(t, &PLOTTED, signals, frames),
        uncertain: BTreeMap::new(),
        about: BTreeMap::new(),
        hidden_until: (stage == Stage::Stage1).then(|| "stage2".to_owned()),
    }
}

/// The corner of the square of side `size`, m, that contains the ego at the keyframe.
pub fn corner(app: &App, t: &TaskRow, size: f64) -> Answer<[f64; 2]> {
    let Shown { drive, .. } = shown(app, t)?;
    let frame = drive.times.partition_point(|at| at.0 <= t.keyframe_ns).saturating_sub(1);
    let at = |values: &[f64]| values.get(frame).copied().filter(|v| v.is_finite());
    let ego = drive.ego.as_ref().and_then(|e| Some([at(&e.motion.x)?, at(&e.motion.y)?]));
    // Without an ego, the position of any object.
    let any = || drive.tracks.iter().find_map(|t| Some([*t.motion.x.first()?, *t.motion.y.first()?]));
    let [x, y] = ego.or_else(any).unwrap_or_default();
    Ok([(x / size).floor() * size, (y / size).floor() * size])
}

fn words(column: Option<&Column>, frames: FrameRange) -> Vec<Option<String>> {
    (frames.start..frames.end).map(|f| column.and_then(|c| c.category(f)).map(str::to_owned)).collect()
}

fn ego(drive: &Drive, frames: FrameRange, signals: &SignalTable) -> Option<EgoView> {
    let ego = drive.ego.as_ref()?;
    let m = &ego.motion;
    let column =
        |values: &[f64]| (frames.start..frames.end).map(|f| number(values.get(f).copied())).collect();
    let from_signal = |name: &str| {
        let column = signals.frame_columns.get(name);
        (frames.start..frames.end).map(|f| number(column.and_then(|c| c.number(f)))).collect()
    };
    Some(EgoView {
        size: [ego.length_m, ego.width_m],
        x: column(&m.x),
        y: column(&m.y),
        heading: column(&m.heading),
        speed: from_signal("ego.forward_speed"),
        accel: from_signal("ego.accel"),
        yaw_rate: from_signal("ego.yaw_rate"),
        steering: column(&ego.bus.steering),
        turn_signal: (frames.start..frames.end)
            .map(|f| ego.bus.turn_signal.get(f).copied().flatten().map(indicator))
            .collect(),
    })
}

fn indicator(state: TurnSignal) -> String {
    word(&state)
}

/// States from the last one before the shown frames on, by lane, then time.
fn lights(drive: &Drive, times: &[Nanos]) -> Vec<LightView> {
    let (Some(states), Some(first), Some(last)) = (&drive.lights, times.first(), times.last()) else {
        return vec![];
    };
    let mut out: Vec<LightView> = Vec::new();
    for state in states.iter().filter(|s| s.time <= *last) {
        let view = LightView {
            lane_id: state.lane_id.clone(),
            to_lane_id: state.to_lane_id.clone(),
            t_index: times.partition_point(|at| *at < state.time),
            colour: word(&state.color),
        };
        // Of the states before the first frame only the newest applies.
        let older = out.last().is_some_and(|o| {
            o.t_index == 0
                && view.t_index == 0
                && state.time <= *first
                && (&o.lane_id, &o.to_lane_id) == (&view.lane_id, &view.to_lane_id)
        });
        if older {
            out.pop();
        }
        let same = out.last().is_some_and(|o| {
            (&o.lane_id, &o.to_lane_id, &o.colour) == (&view.lane_id, &view.to_lane_id, &view.colour)
        });
        if !same {
            out.push(view);
        }
    }
    out
}

/// Images in the shown time range, by camera.
fn images<'d>(drive: &'d Drive, times: &[Nanos]) -> Vec<(&'d str, Vec<&'d MediaFrame>)> {
    let (Some(media), Some(first), Some(last)) = (&drive.media, times.first(), times.last()) else {
        return vec![];
    };
    let mut out: Vec<(&str, Vec<&MediaFrame>)> = Vec::new();
    for frame in media.iter().filter(|m| m.time >= *first && m.time <= *last) {
        match out.last_mut().filter(|(camera, _)| *camera == frame.camera) {
            Some((_, frames)) => frames.push(frame),
            None => out.push((&frame.camera, vec![frame])),
        }
    }
    out
}

/// Cameras in the order of the drive. A camera without an image here is listed only when nothing is withheld: the
/// absence of its images may depend on later times.
fn cameras(t: &TaskRow, stage: Stage, drive: &Drive, times: &[Nanos]) -> Vec<CameraView> {
    let keyframe = Nanos(t.keyframe_ns);
    let camera = |(camera, frames): (&str, Vec<&MediaFrame>)| CameraView {
        camera: camera.to_owned(),
        frames: frames
            .iter()
            .enumerate()
            .map(|(index, frame)| CameraFrame {
                index,
                t_index: times.partition_point(|at| *at <= frame.time).saturating_sub(1),
                t_s: columns::rounded(frame.time.seconds_since(keyframe)),
                url: format!("/api/v1/tasks/{}/media/{}/{index}", t.id, crate::url::encoded(camera)),
            })
            .collect(),
    };
    let mut out: Vec<CameraView> = images(drive, times).into_iter().map(camera).collect();
    let named = &drive.meta.video;
    if stage == Stage::Stage2 {
        let without: Vec<&String> = named.iter().filter(|n| out.iter().all(|c| c.camera != **n)).collect();
        out.extend(without.into_iter().map(|n| CameraView { camera: n.clone(), frames: vec![] }));
    }
    out.sort_by_key(|c| named.iter().position(|n| *n == c.camera).unwrap_or(named.len()));
    out
}

/// Location of image `index` of `camera`, counted among the images that may be shown. No other image can be requested.
pub fn image(app: &App, t: &TaskRow, camera: &str, index: usize) -> Answer<CameraImage> {
    let Shown { drive, frames } = shown(app, t)?;
    let all = images(&drive, &drive.times[frames.start..frames.end]);
    let found =
        all.iter().find(|(name, _)| *name == camera).and_then(|(_, frames)| frames.get(index).copied());
    let frame = found.ok_or_else(Problem::missing)?;
    let id = &drive.meta.drive_id;
    if let Some(file) = app.recordings.media(id, frame) {
        return Ok(CameraImage::File(file));
    }
    let stored = app.recordings.stored_image(id, frame);
    let stored = stored.map_err(|why| Problem::new(502, "media.storage", why.zh, why.en))?;
    stored.map(CameraImage::Stored).ok_or_else(Problem::missing)
}
