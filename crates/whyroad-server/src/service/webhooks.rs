//! Webhooks: changes of a task are written into an outbox in the same transaction as the change itself, and sent from
//! there until the receiver accepts them. So no event is announced that did not happen, and none is lost because a
//! receiver was unavailable. A receiver may get a message twice (with the same delivery id).
//!
//! Messages are signed: `x-whyroad-signature: t=<ms>,v1=<hex>` where `v1` is HMAC-SHA256 over `<ms>.<body>` with the
//! webhook's secret. Addresses may be `http://` or `https://`.

mod post;
pub mod reach;
pub mod tls;

pub use post::{Receiver, post};
pub use reach::Reach;
pub use tls::Trust;

use crate::app::App;
use crate::domain::people::User;
use crate::domain::project::Webhook;
use crate::domain::workflow::Action;
use crate::problem::{Answer, Problem};
use crate::service::projects::{json, parse};
use crate::service::tasks::{Entry, TaskRow};
use crate::store::vault::{self, Vault};
use crate::store::{Tx, Value};
use crate::{secret, values};
use serde_json::json;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;
use whyroad_model::Bilingual;

/// Announced events in addition to the steps of the workflow. Edits are not announced: they happen every second and
/// change no state.
const FURTHER_EVENTS: &[&str] = &["create", "assign", "adjudicate", "restore"];
/// Wait after the first failure, ms; doubles with each further one.
const FIRST_WAIT_MS: i64 = 5_000;
/// Maximum wait, ms.
const LONGEST_WAIT_MS: i64 = 3_600_000;
/// Number of failures after which a message is dropped: about a day.
const MOST_TRIES: i64 = 32;
/// Time for which a sender reserves a message that it is sending, ms.
const CLAIM_MS: i64 = 60_000;
/// Maximum number of messages sent in one pass.
const PASS: i64 = 50;
/// Time between two reads of the outbox.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// Maximum number of webhooks of one project.
const MOST_HOOKS: i64 = 20;

/// True for events that webhooks announce.
fn is_event(word: &str) -> bool {
    Action::from_word(word).is_some() || FURTHER_EVENTS.contains(&word)
}

/// Joins webhooks `w` with their owners `u`.
const OWNERS: &str = "webhooks w LEFT JOIN users u ON u.id = w.owner";
/// SQL for webhooks that are not paused, with [`OWNERS`].
const ACTIVE: &str = "coalesce(u.disabled, 0) = 0";

/// Number of messages to send, and when the oldest was added; without those of paused webhooks.
pub fn waiting(tx: &mut dyn Tx) -> Answer<(i64, Option<i64>)> {
    let sql = format!(
        "SELECT count(*) AS n, min(o.created) AS oldest FROM outbox o
         WHERE o.webhook_id IN (SELECT w.id FROM {OWNERS} WHERE {ACTIVE})"
    );
    tx.row(&sql, &[])?.map_or(Ok((0, None)), |row| Ok((row.int("n")?, row.maybe_int("oldest")?)))
}

/// Adds `entry` of `t` to the outbox of each webhook of its project that subscribes to it and is not paused.
pub fn announce(tx: &mut dyn Tx, t: &TaskRow, entry: &Entry<'_>, now: i64) -> Answer<()> {
    if !is_event(entry.action) {
        return Ok(());
    }
    let sql = format!("SELECT w.id, w.events FROM {OWNERS} WHERE w.project_id = $1 AND {ACTIVE}");
    let hooks = tx.rows(&sql, values![&t.project])?;
    for hook in hooks {
        let wanted: Vec<String> = parse(&hook.text("events")?)?;
        if !(wanted.is_empty() || wanted.iter().any(|w| w == entry.action)) {
            continue;
        }
        let id = secret::id()?;
        // No label and no text of people: the receiver can request them from the API, which checks access.
        let body = json!({
            "delivery": id, "event": entry.action, "at": now, "project": t.project, "task": t.id,
            "clip_id": t.clip_id, "scenario_id": t.scenario_id, "actor": entry.actor,
            "from_state": entry.from, "to_state": t.at.state, "version": t.version,
        });
        tx.run(
            "INSERT INTO outbox (id, webhook_id, body, tries, due, created) VALUES ($1, $2, $3, 0, $4, $5)",
            values![&id, hook.text("id")?, body.to_string(), now, now],
        )?;
    }
    Ok(())
}

/// Webhooks of a project, by URL.
pub fn list(tx: &mut dyn Tx, project: &str) -> Answer<Vec<Webhook>> {
    select(tx, "w.project_id = $1 ORDER BY w.url, w.id", values![project])
}

/// Paused webhooks of all projects.
pub fn paused(tx: &mut dyn Tx) -> Answer<Vec<Webhook>> {
    select(tx, &format!("NOT ({ACTIVE}) ORDER BY w.project_id, w.url, w.id"), &[])
}

fn select(tx: &mut dyn Tx, condition: &str, values: &[Value]) -> Answer<Vec<Webhook>> {
    let sql = format!(
        "SELECT w.id, w.project_id, w.url, w.events, w.last_error, w.delivered, u.display AS owner,
           CASE WHEN {ACTIVE} THEN 0 ELSE 1 END AS paused,
           (SELECT count(*) FROM outbox o WHERE o.webhook_id = w.id) AS pending,
           (SELECT max(o.tries) FROM outbox o WHERE o.webhook_id = w.id) AS tries,
           (SELECT min(o.due) FROM outbox o WHERE o.webhook_id = w.id) AS next_try
         FROM {OWNERS} WHERE {condition}"
    );
    let rows = tx.rows(&sql, values)?;
    rows.iter()
        .map(|r| {
            Ok(Webhook {
                id: r.text("id")?,
                project: r.text("project_id")?,
                owner: r.maybe_text("owner")?,
                paused: r.flag("paused")?,
                url: r.text("url")?,
                events: parse(&r.text("events")?)?,
                last_error: r.maybe_text("last_error")?.map(|text| parse(&text)).transpose()?,
                pending: r.int("pending")?,
                failures: r.maybe_int("tries")?.unwrap_or(0),
                last_delivery: r.maybe_int("delivered")?,
                next_try: r.maybe_int("next_try")?,
                secret: None,
            })
        })
        .collect()
}

/// A webhook to add.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    /// Project id.
    pub project: &'a str,
    /// The user who adds it.
    pub owner: &'a User,
    /// Target URL.
    pub url: &'a str,
    /// Actions to announce; empty for all.
    pub events: &'a [String],
}

/// Adds a webhook; its secret is only in this result.
pub fn create(
    tx: &mut dyn Tx,
    wanted: Wanted<'_>,
    reach: &Reach,
    vault: &Vault,
    now: i64,
) -> Answer<Webhook> {
    let Wanted { project, owner, url, events } = wanted;
    if url.len() > 500 {
        return Err(Problem::request(
            "webhook 网址至多 500 个字符",
            "a webhook address may have at most 500 characters",
        ));
    }
    if let Some(unknown) = events.iter().find(|e| !is_event(e)) {
        return Err(no_event(unknown));
    }
    let to = Receiver::parse(url).map_err(|why| {
        Problem::new(
            422,
            "webhook.url",
            format!("网址无效：{}；须为 http(s)://主机[:端口]/路径", why.zh),
            format!("the address is invalid: {}; it must be http(s)://host[:port]/path", why.en),
        )
    })?;
    if !to.may_be_reached(reach) {
        let why = post::not_reached(to.host());
        return Err(Problem::new(422, "webhook.address", why.zh, why.en));
    }
    let count = tx.row("SELECT count(*) AS n FROM webhooks WHERE project_id = $1", values![project])?;
    if count.map_or(Ok(0), |r| r.int("n"))? >= MOST_HOOKS {
        return Err(Problem::request(
            format!("每个项目至多 {MOST_HOOKS} 个 webhook"),
            format!("a project may have at most {MOST_HOOKS} webhooks"),
        ));
    }
    let (id, key) = (secret::id()?, secret::random(32)?);
    tx.run(
        "INSERT INTO webhooks (id, project_id, url, events, secret, created, owner) VALUES ($1, $2, $3, $4, $5, $6, $7)",
        values![&id, project, url, json(&events)?, vault.seal(&vault::webhook(&id), &key)?, now, &owner.id],
    )?;
    Ok(Webhook {
        id,
        project: project.to_owned(),
        owner: Some(owner.display.clone()),
        paused: false,
        url: url.to_owned(),
        events: events.to_vec(),
        pending: 0,
        failures: 0,
        last_delivery: None,
        next_try: None,
        last_error: None,
        secret: Some(key),
    })
}

fn no_event(word: &str) -> Problem {
    let known: Vec<&str> =
        Action::ALL.iter().map(|a| a.word()).chain(FURTHER_EVENTS.iter().copied()).collect();
    let known = known.join(", ");
    Problem::new(
        422,
        "webhook.event",
        format!("没有事件 '{word}'；可选：{known}"),
        format!("unknown event '{word}'; known: {known}"),
    )
}

/// Removes a webhook with its unsent messages.
pub fn remove(tx: &mut dyn Tx, id: &str) -> Answer<()> {
    tx.run("DELETE FROM outbox WHERE webhook_id = $1", values![id])?;
    tx.run("DELETE FROM webhooks WHERE id = $1", values![id])?;
    Ok(())
}

/// The signature of `body` at the time `at`.
pub fn signature(secret: &str, at: i64, body: &str) -> String {
    format!("t={at},v1={}", secret::sign(secret, format!("{at}.{body}").as_bytes()))
}

/// Wait after this number of failures, ms.
pub fn wait_ms(failures: i64) -> i64 {
    FIRST_WAIT_MS
        .checked_shl((failures - 1).clamp(0, 20) as u32)
        .map_or(LONGEST_WAIT_MS, |w| w.min(LONGEST_WAIT_MS))
}

/// A message to send.
struct Message {
    id: String,
    webhook: String,
    url: String,
    body: String,
    tries: i64,
}

/// Sends the due messages, oldest first; returns the number of accepted ones. A receiver that fails once is skipped for
/// the rest of the pass, so that one that hangs does not delay the others.
pub fn deliver_due(app: &App) -> Answer<usize> {
    let now = app.now();
    let sql = format!(
        "SELECT o.id, o.due, o.webhook_id, w.url, w.secret, o.body, o.tries
         FROM outbox o JOIN webhooks w ON w.id = o.webhook_id LEFT JOIN users u ON u.id = w.owner
         WHERE o.due <= $1 AND {ACTIVE} ORDER BY o.due, o.id LIMIT $2"
    );
    let due = app.store.read(|tx| tx.rows(&sql, values![now, PASS]))?;
    let (mut taken, mut failing) = (0, BTreeSet::new());
    for row in due {
        let (webhook, secret) = (row.text("webhook_id")?, row.text("secret")?);
        let message = Message {
            id: row.text("id")?,
            webhook,
            url: row.text("url")?,
            body: row.text("body")?,
            tries: row.int("tries")?,
        };
        if failing.contains(&message.webhook) || !claim(app, &message.id, row.int("due")?)? {
            continue;
        }
        let sent_at = app.now();
        let secret = app.store.vault.open_text(&vault::webhook(&message.webhook), &secret)?;
        let signature = signature(&secret, sent_at, &message.body);
        let headers = [("x-whyroad-signature", signature.as_str()), ("x-whyroad-delivery", &message.id)];
        let outcome = Receiver::parse(&message.url)
            .and_then(|to| post(&to, (&app.reach, &app.trust), &headers, message.body.as_bytes()));
        if outcome.is_ok() {
            taken += 1;
        } else {
            failing.insert(message.webhook.clone());
        }
        settle(app, message, outcome, app.now())?;
    }
    Ok(taken)
}

/// Reserves a message for this sender: two services on one database do not send the same one, and none is sent once its
/// webhook is paused.
fn claim(app: &App, id: &str, was_due: i64) -> Answer<bool> {
    let (id, until) = (id.to_owned(), app.now() + CLAIM_MS);
    app.store.write(move |tx| {
        let sql = format!(
            "UPDATE outbox SET due = $1 WHERE id = $2 AND due = $3
               AND webhook_id IN (SELECT w.id FROM {OWNERS} WHERE {ACTIVE})"
        );
        Ok(tx.run(&sql, values![until, &id, was_due])? == 1)
    })
}

fn settle(app: &App, message: Message, outcome: Result<(), Bilingual>, now: i64) -> Answer<()> {
    app.store.write(move |tx| {
        let failures = message.tries + 1;
        let error = match &outcome {
            Ok(()) => None,
            Err(why) if failures >= MOST_TRIES => Some(Bilingual::new(
                format!("消息 {} 发送 {failures} 次失败后丢弃：{}", message.id, why.zh),
                format!("message {} dropped after {failures} attempts: {}", message.id, why.en),
            )),
            Err(why) => Some(why.clone()),
        };
        if error.is_none() || failures >= MOST_TRIES {
            tx.run("DELETE FROM outbox WHERE id = $1", values![&message.id])?;
        } else {
            tx.run(
                "UPDATE outbox SET tries = $1, due = $2 WHERE id = $3",
                values![failures, now + wait_ms(failures), &message.id],
            )?;
        }
        let delivered = outcome.is_ok().then_some(now);
        let error = error.map(|e| json(&e)).transpose()?;
        tx.run(
            "UPDATE webhooks SET last_error = $1, delivered = coalesce($2, delivered) WHERE id = $3",
            values![error, delivered, &message.webhook],
        )?;
        Ok(())
    })
}

/// Sends on a separate thread that reads the outbox once a second, as long as the service exists. If the store is
/// unavailable for a while, it is tried again: messages that could not be sent or recorded stay in the outbox.
pub fn spawn(app: Arc<App>) -> JoinHandle<()> {
    let service = Arc::downgrade(&app);
    std::thread::spawn(move || {
        while let Some(app) = service.upgrade() {
            let _ = deliver_due(&app);
            drop(app);
            std::thread::sleep(LOOK_EVERY);
        }
    })
}

#[cfg(test)]
mod tests;
