//! Whole tasks as JSON lines, part by part: the history of a task that was edited all day can be longer than the rest
//! of its project, so it is never completely in memory.

use super::BYTES_AT_ONCE;
use crate::problem::{Answer, Problem};
use crate::service::projects::parse;
use crate::service::tasks;
use crate::store::{Row, Store, Tx};
use crate::values;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::io::Write;
use whyroad_label::episode_of;

/// Number of history entries that are read together.
const ENTRIES_AT_ONCE: i64 = 100;

/// Login names by user id.
type Names = HashMap<String, String>;

/// A task whose line has begun: its history is written after entry `after` up to entry `until`.
#[derive(Clone)]
struct Begun {
    id: String,
    after: i64,
    until: i64,
}

/// The part that is still to be written.
#[derive(Clone)]
struct Rest<'a> {
    begun: Option<Begun>,
    ids: &'a [String],
}

/// Writes a line for each of these tasks, each in its state when its turn comes.
pub(super) fn write(store: &Store, ids: &[String], names: &Names, out: &mut dyn Write) -> Answer<()> {
    let mut rest = Rest { begun: None, ids };
    while rest.begun.is_some() || !rest.ids.is_empty() {
        let (text, left) = store.report(|tx| part(tx, rest.clone(), names))?;
        out.write_all(text.as_bytes()).map_err(Problem::store)?;
        rest = left;
    }
    Ok(())
}

/// The part of `rest` that is read in one transaction, and the remaining part.
fn part<'a>(tx: &mut dyn Tx, mut rest: Rest<'a>, names: &Names) -> Answer<(String, Rest<'a>)> {
    let mut text = String::new();
    while text.len() < BYTES_AT_ONCE {
        rest.begun = match (rest.begun.take(), rest.ids) {
            (Some(begun), _) => entries(tx, begun, names, &mut text)?,
            (None, [id, others @ ..]) => {
                rest.ids = others;
                Some(begin(tx, id, names, &mut text)?)
            }
            (None, []) => break,
        };
    }
    Ok((text, rest))
}

fn begin(tx: &mut dyn Tx, id: &str, names: &Names, text: &mut String) -> Answer<Begun> {
    let t = tasks::get(tx, id)?;
    let name = |id: Option<&str>| named(names, id);
    let comments = tx.rows(
        "SELECT path, author, body, at, resolved FROM comments WHERE task_id = $1 ORDER BY at, id",
        values![id],
    )?;
    let comments = comments.iter().map(|r| {
        Ok(json!({
            "path": r.text("path")?, "author": name(Some(&r.text("author")?)), "text": r.text("body")?, "at": r.int("at")?,
            "resolved": r.flag("resolved")?,
        }))
    });
    let mut episode = serde_json::to_value(&t.episode).map_err(Problem::store)?;
    episode["score"] = episode_of::score(&t.episode).into();
    let task = json!({
        "id": t.id, "episode": episode, "overlap_index": t.overlap_index, "overlap_count": t.overlap_count,
        "priority": t.priority, "state": t.at.state, "author": name(t.at.author()),
        "checker": name(t.at.checker.as_deref()), "auditor": name(t.at.auditor.as_deref()),
        "adjudication": t.adjudication, "initial": t.initial, "draft": t.draft, "version": t.version,
        "created": t.created, "updated": t.updated, "comments": comments.collect::<Answer<Vec<Value>>>()?,
    });
    // The object is left open for the history.
    let task = task.to_string();
    text.push_str("{\"task\":");
    text.push_str(task.strip_suffix('}').unwrap_or(&task));
    text.push_str(",\"history\":[");
    Ok(Begun { id: t.id, after: 0, until: t.seq })
}

/// Some entries of the history; `None` when it is complete and the line has ended.
fn entries(tx: &mut dyn Tx, begun: Begun, names: &Names, text: &mut String) -> Answer<Option<Begun>> {
    let Begun { id, mut after, until } = begun;
    let rows = tx.rows(
        "SELECT seq, at, actor, action, from_state, to_state, changes, snapshot, note, version
         FROM history WHERE task_id = $1 AND seq > $2 AND seq <= $3 ORDER BY seq LIMIT $4",
        values![&id, after, until, ENTRIES_AT_ONCE],
    )?;
    for row in &rows {
        if after > 0 {
            text.push(',');
        }
        text.push_str(&entry(row, names)?.to_string());
        after = row.int("seq")?;
    }
    if after < until {
        // Deleted in the meantime: a line without its end is detected, half a history is not.
        let more = !rows.is_empty();
        return if more { Ok(Some(Begun { id, after, until })) } else { Err(Problem::missing()) };
    }
    text.push_str("]}}\n");
    Ok(None)
}

fn entry(row: &Row, names: &Names) -> Answer<Value> {
    let json_text = |text: Option<String>| text.map_or(Ok(Value::Null), |text| parse::<Value>(&text));
    Ok(json!({
        "seq": row.int("seq")?, "at": row.int("at")?, "actor": named(names, row.maybe_text("actor")?.as_deref()),
        "action": row.text("action")?, "from_state": row.maybe_text("from_state")?,
        "to_state": row.maybe_text("to_state")?, "changes": json_text(row.maybe_text("changes")?)?,
        "draft": json_text(row.maybe_text("snapshot")?)?, "note": row.maybe_text("note")?,
        "version": row.int("version")?,
    }))
}

/// The name of a person for other systems.
fn named(names: &Names, id: Option<&str>) -> Option<String> {
    id.map(|id| names.get(id).map_or(id, String::as_str).to_owned())
}
