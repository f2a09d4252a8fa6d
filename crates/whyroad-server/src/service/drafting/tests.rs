//! Drafts in the background: equal to immediate ones, each drive read once, progress, and distribution among workers.

use super::*;
use crate::domain::task::CreateTasks;
use crate::domain::workflow::Role;
use crate::service::create::{Drafting, create};
use crate::service::{fixtures, work};
use serde_json::{Value, json};
use std::sync::atomic::Ordering;

/// Episodes: 20 drives with 3 each.
fn request() -> CreateTasks {
    let episode = |n: usize| {
        let mut e = fixtures::episode(&format!("e{n}"));
        e["scenario_id"] = json!("reactive_agent.cutin.urgent");
        e["drive_id"] = json!(format!("d{}", n / 3));
        e
    };
    let episodes: Vec<Value> = (0..60).map(episode).collect();
    serde_json::from_value(json!({ "episodes": episodes })).unwrap()
}

/// Draft and thumbnail of each task, by episode.
fn drafts(app: &App) -> Vec<(String, Value, Option<String>)> {
    let mut all: Vec<(String, Value, Option<String>)> = app
        .store
        .read(|tx| {
            let ids = tx.rows("SELECT id FROM tasks", &[])?;
            let one = |id: String| -> Answer<_> {
                let t = tasks::get(tx, &id)?;
                Ok((t.episode.episode_id, t.draft, thumbnail::get(tx, &id)?))
            };
            ids.iter().map(|r| r.text("id")).collect::<Answer<Vec<_>>>()?.into_iter().map(one).collect()
        })
        .unwrap();
    all.sort_by(|(a, ..), (b, ..)| a.cmp(b));
    all
}

fn left(app: &App) -> i64 {
    app.store.read(|tx| work::of(tx, "p", "lead", &[Role::Lead], 0)).unwrap().pending
}

#[test]
fn drafts_in_the_background_are_those_made_at_once() {
    let (at_once, _, _dir) = fixtures::counted();
    create(&at_once, "p", &request(), None, Drafting::Now).unwrap();
    let (app, recordings, _dir) = fixtures::counted();
    create(&app, "p", &request(), None, Drafting::Later).unwrap();
    let (app, turns) = (Arc::new(app), Turns::default());
    let mut progress = vec![left(&app)];
    while let Some(batch) = turns.next(&app).unwrap() {
        make(&Arc::downgrade(&app), &batch).unwrap();
        progress.push(left(&app));
    }
    assert_eq!((progress[0], progress.last()), (60, Some(&0)));
    assert!(progress.len() > 3 && progress.is_sorted_by(|a, b| a > b), "{progress:?}");
    assert_eq!(recordings.read.load(Ordering::SeqCst), 20, "each drive is read once");
    // Each drive as a whole, and each task's part up to its keyframe.
    assert_eq!(recordings.derived.load(Ordering::SeqCst), 20 + 60);
    assert_eq!(drafts(&app), drafts(&at_once));
}

#[test]
fn no_task_is_in_two_hands() {
    let (app, _, _dir) = fixtures::counted();
    create(&app, "p", &request(), None, Drafting::Later).unwrap();
    let turns = Turns::default();
    let mut batches = Vec::new();
    while let Some(batch) = turns.next(&app).unwrap() {
        batches.push(batch);
    }
    let mut all: Vec<&String> = batches.iter().flat_map(|b| &b.tasks).collect();
    all.sort();
    all.dedup();
    assert_eq!((all.len(), batches.iter().map(|b| b.tasks.len()).sum()), (60, 60));
    // Tasks of a dropped batch are available to the next one.
    batches.pop();
    assert!(turns.next(&app).unwrap().is_some());
}

#[test]
fn a_draft_that_cannot_be_made_holds_nothing_up() {
    let (app, _, _dir) = fixtures::counted();
    create(&app, "p", &request(), None, Drafting::Later).unwrap();
    let gone = r#"UPDATE tasks SET episode = replace(episode, '"d7"', '"absent"') WHERE drive_id = 'd7'"#;
    app.store.write(move |tx| tx.run(gone, &[])).unwrap();
    let (app, turns) = (Arc::new(app), Turns::default());
    while let Some(batch) = turns.next(&app).unwrap() {
        make(&Arc::downgrade(&app), &batch).unwrap();
    }
    let count = "SELECT count(*) AS n FROM tasks WHERE pending = $1";
    let of = |pending: i64| app.store.read(|tx| tx.row(count, values![pending])?.unwrap().int("n")).unwrap();
    assert_eq!((of(0), of(PENDING), of(FAILED)), (57, 0, 3));
}

#[test]
fn a_worker_takes_a_drive_and_more_only_while_they_are_few() {
    let free = |sizes: &[usize]| -> Vec<(String, String)> {
        let of = |(d, n): (usize, &usize)| (0..*n).map(move |i| (format!("d{d}_{i}"), format!("d{d}")));
        sizes.iter().enumerate().flat_map(of).collect()
    };
    assert_eq!(some_of(&free(&[40, 1]), 0).len(), 40);
    assert_eq!(some_of(&free(&[40, 1]), 1), ["d1_0"]);
    assert_eq!(some_of(&free(&[10, 10, 10]), 3).len(), 20);
    assert!(some_of(&[], 5).is_empty());
}
