//! PhysicalAI-AV (nvidia/PhysicalAI-Autonomous-Vehicles on Hugging Face), as it is downloaded: tables and archives by
//! chunk, clips of 20 s. One clip is one drive.
//!
//! Poses are the rig's (rear axle, on the ground) in the rig's frame at the clip's start, and become those of the box
//! center where the vehicle's dimensions are there. The set has no map, lanes, lights, route or bus. Not read: pictures
//! (they are named, and stay where they are), lidar, radar, accelerations and curvature of `egomotion`, which follow
//! from the poses, and month and hour of `data_collection`.

mod camera;
mod egomotion;
mod findings;
mod obstacles;
mod tree;

use crate::adapter::{Adapter, DriveSink, FormatAbout, Located, Source};
use crate::assemble::resample::MAX_GAP_S;
use crate::encodings::columns::{Columns, read_parquet_bytes};
use crate::file_reader::FileReader;
use crate::options::{LICENCE, Options, START};
use crate::report::SourceReport;
use crate::source::{ContentHash, drive_id, find_folders, implausible_span, impossible_speeds, resampled};
use egomotion::PoseTrack;
use obstacles::{Obstacles, class_of};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use tree::{Clip, Tree};
use whyroad_model::scene::{DriveMeta, Ego, Track};
use whyroad_model::{Diagnostic, Drive, Nanos, Need};

/// Raised when the adapter makes something else of the same files, so that drives in a lake are replaced.
const REVISION: u32 = 2;
/// Clips read with one reading of the tree's tables; a chunk has about a hundred.
const CLIPS_TOGETHER: usize = 100;
/// Poses, the better source first.
const EGOMOTION: [&str; 2] = ["egomotion", "egomotion.offline"];
const OBSTACLES: &str = "obstacle.offline";
const DIMENSIONS: &str = "vehicle_dimensions";
/// The set's own agreement: not an SPDX license.
const LICENCE_ID: &str = "LicenseRef-NVIDIA-Autonomous-Vehicle-Dataset";
/// Objects missing for longer than this at an end of the drive are reported, s.
const UNCOVERED_S: f64 = 0.5;

/// PhysicalAI-AV clips.
pub struct PhysicalAiAv;

impl Adapter for PhysicalAiAv {
    fn about(&self) -> &'static FormatAbout {
        const {
            &FormatAbout {
                name: "pai",
                summary: "PhysicalAI-AV: a folder with features.csv, clip_index.parquet and downloaded chunks",
                example: "pai path/to/PhysicalAI-Autonomous-Vehicles --lake lake",
                options: &[START, LICENCE],
                codes: findings::CODES,
            }
        }
    }

    fn find(&self, path: &Path) -> Vec<Located> {
        let is_tree = |dir: &Path| dir.join(tree::FEATURES).is_file() && dir.join(tree::CLIPS).is_file();
        let mut out = Vec::new();
        for root in find_folders(path, is_tree) {
            let parts = match Tree::open(&root) {
                Ok(tree) => downloaded(&tree),
                // One source, whose reading says why.
                Err(_) => vec![0],
            };
            out.extend(parts.into_iter().map(|part| Located { path: root.clone(), part: Some(part) }));
        }
        out
    }

    fn read(&self, source: &Source, options: &Options, drives: &mut DriveSink<'_>) {
        self.read_batch(std::slice::from_ref(source), options, drives);
    }

    fn batch_size(&self) -> usize {
        CLIPS_TOGETHER
    }

    fn read_batch(&self, sources: &[Source], options: &Options, drives: &mut DriveSink<'_>) {
        let Some(first) = sources.first() else { return };
        let parts: Vec<u64> = sources.iter().map(|s| s.part.unwrap_or(0)).collect();
        read_several(&first.path, &parts, options, &mut |drive, report| drives.put((drive, report)));
    }
}

/// Rows of the clip index whose chunk of poses has been downloaded.
fn downloaded(tree: &Tree) -> Vec<u64> {
    let chunks: BTreeSet<i64> = tree.clips.iter().map(|c| c.chunk).collect();
    let here = |chunk: &i64| EGOMOTION.iter().any(|f| tree.chunk_file(f, *chunk).is_some());
    let chunks: BTreeSet<i64> = chunks.into_iter().filter(here).collect();
    (0u64..).zip(&tree.clips).filter(|(_, clip)| chunks.contains(&clip.chunk)).map(|(row, _)| row).collect()
}

/// Reads several clips of a tree, by their rows in the clip index, and hands over each in this order.
pub fn read_several(
    root: &Path,
    rows: &[u64],
    options: &Options,
    each: &mut dyn FnMut(Option<Drive>, SourceReport),
) {
    let mut tree = match Tree::open(root) {
        Ok(tree) => tree,
        Err((file, reason)) => {
            let mut report = SourceReport::new(root.display().to_string());
            report.diagnostics.push(findings::tree(&file.display().to_string(), &reason));
            return each(None, report);
        }
    };
    let clips = std::mem::take(&mut tree.clips);
    for &row in rows {
        let Some(clip) = usize::try_from(row).ok().and_then(|row| clips.get(row)) else { continue };
        let mut report = SourceReport::new(format!("{}#{}", root.display(), clip.id));
        let drive = read_clip(&mut tree, clip, options, &mut report);
        each(drive, report);
    }
}

fn read_clip(tree: &mut Tree, clip: &Clip, options: &Options, report: &mut SourceReport) -> Option<Drive> {
    let label = report.source.clone();
    if clip.is_valid == Some(false) {
        report.diagnostics.push(findings::clip_invalid(&label));
        return None;
    }
    let mut hash = ContentHash::new("pai", REVISION);
    let start = options.start();
    options.hash_start(&mut hash);
    let poses = read_poses(tree, clip, &mut hash, report)?;
    let seconds = |us: i64| us as f64 / 1e6;
    let frames_us = match frames(&poses, &label) {
        Ok(frames) => frames,
        Err(problem) => {
            report.diagnostics.push(*problem);
            return None;
        }
    };
    if frames_us.is_empty() {
        report.diagnostics.push(findings::egomotion_missing(&label));
        return None;
    }
    let mut steps: Vec<i64> = poses.times.windows(2).map(|w| w[1] - w[0]).collect();
    steps.sort_unstable();
    if let Some(step) = steps.get(steps.len() / 2).filter(|s| (**s - egomotion::FRAME_US).abs() > 10_000) {
        report.diagnostics.push(resampled(&label, seconds(*step)));
    }

    let shape = read_dimensions(tree, clip, &mut hash, report);
    let center = shape.map_or([0.0; 3], |s| [s.axle_to_center_m, 0.0, s.height_m / 2.0]);
    let (motion, velocities_agree) = poses.motion(&frames_us, center);
    if !velocities_agree {
        report.diagnostics.push(findings::velocity(&label));
    }
    let frames: Vec<f64> = frames_us.iter().map(|&us| seconds(us)).collect();
    let tracks = read_obstacles(tree, clip, &poses, center, &mut hash, report)
        .map(|obstacles| tracks(obstacles, &frames, &label, report));
    let media = camera::frames(tree, clip, start, &mut hash, report);
    let collection = tree.collection(clip);
    for (name, value) in [("country", &collection.country), ("platform", &collection.platform)] {
        hash.add(name, value.as_deref().unwrap_or_default().as_bytes());
    }
    let missing = Need::absent([
        (tracks.is_none(), Need::Objects),
        (true, Need::LidarPointsInBoxes),
        (shape.is_none(), Need::EgoSize),
        (true, Need::Map),
        (true, Need::TrafficLights),
        (true, Need::VehicleBus),
        (true, Need::Route),
        (true, Need::Routing),
        (true, Need::WeatherAndSurface),
        (media.is_empty(), Need::CameraPictures),
        (!options.is_set(&START), Need::Date),
    ]);
    let cameras: BTreeSet<&str> = media.iter().map(|m| m.camera.as_str()).collect();
    let platform = collection.platform.map_or_else(String::new, |p| format!(" {p}"));
    Some(Drive {
        meta: DriveMeta {
            drive_id: options.drive_id.clone().unwrap_or_else(|| drive_id(&clip.id)),
            format: "pai".into(),
            source: format!("physical-ai-av{platform}"),
            place: collection.country,
            licence: options.licence().or_else(|| Some(LICENCE_ID.into())),
            content_hash: hash.finish(),
            video: cameras.into_iter().map(str::to_owned).collect(),
            missing,
            ..DriveMeta::default()
        },
        times: frames_us.iter().map(|us| Nanos(start.0.saturating_add(us * 1000))).collect(),
        ego: Some(Ego {
            length_m: shape.map_or(f64::NAN, |s| s.length_m),
            width_m: shape.map_or(f64::NAN, |s| s.width_m),
            height_m: shape.map_or(f64::NAN, |s| s.height_m),
            reference_to_centre_m: center[0],
            motion,
            known_at: poses.lags(&frames_us),
            ..Ego::default()
        }),
        tracks: tracks.unwrap_or_default(),
        map: None,
        lights: None,
        context: None,
        media: (!media.is_empty()).then_some(media),
    })
}

/// Times of the frames, us.
fn frames(poses: &PoseTrack, label: &str) -> Result<Vec<i64>, Box<Diagnostic>> {
    let seconds = |us: &i64| *us as f64 / 1e6;
    let ends = poses.times.first().zip(poses.times.last());
    match ends.and_then(|(a, b)| implausible_span(label, seconds(a), seconds(b), poses.times.len())) {
        Some(problem) => Err(Box::new(problem)),
        None => Ok(poses.frames()),
    }
}

/// The best poses that the clip has.
fn read_poses(
    tree: &mut Tree,
    clip: &Clip,
    hash: &mut ContentHash,
    report: &mut SourceReport,
) -> Option<PoseTrack> {
    let label = report.source.clone();
    let before = report.diagnostics.len();
    for feature in EGOMOTION {
        let file = tree.features.get(feature).and_then(|f| f.file_names().into_iter().next());
        let Some(member) = file.and_then(|file| tree.member(feature, &file, clip)) else { continue };
        let read = member.content.and_then(|content| {
            let Some(content) = content else { return Ok(None) };
            hash.add(feature, &content);
            egomotion::read(&read_parquet_bytes(content)?).map(Some)
        });
        match read {
            Ok(Some((poses, count))) => {
                let lost = count.dropped_total();
                if lost > 0 {
                    report.diagnostics.push(findings::egomotion_invalid(&label, lost));
                }
                report.tables.push(count);
                return Some(poses);
            }
            Ok(None) => {}
            Err(reason) => {
                report.diagnostics.push(findings::egomotion_unreadable(&label, &member.uri, &reason));
            }
        }
    }
    if report.diagnostics.len() == before {
        report.diagnostics.push(findings::egomotion_missing(&label));
    }
    None
}

/// The ego's box.
#[derive(Clone, Copy)]
struct Dimensions {
    length_m: f64,
    width_m: f64,
    height_m: f64,
    axle_to_center_m: f64,
}

/// The vehicle's dimensions; `None`, reported, when they are unknown or no sizes.
fn read_dimensions(
    tree: &Tree,
    clip: &Clip,
    hash: &mut ContentHash,
    report: &mut SourceReport,
) -> Option<Dimensions> {
    let read = |(table, row): (Columns, usize)| -> Result<[f64; 4], String> {
        let mut out = [f64::NAN; 4];
        for (value, name) in out.iter_mut().zip(["length", "width", "height", "rear_axle_to_bbox_center"]) {
            *value = table.numbers(name)?.get(row).copied().unwrap_or(f64::NAN);
        }
        Ok(out)
    };
    let row = tree.row(DIMENSIONS, clip).map_err(|(_, reason)| reason);
    let values = row.and_then(|row| row.map(read).transpose());
    let plausible =
        |v: &[f64; 4]| v[..3].iter().all(|v| (0.1..50.0).contains(v)) && (-10.0..10.0).contains(&v[3]);
    let reason = match values {
        Ok(Some(v)) if plausible(&v) => {
            v.iter().for_each(|value| hash.add(DIMENSIONS, &value.to_le_bytes()));
            let [length_m, width_m, height_m, axle_to_center_m] = v;
            return Some(Dimensions { length_m, width_m, height_m, axle_to_center_m });
        }
        Ok(Some(v)) => Some(format!("{v:?}")),
        Ok(None) => None,
        Err(reason) => Some(reason),
    };
    report.diagnostics.push(findings::dimensions(&report.source, reason.as_deref()));
    None
}

/// The clip's objects; `None` when they are unknown.
fn read_obstacles(
    tree: &mut Tree,
    clip: &Clip,
    poses: &PoseTrack,
    center: [f64; 3],
    hash: &mut ContentHash,
    report: &mut SourceReport,
) -> Option<Obstacles> {
    let label = report.source.clone();
    let files = tree.features.get(OBSTACLES).map(|f| f.file_names()).unwrap_or_default();
    for file in files {
        let Some(member) = tree.member(OBSTACLES, &file, clip) else { continue };
        let read = member.content.and_then(|content| {
            let Some(content) = content else { return Ok(None) };
            hash.add(OBSTACLES, &content);
            obstacles::read(&read_parquet_bytes(content)?, poses, center).map(Some)
        });
        match read {
            Ok(Some(obstacles)) => {
                report.diagnostics.extend(findings::of_obstacles(&label, &obstacles));
                report.tables.push(obstacles.count.clone());
                if obstacles.count.kept_total() > 0 {
                    return Some(obstacles);
                }
            }
            Ok(None) => {}
            Err(reason) => {
                report.diagnostics.push(findings::obstacles_unreadable(&label, &member.uri, &reason));
                return None;
            }
        }
    }
    report.diagnostics.push(findings::obstacles_missing(&label));
    None
}

fn tracks(obstacles: Obstacles, frames: &[f64], label: &str, report: &mut SourceReport) -> Vec<Track> {
    if let (Some((first, last)), [begin, .., end]) = (obstacles.span, frames) {
        let uncovered = [first - begin, end - last].into_iter().filter(|s| *s > UNCOVERED_S).sum::<f64>();
        if uncovered > 0.0 {
            report.diagnostics.push(findings::partial(label, uncovered));
        }
    }
    let mut impossible = BTreeMap::new();
    let mut out = Vec::new();
    for (id, (word, samples)) in obstacles.tracks {
        let class = class_of(&word).unwrap_or_default();
        let (track, rows) = samples.track_at(&id, class, &word, frames, MAX_GAP_S);
        if rows > 0 {
            impossible.insert(id, rows);
        }
        if !track.frames.is_empty() {
            out.push(track);
        }
    }
    report.diagnostics.extend(impossible_speeds(label, &impossible));
    out
}

/// For [`crate::readers`].
pub(crate) const READERS: &[FileReader] = &[
    FileReader {
        name: "pai-features",
        read: |bytes| {
            let Ok(features) = tree::features(bytes) else { return false };
            let paths = features.values().map(|feature| (feature.file_names(), feature.chunk_path(7)));
            paths.count() > 0
        },
    },
    FileReader {
        name: "pai-clips",
        read: |bytes| tree::clips(bytes.to_vec()).is_ok() & tree::collection(bytes.to_vec()).is_ok(),
    },
    FileReader {
        name: "pai-egomotion",
        read: |bytes| {
            let poses = read_parquet_bytes(bytes.to_vec()).and_then(|table| egomotion::read(&table));
            let Ok((poses, _)) = poses else { return false };
            let Ok(frames) = frames(&poses, "clip") else { return false };
            drop((poses.motion(&frames, [1.4, 0.0, 0.8]), poses.lags(&frames)));
            !frames.is_empty()
        },
    },
    FileReader {
        name: "pai-obstacles",
        read: |bytes| {
            let poses = PoseTrack::standing(&[0, 100_000, 200_000]);
            let table = read_parquet_bytes(bytes.to_vec());
            let read = table.and_then(|table| obstacles::read(&table, &poses, [1.4, 0.0, 0.8]));
            let Ok(obstacles) = read else { return false };
            drop(findings::of_obstacles("clip", &obstacles));
            let mut report = SourceReport::new("clip".to_owned());
            !tracks(obstacles, &[0.0, 0.1, 0.2], "clip", &mut report).is_empty()
        },
    },
];
