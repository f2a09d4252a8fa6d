//! SQLite: one writer thread that commits in groups, with concurrent readers (WAL).

mod connection;
mod log_file;
mod readers;

use super::backend::{Backend, Job, Purpose};
use super::sql::{Row, Tx, Value, holdable};
use super::{migrate, private};
use crate::problem::{Answer, Problem};
use connection::{connect, problem};
use log_file::LogFile;
use readers::Readers;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, ErrorCode, ToSql};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex};

/// Bytes of a page, the default of SQLite for new files.
const PAGE: i64 = 4096;
/// Maximum number of requests that are committed together.
const GROUP: usize = 128;
/// Number of readers: for work, and for reports.
const READERS: usize = 4;
const REPORTERS: usize = 2;

pub(super) struct Sqlite {
    jobs: Mutex<Sender<Waiting>>,
    readers: Arc<Readers>,
    reporters: Arc<Readers>,
}

struct Waiting {
    job: Job,
    done: SyncSender<Answer<()>>,
}

impl Sqlite {
    /// Opens the file; also returns the path of its copy from before a migration.
    pub(super) fn open(path: &Path) -> Answer<(Self, Option<PathBuf>)> {
        Self::open_with_log(path, log_file::LONG)
    }

    /// The same, with a log of changes that is emptied when it reaches this length.
    fn open_with_log(path: &Path, long: u64) -> Answer<(Self, Option<PathBuf>)> {
        if let Some(dir) = path.parent().filter(|d| !d.as_os_str().is_empty()) {
            private::folder(dir).map_err(Problem::store)?;
        }
        private::file(path).map_err(Problem::store)?;
        let mut writer = connect(path)?;
        writer.execute_batch("PRAGMA journal_mode = WAL").map_err(problem)?;
        // Not at each commit, which would wait for it: see `log_file`. This is for a log that `log_file` cannot empty.
        writer
            .pragma_update(None, "wal_autocheckpoint", 4 * log_file::LONG as i64 / PAGE)
            .map_err(problem)?;
        let version = migrate::version(&mut Plain(&mut writer))?;
        let copy = (version > 0 && version < migrate::LATEST)
            .then(|| PathBuf::from(format!("{}.before-{}", path.display(), migrate::LATEST)));
        if let Some(aside) = &copy {
            private::file(aside).map_err(Problem::store)?;
            writer.backup("main", aside, None::<fn(rusqlite::backup::Progress)>).map_err(problem)?;
        }
        writer.execute_batch("BEGIN IMMEDIATE").map_err(problem)?;
        migrate::to(&mut Plain(&mut writer), migrate::LATEST)?;
        writer.execute_batch("COMMIT").map_err(problem)?;
        let (readers, reporters) =
            (Arc::new(Readers::open(path, READERS)?), Arc::new(Readers::open(path, REPORTERS)?));
        let log = LogFile::keep_short(path, long, [Arc::clone(&readers), Arc::clone(&reporters)])?;
        let (jobs, queue) = channel();
        std::thread::Builder::new()
            .name("whyroad-store".to_owned())
            .spawn(move || write_loop(writer, &queue, &log))
            .map_err(Problem::store)?;
        Ok((Self { jobs: Mutex::new(jobs), readers, reporters }, copy))
    }
}

impl Backend for Sqlite {
    fn write(&self, job: Job) -> Answer<()> {
        let (done, answer) = sync_channel(1);
        self.jobs.lock().map_err(Problem::store)?.send(Waiting { job, done }).map_err(Problem::store)?;
        answer.recv().map_err(Problem::store)?
    }

    fn read(&self, purpose: Purpose, job: &mut dyn FnMut(&mut dyn Tx) -> Answer<()>) -> Answer<()> {
        let readers = match purpose {
            Purpose::Work | Purpose::Probe => &self.readers,
            Purpose::Report => &self.reporters,
        };
        let mut connection = readers.take()?;
        let result = connection
            .execute_batch("BEGIN")
            .map_err(problem)
            .and_then(|()| job(&mut Plain(&mut connection)));
        let ended = connection.execute_batch("COMMIT").map_err(problem);
        readers.give(connection);
        result.and(ended)
    }

    fn purge(&self) -> Answer<bool> {
        // Rows that were moved between pages leave copies behind, which `secure_delete` does not overwrite.
        let rewrite = |connection: &Connection| {
            connection.execute_batch("VACUUM")?;
            connection.query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |row| row.get::<_, i64>(0))
        };
        let connection = self.reporters.take()?;
        let busy = rewrite(&connection);
        self.reporters.give(connection);
        match busy {
            Err(e)
                if matches!(
                    e.sqlite_error_code(),
                    Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked)
                ) =>
            {
                Ok(false)
            }
            busy => Ok(busy.map_err(problem)? == 0),
        }
    }
}

fn write_loop(mut writer: Connection, queue: &Receiver<Waiting>, log: &LogFile) {
    while let Ok(first) = queue.recv() {
        let mut group = vec![first];
        group.extend(queue.try_iter().take(GROUP - 1));
        let answers = commit_group(&mut writer, &mut group);
        for (waiting, answer) in group.into_iter().zip(answers) {
            // A request that no longer waits needs no answer.
            let _ = waiting.done.send(answer);
        }
        log.committed();
    }
}

/// Runs the jobs in one transaction, one savepoint each. When the transaction fails, all fail.
fn commit_group(writer: &mut Connection, group: &mut [Waiting]) -> Vec<Answer<()>> {
    let mut answers: Vec<Answer<()>> = Vec::with_capacity(group.len());
    let whole = (|| {
        writer.execute_batch("BEGIN IMMEDIATE").map_err(problem)?;
        for waiting in group.iter_mut() {
            writer.execute_batch("SAVEPOINT job").map_err(problem)?;
            let answer = (waiting.job)(&mut Plain(writer));
            // When the disk is full, SQLite rolls back the whole transaction.
            if writer.is_autocommit() {
                return Err(answer.err().unwrap_or_else(|| Problem::store("transaction lost")));
            }
            let end = if answer.is_ok() { "RELEASE job" } else { "ROLLBACK TO job; RELEASE job" };
            writer.execute_batch(end).map_err(problem)?;
            answers.push(answer);
        }
        writer.execute_batch("COMMIT").map_err(problem)
    })();
    if let Err(e) = whole {
        if !writer.is_autocommit() {
            let _ = writer.execute_batch("ROLLBACK");
        }
        return group.iter().map(|_| Err(e.clone())).collect();
    }
    answers
}

/// A connection inside a transaction.
struct Plain<'c>(&'c mut Connection);

impl ToSql for Value {
    fn to_sql(&self) -> rusqlite::Result<rusqlite::types::ToSqlOutput<'_>> {
        Ok(match self {
            Value::Null => rusqlite::types::Null.into(),
            Value::Int(n) => (*n).into(),
            Value::Text(t) => rusqlite::types::ToSqlOutput::Borrowed(t.as_str().into()),
        })
    }
}

impl Tx for Plain<'_> {
    fn run(&mut self, sql: &str, values: &[Value]) -> Answer<u64> {
        holdable(values)?;
        let mut statement = self.0.prepare_cached(&numbered(sql)).map_err(problem)?;
        let n = statement.execute(rusqlite::params_from_iter(values)).map_err(problem)?;
        Ok(n as u64)
    }

    fn rows(&mut self, sql: &str, values: &[Value]) -> Answer<Vec<Row>> {
        holdable(values)?;
        let mut statement = self.0.prepare_cached(&numbered(sql)).map_err(problem)?;
        let columns: Arc<[String]> = statement.column_names().map(str::to_owned).collect();
        let rows = statement.query_map(rusqlite::params_from_iter(values), |row| {
            let value = |i| {
                Ok(match row.get_ref(i)? {
                    ValueRef::Null => Value::Null,
                    ValueRef::Integer(n) => Value::Int(n),
                    ValueRef::Text(t) => Value::Text(String::from_utf8_lossy(t).into_owned()),
                    ValueRef::Real(_) | ValueRef::Blob(_) => return Err(rusqlite::Error::InvalidQuery),
                })
            };
            let values = (0..columns.len()).map(value).collect::<rusqlite::Result<Vec<_>>>()?;
            Ok(Row { columns: Arc::clone(&columns), values })
        });
        rows.map_err(problem)?.collect::<rusqlite::Result<Vec<_>>>().map_err(problem)
    }

    fn script(&mut self, sql: &str) -> Answer<()> {
        self.0.execute_batch(sql).map_err(problem)
    }

    fn columns(&mut self, table: &str) -> Answer<Vec<String>> {
        let sql = "SELECT name FROM pragma_table_info($1) ORDER BY cid";
        self.rows(sql, crate::values![table])?.iter().map(|r| r.text("name")).collect()
    }

    fn lock(&self) -> &'static str {
        ""
    }

    fn overwrite_deleted(&mut self) -> Answer<()> {
        self.script("PRAGMA secure_delete = ON")
    }
}

/// `$1` is a *named* parameter to SQLite; `?1` is the first.
fn numbered(sql: &str) -> String {
    sql.replace('$', "?")
}

#[cfg(test)]
mod tests;
