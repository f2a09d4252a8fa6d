//! Backup and restore of a whole store, from either database into either.

use super::dump::{Lines, TABLES, broken, read_all, to_file, write_all};
use super::migrate::{self, LATEST};
use super::opened::Store;
use crate::problem::{Answer, Problem};
use std::io::{BufRead, Write};
use std::path::Path;

/// Writes the whole store, in one consistent state, as JSON lines; returns the number of rows.
pub fn backup(store: &Store, out: &mut dyn Write) -> Answer<u64> {
    store.report(|tx| {
        // One state for all tables; SQLite's read transactions already guarantee that.
        if !tx.lock().is_empty() {
            tx.script("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ")?;
        }
        write_all(tx, LATEST, out)
    })
}

/// The same into a temporary file that is renamed at the end, so that the file is complete or absent; only its owner
/// can read it.
pub fn backup_to(store: &Store, path: &Path) -> Answer<u64> {
    to_file(path, |out| backup(store, out))
}

/// Reads a backup into an empty store, completely or not at all; returns the number of rows. A truncated or changed
/// backup is refused. `open` opens the backup from its beginning: the database may require that the whole restore is
/// repeated.
pub fn restore<R: BufRead>(
    store: &Store,
    mut open: impl FnMut() -> std::io::Result<R> + Send + 'static,
) -> Answer<u64> {
    let vault = std::sync::Arc::clone(&store.vault);
    store.write(move |tx| {
        let mut lines = Lines::new(open().map_err(Problem::store)?);
        let head = lines.next()?.ok_or_else(|| broken("empty"))?;
        let version = head["schema_version"].as_i64().unwrap_or(0);
        if head["whyroad_backup"] != 1 || version < 1 {
            return Err(broken("not a Whyroad backup"));
        }
        if version > LATEST {
            return Err(broken(format!(
                "the backup has version {version}, this program supports up to {LATEST}"
            )));
        }
        for table in ["users", "projects"] {
            if tx.row(&format!("SELECT 1 FROM {table} LIMIT 1"), &[])?.is_some() {
                return Err(Problem::new(
                    409,
                    "restore.not_empty",
                    "目标存储不是空的",
                    "the store is not empty",
                ));
            }
        }
        tx.run("DELETE FROM settings", &[])?;
        if version < LATEST {
            TABLES.iter().rev().try_for_each(|t| tx.script(&format!("DROP TABLE IF EXISTS {t}")))?;
            tx.run("DELETE FROM schema_version", &[])?;
            migrate::to(tx, version)?;
        }
        let rows = read_all(tx, &mut lines)?;
        migrate::to(tx, LATEST)?;
        // With another key than the backup's nothing is restored: its secrets would be lost.
        vault.seal_all(tx)?;
        vault.check(tx)?;
        Ok(rows)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A backup would silently omit a table that is not in [`TABLES`].
    #[test]
    fn every_table_is_in_a_backup() {
        let dir = tempfile::tempdir().unwrap();
        let store = Store::open(&dir.path().join("s")).unwrap();
        let sql =
            "SELECT name FROM sqlite_master WHERE type = 'table' AND name <> 'schema_version' ORDER BY name";
        let there = store.read(|tx| tx.rows(sql, &[])).unwrap();
        let there: Vec<_> = there.iter().map(|r| r.text("name").unwrap()).collect();
        let mut kept = TABLES.to_vec();
        kept.sort_unstable();
        assert_eq!(there, kept);
    }
}
