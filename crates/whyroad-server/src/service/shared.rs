//! Shares one read among concurrent requests: a slow read that many request, such as a dashboard, runs once at a time.

use crate::problem::Answer;
use crate::sync::lock;
use std::collections::HashMap;
use std::sync::{Arc, Condvar, Mutex, PoisonError};

/// Reads by key, one at a time each. No caller gets a result whose read began before their request.
pub struct SharedReadings<T> {
    by_key: Mutex<HashMap<String, Arc<OneAtATime<T>>>>,
}

struct OneAtATime<T> {
    turn: Mutex<Turn<T>>,
    ended: Condvar,
}

struct Turn<T> {
    /// Number of the newest read that has begun.
    begun: u64,
    running: bool,
    /// Number of callers that wait for a read.
    waiting: usize,
    /// The newest finished read, with its number; kept while a caller waits.
    last: Option<(u64, Answer<Arc<T>>)>,
}

impl<T> Default for SharedReadings<T> {
    fn default() -> Self {
        Self { by_key: Mutex::default() }
    }
}

impl<T> SharedReadings<T> {
    /// The result of `read` for `key`: of this call, or of another one that began after this one.
    ///
    /// # Errors
    /// Those of `read`.
    pub fn get(&self, key: &str, read: impl FnOnce() -> Answer<T>) -> Answer<Arc<T>> {
        let one = Arc::clone(lock(&self.by_key).entry(key.to_owned()).or_default());
        one.get(read)
    }
}

impl<T> Default for OneAtATime<T> {
    fn default() -> Self {
        let turn = Turn { begun: 0, running: false, waiting: 0, last: None };
        Self { turn: Mutex::new(turn), ended: Condvar::new() }
    }
}

impl<T> OneAtATime<T> {
    fn get(&self, read: impl FnOnce() -> Answer<T>) -> Answer<Arc<T>> {
        let mut turn = lock(&self.turn);
        let enough = turn.begun + 1;
        turn.waiting += 1;
        loop {
            if let Some((number, answer)) = &turn.last
                && *number >= enough
            {
                let answer = answer.clone();
                turn.leave();
                return answer;
            }
            if !turn.running {
                break;
            }
            turn = self.ended.wait(turn).unwrap_or_else(PoisonError::into_inner);
        }
        turn.running = true;
        turn.begun += 1;
        let mut running = Running { of: self, number: turn.begun, answer: None };
        drop(turn);
        let answer = read().map(Arc::new);
        running.answer = Some(answer.clone());
        answer
    }
}

impl<T> Turn<T> {
    fn leave(&mut self) {
        self.waiting -= 1;
        if self.waiting == 0 {
            self.last = None;
        }
    }
}

/// Permits the next read when this one has ended, also by a panic.
struct Running<'a, T> {
    of: &'a OneAtATime<T>,
    number: u64,
    answer: Option<Answer<Arc<T>>>,
}

impl<T> Drop for Running<'_, T> {
    fn drop(&mut self) {
        let mut turn = lock(&self.of.turn);
        turn.running = false;
        if let Some(answer) = self.answer.take() {
            turn.last = Some((self.number, answer));
        }
        turn.leave();
        self.of.ended.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Problem;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::mpsc::channel;
    use std::time::Duration;

    /// A caller during a read gets the result of the next one, because the current one began before their request.
    #[test]
    fn who_asks_during_a_reading_shares_the_next_one() {
        let (shared, readings) = (SharedReadings::default(), AtomicUsize::new(0));
        let (begun, has_begun) = channel();
        let (go_on, may_go_on) = channel::<()>();
        std::thread::scope(|scope| {
            let (shared, readings) = (&shared, &readings);
            let first = scope.spawn(move || {
                shared.get("p", || {
                    begun.send(()).unwrap();
                    may_go_on.recv().unwrap();
                    Ok(readings.fetch_add(1, Ordering::SeqCst))
                })
            });
            has_begun.recv().unwrap();
            let later: Vec<_> = (0..8)
                .map(|_| scope.spawn(move || shared.get("p", || Ok(readings.fetch_add(1, Ordering::SeqCst)))))
                .collect();
            let waiting = || lock(&lock(&shared.by_key)["p"].turn).waiting;
            while waiting() < 9 {
                std::thread::sleep(Duration::from_millis(1));
            }
            go_on.send(()).unwrap();
            assert_eq!(*first.join().unwrap().unwrap(), 0);
            for one in later {
                assert_eq!(*one.join().unwrap().unwrap(), 1);
            }
        });
        assert_eq!(readings.load(Ordering::SeqCst), 2);
        // Nobody waits: nothing is kept, and the next caller reads.
        assert!(lock(&lock(&shared.by_key)["p"].turn).last.is_none());
        assert_eq!(*shared.get("p", || Ok(7)).unwrap(), 7);
        assert_eq!(*shared.get("q", || Ok(8)).unwrap(), 8);
    }

    #[test]
    fn a_failure_and_a_panic_keep_nobody_waiting() {
        let shared = SharedReadings::<u8>::default();
        assert_eq!(shared.get("p", || Err(Problem::missing())).unwrap_err().code, Problem::missing().code);
        let died = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            shared.get("p", || panic!("on purpose"))
        }));
        assert!(died.is_err());
        assert_eq!(*shared.get("p", || Ok(1)).unwrap(), 1);
    }
}
