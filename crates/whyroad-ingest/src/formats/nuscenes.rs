//! nuScenes (Caesar et al. 2020): the published JSON tables, with the CAN bus expansion and the map expansion where
//! they lie beside them. One scene is one drive.
//!
//! Objects are annotated at keyframes, 2 Hz. In between they are interpolated as the devkit does (place linearly,
//! heading the shorter way), never over more than 0.6 s; velocities are the devkit's `box_velocity` (central difference
//! over the neighboring keyframes), interpolated likewise. **What an object does within half a second is not in the
//! set**: its accelerations are smooth, and a short brake of another car cannot be seen. The ego's poses are the
//! lidar's, 20 Hz. Not read: radar and lidar points, attributes, visibility bins, the scene's description.

mod bus;
pub(crate) mod findings;
mod map;
mod tables;

use crate::adapter::{Adapter, DriveSink, FilesInMemory, FormatAbout, Located, Source};
use crate::assemble::frames::{Sample, Sampled, every_tenth};
use crate::assemble::licences;
use crate::assemble::resample::{MAX_GAP_S as MAX_POSE_GAP_S, linear};
use crate::assemble::se3::{self, Se3};
use crate::encodings::input::Folder;
use crate::options::{LICENCE, Options};
use crate::report::{RowCount, SourceReport};
use crate::source::{ContentHash, drive_id, find_folders, implausible_span, impossible_speeds, resampled};
use bus::BusReading;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use tables::{Annotation, SceneTables, TableError};
use whyroad_model::road_map::Point3;
use whyroad_model::scene::{DriveMeta, Ego, EgoBus, GeoPosition, MediaFrame, Motion, Track};
use whyroad_model::{Drive, Nanos, Need, ObjectClass, RoadMap};

/// Scenes of one set that are read together: the full set has 850; reading 50 at a time goes through its tables 17
/// times and holds the rows of 50.
const SCENES_TOGETHER: usize = 50;
/// Raised when the adapter makes something else of the same files, so that drives in a lake are replaced.
const REVISION: u32 = 5;
/// Keyframes are 0.5 s apart; over more nothing is interpolated, s.
const MAX_GAP_S: f64 = 0.6;
/// The devkit's limit for a velocity between two keyframes, s; twice that over both neighbors.
const MAX_VELOCITY_SPAN_S: f64 = 1.5;
/// The recording cars are Renault Zoe: 4.084 x 1.730 x 1.562 m (maker's data sheet). The pose is the rear axle's; the
/// overhang behind it is 0.657 m, so that the middle of the car is 1.385 m ahead of it.
const EGO_SIZE_M: [f64; 3] = [4.084, 1.730, 1.562];
const AXLE_TO_CENTER_M: f64 = 1.385;

/// nuScenes scenes.
pub struct NuScenes;

impl Adapter for NuScenes {
    fn about(&self) -> &'static FormatAbout {
        const {
            &FormatAbout {
                name: "nuscenes",
                summary: "nuScenes: a folder with the JSON tables; CAN bus and map expansions beside it",
                example: "nuscenes path/to/v1.0-mini --lake lake",
                options: &[LICENCE],
                codes: findings::CODES,
            }
        }
    }

    fn find(&self, path: &Path) -> Vec<Located> {
        let scenes = find_scenes(path).into_iter();
        scenes.map(|(path, index)| Located { path, part: Some(index) }).collect()
    }

    fn companions(&self, set: &Path) -> Vec<PathBuf> {
        let root = set.parent().unwrap_or(set);
        let inside = |dir: PathBuf| fs::read_dir(dir).into_iter().flatten().flatten().map(|e| e.path());
        inside(root.join("can_bus")).chain(inside(root.join("maps/expansion"))).collect()
    }

    fn read_files(&self, files: &FilesInMemory, options: &Options, drives: &mut DriveSink<'_>) {
        let all = Folder::Memory(files);
        let set = Set { tables: all, can_bus: all, maps: all, label: "memory".to_owned() };
        read_set(&set, &[0], options, &mut |drive, report| drives.put((drive, report)));
    }

    fn read(&self, source: &Source, options: &Options, drives: &mut DriveSink<'_>) {
        drives.put(read(&source.path, source.part.unwrap_or(0), options));
    }

    fn batch_size(&self) -> usize {
        SCENES_TOGETHER
    }

    fn read_batch(&self, sources: &[Source], options: &Options, drives: &mut DriveSink<'_>) {
        let Some(first) = sources.first() else { return };
        let indices: Vec<u64> = sources.iter().map(|s| s.part.unwrap_or(0)).collect();
        read_several(&first.path, &indices, options, &mut |drive, report| drives.put((drive, report)));
    }
}

/// Scenes at or below `path`: the folder with the tables (`v1.0-mini`, ...) and the scene's place in `scene.json`.
pub fn find_scenes(path: &Path) -> Vec<(PathBuf, u64)> {
    let is_set = |dir: &Path| {
        ["scene", "sample", "sample_annotation"].iter().all(|t| dir.join(format!("{t}.json")).is_file())
    };
    let mut out = Vec::new();
    for set in find_folders(path, is_set) {
        // A list of scenes that cannot be read is one source, whose reading says why.
        let n = tables::scene_count(Folder::Disk(&set)).unwrap_or(1);
        out.extend((0..n).map(|i| (set.clone(), i)));
    }
    out
}

/// Reads one scene. `None` when there is nothing that could be kept; the report says why.
pub fn read(set: &Path, index: u64, options: &Options) -> (Option<Drive>, SourceReport) {
    let mut one = None;
    read_several(set, &[index], options, &mut |drive, report| one = Some((drive, report)));
    one.unwrap_or_else(|| (None, report(set, index)))
}

/// Reads several scenes of a set in one pass over its tables (the whole set's are gigabytes of JSON, whatever scene is
/// wanted) and hands over each, in the order of `indices`. Rows of all of them are held meanwhile: some 3 MB per scene.
pub fn read_several(
    set: &Path,
    indices: &[u64],
    options: &Options,
    each: &mut dyn FnMut(Option<Drive>, SourceReport),
) {
    let root = set.parent().unwrap_or(set);
    let (can_bus, maps) = (root.join("can_bus"), root.join("maps/expansion"));
    let set = Set {
        tables: Folder::Disk(set),
        can_bus: Folder::Disk(&can_bus),
        maps: Folder::Disk(&maps),
        label: set.display().to_string(),
    };
    read_set(&set, indices, options, each);
}

/// The folders of a set, and its name in messages.
struct Set<'a> {
    tables: Folder<'a>,
    can_bus: Folder<'a>,
    maps: Folder<'a>,
    label: String,
}

fn read_set(
    set: &Set<'_>,
    indices: &[u64],
    options: &Options,
    each: &mut dyn FnMut(Option<Drive>, SourceReport),
) {
    let scenes = match tables::read(set.tables, indices) {
        Ok(scenes) => scenes,
        Err(e) => indices.iter().map(|_| Err(e.clone())).collect(),
    };
    for (&index, tables) in indices.iter().zip(scenes) {
        let mut report = SourceReport::new(format!("{}#{index}", set.label));
        let drive = match tables {
            Ok(t) => drive(set, &t, options, &mut report),
            Err(e) => {
                report.diagnostics.push(findings::table(&set.label, &e));
                None
            }
        };
        each(drive, report);
    }
}

fn report(set: &Path, index: u64) -> SourceReport {
    SourceReport::new(format!("{}#{index}", set.display()))
}

fn drive(set: &Set<'_>, t: &SceneTables, options: &Options, report: &mut SourceReport) -> Option<Drive> {
    let label = format!("{}/{}", set.label, t.scene.name);
    let zero = t.samples.values().min().copied().unwrap_or(0);
    let seconds = |us: i64| us.saturating_sub(zero) as f64 / 1e6;
    let mut keyframes: Vec<f64> = t.samples.values().map(|&us| seconds(us)).collect();
    keyframes.sort_by(f64::total_cmp);
    if let Some(d) = implausible_span(&label, 0.0, keyframes.last().copied().unwrap_or(0.0), keyframes.len())
    {
        report.diagnostics.push(d);
        return None;
    }
    let Some(start) = zero.checked_mul(1000) else {
        let reason = "a timestamp does not fit into 64 bits of nanoseconds".to_owned();
        report.diagnostics.push(findings::table(&set.label, &TableError { table: "sample", reason }));
        return None;
    };
    let mut frames = every_tenth(&keyframes);
    let poses = ego_poses(t, zero, report);
    // Where the ego is missing there are no frames: the last keyframe may be later than the last pose.
    let mut there = linear(&poses.times, &poses.times, &frames, MAX_POSE_GAP_S).into_iter();
    frames.retain(|_| there.next().is_some_and(f64::is_finite));
    if frames.len() < 2 || t.poses.len() < 2 {
        report.diagnostics.push(findings::empty(&label));
        return None;
    }
    report.diagnostics.push(resampled(&label, keyframes[1] - keyframes[0]));
    let (motion, known_at) = (poses.motion_at(&frames, MAX_POSE_GAP_S), poses.lags(&frames));
    let tracks = tracks(t, &frames, zero, &label, report);
    let mut hash = ContentHash::new("nuscenes", REVISION);
    add_rows(&mut hash, t);
    let BusReading { bus, files, broken } = bus::read(set.can_bus, &t.scene.name, zero, &frames);
    report.diagnostics.extend(broken.iter().map(|name| findings::bus(&set.can_bus.label(name))));
    files.iter().for_each(|(name, bytes)| hash.add(name, bytes));
    let map = city_map(set.maps, &t.log.location, &motion, &mut hash, report);
    let media = media(t);
    let can = !bus.speed_mps.is_empty() || !bus.steering.is_empty();
    let missing = Need::absent([
        (map.is_none(), Need::Map),
        (true, Need::TrafficLights),
        (!can, Need::VehicleBus),
        (true, Need::WeatherAndSurface),
        (media.is_empty(), Need::CameraPictures),
    ]);
    let cameras: BTreeSet<&str> = media.iter().map(|m| m.camera.as_str()).collect();
    Some(Drive {
        meta: DriveMeta {
            drive_id: options.drive_id.clone().unwrap_or_else(|| drive_id(&t.scene.name)),
            format: "nuscenes".into(),
            source: t.log.vehicle.clone(),
            session: Some(t.log.token.clone()).filter(|s| !s.is_empty()),
            vehicle: Some(t.log.vehicle.clone()).filter(|v| !v.is_empty()),
            place: Some(t.log.location.clone()).filter(|l| !l.is_empty()),
            map_ref: map.as_ref().map(|_| t.log.location.clone()),
            licence: options.licence().or_else(|| Some(licences::NUSCENES.into())),
            content_hash: hash.finish(),
            video: cameras.into_iter().map(str::to_owned).collect(),
            can,
            missing,
            position: map_origin(&t.log.location),
            ..DriveMeta::default()
        },
        times: frames.iter().map(|&s| Nanos(start).plus_secs(s)).collect(),
        ego: Some(Ego { known_at, ..ego(motion, bus) }),
        tracks,
        map,
        lights: None,
        context: None,
        media: (!media.is_empty()).then_some(media),
    })
}

/// Everything in the tables that the drive is made from, in an order that does not depend on the tables'.
fn add_rows(hash: &mut ContentHash, t: &SceneTables) {
    let number = |v: f64| v.to_le_bytes();
    hash.add("scene", t.scene.token.as_bytes());
    for p in &t.poses {
        let values: Vec<u8> = p.translation.iter().chain(&p.rotation).flat_map(|v| number(*v)).collect();
        hash.add(&p.timestamp.to_string(), &values);
    }
    let mut rows: Vec<&Annotation> = t.annotations.iter().collect();
    rows.sort_by_key(|a| (t.samples.get(&a.sample_token), a.instance_token.as_str()));
    for a in rows {
        let values = a.translation.iter().chain(&a.size).chain(&a.rotation).chain(&a.num_lidar_pts);
        let category = t.categories.get(&a.instance_token).map_or("", String::as_str);
        let bytes: Vec<u8> = values.flat_map(|v| number(*v)).chain(category.bytes()).collect();
        hash.add(&format!("{} {}", a.sample_token, a.instance_token), &bytes);
    }
    let mut pictures: Vec<&str> = t.data.iter().map(|d| d.filename.as_str()).collect();
    pictures.sort_unstable();
    pictures.iter().for_each(|p| hash.add("data", p.as_bytes()));
}

/// The poses of the ego at their own times.
fn ego_poses(t: &SceneTables, zero: i64, report: &mut SourceReport) -> Sampled {
    let mut count = RowCount::new("ego_pose");
    let mut sampled = Sampled::default();
    for p in &t.poses {
        count.read += 1;
        let finite = p.translation.iter().all(|v| v.is_finite());
        match se3::unit(p.rotation).filter(|_| finite) {
            Some(q) => {
                let pose = Se3 { q, t: p.translation };
                let center = pose.apply([AXLE_TO_CENTER_M, 0.0, EGO_SIZE_M[2] / 2.0]);
                count.keep("pose", 1);
                sampled.push(Sample {
                    time: p.timestamp.saturating_sub(zero) as f64 / 1e6,
                    position: center,
                    heading: se3::heading(q),
                    velocity: [f64::NAN; 2],
                    size: EGO_SIZE_M,
                    ..Sample::UNKNOWN
                });
            }
            None => count.drop_rows("invalid", 1),
        }
    }
    report.tables.push(count);
    sampled
}

fn ego(motion: Motion, bus: EgoBus) -> Ego {
    let [length_m, width_m, height_m] = EGO_SIZE_M;
    Ego {
        length_m,
        width_m,
        height_m,
        reference_to_centre_m: AXLE_TO_CENTER_M,
        motion,
        bus,
        ..Ego::default()
    }
}

/// Our class for a category of nuScenes (23 of the detection set and `static_object`); `None` for others.
pub(crate) fn class_of(category: &str) -> Option<ObjectClass> {
    Some(match category {
        "vehicle.car" => ObjectClass::Car,
        "vehicle.truck" | "vehicle.trailer" => ObjectClass::Truck,
        "vehicle.bus.bendy" | "vehicle.bus.rigid" => ObjectClass::Bus,
        "vehicle.construction" => ObjectClass::LargeVehicle,
        "vehicle.emergency.police" | "vehicle.emergency.ambulance" => ObjectClass::EmergencyVehicle,
        "vehicle.motorcycle" => ObjectClass::Motorcycle,
        "vehicle.bicycle" => ObjectClass::Bicycle,
        "human.pedestrian.adult"
        | "human.pedestrian.child"
        | "human.pedestrian.construction_worker"
        | "human.pedestrian.police_officer" => ObjectClass::Pedestrian,
        "human.pedestrian.personal_mobility"
        | "human.pedestrian.stroller"
        | "human.pedestrian.wheelchair" => ObjectClass::WheeledPedestrian,
        "animal" => ObjectClass::Animal,
        "movable_object.trafficcone" => ObjectClass::Cone,
        "movable_object.barrier" => ObjectClass::Barrier,
        "movable_object.debris" | "movable_object.pushable_pullable" | "static_object.bicycle_rack" => {
            ObjectClass::StaticObject
        }
        _ => return None,
    })
}

fn tracks(t: &SceneTables, frames: &[f64], zero: i64, label: &str, report: &mut SourceReport) -> Vec<Track> {
    let mut count = RowCount::new("annotations");
    let mut objects: BTreeMap<&str, BTreeMap<i64, Sample>> = BTreeMap::new();
    let mut invalid = None;
    for a in &t.annotations {
        count.read += 1;
        let time = t.samples.get(&a.sample_token).copied().unwrap_or(zero);
        let numbers = a.translation.iter().chain(&a.size).all(|v| v.is_finite());
        let Some(q) = se3::unit(a.rotation).filter(|_| numbers) else {
            count.drop_rows("invalid", 1);
            invalid.get_or_insert_with(|| {
                format!("{} at {}: rotation {:?}", a.instance_token, a.sample_token, a.rotation)
            });
            continue;
        };
        let [width, length, height] = a.size;
        let sample = Sample {
            time: time.saturating_sub(zero) as f64 / 1e6,
            position: a.translation,
            heading: se3::heading(q),
            velocity: [f64::NAN; 2],
            size: [length, width, height],
            points: a.num_lidar_pts.unwrap_or(f64::NAN),
            ..Sample::UNKNOWN
        };
        if objects.entry(&a.instance_token).or_default().insert(time, sample).is_some() {
            count.drop_rows("duplicate", 1);
            invalid.get_or_insert_with(|| format!("{} twice at {}", a.instance_token, a.sample_token));
        } else {
            count.keep("track", 1);
        }
    }
    let (mut out, mut unknown, mut impossible) = (Vec::new(), BTreeSet::new(), BTreeMap::new());
    for (id, samples) in objects {
        let category = t.categories.get(id).map_or("", String::as_str);
        let class = class_of(category).unwrap_or_else(|| {
            unknown.insert(category);
            ObjectClass::Unknown
        });
        let mut sampled = Sampled::default();
        with_velocities(samples.into_values().collect()).into_iter().for_each(|s| sampled.push(s));
        let (track, rows) = sampled.track_at(id, class, category, frames, MAX_GAP_S);
        if rows > 0 {
            impossible.insert(id.to_owned(), rows);
        }
        if !track.frames.is_empty() {
            out.push(track);
        }
    }
    if count.dropped_total() > 0 {
        report.diagnostics.push(findings::annotations(label, &count, &invalid.unwrap_or_default()));
    }
    if !unknown.is_empty() {
        report
            .diagnostics
            .push(findings::category(label, &unknown.into_iter().collect::<Vec<_>>().join(", ")));
    }
    report.diagnostics.extend(impossible_speeds(label, &impossible));
    report.tables.push(count);
    out
}

/// The devkit's `box_velocity`: difference between the keyframes before and after; at an end, to the one neighbor.
fn with_velocities(mut samples: Vec<Sample>) -> Vec<Sample> {
    let velocities: Vec<[f64; 2]> = (0..samples.len())
        .map(|i| {
            let (a, b) = (samples[i.saturating_sub(1)], samples[(i + 1).min(samples.len() - 1)]);
            let (span, inside) = (b.time - a.time, i > 0 && i + 1 < samples.len());
            let limit = if inside { 2.0 * MAX_VELOCITY_SPAN_S } else { MAX_VELOCITY_SPAN_S };
            if span > 0.0 && span <= limit {
                [0, 1].map(|k| (b.position[k] - a.position[k]) / span)
            } else {
                [f64::NAN; 2]
            }
        })
        .collect();
    samples.iter_mut().zip(velocities).for_each(|(s, v)| s.velocity = v);
    samples
}

/// Where the south-west corner of a city's map lies, from which x runs east and y north (nuscenes-devkit,
/// `export_poses.py`).
fn map_origin(location: &str) -> Option<GeoPosition> {
    let (latitude_deg, longitude_deg) = match location {
        "boston-seaport" => (42.336_849_169_438_615, -71.057_853_698_730_47),
        "singapore-onenorth" => (1.288_210_086_874_372_4, 103.784_751_892_089_84),
        "singapore-hollandvillage" => (1.299_365_232_178_095_7, 103.782_176_971_435_55),
        "singapore-queenstown" => (1.278_256_224_022_318_8, 103.767_414_093_017_58),
        _ => return None,
    };
    Some(GeoPosition { latitude_deg, longitude_deg })
}

fn city_map(
    maps: Folder<'_>,
    location: &str,
    motion: &Motion,
    hash: &mut ContentHash,
    report: &mut SourceReport,
) -> Option<RoadMap> {
    let name = format!("{location}.json");
    let text = maps.file(&name)?.bytes().ok()?;
    let label = maps.label(&name);
    hash.add("map", &text);
    let places: Vec<Point3> = (0..motion.len())
        .map(|i| Point3 { x: motion.x[i], y: motion.y[i], z: 0.0 })
        .filter(|p| p.x.is_finite())
        .collect();
    match map::read(&text, &places) {
        Ok(built) => {
            report.diagnostics.extend(
                built.invalid_example.as_ref().map(|e| findings::map_invalid(&label, &built.count, e)),
            );
            report.tables.push(built.count);
            Some(built.map)
        }
        Err(reason) => {
            report.diagnostics.push(findings::map_unreadable(&label, &reason));
            None
        }
    }
}

/// Camera pictures, by names and times.
fn media(t: &SceneTables) -> Vec<MediaFrame> {
    let mut out: Vec<MediaFrame> = t
        .data
        .iter()
        .filter_map(|d| {
            let camera = d.filename.split('/').find(|part| part.starts_with("CAM_"))?;
            Some(MediaFrame {
                camera: camera.to_owned(),
                time: Nanos(d.timestamp.checked_mul(1000)?),
                uri: d.filename.clone(),
                index: 0,
            })
        })
        .collect();
    out.sort_by(|a, b| (&a.camera, a.time, &a.uri).cmp(&(&b.camera, b.time, &b.uri)));
    out.dedup_by(|b, a| a.camera == b.camera && a.time == b.time);
    out
}
