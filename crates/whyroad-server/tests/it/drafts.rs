//! Autosave: merging, conflicts, leases and their tokens, restoring.

use crate::recorded::episode;
use crate::work::{Begin, Work};
use crate::world::World;
use serde_json::{Value, json};

pub fn changes_of_different_fields_merge_and_of_the_same_conflict(world: &World) {
    let Begin { ann, task, .. } = Begin::on(world);
    let mut work = Work::take(&ann, &task);
    work.stage1();
    work.act("lock_stage1", &json!({})).fine();
    work.safe();
    let base = work.version;
    // One tab writes the trace; another one, which has not loaded it, the decision.
    assert_eq!(work.set(&[("/coc_trace", json!("one"))]).status, 200);
    let save = |base: i64, path: &str, value: Value| {
        let body = json!({ "fence": work.fence, "base_version": base, "changes": [{ "path": path, "value": value }] });
        ann.patch(&format!("/tasks/{task}/draft"), &body)
    };
    let merged = save(base, "/driving_decision/longitudinal", json!("yield_to_agent")).fine();
    assert_eq!(merged["merged"]["coc_trace"], "one", "the other's change is told");
    assert_eq!(merged["merged"]["driving_decision"]["longitudinal"], "yield_to_agent");
    // The same field: nothing is overwritten.
    let conflict = save(base, "/coc_trace", json!("two"));
    assert_eq!(conflict.refusal(), (409, "draft.conflict".into()));
    let more = &conflict.json()["more"];
    assert_eq!(more["conflicts"], json!([{ "path": "/coc_trace", "mine": "two", "theirs": "one" }]));
    assert_eq!(more["draft"]["coc_trace"], "one");
    let now = more["version"].as_i64().unwrap();
    // The same value is no conflict, and with the newest version it is accepted.
    save(base, "/coc_trace", json!("one")).fine();
    save(now + 1, "/coc_trace", json!("two")).fine();
    assert_eq!(save(now + 99, "/coc_trace", json!("x")).refusal().0, 400);
    assert_eq!(
        save(now + 2, "/no/such/0/way", json!("x")).status,
        200,
        "a new field is the checker's to find"
    );
    assert_eq!(save(now + 3, "/critical_components/9/id", json!("x")).refusal().0, 422);
    assert_eq!(save(now + 3, "/coc_trace/x", json!("x")).refusal(), (422, "draft.path".into()));
    let long = "长".repeat(100_000);
    assert_eq!(save(now + 3, "/coc_trace", json!(long)).refusal(), (413, "draft.too_large".into()));
}

pub fn an_older_token_writes_nothing(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({ "lease_s": 60 }));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let bob = world.person(&admin, &project, "bob", &["annotator"]);
    let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    let mut first = Work::take(&ann, &task);
    let lease = |who: &crate::world::Person, body: Value| who.post(&format!("/tasks/{task}/lease"), &body);
    assert_eq!(lease(&bob, json!({ "action": "take" })).refusal(), (409, "lease.held".into()));
    // A second tab of the same person invalidates the first.
    let mut second = Work::take(&ann, &task);
    assert!(second.fence > first.fence);
    let name = |n: i64| json!({ "action": "heartbeat", "fence": n });
    assert_eq!(first.set(&[("/critical_components", json!([]))]).refusal(), (409, "lease.lost".into()));
    assert_eq!(lease(&ann, name(first.fence)).refusal(), (409, "lease.lost".into()));
    assert_eq!(first.act("lock_stage1", &json!({})).refusal(), (409, "lease.lost".into()));
    // Heartbeats renew it.
    for _ in 0..5 {
        world.wait(50);
        lease(&ann, name(second.fence)).fine();
    }
    assert_eq!(lease(&bob, json!({ "action": "take" })).refusal(), (409, "lease.held".into()));
    // It expired, and nobody took it: its holder can still write, and gets the lease again.
    world.wait(120);
    assert_eq!(second.set(&[("/critical_components/0/description", json!("late"))]).status, 200);
    assert_eq!(lease(&bob, json!({ "action": "take" })).refusal(), (409, "lease.held".into()));
    // It expired, and another user took it.
    world.wait(120);
    lease(&bob, json!({ "action": "take" })).fine();
    assert_eq!(
        second.set(&[("/critical_components", json!([]))]).refusal().0,
        404,
        "not even there any more"
    );
    assert_eq!(lease(&ann, name(second.fence)).refusal(), (409, "lease.lost".into()));
    // A lead releases it from bob.
    lease(&admin, json!({ "action": "release" })).fine();
    lease(&ann, json!({ "action": "take" })).fine();
}

pub fn a_task_is_never_held_twice(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let names = ["a1", "a2", "a3", "a4", "a5", "a6"];
    let people: Vec<_> = names.iter().map(|n| world.person(&admin, &project, n, &["annotator"])).collect();
    let drives = ["drive1", "drive2", "drive3", "drive4"];
    world.tasks(&admin, &project, &drives, 1);
    let got: Vec<Option<String>> = std::thread::scope(|scope| {
        let project = &project;
        let ask = |p| scope.spawn(move || Work::next(p, project, "label").map(|w| w.task));
        let threads: Vec<_> = people.iter().map(ask).collect();
        threads.into_iter().map(|t| t.join().unwrap()).collect()
    });
    let mut held: Vec<String> = got.into_iter().flatten().collect();
    assert_eq!(held.len(), drives.len(), "each task went to somebody, two people got none");
    held.sort_unstable();
    held.dedup();
    assert_eq!(held.len(), drives.len());
}

pub fn an_earlier_draft_comes_back(world: &World) {
    let Begin { ann, task, .. } = Begin::on(world);
    let mut work = Work::take(&ann, &task);
    work.stage1();
    let components = work.view()["draft"]["critical_components"].clone();
    work.act("lock_stage1", &json!({})).fine();
    work.safe();
    assert_eq!(work.set(&[("/coc_trace", json!("first"))]).status, 200);
    let seq = work.view()["history_count"].as_i64().unwrap();
    assert_eq!(work.set(&[("/coc_trace", json!("second"))]).status, 200);
    let back = work.act("restore", &json!({ "seq": seq })).fine();
    assert_eq!(back["draft"]["coc_trace"], "first");
    // Back to the first draft: the parts locked in Stage I stay locked.
    let back = work.act("restore", &json!({ "seq": 1 })).fine();
    assert!(back["draft"]["coc_trace"].as_str().unwrap().starts_with("[DRAFT]"));
    assert_eq!(back["draft"]["critical_components"], components);
    assert_eq!(back["draft"]["safety_filter"], json!({ "answer": "safe" }), "the answer stands");
    assert_eq!(work.act("restore", &json!({ "seq": 999 })).refusal().0, 404);
    // The history still contains everything.
    let second = ann.get(&work.path(&format!("/history/{}", seq + 1))).fine();
    assert_eq!(second["draft"]["coc_trace"], "second");
}

pub fn in_stage_one_the_end_of_the_keyframes_range_survives_unseen(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let mut episode = serde_json::to_value(episode("drive1", 1, world.future)).unwrap();
    episode["keyframe"]["type"] = json!("proactive");
    episode["keyframe"]["range_start"] = episode["keyframe"]["timestamp"].clone();
    episode["keyframe"]["range_end"] = json!("2026-01-15T10:30:12.000Z");
    let path = format!("/projects/{project}/tasks:create");
    let task =
        admin.post(&path, &json!({ "episodes": [episode] })).fine()["tasks"][0].as_str().unwrap().to_owned();
    let mut work = Work::take(&ann, &task);
    let mut keyframe = work.view()["draft"]["keyframe"].clone();
    assert!(keyframe.get("range_end").is_none());
    keyframe["timestamp"] = json!("2026-01-15T10:30:09.000Z");
    keyframe["range_start"] = json!("2026-01-15T10:30:09.000Z");
    keyframe["frame_idx"] = json!(90);
    assert_eq!(work.set(&[("/keyframe", keyframe)]).status, 200);
    work.stage1_at("2026-01-15T10:30:09.000Z");
    let locked = work.act("lock_stage1", &json!({})).fine();
    assert_eq!(locked["draft"]["keyframe"]["range_end"], "2026-01-15T10:30:12.000Z");
    assert_eq!(locked["draft"]["keyframe"]["timestamp"], "2026-01-15T10:30:09.000Z");
    let changed = locked["changed_from_suggestion"].as_array().unwrap();
    assert!(changed.contains(&json!("/keyframe")), "the difference from the suggestion is kept");
}

/// The range begins at the suggested keyframe, as for most classes, and is set in Stage II only.
pub fn in_stage_one_a_keyframe_before_its_range_can_be_locked(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let mut one = serde_json::to_value(episode("drive1", 1, world.future)).unwrap();
    one["time_range"]["start_timestamp"] = one["keyframe"]["timestamp"].clone();
    one["time_range"]["start_frame_idx"] = one["keyframe"]["frame_idx"].clone();
    let made = admin.post(&format!("/projects/{project}/tasks:create"), &json!({ "episodes": [one] })).fine();
    let mut work = Work::take(&ann, made["tasks"][0].as_str().unwrap());
    work.stage1_at("2026-01-15T10:30:08.400Z");
    let earlier = json!({ "timestamp": "2026-01-15T10:30:08.400Z", "frame_idx": 84, "type": "reactive" });
    let saved = work.set(&[("/keyframe", earlier)]).fine();
    assert_eq!(saved["findings"], json!([]));
    let locked = work.act("lock_stage1", &json!({})).fine();
    let codes: Vec<&str> =
        locked["findings"].as_array().unwrap().iter().map(|f| f["code"].as_str().unwrap()).collect();
    assert!(codes.contains(&"label.keyframe.outside_time_range"), "{codes:?}");
}
