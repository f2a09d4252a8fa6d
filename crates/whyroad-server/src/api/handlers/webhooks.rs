//! Webhooks of a project.

use crate::api::call::Call;
use crate::api::reply::Reply;
use crate::domain::people::Done;
use crate::domain::project::{NewWebhook, Webhooks};
use crate::problem::Answer;
use crate::service::webhooks::{self, Wanted};
use std::sync::Arc;

/// `GET /projects/{p}/webhooks`
pub fn list(call: &Call<'_>) -> Answer<Reply> {
    let project = call.grant.project()?;
    Reply::json(&Webhooks { items: call.app.store.read(|tx| webhooks::list(tx, project))? })
}

/// `GET /webhooks/paused`
pub fn paused(call: &Call<'_>) -> Answer<Reply> {
    Reply::json(&Webhooks { items: call.app.store.read(webhooks::paused)? })
}

/// `POST /projects/{p}/webhooks`
pub fn create(call: &Call<'_>) -> Answer<Reply> {
    let wanted: NewWebhook = call.body()?;
    let (project, owner, now) = (call.grant.project()?.to_owned(), call.user()?.clone(), call.app.now());
    let (reach, vault) = (call.app.reach.clone(), Arc::clone(&call.app.store.vault));
    let hook = call.app.store.write(move |tx| {
        let wanted = Wanted { project: &project, owner: &owner, url: &wanted.url, events: &wanted.events };
        webhooks::create(tx, wanted, &reach, &vault, now)
    })?;
    Reply::json(&hook)
}

/// `DELETE /webhooks/{w}`
pub fn remove(call: &Call<'_>) -> Answer<Reply> {
    let id = call.param("w").to_owned();
    call.app.store.write(move |tx| webhooks::remove(tx, &id))?;
    Reply::json(&Done { done: true })
}
