//! Files of causal texts: found, opened, and passed to the reader of their format.

use super::SourceFormat;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use whyroad_ingest::rows::read_rows;
use whyroad_label::import::{Reading, alpamayo2, auto_labeler, lerobot, ood_reasoning, unreadable};

/// How far below a named folder files are searched.
const SEARCH_DEPTH: usize = 8;

/// Name of the format on the command line.
pub(super) fn name(format: SourceFormat) -> &'static str {
    match format {
        SourceFormat::OodReasoning => "ood-reasoning",
        SourceFormat::AutoLabeler => "auto-labeler",
        SourceFormat::Alpamayo2 => "alpamayo2",
        SourceFormat::Lerobot => "lerobot",
    }
}

/// All texts in the paths.
pub(super) fn read(format: SourceFormat, paths: &[PathBuf]) -> Reading {
    let mut out = Reading::default();
    for path in paths {
        if format == SourceFormat::Lerobot {
            out.append(data_set(path));
            continue;
        }
        let mut files = Vec::new();
        if let Err(e) = search(path, SEARCH_DEPTH, &mut |file| files.push(file)) {
            out.diagnostics.push(unreadable(&path.display().to_string(), &e.to_string()));
        }
        files.retain(|file| path.is_file() || belongs(format, file));
        files.sort();
        if files.is_empty() {
            out.diagnostics
                .push(unreadable(&path.display().to_string(), &format!("no file of {} here", name(format))));
        }
        for file in files {
            out.append(one(format, &file));
        }
    }
    out
}

fn search(path: &Path, depth: usize, each: &mut dyn FnMut(PathBuf)) -> std::io::Result<()> {
    if path.is_dir() {
        if depth > 0 {
            for entry in fs::read_dir(path)? {
                search(&entry?.path(), depth - 1, each)?;
            }
        }
    } else {
        fs::metadata(path)?;
        each(path.to_owned());
    }
    Ok(())
}

fn part(name: Option<&std::ffi::OsStr>) -> String {
    name.unwrap_or_default().to_string_lossy().into_owned()
}

/// True for files of a folder that are of the format by their names.
fn belongs(format: SourceFormat, file: &Path) -> bool {
    let (stem, ending) = (part(file.file_stem()), part(file.extension()));
    let folder = part(file.parent().and_then(Path::file_name));
    match format {
        SourceFormat::OodReasoning => ending == "parquet" && stem.contains("reasoning"),
        SourceFormat::AutoLabeler => {
            (ending == "yaml" && stem.starts_with("cot_")) || (ending == "txt" && folder == "final_outputs")
        }
        SourceFormat::Alpamayo2 => ending == "json" || ending == "jsonl",
        SourceFormat::Lerobot => false,
    }
}

fn one(format: SourceFormat, file: &Path) -> Reading {
    let label = file.display().to_string();
    if format == SourceFormat::OodReasoning {
        return match read_rows(file, None) {
            Ok(rows) => ood_reasoning::read(&label, &rows),
            Err(reason) => failed(&label, &reason),
        };
    }
    let content = match fs::read_to_string(file) {
        Ok(content) => content,
        Err(e) => return failed(&label, &e.to_string()),
    };
    let stem = part(file.file_stem());
    match format {
        SourceFormat::Alpamayo2 => alpamayo2::read(&label, &stem, &content),
        _ if part(file.extension()) == "txt" => auto_labeler::read_meta_actions(&label, &content),
        _ => {
            let clip = part(file.parent().and_then(Path::file_name));
            auto_labeler::read_text(&label, &clip, &stem, &content)
        }
    }
}

fn failed(file: &str, reason: &str) -> Reading {
    Reading { diagnostics: vec![unreadable(file, reason)], ..Reading::default() }
}

/// A LeRobot v3 data set: `meta/tasks.parquet` and the data's files, in order.
fn data_set(root: &Path) -> Reading {
    let label = root.display().to_string();
    let tasks = match read_tasks(&root.join("meta/tasks.parquet")) {
        Ok(tasks) => tasks,
        Err(reason) => return failed(&label, &format!("meta/tasks.parquet: {reason}")),
    };
    let mut files = Vec::new();
    if let Err(e) = search(&root.join("data"), SEARCH_DEPTH, &mut |file| files.push(file)) {
        return failed(&label, &format!("data: {e}"));
    }
    files.retain(|f| part(f.extension()) == "parquet");
    files.sort();
    let (mut out, mut rows) = (Reading::default(), Vec::new());
    for file in &files {
        match read_rows(file, Some(&lerobot::DATA_COLUMNS)) {
            Ok(more) => rows.extend(more),
            Err(reason) => out.append(failed(&file.display().to_string(), &reason)),
        }
    }
    // Together: an episode may continue in the next file.
    out.append(lerobot::read(&root.join("data").display().to_string(), &rows, &tasks));
    out
}

/// Texts of tasks by index. pandas writes the text as the index of the table.
fn read_tasks(file: &Path) -> Result<BTreeMap<i64, String>, String> {
    let rows = read_rows(file, None)?;
    let task = |row: &serde_json::Map<String, serde_json::Value>| {
        let text = ["task", "__index_level_0__"].iter().find_map(|name| row.get(*name)?.as_str())?;
        Some((row.get("task_index")?.as_i64()?, text.to_owned()))
    };
    Ok(rows.iter().filter_map(task).collect())
}
