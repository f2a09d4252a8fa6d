//! Where a store is, and a store that was opened.

use super::backend::{Backend, Purpose};
use super::sql::Tx;
use super::vault::Vault;
use super::{postgres, sqlite};
use crate::problem::{Answer, Problem};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// Where a store is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StoreLocation {
    /// A file of SQLite's; made when it is not there.
    File(PathBuf),
    /// A PostgreSQL database (`postgres://user:password@host/name`).
    Server(String),
}

impl StoreLocation {
    /// `postgres://...` and `postgresql://...` are servers, everything else (`sqlite:` in front or not) a file.
    pub fn parse(text: &str) -> Self {
        if text.starts_with("postgres://") || text.starts_with("postgresql://") {
            return Self::Server(text.to_owned());
        }
        Self::File(text.strip_prefix("sqlite:").unwrap_or(text).into())
    }
}

/// The key file of a store that names none: beside a SQLite file, in the folder `data` for a server.
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
    /// The keys that its secrets are sealed with.
    pub vault: Arc<Vault>,
    /// What was kept of the store before its tables were brought forward, where they were: a file to go back to.
    pub kept: Option<PathBuf>,
    /// Whether other services may use it at the same time: a database server's.
    pub is_shared: bool,
}

impl std::fmt::Debug for Store {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Store")
    }
}

impl Store {
    /// Opens the SQLite store `file`; everything that belongs to it lies beside it.
    pub fn open(file: &Path) -> Answer<Self> {
        Self::open_keeping(&StoreLocation::File(file.to_owned()), file.parent().unwrap_or(Path::new("")))
    }

    /// Opens the store and brings its tables up to date, after keeping what is there: a file is copied
    /// (`<file>.before-<version>`), a server's tables are backed up into the folder `aside`
    /// (`store.before-<version>.jsonl`, which [`restore`] reads), where its key file lies, too.
    pub fn open_keeping(place: &StoreLocation, aside: &Path) -> Answer<Self> {
        Self::open_with_key(place, aside, &key_file(place, aside))
    }

    /// The same, with the key file at `key`. Secrets from before sealing are sealed.
    pub fn open_with_key(place: &StoreLocation, aside: &Path, key: &Path) -> Answer<Self> {
        let opened = |(backend, kept): (Arc<dyn Backend>, Option<PathBuf>)| -> Answer<Store> {
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

    /// Seals all secrets that are not sealed with the first key of the key file; the number of these.
    pub(super) fn seal_all(&self) -> Answer<u64> {
        let vault = Arc::clone(&self.vault);
        self.write(move |tx| vault.seal_all(tx))
    }

    /// Replaces the key: all secrets are sealed with a new one; the number of secrets. No other service may use the
    /// store meanwhile.
    pub fn rotate_key(&self) -> Answer<u64> {
        self.vault.rotate(|| self.seal_all())
    }

    /// Runs `job` in a transaction. What it returns is returned only after the commit.
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

    /// Removes what is left of deleted rows from the database's files: earlier versions in free space, and its log of
    /// changes; false when another process keeps them in use. Of a database server this is the server's task. A SQLite
    /// file is rewritten, which takes as much space again for that time.
    pub fn purge(&self) -> Answer<bool> {
        self.backend.purge()
    }

    /// Runs `job` on one consistent state of the store.
    pub fn read<T>(&self, job: impl FnMut(&mut dyn Tx) -> Answer<T>) -> Answer<T> {
        self.read_for(Purpose::Work, job)
    }

    /// The same for what takes long: dashboards, exports, backups. They have connections of their own.
    pub fn report<T>(&self, job: impl FnMut(&mut dyn Tx) -> Answer<T>) -> Answer<T> {
        self.read_for(Purpose::Report, job)
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
