//! The audit file of deletions: time, request and counts. No ids of drives: they can be personal data themselves.

use crate::output::reason::{Reason, cannot_write, reason};
use anyhow::Context as _;
use serde::Serialize;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};
use whyroad_model::Nanos;

/// Counts of deleted data, and the remaining copies.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Deleted {
    /// Requested drives.
    pub drives: usize,
    /// Of these, drives that were in the lake.
    pub lake_drives: usize,
    /// Mined folders that were written again; this and what follows is `None` where the place was not given.
    pub mined_folders: Option<usize>,
    /// Episodes in them.
    pub episodes: Option<usize>,
    /// Tasks in the store.
    pub tasks: Option<u64>,
    /// Other rows in the store.
    pub store_rows: Option<u64>,
    /// Camera images outside the lake's own folder.
    pub images: Option<usize>,
    /// Releases that hold a drive, by folder.
    pub releases: Vec<String>,
    /// Backups that hold a drive, by file.
    pub backups: Vec<String>,
    /// Parts of mining runs that hold a drive, by folder.
    pub parts: Vec<String>,
    /// Places that could not be searched.
    pub unsearched: Vec<String>,
}

#[derive(Serialize)]
struct Entry<'a> {
    at: String,
    state: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    request: Option<&'a str>,
    whyroad: &'a str,
    #[serde(flatten)]
    counts: &'a Deleted,
}

/// Adds a line to the file, on disk when this returns.
pub(super) fn put(file: &Path, state: &str, request: Option<&str>, counts: &Deleted) -> anyhow::Result<()> {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_nanos());
    let at = Nanos(i64::try_from(now).unwrap_or(i64::MAX)).to_string();
    let entry = Entry { at, state, request, whyroad: env!("CARGO_PKG_VERSION"), counts };
    let mut line = serde_json::to_string(&entry)?;
    line.push('\n');
    let cannot = || cannot_write(file.display());
    let mut out = OpenOptions::new().create(true).append(true).open(file).with_context(cannot)?;
    out.write_all(line.as_bytes()).and_then(|()| out.sync_all()).with_context(cannot)
}

/// True where the last entry belongs to a deletion that began and did not finish.
pub(super) fn unfinished(file: &Path) -> bool {
    let text = std::fs::read_to_string(file).unwrap_or_default();
    let last = text.lines().last().and_then(|l| serde_json::from_str::<serde_json::Value>(l).ok());
    last.is_some_and(|entry| entry["state"] == "begun")
}

/// A reference such as a ticket's number; free text is rejected.
pub(super) fn reference(text: &str) -> Result<String, Reason> {
    let fits = !text.is_empty()
        && text.len() <= 40
        && text.chars().all(|c| c.is_ascii_alphanumeric() || "-_.#/".contains(c));
    fits.then(|| text.to_owned()).ok_or_else(|| {
        reason("只能用字母、数字和 -_.#/，最多 40 个", "letters, digits and -_.#/, at most 40")
    })
}
