//! Signing in at an identity provider, and its users who are linked to an account here.

use super::session::{self, Door};
use crate::api::call::Call;
use crate::api::reply::Reply;
use crate::domain::oidc::{BeginAtProvider, Identities, ProviderAddress};
use crate::domain::people::Done;
use crate::oidc::flow::{self, Browser, Purpose, Returned};
use crate::oidc::provider::Provider;
use crate::problem::{Answer, Problem};
use crate::service::identities;

fn provider<'a>(call: &'a Call<'_>) -> Answer<&'a Provider> {
    call.app.oidc.as_ref().ok_or_else(|| {
        Problem::new(
            404,
            "oidc.off",
            "此服务没有设置身份提供方",
            "no identity provider is set up for this service",
        )
    })
}

/// The browser of the caller. A caller with a token has none.
fn browser<'a>(call: &'a Call<'_>) -> Answer<Browser<'a>> {
    let cookie = call.request.cookie.as_deref().filter(|_| call.request.token.is_none());
    let cookie = cookie.ok_or_else(|| {
        Problem::request("仅供浏览器使用：需要会话 cookie", "for browsers only: a session cookie is needed")
    })?;
    Ok(Browser { cookie, user: call.caller.as_ref().map(|u| u.id.as_str()) })
}

/// `POST /oidc/begin`
pub fn begin(call: &Call<'_>) -> Answer<Reply> {
    let BeginAtProvider { purpose } = call.body()?;
    let (provider, mut browser) = (provider(call)?, browser(call)?);
    match purpose {
        Purpose::Link => drop(call.user()?),
        Purpose::SignIn => browser.user = None,
    }
    call.app.limits.admit_from(&call.request.address, call.app.now())?;
    Reply::json(&ProviderAddress { url: flow::begin(call.app, provider, browser, purpose)? })
}

/// `POST /oidc/finish`
pub fn finish(call: &Call<'_>) -> Answer<Reply> {
    let returned: Returned = call.body()?;
    let (app, provider, browser) = (call.app, provider(call)?, browser(call)?);
    let (address, now) = (&call.request.address, app.now());
    let attempt = app.limits.begin_from(address, now)?;
    let (claims, purpose) = match flow::finish(app, provider, browser, &returned) {
        Ok(done) => {
            attempt.forgiven();
            done
        }
        Err(p) => {
            // A failure of the provider does not count against the person who signs in.
            if p.status != 403 {
                attempt.forgiven();
            }
            return Err(p);
        }
    };
    let settings = provider.settings.clone();
    if purpose == Purpose::Link {
        let user = call.user()?.id.clone();
        app.store.write(move |tx| identities::link(tx, &settings, &claims, &user, now))?;
        return session::show(call);
    }
    let user = app.store.write(move |tx| identities::enter(tx, &settings, &claims, now))?;
    session::begin(call, user, Door::Provider)
}

/// `GET /identities`
pub fn list(call: &Call<'_>) -> Answer<Reply> {
    let caller = call.user()?;
    let user = call.query("user").unwrap_or(&caller.id);
    if user != caller.id && !caller.admin {
        return Err(Problem::forbidden());
    }
    Reply::json(&Identities { items: call.app.store.read(|tx| identities::of_user(tx, user))? })
}

/// `DELETE /identities/{id}`
pub fn unlink(call: &Call<'_>) -> Answer<Reply> {
    let (id, caller) = (call.param("id").to_owned(), call.user()?.clone());
    call.app.store.write(move |tx| identities::unlink(tx, &id, &caller))?;
    Reply::json(&Done { done: true })
}
