//! What may befall the labeling service, done to the real one: after each, every acknowledged change is there and no
//! task is held twice.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::print_stdout)] // in a test a panic is the report, and a skip is said

use crate::service::http::Client;
use crate::service::storm::{Annotator, Progress};
use crate::service::{Service, crew};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Annotators of a storm.
const PEOPLE: usize = 6;

/// All of them save as fast as they can while `fault` runs, which is told how far each has come; a refusal or a broken
/// connection ends one's storm.
fn storm(crew: &mut [Annotator], fault: impl FnOnce(&[Arc<Progress>])) {
    let stop = AtomicBool::new(false);
    let progress: Vec<Arc<Progress>> = crew.iter().map(|a| Arc::clone(&a.progress)).collect();
    std::thread::scope(|scope| {
        for annotator in crew.iter_mut() {
            scope.spawn(|| annotator.save_until(&stop, Duration::ZERO));
        }
        fault(&progress);
        stop.store(true, Ordering::Relaxed);
    });
}

/// Waits, however slow the machine is, until each has saved `n` more changes since `crew` was as in `before`, or was
/// refused one since.
fn each_saves(crew: &[Arc<Progress>], before: &[(u64, u64)], n: u64) {
    let on = |(p, (saved, refused)): (&Arc<Progress>, &(u64, u64))| {
        p.saved() >= saved + n || p.refused() > *refused
    };
    wait_for(|| crew.iter().zip(before).all(on));
}

/// Changes saved and refused so far.
fn so_far(crew: &[Arc<Progress>]) -> Vec<(u64, u64)> {
    crew.iter().map(|p| (p.saved(), p.refused())).collect()
}

fn wait_for(done: impl Fn() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(120), "it did not come about in two minutes");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Each annotator finds what was acknowledged, or the one change that was on its way; each task has one holder.
#[track_caller]
fn nothing_is_lost(admin: &mut Client, project: &str, crew: &mut [Annotator]) {
    for a in crew.iter_mut() {
        let stored = a.stored();
        assert!(
            stored == a.saved || stored == a.sent,
            "stored {stored}, acknowledged {}, sent {}",
            a.saved,
            a.sent
        );
        // Before the lock the history is the author's alone.
        let answer = a.client.get(&format!("/tasks/{}/history", a.task)).good();
        let entries = answer["items"].as_array().unwrap();
        let takes = entries.iter().filter(|e| e["action"] == "take").count();
        assert_eq!(takes, 1, "{entries:?}");
        // Append-only and without a gap: each acknowledged change has its entry.
        let numbers: Vec<i64> = entries.iter().map(|e| e["seq"].as_i64().unwrap()).collect();
        assert_eq!(numbers, (2..2 + entries.len() as i64).collect::<Vec<_>>(), "1 is its making");
        assert!(entries.iter().filter(|e| e["action"] == "edit").count() as u64 >= a.saved);
    }
    let list = admin.get(&format!("/projects/{project}/tasks?state=stage1&limit=200")).good();
    let mut holders: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for task in list["items"].as_array().unwrap() {
        let text = |v: &Value| v.as_str().unwrap().to_owned();
        holders.entry(text(&task["assigned_to"])).or_default().push(text(&task["id"]));
    }
    assert_eq!(holders.len(), crew.len());
    assert!(holders.values().all(|tasks| tasks.len() == 1), "{holders:?}");
}

#[test]
fn kill_9_in_an_autosave_storm_loses_nothing_that_was_acknowledged() {
    let data = tempfile::tempdir().unwrap();
    let arguments = ["--data", data.path().to_str().unwrap()];
    let service = Service::start(&arguments);
    let (_, project, mut crew) = crew(service.at, PEOPLE);
    let mut service = Some(service);
    for round in 0..3 {
        storm(&mut crew, |progress| {
            each_saves(progress, &so_far(progress), 5 + 3 * round);
            service.take().unwrap().kill();
        });
        assert!(
            crew.iter().all(|a| a.saved > 0 && a.refused.is_empty()),
            "each was heard before the service died"
        );
        let again = Service::start(&arguments);
        let mut admin = Client::sign_in(again.at, "admin");
        crew.iter_mut().for_each(|a| a.client.move_to(again.at));
        nothing_is_lost(&mut admin, &project, &mut crew);
        // They go on where they were: same token, same lease, the draft as it is now.
        for a in &mut crew {
            let task = a.client.get(&format!("/tasks/{}", a.task)).good();
            assert_eq!(task["fence"].as_i64(), Some(a.fence), "the lease outlives the service");
            a.version = task["version"].as_i64().unwrap();
            assert!(a.save());
        }
        service = Some(again);
    }
}

#[test]
fn a_full_disk_is_told_and_what_was_saved_before_stays() {
    let dir = tempfile::tempdir().unwrap();
    let Some(disk) = SmallDisk::mount(dir.path()) else {
        crate::require::skipped("root", "a small disk can be mounted only as root");
        return;
    };
    let service = Service::start(&["--data", disk.0.to_str().unwrap()]);
    let (mut admin, project, mut crew) = crew(service.at, PEOPLE);
    storm(&mut crew, |progress| each_saves(progress, &so_far(progress), 3));
    // Fill what is left.
    let filler = disk.0.join("filler");
    let mut file = std::fs::File::create(&filler).unwrap();
    while file.write_all(&[0; 4096]).is_ok() {}
    while file.write_all(&[0; 1]).is_ok() {}
    storm(&mut crew, |progress| wait_for(|| progress.iter().all(|p| p.refused() > 0)));
    for a in &crew {
        let told = a.refused.last().expect("a full disk is told");
        assert!(told.starts_with("507 ") && told.contains("store.full"), "{told}");
    }
    nothing_is_lost(&mut admin, &project, &mut crew);
    drop(file);
    std::fs::remove_file(&filler).unwrap();
    assert!(crew.iter_mut().all(Annotator::save), "it goes on as soon as there is room");
    nothing_is_lost(&mut admin, &project, &mut crew);
}

/// A file system of a few megabytes in memory.
struct SmallDisk(std::path::PathBuf);

impl SmallDisk {
    fn mount(at: &Path) -> Option<Self> {
        let done =
            Command::new("mount").args(["-t", "tmpfs", "-o", "size=6m", "none"]).arg(at).output().ok()?;
        let disk = done.status.success().then(|| Self(at.to_owned()))?;
        // In some containers the mount is told to be there and is not, or cannot be written.
        let mounts = std::fs::read_to_string("/proc/mounts").ok()?;
        let real = at.canonicalize().ok()?;
        let there = mounts.lines().any(|l| l.split(' ').nth(1).is_some_and(|p| Path::new(p) == real));
        (there && std::fs::write(at.join("try"), "x").is_ok()).then_some(disk)
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg("-l").arg(&self.0).output();
    }
}

#[test]
fn a_database_that_restarts_is_waited_for() {
    let Some(mut server) = crate::postgres::Server::start() else { return };
    let data = tempfile::tempdir().unwrap();
    let service = Service::start(&["--store", &server.database(), "--data", data.path().to_str().unwrap()]);
    let (mut admin, project, mut crew) = crew(service.at, PEOPLE);
    for _ in 0..2 {
        storm(&mut crew, |progress| {
            let before = so_far(progress);
            each_saves(progress, &before, 3);
            server.restart(Duration::from_millis(800));
            each_saves(progress, &before, 9);
        });
        nothing_is_lost(&mut admin, &project, &mut crew);
        // Who was cut off in the middle of a commit was told so, and goes on after one look.
        for a in &mut crew {
            let unsure = a.refused.drain(..).all(|r| r.starts_with("503 "));
            assert!(unsure);
            let task = a.client.get(&format!("/tasks/{}", a.task)).good();
            a.version = task["version"].as_i64().unwrap();
            assert!(a.save(), "{:?}", a.refused);
        }
    }
}

#[test]
fn slow_clients_do_not_hold_up_the_others() {
    let data = tempfile::tempdir().unwrap();
    let service = Service::start(&["--data", data.path().to_str().unwrap()]);
    let (_, _, mut crew) = crew(service.at, PEOPLE);
    let at = service.at;
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        // A hundred who send a request byte by byte and never come to its end, and ten who never read the answers.
        scope.spawn(|| {
            let mut slow: Vec<TcpStream> = (0..110).map(|_| TcpStream::connect(at).unwrap()).collect();
            let head = b"POST /api/v1/session HTTP/1.1\r\nhost: x\r\ncontent-length: 4000\r\n\r\n{";
            for deaf in &mut slow[100..] {
                let _ = deaf.write_all(&b"GET /page.js HTTP/1.1\r\nhost: x\r\n\r\n".repeat(10));
            }
            for i in 0.. {
                if stop.load(Ordering::Relaxed) {
                    break;
                }
                for stream in &mut slow[..100] {
                    let _ = stream.write_all(&[head.get(i).copied().unwrap_or(b' ')]);
                }
                std::thread::sleep(Duration::from_millis(100));
            }
        });
        std::thread::sleep(Duration::from_millis(500));
        for a in &mut crew {
            for _ in 0..5 {
                assert!(a.save(), "{:?}", a.refused);
            }
        }
        stop.store(true, Ordering::Relaxed);
    });
    let slowest = crew.iter().flat_map(|a| &a.seconds).copied().fold(0.0, f64::max);
    // No figure of speed: the service gives a silent connection three minutes, so who had to wait for one of these slow
    // ones waited longer than this.
    assert!(slowest < 60.0, "the slowest of {} saves took {slowest} s", PEOPLE * 5);
}

#[test]
fn a_service_told_to_stop_finishes_what_it_has_begun() {
    let data = tempfile::tempdir().unwrap();
    let arguments = ["--data", data.path().to_str().unwrap()];
    let service = Service::start(&arguments);
    let (_, project, mut crew) = crew(service.at, PEOPLE);
    let pid = service.pid().to_string();
    let mut service = Some(service);
    storm(&mut crew, |progress| {
        each_saves(progress, &so_far(progress), 5);
        assert!(Command::new("kill").args(["-TERM", &pid]).status().unwrap().success());
        let ended = service.take().unwrap().wait();
        assert!(ended.success(), "{ended}");
    });
    let again = Service::start(&arguments);
    let mut admin = Client::sign_in(again.at, "admin");
    crew.iter_mut().for_each(|a| a.client.move_to(again.at));
    nothing_is_lost(&mut admin, &project, &mut crew);
}

#[test]
fn a_service_on_postgresql_ends_well_on_either_signal() {
    let Some(server) = crate::postgres::Server::start() else { return };
    for signal in ["-TERM", "-INT"] {
        let data = tempfile::tempdir().unwrap();
        let arguments = ["--store", &server.database(), "--data", data.path().to_str().unwrap()];
        let service = Service::start(&arguments);
        let mut admin = Client::set_up(service.at, "admin");
        assert_eq!(admin.get("/projects").status, 200);
        let begun = Instant::now();
        let pid = service.pid().to_string();
        assert!(Command::new("kill").args([signal, &pid]).status().unwrap().success());
        // A panic would end it with 101.
        let ended = service.wait();
        assert!(ended.success(), "{signal}: {ended}");
        assert!(begun.elapsed() < Duration::from_secs(20), "{signal}: {:?}", begun.elapsed());
    }
}

#[test]
fn two_services_on_one_address_are_told_apart() {
    let data = tempfile::tempdir().unwrap();
    let service = Service::start(&["--data", data.path().to_str().unwrap()]);
    let second = Command::new(env!("CARGO_BIN_EXE_whyroad"))
        .args(["serve", "--listen", &service.at.to_string(), "--lake"])
        .arg(crate::service::demo().join("lake"))
        .arg("--data")
        .arg(data.path())
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&second.stderr);
    assert_eq!(second.status.code(), Some(1));
    assert!(told.contains("cannot listen on 127.0.0.1:"), "{told}");
    // The first one is none the worse for it.
    let mut stream = TcpStream::connect(service.at).unwrap();
    stream.write_all(b"GET /api/v1/healthz HTTP/1.1\r\nhost: x\r\nconnection: close\r\n\r\n").unwrap();
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    assert!(text.starts_with("HTTP/1.1 200"), "{text}");
    assert_eq!(
        serde_json::from_str::<Value>(text.split("\r\n\r\n").nth(1).unwrap()).unwrap(),
        json!({"done": true})
    );
}
