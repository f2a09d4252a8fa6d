//! Users and sessions.

use crate::domain::people::User;
use crate::problem::{Answer, Problem};
use crate::service::appearance::appearance;
use crate::store::{Row, Tx};
use crate::{secret, values};
use std::collections::BTreeSet;

/// Duration of a session, ms.
pub const SESSION_MS: i64 = 14 * 24 * 3_600_000;
const COLUMNS: &str = "id, name, display, admin, lang, disabled, email";
pub(super) const OF_U: &str = "u.id, u.name, u.display, u.admin, u.lang, u.disabled, u.email";

pub(super) fn user(row: &Row) -> Answer<User> {
    Ok(User {
        id: row.text("id")?,
        name: row.text("name")?,
        display: row.text("display")?,
        admin: row.flag("admin")?,
        lang: row.text("lang")?,
        disabled: row.flag("disabled")?,
        email: row.maybe_text("email")?,
    })
}

/// All users by name.
pub fn all(tx: &mut dyn Tx) -> Answer<Vec<User>> {
    tx.rows(&format!("SELECT {COLUMNS} FROM users ORDER BY name"), &[])?.iter().map(user).collect()
}

/// The user with this id or name.
pub fn find(tx: &mut dyn Tx, id_or_name: &str) -> Answer<Option<User>> {
    let sql = format!("SELECT {COLUMNS} FROM users WHERE id = $1 OR name = $2");
    tx.row(&sql, values![id_or_name, id_or_name])?.as_ref().map(user).transpose()
}

/// True while there is no user.
pub fn is_first_run(tx: &mut dyn Tx) -> Answer<bool> {
    Ok(tx.row("SELECT 1 FROM users LIMIT 1", &[])?.is_none())
}

/// Creates a user. `password_hash` comes from [`secret::hash_password`].
pub fn create(tx: &mut dyn Tx, user: &User, password_hash: &str, now: i64) -> Answer<()> {
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '.' | '_' | '-' | '@');
    if user.name.is_empty() || user.name.chars().count() > 64 || !user.name.chars().all(plain) {
        return Err(Problem::new(
            422,
            "user.name",
            "用户名只能含字母、数字和 . _ - @，至多 64 个字符",
            "a user name may have letters, digits and . _ - @, at most 64 characters",
        ));
    }
    check_texts(user)?;
    check_display(tx, user)?;
    check_email(tx, user)?;
    if find(tx, &user.name)?.is_some() {
        return Err(Problem::new(409, "user.exists", "用户名已存在", "a user of this name exists"));
    }
    tx.run(
        "INSERT INTO users (id, name, display, admin, lang, password_hash, disabled, created, email)
         VALUES ($1, $2, $3, $4, $5, $6, 0, $7, $8)",
        values![
            &user.id,
            &user.name,
            &user.display,
            i64::from(user.admin),
            &user.lang,
            password_hash,
            now,
            user.email.clone()
        ],
    )?;
    Ok(())
}

fn check_texts(user: &User) -> Answer<()> {
    if !matches!(user.lang.as_str(), "zh" | "en") || user.display.chars().count() > 100 {
        return Err(Problem::request(
            "lang 须为 zh 或 en，显示名至多 100 个字符",
            "lang must be zh or en, the display name at most 100 characters",
        ));
    }
    Ok(())
}

/// The stored form of an address: lower case; `None` for an empty one.
pub fn email(text: &str) -> Option<String> {
    Some(text.trim().to_ascii_lowercase()).filter(|e| !e.is_empty())
}

fn check_email(tx: &mut dyn Tx, user: &User) -> Answer<()> {
    let Some(email) = &user.email else { return Ok(()) };
    let plain = email.len() <= 254 && email.bytes().all(|b| b.is_ascii_graphic() && !b.is_ascii_uppercase());
    if !plain || email.split_once('@').is_none_or(|(name, domain)| name.is_empty() || domain.is_empty()) {
        return Err(Problem::new(422, "user.email", "邮箱地址无效", "invalid e-mail address"));
    }
    let other = tx.row("SELECT 1 FROM users WHERE email = $1 AND id <> $2", values![email, &user.id])?;
    if other.is_some() {
        return Err(Problem::new(
            409,
            "user.email_taken",
            "另一个用户已有此邮箱",
            "another user has this e-mail address",
        ));
    }
    Ok(())
}

/// The display names of all other users, as they look. Until the transaction ends, no other one reads them here.
fn other_displays(tx: &mut dyn Tx, id: &str) -> Answer<BTreeSet<String>> {
    // The first account is never removed.
    tx.rows(&format!("SELECT id FROM users ORDER BY created, id LIMIT 1{}", tx.lock()), &[])?;
    let rows = tx.rows("SELECT display FROM users WHERE id <> $1", values![id])?;
    rows.iter().map(|r| Ok(appearance(&r.text("display")?))).collect()
}

/// A display name that another user does not have: work is assigned and attributed by it.
fn check_display(tx: &mut dyn Tx, user: &User) -> Answer<()> {
    let wanted = appearance(&user.display);
    if wanted.is_empty() {
        return Err(Problem::new(
            422,
            "user.display",
            "显示名为空或不可见，请填写可见的名字",
            "the display name is empty or invisible: give one that can be seen",
        ));
    }
    if other_displays(tx, &user.id)?.contains(&wanted) {
        return Err(Problem::new(
            409,
            "user.display_taken",
            "另一个用户的显示名与此相同（不区分大小写、全半角和空格）；请换一个，例如加上部门或工号",
            "another user has this display name (letter case, width and spaces make no difference): choose another one, \
             for example with a team or a number",
        ));
    }
    Ok(())
}

/// `wanted`, or else the same with `name` or a number, so that no other user has it.
pub fn free_display(tx: &mut dyn Tx, id: &str, wanted: &str, name: &str) -> Answer<String> {
    let taken = other_displays(tx, id)?;
    let short: String = wanted.chars().take(30).collect();
    let more = (2..=taken.len() + 2).map(|n| format!("{short} ({n})"));
    let mut all = [wanted.to_owned(), name.to_owned(), format!("{short} ({name})")].into_iter().chain(more);
    let free = |display: &String| {
        let looks = appearance(display);
        !looks.is_empty() && !taken.contains(&looks)
    };
    all.find(free).ok_or_else(|| Problem::store("no free display name"))
}

/// Writes a user's display name, language, address and permissions.
pub fn update(tx: &mut dyn Tx, user: &User) -> Answer<()> {
    check_texts(user)?;
    // Names from before this was checked stay.
    let before = tx.row("SELECT display FROM users WHERE id = $1", values![&user.id])?;
    if before.map(|r| r.text("display")).transpose()?.as_deref() != Some(user.display.as_str()) {
        check_display(tx, user)?;
    }
    check_email(tx, user)?;
    tx.run(
        "UPDATE users SET display = $1, lang = $2, admin = $3, disabled = $4, email = $5 WHERE id = $6",
        values![
            &user.display,
            &user.lang,
            i64::from(user.admin),
            i64::from(user.disabled),
            user.email.clone(),
            &user.id
        ],
    )?;
    if user.disabled {
        end_access(tx, &user.id)?;
    }
    let admins = tx.row("SELECT 1 FROM users WHERE admin = 1 AND disabled = 0 LIMIT 1", &[])?;
    if admins.is_none() {
        return Err(Problem::new(
            409,
            "user.last_admin",
            "至少要有一个管理员",
            "at least one admin is required",
        ));
    }
    Ok(())
}

/// Sets a password and ends all sessions and API tokens, so that the old password gives no access any more.
pub fn set_password(tx: &mut dyn Tx, user: &str, hash: &str) -> Answer<()> {
    tx.run("UPDATE users SET password_hash = $1 WHERE id = $2", values![hash, user])?;
    end_access(tx, user)
}

fn end_access(tx: &mut dyn Tx, user: &str) -> Answer<()> {
    tx.run("DELETE FROM sessions WHERE user_id = $1", values![user])?;
    tx.run("DELETE FROM api_tokens WHERE user_id = $1", values![user])?;
    Ok(())
}

/// Id and password hash of the user with this name, if they may sign in.
pub fn credentials(tx: &mut dyn Tx, name: &str) -> Answer<Option<(String, String)>> {
    let row =
        tx.row("SELECT id, password_hash FROM users WHERE name = $1 AND disabled = 0", values![name])?;
    row.map(|r| Ok((r.text("id")?, r.text("password_hash")?))).transpose()
}

/// The password hash of a user.
pub fn password_hash(tx: &mut dyn Tx, user: &str) -> Answer<String> {
    let row = tx.row("SELECT password_hash FROM users WHERE id = $1", values![user])?;
    row.ok_or_else(Problem::missing)?.text("password_hash")
}

/// Starts a session whose cookie is `cookie`, and removes ended ones.
pub fn start_session(tx: &mut dyn Tx, cookie: &str, user: &str, now: i64) -> Answer<()> {
    tx.run("DELETE FROM sessions WHERE expires < $1", values![now])?;
    tx.run(
        "INSERT INTO sessions (hash, user_id, expires) VALUES ($1, $2, $3)",
        values![secret::hash(cookie), user, now + SESSION_MS],
    )?;
    Ok(())
}

/// The password hash of an account without a password.
pub const NO_PASSWORD: &str = "";

/// Records that a session began at the identity provider.
pub fn note_provider(tx: &mut dyn Tx, cookie: &str) -> Answer<()> {
    tx.run("UPDATE sessions SET oidc = 1 WHERE hash = $1", values![secret::hash(cookie)])?;
    Ok(())
}

/// True for a session that began at the identity provider.
pub fn began_at_provider(tx: &mut dyn Tx, cookie: &str) -> Answer<bool> {
    let sql = "SELECT 1 FROM sessions WHERE hash = $1 AND oidc = 1";
    Ok(tx.row(sql, values![secret::hash(cookie)])?.is_some())
}

/// Ends a session.
pub fn end_session(tx: &mut dyn Tx, cookie: &str) -> Answer<()> {
    tx.run("DELETE FROM sessions WHERE hash = $1", values![secret::hash(cookie)])?;
    Ok(())
}

/// The user of this cookie.
pub fn by_cookie(tx: &mut dyn Tx, cookie: &str, now: i64) -> Answer<Option<User>> {
    let sql = format!(
        "SELECT {OF_U} FROM sessions s JOIN users u ON u.id = s.user_id
         WHERE s.hash = $1 AND s.expires >= $2 AND u.disabled = 0"
    );
    tx.row(&sql, values![secret::hash(cookie), now])?.as_ref().map(user).transpose()
}
