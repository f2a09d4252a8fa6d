//! Saves changed fields of a draft, and rebuilds an earlier draft from the history.

use crate::domain::project::Settings;
use crate::domain::task::{Conflicts, DraftChange};
use crate::domain::workflow::{Actor, Stage, State};
use crate::problem::{Answer, Problem};
use crate::service::projects::parse;
use crate::service::tasks::{self, Entry, TaskRow};
use crate::service::{history, leases, visible};
use crate::store::Tx;
use crate::values;
use serde_json::Value;
use whyroad_label::merge::{self, FieldChange};
use whyroad_model::label_fields::{name, pointer};

/// Result of saving.
#[derive(Clone, Debug)]
pub struct Saved {
    /// The task with its new draft.
    pub task: TaskRow,
    /// Whether changes by others were made in between and kept.
    pub merged: Merged,
}

/// Whether changes by others were made in between.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Merged {
    /// No.
    No,
    /// Yes: the caller does not have the current draft.
    Yes,
}

/// Saves changed fields, in one transaction with their entry in the history. Changes based on an older version are
/// merged field by field.
pub fn save(
    tx: &mut dyn Tx,
    task: &str,
    actor: &Actor,
    settings: &Settings,
    change: &DraftChange,
    now: i64,
) -> Answer<Saved> {
    let mut t = tasks::get_for_change(tx, task)?;
    leases::may_edit(&t, actor, Some(change.fence))?;
    if change.changes.is_empty() || change.changes.len() > merge::MAX_CHANGES {
        return Err(Problem::request(
            format!("一次须有 1 至 {} 处修改", merge::MAX_CHANGES),
            format!("a request must have 1 to {} changes", merge::MAX_CHANGES),
        ));
    }
    for c in &change.changes {
        merge::canonical(&c.path)?;
        visible::may_change(&t, &c.path, &c.value)?;
    }
    let changes = by_field(&t, &change.changes);
    let merged = if change.base_version == t.version { Merged::No } else { Merged::Yes };
    if merged == Merged::Yes {
        clash(tx, &t, change.base_version, &changes)?;
    }
    let mut draft = t.draft.clone();
    for c in &changes {
        merge::apply(&mut draft, c)?;
    }
    merge::bounded(&draft)?;
    t.draft = draft;
    t.version += 1;
    leases::extend(&mut t, settings, now);
    let from = Some(t.at.state);
    let entry = Entry { action: "edit", actor: Some(&actor.id), from, changes: &changes, ..Entry::default() };
    history::record(tx, &mut t, &entry, now)?;
    tasks::update(tx, &t)?;
    Ok(Saved { task: t, merged })
}

/// In Stage I a keyframe is changed part by part, so that the end of its range, which is not shown, is kept.
fn by_field(t: &TaskRow, changes: &[FieldChange]) -> Vec<FieldChange> {
    // If the L3 class is hidden, only the moment is changed: the type of the keyframe was not shown.
    let sets = |part: &str| !t.hides_leaf() || visible::MOMENT.contains(&part);
    let mut out = Vec::new();
    for c in changes {
        match c.value.as_object().filter(|_| t.at.state == State::Stage1 && c.path == pointer::KEYFRAME) {
            Some(parts) => out.extend(parts.iter().filter(|(k, _)| sets(k)).map(|(k, v)| FieldChange {
                path: format!("{}/{}", pointer::KEYFRAME, k.replace('~', "~0").replace('/', "~1")),
                value: v.clone(),
                remove: false,
            })),
            None => out.push(c.clone()),
        }
    }
    out
}

/// Refuses when the fields of `mine` were changed by others since version `base`.
fn clash(tx: &mut dyn Tx, t: &TaskRow, base: i64, mine: &[FieldChange]) -> Answer<()> {
    if base > t.version {
        return Err(Problem::request(
            format!("base_version {base} 尚不存在"),
            format!("base_version {base} does not exist yet"),
        ));
    }
    let theirs = since(tx, t, base)?;
    let conflicts = merge::conflicts(&t.draft, mine, &theirs);
    if conflicts.is_empty() {
        return Ok(());
    }
    let more = Conflicts { version: t.version, draft: visible::label(&t.draft, t.view()), conflicts };
    let more = serde_json::to_value(more).map_err(Problem::store)?;
    Err(Problem::new(
        409,
        "draft.conflict",
        "这些字段同时被另一处修改",
        "these fields were changed elsewhere at the same time",
    )
    .with(more))
}

/// All changes after `version`; an entry with a whole draft counts as a change of each of its fields.
fn since(tx: &mut dyn Tx, t: &TaskRow, version: i64) -> Answer<Vec<FieldChange>> {
    let rows = tx.rows(
        "SELECT changes, snapshot FROM history WHERE task_id = $1 AND version > $2 ORDER BY seq",
        values![&t.id, version],
    )?;
    let mut out = Vec::new();
    for row in rows {
        if let Some(changes) = row.maybe_text("changes")? {
            out.extend(parse::<Vec<FieldChange>>(&changes)?);
        }
        if let Some(snapshot) = row.maybe_text("snapshot")? {
            let whole: Value = parse(&snapshot)?;
            let fields = whole.as_object().into_iter().flatten();
            out.extend(fields.map(|(k, v)| FieldChange {
                path: format!("/{k}"),
                value: v.clone(),
                remove: false,
            }));
        }
    }
    Ok(out)
}

/// The draft after entry `seq` of the history.
pub fn at(tx: &mut dyn Tx, t: &TaskRow, seq: i64) -> Answer<Value> {
    let rows = tx.rows(
        "SELECT seq, changes, snapshot FROM history WHERE task_id = $1 AND seq <= $2 ORDER BY seq",
        values![&t.id, seq],
    )?;
    if rows.last().map(|r| r.int("seq")).transpose()? != Some(seq) {
        return Err(Problem::missing());
    }
    let mut draft = t.initial.clone();
    for row in rows {
        if let Some(snapshot) = row.maybe_text("snapshot")? {
            draft = parse(&snapshot)?;
        }
        if let Some(changes) = row.maybe_text("changes")? {
            for c in parse::<Vec<FieldChange>>(&changes)? {
                merge::apply(&mut draft, &c)?;
            }
        }
    }
    Ok(draft)
}

/// `now` with those parts of `old` that may be changed in this state.
pub fn restored(t: &TaskRow, old: &Value) -> Value {
    let suggested = t.hides_drafted() && t.are_suggested_in(old);
    let hidden = |field: &str| field == name::CRITICAL_COMPONENTS && suggested;
    let open =
        |field: &str| visible::may_change(t, &format!("/{field}"), &Value::Null).is_ok() && !hidden(field);
    let mut out = t.draft.as_object().cloned().unwrap_or_default();
    out.retain(|field, _| !open(field));
    let back = old.as_object().into_iter().flatten().filter(|(field, _)| open(field));
    out.extend(back.map(|(k, v)| (k.clone(), v.clone())));
    Value::Object(out)
}

/// The draft after `seq` as `user` may see it now.
pub fn at_for(tx: &mut dyn Tx, t: &TaskRow, user: &str, seq: i64) -> Answer<Value> {
    let stage = t.at.state.stage();
    if stage == Stage::Stage1 && !visible::history(tx, t, user)?.iter().any(|e| e.seq == seq) {
        return Err(Problem::missing());
    }
    Ok(visible::earlier(&at(tx, t, seq)?, t))
}
