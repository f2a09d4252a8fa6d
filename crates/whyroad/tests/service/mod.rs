//! The real `whyroad serve`, started by a test on a port of its own, and people who call it.
#![allow(dead_code)] // each test file uses its part of this

pub mod http;
pub mod storm;

use http::Client;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;

/// A running service.
pub struct Service {
    pub at: SocketAddr,
    child: Child,
}

impl Service {
    /// Starts the service on `demo()`'s lake with these further arguments, and waits until it listens.
    pub fn start(arguments: &[&str]) -> Self {
        let dir = demo();
        let mut child = Command::new(env!("CARGO_BIN_EXE_whyroad"))
            .args(["serve", "--listen", "127.0.0.1:0", "--lake"])
            .arg(dir.join("lake"))
            .arg("--mined")
            .arg(dir.join("mined"))
            .args(arguments)
            .env_remove("WHYROAD_FRAMEWORK")
            .env_remove("WHYROAD_LANG")
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
        let mut said = Vec::new();
        let at = loop {
            let Some(line) = lines.next() else { panic!("the service did not start: {said:?}") };
            if let Some(rest) = line.strip_prefix("labelling service: http://") {
                break rest.split('/').next().unwrap().parse().unwrap();
            }
            said.push(line);
        };
        // A full pipe would stop it.
        std::thread::spawn(move || lines.for_each(drop));
        Self { at, child }
    }

    /// Ends it as `kill -9` does.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Its process id.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Waits until it ends of itself.
    pub fn wait(mut self) -> std::process::ExitStatus {
        self.child.wait().unwrap()
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The folder that `whyroad demo` wrote, once for all tests of a binary.
pub fn demo() -> &'static Path {
    static DEMO: OnceLock<tempfile::TempDir> = OnceLock::new();
    DEMO.get_or_init(|| {
        let dir = tempfile::tempdir().unwrap();
        let run = Command::new(env!("CARGO_BIN_EXE_whyroad"))
            .args(["demo", "--out"])
            .arg(dir.path())
            .output()
            .unwrap();
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        dir
    })
    .path()
}

/// The episodes of the demo.
pub fn episodes() -> Vec<Value> {
    let path: PathBuf = demo().join("mined/episodes.jsonl");
    std::fs::read_to_string(path).unwrap().lines().map(|l| serde_json::from_str(l).unwrap()).collect()
}

/// Signs up `n` annotators of `project` under an admin, and gives each an API token.
pub fn annotators(admin: &mut Client, at: SocketAddr, project: &str, n: usize) -> Vec<String> {
    let tokens = |i: usize| {
        let name = format!("annotator{i}");
        let user = json!({"name": name, "display": name, "password": "a long password"});
        admin.post("/users", &user).good();
        let member = json!({"user": name, "roles": ["annotator"]});
        admin.post(&format!("/projects/{project}/members"), &member).good();
        let mut own = Client::sign_in(at, &name);
        own.post("/tokens", &json!({"name": "test"})).good()["token"].as_str().unwrap().to_owned()
    };
    (0..n).map(tokens).collect()
}

/// The id of the project that a fresh service begins with.
pub fn first_project(client: &mut Client) -> String {
    client.get("/projects").good()["items"][0]["id"].as_str().unwrap().to_owned()
}
