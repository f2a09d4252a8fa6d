//! `serve/mixed`: a labeling day in one process. 200 annotators save a change every second, 20 dashboards are read
//! every second, and exports run one after another; the service and its clients share the machine. On SQLite.
//!
//! `cargo bench -p whyroad-server --bench mixed -- [--seconds 30] [--annotators 200] [--dashboards 20] [--tasks 2000]`.
//! Prints the times of each kind of call and the memory of the process; with `--limit-ms 100` it fails when a save
//! takes longer at p99. For a soak test run it for an hour (`.ci/soak`): memory is printed every minute, and with
//! `--growth-percent 15` it fails when the process has grown by more since the first tenth of the time.

#![allow(clippy::unwrap_used, reason = "a bench says what went wrong by failing")]
#![allow(clippy::print_stdout, reason = "a bench prints its figures")]

#[allow(dead_code, reason = "shared with the tests")]
#[path = "../tests/it/recorded.rs"]
mod recorded;
#[allow(dead_code, reason = "shared with the tests")]
#[path = "../tests/it/world.rs"]
mod world;

use recorded::Future;
use serde_json::{Value, json};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use world::{Person, World};

/// The number after `name` among the arguments.
fn argument(name: &str, usual: u64) -> u64 {
    let all: Vec<String> = std::env::args().collect();
    let at = all.iter().position(|a| a == name);
    at.and_then(|i| all.get(i + 1)).map_or(usual, |text| text.parse().expect("a number"))
}

/// Times of one kind of call, ms.
struct Times(Mutex<Vec<f64>>);

impl Times {
    /// Allocates and touches memory for `calls`, so that the list itself does not grow during a soak test.
    fn of(calls: u64) -> Self {
        let mut all = vec![f64::NAN; calls as usize];
        all.clear();
        Self(Mutex::new(all))
    }

    fn measure<T>(&self, work: impl FnOnce() -> T) -> T {
        let begun = Instant::now();
        let out = work();
        self.0.lock().unwrap().push(begun.elapsed().as_secs_f64() * 1e3);
        out
    }

    /// Number, median, 99th percentile and maximum, ms.
    fn figures(&self) -> (usize, f64, f64, f64) {
        let mut all = self.0.lock().unwrap().clone();
        all.sort_by(f64::total_cmp);
        let at = |share: f64| {
            all.get(((all.len() as f64 * share) as usize).min(all.len().saturating_sub(1))).copied()
        };
        (
            all.len(),
            at(0.5).unwrap_or(f64::NAN),
            at(0.99).unwrap_or(f64::NAN),
            all.last().copied().unwrap_or(f64::NAN),
        )
    }
}

/// Memory of this process in MB, if the system reports it.
fn memory_mb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:"))?;
    line.trim().trim_end_matches("kB").trim().parse::<u64>().ok().map(|kb| kb / 1024)
}

/// An annotator with their task.
struct Hand {
    who: Person,
    task: String,
    fence: i64,
    version: i64,
}

impl Hand {
    fn save(&mut self, n: u64) {
        let text = format!("前方左侧轿车正在压线切入本车道，第 {n} 次修改");
        let change = json!({
            "fence": self.fence, "base_version": self.version,
            "changes": [{ "path": "/critical_components/0/description", "value": text }],
        });
        let saved = self.who.patch(&format!("/tasks/{}/draft", self.task), &change).fine();
        self.version = saved["version"].as_i64().unwrap();
    }
}

fn main() {
    whyroad_server::memory::limit_arenas();
    let seconds = argument("--seconds", 30);
    let (annotators, dashboards, tasks) =
        (argument("--annotators", 200), argument("--dashboards", 20), argument("--tasks", 2000).max(200));
    let (limit_ms, growth) = (argument("--limit-ms", 0), argument("--growth-percent", 0));
    // After the first tenth, everything that is loaded once has been loaded.
    let warm = Mutex::new(None);
    let world = World::on_sqlite(Future::Brakes);
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({ "lease_s": 3600 }));
    let names: Vec<String> = (0..tasks.max(annotators)).map(|n| format!("drive{n}")).collect();
    let begun = Instant::now();
    for part in names.chunks(500) {
        let part: Vec<&str> = part.iter().map(String::as_str).collect();
        world.tasks(&admin, &project, &part, 1);
    }
    println!("serve/create/{}: {:.2} s", names.len(), begun.elapsed().as_secs_f64());
    let pending = || admin.get(&format!("/projects/{project}/work")).fine()["pending"].as_i64().unwrap();
    while pending() > 0 {
        std::thread::sleep(Duration::from_millis(200));
    }
    println!("serve/draft/{}: {:.2} s with the above", names.len(), begun.elapsed().as_secs_f64());
    let mut hands = Vec::new();
    for n in 0..annotators {
        let who = world.person(&admin, &project, &format!("ann{n}"), &["annotator"]);
        let t: Value =
            who.post(&format!("/projects/{project}/tasks:next"), &json!({ "kind": "label" })).fine();
        hands.push(Hand {
            who,
            task: t["task"]["id"].as_str().unwrap().to_owned(),
            fence: t["fence"].as_i64().unwrap(),
            version: t["version"].as_i64().unwrap(),
        });
    }
    println!("{annotators} annotators hold a task each; memory {:?} MB", memory_mb());
    let (saves, boards, exports) =
        (Times::of(seconds * annotators), Times::of(seconds * dashboards), Times::of(seconds));
    let stop = AtomicBool::new(false);
    let ends = Instant::now() + Duration::from_secs(seconds);
    std::thread::scope(|scope| {
        for (n, mut hand) in hands.into_iter().enumerate() {
            let saves = &saves;
            scope.spawn(move || {
                // Distributed over the second, as people are.
                std::thread::sleep(Duration::from_millis(n as u64 * 1000 / annotators));
                let mut due = Instant::now();
                let mut round = 0;
                while Instant::now() < ends {
                    saves.measure(|| hand.save(round));
                    round += 1;
                    due += Duration::from_secs(1);
                    std::thread::sleep(due.saturating_duration_since(Instant::now()));
                }
            });
        }
        for n in 0..dashboards {
            let (admin, project, boards) = (&admin, &project, &boards);
            scope.spawn(move || {
                std::thread::sleep(Duration::from_millis(n * 1000 / dashboards.max(1)));
                while Instant::now() < ends {
                    let next = Instant::now() + Duration::from_secs(1);
                    boards.measure(|| admin.get(&format!("/projects/{project}/dashboard")).fine());
                    std::thread::sleep(next.saturating_duration_since(Instant::now()));
                }
            });
        }
        scope.spawn(|| {
            while Instant::now() < ends {
                // Not kept: an export contains the whole history, which grows, and is not memory of the service.
                let lines =
                    exports.measure(|| admin.lines(&format!("/projects/{project}/export?format=tasks")));
                assert_eq!(lines, names.len());
            }
        });
        scope.spawn(|| {
            std::thread::sleep(Duration::from_secs(seconds) / 10);
            *warm.lock().unwrap() = memory_mb();
        });
        scope.spawn(|| {
            let mut minute = 0;
            while !stop.load(Ordering::Relaxed) && Instant::now() < ends {
                std::thread::sleep(
                    Duration::from_secs(60).min(ends.saturating_duration_since(Instant::now())),
                );
                minute += 1;
                println!("  minute {minute}: memory {:?} MB", memory_mb());
            }
        });
    });
    stop.store(true, Ordering::Relaxed);
    let (before, after) = (*warm.lock().unwrap(), memory_mb());
    for (name, times) in [("save", &saves), ("dashboard", &boards), ("export", &exports)] {
        let (n, median, p99, most) = times.figures();
        println!("serve/mixed/{name}: {n} calls, p50 {median:.1} ms, p99 {p99:.1} ms, longest {most:.1} ms");
    }
    println!("memory after the first tenth: {before:?} MB, at the end: {after:?} MB");
    if growth > 0 && before.zip(after).is_some_and(|(b, a)| a * 100 > b * (100 + growth)) {
        println!("it grew by more than {growth} %");
        std::process::exit(1);
    }
    let (_, _, p99, _) = saves.figures();
    if limit_ms > 0 && p99 > limit_ms as f64 {
        println!("p99 of a save is over {limit_ms} ms");
        std::process::exit(1);
    }
}
