//! Connections that read: each reader has one for itself, and all can be kept back for a moment.

use super::connection::connect;
use crate::problem::{Answer, Problem};
use crate::sync::lock;
use rusqlite::Connection;
use std::path::Path;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

pub(super) struct Readers {
    pool: Mutex<Pool>,
    /// For who waits for a connection.
    free: Condvar,
    /// For who waits until nobody reads.
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

    /// A connection, once one is free.
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

    /// Gives a connection back.
    pub fn give(&self, connection: Connection) {
        let mut pool = self.lock();
        pool.idle.push(connection);
        if !pool.closed {
            self.free.notify_one();
        } else if pool.idle.len() == self.size {
            self.quiet.notify_one();
        }
    }

    /// Lets nobody begin to read until the result is dropped, once those who do have ended; `None` where they have not
    /// after `wait`.
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

    /// The pool. It stays whole even when a thread that held the lock has died.
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
