//! SUMO simulations: floating car data (`--fcd-output`, XML or gzip) with the network as map, one vehicle as ego.
//!
//! FCD places vehicles by the centre of their front bumper and turns them clockwise from north in degrees; scene
//! tables want box centres and radians from x. A person's place is taken as its centre (its front is at most half a
//! body's depth away). A vehicle's speed along its heading is the simulator's own, its sideways speed comes from
//! positions; a person's motion comes from positions altogether, because a person moved by script is not where
//! its speed says. Times are `start` plus simulated time.

mod fcd;
pub(crate) mod findings;
mod frames;
mod lights;
mod net;
mod vehicle_types;
mod xml;

use crate::kinematics::{self, MAX_GAP_S, wrap_angle};
use crate::plausibility::forget_impossible;
use crate::report::SourceReport;
use crate::run::Options;
use crate::source::{ContentHash, drive_id, file_label, impossible_speeds};
use fcd::{Fcd, Object, Sample};
use frames::Cadence;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::{fs, io};
use vehicle_types::{IsPerson, VehicleType, VehicleTypes};
use whyroad_model::scene::{DriveMeta, Ego, EgoBus, FrameOfReference, LightState, Motion, Track, TurnSignal};
use whyroad_model::{Drive, Nanos, RoadMap, TrackId};

/// Raised when the adapter makes something else of the same files, so that drives in a lake are replaced.
const REVISION: u32 = 1;
/// A sideways step of more than this in 0.1 s is a jump, not a motion, m.
const MAX_SIDE_STEP_M: f64 = 1.0;

/// FCD files at or below `path`, sorted: files whose name says `fcd` and `.xml`, or `path` itself when it is a file.
pub fn find_simulations(path: &Path) -> io::Result<Vec<PathBuf>> {
    fn search(dir: &Path, depth: usize, out: &mut Vec<PathBuf>) -> io::Result<()> {
        for entry in fs::read_dir(dir)? {
            let path = entry?.path();
            if path.is_dir() && depth > 0 {
                search(&path, depth - 1, out)?;
            } else if path.is_file() && is_named(&path, "fcd") {
                out.push(path);
            }
        }
        Ok(())
    }
    if path.is_file() {
        let xml = file_label(path);
        return Ok(if xml.ends_with(".xml") || xml.ends_with(".xml.gz") {
            vec![path.to_owned()]
        } else {
            Vec::new()
        });
    }
    let mut out = Vec::new();
    search(path, 3, &mut out)?;
    out.sort();
    Ok(out)
}

/// `...fcd....xml`, `...net.xml.gz` and the like.
fn is_named(path: &Path, word: &str) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let stem = name.strip_suffix(".gz").unwrap_or(&name);
    stem.strip_suffix(".xml").is_some_and(|s| s.split(['.', '_', '-']).any(|part| part == word))
}

/// Files beside `fcd`, and in the folder above, that are named `word`.
fn beside(fcd: &Path, words: &[&str]) -> Vec<PathBuf> {
    let near = fcd.parent().into_iter().chain(fcd.parent().and_then(Path::parent));
    let mut out = Vec::new();
    for dir in near {
        let Ok(entries) = fs::read_dir(dir) else { continue };
        let mut here: Vec<PathBuf> = entries
            .flatten()
            .map(|e| e.path())
            .filter(|p| p.is_file() && words.iter().any(|w| is_named(p, w)))
            .collect();
        here.sort();
        out.extend(here);
    }
    out
}

/// Reads one simulation. `None` when there is nothing that could be kept; the report says why.
pub fn read(path: &Path, options: &Options) -> (Option<Drive>, SourceReport) {
    let mut report = SourceReport::new(path.display().to_string());
    let drive = read_simulation(path, options, &mut report);
    (drive, report)
}

fn read_simulation(path: &Path, options: &Options, report: &mut SourceReport) -> Option<Drive> {
    let label = path.display().to_string();
    let mut hash = ContentHash::new("sumo", REVISION);
    hash.add("ego", options.ego.as_bytes());
    hash.add("start", &options.start.0.to_le_bytes());
    add_file(&mut hash, path);
    let mut fcd = match fcd::read(path) {
        Ok(fcd) => fcd,
        Err(reason) => {
            report.diagnostics.push(findings::fcd_unreadable(&label, &reason));
            return None;
        }
    };
    if let Some(reason) = &fcd.broken {
        report.diagnostics.push(findings::fcd_broken(&label, reason, fcd.count.read));
    }
    if fcd.count.dropped_total() > 0 {
        let example =
            fcd.invalid_example.clone().unwrap_or_else(|| "a repeated or backward time step".to_owned());
        report.diagnostics.push(findings::fcd_invalid(&label, fcd.count.dropped_total(), &example));
    }
    let Some(ego) = fcd.objects.remove(&options.ego).filter(|o| o.is_person == IsPerson::No) else {
        let some: Vec<&str> = fcd.objects.keys().map(String::as_str).take(8).collect();
        report.diagnostics.push(findings::ego_missing(&label, &options.ego, &some));
        return None;
    };

    let types = read_types(path, options, &mut hash, report);
    let net = read_net(path, options, &mut hash, report);
    let lights = net.as_ref().and_then(|(_, links, _)| read_lights(path, options, links, &mut hash, report));
    let (times, cadence) = frames::frames(&fcd.steps, &ego);
    if let Cadence::Filled(step) = cadence {
        report.diagnostics.push(findings::step(&label, step as f64 / 1e9));
    }
    let mut notes = Notes::default();
    let ego_samples = samples_at(&ego, &times);
    let (ego_type, known) = types.get(&ego.type_id, ego.is_person);
    notes.assume(&ego.type_id, known);
    let ego_state = ego_table(&ego_samples, &ego_type, &mut notes);
    let tracks = tracks(&fcd, &times, &types, &mut notes);
    count_rows(&mut fcd, &ego, &times, cadence);
    report.tables.insert(0, fcd.count);
    if notes.jumps > 0 {
        report.diagnostics.push(findings::lane_jump(&label, notes.jumps, &notes.jump_example));
    }
    if !notes.assumed.is_empty() {
        report.diagnostics.push(findings::type_assumed(&label, &notes.assumed));
    }
    report.diagnostics.extend(impossible_speeds(&label, &notes.impossible));

    let mut missing: Vec<String> = Vec::new();
    for (absent, what) in [
        (net.is_none(), "map"),
        (lights.is_none(), "traffic lights"),
        (ego_state.bus.turn_signal.is_empty(), "vehicle bus"),
        (true, "weather and surface"),
        (true, "camera pictures"),
    ] {
        if absent {
            missing.push(what.to_owned());
        }
    }
    let (map, map_ref) = net.map_or((None, None), |(map, _, name)| (Some(map), Some(name)));
    let meta = DriveMeta {
        drive_id: options
            .drive_id
            .clone()
            .unwrap_or_else(|| drive_id(&format!("{}-{}", run_name(path), options.ego))),
        format: "sumo".into(),
        source: "sumo".into(),
        place: map_ref.clone(),
        map_ref,
        licence: options.licence.clone(),
        frame_of_reference: FrameOfReference::World,
        content_hash: hash.finish(),
        video: Vec::new(),
        sensors: Vec::new(),
        can: !ego_state.bus.turn_signal.is_empty(),
        missing,
    };
    Some(Drive {
        meta,
        times: times.iter().map(|t| options.start + Nanos(*t)).collect(),
        ego: Some(ego_state),
        tracks,
        map,
        lights,
        context: None,
        media: None,
    })
}

/// The name of a run: the file's without its endings, or the folder's when the file is just called `fcd`.
fn run_name(path: &Path) -> String {
    let name = file_label(path);
    let stem = name.trim_end_matches(".gz").trim_end_matches(".xml");
    // `crossroads.fcd.xml` is the run `crossroads`.
    let stem = [".fcd", "_fcd", "-fcd"].iter().find_map(|e| stem.strip_suffix(e)).unwrap_or(stem).to_owned();
    let folder = path.canonicalize().ok().and_then(|p| Some(file_label(p.parent()?)));
    if stem.eq_ignore_ascii_case("fcd") { folder.unwrap_or(stem) } else { stem }
}

fn add_file(hash: &mut ContentHash, path: &Path) {
    // What cannot be read is told of where it is read; here it only makes another hash.
    let mut bytes = Vec::new();
    let _ = fs::File::open(path).and_then(|mut f| f.read_to_end(&mut bytes));
    hash.add(&file_label(path), &bytes);
}

fn read_types(
    fcd: &Path,
    options: &Options,
    hash: &mut ContentHash,
    report: &mut SourceReport,
) -> VehicleTypes {
    let given = !options.types.is_empty();
    let files = if given { options.types.clone() } else { beside(fcd, &["rou", "add"]) };
    let mut types = VehicleTypes::default();
    for file in files {
        add_file(hash, &file);
        if let Err(reason) = types.read(&file) {
            report.diagnostics.push(findings::type_unreadable(&file.display().to_string(), &reason));
        }
    }
    types
}

type NetParts = (RoadMap, Vec<net::LightLink>, String);

fn read_net(
    fcd: &Path,
    options: &Options,
    hash: &mut ContentHash,
    report: &mut SourceReport,
) -> Option<NetParts> {
    let Some(file) = options.net.clone().or_else(|| beside(fcd, &["net"]).into_iter().next()) else {
        report.diagnostics.push(findings::net_missing(&fcd.display().to_string()));
        return None;
    };
    let label = file.display().to_string();
    add_file(hash, &file);
    match net::read(&file) {
        Ok(net) => {
            report.diagnostics.extend(findings::of_net(&label, &net));
            report.tables.push(net.count);
            let name = run_name(&file);
            // `net.xml` in a folder of its own is the folder's network.
            let name = if name == "net" {
                file.canonicalize().ok().and_then(|p| Some(file_label(p.parent()?))).unwrap_or(name)
            } else {
                name
            };
            Some((net.map, net.links, name.trim_end_matches(".net").to_owned()))
        }
        Err(reason) => {
            report.diagnostics.push(findings::net_unreadable(&label, &reason));
            None
        }
    }
}

fn read_lights(
    fcd: &Path,
    options: &Options,
    links: &[net::LightLink],
    hash: &mut ContentHash,
    report: &mut SourceReport,
) -> Option<Vec<LightState>> {
    let file = options
        .lights
        .clone()
        .or_else(|| beside(fcd, &["tls"]).into_iter().find(|p| p.parent() == fcd.parent()))?;
    add_file(hash, &file);
    match lights::read(&file, links, options.start) {
        Ok(states) => Some(states),
        Err(reason) => {
            report.diagnostics.push(findings::lights_unreadable(&file.display().to_string(), &reason));
            None
        }
    }
}

/// What is noticed while objects are brought to frames.
#[derive(Default)]
struct Notes {
    assumed: BTreeMap<String, usize>,
    jumps: usize,
    jump_example: String,
    impossible: BTreeMap<String, usize>,
}

impl Notes {
    fn assume(&mut self, type_id: &str, known: bool) {
        if !known {
            *self.assumed.entry(type_id.to_owned()).or_default() += 1;
        }
    }
}

/// The object's samples at those frames in which it is there: (frame, sample).
fn samples_at(object: &Object, times: &[i64]) -> Vec<(u32, Sample)> {
    let frame = |(i, &t): (usize, &i64)| Some((u32::try_from(i).ok()?, frames::at(&object.samples, t)?));
    times.iter().enumerate().filter_map(frame).collect()
}

/// Motion of the box centre.
fn motion(
    id: &str,
    rows: &[(u32, Sample)],
    shape: &VehicleType,
    is_person: IsPerson,
    notes: &mut Notes,
) -> Motion {
    let back = if is_person == IsPerson::Yes { 0.0 } else { shape.length_m / 2.0 };
    let mut m = Motion::unknown(rows.len());
    for (i, (_, s)) in rows.iter().enumerate() {
        m.heading[i] = s.heading;
        m.x[i] = s.x - back * s.heading.cos();
        m.y[i] = s.y - back * s.heading.sin();
        // SUMO's z is the road's surface.
        m.z[i] = s.z + shape.height_m / 2.0;
    }
    let seconds: Vec<f64> = rows.iter().map(|(_, s)| (s.time - rows[0].1.time) as f64 / 1e9).collect();
    let jumped = |i: usize| is_person == IsPerson::No && side_jump(&rows[i - 1].1, &rows[i].1);
    for i in (1..rows.len()).filter(|&i| jumped(i)) {
        if notes.jumps == 0 {
            notes.jump_example = format!("{id} at {} s", rows[i].1.time as f64 / 1e9);
        }
        notes.jumps += 1;
    }
    let d = kinematics::derive(&seconds, &m.x, &m.y, &m.heading, jumped);
    (m.vx, m.vy, m.accel, m.yaw_rate) = (d.vx, d.vy, d.accel, d.yaw_rate);
    if is_person == IsPerson::No {
        for (i, (_, s)) in rows.iter().enumerate() {
            let (sin, cos) = s.heading.sin_cos();
            if !s.speed.is_nan() {
                let sideways = m.vy[i] * cos - m.vx[i] * sin;
                m.vx[i] = s.speed * cos - sideways * sin;
                m.vy[i] = s.speed * sin + sideways * cos;
            }
            if !s.accel.is_nan() {
                m.accel[i] = s.accel;
            }
        }
    }
    let rows = forget_impossible(shape.class, &mut m);
    if rows > 0 {
        notes.impossible.insert(id.to_owned(), rows);
    }
    m
}

/// True when the front bumper went sideways faster than any vehicle can.
fn side_jump(a: &Sample, b: &Sample) -> bool {
    let dt = (b.time - a.time) as f64 / 1e9;
    if dt > MAX_GAP_S {
        return false;
    }
    let middle = a.heading + wrap_angle(b.heading - a.heading) / 2.0;
    let side = (b.y - a.y) * middle.cos() - (b.x - a.x) * middle.sin();
    side.abs() > MAX_SIDE_STEP_M * (dt / 0.1).max(1.0)
}

/// SUMO's `signals` bits (TraCI documentation, "Signalling"): 1 right, 2 left indicator, 4 hazard, 8 brake light.
fn turn_signal(bits: u32) -> TurnSignal {
    match (bits & 4 != 0, bits & 2 != 0, bits & 1 != 0) {
        (true, _, _) | (_, true, true) => TurnSignal::Hazard,
        (_, true, false) => TurnSignal::Left,
        (_, false, true) => TurnSignal::Right,
        _ => TurnSignal::Off,
    }
}

fn empty_when_never_told<T>(values: Vec<Option<T>>) -> Vec<Option<T>> {
    if values.iter().any(Option::is_some) { values } else { Vec::new() }
}

fn ego_table(rows: &[(u32, Sample)], shape: &VehicleType, notes: &mut Notes) -> Ego {
    let signals = |f: &dyn Fn(u32) -> TurnSignal| rows.iter().map(|(_, s)| s.signals.map(f)).collect();
    Ego {
        length_m: shape.length_m,
        width_m: shape.width_m,
        height_m: shape.height_m,
        reference_to_centre_m: -shape.length_m / 2.0,
        motion: motion("ego", rows, shape, IsPerson::No, notes),
        bus: EgoBus {
            turn_signal: empty_when_never_told(signals(&turn_signal)),
            brake: empty_when_never_told(rows.iter().map(|(_, s)| s.signals.map(|b| b & 8 != 0)).collect()),
            ..EgoBus::default()
        },
    }
}

fn tracks(fcd: &Fcd, times: &[i64], types: &VehicleTypes, notes: &mut Notes) -> Vec<Track> {
    let mut out = Vec::new();
    for (id, object) in &fcd.objects {
        let rows = samples_at(object, times);
        if rows.is_empty() {
            continue;
        }
        let (shape, known) = types.get(&object.type_id, object.is_person);
        notes.assume(&object.type_id, known);
        let n = rows.len();
        let signals = rows.iter().map(|(_, s)| s.signals.map(turn_signal)).collect();
        out.push(Track {
            id: TrackId::from(id.as_str()),
            class: shape.class,
            source_class: format!("{}/{}", shape.vclass, object.type_id),
            frames: rows.iter().map(|r| r.0).collect(),
            motion: motion(id, &rows, &shape, object.is_person, notes),
            length_m: vec![shape.length_m; n],
            width_m: vec![shape.width_m; n],
            height_m: vec![shape.height_m; n],
            interior_points: vec![f64::NAN; n],
            turn_signal: empty_when_never_told(signals),
        });
    }
    out
}

/// Accounts for every row of the file.
fn count_rows(fcd: &mut Fcd, ego: &Object, times: &[i64], cadence: Cadence) {
    let chosen: BTreeSet<i64> = times.iter().copied().collect();
    let (first, last) = (times.first().copied().unwrap_or(0), times.last().copied().unwrap_or(0));
    let own: BTreeSet<i64> = ego.samples.iter().map(|s| s.time).collect();
    let all = fcd.objects.values().map(|o| ("track", o)).chain([("ego", ego)]);
    let mut counts: BTreeMap<(bool, &'static str), usize> = BTreeMap::new();
    for (what, o) in all {
        for s in &o.samples {
            // Interpolated frames are made of every step in their span.
            let used = match cadence {
                Cadence::Filled(_) => first <= s.time && s.time <= last && own.contains(&s.time),
                _ => chosen.contains(&s.time),
            };
            let key = match (used, own.contains(&s.time)) {
                (true, _) => (true, what),
                (false, true) => (false, "between_frames"),
                (false, false) => (false, "ego_away"),
            };
            *counts.entry(key).or_default() += 1;
        }
    }
    for ((kept, key), rows) in counts {
        if kept { fcd.count.keep(key, rows) } else { fcd.count.set_aside(key, rows) }
    }
}
