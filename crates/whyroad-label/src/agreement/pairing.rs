//! Finds the labels of one episode by several people: in two exports, by clip and nearest keyframe; or in tasks of the
//! labeling service, by episode.

use serde_json::Value;
use std::collections::BTreeMap;
use whyroad_model::Nanos;
use whyroad_model::messages::CocLabel;

/// Keyframes of one clip farther apart than this are of different episodes, s.
const SAME_EPISODE_S: f64 = 5.0;

/// A label and its rater.
#[derive(Clone, Debug, PartialEq)]
pub struct RatedLabel {
    /// The rater: the name of a file or of an annotator.
    pub rater: String,
    /// The label.
    pub label: CocLabel,
}

/// An episode with the labels of two or more raters, sorted by rater.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// Id of the episode, or clip and keyframe.
    pub id: String,
    /// One label per rater.
    pub labels: Vec<RatedLabel>,
}

/// Result of pairing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Judged {
    /// Episodes with two or more labels.
    pub items: Vec<Item>,
    /// Labels of episodes that only one rater has.
    pub unmatched: usize,
    /// Tasks whose label nobody has submitted yet.
    pub waiting: usize,
    /// Tasks that were skipped or rejected before a label was submitted: there will be none.
    pub left_out: usize,
    /// Lines without a readable label.
    pub unreadable: usize,
}

/// Pairs the labels of two files: within a clip the nearest keyframes first, one to one.
pub fn pair_files(first: (&str, &[Value]), second: (&str, &[Value])) -> Judged {
    let mut out = Judged::default();
    let mut by_clip: BTreeMap<String, [Vec<CocLabel>; 2]> = BTreeMap::new();
    for (side, (_, documents)) in [first, second].into_iter().enumerate() {
        for document in documents {
            match label_of(document) {
                Some(label) => by_clip.entry(label.clip_id.clone()).or_default()[side].push(label),
                None => out.unreadable += 1,
            }
        }
    }
    for (clip, [left, right]) in by_clip {
        let mut gaps: Vec<(f64, usize, usize)> = Vec::new();
        for (i, a) in left.iter().enumerate() {
            for (j, b) in right.iter().enumerate() {
                let gap = a.keyframe.timestamp.seconds_since(b.keyframe.timestamp).abs();
                if gap <= SAME_EPISODE_S {
                    gaps.push((gap, i, j));
                }
            }
        }
        gaps.sort_by(|x, y| x.0.total_cmp(&y.0).then_with(|| (x.1, x.2).cmp(&(y.1, y.2))));
        let (mut used, mut pairs) = ([vec![false; left.len()], vec![false; right.len()]], 0);
        for (_, i, j) in gaps {
            if used[0][i] || used[1][j] {
                continue;
            }
            (used[0][i], used[1][j]) = (true, true);
            pairs += 1;
            let rated =
                |rater: &str, label: &CocLabel| RatedLabel { rater: rater.to_owned(), label: label.clone() };
            let id = format!("{clip} @ {}", left[i].keyframe.timestamp);
            out.items.push(Item { id, labels: vec![rated(first.0, &left[i]), rated(second.0, &right[j])] });
        }
        out.unmatched += left.len() + right.len() - 2 * pairs;
    }
    out.items.sort_by(|a, b| a.id.cmp(&b.id));
    out
}

/// Groups the lines of `tasks export --content tasks` by episode. Only submitted labels count, each as its author first
/// submitted it: a label that a checker has returned is no longer independent.
pub fn pair_tasks(lines: &[Value]) -> Judged {
    let mut out = Judged::default();
    let mut by_episode: BTreeMap<String, BTreeMap<String, CocLabel>> = BTreeMap::new();
    for line in lines {
        let task = line.get("task").unwrap_or(line);
        if submission(task).is_none() {
            let state = task.get("state").and_then(Value::as_str).unwrap_or_default();
            let count = match state {
                _ if NOT_YET_SUBMITTED.contains(&state) => Some(&mut out.waiting),
                _ if LEFT_OUT.contains(&state) => Some(&mut out.left_out),
                _ => None,
            };
            if let Some(count) = count {
                *count += 1;
                continue;
            }
        }
        let Some(label) = first_label(task) else {
            out.unreadable += 1;
            continue;
        };
        let episode = task.pointer("/episode/episode_id").and_then(Value::as_str);
        let author = task.get("author").and_then(Value::as_str);
        let Some((episode, author)) = episode.zip(author) else {
            out.unreadable += 1;
            continue;
        };
        by_episode.entry(episode.to_owned()).or_default().entry(author.to_owned()).or_insert(label);
    }
    for (id, labels) in by_episode {
        if labels.len() < 2 {
            out.unmatched += labels.len();
            continue;
        }
        let labels = labels.into_iter().map(|(rater, label)| RatedLabel { rater, label }).collect();
        out.items.push(Item { id, labels });
    }
    out
}

/// States of tasks whose label is still to be submitted, where the history has no submission.
const NOT_YET_SUBMITTED: [&str; 4] = ["open", "stage1", "stage1_locked", "stage2"];
/// States of tasks of which there will be no label.
const LEFT_OUT: [&str; 2] = ["skipped", "rejected"];

/// The entry of the history that has the label as first submitted.
fn submission(task: &Value) -> Option<&Value> {
    task.get("history").and_then(Value::as_array).into_iter().flatten().find(|e| {
        e.get("action").and_then(Value::as_str) == Some("submit")
            && e.get("draft").is_some_and(Value::is_object)
    })
}

/// The label as first submitted, if the history has it; else the current label.
fn first_label(task: &Value) -> Option<CocLabel> {
    match submission(task) {
        Some(entry) => label_of(entry.get("draft")?),
        None => label_of(task.get("draft").or_else(|| task.get("label"))?),
    }
}

fn label_of(document: &Value) -> Option<CocLabel> {
    let label = document.pointer("/task/draft").or_else(|| document.get("label")).unwrap_or(document);
    serde_json::from_value(label.clone()).ok()
}

/// A moment within its clip, s.
pub(super) fn seconds_in_clip(label: &CocLabel) -> f64 {
    f64::from(label.keyframe.frame_idx) / whyroad_model::scene::FRAME_RATE_HZ
}

/// The moment of a label.
pub(super) fn moment(label: &CocLabel) -> Nanos {
    label.keyframe.timestamp
}
