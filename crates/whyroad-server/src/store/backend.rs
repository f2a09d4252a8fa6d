//! Operations that a database must provide for the store.

use super::sql::Tx;
use crate::problem::Answer;

/// Purpose of a read. Each has its own connections, so that slow reports do not block work on tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Work of a user on a task.
    Work,
    /// Dashboards, exports, backups.
    Report,
    /// Whether the store answers: a few rows, and an answer soon even if it is an error.
    Probe,
}

/// Work in a transaction. The database may require that it is run again, so it changes nothing except the database and
/// its own result.
pub(super) type Job = Box<dyn FnMut(&mut dyn Tx) -> Answer<()> + Send>;

pub(super) trait Backend: Send + Sync {
    /// Runs `job` in a transaction and commits it; an error rolls it back.
    fn write(&self, job: Job) -> Answer<()>;
    /// Runs `job` on one consistent state.
    fn read(&self, purpose: Purpose, job: &mut dyn FnMut(&mut dyn Tx) -> Answer<()>) -> Answer<()>;
    /// Removes the remains of deleted rows from free space and from the log of changes, if the database does not do
    /// that itself. False when another process keeps it in use.
    fn purge(&self) -> Answer<bool> {
        Ok(true)
    }
}
