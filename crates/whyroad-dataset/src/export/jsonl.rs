//! JSON Lines: every column of the release, images as files.

use super::{ExportOptions, Exported, Folder, SampleWriter, images};
use crate::DatasetError;
use crate::item::SplitName;
use crate::sample::Sample;
use serde_json::{Value, json};

#[derive(Default)]
pub(super) struct Writer;

impl SampleWriter for Writer {
    fn add(
        &mut self,
        sample: &Sample,
        split: SplitName,
        _: &ExportOptions,
        folder: &mut Folder,
        exported: &mut Exported,
    ) -> Result<(), DatasetError> {
        let paths = images::write(sample, folder)?;
        let without_bytes = Sample {
            images: sample
                .images
                .iter()
                .map(|i| crate::sample::Image { bytes: vec![], ..i.clone() })
                .collect(),
            ..sample.clone()
        };
        let broken = |e| DatasetError::broken(&folder.root, e);
        let mut record = serde_json::to_value(&without_bytes).map_err(broken)?;
        for (image, path) in record["images"].as_array_mut().into_iter().flatten().zip(paths) {
            if let Value::Object(fields) = image {
                fields.remove("bytes");
                fields.insert("path".to_owned(), json!(path));
            }
        }
        // The label itself, not a text that holds it.
        record["label"] = serde_json::from_str(&sample.label_json).unwrap_or(Value::Null);
        exported.records += 1;
        folder.line(&format!("{}.jsonl", split.name()), &record)
    }
}
