//! Qwen-VL fine-tuning files: JSON Lines with `image` (a list of paths) and `conversations` of `human` and `gpt`.

use super::Output;
use super::chat::{ChatFormat, Conversation};
use crate::DatasetError;
use serde_json::json;

pub(super) struct Qwen;

impl ChatFormat for Qwen {
    fn add(&mut self, c: &Conversation<'_>, out: &mut Output) -> Result<(), DatasetError> {
        // The trainer splits at each tag and expects one line per image before the text.
        let record = json!({ "conversations": [
            { "from": "human", "value": c.question("<image>\n") },
            { "from": "gpt", "value": c.answer() },
        ]});
        out.report.records += 1;
        out.line(&format!("{}.jsonl", c.split), &c.with_images(record, "image"))
    }
}
