//! Single rules against query engines: the same question, the same files, the same answer.

use crate::cost::{Cost, timed};
use crate::data::{self, Stored};
use rayon::prelude::*;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use whyroad_engine::mine::find_stored;
use whyroad_mining::fast::Plan;
use whyroad_mining::rule::text::compile_text;
use whyroad_model::Nanos;
use whyroad_signals::Catalog;

/// A question in the rule language, and as the condition of a row and a least duration for the peers.
pub struct Question {
    name: &'static str,
    rule: &'static str,
    /// What a row must fulfill, as SQL.
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

    /// What it took, and the number of episodes.
    fn ask(&mut self, q: &Question) -> Option<(Cost, usize)> {
        let stdin = self.child.stdin.as_mut()?;
        writeln!(stdin, "{}\t{}", q.sql, q.least_ns).ok()?;
        let mut line = String::new();
        self.answers.read_line(&mut line).ok()?;
        let mut words = line.split_whitespace();
        let (seconds, cpu) = (words.next()?.parse().ok()?, words.next()?.parse().ok()?);
        Some((Cost { seconds, cpu }, words.next()?.parse().ok()?))
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        drop(self.child.stdin.take());
        let _ = self.child.wait();
    }
}

/// Each question to each engine in turn.
pub fn run(dir: &Path, folders: &[PathBuf], total: usize, rounds: usize) {
    let mut peers: Vec<Peer> = ["duckdb", "polars"].into_iter().filter_map(|n| Peer::start(n, dir)).collect();
    for q in QUESTIONS {
        let class = "proactive.turn.straight".parse().expect("a class");
        let mut rule = compile_text(q.rule, None, &class, Catalog::bundled(), "bench").expect("a rule");
        rule.merge_gap = Nanos(0);
        let plan = Plan::of_rules([&rule]);
        let one =
            |s: &Stored| find_stored(&plan, &s.file, s.drive, &[0]).expect("readable")[0].episodes.len();
        // Like the peers, from the closed files on.
        let ours = || -> usize { data::open(folders).par_iter().with_max_len(1).map(one).sum() };
        let mut best = vec![Cost::WORST; peers.len() + 1];
        let mut counts = vec![0; peers.len() + 1];
        for _ in 0..rounds {
            let asked = peers.iter_mut().map(|peer| peer.ask(q).expect("an answer"));
            for (k, (cost, episodes)) in std::iter::once(timed(ours)).chain(asked).enumerate() {
                best[k] = best[k].least(cost);
                counts[k] = episodes;
            }
        }
        print!("mine/one/{total} {} ({}): {} episodes {}", q.name, q.rule, counts[0], best[0]);
        for (k, peer) in peers.iter().enumerate() {
            let (theirs, episodes) = (best[k + 1], counts[k + 1]);
            let ratio = theirs.seconds / best[0].seconds;
            print!("; {} {episodes} episodes {theirs}, {ratio:.1} x", peer.name);
        }
        println!();
    }
}
