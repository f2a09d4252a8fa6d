//! Runs of the language model, and judgments.

use super::tasks;
use crate::api::call::Call;
use crate::api::reply::Reply;
use crate::domain::model::{JudgementAnswers, NewModelRun, StopModelRun};
use crate::problem::Answer;
use crate::service::{judgements, model_runs};

/// `GET /projects/{p}/model-runs`
pub fn show(call: &Call<'_>) -> Answer<Reply> {
    let (app, project, roles) = (call.app, call.grant.project()?, &call.grant.roles);
    Reply::json(&app.store.report(|tx| model_runs::work(app, tx, project, roles))?)
}

/// `POST /projects/{p}/model-runs`
pub fn start(call: &Call<'_>) -> Answer<Reply> {
    let wanted: NewModelRun = call.body()?;
    let (app, user, roles) = (call.app.clone(), call.user()?.clone(), call.grant.roles.clone());
    let project = call.grant.project()?.to_owned();
    let run =
        call.app.store.write(move |tx| model_runs::start(&app, tx, &project, (&user, &roles), &wanted))?;
    Reply::json(&run)
}

/// `POST /projects/{p}/model-runs:stop`
pub fn stop(call: &Call<'_>) -> Answer<Reply> {
    let StopModelRun { run } = call.body()?;
    let (project, roles, now) = (call.grant.project()?.to_owned(), call.grant.roles.clone(), call.app.now());
    let stopped = call.app.store.write(move |tx| model_runs::stop(tx, &project, &run, &roles, now))?;
    Reply::json(&stopped)
}

/// `GET /projects/{p}/judge`
pub fn report(call: &Call<'_>) -> Answer<Reply> {
    let project = call.grant.project()?;
    Reply::json(&call.app.store.report(|tx| judgements::report(tx, project))?)
}

/// `POST /tasks/{t}/judgement`
pub fn answer(call: &Call<'_>) -> Answer<Reply> {
    let given: JudgementAnswers = call.body()?;
    let (id, user, now) = (call.param("t").to_owned(), call.user()?.clone(), call.app.now());
    let t = call.app.store.write(move |tx| {
        let before = crate::service::tasks::get_for_change(tx, &id)?;
        let actor = tasks::actor(tx, &before, &user)?;
        judgements::answer(tx, &id, &actor, &given, now)
    })?;
    tasks::answer(call, &t)
}
