//! ms-swift (4.x) JSON Lines: `sft.<split>.jsonl` (messages, images), `dpo.<split>.jsonl` (with `rejected_response`:
//! versions that a checker returned), `grpo.<split>.jsonl` (question only; further columns reach the reward functions).

use super::chat::{Conversation, conversations};
use super::{ExportOptions, Exported, Folder, SampleWriter, images};
use crate::DatasetError;
use crate::item::SplitName;
use crate::sample::Sample;
use serde_json::{Value, json};

#[derive(Default)]
pub(super) struct Writer {
    rejected: usize,
}

/// The user's text with one tag per image: ms-swift replaces them in order.
fn tagged(question: &str, count: usize) -> String {
    format!("{}{question}", "<image>".repeat(count))
}

fn with_images(mut record: Value, paths: &[String]) -> Value {
    if !paths.is_empty() {
        record["images"] = json!(paths);
    }
    record
}

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
        let split = split.name();
        for Conversation { lang, question, trace, answer } in all {
            let user = json!({ "role": "user", "content": tagged(&question, paths.len()) });
            let messages = json!([user, { "role": "assistant", "content": answer }]);
            folder
                .line(&format!("sft.{split}.jsonl"), &with_images(json!({ "messages": messages }), &paths))?;
            exported.records += 1;
            for rejected in &sample.rejected {
                // A returned version in the other language is no alternative to this answer.
                let Some(text) = rejected
                    .trace
                    .as_deref()
                    .filter(|t| crate::labels::is_chinese(t) == (lang == whyroad_model::Lang::Zh))
                else {
                    continue;
                };
                let record = json!({ "messages": messages, "rejected_response": text });
                folder.line(&format!("dpo.{split}.jsonl"), &with_images(record, &paths))?;
                exported.records += 1;
                self.rejected += 1;
            }
            let future: Vec<[Option<f32>; 2]> =
                sample.future.x.iter().zip(&sample.future.y).map(|(x, y)| [*x, *y]).collect();
            let record = json!({
                "messages": [user],
                "solution": trace,
                "scenario_id": sample.scenario_id,
                "longitudinal": sample.longitudinal,
                "lateral": sample.lateral,
                "lateral_direction": sample.lateral_direction,
                "components": sample.components.iter().map(|c| &c.description).collect::<Vec<_>>(),
                "future_xy": future,
                "future_t": sample.future.t_s,
                "sample_id": sample.sample_id,
            });
            folder.line(&format!("grpo.{split}.jsonl"), &with_images(record, &paths))?;
            exported.records += 1;
        }
        Ok(())
    }

    fn finish(
        &mut self,
        _: &ExportOptions,
        _: &mut Folder,
        exported: &mut Exported,
    ) -> Result<(), DatasetError> {
        if self.rejected == 0 {
            exported.notes.push("no label was returned by a checker: no DPO file was written".to_owned());
        }
        exported.notes.push(
            "swift sft --dataset sft.train.jsonl --val_dataset sft.val.jsonl (run it inside this folder: image paths are relative)"
                .to_owned(),
        );
        Ok(())
    }
}
