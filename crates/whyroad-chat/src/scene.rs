//! A scene as input for a model: a JSON record and images. [`Scene::before`] is made from the drive *cut at the
//! keyframe* and contains nothing later; [`Scene::after`] is the 6 s that follow.
//!
//! Object names from a log are data: they are shortened, quoted as JSON, and never used in prompts' text; answers name
//! objects by the ids assigned here (`o1`, `o2`, ...).

use crate::{ImageKind, Part};
use serde_json::{Map, Value, json};
use whyroad_model::names::class_name;
use whyroad_model::scene::MediaFrame;
use whyroad_model::time::frame_at;
use whyroad_model::{Drive, Lang, Nanos, SignalTable, TrackId};
use whyroad_render::raster::{Raster, birds_eye};

/// Time between two images, s: 2 Hz (LABELING.md 6).
const IMAGE_EVERY_S: f64 = 0.5;
/// Shown history and future, s.
const HISTORY_S: f64 = 2.0;
const FUTURE_S: f64 = 6.0;
/// Maximum number of listed objects, nearest first.
const OBJECTS: usize = 12;
/// Farther objects are not listed, m.
const REACH_M: f64 = 100.0;
/// Longest name of a log that is shown, characters.
const NAME: usize = 40;
/// Maximum age of a camera image at its moment, s.
const CAMERA_LAG_S: f64 = 0.3;
/// Bird's-eye images: 96 m by 96 m.
const RASTER: Raster = Raster { size_px: 384, m_per_px: 0.25 };

/// Camera images by their entry in the lake.
pub trait Images: Sync {
    /// The image's bytes; `None` where it is not available.
    fn image(&self, drive: &Drive, frame: &MediaFrame) -> Option<(ImageKind, Vec<u8>)>;
}

/// Bird's-eye images only.
pub struct NoCamera;

impl Images for NoCamera {
    fn image(&self, _: &Drive, _: &MediaFrame) -> Option<(ImageKind, Vec<u8>)> {
        None
    }
}

/// What is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The record.
    pub json: Value,
    /// Images in the order of time.
    pub images: Vec<Part>,
    /// Objects by the ids of the record.
    pub objects: Vec<(String, TrackId)>,
}

impl Scene {
    /// The scene at the last frame of `cut`, a drive cut at the keyframe, and the 2 s before it. `None` where the ego's
    /// pose is unknown then.
    pub fn before(cut: &Drive, images: &dyn Images, lang: Lang) -> Option<Self> {
        let keyframe = cut.times.len().checked_sub(1)?;
        let seen = whyroad_signals::estimate(cut);
        let (ego, objects) = record(&seen, keyframe, lang)?;
        let signals = whyroad_signals::derive(cut);
        let mut json = Map::new();
        json.insert("ego".into(), ego);
        json.insert("objects".into(), objects.iter().map(|(json, _)| json.clone()).collect());
        json.extend(surroundings(&signals, keyframe));
        let at = cut.times[keyframe];
        let steps = (HISTORY_S / IMAGE_EVERY_S) as i32;
        let moments = (-steps..=0).map(|i| at.plus_secs(f64::from(i) * IMAGE_EVERY_S));
        let objects = objects.into_iter().enumerate().map(|(i, (_, id))| (alias(i), id)).collect();
        Some(Self { json: Value::Object(json), images: views(cut, images, moments), objects })
    }

    /// The motion of the ego after frame `keyframe` of the whole drive, and the images of that time.
    pub fn after(drive: &Drive, signals: &SignalTable, keyframe: usize, images: &dyn Images) -> Self {
        let Some(at) = drive.times.get(keyframe).copied() else {
            return Self { json: json!({}), images: Vec::new(), objects: Vec::new() };
        };
        let steps = (FUTURE_S / IMAGE_EVERY_S) as i32;
        let moments = (0..=steps).map(|i| at.plus_secs(f64::from(i) * IMAGE_EVERY_S));
        let last = *drive.times.last().unwrap_or(&at);
        let images = views(drive, images, moments.filter(|t| *t <= last));
        Self { json: motion(signals, keyframe), images, objects: Vec::new() }
    }
}

/// Id of an object in the record.
fn alias(index: usize) -> String {
    format!("o{}", index + 1)
}

/// The ego and the nearest objects, in the ego's frame.
fn record(drive: &Drive, frame: usize, lang: Lang) -> Option<(Value, Vec<(Value, TrackId)>)> {
    let ego = &drive.ego.as_ref()?.motion;
    let at = |v: &[f64], i: usize| v.get(i).copied().filter(|v| v.is_finite());
    let (x, y, heading) = (at(&ego.x, frame)?, at(&ego.y, frame)?, at(&ego.heading, frame)?);
    let speed = |i: usize| Some(rounded(at(&ego.vx, i)?.hypot(at(&ego.vy, i)?)));
    let (sin, cos) = heading.sin_cos();
    let seconds = [2.0, 1.0, 0.0];
    let frames = seconds.map(|s| frame_at(&drive.times, drive.times[frame].plus_secs(-s)));
    let mut found: Vec<(f64, Value, TrackId)> = Vec::new();
    for track in &drive.tracks {
        let Some(row) = track.row_at(frame) else { continue };
        let place = |row: usize| {
            let (dx, dy) = (at(&track.motion.x, row)? - x, at(&track.motion.y, row)? - y);
            Some((dx * cos + dy * sin, -dx * sin + dy * cos))
        };
        let Some((ahead, left)) = place(row) else { continue };
        let distance = ahead.hypot(left);
        if distance > REACH_M {
            continue;
        }
        let history: Vec<Value> = frames
            .iter()
            .zip(seconds)
            .filter_map(|(f, s)| Some((place(track.row_at(*f)?)?, s)))
            .map(|((ahead, left), s)| json!({ "s": -s, "ahead_m": rounded(ahead), "left_m": rounded(left) }))
            .collect();
        let own = Some((at(&track.motion.vx, row), at(&track.motion.vy, row)));
        let speed = own.and_then(|(vx, vy)| Some(rounded(vx?.hypot(vy?))));
        let json = json!({
            "class": class_name(track.class).get(lang),
            "ahead_m": rounded(ahead),
            "left_m": rounded(left),
            "speed_mps": speed,
            "from_now_frame": history,
            "name_in_log": track.id.as_str().chars().take(NAME).collect::<String>(),
        });
        found.push((distance, json, track.id.clone()));
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.2.cmp(&b.2)));
    found.truncate(OBJECTS);
    let objects = found.into_iter().enumerate().map(|(i, (_, mut json, id))| {
        json["id"] = alias(i).into();
        (json, id)
    });
    let speeds: Vec<Value> =
        frames.iter().zip(seconds).map(|(f, s)| json!({ "s": -s, "speed_mps": speed(*f) })).collect();
    let ego = json!({ "speed_mps": speed(frame), "history": speeds });
    Some((ego, objects.collect()))
}

/// Light and road at a frame, as far as they are known.
fn surroundings(signals: &SignalTable, frame: usize) -> Map<String, Value> {
    let mut out = Map::new();
    let column = |name: &str| signals.frame_columns.get(name);
    for name in ["light.state", "map.speed_limit", "map.distance_to_junction", "ego.turn_signal"] {
        let Some(c) = column(name).filter(|c| c.is_known(frame)) else { continue };
        let value = c.category(frame).map(Value::from).or_else(|| c.number(frame).map(|v| rounded(v).into()));
        out.extend(value.map(|v| (name.to_owned(), v)));
    }
    out
}

/// What the ego does in the 6 s after a frame: runs of meta actions, speeds, route and lane changes.
fn motion(signals: &SignalTable, keyframe: usize) -> Value {
    let times = &signals.times;
    let Some(start) = times.get(keyframe).copied() else { return json!({}) };
    let end = frame_at(times, start.plus_secs(FUTURE_S)).min(times.len().saturating_sub(1));
    let seconds = |f: usize| times.get(f).map(|t| rounded(t.seconds_since(start)));
    let runs = |name: &str| -> Vec<Value> {
        let Some(column) = signals.frame_columns.get(name) else { return Vec::new() };
        let mut out: Vec<(usize, usize, &str)> = Vec::new();
        for f in keyframe..=end {
            let Some(word) = column.category(f) else { continue };
            match out.last_mut() {
                Some((_, to, last)) if *last == word && *to + 1 == f => *to = f,
                _ => out.push((f, f, word)),
            }
        }
        out.into_iter()
            .map(|(from, to, word)| json!({ "from_s": seconds(from), "to_s": seconds(to), "action": word }))
            .collect()
    };
    let speed = signals.frame_columns.get("ego.speed");
    let speeds: Vec<Value> = (0..=(FUTURE_S as i32))
        .filter_map(|s| {
            let at = start.plus_secs(f64::from(s));
            let f = frame_at(times, at);
            let near = times.get(f).is_some_and(|t| t.seconds_since(at).abs() < IMAGE_EVERY_S);
            near.then(|| json!({ "s": s, "speed_mps": speed.and_then(|c| c.number(f)).map(rounded) }))
        })
        .collect();
    json!({
        "speed": speeds,
        "longitudinal": runs("ego.meta_longitudinal"),
        "lateral": runs("ego.meta_lateral"),
        "route": runs("ego.movement"),
        "lane_change": runs("ego.lane_change"),
    })
}

/// Images at these moments: of the front camera where it has one, else from above.
fn views(drive: &Drive, images: &dyn Images, moments: impl Iterator<Item = Nanos>) -> Vec<Part> {
    let camera = front_camera(drive);
    let mut out = Vec::new();
    for moment in moments.filter(|t| drive.times.first().is_some_and(|first| t >= first)) {
        let shot = camera.and_then(|camera| {
            let all = drive.media.as_deref().unwrap_or_default().iter().filter(|m| m.camera == camera);
            let last = all.filter(|m| m.time <= moment).max_by_key(|m| m.time)?;
            (moment.seconds_since(last.time) <= CAMERA_LAG_S).then(|| images.image(drive, last)).flatten()
        });
        let from_above = || {
            let frame = frame_at(&drive.times, moment).min(drive.times.len().saturating_sub(1));
            birds_eye(drive, frame, &RASTER).map(|png| (ImageKind::Png, png))
        };
        if let Some((kind, bytes)) = shot.or_else(from_above) {
            out.push(Part::Image { kind, bytes });
        }
    }
    out
}

/// The camera that looks ahead; the first by name where no name shows it.
fn front_camera(drive: &Drive) -> Option<&str> {
    let names: std::collections::BTreeSet<&str> =
        drive.media.as_deref()?.iter().map(|m| m.camera.as_str()).collect();
    let is_front = |n: &&str| {
        let n = n.to_lowercase();
        (n.contains("front") || n.contains('前')) && !n.contains("left") && !n.contains("right")
    };
    names.iter().copied().find(|n| is_front(n)).or_else(|| names.first().copied())
}

/// One decimal: finer than the accuracy of an estimate.
fn rounded(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}
