//! ms-swift (4.x) JSON Lines: `sft.<split>.jsonl` (messages, images), `dpo.<split>.jsonl` (with `rejected_response`:
//! versions that a checker returned), `grpo.<split>.jsonl` (question only; further columns reach the reward functions).

use super::chat::{ChatFormat, Conversation};
use super::{Output, number};
use crate::DatasetError;
use serde_json::{Value, json};
use whyroad_model::Bilingual;

#[derive(Default)]
pub(super) struct MsSwift {
    rejected: usize,
}

impl ChatFormat for MsSwift {
    fn add(&mut self, c: &Conversation<'_>, out: &mut Output) -> Result<(), DatasetError> {
        let (sample, split) = (c.sample, c.split);
        let mut line = |kind: &str, record: Value| {
            out.report.records += 1;
            out.line(&format!("{kind}.{split}.jsonl"), &c.with_images(record, "images"))
        };
        // ms-swift replaces the tags in order.
        let user = json!({ "role": "user", "content": c.question("<image>") });
        let messages = json!([user, { "role": "assistant", "content": c.answer() }]);
        line("sft", json!({ "messages": messages }))?;
        for text in sample.rejected.iter().filter_map(|version| c.rejected_answer(version)) {
            line("dpo", json!({ "messages": messages, "rejected_response": text }))?;
            self.rejected += 1;
        }
        let future: Vec<[Option<f64>; 2]> = sample
            .future
            .x
            .iter()
            .zip(&sample.future.y)
            .map(|(x, y)| [*x, *y].map(|v| v.map(number)))
            .collect();
        // A reward compares them with an answer in the language of the record.
        let components: Vec<&str> = sample
            .components
            .iter()
            .map(|component| component.description.as_str())
            .filter(|text| crate::labels::language(text) == Some(c.lang))
            .collect();
        let record = json!({
            "messages": [user],
            "solution": c.trace,
            "scenario_id": sample.scenario_id,
            "longitudinal": sample.longitudinal,
            "lateral": sample.lateral,
            "lateral_direction": sample.lateral_direction,
            "components": components,
            "future_xy": future,
            "future_t": sample.future.t_s.iter().copied().map(number).collect::<Vec<_>>(),
            "sample_id": sample.sample_id,
        });
        line("grpo", record)
    }

    fn finish(&mut self, out: &mut Output) -> Result<(), DatasetError> {
        if self.rejected == 0 {
            out.report.notes.push(Bilingual::new(
                "没有被质检退回的标签：未写出 DPO 文件",
                "no label was returned by a checker: no DPO file was written",
            ));
        }
        let command = "swift sft --dataset sft.train.jsonl --val_dataset sft.val.jsonl";
        out.report.notes.push(Bilingual::new(
            format!("{command}（在此文件夹中运行：图像路径是相对的）"),
            format!("{command} (run it inside this folder: image paths are relative)"),
        ));
        Ok(())
    }
}
