//! Lists, creation, the queue, leases, assignment.

use crate::api::access;
use crate::api::call::Call;
use crate::api::reply::Reply;
use crate::domain::people::User;
use crate::domain::task::{
    Assign, BulkChange, CreateTasks, EpisodeTask, LeaseAction, LeaseRequest, MinedFolder, MinedFolders,
    NextTask, OtherClass, QueueState, WorkKind,
};
use crate::domain::workflow::{Actor, Role, Stage};
use crate::problem::{Answer, Problem};
use crate::service::create::Drafting;
use crate::service::mined::EpisodeName;
use crate::service::recognized::Hidden;
use crate::service::sample_window::Window;
use crate::service::tasks::TaskRow;
use crate::service::{
    answer, bulk, create, drafting, findings, leases, list as listing, mined as episodes, other_class,
    projects, queue, seen, tasks, texts, thumbnail, work,
};
use crate::store::Tx;
use std::collections::HashMap;
use whyroad_model::Nanos;
use whyroad_model::messages::EpisodeFilter;

/// `GET /projects/{p}/tasks`
pub fn list(call: &Call<'_>) -> Answer<Reply> {
    let leads = call.grant.roles.contains(&Role::Lead);
    let groups = match call.query("overlap") {
        Some("disagreeing") => Some(listing::Groups::Disagreeing),
        Some("to_choose") => Some(listing::Groups::ToChoose),
        _ => None,
    };
    if groups.is_some() && !leads {
        return Err(Problem::forbidden());
    }
    let filter = listing::Filter {
        states: call.query("state"),
        scenario: call.query("scenario"),
        assignee: call.query("assignee"),
        part: call.query("q"),
        cursor: call.query("cursor"),
        limit: call.query("limit"),
        sort: call.query("sort"),
        asks_lead: call.query("asks") == Some("lead"),
        wrong_class: leads && call.query("asks") == Some("class"),
        finding: call.query("finding"),
        groups,
        hidden: None,
        only_of: (!call.grant.is_staff() || call.query("mine") == Some("true"))
            .then_some(call.user()?.id.as_str()),
    };
    let project = call.grant.project()?;
    let (user, labels) = (call.user()?, call.grant.roles.contains(&Role::Annotator));
    let viewer = listing::Viewer { user: &user.id, labels, leads };
    let (mut page, keyframes) = call.app.store.read(|tx| {
        let hidden = Hidden::of(tx, project, &user.id, &call.grant.roles)?;
        let filter = listing::Filter { hidden: Some(&hidden.ids), ..filter };
        listing::page(tx, project, &filter, viewer)
    })?;
    let mut spans: HashMap<String, Option<(Nanos, Nanos)>> = HashMap::new();
    for (item, keyframe) in page.items.iter_mut().zip(keyframes) {
        let span = || call.app.recordings.span(&item.drive_id.as_str().into()).ok();
        let span = *spans.entry(item.drive_id.clone()).or_insert_with(span);
        item.keyframe_s = span.map(|(start, _)| keyframe.seconds_since(start));
        // How long the drive goes on is for leads, who decide what is labeled, and after Stage I.
        let with_future = leads || item.stage == Stage::Stage2;
        item.short_window = span.and_then(|span| Window::of(keyframe, span).short(with_future));
    }
    Reply::json(&page)
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
    let user = &call.user()?.id;
    Reply::json(&create::create(call.app, call.grant.project()?, &request, Some(user), Drafting::Later)?)
}

/// `POST /projects/{p}/tasks:next`
pub fn next(call: &Call<'_>) -> Answer<Reply> {
    let NextTask { kind } = call.body()?;
    let (app, user, roles) = (call.app.clone(), call.user()?.clone(), call.grant.roles.clone());
    let project = call.grant.project()?.to_owned();
    let found = call.app.store.write(move |tx| {
        seen::lock(tx, &user.id)?;
        let project = projects::get(tx, &project)?;
        let now = app.lease_now(tx)?;
        queue::next(tx, &project, &user, &roles, kind, now)
    })?;
    found.map_or_else(|| Ok(Reply::nothing()), |t| answer(call, &drafting::ready(call.app, t)?))
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
                format!("'{other}' is not a kind of work (label, check or audit)"),
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

/// Reads a task in order to show it, and records which part of its drive the caller is shown.
pub fn look(call: &Call<'_>) -> Answer<TaskRow> {
    let (id, user) = (call.param("t"), call.user()?);
    let t = drafting::ready(call.app, call.app.store.read(|tx| tasks::get(tx, id))?)?;
    seen::note(&call.app.store, &t, &user.id)?;
    Ok(t)
}

/// The answer about task `t` in its current state.
pub fn answer(call: &Call<'_>, t: &TaskRow) -> Answer<Reply> {
    let user = call.user()?;
    let found = findings::of(call.app, t, &t.draft, t.view());
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
    if request.action == LeaseAction::Take {
        drafting::ready(call.app, call.app.store.read(|tx| tasks::get(tx, &id))?)?;
    }
    let lease = call.app.store.write(move |tx| {
        if request.action == LeaseAction::Take {
            seen::lock(tx, &user.id)?;
        }
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
                // A lead may release a task that another user holds; the holder sends the token.
                if holds || !actor.is(Role::Lead) {
                    leases::held(&t, &user.id, request.fence)?;
                }
                let reason = texts::reason(request.reason.as_deref())?;
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
        seen::lock(tx, &caller.id)?;
        let mut t = tasks::get_for_change(tx, &id)?;
        bulk::assign(tx, &mut t, wanted.as_deref(), None, &caller, now)?;
        seen::show(tx, &t, &caller.id)?;
        Ok(t)
    })?;
    answer(call, &t)
}

/// `POST /tasks/{t}/reclass`
pub fn reclass(call: &Call<'_>) -> Answer<Reply> {
    let OtherClass { scenario } = call.body()?;
    let (id, user) = (call.param("t").to_owned(), call.user()?.clone());
    let (t, project) = call.app.store.read(|tx| {
        let t = tasks::get(tx, &id)?;
        let project = projects::get(tx, &t.project)?;
        Ok((t, project))
    })?;
    // Outside of the transaction: it reads the drive.
    let row = other_class::prepare(call.app, &project, &t, &scenario)?;
    let now = call.app.now();
    let made = call.app.store.write(move |tx| {
        let actor = actor(tx, &row, &user)?;
        other_class::replace(tx, &id, &row, &actor, now)
    })?;
    Reply::json(&made)
}

/// `POST /projects/{p}/mined/{m}/tasks`
pub fn from_episode(call: &Call<'_>) -> Answer<Reply> {
    let request: EpisodeTask = call.body()?;
    let project = call.app.store.read(|tx| projects::get(tx, call.grant.project()?))?;
    let name = EpisodeName {
        mined: call.param("m"),
        drive: &request.drive,
        scenario: &request.scenario,
        episode: &request.episode,
    };
    let found = episodes::find(call.app, name)?;
    let other = request.as_class.as_deref().filter(|class| *class != request.scenario);
    let row = match other {
        Some(class) => {
            let episode = other_class::episode_as(call.app.framework, &found, class)?;
            create::undrafted(call.app, &project, &episode, "")?
        }
        None if !call.app.framework.taxonomy.contains(&found.scenario_id) => {
            return Err(Problem::new(
                422,
                "class.missing",
                "没有场景可解释此事件：须给出任务的场景",
                "no class explains this episode: give the class of the task",
            ));
        }
        None => create::drafted(call.app, &project, &found)?,
    };
    let row = TaskRow { priority: request.priority, ..row };
    let (user, now) = (call.user()?.id.clone(), call.app.now());
    let made = call.app.store.write(move |tx| other_class::store(tx, &row, 1, &user, now))?;
    Reply::json(&made)
}

/// `POST /projects/{p}/tasks:change`
pub fn change(call: &Call<'_>) -> Answer<Reply> {
    let wanted: BulkChange = call.body()?;
    let (project, caller, now) = (call.grant.project()?.to_owned(), call.user()?.clone(), call.app.now());
    let changed = call.app.store.write(move |tx| bulk::change(tx, &project, &wanted, &caller, now))?;
    Reply::json(&changed)
}

/// `GET /projects/{p}/work`
pub fn work(call: &Call<'_>) -> Answer<Reply> {
    let (project, user, now) = (call.grant.project()?, call.user()?, call.app.now());
    let roles = &call.grant.roles;
    Reply::json(&call.app.store.report(|tx| work::of(tx, project, &user.id, roles, now))?)
}

/// `GET /tasks/{t}/thumbnail`
pub fn thumbnail(call: &Call<'_>) -> Answer<Reply> {
    let (id, user) = (call.param("t"), call.user()?);
    let labels = call.grant.roles.contains(&Role::Annotator);
    let found = call.app.store.read(|tx| {
        let t = tasks::get(tx, id)?;
        // It shows the target, which reveals the L3 class.
        if t.hides_leaf() {
            return Ok(None);
        }
        // A keyframe is in the future of an earlier one: users who may still do Stage I see only those of tasks that
        // they have opened.
        if labels && !seen::was_shown(tx, &t, &user.id)? {
            return Ok(None);
        }
        Ok(thumbnail::get(tx, id)?.map(|svg| (t, svg)))
    })?;
    let svg = match found {
        // Others may do Stage I one day.
        Some((t, svg)) => seen::note_keyframe(&call.app.store, &t, &user.id).map(|()| Some(svg))?,
        None => None,
    };
    Ok(Reply::bytes("image/svg+xml", svg.ok_or_else(Problem::missing)?.into_bytes()))
}
