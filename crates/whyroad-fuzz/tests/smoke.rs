//! Every target runs a few times in `cargo test`: its seeds are accepted or refused, never a panic.
#![allow(clippy::unwrap_used)]

use std::time::Duration;
use whyroad_fuzz::harness::{Begin, Limit, run};

#[test]
fn every_target_survives_some_mutations() {
    let folder = tempfile::tempdir().unwrap();
    let targets = whyroad_fuzz::all();
    assert!(targets.len() > 30, "{}", targets.len());
    let mut broken = Vec::new();
    for target in &targets {
        assert!(
            !target.seeds.is_empty() && target.seeds.iter().chain(&target.small).all(|s| !s.is_empty()),
            "{}",
            target.name
        );
        let limit = Limit { executions: 60, time: Duration::from_millis(200) };
        let outcome = run(target, 7, limit, Begin::New, folder.path());
        assert!(outcome.executions > 0);
        broken
            .extend(outcome.failures.iter().map(|f| format!("{} {}: {}", target.name, f.execution, f.what)));
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}
