//! SUMO simulations: floating car data (`--fcd-output`, XML or CSV, plain or compressed) with the network as map, and
//! any vehicles as egos, one drive per ego.
//!
//! FCD places vehicles by the center of their front bumper and turns them clockwise from north in degrees; scene
//! tables want box centers and radians from x. A person's place is taken as its center (its front is at most half a
//! body's depth away). A vehicle's speed along its heading is the simulator's own, its sideways speed comes from
//! positions; a person's motion comes from positions altogether, because a person moved by script is not where
//! its speed says. Times are `start` plus simulated time.

mod border;
mod csv;
mod edge;
mod egos;
mod fcd;
pub(crate) mod findings;
mod frames;
mod inputs;
mod lights;
mod naming;
mod net;
mod objects;
mod on_net;
mod options;
mod ramps;
mod roundabouts;
mod sensing;
mod shapes;
mod vehicle_types;

pub use options::{EGO, EGO_SHARE, LIGHTS, NET, OCCLUSION, SEED, SENSOR_RANGE, TYPES};

use crate::adapter::{Adapter, DriveSink, FormatAbout, Located, SkipReason, Source, whole};
use crate::assemble::finish::finish;
use crate::encodings::compressed::without_ending;
use crate::file_reader::{FileReader, finish_map};
use crate::options::{DEFAULT_START, Options, START};
use crate::report::{RowCount, SourceReport};
use crate::source::{
    ContentHash, SEARCH_DEPTH, drive_id, entries, file_label, implausible_span, impossible_speeds,
};
use fcd::{Fcd, Object};
use frames::Cadence;
use inputs::{NetParts, add_file, read_lights, read_net, read_types};
use naming::{beside, is_named, run_name};
use net::LightLink;
use objects::{Notes, ego_table, samples_at, tracks};
use sensing::{Occlusion, Sensing, Unseen};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use vehicle_types::{IsPerson, VehicleTypes};
use whyroad_model::scene::{DriveMeta, FrameOfReference, LightState};
use whyroad_model::{Bilingual, Diagnostic, Drive, DriveId, Nanos, Need, RoadMap};

/// Raised when the adapter makes something else of the same files, so that drives in a lake are replaced.
const REVISION: u32 = 8;

/// SUMO simulations.
pub struct Sumo;

impl Adapter for Sumo {
    fn about(&self) -> &'static FormatAbout {
        const {
            &FormatAbout {
                name: "sumo",
                summary: "SUMO simulations: floating car data (FCD) as XML or CSV, with the network",
                example: "sumo path/to/runs --ego ego --lake lake",
                options: options::ALL,
                codes: findings::CODES,
            }
        }
    }

    fn find(&self, path: &Path) -> Vec<Located> {
        whole(find_simulations(path))
    }

    fn companions(&self, source: &Path) -> Vec<PathBuf> {
        beside(source, &["rou", "add", "net", "poly", "tls"])
    }

    fn why_skipped(&self, file: &Path) -> Option<SkipReason> {
        let name = file_label(file).to_lowercase();
        let plain = without_ending(&name);
        (plain.ends_with(".xml") || plain.ends_with(".csv")).then(|| {
            Bilingual::new(
                "XML 或 CSV 文件，名称中没有 fcd，旁边也没有用到它的仿真日志；自有轨迹可按 docs/reference/table-format.zh.md 写成表格",
                "an XML or CSV file without 'fcd' in its name that belongs to no simulation log; tracks of your own are \
                 read as tables (docs/reference/table-format.md)",
            )
        })
    }

    fn read(&self, source: &Source, options: &Options, drives: &mut DriveSink<'_>) {
        read_new(&source.path, options, drives);
    }
}

/// FCD files at or below `path`, sorted: files whose name says `fcd` and `.xml` or `.csv`, or `path` itself when it is
/// a file.
pub fn find_simulations(path: &Path) -> Vec<PathBuf> {
    fn search(dir: &Path, depth: usize, out: &mut Vec<PathBuf>) {
        for path in entries(dir) {
            if path.is_dir() && depth > 0 {
                search(&path, depth - 1, out);
            } else if path.is_file() && (is_named(&path, "fcd", ".xml") || is_named(&path, "fcd", ".csv")) {
                out.push(path);
            }
        }
    }
    if path.is_file() {
        let name = file_label(path).to_lowercase();
        let plain = without_ending(&name);
        // Many programs write CSV; FCD must be declared.
        let is_log = plain.ends_with(".xml") || is_named(path, "fcd", ".csv");
        return if is_log { vec![path.to_owned()] } else { Vec::new() };
    }
    let mut out = Vec::new();
    search(path, SEARCH_DEPTH, &mut out);
    out.sort();
    out
}

/// Reads one simulation as seen from its first ego. `None` when there is nothing that could be kept; the report says
/// why.
pub fn read(path: &Path, options: &Options) -> (Option<Drive>, SourceReport) {
    let mut first = None;
    read_each(path, options, &mut |drive, report| {
        first.get_or_insert((drive, report));
    });
    first.unwrap_or_else(|| (None, SourceReport::new(path.display().to_string())))
}

/// Reads one simulation and hands over a drive with its report for each ego, one at a time: the log is in memory once,
/// drives one by one.
pub fn read_each(path: &Path, options: &Options, each: &mut dyn FnMut(Option<Drive>, SourceReport)) {
    read_new(path, options, &mut DriveSink::new(&|_, _| false, each));
}

/// The same without the drives that the lake holds: these are not made, and are handed over as `None` with a report
/// that names the drive.
fn read_new(path: &Path, options: &Options, drives: &mut DriveSink<'_>) {
    let mut report = SourceReport::new(path.display().to_string());
    let Some(run) = Simulation::read(path, options, &mut report) else { return drives.put((None, report)) };
    let egos = options::egos(options).choose(&run.fcd, &run.types);
    if egos.is_empty() {
        report.diagnostics.push(findings::none_drawn(&run.label));
        return drives.put((None, report));
    }
    let sensing = options::sensing(options);
    for id in &egos {
        // What is wrong with the files is reported once.
        let mut report = std::mem::replace(&mut report, SourceReport::new(run.label.clone()));
        let name = run.drive_id(id, egos.len(), options);
        // A single drive is always made again: its report covers every row.
        if egos.len() > 1 && drives.holds(&name, &run.content_hash(id, sensing)) {
            report.drive_id = Some(name);
            drives.put((None, report));
            continue;
        }
        let drive = run.seen_from(id, egos.len(), options, &mut report);
        drives.put((drive, report));
    }
}

/// The files of a run, read once for all its egos.
struct Simulation {
    label: String,
    name: String,
    fcd: Fcd,
    types: VehicleTypes,
    net: Option<NetParts>,
    lights: Option<Vec<LightState>>,
    /// Rows of the network.
    tables: Vec<RowCount>,
    hash: String,
}

impl Simulation {
    fn read(path: &Path, options: &Options, report: &mut SourceReport) -> Option<Self> {
        let label = path.display().to_string();
        let mut hash = ContentHash::new("sumo", REVISION);
        options.hash_start(&mut hash);
        add_file(&mut hash, path);
        let fcd = match fcd::read(path) {
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
        let types = read_types(path, options, &mut hash, report);
        let net = read_net(path, options, &mut hash, report).filter(|(map, _, name)| {
            let found = on_net::on_net(&fcd, map);
            report.diagnostics.extend(findings::off_net(&label, name, &found));
            !found.is_foreign()
        });
        let lights =
            net.as_ref().and_then(|(_, links, _)| read_lights(path, options, links, &mut hash, report));
        let tables = std::mem::take(&mut report.tables);
        Some(Self { label, name: run_name(path), fcd, types, net, lights, tables, hash: hash.finish() })
    }

    fn content_hash(&self, ego: &str, sensing: Sensing) -> String {
        let mut hash = ContentHash::new("sumo", REVISION);
        hash.add("files", self.hash.as_bytes());
        hash.add("ego", ego.as_bytes());
        let range = sensing.range_m.unwrap_or(f64::INFINITY);
        hash.add("range", &range.to_le_bytes());
        hash.add("occlusion", &[u8::from(sensing.occlusion == Occlusion::ByBoxes)]);
        hash.finish()
    }

    fn drive_id(&self, ego: &str, egos: usize, options: &Options) -> DriveId {
        match &options.drive_id {
            Some(id) if egos == 1 => id.clone(),
            Some(id) => drive_id(&format!("{}-{ego}", id.as_str())),
            None => drive_id(&format!("{}-{ego}", self.name)),
        }
    }

    fn seen_from(
        &self,
        id: &str,
        egos: usize,
        options: &Options,
        report: &mut SourceReport,
    ) -> Option<Drive> {
        let label = &self.label;
        let Some(ego) = self.fcd.objects.get(id).filter(|o| o.is_person == IsPerson::No) else {
            let some: Vec<&str> = self.fcd.objects.keys().map(String::as_str).take(8).collect();
            report.diagnostics.push(findings::ego_missing(label, id, &some));
            return None;
        };
        let seconds = |s: Option<&fcd::Sample>| s.map_or(0.0, |s| s.time as f64 / 1e9);
        if let Some(d) = implausible_span(
            label,
            seconds(ego.samples.first()),
            seconds(ego.samples.last()),
            ego.samples.len(),
        ) {
            report.diagnostics.push(d);
            return None;
        }
        let (times, cadence) = frames::frames(&self.fcd.steps, ego);
        if let Cadence::Filled(step) = cadence {
            report.diagnostics.push(findings::step(label, step as f64 / 1e9));
        }
        let mut notes = Notes::default();
        let ego_samples = samples_at(ego, &times);
        let (ego_type, known) = self.types.get(&ego.type_id, ego.is_person);
        notes.assume(&ego.type_id, known);
        let ego_state = ego_table(&ego_samples, &ego_type, &mut notes);
        let mut tracks = tracks(&self.fcd, id, &times, &self.types, &mut notes);
        let unseen = {
            let map = self.net.as_ref().map(|(map, _, _)| map);
            sensing::apply(options::sensing(options), &ego_state, map, &mut tracks)
        };
        let mut count = self.fcd.count.clone();
        count_rows(&mut count, &self.fcd, id, ego, &times, cadence, unseen);
        report.tables.push(count);
        report.tables.extend(self.tables.iter().cloned());
        report.diagnostics.extend(diagnostics_of(&notes, label));

        let bus = !ego_state.bus.turn_signal.is_empty();
        let missing = Need::absent([
            (self.net.is_none(), Need::Map),
            (self.lights.is_none(), Need::TrafficLights),
            (!bus, Need::VehicleBus),
            (true, Need::WeatherAndSurface),
            (true, Need::CameraPictures),
            (!options.is_set(&START), Need::Date),
        ]);
        let map_ref = self.net.as_ref().map(|(_, _, name)| name.clone());
        let meta = DriveMeta {
            drive_id: self.drive_id(id, egos, options),
            format: "sumo".into(),
            source: "sumo".into(),
            place: map_ref.clone(),
            map_ref,
            licence: options.licence(),
            // Egos of one simulation see the same traffic at the same time.
            session: Some(self.name.clone()),
            frame_of_reference: FrameOfReference::World,
            content_hash: self.content_hash(id, options::sensing(options)),
            video: Vec::new(),
            sensors: Vec::new(),
            can: bus,
            missing,
            ..DriveMeta::default()
        };
        Some(Drive {
            meta,
            times: times.iter().map(|t| options.start() + Nanos(*t)).collect(),
            ego: Some(ego_state),
            tracks,
            map: self.net.as_ref().map(|(map, _, _)| map.clone()),
            lights: self.lights.clone(),
            context: None,
            media: None,
        })
    }
}

fn diagnostics_of(notes: &Notes, label: &str) -> Vec<Diagnostic> {
    let mut out = Vec::new();
    if notes.jumps > 0 {
        out.push(findings::lane_jump(label, notes.jumps, &notes.jump_example));
    }
    if !notes.assumed.is_empty() {
        out.push(findings::type_assumed(label, &notes.assumed));
    }
    out.extend(impossible_speeds(label, &notes.impossible));
    out
}

/// Accounts for every row of the file.
fn count_rows(
    count: &mut RowCount,
    fcd: &Fcd,
    id: &str,
    ego: &Object,
    times: &[i64],
    cadence: Cadence,
    unseen: Unseen,
) {
    let chosen: BTreeSet<i64> = times.iter().copied().collect();
    let (first, last) = (times.first().copied().unwrap_or(0), times.last().copied().unwrap_or(0));
    let own: BTreeSet<i64> = ego.samples.iter().map(|s| s.time).collect();
    let all = fcd.objects.iter().map(|(k, o)| (if k == id { "ego" } else { "track" }, o));
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
    // Interpolated rows are not rows of the file; otherwise each row taken out of a track is one.
    if !matches!(cadence, Cadence::Filled(_)) {
        for (key, rows) in [("out_of_range", unseen.out_of_range), ("hidden", unseen.hidden)] {
            if let Some(tracks) = counts.get_mut(&(true, "track")) {
                *tracks = tracks.saturating_sub(rows);
            }
            count.set_aside(key, rows);
        }
    }
    for ((kept, key), rows) in counts {
        if kept { count.keep(key, rows) } else { count.set_aside(key, rows) }
    }
}

/// For [`crate::readers`].
pub(crate) const READERS: &[FileReader] = &[
    FileReader { name: "sumo-fcd", read: |bytes| see(fcd::read_xml(bytes.into())) },
    FileReader { name: "sumo-fcd-csv", read: |bytes| see(fcd::read_csv(bytes.into())) },
    FileReader {
        name: "sumo-net",
        read: |bytes| {
            let Ok(net) = net::read(bytes.into()) else { return false };
            drop(findings::of_net("net", &net));
            finish_map(net.map)
        },
    },
    FileReader { name: "sumo-types", read: |bytes| VehicleTypes::default().read(bytes.into()).is_ok() },
    FileReader {
        name: "sumo-lights",
        read: |bytes| {
            let link = |index| LightLink {
                tls: "J".to_owned(),
                index,
                lane: format!("in_{index}"),
                to_lane: "out_0".to_owned(),
            };
            let states = lights::read(bytes.into(), &[link(0), link(1)], DEFAULT_START);
            states.is_ok_and(|states| !states.is_empty())
        },
    },
    FileReader {
        name: "sumo-shapes",
        read: |bytes| {
            let (mut map, mut count) = (RoadMap::default(), RowCount::new("shapes"));
            let end = shapes::read(bytes.into(), &mut map, &mut count);
            finish_map(map);
            end.is_ok() && count.kept_total() > 0
        },
    },
];

/// Makes the drive of the first vehicle.
fn see(fcd: Result<Fcd, String>) -> bool {
    let Ok(fcd) = fcd else { return false };
    let (label, name, hash) = ("fcd".to_owned(), "fcd".to_owned(), String::new());
    let (types, tables) = (VehicleTypes::default(), Vec::new());
    let Some(ego) = fcd.objects.keys().next().cloned() else { return false };
    let run = Simulation { label, name, fcd, types, net: None, lights: None, tables, hash };
    let mut report = SourceReport::new("fcd".to_owned());
    let drive = run.seen_from(&ego, 1, &Options::default(), &mut report);
    drive.map(|mut drive| finish(&mut drive)).is_some()
}
