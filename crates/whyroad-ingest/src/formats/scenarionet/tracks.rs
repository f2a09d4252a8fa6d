//! `tracks`: one dict per object, with arrays as long as the scenario.

use crate::assemble::frames::{Sample, Sampled};
use crate::assemble::key_frames::KeyFrames;
use crate::encodings::pickle::Value;
use crate::formats::nuscenes;
use crate::report::RowCount;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::ObjectClass;
use whyroad_model::scene::Track;

/// The objects of a scenario, and what was found on the way.
#[derive(Default)]
pub(super) struct Tracks {
    objects: Vec<(String, String, Sampled)>,
    pub ego: Option<Sampled>,
    /// Filled by [`Tracks::finish`].
    pub tracks: Vec<Track>,
    pub count: RowCount,
    pub impossible: BTreeMap<String, usize>,
    /// Objects that could not be used, with a description of the first.
    pub invalid_example: Option<String>,
    pub unknown_types: BTreeSet<String>,
    /// Rows that were measured, where the rest is interpolated; see [`KeyFrames`].
    pub key_frames: Option<KeyFrames>,
    /// The ego that the metadata name is missing.
    pub ego_missing: Option<String>,
}

/// What an object is: the category of the source, which the conversion of nuScenes keeps in the track's own metadata,
/// if it is one of nuScenes'; else the type of MetaDrive.
fn kind_of(object: Value<'_>) -> String {
    let text = |v: Option<Value<'_>>| v.and_then(|v| v.text()).map(|t| t.into_owned());
    let category = text(object.get("metadata").and_then(|m| m.get("type")));
    category
        .filter(|c| nuscenes::class_of(c).is_some())
        .or_else(|| text(object.get("type")))
        .unwrap_or_default()
}

/// Our class for a category of nuScenes or a type of MetaDrive 0.4; `None` for one that neither defines. A `VEHICLE`
/// may be of any kind.
fn class_of(kind: &str) -> Option<ObjectClass> {
    Some(match kind {
        "VEHICLE" => ObjectClass::Vehicle,
        "PEDESTRIAN" => ObjectClass::Pedestrian,
        "CYCLIST" => ObjectClass::Bicycle,
        "TRAFFIC_CONE" => ObjectClass::Cone,
        "TRAFFIC_BARRIER" => ObjectClass::Barrier,
        "TRAFFIC_OBJECT" | "BUILDING" | "INVISIBLE_WALL" => ObjectClass::StaticObject,
        "OTHER" | "UNSET" => ObjectClass::Unknown,
        category => return nuscenes::class_of(category),
    })
}

impl Tracks {
    /// Reads all objects. `budget` is the number of rows that the file can hold: arrays that many objects share count
    /// for each of them, so that a small file cannot become more rows than memory has.
    pub fn read(all: Value<'_>, times: &[f64], sdc: Option<&str>, budget: usize) -> Self {
        let mut out = Self { count: RowCount::new("states"), ..Self::default() };
        let mut seen = BTreeSet::new();
        for (key, object) in all.entries().into_iter().flatten() {
            let id = key.id().unwrap_or_default();
            let rows = times.len();
            out.count.read += rows;
            let result = if out.count.read > budget {
                Err("more rows than the file has bytes".to_owned())
            } else if id.is_empty() || !seen.insert(id.clone()) {
                Err("no id, or one that another object has".to_owned())
            } else {
                out.object(object, times)
            };
            match result {
                Err(reason) => {
                    out.count.drop_rows("invalid", rows);
                    out.invalid_example.get_or_insert_with(|| format!("{id}: {reason}"));
                }
                Ok(sampled) if sdc == Some(id.as_str()) => {
                    out.count.keep("ego", sampled.times.len());
                    out.ego = Some(sampled);
                }
                Ok(sampled) => {
                    out.count.keep("track", sampled.times.len());
                    out.objects.push((id, kind_of(object), sampled));
                }
            }
        }
        out.take_out_interpolated(times);
        if out.ego.is_none() {
            out.ego_missing = Some(sdc.unwrap_or_default().to_owned());
        }
        out
    }

    fn object(&mut self, object: Value<'_>, times: &[f64]) -> Result<Sampled, String> {
        let state = object.get("state").ok_or("it has no state")?;
        let n = times.len();
        let table = |key: &str| match state.get(key) {
            None => Ok(None),
            Some(v) => match v.rows() {
                Some(rows) if rows.len() == n => Ok(Some(rows)),
                Some(rows) => Err(format!("{key} has {} rows, the scenario {n}", rows.len())),
                None => Err(format!("{key} is not a table of numbers")),
            },
        };
        let at = |rows: &Option<Vec<Vec<f64>>>, i: usize, j: usize| {
            rows.as_ref().and_then(|r| r[i].get(j)).copied().unwrap_or(f64::NAN)
        };
        let position = table("position")?.ok_or("it has no position")?;
        let position = Some(position);
        let (heading, velocity, valid) = (table("heading")?, table("velocity")?, table("valid")?);
        let [length, width, height] = [table("length")?, table("width")?, table("height")?];
        let mut sampled = Sampled::default();
        for (i, &time) in times.iter().enumerate() {
            if valid.is_some() && at(&valid, i, 0) == 0.0 {
                self.count.set_aside("not_observed", 1);
                continue;
            }
            let sample = Sample {
                time,
                position: [0, 1, 2].map(|j| at(&position, i, j)),
                heading: at(&heading, i, 0),
                velocity: [0, 1].map(|j| at(&velocity, i, j)),
                size: [at(&length, i, 0), at(&width, i, 0), at(&height, i, 0)],
                ..Sample::UNKNOWN
            };
            if sample.position[..2].iter().chain([&sample.heading]).all(|v| v.is_finite()) {
                sampled.push(sample);
            } else {
                self.count.drop_rows("invalid", 1);
                self.invalid_example
                    .get_or_insert_with(|| format!("a place or heading at {time} s is not a number"));
            }
        }
        Ok(sampled)
    }

    /// Leaves all heights open: of a set whose poses lie in one plane, where a box's height is the distance of the road
    /// from that plane at the recording car, not the height of the road.
    pub fn forget_heights(&mut self) {
        for object in self.objects.iter_mut().map(|(_, _, o)| o).chain(&mut self.ego) {
            object.z.fill(f64::NAN);
        }
    }

    fn take_out_interpolated(&mut self, times: &[f64]) {
        self.key_frames = KeyFrames::find(self.objects.iter().map(|(_, _, o)| o), times);
        let Some(key_frames) = self.key_frames else { return };
        for object in self.objects.iter_mut().map(|(_, _, o)| o).chain(&mut self.ego) {
            key_frames.keep(object, times);
        }
    }

    /// Brings the objects to frames.
    pub fn finish(&mut self, frames: &[f64], max_gap_s: f64) {
        for (id, kind, sampled) in std::mem::take(&mut self.objects) {
            let class = class_of(&kind).unwrap_or_else(|| {
                self.unknown_types.insert(kind.clone());
                ObjectClass::Unknown
            });
            let (track, impossible) = sampled.track_at(&id, class, &kind, frames, max_gap_s);
            if impossible > 0 {
                self.impossible.insert(id, impossible);
            }
            if !track.frames.is_empty() {
                self.tracks.push(track);
            }
        }
        self.tracks.sort_by(|a, b| a.id.cmp(&b.id));
    }
}
