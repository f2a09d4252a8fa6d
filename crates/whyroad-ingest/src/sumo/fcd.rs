//! Floating car data: `<fcd-export><timestep time=".."><vehicle ../><person ../></timestep></fcd-export>`.

use super::vehicle_types::IsPerson;
use super::xml::{Tag, for_each_tag};
use crate::kinematics::wrap_angle;
use crate::report::RowCount;
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::path::Path;

/// One object at one time, as FCD states it but for units: positions are still the front bumper's centre.
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
    /// Bits of SUMO's `signals`.
    pub signals: Option<u32>,
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
    let mut fcd = Fcd { count: RowCount::new("fcd"), ..Fcd::default() };
    let mut step: Option<i64> = None;
    let mut is_fcd = false;
    let end = for_each_tag(path, |tag| match tag {
        Tag::Open(e) => match e.name() {
            "fcd-export" => is_fcd = true,
            "timestep" => {
                let time = e.number("time").map(|s| (s * 1e9).round() as i64);
                // Time that stands still or runs backwards cannot be a step of its own.
                step = time.filter(|t| fcd.steps.last().is_none_or(|last| t > last));
                fcd.steps.extend(step);
            }
            kind @ ("vehicle" | "person" | "container") => {
                fcd.count.read += 1;
                let Some(time) = step else {
                    fcd.count.drop_rows("out_of_order", 1);
                    return;
                };
                // Whoever rides in something has no box of its own on the road; containers are freight.
                if kind == "container"
                    || (kind == "person" && e.get("vehicle").is_some_and(|v| !v.is_empty()))
                {
                    fcd.count.set_aside("carried", 1);
                    return;
                }
                let id = e.text("id").unwrap_or_default();
                let (Some(x), Some(y), Some(angle), false) =
                    (e.number("x"), e.number("y"), e.number("angle"), id.is_empty())
                else {
                    fcd.count.drop_rows("invalid", 1);
                    fcd.invalid_example
                        .get_or_insert_with(|| format!("{kind} '{id}' at {} s", time as f64 / 1e9));
                    return;
                };
                let sample = Sample {
                    time,
                    x,
                    y,
                    z: e.number("z").unwrap_or(0.0),
                    heading: wrap_angle(FRAC_PI_2 - angle.to_radians()),
                    speed: e.number("speed").unwrap_or(f64::NAN),
                    accel: e.number("acceleration").unwrap_or(f64::NAN),
                    signals: e.get("signals").and_then(|s| s.trim().parse().ok()),
                };
                let object = fcd.objects.entry(id).or_insert_with(|| Object {
                    is_person: if kind == "person" { IsPerson::Yes } else { IsPerson::No },
                    type_id: e.text("type").unwrap_or_default(),
                    samples: Vec::new(),
                });
                if object.samples.last().is_some_and(|s| s.time == time) {
                    fcd.count.drop_rows("duplicate", 1);
                } else {
                    object.samples.push(sample);
                }
            }
            _ => {}
        },
        Tag::Close("timestep") => step = None,
        Tag::Close(_) => {}
    });
    match end {
        _ if !is_fcd => Err(end.err().unwrap_or_else(|| "it has no <fcd-export>".to_owned())),
        Ok(()) => Ok(fcd),
        Err(reason) => {
            fcd.broken = Some(reason);
            Ok(fcd)
        }
    }
}
