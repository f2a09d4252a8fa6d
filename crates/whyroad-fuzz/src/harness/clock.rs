//! The CPU time of a thread: other work on the machine does not lengthen it.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A clock that stands while its thread does; where the system does not say, that of the wall.
#[derive(Clone)]
pub(super) struct ThreadClock {
    file: Option<PathBuf>,
    made: Instant,
}

impl ThreadClock {
    /// Of the thread that calls.
    pub fn new() -> Self {
        let of = fs::read_link("/proc/thread-self").ok();
        let file = of.map(|of| Path::new("/proc").join(of).join("schedstat"));
        Self { file: file.filter(|file| nanos(file).is_some()), made: Instant::now() }
    }

    /// Its time.
    pub fn time(&self) -> Duration {
        let on_cpu = self.file.as_deref().and_then(nanos);
        on_cpu.map_or_else(|| self.made.elapsed(), Duration::from_nanos)
    }
}

/// Time on a CPU, the first number of the file (Linux, `Documentation/scheduler/sched-stats.rst`), ns.
fn nanos(file: &Path) -> Option<u64> {
    fs::read_to_string(file).ok()?.split_whitespace().next()?.parse().ok()
}
