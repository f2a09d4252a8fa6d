//! The tasks of a project in short, for reports: what each is about, how far it is, what people changed, how long they
//! worked. Read page by page; a draft is compared and dropped before the next page is read.

use crate::domain::workflow::State;
use crate::problem::{Answer, Problem};
use crate::service::gold::NOT_GOLD;
use crate::service::projects::parse;
use crate::service::{drafts, tasks};
use crate::store::{Row, Tx};
use crate::values;
use serde_json::Value;
use std::collections::HashMap;
use whyroad_label::facts::{Judgement, LabelStage, Step, TaskFacts, revision, worked_s};
use whyroad_model::{DriveId, Nanos};

/// Tasks read together.
const PAGE: i64 = 500;

/// How far the label of a task in this state is.
fn stage(state: State) -> LabelStage {
    match state {
        State::Open | State::Stage1 | State::Stage1Locked | State::Stage2 => LabelStage::Waiting,
        State::Submitted | State::InCheck | State::Rework | State::Checked | State::InAudit => {
            LabelStage::Labelled
        }
        State::Accepted => LabelStage::Accepted,
        State::Skipped | State::Rejected => LabelStage::LeftOut,
    }
}

/// All tasks of `project`, by id.
pub fn of(tx: &mut dyn Tx, project: &str) -> Answer<Vec<TaskFacts>> {
    let names = tasks::names(tx)?;
    let mut out = Vec::new();
    let mut after = String::new();
    loop {
        // Drafts only of what was handed in: others are not compared.
        let rows = tx.rows(
            &format!("SELECT id, episode_id, overlap_count, drive_id, scenario_id, keyframe_ns, state, adjudication, author,
               created, CASE WHEN state = 'accepted' THEN initial END AS initial,
               CASE WHEN state IN ('submitted', 'in_check', 'rework', 'checked', 'in_audit', 'accepted') THEN draft END AS draft
             FROM tasks WHERE project_id = $1 AND id > $2 AND {NOT_GOLD} ORDER BY id LIMIT $3"),
            values![project, &after, PAGE],
        )?;
        let Some(last) = rows.last() else { return Ok(out) };
        let last = last.text("id")?;
        let mut steps = steps(tx, project, &after, &last)?;
        for row in &rows {
            let steps = steps.remove(&row.text("id")?).unwrap_or_default();
            out.push(task(tx, row, &steps, &names)?);
        }
        after = last;
    }
}

/// The histories of the tasks after `after` up to `last`, without their changes.
fn steps(tx: &mut dyn Tx, project: &str, after: &str, last: &str) -> Answer<HashMap<String, Vec<Step>>> {
    let rows = tx.rows(
        "SELECT h.task_id, h.at, h.actor, h.action FROM history h JOIN tasks t ON t.id = h.task_id
         WHERE t.project_id = $1 AND h.task_id > $2 AND h.task_id <= $3 ORDER BY h.task_id, h.seq",
        values![project, after, last],
    )?;
    let mut out: HashMap<String, Vec<Step>> = HashMap::new();
    for r in rows {
        let step = Step { at_ms: r.int("at")?, actor: r.maybe_text("actor")?, action: r.text("action")? };
        out.entry(r.text("task_id")?).or_default().push(step);
    }
    Ok(out)
}

fn task(tx: &mut dyn Tx, row: &Row, steps: &[Step], names: &HashMap<String, String>) -> Answer<TaskFacts> {
    let id = row.text("id")?;
    let word = row.text("state")?;
    let state = State::from_word(&word).ok_or_else(|| Problem::store(format!("state '{word}'")))?;
    let json =
        |name: &str| -> Answer<Option<Value>> { row.maybe_text(name)?.map(|text| parse(&text)).transpose() };
    let (initial, draft) = (json("initial")?, json("draft")?);
    let at = |action: &str, ms: Option<&Step>| ms.filter(|s| s.action == action).map(|s| ms_time(s.at_ms));
    let submitted = at("submit", steps.iter().find(|s| s.action == "submit"));
    let accepted = at("accept", steps.iter().rev().find(|s| s.action == "accept"));
    let stage = stage(state);
    let first = match (row.int("overlap_count")? > 1, submitted) {
        (true, Some(_)) => Some(first_submission(tx, &id)?),
        _ => None,
    };
    Ok(TaskFacts {
        episode: row.text("episode_id")?,
        drive: DriveId(row.text("drive_id")?),
        scenario: row.text("scenario_id")?.parse().map_err(Problem::store)?,
        keyframe: Nanos(row.int("keyframe_ns")?),
        stage,
        superseded: row.maybe_text("adjudication")?.as_deref() == Some("superseded"),
        author: row.maybe_text("author")?.map(|a| names.get(&a).cloned().unwrap_or(a)),
        label: draft.as_ref().map(Judgement::of),
        first,
        revision: initial.as_ref().zip(draft.as_ref()).map(|(a, b)| revision(a, b)),
        created: ms_time(row.int("created")?),
        submitted,
        accepted: accepted.filter(|_| stage == LabelStage::Accepted),
        returned: steps.iter().filter(|s| s.action == "send_back").count() as u32,
        worked_s: worked_s(steps),
        task: id,
    })
}

fn ms_time(ms: i64) -> Nanos {
    Nanos(ms.saturating_mul(1_000_000))
}

/// The label as first handed in. It is kept whole; before that was so, it is put together from its changes.
fn first_submission(tx: &mut dyn Tx, id: &str) -> Answer<Judgement> {
    let row = tx.row(
        "SELECT seq, snapshot FROM history WHERE task_id = $1 AND action = 'submit' ORDER BY seq LIMIT 1",
        values![id],
    )?;
    let row = row.ok_or_else(Problem::missing)?;
    let label = match row.maybe_text("snapshot")? {
        Some(snapshot) => parse(&snapshot)?,
        None => {
            let t = tasks::get(tx, id)?;
            drafts::at(tx, &t, row.int("seq")?)?
        }
    };
    Ok(Judgement::of(&label))
}
