//! Backup: all tables as JSON lines, the same for both databases, so that a backup of one restores into the other.

use super::sql::{Tx, Value};
use super::{Store, migrate};
use crate::problem::{Answer, Problem};
use serde_json::{Value as Json, json};
use std::io::{BufRead, Write};

/// Tables and their columns, a table after those that it refers to. A test holds it against the scripts.
pub(super) const TABLES: &[(&str, &str)] = &[
    ("settings", "name,value"),
    ("users", "id,name,display,admin,lang,password_hash,disabled,created"),
    ("sessions", "hash,user_id,expires"),
    ("api_tokens", "id,hash,user_id,name,created"),
    ("projects", "id,name,guide,quota,settings,created"),
    ("members", "project_id,user_id,roles,skills"),
    (
        "tasks",
        "id,project_id,episode_id,overlap_index,overlap_count,drive_id,clip_id,scenario_id,keyframe_ns,from_ns,to_ns,\
         episode,initial,draft,version,priority,state,authors,author,checker,auditor,checked,audited,adjudication,\
         assigned,holder,fence,lease_until,seq,created,updated,lang",
    ),
    ("history", "task_id,seq,at,actor,action,from_state,to_state,changes,snapshot,note,version"),
    ("comments", "id,task_id,path,author,body,at,resolved"),
    ("seen", "user_id,task_id,drive_id,from_ns,to_ns"),
    ("webhooks", "id,project_id,url,events,secret,last_error,created"),
    ("outbox", "id,webhook_id,body,tries,due,created"),
];

/// Rows fetched at once.
const PAGE: i64 = 1000;

/// Writes the whole store, one consistent state of it, as JSON lines; the number of rows.
pub fn backup(store: &Store, out: &mut dyn Write) -> Answer<u64> {
    store.read(|tx| {
        // One state for all tables; SQLite's read transactions are that already.
        if !tx.lock().is_empty() {
            tx.script("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ")?;
        }
        line(out, &json!({"whyroad_backup": 1, "schema_version": migrate::LATEST}))?;
        let mut rows = 0;
        for (table, columns) in TABLES {
            let mut from = 0;
            loop {
                let sql = format!("SELECT {columns} FROM {table} ORDER BY 1, 2 LIMIT $1 OFFSET $2");
                let page = tx.rows(&sql, crate::values![PAGE, from])?;
                let n = page.len() as i64;
                for row in page {
                    let values: Vec<Json> = row.0.into_iter().map(to_json).collect();
                    line(out, &json!({"table": table, "row": values}))?;
                }
                rows += n as u64;
                from += n;
                if n < PAGE {
                    break;
                }
            }
        }
        line(out, &json!({"end": true, "rows": rows}))?;
        out.flush().map_err(Problem::store)?;
        Ok(rows)
    })
}

/// Reads a backup into an empty store, whole or not at all; the number of rows. A cut-off backup is refused.
pub fn restore(store: &Store, input: &mut dyn BufRead) -> Answer<u64> {
    let mut lines = Vec::new();
    for line in input.lines() {
        let line = line.map_err(Problem::store)?;
        lines.push(serde_json::from_str::<Json>(&line).map_err(Problem::request)?);
    }
    let (Some(head), Some(tail)) = (lines.first(), lines.last()) else { return Err(broken("empty")) };
    if head["whyroad_backup"] != 1 {
        return Err(broken("not a backup of whyroad"));
    }
    if head["schema_version"] != migrate::LATEST {
        return Err(broken(format!(
            "tables of version {}, this program has {}",
            head["schema_version"],
            migrate::LATEST
        )));
    }
    if tail["end"] != true || tail["rows"] != (lines.len() - 2) as u64 {
        return Err(broken("it is cut off"));
    }
    store.write(move |tx| {
        if tx.row("SELECT 1 FROM users LIMIT 1", &[])?.is_some() {
            return Err(Problem::new(409, "restore.not_empty", "目标存储不是空的", "the store is not empty"));
        }
        tx.run("DELETE FROM settings", &[])?;
        for entry in &lines[1..lines.len() - 1] {
            put(tx, entry)?;
        }
        Ok((lines.len() - 2) as u64)
    })
}

fn put(tx: &mut dyn Tx, entry: &Json) -> Answer<()> {
    let name = entry["table"].as_str().unwrap_or_default();
    let Some((table, columns)) = TABLES.iter().find(|(t, _)| *t == name) else {
        return Err(broken(format!("unknown table '{name}'")));
    };
    let values = entry["row"].as_array().map(|r| r.iter().map(from_json).collect::<Answer<Vec<_>>>());
    let values = values.ok_or_else(|| broken("a row is missing"))??;
    if values.len() != columns.split(',').count() {
        return Err(broken(format!("a row of '{name}' has {} values", values.len())));
    }
    let holes: Vec<String> = (1..=values.len()).map(|i| format!("${i}")).collect();
    tx.run(&format!("INSERT INTO {table} ({columns}) VALUES ({})", holes.join(",")), &values)?;
    Ok(())
}

fn line(out: &mut dyn Write, value: &Json) -> Answer<()> {
    writeln!(out, "{value}").map_err(Problem::store)
}

fn to_json(value: Value) -> Json {
    match value {
        Value::Null => Json::Null,
        Value::Int(n) => n.into(),
        Value::Text(t) => t.into(),
    }
}

fn from_json(value: &Json) -> Answer<Value> {
    match value {
        Json::Null => Ok(Value::Null),
        Json::String(t) => Ok(Value::Text(t.clone())),
        Json::Number(n) => n.as_i64().map(Value::Int).ok_or_else(|| broken("a number is too great")),
        _ => Err(broken("a value is no number or text")),
    }
}

fn broken(why: impl std::fmt::Display) -> Problem {
    Problem::new(
        400,
        "restore.broken",
        format!("备份无法使用：{why}"),
        format!("the backup cannot be used: {why}"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::Place;

    /// A column that is not in [`TABLES`] would be lost by a backup without a word.
    #[test]
    fn every_table_and_column_is_in_a_backup() {
        let dir = tempfile::tempdir().unwrap();
        let store = Store::open(&Place::File(dir.path().join("s"))).unwrap();
        let sql = "SELECT m.name, group_concat(c.name, ',') FROM sqlite_master m, pragma_table_info(m.name) c
                   WHERE m.type = 'table' AND m.name <> 'schema_version' GROUP BY m.name ORDER BY m.name";
        let there = store.read(|tx| tx.rows(sql, &[])).unwrap();
        let there: Vec<_> = there.iter().map(|r| (r.text(0).unwrap(), r.text(1).unwrap())).collect();
        let mut kept: Vec<_> = TABLES.iter().map(|(t, c)| ((*t).to_owned(), (*c).to_owned())).collect();
        kept.sort();
        assert_eq!(there, kept);
    }
}
