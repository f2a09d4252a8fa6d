//! ASAM OpenLABEL 1.0: one document per sample with the objects' boxes per frame in the ego frame at t0, the ego's
//! decisions as actions, the critical components as contexts, and their causes as relations.

use super::{Output, SampleWriter};
use crate::DatasetError;
use crate::item::SplitName;
use crate::sample::{Cause, Sample};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// Coordinate system of every box: the ego's reference point at t0, fixed to the ground.
const FRAME: &str = "ego_t0";
/// Coordinate system of the ego's reference point at each frame.
const EGO: &str = "ego";

#[derive(Default)]
pub(super) struct Writer;

impl SampleWriter for Writer {
    fn add(&mut self, sample: Sample, split: SplitName, out: &mut Output) -> Result<(), DatasetError> {
        out.report.records += 1;
        out.json(&format!("{}/{}.json", split.name(), sample.sample_id), &document(&sample))
    }
}

/// Times of all frames, seconds from t0, ascending.
fn times(sample: &Sample) -> Vec<f32> {
    sample.history.t_s.iter().chain(&sample.future.t_s).copied().collect()
}

fn document(sample: &Sample) -> Value {
    let times = times(sample);
    let last = times.len().saturating_sub(1);
    let keyframe = sample.history.t_s.len().saturating_sub(1);
    let whole = json!([{ "frame_start": 0, "frame_end": last }]);
    let at_keyframe = json!([{ "frame_start": keyframe, "frame_end": keyframe }]);
    let (objects, mut frames) = objects(sample, &times);
    for (i, t) in times.iter().enumerate() {
        let frame = frames.entry(i.to_string()).or_insert_with(|| json!({ "objects": {} }));
        frame["frame_properties"] = json!({ "timestamp": t });
        if let Some(pose) = pose(sample, i) {
            let name = format!("{EGO}_to_{FRAME}");
            let transform = json!({ "src": EGO, "dst": FRAME, "transform_src_to_dst": pose });
            frame["frame_properties"]["transforms"] = json!({ name: transform });
        }
    }
    let (mut actions, mut relations) = (Map::new(), Map::new());
    let decisions = [
        ("longitudinal", &sample.longitudinal, &sample.cause_longitudinal),
        ("lateral", &sample.lateral, &sample.cause_lateral),
    ];
    for (channel, decision, cause) in decisions {
        let Some(decision) = decision else { continue };
        let mut action = json!({
            "name": channel,
            "type": decision,
            "frame_intervals": at_keyframe,
        });
        if let (true, Some(side)) = (channel == "lateral", &sample.lateral_direction) {
            action["action_data"] = json!({ "text": [{ "name": "direction", "val": side }] });
        }
        actions.insert(channel.to_owned(), action);
        for id in cause.iter().flat_map(|c: &Cause| &c.components) {
            relations.insert(
                format!("{id}-{channel}"),
                json!({
                    "name": format!("{id} causes {channel}"),
                    "type": "causes",
                    "rdf_subjects": [{ "uid": id, "type": "context" }],
                    "rdf_objects": [{ "uid": channel, "type": "action" }],
                }),
            );
        }
    }
    let contexts: Map<String, Value> = sample
        .components
        .iter()
        .enumerate()
        .map(|(i, c)| {
            let uid = c.id.clone().unwrap_or_else(|| format!("component-{}", i + 1));
            let context = json!({
                "name": c.description,
                "type": c.category.as_deref().unwrap_or("critical_component"),
                "frame_intervals": at_keyframe,
                "context_data": { "text": [{ "name": "uncertainty", "val": c.uncertainty }] },
            });
            (uid, context)
        })
        .collect();
    let texts: Vec<Value> = [("trace_zh", &sample.trace_zh), ("trace_en", &sample.trace_en)]
        .into_iter()
        .filter_map(|(name, text)| Some(json!({ "name": name, "val": text.as_ref()? })))
        .collect();
    json!({
        "openlabel": {
            "metadata": {
                "schema_version": "1.0.0",
                "name": sample.sample_id,
                "annotator": sample.lineage.label_by,
                "comment": sample.lineage.drive_id,
            },
            "coordinate_systems": {
                FRAME: { "type": "scene_cs", "parent": "", "children": [EGO] },
                EGO: { "type": "local_cs", "parent": FRAME, "children": [] },
            },
            "frame_intervals": whole,
            "frames": frames,
            "objects": objects,
            "actions": actions,
            "contexts": contexts,
            "relations": relations,
            "tags": {
                "scenario": {
                    "type": sample.scenario_id,
                    "tag_data": { "text": texts },
                },
            },
        },
    })
}

/// The ego's pose at a step of history and future; `None` where it is not known.
fn pose(sample: &Sample, step: usize) -> Option<Value> {
    let before = sample.history.t_s.len();
    let (trajectory, row) =
        if step < before { (&sample.history, step) } else { (&sample.future, step - before) };
    let at = |column: &[Option<f32>]| column.get(row).copied().flatten();
    let (x, y, heading) = (at(&trajectory.x)?, at(&trajectory.y)?, at(&trajectory.heading)?);
    let half = heading / 2.0;
    Some(json!({
        "quaternion": [0.0, 0.0, half.sin(), half.cos()],
        "translation": [x, y, at(&trajectory.z).unwrap_or(0.0)],
    }))
}

/// Objects by id, and frames with their boxes.
fn objects(sample: &Sample, times: &[f32]) -> (Map<String, Value>, BTreeMap<String, Value>) {
    let (mut objects, mut frames) = (Map::new(), BTreeMap::new());
    for object in &sample.objects {
        let (mut first, mut last) = (usize::MAX, 0);
        for (row, t) in object.t_s.iter().enumerate() {
            let Some(frame) = times.iter().position(|f| (f - t).abs() < 0.01) else { continue };
            let at = |column: &[Option<f32>]| column.get(row).copied().flatten();
            let (Some(x), Some(y), Some(heading)) = (at(&object.x), at(&object.y), at(&object.heading))
            else {
                continue;
            };
            let (Some(length), Some(width)) = (object.length_m, object.width_m) else { continue };
            first = first.min(frame);
            last = last.max(frame);
            let height = object.height_m.unwrap_or(0.0);
            // x, y, z, quaternion x, y, z, w, sizes; a turn about z.
            let half = heading / 2.0;
            let cuboid = json!({
                "name": "box",
                "coordinate_system": FRAME,
                "val": [x, y, 0.0, 0.0, 0.0, half.sin(), half.cos(), length, width, height],
            });
            let frame: &mut Value =
                frames.entry(frame.to_string()).or_insert_with(|| json!({ "objects": {} }));
            frame["objects"][&object.id] = json!({ "object_data": { "cuboid": [cuboid] } });
        }
        if first <= last {
            let intervals = json!([{ "frame_start": first, "frame_end": last }]);
            let entry = json!({
                "name": object.id,
                "type": object.class,
                "coordinate_system": FRAME,
                "frame_intervals": intervals,
            });
            objects.insert(object.id.clone(), entry);
        }
    }
    (objects, frames)
}
