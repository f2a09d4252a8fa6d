//! PostgreSQL: a pool of connections; a transaction that fails before its commit because of a restart or a deadlock is
//! run again.

use super::backend::{Backend, Job, Purpose};
use super::sql::{Row, Tx, Value, holdable};
use super::{dump, migrate};
use crate::problem::{Answer, Problem};
use postgres::error::SqlState;
use postgres::types::{IsNull, ToSql, Type, to_sql_checked};
use postgres::{Client, Config, NoTls, Statement, Transaction};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

/// Maximum number of connections.
const CONNECTIONS: usize = 16;
/// Of these, maximum number for reports.
const REPORTS: usize = 3;
/// Maximum time that a request waits for a database that restarts.
const RETRY_FOR: Duration = Duration::from_secs(15);
/// The same for a probe: enough to replace a connection that was closed meanwhile.
const PROBE_FOR: Duration = Duration::from_secs(1);
/// Time after which a connection on which nothing comes back counts as broken: its peer or the network is gone.
const SILENCE: Duration = Duration::from_secs(30);
/// Maximum number of prepared statements per connection; beyond that the cache is cleared.
const PREPARED: usize = 200;
/// Key of the advisory lock that prevents two services from migrating at once.
const MIGRATION_LOCK: i64 = 0x7768_7972;

pub(super) struct Postgres {
    config: Config,
    pool: Mutex<Pool>,
    free: Condvar,
    reports: Turns,
}

/// Limits the connections of reports, which could otherwise use all of them.
#[derive(Default)]
struct Turns {
    taken: Mutex<usize>,
    free: Condvar,
}

/// A permission to use a connection, until it is dropped.
struct Turn<'t>(&'t Turns);

impl Turns {
    fn wait(&self) -> Answer<Turn<'_>> {
        let mut taken = self.taken.lock().map_err(Problem::store)?;
        while *taken >= REPORTS {
            taken = self.free.wait(taken).map_err(Problem::store)?;
        }
        *taken += 1;
        Ok(Turn(self))
    }
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        if let Ok(mut taken) = self.0.taken.lock() {
            *taken -= 1;
        }
        self.0.free.notify_one();
    }
}

struct Pool {
    idle: Vec<Connection>,
    out: usize,
}

/// A connection with its prepared statements: saves half of the round trips to the server.
struct Connection {
    client: Client,
    prepared: HashMap<String, Statement>,
}

impl Postgres {
    /// Opens the database; also returns the path of the backup that was written into `aside` before a migration.
    pub(super) fn open(url: &str, aside: &Path) -> Answer<(Self, Option<PathBuf>)> {
        let mut config: Config = url.parse().map_err(|e| problem(&e))?;
        config.connect_timeout(Duration::from_secs(5)).application_name("whyroad");
        config.keepalives_idle(SILENCE);
        if config.get_tcp_user_timeout().is_none() {
            config.tcp_user_timeout(SILENCE);
        }
        let store = Self {
            config,
            pool: Mutex::new(Pool { idle: vec![], out: 0 }),
            free: Condvar::new(),
            reports: Turns::default(),
        };
        let mut copy = None;
        store.read(Purpose::Work, &mut |tx| {
            tx.script(&format!("SELECT pg_advisory_xact_lock({MIGRATION_LOCK})"))?;
            let version = migrate::version(tx)?;
            if version > 0 && version < migrate::LATEST {
                let path = aside.join(format!("store.before-{}.jsonl", migrate::LATEST));
                lock_all(tx)?;
                dump::to_file(&path, |out| dump::write_all(tx, version, out))?;
                copy = Some(path);
            }
            migrate::to(tx, migrate::LATEST)
        })?;
        Ok((store, copy))
    }

    /// A connection; at most `most` are in use.
    fn connection(&self, most: usize) -> Result<Connection, Failure> {
        let broken = || Failure::Final(Problem::store("the pool is broken"));
        let mut pool = self.pool.lock().map_err(|_| broken())?;
        while pool.out >= most {
            pool = self.free.wait(pool).map_err(|_| broken())?;
        }
        pool.out += 1;
        if let Some(connection) = pool.idle.pop().filter(|c| !c.client.is_closed()) {
            return Ok(connection);
        }
        // If one connection is closed, the others probably are, too.
        pool.idle.retain(|c| !c.client.is_closed());
        drop(pool);
        let client = self.config.connect(NoTls).map_err(|e| {
            self.give_back(None);
            // An unavailable server may come back; a wrong password stays wrong.
            if passes(&e) { Failure::Again(problem(&e)) } else { Failure::Final(problem(&e)) }
        })?;
        Ok(Connection { client, prepared: HashMap::new() })
    }

    fn give_back(&self, connection: Option<Connection>) {
        if let Ok(mut pool) = self.pool.lock() {
            pool.out -= 1;
            pool.idle.extend(connection.filter(|c| !c.client.is_closed()));
        }
        self.free.notify_one();
    }

    fn transact(&self, purpose: Purpose, job: &mut dyn FnMut(&mut dyn Tx) -> Answer<()>) -> Answer<()> {
        let start = Instant::now();
        // One connection is left for probes: that all others are busy does not mean that the server does not answer.
        let (most, retry_for) = match purpose {
            Purpose::Work | Purpose::Report => (CONNECTIONS, RETRY_FOR),
            Purpose::Probe => (CONNECTIONS + 1, PROBE_FOR),
        };
        loop {
            let outcome = match self.connection(most) {
                Ok(mut connection) => {
                    let outcome = attempt(&mut connection, job);
                    self.give_back(Some(connection));
                    outcome
                }
                Err(failure) => Err(failure),
            };
            match outcome {
                Ok(()) => return Ok(()),
                Err(Failure::Final(e)) => return Err(e),
                Err(Failure::Again(e)) if start.elapsed() > retry_for => return Err(e),
                Err(Failure::Again(_)) => std::thread::sleep(Duration::from_millis(50)),
            }
        }
    }
}

/// Locks all tables until the transaction ends, so that the copied state is the migrated state.
fn lock_all(tx: &mut dyn Tx) -> Answer<()> {
    for table in dump::TABLES {
        if !tx.columns(table)?.is_empty() {
            tx.script(&format!("LOCK TABLE {table} IN ACCESS EXCLUSIVE MODE"))?;
        }
    }
    Ok(())
}

impl Drop for Postgres {
    /// Connections are closed on a separate thread: closing blocks, which is not permitted on a thread that drives a
    /// runtime.
    fn drop(&mut self) {
        let idle = self.pool.get_mut().map(|pool| std::mem::take(&mut pool.idle)).unwrap_or_default();
        let closing = std::thread::Builder::new().name("whyroad-close".to_owned()).spawn(move || drop(idle));
        if let Ok(closing) = closing {
            let _ = closing.join();
        }
    }
}

enum Failure {
    /// Nothing was committed, and another attempt may succeed.
    Again(Problem),
    /// A refusal, or it is unknown whether it was committed.
    Final(Problem),
}

fn attempt(
    connection: &mut Connection,
    job: &mut dyn FnMut(&mut dyn Tx) -> Answer<()>,
) -> Result<(), Failure> {
    let Connection { client, prepared } = connection;
    if prepared.len() > PREPARED {
        prepared.clear();
    }
    let transaction = client.transaction().map_err(|e| Failure::Again(problem(&e)))?;
    let mut tx = Running { transaction, prepared, again: false };
    match job(&mut tx) {
        Ok(()) => tx.transaction.commit().map_err(|e| {
            // A server that returns an error has not committed; a connection that broke may have.
            if e.code().is_some() && passes(&e) {
                Failure::Again(problem(&e))
            } else {
                Failure::Final(problem(&e))
            }
        }),
        Err(e) if tx.again => Err(Failure::Again(e)),
        Err(e) => Err(Failure::Final(e)),
    }
}

/// True for temporary errors: a restart, a broken connection, a deadlock.
fn passes(e: &postgres::Error) -> bool {
    let by_code = e.code().is_some_and(|c| {
        [
            &SqlState::T_R_SERIALIZATION_FAILURE,
            &SqlState::T_R_DEADLOCK_DETECTED,
            &SqlState::ADMIN_SHUTDOWN,
            &SqlState::CRASH_SHUTDOWN,
            &SqlState::CANNOT_CONNECT_NOW,
        ]
        .contains(&c)
    });
    by_code || e.is_closed() || e.code().is_none()
}

impl Backend for Postgres {
    fn write(&self, mut job: Job) -> Answer<()> {
        self.transact(Purpose::Work, &mut *job)
    }

    fn read(&self, purpose: Purpose, job: &mut dyn FnMut(&mut dyn Tx) -> Answer<()>) -> Answer<()> {
        let _turn = match purpose {
            Purpose::Work | Purpose::Probe => None,
            Purpose::Report => Some(self.reports.wait()?),
        };
        self.transact(purpose, job)
    }
}

struct Running<'c> {
    transaction: Transaction<'c>,
    prepared: &'c mut HashMap<String, Statement>,
    again: bool,
}

impl Running<'_> {
    fn statement(&mut self, sql: &str) -> Answer<Statement> {
        if let Some(statement) = self.prepared.get(sql) {
            return Ok(statement.clone());
        }
        let made = self.transaction.prepare(sql);
        let statement = self.noted(made)?;
        self.prepared.insert(sql.to_owned(), statement.clone());
        Ok(statement)
    }

    fn noted<T>(&mut self, result: Result<T, postgres::Error>) -> Answer<T> {
        result.map_err(|e| {
            self.again |= passes(&e);
            problem(&e)
        })
    }
}

impl ToSql for Value {
    fn to_sql(
        &self,
        kind: &Type,
        out: &mut postgres::types::private::BytesMut,
    ) -> Result<IsNull, Box<dyn std::error::Error + Sync + Send>> {
        match self {
            Value::Null => Ok(IsNull::Yes),
            // With a literal beside it the parameter has the type INT4.
            Value::Int(n) if *kind == Type::INT4 => i32::try_from(*n)?.to_sql(kind, out),
            Value::Int(n) => n.to_sql(kind, out),
            Value::Text(t) => t.to_sql(kind, out),
        }
    }

    fn accepts(_: &Type) -> bool {
        true
    }

    to_sql_checked!();
}

impl Tx for Running<'_> {
    fn run(&mut self, sql: &str, values: &[Value]) -> Answer<u64> {
        holdable(values)?;
        let values: Vec<&(dyn ToSql + Sync)> = values.iter().map(|v| v as _).collect();
        let statement = self.statement(sql)?;
        let result = self.transaction.execute(&statement, &values);
        self.noted(result)
    }

    fn rows(&mut self, sql: &str, values: &[Value]) -> Answer<Vec<Row>> {
        holdable(values)?;
        let values: Vec<&(dyn ToSql + Sync)> = values.iter().map(|v| v as _).collect();
        let statement = self.statement(sql)?;
        let result = self.transaction.query(&statement, &values);
        let columns: Arc<[String]> = statement.columns().iter().map(|c| c.name().to_owned()).collect();
        self.noted(result)?.iter().map(|r| row(&columns, r)).collect()
    }

    fn script(&mut self, sql: &str) -> Answer<()> {
        let result = self.transaction.batch_execute(sql);
        self.noted(result)
    }

    fn columns(&mut self, table: &str) -> Answer<Vec<String>> {
        let sql = "SELECT CAST(column_name AS TEXT) AS name FROM information_schema.columns
                   WHERE table_schema = current_schema() AND table_name = $1 ORDER BY ordinal_position";
        self.rows(sql, crate::values![table])?.iter().map(|r| r.text("name")).collect()
    }

    fn clock(&mut self) -> Answer<Option<i64>> {
        let sql = "SELECT CAST(extract(epoch FROM clock_timestamp()) * 1000 AS BIGINT) AS now";
        self.row(sql, &[])?.map(|r| r.int("now")).transpose()
    }

    fn lock(&self) -> &'static str {
        " FOR UPDATE"
    }
}

fn row(columns: &Arc<[String]>, row: &postgres::Row) -> Answer<Row> {
    let value = |(i, column): (usize, &postgres::Column)| {
        let number = |n: Option<i64>| n.map_or(Value::Null, Value::Int);
        Ok(match *column.type_() {
            Type::INT8 => number(row.try_get(i).map_err(|e| problem(&e))?),
            Type::INT4 => number(row.try_get::<_, Option<i32>>(i).map_err(|e| problem(&e))?.map(i64::from)),
            _ => {
                row.try_get::<_, Option<String>>(i).map_err(|e| problem(&e))?.map_or(Value::Null, Value::Text)
            }
        })
    };
    let values = row.columns().iter().enumerate().map(value).collect::<Answer<Vec<_>>>()?;
    Ok(Row { columns: Arc::clone(columns), values })
}

fn problem(e: &postgres::Error) -> Problem {
    match (e.code(), e.as_db_error()) {
        (Some(code), _) if *code == SqlState::DISK_FULL => Problem::disk_full(),
        (_, Some(d)) => Problem::store(d.message()),
        // The error itself only states where it happened; its source states the reason.
        _ => match std::error::Error::source(e) {
            Some(cause) => Problem::store(format!("{e}: {cause}")),
            None => Problem::store(e),
        },
    }
}
