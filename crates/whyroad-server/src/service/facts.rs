//! Summaries of the tasks of a project, for reports: the subject and state of each, the changes by people, the working
//! time. Read page by page; a draft is compared and dropped before the next page is read.

pub mod cache;

use crate::domain::workflow::State;
use crate::problem::{Answer, Problem};
use crate::service::copies::NOT_GOLD;
use crate::service::projects::parse;
use crate::service::{drafts, tasks};
use crate::store::{Row, Store, Tx, Value as Cell};
use crate::values;
use cache::{FactsCache, Kept, Version};
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use whyroad_label::facts::{Judgement, LabelStage, Step, TaskFacts, revision, worked_s};
use whyroad_model::{DriveId, Nanos};

/// Number of tasks read together.
const PAGE: usize = 500;

/// Progress of the label of a task in this state.
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
    let ids: Vec<String> = versions(tx, project)?.into_keys().collect();
    let mut out = Vec::with_capacity(ids.len());
    for part in ids.chunks(PAGE) {
        out.extend(some(tx, part, &names)?);
    }
    Ok(out)
}

fn versions(tx: &mut dyn Tx, project: &str) -> Answer<BTreeMap<String, Version>> {
    let sql = format!("SELECT id, seq, adjudication FROM tasks WHERE project_id = $1 AND {NOT_GOLD}");
    let rows = tx.rows(&sql, values![project])?;
    rows.iter().map(|r| Ok((r.text("id")?, (r.int("seq")?, r.maybe_text("adjudication")?)))).collect()
}

/// The facts of these tasks; a deleted one has none.
fn some(tx: &mut dyn Tx, ids: &[String], names: &HashMap<String, String>) -> Answer<Vec<TaskFacts>> {
    let holes = (1..=ids.len()).map(|i| format!("${i}")).collect::<Vec<_>>().join(", ");
    let values: Vec<Cell> = ids.iter().map(Cell::from).collect();
    // Drafts only of submitted labels: others are not compared.
    let rows = tx.rows(
            &format!("SELECT id, episode_id, overlap_count, drive_id, scenario_id, keyframe_ns, state, adjudication, author,
               created, CASE WHEN state = 'accepted' THEN initial END AS initial,
               CASE WHEN state IN ('submitted', 'in_check', 'rework', 'checked', 'in_audit', 'accepted') THEN draft END AS draft
             FROM tasks WHERE id IN ({holes}) ORDER BY id"),
        &values,
    )?;
    let mut steps = steps(tx, &holes, &values)?;
    let mut out = Vec::with_capacity(rows.len());
    for row in &rows {
        let steps = steps.remove(&row.text("id")?).unwrap_or_default();
        out.push(task(tx, row, &steps, names)?);
    }
    Ok(out)
}

/// The same as [`of`], from `cache` where nothing has changed; the second number is the number of tasks that were read.
pub fn kept(store: &Store, cache: &FactsCache, project: &str) -> Answer<(Vec<TaskFacts>, usize)> {
    let (names, now) = store.report(|tx| Ok((tasks::names(tx)?, versions(tx, project)?)))?;
    let before = cache.get(project).filter(|kept| kept.names == names).unwrap_or_default();
    let same = |id: &String, version: &Version| before.tasks.get(id).is_some_and(|(v, _)| v == version);
    let stale: Vec<String> = now.iter().filter(|(id, v)| !same(id, v)).map(|(id, _)| id.clone()).collect();
    let mut fresh = HashMap::with_capacity(stale.len());
    for part in stale.chunks(PAGE) {
        let read = store.report(|tx| some(tx, part, &names))?;
        fresh.extend(read.into_iter().map(|facts| (facts.task.clone(), facts)));
    }
    let read = fresh.len();
    let mut tasks = BTreeMap::new();
    for (id, version) in now {
        // A task that changes between the two reads has a newer version next time, and is read again then.
        let facts = fresh.remove(&id).or_else(|| before.tasks.get(&id).map(|(_, f)| f.clone()));
        if let Some(facts) = facts {
            tasks.insert(id, (version, facts));
        }
    }
    let out = tasks.values().map(|(_, facts)| facts.clone()).collect();
    cache.put(project, Arc::new(Kept { names, tasks }));
    Ok((out, read))
}

/// The histories of these tasks, without their changes.
fn steps(tx: &mut dyn Tx, holes: &str, ids: &[Cell]) -> Answer<HashMap<String, Vec<Step>>> {
    let sql = format!(
        "SELECT task_id, at, actor, action FROM history WHERE task_id IN ({holes}) ORDER BY task_id, seq"
    );
    let rows = tx.rows(&sql, ids)?;
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

/// The label as first submitted. It is stored completely; older ones are rebuilt from their changes.
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
