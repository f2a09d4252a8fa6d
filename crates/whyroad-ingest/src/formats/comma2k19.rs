//! comma2k19 (Schafer et al. 2018, arXiv 1812.05752): one-minute segments of motorway driving with camera poses, raw
//! CAN and the car's own radar. Consecutive segments of a route become one drive.
//!
//! Times are GPS times of the pose (18 leap seconds behind GPS in 2018), positions local east and north around the
//! first pose. Radar returns become tracks whose box is a point (length and width 0): the radar tells where the nearest
//! surface is, not what it belongs to. Where poses are missing (a segment that is not there) there are no frames. Not
//! read: video, IMU, raw GNSS.

mod bus;
mod findings;
mod motion;
mod radar;
mod recording;
mod state_sources;

use crate::adapter::{Adapter, DriveSink, FilesInMemory, FormatAbout, Located, SkipReason, Source, whole};
use crate::encodings::can::CanDatabase;
use crate::encodings::input::Folder;
use crate::options::{OptionSpec, OptionType, Options, START};
use crate::report::SourceReport;
use crate::source::{ContentHash, SEARCH_DEPTH, drive_id, entries, file_label, implausible_span};
pub(crate) use findings::CODES;
use recording::{Pose, Recording};
use std::fs;
use std::path::{Path, PathBuf};
use whyroad_model::scene::{DriveMeta, Ego, FRAME_RATE_HZ, FrameOfReference};
use whyroad_model::{Bilingual, Drive, Nanos, Need};

/// Raised when the adapter makes something else of the same files, so that drives in a lake are replaced.
const REVISION: u32 = 2;
/// Seconds by which GPS time was ahead of UTC from 2017 on (IERS Bulletin C 52).
const GPS_LEAP_SECONDS: i64 = 18;
/// The DBC file of the car.
pub const DBC: OptionSpec =
    OptionSpec::new("dbc", OptionType::File, "FILE", "DBC file of the car; it defines the raw CAN messages");
/// GPS week 0, 1980-01-06T00:00:00Z, in Unix seconds.
const GPS_EPOCH_S: i64 = 315_964_800;
const WEEK_S: i64 = 604_800;

/// comma2k19 routes.
pub struct Comma2k19;

impl Adapter for Comma2k19 {
    fn about(&self) -> &'static FormatAbout {
        const {
            &FormatAbout {
                name: "comma2k19",
                summary: "comma2k19 routes: folders of one-minute segments with poses, raw CAN and radar",
                example: "comma2k19 path/to/routes --dbc car.dbc --lake lake",
                options: &[DBC, START],
                codes: CODES,
            }
        }
    }

    fn find(&self, path: &Path) -> Vec<Located> {
        whole(find_routes(path))
    }

    fn why_skipped(&self, file: &Path) -> Option<SkipReason> {
        file.extension().is_some_and(|e| e.eq_ignore_ascii_case("dbc")).then(|| {
            Bilingual::new(
                "CAN 报文定义：用 `ingest comma2k19 --dbc` 给出",
                "definitions of CAN messages: give them with `ingest comma2k19 --dbc`",
            )
        })
    }

    fn read_files(&self, files: &FilesInMemory, options: &Options, drives: &mut DriveSink<'_>) {
        let mut report = SourceReport::new("memory".to_owned());
        let drive = read_route(&[Folder::Memory(files)], "memory", options, &mut report);
        drives.put((drive, report));
    }

    fn read(&self, source: &Source, options: &Options, drives: &mut DriveSink<'_>) {
        drives.put(read(&source.path, options));
    }
}

/// Routes at or below `path`, sorted: folders whose subfolders are segments, or `path` itself when it is one segment.
pub fn find_routes(path: &Path) -> Vec<PathBuf> {
    fn search(dir: &Path, depth: usize, out: &mut Vec<PathBuf>) {
        let folders = folders(dir);
        if folders.iter().any(|p| is_segment(p)) {
            out.push(dir.to_owned());
        } else if depth > 0 {
            for folder in folders {
                search(&folder, depth - 1, out);
            }
        }
    }
    if is_segment(path) {
        return vec![path.to_owned()];
    }
    let mut out = Vec::new();
    if path.is_dir() {
        search(path, SEARCH_DEPTH, &mut out);
    }
    out
}

/// Subfolders in the order of their numbers, then names.
fn folders(dir: &Path) -> Vec<PathBuf> {
    let mut folders: Vec<PathBuf> = entries(dir).filter(|p| p.is_dir()).collect();
    folders.sort_by_key(|p| (file_label(p).parse().unwrap_or(u64::MAX), p.clone()));
    folders
}

fn is_segment(dir: &Path) -> bool {
    dir.join("global_pose").is_dir() || dir.join("processed_log/CAN").is_dir()
}

/// Reads a route's folder, or one segment's. `None` when there is nothing that could be kept; the report says why.
pub fn read(path: &Path, options: &Options) -> (Option<Drive>, SourceReport) {
    let mut report = SourceReport::new(path.display().to_string());
    let segments = if is_segment(path) {
        vec![path.to_owned()]
    } else {
        folders(path).into_iter().filter(|p| is_segment(p)).collect()
    };
    let folders: Vec<Folder<'_>> = segments.iter().map(|s| Folder::Disk(s)).collect();
    let drive = read_route(&folders, &name_of_route(&segments), options, &mut report);
    (drive, report)
}

fn read_route(
    segments: &[Folder<'_>],
    route: &str,
    options: &Options,
    report: &mut SourceReport,
) -> Option<Drive> {
    let mut hash = ContentHash::new("comma2k19", REVISION);
    let recording = Recording::read(segments, &mut hash, report);
    let at = |time: Option<&f64>| time.copied().unwrap_or(0.0);
    let times = &recording.pose.times;
    if let Some(d) = implausible_span(&report.source, at(times.first()), at(times.last()), times.len()) {
        report.diagnostics.push(d);
        return None;
    }
    let frames = frame_grid(&recording.pose);
    if frames.is_empty() {
        report.diagnostics.push(findings::no_pose(&report.source));
        return None;
    }
    // Until the year 2100; other numbers are not a time.
    let plausible = |t: &(f64, f64)| (0.0..6300.0).contains(&t.0) && (0.0..WEEK_S as f64).contains(&t.1);
    let gps = recording.pose.gps_of_first.filter(plausible);
    let dated = gps.is_some() || options.is_set(&START);
    let start = match gps {
        Some((week, second)) => {
            let week_began = GPS_EPOCH_S + week as i64 * WEEK_S - GPS_LEAP_SECONDS;
            Nanos(week_began * Nanos::SECOND.0).plus_secs(second)
        }
        None => {
            options.hash_start(&mut hash);
            options.start()
        }
    };
    let times = frames.iter().map(|t| start.plus_secs(t - frames[0])).collect();

    let dbc = read_dbc(options, &mut hash, report);
    let (bus, lacking) = bus::decode(&recording, dbc.as_ref(), &frames);
    if let (Some(path), true) =
        (options.file(&DBC), dbc.is_some() && !recording.can.times.is_empty() && bus::has_no_state(&bus))
    {
        report.diagnostics.push(findings::foreign_dbc(&path.display().to_string()));
    }
    if !options.is_set(&DBC) && !recording.can.times.is_empty() {
        report.diagnostics.push(findings::no_dbc(&report.source));
    }
    let motion = motion::at_frames(&recording.pose, &frames);
    let (tracks, radar_rows) = radar::tracks(&recording.radar, &frames, &motion);

    let mut missing = vec![Need::Map, Need::ObjectClasses, Need::ObjectSizes, Need::TrafficLights];
    if radar_rows.is_none() {
        missing.push(Need::Radar);
    }
    missing.extend(lacking);
    missing.extend([Need::WeatherAndSurface, Need::CameraPictures]);
    missing.extend((!dated).then_some(Need::Date));
    let sensors = radar_rows.iter().map(|_| "radar".to_owned()).collect();
    report.tables.extend(radar_rows);
    Some(Drive {
        meta: DriveMeta {
            drive_id: options.drive_id.clone().unwrap_or_else(|| drive_id(route)),
            format: "comma2k19".into(),
            source: route.split(['|', '_']).next().unwrap_or_default().to_owned(),
            place: None,
            map_ref: None,
            licence: Some("MIT".into()),
            frame_of_reference: FrameOfReference::World,
            content_hash: hash.finish(),
            video: Vec::new(),
            sensors,
            can: !recording.can.times.is_empty() || !recording.speed.0.is_empty(),
            missing,
            ..DriveMeta::default()
        },
        times,
        ego: Some(Ego {
            length_m: motion::EGO_LENGTH_M,
            width_m: motion::EGO_WIDTH_M,
            height_m: motion::EGO_HEIGHT_M,
            reference_to_centre_m: motion::CAMERA_TO_CENTER_M,
            motion,
            bus,
            known_at: crate::assemble::resample::lags(&recording.pose.times, &frames),
        }),
        tracks,
        map: None,
        lights: None,
        context: None,
        media: None,
    })
}

/// Frames at 10 Hz from the first pose on, on the log's own clock; none where poses are missing.
fn frame_grid(pose: &Pose) -> Vec<f64> {
    let (Some(&first), Some(&last)) = (pose.times.first(), pose.times.last()) else { return Vec::new() };
    // The last pose has a frame when it falls on the grid, give or take a microsecond.
    let count = ((last - first) * FRAME_RATE_HZ + 1e-5).floor() as usize + 1;
    (0..count).map(|i| first + i as f64 / FRAME_RATE_HZ).filter(|&t| motion::covers(pose, t)).collect()
}

fn read_dbc(options: &Options, hash: &mut ContentHash, report: &mut SourceReport) -> Option<CanDatabase> {
    let path = options.file(&DBC)?;
    let read = fs::read(path).map_err(|e| e.to_string()).and_then(|bytes| {
        hash.add("dbc", &bytes);
        // DBC files are often Latin-1 (degree signs in units); what we look up is ASCII.
        CanDatabase::parse(&String::from_utf8_lossy(&bytes))
    });
    read.map_err(|e| report.diagnostics.push(findings::dbc(&path.display().to_string(), &e))).ok()
}

/// `dongle|time_firstsegment`, as the folders name it.
fn name_of_route(segments: &[PathBuf]) -> String {
    let Some(first) = segments.first() else { return "comma2k19".into() };
    let absolute = first.canonicalize().unwrap_or_else(|_| first.clone());
    let route = absolute.parent().map(file_label).unwrap_or_default();
    format!("{route}_{}", file_label(first))
}
