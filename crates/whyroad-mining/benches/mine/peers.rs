//! Single rules against query engines: the same question, the same files, the same answer.

use crate::data::Stored;
use crate::timed;
use rayon::prelude::*;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use whyroad_lake::SignalFile;
use whyroad_mining::engine::find_stored;
use whyroad_mining::fast::Plan;
use whyroad_mining::rule::text::compile_text;
use whyroad_model::Nanos;
use whyroad_signals::Catalogue;

/// A question in the rule language, and as the condition of a row and a least duration for the peers.
pub struct Question {
    name: &'static str,
    rule: &'static str,
    /// What a row must fulfil, as SQL.
    sql: &'static str,
    /// For how long, in ns, by 10 ms less: the tolerance of a clock.
    least_ns: i64,
    /// Signals that it reads.
    pub signals: &'static [&'static str],
}

/// Often true, seldom true, and two conditions of which one is about the ego (a join for the peers).
pub const QUESTIONS: &[Question] = &[
    Question {
        name: "dense",
        rule: "target.distance < 40 m for 1 s",
        sql: "\"target.distance\" < 40",
        least_ns: 990_000_000,
        signals: &["target.distance"],
    },
    Question {
        name: "sparse",
        rule: "target.ttc < 3 s and target.in_ego_lane for 0.5 s",
        sql: "\"target.ttc\" < 3 AND \"target.in_ego_lane\"",
        least_ns: 490_000_000,
        signals: &["target.ttc", "target.in_ego_lane"],
    },
    Question {
        name: "join",
        rule: "target.distance < 20 m and ego.speed > 5 m/s for 0.5 s",
        sql: "\"target.distance\" < 20 AND \"ego.speed\" > 5",
        least_ns: 490_000_000,
        signals: &["target.distance", "ego.speed"],
    },
];

/// A Python that answers questions line by line.
struct Peer {
    name: &'static str,
    child: Child,
    answers: BufReader<std::process::ChildStdout>,
}

impl Peer {
    fn start(name: &'static str, dir: &Path) -> Option<Self> {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/mine/peer.py");
        let mut child = Command::new("python3")
            .args([script, name])
            .arg(dir)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut answers = BufReader::new(child.stdout.take()?);
        let mut line = String::new();
        answers.read_line(&mut line).ok()?;
        if line.trim() != "ready" {
            println!("{name}: skipped: Python lacks it");
            let _ = child.wait();
            return None;
        }
        Some(Self { name, child, answers })
    }

    /// Seconds and number of episodes.
    fn ask(&mut self, q: &Question) -> Option<(f64, usize)> {
        let stdin = self.child.stdin.as_mut()?;
        writeln!(stdin, "{}\t{}", q.sql, q.least_ns).ok()?;
        let mut line = String::new();
        self.answers.read_line(&mut line).ok()?;
        let (seconds, episodes) = line.trim().split_once(' ')?;
        Some((seconds.parse().ok()?, episodes.parse().ok()?))
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        drop(self.child.stdin.take());
        let _ = self.child.wait();
    }
}

/// Each question to each engine in turn.
pub fn run(dir: &Path, stored: &[Stored], total: usize, rounds: usize) {
    let mut folders: Vec<&Path> = stored.iter().map(|s| s.folder.as_path()).collect();
    folders.dedup();
    let mut peers: Vec<Peer> = ["duckdb", "polars"].into_iter().filter_map(|n| Peer::start(n, dir)).collect();
    for q in QUESTIONS {
        let class = "proactive.turn.straight".parse().expect("a class");
        let mut rule = compile_text(q.rule, None, &class, Catalogue::bundled(), "bench").expect("a rule");
        rule.merge_gap = Nanos(0);
        let plan = Plan::of_rules([&rule]);
        let ours = || -> usize {
            // Like the peers, from the closed files on.
            let opened: Vec<SignalFile> =
                folders.par_iter().map(|f| SignalFile::open(f).expect("readable").expect("there")).collect();
            let stored: Vec<(&SignalFile, usize)> =
                opened.iter().flat_map(|f| (0..f.contents().drives.len()).map(move |d| (f, d))).collect();
            let one = |(file, drive): &(&SignalFile, usize)| {
                find_stored(&plan, file, *drive, &[0]).expect("readable")[0].episodes.len()
            };
            stored.par_iter().with_max_len(1).map(one).sum()
        };
        let mut best = vec![f64::INFINITY; peers.len() + 1];
        let mut counts = vec![0; peers.len() + 1];
        for _ in 0..rounds {
            let (seconds, episodes) = timed(ours);
            best[0] = best[0].min(seconds);
            counts[0] = episodes;
            for (k, peer) in peers.iter_mut().enumerate() {
                let (seconds, episodes) = peer.ask(q).expect("an answer");
                best[k + 1] = best[k + 1].min(seconds);
                counts[k + 1] = episodes;
            }
        }
        print!("mine/one/{total} {} ({}): {} episodes {:.3} s", q.name, q.rule, counts[0], best[0]);
        for (k, peer) in peers.iter().enumerate() {
            print!(
                "; {} {} episodes {:.3} s, {:.1} x",
                peer.name,
                counts[k + 1],
                best[k + 1],
                best[k + 1] / best[0]
            );
        }
        println!();
    }
}
