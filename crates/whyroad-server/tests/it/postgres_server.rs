//! A real PostgreSQL for tests, started by the test itself in a separate folder and stopped with it. It refuses to run
//! as root, so then it runs as the user `postgres` or `nobody`.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // in a test a panic is the report, and a skip is said

use postgres::{Client, NoTls};
use std::net::TcpListener;
use std::os::unix::fs::chown;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// A running server.
pub struct Server {
    programs: PathBuf,
    dir: tempfile::TempDir,
    port: u16,
    user: Option<u32>,
    child: Child,
    databases: AtomicU32,
}

impl Server {
    /// Starts a server; `None`, with a message, on a machine without PostgreSQL.
    pub fn start() -> Option<Self> {
        let Some(programs) = programs() else {
            crate::require::skipped("postgres", "no PostgreSQL");
            return None;
        };
        let dir = tempfile::tempdir().unwrap();
        let user = is_root().then(other_user);
        if let Some(user) = user {
            chown(dir.path(), Some(user), None).unwrap();
        }
        let data = dir.path().join("data");
        let made = command(&programs.join("initdb"), user)
            .args(["-U", "whyroad", "-A", "trust", "-E", "UTF8", "--locale=C", "--no-sync", "-D"])
            .arg(&data)
            .output()
            .unwrap();
        assert!(made.status.success(), "initdb: {}", String::from_utf8_lossy(&made.stderr));
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let child = run(&programs, dir.path(), port, user);
        let server = Self { programs, dir, port, user, child, databases: AtomicU32::new(0) };
        server.wait();
        Some(server)
    }

    fn url_of(&self, database: &str) -> String {
        format!("postgres://whyroad@127.0.0.1:{}/{database}", self.port)
    }

    /// The URL of a new, empty database.
    pub fn database(&self) -> String {
        let name = format!("test{}", self.databases.fetch_add(1, Ordering::SeqCst));
        let mut client = Client::connect(&self.url_of("postgres"), NoTls).unwrap();
        client.batch_execute(&format!("CREATE DATABASE {name}")).unwrap();
        self.url_of(&name)
    }

    /// Stops the server immediately, as after a crash of its process (without losing data that the system has), and
    /// starts it again after `away`.
    pub fn restart(&mut self, away: Duration) {
        self.stop();
        std::thread::sleep(away);
        self.child = run(&self.programs, self.dir.path(), self.port, self.user);
        self.wait();
    }

    /// Suspends the server and its processes: connections stay open, and nothing is answered, as on a machine that
    /// hangs.
    pub fn hang(&self) {
        self.signal("STOP");
    }

    /// Ends [`Self::hang`].
    pub fn resume(&self) {
        self.signal("CONT");
    }

    fn signal(&self, name: &str) {
        let parent = self.child.id();
        let of = |stat: String| -> Option<u32> {
            stat.rsplit(')').next()?.split_whitespace().nth(1)?.parse().ok()
        };
        let is_child = |pid: &u32| {
            std::fs::read_to_string(format!("/proc/{pid}/stat")).ok().and_then(of) == Some(parent)
        };
        let all = std::fs::read_dir("/proc").into_iter().flatten().flatten();
        let all = all.filter_map(|e| e.file_name().to_str()?.parse().ok());
        // The parent first, so that it starts no others.
        for pid in std::iter::once(parent).chain(all.filter(is_child)) {
            let _ = Command::new("kill").args([format!("-{name}"), pid.to_string()]).status();
        }
    }

    /// `pg_ctl stop -m immediate` stops the postmaster and all its children.
    fn stop(&mut self) {
        self.resume();
        let mut stop = command(&self.programs.join("pg_ctl"), self.user);
        let _ = stop.args(["stop", "-m", "immediate", "-D"]).arg(self.dir.path().join("data")).output();
        let _ = self.child.wait();
    }

    fn wait(&self) {
        let start = Instant::now();
        while let Err(e) = Client::connect(&self.url_of("postgres"), NoTls) {
            assert!(start.elapsed() < Duration::from_secs(30), "PostgreSQL does not answer: {e}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop();
    }
}

fn run(programs: &Path, dir: &Path, port: u16, user: Option<u32>) -> Child {
    let mut postgres = command(&programs.join("postgres"), user);
    postgres.arg("-D").arg(dir.join("data")).arg("-k").arg(dir).arg("-p").arg(port.to_string());
    postgres.args(["-c", "listen_addresses=127.0.0.1", "-c", "max_connections=200"]);
    postgres.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

fn command(program: &Path, user: Option<u32>) -> Command {
    let mut command = Command::new(program);
    command.current_dir("/");
    if let Some(user) = user {
        command.uid(user);
    }
    command
}

/// Folder of `postgres` and `initdb`: from `pg_config`, else the newest of Debian's folders.
fn programs() -> Option<PathBuf> {
    let told = Command::new("pg_config").arg("--bindir").output().ok().filter(|o| o.status.success());
    let told = told.map(|o| PathBuf::from(String::from_utf8_lossy(&o.stdout).trim()));
    let version = |p: &PathBuf| p.parent()?.file_name()?.to_str()?.parse::<u32>().ok();
    let debian = std::fs::read_dir("/usr/lib/postgresql").ok().into_iter().flatten().flatten();
    let newest = debian.map(|e| e.path().join("bin")).max_by_key(version);
    told.into_iter().chain(newest).find(|p| p.join("postgres").is_file() && p.join("initdb").is_file())
}

fn is_root() -> bool {
    let id = Command::new("id").arg("-u").output().unwrap();
    String::from_utf8_lossy(&id.stdout).trim() == "0"
}

fn other_user() -> u32 {
    let users = std::fs::read_to_string("/etc/passwd").unwrap();
    let id = |name: &str| {
        let line = users.lines().find_map(|l| l.strip_prefix(&format!("{name}:")))?;
        line.split(':').nth(1)?.parse().ok()
    };
    id("postgres").or_else(|| id("nobody")).expect("a user other than root")
}
