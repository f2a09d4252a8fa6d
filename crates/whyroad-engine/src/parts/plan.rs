//! Work lists: the drives of a lake divided among workers by the rows from which signals are derived. Reads the
//! `drive.json` of each drive and no table.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::path::{Path, PathBuf};
use whyroad_lake::Lake;
use whyroad_model::DriveId;

const FORMAT: &str = "whyroad-work-list";

/// A plan that a list belongs to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlannedLake {
    /// Hash of the ids and contents of all drives of the plan.
    pub id: String,
    /// Number of lists.
    pub lists: usize,
    /// Number of drives in all lists.
    pub drives: usize,
}

/// A drive of a list.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlannedDrive {
    /// The drive.
    pub drive_id: DriveId,
    /// Its content when the plan was made; empty where that is unknown.
    pub content_hash: String,
    /// Rows of its frames and objects, from which signals are derived.
    pub rows: u64,
}

/// The drives for one worker.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorkList {
    /// `whyroad-work-list`.
    pub format: String,
    /// The plan; `None` for a list made by another program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plan: Option<PlannedLake>,
    /// Its number in the plan, from 1.
    #[serde(default)]
    pub list: usize,
    /// Its drives, by id.
    pub drives: Vec<PlannedDrive>,
}

/// A file is not a work list.
#[derive(Debug, thiserror::Error)]
pub enum WorkListError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}", .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Its reason.
        source: std::io::Error,
    },
    /// It is JSON, but not a work list.
    #[error("{} is not a work list: {reason}", .path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// A drive is named twice.
    #[error("{} names drive '{drive}' twice", .path.display())]
    Twice {
        /// The file.
        path: PathBuf,
        /// The drive.
        drive: DriveId,
    },
}

impl WorkList {
    /// Sum of its drives' rows.
    pub fn rows(&self) -> u64 {
        self.drives.iter().map(|d| d.rows).sum()
    }

    /// Reads a list: JSON from [`plan`], or one drive id per line.
    pub fn parse(text: &str, path: &Path) -> Result<Self, WorkListError> {
        let mut list = if text.trim_start().starts_with('{') {
            let invalid = |reason: String| WorkListError::Invalid { path: path.to_owned(), reason };
            let list: Self = serde_json::from_str(text).map_err(|e| invalid(e.to_string()))?;
            if list.format != FORMAT {
                return Err(invalid(format!("format '{}', expected '{FORMAT}'", list.format)));
            }
            list
        } else {
            let ids = text.lines().map(str::trim).filter(|line| !line.is_empty());
            let drive = |id: &str| PlannedDrive { drive_id: id.into(), content_hash: String::new(), rows: 0 };
            Self { format: FORMAT.to_owned(), plan: None, list: 0, drives: ids.map(drive).collect() }
        };
        list.drives.sort_by(|a, b| a.drive_id.cmp(&b.drive_id));
        match list.drives.windows(2).find(|w| w[0].drive_id == w[1].drive_id) {
            Some(w) => Err(WorkListError::Twice { path: path.to_owned(), drive: w[0].drive_id.clone() }),
            None => Ok(list),
        }
    }

    /// Reads the file of a list.
    pub fn read(path: &Path) -> Result<Self, WorkListError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| WorkListError::Io { path: path.to_owned(), source })?;
        Self::parse(&text, path)
    }
}

/// Divides all drives of a lake into `lists` lists. A drive whose size cannot be read is in a list too: the worker
/// reports it. The same lake gives the same lists.
pub fn plan(lake: &Lake, lists: usize) -> Vec<WorkList> {
    let size = |drive_id: DriveId| match lake.size(&drive_id) {
        Ok(s) => {
            let rows = s.frames.saturating_add(s.object_rows);
            PlannedDrive { drive_id, content_hash: s.content_hash, rows }
        }
        Err(_) => PlannedDrive { drive_id, content_hash: String::new(), rows: 0 },
    };
    divide(lake.drive_ids().into_par_iter().map(size).collect(), lists)
}

/// The largest drive first, each to the list that has the least so far: no list exceeds the best possible one by more
/// than a third (Graham 1969, longest processing time).
fn divide(drives: Vec<PlannedDrive>, lists: usize) -> Vec<WorkList> {
    let lists = lists.max(1);
    let plan = PlannedLake {
        id: plan_id(drives.iter().map(|d| (&d.drive_id, d.content_hash.as_str()))),
        lists,
        drives: drives.len(),
    };
    let empty = |i| WorkList { format: FORMAT.to_owned(), plan: Some(plan.clone()), list: i, drives: vec![] };
    let mut out: Vec<WorkList> = (1..=lists).map(empty).collect();
    // Drives without rows are spread too.
    let mut least: BinaryHeap<_> = (0..lists).map(|i| Reverse((0_u64, 0_usize, i))).collect();
    let mut drives = drives;
    drives.sort_by(|a, b| b.rows.cmp(&a.rows).then_with(|| a.drive_id.cmp(&b.drive_id)));
    for drive in drives {
        let Some(Reverse((rows, n, i))) = least.pop() else { break };
        least.push(Reverse((rows.saturating_add(drive.rows), n + 1, i)));
        out[i].drives.push(drive);
    }
    out.iter_mut().for_each(|list| list.drives.sort_by(|a, b| a.drive_id.cmp(&b.drive_id)));
    out
}

/// Hash of drives with their contents, in the order of the ids.
pub(super) fn plan_id<'a>(drives: impl Iterator<Item = (&'a DriveId, &'a str)>) -> String {
    let mut hasher = blake3::Hasher::new();
    for (id, content) in drives {
        hasher.update(format!("{id}\0{content}\n").as_bytes());
    }
    hasher.finalize().to_hex()[..32].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn drives(rows: &[u64]) -> Vec<PlannedDrive> {
        let one = |(i, rows): (usize, &u64)| PlannedDrive {
            drive_id: format!("d{i:04}").as_str().into(),
            content_hash: format!("h{i}"),
            rows: *rows,
        };
        rows.iter().enumerate().map(one).collect()
    }

    proptest! {
        #[test]
        fn every_drive_is_in_one_list_and_the_lists_are_balanced(
            rows in prop::collection::vec(0_u64..10_000, 0..60), n in 1_usize..9,
        ) {
            let lists = divide(drives(&rows), n);
            prop_assert_eq!(lists.len(), n);
            let all: Vec<&DriveId> = lists.iter().flat_map(|l| l.drives.iter().map(|d| &d.drive_id)).collect();
            prop_assert_eq!(all.len(), rows.len());
            prop_assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), rows.len());
            // Graham's bound against a lower bound of the optimum.
            let (sum, largest) = (rows.iter().sum::<u64>(), rows.iter().max().copied().unwrap_or(0));
            let optimum = (sum as f64 / n as f64).max(largest as f64);
            let heaviest = lists.iter().map(WorkList::rows).max().unwrap_or(0) as f64;
            prop_assert!(heaviest <= optimum + largest as f64, "{heaviest} {optimum}");
            let (most, least) = (lists.iter().map(WorkList::rows).max(), lists.iter().map(WorkList::rows).min());
            prop_assert!(most.unwrap() - least.unwrap() <= largest);
        }
    }

    #[test]
    fn a_list_is_read_as_json_or_as_lines_and_a_drive_twice_is_refused() {
        let list = divide(drives(&[5, 7, 3]), 2).remove(0);
        let text = serde_json::to_string(&list).unwrap();
        let path = Path::new("list");
        assert_eq!(WorkList::parse(&text, path).unwrap(), list);
        let ids = |text: &str| -> Vec<String> {
            let list = WorkList::parse(text, path).unwrap();
            list.drives.iter().map(|d| d.drive_id.to_string()).collect()
        };
        assert_eq!(ids("b\r\n\n a \n"), ["a", "b"]);
        assert!(matches!(WorkList::parse("a\na\n", path), Err(WorkListError::Twice { .. })));
        assert!(matches!(WorkList::parse("{}", path), Err(WorkListError::Invalid { .. })));
    }
}
