//! Runs targets: mutates, executes, watches time, and reports what broke with the input that did it.

use crate::mutate::{Random, mutate};
use std::cell::RefCell;
use std::fs;
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Once};
use std::thread;
use std::time::{Duration, Instant};

/// Longest time that one input of a few kilobytes may take, also without optimisation.
pub const SLOW: Duration = Duration::from_secs(10);
/// After this time an execution counts as endless.
const ENDLESS: Duration = Duration::from_secs(60);
/// Inputs do not grow beyond this.
const MAX_BYTES: usize = 1 << 20;

/// Reads bytes; what it makes of them is dropped.
pub type Parser = Box<dyn Fn(&[u8])>;

/// A parser of untrusted bytes.
pub struct Target {
    /// Name on the command line.
    pub name: String,
    /// Inputs that the parser accepts.
    pub seeds: Vec<Vec<u8>>,
    /// Repairs checksums after a mutation, so that the bytes behind them are reached.
    pub repair: fn(&mut Vec<u8>),
    /// The parser.
    pub run: Parser,
}

/// How long a target is run.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// Maximum number of executions.
    pub executions: u64,
    /// Maximum time.
    pub time: Duration,
}

/// What a run did.
#[derive(Debug)]
pub struct Outcome {
    /// Inputs that were tried.
    pub executions: u64,
    /// Inputs that broke the parser: number of the execution, and what happened.
    pub failures: Vec<(u64, String)>,
}

thread_local! {
    static LAST_PANIC: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Panics of targets are results, not messages.
fn quiet_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            LAST_PANIC.with(|last| *last.borrow_mut() = info.to_string());
            if thread::current().name().is_some_and(|n| n == "main") {
                return;
            }
            if !RUNNING.with(|r| *r.borrow()) {
                usual(info);
            }
        }));
    });
}

thread_local! {
    static RUNNING: RefCell<bool> = const { RefCell::new(false) };
}

/// Runs `target`; the input at work is kept in `folder`, so that it is there even if the process is ended.
pub fn run(target: &Target, seed: u64, limit: Limit, folder: &Path) -> Outcome {
    quiet_panics();
    let current = folder.join(format!("{}.input", target.name));
    let begun = Arc::new(AtomicU64::new(0));
    let start = Instant::now();
    watch(&target.name, start, Arc::clone(&begun));
    let mut random = Random::new(seed);
    let mut outcome = Outcome { executions: 0, failures: Vec::new() };
    let count = target.seeds.len() as u64;
    while outcome.executions < limit.executions.max(count) && start.elapsed() < limit.time {
        let mut input = target.seeds[random.below(target.seeds.len())].clone();
        // The seeds themselves come first.
        if outcome.executions < count {
            input.clone_from(&target.seeds[outcome.executions as usize]);
        } else {
            let other = &target.seeds[random.below(target.seeds.len())];
            mutate(&mut random, &mut input, other);
            input.truncate(MAX_BYTES);
            (target.repair)(&mut input);
        }
        let _ = fs::write(&current, &input);
        begun.store(start.elapsed().as_millis() as u64 + 1, Ordering::Relaxed);
        let from = Instant::now();
        RUNNING.with(|r| *r.borrow_mut() = true);
        let result = panic::catch_unwind(AssertUnwindSafe(|| (target.run)(&input)));
        RUNNING.with(|r| *r.borrow_mut() = false);
        begun.store(0, Ordering::Relaxed);
        let failure = match result {
            Err(_) => Some(LAST_PANIC.with(|last| last.borrow().clone())),
            Ok(()) if from.elapsed() > SLOW => Some(format!("took {:.1} s", from.elapsed().as_secs_f64())),
            Ok(()) => None,
        };
        if let Some(what) = failure {
            keep(folder, &target.name, outcome.executions, &input);
            outcome.failures.push((outcome.executions, what));
            if outcome.failures.len() >= 20 {
                break;
            }
        }
        outcome.executions += 1;
    }
    begun.store(u64::MAX, Ordering::Relaxed);
    let _ = fs::remove_file(current);
    outcome
}

fn keep(folder: &Path, target: &str, execution: u64, input: &[u8]) {
    let path: PathBuf = folder.join(format!("{target}.{execution}.failure"));
    let _ = fs::write(path, input);
}

/// Ends the process when one execution does not return.
fn watch(name: &str, start: Instant, begun: Arc<AtomicU64>) {
    let name = name.to_owned();
    thread::spawn(move || {
        loop {
            thread::sleep(Duration::from_millis(500));
            match begun.load(Ordering::Relaxed) {
                u64::MAX => return,
                0 => {}
                since if start.elapsed().as_millis() as u64 > since + ENDLESS.as_millis() as u64 => {
                    use std::io::Write as _;
                    let _ = writeln!(std::io::stderr(), "{name}: endless; the input is {name}.input");
                    std::process::exit(101);
                }
                _ => {}
            }
        }
    });
}
