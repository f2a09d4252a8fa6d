//! What differs between two releases: samples added, removed, moved between splits, relabeled, and the counts by
//! class.

use crate::sample::schema::from_batch;
use crate::{DatasetError, Release};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Columns that are compared.
const COLUMNS: &[&str] = &["sample_id", "split", "scenario_id", "weight", "lineage"];

/// The difference; ids sorted.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Difference {
    /// Samples only in the second.
    pub added: Vec<String>,
    /// Samples only in the first.
    pub removed: Vec<String>,
    /// Samples in another split: id, from, to.
    pub moved: Vec<(String, String, String)>,
    /// Samples whose label has other content.
    pub relabelled: Vec<String>,
    /// Samples whose drive has other content.
    pub changed_drives: Vec<String>,
    /// Per class the samples of the first and the second, where they differ.
    pub by_class: BTreeMap<String, (usize, usize)>,
    /// Fields of the spec that differ: path, first, second.
    pub spec: Vec<(String, String, String)>,
    /// Versions that differ: name, first, second.
    pub versions: Vec<(String, String, String)>,
}

struct Row {
    split: String,
    label: String,
    drive: String,
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
                if before.drive != row.drive {
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
            let row = Row { split: s.split, label: s.lineage.label_sha256, drive: s.lineage.drive_hash };
            out.insert(s.sample_id, row);
        }
    }
    Ok(out)
}

fn compare(
    path: &str,
    a: &serde_json::Value,
    b: &serde_json::Value,
    out: &mut Vec<(String, String, String)>,
) {
    match (a, b) {
        (serde_json::Value::Object(x), serde_json::Value::Object(y)) => {
            let keys: BTreeSet<&String> = x.keys().chain(y.keys()).collect();
            for key in keys {
                let inner = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                let null = serde_json::Value::Null;
                compare(&inner, x.get(key).unwrap_or(&null), y.get(key).unwrap_or(&null), out);
            }
        }
        _ if a == b => {}
        _ => out.push((path.to_owned(), a.to_string(), b.to_string())),
    }
}
