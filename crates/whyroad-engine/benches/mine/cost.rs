//! What a call costs: seconds on the clock, and seconds of all processors.

use super::cpu::cpu_seconds;
use std::fmt;
use std::hint::black_box;
use std::time::Instant;

/// Seconds on the clock, and of all processors (NaN where the system does not tell).
#[derive(Clone, Copy)]
pub struct Cost {
    /// On the clock.
    pub seconds: f64,
    /// Of all processors.
    pub cpu: f64,
}

impl Cost {
    /// Worse than any.
    pub const WORST: Cost = Cost { seconds: f64::INFINITY, cpu: f64::INFINITY };

    /// The lesser of each of the two.
    pub fn least(self, other: Cost) -> Cost {
        Cost { seconds: self.seconds.min(other.seconds), cpu: self.cpu.min(other.cpu) }
    }
}

impl fmt::Display for Cost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.4} s", self.seconds)?;
        if self.cpu.is_finite() { write!(f, " (CPU {:.4} s)", self.cpu) } else { Ok(()) }
    }
}

/// What a call costs, and gives.
pub fn timed<T>(f: impl FnOnce() -> T) -> (Cost, T) {
    let (cpu, start) = (cpu_seconds(), Instant::now());
    let out = black_box(f());
    let seconds = start.elapsed().as_secs_f64();
    (Cost { seconds, cpu: cpu_seconds() - cpu }, out)
}
