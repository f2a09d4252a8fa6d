//! Users and API tokens.

use crate::api::call::Call;
use crate::api::reply::Reply;
use crate::domain::people::{Done, NewUser, Tokens, User, UserChange, Users};
use crate::problem::{Answer, Problem};
use crate::secret;
use crate::service::{people, projects, tokens};
use crate::store::Tx;

/// `GET /users`
pub fn list(call: &Call<'_>) -> Answer<Reply> {
    let caller = call.user()?;
    let (mut items, fellows) = call.app.store.read(|tx| {
        // Users who assign tasks may assign them to anybody; others see only the people they work with.
        let all = caller.admin || projects::leads_any(tx, &caller.id)?;
        Ok((people::all(tx)?, if all { None } else { Some(projects::fellows(tx, &caller.id)?) }))
    })?;
    items.retain(|u| u.id == caller.id || fellows.as_ref().is_none_or(|f| f.contains(&u.id)));
    for user in items.iter_mut().filter(|u| !caller.admin && u.id != caller.id) {
        user.email = None;
    }
    Reply::json(&Users { items })
}

/// `POST /users`
pub fn create(call: &Call<'_>) -> Answer<Reply> {
    let wanted: NewUser = call.body()?;
    let email = wanted.email.as_deref().and_then(people::email);
    let hash = match &wanted.password {
        Some(password) => call.app.limits.one_at_a_time(|| secret::hash_password(password))?,
        None if email.is_some() => people::NO_PASSWORD.to_owned(),
        None => {
            return Err(Problem::request(
                "用户须有密码或邮箱",
                "a user needs a password or an e-mail address",
            ));
        }
    };
    let user = User {
        id: secret::id()?,
        display: wanted.display.unwrap_or_else(|| wanted.name.clone()),
        name: wanted.name,
        admin: wanted.admin,
        lang: wanted.lang.unwrap_or_else(|| "zh".to_owned()),
        disabled: false,
        email,
    };
    let (new, cookie, now) = (user.clone(), call.request.cookie.clone(), call.app.now());
    call.app.store.write(move |tx| {
        if !caller_now(tx, cookie.as_deref(), now)?.admin {
            return Err(Problem::forbidden());
        }
        people::create(tx, &new, &hash, now)
    })?;
    Reply::json(&user)
}

/// The caller as they are now. Hashing a password takes long, and others may have disabled the account, ended its
/// sessions or taken its rights since the access check.
fn caller_now(tx: &mut dyn Tx, cookie: Option<&str>, now: i64) -> Answer<User> {
    let Some(cookie) = cookie else { return Err(Problem::sign_in()) };
    people::by_cookie(tx, cookie, now)?.ok_or_else(Problem::sign_in)
}

/// Whether `caller` may change the user `id` like this.
fn may_change(caller: &User, id: &str, change: &UserChange) -> Answer<()> {
    let rights = change.admin.is_some() || change.disabled.is_some() || change.email.is_some();
    if caller.admin || (caller.id == id && !rights) { Ok(()) } else { Err(Problem::forbidden()) }
}

/// `PATCH /users/{u}`
pub fn change(call: &Call<'_>) -> Answer<Reply> {
    let (caller, change) = (call.user()?, call.body::<UserChange>()?);
    let target = call.app.store.read(|tx| people::find(tx, call.param("u")))?;
    may_change(caller, target.as_ref().map_or("", |t| &t.id), &change)?;
    let target = target.ok_or_else(Problem::missing)?;
    let password = new_password(call, &target, &change)?;
    let (id, cookie, now) = (target.id, call.request.cookie.clone(), call.app.now());
    let user = call.app.store.write(move |tx| {
        may_change(&caller_now(tx, cookie.as_deref(), now)?, &id, &change)?;
        let mut user = people::find(tx, &id)?.ok_or_else(Problem::missing)?;
        let UserChange { display, lang, admin, disabled, email, .. } = change.clone();
        user.display = display.unwrap_or(user.display);
        user.lang = lang.unwrap_or(user.lang);
        user.admin = admin.unwrap_or(user.admin);
        user.disabled = disabled.unwrap_or(user.disabled);
        user.email = email.as_deref().map_or(user.email, people::email);
        people::update(tx, &user)?;
        if let Some(password) = &password {
            if let Some(present) = &password.instead_of
                && people::password_hash(tx, &id)? != *present
            {
                return Err(wrong_present());
            }
            people::set_password(tx, &id, &password.hash)?;
        }
        Ok(user)
    })?;
    Reply::json(&user)
}

/// A new password.
struct NewPassword {
    /// Its hash.
    hash: String,
    /// The hash of the current one that its user gave; unset if an admin resets it.
    instead_of: Option<String>,
}

/// A new password, if one is given. Users who change their own must give the current one.
fn new_password(call: &Call<'_>, user: &User, change: &UserChange) -> Answer<Option<NewPassword>> {
    let Some(new) = &change.password else { return Ok(None) };
    let mut instead_of = None;
    if call.user()?.id == user.id {
        let now = call.app.now();
        let attempt = call.app.limits.begin(&user.name, &call.request.address, now)?;
        let present = call.app.store.read(|tx| people::password_hash(tx, &user.id))?;
        let given = change.present_password.as_deref().unwrap_or_default();
        if !call.app.limits.one_at_a_time(|| secret::is_password(given, &present)) {
            return Err(wrong_present());
        }
        attempt.succeeded();
        instead_of = Some(present);
    }
    let hash = call.app.limits.one_at_a_time(|| secret::hash_password(new))?;
    Ok(Some(NewPassword { hash, instead_of }))
}

fn wrong_present() -> Problem {
    Problem::new(403, "password.present", "当前密码不正确", "the current password is wrong")
}

/// `GET /tokens`
pub fn tokens(call: &Call<'_>) -> Answer<Reply> {
    let caller = call.user()?;
    let user = call.query("user").unwrap_or(&caller.id);
    if user != caller.id && !caller.admin {
        return Err(Problem::forbidden());
    }
    Reply::json(&Tokens { items: call.app.store.read(|tx| tokens::of_user(tx, user))? })
}

/// `POST /tokens`
pub fn make_token(call: &Call<'_>) -> Answer<Reply> {
    let token = tokens::fresh(&call.body()?, call.app.now())?;
    let (new, user) = (token.clone(), call.user()?.id.clone());
    call.app.store.write(move |tx| tokens::store(tx, &user, &new))?;
    Reply::json(&token)
}

/// `DELETE /tokens/{id}`
pub fn revoke_token(call: &Call<'_>) -> Answer<Reply> {
    let (id, caller) = (call.param("id").to_owned(), call.user()?.clone());
    call.app.store.write(move |tx| tokens::revoke(tx, &id, &caller))?;
    Reply::json(&Done { done: true })
}
