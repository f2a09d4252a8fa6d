//! All tables as JSON lines, in the same form for both databases, so that a backup of one can be restored into the
//! other. The columns of a table are read from the database, in the order of the scripts that created it: a backup of
//! an older version of the program is restored into tables of that version, which are then migrated like any other
//! store.

use super::private;
use super::sql::{Tx, Value};
use crate::problem::{Answer, Problem};
use crate::secret;
use serde_json::{Value as Json, json};
use sha2::{Digest as _, Sha256};
use std::collections::HashMap;
use std::fs::File;
use std::io::{BufRead, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

/// Tables, each after those that it references, with a key in the first two columns. A test compares the list with the
/// scripts.
pub(crate) const TABLES: &[&str] = &[
    "settings",
    "users",
    "identities",
    "oidc_used",
    "sessions",
    "sign_in_failures",
    "api_tokens",
    "projects",
    "members",
    "tasks",
    "finished_episodes",
    "history",
    "activity",
    "comments",
    "thumbnails",
    "safety",
    "gold",
    "verdicts",
    "model_runs",
    "model_run_tasks",
    "judgements",
    "seen",
    "webhooks",
    "outbox",
];

/// Number of rows fetched together.
const PAGE: usize = 1000;
/// Maximum length of a line: the largest row is a task with two drafts.
const MOST_BYTES: u64 = 16 * 1024 * 1024;

pub(super) fn to_file(path: &Path, write: impl FnOnce(&mut dyn Write) -> Answer<u64>) -> Answer<u64> {
    let cannot = |e: std::io::Error| Problem::store(format!("{}: {e}", path.display()));
    if let Some(dir) = path.parent().filter(|d| !d.as_os_str().is_empty()) {
        private::folder(dir).map_err(cannot)?;
    }
    let aside = PathBuf::from(format!("{}.part", path.display()));
    let mut options = File::options();
    options.write(true).create(true).truncate(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    let mut file = BufWriter::new(options.open(&aside).map_err(cannot)?);
    let rows = write(&mut file)?;
    file.flush().map_err(cannot)?;
    file.get_ref().sync_all().map_err(cannot)?;
    std::fs::rename(&aside, path).map_err(cannot)?;
    Ok(rows)
}

/// All tables of a store of `version`. The last line states the number of rows and the hash of the lines above it.
pub(super) fn write_all(tx: &mut dyn Tx, version: i64, out: &mut dyn Write) -> Answer<u64> {
    let mut out = Hashed { to: out, hash: Sha256::new() };
    let out = &mut out;
    line(out, &json!({"whyroad_backup": 1, "schema_version": version}))?;
    let mut rows = 0;
    for table in TABLES {
        // A table of a later version has no columns yet.
        let columns = tx.columns(table)?;
        let [one, two, ..] = &columns[..] else { continue };
        let sql = |condition: &str| {
            let all = columns.join(",");
            format!("SELECT {all} FROM {table} {condition} ORDER BY {one}, {two} LIMIT {PAGE}")
        };
        let mut page = tx.rows(&sql(""), &[])?;
        while let Some(last) = page.last().map(|row| [row.values[0].clone(), row.values[1].clone()]) {
            let full = page.len() == PAGE;
            rows += page.len() as u64;
            for row in page {
                let values: Vec<Json> = row.values.into_iter().map(to_json).collect();
                line(out, &json!({"table": table, "row": values}))?;
            }
            // From the last key on: an offset would be counted again for each page.
            let after = format!("WHERE ({one}, {two}) > ($1, $2)");
            page = if full { tx.rows(&sql(&after), &last)? } else { vec![] };
        }
    }
    let hash = secret::hex(&out.hash.clone().finalize());
    line(out, &json!({"end": true, "rows": rows, "sha256": hash}))?;
    out.flush().map_err(Problem::store)?;
    Ok(rows)
}

pub(super) fn read_all(tx: &mut dyn Tx, lines: &mut Lines<impl BufRead>) -> Answer<u64> {
    let mut rows = 0;
    let mut columns: HashMap<&str, Vec<String>> = HashMap::new();
    loop {
        let above = lines.hash.clone();
        let Some(entry) = lines.next()? else { break };
        if entry["end"] == true {
            if entry["rows"] != rows || lines.next()?.is_some() {
                return Err(broken("rows are missing"));
            }
            // Backups of earlier programs have none.
            return match entry["sha256"].as_str() {
                Some(stated) if stated != secret::hex(&above.finalize()) => {
                    Err(broken("it was changed after it was made (its hash differs)"))
                }
                _ => Ok(rows),
            };
        }
        let name = entry["table"].as_str().unwrap_or_default();
        let Some(table) = TABLES.iter().find(|t| **t == name) else {
            return Err(broken(format!("unknown table '{name}'")));
        };
        if !columns.contains_key(table) {
            columns.insert(table, tx.columns(table)?);
        }
        put(tx, table, &columns[table], &entry)?;
        rows += 1;
    }
    Err(broken("it is truncated"))
}

fn put(tx: &mut dyn Tx, table: &str, columns: &[String], entry: &Json) -> Answer<()> {
    let values = entry["row"].as_array().map(|r| r.iter().map(from_json).collect::<Answer<Vec<_>>>());
    let values = values.ok_or_else(|| broken("a row is missing"))??;
    if values.is_empty() || values.len() != columns.len() {
        return Err(broken(format!("a row of '{table}' has {} values", values.len())));
    }
    let holes: Vec<String> = (1..=values.len()).map(|i| format!("${i}")).collect();
    let sql = format!("INSERT INTO {table} ({}) VALUES ({})", columns.join(","), holes.join(","));
    tx.run(&sql, &values)?;
    Ok(())
}

/// Hashes what is written.
struct Hashed<'a> {
    to: &'a mut dyn Write,
    hash: Sha256,
}

impl Write for Hashed<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let n = self.to.write(bytes)?;
        self.hash.update(&bytes[..n]);
        Ok(n)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.to.flush()
    }
}

/// A backup line by line: it may be larger than the memory.
pub(super) struct Lines<R> {
    from: R,
    /// Of the lines read so far.
    hash: Sha256,
}

impl<R: BufRead> Lines<R> {
    pub(super) fn new(from: R) -> Self {
        Self { from, hash: Sha256::new() }
    }

    pub(super) fn next(&mut self) -> Answer<Option<Json>> {
        let mut text = String::new();
        let n = (&mut self.from).take(MOST_BYTES).read_line(&mut text).map_err(broken)?;
        if n == 0 {
            return Ok(None);
        }
        if n as u64 == MOST_BYTES {
            return Err(broken(format!("a line is longer than {MOST_BYTES} bytes")));
        }
        self.hash.update(text.as_bytes());
        serde_json::from_str(&text).map(Some).map_err(broken)
    }
}

fn line(out: &mut impl Write, value: &Json) -> Answer<()> {
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
        Json::Number(n) => n.as_i64().map(Value::Int).ok_or_else(|| broken("a number is too large")),
        _ => Err(broken("a value is neither a number nor a text")),
    }
}

pub(super) fn broken(why: impl std::fmt::Display) -> Problem {
    Problem::new(
        400,
        "restore.broken",
        format!("备份无法使用：{why}"),
        format!("the backup cannot be used: {why}"),
    )
}
