//! Waymo Open Motion Dataset (Ettinger et al. 2021): TFRecord files of `Scenario` messages, about 9 s at 10 Hz each.
//! One record is one drive.
//!
//! Positions are box centers in a frame of the scenario's own, meters; headings counter-clockwise from x: as here.
//! Times are `start` plus the scenario's own seconds. States that are not valid are not observations. A vehicle is
//! taken for a car: the set does not tell trucks and buses apart. Not read: lidar, camera tokens, tracks to predict.

pub(crate) mod findings;
mod scenario;

use crate::adapter::{Adapter, DriveSink, FormatAbout, Located, Source};
use crate::assemble::feature_map;
use crate::assemble::finish::finish;
use crate::assemble::frames::{Frames, Sampled, median};
use crate::assemble::lane_lights;
use crate::assemble::licences;
use crate::encodings::tfrecord;
use crate::file_reader::FileReader;
use crate::options::{LICENCE, Options, START};
use crate::report::{RowCount, SourceReport};
use crate::source::{
    ContentHash, drive_id, file_label, find_files, implausible_span, impossible_speeds, resampled,
};
use scenario::{ObjectTrack, Scenario};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use whyroad_model::road_map::Point3;
use whyroad_model::scene::{DriveMeta, Ego, LightColor, LightState};
use whyroad_model::{Drive, Nanos, Need, ObjectClass};

/// Raised when the adapter makes something else of the same files, so that drives in a lake are replaced.
const REVISION: u32 = 4;
/// Nothing is interpolated over more than this, s.
const MAX_GAP_S: f64 = 0.25;

/// Waymo Open Motion Dataset scenarios.
pub struct WaymoMotion;

impl Adapter for WaymoMotion {
    fn about(&self) -> &'static FormatAbout {
        const {
            &FormatAbout {
                name: "waymo-motion",
                summary: "Waymo Open Motion Dataset: TFRecord files of scenarios",
                example: "waymo-motion path/to/tfrecords --lake lake",
                options: &[START, LICENCE],
                codes: findings::CODES,
            }
        }
    }

    fn find(&self, path: &Path) -> Vec<Located> {
        let scenarios = find_scenarios(path).into_iter();
        scenarios.map(|(path, at)| Located { path, part: Some(at) }).collect()
    }

    fn read(&self, source: &Source, options: &Options, drives: &mut DriveSink<'_>) {
        drives.put(read(&source.path, source.part.unwrap_or(0), options));
    }
}

/// Records at or below `path` in files whose name says `tfrecord`, with the byte at which each begins; sorted.
pub fn find_scenarios(path: &Path) -> Vec<(PathBuf, u64)> {
    let is_records = |file: &Path| file.file_name().is_some_and(|n| n.to_string_lossy().contains("tfrecord"));
    let mut out = Vec::new();
    for file in find_files(path, is_records) {
        // A file that cannot be read is one source, whose reading says why.
        let offsets = tfrecord::offsets(&file).unwrap_or_else(|_| vec![0]);
        out.extend(offsets.into_iter().map(|at| (file.clone(), at)));
    }
    out
}

/// Reads the scenario whose record begins at byte `at`. `None` when there is nothing that could be kept; the report
/// says why.
pub fn read(path: &Path, at: u64, options: &Options) -> (Option<Drive>, SourceReport) {
    let mut report = SourceReport::new(format!("{}@{at}", path.display()));
    let drive = read_record(path, at, options, &mut report);
    (drive, report)
}

fn read_record(path: &Path, at: u64, options: &Options, report: &mut SourceReport) -> Option<Drive> {
    let record = tfrecord::read(path, at)
        .map_err(|e| report.diagnostics.push(findings::record(&report.source, &e)))
        .ok()?;
    of_record(&record, path, at, options, report)
}

/// The drive of a record, whose name is that of its file and the byte at which it begins.
fn of_record(
    record: &[u8],
    path: &Path,
    at: u64,
    options: &Options,
    report: &mut SourceReport,
) -> Option<Drive> {
    let label = report.source.clone();
    let scenario = match scenario::parse(record) {
        Err(e) => Err(e.to_string()),
        Ok(s) if s.times.is_empty() || s.tracks.is_empty() => Err("it has no times or no tracks".to_owned()),
        // Written so that NaN fails.
        Ok(s) if !s.times.windows(2).all(|w| w[1] > w[0]) => Err("its times do not rise".to_owned()),
        Ok(s) => Ok(s),
    };
    let s = scenario.map_err(|what| report.diagnostics.push(findings::schema(&label, &what))).ok()?;
    if let Some(d) = implausible_span(&label, s.times[0], s.times[s.times.len() - 1], s.times.len()) {
        report.diagnostics.push(d);
        return None;
    }
    let frames = Frames::of(&s.times);
    if frames.resampled() {
        report.diagnostics.push(resampled(&label, frames.native_step_s));
    }
    let time = |seconds: f64| options.start().plus_secs(seconds - s.times[0]);

    let (ego, tracks) = objects(&s, &frames, &label, report);
    let (lights, stops) = lights(&s, time);
    let mut hash = ContentHash::new("waymo-motion", REVISION);
    options.hash_start(&mut hash);
    hash.add(&file_label(path), record);
    let built = (!s.features.is_empty()).then(|| feature_map::build(s.features, &stops));
    let map = built.map(|built| {
        report
            .diagnostics
            .extend(built.invalid_example.as_ref().map(|e| findings::map(&label, &built.count, e)));
        report.tables.push(built.count);
        built.map
    });
    let missing = Need::absent([
        (ego.is_none(), Need::EgoPose),
        (map.is_none(), Need::Map),
        (lights.is_none(), Need::TrafficLights),
        (true, Need::VehicleBus),
        (true, Need::WeatherAndSurface),
        (true, Need::CameraPictures),
        (!options.is_set(&START), Need::Date),
    ]);
    let name = if s.id.is_empty() { format!("{}-{at}", file_label(path)) } else { s.id.clone() };
    Some(Drive {
        meta: DriveMeta {
            drive_id: options.drive_id.clone().unwrap_or_else(|| drive_id(&name)),
            format: "waymo-motion".into(),
            source: "waymo".into(),
            map_ref: map.as_ref().map(|_| name),
            licence: options.licence().or_else(|| Some(licences::WAYMO.into())),
            content_hash: hash.finish(),
            missing,
            ..DriveMeta::default()
        },
        times: frames.seconds.iter().map(|&t| time(t)).collect(),
        ego,
        tracks,
        map,
        lights,
        context: None,
        media: None,
    })
}

/// `Track.ObjectType` and our class for it.
fn class_of(kind: i64) -> (&'static str, ObjectClass) {
    match kind {
        1 => ("TYPE_VEHICLE", ObjectClass::Vehicle),
        2 => ("TYPE_PEDESTRIAN", ObjectClass::Pedestrian),
        3 => ("TYPE_CYCLIST", ObjectClass::Bicycle),
        4 => ("TYPE_OTHER", ObjectClass::Unknown),
        _ => ("TYPE_UNSET", ObjectClass::Unknown),
    }
}

fn sampled(
    track: &ObjectTrack,
    steps: usize,
    count: &mut RowCount,
    what: &'static str,
) -> Result<Sampled, String> {
    count.read += track.states.len();
    if track.states.len() != steps {
        count.drop_rows("invalid", track.states.len());
        return Err(format!(
            "track {} has {} states, the scenario {steps} times",
            track.id,
            track.states.len()
        ));
    }
    let (mut out, mut bad) = (Sampled::default(), None);
    for state in &track.states {
        match state {
            None => count.set_aside("not_observed", 1),
            Some(s) if [s.position[0], s.position[1], s.heading].iter().all(|v| v.is_finite()) => {
                count.keep(what, 1);
                out.push(*s);
            }
            Some(s) => {
                count.drop_rows("invalid", 1);
                bad = Some(format!("track {} at {} s has a place that is not a number", track.id, s.time));
            }
        }
    }
    // A track with an invalid state keeps its valid ones; the invalid one is counted.
    match bad {
        Some(reason) if out.times.is_empty() => Err(reason),
        _ => Ok(out),
    }
}

fn objects(
    s: &Scenario,
    frames: &Frames,
    label: &str,
    report: &mut SourceReport,
) -> (Option<Ego>, Vec<whyroad_model::scene::Track>) {
    let mut count = RowCount::new("states");
    let (mut ego, mut tracks, mut ids) = (None, Vec::new(), BTreeSet::new());
    let (mut invalid, mut impossible) = (None, BTreeMap::new());
    for (i, track) in s.tracks.iter().enumerate() {
        let own = s.sdc_track_index == Some(i);
        let id = track.id.to_string();
        let result = if ids.insert(track.id) {
            sampled(track, s.times.len(), &mut count, if own { "ego" } else { "track" })
        } else {
            count.read += track.states.len();
            count.drop_rows("duplicate", track.states.len());
            Err(format!("a second track {id}"))
        };
        match result {
            Err(reason) => drop(invalid.get_or_insert(reason)),
            Ok(object) if own => {
                ego = Some(Ego {
                    length_m: median(&object.length),
                    width_m: median(&object.width),
                    height_m: median(&object.height),
                    reference_to_centre_m: 0.0,
                    motion: object.motion_at(&frames.seconds, MAX_GAP_S),
                    known_at: object.lags(&frames.seconds),
                    ..Ego::default()
                });
            }
            Ok(object) => {
                let (name, class) = class_of(track.kind);
                let (track, rows) = object.track_at(&id, class, name, &frames.seconds, MAX_GAP_S);
                if rows > 0 {
                    impossible.insert(id, rows);
                }
                if !track.frames.is_empty() {
                    tracks.push(track);
                }
            }
        }
    }
    if ego.is_none() {
        report.diagnostics.push(findings::ego_missing(label, s.sdc_track_index, s.tracks.len()));
    }
    if count.dropped_total() > 0 {
        let example = invalid.unwrap_or_else(|| "a place that is not a number".to_owned());
        report.diagnostics.push(findings::tracks(label, &count, &example));
    }
    report.diagnostics.extend(impossible_speeds(label, &impossible));
    report.tables.push(count);
    tracks.sort_by(|a, b| a.id.cmp(&b.id));
    (ego, tracks)
}

/// `TrafficSignalLaneState.State` by number.
fn color(state: i64) -> Option<LightColor> {
    const NAMES: [&str; 9] = [
        "UNKNOWN",
        "ARROW_STOP",
        "ARROW_CAUTION",
        "ARROW_GO",
        "STOP",
        "CAUTION",
        "GO",
        "FLASHING_STOP",
        "FLASHING_CAUTION",
    ];
    NAMES.get(usize::try_from(state).ok()?).and_then(|name| lane_lights::color(name))
}

/// States of the lights by lane, and where lanes stop for them.
fn lights(s: &Scenario, time: impl Fn(f64) -> Nanos) -> (Option<Vec<LightState>>, BTreeMap<String, Point3>) {
    let mut by_lane: BTreeMap<&str, BTreeMap<usize, Option<LightColor>>> = BTreeMap::new();
    let mut stops = BTreeMap::new();
    for (step, states) in s.lights.iter().enumerate().take(s.times.len()) {
        for state in states {
            by_lane.entry(&state.lane).or_default().insert(step, color(state.state));
            let point = state.stop_point.filter(|p| p.x.is_finite() && p.y.is_finite() && p.z.is_finite());
            stops.extend(point.map(|p| (state.lane.clone(), p)));
        }
    }
    let all: Vec<LightState> = by_lane
        .iter()
        .flat_map(|(lane, seen)| {
            // Steps before the light first comes into view are not worth a state.
            let first = seen.keys().next().copied().unwrap_or(0);
            let steps = (first..s.times.len()).map(|i| (time(s.times[i]), seen.get(&i).copied().flatten()));
            lane_lights::changes(lane, steps)
        })
        .collect();
    ((!all.is_empty()).then_some(all), stops)
}

/// For [`crate::readers`].
pub(crate) const READERS: &[FileReader] = &[FileReader {
    name: "waymo-scenario",
    read: |bytes| {
        let mut report = SourceReport::new("record".to_owned());
        let drive = of_record(bytes, Path::new("record"), 0, &Options::default(), &mut report);
        drive.map(|mut drive| finish(&mut drive)).is_some()
    },
}];
