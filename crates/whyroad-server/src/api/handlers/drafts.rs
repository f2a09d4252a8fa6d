//! Saving, acting, checking.

use super::tasks::{actor, answer, look};
use crate::api::access;
use crate::api::call::Call;
use crate::api::reply::Reply;
use crate::domain::people::User;
use crate::domain::safety::SafetyRequest;
use crate::domain::task::{DraftChange, DraftSaved, Findings, TaskAction, Validate};
use crate::domain::workflow::{Actor, Seen, Stage};
use crate::problem::{Answer, Problem};
use crate::service::drafts::Merged;
use crate::service::tasks::TaskRow;
use crate::service::{actions, drafts, findings, projects, safety, seen, tasks, visible};
use crate::store::Tx;
use whyroad_label::merge::MAX_DRAFT;

/// `PATCH /tasks/{t}/draft`
pub fn save(call: &Call<'_>) -> Answer<Reply> {
    let change: DraftChange = call.body()?;
    let (id, user, app) = (call.param("t").to_owned(), call.user()?.clone(), call.app.clone());
    let project = call.grant.project()?.to_owned();
    let saved = call.app.store.write(move |tx| {
        let settings = projects::get(tx, &project)?.settings;
        let now = app.lease_now(tx)?;
        // Saving asks for the role only, not for what was seen.
        let roles = access::roles(tx, &project, &user)?;
        let actor = Actor { id: user.id.clone(), roles, has_seen: Seen::History };
        drafts::save(tx, &id, &actor, &settings, &change, now)
    })?;
    let t = saved.task;
    Reply::json(&DraftSaved {
        version: t.version,
        findings: findings::of(call.app, &t, &t.draft, t.view()),
        merged: (saved.merged == Merged::Yes).then(|| visible::label(&t.draft, t.view())),
        lease_until: t.lease_until.unwrap_or_default(),
    })
}

/// Number of attempts to check a draft that changes in the meantime.
const CHECKS: usize = 5;

/// `POST /tasks/{t}/actions`
pub fn act(call: &Call<'_>) -> Answer<Reply> {
    let request: TaskAction = call.body()?;
    let mut tries = 1;
    loop {
        match act_once(call, &request) {
            Err(p) if p.code == actions::CHANGED_SINCE && tries < CHECKS => tries += 1,
            Ok(t) => return answer(call, &t),
            Err(p) => return Err(p),
        }
    }
}

fn act_once(call: &Call<'_>, request: &TaskAction) -> Answer<TaskRow> {
    let (id, user, app) = (call.param("t").to_owned(), call.user()?.clone(), call.app.clone());
    let before = app.store.read(|tx| tasks::get(tx, &id))?;
    let checked = actions::check(&app, &before, &user.name, request, app.now())?;
    let (project, request) = (call.grant.project()?.to_owned(), request.clone());
    call.app.store.write(move |tx| {
        seen::lock(tx, &user.id)?;
        let project = projects::get(tx, &project)?;
        let before = tasks::get_for_change(tx, &id)?;
        let actor = actor(tx, &before, &user)?;
        actions::act(&app, tx, &id, &actor, &project, &request, checked.as_ref())
    })
}

/// `POST /tasks/{t}/safety`
pub fn safety(call: &Call<'_>) -> Answer<Reply> {
    let request: SafetyRequest = call.body()?;
    let (id, user, app) = (call.param("t").to_owned(), call.user()?.clone(), call.app.clone());
    let project = call.grant.project()?.to_owned();
    let t = call.app.store.write(move |tx| {
        let project = projects::get(tx, &project)?;
        let actor = actor_of(tx, &id, &user)?;
        safety::record(&app, tx, &id, &actor, &project, &request)
    })?;
    answer(call, &t)
}

fn actor_of(tx: &mut dyn Tx, id: &str, user: &User) -> Answer<Actor> {
    let t = tasks::get_for_change(tx, id)?;
    actor(tx, &t, user)
}

/// `POST /tasks/{t}/validate`
pub fn validate(call: &Call<'_>) -> Answer<Reply> {
    // The access check has verified that the caller may read the task; the label is the caller's own text.
    let t = look(call)?;
    let Validate { label } = call.body()?;
    if label.to_string().len() > MAX_DRAFT {
        return Err(Problem::new(413, "draft.too_large", "草稿过大", "the draft is too large"));
    }
    // In Stage I without what the recording has after the keyframe.
    let findings = match t.view().stage {
        Stage::Stage1 => findings::in_stage1(call.app, &t, &label),
        Stage::Stage2 => findings::of(call.app, &t, &label, t.view()),
    };
    Reply::json(&Findings { findings })
}
