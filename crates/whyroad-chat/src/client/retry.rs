//! When the next request may be sent: evenly spaced by the rate limit, and after a pause where one failed.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Pauses between attempts of one question.
#[derive(Clone, Copy, Debug)]
pub(super) struct Retry {
    pub most: u32,
    pub first: Duration,
    pub longest: Duration,
}

impl Retry {
    /// Pause after `attempts` requests: as the endpoint requests, else doubled each time. `None` when no further
    /// attempt is made, also when the endpoint requests a longer pause than is allowed: an earlier request would be
    /// refused again.
    pub fn pause(&self, attempts: u32, asked: Option<Duration>) -> Option<Duration> {
        if attempts > self.most {
            return None;
        }
        match asked {
            Some(asked) => (asked <= self.longest).then_some(asked),
            None => Some(self.first.saturating_mul(1 << (attempts - 1).min(16)).min(self.longest)),
        }
    }
}

/// Spaces requests evenly, over all threads.
#[derive(Debug)]
pub(super) struct Pace {
    gap: Duration,
    next: Mutex<Option<Instant>>,
}

impl Pace {
    pub fn new(requests_per_minute: Option<u32>) -> Self {
        let gap = requests_per_minute.map_or(Duration::ZERO, |n| Duration::from_secs(60) / n.max(1));
        Self { gap, next: Mutex::default() }
    }

    /// Waits for this request's turn.
    pub fn wait(&self) {
        if self.gap.is_zero() {
            return;
        }
        let now = Instant::now();
        let turn = {
            let mut next = self.next.lock().unwrap_or_else(PoisonError::into_inner);
            let turn = next.map_or(now, |n| n.max(now));
            *next = Some(turn + self.gap);
            turn
        };
        std::thread::sleep(turn.saturating_duration_since(now));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_double_and_end_and_the_endpoint_has_its_say() {
        let retry = Retry { most: 3, first: Duration::from_secs(1), longest: Duration::from_secs(3) };
        let seconds =
            |n, asked: Option<u64>| retry.pause(n, asked.map(Duration::from_secs)).map(|d| d.as_secs());
        assert_eq!([1, 2, 3, 4].map(|n| seconds(n, None)), [Some(1), Some(2), Some(3), None]);
        assert_eq!((seconds(1, Some(2)), seconds(1, Some(4)), seconds(1, Some(0))), (Some(2), None, Some(0)));
    }

    #[test]
    fn requests_are_spaced() {
        // 1200 per minute is one each 50 ms.
        let pace = Pace::new(Some(1200));
        let start = Instant::now();
        (0..4).for_each(|_| pace.wait());
        assert!(start.elapsed() >= Duration::from_millis(150));
    }
}
