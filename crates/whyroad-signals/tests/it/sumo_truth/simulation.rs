//! The simulator's own outputs, read from the files beside the log: vehicles with lane and leader, lane changes,
//! lights, surrogate safety measures. A line-wise reader that is independent of the adapter under test: SUMO writes one
//! element per line.

#![allow(missing_docs, reason = "fields are named as SUMO's documentation names them")]

use flate2::read::GzDecoder;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::PathBuf;
use whyroad_ingest::{DEFAULT_START, Options};
use whyroad_model::{Drive, SignalTable};

/// Simulated time in steps of 0.1 s.
pub type Step = i64;

/// Data of one vehicle at one step.
pub struct Vehicle {
    pub x: f64,
    pub y: f64,
    pub speed: f64,
    /// Clockwise from north.
    pub angle_deg: f64,
    pub lane: String,
    /// Id and gap (m, bumper to bumper: SUMO does not subtract its `minGap` here) of the leader within 100 m.
    pub leader: Option<(String, f64)>,
}

pub struct LaneChange {
    pub vehicle: String,
    pub step: Step,
    /// 1 left, -1 right.
    pub side: i32,
}

/// One encounter as reported by the SSM device of `ego`. Codes: 2 following as follower, 3 as leader, 6 merging as
/// leader, 7 as follower, 10 crossing as leader, 11 as follower, 12 to 17 in and behind the conflict area.
#[derive(Default)]
pub struct Conflict {
    pub ego: String,
    pub foe: String,
    pub steps: Vec<Step>,
    pub types: Vec<u32>,
    pub ttc: Vec<Option<f64>>,
    pub drac: Vec<Option<f64>>,
    /// Step, type, value of the extremes.
    pub min_ttc: Option<(Step, u32, f64)>,
    pub max_drac: Option<(Step, u32, f64)>,
    pub pet: Option<(Step, u32, f64)>,
}

pub struct Simulation {
    pub name: &'static str,
    /// Vehicles with an SSM device, around which the log was recorded.
    pub vehicles: BTreeMap<Step, BTreeMap<String, Vehicle>>,
    pub lane_changes: Vec<LaneChange>,
    pub conflicts: Vec<Conflict>,
    /// State letters by light, each from its step on.
    pub lights: BTreeMap<String, BTreeMap<Step, String>>,
    /// Light and link of each lane inside a junction.
    pub link_of: BTreeMap<String, (String, usize)>,
    /// Last point of each lane.
    pub lane_end: BTreeMap<String, (f64, f64)>,
}

pub const GRID: (&str, &[&str]) = ("grid", &["g18", "g34", "g36", "g44", "g53", "g72"]);
pub const MOTORWAY: (&str, &[&str]) = ("motorway", &["m6", "m10", "m23", "m27", "m30", "m40", "m41"]);

fn folder(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../examples/truth").join(name)
}

fn lines(name: &str, kind: &str) -> Vec<String> {
    let path = folder(name).join(format!("{kind}.xml.gz"));
    let Ok(file) = File::open(&path) else { return Vec::new() };
    let mut text = String::new();
    GzDecoder::new(file).read_to_string(&mut text).expect("the committed file unpacks");
    text.lines().map(str::to_owned).collect()
}

/// The element's name and attributes of a line.
fn element(line: &str) -> (&str, BTreeMap<&str, &str>) {
    let line = line.trim().trim_start_matches('<');
    let name = line.split([' ', '>', '/']).next().unwrap_or("");
    let mut parts = line[name.len()..].split('"');
    let mut found = BTreeMap::new();
    while let (Some(key), Some(value)) = (parts.next(), parts.next()) {
        found.insert(key.trim().trim_end_matches('='), value);
    }
    (name, found)
}

fn step(seconds: &str) -> Step {
    (seconds.parse::<f64>().expect("a time") * 10.0).round() as Step
}

fn number(text: &str) -> f64 {
    text.parse().expect("a number")
}

fn series<T>(text: &str, value: impl Fn(&str) -> T) -> Vec<T> {
    text.split_whitespace().map(value).collect()
}

impl Simulation {
    pub fn read((name, _): (&'static str, &'static [&'static str])) -> Self {
        let mut s = Self {
            name,
            vehicles: BTreeMap::new(),
            lane_changes: Vec::new(),
            conflicts: Vec::new(),
            lights: BTreeMap::new(),
            link_of: BTreeMap::new(),
            lane_end: BTreeMap::new(),
        };
        s.read_vehicles();
        s.read_conflicts();
        s.read_map_and_lights();
        for line in lines(name, "lanechange") {
            if let ("change", a) = element(&line) {
                let side = a["dir"].parse().expect("a direction");
                s.lane_changes.push(LaneChange { vehicle: a["id"].to_owned(), step: step(a["time"]), side });
            }
        }
        s
    }

    fn read_vehicles(&mut self) {
        let mut now = 0;
        for line in lines(self.name, "fcd") {
            match element(&line) {
                ("timestep", a) => now = step(a["time"]),
                ("vehicle", a) => {
                    let leader = (!a["leaderID"].is_empty())
                        .then(|| (a["leaderID"].to_owned(), number(a["leaderGap"])));
                    let v = Vehicle {
                        x: number(a["x"]),
                        y: number(a["y"]),
                        speed: number(a["speed"]),
                        angle_deg: number(a["angle"]),
                        lane: a["lane"].to_owned(),
                        leader,
                    };
                    self.vehicles.entry(now).or_default().insert(a["id"].to_owned(), v);
                }
                _ => {}
            }
        }
    }

    fn read_conflicts(&mut self) {
        let value = |v: &str| (v != "NA").then(|| number(v));
        for line in lines(self.name, "ssm") {
            let (tag, a) = element(&line);
            if tag == "conflict" {
                let (ego, foe) = (a["ego"].to_owned(), a["foe"].to_owned());
                self.conflicts.push(Conflict { ego, foe, ..Conflict::default() });
                continue;
            }
            let Some(c) = self.conflicts.last_mut() else { continue };
            let extreme = || {
                let v = a.get("value").and_then(|v| value(v))?;
                Some((step(a["time"]), a["type"].parse().ok()?, v))
            };
            match tag {
                "timeSpan" => c.steps = series(a["values"], step),
                "typeSpan" => c.types = series(a["values"], |v| v.parse().expect("a code")),
                "TTCSpan" => c.ttc = series(a["values"], value),
                "DRACSpan" => c.drac = series(a["values"], value),
                "minTTC" => c.min_ttc = extreme(),
                "maxDRAC" => c.max_drac = extreme(),
                "PET" => c.pet = extreme(),
                _ => {}
            }
        }
    }

    fn read_map_and_lights(&mut self) {
        for line in lines(self.name, "tls") {
            if let ("tlsState", a) = element(&line) {
                self.lights
                    .entry(a["id"].to_owned())
                    .or_default()
                    .insert(step(a["time"]), a["state"].to_owned());
            }
        }
        for line in lines(self.name, "net") {
            match element(&line) {
                ("lane", a) => {
                    let last = a["shape"].split(' ').next_back().expect("a point");
                    let (x, y) = last.split_once(',').expect("two coordinates");
                    self.lane_end.insert(a["id"].to_owned(), (number(x), number(y)));
                }
                ("connection", a) => {
                    if let (Some(via), Some(light), Some(index)) =
                        (a.get("via"), a.get("tl"), a.get("linkIndex"))
                    {
                        self.link_of.insert(
                            (*via).to_owned(),
                            ((*light).to_owned(), index.parse().expect("an index")),
                        );
                    }
                }
                _ => {}
            }
        }
    }

    pub fn vehicle(&self, step: Step, id: &str) -> Option<&Vehicle> {
        self.vehicles.get(&step)?.get(id)
    }

    /// The same simulation through the adapter and the signals, seen from `ego`.
    pub fn derived(&self, ego: &str) -> Derived {
        let log = folder(self.name).join("fcd.xml.gz");
        let options = Options::default()
            .with(&whyroad_ingest::sumo::EGO, ego)
            .with(&whyroad_ingest::sumo::SENSOR_RANGE, f64::INFINITY);
        let (drive, report) = whyroad_ingest::sumo::read(&log, &options);
        let drive = drive.unwrap_or_else(|| panic!("{ego} is ingested: {:?}", report.diagnostics));
        let table = whyroad_signals::derive(&drive);
        let step_of = |t: &whyroad_model::Nanos| ((t.0 - DEFAULT_START.0) as f64 / 1e8).round() as Step;
        let frames = drive.times.iter().enumerate().map(|(i, t)| (step_of(t), i)).collect();
        Derived { drive, table, frames }
    }
}

/// A drive, its signals, and its frames by step.
pub struct Derived {
    pub drive: Drive,
    pub table: SignalTable,
    pub frames: BTreeMap<Step, usize>,
}

impl Derived {
    /// Row of a target in the target columns.
    pub fn row(&self, id: &str, step: Step) -> Option<usize> {
        let target = self.table.targets.iter().find(|t| t.id.as_str() == id)?;
        target.row(*self.frames.get(&step)?)
    }

    /// A number of a target.
    pub fn target(&self, name: &str, id: &str, step: Step) -> Option<f64> {
        self.table.target_columns.get(name)?.number(self.row(id, step)?)
    }

    /// Id and gap of our lead.
    pub fn lead(&self, step: Step) -> Option<(String, f64)> {
        let frame = *self.frames.get(&step)?;
        let is_lead = self.table.target_columns.get("target.is_lead")?;
        let lead =
            self.table.targets.iter().find(|t| t.row(frame).is_some_and(|r| is_lead.flag(r).is_true()))?;
        Some((lead.id.to_string(), self.target("target.gap", lead.id.as_str(), step)?))
    }
}
