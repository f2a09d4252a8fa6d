//! Making tasks whose drafts come later: which drives are read, and when.

use super::*;
use crate::service::fixtures::{self, Counted};
use crate::service::{drafting, thumbnail};
use serde_json::json;
use std::sync::atomic::Ordering;

/// `count` episodes of as many drives, and one of a drive that is not there.
fn request(count: usize) -> CreateTasks {
    let of = |n: usize, drive: &str| {
        let mut e = fixtures::episode(&format!("e{n}"));
        e["scenario_id"] = json!("reactive_agent.cutin.urgent");
        e["drive_id"] = json!(drive);
        e
    };
    let mut episodes: Vec<Value> = (0..count).map(|n| of(n, &format!("d{n}"))).collect();
    episodes.push(of(count, "absent"));
    serde_json::from_value(json!({ "episodes": episodes })).unwrap()
}

fn read(recordings: &Counted) -> usize {
    recordings.read.load(Ordering::SeqCst)
}

#[test]
fn tasks_whose_drafts_come_later_read_no_drive() {
    let (app, recordings, _dir) = fixtures::counted();
    let made = create(&app, "p", &request(60), None, Drafting::Later).unwrap();
    assert_eq!((made.tasks.len(), made.lost.len()), (60, 1));
    assert_eq!(made.lost[0].text.en, "no such drive", "a drive that is not there is reported at once");
    assert_eq!(read(&recordings), 0);
    // Whoever opens one has its draft and picture made then.
    let id = made.tasks[0].clone();
    let pictured = |id: &str| app.store.read(|tx| thumbnail::get(tx, id)).unwrap().is_some();
    assert!(!pictured(&id));
    let t = drafting::ready(&app, app.store.read(|tx| tasks::get(tx, &id)).unwrap()).unwrap();
    assert!(!t.pending && t.draft["coc_trace"] == "drafted", "{}", t.draft);
    assert!(pictured(&id) && !pictured(&made.tasks[1]));
    assert_eq!(read(&recordings), 1);
}

#[test]
fn tasks_with_their_drafts_read_each_drive_once() {
    let (app, recordings, _dir) = fixtures::counted();
    let made = create(&app, "p", &request(5), None, Drafting::Now).unwrap();
    assert_eq!((made.tasks.len(), made.lost.len(), read(&recordings)), (5, 1, 6));
    assert!(app.store.read(|tx| thumbnail::get(tx, &made.tasks[4])).unwrap().is_some());
}

#[test]
fn an_episode_outside_its_drive_is_reported() {
    let (app, recordings, _dir) = fixtures::counted();
    let mut late = fixtures::episode("late");
    late["scenario_id"] = json!("reactive_agent.cutin.urgent");
    late["keyframe"]["timestamp"] = json!("2026-01-01T00:01:00Z");
    let request = serde_json::from_value(json!({ "episodes": [late] })).unwrap();
    let made = create(&app, "p", &request, None, Drafting::Later).unwrap();
    assert!(made.tasks.is_empty() && made.lost[0].text.zh.contains("不在行程内"), "{:?}", made.lost);
    assert_eq!(read(&recordings), 0);
}
