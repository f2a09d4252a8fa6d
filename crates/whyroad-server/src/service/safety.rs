//! The safety filter of Stage II: its answer is recorded before any decision is saved. An unsafe sample is rejected
//! with the answer, in one transaction.

use crate::app::App;
use crate::domain::project::Project;
use crate::domain::safety::{SafetyCounts, SafetyReason, SafetyRequest};
use crate::domain::workflow::{self, Action, Actor, Draw, Role, State};
use crate::problem::{Answer, Problem};
use crate::service::projects::{json as text_of, parse};
use crate::service::tasks::{self, Entry, TaskRow};
use crate::service::{disagreement, history, leases, texts};
use crate::store::Tx;
use crate::values;
use serde_json::{Value, json};
use whyroad_label::merge::{self, FieldChange};
use whyroad_model::label_fields::{name, pointer};
use whyroad_model::messages::SafetyAnswer;

/// Fields of a label that require the answer first.
const WAITING: [&str; 3] = [name::DRIVING_DECISION, name::CAUSES, name::COC_TRACE];

/// True while `state` has a label to which the answer belongs.
pub fn applies(state: State) -> bool {
    matches!(state, State::Stage2 | State::Rework)
}

/// Refuses to save the field at `path` if it requires the answer first.
pub fn before(t: &TaskRow, path: &str) -> Answer<()> {
    if applies(t.at.state) && WAITING.contains(&merge::top(path)) { required(t) } else { Ok(()) }
}

/// Refuses an action that requires the answer while it is missing.
pub fn required(t: &TaskRow) -> Answer<()> {
    let answer = t.draft.pointer(pointer::SAFETY_FILTER_ANSWER).and_then(Value::as_str);
    if answer == Some(SafetyAnswer::Safe.id()) {
        return Ok(());
    }
    Err(Problem::new(
        422,
        "safety.unanswered",
        "请先回答安全过滤：驾驶是否合法且安全",
        "answer the safety filter first: is the driving legal and safe?",
    ))
}

/// Records the answer of the task's holder; an unsafe one also rejects the task.
pub fn record(
    app: &App,
    tx: &mut dyn Tx,
    id: &str,
    actor: &Actor,
    project: &Project,
    request: &SafetyRequest,
) -> Answer<TaskRow> {
    let mut t = tasks::get_for_change(tx, id)?;
    let now = app.lease_now(tx)?;
    leases::held_as(&t, actor, Role::Annotator, Some(request.fence))?;
    if !applies(t.at.state) {
        return Err(Problem::new(
            409,
            "task.wrong_state",
            "安全过滤在阶段二回答",
            "the safety filter is answered in Stage II",
        ));
    }
    let note = texts::reason(request.note.as_deref())?;
    let mut reasons = request.reasons.clone();
    reasons.sort_unstable();
    reasons.dedup();
    let unsafe_ = request.answer == SafetyAnswer::Unsafe;
    if unsafe_ && (reasons.is_empty() || (reasons.contains(&SafetyReason::Other) && note.is_none())) {
        return Err(Problem::new(
            422,
            "safety.reason",
            "请说明为何违法或不安全；选“其他”时须填写说明",
            "state why it is illegal or unsafe; the reason 'other' requires a note",
        ));
    }
    let ids: Vec<&str> = reasons.iter().map(|r| r.id()).collect();
    let mut value = json!({ (name::ANSWER): request.answer.id() });
    if !ids.is_empty() {
        value[name::REASONS] = json!(ids);
    }
    if let Some(note) = note {
        value[name::NOTE] = json!(note);
    }
    let changes = [FieldChange { path: pointer::SAFETY_FILTER.to_owned(), value, remove: false }];
    changes.iter().try_for_each(|c| merge::apply(&mut t.draft, c))?;
    t.version += 1;
    leases::extend(&mut t, &project.settings, now);
    tx.run(
        "INSERT INTO safety (task_id, project_id, answer, reasons, note, actor, at) VALUES ($1, $2, $3, $4, $5, $6, $7)
         ON CONFLICT (task_id) DO UPDATE SET answer = excluded.answer, reasons = excluded.reasons,
           note = excluded.note, actor = excluded.actor, at = excluded.at",
        values![&t.id, &t.project, request.answer.id(), text_of(&ids)?, note, &actor.id, now],
    )?;
    let from = Some(t.at.state);
    let entry =
        Entry { action: "safety", actor: Some(&actor.id), from, changes: &changes, note, ..Entry::default() };
    history::record(tx, &mut t, &entry, now)?;
    if unsafe_ {
        t.at = workflow::step(&t.at, actor, Action::Reject, Draw::Pass)?;
        t.lease_until = None;
        if t.is_chosen() {
            disagreement::reopen(tx, &mut t)?;
        }
        let why = in_words(&reasons, note);
        let entry = Entry {
            action: Action::Reject.word(),
            actor: Some(&actor.id),
            from,
            note: Some(&why),
            ..Entry::default()
        };
        history::record(tx, &mut t, &entry, now)?;
    }
    tasks::update(tx, &t)?;
    if unsafe_ && t.overlap_count > 1 {
        disagreement::note(tx, &t.project, &t.episode.episode_id)?;
    }
    Ok(t)
}

/// The reasons as text in the history, in both languages.
fn in_words(reasons: &[SafetyReason], note: Option<&str>) -> String {
    let names = reasons.iter().map(|r| r.name()).map(|n| format!("{} / {}", n.zh, n.en));
    names.chain(note.map(str::to_owned)).collect::<Vec<_>>().join("; ")
}

/// Removes the answer: the task starts again.
pub fn forget(tx: &mut dyn Tx, task: &str) -> Answer<()> {
    tx.run("DELETE FROM safety WHERE task_id = $1", values![task]).map(drop)
}

/// The answers in `project`.
pub fn counts(tx: &mut dyn Tx, project: &str) -> Answer<SafetyCounts> {
    let sql =
        "SELECT answer, reasons, count(*) AS n FROM safety WHERE project_id = $1 GROUP BY answer, reasons";
    let mut out = SafetyCounts::default();
    for row in tx.rows(sql, values![project])? {
        let n = row.int("n")?;
        if row.text("answer")? == SafetyAnswer::Safe.id() {
            out.safe += n;
        } else {
            out.unsafe_ += n;
        }
        for reason in parse::<Vec<String>>(&row.text("reasons")?)? {
            *out.reasons.entry(reason).or_default() += n;
        }
    }
    Ok(out)
}
