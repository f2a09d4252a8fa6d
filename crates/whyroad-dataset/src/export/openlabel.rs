//! ASAM OpenLABEL 1.0: one document per sample with the objects' boxes per frame in the ego frame at t0, the ego's
//! decisions as actions, the critical components as contexts, and their causes as relations. The standard's schema
//! requires numbers as keys of elements; the names that the log and the label use are in `name` and `id`.

use super::{Output, SampleWriter, number};
use crate::DatasetError;
use crate::item::SplitName;
use crate::sample::{Cause, Component, Sample};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use whyroad_model::Bilingual;

/// Coordinate system of every box: the ego's reference point at t0, fixed to the ground.
const FRAME: &str = "ego_t0";
/// Coordinate system of the ego's reference point at each frame.
const EGO: &str = "ego";

/// The definition of the class in `tags`.
const ONTOLOGY: &str = "https://github.com/whyroad/whyroad/blob/main/schema/scenario_taxonomy.yaml";

/// Name of the attribute of a cuboid that lists its unknown values. The standard has no null: they are 0.
const UNKNOWN: &str = "unknown";

#[derive(Default)]
pub(super) struct Writer {
    cuboids: usize,
    /// Cuboids whose `z` or height is unknown.
    of_unknown_height: usize,
}

impl SampleWriter for Writer {
    fn add(&mut self, sample: Sample, split: SplitName, out: &mut Output) -> Result<(), DatasetError> {
        out.report.records += 1;
        let document = document(&sample);
        for cuboid in cuboids(&document) {
            self.cuboids += 1;
            self.of_unknown_height += usize::from(cuboid.get("attributes").is_some());
        }
        let name = format!("{}/{}.json", split.name(), sample.sample_id);
        let text = serde_json::to_vec(&document).map_err(|e| DatasetError::broken(&out.root, e))?;
        out.write(&name, &text)
    }

    fn finish(&mut self, out: &mut Output) -> Result<(), DatasetError> {
        let (n, all) = (self.of_unknown_height, self.cuboids);
        if n > 0 {
            out.report.notes.push(Bilingual::new(
                format!("{all} 个框中的 {n} 个 z 或高度未知：数值写为 0，由属性 `{UNKNOWN}` 写明"),
                format!(
                    "{n} of {all} cuboids have no known z or height: the value is 0, and the attribute `{UNKNOWN}` names it"
                ),
            ));
        }
        Ok(())
    }
}

fn cuboids(document: &Value) -> impl Iterator<Item = &Value> {
    let frames = document["openlabel"]["frames"].as_object().into_iter().flat_map(Map::values);
    let objects = frames.flat_map(|f| f["objects"].as_object().into_iter().flat_map(Map::values));
    objects.flat_map(|o| o["object_data"]["cuboid"].as_array().into_iter().flatten())
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
        frame["frame_properties"] = json!({ "timestamp": number(*t) });
        if let Some(pose) = pose(sample, i) {
            let name = format!("{EGO}_to_{FRAME}");
            let transform = json!({ "src": EGO, "dst": FRAME, "transform_src_to_dst": pose });
            frame["frame_properties"]["transforms"] = json!({ name: transform });
        }
    }
    // Components and the decisions that they cause refer to each other by these keys.
    let component_id = |i: usize, c: &Component| c.id.clone().unwrap_or_else(|| format!("c{}", i + 1));
    let ids: Vec<String> = sample.components.iter().enumerate().map(|(i, c)| component_id(i, c)).collect();
    let (mut actions, mut relations) = (Map::new(), Map::new());
    let decisions = [
        ("longitudinal", &sample.longitudinal, &sample.cause_longitudinal),
        ("lateral", &sample.lateral, &sample.cause_lateral),
    ];
    for (channel, decision, cause) in decisions {
        let Some(decision) = decision else { continue };
        let key = actions.len().to_string();
        let mut action = json!({
            "name": channel,
            "type": decision,
            "frame_intervals": at_keyframe,
        });
        if let (true, Some(side)) = (channel == "lateral", &sample.lateral_direction) {
            action["action_data"] = json!({ "text": [{ "name": "direction", "val": side }] });
        }
        for id in cause.iter().flat_map(|c: &Cause| &c.components) {
            let Some(context) = ids.iter().position(|known| known == id) else { continue };
            let relation = json!({
                "name": format!("{id} causes {channel}"),
                "type": "causes",
                "rdf_subjects": [{ "uid": context.to_string(), "type": "context" }],
                "rdf_objects": [{ "uid": key, "type": "action" }],
            });
            relations.insert(relations.len().to_string(), relation);
        }
        actions.insert(key, action);
    }
    let context = |(i, c): (usize, &Component)| {
        let text = |name: &str, val: &str| json!({ "name": name, "val": val });
        let texts = [Some(text("id", &ids[i])), c.uncertainty.as_ref().map(|u| text("uncertainty", u))];
        let context = json!({
            "name": c.description,
            "type": c.category.as_deref().unwrap_or("critical_component"),
            "frame_intervals": at_keyframe,
            "context_data": { "text": texts.into_iter().flatten().collect::<Vec<_>>() },
        });
        (i.to_string(), context)
    };
    let contexts: Map<String, Value> = sample.components.iter().enumerate().map(context).collect();
    let texts: Vec<Value> = [("trace_zh", &sample.trace_zh), ("trace_en", &sample.trace_en)]
        .into_iter()
        .filter_map(|(name, text)| Some(json!({ "name": name, "val": text.as_ref()? })))
        .collect();
    let mut metadata = json!({
        "schema_version": "1.0.0",
        "name": sample.sample_id,
        "comment": sample.lineage.drive_id,
    });
    if let Some(by) = &sample.lineage.label_by {
        metadata["annotator"] = json!(by);
    }
    json!({
        "openlabel": {
            "metadata": metadata,
            "ontologies": { "0": { "uri": ONTOLOGY } },
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
                "0": {
                    "ontology_uid": "0",
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
        "quaternion": ([0.0, 0.0, half.sin(), half.cos()].map(number)),
        "translation": ([x, y, at(&trajectory.z).unwrap_or(0.0)].map(number)),
    }))
}

/// Objects by their number, and frames with their boxes. An object is named by its track id.
fn objects(sample: &Sample, times: &[f32]) -> (Map<String, Value>, BTreeMap<String, Value>) {
    let (mut objects, mut frames) = (Map::new(), BTreeMap::new());
    for (uid, object) in sample.objects.iter().enumerate().map(|(i, o)| (i.to_string(), o)) {
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
            let (z, height) = (at(&object.z), object.height_m);
            // x, y, z, quaternion x, y, z, w, sizes; a turn about z.
            let half = heading / 2.0;
            let (center_z, size_z) = (z.unwrap_or(0.0), height.unwrap_or(0.0));
            let values = [x, y, center_z, 0.0, 0.0, half.sin(), half.cos(), length, width, size_z];
            let values = values.map(number);
            let mut cuboid = json!({ "name": "box", "coordinate_system": FRAME, "val": values });
            let unknown = [("z", z), ("height", height)].into_iter().filter(|(_, v)| v.is_none());
            let unknown: Vec<&str> = unknown.map(|(name, _)| name).collect();
            if !unknown.is_empty() {
                let names = json!({ "name": UNKNOWN, "val": unknown.join(", ") });
                cuboid["attributes"] = json!({ "text": [names] });
            }
            let frame: &mut Value =
                frames.entry(frame.to_string()).or_insert_with(|| json!({ "objects": {} }));
            frame["objects"][&uid] = json!({ "object_data": { "cuboid": [cuboid] } });
        }
        if first <= last {
            let intervals = json!([{ "frame_start": first, "frame_end": last }]);
            let entry = json!({
                "name": object.id,
                "type": object.class,
                "coordinate_system": FRAME,
                "frame_intervals": intervals,
            });
            objects.insert(uid, entry);
        }
    }
    (objects, frames)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Object, Trajectory};

    /// A bus of the AV2 log adcf7d18: its center is 1.09 m above the ego frame's origin, its height 3.0 m. The height
    /// of the other object is not known, as in nuScenes drives of ScenarioNet.
    #[test]
    fn heights_are_those_of_the_log_and_marked_where_it_has_none() {
        let object = |id: &str, z: Option<f32>, height_m: Option<f32>| Object {
            id: id.into(),
            length_m: Some(11.6),
            width_m: Some(2.9),
            height_m,
            t_s: vec![0.0],
            x: vec![Some(8.0)],
            y: vec![Some(1.0)],
            z: vec![z],
            heading: vec![Some(0.0)],
            ..Object::default()
        };
        let sample = Sample {
            history: Trajectory { t_s: vec![0.0], ..Trajectory::default() },
            objects: vec![object("bus", Some(1.09), Some(3.0)), object("flat", None, None)],
            ..Sample::default()
        };
        let document = document(&sample);
        let found: Vec<&Value> = cuboids(&document).collect();
        let [bus, flat] = found[..] else { panic!("{document:#}") };
        // ASAM OpenLABEL 1.0, cuboid: x, y, z of the center, quaternion, sizes along x, y, z.
        assert_eq!((&bus["val"][2], &bus["val"][9]), (&json!(1.09), &json!(3.0)));
        assert!(bus.get("attributes").is_none());
        assert_eq!((&flat["val"][2], &flat["val"][9]), (&json!(0.0), &json!(0.0)));
        assert_eq!(flat["attributes"]["text"], json!([{ "name": "unknown", "val": "z, height" }]));
    }
}
