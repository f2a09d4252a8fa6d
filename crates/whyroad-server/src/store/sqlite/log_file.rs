//! The log file of changes beside the database (`-wal`). SQLite restarts it only when nobody reads, and under load
//! there are always readers: it would grow without limit, and reading would become slower. So readers are held back for
//! a moment when it is long.

use super::connection::{connect, problem};
use super::readers::Readers;
use crate::problem::{Answer, Problem};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::time::Duration;

/// Length from which on it is emptied, bytes: about every 30 s with 200 annotators who save every second.
pub(super) const LONG: u64 = 128 << 20;
/// Maximum wait for reports; work continues during this time.
const WAIT_FOR_REPORTS: Duration = Duration::from_secs(5);
/// Maximum wait for work, which is held back during this time.
const WAIT_FOR_WORK: Duration = Duration::from_millis(100);
/// Maximum time that another process may keep the file locked.
const BUSY: Duration = Duration::from_millis(100);
/// Time until the next attempt, if somebody read for too long.
const TRY_AGAIN: Duration = Duration::from_secs(2);

/// Notified after each commit.
pub(super) struct LogFile {
    path: PathBuf,
    long: u64,
    wanted: SyncSender<()>,
}

impl LogFile {
    /// The log of the database at `path`, emptied in coordination with these readers once it has `long` bytes.
    pub fn keep_short(path: &Path, long: u64, readers: [Arc<Readers>; 2]) -> Answer<Self> {
        let (wanted, queue) = sync_channel(1);
        let log = Self { path: PathBuf::from(format!("{}-wal", path.display())), long, wanted };
        let connection = connect(path)?;
        connection.busy_timeout(BUSY).map_err(problem)?;
        let file = log.path.clone();
        std::thread::Builder::new()
            .name("whyroad-log-file".to_owned())
            .spawn(move || empty_when_wanted(&connection, &file, long, &readers, &queue))
            .map_err(Problem::store)?;
        Ok(log)
    }

    /// Called after a commit.
    pub fn committed(&self) {
        if length(&self.path) >= self.long {
            // One pending request is enough.
            let _ = self.wanted.try_send(());
        }
    }
}

fn length(file: &Path) -> u64 {
    std::fs::metadata(file).map_or(0, |about| about.len())
}

fn empty_when_wanted(
    connection: &rusqlite::Connection,
    file: &Path,
    long: u64,
    readers: &[Arc<Readers>; 2],
    queue: &Receiver<()>,
) {
    while queue.recv().is_ok() {
        while length(file) >= long {
            if empty(connection, readers) {
                break;
            }
            // The store is closed.
            if queue.try_recv() == Err(TryRecvError::Disconnected) {
                return;
            }
            std::thread::sleep(TRY_AGAIN);
        }
    }
}

/// False if somebody reads for too long.
fn empty(connection: &rusqlite::Connection, [work, reports]: &[Arc<Readers>; 2]) -> bool {
    // Most of it while others read: then little is left for the moment in which nobody may read.
    let checkpoint = |how: &str| {
        let sql = format!("PRAGMA wal_checkpoint({how})");
        connection.query_row(&sql, [], |row| row.get::<_, i64>(0)).is_ok_and(|busy| busy == 0)
    };
    checkpoint("PASSIVE");
    let Some(_reports) = reports.close(WAIT_FOR_REPORTS) else { return false };
    checkpoint("PASSIVE");
    let Some(_work) = work.close(WAIT_FOR_WORK) else { return false };
    checkpoint("TRUNCATE")
}
