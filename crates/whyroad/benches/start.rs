//! The labeling service with large mined folders: `cargo bench -p whyroad --bench start [-- EPISODES TASKS]`
//! (1,000,000 and 350). `start/<episodes>`: from the start of the program until it answers, three times.
//! `browse/<episodes>`: the first page of the episodes, and one of a class. `create/<tasks>`: tasks of as many drives,
//! until they are there, while somebody saves every 50 ms, and until the last draft is made in the background.
//! `WHYROAD_BIN` names another build of the program.
#![allow(clippy::print_stdout, clippy::unwrap_used)] // printing is what a bench is for; a panic is its report

#[path = "../tests/it/service/mod.rs"]
mod service;

use serde_json::json;
use service::http::Client;
use service::storm::Annotator;
use service::{Service, annotators, demo, mined_folder};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use whyroad_lake::mined::{Existing, MinedFolderWriter};
use whyroad_lake::{Lake, MinedFolder};
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{ClipId, DriveId};

/// A lake of `n` drives, the bundled ones under other ids, and a mined folder with an episode of each.
fn many_drives(at: &Path, n: usize) {
    let (from, lake) =
        (Lake::open(demo().join("lake")).unwrap(), Lake::create_or_open(at.join("lake")).unwrap());
    let mined = MinedFolder::open(demo().join("mined")).unwrap();
    let few: Vec<_> = mined.episodes().unwrap().map(Result::unwrap).collect();
    let question = mined.question().unwrap();
    let mut out = MinedFolderWriter::create(&at.join("many"), question, Existing::default()).unwrap();
    for i in 0..n {
        let episode = &few[i % few.len()];
        let mut drive = from.read_drive(&episode.drive_id).unwrap();
        let id = DriveId::from(format!("copy{i:04}").as_str());
        drive.meta.drive_id = id.clone();
        drive.meta.content_hash = format!("{}-{i}", drive.meta.content_hash);
        lake.write_drive(&drive).unwrap();
        let clip = episode.clip_id.as_str().replace(episode.drive_id.as_str(), id.as_str());
        let episode_id = format!("{id}_e");
        let clip_id = ClipId::from(clip.as_str());
        out.episode(&EpisodeRecord { episode_id, clip_id, drive_id: id, ..episode.clone() }).unwrap();
    }
    out.finish().unwrap();
    // As `mine` leaves the lake.
    let program = std::env::var_os("WHYROAD_BIN").unwrap_or_else(|| env!("CARGO_BIN_EXE_whyroad").into());
    let derived = Command::new(program).args(["signals", "derive", "--lake"]).arg(at.join("lake")).status();
    assert!(derived.unwrap().success());
}

fn main() {
    let numbers: Vec<usize> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let episodes = numbers.first().copied().unwrap_or(1_000_000);
    let tasks = numbers.get(1).copied().unwrap_or(350);
    let dir = tempfile::tempdir().unwrap();
    let mined = dir.path().join("large");
    let begun = Instant::now();
    mined_folder(&mined, episodes);
    println!("(the folder was written in {:.1} s)", begun.elapsed().as_secs_f64());
    let data = dir.path().join("data").display().to_string();
    many_drives(dir.path(), tasks);
    let many = dir.path().join("many").display().to_string();
    let start =
        || Service::start_mined(&dir.path().join("lake"), &mined, &["--mined", &many, "--data", &data]);
    let mut service = None;
    for _ in 0..3 {
        drop(service.take());
        let begun = Instant::now();
        let running = start();
        assert_eq!(Client::new(running.at).get("/healthz").status, 200);
        println!("start/{episodes}: {:.2} s", begun.elapsed().as_secs_f64());
        service = Some(running);
    }
    let service = service.unwrap();
    let mut admin = Client::set_up(service.at, "admin");
    let project =
        admin.post("/projects", &json!({ "name": "first", "settings": { "history": "episode" } })).good();
    let project = project["id"].as_str().unwrap();
    for query in ["limit=50", "limit=50&scenario=reactive_agent"] {
        let begun = Instant::now();
        let page = admin.get(&format!("/projects/{project}/mined/large/episodes?{query}")).good();
        assert!(page["total"].as_u64().unwrap() > 0, "{page}");
        println!("browse/{episodes}?{query}: {:.3} s", begun.elapsed().as_secs_f64());
    }

    // Somebody works meanwhile.
    let make = |admin: &mut Client, n: usize| {
        let body = json!({ "mined": "many", "limit": n, "secondary": true });
        admin.post(&format!("/projects/{project}/tasks:create"), &body).good()
    };
    make(&mut admin, 2);
    let token = annotators(&mut admin, service.at, project, 0..1).remove(0);
    let mut worker = Annotator::begin(service.at, &token, project);
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| worker.save_until(&stop, Duration::from_millis(50)));
        let begun = Instant::now();
        let made = make(&mut admin, tasks)["tasks"].as_array().unwrap().len();
        println!("create/{made}: {:.2} s until the tasks are there", begun.elapsed().as_secs_f64());
        let mut pending = made;
        while pending > 0 {
            std::thread::sleep(Duration::from_millis(200));
            let work = admin.get(&format!("/projects/{project}/work")).good();
            pending = work["pending"].as_u64().unwrap() as usize;
        }
        println!("create/{made}: {:.1} s until the last draft is made", begun.elapsed().as_secs_f64());
        stop.store(true, Ordering::Relaxed);
    });
    let mut times = worker.seconds.clone();
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize] * 1000.0;
    println!("save meanwhile: {} saves, p50 {:.1} ms, p99 {:.1} ms", times.len(), at(0.5), at(0.99));
    assert!(worker.refused.is_empty(), "{:?}", worker.refused);
}
