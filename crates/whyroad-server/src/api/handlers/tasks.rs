//! Lists, making, the queue, leases, assignment.

use crate::api::access;
use crate::api::call::Call;
use crate::api::reply::Reply;
use crate::domain::people::User;
use crate::domain::task::{
    Assign, CreateTasks, LeaseAction, LeaseRequest, MinedFolder, MinedFolders, NextTask, QueueState, WorkKind,
};
use crate::domain::workflow::{Actor, Role, Seen};
use crate::problem::{Answer, Problem};
use crate::service::tasks::{Entry, TaskRow};
use crate::service::{
    actions, answer, create, findings, history, leases, list as listing, people, projects, queue, seen, tasks,
};
use crate::store::Tx;
use whyroad_model::messages::EpisodeFilter;

/// `GET /projects/{p}/tasks`
pub fn list(call: &Call<'_>) -> Answer<Reply> {
    let filter = listing::Filter {
        states: call.query("state"),
        scenario: call.query("scenario"),
        assignee: call.query("assignee"),
        part: call.query("q"),
        cursor: call.query("cursor"),
        limit: call.query("limit"),
        only_of: (!call.grant.is_staff() || call.query("mine") == Some("true"))
            .then_some(call.user()?.id.as_str()),
    };
    let project = call.grant.project()?;
    Reply::json(&call.app.store.read(|tx| listing::page(tx, project, &filter))?)
}

/// `GET /mined`
pub fn mined(call: &Call<'_>) -> Answer<Reply> {
    let user = call.user()?;
    let leads = user.admin || call.app.store.read(|tx| projects::leads_any(tx, &user.id))?;
    if !leads {
        return Err(Problem::forbidden());
    }
    let folder = |name: String| {
        let count = call.app.recordings.episode_count(&name, &EpisodeFilter::default());
        let episodes = count.and_then(Result::ok).map_or(0, |n| u32::try_from(n).unwrap_or(u32::MAX));
        MinedFolder { name, episodes }
    };
    Reply::json(&MinedFolders { items: call.app.recordings.mined().into_iter().map(folder).collect() })
}

/// `POST /projects/{p}/tasks:create`
pub fn create(call: &Call<'_>) -> Answer<Reply> {
    let request: CreateTasks = call.body()?;
    Reply::json(&create::create(call.app, call.grant.project()?, &request, Some(&call.user()?.id))?)
}

/// `POST /projects/{p}/tasks:next`
pub fn next(call: &Call<'_>) -> Answer<Reply> {
    let NextTask { kind } = call.body()?;
    let (app, user, roles) = (call.app.clone(), call.user()?.clone(), call.grant.roles.clone());
    let project = call.grant.project()?.to_owned();
    let found = call.app.store.write(move |tx| {
        let project = projects::get(tx, &project)?;
        let now = app.lease_now(tx)?;
        queue::next(tx, &project, &user, &roles, kind, now)
    })?;
    found.map_or_else(|| Ok(Reply::nothing()), |t| answer(call, &t))
}

/// `GET /projects/{p}/queue`
pub fn queue(call: &Call<'_>) -> Answer<Reply> {
    let kind = match call.query("kind") {
        None | Some("label") => WorkKind::Label,
        Some("check") => WorkKind::Check,
        Some("audit") => WorkKind::Audit,
        Some(other) => {
            return Err(Problem::request(
                format!("'{other}' 不是工作类别：label、check 或 audit"),
                format!("'{other}' is not a kind of work: label, check or audit"),
            ));
        }
    };
    let user = call.user()?;
    let reasons = call.app.store.read(|tx| {
        let project = projects::get(tx, call.grant.project()?)?;
        let now = call.app.lease_now(tx)?;
        queue::why_nothing(tx, &project, user, &call.grant.roles, kind, now)
    })?;
    Reply::json(&QueueState { reasons: reasons.into_iter().collect() })
}

/// Reads a task for showing it, and records what of its drive the caller is shown.
pub fn look(call: &Call<'_>) -> Answer<TaskRow> {
    let (id, user) = (call.param("t"), call.user()?);
    let t = call.app.store.read(|tx| tasks::get(tx, id))?;
    if !call.app.store.read(|tx| seen::was_shown(tx, &t, &user.id))? {
        let (row, user) = (t.clone(), user.id.clone());
        call.app.store.write(move |tx| seen::show(tx, &row, &user))?;
    }
    Ok(t)
}

/// The answer about a task as it is in `t`.
pub fn answer(call: &Call<'_>, t: &TaskRow) -> Answer<Reply> {
    let user = call.user()?;
    let found = findings::of(call.app, &t.draft, t.at.state.stage());
    let task = call.app.store.read(|tx| {
        let actor = actor(tx, t, user)?;
        answer::task(call.app, tx, t, &actor, found.clone())
    })?;
    Reply::json(&task)
}

/// The user as an actor on the task.
pub fn actor(tx: &mut dyn Tx, t: &TaskRow, user: &User) -> Answer<Actor> {
    let roles = access::roles(tx, &t.project, user)?;
    let history = projects::get(tx, &t.project)?.settings.history;
    seen::actor(tx, t, &user.id, &roles, history)
}

/// `GET /tasks/{t}`
pub fn show(call: &Call<'_>) -> Answer<Reply> {
    answer(call, &look(call)?)
}

/// `POST /tasks/{t}/lease`
pub fn lease(call: &Call<'_>) -> Answer<Reply> {
    let request: LeaseRequest = call.body()?;
    let (id, user, app) = (call.param("t").to_owned(), call.user()?.clone(), call.app.clone());
    let lease = call.app.store.write(move |tx| {
        let now = app.lease_now(tx)?;
        let mut t = tasks::get_for_change(tx, &id)?;
        let settings = projects::get(tx, &t.project)?.settings;
        let actor = actor(tx, &t, &user)?;
        let holds = t.at.holder.as_deref() == Some(user.id.as_str());
        match request.action {
            LeaseAction::Take => leases::take(tx, &mut t, &actor, &settings, now)?,
            LeaseAction::Heartbeat => {
                leases::held(&t, &user.id, request.fence)?;
                leases::keep(tx, &mut t, &settings, now)?;
            }
            LeaseAction::Release => {
                // A lead takes a task out of another's hands; the holder shows the token.
                if holds || !actor.is(Role::Lead) {
                    leases::held(&t, &user.id, request.fence)?;
                }
                let reason = actions::reason(request.reason.as_deref())?;
                leases::release(tx, &mut t, &actor, reason, now)?;
            }
        }
        Ok(leases::lease(&t))
    })?;
    Reply::json(&lease)
}

/// `POST /tasks/{t}/assign`
pub fn assign(call: &Call<'_>) -> Answer<Reply> {
    let Assign { user: wanted } = call.body()?;
    let (id, caller, now) = (call.param("t").to_owned(), call.user()?.clone(), call.app.now());
    let t = call.app.store.write(move |tx| {
        let mut t = tasks::get_for_change(tx, &id)?;
        t.assigned = match &wanted {
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
                refuse_who_has_seen(tx, &t, &user.id)?;
                Some(user.id)
            }
        };
        let (from, note) = (Some(t.at.state), t.assigned.clone());
        let entry = Entry {
            action: "assign",
            actor: Some(&caller.id),
            from,
            note: note.as_deref(),
            ..Entry::default()
        };
        history::record(tx, &mut t, &entry, now)?;
        tasks::update(tx, &t)?;
        seen::show(tx, &t, &caller.id)?;
        Ok(t)
    })?;
    answer(call, &t)
}

/// Nobody is given a task to begin whose future they know.
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
