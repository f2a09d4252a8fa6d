//! Tasks of another class than the mined one: in place of a task whose class does not fit, and of an episode that no
//! class explains.

use crate::work::Work;
use crate::world::{Person, Reply, World};
use serde_json::{Value, json};

const URGENT: &str = "reactive_agent.cutin.urgent";
const SLOW: &str = "reactive_agent.cutin.slow";

fn take(who: &Person, task: &str) -> Reply {
    who.post(&format!("/tasks/{task}/lease"), &json!({ "action": "take" }))
}

fn reclass(who: &Person, task: &str, class: &str) -> Reply {
    who.post(&format!("/tasks/{task}/reclass"), &json!({ "scenario": class }))
}

fn list(who: &Person, project: &str, query: &str) -> Value {
    who.get(&format!("/projects/{project}/tasks?{query}")).fine()["items"].clone()
}

/// Skips the task because its class does not fit.
fn say_wrong(work: &mut Work<'_>, class: &str) -> Reply {
    let question = json!({ "path": "", "text": "the class is wrong", "to_lead": true });
    work.who.post(&work.path("/comments"), &question).fine();
    work.act("skip", &json!({ "reason": "the class is wrong", "right_class": class }))
}

pub fn a_lead_makes_the_task_of_the_class_that_fits(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({ "history": "episode" }));
    let lead = world.person(&admin, &project, "lea", &["lead"]);
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let bob = world.person(&admin, &project, "bob", &["annotator"]);
    let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    // Ann locks Stage I, so she sees the future, and says then that the class is wrong.
    let mut work = Work::take(&ann, &task);
    work.stage1();
    work.act("lock_stage1", &json!({})).fine();
    assert_eq!(say_wrong(&mut work, "no.such").status, 400);
    say_wrong(&mut work, SLOW).fine();
    let asked = list(&lead, &project, "asks=class");
    assert_eq!((&asked[0]["id"], &asked[0]["right_class"]), (&json!(task), &json!(SLOW)));
    assert_eq!(lead.get(&format!("/projects/{project}/work")).fine()["wrong_class"], 1);

    assert_eq!(reclass(&ann, &task, SLOW).status, 403);
    assert_eq!(reclass(&lead, &task, URGENT).refusal(), (422, "class.same".into()));
    assert_eq!(reclass(&lead, &task, "reactive_agent").status, 400, "neither an L2 nor an L3");
    let new = reclass(&lead, &task, SLOW).fine()["tasks"][0].as_str().unwrap().to_owned();
    let old = lead.get(&format!("/tasks/{task}")).fine();
    assert_eq!((&old["task"]["state"], &old["task"]["replaced_by"]), (&json!("skipped"), &json!(new)));
    assert_eq!(list(&lead, &project, "asks=lead"), json!([]), "the question is answered");
    let made = lead.get(&format!("/tasks/{new}")).fine();
    assert_eq!(made["task"]["scenario_id"], SLOW);
    assert_eq!((&made["task"]["replaces"], &made["task"]["state"]), (&json!(task), &json!("open")));
    // The same clip and moment, without the text of a rule that did not find it.
    for same in ["/task/clip_id", "/suggestion/keyframe/timestamp", "/suggestion/target_id"] {
        assert_eq!(made.pointer(same), old.pointer(same), "{same}");
    }
    assert_eq!(made["draft"]["critical_components"], json!([]));
    assert_eq!(list(&lead, &project, "asks=class"), json!([]));
    assert_eq!(reclass(&lead, &task, SLOW).refusal(), (409, "task.replaced".into()));

    // Ann has seen the future of the episode, in the other task.
    assert_eq!(take(&ann, &new).refusal(), (403, "task.future_seen".into()));
    let mut work = Work::take(&bob, &new);
    work.stage1();
    let locked = work.act("lock_stage1", &json!({})).fine();
    assert_eq!(locked["draft"]["coc_trace"], "");
    assert_eq!(locked["draft"]["scenario"]["l3"], "slow");
    let history = lead.get(&format!("/tasks/{task}/history")).fine();
    assert!(history["items"].as_array().unwrap().iter().any(|e| e["action"] == "replace"), "{history}");
}

pub fn an_l2_is_a_class_whose_variant_is_unknown(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({ "stage1_class": "leaf" }));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let bob = world.person(&admin, &project, "bob", &["annotator"]);
    let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    let l2 = "reactive_agent.following";
    let mut work = Work::take(&ann, &task);
    say_wrong(&mut work, l2).fine();
    assert_eq!(list(&admin, &project, "asks=class")[0]["right_class"], l2);
    let new = reclass(&admin, &task, l2).fine()["tasks"][0].as_str().unwrap().to_owned();
    // Stage I shows the specification: nothing is withheld, there is no L3. In a project that withholds the L3 of this
    // L2 it comes with the lock, as for every task of the L2.
    let view = Work::take(&bob, &new).view();
    assert_eq!((&view["task"]["scenario_id"], &view["stage"]), (&json!(l2), &json!("stage1")));
    assert_eq!(view["spec"]["leaf"], json!(l2), "{}", view["spec"]);
    let veiled = json!({ "settings": { "stage1_class": "l2" } });
    admin.patch(&format!("/projects/{project}"), &veiled).fine();
    assert_eq!(bob.get(&format!("/tasks/{new}")).fine()["spec"], Value::Null);
}

pub fn who_saw_no_future_may_do_the_task_again_with_another_class(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let tasks = world.tasks(&admin, &project, &["drive1"], 2);
    let mut work = Work::take(&ann, &tasks[0]);
    say_wrong(&mut work, "").fine();
    assert_eq!(list(&admin, &project, "asks=class")[0]["right_class"], "");
    // Each person of the group gets a task again; the other one, which nobody had begun, is closed too.
    let made = reclass(&admin, &tasks[0], SLOW).fine()["tasks"].clone();
    assert_eq!(made.as_array().unwrap().len(), 2);
    let other = admin.get(&format!("/tasks/{}", tasks[1])).fine()["task"].clone();
    assert_eq!((&other["state"], &other["replaced_by"]), (&json!("skipped"), &made[1]));
    take(&ann, made[0].as_str().unwrap()).fine();
}

pub fn an_episode_that_no_class_explains_becomes_a_task_of_a_chosen_class(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let chen = world.person(&admin, &project, "chen", &["checker"]);
    let path = format!("/projects/{project}/mined/unexplained");
    let other = admin.get(&format!("{path}/episodes?scenario=other")).fine()["items"][0].clone();
    let body = |class: Value| json!({ "drive": other["drive_id"], "scenario": "other", "episode": other["episode_id"], "as_class": class });
    let make = |who: &Person, class: Value| who.post(&format!("{path}/tasks"), &body(class));
    assert_eq!(make(&chen, json!(SLOW)).status, 403);
    assert_eq!(make(&admin, Value::Null).refusal(), (422, "class.missing".into()));
    let made = make(&admin, json!(SLOW)).fine();
    let task = admin.get(&format!("/tasks/{}", made["tasks"][0].as_str().unwrap())).fine();
    assert_eq!(task["task"]["scenario_id"], SLOW);
    let again = make(&admin, json!(SLOW)).fine();
    assert_eq!((&again["tasks"], &again["known"]), (&json!([]), &json!(1)));
    // The mined class of an episode that has one, with the rule's draft.
    let one = json!({ "drive": "drive2", "scenario": URGENT, "episode": "drive2_e1" });
    let made = admin.post(&format!("/projects/{project}/mined/week1/tasks"), &one).fine();
    let id = made["tasks"][0].as_str().unwrap();
    let task = admin.get(&format!("/tasks/{id}")).fine();
    assert_ne!(task["draft"]["critical_components"], json!([]));
}

pub fn lists_have_the_time_in_the_drive_and_what_checks_found(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let tasks = world.tasks(&admin, &project, &["drive2", "drive1"], 1);
    // Keyframes are 9.4 s from the start of each drive; the order is that of drive, then moment.
    let by_moment = |sort: &str| -> Vec<String> {
        let mut drives = Vec::new();
        let mut cursor = String::new();
        loop {
            let page = admin.get(&format!("/projects/{project}/tasks?sort={sort}&limit=1{cursor}")).fine();
            assert_eq!(page["items"][0]["keyframe_s"], 9.4);
            drives.push(page["items"][0]["drive_id"].as_str().unwrap().to_owned());
            let Some(next) = page["next"].as_str() else { break };
            cursor = format!("&cursor={}", next.replace(' ', "%20"));
        }
        drives
    };
    assert_eq!(by_moment("keyframe"), ["drive1", "drive2"]);
    assert_eq!(by_moment("-keyframe"), ["drive2", "drive1"]);

    assert_eq!(list(&admin, &project, "finding=any"), json!([]));
    let work = Work::label(&ann, &tasks[0]);
    let codes = work.view()["findings"].clone();
    let mut expected: Vec<&str> =
        codes.as_array().unwrap().iter().map(|f| f["code"].as_str().unwrap()).collect();
    expected.sort_unstable();
    expected.dedup();
    let found = list(&admin, &project, "");
    let of = |id: &str| found.as_array().unwrap().iter().find(|t| t["id"] == id).unwrap()["findings"].clone();
    assert_eq!(of(&tasks[0]), json!(expected));
    assert_eq!(of(&tasks[1]), json!([]));
    for code in expected {
        assert_eq!(list(&admin, &project, &format!("finding={code}"))[0]["id"], tasks[0], "{code}");
    }
    assert_eq!(list(&admin, &project, "finding=label.no%25"), json!([]));
}

/// 2026-01-15T16:30Z is the 16th in a project whose clock is 8 h ahead.
pub fn days_are_those_of_the_projects_clock(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({ "utc_offset_min": 480 }));
    let too_far = json!({ "settings": { "utc_offset_min": 900 } });
    assert_eq!(admin.patch(&format!("/projects/{project}"), &too_far).status, 422);
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    let day_ms = 86_400_000;
    let now = world.clock.load(std::sync::atomic::Ordering::SeqCst);
    // To 16:30 of the day (UTC).
    world.wait((now.div_euclid(day_ms) * day_ms + day_ms + 59_400_000 - now) / 1000);
    let ann = world.sign_in(if ann.id.is_empty() { "" } else { "ann" });
    Work::label(&ann, &task);
    let admin = world.sign_in("admin");
    let board = admin.get(&format!("/projects/{project}/dashboard")).fine();
    let next_day = whyroad_model::Nanos((now.div_euclid(day_ms) + 2) * day_ms * 1_000_000).to_string();
    assert_eq!(board["throughput"][0]["day"], next_day[..10]);
    assert_eq!(board["utc_offset_min"], 480);
    assert_eq!(ann.get(&format!("/projects/{project}/work")).fine()["mine"]["submitted_today"], 1);
}
