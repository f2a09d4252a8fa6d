//! Types of the required records of a label (`scenarios/records.yaml`), and their stored form, which is independent of
//! the language. The labeling specs state which leaf requires which record.

use crate::spec::{RecordChoice, RecordSpec};
use crate::yaml_text;
use serde::Deserialize;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::{Bilingual, Diagnostic};

/// The stored value where the clip does not show it.
pub const UNKNOWN: &str = "unknown";
/// Ids of the choices of a record that is true or false.
const YES: &str = "yes";
const NO: &str = "no";

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

impl RecordType {
    /// The type that a labeling spec itself states: a number where there is a unit, one of its choices, else text. What
    /// is plausible and which other words stand for a choice is not known.
    pub fn of_spec(spec: &RecordSpec) -> Self {
        let words = |c: &RecordChoice| vec![c.id.clone(), c.name.zh.clone(), c.name.en.clone()];
        match offered(spec)[..] {
            [] if spec.unit.is_some() => Self::Number { min: f64::NEG_INFINITY, max: f64::INFINITY },
            [] => Self::Text,
            [yes, no] if (yes.id.as_str(), no.id.as_str()) == (YES, NO) => {
                Self::Flag { yes: words(yes), no: words(no) }
            }
            ref choices => Self::Choice {
                values: choices.iter().map(|c| ChoiceValue { id: c.id.clone(), words: words(c) }).collect(),
                or_text: false,
                text_words: 0,
            },
        }
    }

    /// How it differs from what a labeling spec states of the record, if it does.
    fn disagrees(&self, spec: &RecordSpec) -> Option<Bilingual> {
        let id = &spec.id;
        if spec.unit.is_some() != matches!(self, Self::Number { .. }) {
            return Some(match &spec.unit {
                Some(unit) => Bilingual::new(
                    format!(
                        "记录 '{id}' 在此处以 {unit} 为单位，scenarios/records.yaml 中的类型却不是 number"
                    ),
                    format!(
                        "record '{id}' is in {unit} here, but its type in scenarios/records.yaml is not number"
                    ),
                ),
                None => Bilingual::new(
                    format!("记录 '{id}' 在此处没有单位，scenarios/records.yaml 中的类型却是 number"),
                    format!(
                        "record '{id}' has no unit here, but its type in scenarios/records.yaml is number"
                    ),
                ),
            });
        }
        let here: BTreeSet<&str> = offered(spec).iter().map(|c| c.id.as_str()).collect();
        let there: BTreeSet<&str> = match self {
            Self::Choice { values, .. } => values.iter().map(|v| v.id.as_str()).collect(),
            Self::Flag { .. } => BTreeSet::from([YES, NO]),
            Self::Number { .. } | Self::Text => BTreeSet::new(),
        };
        let list = |ids: &BTreeSet<&str>| match ids.is_empty() {
            true => "-".to_owned(),
            false => ids.iter().copied().collect::<Vec<_>>().join(", "),
        };
        (here != there).then(|| {
            let (here, there) = (list(&here), list(&there));
            Bilingual::new(
                format!("记录 '{id}' 的选项在此处为 {here}，在 scenarios/records.yaml 中为 {there}"),
                format!("record '{id}' has the choices {here} here, but {there} in scenarios/records.yaml"),
            )
        })
    }
}

/// Choices of a record that state something.
fn offered(spec: &RecordSpec) -> Vec<&RecordChoice> {
    spec.choices.iter().filter(|c| c.id != UNKNOWN).collect()
}

impl RecordTypes {
    /// How the table differs from what a labeling spec states of a record, if it does; a record without an entry is
    /// checked by its spec alone.
    pub(crate) fn disagrees(&self, spec: &RecordSpec) -> Option<Bilingual> {
        let Some(kind) = self.records.get(&spec.id) else {
            let id = &spec.id;
            return Some(Bilingual::new(
                format!("scenarios/records.yaml 中没有记录 '{id}'：取值只按规格的单位和选项检查"),
                format!(
                    "scenarios/records.yaml has no record '{id}': its values are checked by the unit and the choices \
                     of the spec alone"
                ),
            ));
        };
        kind.disagrees(spec)
    }

    /// Gives each record without an entry the type that its spec states. Where two specs state different types, only
    /// text is left; different choices are joined.
    pub(crate) fn complete<'s>(&mut self, specs: impl Iterator<Item = &'s RecordSpec>) {
        let mut added: BTreeMap<String, RecordType> = BTreeMap::new();
        for spec in specs.filter(|spec| !self.records.contains_key(&spec.id)) {
            let stated = RecordType::of_spec(spec);
            match (added.get_mut(&spec.id), stated) {
                (None, stated) => drop(added.insert(spec.id.clone(), stated)),
                (Some(known), stated) if *known == stated => {}
                (Some(RecordType::Choice { values, .. }), RecordType::Choice { values: more, .. }) => {
                    let new: Vec<_> =
                        more.into_iter().filter(|m| values.iter().all(|v| v.id != m.id)).collect();
                    values.extend(new);
                }
                (Some(known), _) => *known = RecordType::Text,
            }
        }
        self.records.extend(added);
    }

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
        text == UNKNOWN || self.unknown.iter().any(|w| w.eq_ignore_ascii_case(text))
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
        let (table, _) = RecordTypes::parse("r.yaml", &Framework::bundled_files()["scenarios/records.yaml"]);
        for spec in f.specs.values() {
            for r in &spec.records {
                let kind = table.records.get(&r.id);
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

    /// The spec states a unit or choices (docs/reference/framework-files.md, `records`): they bind without an entry.
    #[test]
    fn a_record_without_an_entry_is_checked_by_its_spec_and_reported() {
        let mut files = Framework::bundled_files();
        let file = "scenarios/reactive_agent/cutin.yaml";
        let at =
            files[file].find("\n  urgent:\n    labeling:\n").unwrap() + "\n  urgent:\n    labeling:\n".len();
        let records = "      records:\n        - id: gap_taken\n          name: { zh: 所占间距, en: gap taken }\n          \
                       unit: m\n        - id: side_from\n          name: { zh: 切入方向, en: side }\n          \
                       choices:\n            - { id: left, name: { zh: 左侧, en: left } }\n            - { id: right, \
                       name: { zh: 右侧, en: right } }\n        - id: grade\n          name: { zh: 坡度, en: grade }\n";
        files.get_mut(file).unwrap().insert_str(at, records);
        let (framework, found) = Framework::from_files(&files);
        let framework = framework.unwrap();
        let said: Vec<(&str, &str, Option<&str>)> = found
            .iter()
            .map(|d| (d.code, d.message.en.split('\'').nth(1).unwrap(), d.location.file.as_deref()))
            .collect();
        let code = "spec.record.type";
        assert_eq!(
            said,
            [
                (code, "gap_taken", Some(file)),
                (code, "side_from", Some(file)),
                // Without a unit, although records.yaml has a range of numbers.
                (code, "grade", Some(file)),
            ]
        );
        let line = |id: &str| files[file].lines().position(|l| l.contains(&format!("id: {id}"))).unwrap() + 1;
        assert_eq!(found[0].location.line, Some(line("gap_taken")));
        let judge =
            |id: &str, v: Value| framework.record_types.judge(id, RecordValue::of(&v).unwrap()).unwrap();
        assert_eq!(judge("gap_taken", json!(12)), RecordVerdict::Stored(json!(12.0)));
        assert_eq!(judge("gap_taken", json!("十二")), RecordVerdict::WrongType);
        assert_eq!(judge("gap_taken", json!("12 s")), RecordVerdict::WrongType);
        assert_eq!(judge("gap_taken", json!("unknown")), RecordVerdict::Stored(json!("unknown")));
        assert_eq!(judge("side_from", json!("左侧")), RecordVerdict::Stored(json!("left")));
        assert_eq!(
            judge("side_from", json!("up")),
            RecordVerdict::NotAChoice(vec!["left".into(), "right".into()])
        );
    }
}
