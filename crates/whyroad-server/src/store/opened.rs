//! The location of a store, and an open store.

use super::backend::{Backend, Purpose};
use super::sql::Tx;
use super::vault::{Vault, check_there};
use super::{postgres, sqlite};
use crate::problem::{Answer, Problem};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// The location of a store.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StoreLocation {
    /// A SQLite file; created if it does not exist.
    File(PathBuf),
    /// A PostgreSQL database (`postgres://user:password@host/name`).
    Server(String),
}

impl StoreLocation {
    /// `postgres://...` and `postgresql://...` are servers, everything else (with or without the prefix `sqlite:`) is a
    /// file.
    pub fn parse(text: &str) -> Self {
        if text.starts_with("postgres://") || text.starts_with("postgresql://") {
            return Self::Server(text.to_owned());
        }
        Self::File(text.strip_prefix("sqlite:").unwrap_or(text).into())
    }
}

/// The default key file of a store: beside a SQLite file, in the folder `data` for a server.
pub fn key_file(place: &StoreLocation, data: &Path) -> PathBuf {
    match place {
        StoreLocation::File(path) => PathBuf::from(format!("{}.key", path.display())),
        StoreLocation::Server(_) => data.join("labels.db.key"),
    }
}

/// An opened store. Clones share it.
#[derive(Clone)]
pub struct Store {
    backend: Arc<dyn Backend>,
    /// The keys that seal its secrets.
    pub vault: Arc<Vault>,
    /// The copy of the store from before its tables were migrated, if they were: a file to go back to.
    pub kept: Option<PathBuf>,
    /// Whether other services may use it at the same time: true for a database server.
    pub is_shared: bool,
}

impl std::fmt::Debug for Store {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Store")
    }
}

impl Store {
    /// Opens the SQLite store `file`; its other files are in the same folder.
    pub fn open(file: &Path) -> Answer<Self> {
        Self::open_keeping(&StoreLocation::File(file.to_owned()), file.parent().unwrap_or(Path::new("")))
    }

    /// Opens the store and migrates its tables, after saving the current content: a file is copied
    /// (`<file>.before-<version>`), a server's tables are backed up into the folder `aside`
    /// (`store.before-<version>.jsonl`, which [`restore`] reads), which also contains its key file.
    pub fn open_keeping(place: &StoreLocation, aside: &Path) -> Answer<Self> {
        Self::open_with_key(place, aside, &key_file(place, aside))
    }

    /// The same, with the key file at `key`. Unsealed secrets of older versions are sealed.
    pub fn open_with_key(place: &StoreLocation, aside: &Path, key: &Path) -> Answer<Self> {
        let opened = |(backend, kept): (Arc<dyn Backend>, Option<PathBuf>)| -> Answer<Store> {
            if !key.exists() {
                let path = key.to_owned();
                backend.write(Box::new(move |tx| check_there(&path, tx)))?;
            }
            let vault = Arc::new(Vault::open(key)?);
            Ok(Store { backend, vault, kept, is_shared: matches!(place, StoreLocation::Server(_)) })
        };
        let store = match place {
            StoreLocation::File(path) => {
                let (backend, kept) = sqlite::Sqlite::open(path)?;
                opened((Arc::new(backend), kept))?
            }
            StoreLocation::Server(url) => {
                let (backend, kept) = postgres::Postgres::open(url, aside)?;
                opened((Arc::new(backend), kept))?
            }
        };
        store.seal_all()?;
        Ok(store)
    }

    /// Seals all secrets that are not sealed with the first key of the key file; returns their number.
    pub(super) fn seal_all(&self) -> Answer<u64> {
        let vault = Arc::clone(&self.vault);
        self.write(move |tx| vault.seal_all(tx))
    }

    /// Replaces the key: all secrets are sealed with a new one; returns the number of secrets. No other service may use
    /// the store meanwhile.
    pub fn rotate_key(&self) -> Answer<u64> {
        self.vault.rotate(|| self.seal_all())
    }

    /// Runs `job` in a transaction. Returns its result only after the commit.
    pub fn write<T: Send + 'static>(
        &self,
        mut job: impl FnMut(&mut dyn Tx) -> Answer<T> + Send + 'static,
    ) -> Answer<T> {
        let slot = Arc::new(Mutex::new(None));
        let inner = Arc::clone(&slot);
        self.backend.write(Box::new(move |tx| {
            let value = job(tx)?;
            *inner.lock().map_err(Problem::store)? = Some(value);
            Ok(())
        }))?;
        let value = slot.lock().map_err(Problem::store)?.take();
        value.ok_or_else(|| Problem::store("no result"))
    }

    /// Removes the remains of deleted rows from the database's files: earlier versions in free space, and its log of
    /// changes; false when another process keeps them in use. For a database server this is the server's task. A SQLite
    /// file is rewritten, which needs the same disk space again during that time.
    pub fn purge(&self) -> Answer<bool> {
        self.backend.purge()
    }

    /// Runs `job` on one consistent state of the store.
    pub fn read<T>(&self, job: impl FnMut(&mut dyn Tx) -> Answer<T>) -> Answer<T> {
        self.read_for(Purpose::Work, job)
    }

    /// The same for slow reads: dashboards, exports, backups. They have their own connections.
    pub fn report<T>(&self, job: impl FnMut(&mut dyn Tx) -> Answer<T>) -> Answer<T> {
        self.read_for(Purpose::Report, job)
    }

    /// The same for probes: a store that is away is reported soon, instead of being waited for.
    pub fn probe<T>(&self, job: impl FnMut(&mut dyn Tx) -> Answer<T>) -> Answer<T> {
        self.read_for(Purpose::Probe, job)
    }

    fn read_for<T>(&self, purpose: Purpose, mut job: impl FnMut(&mut dyn Tx) -> Answer<T>) -> Answer<T> {
        let mut out = None;
        self.backend.read(purpose, &mut |tx| {
            out = Some(job(tx)?);
            Ok(())
        })?;
        out.ok_or_else(|| Problem::store("no result"))
    }
}
