//! Two service processes on one PostgreSQL, as behind a proxy: whoever is sent to the one or the other finds the same
//! accounts, tasks, leases and limits; a killed one takes nothing with it.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::postgres::Server;
use crate::service::http::Client;
use crate::service::storm::Annotator;
use crate::service::{Service, annotators, first_project};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Annotators; there are tasks for all of them.
const PEOPLE: usize = 6;

/// Processes on one database and one key file, each with a folder of its own.
struct Processes {
    store: String,
    dir: TempDir,
    running: Vec<Option<Service>>,
}

impl Processes {
    /// Starts two. The key file is made by the first and shared, as an operator copies it to every machine.
    fn start(server: &Server) -> Self {
        let mut all = Self { store: server.database(), dir: tempfile::tempdir().unwrap(), running: vec![] };
        let (first, second) = (all.one(0), all.one(1));
        all.running = vec![Some(first), Some(second)];
        all
    }

    fn one(&self, number: usize) -> Service {
        let (data, key) = (self.dir.path().join(format!("data{number}")), self.dir.path().join("key"));
        let arguments = ["--store", &self.store, "--data", data.to_str().unwrap()];
        Service::start(&[&arguments[..], &["--key-file", key.to_str().unwrap()]].concat())
    }

    fn at(&self, number: usize) -> SocketAddr {
        self.running[number].as_ref().unwrap().at
    }

    fn kill(&mut self, number: usize) {
        self.running[number].take().unwrap().kill();
    }

    fn restart(&mut self, number: usize) {
        self.running[number] = Some(self.one(number));
    }
}

fn give_back(fence: i64) -> Value {
    json!({"action": "release", "fence": fence})
}

fn wait_for(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(120), "not within two minutes: {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn two_services_that_start_at_once_make_one_set_of_tables() {
    let Some(server) = Server::start() else { return };
    let (store, dir) = (server.database(), tempfile::tempdir().unwrap());
    let key = dir.path().join("key");
    // A key as `whyroad` makes it, from a store that is not used.
    drop(Service::start(&["--data", dir.path().to_str().unwrap()]));
    std::fs::copy(dir.path().join("labels.db.key"), &key).unwrap();
    let start = |data: &str| {
        let data = dir.path().join(data);
        let arguments = ["--store", &store, "--data", data.to_str().unwrap()];
        Service::start(&[&arguments[..], &["--key-file", key.to_str().unwrap()]].concat())
    };
    let services: Vec<Service> = std::thread::scope(|scope| {
        let all: Vec<_> = ["a", "b"].map(|data| scope.spawn(move || start(data))).into();
        all.into_iter().map(|s| s.join().unwrap()).collect()
    });
    let mut admin = Client::set_up(services[0].at, "admin");
    admin.move_to(services[1].at);
    let answer = admin.get("/session").good();
    assert_eq!(answer["user"]["name"], "admin", "{answer}");
    // There is one first account, not one per process.
    let mut second = Client::new(services[1].at);
    let account = json!({"name": "other", "display": "other", "password": "a long password"});
    assert_ne!(second.try_to_enter("/setup", &account).status, 200);
}

#[test]
fn leases_hold_across_processes_and_a_killed_one_takes_nothing_with_it() {
    let Some(server) = Server::start() else { return };
    let mut processes = Processes::start(&server);
    let mut admin = Client::set_up(processes.at(0), "admin");
    let project = first_project(&mut admin);
    let tokens = annotators(&mut admin, processes.at(0), &project, 0..PEOPLE);
    // All ask for a task at the same moment, half of them here and half there.
    let mut crew: Vec<Annotator> = std::thread::scope(|scope| {
        let begin = |(i, token): (usize, &String)| {
            let (at, token, project) = (processes.at(i % 2), token.clone(), project.clone());
            scope.spawn(move || Annotator::begin(at, &token, &project))
        };
        let all: Vec<_> = tokens.iter().enumerate().map(begin).collect();
        all.into_iter().map(|a| a.join().unwrap()).collect()
    });
    let tasks: BTreeSet<&str> = crew.iter().map(|a| a.task.as_str()).collect();
    assert_eq!(tasks.len(), PEOPLE, "no task has two holders");

    for killed in [0, 1, 0] {
        let stop = AtomicBool::new(false);
        std::thread::scope(|scope| {
            for a in &mut crew {
                scope.spawn(|| a.save_until(&stop, Duration::ZERO));
            }
            std::thread::sleep(Duration::from_millis(400));
            processes.kill(killed);
            std::thread::sleep(Duration::from_millis(200));
            stop.store(true, Ordering::Relaxed);
        });
        let other = processes.at(1 - killed);
        for a in &mut crew {
            assert!(a.refused.is_empty(), "{:?}", a.refused);
            // The proxy sends everybody to the process that is left: same token, lease and draft.
            a.client.move_to(other);
            let stored = a.stored();
            assert!(stored == a.saved || stored == a.sent, "{stored}, {}, {}", a.saved, a.sent);
            let task = a.client.get(&format!("/tasks/{}", a.task)).good();
            assert_eq!(task["fence"].as_i64(), Some(a.fence));
            a.version = task["version"].as_i64().unwrap();
            assert!(a.save(), "{:?}", a.refused);
        }
        processes.restart(killed);
        for (i, a) in crew.iter_mut().enumerate() {
            a.client.move_to(processes.at(i % 2));
        }
    }
    assert!(crew.iter().all(|a| a.saved > 5));

    // A lease that is given back in one process is free in the other, and the old fence is refused there.
    let (task, fence, version) = (crew[0].task.clone(), crew[0].fence, crew[0].version);
    let released = crew[0].client.post(&format!("/tasks/{task}/lease"), &give_back(fence));
    assert_eq!(released.status, 200, "{}", String::from_utf8_lossy(&released.body));
    crew[0].client.move_to(processes.at(1));
    let change = json!({"fence": fence, "base_version": version, "changes": []});
    let late = crew[0].client.patch(&format!("/tasks/{task}/draft"), &change);
    assert!(late.status == 409 || late.status == 403, "{}", late.status);
}

#[test]
fn failed_sign_ins_are_counted_together_and_outlive_a_restart() {
    let Some(server) = Server::start() else { return };
    let mut processes = Processes::start(&server);
    drop(Client::set_up(processes.at(0), "admin"));
    let attempt = |at: SocketAddr, name: &str, password: &str| {
        let mut client = Client::new(at);
        let answer = client.try_to_sign_in(name, password);
        (answer.status, answer.json()["code"].as_str().unwrap_or_default().to_owned())
    };
    // Five are free, wherever they are tried.
    for i in 0..5 {
        assert_eq!(
            attempt(processes.at(i % 2), "admin", "wrong password"),
            (401, "session.wrong".into()),
            "{i}"
        );
    }
    for number in [0, 1] {
        assert_eq!(attempt(processes.at(number), "admin", "wrong password").0, 429, "process {number}");
    }
    // A restart does not give five more: the wait is over soon, and is longer after each failure.
    processes.kill(1);
    processes.restart(1);
    let mut failures = 0;
    wait_for("waits grow", || {
        let (status, _) = attempt(processes.at(failures % 2), "admin", "wrong password");
        failures += usize::from(status == 401);
        failures == 2
    });
    assert_eq!(
        attempt(processes.at(1), "admin", "a long password").0,
        429,
        "the right password waits as well"
    );
    // Somebody else does not wait; who signs in at last starts from none.
    assert_eq!(attempt(processes.at(0), "nobody", "wrong password").0, 401);
    wait_for("sign-in after the wait", || attempt(processes.at(0), "admin", "a long password").0 == 200);
    assert_eq!(attempt(processes.at(1), "admin", "wrong password").0, 401);
}

#[test]
fn sessions_and_what_is_cached_are_the_same_in_both() {
    let Some(server) = Server::start() else { return };
    let processes = Processes::start(&server);
    let mut admin = Client::set_up(processes.at(0), "admin");
    let project = first_project(&mut admin);
    let tokens = annotators(&mut admin, processes.at(0), &project, 0..1);
    let mut there = Client::sign_in(processes.at(1), "admin");
    // The dashboard is made from what is kept in memory: it must know what the other process has stored since.
    let dashboard = |client: &mut Client| {
        let mut board = client.get(&format!("/projects/{project}/dashboard")).good();
        // How long tasks have waited differs from call to call.
        board["ageing"].as_array_mut().unwrap().iter_mut().for_each(|task| task["hours"] = Value::Null);
        board
    };
    let (here_before, there_before) = (dashboard(&mut admin), dashboard(&mut there));
    assert_eq!(here_before, there_before);
    let mut annotator = Annotator::begin(processes.at(0), &tokens[0], &project);
    assert!(annotator.save());
    let (here, now_there) = (dashboard(&mut admin), dashboard(&mut there));
    assert_eq!(here, now_there);
    assert_ne!(now_there, there_before, "a task was taken");
    // A session that began here holds there, with its CSRF value, and ends in both.
    admin.move_to(processes.at(1));
    let renamed = admin.patch(&format!("/projects/{project}"), &json!({"name": "renamed"}));
    assert_eq!(renamed.status, 200, "{}", String::from_utf8_lossy(&renamed.body));
    admin.move_to(processes.at(0));
    assert_eq!(admin.get(&format!("/projects/{project}")).good()["name"], "renamed");
    admin.send("DELETE", "/session", None).unwrap().good();
    admin.move_to(processes.at(1));
    assert_eq!(admin.get("/projects").status, 401);
}

/// Deliveries that a receiver has taken: how often each, with its event.
type Taken = Arc<Mutex<BTreeMap<String, (usize, String)>>>;

/// Takes webhook messages until it is dropped.
fn receiver() -> (SocketAddr, Taken) {
    let (listener, taken) = (TcpListener::bind("127.0.0.1:0").unwrap(), Taken::default());
    let at = listener.local_addr().unwrap();
    let to = Arc::clone(&taken);
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let to = Arc::clone(&to);
            std::thread::spawn(move || {
                let mut reader = BufReader::new(stream);
                let (mut line, mut length) = (String::new(), 0);
                while reader.read_line(&mut line).is_ok_and(|n| n > 0) && !line.trim().is_empty() {
                    if let Some(n) = line.to_lowercase().strip_prefix("content-length:") {
                        length = n.trim().parse().unwrap();
                    }
                    line.clear();
                }
                let mut body = vec![0; length];
                if reader.read_exact(&mut body).is_err() {
                    return;
                }
                let message: Value = serde_json::from_slice(&body).unwrap();
                let text = |key: &str| message[key].as_str().unwrap().to_owned();
                // Slow enough for a sender to be killed in the middle.
                std::thread::sleep(Duration::from_millis(30));
                to.lock().unwrap().entry(text("delivery")).or_insert((0, text("event"))).0 += 1;
                let _ = reader.get_mut().write_all(b"HTTP/1.1 200 OK\r\ncontent-length: 0\r\n\r\n");
            });
        }
    });
    (at, taken)
}

#[test]
fn webhooks_are_sent_once_by_two_processes_and_none_is_lost_with_a_killed_one() {
    let Some(server) = Server::start() else { return };
    let mut processes = Processes::start(&server);
    let mut admin = Client::set_up(processes.at(0), "admin");
    let project = first_project(&mut admin);
    let tokens = annotators(&mut admin, processes.at(0), &project, 0..PEOPLE);
    let (at, taken) = receiver();
    let hook = json!({"url": format!("http://{at}/hook"), "events": ["take", "release"]});
    admin.post(&format!("/projects/{project}/webhooks"), &hook).good();
    let mut expected = 0;
    let round = |processes: &Processes, crew: &[String], expected: &mut usize| {
        for (i, token) in crew.iter().enumerate() {
            let mut a = Annotator::begin(processes.at(i % 2), token, &project);
            let released = a.client.post(&format!("/tasks/{}/lease", a.task), &give_back(a.fence));
            assert_eq!(released.status, 200, "{}", String::from_utf8_lossy(&released.body));
            *expected += 2;
        }
    };
    round(&processes, &tokens, &mut expected);
    wait_for("all messages", || taken.lock().unwrap().len() == expected);
    std::thread::sleep(Duration::from_secs(3));
    let twice: Vec<_> =
        taken.lock().unwrap().iter().filter(|(_, (n, _))| *n != 1).map(|(id, _)| id.clone()).collect();
    assert!(twice.is_empty(), "two senders sent the same: {twice:?}");

    round(&processes, &tokens, &mut expected);
    // Most probably in the middle of sending: what it has claimed is sent by the other after a minute.
    processes.kill(0);
    wait_for("messages of a killed sender", || taken.lock().unwrap().len() == expected);
    let takes = taken.lock().unwrap().values().filter(|(_, event)| event == "take").count();
    assert_eq!(takes * 2, expected);
}
