//! The table of a motion forecasting scenario: samples by track, and what is known about the scenario.

use crate::assemble::frames::{Sample, Sampled};
use crate::encodings::columns::Columns;
use crate::report::RowCount;
use std::collections::{BTreeMap, HashSet};
use whyroad_model::scene::FRAME_RATE_HZ;
use whyroad_model::{Nanos, ObjectClass};

/// `track_id` of the recording vehicle.
pub(super) const EGO: &str = "AV";

/// What the parquet file has.
pub(super) struct Scenario {
    /// Object type and samples by track id.
    pub tracks: BTreeMap<String, (String, Sampled)>,
    /// Number of frames.
    pub steps: usize,
    pub start: Option<Nanos>,
    pub city: Option<String>,
    pub map_ref: Option<String>,
    pub count: RowCount,
    /// Description of the first row that could not be used.
    pub invalid_example: Option<String>,
    /// Rows by object type that AV2 does not define.
    pub unknown_types: BTreeMap<String, usize>,
}

impl Scenario {
    pub fn read(table: &Columns) -> Result<Self, String> {
        let (ids, types) = (table.texts("track_id")?, table.texts("object_type")?);
        let steps = table.integers("timestep")?;
        let [x, y, heading, vx, vy] = ["position_x", "position_y", "heading", "velocity_x", "velocity_y"]
            .map(|name| table.numbers(name));
        let (x, y, heading, vx, vy) = (x?, y?, heading?, vx?, vy?);
        let length = table.integers("num_timestamps").ok().and_then(|v| v.into_iter().flatten().next());
        let first_text = |name: &str| table.texts(name).ok().and_then(|v| v.into_iter().flatten().next());
        // Written as floating-point nanoseconds: at this size they are multiples of 64 ns.
        let start = table.numbers("start_timestamp").ok().and_then(|v| v.into_iter().find(|t| t.is_finite()));
        let city = first_text("city");
        let map_id = table.integers("map_id").ok().and_then(|v| v.into_iter().flatten().next());
        let mut out = Self {
            tracks: BTreeMap::new(),
            steps: 0,
            start: start.map(|t| Nanos(t as i64)),
            map_ref: map_id.map(|id| format!("{}_{id}", city.as_deref().unwrap_or("av2"))),
            city,
            count: RowCount { read: ids.len(), ..RowCount::new("scenario") },
            invalid_example: None,
            unknown_types: BTreeMap::new(),
        };
        let mut order: Vec<usize> = (0..ids.len()).collect();
        order.sort_by_key(|&i| steps[i]);
        let mut seen = HashSet::new();
        for i in order {
            let within = |step: i64| step >= 0 && length.is_none_or(|n| step < n);
            let finite = [x[i], y[i], heading[i]].iter().all(|v| v.is_finite());
            let (Some(id), Some(step), true) = (ids[i].as_ref(), steps[i].filter(|&s| within(s)), finite)
            else {
                out.count.drop_rows("invalid", 1);
                out.invalid_example.get_or_insert_with(|| format!("row {}", i + 1));
                continue;
            };
            if !seen.insert((id, step)) {
                out.count.drop_rows("duplicate", 1);
                continue;
            }
            out.count.keep(if id == EGO { "ego" } else { "track" }, 1);
            out.steps = out.steps.max(step as usize + 1);
            let kind = types[i].clone().unwrap_or_default();
            let (_, samples) = out.tracks.entry(id.clone()).or_insert_with(|| (kind, Sampled::default()));
            samples.push(Sample {
                time: step as f64 / FRAME_RATE_HZ,
                position: [x[i], y[i], f64::NAN],
                heading: heading[i],
                velocity: [vx[i], vy[i]],
                size: [f64::NAN; 3],
                ..Sample::UNKNOWN
            });
        }
        for (kind, samples) in out.tracks.values() {
            if class_of(kind).is_none() {
                *out.unknown_types.entry(kind.clone()).or_default() += samples.times.len();
            }
        }
        Ok(out)
    }
}

/// Our class for an object type; `None` for one that AV2 does not define (`ObjectType` of the AV2 API). `background` is
/// what the tracker could not name.
pub(super) fn class_of(kind: &str) -> Option<ObjectClass> {
    Some(match kind {
        "vehicle" => ObjectClass::Vehicle,
        "bus" => ObjectClass::Bus,
        "pedestrian" => ObjectClass::Pedestrian,
        "motorcyclist" => ObjectClass::Motorcyclist,
        "cyclist" => ObjectClass::Bicyclist,
        "riderless_bicycle" => ObjectClass::Bicycle,
        "static" | "construction" => ObjectClass::StaticObject,
        "background" | "unknown" => ObjectClass::Unknown,
        _ => return None,
    })
}
