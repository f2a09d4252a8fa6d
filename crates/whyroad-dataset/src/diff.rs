//! What differs between two releases: samples added, removed, moved between splits, relabeled, and the counts by
//! class.

use crate::sample::Lineage;
use crate::sample::schema::from_batch;
use crate::{DatasetError, Release};
use serde::Serialize;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Columns that are compared.
const COLUMNS: &[&str] =
    &["sample_id", "split", "scenario_id", "weight", "lineage", "label_json", "rejected"];

/// The difference; ids sorted.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Difference {
    /// Samples only in the second.
    pub added: Vec<String>,
    /// Samples only in the first.
    pub removed: Vec<String>,
    /// Samples in another split: id, from, to.
    pub moved: Vec<(String, String, String)>,
    /// Samples whose label has other content; the order of keys and the form of numbers are no content.
    pub relabelled: Vec<String>,
    /// Samples whose drive has other content.
    pub changed_drives: Vec<String>,
    /// Samples whose label has another state: id, from, to.
    pub restated: Vec<(String, String, String)>,
    /// Other facts about the labels, each with the number of samples where it differs: columns of `lineage`, and
    /// `rejected`.
    pub facts: BTreeMap<String, usize>,
    /// Per class the samples of the first and the second, where they differ.
    pub by_class: BTreeMap<String, (usize, usize)>,
    /// Fields of the spec that differ: path, first, second.
    pub spec: Vec<(String, String, String)>,
    /// Versions that differ: name, first, second.
    pub versions: Vec<(String, String, String)>,
}

struct Row {
    split: String,
    /// Hash of the label as a value.
    label: blake3::Hash,
    lineage: Lineage,
    /// Hash of the versions that were returned.
    rejected: blake3::Hash,
}

/// Columns of `lineage` that have a field of their own in [`Difference`], or follow from the label and the sample's id.
const OWN: &[&str] =
    &["drive_id", "drive_hash", "label_status", "label_sha256", "keyframe_time_ns", "keyframe_frame"];

impl Row {
    /// Names of the facts that differ.
    fn facts(&self, other: &Self) -> Vec<String> {
        let json = |row: &Self| serde_json::to_value(&row.lineage).unwrap_or_default();
        let (a, b) = (json(self), json(other));
        let differs = |name: &&String| a.get(*name) != b.get(*name) && !OWN.contains(&name.as_str());
        let mut out: Vec<String> =
            a.as_object().into_iter().flatten().map(|(name, _)| name).filter(differs).cloned().collect();
        if self.rejected != other.rejected {
            out.push("rejected".to_owned());
        }
        out
    }
}

/// Compares two releases.
///
/// # Errors
/// When one cannot be read.
pub fn diff(a: &Release, b: &Release) -> Result<Difference, DatasetError> {
    let (first, second) = (rows(a)?, rows(b)?);
    let mut out = Difference::default();
    for (id, row) in &second {
        match first.get(id) {
            None => out.added.push(id.clone()),
            Some(before) => {
                if before.split != row.split {
                    out.moved.push((id.clone(), before.split.clone(), row.split.clone()));
                }
                if before.label != row.label {
                    out.relabelled.push(id.clone());
                }
                let state = |row: &Row| row.lineage.label_status.clone();
                if state(before) != state(row) {
                    out.restated.push((id.clone(), state(before), state(row)));
                }
                for fact in before.facts(row) {
                    *out.facts.entry(fact).or_default() += 1;
                }
                if before.lineage.drive_hash != row.lineage.drive_hash {
                    out.changed_drives.push(id.clone());
                }
            }
        }
    }
    out.removed = first.keys().filter(|id| !second.contains_key(*id)).cloned().collect();
    let count =
        |r: &Release, class: &String| r.manifest.counts.by_class.get(class).map_or(0, |s| s.values().sum());
    let classes: BTreeSet<&String> =
        a.manifest.counts.by_class.keys().chain(b.manifest.counts.by_class.keys()).collect();
    for class in classes {
        let (x, y): (usize, usize) = (count(a, class), count(b, class));
        if x != y {
            out.by_class.insert(class.clone(), (x, y));
        }
    }
    let json = |r: &Release| serde_json::to_value(&r.manifest.spec).unwrap_or_default();
    compare("", &json(a), &json(b), &mut out.spec);
    let versions: BTreeSet<&String> = a.manifest.versions.keys().chain(b.manifest.versions.keys()).collect();
    for name in versions {
        let of = |r: &Release| r.manifest.versions.get(name).cloned().unwrap_or_default();
        if of(a) != of(b) {
            out.versions.push((name.clone(), of(a), of(b)));
        }
    }
    Ok(out)
}

fn rows(release: &Release) -> Result<BTreeMap<String, Row>, DatasetError> {
    let mut out = BTreeMap::new();
    for batch in release.batches(None, Some(COLUMNS)) {
        for s in from_batch(&batch?).map_err(|e| DatasetError::broken(release.dir(), e))? {
            let label = content_hash(&s.label_json);
            let mut rejected = blake3::Hasher::new();
            for r in &s.rejected {
                rejected.update(format!("{:?}", (&r.label_json, &r.trace, &r.reason)).as_bytes());
            }
            let row = Row { split: s.split, label, lineage: s.lineage, rejected: rejected.finalize() };
            out.insert(s.sample_id, row);
        }
    }
    Ok(out)
}

/// A hash that is equal for equal JSON values, however they are written; of a text that is not JSON, of the text.
pub fn content_hash(json: &str) -> blake3::Hash {
    let mut hash = blake3::Hasher::new();
    match serde_json::from_str(json) {
        Ok(value) => put(&value, &mut hash),
        Err(_) => drop(hash.update(json.as_bytes())),
    }
    hash.finalize()
}

fn put(value: &Value, hash: &mut blake3::Hasher) {
    match value {
        Value::Object(entries) => {
            let sorted: BTreeMap<&String, &Value> = entries.iter().collect();
            hash.update(b"{");
            for (key, value) in sorted {
                put(&Value::from(key.as_str()), hash);
                put(value, hash);
            }
            hash.update(b"}");
        }
        Value::Array(items) => {
            hash.update(b"[");
            items.iter().for_each(|item| put(item, hash));
            hash.update(b"]");
        }
        // 2 and 2.0 are one number.
        Value::Number(n) if n.is_f64() => {
            let n = n.as_f64().unwrap_or_default();
            let whole = n.fract() == 0.0 && n.abs() < 2.0_f64.powi(53);
            let text = if whole { (n as i64).to_string() } else { n.to_string() };
            hash.update(text.as_bytes()).update(b",");
        }
        // Texts are quoted and escaped, so that none can look like another value.
        _ => drop(hash.update(value.to_string().as_bytes()).update(b",")),
    }
}

fn compare(path: &str, a: &Value, b: &Value, out: &mut Vec<(String, String, String)>) {
    match (a, b) {
        (Value::Object(x), Value::Object(y)) => {
            let keys: BTreeSet<&String> = x.keys().chain(y.keys()).collect();
            for key in keys {
                let inner = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                let null = Value::Null;
                compare(&inner, x.get(key).unwrap_or(&null), y.get(key).unwrap_or(&null), out);
            }
        }
        _ if a == b => {}
        _ => out.push((path.to_owned(), a.to_string(), b.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// RFC 8259: an object is an unordered collection; white space and escapes are form.
    #[test]
    fn labels_are_compared_as_values() {
        let same = |a: &str, b: &str| content_hash(a) == content_hash(b);
        let label = r#"{"a": {"x": 1, "y": [1, 2]}, "b": "\u81ea\u8f66"}"#;
        assert!(same(label, r#"{"b":"自车","a":{"y":[1,2.0],"x":1.0}}"#));
        for other in [
            r#"{"b":"自车","a":{"y":[2,1],"x":1}}"#,
            r#"{"b":"自车","a":{"y":[1,2],"x":1.5}}"#,
            r#"{"b":"自车","a":{"y":[1,2]}}"#,
            r#"{"b":"自车","a":{"y":[1,2],"x":null}}"#,
            r#"{"b":"自车","a":{"y":[1,2],"x":"1"}}"#,
            r#"{"b":"自车","a":{"y":[12],"x":1}}"#,
        ] {
            assert!(!same(label, other), "{other}");
        }
        assert!(same("no JSON", "no JSON") && !same("no JSON", "{}"));
    }
}
