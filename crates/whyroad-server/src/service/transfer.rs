//! Export and import of labels and tasks, as JSON lines, at any time.
//!
//! Export: labels in the exchange format (DATA_FORMAT.md 4), 2.1 or 2.0; or whole tasks with their history and
//! comments. Import: episodes and tasks become open tasks, labels become drafts of open tasks. Imported data never
//! skips the workflow: an imported label is a proposal that is labeled, checked and accepted like any other.

mod read;
mod task_lines;

use crate::app::App;
use crate::domain::project::Project;
use crate::domain::task::{Imported, LostLine};
use crate::domain::workflow::State;
use crate::problem::{Answer, Problem};
use crate::service::copies::NOT_GOLD;
use crate::service::create::{self, LastDrive};
use crate::service::disagreement::{NOT_SUPERSEDED, STANDS, TO_CHOOSE};
use crate::service::known::KnownEpisodes;
use crate::service::projects;
use crate::service::tasks::{self, TaskRow};
use crate::store::{Store, Tx};
use crate::values;
use read::{Incoming, read_line};
use std::collections::{BTreeMap, HashMap};
use std::io::Write;
use whyroad_model::messages::CocLabel;
use whyroad_model::{Bilingual, Diagnostic};

/// Maximum number of lines of one import.
pub const MOST_LINES: usize = 20_000;
/// Maximum number of reported reasons for unreadable lines; the rest is counted.
const MOST_REASONS: usize = 100;

/// Code of the report that an export leaves out episodes of which no label was chosen.
pub const NOT_CHOSEN: &str = "export.not_chosen";

/// What to export.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ExportFormat {
    /// Labels of tasks in these states, in this format version.
    Labels(Vec<State>, LabelVersion),
    /// All tasks, with history and comments.
    Tasks,
}

/// Format of exported labels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LabelVersion {
    /// 2.0.0.
    V2_0,
    /// 2.1.0.
    V2_1,
}

impl ExportFormat {
    /// From the values in a request: `labels` or `tasks`; `2.0` or `2.1`; states separated by commas.
    pub fn from_words(format: Option<&str>, version: Option<&str>, states: Option<&str>) -> Answer<Self> {
        let version = match version {
            None | Some("2.1" | "2.1.0") => LabelVersion::V2_1,
            Some("2.0" | "2.0.0") => LabelVersion::V2_0,
            Some(other) => {
                return Err(Problem::request(
                    format!("'{other}' 不是格式版本：2.0 或 2.1"),
                    format!("'{other}' is not a format version (2.0 or 2.1)"),
                ));
            }
        };
        let state = |word: &str| {
            State::from_word(word).ok_or_else(|| {
                Problem::request(format!("'{word}' 不是任务状态"), format!("'{word}' is not a task state"))
            })
        };
        let states = match states {
            None | Some("") => vec![State::Accepted],
            Some(words) => words.split(',').map(state).collect::<Answer<_>>()?,
        };
        match format {
            None | Some("labels") => Ok(Self::Labels(states, version)),
            Some("tasks") => Ok(Self::Tasks),
            Some(other) => Err(Problem::request(
                format!("'{other}' 不是导出类型：labels 或 tasks"),
                format!("'{other}' is not an export type (labels or tasks)"),
            )),
        }
    }

    /// What the file contains: labels with their states and format version, or tasks.
    pub fn file_stem(&self) -> String {
        match self {
            Self::Tasks => "tasks".to_owned(),
            Self::Labels(states, version) => {
                let states: Vec<&str> = states.iter().map(|s| s.word()).collect();
                let version = match version {
                    LabelVersion::V2_0 => "2.0",
                    LabelVersion::V2_1 => "2.1",
                };
                format!("labels-{}-{version}", states.join("+"))
            }
        }
    }
}

/// Number of labels read in one transaction: an export does not block the work of others, and holds no connection while
/// its receiver is slow.
const EXPORTED_AT_ONCE: usize = 200;
/// A transaction ends once it has read this much, bytes.
const BYTES_AT_ONCE: usize = 1 << 18;

/// Writes the lines of an export, by clip, then class, then number in the overlap group; each task in its state when
/// its turn comes. The export is never completely in memory.
pub fn export_to(store: &Store, project: &str, format: &ExportFormat, out: &mut dyn Write) -> Answer<()> {
    let ids = store.report(|tx| exported_ids(tx, project, format))?;
    match format {
        ExportFormat::Tasks => task_lines::write(store, &ids, &store.report(user_names)?, out),
        ExportFormat::Labels(_, version) => label_lines(store, &ids, *version, out),
    }
}

fn label_lines(store: &Store, ids: &[String], version: LabelVersion, out: &mut dyn Write) -> Answer<()> {
    let mut rest = ids;
    while !rest.is_empty() {
        let (text, lines) = store.report(|tx| {
            let (mut text, mut lines) = (String::new(), 0);
            for id in rest.iter().take(EXPORTED_AT_ONCE) {
                let row = tx.row("SELECT draft FROM tasks WHERE id = $1", values![id])?;
                text.push_str(&label_line(row.ok_or_else(Problem::missing)?.text("draft")?, version)?);
                text.push('\n');
                lines += 1;
                if text.len() >= BYTES_AT_ONCE {
                    break;
                }
            }
            Ok((text, lines))
        })?;
        out.write_all(text.as_bytes()).map_err(Problem::store)?;
        rest = &rest[lines..];
    }
    Ok(())
}

/// Episodes that an export of labels leaves out because they have several labels and none was chosen: those that wait
/// for a choice, and those with a label in a state of the export.
pub fn not_chosen(tx: &mut dyn Tx, project: &str, format: &ExportFormat) -> Answer<i64> {
    let ExportFormat::Labels(states, _) = format else { return Ok(0) };
    let states: Vec<String> = states.iter().map(|s| format!("'{}'", s.word())).collect();
    let sql = format!(
        "SELECT count(DISTINCT episode_id) AS n FROM tasks
         WHERE project_id = $1 AND overlap_count > 1 AND adjudication IS NULL AND {NOT_GOLD}
           AND (({TO_CHOOSE}) OR state IN ({}))
           AND NOT EXISTS (SELECT 1 FROM tasks c WHERE c.project_id = tasks.project_id
             AND c.episode_id = tasks.episode_id AND c.adjudication = 'chosen')",
        states.join(", ")
    );
    tx.row(&sql, values![project])?.map_or(Ok(0), |r| r.int("n"))
}

/// What is reported with an export that leaves out `episodes` because no label of them was chosen.
pub fn report_not_chosen(episodes: i64) -> Diagnostic {
    let message = Bilingual::new(
        format!("{episodes} 个事件有多份独立标注，尚未采用其中一份：未导出"),
        format!(
            "{} several independent labels of which none was chosen: not exported",
            if episodes == 1 { "1 episode has".to_owned() } else { format!("{episodes} episodes have") }
        ),
    );
    let hint = Bilingual::new(
        "由负责人采用：页面“任务”中的“待采用”，或 POST /tasks/{t}/actions {\"action\": \"adjudicate\"}；\
         尚未标注的份先标注或跳过",
        "a lead chooses one: under Tasks, \"to choose\", or by POST /tasks/{t}/actions {\"action\": \"adjudicate\"}; \
         copies that are not labeled yet are labeled or skipped before",
    );
    Diagnostic::warning(NOT_CHOSEN, message).with_hint(hint)
}

/// What is said with an export in format 2.0.
pub fn left_out_of_2_0() -> Bilingual {
    Bilingual::new(
        "格式 2.0 没有这些字段，导出时略去：records、causes、second_keyframe、secondary_scenarios、provenance，\
         以及关键要素的编号、证据时间和关联目标；要保留它们，导出格式 2.1",
        "format 2.0 has no records, causes, second_keyframe, secondary_scenarios and provenance, nor ids, evidence times \
         and linked objects of components: they are left out; export format 2.1 to keep them",
    )
}

/// The tasks of an export in its order, without gold tasks; only ids, because a project may have a hundred thousand
/// tasks, each with drafts.
fn exported_ids(tx: &mut dyn Tx, project: &str, format: &ExportFormat) -> Answer<Vec<String>> {
    let rows = tx.rows(
        &format!(
            "SELECT id, state, CASE WHEN {STANDS} THEN 1 ELSE 0 END AS stands FROM tasks
             WHERE project_id = $1 AND {NOT_GOLD}
             ORDER BY clip_id, scenario_id, keyframe_ns, episode_id, overlap_index"
        ),
        values![project],
    )?;
    let mut ids = Vec::new();
    for row in rows {
        let stands = row.flag("stands")?;
        let state = State::from_word(&row.text("state")?);
        if match format {
            ExportFormat::Tasks => true,
            ExportFormat::Labels(states, _) => stands && state.is_some_and(|s| states.contains(&s)),
        } {
            ids.push(row.text("id")?);
        }
    }
    Ok(ids)
}

/// The lines of an export as one text, for small exports and tests.
pub fn export(store: &Store, project: &str, format: &ExportFormat) -> Answer<String> {
    let mut out = Vec::new();
    export_to(store, project, format, &mut out)?;
    String::from_utf8(out).map_err(Problem::store)
}

/// Login names by id: the names that other systems know.
fn user_names(tx: &mut dyn Tx) -> Answer<HashMap<String, String>> {
    tx.rows("SELECT id, name FROM users", &[])?.iter().map(|r| Ok((r.text("id")?, r.text("name")?))).collect()
}

/// The label; its provenance was written at submission. An unfinished draft, which may be incomplete, is exported
/// unchanged.
fn label_line(draft: String, version: LabelVersion) -> Answer<String> {
    if version == LabelVersion::V2_1 {
        return Ok(draft);
    }
    match serde_json::from_str::<CocLabel>(&draft) {
        Ok(label) => serde_json::to_string(&label.to_2_0()).map_err(Problem::store),
        Err(_) => Ok(draft),
    }
}

/// Reads JSON lines into `project`. Unreadable lines are reported with their numbers and do not stop the rest. When the
/// store fails in between, importing the same file again adds what is missing.
pub fn import(app: &App, project: &str, text: &str, actor: Option<&str>) -> Answer<Imported> {
    let lines: Vec<(usize, &str)> = text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()).collect();
    if lines.len() > MOST_LINES {
        return Err(Problem::request(
            format!("超过 {MOST_LINES} 行，请分批导入"),
            format!("more than {MOST_LINES} lines: import them in several parts"),
        ));
    }
    let project = app.store.read(|tx| projects::get(tx, project))?;
    let (mut incoming, mut lost) = (Vec::new(), BTreeMap::new());
    for (number, line) in lines {
        match read_line(line) {
            Ok(read) => incoming.push((number, read)),
            Err(why) => drop(lost.insert(number, why)),
        }
    }
    // Sorted by drive, so that each is read and derived once.
    incoming.sort_by(|(_, a), (_, b)| a.episode.drive_id.cmp(&b.episode.drive_id));
    let (mut last, mut rows, mut known) = (LastDrive::default(), Vec::new(), KnownEpisodes::default());
    for (number, mut one) in incoming {
        if one.is_made
            && let Some(label) = &one.draft
            && let Some(episode) = known.of(app, &one.episode, label)?
        {
            one.episode = episode;
        }
        match prepare(app, &project, one, &mut last) {
            Ok(row) => rows.push((number, row)),
            Err(p) => drop(lost.insert(number, p.text)),
        }
    }
    // In the order of the file, which then is the order of the queue.
    rows.sort_by_key(|(number, _)| *number);
    let rows: Vec<TaskRow> = rows.into_iter().map(|(_, row)| row).collect();
    let tasks = create::put_all(app, &rows, actor)?;
    let more = lost.len().saturating_sub(MOST_REASONS) as u32;
    let first = lost.into_iter().take(MOST_REASONS);
    let lost = first.map(|(number, text)| LostLine { line: number as u32 + 1, text }).collect();
    Ok(Imported { tasks, known: rows.len() as u32 - tasks, lost, more })
}

fn prepare(app: &App, project: &Project, incoming: Incoming, last: &mut LastDrive) -> Answer<TaskRow> {
    let Incoming { episode, draft, priority, overlap: (overlap_index, overlap_count), .. } = incoming;
    let row = create::prepare(app, project, &episode, draft, last)?;
    Ok(TaskRow { priority, overlap_index, overlap_count, ..row })
}

/// Tasks of a project, by class and clip; only of `state`, if one is given. A label of which another one was chosen is
/// in no state.
pub fn tasks_of(tx: &mut dyn Tx, project: &str, state: Option<&str>) -> Answer<Vec<TaskRow>> {
    if let Some(word) = state.filter(|w| State::from_word(w).is_none()) {
        let words: Vec<&str> = State::ALL.iter().map(|s| s.word()).collect();
        return Err(Problem::request(
            format!("'{word}' 不是任务状态：{}", words.join("、")),
            format!("'{word}' is not a task state: {}", words.join(", ")),
        ));
    }
    let condition = format!(
        "project_id = $1 AND ($2 = '' OR (state = $3 AND {NOT_SUPERSEDED}))
         ORDER BY scenario_id, clip_id, keyframe_ns, overlap_index"
    );
    tasks::select(tx, &condition, values![project, state.unwrap_or_default(), state.unwrap_or_default()])
}

#[cfg(test)]
mod tests;
