//! Tasks in the store: reading, writing, listing, and their append-only history.

use crate::domain::task::TaskSummary;
use crate::domain::workflow::{Position, Stage, State};
use crate::problem::{Answer, Problem};
use crate::service::projects::{json, parse};
use crate::service::{thumbnail, veil};
use crate::store::{Row, Tx, Value as Cell};
use crate::values;
use serde_json::Value;
use std::collections::{BTreeSet, HashMap};
use whyroad_label::merge::FieldChange;
use whyroad_model::label_fields::name;
use whyroad_model::messages::EpisodeRecord;

/// A complete task.
#[derive(Clone, Debug)]
pub struct TaskRow {
    /// Id.
    pub id: String,
    /// Project id.
    pub project: String,
    /// Number in the overlap group, from 0.
    pub overlap_index: i64,
    /// Size of the overlap group.
    pub overlap_count: i64,
    /// Drive.
    pub drive_id: String,
    /// Clip.
    pub clip_id: String,
    /// Class.
    pub scenario_id: String,
    /// Suggested keyframe: Stage I shows nothing after it.
    pub keyframe_ns: i64,
    /// First time that is shown.
    pub from_ns: i64,
    /// Last time that Stage II shows.
    pub to_ns: i64,
    /// The mined episode.
    pub episode: EpisodeRecord,
    /// The suggested draft.
    pub initial: Value,
    /// The current draft.
    pub draft: Value,
    /// Increased by each change of the draft.
    pub version: i64,
    /// Higher values come first.
    pub priority: i64,
    /// Workflow.
    pub at: Position,
    /// An audit has judged the current or an earlier submission.
    pub audited: bool,
    /// `chosen`, `superseded`.
    pub adjudication: Option<String>,
    /// User to whom a lead has assigned it.
    pub assigned: Option<String>,
    /// Fencing token of the newest lease.
    pub fence: i64,
    /// End of the lease.
    pub lease_until: Option<i64>,
    /// Last entry of the history.
    pub seq: i64,
    /// When it was created.
    pub created: i64,
    /// When it last changed.
    pub updated: i64,
    /// Language of the label: `zh`, `en`, or empty for any.
    pub lang: String,
    /// A comment with a question to the lead is not resolved.
    pub asks_lead: bool,
    /// It belongs to an overlap group whose labels disagree, of which none was chosen.
    pub disagrees: bool,
    /// It belongs to an overlap group whose labels are all handed in, of which none was chosen.
    pub to_choose: bool,
    /// The store has a thumbnail of it.
    pub pictured: bool,
    /// Its draft is still to be created.
    pub pending: bool,
    /// Its suggested draft comes from an import.
    pub imported: bool,
    /// Its project shows only the L2 of its class in Stage I.
    pub veiled: bool,
    /// The class that fits instead, as its annotator says; empty for one that they do not know.
    pub right_class: Option<String>,
    /// The task of another class that replaces it.
    pub replaced_by: Option<String>,
    /// The task of another class that it replaces.
    pub replaces: Option<String>,
    /// Codes of the findings with which it was submitted.
    pub findings: BTreeSet<String>,
    /// The thumbnail of a task that is being created; empty for one that was read.
    pub thumbnail: String,
}

/// How much of a label is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LabelView {
    /// Stage.
    pub stage: Stage,
    /// Its L3 class is hidden.
    pub hides_leaf: bool,
    /// The suggested components are hidden.
    pub hides_drafted: bool,
    /// A user is in Stage I: the components are theirs.
    pub in_hand: bool,
}

impl TaskRow {
    /// A lead has chosen it of the labels of its episode.
    pub fn is_chosen(&self) -> bool {
        self.adjudication.as_deref() == Some("chosen")
    }

    /// True while its L3 class is hidden.
    pub fn hides_leaf(&self) -> bool {
        self.veiled && self.at.state.stage() == Stage::Stage1
    }

    /// True while the suggested components are hidden: those of a rule may depend on the hidden L3 class, the words of
    /// imported ones on what comes after the keyframe.
    pub fn hides_drafted(&self) -> bool {
        self.hides_leaf() || (self.imported && self.at.state.stage() == Stage::Stage1)
    }

    /// True where the components of `draft` are the suggested ones, and there are some.
    pub fn are_suggested_in<'a>(&'a self, draft: &'a Value) -> bool {
        let of =
            |label: &'a Value| label.get(name::CRITICAL_COMPONENTS)?.as_array().filter(|all| !all.is_empty());
        of(draft).is_some_and(|all| Some(all) == of(&self.initial))
    }

    /// How much of its label is shown now.
    pub fn view(&self) -> LabelView {
        LabelView {
            stage: self.at.state.stage(),
            hides_leaf: self.hides_leaf(),
            hides_drafted: self.hides_drafted(),
            in_hand: self.at.state == State::Stage1,
        }
    }

    /// The class that is shown now.
    pub fn shown_class(&self) -> &str {
        if self.hides_leaf() { veil::l2(&self.scenario_id) } else { &self.scenario_id }
    }

    /// First time that is shown now. The beginning of the range depends on the L3 class, so if that is hidden, the
    /// history has the same length for every task.
    pub fn shown_from(&self) -> i64 {
        if self.hides_leaf() { self.from_ns.max(self.keyframe_ns - VEILED_HISTORY_NS) } else { self.from_ns }
    }
}

/// History that is shown of a task with a hidden L3 class, ns: as required in LABELING.md.
const VEILED_HISTORY_NS: i64 = 2_000_000_000;

const COLUMNS: &str = "id, project_id, overlap_index, overlap_count, drive_id, clip_id, scenario_id, keyframe_ns, from_ns, \
    to_ns, episode, initial, draft, version, priority, state, authors, checker, auditor, checked, audited, adjudication, \
    assigned, holder, fence, lease_until, seq, created, updated, lang, pending, coalesce(disagrees, 0) AS disagrees, complete, imported, \
    right_class, replaced_by, replaces, findings, \
    (SELECT count(*) FROM comments c WHERE c.task_id = tasks.id AND c.to_lead = 1 AND c.resolved = 0) AS asks, \
    (SELECT count(*) FROM thumbnails p WHERE p.task_id = tasks.id) AS pictured, \
    (SELECT v.veiled FROM projects v WHERE v.id = tasks.project_id) AS veiled";

fn task(row: &Row) -> Answer<TaskRow> {
    let state = row.text("state")?;
    let scenario = row.text("scenario_id")?;
    let veiled: Vec<String> = parse(&row.text("veiled")?)?;
    let known = State::from_word(&state).ok_or_else(|| Problem::store(format!("state '{state}'")))?;
    let adjudication = row.maybe_text("adjudication")?;
    Ok(TaskRow {
        disagrees: row.flag("disagrees")? && adjudication.is_none() && known.is_handed_in(),
        to_choose: row.flag("complete")? && adjudication.is_none() && known.is_handed_in(),
        imported: row.flag("imported")?,
        veiled: veiled.iter().any(|l2| l2 == veil::l2(&scenario)),
        id: row.text("id")?,
        project: row.text("project_id")?,
        overlap_index: row.int("overlap_index")?,
        overlap_count: row.int("overlap_count")?,
        drive_id: row.text("drive_id")?,
        clip_id: row.text("clip_id")?,
        scenario_id: scenario,
        keyframe_ns: row.int("keyframe_ns")?,
        from_ns: row.int("from_ns")?,
        to_ns: row.int("to_ns")?,
        episode: parse(&row.text("episode")?)?,
        initial: parse(&row.text("initial")?)?,
        draft: parse(&row.text("draft")?)?,
        version: row.int("version")?,
        priority: row.int("priority")?,
        at: Position {
            state: known,
            authors: parse(&row.text("authors")?)?,
            checker: row.maybe_text("checker")?,
            auditor: row.maybe_text("auditor")?,
            holder: row.maybe_text("holder")?,
            checked: row.flag("checked")?,
        },
        audited: row.flag("audited")?,
        adjudication,
        assigned: row.maybe_text("assigned")?,
        fence: row.int("fence")?,
        lease_until: row.maybe_int("lease_until")?,
        seq: row.int("seq")?,
        created: row.int("created")?,
        updated: row.int("updated")?,
        lang: row.text("lang")?,
        asks_lead: row.int("asks")? > 0,
        pictured: row.int("pictured")? > 0,
        pending: row.int("pending")? != 0,
        right_class: row.maybe_text("right_class")?,
        replaced_by: row.maybe_text("replaced_by")?,
        replaces: row.maybe_text("replaces")?,
        findings: row.text("findings")?.split_whitespace().map(str::to_owned).collect(),
        thumbnail: String::new(),
    })
}

/// The task with this id.
pub fn get(tx: &mut dyn Tx, id: &str) -> Answer<TaskRow> {
    let row = tx.row(&format!("SELECT {COLUMNS} FROM tasks WHERE id = $1"), values![id])?;
    task(&row.ok_or_else(Problem::missing)?)
}

/// The data that determines who may see a task: sufficient for the access check of every call.
#[derive(Clone, Debug)]
pub struct Concern {
    /// Project id.
    pub project: String,
    holder: Option<String>,
    author: Option<String>,
    assigned: Option<String>,
}

impl Concern {
    /// True if the user holds it, wrote it last, or is assigned to it and may still start.
    pub fn is_of(&self, user: &str) -> bool {
        let given = self.assigned.as_deref() == Some(user) && self.author.is_none();
        self.holder.as_deref() == Some(user) || self.author.as_deref() == Some(user) || given
    }
}

/// The access data of the task with this id.
pub fn concern(tx: &mut dyn Tx, id: &str) -> Answer<Concern> {
    let row = tx.row("SELECT project_id, holder, author, assigned FROM tasks WHERE id = $1", values![id])?;
    let row = row.ok_or_else(Problem::missing)?;
    Ok(Concern {
        project: row.text("project_id")?,
        holder: row.maybe_text("holder")?,
        author: row.maybe_text("author")?,
        assigned: row.maybe_text("assigned")?,
    })
}

/// The task with this id, locked for other writers until the transaction ends.
pub fn get_for_change(tx: &mut dyn Tx, id: &str) -> Answer<TaskRow> {
    let sql = format!("SELECT {COLUMNS} FROM tasks WHERE id = $1{}", tx.lock());
    task(&tx.row(&sql, values![id])?.ok_or_else(Problem::missing)?)
}

/// Tasks that match `condition`, SQL of this crate with `values`.
pub fn select(tx: &mut dyn Tx, condition: &str, values: &[Cell]) -> Answer<Vec<TaskRow>> {
    tx.rows(&format!("SELECT {COLUMNS} FROM tasks WHERE {condition}"), values)?.iter().map(task).collect()
}

/// The tasks of the overlap group of an episode, in the order of creation.
pub fn group(tx: &mut dyn Tx, project: &str, episode: &str) -> Answer<Vec<TaskRow>> {
    select(tx, "project_id = $1 AND episode_id = $2 ORDER BY overlap_index", values![project, episode])
}

/// Stores a new task; false when its episode already has one.
pub fn insert(tx: &mut dyn Tx, t: &TaskRow) -> Answer<bool> {
    let n = tx.run(
        "INSERT INTO tasks (id, project_id, episode_id, overlap_index, overlap_count, drive_id, clip_id, scenario_id,
           keyframe_ns, from_ns, to_ns, episode, initial, draft, version, priority, state, authors, checked, audited,
           fence, seq, created, updated, lang, pending, imported, replaces)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, $17, '[]', 0, 0, 0, 0, $18, $19,
           $20, $21, $22, $23)
         ON CONFLICT DO NOTHING",
        values![
            &t.id, &t.project, &t.episode.episode_id, t.overlap_index, t.overlap_count, &t.drive_id, &t.clip_id,
            &t.scenario_id, t.keyframe_ns, t.from_ns, t.to_ns, json(&t.episode)?, json(&t.initial)?, json(&t.draft)?,
            t.version, t.priority, t.at.state.word(), t.created, t.updated, &t.lang, i64::from(t.pending),
            i64::from(t.imported), t.replaces.as_ref(),
        ],
    )?;
    if n == 1 {
        thumbnail::put(tx, &t.id, &t.thumbnail)?;
        if t.overlap_count > 1 {
            add_to_group(tx, &t.project, &t.episode.episode_id)?;
        }
    }
    Ok(n == 1)
}

/// Writes the fields of a task that can change.
pub fn update(tx: &mut dyn Tx, t: &TaskRow) -> Answer<()> {
    tx.run(
        "UPDATE tasks SET draft = $1, version = $2, priority = $3, state = $4, authors = $5, author = $6, checker = $7,
           auditor = $8, checked = $9, audited = $10, adjudication = $11, assigned = $12, holder = $13, fence = $14,
           lease_until = $15, seq = $16, updated = $17, right_class = $18, replaced_by = $19, findings = $20
         WHERE id = $21",
        values![
            json(&t.draft)?, t.version, t.priority, t.at.state.word(), json(&t.at.authors)?,
            t.at.author(), t.at.checker.as_ref(), t.at.auditor.as_ref(), i64::from(t.at.checked), i64::from(t.audited),
            t.adjudication.as_ref(), t.assigned.as_ref(), t.at.holder.as_ref(), t.fence, t.lease_until, t.seq,
            t.updated, t.right_class.as_ref(), t.replaced_by.as_ref(), spaced(&t.findings), &t.id,
        ],
    )?;
    Ok(())
}

/// Words with a space before and after each, so that one can be found in the store.
fn spaced(words: &BTreeSet<String>) -> String {
    words.iter().fold(" ".to_owned(), |text, word| text + word + " ")
}

/// A new entry of the history.
#[derive(Clone, Debug, Default)]
pub struct Entry<'a> {
    /// `take`, `edit`, ...
    pub action: &'a str,
    /// The user; `None` for the command line.
    pub actor: Option<&'a str>,
    /// State before.
    pub from: Option<State>,
    /// Fields changed.
    pub changes: &'a [FieldChange],
    /// The complete draft, if it did not result from changes.
    pub snapshot: Option<&'a Value>,
    /// Reason.
    pub note: Option<&'a str>,
}

/// Display names of users, by id.
pub fn names(tx: &mut dyn Tx) -> Answer<HashMap<String, String>> {
    tx.rows("SELECT id, display FROM users", &[])?
        .iter()
        .map(|r| Ok((r.text("id")?, r.text("display")?)))
        .collect()
}

/// Summary of a task, without the fields that only some users may see.
pub fn summary(t: &TaskRow, names: &HashMap<String, String>) -> TaskSummary {
    let name = |id: Option<&str>| id.map(|id| names.get(id).cloned().unwrap_or_else(|| id.to_owned()));
    TaskSummary {
        id: t.id.clone(),
        project: t.project.clone(),
        clip_id: t.clip_id.clone(),
        drive_id: t.drive_id.clone(),
        scenario_id: t.shown_class().to_owned(),
        target_id: t.episode.target_id.as_ref().filter(|_| !t.hides_leaf()).map(ToString::to_string),
        state: t.at.state,
        stage: t.at.state.stage(),
        priority: t.priority,
        assigned_to: name(t.at.holder.as_deref().or(t.assigned.as_deref())),
        author: name(t.at.author()),
        checker: name(t.at.checker.as_deref()),
        lease_until: t.lease_until.filter(|_| t.at.holder.is_some()),
        overlap: t.overlap_count > 1,
        adjudication: t.adjudication.clone(),
        updated: t.updated,
        keyframe_s: None,
        short_window: None,
        right_class: t.right_class.clone(),
        replaced_by: t.replaced_by.clone(),
        replaces: t.replaces.clone(),
        findings: t.findings.iter().cloned().collect(),
        asks_lead: t.asks_lead,
        disagrees: false,
        to_choose: false,
        thumbnail: None,
    }
}

/// A label was added to the overlap group of an episode.
fn add_to_group(tx: &mut dyn Tx, project: &str, episode: &str) -> Answer<()> {
    tx.run(
        "UPDATE tasks SET complete = 0 WHERE project_id = $1 AND episode_id = $2 AND complete <> 0",
        values![project, episode],
    )
    .map(drop)
}
