//! How far the run of a target is, in a file that outlives the process: its seed, the number of the next execution, how
//! often that one was begun, and the CPU time so far. An execution that was begun twice and never ended ends the
//! process.

use std::fs::{File, OpenOptions};
use std::io::{Read as _, Seek as _, Write as _};
use std::path::Path;
use std::time::Duration;

/// Where a run begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Begin {
    /// With the seeds themselves.
    New,
    /// Where the run before ended that had the same seed.
    Resumed,
}

pub(super) struct Progress {
    file: Option<File>,
    seed: u64,
    next: u64,
    begun: u64,
    spent: Duration,
    fatal: Option<u64>,
}

impl Progress {
    pub fn open(folder: &Path, target: &str, seed: u64, begin: Begin) -> Self {
        let path = folder.join(format!("{target}.progress"));
        let file = OpenOptions::new().create(true).truncate(false).read(true).write(true).open(path).ok();
        let mut progress = Self { file, seed, next: 0, begun: 0, spent: Duration::ZERO, fatal: None };
        if begin == Begin::Resumed {
            progress.read();
        }
        progress.write();
        progress
    }

    fn read(&mut self) {
        let mut text = String::new();
        let Some(Ok(_)) = self.file.as_mut().map(|f| f.read_to_string(&mut text)) else { return };
        let numbers: Vec<u64> = text.split_whitespace().map_while(|n| n.parse().ok()).collect();
        let [seed, next, begun, spent_ms] = numbers[..] else { return };
        if seed != self.seed {
            return;
        }
        (self.next, self.begun, self.spent) = (next, begun, Duration::from_millis(spent_ms));
        if begun > 1 {
            self.fatal = Some(next);
            (self.next, self.begun) = (next + 1, 0);
        }
    }

    /// Number of the next execution.
    pub fn next(&self) -> u64 {
        self.next
    }

    /// Adds CPU time.
    pub fn spend(&mut self, time: Duration) {
        self.spent += time;
    }

    /// CPU time of all executions.
    pub fn spent(&self) -> Duration {
        self.spent
    }

    /// The execution that ended the process twice.
    pub fn fatal(&self) -> Option<u64> {
        self.fatal
    }

    /// The next execution begins.
    pub fn begin(&mut self) {
        self.begun += 1;
        self.write();
    }

    /// It has ended; written with the beginning of the next one.
    pub fn end(&mut self) {
        (self.next, self.begun) = (self.next + 1, 0);
    }

    /// Writes all of it in place: always of the same length.
    pub fn write(&mut self) {
        let Some(file) = &mut self.file else { return };
        let line =
            format!("{:20} {:20} {:20} {:20}\n", self.seed, self.next, self.begun, self.spent.as_millis());
        let _ = file.rewind().and_then(|()| file.write_all(line.as_bytes()));
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_run_goes_on_where_it_was_and_skips_what_ended_the_process_twice() {
        let dir = tempfile::tempdir().unwrap();
        let open = |seed, begin| Progress::open(dir.path(), "a", seed, begin);
        let mut first = open(1, Begin::New);
        for _ in 0..3 {
            first.begin();
            first.end();
        }
        first.begin();
        drop(first);
        let mut second = open(1, Begin::Resumed);
        assert_eq!((second.next(), second.fatal()), (3, None), "the one at work is run again");
        second.begin();
        drop(second);
        let third = open(1, Begin::Resumed);
        assert_eq!((third.next(), third.fatal()), (4, Some(3)));
        assert_eq!(open(1, Begin::Resumed).next(), 4, "it is told once");
        assert_eq!(open(2, Begin::Resumed).next(), 0, "another seed is another run");
        assert_eq!(open(1, Begin::New).next(), 0);
    }
}
