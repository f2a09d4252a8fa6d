//! Failed sign-ins: after a few, each further one has to wait longer, by name and by address. And passwords are hashed one
//! at a time: each takes a good part of a second of a core on purpose.

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
    if wait == 0 {
        return Ok(());
    }
    let seconds = (wait + 999) / 1000;
    Err(Problem::new(
        429,
        "session.wait",
        format!("失败次数过多，请 {seconds} 秒后再试"),
        format!("too many failures: try again in {seconds} s"),
    )
    .with(json!({ "retry_after_s": seconds })))
}

impl Limits {
    /// Lets a sign-in be tried, or says how long to wait.
    pub fn admit(&self, name: &str, address: &str, now: i64) -> Answer<()> {
        let wait =
            keys(name, address).iter().map(|(key, free)| self.wait(key, *free, now)).max().unwrap_or(0);
        admitted(wait)
    }

    fn wait(&self, key: &str, free: u32, now: i64) -> i64 {
        let Ok(failures) = self.failures.lock() else { return LONGEST };
        // A clock that was set back must not lock anybody out for longer than the wait itself.
        failures
            .get(key)
            .map_or(0, |f| (f.last + wait_ms(f.count, free) - now).clamp(0, wait_ms(f.count, free)))
    }

    /// As [`Limits::admit`], where no name is known: by address alone.
    pub fn admit_from(&self, address: &str, now: i64) -> Answer<()> {
        let [_, (key, free)] = keys("", address);
        admitted(self.wait(&key, free, now))
    }

    /// Counts a failure where no name is known.
    pub fn failed_from(&self, address: &str, now: i64) {
        let [_, key] = keys("", address);
        self.count(&[key], now);
    }

    /// Counts a failure.
    pub fn failed(&self, name: &str, address: &str, now: i64) {
        self.count(&keys(name, address), now);
    }

    fn count(&self, keys: &[(String, u32)], now: i64) {
        let Ok(mut failures) = self.failures.lock() else { return };
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
    }

    /// Forgets the failures of a name. Those of the address stay: one good password must not free the guessing of others.
    pub fn succeeded(&self, name: &str) {
        if let Ok(mut failures) = self.failures.lock() {
            failures.remove(&keys(name, "")[0].0);
        }
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

    #[test]
    fn five_are_free_then_the_wait_doubles() {
        let limits = Limits::default();
        let wait = |name: &str, now: i64| match limits.admit(name, "a", now) {
            Ok(()) => 0,
            Err(e) => e.more.map_or(-1, |m| m["retry_after_s"].as_i64().unwrap()),
        };
        for _ in 0..5 {
            assert_eq!(wait("ann", 0), 0);
            limits.failed("ann", "a", 0);
        }
        assert_eq!(wait("ann", 0), 1);
        assert_eq!(wait("bob", 0), 0);
        limits.failed("ann", "a", 1000);
        assert_eq!(wait("ann", 1000), 2);
        assert_eq!(wait("ann", -1_000_000), 2, "the clock was set back");
        limits.succeeded("ann");
        assert_eq!(wait("ann", 1000), 0);
    }

    #[test]
    fn an_address_that_tries_many_names_waits_too() {
        let limits = Limits::default();
        for i in 0..50 {
            limits.failed(&format!("user{i}"), "a", 0);
        }
        assert_eq!(limits.admit("fresh", "a", 0).unwrap_err().code, "session.wait");
        assert!(limits.admit("fresh", "b", 0).is_ok());
    }
}
