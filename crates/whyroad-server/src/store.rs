//! The store: SQLite in a file, or PostgreSQL by URL; the same SQL text and the same tests for both.
//!
//! All writes of one request are one transaction. SQLite has one writer thread that commits many requests together
//! (each in its own savepoint) and answers none of them before the commit is on disk.

mod backend;
mod backup;
mod dump;
mod migrate;
mod opened;
mod postgres;
pub mod private;
mod sql;
mod sqlite;
pub mod vault;

pub use backup::{backup, backup_to, restore};
pub(crate) use dump::TABLES;
pub use opened::{Store, StoreLocation, key_file};
pub use sql::{Row, Tx, Value};

/// A list of values.
#[macro_export]
macro_rules! values {
    ($($v:expr),* $(,)?) => { &[$($crate::store::Value::from($v)),*] };
}
