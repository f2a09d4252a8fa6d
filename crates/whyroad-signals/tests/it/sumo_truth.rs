//! Signals against the simulator's own outputs (examples/truth, made by its make.py). Every expected value here is
//! SUMO's; thresholds are what a sound implementation must reach, with room for the classes of difference that
//! docs/reference/accuracy.md explains. Figures: `cargo test -p whyroad-signals --test it sumo_truth -- --nocapture
//! --test-threads 1`.

mod conflicts;
mod errors;
mod lane_changes;
mod lanes;
mod leads;
mod lights;
mod simulation;
mod standing;

use simulation::{Derived, GRID, MOTORWAY, Simulation};
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// One simulation and what we make of it, seen from each ego.
pub struct Run {
    pub truth: Simulation,
    pub seen_from: BTreeMap<&'static str, Derived>,
}

fn run(which: (&'static str, &'static [&'static str])) -> Run {
    let truth = Simulation::read(which);
    let seen_from = std::thread::scope(|scope| {
        let threads: Vec<_> = which
            .1
            .iter()
            .map(|&ego| {
                (
                    ego,
                    scope.spawn({
                        let truth = &truth;
                        move || truth.derived(ego)
                    }),
                )
            })
            .collect();
        threads.into_iter().map(|(ego, t)| (ego, t.join().expect("derived"))).collect()
    });
    Run { truth, seen_from }
}

pub static GRID_RUN: LazyLock<Run> = LazyLock::new(|| run(GRID));
pub static MOTORWAY_RUN: LazyLock<Run> = LazyLock::new(|| run(MOTORWAY));

/// Counts by name.
#[derive(Default, Debug)]
pub struct Tally(BTreeMap<&'static str, usize>);

impl Tally {
    pub fn add(&mut self, what: &'static str) {
        *self.0.entry(what).or_default() += 1;
    }

    pub fn get(&self, what: &str) -> usize {
        self.0.get(what).copied().unwrap_or(0)
    }

    pub fn total(&self) -> usize {
        self.0.values().sum()
    }

    /// Share of all that is one of `what`.
    pub fn share(&self, what: &[&str]) -> f64 {
        what.iter().map(|w| self.get(w)).sum::<usize>() as f64 / self.total().max(1) as f64
    }

    pub fn line(&self) -> String {
        let parts: Vec<String> = self.0.iter().map(|(k, n)| format!("{k} {n}")).collect();
        parts.join(", ")
    }
}

/// The edge of a lane.
pub fn edge(lane: &str) -> &str {
    lane.rsplit_once('_').map_or(lane, |p| p.0)
}
