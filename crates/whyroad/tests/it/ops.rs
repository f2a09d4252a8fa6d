//! The port for operators and the JSON log of a real `whyroad serve`: what they say, that nothing secret or personal is
//! in it, and that the port has nothing of the API.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::postgres::Server;
use crate::service::demo;
use crate::service::http::Client;
use crate::session::{root, whyroad_with};
use serde_json::{Value, json};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// A service with JSON logs.
struct Service {
    child: Child,
    at: SocketAddr,
    ops: SocketAddr,
    log: Arc<Mutex<Vec<Value>>>,
}

impl Service {
    fn start(lake: &Path, data: &Path) -> Self {
        Self::start_with(lake, data, None)
    }

    /// On another store than a file in `data`.
    fn start_with(lake: &Path, data: &Path, store: Option<&str>) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_whyroad"))
            .args(["serve", "--listen", "127.0.0.1:0", "--ops-listen", "127.0.0.1:0", "--log-format", "json"])
            .args(["--lake", lake.to_str().unwrap(), "--data", data.to_str().unwrap()])
            .args(store.iter().flat_map(|store| ["--store", *store]))
            .env_remove("WHYROAD_LANG")
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let log = Arc::new(Mutex::new(Vec::new()));
        let kept = Arc::clone(&log);
        std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                kept.lock().unwrap().push(serde_json::from_str(&line).unwrap_or(Value::String(line)));
            }
        });
        let address = |before: &str| -> SocketAddr {
            let start = Instant::now();
            loop {
                let found = log.lock().unwrap().iter().find_map(|line| {
                    let text = line["message"].as_str()?.strip_prefix(before)?;
                    text.split('/').next()?.parse().ok()
                });
                if let Some(at) = found {
                    return at;
                }
                assert!(start.elapsed() < Duration::from_secs(60), "{:?}", log.lock().unwrap());
                std::thread::sleep(Duration::from_millis(10));
            }
        };
        let (at, ops) = (address("labeling service: http://"), address("for operators: http://"));
        Self { child, at, ops, log }
    }

    /// Status and body of a request to the port for operators.
    fn ops(&self, line: &str) -> (u16, String) {
        let mut stream = TcpStream::connect(self.ops).unwrap();
        write!(stream, "{line} HTTP/1.1\r\nhost: ops\r\nconnection: close\r\n\r\n").unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        let (head, body) = text.split_once("\r\n\r\n").unwrap();
        (head.split(' ').nth(1).unwrap().parse().unwrap(), body.to_owned())
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn figures_and_logs_of_a_service_name_nobody_and_its_port_has_no_api() {
    let dir = tempfile::tempdir().unwrap();
    let lake = dir.path().join("lake");
    fs::create_dir_all(lake.join("drives")).unwrap();
    fs::copy(demo().join("lake/whyroad-lake.json"), lake.join("whyroad-lake.json")).unwrap();
    let service = Service::start(&lake, &dir.path().join("data"));
    let mut admin = Client::set_up(service.at, "very-secret-admin");
    admin.post("/projects", &json!({ "name": "very-secret-project" })).good();
    admin.get("/users").good();
    let unknown = admin.get("/tasks/very-secret-task");
    assert_eq!(unknown.status, 404);

    assert_eq!(service.ops("GET /livez"), (200, "ok\n".to_owned()));
    assert_eq!(service.ops("GET /readyz"), (200, "ok\n".to_owned()));
    let (status, text) = service.ops("GET /metrics");
    assert_eq!(status, 200);
    for line in [
        "whyroad_ready 1",
        "whyroad_store_up 1",
        "whyroad_http_requests_total{method=\"GET\",route=\"/users\",status=\"200\"} 1",
        "whyroad_http_requests_total{method=\"GET\",route=\"/tasks/{t}\",status=\"404\"} 1",
    ] {
        assert!(text.lines().any(|l| l == line), "no {line}:\n{text}");
    }
    // The process that was started serves, with the allocator's arenas limited: mallopt(3), M_ARENA_MAX.
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        let environment = fs::read(format!("/proc/{}/environ", service.child.id())).unwrap();
        let mut all = environment.split(|b| *b == 0);
        assert!(
            all.any(|v| v.starts_with(b"MALLOC_ARENA_MAX=")),
            "{}",
            String::from_utf8_lossy(&environment)
        );
    }
    // The format: a name, labels, a number; each name announced before.
    for line in text.lines().filter(|l| !l.starts_with('#')) {
        let (name, value) = line.rsplit_once(' ').unwrap();
        assert!(value.parse::<f64>().is_ok(), "{line}");
        let name = name.split('{').next().unwrap();
        let of = ["_bucket", "_sum", "_count"].iter().find_map(|s| name.strip_suffix(s)).unwrap_or(name);
        assert!(
            text.contains(&format!("# TYPE {of} ")) || text.contains(&format!("# TYPE {name} ")),
            "{line}"
        );
    }
    assert_eq!(service.ops("GET /api/v1/users").0, 404);
    assert_eq!(service.ops("POST /metrics").0, 405);

    // Without its lake it is not ready; the process lives.
    fs::rename(lake.join("whyroad-lake.json"), dir.path().join("marker")).unwrap();
    assert_eq!(service.ops("GET /readyz"), (503, "lake: cannot be read\n".to_owned()));
    assert!(service.ops("GET /metrics").1.contains("whyroad_ready 0\n"));
    assert_eq!(service.ops("GET /livez").0, 200);
    fs::rename(dir.path().join("marker"), lake.join("whyroad-lake.json")).unwrap();
    assert_eq!(service.ops("GET /readyz").0, 200);

    // Lines are read by a thread of the test, which may be behind.
    let is_request = |l: &&Value| l["event"] == "request";
    let until = Instant::now() + Duration::from_secs(20);
    while service.log.lock().unwrap().iter().filter(is_request).count() < 5 && Instant::now() < until {
        std::thread::sleep(Duration::from_millis(20));
    }
    let log = service.log.lock().unwrap().clone();
    let requests: Vec<&Value> = log.iter().filter(is_request).collect();
    assert!(requests.len() >= 5, "{log:?}");
    for line in &log {
        assert!(line["time"].is_string() && line["level"].is_string(), "not a line of the log: {line}");
    }
    assert!(
        requests.iter().any(|l| l["route"] == "/tasks/{t}" && l["status"] == 404 && l["seconds"].is_number())
    );
    let all = format!("{text}{}", serde_json::to_string(&log).unwrap());
    assert!(!all.contains("very-secret"), "{all}");
}

/// docs/how-to/monitor.md: an answer within seconds whatever the database does, since Prometheus gives up after 10 s
/// and probes after 5 s. A database that hangs keeps its connections open and answers nothing.
#[test]
fn probes_answer_while_the_database_hangs_and_while_it_is_away() {
    let Some(mut server) = Server::start() else { return };
    let dir = tempfile::tempdir().unwrap();
    let lake = dir.path().join("lake");
    fs::create_dir_all(lake.join("drives")).unwrap();
    fs::copy(demo().join("lake/whyroad-lake.json"), lake.join("whyroad-lake.json")).unwrap();
    let service = Service::start_with(&lake, &dir.path().join("data"), Some(&server.database()));
    let ready = (200, "ok\n".to_owned());
    assert_eq!(service.ops("GET /readyz"), ready);
    let within = |start: Instant| assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
    let health = || {
        let mut stream = TcpStream::connect(service.at).unwrap();
        write!(stream, "GET /api/v1/healthz HTTP/1.1\r\nhost: t\r\nconnection: close\r\n\r\n").unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        text.split(' ').nth(1).unwrap().parse::<u16>().unwrap()
    };
    let all_fail = |reason: &str| {
        let start = Instant::now();
        let (status, why) = service.ops("GET /readyz");
        assert_eq!((status, why.starts_with(reason)), (503, true), "{why}");
        within(start);
        let start = Instant::now();
        let (status, text) = service.ops("GET /metrics");
        assert!(status == 200 && text.contains("whyroad_ready 0\n"), "{text}");
        within(start);
        let start = Instant::now();
        assert_eq!(health(), 503);
        within(start);
    };
    let recovers = || {
        let start = Instant::now();
        while service.ops("GET /readyz") != ready {
            assert!(start.elapsed() < Duration::from_secs(30), "{:?}", service.ops("GET /readyz"));
            std::thread::sleep(Duration::from_millis(50));
        }
        assert_eq!(health(), 200);
    };
    server.hang();
    // Twice: a probe that hangs does not keep the next one from answering.
    all_fail("store: no answer");
    all_fail("store: no answer");
    server.resume();
    recovers();
    std::thread::scope(|scope| {
        let restarts = scope.spawn(|| server.restart(Duration::from_secs(8)));
        let start = Instant::now();
        while service.ops("GET /readyz").0 == 200 {
            assert!(start.elapsed() < Duration::from_secs(30));
            std::thread::sleep(Duration::from_millis(50));
        }
        all_fail("store: ");
        restarts.join().unwrap();
    });
    recovers();
}

#[test]
fn every_command_can_log_json_and_keeps_stdout_for_results() {
    let dir = tempfile::tempdir().unwrap();
    let drive = root().join("examples/drives/back_street");
    let run = |args: &[&str]| whyroad_with(dir.path(), args, &[("WHYROAD_LOG_FORMAT", "json")]);
    assert_eq!(run(&["ingest", "sumo", drive.to_str().unwrap(), "--lake", "lake"]).code, 0);
    let mined =
        run(&["mine", "--lake", "lake", "--rule", "ego.speed > 1 m/s", "--out", "mined", "--format", "json"]);
    assert_eq!(mined.code, 0, "{}", mined.err);
    assert!(serde_json::from_str::<Value>(&mined.out).is_ok());
    let lines =
        |text: &str| -> Vec<Value> { text.lines().map(|l| serde_json::from_str(l).unwrap()).collect() };
    let progress = lines(&mined.err);
    assert!(
        progress.iter().any(|l| l["event"] == "progress" && l["done"] == 1 && l["total"] == 1),
        "{progress:?}"
    );
    let failed = run(&["inspect", "--lake", "nowhere"]);
    let said = lines(&failed.err);
    assert!(said.iter().any(|l| l["level"] == "error" && l["code"] == "lake.not_a_lake"), "{said:?}");
}
