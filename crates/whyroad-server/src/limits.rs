//! Limits for failed sign-ins: after a few, each further one has to wait longer, by name and by address. Services on
//! one PostgreSQL share the counts, in the store, by hashes of name and address; a service on SQLite is alone and
//! counts in memory. Passwords are hashed one at a time, because each hash intentionally takes a large part of a second
//! of a core.

use crate::problem::{Answer, Problem};
use crate::store::{Store, Tx};
use crate::{secret, values};
use serde_json::json;
use std::collections::HashMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Failures of one name without a wait.
const FREE_OF_NAME: u32 = 5;
/// Failures from one address without a wait: behind a proxy all have the same address.
const FREE_OF_ADDRESS: u32 = 50;
/// Maximum wait, ms.
const LONGEST: i64 = 300_000;
/// Maximum number of entries; beyond that, entries without a wait are removed.
const KEPT: usize = 10_000;
/// Time after which a count starts again, ms.
const DAY: i64 = 24 * 3_600_000;

/// Failures so far.
#[derive(Debug, Default)]
pub struct Limits {
    failures: Failures,
    hashing: Mutex<()>,
    hashes: AtomicUsize,
}

/// Counts one until it is dropped.
struct Counted<'c>(&'c AtomicUsize);

impl<'c> Counted<'c> {
    fn new(count: &'c AtomicUsize) -> Self {
        count.fetch_add(1, Ordering::SeqCst);
        Self(count)
    }
}

impl Drop for Counted<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Where failures are counted.
#[derive(Debug)]
enum Failures {
    Memory(Mutex<HashMap<String, Failed>>),
    Shared(Store),
}

impl Default for Failures {
    fn default() -> Self {
        Self::Memory(Mutex::default())
    }
}

/// Failures of a name or an address.
#[derive(Clone, Copy, Debug)]
struct Failed {
    count: u32,
    last: i64,
}

impl Failed {
    /// The count after another failure.
    fn again(self, now: i64) -> Self {
        let count = if self.last + DAY < now { 0 } else { self.count };
        Self { count: count + 1, last: now }
    }
}

fn wait_ms(count: u32, free: u32) -> i64 {
    if count < free { 0 } else { (1000_i64 << (count - free).min(20)).min(LONGEST) }
}

/// A name or an address, and its number of failures without a wait.
type Key = (String, u32);

fn keys(name: &str, address: &str) -> [Key; 2] {
    // A name is cut: no real name has a megabyte.
    let name: String = name.chars().take(64).collect();
    [(format!("name {name}"), FREE_OF_NAME), (format!("address {address}"), FREE_OF_ADDRESS)]
}

/// A wait in ms as an answer.
fn admitted(wait: i64) -> Answer<()> {
    if wait == 0 { Ok(()) } else { Err(must_wait(wait)) }
}

fn must_wait(wait: i64) -> Problem {
    let seconds = (wait + 999) / 1000;
    Problem::new(
        429,
        "session.wait",
        format!("失败次数过多，请 {seconds} 秒后再试"),
        format!("too many failures: try again in {seconds} s"),
    )
    .with(json!({ "retry_after_s": seconds }))
}

/// Time that `key` has to wait, ms. A clock that was set back must not lock anybody out for longer than the wait
/// itself.
fn wait(failed: Option<Failed>, free: u32, now: i64) -> i64 {
    failed.map_or(0, |f| (f.last + wait_ms(f.count, free) - now).clamp(0, wait_ms(f.count, free)))
}

/// A sign-in in progress. It counts as a failure from its start, so that concurrent ones are counted like consecutive
/// ones; only [`Attempt::succeeded`] and [`Attempt::forgiven`] revert that.
#[must_use = "a sign-in that is dropped counts as failed"]
pub struct Attempt<'l> {
    limits: &'l Limits,
    keys: Vec<String>,
}

impl Attempt<'_> {
    /// Reverts the count: the error was not the caller's.
    pub fn forgiven(self) {
        self.take_back(false);
    }

    /// Removes the failures of the name. Those of the address stay: one correct password must not permit guessing
    /// others.
    pub fn succeeded(self) {
        self.take_back(true);
    }

    fn take_back(self, forget_name: bool) {
        let forgotten = self.keys.first().filter(|_| forget_name).cloned();
        match &self.limits.failures {
            Failures::Memory(failures) => {
                let Ok(mut failures) = failures.lock() else { return };
                for key in &self.keys {
                    if let Some(f) = failures.get_mut(key) {
                        f.count = f.count.saturating_sub(1);
                    }
                }
                failures.retain(|key, f| f.count > 0 && forgotten.as_ref() != Some(key));
            }
            // If the store is unavailable, the attempt stays counted as a failure.
            Failures::Shared(store) => {
                drop(store.write(move |tx| shared::take_back(tx, &self.keys, forgotten.as_deref())))
            }
        }
    }
}

impl Limits {
    /// Counts in the store if other services may use it, too.
    pub fn of(store: &Store) -> Self {
        let failures = if store.is_shared { Failures::Shared(store.clone()) } else { Failures::default() };
        Self { failures, ..Self::default() }
    }

    /// Starts a sign-in, or returns the time to wait.
    pub fn begin(&self, name: &str, address: &str, now: i64) -> Answer<Attempt<'_>> {
        self.count(&keys(name, address), now)
    }

    /// As [`Limits::begin`], where no name is known: by address alone.
    pub fn begin_from(&self, address: &str, now: i64) -> Answer<Attempt<'_>> {
        let [_, key] = keys("", address);
        self.count(&[key], now)
    }

    /// Returns the time to wait before a sign-in where no name is known; counts nothing.
    pub fn admit_from(&self, address: &str, now: i64) -> Answer<()> {
        let [_, (key, free)] = keys("", address);
        let failed = match &self.failures {
            Failures::Memory(failures) => {
                let Ok(failures) = failures.lock() else { return admitted(LONGEST) };
                failures.get(&key).copied()
            }
            Failures::Shared(store) => store.read(|tx| shared::failed(tx, &shared::hash(&key), ""))?,
        };
        admitted(wait(failed, free, now))
    }

    /// Reads and counts in one step: concurrent attempts see each other.
    fn count(&self, keys: &[Key], now: i64) -> Answer<Attempt<'_>> {
        let attempt = Attempt { limits: self, keys: keys.iter().map(|(key, _)| key.clone()).collect() };
        let failures = match &self.failures {
            Failures::Memory(failures) => failures,
            Failures::Shared(store) => {
                let keys = keys.to_vec();
                store.write(move |tx| shared::count(tx, &keys, now))?;
                return Ok(attempt);
            }
        };
        let Ok(mut failures) = failures.lock() else { return Err(must_wait(LONGEST)) };
        let longest = keys.iter().map(|(key, free)| wait(failures.get(key).copied(), *free, now)).max();
        admitted(longest.unwrap_or(0))?;
        if failures.len() >= KEPT {
            failures.retain(|_, f| f.last + LONGEST > now);
        }
        for (key, _) in keys {
            let failed = failures.get(key).copied().unwrap_or(Failed { count: 0, last: now });
            failures.insert(key.clone(), failed.again(now));
        }
        Ok(attempt)
    }

    /// Runs a password hash while no other one runs.
    pub fn one_at_a_time<T>(&self, hash: impl FnOnce() -> T) -> T {
        let _counted = Counted::new(&self.hashes);
        let _alone = self.hashing.lock();
        hash()
    }

    /// Number of password hashes that run or wait for their turn.
    pub fn hashes(&self) -> usize {
        self.hashes.load(Ordering::SeqCst)
    }
}

/// The count in the store. It stores two hashes and two numbers per attempt without a sign-in, for a bounded number of
/// names and addresses.
mod shared {
    use super::{Answer, Failed, KEPT, Key, LONGEST, Tx, admitted, secret, values, wait};

    /// A name may be a password that was typed into the wrong field.
    pub fn hash(key: &str) -> String {
        secret::hash(key)
    }

    /// Failures of a key; `lock` is from [`Tx::lock`], or empty.
    pub fn failed(tx: &mut dyn Tx, hash: &str, lock: &str) -> Answer<Option<Failed>> {
        let sql = format!("SELECT failures, last FROM sign_in_failures WHERE who = $1{lock}");
        let row = tx.row(&sql, values![hash])?;
        row.map(|r| {
            Ok(Failed { count: u32::try_from(r.int("failures")?).unwrap_or(0), last: r.int("last")? })
        })
        .transpose()
    }

    /// Always in the order of `keys`, name before address, so that two services never wait for each other.
    pub fn count(tx: &mut dyn Tx, keys: &[Key], now: i64) -> Answer<()> {
        let lock = tx.lock();
        let mut longest = 0;
        let mut counted = Vec::new();
        for (key, free) in keys {
            let who = hash(key);
            let sql = "INSERT INTO sign_in_failures (who, failures, last) VALUES ($1, 0, $2)
                       ON CONFLICT (who) DO NOTHING";
            tx.run(sql, values![&who, now])?;
            let before = failed(tx, &who, lock)?.unwrap_or(Failed { count: 0, last: now });
            longest = longest.max(wait(Some(before), *free, now));
            counted.push((who, before));
        }
        // A refusal rolls back the rows above with the transaction.
        admitted(longest)?;
        for (who, before) in counted {
            let after = before.again(now);
            let sql = "UPDATE sign_in_failures SET failures = $1, last = $2 WHERE who = $3";
            tx.run(sql, values![i64::from(after.count), after.last, &who])?;
        }
        let rows =
            tx.row("SELECT count(*) AS n FROM sign_in_failures", &[])?.map_or(Ok(0), |r| r.int("n"))?;
        if usize::try_from(rows).is_ok_and(|n| n > KEPT) {
            tx.run("DELETE FROM sign_in_failures WHERE last <= $1", values![now - LONGEST])?;
        }
        Ok(())
    }

    pub fn take_back(tx: &mut dyn Tx, keys: &[String], forgotten: Option<&str>) -> Answer<()> {
        for key in keys {
            let who = hash(key);
            if forgotten == Some(key) {
                tx.run("DELETE FROM sign_in_failures WHERE who = $1", values![&who])?;
                continue;
            }
            tx.run("UPDATE sign_in_failures SET failures = failures - 1 WHERE who = $1", values![&who])?;
            tx.run("DELETE FROM sign_in_failures WHERE who = $1 AND failures <= 0", values![&who])?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counting in memory, and in a store as services on PostgreSQL do.
    fn both(dir: &tempfile::TempDir) -> [Limits; 2] {
        let store = Store::open(&dir.path().join("store")).unwrap();
        [Limits::default(), Limits { failures: Failures::Shared(store), ..Limits::default() }]
    }

    /// Fails to sign in, or returns the time to wait, s.
    fn fail(limits: &Limits, name: &str, now: i64) -> i64 {
        match limits.begin(name, "a", now) {
            Ok(attempt) => {
                drop(attempt);
                0
            }
            Err(e) => e.more.map_or(-1, |m| m["retry_after_s"].as_i64().unwrap()),
        }
    }

    #[test]
    fn five_are_free_then_the_wait_doubles() {
        let dir = tempfile::tempdir().unwrap();
        for limits in both(&dir) {
            for _ in 0..5 {
                assert_eq!(fail(&limits, "ann", 0), 0);
            }
            assert_eq!(fail(&limits, "ann", 0), 1);
            assert_eq!(fail(&limits, "bob", 0), 0);
            assert_eq!(fail(&limits, "ann", 1000), 0, "the wait is over");
            assert_eq!(fail(&limits, "ann", 1000), 2);
            assert_eq!(fail(&limits, "ann", -1_000_000), 2, "the clock was set back");
            limits.begin("ann", "a", 3000).unwrap().succeeded();
            assert_eq!(fail(&limits, "ann", 3000), 0);
        }
    }

    #[test]
    fn what_is_being_tried_counts_already() {
        let dir = tempfile::tempdir().unwrap();
        for limits in both(&dir) {
            let open: Vec<_> = (0..400).filter_map(|_| limits.begin("ann", "a", 0).ok()).collect();
            assert_eq!(open.len(), 5);
            // A failure of the provider is not counted.
            open.into_iter().for_each(Attempt::forgiven);
            assert_eq!(fail(&limits, "ann", 0), 0);
        }
    }

    #[test]
    fn an_address_that_tries_many_names_waits_too() {
        let dir = tempfile::tempdir().unwrap();
        for limits in both(&dir) {
            for i in 0..50 {
                assert_eq!(fail(&limits, &format!("user{i}"), 0), 0);
            }
            assert!(fail(&limits, "fresh", 0) > 0);
            assert!(limits.begin("fresh", "b", 0).is_ok());
            assert_eq!(limits.admit_from("a", 0).unwrap_err().code, "session.wait");
        }
    }
}
