//! Labels in: JSON lines of the service's export (`tasks export --content tasks`), plain labels (DATA_FORMAT.md 4), or
//! episodes as `whyroad mine` writes them, which are drafted by rule when drafts are requested. Each line is kept or
//! dropped with a reason; kept lines go to a record file, and a short [`Item`] stays in memory. A label has no place
//! for the score and the id of its episode: where a stream has the episode itself, the label takes them from it.

use crate::DatasetError;
use crate::item::{Dropped, Item, SampleId, Stage};
use crate::records::{RecordRef, RecordWriter};
use crate::sample::Rejected;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::{HashMap, HashSet};
use std::io::BufRead;
use std::path::Path;
use whyroad_framework::Framework;
use whyroad_label::check::Checker;
use whyroad_label::episode_of;
use whyroad_model::messages::{CocLabel, DrivingDecision, EpisodeRecord, ProvenanceSource};
use whyroad_model::{Bilingual, Diagnostic, Lang, ScenarioId, Severity};

/// A stream of labels.
pub struct LabelStream {
    /// Its name in diagnostics and in the manifest.
    pub name: String,
    /// JSON lines.
    pub lines: Box<dyn BufRead + Send>,
}

/// State of labels that come from a plain file.
pub const IMPORTED: &str = "imported";
/// States of the labeling service in which a label is finished.
pub const FINISHED: &[&str] = &["accepted", "checked", "submitted", "rework"];
/// States of the labeling service in which people refused the clip: neither its label nor a draft of its episode is
/// used.
const REFUSED: &[&str] = &["rejected", "skipped"];
/// State of labels that no person has finished.
pub const DRAFT: &str = "draft";

/// One label on disk.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct LabelRecord {
    /// The label, or the episode that is to be drafted.
    pub json: String,
    pub is_episode: bool,
    pub episode_id: Option<String>,
    pub target_id: Option<String>,
    pub task_id: Option<String>,
    pub rule_version: Option<String>,
    pub score: Option<f64>,
    pub rejected: Vec<Rejected>,
}

impl LabelRecord {
    /// With the facts of its episode that it does not state itself.
    pub fn of_episode(self, episode: Self) -> Self {
        Self {
            episode_id: self.episode_id.or(episode.episode_id),
            target_id: self.target_id.or(episode.target_id),
            rule_version: self.rule_version.or(episode.rule_version),
            score: self.score.or(episode.score),
            ..self
        }
    }
}

/// A line that did not become a candidate.
#[derive(Clone, Debug)]
pub(crate) struct DroppedLine {
    pub line: String,
    pub clip_id: String,
    pub scenario_id: String,
    pub dropped: Dropped,
}

/// Names that items refer to by index.
#[derive(Clone, Debug, Default)]
pub(crate) struct Names {
    list: Vec<String>,
    index: HashMap<String, u32>,
}

impl Names {
    pub fn put(&mut self, name: &str) -> u32 {
        if let Some(&i) = self.index.get(name) {
            return i;
        }
        let i = self.list.len() as u32;
        self.list.push(name.to_owned());
        self.index.insert(name.to_owned(), i);
        i
    }
    pub fn get(&self, i: u32) -> &str {
        self.list.get(i as usize).map_or("", String::as_str)
    }
    pub fn all(&self) -> &[String] {
        &self.list
    }
}

/// All labels that were read.
pub(crate) struct Labels {
    pub items: Vec<Item>,
    pub drives: Names,
    pub classes: Names,
    pub statuses: Names,
    pub lines: usize,
    pub dropped: Vec<DroppedLine>,
    /// Items that are episodes, to be drafted.
    pub episodes: HashSet<SampleId>,
    pub diagnostics: Vec<Diagnostic>,
    /// Hash of all bytes.
    pub hash: String,
}

struct Read {
    record: LabelRecord,
    clip_id: String,
    scenario: ScenarioId,
    keyframe_ns: i64,
    status: String,
    checked: bool,
    lang: Option<Lang>,
    decision: Option<DrivingDecision>,
    drive: Option<String>,
}

/// Reads all streams. Labels are written to `records`.
pub(crate) fn read(
    streams: Vec<LabelStream>,
    framework: &Framework,
    records: &Path,
) -> Result<Labels, DatasetError> {
    let checker = Checker::new(framework);
    let mut out = Labels {
        items: Vec::new(),
        drives: Names::default(),
        classes: Names::default(),
        statuses: Names::default(),
        lines: 0,
        dropped: Vec::new(),
        episodes: HashSet::new(),
        diagnostics: Vec::new(),
        hash: String::new(),
    };
    let mut writer = RecordWriter::create(records)?;
    let mut hash = blake3::Hasher::new();
    let mut known: HashMap<SampleId, usize> = HashMap::new();
    let mut invalid: Vec<(String, Bilingual)> = Vec::new();
    for mut stream in streams {
        let (mut number, mut line) = (0, Vec::new());
        loop {
            line.clear();
            let path = Path::new(&stream.name).to_owned();
            if stream.lines.read_until(b'\n', &mut line).map_err(DatasetError::io(&path))? == 0 {
                break;
            }
            number += 1;
            hash.update(&line);
            if line.trim_ascii().is_empty() {
                continue;
            }
            out.lines += 1;
            let at = format!("{}:{number}", stream.name);
            match read_line(&line, &checker) {
                Ok(read) => {
                    let at_record = writer.append(&read.record)?;
                    out.put(read, at_record, &mut known, at);
                }
                Err(Fault { reason, message, clip_id, scenario_id }) => {
                    if reason == "invalid_label" {
                        invalid.push((at.clone(), message.clone()));
                    }
                    if reason == "unreadable" {
                        let d =
                            Diagnostic::warning("dataset.labels.line", message.clone()).in_file(at.clone());
                        out.diagnostics.push(d);
                    }
                    let dropped = Dropped::with(Stage::Select, reason, message.en);
                    out.dropped.push(DroppedLine { line: at, clip_id, scenario_id, dropped });
                }
            }
        }
    }
    writer.finish()?;
    report_invalid(&invalid, &mut out.diagnostics);
    out.hash = hash.finalize().to_hex().to_string();
    out.items.sort_by_key(|a| a.id);
    Ok(out)
}

/// Invalid labels that are named; the rest is counted.
const NAMED: usize = 10;

/// Labels that do not pass the checks, so that there is no sample of them.
fn report_invalid(invalid: &[(String, Bilingual)], out: &mut Vec<Diagnostic>) {
    let code = "dataset.labels.invalid";
    for (at, why) in invalid.iter().take(NAMED) {
        let message = Bilingual::new(
            format!("标签未通过校验，未收入：{}", why.zh),
            format!("the label does not validate and is left out: {}", why.en),
        );
        let hint = Bilingual::new(
            "用 `whyroad validate` 检查标签文件，它给出每个错误的位置",
            "run `whyroad validate` on the labels: it shows where each error is",
        );
        out.push(Diagnostic::warning(code, message).in_file(at.clone()).with_hint(hint));
    }
    let more = invalid.len().saturating_sub(NAMED);
    if more > 0 {
        let message = Bilingual::new(
            format!("另有 {more} 个标签未通过校验"),
            format!("{more} more labels do not validate"),
        );
        out.push(Diagnostic::warning(code, message));
    }
}

impl Labels {
    fn put(&mut self, read: Read, at: RecordRef, known: &mut HashMap<SampleId, usize>, line: String) {
        let drive_name = read.drive.clone().unwrap_or_else(|| drive_of(&read.clip_id).to_owned());
        let scenario = read.scenario.to_string();
        let id = sample_id(&drive_name, read.keyframe_ns, &scenario);
        let item = Item {
            id,
            label: at,
            other: None,
            episode: None,
            drive: self.drives.put(&drive_name),
            keyframe_ns: read.keyframe_ns,
            class: self.classes.put(&scenario),
            status: self.statuses.put(&read.status),
            checked: read.checked,
            score: read.record.score.map_or(f32::NAN, |s| s as f32),
            lang: read.lang,
            decision: read.decision,
            dropped: None,
            cut: None,
            split: None,
            component: 0,
            place_cell: u32::MAX,
            weight: 1.0,
        };
        let is_episode = read.record.is_episode;
        let Some(&i) = known.get(&id) else {
            if is_episode {
                self.episodes.insert(id);
            }
            known.insert(id, self.items.len());
            self.items.push(item);
            return;
        };
        // Two labels of one keyframe and class: one per language, the checked one first. Without a trace the language
        // is unknown: it is not the other one, and a label with a trace is taken before.
        let held = &mut self.items[i];
        let repeated = |detail: &str| DroppedLine {
            line: line.clone(),
            clip_id: read.clip_id.clone(),
            scenario_id: scenario.clone(),
            dropped: Dropped::with(Stage::Select, "repeated_label", detail),
        };
        // The episode that a label is about is no second label: the label is used, with the episode's facts.
        if is_episode != self.episodes.contains(&id) {
            if is_episode {
                // Of several road users at one moment the first one read counts, for score and facts alike.
                if held.episode.is_none() {
                    (held.episode, held.score) = (Some(at), first_known(held.score, item.score));
                }
            } else {
                let score = first_known(item.score, held.score);
                *held = Item { episode: Some(held.label), score, ..item };
                self.episodes.remove(&id);
            }
            self.dropped.push(repeated("the episode of a label"));
            return;
        }
        let [of_held, of_item] = [held.status, item.status].map(|status| self.statuses.get(status));
        let (was_refused, is_refused) = (REFUSED.contains(&of_held), REFUSED.contains(&of_item));
        if was_refused != is_refused {
            // A finished label of a clip that somebody else refused is used, a draft is not.
            let is_draft = if was_refused { of_item } else { of_held } == DRAFT;
            self.dropped.push(repeated("a task of the same keyframe and class was rejected or skipped"));
            if is_refused == is_draft {
                replace(held, item);
            }
            return;
        }
        let languages = held.lang.zip(item.lang);
        if languages.is_some_and(|(a, b)| a != b) && held.status == item.status && held.other.is_none() {
            if held.decision == item.decision {
                held.other = Some(item.label);
            } else {
                self.dropped
                    .push(repeated("the label in the other language, read before, has another decision"));
            }
        } else if item.checked && !held.checked {
            self.dropped.push(repeated("an earlier label of the same keyframe and class is not checked"));
            replace(held, item);
        } else if held.lang.is_none() && item.lang.is_some() && item.checked == held.checked {
            self.dropped.push(repeated("an earlier label of the same keyframe and class has no trace"));
            replace(held, item);
        } else {
            self.dropped.push(repeated("a label of the same keyframe and class was read before"));
        }
    }
}

/// Another label of the same keyframe and class, of the same episode.
fn replace(held: &mut Item, by: Item) {
    *held = Item { episode: held.episode, score: first_known(by.score, held.score), ..by };
}

/// The first score that is known; NaN is unknown.
fn first_known(a: f32, b: f32) -> f32 {
    if a.is_nan() { b } else { a }
}

/// Drive of a clip: clips are called `<drive>_<index>`.
pub(crate) fn drive_of(clip_id: &str) -> &str {
    clip_id.rsplit_once('_').map_or("", |(drive, _)| drive)
}

pub(crate) fn sample_id(drive: &str, keyframe_ns: i64, scenario: &str) -> SampleId {
    let mut hash = blake3::Hasher::new();
    hash.update(drive.as_bytes());
    hash.update(&[0]);
    hash.update(&keyframe_ns.to_le_bytes());
    hash.update(scenario.as_bytes());
    let mut id = [0; 8];
    id.copy_from_slice(&hash.finalize().as_bytes()[..8]);
    id
}

struct Fault {
    reason: &'static str,
    message: Bilingual,
    clip_id: String,
    scenario_id: String,
}

fn unreadable(zh: String, en: String) -> Fault {
    Fault {
        reason: "unreadable",
        message: Bilingual::new(zh, en),
        clip_id: String::new(),
        scenario_id: String::new(),
    }
}

fn read_line(line: &[u8], checker: &Checker<'_>) -> Result<Read, Fault> {
    let line = std::str::from_utf8(line)
        .map_err(|e| unreadable(format!("不是 UTF-8：{e}"), format!("not UTF-8: {e}")))?;
    let value: Value = serde_json::from_str(line.strip_prefix('\u{feff}').unwrap_or(line))
        .map_err(|e| unreadable(format!("不是 JSON：{e}"), format!("not JSON: {e}")))?;
    if let Some(task) = value.get("task") {
        return of_task(task, checker);
    }
    if value.get("episode_id").is_some() && value.get("conditions_matched").is_some() {
        return of_episode(value);
    }
    if value.get("clip_id").is_some() {
        return of_label(&value, LabelRecord::default(), None, checker);
    }
    Err(unreadable("既不是任务、事件，也不是标签".into(), "neither a task, an episode nor a label".into()))
}

fn of_episode(value: Value) -> Result<Read, Fault> {
    let json = value.to_string();
    let episode: EpisodeRecord = serde_json::from_value(value)
        .map_err(|e| unreadable(format!("不是事件：{e}"), format!("not an episode: {e}")))?;
    let fault = |reason, zh: &str, en: &str| Fault {
        reason,
        message: Bilingual::new(zh, en),
        clip_id: episode.clip_id.to_string(),
        scenario_id: episode.scenario_id.to_string(),
    };
    if !episode.is_primary {
        return Err(fault("secondary_episode", "次要事件", "a secondary episode"));
    }
    if episode.scenario_id.l2.is_none() {
        return Err(fault("class_unknown", "没有 L2", "the class is not known to the L2"));
    }
    Ok(Read {
        clip_id: episode.clip_id.to_string(),
        scenario: episode.scenario_id.clone(),
        keyframe_ns: episode.keyframe.timestamp.0,
        status: DRAFT.to_owned(),
        checked: false,
        lang: None,
        decision: None,
        drive: Some(episode.drive_id.0.clone()),
        record: LabelRecord {
            json,
            is_episode: true,
            episode_id: Some(episode.episode_id.clone()),
            target_id: episode.target_id.as_ref().map(ToString::to_string),
            score: Some(episode.score),
            rule_version: episode.rule_version.clone(),
            ..LabelRecord::default()
        },
    })
}

fn of_task(task: &Value, checker: &Checker<'_>) -> Result<Read, Fault> {
    let episode = episode_of::of_task(&task["episode"]).ok();
    let text = |v: &Value| v.as_str().map(str::to_owned);
    let record = LabelRecord {
        task_id: text(&task["id"]),
        // One made from the label says nothing about it: facts come from the mined episode, where it is read, too.
        episode_id: episode.as_ref().map(|e| e.episode_id.clone()).filter(|id| !episode_of::is_made(id)),
        target_id: episode.as_ref().and_then(|e| e.target_id.as_ref()).map(ToString::to_string),
        rule_version: episode.as_ref().and_then(|e| e.rule_version.clone()),
        score: episode.as_ref().and_then(episode_of::score),
        rejected: rejected(task),
        ..LabelRecord::default()
    };
    let fault = match task["adjudication"].as_str() {
        Some("superseded") => Some((
            "overruled",
            Bilingual::new("被同一事件的另一标签取代", "another label of the same episode was chosen"),
        )),
        Some("chosen") => None,
        _ if task["overlap_count"].as_i64().is_some_and(|n| n > 1) => Some((
            "not_chosen",
            Bilingual::new(
                "同一事件有多份标签，尚未采用其中一份",
                "there are several labels of the episode, of which none was chosen",
            ),
        )),
        _ => None,
    };
    if let Some((reason, message)) = fault {
        return Err(Fault {
            reason,
            message,
            clip_id: episode.as_ref().map(|e| e.clip_id.to_string()).unwrap_or_default(),
            scenario_id: episode.as_ref().map(|e| e.scenario_id.to_string()).unwrap_or_default(),
        });
    }
    let state = text(&task["state"]).unwrap_or_default();
    if let Some(episode) = episode.as_ref().filter(|_| REFUSED.contains(&state.as_str())) {
        return Ok(Read {
            clip_id: episode.clip_id.to_string(),
            scenario: episode.scenario_id.clone(),
            keyframe_ns: episode.keyframe.timestamp.0,
            status: state,
            checked: false,
            lang: None,
            decision: None,
            drive: Some(episode.drive_id.0.clone()),
            record,
        });
    }
    let mut read = of_label(&task["draft"], record, Some(state), checker)?;
    read.drive = episode.map(|e| e.drive_id.0);
    Ok(read)
}

/// Why a version was returned: the note, else the comments made with the return.
fn reason(task: &Value, entry: &Value) -> Option<String> {
    if let Some(note) = entry["note"].as_str().filter(|n| !n.is_empty()) {
        return Some(note.to_owned());
    }
    let comments = task["comments"].as_array().into_iter().flatten();
    let texts: Vec<String> = comments
        .filter(|c| c["at"] == entry["at"] && c["author"] == entry["actor"])
        .filter_map(|c| Some(format!("{}: {}", c["path"].as_str()?, c["text"].as_str()?)))
        .collect();
    (!texts.is_empty()).then(|| texts.join("; "))
}

/// Label versions that a checker or auditor returned: the last version before each return, with the note.
fn rejected(task: &Value) -> Vec<Rejected> {
    let mut out: Vec<Rejected> = Vec::new();
    let mut last: Option<&Value> = None;
    for entry in task["history"].as_array().into_iter().flatten() {
        if entry["draft"].is_object() {
            last = Some(&entry["draft"]);
        }
        // Not `reopen`: reopening an accepted label requests another review and rejects nothing yet.
        if entry["action"].as_str() == Some("send_back")
            && let Some(draft) = last
        {
            out.push(Rejected {
                label_json: draft.to_string(),
                trace: draft["coc_trace"].as_str().map(str::to_owned),
                reason: reason(task, entry),
            });
        }
    }
    out
}

fn of_label(
    value: &Value,
    record: LabelRecord,
    state: Option<String>,
    checker: &Checker<'_>,
) -> Result<Read, Fault> {
    let json = value.to_string();
    let clip_id = value["clip_id"].as_str().unwrap_or_default().to_owned();
    let label: CocLabel = serde_json::from_value(value.clone()).map_err(|e| Fault {
        reason: "invalid_label",
        message: Bilingual::new(format!("不是标签：{e}"), format!("not a label: {e}")),
        clip_id: clip_id.clone(),
        scenario_id: String::new(),
    })?;
    let by_program = label
        .provenance
        .as_ref()
        .is_some_and(|p| matches!(p.source, ProvenanceSource::Rule | ProvenanceSource::Model));
    let finished = state.as_deref().is_some_and(|state| FINISHED.contains(&state));
    let status = match state {
        Some(state) if finished => state,
        Some(_) => DRAFT.to_owned(),
        None if by_program => DRAFT.to_owned(),
        None => IMPORTED.to_owned(),
    };
    let scenario = ScenarioId {
        l1: label.scenario.l1.clone(),
        l2: Some(label.scenario.l2.clone()),
        l3: label.scenario.l3.clone(),
    };
    if status != DRAFT {
        let found = checker.check_text(&json);
        let errors: Vec<&str> =
            found.iter().filter(|d| d.severity == Severity::Error).map(|d| d.code).collect();
        if !errors.is_empty() {
            let codes = errors.join(", ");
            return Err(Fault {
                reason: "invalid_label",
                message: Bilingual::same(codes),
                clip_id,
                scenario_id: scenario.to_string(),
            });
        }
    }
    Ok(Read {
        clip_id,
        scenario,
        keyframe_ns: label.keyframe.timestamp.0,
        checked: status == "accepted",
        status,
        lang: language(&label.coc_trace),
        decision: Some(label.driving_decision),
        drive: None,
        record: LabelRecord { json, ..record },
    })
}

/// Language of a trace: Chinese where it has Chinese characters; unknown where it has no letters at all.
pub(crate) fn language(text: &str) -> Option<Lang> {
    let is_chinese = |c: char| ('\u{4e00}'..='\u{9fff}').contains(&c);
    match text.chars().any(is_chinese) {
        true => Some(Lang::Zh),
        false => text.chars().any(char::is_alphabetic).then_some(Lang::En),
    }
}

#[cfg(test)]
mod tests;
