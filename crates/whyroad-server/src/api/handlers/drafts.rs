//! Saving, acting, checking.

use super::tasks::{actor, answer, look};
use crate::api::call::Call;
use crate::api::reply::Reply;
use crate::domain::task::{DraftChange, DraftSaved, Findings, TaskAction, Validate};
use crate::problem::{Answer, Problem};
use crate::service::drafts::Merged;
use crate::service::{actions, drafts, findings, projects, tasks, visible};
use whyroad_label::merge::MAX_DRAFT;

/// `PATCH /tasks/{t}/draft`
pub fn save(call: &Call<'_>) -> Answer<Reply> {
    let change: DraftChange = call.body()?;
    let (id, user, now) = (call.param("t").to_owned(), call.user()?.id.clone(), call.app.now());
    let project = call.grant.project()?.to_owned();
    let saved = call.app.store.write(move |tx| {
        let settings = projects::get(tx, &project)?.settings;
        drafts::save(tx, &id, &user, &settings, &change, now)
    })?;
    let t = saved.task;
    let stage = t.at.state.stage();
    Reply::json(&DraftSaved {
        version: t.version,
        findings: findings::of(call.app, &t.draft, stage),
        merged: (saved.merged == Merged::Yes).then(|| visible::label(&t.draft, stage)),
        lease_until: t.lease_until.unwrap_or(now),
    })
}

/// `POST /tasks/{t}/actions`
pub fn act(call: &Call<'_>) -> Answer<Reply> {
    let request: TaskAction = call.body()?;
    let (id, user, app) = (call.param("t").to_owned(), call.user()?.clone(), call.app.clone());
    let project = call.grant.project()?.to_owned();
    let task = call.app.store.write(move |tx| {
        let project = projects::get(tx, &project)?;
        let before = tasks::get_for_change(tx, &id)?;
        let actor = actor(tx, &before, &user)?;
        let t = actions::act(&app, tx, &id, (&actor, &user.name), &project, &request)?;
        answer(&app, tx, &t, &user)
    })?;
    Reply::json(&task)
}

/// `POST /tasks/{t}/validate`
pub fn validate(call: &Call<'_>) -> Answer<Reply> {
    // The gate has seen that the caller may read the task; the label is the caller's own text.
    look(call)?;
    let Validate { label } = call.body()?;
    if label.to_string().len() > MAX_DRAFT {
        return Err(Problem::new(413, "draft.too_large", "草稿过大", "the draft is too large"));
    }
    Reply::json(&Findings { findings: findings::check(call.app, &label) })
}
