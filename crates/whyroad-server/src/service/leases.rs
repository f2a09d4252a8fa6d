//! Leases: a user holds a task for some minutes, with a fencing token that invalidates older leases. The holder of an
//! expired lease can still write until another user takes the task: then the newer token prevents it.

use crate::domain::project::Settings;
use crate::domain::task::Lease;
use crate::domain::workflow::{self, Action, Actor, Draw, Position, Role, State};
use crate::problem::{Answer, Problem};
use crate::service::tasks::{self, Entry, TaskRow};
use crate::service::{history, seen};
use crate::store::Tx;
use crate::values;
use serde_json::json;
use whyroad_model::label_fields::name;

/// The lease of `t` for its holder.
pub fn lease(t: &TaskRow) -> Lease {
    Lease { fence: t.fence, lease_until: t.lease_until, state: t.at.state }
}

/// Takes `t`: refused while another user has a live lease. A new author of Stage I starts from the suggestion, not from
/// another person's text.
pub fn take(tx: &mut dyn Tx, t: &mut TaskRow, actor: &Actor, settings: &Settings, now: i64) -> Answer<()> {
    let next = may_take(tx, t, actor, settings, now)?;
    let others = matches!(t.at.state, State::Open | State::Stage1)
        && t.at.author().is_some_and(|a| a != actor.id)
        && t.draft != t.initial;
    let from = t.at.state;
    t.at = next;
    t.fence += 1;
    renew(t, settings, now);
    seen::show(tx, t, &actor.id)?;
    if others {
        t.draft = t.initial.clone();
    }
    // Hidden components are kept in the suggested draft, as are the causes that refer to them.
    let cleared = t.hides_drafted() && t.are_suggested_in(&t.draft);
    if cleared {
        t.draft[name::CRITICAL_COMPONENTS] = json!([]);
        if let Some(fields) = t.draft.as_object_mut() {
            fields.remove(name::CAUSES);
        }
    }
    t.version += i64::from(others || cleared);
    let snapshot = (others || cleared).then(|| t.draft.clone());
    let entry = Entry {
        action: "take",
        actor: Some(&actor.id),
        from: Some(from),
        snapshot: snapshot.as_ref(),
        ..Entry::default()
    };
    history::record(tx, t, &entry, now)?;
    tasks::update(tx, t)
}

/// Code of the refusal to check a label of an overlap group that a lead has not chosen.
pub const NOT_CHOSEN: &str = "task.not_chosen";

/// Maximum time that a live lease may appear to start after `now`, ms: when two users take a task at the same moment,
/// one waits for the other's transaction, and has read the clock before.
const LONGEST_WAIT_MS: i64 = 60_000;

/// True while a lease is valid. A remaining time longer than any lease comes from a clock that has since been set back:
/// this must not extend a lease.
fn is_live(t: &TaskRow, settings: &Settings, now: i64) -> bool {
    t.lease_until.is_some_and(|until| until > now && until - now <= longest_ms(settings))
}

/// Maximum remaining time of a live lease, ms.
pub(super) fn longest_ms(settings: &Settings) -> i64 {
    lease_ms(settings) + LONGEST_WAIT_MS
}

/// Length of a lease, ms.
fn lease_ms(settings: &Settings) -> i64 {
    i64::from(settings.lease_s) * 1000
}

/// The workflow position of `t` if `actor` took it, or why they may not take it. Changes nothing.
pub(super) fn may_take(
    tx: &mut dyn Tx,
    t: &TaskRow,
    actor: &Actor,
    settings: &Settings,
    now: i64,
) -> Answer<Position> {
    if is_live(t, settings, now) && t.at.holder.as_deref().is_some_and(|h| h != actor.id) {
        return Err(Problem::new(409, "lease.held", "该任务已由他人领取", "somebody else holds this task")
            .with(json!({ "lease_until": t.lease_until })));
    }
    if t.adjudication.as_deref() == Some("superseded") {
        return Err(Problem::new(
            409,
            "task.superseded",
            "已采用另一份标注",
            "another label of this episode was chosen",
        ));
    }
    if t.at.state == State::Open && t.assigned.as_deref().is_some_and(|a| a != actor.id) {
        return Err(Problem::new(
            403,
            "task.assigned",
            "该任务已指派给他人",
            "this task is assigned to somebody else",
        ));
    }
    let next = workflow::step(&t.at, actor, Action::Take, Draw::Pass)?;
    if matches!(t.at.state, State::Open | State::Stage1) {
        only_one_of_a_group(tx, t, &actor.id)?;
    }
    seen::may_be_shown(tx, t, next.state, &actor.id)?;
    if waits_for_choice(t) {
        return Err(Problem::new(
            409,
            NOT_CHOSEN,
            "该事件有多份独立标注，负责人采用其中一份之后才质检",
            "this episode has several independent labels: one is checked after a lead has chosen it",
        ));
    }
    Ok(next)
}

/// A submitted label of an overlap group that a lead has not chosen: it is not checked.
pub(super) fn waits_for_choice(t: &TaskRow) -> bool {
    let to_check = matches!(t.at.state, State::Submitted | State::InCheck | State::Checked | State::InAudit);
    t.overlap_count > 1 && !t.is_chosen() && to_check
}

/// Independent overlap: nobody labels the same episode twice.
fn only_one_of_a_group(tx: &mut dyn Tx, t: &TaskRow, user: &str) -> Answer<()> {
    if t.overlap_count < 2 {
        return Ok(());
    }
    let other = tx.row(
        "SELECT 1 FROM tasks WHERE project_id = $1 AND episode_id = $2 AND id <> $3 AND authors LIKE $4 LIMIT 1",
        values![&t.project, &t.episode.episode_id, &t.id, format!("%\"{user}\"%")],
    )?;
    if other.is_some() {
        return Err(Problem::new(
            403,
            "task.overlap_twice",
            "您已标注同一事件的另一份",
            "you label another copy of this episode: each copy needs a different annotator",
        ));
    }
    Ok(())
}

fn renew(t: &mut TaskRow, settings: &Settings, now: i64) {
    t.lease_until = Some(now + lease_ms(settings));
}

/// Accepts only the holder with the newest token.
pub fn held(t: &TaskRow, user: &str, fence: Option<i64>) -> Answer<()> {
    let Some(fence) = fence else { return Err(Problem::request("缺少 fence", "fence is missing")) };
    if t.at.holder.as_deref() == Some(user) && t.fence == fence { Ok(()) } else { Err(Problem::lease_lost()) }
}

/// Accepts only the holder with the newest token, and only while they have the role for the work. To a user who is no
/// longer a member, the task appears not to exist.
pub fn held_as(t: &TaskRow, actor: &Actor, role: Role, fence: Option<i64>) -> Answer<()> {
    if actor.roles.is_empty() {
        return Err(Problem::missing());
    }
    held(t, &actor.id, fence)?;
    Ok(actor.needs(role)?)
}

/// Accepts only the holder with the newest token who still labels in the project, and only while the draft may be
/// changed.
pub fn may_edit(t: &TaskRow, actor: &Actor, fence: Option<i64>) -> Answer<()> {
    held_as(t, actor, Role::Annotator, fence)?;
    if !t.at.state.is_editable() {
        return Err(Problem::new(
            409,
            "task.wrong_state",
            "当前状态下不能修改",
            "the draft cannot be changed in this state",
        ));
    }
    Ok(())
}

/// Renews the lease. It is written only when a fifth of it has passed, because heartbeats are frequent.
pub fn keep(tx: &mut dyn Tx, t: &mut TaskRow, settings: &Settings, now: i64) -> Answer<()> {
    let fresh = i64::from(settings.lease_s) * 800;
    if t.lease_until.is_some_and(|until| until - now > fresh && until - now <= fresh * 5 / 4) {
        return Ok(());
    }
    renew(t, settings, now);
    tasks::update(tx, t)
}

/// Renews the lease from now on, without writing it.
pub fn extend(t: &mut TaskRow, settings: &Settings, now: i64) -> i64 {
    renew(t, settings, now);
    t.lease_until.unwrap_or(now)
}

/// Releases the task, with a reason if one is given.
pub fn release(
    tx: &mut dyn Tx,
    t: &mut TaskRow,
    actor: &Actor,
    reason: Option<&str>,
    now: i64,
) -> Answer<()> {
    let from = t.at.state;
    t.at = workflow::step(&t.at, actor, Action::Release, Draw::Pass)?;
    t.lease_until = None;
    let entry = Entry {
        action: "release",
        actor: Some(&actor.id),
        from: Some(from),
        note: reason,
        ..Entry::default()
    };
    history::record(tx, t, &entry, now)?;
    tasks::update(tx, t)
}
