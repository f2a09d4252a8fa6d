//! Every target runs a few times in `cargo test`: its seeds are accepted, changed ones accepted or refused, never a
//! panic.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::time::Duration;
use whyroad_fuzz::harness::{Begin, Limit, run};

/// Small seeds of these are what is left of a file when rows are cut away that others need: of the whole file, or of
/// all seeds together, at least one is accepted.
#[test]
fn every_target_accepts_a_seed_and_survives_some_mutations() {
    let folder = tempfile::tempdir().unwrap();
    let targets = whyroad_fuzz::all();
    let names: BTreeSet<&str> = targets.iter().map(|t| t.name.as_str()).collect();
    assert_eq!(names.len(), targets.len(), "two targets have one name");
    assert!(targets.len() > 80, "{}", targets.len());
    let mut broken = Vec::new();
    for target in &targets {
        let seeds = || target.small.iter().chain(&target.seeds);
        assert!(!target.seeds.is_empty() && seeds().all(|s| !s.is_empty()), "{}", target.name);
        let taken = seeds().filter(|s| (target.run)(s)).count();
        if taken == 0 || target.small.is_empty() && taken < seeds().count() {
            broken.push(format!("{}: {taken} of {} seeds are accepted", target.name, seeds().count()));
        }
        let limit = Limit { executions: 60, time: Duration::from_millis(200) };
        let outcome = run(target, 7, limit, Begin::New, folder.path());
        assert!(outcome.executions > 0);
        broken
            .extend(outcome.failures.iter().map(|f| format!("{} {}: {}", target.name, f.execution, f.what)));
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}
