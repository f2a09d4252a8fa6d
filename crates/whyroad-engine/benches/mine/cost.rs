//! What a call costs: seconds on the clock, and seconds of all processors.

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

/// What the threads of this process, all of which live on, have had of the processors so far.
fn cpu_seconds() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let of_task = |task: std::fs::DirEntry| {
        let text = std::fs::read_to_string(task.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    };
    let each: Option<Vec<f64>> = tasks.map(of_task).collect();
    each.filter(|e| !e.is_empty()).map_or(f64::NAN, |e| e.iter().sum::<f64>() / 1e9)
}
