//! AV2 motion forecasting scenarios (Argoverse 2, Wilson et al. 2021): 11 s of tracks at 10 Hz in the city frame, with
//! velocities and headings as the tracker had them, and a map that has center lines.
//!
//! Nothing has a size and there is no height. The track `AV` is the ego; it is taken for the middle of the car that
//! AV2's sensor logs were recorded with, as every other row is the middle of its object (if it were the rear axle, the
//! ego's box would be 1.34 m further forward: no publication states this, and the car does not turn enough here to
//! decide it).

mod findings;
mod scenario;

use super::av2::ego_box::FORD_FUSION;
use super::av2::map_file::read_map;
use crate::adapter::{Adapter, DriveSink, FormatAbout, Located, Source, whole};
use crate::assemble::frames::Sampled;
use crate::assemble::geometry::{center_line, distance};
use crate::assemble::licences;
use crate::assemble::resample::MAX_GAP_S;
use crate::encodings::columns::{read_parquet, read_parquet_bytes};
use crate::file_reader::FileReader;
use crate::options::{Options, START};
use crate::report::SourceReport;
use crate::source::{ContentHash, drive_id, file_label, find_folders, implausible_span, impossible_speeds};
pub(crate) use findings::CODES;
use scenario::{EGO, Scenario, class_of};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use whyroad_model::scene::{DriveMeta, Ego, FRAME_RATE_HZ, FrameOfReference, Track};
use whyroad_model::{Diagnostic, Drive, Need, RoadMap};

/// Raised when the adapter makes something else of the same files, so that drives in a lake are replaced.
const REVISION: u32 = 3;

/// Argoverse 2 motion forecasting scenarios.
pub struct Av2Motion;

impl Adapter for Av2Motion {
    fn about(&self) -> &'static FormatAbout {
        const {
            &FormatAbout {
                name: "av2-motion",
                summary: "Argoverse 2 motion forecasting: a folder with scenario_*.parquet and a map",
                example: "av2-motion path/to/scenarios --lake lake",
                options: &[START],
                codes: CODES,
            }
        }
    }

    fn find(&self, path: &Path) -> Vec<Located> {
        whole(find_scenarios(path))
    }

    fn read(&self, source: &Source, options: &Options, drives: &mut DriveSink<'_>) {
        drives.put(read(&source.path, options));
    }
}

/// Scenario folders (one with `scenario_*.parquet` in it) at or below `path`, sorted.
pub fn find_scenarios(path: &Path) -> Vec<PathBuf> {
    find_folders(path, |dir| scenario_file(dir).is_some())
}

fn scenario_file(dir: &Path) -> Option<PathBuf> {
    let is_scenario = |p: &PathBuf| {
        let name = p.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("scenario_") && name.ends_with(".parquet")
    };
    fs::read_dir(dir).ok()?.flatten().map(|e| e.path()).filter(is_scenario).min()
}

/// Reads one scenario folder. `None` when there is nothing that could be kept; the report says why.
pub fn read(dir: &Path, options: &Options) -> (Option<Drive>, SourceReport) {
    let mut report = SourceReport::new(dir.display().to_string());
    let drive = read_scenario(dir, options, &mut report);
    (drive, report)
}

fn read_scenario(dir: &Path, options: &Options, report: &mut SourceReport) -> Option<Drive> {
    let mut hash = ContentHash::new("av2-motion", REVISION);
    let Some(file) = scenario_file(dir) else {
        report
            .diagnostics
            .push(findings::unreadable(&dir.display().to_string(), "scenario_*.parquet is missing"));
        return None;
    };
    let label = file.display().to_string();
    let read = fs::read(&file).map_err(|e| e.to_string()).and_then(|bytes| {
        hash.add(&file_label(&file), &bytes);
        Scenario::read(&read_parquet(&file)?)
    });
    let scenario = match read {
        Ok(s) => s,
        Err(reason) => {
            report.diagnostics.push(findings::unreadable(&label, &reason));
            return None;
        }
    };
    report.diagnostics.extend(findings::of_rows(&label, &scenario));
    let frames = match frames(&scenario, &label) {
        Ok(frames) => frames,
        Err(problem) => {
            report.diagnostics.push(*problem);
            return None;
        }
    };
    if scenario.tracks.is_empty() {
        report.tables.push(scenario.count);
        return None;
    }
    let (mut road, map_file) = read_map(dir, &mut hash, report);
    if let Some(map) = &mut road {
        lift_center_lines(map);
    }

    let mut missing = vec![Need::ObjectSizes];
    if road.is_none() {
        missing.push(Need::Map);
    }
    let ego = scenario.tracks.get(EGO).map(|(_, samples)| ego(samples, &frames));
    if ego.is_none() {
        missing.push(Need::EgoPose);
        report.diagnostics.push(findings::no_ego(&label));
    }
    missing.extend([
        Need::LidarPointsInBoxes,
        Need::TrafficLights,
        Need::VehicleBus,
        Need::WeatherAndSurface,
        Need::CameraPictures,
    ]);
    missing.extend((scenario.start.is_none() && !options.is_set(&START)).then_some(Need::Date));
    let tracks = tracks(&scenario, &frames, &label, report);
    report.tables.insert(0, scenario.count);

    let start = scenario.start.unwrap_or_else(|| {
        options.hash_start(&mut hash);
        options.start()
    });
    Some(Drive {
        meta: DriveMeta {
            drive_id: options.drive_id.clone().unwrap_or_else(|| drive_id(&file_label(dir))),
            format: "av2-motion".into(),
            source: "av2".into(),
            place: scenario.city.as_deref().map(city),
            map_ref: map_file.map(|file| scenario.map_ref.unwrap_or(file)),
            licence: Some(licences::ARGOVERSE_2.into()),
            frame_of_reference: FrameOfReference::World,
            content_hash: hash.finish(),
            video: Vec::new(),
            sensors: Vec::new(),
            can: false,
            missing,
            ..DriveMeta::default()
        },
        times: frames.iter().map(|&t| start.plus_secs(t)).collect(),
        ego,
        tracks,
        map: road,
        lights: None,
        context: None,
        media: None,
    })
}

/// Times of the frames, s.
fn frames(scenario: &Scenario, label: &str) -> Result<Vec<f64>, Box<Diagnostic>> {
    match implausible_span(label, 0.0, scenario.steps as f64 / FRAME_RATE_HZ, scenario.steps + 1) {
        Some(problem) => Err(Box::new(problem)),
        None => Ok((0..scenario.steps).map(|i| i as f64 / FRAME_RATE_HZ).collect()),
    }
}

/// These maps write their center lines at height 0 though the edges have heights: they get the height half way between
/// the edges.
fn lift_center_lines(map: &mut RoadMap) {
    for lane in map.lanes.iter_mut().filter(|l| l.center.iter().all(|p| p.z == 0.0)) {
        let between = center_line(&lane.left, &lane.right);
        for p in &mut lane.center {
            let nearest = between.iter().min_by(|a, b| distance(**a, *p).total_cmp(&distance(**b, *p)));
            p.z = nearest.map_or(f64::NAN, |q| q.z);
        }
    }
}

fn ego(samples: &Sampled, frames: &[f64]) -> Ego {
    Ego {
        length_m: FORD_FUSION.length_m,
        width_m: FORD_FUSION.width_m,
        height_m: FORD_FUSION.height_m,
        reference_to_centre_m: 0.0,
        motion: samples.motion_at(frames, MAX_GAP_S),
        known_at: samples.lags(frames),
        ..Ego::default()
    }
}

fn tracks(scenario: &Scenario, frames: &[f64], label: &str, report: &mut SourceReport) -> Vec<Track> {
    let mut impossible = BTreeMap::new();
    let tracks = scenario
        .tracks
        .iter()
        .filter(|(id, _)| *id != EGO)
        .map(|(id, (kind, samples))| {
            let class = class_of(kind).unwrap_or_default();
            let (track, rows) = samples.track_at(id, class, kind, frames, MAX_GAP_S);
            if rows > 0 {
                impossible.insert(id.clone(), rows);
            }
            track
        })
        .collect();
    report.diagnostics.extend(impossible_speeds(label, &impossible));
    tracks
}

/// `palo-alto` as people write it.
fn city(name: &str) -> String {
    if name == "washington-dc" {
        return "Washington, DC".into();
    }
    let word =
        |w: &str| w.chars().take(1).flat_map(char::to_uppercase).chain(w.chars().skip(1)).collect::<String>();
    name.split('-').map(word).collect::<Vec<_>>().join(" ")
}

/// For [`crate::readers`].
pub(crate) const READERS: &[FileReader] = &[FileReader {
    name: "av2-motion",
    read: |bytes| {
        let read = read_parquet_bytes(bytes.to_vec()).and_then(|table| Scenario::read(&table));
        let Ok(scenario) = read else { return false };
        drop(findings::of_rows("scenario", &scenario));
        let Ok(frames) = frames(&scenario, "scenario") else { return false };
        let mut report = SourceReport::new("scenario".to_owned());
        let ego = scenario.tracks.get(EGO).map(|(_, samples)| ego(samples, &frames));
        drop(tracks(&scenario, &frames, "scenario", &mut report));
        ego.is_some()
    },
}];
