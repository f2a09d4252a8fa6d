//! The real `whyroad serve`, started by a test on a port of its own, and people who call it.
#![allow(clippy::unwrap_used, reason = "a test may panic")]
#![allow(dead_code)] // each test file uses its part of this

pub mod http;
pub mod storm;

use http::Client;
use serde_json::json;
use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use storm::Annotator;
use whyroad_lake::MinedFolder;
use whyroad_lake::mined::{Existing, MinedFolderWriter};

/// Episodes that tasks are made from.
const EPISODES: usize = 8;

/// A running service.
pub struct Service {
    pub at: SocketAddr,
    child: Child,
}

impl Service {
    /// Starts the service on `demo()`'s lake with these further arguments, and waits until it listens.
    pub fn start(arguments: &[&str]) -> Self {
        Self::start_on(&demo().join("lake"), arguments)
    }

    /// The same on a lake that has the drives of `demo()`.
    pub fn start_on(lake: &Path, arguments: &[&str]) -> Self {
        Self::start_mined(lake, &demo().join("mined"), arguments)
    }

    /// The same on a lake and a mined folder of the test's own.
    pub fn start_mined(lake: &Path, mined: &Path, arguments: &[&str]) -> Self {
        let drives = ["--lake", lake.to_str().unwrap(), "--mined", mined.to_str().unwrap()];
        Self::run(&[&drives[..], arguments].concat(), &[])
    }

    /// [`Service::start_on`] with these environment variables.
    pub fn start_in(lake: &Path, arguments: &[&str], environment: &[(String, String)]) -> Self {
        let mined = demo().join("mined");
        let drives = ["--lake", lake.to_str().unwrap(), "--mined", mined.to_str().unwrap()];
        Self::run(&[&drives[..], arguments].concat(), environment)
    }

    fn run(arguments: &[&str], environment: &[(String, String)]) -> Self {
        // A bench may measure another build than its own.
        let program = std::env::var_os("WHYROAD_BIN").unwrap_or_else(|| env!("CARGO_BIN_EXE_whyroad").into());
        let mut child = Command::new(program)
            .args(["serve", "--listen", "127.0.0.1:0"])
            .args(arguments)
            .env_remove("WHYROAD_FRAMEWORK")
            .env_remove("WHYROAD_LANG")
            .envs(environment.iter().map(|(name, value)| (name, value)))
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
        let mut said = Vec::new();
        let at = loop {
            let Some(line) = lines.next() else { panic!("the service did not start: {said:?}") };
            if let Some(rest) = line.strip_prefix("labeling service: http://") {
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

/// A folder with the bundled drives as `lake` and a few of their episodes as `mined`, once for all tests of a binary.
pub fn demo() -> &'static Path {
    static DEMO: OnceLock<tempfile::TempDir> = OnceLock::new();
    let dir = DEMO.get_or_init(|| {
        let dir = tempfile::tempdir().unwrap();
        // A service without a lake prepares the bundled drives before it listens.
        drop(Service::run(&["--data", dir.path().to_str().unwrap()], &[]));
        let mined = MinedFolder::open(dir.path().join("demo/mined")).unwrap();
        let all = mined.episodes().unwrap().map(Result::unwrap);
        let few: Vec<_> =
            all.filter(|e| e.is_primary && e.scenario_id.l1 != "other").take(EPISODES).collect();
        assert_eq!(few.len(), EPISODES);
        let question = mined.question().unwrap();
        let mut fewer = MinedFolderWriter::create(mined.dir(), question, Existing::default()).unwrap();
        for episode in &few {
            fewer.episode(episode).unwrap();
        }
        fewer.finish().unwrap();
        dir
    });
    static AT: OnceLock<PathBuf> = OnceLock::new();
    AT.get_or_init(|| dir.path().join("demo"))
}

/// Writes a mined folder of `n` episodes: those of [`demo`] again and again, under other ids.
pub fn mined_folder(to: &Path, n: usize) {
    let demo = MinedFolder::open(demo().join("mined")).unwrap();
    let few: Vec<_> = demo.episodes().unwrap().map(Result::unwrap).collect();
    let mut out = MinedFolderWriter::create(to, demo.question().unwrap(), Existing::default()).unwrap();
    // Drive by drive, as mining writes them.
    let each = n.div_ceil(few.len());
    for episode in few.iter().flat_map(|e| (0..each).map(move |i| (e, i))).take(n).map(|(e, i)| {
        let episode_id = format!("{}_{i}", e.episode_id);
        whyroad_model::messages::EpisodeRecord { episode_id, ..e.clone() }
    }) {
        out.episode(&episode).unwrap();
    }
    out.finish().unwrap();
}

/// Signs up annotators of `project` with these numbers under an admin, and gives each an API token.
pub fn annotators(admin: &mut Client, at: SocketAddr, project: &str, numbers: Range<usize>) -> Vec<String> {
    let tokens = |i: usize| {
        let name = format!("annotator{i}");
        let user = json!({"name": name, "display": name, "password": "a long password"});
        admin.post("/users", &user).good();
        let member = json!({"user": name, "roles": ["annotator"]});
        admin.post(&format!("/projects/{project}/members"), &member).good();
        let mut own = Client::sign_in(at, &name);
        own.post("/tokens", &json!({"name": "test"})).good()["token"].as_str().unwrap().to_owned()
    };
    numbers.map(tokens).collect()
}

/// Sets a new service up: its admin, its first project, and this many annotators with a task each.
pub fn crew(at: SocketAddr, people: usize) -> (Client, String, Vec<Annotator>) {
    let mut admin = Client::set_up(at, "admin");
    let project = first_project(&mut admin);
    let tokens = annotators(&mut admin, at, &project, 0..people);
    let crew = tokens.iter().map(|t| Annotator::begin(at, t, &project)).collect();
    (admin, project, crew)
}

/// The id of the first project of a service; created, with tasks from its mined folder, if it has none.
pub fn first_project(client: &mut Client) -> String {
    let id = |project: &serde_json::Value| project["id"].as_str().unwrap().to_owned();
    let all = client.get("/projects").good();
    if let Some(first) = all["items"].as_array().and_then(|items| items.first()) {
        return id(first);
    }
    // Few people and short drives: whoever has seen one task of a drive may do another one's Stage I.
    let settings = json!({ "history": "episode", "lang": "en" });
    let project = id(&client.post("/projects", &json!({ "name": "first", "settings": settings })).good());
    let mined = client.get("/mined").good()["items"][0]["name"].clone();
    client.post(&format!("/projects/{project}/tasks:create"), &json!({ "mined": mined })).good();
    project
}
