//! API tokens for programs. They expire, can read or write, and are removed when the password of their user changes.

use crate::domain::people::{NewToken, Token, TokenScope, User};
use crate::problem::{Answer, Problem};
use crate::service::people::{self, OF_U};
use crate::service::projects::DAY_MS;
use crate::store::{Row, Tx};
use crate::{secret, values};

/// Maximum number of tokens of one user.
const MOST_TOKENS: i64 = 50;
/// Days until a token expires: the default, and the maximum.
const USUAL_DAYS: u32 = 90;
const MOST_DAYS: u32 = 365;

/// The token as it is stored, and its text, which is shown once.
pub fn fresh(wanted: &NewToken, now: i64) -> Answer<Token> {
    if wanted.name.trim().is_empty() || wanted.name.chars().count() > 100 {
        return Err(Problem::request("名称须为 1 至 100 个字符", "the name must have 1 to 100 characters"));
    }
    let days = wanted.days.unwrap_or(USUAL_DAYS);
    if !(1..=MOST_DAYS).contains(&days) {
        return Err(Problem::request(
            format!("days 须为 1 至 {MOST_DAYS}"),
            format!("days must be 1 to {MOST_DAYS}"),
        ));
    }
    Ok(Token {
        id: secret::id()?,
        name: wanted.name.clone(),
        scope: wanted.scope,
        created: now,
        expires: now + i64::from(days) * DAY_MS,
        token: Some(format!("wr_{}", secret::random(24)?)),
    })
}

/// Stores a token of `user`: the hash of its text. Expired ones are removed.
pub fn store(tx: &mut dyn Tx, user: &str, token: &Token) -> Answer<()> {
    tx.run("DELETE FROM api_tokens WHERE user_id = $1 AND expires <= $2", values![user, token.created])?;
    let have = tx.row("SELECT count(*) AS n FROM api_tokens WHERE user_id = $1", values![user])?;
    if have.map_or(Ok(0), |r| r.int("n"))? >= MOST_TOKENS {
        return Err(Problem::new(
            409,
            "token.too_many",
            "令牌过多，请先删除",
            "too many tokens: revoke some first",
        ));
    }
    let hash = secret::hash(token.token.as_deref().unwrap_or_default());
    tx.run(
        "INSERT INTO api_tokens (id, hash, user_id, name, created, expires, scope) VALUES ($1, $2, $3, $4, $5, $6, $7)",
        values![&token.id, &hash, user, &token.name, token.created, token.expires, token.scope.word()],
    )?;
    Ok(())
}

/// Tokens of a user, without their texts.
pub fn of_user(tx: &mut dyn Tx, user: &str) -> Answer<Vec<Token>> {
    let sql =
        "SELECT id, name, scope, created, expires FROM api_tokens WHERE user_id = $1 ORDER BY created, id";
    let token = |r: &Row| {
        Ok(Token {
            id: r.text("id")?,
            name: r.text("name")?,
            scope: TokenScope::from_word(&r.text("scope")?),
            created: r.int("created")?,
            expires: r.int("expires")?,
            token: None,
        })
    };
    tx.rows(sql, values![user])?.iter().map(token).collect()
}

/// Revokes a token: of the caller, or of any user for an admin.
pub fn revoke(tx: &mut dyn Tx, id: &str, caller: &User) -> Answer<()> {
    let n = if caller.admin {
        tx.run("DELETE FROM api_tokens WHERE id = $1", values![id])?
    } else {
        tx.run("DELETE FROM api_tokens WHERE id = $1 AND user_id = $2", values![id, &caller.id])?
    };
    if n == 0 { Err(Problem::missing()) } else { Ok(()) }
}

/// The user of this token, and its scope.
pub fn holder(tx: &mut dyn Tx, token: &str, now: i64) -> Answer<Option<(User, TokenScope)>> {
    let sql = format!(
        "SELECT {OF_U}, t.scope FROM api_tokens t JOIN users u ON u.id = t.user_id
         WHERE t.hash = $1 AND t.expires > $2 AND u.disabled = 0"
    );
    let row = tx.row(&sql, values![secret::hash(token), now])?;
    row.map(|r| Ok((people::user(&r)?, TokenScope::from_word(&r.text("scope")?)))).transpose()
}
