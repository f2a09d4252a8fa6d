//! Users and API tokens.

use crate::api::call::Call;
use crate::api::reply::Reply;
use crate::domain::people::{Done, NewUser, Tokens, User, UserChange, Users};
use crate::problem::{Answer, Problem};
use crate::secret;
use crate::service::{people, projects, tokens};

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
    let (new, now) = (user.clone(), call.app.now());
    call.app.store.write(move |tx| people::create(tx, &new, &hash, now))?;
    Reply::json(&user)
}

/// `PATCH /users/{u}`
pub fn change(call: &Call<'_>) -> Answer<Reply> {
    let (caller, change) = (call.user()?, call.body::<UserChange>()?);
    let target = call.app.store.read(|tx| people::find(tx, call.param("u")))?;
    let own = target.as_ref().is_some_and(|t| t.id == caller.id);
    let rights = change.admin.is_some() || change.disabled.is_some() || change.email.is_some();
    if !caller.admin && (!own || rights) {
        return Err(Problem::forbidden());
    }
    let mut user = target.ok_or_else(Problem::missing)?;
    let hash = new_password(call, &user, &change)?;
    user.display = change.display.unwrap_or(user.display);
    user.lang = change.lang.unwrap_or(user.lang);
    user.admin = change.admin.unwrap_or(user.admin);
    user.disabled = change.disabled.unwrap_or(user.disabled);
    user.email = change.email.as_deref().map_or(user.email, people::email);
    let new = user.clone();
    call.app.store.write(move |tx| {
        people::update(tx, &new)?;
        hash.as_ref().map_or(Ok(()), |hash| people::set_password(tx, &new.id, hash))
    })?;
    Reply::json(&user)
}

/// The hash of a new password, if one is given. Users who change their own must give the current one.
fn new_password(call: &Call<'_>, user: &User, change: &UserChange) -> Answer<Option<String>> {
    let Some(new) = &change.password else { return Ok(None) };
    if call.user()?.id == user.id {
        let now = call.app.now();
        let attempt = call.app.limits.begin(&user.name, &call.request.address, now)?;
        let present = call.app.store.read(|tx| people::password_hash(tx, &user.id))?;
        let given = change.present_password.as_deref().unwrap_or_default();
        if !call.app.limits.one_at_a_time(|| secret::is_password(given, &present)) {
            return Err(Problem::new(
                403,
                "password.present",
                "当前密码不正确",
                "the current password is wrong",
            ));
        }
        attempt.succeeded();
    }
    call.app.limits.one_at_a_time(|| secret::hash_password(new)).map(Some)
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
