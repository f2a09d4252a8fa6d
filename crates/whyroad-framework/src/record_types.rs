//! Types of the required records of a label (`scenarios/records.yaml`), and their stored form, which is independent of
//! the language. The labeling specs state which leaf requires which record.

use crate::yaml_text;
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;
use whyroad_model::{Bilingual, Diagnostic};

/// The stored value where the clip does not show it.
pub const UNKNOWN: &str = "unknown";

/// Type of a record.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum RecordType {
    /// A number in the unit of the spec.
    Number {
        /// Least plausible value.
        min: f64,
        /// Largest plausible value.
        max: f64,
    },
    /// True or false.
    Flag {
        /// Words for true.
        yes: Vec<String>,
        /// Words for false.
        no: Vec<String>,
    },
    /// One of a closed set.
    Choice {
        /// The set.
        values: Vec<ChoiceValue>,
        /// Other text is kept.
        #[serde(default)]
        or_text: bool,
        /// Minimum number of words of such a text: an adverb of degree alone is not a description.
        #[serde(default)]
        text_words: usize,
    },
    /// Free words.
    Text,
}

/// A member of a closed set.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChoiceValue {
    /// The stored value.
    pub id: String,
    /// Words that state it.
    pub words: Vec<String>,
}

/// All records, and the words for "unknown".
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordTypes {
    #[allow(dead_code)] // read by people
    #[serde(default)]
    version: String,
    unknown: Vec<String>,
    /// By record id.
    pub records: BTreeMap<String, RecordType>,
}

/// A record's value as a label holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RecordValue<'a> {
    /// A number.
    Number(f64),
    /// True or false.
    Flag(bool),
    /// Words.
    Text(&'a str),
    /// A list or an object.
    Nested,
}

impl<'a> RecordValue<'a> {
    /// From JSON; `None` is null.
    pub fn of(value: &'a Value) -> Option<Self> {
        Some(match value {
            Value::Null => return None,
            Value::Bool(b) => Self::Flag(*b),
            Value::Number(n) => Self::Number(n.as_f64().unwrap_or(f64::NAN)),
            Value::String(s) => Self::Text(s),
            Value::Array(_) | Value::Object(_) => Self::Nested,
        })
    }
}

/// Check result of a record's value.
#[derive(Clone, Debug, PartialEq)]
pub enum RecordVerdict {
    /// Valid; to be stored in this form.
    Stored(Value),
    /// Of another type.
    WrongType,
    /// A number outside of what is plausible.
    OutOfRange {
        /// Least plausible value.
        min: f64,
        /// Largest plausible value.
        max: f64,
    },
    /// Not in the closed set.
    NotAChoice(Vec<String>),
}

impl RecordTypes {
    /// From the text of `scenarios/records.yaml`; `file` is named in diagnostics.
    pub fn parse(file: &str, text: &str) -> (RecordTypes, Vec<Diagnostic>) {
        let what = Bilingual::new("记录类型表", "the record types");
        match yaml_text::read("spec.record_types", file, text, what) {
            Ok((types, _)) => (types, Vec::new()),
            Err(finding) => (RecordTypes::default(), vec![*finding]),
        }
    }

    /// True when `text` states that the clip does not show it.
    pub fn is_unknown(&self, text: &str) -> bool {
        let text = text.trim();
        self.unknown.iter().any(|w| w.eq_ignore_ascii_case(text))
    }

    /// `value` as it is stored; `None` where it is already so, wrong, or of a record that has no type.
    pub fn stored(&self, id: &str, value: &Value) -> Option<Value> {
        match self.judge(id, RecordValue::of(value)?)? {
            RecordVerdict::Stored(stored) => {
                let same_number = stored.as_f64().is_some() && stored.as_f64() == value.as_f64();
                (stored != *value && !same_number).then_some(stored)
            }
            _ => None,
        }
    }

    /// Check result of `value` as the record `id`; `None` for an id that has no type.
    pub fn judge(&self, id: &str, value: RecordValue<'_>) -> Option<RecordVerdict> {
        let kind = self.records.get(id)?;
        if let RecordValue::Text(t) = value
            && self.is_unknown(t)
        {
            return Some(RecordVerdict::Stored(UNKNOWN.into()));
        }
        Some(match (kind, value) {
            (RecordType::Number { min, max }, value) => number(value, *min, *max),
            (RecordType::Flag { .. }, RecordValue::Flag(b)) => RecordVerdict::Stored(b.into()),
            (RecordType::Flag { yes, no }, RecordValue::Text(t)) => {
                let is = |words: &[String]| words.iter().any(|w| w.eq_ignore_ascii_case(t.trim()));
                match (is(yes), is(no)) {
                    (true, _) => RecordVerdict::Stored(true.into()),
                    (_, true) => RecordVerdict::Stored(false.into()),
                    _ => RecordVerdict::NotAChoice(vec!["true".into(), "false".into()]),
                }
            }
            (RecordType::Choice { values, or_text, text_words }, RecordValue::Text(t)) => {
                choice(values, or_text.then_some(*text_words), t)
            }
            // "exit 2" may be given by its number, where that is one of the words.
            (RecordType::Choice { values, .. }, RecordValue::Number(n)) => {
                let word = n.to_string();
                match values.iter().find(|v| v.words.contains(&word)) {
                    Some(v) => RecordVerdict::Stored(v.id.as_str().into()),
                    None => RecordVerdict::WrongType,
                }
            }
            (RecordType::Text, RecordValue::Text(t)) => RecordVerdict::Stored(t.trim().into()),
            // The passed road user may be given by its track number.
            (RecordType::Text, RecordValue::Number(n)) => RecordVerdict::Stored(n.into()),
            _ => RecordVerdict::WrongType,
        })
    }
}

/// A number, or a text that is one, with or without its unit.
fn number(value: RecordValue<'_>, min: f64, max: f64) -> RecordVerdict {
    let n = match value {
        RecordValue::Number(n) => Some(n),
        RecordValue::Text(t) => t.trim().parse().ok(),
        RecordValue::Flag(_) | RecordValue::Nested => None,
    };
    match n {
        None => RecordVerdict::WrongType,
        Some(n) if (min..=max).contains(&n) => {
            RecordVerdict::Stored(serde_json::Number::from_f64(n).map_or(Value::Null, Value::Number))
        }
        Some(_) => RecordVerdict::OutOfRange { min, max },
    }
}

/// `or_text`: other text is kept if it has at least this number of words.
fn choice(values: &[ChoiceValue], or_text: Option<usize>, text: &str) -> RecordVerdict {
    let text = text.trim();
    if let Some(v) = values.iter().find(|v| v.id == text) {
        return RecordVerdict::Stored(v.id.as_str().into());
    }
    let lower = text.to_lowercase();
    let found =
        values
            .iter()
            .flat_map(|v| v.words.iter().map(move |w| (w, v)))
            .filter(|(w, _)| {
                if or_text.is_some() { lower == w.to_lowercase() } else { lower.contains(&w.to_lowercase()) }
            })
            .max_by_key(|(w, _)| w.len());
    // "-3" is neither a word for the third nor a text.
    let bare = |t: &str| t.parse::<f64>().is_ok();
    let negative = text.starts_with('-') && text.split_whitespace().next().is_some_and(bare);
    // In Chinese a word has two characters.
    let words = match text.is_ascii() {
        true => text.split_whitespace().count(),
        false => text.chars().count() / 2,
    };
    let is_kept = or_text.is_some_and(|least| words >= least);
    match found {
        Some((_, v)) if !negative => RecordVerdict::Stored(v.id.as_str().into()),
        None if is_kept && !negative && !bare(text) => RecordVerdict::Stored(text.into()),
        _ => RecordVerdict::NotAChoice(values.iter().map(|v| v.id.clone()).collect()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Framework;
    use serde_json::json;

    #[test]
    fn values_are_typed_and_stored_without_language() {
        let f = Framework::bundled();
        let judge = |id: &str, v: Value| f.record_types.judge(id, RecordValue::of(&v).unwrap()).unwrap();
        let stored = |v: Value| RecordVerdict::Stored(v);
        assert_eq!(judge("grade", json!(-6.5)), stored(json!(-6.5)));
        assert_eq!(judge("grade", json!(-900)), RecordVerdict::OutOfRange { min: -35.0, max: 35.0 });
        assert_eq!(judge("grade", json!("steep")), RecordVerdict::WrongType);
        assert_eq!(judge("grade", json!("未知")), stored(json!("unknown")));
        assert_eq!(judge("has_traffic_light", json!("有")), stored(json!(true)));
        assert_eq!(judge("has_traffic_light", json!(false)), stored(json!(false)));
        assert!(matches!(judge("has_traffic_light", json!("香蕉")), RecordVerdict::NotAChoice(_)));
        assert_eq!(judge("lighting_change", json!("进入隧道后由亮变暗")), stored(json!("darker")));
        assert_eq!(judge("occlusion", json!("挡住了左侧路口")), stored(json!("挡住了左侧路口")));
        assert_eq!(judge("occlusion", json!(3)), RecordVerdict::WrongType);
        assert_eq!(judge("target_exit", json!("第二出口")), stored(json!("second")));
        assert_eq!(judge("target_exit", json!(2)), stored(json!("second")));
        for none in ["-3", "9", "12"] {
            assert!(matches!(judge("target_exit", json!(none)), RecordVerdict::NotAChoice(_)), "{none}");
        }
        assert!(matches!(judge("oncoming_traffic", json!("-4 cars")), RecordVerdict::NotAChoice(_)));
        assert_eq!(judge("oncoming_traffic", json!("4 cars")), stored(json!("4 cars")));
        assert_eq!(judge("oncoming_traffic", json!("Dense traffic")), stored(json!("dense")));
        assert_eq!(judge("merge_position", json!("匝道末端")), stored(json!("匝道末端")));
        assert_eq!(f.record_types.judge("no_such", RecordValue::Flag(true)), None);
    }

    #[test]
    fn a_broken_table_is_reported() {
        let (types, found) =
            RecordTypes::parse("r.yaml", "unknown: []\nrecords: { grade: { type: numeric } }\n");
        assert!(types.records.is_empty());
        assert_eq!((found.len(), found[0].code), (1, "spec.record_types"));
    }

    /// The page offers the choices of the spec; the same set is stored, checked and counted.
    #[test]
    fn every_record_of_a_spec_has_a_type_with_its_choices() {
        let f = Framework::bundled();
        for spec in f.specs.values() {
            for r in &spec.records {
                let kind = f.record_types.records.get(&r.id);
                assert!(kind.is_some(), "{}: {}", spec.leaf, r.id);
                assert_eq!(r.unit.is_some(), matches!(kind, Some(RecordType::Number { .. })), "{}", r.id);
                let offered: Vec<_> =
                    r.choices.iter().map(|c| c.id.as_str()).filter(|&c| c != UNKNOWN).collect();
                let typed: Vec<_> = match kind {
                    Some(RecordType::Choice { values, .. }) => values.iter().map(|v| v.id.as_str()).collect(),
                    Some(RecordType::Flag { .. }) => vec!["yes", "no"],
                    _ => Vec::new(),
                };
                assert_eq!(offered, typed, "{}: {}", spec.leaf, r.id);
            }
        }
    }
}
