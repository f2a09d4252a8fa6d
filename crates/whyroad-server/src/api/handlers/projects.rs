//! Projects, members, dashboard.

use crate::api::access;
use crate::api::call::Call;
use crate::api::reply::Reply;
use crate::domain::gold::NewGold;
use crate::domain::project::{
    AnalyticsPage, Dashboard, MemberChange, Members, NewProject, Project, ProjectChange, Projects,
};
use crate::domain::workflow::Role;
use crate::problem::{Answer, Problem};
use crate::secret;
use crate::service::recognized::Hidden;
use crate::service::{classes, dashboard, facts, gold, people, projects, veil};
use crate::store::Tx;
use std::collections::BTreeMap;
use whyroad_model::Nanos;

/// `GET /projects`
pub fn list(call: &Call<'_>) -> Answer<Reply> {
    let user = call.user()?;
    let items = call.app.store.read(|tx| {
        let mut items = Vec::new();
        for mut project in projects::all(tx)? {
            project.roles = access::roles(tx, &project.id, user)?;
            if !project.roles.is_empty() {
                items.push(project);
            }
        }
        Ok(items)
    })?;
    Reply::json(&Projects { items })
}

/// `POST /projects`
pub fn create(call: &Call<'_>) -> Answer<Reply> {
    let wanted: NewProject = call.body()?;
    classes::check_quota(&call.app.framework.taxonomy, &wanted.quota, &BTreeMap::new())?;
    let project = Project {
        id: secret::id()?,
        name: wanted.name.trim().to_owned(),
        guide: wanted.guide,
        quota: wanted.quota,
        settings: wanted.settings,
        roles: Role::ALL.to_vec(),
    };
    let framework = call.app.framework;
    let (new, user, now) = (project.clone(), call.user()?.id.clone(), call.app.now());
    call.app.store.write(move |tx| {
        projects::create(tx, &new, now)?;
        veil::set(tx, framework, &new.id, &new.settings)?;
        projects::set_member(tx, &new.id, &user, Role::ALL, &[])
    })?;
    Reply::json(&project)
}

/// `GET /projects/{p}`
pub fn show(call: &Call<'_>) -> Answer<Reply> {
    let mut project = call.app.store.read(|tx| projects::get(tx, call.grant.project()?))?;
    project.roles.clone_from(&call.grant.roles);
    Reply::json(&project)
}

/// `PATCH /projects/{p}`
pub fn change(call: &Call<'_>) -> Answer<Reply> {
    let change: ProjectChange = call.body()?;
    let (id, roles) = (call.grant.project()?.to_owned(), call.grant.roles.clone());
    let framework = call.app.framework;
    let taxonomy = &framework.taxonomy;
    let project = call.app.store.write(move |tx| {
        let mut project = projects::get(tx, &id)?;
        // Names from before stay, also one that looks like another.
        if let Some(name) = change.name.as_deref().map(str::trim).filter(|name| *name != project.name) {
            name.clone_into(&mut project.name);
            projects::check_name(tx, &project)?;
        }
        project.guide = change.guide.clone().unwrap_or(project.guide);
        if let Some(quota) = &change.quota {
            classes::check_quota(taxonomy, quota, &project.quota)?;
        }
        project.quota = change.quota.clone().unwrap_or(project.quota);
        if let Some(change) = &change.settings {
            project.settings = project.settings.with(change).map_err(Problem::store)?;
        }
        projects::update(tx, &project)?;
        veil::set(tx, framework, &id, &project.settings)?;
        Ok(Project { roles: roles.clone(), ..project })
    })?;
    Reply::json(&project)
}

/// `GET /projects/{p}/gold`
pub fn gold(call: &Call<'_>) -> Answer<Reply> {
    let project = call.grant.project()?;
    let report = |tx: &mut dyn Tx| {
        let project = projects::get(tx, project)?;
        gold::report(tx, &project)
    };
    Reply::json(&call.app.store.report(report)?)
}

/// `POST /projects/{p}/gold`
pub fn make_gold(call: &Call<'_>) -> Answer<Reply> {
    let wanted: NewGold = call.body()?;
    let (app, project) = (call.app.clone(), call.grant.project()?.to_owned());
    let made = call.app.store.write(move |tx| {
        let project = projects::get(tx, &project)?;
        gold::make(&app, tx, &project, &wanted)
    })?;
    Reply::json(&made)
}

/// `GET /projects/{p}/members`
pub fn members(call: &Call<'_>) -> Answer<Reply> {
    let project = call.grant.project()?;
    Reply::json(&Members { items: call.app.store.read(|tx| projects::members(tx, project))? })
}

/// `POST /projects/{p}/members`
pub fn set_member(call: &Call<'_>) -> Answer<Reply> {
    let change: MemberChange = call.body()?;
    if change.skills.len() > 200 || change.skills.iter().any(|s| s.len() > 100) {
        return Err(Problem::request(
            "技能至多 200 项，每项至多 100 个字符",
            "at most 200 skills with at most 100 characters each",
        ));
    }
    classes::check_skills(&call.app.framework.taxonomy, &change.skills)?;
    let project = call.grant.project()?.to_owned();
    let items = call.app.store.write(move |tx| {
        let user = people::find(tx, &change.user)?.ok_or_else(Problem::missing)?;
        projects::set_member(tx, &project, &user.id, &change.roles, &change.skills)?;
        if let Some(languages) = &change.languages {
            projects::set_languages(tx, &project, &user.id, languages)?;
        }
        projects::members(tx, &project)
    })?;
    Reply::json(&Members { items })
}

/// `GET /projects/{p}/dashboard`
pub fn dashboard(call: &Call<'_>) -> Answer<Reply> {
    let (app, project) = (call.app, call.grant.project()?);
    let read = || {
        app.store.report(|tx| {
            let project = projects::get(tx, project)?;
            dashboard::of(tx, &project, app.now())
        })
    };
    let board = app.dashboards.get(project, read)?;
    if !call.grant.roles.contains(&Role::Annotator) {
        return Reply::json(&*board);
    }
    let (user, roles) = (&call.user()?.id, &call.grant.roles);
    let (veiled, hidden) =
        app.store.read(|tx| Ok((veil::of(tx, project)?, Hidden::of(tx, project, user, roles)?)))?;
    if veiled.is_empty() && hidden.ids.is_empty() {
        return Reply::json(&*board);
    }
    let board = hidden.from_dashboard((*board).clone());
    let coverage = dashboard::veil_coverage(board.coverage.clone(), &veiled);
    Reply::json(&Dashboard { coverage, ..board })
}

/// `GET /projects/{p}/analytics`
pub fn analytics(call: &Call<'_>) -> Answer<Reply> {
    let reports = call.app.reports.as_ref().ok_or_else(Problem::missing)?;
    let offset = call.query("utc_offset").map_or(Ok(0), str::parse::<i8>).ok();
    let offset = offset.filter(|h| (-14..=14).contains(h)).ok_or_else(|| {
        Problem::request(
            "utc_offset 须为 -14 至 14 的整数",
            "utc_offset must be a whole number from -14 to 14",
        )
    })?;
    let project = call.app.store.report(|tx| projects::get(tx, call.grant.project()?))?;
    let (tasks, _) = facts::kept(&call.app.store, &call.app.facts, &project.id)?;
    // Outside of the transaction: creating the page reads folders.
    let now = Nanos(call.app.now().saturating_mul(1_000_000));
    let html = reports.analytics(&project, &tasks, now, offset).map_err(|why| {
        Problem::new(
            422,
            "analytics.unreadable",
            format!("无法生成数据分析：{}", why.zh),
            format!("no analytics: {}", why.en),
        )
    })?;
    Reply::json(&AnalyticsPage { html })
}
