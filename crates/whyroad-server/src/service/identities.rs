//! The account of a person of the identity provider, and its permissions.
//!
//! An account is found by the provider's permanent identifier of the person (issuer and subject), never by a name or an
//! address alone. It is linked in one of three cases: its user, signed in, requests it; the person's *verified* address
//! is the one that an administrator entered for the account, and the account is not linked to anybody of that provider
//! yet; or it is created for the person, if the configuration permits it. So nobody can take over an account by
//! choosing a name or an address.

use super::{people, projects};
use crate::domain::oidc::Identity;
use crate::domain::people::User;
use crate::domain::workflow::Role;
use crate::oidc::claims::verified_email;
use crate::oidc::settings::{Accounts, Settings, has};
use crate::problem::{Answer, Problem};
use crate::store::{Row, Tx};
use crate::{secret, values};
use serde_json::Value;
use std::collections::BTreeMap;

/// Maximum number that is appended to a name that is taken.
const MOST_OF_A_NAME: usize = 1000;

/// The id of the account to which the person of these claims signs in; created or linked if the configuration permits
/// it. Roles from the provider apply from now on.
pub fn enter(tx: &mut dyn Tx, settings: &Settings, claims: &Value, now: i64) -> Answer<String> {
    if people::is_first_run(tx)? {
        return Err(refused(
            409,
            "oidc.first_run",
            "请先建立管理员账号",
            "create the first administrator first",
        ));
    }
    let email = verified_email(claims);
    if !settings.allow.is_empty() && !settings.allow.iter().any(|a| a.is_met(claims, email.as_deref())) {
        return Err(refused(
            403,
            "oidc.not_allowed",
            "你在身份提供方的账号不在允许登录之列，请联系管理员",
            "your account at the identity provider is not permitted to sign in: ask an administrator",
        ));
    }
    let user = match linked(tx, &settings.issuer, subject(claims)?)? {
        Some(user) => user,
        None => {
            let user = match by_address(tx, settings, email.as_deref())? {
                Some(user) => user,
                None if settings.accounts == Accounts::Made => made(tx, claims, email.clone(), now)?,
                None => return Err(no_account()),
            };
            store(tx, settings, claims, &user.id, now)?;
            user
        }
    };
    if user.disabled {
        return Err(refused(
            403,
            "oidc.disabled",
            "此账号已停用，请联系管理员",
            "this account is disabled: ask an administrator",
        ));
    }
    tx.run(
        "UPDATE identities SET seen = $1, email = $2 WHERE issuer = $3 AND subject = $4",
        values![now, email, &settings.issuer, subject(claims)?],
    )?;
    grant(tx, settings, claims, &user)?;
    Ok(user.id)
}

/// Links the person of these claims to a signed-in user who requested it.
pub fn link(tx: &mut dyn Tx, settings: &Settings, claims: &Value, user: &str, now: i64) -> Answer<()> {
    match linked(tx, &settings.issuer, subject(claims)?)? {
        Some(other) if other.id == user => Ok(()),
        Some(_) => Err(refused(
            409,
            "oidc.linked_elsewhere",
            "该身份已关联到另一个账号",
            "this identity is already linked to another account",
        )),
        None if has_identity(tx, &settings.issuer, user)? => Err(refused(
            409,
            "oidc.has_identity",
            "你的账号已关联另一个身份，请先解除",
            "your account is linked to another identity: unlink it first",
        )),
        None => store(tx, settings, claims, user, now),
    }
}

/// Identities of a user.
pub fn of_user(tx: &mut dyn Tx, user: &str) -> Answer<Vec<Identity>> {
    let sql =
        "SELECT id, issuer, email, created, seen FROM identities WHERE user_id = $1 ORDER BY created, id";
    let identity = |r: &Row| {
        Ok(Identity {
            id: r.text("id")?,
            issuer: r.text("issuer")?,
            email: r.maybe_text("email")?,
            created: r.int("created")?,
            seen: r.int("seen")?,
        })
    };
    tx.rows(sql, values![user])?.iter().map(identity).collect()
}

/// Unlinks an identity; the caller is its user or an admin. Sessions that began with it end. Users cannot lock
/// themselves out.
pub fn unlink(tx: &mut dyn Tx, id: &str, caller: &User) -> Answer<()> {
    let row = tx.row("SELECT user_id FROM identities WHERE id = $1", values![id])?;
    let user = row.ok_or_else(Problem::missing)?.text("user_id")?;
    if user != caller.id && !caller.admin {
        return Err(Problem::missing());
    }
    let only_way = people::password_hash(tx, &user)? == people::NO_PASSWORD && of_user(tx, &user)?.len() == 1;
    if user == caller.id && only_way {
        return Err(refused(
            409,
            "oidc.only_way",
            "账号没有密码，这是唯一的登录方式；请先让管理员设置密码",
            "the account has no password, so this is its only sign-in method: ask an administrator to set one first",
        ));
    }
    tx.run("DELETE FROM identities WHERE id = $1", values![id])?;
    tx.run("DELETE FROM sessions WHERE user_id = $1 AND oidc = 1", values![&user])?;
    Ok(())
}

fn refused(status: u16, code: &'static str, zh: &str, en: &str) -> Problem {
    Problem::new(status, code, zh, en)
}

fn no_account() -> Problem {
    refused(
        403,
        "oidc.no_account",
        "没有与此身份关联的账号。可用密码登录后在“设置”中关联，或请管理员把已验证的邮箱填入你的账号",
        "no account is linked to this identity: sign in by password and link it in the settings, or let an administrator \
         give your account your verified e-mail address",
    )
}

fn subject(claims: &Value) -> Answer<&str> {
    claims["sub"].as_str().ok_or_else(|| crate::oidc::refused_token("sub"))
}

fn linked(tx: &mut dyn Tx, issuer: &str, subject: &str) -> Answer<Option<User>> {
    let sql = "SELECT user_id FROM identities WHERE issuer = $1 AND subject = $2";
    match tx.row(sql, values![issuer, subject])? {
        Some(row) => people::find(tx, &row.text("user_id")?),
        None => Ok(None),
    }
}

fn has_identity(tx: &mut dyn Tx, issuer: &str, user: &str) -> Answer<bool> {
    let sql = "SELECT 1 FROM identities WHERE issuer = $1 AND user_id = $2";
    Ok(tx.row(sql, values![issuer, user])?.is_some())
}

/// The account for which an administrator entered this verified address. An account that is linked to another person of
/// this provider is not linked to a second one.
fn by_address(tx: &mut dyn Tx, settings: &Settings, email: Option<&str>) -> Answer<Option<User>> {
    let Some(email) = email else { return Ok(None) };
    let Some(row) = tx.row("SELECT id FROM users WHERE email = $1", values![email])? else { return Ok(None) };
    let id = row.text("id")?;
    if has_identity(tx, &settings.issuer, &id)? {
        return Err(refused(
            409,
            "oidc.address_taken",
            "有此邮箱的账号已关联另一个身份，请联系管理员",
            "the account with your e-mail address is linked to another identity: ask an administrator",
        ));
    }
    people::find(tx, &id)
}

fn store(tx: &mut dyn Tx, settings: &Settings, claims: &Value, user: &str, now: i64) -> Answer<()> {
    tx.run(
        "INSERT INTO identities (id, issuer, subject, user_id, email, created, seen) VALUES ($1, $2, $3, $4, $5, $6, $6)",
        values![secret::id()?, &settings.issuer, subject(claims)?, user, verified_email(claims), now],
    )?;
    Ok(())
}

/// A new account without a password and without permissions.
fn made(tx: &mut dyn Tx, claims: &Value, email: Option<String>, now: i64) -> Answer<User> {
    let text = |name: &str| claims[name].as_str().map(str::trim).filter(|t| !t.is_empty());
    let address = text("email").and_then(|e| e.split('@').next());
    let wanted = text("preferred_username").or(address).unwrap_or("user");
    let name = free_name(tx, wanted)?;
    let display: String =
        text("name").unwrap_or(&name).chars().filter(|c| !c.is_control()).take(100).collect();
    let id = secret::id()?;
    let display = people::free_display(tx, &id, &display, &name)?;
    let lang = if text("locale").is_some_and(|l| l.starts_with("en")) { "en" } else { "zh" };
    let user = User { id, name, display, admin: false, lang: lang.to_owned(), disabled: false, email };
    people::create(tx, &user, people::NO_PASSWORD, now)?;
    Ok(user)
}

/// A free name that is as similar to the requested one as possible.
fn free_name(tx: &mut dyn Tx, wanted: &str) -> Answer<String> {
    let plain = |c: &char| c.is_alphanumeric() || matches!(c, '.' | '_' | '-' | '@');
    let base: String = wanted.chars().filter(plain).take(58).collect();
    let base = if base.is_empty() { "user".to_owned() } else { base };
    for n in 1..MOST_OF_A_NAME {
        let name = if n == 1 { base.clone() } else { format!("{base}-{n}") };
        // A name that is another user's id would be found as that user.
        if people::find(tx, &name)?.is_none() {
            return Ok(name);
        }
    }
    Err(Problem::store("no free name"))
}

/// Adds and removes the permissions that the grants contain: administration, and roles in their projects. Other
/// permissions stay unchanged.
fn grant(tx: &mut dyn Tx, settings: &Settings, claims: &Value, user: &User) -> Answer<()> {
    let mut projects: BTreeMap<&str, Vec<Role>> = BTreeMap::new();
    let (mut speaks_of_admin, mut admin) = (false, false);
    for grant in &settings.grants {
        let met = has(claims, &grant.claim, &grant.value);
        speaks_of_admin |= grant.admin;
        admin |= grant.admin && met;
        if let Some(project) = &grant.project {
            let roles = projects.entry(project).or_default();
            let more = grant.roles.iter().filter(|_| met).copied();
            roles.extend(more);
        }
    }
    if speaks_of_admin && admin != user.admin {
        let sql = "SELECT 1 FROM users WHERE admin = 1 AND disabled = 0 AND id <> $1 LIMIT 1";
        // The last administrator keeps this permission: otherwise nobody could fix a wrong configuration.
        if admin || tx.row(sql, values![&user.id])?.is_some() {
            people::update(tx, &User { admin, ..user.clone() })?;
        }
    }
    for (name, mut roles) in projects {
        let Some(project) = projects::find(tx, name)? else { continue };
        roles.sort_unstable();
        roles.dedup();
        let skills = projects::skills(tx, &project.id, &user.id)?;
        projects::set_member(tx, &project.id, &user.id, &roles, &skills)?;
    }
    Ok(())
}
