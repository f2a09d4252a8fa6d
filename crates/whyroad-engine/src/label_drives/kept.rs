//! Values by key within a number of bytes: those used last stay. Each is made once, also when several threads ask for
//! it at the same time; the others wait. Knows nothing of drives.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// Memory of an entry beside its value, about.
const ENTRY_BYTES: usize = 256;

/// Kept values.
pub(super) struct Kept<K, V> {
    bytes: usize,
    entries: Mutex<Entries<K, V>>,
}

struct Entries<K, V> {
    all: HashMap<K, Entry<V>>,
    /// Memory of all that are made.
    bytes: usize,
    /// Counts requests.
    now: u64,
}

struct Entry<V> {
    value: Slot<V>,
    /// 0 while it is being made.
    bytes: usize,
    used: u64,
}

/// `None` where there is no such value.
type Slot<V> = Arc<OnceLock<Option<Arc<V>>>>;

impl<K: Clone + Eq + Hash, V> Kept<K, V> {
    /// Keeps values of this many bytes together, or one value that is larger.
    pub fn new(bytes: usize) -> Self {
        Self { bytes, entries: Mutex::new(Entries { all: HashMap::new(), bytes: 0, now: 0 }) }
    }

    /// The value of `key`; `make` returns it with its bytes, or `None` where there is none.
    pub fn get(&self, key: &K, make: impl FnOnce() -> Option<(V, usize)>) -> Option<Arc<V>> {
        let slot = self.entries().slot(key);
        let mut made = None;
        let value = slot
            .get_or_init(|| {
                let (value, bytes) = make().map_or((None, 0), |(v, bytes)| (Some(Arc::new(v)), bytes));
                made = Some(bytes + ENTRY_BYTES);
                value
            })
            .clone();
        match (made, &value) {
            // What cannot be read now may be readable later.
            (Some(_), None) => self.entries().forget(key),
            (Some(bytes), Some(_)) => self.entries().keep(key, bytes, self.bytes),
            (None, _) => {}
        }
        value
    }

    /// The entries. They stay consistent even when a thread that held the lock has panicked.
    fn entries(&self) -> MutexGuard<'_, Entries<K, V>> {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<K: Clone + Eq + Hash, V> Entries<K, V> {
    fn slot(&mut self, key: &K) -> Slot<V> {
        self.now += 1;
        if let Some(entry) = self.all.get_mut(key) {
            entry.used = self.now;
            return Arc::clone(&entry.value);
        }
        let value = Slot::default();
        self.all.insert(key.clone(), Entry { value: Arc::clone(&value), bytes: 0, used: self.now });
        value
    }

    /// Removes an entry of which nothing was made.
    fn forget(&mut self, key: &K) {
        self.all.remove(key);
    }

    /// Counts what was made, and removes others until all fit.
    fn keep(&mut self, key: &K, bytes: usize, most: usize) {
        if let Some(entry) = self.all.get_mut(key) {
            entry.bytes = bytes;
            self.bytes += bytes;
        }
        while self.bytes > most {
            let others = self.all.iter().filter(|(k, e)| *k != key && e.bytes > 0);
            let Some(oldest) = others.min_by_key(|(_, e)| e.used).map(|(k, _)| k.clone()) else { return };
            self.bytes -= self.all.remove(&oldest).map_or(0, |e| e.bytes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn what_was_used_last_stays_within_the_bytes() {
        let kept = Kept::new(3 * (100 + ENTRY_BYTES));
        let made = AtomicUsize::new(0);
        let get = |key: u32, bytes: usize| {
            let value = kept.get(&key, || {
                made.fetch_add(1, Ordering::Relaxed);
                Some((key * 10, bytes))
            });
            assert_eq!(value.as_deref(), Some(&(key * 10)));
            made.load(Ordering::Relaxed)
        };
        assert_eq!([1, 2, 3, 1].map(|key| get(key, 100)), [1, 2, 3, 3]);
        // 2 was used longest ago.
        assert_eq!([4, 1, 3, 2].map(|key| get(key, 100)), [4, 4, 4, 5]);
        // A larger one is kept alone.
        assert_eq!([get(9, 5000), get(9, 5000), get(2, 100)], [6, 6, 7]);
        let entries = kept.entries();
        assert_eq!((entries.all.len(), entries.bytes), (1, 100 + ENTRY_BYTES));
    }

    #[test]
    fn a_value_is_made_once_and_an_absent_one_is_asked_for_again() {
        let kept: Kept<u32, u32> = Kept::new(1 << 20);
        let made = AtomicUsize::new(0);
        let ask = |key: u32| {
            kept.get(&key, || {
                made.fetch_add(1, Ordering::Relaxed);
                std::thread::sleep(std::time::Duration::from_millis(20));
                (key > 0).then_some((key, 1))
            })
        };
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| assert_eq!(ask(1).as_deref(), Some(&1)));
            }
        });
        assert_eq!(made.load(Ordering::Relaxed), 1);
        assert_eq!([ask(0), ask(0)], [None, None]);
        assert_eq!(made.load(Ordering::Relaxed), 3);
    }
}
