//! The file of changes beside the database (`-wal`). SQLite restarts it only at a moment at which nobody reads, and
//! under load somebody always does: it would grow without end, and reading would become slower with it. So, when it is
//! long, readers are kept back for a moment.

use super::connection::{connect, problem};
use super::readers::Readers;
use crate::problem::{Answer, Problem};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::time::Duration;

/// From this length on it is emptied, bytes: every half minute with 200 annotators who save every second.
pub(super) const LONG: u64 = 128 << 20;
/// Reports may last; work goes on while one is waited for.
const WAIT_FOR_REPORTS: Duration = Duration::from_secs(5);
/// Work is kept back meanwhile.
const WAIT_FOR_WORK: Duration = Duration::from_millis(100);
/// How long another process may keep the file.
const BUSY: Duration = Duration::from_millis(100);
/// Until the next attempt, where somebody read for too long.
const TRY_AGAIN: Duration = Duration::from_secs(2);

/// Whom to tell after each commit.
pub(super) struct LogFile {
    path: PathBuf,
    long: u64,
    wanted: SyncSender<()>,
}

impl LogFile {
    /// The log of the database at `path`, emptied beside these readers once it is `long` bytes.
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

    /// Something was committed.
    pub fn committed(&self) {
        if length(&self.path) >= self.long {
            // One wish is enough.
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

/// False where somebody reads for too long.
fn empty(connection: &rusqlite::Connection, [work, reports]: &[Arc<Readers>; 2]) -> bool {
    // The greater part, beside everybody: then little is left for the moment in which nobody may read.
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
