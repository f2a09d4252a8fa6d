//! JSON Lines: every column of the release, images as files.

use super::{Output, SampleWriter, images};
use crate::DatasetError;
use crate::item::SplitName;
use crate::sample::Sample;
use serde_json::{Value, json};

#[derive(Default)]
pub(super) struct Writer;

impl SampleWriter for Writer {
    fn add(&mut self, mut sample: Sample, split: SplitName, out: &mut Output) -> Result<(), DatasetError> {
        let paths = images::write(&sample, out)?;
        sample.images.iter_mut().for_each(|image| image.bytes.clear());
        let broken = |e| DatasetError::broken(&out.root, e);
        // Through the text: a value made directly would write every number with the digits of a double.
        let text = serde_json::to_string(&sample).map_err(broken)?;
        let mut record: Value = serde_json::from_str(&text).map_err(broken)?;
        for (image, path) in record["images"].as_array_mut().into_iter().flatten().zip(paths) {
            if let Value::Object(fields) = image {
                fields.remove("bytes");
                fields.insert("path".to_owned(), json!(path));
            }
        }
        // The label itself, not a text that holds it.
        record["label"] = serde_json::from_str(&sample.label_json).unwrap_or(Value::Null);
        out.report.records += 1;
        out.line(&format!("{}.jsonl", split.name()), &record)
    }
}
