//! Annotators who save at every change: what the service confirmed to each of them as saved is compared with what is
//! there afterwards.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use super::http::Client;
use serde_json::{Value, json};
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// One annotator with a task in Stage I.
pub struct Annotator {
    pub client: Client,
    pub task: String,
    pub fence: i64,
    pub version: i64,
    /// Last change that the service said is saved.
    pub saved: u64,
    /// Last change that was sent.
    pub sent: u64,
    /// Time of each answer of 200, s.
    pub seconds: Vec<f64>,
    /// Answers other than 200, as text.
    pub refused: Vec<String>,
    /// What others may know of it while it works.
    pub progress: Arc<Progress>,
}

/// How far one has come.
#[derive(Debug, Default)]
pub struct Progress {
    saved: AtomicU64,
    refused: AtomicU64,
}

impl Progress {
    /// Changes acknowledged so far.
    pub fn saved(&self) -> u64 {
        self.saved.load(Ordering::Relaxed)
    }

    /// Changes refused so far.
    pub fn refused(&self) -> u64 {
        self.refused.load(Ordering::Relaxed)
    }
}

impl Annotator {
    /// Takes the next task of the queue.
    pub fn begin(at: SocketAddr, token: &str, project: &str) -> Self {
        let mut client = Client::with_token(at, token);
        let next = client.post(&format!("/projects/{project}/tasks:next"), &json!({"kind": "label"}));
        assert_eq!(
            next.status,
            200,
            "there is a task for everybody: {}",
            String::from_utf8_lossy(&next.body)
        );
        let task = next.json();
        Self {
            client,
            task: task["task"]["id"].as_str().unwrap().to_owned(),
            fence: task["fence"].as_i64().unwrap(),
            version: task["version"].as_i64().unwrap(),
            saved: 0,
            sent: 0,
            seconds: vec![],
            refused: vec![],
            progress: Arc::default(),
        }
    }

    /// Saves one more change; false when the connection broke or the service is away.
    pub fn save(&mut self) -> bool {
        if self.sent == self.saved {
            self.sent += 1;
        }
        let change = json!({
            "fence": self.fence, "base_version": self.version,
            "changes": [{"path": "/critical_components", "value": [component(self.sent)]}],
        });
        let start = Instant::now();
        match self.client.send("PATCH", &format!("/tasks/{}/draft", self.task), Some(&change)) {
            Ok(answer) if answer.status == 200 => {
                self.seconds.push(start.elapsed().as_secs_f64());
                self.version = answer.json()["version"].as_i64().unwrap();
                self.saved = self.sent;
                self.progress.saved.fetch_add(1, Ordering::Relaxed);
                true
            }
            Ok(answer) => {
                self.refused.push(format!("{} {}", answer.status, String::from_utf8_lossy(&answer.body)));
                self.progress.refused.fetch_add(1, Ordering::Relaxed);
                false
            }
            Err(_) => false,
        }
    }

    /// Saves one change each `every`, counted from `start`, until `stop`; or until the service is gone.
    pub fn save_until(&mut self, stop: &AtomicBool, every: Duration) {
        let mut due = Instant::now();
        while !stop.load(Ordering::Relaxed) && self.save() {
            due += every;
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
    }

    /// Number of the change that the service has.
    pub fn stored(&mut self) -> u64 {
        let task = self.client.get(&format!("/tasks/{}", self.task)).good();
        number(&task["draft"])
    }
}

fn component(number: u64) -> Value {
    json!({"id": "c1", "category": "agent", "description": format!("change {number}"), "evidence_times": []})
}

fn number(draft: &Value) -> u64 {
    let text = draft["critical_components"][0]["description"].as_str().unwrap_or_default();
    text.strip_prefix("change ").map_or(0, |n| n.parse().unwrap())
}
