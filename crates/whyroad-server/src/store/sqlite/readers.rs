//! Read connections: each reader has its own, and all can be held back for a moment.

use super::connection::connect;
use crate::problem::{Answer, Problem};
use crate::sync::lock;
use rusqlite::Connection;
use std::path::Path;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

pub(super) struct Readers {
    pool: Mutex<Pool>,
    /// Notifies callers that wait for a connection.
    free: Condvar,
    /// Notifies callers that wait until nobody reads.
    quiet: Condvar,
    size: usize,
}

struct Pool {
    idle: Vec<Connection>,
    closed: bool,
}

impl Readers {
    pub fn open(path: &Path, size: usize) -> Answer<Self> {
        let idle = (0..size).map(|_| connect(path)).collect::<Answer<Vec<_>>>()?;
        let pool = Mutex::new(Pool { idle, closed: false });
        Ok(Self { pool, free: Condvar::new(), quiet: Condvar::new(), size })
    }

    /// A connection, as soon as one is free.
    pub fn take(&self) -> Answer<Connection> {
        let mut pool = self.pool.lock().map_err(Problem::store)?;
        loop {
            if !pool.closed
                && let Some(connection) = pool.idle.pop()
            {
                return Ok(connection);
            }
            pool = self.free.wait(pool).map_err(Problem::store)?;
        }
    }

    /// Returns a connection.
    pub fn give(&self, connection: Connection) {
        let mut pool = self.lock();
        pool.idle.push(connection);
        if !pool.closed {
            self.free.notify_one();
        } else if pool.idle.len() == self.size {
            self.quiet.notify_one();
        }
    }

    /// Waits until all current reads have ended, and starts no new ones until the result is dropped; `None` if they
    /// have not ended after `wait`.
    pub fn close(&self, wait: Duration) -> Option<Closed<'_>> {
        let mut pool = self.lock();
        pool.closed = true;
        let closed = Closed(self);
        let (pool, late) = self
            .quiet
            .wait_timeout_while(pool, wait, |pool| pool.idle.len() < self.size)
            .unwrap_or_else(PoisonError::into_inner);
        drop(pool);
        (!late.timed_out()).then_some(closed)
    }

    /// The pool. It stays valid even after a panic of a thread that held the lock.
    fn lock(&self) -> MutexGuard<'_, Pool> {
        lock(&self.pool)
    }
}

/// Nobody reads, until this is dropped.
pub(super) struct Closed<'a>(&'a Readers);

impl Drop for Closed<'_> {
    fn drop(&mut self) {
        self.0.lock().closed = false;
        self.0.free.notify_all();
    }
}
