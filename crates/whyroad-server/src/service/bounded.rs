//! A question to something that may hang, a database or a network file system, with a bound on the time that it is
//! waited for. One thread asks at a time, however many ask for the answer: what hangs for hours holds one thread, not
//! one for each probe.

use crate::sync::lock;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Instant;

/// The answers to one question.
pub(crate) struct Bounded<T> {
    state: Mutex<State<T>>,
    answered: Condvar,
}

struct State<T> {
    /// A thread is asking.
    asking: bool,
    /// Number of answers so far.
    answers: u64,
    /// The last answer; `None` where its thread failed.
    last: Option<T>,
}

/// The number of the answer to wait for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn(u64);

impl<T> Default for Bounded<T> {
    fn default() -> Self {
        Self { state: Mutex::new(State { asking: false, answers: 0, last: None }), answered: Condvar::new() }
    }
}

impl<T: Clone + Send + 'static> Bounded<T> {
    /// Asks on a separate thread, unless the question is already being asked.
    pub(crate) fn ask(self: &Arc<Self>, question: impl FnOnce() -> T + Send + 'static) -> Turn {
        let mut state = lock(&self.state);
        let turn = Turn(state.answers + 1);
        if !state.asking {
            state.asking = true;
            let given = Given { to: Arc::clone(self), answer: None };
            let thread = std::thread::Builder::new().name("whyroad-probe".to_owned());
            drop(state);
            // Without a thread there is no answer: what was moved into the closure says so when it is dropped.
            let _ = thread.spawn(move || {
                // All of it is moved here, to be dropped here.
                let mut given = given;
                given.answer = Some(question());
            });
        }
        turn
    }

    /// The answer, if there is one by `deadline`.
    pub(crate) fn until(&self, turn: Turn, deadline: Instant) -> Option<T> {
        let state = lock(&self.state);
        let wait = deadline.saturating_duration_since(Instant::now());
        let (state, _) = self
            .answered
            .wait_timeout_while(state, wait, |state| state.answers < turn.0)
            .unwrap_or_else(PoisonError::into_inner);
        state.last.clone().filter(|_| state.answers >= turn.0)
    }
}

/// Reports the answer when it is dropped, also by a panic.
struct Given<T> {
    to: Arc<Bounded<T>>,
    answer: Option<T>,
}

impl<T> Drop for Given<T> {
    fn drop(&mut self) {
        let mut state = lock(&self.to.state);
        state.asking = false;
        state.answers += 1;
        state.last = self.answer.take();
        drop(state);
        self.to.answered.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::mpsc::channel;
    use std::time::Duration;

    fn soon() -> Instant {
        Instant::now() + Duration::from_millis(50)
    }

    fn later() -> Instant {
        Instant::now() + Duration::from_secs(30)
    }

    #[test]
    fn what_hangs_is_asked_once_and_answers_when_it_goes_on() {
        let bounded = Arc::new(Bounded::default());
        let (asked, (go, wait)) = (Arc::new(AtomicUsize::new(0)), channel::<()>());
        let count = Arc::clone(&asked);
        let first = bounded.ask(move || {
            count.fetch_add(1, Ordering::SeqCst);
            wait.recv().unwrap();
            7
        });
        assert_eq!(bounded.until(first, soon()), None);
        for _ in 0..5 {
            let turn = bounded.ask(|| 8);
            assert_eq!(bounded.until(turn, Instant::now()), None);
        }
        go.send(()).unwrap();
        assert_eq!(bounded.until(first, later()), Some(7));
        assert_eq!(asked.load(Ordering::SeqCst), 1);
        let next = bounded.ask(|| 9);
        assert_eq!(bounded.until(next, later()), Some(9));
    }

    #[test]
    fn a_question_that_panics_has_no_answer_and_is_asked_again() {
        let bounded = Arc::new(Bounded::default());
        let turn = bounded.ask(|| -> u8 { panic!("for the test") });
        assert_eq!(bounded.until(turn, later()), None);
        let turn = bounded.ask(|| 2);
        assert_eq!(bounded.until(turn, later()), Some(2));
    }
}
