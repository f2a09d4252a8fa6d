//! Failed sign-ins: after a few, each further one has to wait longer, by name and by address. And passwords are hashed
//! one at a time: each takes a good part of a second of a core on purpose.

use crate::problem::{Answer, Problem};
use serde_json::json;
use std::collections::HashMap;
use std::sync::Mutex;

/// Failures of one name that cost nothing.
const FREE_OF_NAME: u32 = 5;
/// Failures from one address that cost nothing: behind a proxy all come from one.
const FREE_OF_ADDRESS: u32 = 50;
/// Longest wait, ms.
const LONGEST: i64 = 300_000;
/// Entries kept; beyond that those that wait no more are forgotten, then nobody new may fail.
const KEPT: usize = 10_000;
/// After this the count starts again, ms.
const DAY: i64 = 24 * 3_600_000;

/// Failures so far.
#[derive(Debug, Default)]
pub struct Limits {
    failures: Mutex<HashMap<String, Failures>>,
    hashing: Mutex<()>,
}

#[derive(Clone, Copy, Debug)]
struct Failures {
    count: u32,
    last: i64,
}

fn wait_ms(count: u32, free: u32) -> i64 {
    if count < free { 0 } else { (1000_i64 << (count - free).min(20)).min(LONGEST) }
}

fn keys(name: &str, address: &str) -> [(String, u32); 2] {
    // A name is kept short: nobody has one of a megabyte.
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

/// How long `key` has to wait, ms. A clock that was set back must not lock anybody out for longer than the wait itself.
fn wait(failures: &HashMap<String, Failures>, key: &str, free: u32, now: i64) -> i64 {
    failures.get(key).map_or(0, |f| (f.last + wait_ms(f.count, free) - now).clamp(0, wait_ms(f.count, free)))
}

/// A sign-in that is being tried. It counts as a failure from its beginning, so that many at once are counted like one
/// after another; only what [`Attempt::succeeded`] or [`Attempt::forgiven`] takes back does not stay.
#[must_use = "a sign-in that is dropped counts as failed"]
pub struct Attempt<'l> {
    limits: &'l Limits,
    keys: Vec<String>,
}

impl Attempt<'_> {
    /// Takes it back: the fault was not the caller's.
    pub fn forgiven(self) {
        let Ok(mut failures) = self.limits.failures.lock() else { return };
        for key in &self.keys {
            if let Some(f) = failures.get_mut(key) {
                f.count = f.count.saturating_sub(1);
            }
        }
        failures.retain(|_, f| f.count > 0);
    }

    /// Forgets the failures of the name. Those of the address stay: one good password must not free the guessing of
    /// others.
    pub fn succeeded(self) {
        if let (Ok(mut failures), Some(name)) = (self.limits.failures.lock(), self.keys.first()) {
            failures.remove(name);
        }
        self.forgiven();
    }
}

impl Limits {
    /// Begins a sign-in, or says how long to wait.
    pub fn begin(&self, name: &str, address: &str, now: i64) -> Answer<Attempt<'_>> {
        self.count(&keys(name, address), now)
    }

    /// As [`Limits::begin`], where no name is known: by address alone.
    pub fn begin_from(&self, address: &str, now: i64) -> Answer<Attempt<'_>> {
        let [_, key] = keys("", address);
        self.count(&[key], now)
    }

    /// How long to wait before a sign-in where no name is known; counts nothing.
    pub fn admit_from(&self, address: &str, now: i64) -> Answer<()> {
        let [_, (key, free)] = keys("", address);
        let Ok(failures) = self.failures.lock() else { return admitted(LONGEST) };
        admitted(wait(&failures, &key, free, now))
    }

    /// Looks and counts in one: two that come together see each other.
    fn count(&self, keys: &[(String, u32)], now: i64) -> Answer<Attempt<'_>> {
        let Ok(mut failures) = self.failures.lock() else { return Err(must_wait(LONGEST)) };
        admitted(keys.iter().map(|(key, free)| wait(&failures, key, *free, now)).max().unwrap_or(0))?;
        if failures.len() >= KEPT {
            failures.retain(|_, f| f.last + LONGEST > now);
        }
        for (key, _) in keys {
            let entry = failures.entry(key.clone()).or_insert(Failures { count: 0, last: now });
            if entry.last + DAY < now {
                entry.count = 0;
            }
            *entry = Failures { count: entry.count + 1, last: now };
        }
        Ok(Attempt { limits: self, keys: keys.iter().map(|(key, _)| key.clone()).collect() })
    }

    /// Runs what hashes a password while nobody else does.
    pub fn one_at_a_time<T>(&self, hash: impl FnOnce() -> T) -> T {
        let _alone = self.hashing.lock();
        hash()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fails to sign in, or says how long to wait, s.
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
        let limits = Limits::default();
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

    #[test]
    fn what_is_being_tried_counts_already() {
        let limits = Limits::default();
        let open: Vec<_> = (0..400).filter_map(|_| limits.begin("ann", "a", 0).ok()).collect();
        assert_eq!(open.len(), 5);
        // The fault of a provider is nobody's failure.
        open.into_iter().for_each(Attempt::forgiven);
        assert_eq!(fail(&limits, "ann", 0), 0);
    }

    #[test]
    fn an_address_that_tries_many_names_waits_too() {
        let limits = Limits::default();
        for i in 0..50 {
            assert_eq!(fail(&limits, &format!("user{i}"), 0), 0);
        }
        assert!(fail(&limits, "fresh", 0) > 0);
        assert!(limits.begin("fresh", "b", 0).is_ok());
        assert_eq!(limits.admit_from("a", 0).unwrap_err().code, "session.wait");
    }
}
