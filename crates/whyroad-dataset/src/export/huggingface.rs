//! Hugging Face: Parquet files per split whose `images` decode as images, a card with front matter, and Croissant
//! metadata. The columns are those of the release; an image's camera and time are in `image_cameras` and `image_t_s`.

use super::Output;
use crate::freeze::card::{hub_license, labels};
use crate::freeze::croissant::croissant;
use crate::freeze::manifest::{FileEntry, Manifest};
use crate::freeze::shards::{ROWS, ROWS_WITH_IMAGES};
use crate::freeze::tables::properties;
use crate::freeze::{CROISSANT, checksums};
use crate::item::SplitName;
use crate::sample::schema::schema;
use crate::{DatasetError, Release};
use arrow_array::cast::AsArray as _;
use arrow_array::{Array, ArrayRef, ListArray, RecordBatch, StringArray, StructArray};
use arrow_schema::{DataType, Field, Fields, Schema, SchemaRef};
use parquet::arrow::ArrowWriter;
use serde_json::{Map, Value, json};
use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

/// Writes the files of the release again, batch by batch, with `images` as Hugging Face stores them; buffers are
/// shared and no sample is decoded.
pub(super) fn write(
    release: &Release,
    out: &mut Output,
    progress: &mut dyn FnMut(),
) -> Result<(), DatasetError> {
    let schema = hf_schema();
    let mut files = Vec::new();
    for split in out.options.splits() {
        for source in release.data_files(Some(split)) {
            let (name, samples) = file(&source, &schema, release, out, progress)?;
            let (bytes, sha256) = checksums::sum(&out.root.join(&name))?;
            out.report.samples += samples;
            out.report.records += samples;
            files.push(FileEntry { path: name, bytes, sha256, samples: Some(samples) });
        }
    }
    let mut manifest = Manifest { files, ..release.manifest.clone() };
    let kept: Vec<&str> = out.options.splits().into_iter().map(SplitName::name).collect();
    manifest.counts.by_split.retain(|split, _| kept.contains(&split.as_str()));
    manifest.counts.samples = manifest.counts.by_split.values().sum();
    out.write(CROISSANT, croissant(&manifest).as_bytes())?;
    out.write("README.md", card(&manifest).as_bytes())
}

/// One file under its name in the release; returns its name in the export and the number of samples.
fn file(
    source: &Path,
    schema: &SchemaRef,
    release: &Release,
    out: &mut Output,
    progress: &mut dyn FnMut(),
) -> Result<(String, usize), DatasetError> {
    let broken = |e: &dyn std::fmt::Display| DatasetError::broken(source, e);
    let name = format!("data/{}", source.file_name().unwrap_or_default().to_string_lossy());
    let rows = if release.manifest.counts.images > 0 { ROWS_WITH_IMAGES } else { ROWS };
    let mut writer = ArrowWriter::try_new(out.create(&name)?, schema.clone(), Some(properties(rows)))
        .map_err(|e| broken(&e))?;
    let mut samples = 0;
    for batch in crate::release::open(source, None)? {
        let batch = with_images(&batch?, schema).map_err(|e| broken(&e))?;
        writer.write(&batch).and_then(|()| writer.flush()).map_err(|e| broken(&e))?;
        samples += batch.num_rows();
        (0..batch.num_rows()).for_each(|_| progress());
    }
    writer.close().map_err(|e| broken(&e))?;
    Ok((name, samples))
}

/// The release's columns with `images` as Hugging Face stores images, and the features in its metadata.
fn hf_schema() -> SchemaRef {
    let mut fields: Vec<Field> = Vec::new();
    let mut features = Map::new();
    for field in schema().fields() {
        if field.name() == "images" {
            for (name, kind, feature) in image_columns() {
                features.insert(name.to_owned(), feature);
                fields.push(Field::new(name, kind, true));
            }
        } else {
            features.insert(field.name().clone(), feature(field.data_type()));
            fields.push(field.as_ref().clone());
        }
    }
    let info = json!({ "info": { "features": features } }).to_string();
    Arc::new(Schema::new_with_metadata(fields, HashMap::from([("huggingface".to_owned(), info)])))
}

fn image_fields() -> Fields {
    vec![Field::new("bytes", DataType::Binary, true), Field::new("path", DataType::Utf8, true)].into()
}

fn item(kind: DataType) -> Arc<Field> {
    Arc::new(Field::new("item", kind, true))
}

fn image_columns() -> [(&'static str, DataType, Value); 3] {
    let list = |feature: Value| json!({ "feature": feature, "_type": "List" });
    [
        ("images", DataType::List(item(DataType::Struct(image_fields()))), list(json!({ "_type": "Image" }))),
        ("image_cameras", DataType::List(item(DataType::Utf8)), list(value("string"))),
        ("image_t_s", DataType::List(item(DataType::Float32)), list(value("float32"))),
    ]
}

fn value(dtype: &str) -> Value {
    json!({ "dtype": dtype, "_type": "Value" })
}

/// The feature of a column, as `datasets` writes it.
fn feature(kind: &DataType) -> Value {
    match kind {
        DataType::Utf8 => value("string"),
        DataType::Boolean => value("bool"),
        DataType::Binary => value("binary"),
        DataType::Float32 => value("float32"),
        DataType::Float64 => value("float64"),
        DataType::Int64 => value("int64"),
        DataType::UInt32 => value("uint32"),
        DataType::List(item) => json!({ "feature": feature(item.data_type()), "_type": "List" }),
        DataType::Struct(fields) => {
            Value::Object(fields.iter().map(|f| (f.name().clone(), feature(f.data_type()))).collect())
        }
        _ => value("string"),
    }
}

/// The batch with `images` split into the three columns; buffers are shared.
fn with_images(batch: &RecordBatch, schema: &SchemaRef) -> Result<RecordBatch, arrow_schema::ArrowError> {
    let mut columns: Vec<ArrayRef> = Vec::new();
    for (field, column) in batch.schema().fields().iter().zip(batch.columns()) {
        if field.name() != "images" {
            columns.push(column.clone());
            continue;
        }
        let list = column.as_list::<i32>();
        let images = list.values().as_struct();
        let part = |name: &str| {
            images.column_by_name(name).cloned().ok_or_else(|| {
                arrow_schema::ArrowError::SchemaError(format!("images have no column '{name}'"))
            })
        };
        let types = part("format")?;
        let hashes = part("sha256")?;
        let paths: StringArray = types
            .as_string::<i32>()
            .iter()
            .zip(hashes.as_string::<i32>().iter())
            .map(|(kind, hash)| Some(format!("{}.{}", hash?, kind?)))
            .collect();
        let pair = StructArray::try_new(
            image_fields(),
            vec![part("bytes")?, Arc::new(paths)],
            images.nulls().cloned(),
        )?;
        let of = |kind: DataType, values: ArrayRef| -> Result<ArrayRef, arrow_schema::ArrowError> {
            Ok(Arc::new(ListArray::try_new(
                item(kind),
                list.offsets().clone(),
                values,
                list.nulls().cloned(),
            )?))
        };
        columns.push(of(DataType::Struct(image_fields()), Arc::new(pair))?);
        columns.push(of(DataType::Utf8, part("camera")?)?);
        columns.push(of(DataType::Float32, part("t_s")?)?);
    }
    RecordBatch::try_new(schema.clone(), columns)
}

/// The card: front matter that `load_dataset` reads, then the contents.
fn card(m: &Manifest) -> String {
    let mut out = String::from("---\n");
    let title = m.title.as_deref().unwrap_or(&m.name);
    let _ = writeln!(out, "pretty_name: {}", json!(title));
    let _ = writeln!(out, "license: {}", hub_license(&m.licence));
    if m.licence.starts_with("LicenseRef-") {
        // The hub requires both beside `other`; the file is the card itself, which names the licenses of the drives.
        let _ = writeln!(out, "license_name: {}\nlicense_link: README.md", m.licence.to_lowercase());
    }
    out += "language:\n- zh\n- en\ntask_categories:\n- image-text-to-text\ntags:\n- autonomous-driving\n- chain-of-causation\n";
    out += "configs:\n- config_name: default\n  data_files:\n";
    for (split, name) in [("train", "train"), ("val", "validation"), ("test", "test")] {
        if m.counts.by_split.get(split).is_some_and(|n| *n > 0) {
            let _ = writeln!(out, "  - split: {name}\n    path: data/{split}-*.parquet");
        }
    }
    let _ = writeln!(out, "---\n\n# {title}\n\nVersion {}, {} samples.\n", m.version, m.counts.samples);
    labels(&mut out, m);
    out += "| license of the drives | drives | samples | attribution |\n|---|---|---|---|\n";
    for l in &m.licences {
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} |",
            l.id,
            l.drives,
            l.samples,
            l.attribution.as_deref().unwrap_or("")
        );
    }
    out += "\n| scenario | train | val | test |\n|---|---|---|---|\n";
    for (class, by_split) in &m.counts.by_class {
        let n = |split: &str| by_split.get(split).copied().unwrap_or(0);
        let _ = writeln!(out, "| {class} | {} | {} | {} |", n("train"), n("val"), n("test"));
    }
    out += "\nPositions, headings and velocities are in the ego frame at the keyframe (x forward, y left, m, rad); times are \
            seconds from the keyframe; null is unknown.\n";
    out
}
