//! The labeling service under load: `cargo bench -p whyroad --bench serve [-- ANNOTATORS SECONDS]` (200 and 20 unless
//! said). `serve/<n>`: n annotators, each with a separate task and connection, each saving a
//! change every second, as the page does while somebody types. The service is the real one, on SQLite in a temporary
//! folder; every answer was given after its commit was on disk. `WHYROAD_BIN` names another build of the program.
#![allow(clippy::print_stdout, clippy::unwrap_used)] // printing is what a bench is for; a panic is its report

#[path = "../tests/it/service/mod.rs"]
mod service;

use serde_json::json;
use service::http::Client;
use service::storm::Annotator;
use service::{Service, annotators};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Between two saves of one annotator.
const EVERY: Duration = Duration::from_secs(1);

fn main() {
    let numbers: Vec<u64> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let people = numbers.first().map_or(200, |n| *n as usize);
    let seconds = numbers.get(1).copied().unwrap_or(20);
    let data = tempfile::tempdir().unwrap();
    let service = Service::start(&["--data", data.path().to_str().unwrap()]);
    let mut admin = Client::set_up(service.at, "admin");
    // Ten people on each of the few episodes, each for themselves; further projects until there is work for all.
    let tasks = json!({"mined": "mined", "overlap": 10});
    let mut crew: Vec<Annotator> = Vec::new();
    for number in 0.. {
        let made = admin.post("/projects", &json!({"name": format!("load {number}")})).good();
        let project = made["id"].as_str().unwrap();
        let made = admin.post(&format!("/projects/{project}/tasks:create"), &tasks).good();
        let until = people.min(crew.len() + made["tasks"].as_array().unwrap().len());
        let tokens = annotators(&mut admin, service.at, project, crew.len()..until);
        crew.extend(tokens.iter().map(|t| Annotator::begin(service.at, t, project)));
        if crew.len() == people {
            break;
        }
    }

    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for (i, annotator) in crew.iter_mut().enumerate() {
            let stop = &stop;
            scope.spawn(move || {
                // People do not save all at the same moment.
                std::thread::sleep(EVERY.mul_f64(i as f64 / people as f64));
                annotator.save_until(stop, EVERY);
            });
        }
        std::thread::sleep(Duration::from_secs(seconds));
        stop.store(true, Ordering::Relaxed);
    });

    let mut times: Vec<f64> = crew.iter().flat_map(|a| a.seconds.iter().copied()).collect();
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize] * 1000.0;
    let refused: Vec<&String> = crew.iter().flat_map(|a| &a.refused).collect();
    println!(
        "serve/{people}: {} saves in {seconds} s, p50 {:.1} ms, p99 {:.1} ms, worst {:.1} ms, errors {}",
        times.len(),
        at(0.5),
        at(0.99),
        at(1.0),
        refused.len()
    );
    refused.iter().take(5).for_each(|r| println!("  {r}"));
    let lost = crew.iter_mut().map(|a| u64::from(a.stored() != a.saved)).sum::<u64>();
    println!("serve/{people}: {lost} of {people} drafts differ from what was acknowledged");
}
