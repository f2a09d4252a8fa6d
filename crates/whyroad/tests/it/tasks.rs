//! `whyroad tasks`, `backup` and `restore` as a user runs them, on the bundled drives.
#![allow(clippy::unwrap_used)] // in a test a panic is the report

use crate::service::http::Client;
use crate::service::{Service, crew, demo, mined_folder};
use crate::session::{Run, whyroad_in};
use serde_json::{Value, json};
use std::path::Path;
use whyroad_server::store::Store;

fn run(folder: &Path, line: &str) -> Run {
    let demo = demo().display().to_string();
    let line = line.replace("DEMO", &demo);
    whyroad_in(folder, &line.split(' ').collect::<Vec<_>>())
}

/// What a successful run printed.
#[track_caller]
fn good(folder: &Path, line: &str) -> String {
    let run = run(folder, line);
    assert_eq!(run.code, 0, "{line}: {}{}", run.out, run.err);
    run.out
}

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|l| serde_json::from_str(l).unwrap()).collect()
}

/// More episodes than one request may carry: 48 h of sparse traffic have 29,000.
#[test]
fn a_mined_folder_of_29_000_episodes_is_served_and_makes_tasks() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    mined_folder(&at.join("large"), 29_000);
    let data = at.join("data").display().to_string();
    let service = Service::start_mined(&demo().join("lake"), &at.join("large"), &["--data", &data]);
    let mut admin = Client::set_up(service.at, "admin");
    assert_eq!(
        admin.get("/projects").good()["items"],
        json!([]),
        "no project of its own for a lake that was given"
    );
    let project =
        admin.post("/projects", &json!({ "name": "first" })).good()["id"].as_str().unwrap().to_owned();
    let page = admin.get(&format!("/projects/{project}/mined/large/episodes?limit=10")).good();
    assert_eq!((page["total"].as_u64(), page["items"].as_array().unwrap().len()), (Some(29_000), 10));
    let body = json!({ "mined": "large", "limit": 12 });
    let made = admin.post(&format!("/projects/{project}/tasks:create"), &body).good();
    assert_eq!(made["tasks"].as_array().unwrap().len(), 12);
    assert_eq!((&made["left_out"], &made["over_limit"]), (&json!(29_000 - 12), &json!(29_000 - 12)));
    drop(service);
    let (large, lake) = (at.join("large").display().to_string(), demo().join("lake").display().to_string());
    let line = format!("tasks create --from {large} --lake {lake} --project p --limit 3 --data other");
    assert!(good(at, &line).starts_with(
        "3 tasks created; 0 already present, 28997 not selected (28997 over a limit, 0 secondary"
    ));
}

#[test]
fn tasks_are_made_listed_exported_and_brought_in_again() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    // The lake is the one beside the mined folder.
    let made = good(at, "tasks create --from DEMO/mined --project p --limit 6 --overlap 2 --priority 5");
    let reasons = made.strip_prefix("6 tasks created; 0 already present, 5 not selected (").unwrap();
    let none =
        " 0 of no or an unknown class, 0 with the first frame of the drive as keyframe), 0 without a drive\n";
    assert!(reasons.ends_with(none), "{made}");
    let again = good(at, "tasks create --from DEMO/mined --project p --limit 6 --overlap 2");
    assert!(again.contains("3 already present"), "{again}");
    assert_eq!(good(at, "tasks list").split("  ").next(), Some("p"));
    let open = good(at, "tasks list --project p --state open");
    assert!(open.lines().count() >= 6 && open.lines().all(|l| l.contains("  open  ")), "{open}");
    assert_eq!(good(at, "tasks list --project p --state accepted"), "");

    assert_eq!(good(at, "tasks export --project p"), "", "nothing is accepted yet");
    let tasks = good(at, "tasks export --project p --content tasks");
    let first = &lines(&tasks)[0]["task"];
    assert_eq!((&first["state"], &first["history"][0]["action"]), (&json!("open"), &json!("create")));
    // Of an episode with several labels one has to be chosen before.
    assert_eq!(good(at, "tasks export --project p --state open"), "");
    good(at, "tasks create --from DEMO/mined --project s --limit 6");
    let drafts = good(at, "tasks export --project s --state open --format-version 2.0");
    assert!(
        !drafts.is_empty()
            && lines(&drafts).iter().all(|l| l["version"] == "2.0.0" && l.get("causes").is_none())
    );

    // Tasks as they are, then drafts as labels.
    let count = lines(&tasks).len();
    std::fs::write(at.join("tasks.jsonl"), &tasks).unwrap();
    std::fs::write(
        at.join("labels.jsonl"),
        good(at, "tasks export --project s --state open") + "not a line\n",
    )
    .unwrap();
    let back = good(at, "tasks import tasks.jsonl --project q --lake DEMO/lake");
    assert_eq!(back, format!("{count} tasks created; 0 already present; 0 lines not readable\n"));
    let again = good(at, "tasks import tasks.jsonl --project q --lake DEMO/lake");
    assert_eq!(again, format!("0 tasks created; {count} already present; 0 lines not readable\n"));
    let strip = |text: &str| lines(text).iter().map(|l| l["task"]["draft"].clone()).collect::<Vec<_>>();
    assert_eq!(strip(&good(at, "tasks export --project q --content tasks")), strip(&tasks));
    let labels = run(at, "tasks import labels.jsonl --project r --lake DEMO/lake");
    assert_eq!(labels.code, 3, "a line was lost");
    // The added line is the last one, and the exported drafts stand before it.
    let last = format!("labels.jsonl:{}: not JSON", lines(&drafts).len() + 1);
    assert!(labels.err.contains(&last), "{}", labels.err);
    assert!(labels.out.ends_with("1 lines not readable\n"), "{}", labels.out);
}

/// docs/reference/service.md: labels of which another one was chosen are in no count by state, and no filter by state
/// lists them.
#[test]
fn overruled_labels_are_listed_as_such_and_counted_nowhere() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    good(at, "tasks create --from DEMO/mined --project q --limit 6 --overlap 2");
    let store = Store::open(&at.join("whyroad-data/labels.db")).unwrap();
    store
        .write(|tx| {
            tx.run(
                "UPDATE tasks SET state = 'submitted',
                   adjudication = CASE WHEN overlap_index = 0 THEN 'chosen' ELSE 'superseded' END
                 WHERE episode_id = (SELECT min(episode_id) FROM tasks)",
                &[],
            )?;
            tx.run(
                "UPDATE tasks SET state = 'submitted', complete = 1
                 WHERE episode_id = (SELECT max(episode_id) FROM tasks)",
                &[],
            )
        })
        .unwrap();
    drop(store);
    assert_eq!(good(at, "tasks list"), "q  open 2, submitted 3\n");
    let states = |line: &str| -> Vec<String> {
        let all = good(at, line);
        let state = |l: &str| l.split("  ").map(str::trim).nth(1).unwrap_or_default().to_owned();
        let mut states: Vec<String> = all.lines().map(state).collect();
        states.sort();
        states
    };
    assert_eq!(states("tasks list --project q --state submitted"), ["submitted", "to choose", "to choose"]);
    assert_eq!(
        states("tasks list --project q"),
        ["not chosen", "open", "open", "submitted", "to choose", "to choose"]
    );
}

#[test]
fn what_is_not_there_is_told_and_makes_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let list = run(dir.path(), "tasks list");
    assert_eq!(list.code, 1);
    assert!(list.err.contains("no store at whyroad-data/labels.db"), "{}", list.err);
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
    good(dir.path(), "tasks create --from DEMO/mined --project p --limit 1");
    let unknown = run(dir.path(), "tasks list --project x");
    assert!(unknown.err.contains("no project 'x'; existing: p"), "{}", unknown.err);
    assert!(
        run(dir.path(), "tasks list --project p --state done")
            .err
            .contains("'done' is not a task state: open, ")
    );
    let nowhere = run(dir.path(), "tasks create --from DEMO/lake --project p --lake DEMO/lake");
    assert!(nowhere.err.contains("episodes.jsonl"), "{}", nowhere.err);
}

#[test]
fn a_backup_of_a_running_service_restores_whole_or_not_at_all() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    let service = Service::start(&["--data", at.join("one").to_str().unwrap()]);
    let (_, _, mut crew) = crew(service.at, 1);
    let mut annotator = crew.remove(0);
    for _ in 0..5 {
        assert!(annotator.save(), "{:?}", annotator.refused);
    }
    good(at, "backup --data one --out safe/backup.jsonl");
    assert!(annotator.save(), "it goes on");
    drop(service);
    let taken = run(at, "backup --data one --out safe/backup.jsonl");
    assert!(taken.code == 1 && taken.err.contains("already exists"), "{}", taken.err);

    // Cut off: refused, and the new store stays empty.
    let whole = std::fs::read(at.join("safe/backup.jsonl")).unwrap();
    std::fs::write(at.join("cut.jsonl"), &whole[..whole.len() / 2]).unwrap();
    assert_eq!(run(at, "restore --data two --from cut.jsonl").code, 1);
    // Secrets in it are sealed: it needs the key that it was made with.
    let keyless = run(at, "restore --data two --from safe/backup.jsonl");
    assert!(keyless.code == 1 && keyless.err.contains("store.key"), "{}", keyless.err);
    std::fs::copy(at.join("one/labels.db.key"), at.join("two/labels.db.key")).unwrap();
    good(at, "restore --data two --from safe/backup.jsonl");
    let twice = run(at, "restore --data two --from safe/backup.jsonl");
    assert!(twice.err.contains("restore.not_empty"), "{}", twice.err);

    let service = Service::start(&["--data", at.join("two").to_str().unwrap()]);
    annotator.client.move_to(service.at);
    assert_eq!(annotator.stored(), 5, "as it was when the backup was taken");
}

#[test]
fn who_cannot_sign_in_any_more_is_given_a_new_password() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    let service = Service::start(&["--data", at.join("one").to_str().unwrap()]);
    let mut admin = Client::set_up(service.at, "admin");
    assert!(good(at, "accounts list --data one").starts_with("admin "));
    let unknown = run(at, "accounts password nobody --data one");
    assert!(unknown.code == 1 && unknown.err.contains("no account 'nobody'"), "{}", unknown.err);
    let password = good(at, "accounts password admin --data one");
    // Beside the running service, which knows it at once.
    assert_eq!(admin.get("/users").status, 401, "all sessions have ended");
    let mut again = Client::sign_in_with(service.at, "admin", password.trim());
    assert_eq!(again.get("/session").good()["user"]["name"], "admin");
}

#[test]
fn the_key_of_a_store_is_replaced_and_the_store_goes_on() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    let service = Service::start(&["--data", at.join("one").to_str().unwrap()]);
    let _admin = Client::set_up(service.at, "admin");
    drop(service);
    let before = std::fs::read_to_string(at.join("one/labels.db.key")).unwrap();
    let done = run(at, "accounts rotate-key --data one");
    assert!(done.code == 0 && done.err.contains("sealed with a new key"), "{}", done.err);
    assert_ne!(std::fs::read_to_string(at.join("one/labels.db.key")).unwrap(), before);
    let service = Service::start(&["--data", at.join("one").to_str().unwrap()]);
    Client::sign_in(service.at, "admin");
    drop(service);
    std::fs::write(at.join("one/labels.db.key"), before).unwrap();
    let wrong = run(at, "accounts list --data one");
    assert!(wrong.code == 1 && wrong.err.contains("store.key"), "{}", wrong.err);
}
