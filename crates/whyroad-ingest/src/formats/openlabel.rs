//! ASAM OpenLABEL 1.0 (JSON): boxes of objects in frames, in coordinate systems with poses.
//!
//! Boxes (`cuboid`) are brought to the world: a coordinate system of type `scene_cs` or `geo_cs`, reached over the
//! poses and transforms that the file states. The ego is the system of type `local_cs`; without transforms from it to
//! the world positions stay relative to it. Not read: boxes in images, other geometry, actions, events, relations,
//! attributes.

mod findings;
mod systems;

use crate::adapter::{Adapter, DriveSink, FilesInMemory, FormatAbout, Located, SkipReason, Source, whole};
use crate::assemble::class_names::class_of;
use crate::assemble::frames::{Frames, Sample, Sampled};
use crate::assemble::se3::{self, Se3};
use crate::encodings::input::Input;
use crate::options::{LICENCE, Options, START};
use crate::report::{RowCount, SourceReport};
use crate::source::{
    ContentHash, drive_id, file_label, find_files, implausible_span, impossible_speeds, resampled,
};
use serde_json::Value;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;
use systems::{Systems, numbers, quaternion};
use whyroad_model::scene::{DriveMeta, Ego, FrameOfReference, Track};
use whyroad_model::{Bilingual, Drive, Nanos, Need};

/// Raised when the adapter makes something else of the same files, so that drives in a lake are replaced.
const REVISION: u32 = 3;
/// Bytes in which a file says what it is.
const SNIFFED_BYTES: u64 = 4096;
/// Maximum size of a file, bytes.
const MAX_FILE_BYTES: u64 = 1 << 30;
/// Samples are joined over gaps up to this, s: labels come at 2 to 10 Hz.
const MAX_GAP_S: f64 = 0.6;

/// OpenLABEL documents.
pub struct OpenLabel;

impl Adapter for OpenLabel {
    fn about(&self) -> &'static FormatAbout {
        const {
            &FormatAbout {
                name: "openlabel",
                summary: "ASAM OpenLABEL 1.0: boxes of objects in frames (JSON)",
                example: "openlabel path/to/labels --map town.xodr --lake lake",
                options: &[START, LICENCE],
                codes: findings::CODES,
            }
        }
    }

    fn find(&self, path: &Path) -> Vec<Located> {
        whole(find_files(path, |file| file.extension().is_some_and(|e| e == "json") && is_openlabel(file)))
    }

    fn why_skipped(&self, file: &Path) -> Option<SkipReason> {
        let name = file_label(file).to_lowercase();
        (name.ends_with(".json.gz") && name.contains("openlabel"))
            .then(|| Bilingual::new("压缩的 OpenLABEL：请先解压", "OpenLABEL, compressed: unpack it first"))
    }

    fn read_files(&self, files: &FilesInMemory, options: &Options, drives: &mut DriveSink<'_>) {
        for (name, bytes) in files {
            let mut report = SourceReport::new(name.clone());
            let text = String::from_utf8_lossy(bytes).into_owned();
            let drive = of_text(Ok(text), Path::new(name), options, &mut report);
            drives.put((drive, report));
        }
    }

    fn read(&self, source: &Source, options: &Options, drives: &mut DriveSink<'_>) {
        drives.put(read(&source.path, options));
    }
}

/// True for a file that begins as an OpenLABEL document.
fn is_openlabel(path: &Path) -> bool {
    let mut bytes = Vec::new();
    let read = File::open(path).and_then(|f| f.take(SNIFFED_BYTES).read_to_end(&mut bytes));
    read.is_ok() && String::from_utf8_lossy(&bytes).contains("\"openlabel\"")
}

/// Reads one document. `None` when there is nothing that could be kept; the report says why.
pub fn read(path: &Path, options: &Options) -> (Option<Drive>, SourceReport) {
    let mut report = SourceReport::new(path.display().to_string());
    let drive = of_text(text_of(path), path, options, &mut report);
    (drive, report)
}

fn text_of(path: &Path) -> Result<String, String> {
    let size = fs::metadata(path).map_err(|e| e.to_string())?.len();
    if size > MAX_FILE_BYTES {
        return Err(format!("it has {size} bytes"));
    }
    Input::from(path).text().map(Cow::into_owned).map_err(|e| e.to_string())
}

/// The drive of a document's text, whose name is that of its file.
fn of_text(
    text: Result<String, String>,
    path: &Path,
    options: &Options,
    report: &mut SourceReport,
) -> Option<Drive> {
    let label = path.display().to_string();
    let mut hash = ContentHash::new("openlabel", REVISION);
    options.hash_start(&mut hash);
    let parsed = text.and_then(|text| {
        hash.add("document", text.as_bytes());
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        serde_json::from_str::<Value>(text).map_err(|e| e.to_string())
    });
    let document = match parsed
        .and_then(|v| v.get("openlabel").cloned().ok_or_else(|| "it has no 'openlabel'".into()))
    {
        Ok(document) => document,
        Err(reason) => {
            report.diagnostics.push(findings::unreadable(&label, &reason));
            return None;
        }
    };
    let systems = Systems::of(&document);
    let steps = steps(&document);
    let Some((origin, dated)) = origin(&steps, options) else {
        report.diagnostics.push(findings::no_time(&label, steps.len(), not_understood(&steps)));
        return None;
    };
    let untimed = steps.iter().filter(|s| s.time.is_none()).count();
    if untimed > 0 {
        report.diagnostics.push(findings::untimed(&label, untimed, not_understood(&steps)));
    }
    let mut timed: Vec<(f64, &Value)> = steps.iter().filter_map(|s| Some((s.time?, s.frame))).collect();
    timed.sort_by(|a, b| a.0.total_cmp(&b.0));
    let first = timed[0].0;
    timed.iter_mut().for_each(|(t, _)| *t -= first);
    let mut times: Vec<f64> = timed.iter().map(|(t, _)| *t).collect();
    // Boxes of a second frame at a time are counted as duplicates.
    times.dedup();
    if let Some(d) = implausible_span(&label, 0.0, times[times.len() - 1], times.len()) {
        report.diagnostics.push(d);
        return None;
    }
    let frames = Frames::of(&times);
    if frames.resampled() {
        report.diagnostics.push(resampled(&label, frames.native_step_s));
    }
    let gap = MAX_GAP_S.max(1.5 * frames.native_step_s);
    let ego = ego(&timed, &systems, &frames.seconds, gap);
    // Without the ego's poses, positions relative to it are all there is.
    let target =
        if ego.is_some() || systems.world.is_some() { systems.world.clone() } else { systems.ego.clone() };
    let Some(target) = target else {
        report.diagnostics.push(findings::no_system(&label));
        return None;
    };
    let read = |target: &str| {
        let mut rows = Rows { count: RowCount::new("objects"), ..Rows::default() };
        timed.iter().for_each(|(time, frame)| rows.add(*time, frame, &document, &systems, target));
        rows.set_aside_static(&document);
        rows
    };
    let mut rows = read(&target);
    let mut moving = ego.is_none() && systems.world.is_none();
    // A world that no frame leads to is named only: positions stay relative to the car.
    if let (None, true, Some(own)) = (&ego, rows.objects.is_empty(), &systems.ego) {
        let of_car = read(own);
        if !of_car.objects.is_empty() {
            (rows, moving) = (of_car, true);
        }
    }
    let tracks = rows.tracks(&frames.seconds, gap, &label, report);
    let missing = Need::absent([
        (true, Need::EgoSize),
        (ego.is_none(), Need::EgoPose),
        (true, Need::Map),
        (true, Need::TrafficLights),
        (true, Need::VehicleBus),
        (true, Need::WeatherAndSurface),
        (true, Need::CameraPictures),
        (!dated, Need::Date),
    ]);
    let name = file_label(path);
    Some(Drive {
        meta: DriveMeta {
            drive_id: options.drive_id.clone().unwrap_or_else(|| drive_id(name.trim_end_matches(".json"))),
            format: "openlabel".into(),
            source: "openlabel".into(),
            licence: options.licence(),
            frame_of_reference: if moving { FrameOfReference::Ego } else { FrameOfReference::World },
            content_hash: hash.finish(),
            missing,
            ..DriveMeta::default()
        },
        times: frames.seconds.iter().map(|&s| origin.plus_secs(s)).collect(),
        ego,
        tracks,
        ..Drive::default()
    })
}

/// A frame of the document with its time, s.
struct Step<'d> {
    time: Option<f64>,
    /// What the frame states as its time.
    stated: Option<&'d Value>,
    frame: &'d Value,
}

/// Frames with their times, as seconds on the document's clock.
fn steps(document: &Value) -> Vec<Step<'_>> {
    let frames = document.get("frames").and_then(Value::as_object);
    let step = |frame| {
        let stated = stated_times(frame);
        Step { time: stated.iter().find_map(|v| seconds(v)), stated: stated.first().copied(), frame }
    };
    frames.into_iter().flatten().map(|(_, frame)| step(frame)).collect()
}

/// The frame's own time, and those of its streams.
fn stated_times(frame: &Value) -> Vec<&Value> {
    let Some(properties) = frame.get("frame_properties") else { return Vec::new() };
    let streams = properties.get("streams").and_then(Value::as_object);
    let of_streams = streams.into_iter().flat_map(|s| s.values());
    let of_streams = of_streams.filter_map(|s| s.pointer("/stream_properties/sync/timestamp"));
    properties.get("timestamp").into_iter().chain(of_streams).collect()
}

/// A time that a frame states and that is not understood.
fn not_understood<'d>(steps: &[Step<'d>]) -> Option<&'d Value> {
    steps.iter().filter(|s| s.time.is_none()).find_map(|s| s.stated).filter(|v| !v.is_null())
}

/// A time in seconds: a number (s, ms, us or ns by its size), the same as text, or a date.
fn seconds(v: &Value) -> Option<f64> {
    let number = match v {
        Value::Number(n) => n.as_f64()?,
        Value::String(s) => match s.trim().parse::<f64>() {
            Ok(n) => n,
            Err(_) => return Nanos::parse_iso(s.trim()).ok().map(|t| t.0 as f64 / 1e9),
        },
        _ => return None,
    };
    let unit = [(1e17, 1e9), (1e14, 1e6), (1e11, 1e3)].iter().find(|(least, _)| number.abs() > *least);
    Some(number / unit.map_or(1.0, |(_, unit)| *unit)).filter(|v| v.is_finite())
}

/// Time of the first frame: the document's where it is a date, else the start that the user gives; and whether either
/// states it.
fn origin(steps: &[Step<'_>], options: &Options) -> Option<(Nanos, bool)> {
    let first = steps.iter().filter_map(|s| s.time).min_by(f64::total_cmp)?;
    // Seconds of this century's dates; less counts from some start.
    let date = (1e9..4.2e9).contains(&first);
    Some(if date {
        (Nanos((first * 1e9).round() as i64), true)
    } else {
        (options.start(), options.is_set(&START))
    })
}

/// The ego's poses, where two frames or more have one.
fn ego(steps: &[(f64, &Value)], systems: &Systems, frames: &[f64], gap: f64) -> Option<Ego> {
    let (own, world) = (systems.ego.as_deref()?, systems.world.as_deref()?);
    let mut sampled = Sampled::default();
    let mut poses = 0;
    for (time, frame) in steps {
        // A position that never changes is not a recorded pose.
        let Some(pose) = systems.between(own, world, frame).filter(|p| p.moves).map(|p| p.pose) else {
            continue;
        };
        if sampled.times.last().is_some_and(|last| last >= time) {
            continue;
        }
        poses += 1;
        let heading = se3::heading(pose.q);
        sampled.push(Sample { time: *time, position: pose.t, heading, ..Sample::UNKNOWN });
    }
    (poses >= 2).then(|| Ego {
        length_m: f64::NAN,
        width_m: f64::NAN,
        height_m: f64::NAN,
        reference_to_centre_m: 0.0,
        motion: sampled.motion_at(frames, gap),
        known_at: sampled.lags(frames),
        ..Ego::default()
    })
}

/// Boxes by object.
#[derive(Default)]
struct Rows {
    count: RowCount,
    objects: BTreeMap<String, (String, BTreeMap<i64, Sample>)>,
    /// Boxes in systems that do not lead to the world.
    foreign: BTreeMap<String, usize>,
    invalid: usize,
}

impl Rows {
    fn add(&mut self, time: f64, frame: &Value, document: &Value, systems: &Systems, target: &str) {
        for (uid, object) in frame.get("objects").and_then(Value::as_object).into_iter().flatten() {
            let about = document.get("objects").and_then(|o| o.get(uid));
            let boxes = object.pointer("/object_data/cuboid").and_then(Value::as_array);
            let Some(first) = boxes.and_then(|b| b.first()) else {
                self.count.read += 1;
                self.count.set_aside("no_position", 1);
                continue;
            };
            let more = boxes.map_or(0, |b| b.len() - 1);
            self.count.read += 1 + more;
            // A second box of the same object at the same time.
            self.count.set_aside("duplicate", more);
            let Some((pose, size)) = cuboid(first) else {
                self.invalid += 1;
                self.count.drop_rows("invalid", 1);
                continue;
            };
            let text = |v: Option<&Value>| v.and_then(Value::as_str).map(str::to_owned);
            let system = text(first.get("coordinate_system"))
                .or_else(|| text(object.get("coordinate_system")))
                .or_else(|| text(about?.get("coordinate_system")))
                .or_else(|| systems.only());
            let there = system.as_deref().and_then(|s| systems.between(s, target, frame));
            let Some(there) = there else {
                *self.foreign.entry(system.unwrap_or_else(|| "-".into())).or_default() += 1;
                self.count.drop_rows("unknown_frame", 1);
                continue;
            };
            let pose = systems::compose(&there.pose, &pose);
            let class = text(about.and_then(|o| o.get("type"))).unwrap_or_default();
            let sample =
                Sample { time, position: pose.t, heading: se3::heading(pose.q), size, ..Sample::UNKNOWN };
            let (_, samples) = self.objects.entry(uid.clone()).or_insert_with(|| (class, BTreeMap::new()));
            match samples.insert((time * 1e9).round() as i64, sample) {
                Some(_) => self.count.drop_rows("duplicate", 1),
                None => self.count.keep("track", 1),
            }
        }
    }

    /// Boxes of the document itself: objects that stand still for all of it.
    fn set_aside_static(&mut self, document: &Value) {
        let objects = document.get("objects").and_then(Value::as_object);
        let boxes =
            |o: &Value| o.pointer("/object_data/cuboid").and_then(Value::as_array).map_or(0, Vec::len);
        let all: usize = objects.into_iter().flatten().map(|(_, o)| boxes(o)).sum();
        self.count.read += all;
        self.count.set_aside("static_box", all);
    }

    fn tracks(self, frames: &[f64], gap: f64, label: &str, report: &mut SourceReport) -> Vec<Track> {
        let (mut out, mut unknown, mut impossible) = (Vec::new(), BTreeSet::new(), BTreeMap::new());
        for (id, (name, samples)) in self.objects {
            let class = class_of(&name);
            if class.is_none() {
                unknown.insert(if name.is_empty() { "-".to_owned() } else { name.clone() });
            }
            let mut sampled = Sampled::default();
            samples.into_values().for_each(|s| sampled.push(s));
            let (track, rows) = sampled.track_at(&id, class.unwrap_or_default(), &name, frames, gap);
            if rows > 0 {
                impossible.insert(id, rows);
            }
            if !track.frames.is_empty() {
                out.push(track);
            }
        }
        report.diagnostics.extend(self.foreign.iter().map(|(name, n)| findings::system(label, name, *n)));
        if self.invalid > 0 {
            report.diagnostics.push(findings::invalid(label, self.invalid));
        }
        if !unknown.is_empty() {
            let names: Vec<String> = unknown.into_iter().collect();
            report.diagnostics.push(findings::class(label, &names.join(", ")));
        }
        report.diagnostics.extend(impossible_speeds(label, &impossible));
        report.tables.push(self.count);
        out
    }
}

/// A box: center, then a quaternion x, y, z, w or angles about x, y, z, then sizes along its own axes.
fn cuboid(v: &Value) -> Option<(Se3, [f64; 3])> {
    let n = numbers(v.get("val")?)?;
    let (q, size) = match n.len() {
        10 => (quaternion(&n[3..7])?, &n[7..]),
        9 => (systems::euler(&n[3..6]), &n[6..]),
        _ => return None,
    };
    Some((Se3 { q, t: [n[0], n[1], n[2]] }, [size[0], size[1], size[2]]))
}

#[cfg(test)]
mod tests;
