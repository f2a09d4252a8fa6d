//! A lake in S3 as its users meet it: every command against moto, two writers, kills, and a store that fails.

mod media;
mod store;

use crate::session::{Run, root, whyroad_with};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use store::{Fault, Proxy, SECRET, Store, TOKEN};
use tempfile::TempDir;

const LAKE: &str = "s3://fleet/lakes/a";
/// Two small simulations.
const MANY: &str = "crates/whyroad-ingest/tests/fixtures/crossroads.fcd.xml";
const ONE: &str = "examples/drives/back_street";

/// A machine: a folder to work in, a cache, and a way to the store.
struct Machine {
    dir: TempDir,
    environment: Vec<(String, String)>,
}

impl Machine {
    fn new(store: &Store, port: u16) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let environment = store.environment(port, &dir.path().join("cache"));
        Self { dir, environment }
    }

    /// Runs a command; whatever it prints, no secret is in it.
    fn run(&self, args: &[&str]) -> Run {
        let environment: Vec<(&str, &str)> =
            self.environment.iter().map(|(k, v)| (k.as_str(), v.as_str())).collect();
        let run = whyroad_with(self.dir.path(), args, &environment);
        for secret in [SECRET, TOKEN] {
            assert!(!run.out.contains(secret) && !run.err.contains(secret), "{args:?}: {}", run.err);
        }
        run
    }

    fn fine(&self, args: &[&str]) -> String {
        let run = self.run(args);
        assert_eq!(run.code, 0, "{args:?}: {}", run.err);
        run.out
    }

    fn ingest(&self, lake: &str, source: &str) {
        let source = root().join(source);
        self.fine(&["ingest", "sumo", source.to_str().unwrap(), "--lake", lake]);
    }

    /// The drives, by id.
    fn drives(&self, lake: &str) -> Vec<String> {
        let listed = self.fine(&["lake", "list", "--lake", lake]);
        listed.lines().map(|l| l.split('\t').next().unwrap().to_owned()).collect()
    }

    /// The episodes of a mining run, as they are written.
    fn mined(&self, lake: &str, out: &str) -> String {
        let run = self.run(&["mine", "--lake", lake, "--out", out]);
        assert_eq!(run.code, 0, "{}", run.err);
        std::fs::read_to_string(self.dir.path().join(out).join("episodes.jsonl")).unwrap()
    }
}

/// What a lake in a folder gives: drives and episodes.
fn expected(machine: &Machine) -> (Vec<String>, String) {
    machine.ingest("local", MANY);
    machine.ingest("local", ONE);
    (machine.drives("local"), machine.mined("local", "mined-local"))
}

#[test]
fn every_command_takes_the_url() {
    let Some(store) = Store::start() else { return };
    let machine = Machine::new(&store, store.port);
    let (drives, episodes) = expected(&machine);
    assert!(drives.len() > 1 && !episodes.is_empty());

    machine.ingest(LAKE, MANY);
    machine.ingest(LAKE, ONE);
    assert_eq!(machine.drives(LAKE), drives);
    assert_eq!(machine.mined(LAKE, "mined"), episodes);
    assert_eq!(machine.fine(&["inspect", "--lake", LAKE]), machine.fine(&["inspect", "--lake", "local"]));
    machine.fine(&["report", "--lake", LAKE, "--mined", "mined", "--out", "report.html"]);
    assert!(machine.dir.path().join("report.html").metadata().unwrap().len() > 10_000);

    // Signals and results of the first run are in the store: another machine reads them.
    let before = store.objects("lakes/a/");
    assert!(before.iter().any(|(key, _)| key.contains("/signals/targets.")), "{before:?}");
    let other = Machine::new(&store, store.port);
    assert_eq!(other.mined(LAKE, "mined"), episodes);
    // Ingesting again changes nothing, on whatever machine.
    other.ingest(LAKE, MANY);
    assert_eq!(store.objects("lakes/a/"), before);

    machine.fine(&["lake", "compact", "--lake", LAKE]);
    assert_eq!(other.drives(LAKE), drives);
    assert_eq!(other.mined(LAKE, "mined-packed"), episodes);

    let gone = &drives[0];
    machine.fine(&["lake", "delete", gone, "--lake", LAKE, "--mined", "mined"]);
    assert_eq!(other.drives(LAKE), drives[1..]);
    let left = store.objects("lakes/a/");
    assert!(left.iter().all(|(key, _)| !key.contains(&format!("/{gone}/"))), "{left:?}");
    assert!(left.iter().any(|(key, _)| key.contains("deletions.")), "the audit file is in the lake");
    // Everything that is still there is named by the manifest.
    let folder = machine.dir.path().join("cache/open");
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), 0, "no working folder is left");
}

#[test]
fn what_cannot_be_opened_says_why_and_what_to_do() {
    let Some(store) = Store::start() else { return };
    let machine = Machine::new(&store, store.port);
    for (lake, code, says) in [
        ("s3://fleet/none", "lake.not_a_lake", "s3://fleet/none"),
        ("s3://nobucket/x", "lake.storage", "NoSuchBucket"),
        ("s3://AKIA:hunter2SecretAccessKey@fleet/x", "lake.url", "s3://BUCKET/PREFIX"),
        ("gs://fleet/x", "lake.url", "gs://"),
    ] {
        for (lang, args) in [
            ("en", vec!["lake", "list", "--lake", lake]),
            ("zh", vec!["--lang", "zh", "mine", "--lake", lake, "--out", "m"]),
        ] {
            let run = machine.run(&args);
            assert_eq!(run.code, 1, "{lang} {lake}: {}", run.err);
            let shown = run.err.contains(code) && run.err.contains(says);
            assert!(
                shown || (code == "lake.not_a_lake" && run.err.contains(code)),
                "{lang} {lake}: {}",
                run.err
            );
        }
    }
    let source = root().join(ONE);
    let run = machine.run(&["ingest", "sumo", source.to_str().unwrap(), "--lake", "s3://nobucket/x"]);
    assert_eq!(run.code, 1);
    assert!(run.err.contains("lake.storage"), "{}", run.err);
}

#[test]
fn two_processes_that_write_at_once_lose_nothing() {
    let Some(store) = Store::start() else { return };
    let machines = [(); 2].map(|()| Machine::new(&store, store.port));
    let (drives, episodes) = expected(&machines[0]);
    std::thread::scope(|s| {
        s.spawn(|| machines[0].ingest(LAKE, MANY));
        s.spawn(|| machines[1].ingest(LAKE, ONE));
    });
    assert_eq!(machines[1].drives(LAKE), drives);
    // Both store signals and findings of the same drives.
    std::thread::scope(|s| {
        let runs = machines.each_ref().map(|m| s.spawn(|| m.mined(LAKE, "mined")));
        runs.into_iter().for_each(|run| assert_eq!(run.join().unwrap(), episodes));
    });
    assert_eq!(Machine::new(&store, store.port).mined(LAKE, "mined"), episodes);
}

#[test]
fn killed_in_the_middle_of_publishing_the_lake_is_whole() {
    let Some(store) = Store::start() else { return };
    let machine = Machine::new(&store, store.port);
    machine.ingest("local", MANY);
    machine.ingest("local", ONE);
    let all = machine.drives("local");
    machine.ingest(LAKE, ONE);
    let first = machine.drives(LAKE);
    // The number of requests of a whole run.
    let counted = "s3://fleet/lakes/counted";
    machine.ingest(counted, ONE);
    let counting = Proxy::before(&store, |_, _| Fault::Pass);
    Machine::new(&store, counting.port).ingest(counted, MANY);
    let requests = counting.requests.load(Ordering::SeqCst);
    assert!(requests > 8, "{requests}");
    let mut unfinished = 0;
    for at in [1, requests / 4, requests / 2, requests - 3, requests - 2, requests - 1, requests + 9] {
        let hanging = Proxy::before(&store, move |n, _| if n >= at { Fault::Hang } else { Fault::Pass });
        let other = Machine::new(&store, hanging.port);
        let mut child = Command::new(env!("CARGO_BIN_EXE_whyroad"))
            .args(["ingest", "sumo", root().join(MANY).to_str().unwrap(), "--lake", LAKE])
            .current_dir(other.dir.path())
            .envs(other.environment.iter().map(|(k, v)| (k, v)))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let start = Instant::now();
        while hanging.requests.load(Ordering::SeqCst) <= at
            && child.try_wait().unwrap().is_none()
            && start.elapsed() < Duration::from_secs(60)
        {
            std::thread::sleep(Duration::from_millis(20));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let now = machine.drives(LAKE);
        assert!(now == first || now == all, "killed at {at} of {requests}: {now:?}");
        unfinished += usize::from(now == first);
        assert!(now == all || at < requests, "nothing was in its way");
        machine.fine(&["inspect", "--lake", LAKE]);
    }
    assert!(unfinished >= 3, "{unfinished}");
    machine.ingest(LAKE, MANY);
    assert_eq!(machine.drives(LAKE), all);
}

#[test]
fn a_store_that_fails_in_every_way_gives_the_same_episodes() {
    let Some(store) = Store::start() else { return };
    let machine = Machine::new(&store, store.port);
    let (drives, episodes) = expected(&machine);
    let faults = [
        Fault::Status(503),
        Fault::Pass,
        Fault::LoseAnswer,
        Fault::Pass,
        Fault::Pass,
        Fault::Status(500),
        Fault::Refuse,
        Fault::Pass,
        Fault::Delay(Duration::from_millis(700)),
        Fault::CutAnswer,
        Fault::Pass,
        Fault::Status(429),
        Fault::Pass,
    ];
    let failing = Proxy::before(&store, move |n, _| faults[n % faults.len()]);
    let far = Machine::new(&store, failing.port);
    // A command that gives up says so, and is run again: that finishes it.
    let again = |args: &[&str]| {
        let mut runs = (0..5).map(|_| far.run(args));
        let done = runs.find(|run| {
            assert!(run.code == 0 || run.err.contains("lake.storage"), "{args:?}: {}", run.err);
            run.code == 0
        });
        assert!(done.is_some(), "{args:?}");
    };
    for source in [MANY, ONE] {
        again(&["ingest", "sumo", root().join(source).to_str().unwrap(), "--lake", LAKE]);
    }
    assert_eq!(machine.drives(LAKE), drives);
    again(&["mine", "--lake", LAKE, "--out", "mined"]);
    let mined = std::fs::read_to_string(far.dir.path().join("mined/episodes.jsonl")).unwrap();
    assert_eq!(mined, episodes);
    again(&["lake", "compact", "--lake", LAKE]);
    assert_eq!(machine.mined(LAKE, "mined"), episodes);
    assert!(failing.requests.load(Ordering::SeqCst) > 50);
}

#[test]
fn a_store_that_is_down_ends_the_command_with_a_reason() {
    let Some(store) = Store::start() else { return };
    let down = Proxy::before(&store, |_, _| Fault::Status(503));
    let mut machine = Machine::new(&store, down.port);
    machine.environment.push(("AWS_MAX_ATTEMPTS".into(), "3".into()));
    let run = machine.run(&["lake", "list", "--lake", LAKE]);
    assert_eq!(run.code, 1);
    assert!(run.err.contains("SlowDown: not now 503"), "{}", run.err);
}

/// Python blocks of a page, run one after the other with the store's environment.
#[test]
fn the_documented_python_reads_the_lake() {
    let import =
        Command::new(crate::duckdb::python()).args(["-c", "import duckdb, polars, pyarrow"]).output();
    if !import.is_ok_and(|o| o.status.success()) {
        crate::require::skipped("python", "no duckdb, polars or pyarrow");
        return;
    }
    let Some(store) = Store::start() else { return };
    let machine = Machine::new(&store, store.port);
    machine.ingest("s3://fleet/lakes/north", MANY);
    machine.ingest("s3://fleet/lakes/north", ONE);
    let drives = machine.drives("s3://fleet/lakes/north").len();
    for page in ["docs/how-to/object-storage.md", "docs/how-to/object-storage.zh.md"] {
        let text = std::fs::read_to_string(root().join(page)).unwrap();
        let blocks: Vec<&str> =
            text.split("```python\n").skip(1).map(|b| b.split("```").next().unwrap()).collect();
        assert!(blocks.len() >= 3, "{page}");
        let program = format!("{}\nprint('drives', drives)", blocks.join("\n"));
        let out = run_python(&program, &machine.environment, machine.dir.path());
        assert!(out.contains(&format!("drives {drives}")), "{page}: {out}");
    }
}

fn run_python(program: &str, environment: &[(String, String)], dir: &Path) -> String {
    let run = Command::new(crate::duckdb::python())
        .args(["-c", program])
        .envs(environment.iter().map(|(k, v)| (k, v)))
        .current_dir(dir)
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    String::from_utf8(run.stdout).unwrap()
}
