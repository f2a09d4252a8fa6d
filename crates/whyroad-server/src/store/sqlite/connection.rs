//! Opens connections, and converts their errors to problems.

use crate::problem::{Answer, Problem};
use rusqlite::{Connection, ErrorCode, OpenFlags};
use std::path::Path;
use std::time::Duration;

/// Maximum time that another process (`whyroad tasks`) may keep the file locked.
const BUSY: Duration = Duration::from_secs(10);

/// Opens the file, or creates it.
pub(super) fn connect(path: &Path) -> Answer<Connection> {
    let flags =
        OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_CREATE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = Connection::open_with_flags(path, flags).map_err(problem)?;
    connection.busy_timeout(BUSY).map_err(problem)?;
    connection.set_prepared_statement_cache_capacity(64);
    // FULL: acknowledged data survives a power failure, not only the end of the process.
    connection.execute_batch("PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON").map_err(problem)?;
    Ok(connection)
}

/// The problem for a database error.
pub(super) fn problem(e: rusqlite::Error) -> Problem {
    match e.sqlite_error_code() {
        Some(ErrorCode::DiskFull) => Problem::disk_full(),
        _ => Problem::store(e),
    }
}
