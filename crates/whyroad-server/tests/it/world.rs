//! A service that runs on a port of this machine, and people who call it over HTTP.

use crate::recorded::{Future, Recorded, episode};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::{Duration, Instant};
use whyroad_framework::Framework;
use whyroad_server::App;
use whyroad_server::app::LeaseClock;
use whyroad_server::store::{Store, StoreLocation};

/// 2026-11-21T16:00:00Z in ms.
pub const NOON: i64 = 1_795_276_800_000;
pub const PASSWORD: &str = "correct horse";

/// A running service.
pub struct World {
    pub app: Arc<App>,
    pub address: SocketAddr,
    pub future: Future,
    pub clock: Arc<AtomicI64>,
    place: StoreLocation,
    runtime: Option<tokio::runtime::Runtime>,
    _dir: tempfile::TempDir,
}

impl World {
    /// One on a new SQLite file.
    pub fn on_sqlite(future: Future) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let place = StoreLocation::File(dir.path().join("store.sqlite"));
        Self::start(&place, future, dir)
    }

    /// One on an empty PostgreSQL database.
    pub fn on_server(url: &str, future: Future) -> Self {
        Self::start(&StoreLocation::parse(url), future, tempfile::tempdir().unwrap())
    }

    fn start(place: &StoreLocation, future: Future, dir: tempfile::TempDir) -> Self {
        let keys = dir.path().to_path_buf();
        Self::open(place, future, (dir, &keys), Arc::new(AtomicI64::new(NOON)), |_| {})
    }

    /// A second service on the same store and with the same clock, configured by `set_up`.
    pub fn beside(&self, set_up: impl FnOnce(&mut App)) -> Self {
        let folders = (tempfile::tempdir().unwrap(), self._dir.path());
        Self::open(&self.place, self.future, folders, Arc::clone(&self.clock), set_up)
    }

    /// A second service on the same store that is not serving yet.
    pub fn second(&self, set_up: impl FnOnce(&mut App)) -> Arc<App> {
        let recordings = Recorded { future: self.future, pictures: self._dir.path().to_path_buf() };
        let store = Store::open_keeping(&self.place, self._dir.path()).unwrap();
        let mut app = App::new(store, Framework::bundled(), Arc::new(recordings)).unwrap();
        let hands = Arc::clone(&self.clock);
        app.clock = Arc::new(move || hands.load(Ordering::SeqCst));
        app.lease_clock = LeaseClock::Service;
        set_up(&mut app);
        Arc::new(app)
    }

    fn open(
        place: &StoreLocation,
        future: Future,
        (dir, keys): (tempfile::TempDir, &std::path::Path),
        clock: Arc<AtomicI64>,
        set_up: impl FnOnce(&mut App),
    ) -> Self {
        let recordings = Recorded { future, pictures: dir.path().to_path_buf() };
        let store = Store::open_keeping(place, keys).unwrap();
        let mut app = App::new(store, Framework::bundled(), Arc::new(recordings)).unwrap();
        let hands = Arc::clone(&clock);
        app.clock = Arc::new(move || hands.load(Ordering::SeqCst));
        app.lease_clock = LeaseClock::Service;
        app.reports = Some(Arc::new(crate::recorded::Counted));
        set_up(&mut app);
        let app = Arc::new(app);
        let runtime =
            tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().unwrap();
        let listener = runtime.block_on(tokio::net::TcpListener::bind("127.0.0.1:0")).unwrap();
        let address = listener.local_addr().unwrap();
        runtime.spawn(whyroad_server::serve(Arc::clone(&app), listener, std::future::pending()));
        Self { app, address, future, clock, place: place.clone(), runtime: Some(runtime), _dir: dir }
    }

    /// Advances the clock.
    pub fn wait(&self, seconds: i64) {
        self.clock.fetch_add(seconds * 1000, Ordering::SeqCst);
    }

    /// A caller who is not signed in.
    pub fn unauthenticated(&self) -> Person {
        Person { address: self.address, cookie: None, csrf: None, token: None, id: String::new() }
    }

    /// The first admin.
    pub fn admin(&self) -> Person {
        let mut p = self.unauthenticated();
        p.hello();
        let body = json!({ "name": "admin", "display": "Admin", "password": PASSWORD, "lang": "zh" });
        let answer = p.post("/setup", &body);
        assert_eq!(answer.status, 200, "{}", answer.text());
        p.keep(&answer);
        p
    }

    /// A new user with roles in a project, signed in.
    pub fn person(&self, admin: &Person, project: &str, name: &str, roles: &[&str]) -> Person {
        let made = admin.post("/users", &json!({ "name": name, "password": PASSWORD, "lang": "zh" }));
        assert_eq!(made.status, 200, "{}", made.text());
        if !roles.is_empty() {
            let path = format!("/projects/{project}/members");
            assert_eq!(admin.post(&path, &json!({ "user": name, "roles": roles })).status, 200);
        }
        self.sign_in(name)
    }

    pub fn sign_in(&self, name: &str) -> Person {
        let mut p = self.unauthenticated();
        p.hello();
        let answer = p.post("/session", &json!({ "name": name, "password": PASSWORD }));
        assert_eq!(answer.status, 200, "{}", answer.text());
        p.keep(&answer);
        p
    }

    /// A project; returns its id.
    pub fn project(&self, admin: &Person, name: &str, settings: &Value) -> String {
        let made = admin.post("/projects", &json!({ "name": name, "settings": settings }));
        assert_eq!(made.status, 200, "{}", made.text());
        made.json()["id"].as_str().unwrap().to_owned()
    }

    /// Tasks from one episode of each of `drives`; returns their ids.
    pub fn tasks(&self, lead: &Person, project: &str, drives: &[&str], overlap: u32) -> Vec<String> {
        let episodes: Vec<Value> =
            drives.iter().map(|d| serde_json::to_value(episode(d, 1, self.future)).unwrap()).collect();
        let body = json!({ "episodes": episodes, "overlap": overlap });
        let made = lead.post(&format!("/projects/{project}/tasks:create"), &body);
        assert_eq!(made.status, 200, "{}", made.text());
        made.json()["tasks"].as_array().unwrap().iter().map(|t| t.as_str().unwrap().to_owned()).collect()
    }
}

impl Drop for World {
    fn drop(&mut self) {
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_timeout(Duration::from_secs(2));
        }
    }
}

/// A client of the service.
#[derive(Clone)]
pub struct Person {
    pub address: SocketAddr,
    pub cookie: Option<String>,
    pub csrf: Option<String>,
    pub token: Option<String>,
    pub id: String,
}

/// A response.
#[derive(Clone, Debug)]
pub struct Reply {
    pub status: u16,
    pub headers: Vec<(String, String)>,
    pub body: Vec<u8>,
}

impl Reply {
    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str())
    }
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|e| panic!("{e}: {} {}", self.status, self.text()))
    }
    /// The body of a successful response.
    pub fn fine(&self) -> Value {
        assert_eq!(self.status, 200, "{}", self.text());
        self.json()
    }
    /// Status and code of a refusal, which must be problem+json.
    pub fn refusal(&self) -> (u16, String) {
        assert_eq!(
            self.header("content-type"),
            Some("application/problem+json"),
            "{} {}",
            self.status,
            self.text()
        );
        let body = self.json();
        assert_eq!(body["status"], self.status);
        assert!(body["detail_zh"].as_str().is_some_and(|t| !t.is_empty()));
        assert!(body["detail_en"].as_str().is_some_and(|t| !t.is_empty()));
        (self.status, body["code"].as_str().unwrap().to_owned())
    }
}

impl Person {
    /// `GET /session`: stores the cookie and its CSRF value.
    pub fn hello(&mut self) -> Reply {
        let answer = self.get("/session");
        self.keep(&answer);
        answer
    }

    /// Stores the cookie, CSRF value and id of a response about the session.
    pub fn keep(&mut self, answer: &Reply) {
        if let Some(cookie) = answer.header("set-cookie") {
            self.cookie = Some(cookie.split(';').next().unwrap().to_owned());
        }
        let body = answer.json();
        self.csrf = body["csrf"].as_str().map(str::to_owned);
        self.id = body["user"]["id"].as_str().unwrap_or_default().to_owned();
    }

    pub fn get(&self, path: &str) -> Reply {
        self.call("GET", path, None, &[])
    }
    pub fn post(&self, path: &str, body: &Value) -> Reply {
        self.call("POST", path, Some(body.to_string().as_bytes()), &[])
    }
    pub fn patch(&self, path: &str, body: &Value) -> Reply {
        self.call("PATCH", path, Some(body.to_string().as_bytes()), &[])
    }

    /// A call below `/api/v1`.
    pub fn call(&self, verb: &str, path: &str, body: Option<&[u8]>, more: &[(&str, &str)]) -> Reply {
        self.raw(verb, &format!("/api/v1{path}"), body, more)
    }

    /// A call of any path.
    pub fn raw(&self, verb: &str, path: &str, body: Option<&[u8]>, more: &[(&str, &str)]) -> Reply {
        let (mut bytes, begun) = (Vec::new(), Instant::now());
        let read = self.send(verb, path, body, more).read_to_end(&mut bytes);
        parse(&bytes)
            .unwrap_or_else(|| panic!("{verb} {path}: no answer within {:?}: {read:?}", begun.elapsed()))
    }

    /// Number of lines in a chunked response (RFC 9112, 7.1), which is read without being kept.
    pub fn lines(&self, path: &str) -> usize {
        let mut answer = BufReader::new(self.send("GET", &format!("/api/v1{path}"), None, &[]));
        let line = |answer: &mut BufReader<TcpStream>| {
            let mut line = String::new();
            answer.read_line(&mut line).unwrap();
            line.trim_end().to_owned()
        };
        assert_eq!(line(&mut answer).split(' ').nth(1), Some("200"));
        while !line(&mut answer).is_empty() {}
        let (mut lines, mut buffer) = (0, vec![0; 1 << 16]);
        loop {
            let mut left = usize::from_str_radix(&line(&mut answer), 16).unwrap();
            if left == 0 {
                return lines;
            }
            while left > 0 {
                let most = left.min(buffer.len());
                let n = answer.read(&mut buffer[..most]).unwrap();
                assert!(n > 0, "the answer is cut off");
                lines += buffer[..n].iter().filter(|b| **b == b'\n').count();
                left -= n;
            }
            assert_eq!(line(&mut answer), "", "the end of a chunk");
        }
    }

    /// Sends a call; the response is not read yet.
    fn send(&self, verb: &str, path: &str, body: Option<&[u8]>, more: &[(&str, &str)]) -> TcpStream {
        let mut head = format!("{verb} {path} HTTP/1.1\r\nconnection: close\r\n");
        let mut put = |name: &str, value: &str| head.push_str(&format!("{name}: {value}\r\n"));
        if let Some(cookie) = &self.cookie {
            put("cookie", cookie);
        }
        if let Some(csrf) = self.csrf.as_ref().filter(|_| verb != "GET") {
            put("x-csrf-token", csrf);
        }
        if let Some(token) = &self.token {
            put("authorization", &format!("Bearer {token}"));
        }
        if !more.iter().any(|(name, _)| *name == "host") {
            put("host", &self.address.to_string());
        }
        for (name, value) in more {
            put(name, value);
        }
        if let Some(body) = body {
            put("content-length", &body.len().to_string());
        }
        head.push_str("\r\n");
        let mut stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        stream.write_all(head.as_bytes()).unwrap();
        // The service may answer and close before it has read a body that is too large.
        let _ = stream.write_all(body.unwrap_or_default());
        stream
    }
}

/// `None` if the head is incomplete.
fn parse(bytes: &[u8]) -> Option<Reply> {
    let end = bytes.windows(4).position(|w| w == b"\r\n\r\n")?;
    let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
    let mut lines = head.split("\r\n");
    let status = lines.next().unwrap().split(' ').nth(1).unwrap().parse().unwrap();
    let headers = lines
        .filter_map(|l| l.split_once(':'))
        .map(|(n, v)| (n.to_ascii_lowercase(), v.trim().to_owned()))
        .collect();
    let mut reply = Reply { status, headers, body: bytes[end + 4..].to_vec() };
    if reply.header("transfer-encoding") == Some("chunked") {
        reply.body = joined(&reply.body);
    }
    Some(reply)
}

/// The content of a chunked body (RFC 9112, 7.1), which must be complete.
fn joined(mut chunks: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    loop {
        let end = chunks.windows(2).position(|w| w == b"\r\n").expect("a size of a chunk");
        let size = usize::from_str_radix(std::str::from_utf8(&chunks[..end]).unwrap(), 16).unwrap();
        chunks = &chunks[end + 2..];
        if size == 0 {
            return out;
        }
        out.extend_from_slice(&chunks[..size]);
        chunks = &chunks[size + 2..];
    }
}
