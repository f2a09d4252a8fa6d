//! Sequences as JSON Lines, the pickle-free equivalent of the challenge's files: one line per log and prompt,
//! `{"log_id", "prompt", "frames": [{"timestamp_ns", "ego": [x, y], "is_positive"?, "objects": [{"track_id",
//! "label"?, "x", "y", "score"?}]}]}`. Positions are box centers in the city (world) frame, m.

use serde::{Deserialize, Deserializer, Serialize};
use whyroad_framework::json_text;
use whyroad_model::{Bilingual, Diagnostic, Location};

/// One log and one prompt.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sequence {
    /// Log (drive).
    pub log_id: String,
    /// The prompt: a text, or the id of a class.
    pub prompt: String,
    /// In the order of time.
    pub frames: Vec<Frame>,
}

/// One moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Frame {
    /// Time.
    pub timestamp_ns: i64,
    /// Center of the ego, m.
    pub ego: [f64; 2],
    /// Whether the prompt applies here. Absent: it applies where an object is referred to. `null`: undecided.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "stated")]
    pub is_positive: Option<Option<bool>>,
    /// Objects; those that are never referred to may be left out.
    pub objects: Vec<Object>,
}

/// One object.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Object {
    /// Track.
    pub track_id: String,
    /// Its relation to the prompt.
    #[serde(default)]
    pub label: Label,
    /// m.
    pub x: f64,
    /// m.
    pub y: f64,
    /// How sure the prediction is; 1 in a truth.
    #[serde(default = "sure")]
    pub score: f64,
}

/// Relation of an object to the prompt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Label {
    /// The prompt refers to it.
    #[default]
    ReferredObject,
    /// The prompt mentions it.
    RelatedObject,
    /// Neither.
    OtherObject,
}

fn sure() -> f64 {
    1.0
}

/// Distinguishes `null` from absent.
fn stated<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Option<bool>>, D::Error> {
    Option::<bool>::deserialize(d).map(Some)
}

/// Reads sequences; a line that is not one is an error with its location and does not stop the rest.
pub fn read(text: &str, file: &str) -> (Vec<Sequence>, Vec<Diagnostic>) {
    let (mut sequences, mut problems) = (Vec::new(), Vec::new());
    for (i, line) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()) {
        match serde_json::from_str(line) {
            Ok(sequence) => sequences.push(sequence),
            Err(e) => problems.push(
                Diagnostic::error(
                    "evaluate.sequence.line",
                    Bilingual::new(
                        format!("该行不是序列，已跳过：{}", json_text::message(line, &e).zh),
                        format!(
                            "this line is not a sequence and is skipped: {}",
                            json_text::message(line, &e).en
                        ),
                    ),
                )
                .with_hint(Bilingual::new(
                    "格式见 docs/reference/evaluation.zh.md",
                    "the format is in docs/reference/evaluation.md",
                ))
                .at(Location { line: Some(i + 1), column: Some(e.column().max(1)), ..Location::default() })
                .in_file(file),
            ),
        }
    }
    (sequences, problems)
}

/// As JSON Lines.
pub fn write(sequences: &[Sequence]) -> Result<String, serde_json::Error> {
    let mut out = String::new();
    for s in sequences {
        out += &serde_json::to_string(s)?;
        out.push('\n');
    }
    Ok(out)
}
