//! comma2k19 (Schafer et al. 2018, arXiv 1812.05752): one-minute segments of motorway driving with camera poses, raw CAN
//! and the car's own radar. Consecutive segments of a route become one drive.
//!
//! Times are GPS times of the pose (18 leap seconds behind GPS in 2018), positions local east and north around the first
//! pose. Radar returns become tracks whose box is a point (length and width 0): the radar tells where the nearest
//! surface is, not what it belongs to. Not read: video, IMU, raw GNSS.

mod bus;
mod findings;
mod motion;
mod radar;
mod recording;

use crate::can::CanDatabase;
use crate::report::SourceReport;
use crate::source::{ContentHash, drive_id, file_label};
pub(crate) use findings::CODES;
use recording::Recording;
use std::path::{Path, PathBuf};
use std::{fs, io};
use whyroad_model::scene::{DriveMeta, Ego, FRAME_RATE_HZ, FrameOfReference};
use whyroad_model::{Drive, DriveId, Nanos};

/// Raised when the adapter makes something else of the same files, so that drives in a lake are replaced.
const REVISION: u32 = 1;
/// Seconds by which GPS time was ahead of UTC from 2017 on (IERS Bulletin C 52).
const GPS_LEAP_SECONDS: f64 = 18.0;
/// GPS week 0, 1980-01-06T00:00:00Z, in Unix seconds.
const GPS_EPOCH_S: f64 = 315_964_800.0;
const WEEK_S: f64 = 604_800.0;

/// What a user may say about a recording.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Name and text of the DBC that describes the car's bus.
    pub dbc: Option<(String, String)>,
    /// Time of the first frame, where the log has no GPS time.
    pub start_time: Nanos,
    /// Id of the drive; made from the route's name when absent.
    pub drive_id: Option<DriveId>,
}

/// Segment folders at or below `path`, grouped into routes, both in order.
pub fn find_routes(path: &Path) -> io::Result<Vec<Vec<PathBuf>>> {
    if is_segment(path) {
        return Ok(vec![vec![path.to_owned()]]);
    }
    fn search(dir: &Path, depth: usize, out: &mut Vec<Vec<PathBuf>>) -> io::Result<()> {
        let mut folders: Vec<PathBuf> =
            fs::read_dir(dir)?.filter_map(|e| e.ok().map(|e| e.path())).filter(|p| p.is_dir()).collect();
        folders.sort_by_key(|p| (segment_number(p), p.clone()));
        let (segments, others): (Vec<_>, Vec<_>) = folders.into_iter().partition(|p| is_segment(p));
        if !segments.is_empty() {
            out.push(segments);
        }
        if depth > 0 {
            for other in others {
                search(&other, depth - 1, out)?;
            }
        }
        Ok(())
    }
    let mut out = Vec::new();
    search(path, 2, &mut out)?;
    Ok(out)
}

fn is_segment(dir: &Path) -> bool {
    dir.join("global_pose/frame_times").is_file() || dir.join("processed_log/CAN").is_dir()
}

fn segment_number(path: &Path) -> u64 {
    file_label(path).parse().unwrap_or(u64::MAX)
}

/// Reads the segments of one route. `None` when there is nothing that could be kept; the report says why.
pub fn read(segments: &[PathBuf], options: &Options) -> (Option<Drive>, SourceReport) {
    let name = segments.first().and_then(|s| s.parent()).unwrap_or(Path::new("."));
    let mut report = SourceReport::new(name.display().to_string());
    let drive = read_route(segments, options, &mut report);
    (drive, report)
}

fn read_route(segments: &[PathBuf], options: &Options, report: &mut SourceReport) -> Option<Drive> {
    let mut hash = ContentHash::new("comma2k19", REVISION);
    let recording = Recording::read(segments, &mut hash, report);
    let source = report.source.clone();
    let (Some(&first), Some(&last)) = (recording.pose.times.first(), recording.pose.times.last()) else {
        report.diagnostics.push(findings::no_pose(&source));
        return None;
    };
    // Frames at 10 Hz on the log's own clock; the last pose has a frame when it falls on the grid.
    let count = ((last - first) * FRAME_RATE_HZ + 1e-6).floor() as usize + 1;
    let frames: Vec<f64> = (0..count).map(|i| first + i as f64 / FRAME_RATE_HZ).collect();
    let start = match recording.pose.gps_of_first {
        Some((week, second)) => Nanos::from_secs_f64(GPS_EPOCH_S + week * WEEK_S - GPS_LEAP_SECONDS).plus_secs(second),
        None => options.start_time,
    };
    let times = (0..count).map(|i| start.plus_secs(i as f64 / FRAME_RATE_HZ)).collect();

    let dbc = options.dbc.as_ref().and_then(|(file, text)| {
        hash.add("dbc", text.as_bytes());
        CanDatabase::parse(text).map_err(|e| report.diagnostics.push(findings::dbc(file, &e))).ok()
    });
    let (bus, lacking) = bus::decode(&recording, dbc.as_ref(), &frames);
    let motion = motion::at_frames(&recording.pose, &frames);
    let (tracks, radar_rows) = radar::tracks(&recording.radar, &frames, &motion);
    if let Some(rows) = radar_rows {
        report.tables.push(rows);
    }

    let mut missing = vec!["map".to_owned(), "object classes and sizes".into(), "traffic lights".into()];
    missing.extend(lacking);
    missing.push("weather and surface".into());
    let route = name_of_route(segments);
    let id = options.drive_id.clone().unwrap_or_else(|| drive_id(&route));
    report.drive_id = Some(id.clone());
    report.frames = count;
    report.duration_s = (count - 1) as f64 / FRAME_RATE_HZ;
    report.tracks = tracks.len();
    report.missing = missing.clone();
    Some(Drive {
        meta: DriveMeta {
            drive_id: id,
            format: "comma2k19".into(),
            source: route.split(['|', '_']).next().unwrap_or_default().to_owned(),
            place: None,
            map_ref: None,
            licence: Some("MIT".into()),
            frame_of_reference: FrameOfReference::World,
            content_hash: hash.finish(),
            video: Vec::new(),
            sensors: vec!["radar".into()],
            can: true,
            missing,
        },
        times,
        ego: Some(Ego {
            length_m: motion::EGO_LENGTH_M,
            width_m: motion::EGO_WIDTH_M,
            height_m: motion::EGO_HEIGHT_M,
            reference_to_centre_m: motion::CAMERA_TO_CENTRE_M,
            motion,
            bus,
        }),
        tracks,
        map: None,
        lights: None,
        context: None,
        media: None,
    })
}

/// `dongle|time_firstsegment`, as the folders name it.
fn name_of_route(segments: &[PathBuf]) -> String {
    let Some(first) = segments.first() else { return "comma2k19".into() };
    let absolute = first.canonicalize().unwrap_or_else(|_| first.clone());
    let route = absolute.parent().map(file_label).unwrap_or_default();
    format!("{route}_{}", file_label(first))
}
