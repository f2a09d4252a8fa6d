//! The Arrow schema of a sample, and batches of samples to and from it. One schema for every file of every release:
//! each column is present, and each is nullable, so that an empty field never changes the schema.

use super::Sample;
use arrow_array::RecordBatch;
use arrow_schema::{DataType, Field, FieldRef, Schema};
use std::sync::Arc;

/// Column name and type, in order.
fn columns() -> Vec<(&'static str, DataType)> {
    let text = DataType::Utf8;
    let (f32s, f64s) = (DataType::Float32, DataType::Float64);
    let cause = structure(&[("components", list(text.clone())), ("unobserved", text.clone())]);
    let trajectory = structure(&[
        ("t_s", list(f32s.clone())),
        ("x", list(f32s.clone())),
        ("y", list(f32s.clone())),
        ("z", list(f32s.clone())),
        ("heading", list(f32s.clone())),
        ("speed", list(f32s.clone())),
        ("accel", list(f32s.clone())),
        ("yaw_rate", list(f32s.clone())),
        ("meta_longitudinal", list(text.clone())),
        ("meta_lateral", list(text.clone())),
        ("complete", DataType::Boolean),
    ]);
    vec![
        ("sample_id", text.clone()),
        ("split", text.clone()),
        ("weight", f64s.clone()),
        ("l1", text.clone()),
        ("l2", text.clone()),
        ("l3", text.clone()),
        ("scenario_id", text.clone()),
        ("secondary_scenarios", list(text.clone())),
        ("longitudinal", text.clone()),
        ("lateral", text.clone()),
        ("lateral_direction", text.clone()),
        ("trace_zh", text.clone()),
        ("trace_en", text.clone()),
        (
            "components",
            list(structure(&[
                ("id", text.clone()),
                ("category", text.clone()),
                ("description", text.clone()),
                ("uncertainty", text.clone()),
                ("evidence_t_s", list(f32s.clone())),
                ("objects", list(text.clone())),
            ])),
        ),
        ("cause_longitudinal", cause.clone()),
        ("cause_lateral", cause),
        ("route", text.clone()),
        ("route_text_zh", text.clone()),
        ("route_text_en", text.clone()),
        (
            "lineage",
            structure(&[
                ("drive_id", text.clone()),
                ("drive_hash", text.clone()),
                ("clip_id", text.clone()),
                ("episode_id", text.clone()),
                ("target_id", text.clone()),
                ("task_id", text.clone()),
                ("keyframe_time_ns", DataType::Int64),
                ("keyframe_frame", DataType::UInt32),
                ("label_sha256", text.clone()),
                ("label_version", text.clone()),
                ("label_status", text.clone()),
                ("checked", DataType::Boolean),
                ("label_source", text.clone()),
                ("label_by", text.clone()),
                ("taxonomy_version", text.clone()),
                ("rule_version", text.clone()),
                ("score", f64s.clone()),
            ]),
        ),
        (
            "groups",
            structure(&[
                ("component", DataType::UInt32),
                ("session", text.clone()),
                ("vehicle", text.clone()),
                ("place", text.clone()),
                ("place_cell", text.clone()),
                ("date", text.clone()),
                ("source", text.clone()),
                ("licence", text.clone()),
                ("position_frame", text.clone()),
                ("position", list(f64s.clone())),
                ("longitude_latitude", list(f64s.clone())),
                ("world_x", f64s.clone()),
                ("world_y", f64s.clone()),
                ("world_z", f64s.clone()),
                ("world_heading", f64s),
            ]),
        ),
        (
            "ego",
            structure(&[
                ("length_m", f32s.clone()),
                ("width_m", f32s.clone()),
                ("height_m", f32s.clone()),
                ("reference", text.clone()),
                ("reference_to_centre_m", f32s.clone()),
            ]),
        ),
        ("history", trajectory.clone()),
        ("future", trajectory),
        (
            "objects",
            list(structure(&[
                ("id", text.clone()),
                ("class", text.clone()),
                ("named", DataType::Boolean),
                ("length_m", f32s.clone()),
                ("width_m", f32s.clone()),
                ("height_m", f32s.clone()),
                ("t_s", list(f32s.clone())),
                ("x", list(f32s.clone())),
                ("y", list(f32s.clone())),
                ("z", list(f32s.clone())),
                ("heading", list(f32s.clone())),
                ("vx", list(f32s.clone())),
                ("vy", list(f32s.clone())),
            ])),
        ),
        (
            "map",
            list(structure(&[
                ("id", text.clone()),
                ("kind", text.clone()),
                ("x", list(f32s.clone())),
                ("y", list(f32s.clone())),
                ("width_m", f32s.clone()),
                ("speed_limit_mps", f32s.clone()),
                ("successors", list(text.clone())),
            ])),
        ),
        (
            "lights",
            list(structure(&[
                ("lane_id", text.clone()),
                ("to_lane_id", text.clone()),
                ("color", text.clone()),
                ("since_s", f32s.clone()),
            ])),
        ),
        ("context", list(structure(&[("kind", text.clone()), ("value", text.clone())]))),
        (
            "images",
            list(structure(&[
                ("camera", text.clone()),
                ("t_s", f32s),
                ("format", text.clone()),
                ("sha256", text.clone()),
                ("bytes", DataType::Binary),
            ])),
        ),
        ("label_json", text.clone()),
        ("label_json_other", text.clone()),
        (
            "rejected",
            list(structure(&[("label_json", text.clone()), ("trace", text.clone()), ("reason", text)])),
        ),
    ]
}

fn list(item: DataType) -> DataType {
    DataType::List(Arc::new(Field::new("item", item, true)))
}

fn structure(fields: &[(&str, DataType)]) -> DataType {
    DataType::Struct(fields.iter().map(|(name, kind)| Field::new(*name, kind.clone(), true)).collect())
}

/// The schema of every samples file.
pub fn schema() -> Schema {
    Schema::new(fields())
}

fn fields() -> Vec<FieldRef> {
    columns().into_iter().map(|(name, kind)| Arc::new(Field::new(name, kind, true))).collect()
}

/// Samples as one batch of [`schema`].
///
/// # Errors
/// With a message, when a sample does not fit the schema (never for a [`Sample`] that this crate made).
pub fn to_batch(samples: &[Sample]) -> Result<RecordBatch, String> {
    serde_arrow::to_record_batch(&fields(), &samples).map_err(|e| e.to_string())
}

/// The samples of a batch that was read from a release.
///
/// # Errors
/// With a message, when a column is missing or of another type.
pub fn from_batch(batch: &RecordBatch) -> Result<Vec<Sample>, String> {
    serde_arrow::from_record_batch(batch).map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use super::super::{Image, MapElement, Object, Trajectory};
    use super::*;

    #[test]
    fn a_sample_survives_the_way_there_and_back() {
        let full = Sample {
            sample_id: "0123456789abcdef".into(),
            weight: 1.5,
            l3: Some("urgent".into()),
            history: Trajectory {
                t_s: vec![-0.1, 0.0],
                x: vec![Some(-1.0), None],
                meta_lateral: vec![None, Some("go_straight".into())],
                ..Trajectory::default()
            },
            objects: vec![Object { id: "7".into(), vx: vec![None, Some(2.0)], ..Object::default() }],
            map: Some(vec![MapElement { x: vec![1.0, 2.0], ..MapElement::default() }]),
            images: vec![Image { bytes: vec![0, 255, 7], ..Image::default() }],
            ..Sample::default()
        };
        let samples = vec![full, Sample::default()];
        let batch = to_batch(&samples).unwrap();
        assert_eq!(*batch.schema(), schema());
        assert_eq!(from_batch(&batch).unwrap(), samples);
        let bytes = postcard::to_allocvec(&samples).unwrap();
        assert_eq!(postcard::from_bytes::<Vec<Sample>>(&bytes).unwrap(), samples);
    }

    #[test]
    fn every_column_is_nullable_at_every_depth() {
        fn check(field: &Field) {
            assert!(field.is_nullable(), "{}", field.name());
            match field.data_type() {
                DataType::List(item) => check(item),
                DataType::Struct(fields) => fields.iter().for_each(|f| check(f)),
                _ => {}
            }
        }
        assert!(schema().fields().len() > 30);
        schema().fields().iter().for_each(|f| check(f));
    }
}
