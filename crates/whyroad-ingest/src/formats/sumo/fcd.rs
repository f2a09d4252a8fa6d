//! Floating car data: `<fcd-export><timestep time=".."><vehicle ../><person ../></timestep></fcd-export>`, or the same
//! attributes as CSV.

use super::csv::for_each_row;
use super::vehicle_types::IsPerson;
use crate::assemble::angles::wrap_angle;
use crate::encodings::compressed::without_ending;
use crate::encodings::input::Input;
use crate::encodings::xml::{Tag, for_each_tag};
use crate::report::RowCount;
use crate::source::file_label;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::path::Path;

/// One object at one time, as FCD states it except for units: positions are still the front bumper's center.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Simulated time, ns.
    pub time: i64,
    pub x: f64,
    pub y: f64,
    pub z: f64,
    /// rad, counter-clockwise from x (FCD: degrees, clockwise from north).
    pub heading: f64,
    /// m/s; NaN when not written.
    pub speed: f64,
    /// m/s2; NaN when not written.
    pub accel: f64,
    /// How much later the sample is from which this one was interpolated, ns; 0 for the log's own.
    pub lag: i64,
    /// Bits of SUMO's `signals`.
    pub signals: Option<u32>,
    /// The generic parameter `whyroad.aeb` (`--fcd-output.params whyroad.aeb`): emergency braking is active.
    pub aeb: Option<bool>,
}

/// Everything of one object.
#[derive(Clone, Debug)]
pub(super) struct Object {
    pub is_person: IsPerson,
    pub type_id: String,
    /// By ascending time.
    pub samples: Vec<Sample>,
}

/// A whole file.
#[derive(Default)]
pub(super) struct Fcd {
    pub objects: BTreeMap<String, Object>,
    /// Times of all time steps, ns, ascending.
    pub steps: Vec<i64>,
    pub count: RowCount,
    pub invalid_example: Option<String>,
    /// Where and why reading stopped before the end.
    pub broken: Option<String>,
}

/// Reads the file as far as it can be read. `Err` when it is not FCD.
pub(super) fn read(path: &Path) -> Result<Fcd, String> {
    let is_csv = without_ending(&file_label(path).to_lowercase()).ends_with(".csv");
    if is_csv { read_csv(path.into()) } else { read_xml(path.into()) }
}

/// The same of CSV.
pub(super) fn read_csv(input: Input<'_>) -> Result<Fcd, String> {
    let (mut fcd, mut is_fcd) = (Fcd::new(), false);
    let end = for_each_row(input, |row| {
        is_fcd = true;
        // Every row of CSV states its time; rows of one step are adjacent.
        let step = row.get("time").and_then(|t| fcd.step_of_row(nanos(t)));
        if let Some(kind) = row.kind {
            fcd.add(step, kind, |name| row.get(name).map(Cow::Borrowed));
        }
    });
    fcd.ended(is_fcd || end.is_ok(), end)
}

/// The same of XML.
pub(super) fn read_xml(input: Input<'_>) -> Result<Fcd, String> {
    let (mut fcd, mut is_fcd) = (Fcd::new(), false);
    let mut step: Option<i64> = None;
    let end = for_each_tag(input, |tag| match tag {
        Tag::Open(e) => match e.name() {
            "fcd-export" => is_fcd = true,
            "timestep" => step = e.get("time").and_then(|t| fcd.next_step(nanos(&t))),
            kind @ ("vehicle" | "person" | "container") => fcd.add(step, kind, |name| e.get(name)),
            _ => {}
        },
        Tag::Close("timestep") => step = None,
        Tag::Close(_) => {}
    });
    fcd.ended(is_fcd, end)
}

/// Seconds as text to ns; `None` when it is not a number.
fn nanos(seconds: &str) -> Option<i64> {
    seconds.trim().parse().ok().filter(|s: &f64| s.is_finite()).map(|s| (s * 1e9).round() as i64)
}

impl Fcd {
    fn new() -> Self {
        Self { count: RowCount::new("fcd"), ..Self::default() }
    }

    /// What was read, and why reading stopped before the end, if it did.
    fn ended(mut self, is_fcd: bool, end: Result<(), String>) -> Result<Self, String> {
        if !is_fcd {
            return Err(end.err().unwrap_or_else(|| "it has no <fcd-export>".to_owned()));
        }
        self.broken = end.err();
        Ok(self)
    }

    /// Begins a step. Time that stands still or runs backwards cannot be a step of its own.
    fn next_step(&mut self, time: Option<i64>) -> Option<i64> {
        let time = time.filter(|t| self.steps.last().is_none_or(|last| t > last))?;
        self.steps.push(time);
        Some(time)
    }

    fn step_of_row(&mut self, time: Option<i64>) -> Option<i64> {
        if time.is_some() && time.as_ref() == self.steps.last() { time } else { self.next_step(time) }
    }

    /// One row of the log; `get` gives its attributes.
    fn add<'a>(&mut self, step: Option<i64>, kind: &str, get: impl Fn(&str) -> Option<Cow<'a, str>>) {
        self.count.read += 1;
        let number = |name: &str| get(name)?.trim().parse().ok().filter(|v: &f64| v.is_finite());
        let Some(time) = step else {
            self.count.drop_rows("out_of_order", 1);
            return;
        };
        // A person who rides in a vehicle has no box on the road; containers are freight.
        if kind == "container" || (kind == "person" && get("vehicle").is_some_and(|v| !v.is_empty())) {
            self.count.set_aside("carried", 1);
            return;
        }
        let id = get("id").map(Cow::into_owned).unwrap_or_default();
        let (Some(x), Some(y), Some(angle), false) =
            (number("x"), number("y"), number("angle"), id.is_empty())
        else {
            self.count.drop_rows("invalid", 1);
            self.invalid_example.get_or_insert_with(|| format!("{kind} '{id}' at {} s", time as f64 / 1e9));
            return;
        };
        let sample = Sample {
            time,
            x,
            y,
            z: number("z").unwrap_or(0.0),
            heading: wrap_angle(FRAC_PI_2 - angle.to_radians()),
            speed: number("speed").unwrap_or(f64::NAN),
            accel: number("acceleration").unwrap_or(f64::NAN),
            lag: 0,
            signals: get("signals").and_then(|s| s.trim().parse().ok()),
            aeb: get("whyroad.aeb").and_then(|s| match s.trim() {
                "1" | "true" => Some(true),
                "0" | "false" => Some(false),
                _ => None,
            }),
        };
        let object = self.objects.entry(id).or_insert_with(|| Object {
            is_person: if kind == "person" { IsPerson::Yes } else { IsPerson::No },
            type_id: get("type").map(Cow::into_owned).unwrap_or_default(),
            samples: Vec::new(),
        });
        if object.samples.last().is_some_and(|s| s.time == time) {
            self.count.drop_rows("duplicate", 1);
        } else {
            object.samples.push(sample);
        }
    }
}
