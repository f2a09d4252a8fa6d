//! The access check before every handler: identifies the caller and checks whether they may call the route. It is the
//! only such check, so no route can omit it.

use super::call::{Grant, Request};
use super::route::{Access, Route, Verb};
use crate::app::App;
use crate::domain::people::{TokenScope, User};
use crate::domain::workflow::Role;
use crate::problem::{Answer, Problem};
use crate::service::recognized::Hidden;
use crate::service::{people, projects, tasks, tokens};
use crate::store::Tx;
use crate::{secret, values};

/// The value of `x-csrf-token` that belongs to a session cookie.
pub fn csrf_of(app: &App, cookie: &str) -> String {
    secret::sign(&app.csrf_key, cookie.as_bytes())
}

/// Accepts the request, or returns the reason for refusing it.
pub fn pass(app: &App, route: &Route, request: &Request) -> Answer<(Option<User>, Grant)> {
    if route.verb != Verb::Get && request.token.is_none() {
        let wanted = request.cookie.as_deref().map(|c| csrf_of(app, c));
        let given = request.csrf.as_deref().unwrap_or_default();
        if !wanted.is_some_and(|w| secret::same(&w, given)) {
            return Err(Problem::new(
                403,
                "session.csrf",
                "缺少或错误的 x-csrf-token",
                "x-csrf-token is missing or wrong; GET /session returns it",
            ));
        }
    }
    let credentials = request.token.is_some() || request.cookie.is_some();
    // Nobody to look up.
    if route.access == Access::Anyone && (route.is_probe || !credentials) {
        return Ok((None, Grant::default()));
    }
    let now = app.now();
    app.store.read(|tx| {
        let user = match (&request.token, &request.cookie) {
            (Some(token), _) => {
                let (user, scope) = tokens::holder(tx, token, now)?.ok_or_else(Problem::sign_in)?;
                may_by_token(route, scope)?;
                Some(user)
            }
            (None, Some(cookie)) => people::by_cookie(tx, cookie, now)?,
            (None, None) => None,
        };
        if route.access == Access::Anyone {
            return Ok((user, Grant::default()));
        }
        let user = user.ok_or_else(Problem::sign_in)?;
        let grant = grant(tx, route, request, &user)?;
        Ok((Some(user), grant))
    })
}

/// Whether the scope of an API token permits a route.
fn may_by_token(route: &Route, scope: TokenScope) -> Answer<()> {
    if route.session_only {
        return Err(Problem::new(
            403,
            "token.session_only",
            "API 令牌不能用于此操作，请登录后进行",
            "API tokens cannot do this: sign in",
        ));
    }
    if route.verb != Verb::Get && scope == TokenScope::Read {
        return Err(Problem::new(403, "token.read_only", "该 API 令牌只读", "this API token is read-only"));
    }
    Ok(())
}

fn grant(tx: &mut dyn Tx, route: &Route, request: &Request, user: &User) -> Answer<Grant> {
    let param = |name: &str| request.params.get(name).map_or("", String::as_str);
    let allowed = |fine: bool| if fine { Ok(()) } else { Err(Problem::forbidden()) };
    match route.access {
        Access::Anyone | Access::SignedIn => Ok(Grant::default()),
        Access::Admin => allowed(user.admin).map(|()| Grant::default()),
        Access::Member | Access::Staff | Access::Lead if route.path.starts_with("/projects/") => {
            let grant = in_project(tx, param("p"), user)?;
            allowed(match route.access {
                Access::Staff => grant.is_staff(),
                Access::Lead => grant.roles.contains(&Role::Lead),
                _ => true,
            })?;
            Ok(grant)
        }
        // A member may have the task from the queue or a link; the workflow decides the rest.
        Access::Member | Access::Staff | Access::Lead => {
            of_task(tx, param("t"), user).map(|(grant, _)| grant)
        }
        Access::TaskReader | Access::TaskWorker => readable(tx, param("t"), user),
        Access::TaskLead => {
            let grant = readable(tx, param("t"), user)?;
            allowed(grant.roles.contains(&Role::Lead))?;
            Ok(grant)
        }
        Access::CommentReader => {
            let task = owner(tx, "SELECT task_id AS owner FROM comments WHERE id = $1", param("c"))?;
            readable(tx, &task, user)
        }
        Access::WebhookLead => {
            let project = owner(tx, "SELECT project_id AS owner FROM webhooks WHERE id = $1", param("w"))?;
            let grant = in_project(tx, &project, user)?;
            allowed(grant.roles.contains(&Role::Lead))?;
            Ok(grant)
        }
    }
}

fn owner(tx: &mut dyn Tx, sql: &str, id: &str) -> Answer<String> {
    tx.row(sql, values![id])?.ok_or_else(Problem::missing)?.text("owner")
}

/// Roles in a project; to a user who is not a member, it appears not to exist.
fn in_project(tx: &mut dyn Tx, project: &str, user: &User) -> Answer<Grant> {
    let there = tx.row("SELECT 1 FROM projects WHERE id = $1", values![project])?;
    let roles = roles(tx, project, user)?;
    if there.is_none() || roles.is_empty() {
        return Err(Problem::missing());
    }
    Ok(Grant { project: Some(project.to_owned()), roles })
}

/// Roles of a user in a project; an admin is lead everywhere.
pub fn roles(tx: &mut dyn Tx, project: &str, user: &User) -> Answer<Vec<Role>> {
    let mut roles = projects::roles(tx, project, &user.id)?;
    if user.admin && !roles.contains(&Role::Lead) {
        roles.push(Role::Lead);
    }
    Ok(roles)
}

fn of_task(tx: &mut dyn Tx, task: &str, user: &User) -> Answer<(Grant, tasks::Concern)> {
    let concern = tasks::concern(tx, task)?;
    let grant = in_project(tx, &concern.project, user)?;
    if Hidden::of(tx, &concern.project, &user.id, &grant.roles)?.ids.contains(task) {
        return Err(Problem::missing());
    }
    Ok((grant, concern))
}

/// Staff read all tasks of their project, others the tasks that they hold, write or were given.
fn readable(tx: &mut dyn Tx, task: &str, user: &User) -> Answer<Grant> {
    let (grant, concern) = of_task(tx, task, user)?;
    if grant.is_staff() || concern.is_of(&user.id) { Ok(grant) } else { Err(Problem::missing()) }
}
