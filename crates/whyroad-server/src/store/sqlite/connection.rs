//! A connection, and what its errors are to who asked.

use crate::problem::{Answer, Problem};
use rusqlite::{Connection, ErrorCode, OpenFlags};
use std::path::Path;
use std::time::Duration;

/// How long another process (`whyroad tasks`) may keep the file.
const BUSY: Duration = Duration::from_secs(10);

/// Opens the file, or makes it.
pub(super) fn connect(path: &Path) -> Answer<Connection> {
    let flags =
        OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_CREATE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = Connection::open_with_flags(path, flags).map_err(problem)?;
    connection.busy_timeout(BUSY).map_err(problem)?;
    connection.set_prepared_statement_cache_capacity(64);
    // FULL: what was acknowledged survives a loss of power, not only of the process.
    connection.execute_batch("PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON").map_err(problem)?;
    Ok(connection)
}

/// What went wrong, for the person who asked.
pub(super) fn problem(e: rusqlite::Error) -> Problem {
    match e.sqlite_error_code() {
        Some(ErrorCode::DiskFull) => Problem::disk_full(),
        _ => Problem::store(e),
    }
}
