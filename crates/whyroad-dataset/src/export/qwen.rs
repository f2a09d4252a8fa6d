//! Qwen-VL fine-tuning files: JSON Lines with `image` (a list of paths) and `conversations` of `human` and `gpt`.

use super::chat::conversations;
use super::{ExportOptions, Exported, Folder, SampleWriter, images};
use crate::DatasetError;
use crate::item::SplitName;
use crate::sample::Sample;
use serde_json::json;

#[derive(Default)]
pub(super) struct Writer;

impl SampleWriter for Writer {
    fn add(
        &mut self,
        sample: &Sample,
        split: SplitName,
        options: &ExportOptions,
        folder: &mut Folder,
        exported: &mut Exported,
    ) -> Result<(), DatasetError> {
        let all = conversations(sample, options, exported);
        if all.is_empty() {
            return Ok(());
        }
        let paths = images::write(sample, folder)?;
        for conversation in all {
            // The trainer splits at each tag and expects one line per image before the text.
            let question = format!("{}{}", "<image>\n".repeat(paths.len()), conversation.question);
            let mut record = json!({ "conversations": [
                { "from": "human", "value": question },
                { "from": "gpt", "value": conversation.answer },
            ]});
            if !paths.is_empty() {
                record["image"] = json!(paths);
            }
            folder.line(&format!("{}.jsonl", split.name()), &record)?;
            exported.records += 1;
        }
        Ok(())
    }
}
