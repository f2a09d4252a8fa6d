//! Runs targets: mutates, executes, watches time, and reports what broke with the input that did it. The input of an
//! execution follows from the seed and its number alone, so a run can be continued, and an input that ended the process
//! is made again from the number that the [`Progress`] file has.

mod clock;
mod progress;

use crate::mutate::{Random, mutate};
use clock::ThreadClock;
pub use progress::Begin;
use progress::Progress;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs;
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Once};
use std::thread;
use std::time::{Duration, Instant};

/// Longest CPU time that one input of a few kilobytes may take, also without optimisation.
pub const SLOW: Duration = Duration::from_secs(10);
/// After this CPU time an execution counts as endless.
const ENDLESS: Duration = Duration::from_secs(60);
/// Inputs do not grow beyond this.
const MAX_BYTES: usize = 1 << 20;
/// Different failures after which a target is given up.
const MOST_FAILURES: usize = 20;
/// One execution in this many starts from a whole seed, where there are small ones, too.
const WHOLE_SEED_EVERY: usize = 128;
/// Between two looks at the CPU time, which takes as long as a fast execution.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// Between two lines about a run that lasts.
const REPORT_EVERY: Duration = Duration::from_secs(60);

/// Reads bytes; what it makes of them is dropped. True when they can be what it reads.
pub type Parser = Box<dyn Fn(&[u8]) -> bool>;

/// A parser of untrusted bytes.
pub struct Target {
    /// Name on the command line.
    pub name: String,
    /// Inputs that the parser accepts.
    pub seeds: Vec<Vec<u8>>,
    /// The same in small, of a few rows: most executions start from one of these.
    pub small: Vec<Vec<u8>>,
    /// Repairs checksums after a mutation, so that the bytes behind them are reached.
    pub repair: fn(&mut Vec<u8>),
    /// The parser.
    pub run: Parser,
}

/// How long a target is run.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// Maximum number of executions, with those of the run that is continued.
    pub executions: u64,
    /// Maximum time.
    pub time: Duration,
}

/// An input that broke the parser.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// Number of the execution.
    pub execution: u64,
    /// What happened.
    pub what: String,
    /// Inputs of this run that broke it at the same line.
    pub times: u64,
}

/// What a run did.
#[derive(Debug)]
pub struct Outcome {
    /// Inputs that were tried, with those of the run that was continued.
    pub executions: u64,
    /// CPU time of all of them.
    pub spent: Duration,
    /// What broke the parser in this run, once for each line of code.
    pub failures: Vec<Failure>,
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

/// The input of execution `number`: first the seeds themselves, then changed ones.
pub fn input(target: &Target, seed: u64, number: u64) -> Vec<u8> {
    let first = target.small.iter().chain(&target.seeds).nth(usize::try_from(number).unwrap_or(usize::MAX));
    if let Some(first) = first {
        return first.clone();
    }
    let mut random = Random::of_execution(seed, number);
    let whole = target.small.is_empty() || random.below(WHOLE_SEED_EVERY) == 0;
    let seeds = if whole { &target.seeds } else { &target.small };
    let mut input = seeds[random.below(seeds.len())].clone();
    let other = random.below(seeds.len());
    mutate(&mut random, &mut input, &seeds[other]);
    input.truncate(MAX_BYTES);
    (target.repair)(&mut input);
    input
}

/// Runs `target`. How far it is, and inputs that broke it, are in `folder`, also when the process is ended.
pub fn run(target: &Target, seed: u64, limit: Limit, begin: Begin, folder: &Path) -> Outcome {
    quiet_panics();
    let mut failures: BTreeMap<String, Failure> = BTreeMap::new();
    let mut failed = |execution: u64, what: String, input: &[u8]| {
        let line = what.lines().next().unwrap_or_default().to_owned();
        let known = failures.entry(line).or_insert_with(|| {
            let _ = fs::write(folder.join(format!("{}.{execution}.failure", target.name)), input);
            Failure { execution, what, times: 0 }
        });
        known.times += 1;
        failures.len() >= MOST_FAILURES
    };
    let mut progress = Progress::open(folder, &target.name, seed, begin);
    if let Some(fatal) = progress.fatal() {
        let _ = failed(fatal, "ended the process twice".to_owned(), &input(target, seed, fatal));
    }
    let begun = Arc::new(AtomicU64::new(0));
    let start = Instant::now();
    let clock = ThreadClock::new();
    watch(&target.name, clock.clone(), Arc::clone(&begun));
    let mut reported = Instant::now();
    let mut looked = (Instant::now(), clock.time());
    let count = (target.small.len() + target.seeds.len()) as u64;
    while progress.next() < limit.executions.max(count) && start.elapsed() < limit.time {
        let number = progress.next();
        progress.begin();
        let input = input(target, seed, number);
        if looked.0.elapsed() > LOOK_EVERY {
            let now = clock.time();
            progress.spend(now - looked.1);
            looked = (Instant::now(), now);
        }
        // A little earlier than it begins: what came since the last look took less than a tenth of a second.
        let from = looked.1;
        begun.store(from.as_millis() as u64 + 1, Ordering::Relaxed);
        let on_wall = Instant::now();
        RUNNING.with(|r| *r.borrow_mut() = true);
        let result = panic::catch_unwind(AssertUnwindSafe(|| (target.run)(&input)));
        RUNNING.with(|r| *r.borrow_mut() = false);
        begun.store(0, Ordering::Relaxed);
        let what = match result {
            Err(_) => Some(LAST_PANIC.with(|last| last.borrow().clone())),
            Ok(_) if on_wall.elapsed() > SLOW && clock.time() > from + SLOW => {
                Some("took too long".to_owned())
            }
            Ok(_) => None,
        };
        progress.end();
        if what.is_some_and(|what| failed(number, what, &input)) {
            break;
        }
        if reported.elapsed() > REPORT_EVERY {
            reported = Instant::now();
            say(&format!("{}: {} executions", target.name, progress.next()));
        }
    }
    begun.store(u64::MAX, Ordering::Relaxed);
    progress.spend(clock.time() - looked.1);
    progress.write();
    Outcome {
        executions: progress.next(),
        spent: progress.spent(),
        failures: failures.into_values().collect(),
    }
}

/// A line for who watches the run.
fn say(line: &str) {
    use std::io::Write as _;
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Ends the process when one execution does not return.
fn watch(name: &str, clock: ThreadClock, begun: Arc<AtomicU64>) {
    let name = name.to_owned();
    thread::spawn(move || {
        loop {
            thread::sleep(Duration::from_millis(500));
            match begun.load(Ordering::Relaxed) {
                u64::MAX => return,
                0 => {}
                since if clock.time().as_millis() as u64 > since + ENDLESS.as_millis() as u64 => {
                    say(&format!("{name}: endless; --resume names the input"));
                    std::process::exit(101);
                }
                _ => {}
            }
        }
    });
}
