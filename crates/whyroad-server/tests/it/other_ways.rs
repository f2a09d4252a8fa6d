//! Ways to the future of a Stage I that lead through something else than the task itself: another copy of its episode,
//! a mined folder, a task that was removed, an imported draft; and roles that end while a task is held.

use crate::leaks::{all_answers, same};
use crate::recorded::{Future, at, episode};
use crate::work::{Work, components, example};
use crate::world::{Person, Reply, World};
use serde_json::{Value, json};
use whyroad_server::service::retention::sweep;

fn take(who: &Person, task: &str) -> Reply {
    who.post(&format!("/tasks/{task}/lease"), &json!({ "action": "take" }))
}

fn act(who: &Person, task: &str, action: &str) -> Reply {
    who.post(&format!("/tasks/{task}/actions"), &json!({ "action": action, "reason": "again" }))
}

/// Whether the label of the group's first copy is in the answer.
fn tells(answer: &Reply) -> bool {
    answer.text().contains(example()["coc_trace"].as_str().unwrap())
}

/// The administrator, somebody who labels, checks and leads, and the two copies of an episode, of which another person
/// has labeled the first.
fn two_copies(world: &World) -> (Person, Person, Vec<String>) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let both = world.person(&admin, &project, "both", &["annotator", "checker", "lead"]);
    let ids = world.tasks(&admin, &project, &["drive1"], 2);
    Work::label(&ann, &ids[0]);
    (admin, both, ids)
}

pub fn labels_side_by_side_count_as_seen(world: &World) {
    let (admin, both, ids) = two_copies(world);
    // A copy that was skipped shows its history only; the other copy beside it shows everything.
    act(&admin, &ids[1], "skip").fine();
    let side_by_side = both.get(&format!("/tasks/{}/overlap", ids[1]));
    assert!(tells(&side_by_side), "{}", side_by_side.text());
    act(&admin, &ids[1], "reopen").fine();
    assert_eq!(take(&both, &ids[1]).refusal(), (403, "task.future_seen".into()));
}

pub fn a_choice_in_a_group_shows_no_future_of_the_task_in_hand(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let [ann, bob] = ["ann", "bob"].map(|name| world.person(&admin, &project, name, &["annotator"]));
    let lea = world.person(&admin, &project, "lea", &["annotator", "lead"]);
    let ids = world.tasks(&admin, &project, &["drive1"], 2);
    let other = json!({ "episodes": [episode("drive1", 2, world.future)] });
    let made = admin.post(&format!("/projects/{project}/tasks:create"), &other).fine();
    let other = made["tasks"][0].as_str().unwrap();
    Work::label(&ann, &ids[0]);
    Work::label(&bob, &ids[1]);
    let held = Work::take(&lea, other);
    let choose = act(&lea, &ids[0], "adjudicate");
    assert!(!tells(&choose), "{}", choose.text());
    assert_eq!(choose.refusal(), (409, "task.stage1_first".into()));
    lea.post(&held.path("/lease"), &json!({ "action": "release", "fence": held.fence })).fine();
    // Afterwards it is possible, and is remembered.
    assert!(tells(&act(&lea, &ids[0], "adjudicate")));
    assert_eq!(take(&lea, other).refusal(), (403, "task.future_seen".into()));
}

pub fn another_persons_label_is_hidden_until_the_own_one_is_submitted(world: &World) {
    let (_, both, ids) = two_copies(world);
    let mut work = Work::take(&both, &ids[1]);
    work.stage1();
    work.act("lock_stage1", &json!({})).fine();
    let refused = (409, "overlap.own_first".to_owned());
    for path in ["", "/history", "/history/5", "/scene"] {
        assert_eq!(both.get(&format!("/tasks/{}{path}", ids[0])).refusal(), refused, "{path}");
    }
    assert_eq!(take(&both, &ids[0]).refusal(), refused);
    work.stage2();
    work.act("submit", &json!({})).fine();
    assert!(tells(&both.get(&format!("/tasks/{}", ids[0]))));
}

pub fn who_browsed_an_episode_does_no_stage_one_of_it(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({ "history": "episode" }));
    let lea = world.person(&admin, &project, "lea", &["annotator", "lead"]);
    let path = "drive=drive1&scenario=reactive_agent.cutin.urgent&episode=drive1_e1";
    lea.get(&format!("/projects/{project}/mined/week1/episode?{path}")).fine();
    let same = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    assert_eq!(take(&lea, &same).refusal(), (403, "task.future_seen".into()));
    // Only the same episode excludes here.
    let other = json!({ "episodes": [episode("drive1", 2, world.future)] });
    let made = admin.post(&format!("/projects/{project}/tasks:create"), &other).fine();
    take(&lea, made["tasks"][0].as_str().unwrap()).fine();
}

pub fn what_was_seen_outlasts_the_task(world: &World) {
    let admin = world.admin();
    let settings = json!({ "history": "episode", "retention_days": 30 });
    let project = world.project(&admin, "town", &settings);
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    Work::label(&ann, &task);
    act(&admin, &task, "reopen").fine();
    act(&admin, &task, "skip").fine();
    world.wait(31 * 86_400);
    assert_eq!(sweep(&world.app).unwrap(), 1);
    let (admin, ann) = (world.sign_in("admin"), world.sign_in("ann"));
    let again = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    assert_ne!(again, task);
    assert_eq!(take(&ann, &again).refusal(), (403, "task.future_seen".into()));
}

/// A line of an import: an exported task whose keyframe was moved back and whose components were changed in rework.
fn imported_line(world: &World, words: &str) -> String {
    let episode = serde_json::to_value(episode("drive1", 1, world.future)).unwrap();
    let (before, after) = (at(90).to_string(), at(120).to_string());
    let mut draft = example();
    draft["clip_id"] = episode["clip_id"].clone();
    draft["time_range"] = episode["time_range"].clone();
    draft["keyframe"] = json!({ "timestamp": after, "frame_idx": 120, "type": "reactive", "range_start": after,
        "range_end": after, "hint": words });
    draft["scenario"]["outcome"] = json!(words);
    draft["critical_components"] = json!([
        { "id": "c1", "category": "critical_objects", "description": "a car", "evidence_times": [before, after],
          "note": words },
        { "id": "c2", "category": "critical_objects", "description": "a van", "evidence_times": [after] },
        { "id": "c3", "category": "critical_objects", "description": words, "evidence_times": [before] },
        { "id": "c4", "category": "critical_objects", "description": words },
    ]);
    draft["causes"] =
        json!({ "longitudinal": { "components": ["c1", "c2"] }, "lateral": { "components": ["c3"] } });
    json!({ "task": { "episode": episode, "draft": draft } }).to_string()
}

fn import(admin: &Person, project: &str, line: &str) -> String {
    let path = format!("/projects/{project}/import");
    assert_eq!(admin.call("POST", &path, Some(line.as_bytes()), &[]).fine()["tasks"], 1);
    let list = admin.get(&format!("/projects/{project}/tasks")).fine();
    list["items"][0]["id"].as_str().unwrap().to_owned()
}

pub fn an_imported_draft_carries_no_future_into_stage_one(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let [ann, bob] = ["ann", "bob"].map(|name| world.person(&admin, &project, name, &["annotator"]));
    let line = imported_line(world, "it stops");
    let task = import(&admin, &project, &line);
    // Staff, before anybody has begun.
    let open = admin.get(&format!("/tasks/{task}")).fine();
    assert_eq!((&open["draft"]["critical_components"], &open["imported"]), (&json!([]), &Value::Null));
    let draft: Value = serde_json::from_str(&line).unwrap();
    let draft = &draft["task"]["draft"];
    let mut work = Work::take(&ann, &task);
    let hidden = |seen: &Value| {
        assert!(
            !seen.to_string().contains("it stops") && !seen.to_string().contains(&at(120).to_string()),
            "{seen}"
        );
        assert_eq!((&seen["draft"]["critical_components"], &seen["imported"]), (&json!([]), &Value::Null));
    };
    hidden(&work.view());
    assert_eq!(work.view()["draft"]["keyframe"]["timestamp"], open["suggestion"]["keyframe"]["timestamp"]);
    // What is saved is the person's own; what is hidden is kept.
    assert_eq!(work.set(&[("/critical_components/-", components()[0].clone())]).status, 200);
    assert_eq!(work.view()["draft"]["critical_components"].as_array().unwrap().len(), 1);
    work.stage1();
    let locked = work.act("lock_stage1", &json!({})).fine();
    assert_eq!(locked["draft"]["critical_components"], components());
    assert_eq!(locked["draft"]["causes"], Value::Null, "they refer to other components");
    assert_eq!(locked["imported"]["critical_components"], draft["critical_components"]);
    assert_eq!(locked["imported"]["causes"], draft["causes"]);
    assert_eq!(locked["draft"]["coc_trace"], draft["coc_trace"]);
    // Started again, it is hidden again.
    assert_eq!(act(&admin, &task, "reopen").status, 200);
    let again = Work::take(&bob, &task);
    hidden(&again.view());
    let first = again.who.get(&again.path("/history")).fine()["items"][0]["seq"].as_i64().unwrap();
    assert!(!again.who.get(&again.path(&format!("/history/{first}"))).text().contains("it stops"));
    // An export gives the import back.
    let other = world.project(&admin, "village", &json!({}));
    import(&admin, &other, &line);
    let exported = admin.get(&format!("/projects/{other}/export?format=tasks")).text();
    let exported: Value = serde_json::from_str(&exported).unwrap();
    assert_eq!(exported["task"]["draft"]["critical_components"], draft["critical_components"]);
}

/// Also a lead who labels is not shown by an earlier draft what they imported.
pub fn an_imported_draft_does_not_come_back_in_stage_one(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let task = import(&admin, &project, &imported_line(world, "it stops"));
    let mut work = Work::take(&admin, &task);
    let first = admin.get(&work.path("/history/1"));
    assert!(first.status == 200 && !first.text().contains("it stops"), "{}", first.text());
    assert_eq!(work.set(&[("/critical_components", components())]).status, 200);
    let back = work.act("restore", &json!({ "seq": 1 }));
    assert!(!back.text().contains("it stops"), "{}", back.text());
    assert_eq!(work.view()["draft"]["critical_components"], components());
}

#[test]
fn imports_that_differ_only_in_hidden_words_answer_alike() {
    let answers = |words: &str| {
        let world = World::on_sqlite(Future::Brakes);
        let admin = world.admin();
        let project = world.project(&admin, "town", &json!({}));
        let ann = world.person(&admin, &project, "ann", &["annotator"]);
        let task = import(&admin, &project, &imported_line(&world, words));
        world.wait(60);
        let mut work = Work::take(&ann, &task);
        work.set(&[("/critical_components", components())]);
        all_answers(&project, &work, &ann)
    };
    same(&answers("it stops"), &answers("the light turns green, and it goes on"));
}

pub fn a_role_that_ended_decides_nothing(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({ "audit_min_percent": 0, "audit_max_percent": 0 }));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let chen = world.person(&admin, &project, "chen", &["checker"]);
    let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    let becomes = |name: &str, role: &str| {
        let body = json!({ "user": name, "roles": [role] });
        admin.post(&format!("/projects/{project}/members"), &body).fine();
    };
    let refused = (403, "task.role_missing".to_owned());
    let mut work = Work::take(&ann, &task);
    work.stage1();
    becomes("ann", "auditor");
    assert_eq!(work.act("lock_stage1", &json!({})).refusal(), refused);
    let components = [("/critical_components", components())];
    assert_eq!(work.set(&components).refusal(), refused);
    assert_eq!(work.act("restore", &json!({ "seq": 1 })).refusal(), refused);
    becomes("ann", "annotator");
    assert_eq!(work.set(&components).status, 200);
    work.act("lock_stage1", &json!({})).fine();
    becomes("ann", "auditor");
    let safe = json!({ "fence": work.fence, "answer": "safe" });
    assert_eq!(ann.post(&work.path("/safety"), &safe).refusal(), refused);
    becomes("ann", "annotator");
    work.stage2();
    becomes("ann", "auditor");
    assert_eq!(work.act("submit", &json!({})).refusal(), refused);
    assert_eq!(work.set(&[("/coc_trace", json!("x"))]).refusal(), refused);
    becomes("ann", "annotator");
    work.act("submit", &json!({})).fine();
    let mut check = Work::take(&chen, &task);
    becomes("chen", "auditor");
    assert_eq!(check.act("accept", &json!({})).refusal(), refused);
    assert_eq!(check.act("send_back", &json!({ "reason": "no" })).refusal(), refused);
    // The task is not lost: it can be released.
    chen.post(&check.path("/lease"), &json!({ "action": "release", "fence": check.fence })).fine();
    // Who is removed from the project while they hold a task writes nothing either.
    let task = world.tasks(&admin, &project, &["drive2"], 1)[0].clone();
    let mut work = Work::take(&ann, &task);
    let gone = json!({ "user": "ann", "roles": [] });
    admin.post(&format!("/projects/{project}/members"), &gone).fine();
    assert_eq!(work.set(&components).refusal(), (404, "not_found".into()));
}
