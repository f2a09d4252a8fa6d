//! Changes of many tasks at once by a lead: their assignment and priority.

use crate::domain::people::User;
use crate::domain::task::{BulkChange, BulkChanged, BulkRefused};
use crate::domain::workflow::{Role, Seen};
use crate::problem::{Answer, Problem};
use crate::service::tasks::{self, Entry, TaskRow};
use crate::service::{history, people, projects, seen};
use crate::store::Tx;

/// Maximum number of tasks in one request.
const MOST: usize = 500;

/// Changes each of the tasks, or returns the reason for not changing it.
pub fn change(
    tx: &mut dyn Tx,
    project: &str,
    wanted: &BulkChange,
    caller: &User,
    now: i64,
) -> Answer<BulkChanged> {
    if wanted.tasks.is_empty() || wanted.tasks.len() > MOST {
        return Err(Problem::request(
            format!("一次须有 1 至 {MOST} 个任务"),
            format!("a request must have 1 to {MOST} tasks"),
        ));
    }
    let mut out = BulkChanged { changed: 0, refused: vec![] };
    for id in &wanted.tasks {
        match change_one(tx, project, id, wanted, caller, now) {
            Ok(()) => out.changed += 1,
            // A failure of the store fails the whole request; a refusal concerns one task.
            Err(p) if p.status >= 500 => return Err(p),
            Err(p) => out.refused.push(BulkRefused { task: id.clone(), text: p.text }),
        }
    }
    Ok(out)
}

fn change_one(
    tx: &mut dyn Tx,
    project: &str,
    id: &str,
    wanted: &BulkChange,
    caller: &User,
    now: i64,
) -> Answer<()> {
    let mut t = tasks::get_for_change(tx, id)?;
    if t.project != project {
        return Err(Problem::missing());
    }
    if let Some(assign) = &wanted.assign {
        return self::assign(tx, &mut t, assign.user.as_deref(), wanted.priority, caller, now);
    }
    t.priority = wanted.priority.unwrap_or(t.priority);
    tasks::update(tx, &t)
}

/// Assigns `t` to `user`, or returns it to the queue; with another priority if one is given.
pub fn assign(
    tx: &mut dyn Tx,
    t: &mut TaskRow,
    user: Option<&str>,
    priority: Option<i64>,
    caller: &User,
    now: i64,
) -> Answer<()> {
    t.assigned = match user {
        None => None,
        Some(name) => {
            let user = people::find(tx, name)?.ok_or_else(Problem::missing)?;
            if !projects::roles(tx, &t.project, &user.id)?.contains(&Role::Annotator) {
                return Err(Problem::new(
                    422,
                    "assign.not_annotator",
                    "该用户不是本项目的标注员",
                    "this user is not an annotator of the project",
                ));
            }
            refuse_who_has_seen(tx, t, &user.id)?;
            Some(user.id)
        }
    };
    t.priority = priority.unwrap_or(t.priority);
    let (from, note) = (Some(t.at.state), t.assigned.clone());
    let entry =
        Entry { action: "assign", actor: Some(&caller.id), from, note: note.as_deref(), ..Entry::default() };
    history::record(tx, t, &entry, now)?;
    tasks::update(tx, t)
}

/// A task to start is not assigned to somebody who has seen its future.
fn refuse_who_has_seen(tx: &mut dyn Tx, t: &TaskRow, user: &str) -> Answer<()> {
    let rule = projects::get(tx, &t.project)?.settings.history;
    let beginning = !t.at.state.shows_future();
    if beginning && seen::actor(tx, t, user, &[], rule)?.has_seen == Seen::Future {
        return Err(Problem::new(
            409,
            "assign.future_seen",
            "该用户已看过此任务关键帧之后的内容，不得做其阶段一",
            "this user has seen what comes after the task's keyframe and cannot do its Stage I",
        ));
    }
    Ok(())
}
