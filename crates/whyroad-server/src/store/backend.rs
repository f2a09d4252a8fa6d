//! What a database has to do for the store.

use super::sql::Tx;
use crate::problem::Answer;

/// What is read for. Each has connections of its own, so that reports, which take long, keep nobody's work waiting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Somebody's work on a task.
    Work,
    /// Dashboards, exports, backups.
    Report,
}

/// Work in a transaction. It may be run again when the database asks for it, so it changes nothing but the database
/// and its own result.
pub(super) type Job = Box<dyn FnMut(&mut dyn Tx) -> Answer<()> + Send>;

pub(super) trait Backend: Send + Sync {
    /// Runs `job` in a transaction and commits it; an error undoes it.
    fn write(&self, job: Job) -> Answer<()>;
    /// Runs `job` on one consistent state.
    fn read(&self, purpose: Purpose, job: &mut dyn FnMut(&mut dyn Tx) -> Answer<()>) -> Answer<()>;
    /// Removes what is left of deleted rows in free space and in the log of changes, where the database leaves that to
    /// us. False when another process keeps it in use.
    fn purge(&self) -> Answer<bool> {
        Ok(true)
    }
}
