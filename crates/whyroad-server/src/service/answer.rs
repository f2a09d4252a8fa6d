//! The complete answer about one task: the parts that may be shown, the permitted actions, the findings of the checker.

use crate::app::App;
use crate::domain::task::{Finding, ShortWindow, Suggestion, Task, TaskSummary};
use crate::domain::workflow::{self, Actor, Role, Stage, State};
use crate::problem::Answer;
use crate::service::sample_window::Window;
use crate::service::tasks::{self, LabelView, TaskRow};
use crate::service::visible::{comments, label};
use crate::service::{create, judgements, leases, permissions, projects};
use crate::store::Tx;
use crate::values;
use serde_json::{Map, Value};
use whyroad_model::label_fields::name;
use whyroad_model::messages::{KeyframeType, ProvenanceSource};
use whyroad_model::{Bilingual, Nanos};

/// Number of entries that [`history`] has in Stage I, without reading them: autosave creates many.
fn count_own(tx: &mut dyn Tx, t: &TaskRow, user: &str) -> Answer<i64> {
    let row = tx.row(
        "SELECT count(*) AS n FROM history h WHERE h.task_id = $1 AND h.actor = $2 AND h.action <> 'reopen'
           AND h.seq > (SELECT coalesce(max(r.seq), 0) FROM history r WHERE r.task_id = h.task_id AND r.action = 'reopen')
           AND coalesce(h.from_state, 'open') IN ('open', 'stage1', 'skipped', 'rejected')
           AND coalesce(h.to_state, 'open') IN ('open', 'stage1', 'skipped', 'rejected')",
        values![&t.id, user],
    )?;
    row.map_or(Ok(0), |r| r.int("n"))
}

/// The complete answer about one task. `found` are the findings in its draft; checking takes long, so it is done
/// outside of transactions.
pub fn task(app: &App, tx: &mut dyn Tx, t: &TaskRow, actor: &Actor, found: Vec<Finding>) -> Answer<Task> {
    let names = tasks::names(tx)?;
    let stage = t.at.state.stage();
    let shown = label(&t.draft, t.view());
    let mine = t.at.holder.as_deref() == Some(actor.id.as_str());
    let history_count = match stage {
        Stage::Stage1 => count_own(tx, t, &actor.id)?,
        Stage::Stage2 => t.seq,
    };
    Ok(Task {
        version: t.version,
        stage,
        fence: mine.then_some(t.fence),
        lease_until: t.lease_until.filter(|_| mine),
        spec: create::spec_of(app.framework, &t.episode.scenario_id).filter(|_| !t.hides_leaf()).cloned(),
        suggestion: suggestion(t),
        drafted_by: drafted_by(t),
        imported: imported(t),
        judgement: judgements::of(tx, t, actor)?,
        comments: comments(tx, t, actor, &names)?,
        history_count,
        findings: found,
        take_refused: take_refused(app, tx, t, actor)?,
        permissions: permissions::of(tx, t, actor)?,
        changed_from_suggestion: changed(t),
        task: TaskSummary {
            short_window: short_window(app, t),
            disagrees: actor.is(Role::Lead) && t.disagrees,
            to_choose: actor.is(Role::Lead) && t.to_choose,
            ..tasks::summary(t, &names)
        },
        draft: shown,
    })
}

/// What the drive lacks of a sample's window around the keyframe as it is set now.
fn short_window(app: &App, t: &TaskRow) -> Option<ShortWindow> {
    let span = app.recordings.span(&t.drive_id.as_str().into()).ok()?;
    let set = t.draft.get(name::KEYFRAME).and_then(|k| k.get(name::TIMESTAMP)?.as_str());
    let keyframe = set.and_then(|text| Nanos::parse_iso(text).ok()).unwrap_or(Nanos(t.keyframe_ns));
    Window::of(keyframe, span).short(t.at.state.stage() == Stage::Stage2)
}

/// What Stage I hides of an imported draft.
fn imported(t: &TaskRow) -> Option<Value> {
    if !t.imported || t.at.state.stage() == Stage::Stage1 {
        return None;
    }
    let field = |name: &str| Some((name.to_owned(), t.initial.get(name)?.clone()));
    let found: Map<String, Value> =
        [name::CRITICAL_COMPONENTS, name::CAUSES].into_iter().filter_map(field).collect();
    (!found.is_empty()).then_some(Value::Object(found))
}

/// Why `actor` cannot take `t` now, as a specific message.
fn take_refused(app: &App, tx: &mut dyn Tx, t: &TaskRow, actor: &Actor) -> Answer<Option<Bilingual>> {
    if t.at.holder.as_deref() == Some(actor.id.as_str())
        || matches!(t.at.state, State::Accepted | State::Skipped | State::Rejected)
    {
        return Ok(None);
    }
    if t.at.author() == Some(actor.id.as_str()) {
        let text = match t.at.state {
            State::Submitted => {
                Some(("这是您的标注，正在等待质检", "this is your label; it waits for its check"))
            }
            State::InCheck => Some(("这是您的标注，正在质检", "this is your label; it is being checked")),
            State::Checked => {
                Some(("这是您的标注，正在等待抽检", "this is your label; it waits for its audit"))
            }
            State::InAudit => Some(("这是您的标注，正在抽检", "this is your label; it is being audited")),
            _ => None,
        };
        if let Some((zh, en)) = text {
            return Ok(Some(Bilingual::new(zh, en)));
        }
    }
    let settings = projects::get(tx, &t.project)?.settings;
    let now = app.lease_now(tx)?;
    match leases::may_take(tx, t, actor, &settings, now) {
        Ok(_) => Ok(None),
        Err(p) if p.status >= 500 => Err(p),
        Err(p) if p.code == workflow::ROLE_MISSING => Ok(Some(waits_for(t.at.state, actor))),
        Err(p) => Ok(Some(p.text)),
    }
}

/// The role for which a task waits, for a user without this role; for a lead also what can be done about it.
fn waits_for(state: State, actor: &Actor) -> Bilingual {
    match state {
        State::Stage1Locked | State::Stage2 | State::Rework => {
            Bilingual::new("等待作者继续标注", "it waits for its author to continue")
        }
        State::Submitted | State::InCheck => Bilingual::new("等待质检", "it waits for a checker"),
        State::Checked | State::InAudit => Bilingual::new("等待抽检", "it waits for an auditor"),
        _ if actor.is(Role::Lead) => Bilingual::new(
            "等待未看过关键帧之后内容的标注员从队列领取；如需指定人员，请在任务列表中指派",
            "it waits in the queue for an annotator who has not seen what comes after its keyframe; to choose one, \
             assign it in the task list",
        ),
        _ => Bilingual::new("等待标注员领取", "it waits for an annotator"),
    }
}

/// The model that drafted the label.
fn drafted_by(t: &TaskRow) -> Option<String> {
    let by = t.initial.get(name::PROVENANCE)?;
    let model = by.get(name::SOURCE)?.as_str()? == ProvenanceSource::Model.id();
    model.then(|| by.get(name::BY)?.as_str().map(str::to_owned)).flatten()
}

/// Fields that differ from the suggestion, of those that may be shown.
fn changed(t: &TaskRow) -> Vec<String> {
    // Without the L3 class, no drafted part is shown.
    let suggested = LabelView { in_hand: false, ..t.view() };
    whyroad_label::merge::differing(&label(&t.initial, suggested), &label(&t.draft, t.view()))
}

/// The rule's proposal, as far as it may be shown.
fn suggestion(t: &TaskRow) -> Suggestion {
    let e = &t.episode;
    let mut keyframe = e.keyframe.clone();
    let whole = t.at.state.stage() == Stage::Stage2;
    if !whole {
        keyframe.range_end = None;
    }
    if t.hides_leaf() {
        keyframe.range_start = None;
        keyframe.kind = KeyframeType::Reactive;
        return Suggestion {
            keyframe,
            second_keyframe: None,
            range_start: Nanos(t.shown_from()).to_string(),
            range_end: None,
            target_id: None,
            conditions: vec![],
            signals: vec![],
        };
    }
    Suggestion {
        keyframe,
        second_keyframe: e.second_keyframe.clone().filter(|_| whole),
        range_start: e.time_range.start_timestamp.to_string(),
        range_end: whole.then(|| e.time_range.end_timestamp.to_string()),
        target_id: e.target_id.as_ref().map(ToString::to_string),
        conditions: if whole { e.conditions_matched.clone() } else { vec![] },
        signals: e.signals.clone(),
    }
}
