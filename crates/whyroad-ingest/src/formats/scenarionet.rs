//! ScenarioNet databases (Li et al. 2023, arXiv 2306.12241): one pickle per scenario, as ScenarioNet and MetaDrive
//! write them (`ScenarioDescription` of MetaDrive 0.4: tracks, dynamic map states, map features, metadata).
//!
//! Positions are box centers, meters, headings counter-clockwise from x: as here. Times are `start` plus the
//! scenario's own seconds, which begin at 0. Rows that the scenario marks as not valid are not observations.
//! The class is the category that a conversion of nuScenes keeps in a track's metadata; a `VEHICLE` without one is a
//! motor vehicle of unknown kind. The pickle is read as data; nothing that it names is imported or called (see
//! [`crate::encodings::pickle`]).

pub(crate) mod findings;
mod map;
mod tracks;

use crate::adapter::{Adapter, DriveSink, FilesInMemory, FormatAbout, Located, SkipReason, Source, whole};
use crate::assemble::frames::{Frames, median};
use crate::assemble::lane_lights;
use crate::assemble::licences;
use crate::encodings::pickle::{self, Value};
use crate::options::{LICENCE, Options, START};
use crate::report::SourceReport;
use crate::source::{
    ContentHash, SEARCH_DEPTH, drive_id, entries, file_label, implausible_span, impossible_speeds, resampled,
};
use std::collections::BTreeMap;
use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use tracks::Tracks;
use whyroad_model::road_map::Point3;
use whyroad_model::scene::{DriveMeta, Ego, FrameOfReference, LightState};
use whyroad_model::{Bilingual, Drive, Nanos, Need};

/// Raised when the adapter makes something else of the same files, so that drives in a lake are replaced.
const REVISION: u32 = 8;
/// Nothing is interpolated over more than this, s: two steps of the slowest sets (2 Hz) with room for jitter.
const MAX_GAP_S: f64 = 0.6;
/// Bytes of a pickle that are searched for the parts of a scenario.
const SNIFFED_BYTES: u64 = 64 << 20;
/// Files of a database that are not scenarios.
const NOT_SCENARIOS: [&str; 2] = ["dataset_summary.pkl", "dataset_mapping.pkl"];

/// ScenarioNet and MetaDrive scenarios.
pub struct ScenarioNet;

impl Adapter for ScenarioNet {
    fn about(&self) -> &'static FormatAbout {
        const {
            &FormatAbout {
                name: "scenarionet",
                summary: "ScenarioNet and MetaDrive scenarios: pickles, one scenario each",
                example: "scenarionet path/to/database --licence CC-BY-4.0 --lake lake",
                options: &[START, LICENCE],
                codes: findings::CODES,
            }
        }
    }

    fn find(&self, path: &Path) -> Vec<Located> {
        whole(find_scenarios(path))
    }

    fn companions(&self, source: &Path) -> Vec<PathBuf> {
        let folders = source.ancestors().skip(1).take(SEARCH_DEPTH);
        folders.flat_map(|dir| NOT_SCENARIOS.map(|name| dir.join(name))).collect()
    }

    fn why_skipped(&self, file: &Path) -> Option<SkipReason> {
        let pickle = file.extension().is_some_and(|e| e == "pkl" || e == "pickle");
        pickle.then(|| Bilingual::new("pickle 中没有场景", "a pickle without a scenario in it"))
    }

    fn read_files(&self, files: &FilesInMemory, options: &Options, drives: &mut DriveSink<'_>) {
        for (name, bytes) in files {
            let mut report = SourceReport::new(name.clone());
            let drive = of_pickle(bytes, Path::new(name), options, &mut report);
            drives.put((drive, report));
        }
    }

    fn read(&self, source: &Source, options: &Options, drives: &mut DriveSink<'_>) {
        drives.put(read(&source.path, options));
    }
}

/// The data set whose poses have no heights: `ego_pose` of nuScenes is localized in a plane, z is 0 by definition.
const IN_ONE_PLANE: &str = "nuscenes";

/// Scenario files at or below `path`, sorted: `sd_*.pkl`, and with a database's `dataset_summary.pkl` beside or above
/// them every pickle; a file given directly, with any name.
pub fn find_scenarios(path: &Path) -> Vec<PathBuf> {
    fn search(dir: &Path, in_database: bool, depth: usize, out: &mut Vec<PathBuf>) {
        let in_database = in_database || NOT_SCENARIOS.iter().any(|n| dir.join(n).is_file());
        for path in entries(dir) {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let scenario = name.ends_with(".pkl") && !NOT_SCENARIOS.contains(&name.as_str());
            if path.is_dir() && depth > 0 {
                search(&path, in_database, depth - 1, out);
            } else if path.is_file()
                && scenario
                && (in_database || name.starts_with("sd_") || looks_like_one(&path))
            {
                out.push(path);
            }
        }
    }
    if path.is_file() {
        let pickle = path.extension().is_some_and(|e| e == "pkl" || e == "pickle");
        return if pickle { vec![path.to_owned()] } else { Vec::new() };
    }
    let mut out = Vec::new();
    search(path, false, SEARCH_DEPTH, &mut out);
    out.sort();
    out
}

/// True for a pickle of any name that has the parts of a scenario.
fn looks_like_one(path: &Path) -> bool {
    let mut bytes = Vec::new();
    let read = fs::File::open(path).and_then(|f| f.take(SNIFFED_BYTES).read_to_end(&mut bytes));
    let has = |word: &str| bytes.windows(word.len()).any(|w| w == word.as_bytes());
    read.is_ok() && bytes.first() == Some(&0x80) && has("tracks") && has("map_features")
}

/// Reads one scenario. `None` when there is nothing that could be kept; the report says why.
pub fn read(path: &Path, options: &Options) -> (Option<Drive>, SourceReport) {
    let mut report = SourceReport::new(path.display().to_string());
    let drive = read_scenario(path, options, &mut report);
    (drive, report)
}

fn read_scenario(path: &Path, options: &Options, report: &mut SourceReport) -> Option<Drive> {
    let label = path.display().to_string();
    let bytes = fs::read(path).map_err(|e| report.diagnostics.push(findings::io(&label, &e))).ok()?;
    of_pickle(&bytes, path, options, report)
}

/// The drive of a pickle, whose name is that of its file.
fn of_pickle(bytes: &[u8], path: &Path, options: &Options, report: &mut SourceReport) -> Option<Drive> {
    let label = path.display().to_string();
    let pickle =
        pickle::read(bytes).map_err(|e| report.diagnostics.push(findings::pickle(&label, &e))).ok()?;
    let root = pickle.root();
    let (all_tracks, times) = match parts(root) {
        Ok(parts) => parts,
        Err((place, what)) => {
            report.diagnostics.push(findings::schema(&label, place, &what));
            return None;
        }
    };
    let metadata = root.get("metadata");
    if let Some(d) = implausible_span(&label, times[0], times[times.len() - 1], times.len()) {
        report.diagnostics.push(d);
        return None;
    }
    let frames = Frames::of(&times);
    if frames.resampled() {
        report.diagnostics.push(resampled(&label, frames.native_step_s));
    }
    let start = |seconds: f64| options.start().plus_secs(seconds - times[0]);

    let sdc = metadata.and_then(|m| m.get("sdc_id")).and_then(|v| v.id());
    let mut read = Tracks::read(all_tracks, &times, sdc.as_deref(), bytes.len());
    let key_step_s = read.key_frames.map_or(0.0, |k| k.step as f64 * frames.native_step_s);
    if read.key_frames.is_some() {
        report.diagnostics.push(findings::key_frames(&label, key_step_s));
    }
    let text = |key: &str| metadata.and_then(|m| m.get(key)).and_then(|v| v.id());
    let in_one_plane = text("dataset").as_deref() == Some(IN_ONE_PLANE);
    if in_one_plane {
        read.forget_heights();
    }
    let max_gap_s = MAX_GAP_S.max(1.2 * key_step_s);
    read.finish(&frames.seconds, max_gap_s);
    report.diagnostics.extend(findings::of_tracks(&label, &read));
    report.diagnostics.extend(impossible_speeds(&label, &read.impossible));
    report.tables.push(read.count);
    let ego = read.ego.map(|e| Ego {
        length_m: median(&e.length),
        width_m: median(&e.width),
        height_m: median(&e.height),
        reference_to_centre_m: 0.0,
        motion: e.motion_at(&frames.seconds, max_gap_s),
        known_at: e.lags(&frames.seconds),
        ..Ego::default()
    });

    let (lights, stops) = lights(root, &times, start);
    let map = root.get("map_features").and_then(|f| map::read(f, &stops)).map(|mut built| {
        if in_one_plane {
            map::forget_heights(&mut built.map);
        }
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
    let name = file_label(path);
    let mut hash = ContentHash::new("scenarionet", REVISION);
    options.hash_start(&mut hash);
    hash.add(&name, bytes);
    Some(Drive {
        meta: DriveMeta {
            drive_id: options.drive_id.clone().unwrap_or_else(|| drive_id(name.trim_end_matches(".pkl"))),
            format: "scenarionet".into(),
            source: text("dataset").unwrap_or_else(|| "scenarionet".into()),
            place: text("map"),
            map_ref: map.as_ref().and_then(|_| root.get("id")).and_then(|v| v.id()),
            licence: options
                .licence()
                .or_else(|| licences::of_data_set(&text("dataset")?).map(str::to_owned)),
            frame_of_reference: FrameOfReference::World,
            content_hash: hash.finish(),
            missing,
            ..DriveMeta::default()
        },
        times: frames.seconds.iter().map(|&s| start(s)).collect(),
        ego,
        tracks: read.tracks,
        map,
        lights,
        context: None,
        media: None,
    })
}

/// Tracks and times of a scenario; or where something is missing, and what.
fn parts(root: Value<'_>) -> Result<(Value<'_>, Vec<f64>), (&'static str, String)> {
    if root.entries().is_none() {
        return Err(("", "is not a dict".into()));
    }
    let tracks = root.get("tracks").ok_or(("/tracks", "is missing".to_owned()))?;
    if tracks.entries().is_none() {
        return Err(("/tracks", "is not a dict".into()));
    }
    let ts = root.get("metadata").and_then(|m| m.get("ts").or_else(|| m.get("timestep")));
    let times =
        ts.and_then(|v| v.column()).ok_or(("/metadata/ts", "is missing or no list of numbers".to_owned()))?;
    if times.is_empty() {
        return Err(("/metadata/ts", "has no times".into()));
    }
    // Written so that NaN fails.
    let rising = times.windows(2).all(|w| w[1] > w[0]) && times.iter().all(|t| t.is_finite());
    if rising { Ok((tracks, times)) } else { Err(("/metadata/ts", "does not rise all the time".into())) }
}

/// States of the lights, and where lanes stop for them.
fn lights(
    root: Value<'_>,
    times: &[f64],
    start: impl Fn(f64) -> Nanos,
) -> (Option<Vec<LightState>>, BTreeMap<String, Point3>) {
    let (mut by_lane, mut stops) = (BTreeMap::new(), BTreeMap::new());
    let entries = root.get("dynamic_map_states").and_then(|d| d.entries());
    for (key, light) in entries.into_iter().flatten() {
        let lane = light.get("lane").and_then(|v| v.id()).or_else(|| key.id());
        let states = light.get("state").and_then(|s| s.get("object_state")).and_then(|v| v.texts());
        let (Some(lane), Some(states)) = (lane, states) else { continue };
        let steps = times.iter().zip(states);
        let colors = steps.map(|(&t, name)| (start(t), name.as_deref().and_then(lane_lights::color)));
        by_lane.entry(lane.clone()).or_insert_with(|| lane_lights::changes(&lane, colors));
        // One point for all steps; a point for each step where the scenario was made by a simulator.
        let point = light.get("stop_point").and_then(|v| v.rows());
        let xyz = point.and_then(|rows| match rows.as_slice() {
            [x, y, rest @ ..] if x.len() == 1 => Some([x[0], y[0], rest.first().map_or(0.0, |z| z[0])]),
            [.., last] if last.len() >= 2 => Some([last[0], last[1], last.get(2).copied().unwrap_or(0.0)]),
            _ => None,
        });
        if let Some([x, y, z]) = xyz.filter(|p| p.iter().all(|v| v.is_finite())) {
            stops.insert(lane, Point3 { x, y, z });
        }
    }
    let states: Vec<LightState> = by_lane.into_values().flatten().collect();
    ((!states.is_empty()).then_some(states), stops)
}
