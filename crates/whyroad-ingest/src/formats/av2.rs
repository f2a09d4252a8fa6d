//! AV2 sensor logs (Argoverse 2, Wilson et al. 2021): cuboid tracks at 10 Hz in the ego frame, ego poses at about
//! 170 Hz in a city frame, a vector map. Tracks are brought to the city frame and differentiated there.
//!
//! Times are AV2's nanoseconds unchanged (a GPS-like clock whose epoch reads as 1980). Frames are the times that have
//! an annotation; a log of another rate is brought to 10 Hz. Not read: lidar sweeps, and camera pictures beyond their
//! names and times.

mod annotations;
mod classes;
pub(crate) mod ego_box;
pub(crate) mod findings;
mod map;
pub(crate) mod map_file;
mod pose;

use crate::adapter::{Adapter, DriveSink, FormatAbout, Located, Source, whole};
use crate::assemble::frames::{Frames, resample_track};
use crate::assemble::licences;
use crate::assemble::plausibility::forget_impossible;
use crate::assemble::se3::{self, Se3};
use crate::encodings::feather;
use crate::file_reader::{FileReader, finish_map};
use crate::options::Options;
use crate::report::SourceReport;
use crate::source::{
    ContentHash, SEARCH_DEPTH, entries, file_label, implausible_span, impossible_speeds, resampled,
};
use annotations::{Annotations, Cuboid};
use ego_box::EgoBox;
use map_file::{map_file, read_map};
use pose::PoseTrack;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use whyroad_model::scene::{DriveMeta, Ego, FrameOfReference, MediaFrame, Motion, Track};
use whyroad_model::{Drive, DriveId, Nanos, Need, TrackId};

/// Raised when the adapter makes something else of the same files, so that drives in a lake are replaced.
const REVISION: u32 = 4;
/// A longer gap between two annotations of an object stays a gap, s, where the log is not at 10 Hz.
const MAX_GAP_S: f64 = 0.6;
const ANNOTATIONS: [&str; 2] = ["annotations_with_ego.feather", "annotations.feather"];
const POSE: &str = "city_SE3_egovehicle.feather";

/// Argoverse 2 sensor logs.
pub struct Av2;

impl Adapter for Av2 {
    fn about(&self) -> &'static FormatAbout {
        const {
            &FormatAbout {
                name: "av2",
                summary: "Argoverse 2 sensor logs: a folder with annotations.feather, poses and a map",
                example: "av2 path/to/sensor_logs --lake lake",
                options: &[],
                codes: findings::CODES,
            }
        }
    }

    fn find(&self, path: &Path) -> Vec<Located> {
        if path.is_dir() { whole(find_logs(path)) } else { Vec::new() }
    }

    fn read(&self, source: &Source, options: &Options, drives: &mut DriveSink<'_>) {
        drives.put(read(&source.path, options.drive_id.as_ref()));
    }
}

/// Log folders at or below `path`, sorted. A folder is a log when it has annotations, poses or a map of its own.
pub fn find_logs(path: &Path) -> Vec<PathBuf> {
    fn search(dir: &Path, depth: usize, out: &mut Vec<PathBuf>) {
        if is_log(dir) {
            out.push(dir.to_owned());
            return;
        }
        if depth == 0 {
            return;
        }
        // A folder that has only the name of a log: an interrupted download. It is reported, not skipped.
        let is_empty = |dir: &Path| fs::read_dir(dir).is_ok_and(|mut entries| entries.next().is_none());
        for path in entries(dir).filter(|path| path.is_dir()) {
            if is_uuid(&path) && is_empty(&path) {
                out.push(path);
            } else {
                search(&path, depth - 1, out);
            }
        }
    }
    let mut out = Vec::new();
    search(path, SEARCH_DEPTH, &mut out);
    out.sort();
    out
}

fn is_log(dir: &Path) -> bool {
    ANNOTATIONS.iter().chain([&POSE]).any(|f| dir.join(f).is_file()) || map_file(&dir.join("map")).is_some()
}

fn is_uuid(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.len() == 36 && name.bytes().all(|b| b.is_ascii_hexdigit() || b == b'-')
}

/// Reads one log folder. `None` when there is nothing that could be kept; the report says why.
pub fn read(dir: &Path, drive_id: Option<&DriveId>) -> (Option<Drive>, SourceReport) {
    let mut report = SourceReport::new(dir.display().to_string());
    let drive = read_log(dir, drive_id, &mut report);
    (drive, report)
}

fn read_log(dir: &Path, drive_id: Option<&DriveId>, report: &mut SourceReport) -> Option<Drive> {
    let mut hash = ContentHash::new("av2", REVISION);
    let Some(file) = ANNOTATIONS.iter().map(|f| dir.join(f)).find(|p| p.is_file()) else {
        report.diagnostics.push(findings::log_missing(&dir.display().to_string()));
        return None;
    };
    let label = file.display().to_string();
    let table = read_feather(&file, &mut hash, report)?;
    let mut rows = match annotations::read(&table.columns) {
        Ok(rows) => rows,
        Err(reason) => {
            report.diagnostics.push(findings::unreadable(&label, &reason));
            return None;
        }
    };
    if rows.objects.is_empty() && rows.ego.is_empty() {
        report.diagnostics.extend(findings::of_rows(&label, &rows, &BTreeMap::new()));
        // A file of which nothing could be read has already been reported.
        if table.truncated.is_none() {
            report.diagnostics.push(findings::log_empty(&label));
        }
        report.tables.push(rows.count);
        return None;
    }

    let mut missing: Vec<Need> = Vec::new();
    let poses = read_poses(dir, &mut hash, report);
    let (mut road, map_ref) = read_map(&dir.join("map"), &mut hash, report);
    // Stop signs are annotated like all other objects: a log without any has none near the road.
    if let Some(map) = &mut road {
        map.complete_for.push("stop".to_owned());
    }
    let times: BTreeSet<i64> = rows.objects.iter().chain(&rows.ego).map(|c| c.time).collect();
    let posed: BTreeMap<i64, Se3> =
        poses.iter().flat_map(|p| times.iter().filter_map(|&t| Some((t, p.at(t)?)))).collect();
    let annotated = times.len();
    // A pose file that covers no frame counts as missing.
    let with_pose = !posed.is_empty();
    let times: Vec<i64> =
        if with_pose { posed.keys().copied().collect() } else { times.into_iter().collect() };
    if !with_pose {
        missing.push(Need::EgoPose);
        if let Some(file) = poses.as_ref().map(|_| dir.join(POSE).display().to_string()) {
            report.diagnostics.push(findings::pose_elsewhere(&file, annotated));
        }
    }
    let first = times.first().copied().unwrap_or_default();
    let seconds: Vec<f64> = times.iter().map(|t| t.saturating_sub(first) as f64 / 1e9).collect();
    if let Some(d) = implausible_span(&label, 0.0, seconds.last().copied().unwrap_or(0.0), seconds.len()) {
        report.diagnostics.push(d);
        return None;
    }
    if road.is_none() {
        missing.push(Need::Map);
    }
    if !rows.has_points {
        missing.push(Need::LidarPointsInBoxes);
    }
    missing.extend([Need::TrafficLights, Need::VehicleBus, Need::WeatherAndSurface]);
    let media = camera_frames(dir);
    if media.is_empty() {
        missing.push(Need::CameraPictures);
    }

    if with_pose && times.len() < annotated {
        drop_uncovered(&mut rows, &posed, dir, report);
    }
    let (ego_box, at_axle) = match rows.ego.first() {
        Some(row) => ego_box::from_row(row.size, row.t),
        None => (ego_box::FORD_FUSION, false),
    };
    if at_axle {
        report.diagnostics.push(findings::box_at_axle(&label));
    }
    let mut posed: Vec<Se3> = posed.into_values().collect();
    let mut unknown_categories = BTreeMap::new();
    let mut tracks = tracks(&rows, &times, &posed, &mut unknown_categories, &label, report);
    let frames = Frames::of(&seconds);
    let is_resampled = frames.resampled() && seconds.len() >= 2;
    let mut times = times;
    if is_resampled {
        report.diagnostics.push(resampled(&label, frames.native_step_s));
        let gap = MAX_GAP_S.max(1.5 * frames.native_step_s);
        let time = |s: &f64| first.saturating_add((s * 1e9).round() as i64);
        let pose = |s: &f64| if with_pose { poses.as_ref()?.at(time(s)).map(Some) } else { Some(None) };
        let (grid, of_grid): (Vec<f64>, Vec<Option<Se3>>) =
            frames.seconds.iter().filter_map(|s| Some((*s, pose(s)?))).unzip();
        tracks = tracks.iter().map(|t| resample_track(t, &seconds, &grid, gap)).collect();
        tracks.retain(|t| !t.frames.is_empty());
        times = grid.iter().map(time).collect();
        posed = of_grid.into_iter().flatten().collect();
    }
    let mut ego = with_pose.then(|| ego(&posed, ego_box));
    if is_resampled {
        let lags: Vec<Nanos> =
            times.iter().map(|&t| Nanos(poses.as_ref().map_or(0, |poses| poses.lag(t)))).collect();
        state_lags(&lags, ego.as_mut(), &mut []);
    } else if let Some(poses) = &poses {
        let lags: Vec<Nanos> = times.iter().map(|&t| Nanos(poses.lag(t))).collect();
        state_lags(&lags, ego.as_mut(), &mut tracks);
    }
    rows.count.keep("track", rows.objects.len());
    report.diagnostics.extend(findings::of_rows(&label, &rows, &unknown_categories));
    report.tables.insert(0, rows.count);

    let video: BTreeSet<String> = media.iter().map(|m| m.camera.clone()).collect();
    let meta = DriveMeta {
        drive_id: drive_id.cloned().unwrap_or_else(|| crate::source::drive_id(&file_label(dir))),
        format: "av2".into(),
        source: "av2".into(),
        place: map_ref.as_deref().and_then(city).map(str::to_owned),
        map_ref,
        licence: Some(licences::ARGOVERSE_2.into()),
        frame_of_reference: if with_pose { FrameOfReference::World } else { FrameOfReference::Ego },
        content_hash: hash.finish(),
        video: video.into_iter().collect(),
        // The boxes' point counts come from the lidar, whether or not its sweeps are here.
        sensors: if rows.has_points { vec!["lidar".into()] } else { Vec::new() },
        can: false,
        missing,
        ..DriveMeta::default()
    };
    Some(Drive {
        meta,
        times: times.into_iter().map(Nanos).collect(),
        ego,
        tracks,
        map: road,
        lights: None,
        context: None,
        media: (!media.is_empty()).then_some(media),
    })
}

fn read_feather(file: &Path, hash: &mut ContentHash, report: &mut SourceReport) -> Option<feather::Feather> {
    let label = file.display().to_string();
    let read = fs::read(file).map_err(|e| e.to_string()).and_then(|bytes| {
        hash.add(&file_label(file), &bytes);
        feather::read(&bytes)
    });
    match read {
        Ok(f) => {
            if let Some(reason) = &f.truncated {
                report.diagnostics.push(findings::truncated(&label, f.columns.rows(), reason));
            }
            Some(f)
        }
        Err(reason) => {
            report.diagnostics.push(findings::unreadable(&label, &reason));
            None
        }
    }
}

fn read_poses(dir: &Path, hash: &mut ContentHash, report: &mut SourceReport) -> Option<PoseTrack> {
    let file = dir.join(POSE);
    if !file.is_file() {
        report.diagnostics.push(findings::pose_missing(&dir.display().to_string()));
        return None;
    }
    let label = file.display().to_string();
    let table = read_feather(&file, hash, report)?;
    // Nothing readable before the cut: the message about the cut is enough.
    if table.truncated.is_some() && table.columns.rows() == 0 {
        return None;
    }
    match pose::read(&table.columns) {
        Ok((poses, count, backward)) => {
            if count.dropped_total() > 0 {
                report.diagnostics.push(findings::pose_invalid(&label, count.dropped_total()));
            }
            if backward {
                report.diagnostics.push(findings::pose_backward(&label));
            }
            report.tables.push(count);
            Some(poses)
        }
        Err(reason) => {
            report.diagnostics.push(findings::unreadable(&label, &reason));
            None
        }
    }
}

/// City in a map reference such as `PIT_city_47896` (the six cities of AV2, by AV2's codes).
fn city(map_ref: &str) -> Option<&'static str> {
    match map_ref.split('_').next()? {
        "ATX" => Some("Austin"),
        "DTW" => Some("Detroit"),
        "MIA" => Some("Miami"),
        "PAO" => Some("Palo Alto"),
        "PIT" => Some("Pittsburgh"),
        "WDC" => Some("Washington, DC"),
        _ => None,
    }
}

/// Rows of frames without an ego pose cannot be placed in the city: they are dropped and counted.
fn drop_uncovered(rows: &mut Annotations, posed: &BTreeMap<i64, Se3>, dir: &Path, report: &mut SourceReport) {
    let mut frames = BTreeSet::new();
    let mut keep = |c: &Cuboid| {
        let covered = posed.contains_key(&c.time);
        if !covered {
            frames.insert(c.time);
        }
        covered
    };
    let before = (rows.objects.len(), rows.ego.len());
    rows.objects.retain(&mut keep);
    rows.ego.retain(&mut keep);
    let ego_lost = before.1 - rows.ego.len();
    let lost = before.0 - rows.objects.len() + ego_lost;
    if lost > 0 {
        rows.count.drop_rows("no_pose", lost);
        rows.count.kept.insert("ego", rows.ego.len());
        report.diagnostics.push(findings::pose_uncovered(
            &dir.join(POSE).display().to_string(),
            frames.len(),
            lost,
        ));
    }
}

fn ego(posed: &[Se3], shape: EgoBox) -> Ego {
    let mut motion = Motion::unknown(posed.len());
    for (i, pose) in posed.iter().enumerate() {
        let center = pose.apply(shape.center);
        (motion.x[i], motion.y[i], motion.z[i]) = (center[0], center[1], center[2]);
        motion.heading[i] = se3::heading(pose.q);
    }
    Ego {
        length_m: shape.length_m,
        width_m: shape.width_m,
        height_m: shape.height_m,
        reference_to_centre_m: shape.center[0],
        motion,
        ..Ego::default()
    }
}

/// `times` of the frames; `posed` is where the ego was in them, empty where that is not known.
fn tracks(
    rows: &Annotations,
    times: &[i64],
    posed: &[Se3],
    unknown_categories: &mut BTreeMap<String, usize>,
    label: &str,
    report: &mut SourceReport,
) -> Vec<Track> {
    let mut by_track: Vec<Vec<&Cuboid>> = vec![Vec::new(); rows.tracks.len()];
    for c in &rows.objects {
        by_track[c.track].push(c);
    }
    let mut by_id: Vec<(&str, Vec<&Cuboid>)> = rows.tracks.iter().map(String::as_str).zip(by_track).collect();
    by_id.retain(|(_, cuboids)| !cuboids.is_empty());
    by_id.sort_by_key(|(id, _)| *id);
    let classes: Vec<_> = rows.categories.iter().map(|name| classes::class_of(name)).collect();
    let mut impossible = BTreeMap::new();
    let tracks = by_id
        .into_iter()
        .map(|(id, mut cuboids)| {
            cuboids.sort_by_key(|c| c.time);
            let mut stated = Vec::with_capacity(cuboids.len());
            for c in &cuboids {
                let category = rows.categories[c.category].as_str();
                let class = classes[c.category].unwrap_or_else(|| {
                    *unknown_categories.entry(category.to_owned()).or_default() += 1;
                    Default::default()
                });
                stated.push((class, category));
            }
            let mut track = Track::default();
            track.state_classes(stated);
            let class = track.class;
            let mut motion = Motion::unknown(cuboids.len());
            let frames = frames_of(&cuboids, times);
            for (i, (c, &frame)) in cuboids.iter().zip(&frames).enumerate() {
                let (p, q) = match posed.get(frame as usize) {
                    Some(pose) => (pose.apply(c.t), se3::compose(pose.q, c.q)),
                    None => (c.t, c.q),
                };
                (motion.x[i], motion.y[i], motion.z[i]) = (p[0], p[1], p[2]);
                motion.heading[i] = se3::heading(q);
            }
            // In the ego's frame a step is relative to a moving car.
            if !posed.is_empty() {
                let seconds: Vec<f64> =
                    cuboids.iter().map(|c| c.time.saturating_sub(times[0]) as f64 / 1e9).collect();
                let rows = forget_impossible(class, &seconds, &mut motion);
                if rows > 0 {
                    impossible.insert(id.to_owned(), rows);
                }
            }
            Track {
                id: TrackId::from(id),
                frames,
                motion,
                length_m: cuboids.iter().map(|c| c.size[0]).collect(),
                width_m: cuboids.iter().map(|c| c.size[1]).collect(),
                height_m: cuboids.iter().map(|c| c.size[2]).collect(),
                interior_points: cuboids.iter().map(|c| c.points).collect(),
                ..track
            }
        })
        .collect();
    report.diagnostics.extend(impossible_speeds(label, &impossible));
    tracks
}

/// Frames of the cuboids of a track, ascending, one per cuboid.
fn frames_of(cuboids: &[&Cuboid], times: &[i64]) -> Vec<u32> {
    let mut frame = 0;
    let of = |c: &&Cuboid| {
        while times.get(frame).is_some_and(|t| *t < c.time) {
            frame += 1;
        }
        frame as u32
    };
    cuboids.iter().map(of).collect()
}

/// States how much later than their frames rows were known that were placed by a pose between two of the log's.
fn state_lags(lags: &[Nanos], ego: Option<&mut Ego>, tracks: &mut [Track]) {
    if lags.iter().all(|lag| lag.0 == 0) {
        return;
    }
    ego.into_iter().for_each(|e| e.known_at = lags.to_vec());
    for track in tracks {
        track.known_at = track.frames.iter().map(|&f| lags[f as usize]).collect();
    }
}

/// Names and times of camera pictures, where the log has them: `sensors/cameras/<camera>/<timestamp_ns>.jpg`.
fn camera_frames(dir: &Path) -> Vec<MediaFrame> {
    let list = |p: &Path| -> Vec<String> {
        let Ok(entries) = fs::read_dir(p) else { return Vec::new() };
        entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect()
    };
    let root = dir.join("sensors").join("cameras");
    let mut frames: Vec<MediaFrame> = Vec::new();
    for camera in list(&root) {
        for name in list(&root.join(&camera)) {
            let Some(time) = name.strip_suffix(".jpg").and_then(|t| t.parse().ok()) else { continue };
            let uri = format!("sensors/cameras/{camera}/{name}");
            frames.push(MediaFrame { camera: camera.clone(), time: Nanos(time), uri, index: 0 });
        }
    }
    frames.sort_by(|a, b| (&a.camera, a.time).cmp(&(&b.camera, b.time)));
    frames
}

/// For [`crate::readers`].
pub(crate) const READERS: &[FileReader] = &[
    FileReader {
        name: "av2-annotations",
        read: |bytes| {
            let Ok(Ok(rows)) = feather::read(bytes).map(|f| annotations::read(&f.columns)) else {
                return false;
            };
            let (mut unknown, mut report) = (BTreeMap::new(), SourceReport::new("annotations".to_owned()));
            let times: BTreeSet<i64> = rows.objects.iter().map(|c| c.time).collect();
            let times: Vec<i64> = times.into_iter().collect();
            let posed = vec![Se3 { q: [1.0, 0.0, 0.0, 0.0], t: [0.0; 3] }; times.len()];
            drop(tracks(&rows, &times, &posed, &mut unknown, "annotations", &mut report));
            drop(findings::of_rows("annotations", &rows, &unknown));
            !times.is_empty()
        },
    },
    FileReader {
        name: "av2-poses",
        read: |bytes| {
            let Ok(Ok((poses, ..))) = feather::read(bytes).map(|f| pose::read(&f.columns)) else {
                return false;
            };
            for time in [T0, T0 + 50_000_000, T0 + 100_000_000, 0, i64::MIN, i64::MAX] {
                let _ = poses.at(time).map(|_| poses.lag(time));
            }
            poses.at(T0).is_some()
        },
    },
    FileReader {
        name: "av2-map",
        read: |bytes| {
            let Ok(Ok(reading)) = std::str::from_utf8(bytes).map(map::read) else { return false };
            drop(findings::of_map("map", &reading));
            finish_map(reading.map)
        },
    },
];

/// A time in the logs of AV2, ns.
const T0: i64 = 315_966_253_660_357_000;
