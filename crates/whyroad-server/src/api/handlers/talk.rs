//! History, overlap, comments.

use super::tasks::{actor, look};
use crate::api::call::Call;
use crate::api::reply::Reply;
use crate::domain::task::{Comment, DraftAt, History, NewComment, Overlap, OverlapItem};
use crate::domain::workflow::Role;
use crate::problem::{Answer, Problem};
use crate::service::{actions, disagreement, drafts, findings, seen, tasks, visible};
use crate::store::Tx;
use crate::values;

/// `GET /tasks/{t}/history`
pub fn history(call: &Call<'_>) -> Answer<Reply> {
    let (t, user) = (look(call)?, call.user()?);
    let number = |name: &str, usual: i64| match call.query(name) {
        None => Ok(usual),
        Some(text) => {
            let wrong = || {
                Problem::request(
                    format!("{name} 须为不小于 1 的整数"),
                    format!("{name} must be a whole number of at least 1"),
                )
            };
            text.parse().ok().filter(|n| *n >= 1).ok_or_else(wrong)
        }
    };
    let (after, limit) = (number("cursor", 0)?, number("limit", i64::MAX)?);
    let mut items = call.app.store.read(|tx| visible::history(tx, &t, &user.id))?;
    items.retain(|e| e.seq > after);
    let more = items.len() as i64 > limit;
    items.truncate(limit as usize);
    let next = items.last().filter(|_| more).map(|e| e.seq.to_string());
    Reply::json(&History { items, next })
}

/// `GET /tasks/{t}/history/{seq}`
pub fn draft_at(call: &Call<'_>) -> Answer<Reply> {
    let (t, user) = (look(call)?, call.user()?);
    let seq = call.param("seq").parse().map_err(|_| Problem::missing())?;
    let draft = call.app.store.read(|tx| drafts::at_for(tx, &t, &user.id, seq))?;
    Reply::json(&DraftAt { seq, draft })
}

/// `GET /tasks/{t}/overlap`
pub fn overlap(call: &Call<'_>) -> Answer<Reply> {
    // For those who choose; a gold task is the only one of its group.
    if !call.grant.roles.contains(&Role::Lead) {
        return Err(Problem::forbidden());
    }
    let (t, user) = (look(call)?, &call.user()?.id);
    let (group, names) = call.app.store.read(|tx| {
        let group = tasks::group(tx, &t.project, &t.episode.episode_id)?;
        if t.overlap_count < 2 || !disagreement::is_ready(&group) {
            return Err(Problem::new(
                409,
                "overlap.not_ready",
                "重叠标注尚未全部提交",
                "not all labels of the overlap group are submitted",
            ));
        }
        Ok((group, tasks::names(tx)?))
    })?;
    // The other labels may be shown further than this one: who sees them has seen that part of the drive.
    for o in group.iter().filter(|o| o.id != t.id) {
        seen::note(&call.app.store, o, user)?;
    }
    // Checking takes long, so it is done outside of the transaction.
    let item = |o: &tasks::TaskRow| OverlapItem {
        task: tasks::summary(o, &names),
        label: visible::label(&o.draft, o.view()),
        findings: findings::of(call.app, o, &o.draft, o.view()),
    };
    Reply::json(&Overlap { items: group.iter().map(item).collect() })
}

/// `POST /tasks/{t}/comments`
pub fn comment(call: &Call<'_>) -> Answer<Reply> {
    let (t, new) = (look(call)?, call.body::<NewComment>()?);
    let user = call.user()?.id.clone();
    let now = call.app.now();
    let comment = call.app.store.write(move |tx| {
        let id = actions::comment(tx, &t, &user, &new, now)?;
        read(tx, &id)
    })?;
    Reply::json(&comment)
}

/// `POST /comments/{c}/resolve`
pub fn resolve(call: &Call<'_>) -> Answer<Reply> {
    let (id, user) = (call.param("c").to_owned(), call.user()?.clone());
    let comment = call.app.store.write(move |tx| {
        let row = tx.row("SELECT task_id, author, to_lead FROM comments WHERE id = $1", values![&id])?;
        let row = row.ok_or_else(Problem::missing)?;
        let t = tasks::get(tx, &row.text("task_id")?)?;
        // In Stage I other people's comments are hidden, but for questions to a lead who answers them.
        let own = row.text("author")? == user.id;
        let asked = row.flag("to_lead")? && visible::reads_questions(&actor(tx, &t, &user)?);
        if !t.at.state.shows_future() && !own && !asked {
            return Err(Problem::missing());
        }
        tx.run("UPDATE comments SET resolved = 1 WHERE id = $1", values![&id])?;
        read(tx, &id)
    })?;
    Reply::json(&comment)
}

fn read(tx: &mut dyn Tx, id: &str) -> Answer<Comment> {
    let sql = "SELECT c.id, c.path, u.display, c.body, c.at, c.resolved, c.to_lead FROM comments c JOIN users u ON u.id = c.author
               WHERE c.id = $1";
    let row = tx.row(sql, values![id])?.ok_or_else(Problem::missing)?;
    Ok(Comment {
        id: row.text("id")?,
        path: row.text("path")?,
        author: row.text("display")?,
        text: row.text("body")?,
        at: row.int("at")?,
        resolved: row.flag("resolved")?,
        to_lead: row.flag("to_lead")?,
    })
}
