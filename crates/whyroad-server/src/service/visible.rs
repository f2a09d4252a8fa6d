//! The parts of a task that may be shown in each stage. All data about a task that leaves the service passes through
//! here or through [`super::scene`]: in Stage I nothing that depends on the time after the keyframe, and no text of
//! another person.

use crate::domain::task::{Comment, HistoryEntry};
use crate::domain::workflow::{Actor, Role, Stage, State};
use crate::problem::{Answer, Problem};
use crate::service::projects::parse;
use crate::service::safety;
use crate::service::tasks::{self, LabelView, TaskRow};
use crate::store::Tx;
use crate::values;
use serde_json::{Map, Value, json};
use std::collections::HashMap;
use whyroad_label::merge::{self, FieldChange};
use whyroad_model::Nanos;
use whyroad_model::label_fields::{name, pointer};
use whyroad_model::messages::KeyframeType;

/// Fields of the label that Stage I shows, in addition to the start of `time_range`.
const STAGE1_FIELDS: [&str; 5] =
    [name::VERSION, name::CLIP_ID, name::SCENARIO, name::KEYFRAME, name::CRITICAL_COMPONENTS];
/// Fields that may be changed in Stage I.
const STAGE1_OPEN: [&str; 2] = [name::CRITICAL_COMPONENTS, name::KEYFRAME];

/// The part of a label that is shown.
pub fn label(label: &Value, view: LabelView) -> Value {
    if view.stage == Stage::Stage2 {
        return label.clone();
    }
    let mut out = Map::new();
    for field in STAGE1_FIELDS {
        if let Some(value) = label.get(field) {
            out.insert(field.to_owned(), value.clone());
        }
    }
    if let Some(keyframe) = out.get_mut(name::KEYFRAME).and_then(Value::as_object_mut) {
        keyframe.remove(name::RANGE_END);
    }
    if view.hides_drafted && !view.in_hand {
        out.insert(name::CRITICAL_COMPONENTS.to_owned(), json!([]));
    }
    if view.hides_leaf {
        without_leaf(&mut out);
        return Value::Object(out);
    }
    if let Some(start) = label.pointer(pointer::TIME_RANGE_START_TIMESTAMP) {
        out.insert(name::TIME_RANGE.to_owned(), json!({ (name::START_TIMESTAMP): start }));
    }
    Value::Object(out)
}

/// Removes the parts that depend on the L3 class: its name, and the type of its keyframe. The start of its range was
/// not added.
fn without_leaf(out: &mut Map<String, Value>) {
    if let Some(scenario) = out.get_mut(name::SCENARIO).and_then(Value::as_object_mut) {
        scenario.retain(|part, _| part == name::L1 || part == name::L2);
    }
    if let Some(keyframe) = out.get_mut(name::KEYFRAME).and_then(Value::as_object_mut) {
        keyframe.retain(|part, _| MOMENT.contains(&part.as_str()));
        keyframe.insert(name::TYPE.to_owned(), json!(KeyframeType::Reactive.id()));
    }
}

/// The part of an earlier draft of `t` that is shown: in Stage I without the suggested components, if these are hidden.
pub fn earlier(draft: &Value, t: &TaskRow) -> Value {
    let view = t.view();
    label(draft, LabelView { in_hand: view.in_hand && !t.are_suggested_in(draft), ..view })
}

/// The parts of a keyframe that state its time.
pub const MOMENT: [&str; 2] = [name::TIMESTAMP, name::FRAME_IDX];

/// True where `path` is the uncertainty of a component.
fn is_uncertainty(path: &str) -> bool {
    path.rsplit_once('/').is_some_and(|(_, last)| last == name::UNCERTAINTY)
}

/// Refuses a change of `path` that the task's state does not allow.
pub fn may_change(t: &TaskRow, path: &str, value: &Value) -> Answer<()> {
    let field = merge::top(path);
    let keyframe = Nanos(t.keyframe_ns);
    if field == name::SAFETY_FILTER {
        return Err(Problem::new(
            422,
            "draft.safety",
            "安全过滤由专门的请求回答，不能作为字段修改",
            "the safety filter has a separate request and cannot be changed as a field",
        ));
    }
    if field == name::CLIP_ID {
        return Err(Problem::new(
            422,
            "draft.clip",
            "标注属于其任务的片段，不能改为另一片段",
            "a label is of the clip of its task and cannot be moved to another one",
        ));
    }
    let part_of_keyframe = path.strip_prefix(pointer::KEYFRAME).and_then(|rest| rest.strip_prefix('/'));
    if t.hides_leaf() && part_of_keyframe.is_some_and(|part| !MOMENT.contains(&part)) {
        return Err(Problem::new(
            422,
            "draft.hidden",
            "本项目阶段一不显示 L3 场景，关键帧范围在阶段二设置",
            "Stage I of this project does not show the L3 class: the keyframe's range is set in Stage II",
        ));
    }
    match t.at.state {
        State::Stage1 if !STAGE1_OPEN.contains(&field) => Err(Problem::new(
            422,
            "draft.hidden",
            format!("阶段一只能修改关键要素和关键帧，不能修改 {path}"),
            format!("in Stage I only critical components and the keyframe can be changed, not {path}"),
        )),
        State::Stage1 if field == name::KEYFRAME => not_after(path, value, keyframe),
        // The requirement of an L3 class on uncertainty could not be known while the class was hidden.
        State::Stage2 if t.veiled && is_uncertainty(path) => Ok(()),
        State::Stage2 if field == name::CRITICAL_COMPONENTS => Err(Problem::new(
            422,
            "draft.frozen",
            "阶段一已锁定，关键要素不能再改",
            "Stage I is locked: its critical components cannot be changed",
        )),
        _ => safety::before(t, path),
    }
}

/// In Stage I the keyframe may move back, never into the hidden part.
fn not_after(path: &str, value: &Value, keyframe: Nanos) -> Answer<()> {
    let hidden = path.rsplit_once('/').is_some_and(|(_, last)| last == name::RANGE_END)
        || value.get(name::RANGE_END).is_some();
    let moment = match path {
        pointer::KEYFRAME => value.get(name::TIMESTAMP).and_then(Value::as_str),
        pointer::KEYFRAME_TIMESTAMP | pointer::KEYFRAME_RANGE_START => value.as_str(),
        _ => None,
    };
    let late = moment.is_some_and(|t| Nanos::parse_iso(t).is_ok_and(|t| t > keyframe));
    // A change of the whole keyframe would remove its hidden end, and a conflict about it would reveal that end.
    let whole = path == pointer::KEYFRAME && !value.is_object();
    if hidden || late || whole {
        return Err(Problem::new(
            422,
            "draft.after_keyframe",
            "阶段一中关键帧不能晚于建议的时刻",
            "in Stage I the keyframe cannot be later than suggested",
        ));
    }
    Ok(())
}

/// Questions to the lead are read in Stage I, too, by a lead who does not label in the project: they wait for an
/// answer, and whoever labels is to see no text of another person before their own Stage I.
pub fn reads_questions(actor: &Actor) -> bool {
    actor.is(Role::Lead) && !actor.is(Role::Annotator)
}

/// Comments on a task that `actor` may see; in Stage I only their own, and those that [`reads_questions`] allows.
pub fn comments(
    tx: &mut dyn Tx,
    t: &TaskRow,
    actor: &Actor,
    names: &HashMap<String, String>,
) -> Answer<Vec<Comment>> {
    let all = t.at.state.stage() == Stage::Stage2;
    let rows = tx.rows(
        "SELECT id, path, author, body, at, resolved, to_lead FROM comments WHERE task_id = $1 ORDER BY at, id",
        values![&t.id],
    )?;
    let mut out = Vec::new();
    for row in rows {
        let author = row.text("author")?;
        let (resolved, to_lead) = (row.flag("resolved")?, row.flag("to_lead")?);
        if all || author == actor.id || to_lead && reads_questions(actor) {
            let author = names.get(&author).cloned().unwrap_or(author);
            let (id, path, text) = (row.text("id")?, row.text("path")?, row.text("body")?);
            out.push(Comment { id, path, author, text, at: row.int("at")?, resolved, to_lead });
        }
    }
    Ok(out)
}

/// The history of a task as `user` may see it; in Stage I only what they did since the task was last opened.
pub fn history(tx: &mut dyn Tx, t: &TaskRow, user: &str) -> Answer<Vec<HistoryEntry>> {
    let all = t.at.state.stage() == Stage::Stage2;
    let names = tasks::names(tx)?;
    let rows = tx.rows(
        "SELECT seq, at, actor, action, from_state, to_state, changes, snapshot, note, version FROM history
         WHERE task_id = $1 ORDER BY seq",
        values![&t.id],
    )?;
    let mut out = Vec::new();
    let mut draft = t.initial.clone();
    for row in rows {
        let before = draft.clone();
        if let Some(snapshot) = row.maybe_text("snapshot")? {
            draft = parse(&snapshot)?;
        }
        let changes: Vec<FieldChange> =
            row.maybe_text("changes")?.map(|c| parse(&c)).transpose()?.unwrap_or_default();
        for c in &changes {
            merge::apply(&mut draft, c)?;
        }
        let actor = row.maybe_text("actor")?;
        let (from, to) = (row.maybe_text("from_state")?, row.maybe_text("to_state")?);
        let state = |word: Option<String>| word.and_then(|w| State::from_word(&w));
        let (from_state, to_state) = (state(from), state(to));
        let action = row.text("action")?;
        if !all {
            // Actions before the task was reopened may reveal the future, even to the user who did them.
            if action == "reopen" {
                out.clear();
            }
            let future = [from_state, to_state].into_iter().flatten().any(State::shows_future);
            if actor.as_deref() != Some(user) || future || action == "reopen" {
                continue;
            }
        }
        let before = earlier(&before, t);
        let was = |c: &FieldChange| before.pointer(&c.path).cloned().unwrap_or_default();
        out.push(HistoryEntry {
            before: changes.iter().map(was).collect(),
            seq: row.int("seq")?,
            at: row.int("at")?,
            actor: actor.map_or_else(|| "whyroad".to_owned(), |a| names.get(&a).cloned().unwrap_or(a)),
            action,
            from_state,
            to_state,
            changes,
            comment: row.maybe_text("note")?,
            version: row.int("version")?,
        });
    }
    Ok(out)
}
