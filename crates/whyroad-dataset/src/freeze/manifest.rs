//! `manifest.json`: contents, tools, inputs and counts of a release.

use crate::balance::BalanceReport;
use crate::dedup::DedupReport;
use crate::spec::Spec;
use crate::split::SplitReport;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Value of `format`.
pub const FORMAT: &str = "whyroad-release";
/// Version of the release's layout.
pub const FORMAT_VERSION: &str = "1.0.0";

/// The manifest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// [`FORMAT`].
    pub format: String,
    /// [`FORMAT_VERSION`].
    pub format_version: String,
    /// Version of the sample's columns.
    pub sample_version: String,
    /// Name of the release.
    pub name: String,
    /// Version of the release.
    pub version: String,
    /// Displayed title.
    pub title: Option<String>,
    /// Program and version.
    pub created_by: String,
    /// Versions of `taxonomy`, `messages`, `signals`, `licences`, `lake`.
    pub versions: BTreeMap<String, String>,
    /// Seed.
    pub seed: u64,
    /// The license that the release declares.
    pub licence: String,
    /// Licenses of the drives in it.
    pub licences: Vec<LicenceCount>,
    /// Inputs.
    pub inputs: Inputs,
    /// Counts.
    pub counts: Counts,
    /// Distances between splits, groups.
    pub split: SplitReport,
    /// Duplicates.
    pub deduplicate: DedupReport,
    /// Caps and shortfalls.
    pub balance: BalanceReport,
    /// The spec in force.
    pub spec: Spec,
    /// Every file except this one and the checksums, by path.
    pub files: Vec<FileEntry>,
}

/// A license and the amount of data under it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LicenceCount {
    /// Id.
    pub id: String,
    /// Its text.
    pub url: Option<String>,
    /// Its obligations.
    pub attribution: Option<String>,
    /// Drives in the release.
    pub drives: usize,
    /// Of these, drives that state no license: the spec assumes it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub assumed: usize,
    /// Samples in the release.
    pub samples: usize,
}

fn is_zero(n: &usize) -> bool {
    *n == 0
}

/// Inputs of a release.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Inputs {
    /// Names of the label streams, without folders.
    pub labels: Vec<String>,
    /// Lines read.
    pub label_lines: usize,
    /// BLAKE3 of all lines.
    pub labels_hash: String,
    /// Drives whose labels were used.
    pub drives: usize,
    /// BLAKE3 over ids and content hashes of those drives.
    pub drives_hash: String,
}

/// Counts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counts {
    /// Samples.
    pub samples: usize,
    /// Samples per split.
    pub by_split: BTreeMap<String, usize>,
    /// Samples per class and split.
    pub by_class: BTreeMap<String, BTreeMap<String, usize>>,
    /// Samples per place (`unknown` where the drive states none).
    pub by_place: BTreeMap<String, usize>,
    /// Samples per pair of decisions.
    pub by_decision: BTreeMap<String, usize>,
    /// Samples per state of the label.
    pub by_status: BTreeMap<String, usize>,
    /// Images.
    pub images: usize,
    /// Candidates dropped, per stage and reason.
    pub dropped: BTreeMap<String, BTreeMap<String, usize>>,
    /// Groups of near-identical traces, and traces in them.
    pub alike_traces: [usize; 2],
}

/// A file of the release.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FileEntry {
    /// Relative path with `/`.
    pub path: String,
    /// Length.
    pub bytes: u64,
    /// SHA-256.
    pub sha256: String,
    /// Samples in it, for data files.
    pub samples: Option<usize>,
}
