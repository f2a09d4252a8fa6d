//! JSON Schemas (draft 2020-12) of every message and of the labeling specs, generated from the Rust types.
//! Rules between fields that JSON Schema can express are added in `rules`, from the framework's data.

mod rules;

use crate::Framework;
use crate::spec::raw::SpecFile;
use indexmap::IndexMap;
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Value, json};
use whyroad_model::FORMAT_VERSION;
use whyroad_model::messages::{
    ClipMetadataMessage, CocLabel, KeyframeSuggestionMessage, MiningQueryMessage, MiningResultMessage,
    ScenarioLabelMessage, ScenarioPreLabelMessage,
};

/// One generated file of `schema/`.
#[derive(Clone, Debug, PartialEq)]
pub struct SchemaFile {
    /// File name, `coc_output_schema.json`.
    pub name: String,
    /// The schema.
    pub schema: Value,
}

impl SchemaFile {
    /// The file's text: pretty JSON with a final newline. The most important fields come first.
    pub fn text(&self) -> String {
        let Value::Object(fields) = &self.schema else { return format!("{:#}\n", self.schema) };
        let mut ordered: IndexMap<&str, &Value> = IndexMap::new();
        for key in FIRST.iter().copied().chain(fields.keys().map(String::as_str)) {
            if let Some(value) = fields.get(key).filter(|_| key != "$defs") {
                ordered.insert(key, value);
            }
        }
        ordered.extend(fields.get("$defs").map(|defs| ("$defs", defs)));
        // Strings and maps with string keys always serialize.
        serde_json::to_string_pretty(&ordered).map(|text| text + "\n").unwrap_or_default()
    }
}

/// Order of a schema file's first fields; `$defs` comes last.
const FIRST: &[&str] =
    &["$schema", "$id", "title", "description", "version", "type", "properties", "required"];

/// All schemas, in the order of DATA_FORMAT.md. Classes and mandatory fields come from `framework`.
pub fn schemas(framework: &Framework) -> Vec<SchemaFile> {
    let mut scenario_label = of::<ScenarioLabelMessage>(
        "scenario_label",
        "DATA_FORMAT.md 2.2: place of a sample in the taxonomy.",
    );
    rules::classes(&mut scenario_label["$defs"]["ScenarioLabel"], &["l3"], &framework.taxonomy);
    let mut clip_metadata = of::<ClipMetadataMessage>(
        "clip_metadata",
        "DATA_FORMAT.md 3.1: what an annotator knows about a clip.",
    );
    rules::classes(&mut clip_metadata["$defs"]["PreLabelScenario"], &["l3"], &framework.taxonomy);
    let mut pre_label = of::<ScenarioPreLabelMessage>(
        "scenario_pre_label",
        "DATA_FORMAT.md 3.2: mining's proposal for one episode.",
    );
    rules::classes(&mut pre_label["$defs"]["ScenarioPreLabel"], &["l3", "suggested_l3"], &framework.taxonomy);
    let keyframe = of::<KeyframeSuggestionMessage>(
        "keyframe_suggestion",
        "DATA_FORMAT.md 3.3: where mining would put the keyframe.",
    );
    let mut coc = of::<CocLabel>("coc_output", "DATA_FORMAT.md 4: a finished Chain-of-Causation label.");
    rules::classes(&mut coc["$defs"]["ScenarioLabel"], &["l3"], &framework.taxonomy);
    rules::label(&mut coc, framework);
    let query = of::<MiningQueryMessage>("mining_query", "DATA_FORMAT.md 5.1: what to look for.");
    let result = of::<MiningResultMessage>("mining_result", "DATA_FORMAT.md 5.2: what was found.");
    let spec = of::<SpecFile>(
        "labeling_spec",
        "A file of scenarios/: how an L1, or an L2 and its leaves, are labeled.",
    );
    [
        ("scenario_label", scenario_label),
        ("clip_metadata", clip_metadata),
        ("scenario_pre_label", pre_label),
        ("keyframe_suggestion", keyframe),
        ("coc_output", coc),
        ("mining_query", query),
        ("mining_result", result),
        ("labeling_spec", spec),
    ]
    .into_iter()
    .map(|(name, schema)| SchemaFile { name: format!("{name}_schema.json"), schema })
    .collect()
}

/// The schema of `T` with a description at its beginning. The `$id` is a name, not an address to fetch.
fn of<T: JsonSchema>(name: &str, description: &str) -> Value {
    let generated = SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<T>();
    let mut head = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": format!("urn:whyroad:schema:{FORMAT_VERSION}:{name}"),
        "title": name,
        "description": description,
        "version": FORMAT_VERSION,
    });
    if let (Some(head), Value::Object(body)) = (head.as_object_mut(), generated.to_value()) {
        for (key, value) in body {
            head.entry(key).or_insert(value);
        }
    }
    head
}
