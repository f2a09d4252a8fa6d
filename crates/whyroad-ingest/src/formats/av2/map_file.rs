//! The vector map of a log folder: its file, and reading it with a report.

use super::{findings, map};
use crate::encodings::input::Input;
use crate::report::SourceReport;
use crate::source::{ContentHash, file_label};
use std::fs;
use std::path::{Path, PathBuf};
use whyroad_model::RoadMap;

/// The vector map in this folder.
pub(super) fn map_file(dir: &Path) -> Option<PathBuf> {
    let entries = fs::read_dir(dir).ok()?;
    let is_map = |p: &PathBuf| {
        p.file_name().is_some_and(|n| {
            let n = n.to_string_lossy();
            n.starts_with("log_map_archive_") && n.ends_with(".json")
        })
    };
    entries.flatten().map(|e| e.path()).filter(is_map).min()
}

/// The map and its name.
pub(crate) fn read_map(
    dir: &Path,
    hash: &mut ContentHash,
    report: &mut SourceReport,
) -> (Option<RoadMap>, Option<String>) {
    let Some(file) = map_file(dir) else {
        report.diagnostics.push(findings::map_missing(&dir.display().to_string()));
        return (None, None);
    };
    let label = file.display().to_string();
    // The name ends in `____<city>_city_<number>`, which states its location; its beginning repeats the log's id.
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let map_ref = stem.split("____").last().unwrap_or(&stem).to_owned();
    let read = Input::from(&file).text().map_err(|e| e.to_string()).and_then(|text| {
        hash.add(&file_label(&file), text.as_bytes());
        map::read(&text)
    });
    match read {
        Ok(r) => {
            report.diagnostics.extend(findings::of_map(&label, &r));
            report.tables.push(r.count);
            (Some(r.map), Some(map_ref))
        }
        Err(reason) => {
            report.diagnostics.push(findings::map_unreadable(&label, &reason));
            (None, None)
        }
    }
}
