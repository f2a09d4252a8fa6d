//! LLaMA-Factory (0.9) in its "sharegpt" form with OpenAI-style messages, and the entries of `dataset_info.json`.

use super::Output;
use super::chat::{ChatFormat, Conversation};
use crate::{DatasetError, Release};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use whyroad_model::Bilingual;

pub(super) struct LlamaFactory {
    name: String,
    /// Files by the name of their data set, and whether their records have images.
    sets: BTreeMap<String, (String, bool)>,
}

impl LlamaFactory {
    pub(super) fn new(release: &Release) -> Self {
        Self { name: release.manifest.name.clone(), sets: BTreeMap::new() }
    }
}

impl ChatFormat for LlamaFactory {
    fn add(&mut self, c: &Conversation<'_>, out: &mut Output) -> Result<(), DatasetError> {
        // One file per column layout: the loader takes the columns of the first record for all.
        let with_images = !c.images.is_empty();
        let suffix = if with_images { "" } else { "_text" };
        let file = format!("{}{suffix}.jsonl", c.split);
        let record = json!({ "messages": [
            { "role": "user", "content": c.question("<image>") },
            { "role": "assistant", "content": c.answer() },
        ]});
        out.line(&file, &c.with_images(record, "images"))?;
        self.sets.insert(format!("{}_{}{suffix}", self.name, c.split), (file, with_images));
        out.report.records += 1;
        Ok(())
    }

    fn finish(&mut self, out: &mut Output) -> Result<(), DatasetError> {
        let mut info = Map::new();
        for (name, (file, with_images)) in &self.sets {
            let mut columns = json!({ "messages": "messages" });
            if *with_images {
                columns["images"] = Value::from("images");
            }
            let entry = json!({
                "file_name": file,
                "formatting": "sharegpt",
                "columns": columns,
                "tags": {
                    "role_tag": "role",
                    "content_tag": "content",
                    "user_tag": "user",
                    "assistant_tag": "assistant",
                },
            });
            info.insert(name.clone(), entry);
        }
        out.report.notes.push(Bilingual::new(
            "llamafactory-cli train：dataset_dir 与 media_dir 为此文件夹；dataset 为 dataset_info.json 中的名称",
            "llamafactory-cli train: dataset_dir and media_dir are this folder; dataset is a name of dataset_info.json",
        ));
        out.json("dataset_info.json", &info)
    }
}
