//! LeRobot v3 data sets: the language columns (`language_persistent`, `language_events`) and, for data sets that have
//! only these, the texts of tasks (L2D: what the driver was asked to do). An episode is the clip `episode_NNNNNN`.

use super::{Reading, Reasoning, Row, findings, text, whole};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Columns of the data that are read.
pub const DATA_COLUMNS: [&str; 5] =
    ["episode_index", "timestamp", "task_index", "language_persistent", "language_events"];
/// Styles of rows that state a reason; the others (motion, questions and answers, ...) are counted.
const CAUSAL_STYLES: [&str; 4] = ["plan", "coc", "reasoning", "trace"];

/// Name of an episode.
pub fn clip_of(episode: i64) -> String {
    format!("episode_{episode:06}")
}

/// Reads rows of the data, and texts of tasks by their index. A text that is repeated over many frames is one text.
pub fn read(file: &str, rows: &[Row], tasks: &BTreeMap<i64, String>) -> Reading {
    let mut out = Reading::default();
    let mut seen = BTreeSet::new();
    let mut with_language = BTreeSet::new();
    let mut task_of = BTreeMap::new();
    for (i, row) in rows.iter().enumerate() {
        let origin = format!("{file}#{}", i + 1);
        let (Some(episode), Some(at_s)) = (whole(row.get("episode_index")), seconds(row.get("timestamp")))
        else {
            out.diagnostics.push(findings::no_time(&origin));
            continue;
        };
        task_of.entry(episode).or_insert_with(|| (origin.clone(), at_s, whole(row.get("task_index"))));
        for column in ["language_persistent", "language_events"] {
            for entry in row.get(column).and_then(Value::as_array).into_iter().flatten() {
                if add(&mut out, &mut seen, &origin, episode, at_s, entry) {
                    with_language.insert(episode);
                }
            }
        }
    }
    for (episode, (origin, at_s, task)) in task_of.into_iter().filter(|(e, _)| !with_language.contains(e)) {
        match task.and_then(|t| tasks.get(&t)).filter(|t| !t.trim().is_empty()) {
            Some(words) => out.found.push(reasoning(&origin, episode, at_s, words.trim())),
            None => out.diagnostics.push(findings::no_text(&origin)),
        }
    }
    out
}

fn seconds(value: Option<&Value>) -> Option<f64> {
    // A float32 written as a double: rounding to the microsecond restores the intended value.
    value.and_then(Value::as_f64).filter(|s| s.is_finite() && s.abs() < 1e6)
}

fn reasoning(origin: &str, episode: i64, at_s: f64, words: &str) -> Reasoning {
    Reasoning {
        origin: origin.to_owned(),
        clip: clip_of(episode),
        at_us: (at_s * 1e6).round() as i64,
        until_us: None,
        text: words.to_owned(),
        components: Vec::new(),
        versions: BTreeMap::new(),
    }
}

/// Adds one row of a language column; true when it is a causal text.
fn add(
    out: &mut Reading,
    seen: &mut BTreeSet<(i64, String, String, i64)>,
    origin: &str,
    episode: i64,
    frame_s: f64,
    entry: &Value,
) -> bool {
    let style = text(entry.get("style")).unwrap_or_default();
    let Some(words) = text(entry.get("content")) else { return false };
    // Persistent rows have their own time: the time of their beginning.
    let at_s = seconds(entry.get("timestamp")).unwrap_or(frame_s);
    let one = reasoning(origin, episode, at_s, &words);
    if !seen.insert((episode, style.clone(), words, one.at_us)) {
        return CAUSAL_STYLES.contains(&style.as_str());
    }
    if entry.get("tool_calls").is_some_and(|t| !t.is_null()) {
        out.leave_out("language.tool_calls");
    }
    if text(entry.get("camera")).is_some() {
        out.leave_out("language.camera");
    }
    let causal =
        CAUSAL_STYLES.contains(&style.as_str()) && text(entry.get("role")).as_deref() != Some("user");
    if causal {
        out.found.push(one);
    } else {
        out.leave_out(format!("language.style.{style}"));
    }
    causal
}
