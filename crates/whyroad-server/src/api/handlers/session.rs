//! Signing in and out, the first admin, and information about the service.

use crate::api::access::csrf_of;
use crate::api::call::Call;
use crate::api::reply::Reply;
use crate::api::route::JSON;
use crate::app::{App, Cookies};
use crate::domain::oidc::SignedOut;
use crate::domain::people::{Session, Setup, SignIn, User};
use crate::oidc::flow;
use crate::problem::{Answer, Problem};
use crate::service::{figures, first_account, people};
use crate::{secret, values};
use serde_json::json;
use std::sync::OnceLock;

/// Name of the session cookie.
pub const COOKIE: &str = "whyroad_session";

/// `set-cookie` for a session; an empty value removes it.
fn cookie(app: &App, value: &str) -> String {
    let age = if value.is_empty() { 0 } else { people::SESSION_MS / 1000 };
    let secure = if app.cookies == Cookies::Secure { "; Secure" } else { "" };
    format!("{COOKIE}={value}; Path=/; HttpOnly; SameSite=Lax; Max-Age={age}{secure}")
}

/// The answer about who is signed in, with a cookie for its CSRF value where the caller has none.
fn answer(call: &Call<'_>, user: Option<User>, fresh: Option<String>) -> Answer<Reply> {
    let first_run = call.app.store.read(people::is_first_run)?;
    let (value, cookies) = match (fresh, &call.request.cookie) {
        (Some(fresh), _) => (fresh.clone(), vec![cookie(call.app, &fresh)]),
        (None, Some(old)) => (old.clone(), vec![]),
        (None, None) => {
            let fresh = secret::random(32)?;
            (fresh.clone(), vec![cookie(call.app, &fresh)])
        }
    };
    let provider = call.app.oidc.as_ref().map(|p| p.settings.name.clone());
    let setup_token = first_run && call.app.setup_token.is_some();
    let session = Session { user, csrf: csrf_of(call.app, &value), first_run, setup_token, provider };
    Ok(Reply { cookies, ..Reply::json(&session)? })
}

/// `GET /session`
pub fn show(call: &Call<'_>) -> Answer<Reply> {
    answer(call, call.caller.clone(), None)
}

/// `POST /session`
pub fn sign_in(call: &Call<'_>) -> Answer<Reply> {
    let SignIn { name, password } = call.body()?;
    let (app, now) = (call.app, call.app.now());
    let attempt = app.limits.begin(&name, &call.request.address, now)?;
    let known = match app.store.read(|tx| people::credentials(tx, &name)) {
        Ok(known) => known,
        Err(p) => {
            attempt.forgiven();
            return Err(p);
        }
    };
    // An unknown user takes as long as a wrong password.
    let set = known.as_ref().map(|(_, hash)| hash.clone()).filter(|hash| hash != people::NO_PASSWORD);
    let hash = set.map_or_else(nobody, Ok)?;
    let right = app.limits.one_at_a_time(|| secret::is_password(&password, &hash));
    let Some((id, hash)) = known.filter(|_| right) else { return Err(wrong()) };
    attempt.succeeded();
    begin(call, id, Door::Password(hash))
}

fn wrong() -> Problem {
    Problem::new(401, "session.wrong", "用户名或密码错误", "wrong name or password")
}

/// How somebody signed in.
#[derive(Clone, PartialEq, Eq)]
pub(super) enum Door {
    /// By the password with this hash.
    Password(String),
    /// By the identity provider.
    Provider,
}

/// Starts a session under a new cookie and answers with it.
pub(super) fn begin(call: &Call<'_>, user: String, door: Door) -> Answer<Reply> {
    let (fresh, now) = (secret::random(32)?, call.app.now());
    let value = fresh.clone();
    let user = call.app.store.write(move |tx| {
        // Checking a password takes long: another one may have been set since, which ended all sessions of the old one.
        if let Door::Password(hash) = &door
            && people::password_hash(tx, &user)? != *hash
        {
            return Err(wrong());
        }
        people::start_session(tx, &value, &user, now)?;
        if door == Door::Provider {
            people::note_provider(tx, &value)?;
        }
        people::find(tx, &user)
    })?;
    answer(call, user, Some(fresh))
}

/// A hash that matches no password.
fn nobody() -> Answer<String> {
    static HASH: OnceLock<String> = OnceLock::new();
    if let Some(hash) = HASH.get() {
        return Ok(hash.clone());
    }
    let hash = secret::hash_password(&secret::random(16)?)?;
    Ok(HASH.get_or_init(|| hash).clone())
}

/// `DELETE /session`
pub fn sign_out(call: &Call<'_>) -> Answer<Reply> {
    let mut at_provider = false;
    if let Some(value) = call.request.cookie.clone() {
        at_provider = call.app.store.write(move |tx| {
            let at_provider = people::began_at_provider(tx, &value)?;
            people::end_session(tx, &value)?;
            Ok(at_provider)
        })?;
    }
    // Otherwise the next person at this computer could sign in as this user without being asked.
    let provider = call.app.oidc.as_ref().filter(|_| at_provider);
    let provider_sign_out = provider.and_then(|p| flow::sign_out_address(call.app, p));
    let answer = SignedOut { done: true, provider_sign_out };
    Ok(Reply { cookies: vec![cookie(call.app, "")], ..Reply::json(&answer)? })
}

/// `POST /setup`
pub fn setup(call: &Call<'_>) -> Answer<Reply> {
    let Setup { name, display, password, lang, token } = call.body()?;
    let shown = token.as_deref().unwrap_or_default();
    if call.app.setup_token.as_deref().is_some_and(|wanted| !secret::same(wanted, shown)) {
        return Err(Problem::new(
            403,
            "setup.token",
            "需要服务启动时显示的设置口令",
            "this needs the setup token that the service printed when it started",
        ));
    }
    if call.app.setup_token.is_none()
        && call.app.cookies == Cookies::Plain
        && !is_own_machine(&call.request.host)
    {
        return Err(Problem::new(
            403,
            "setup.host",
            "请在本机用 127.0.0.1 或 localhost 的地址完成首次设置",
            "do the first setup at an address of this machine: 127.0.0.1 or localhost",
        ));
    }
    if !call.app.store.read(people::is_first_run)? {
        return Err(over());
    }
    let hash = call.app.limits.one_at_a_time(|| secret::hash_password(&password))?;
    let lang = lang.unwrap_or_else(|| "zh".to_owned());
    let user = User { id: secret::id()?, name, display, admin: true, lang, disabled: false, email: None };
    let (id, now, door) = (user.id.clone(), call.app.now(), Door::Password(hash.clone()));
    call.app.store.write(move |tx| {
        // Of two concurrent requests, one is too late.
        if !people::is_first_run(tx)? {
            return Err(over());
        }
        people::create(tx, &user, &hash, now)?;
        // Projects from the command line have no members yet.
        tx.run(
            "INSERT INTO members (project_id, user_id, roles, skills)
             SELECT id, $1, '[\"lead\",\"annotator\",\"checker\",\"auditor\"]', '[]' FROM projects
             WHERE NOT EXISTS (SELECT 1 FROM members m WHERE m.project_id = projects.id)",
            values![&user.id],
        )?;
        first_account::forget(tx)
    })?;
    begin(call, id, door)
}

/// True for `localhost` and IP addresses. A malicious site can make its own *host name* resolve to this machine and so
/// bypass the browser's same-origin rules; it cannot do that with `localhost` or an IP address.
fn is_own_machine(host: &str) -> bool {
    let name = if host.starts_with('[') {
        host.trim_start_matches('[').split(']').next().unwrap_or_default()
    } else {
        host.split(':').next().unwrap_or_default()
    };
    name == "localhost" || name.parse::<std::net::IpAddr>().is_ok()
}

fn over() -> Problem {
    Problem::new(
        409,
        "setup.done",
        "已有用户，首次设置已结束",
        "users already exist: the initial setup is complete",
    )
}

/// `GET /openapi.json`
pub fn openapi(call: &Call<'_>) -> Answer<Reply> {
    Ok(Reply::bytes(JSON, (call.document)().into_bytes()))
}

/// `GET /healthz`
pub fn health(call: &Call<'_>) -> Answer<Reply> {
    figures::store_ready(call.app).map_err(Problem::store)?;
    Reply::json(&json!({ "done": true }))
}
