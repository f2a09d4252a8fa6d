//! Gold tasks: hidden among others, compared with the known answer, visible to leads only.

use crate::leaks::{all_answers, same};
use crate::work::Work;
use crate::world::{Person, World};
use serde_json::{Value, json};
use whyroad_server::values;

const ALL_ROLES: &[&str] = &["annotator"];

/// A project with an accepted label by Bob of `labelled`, and open tasks of `open`.
struct Town {
    admin: Person,
    project: String,
    ann: Person,
    accepted: String,
    open: Vec<String>,
}

fn town(world: &World, labelled: &str, open: &[&str], settings: &Value) -> Town {
    let admin = world.admin();
    let project = world.project(&admin, "town", settings);
    let ann = world.person(&admin, &project, "ann", ALL_ROLES);
    let bob = world.person(&admin, &project, "bob", ALL_ROLES);
    let chen = world.person(&admin, &project, "chen", &["checker"]);
    let accepted = world.tasks(&admin, &project, &[labelled], 1)[0].clone();
    let open = world.tasks(&admin, &project, open, 1);
    world.wait(60);
    let bobs = Work::label(&bob, &accepted);
    Work::take(&chen, &bobs.task).act("accept", &json!({})).fine();
    world.wait(60);
    Town { admin, project, ann, accepted, open }
}

fn settings() -> Value {
    json!({ "audit_min_percent": 0, "audit_max_percent": 0, "gold_labels": 1, "gold_percent": 80 })
}

fn gold(town: &Town, tasks: &[&str], users: &[&str]) -> Value {
    let body = json!({ "tasks": tasks, "users": users });
    town.admin.post(&format!("/projects/{}/gold", town.project), &body).fine()
}

fn report(town: &Town) -> Value {
    town.admin.get(&format!("/projects/{}/gold", town.project)).fine()
}

/// All responses that Ann gets in Stage I, then in Stage II and after, for the task of `drive1`: a gold task or an
/// ordinary one. One more task waits in both towns; with two of the same age their random ids would determine the
/// order.
fn answers(is_gold: bool) -> Vec<(String, String)> {
    let world = World::on_sqlite(crate::recorded::Future::Brakes);
    let (labelled, open): (&str, &[&str]) =
        if is_gold { ("drive1", &["drive3"]) } else { ("drive2", &["drive1", "drive3"]) };
    let town = town(&world, labelled, open, &settings());
    let task = if is_gold {
        assert_eq!(gold(&town, &[&town.accepted], &["ann"])["made"], 1);
        report(&town)["tasks"][0]["task"].as_str().unwrap().to_owned()
    } else {
        town.open[0].clone()
    };
    let mut work = Work::take(&town.ann, &task);
    work.set(&[("/critical_components/0/description", json!("a car on the left"))]);
    let mut out = all_answers(&town.project, &work, &town.ann);
    world.wait(5);
    let mut work = Work::take(&town.ann, &task);
    // The attack moved the keyframe.
    let moment = json!({ "timestamp": "2026-01-15T10:30:09.400Z", "frame_idx": 94, "type": "reactive" });
    assert_eq!(work.set(&[("/keyframe", moment)]).status, 200);
    work.stage1();
    work.act("lock_stage1", &json!({})).fine();
    let before = work.view()["draft"].clone();
    out.extend(all_answers(&town.project, &work, &town.ann));
    // Comments of the same time are listed in the order of their random ids.
    world.wait(5);
    let mut work = Work::take(&town.ann, &task);
    // The attack moved the range, too.
    let back = [("/time_range", before["time_range"].clone()), ("/keyframe", before["keyframe"].clone())];
    assert_eq!(work.set(&back).status, 200);
    work.safe();
    work.stage2();
    work.act("submit", &json!({})).fine();
    out.extend(all_answers(&town.project, &work, &town.ann));
    out
}

#[test]
fn a_gold_task_answers_like_any_other_in_every_stage() {
    same(&answers(true), &answers(false));
}

pub fn order_and_history_of_gold_tasks_are_those_of_others(world: &World) {
    let town = town(world, "drive1", &["drive2", "drive3", "drive4"], &settings());
    let made_at = |id: String| {
        let read = |tx: &mut dyn whyroad_server::store::Tx| {
            let sql =
                "SELECT t.created, t.priority, t.overlap_index, t.overlap_count, t.updated, h.at, h.actor
                       FROM tasks t JOIN history h ON h.task_id = t.id AND h.seq = 1 WHERE t.id = $1";
            let row = tx.row(sql, values![&id])?.unwrap();
            let numbers = ["created", "priority", "overlap_index", "overlap_count", "updated", "at"];
            let numbers = numbers.iter().map(|n| row.int(n).unwrap()).collect::<Vec<_>>();
            Ok((numbers, row.maybe_text("actor")?))
        };
        world.app.store.read(read).unwrap()
    };
    world.wait(3600);
    gold(&town, &[&town.accepted], &["ann"]);
    let copy = report(&town)["tasks"][0]["task"].as_str().unwrap().to_owned();
    assert_eq!(made_at(copy.clone()), made_at(town.open[0].clone()), "as if made with them");
    // The queue gives it to Ann only, at some position among the others.
    let other = world.person(&town.admin, &town.project, "dee", ALL_ROLES);
    let queue = |who: &Person| {
        let mut ids = Vec::new();
        while let Some(work) = Work::next(who, &town.project, "label") {
            ids.push(work.task.clone());
            who.post(&work.path("/lease"), &json!({ "action": "release", "fence": work.fence })).fine();
            if ids.len() > 12 || ids.iter().filter(|id| **id == work.task).count() > 1 {
                break;
            }
            // A released task is the next one again, so it is labeled instead.
            Work::label(who, &work.task);
        }
        ids
    };
    assert!(queue(&town.ann).contains(&copy));
    assert!(!queue(&other).contains(&copy));
}

pub fn gold_answers_are_compared_and_shown_to_leads_alone(world: &World) {
    let town = town(world, "drive1", &["drive2"], &settings());
    let path = format!("/projects/{}/gold", town.project);
    let chen = world.sign_in("chen");
    assert_eq!((town.ann.get(&path).status, chen.get(&path).status), (403, 403));
    let refused = gold(&town, &[&town.open[0]], &["ann"]);
    assert_eq!(
        (&refused["made"], refused["refused"].as_array().unwrap().len()),
        (&json!(0), 1),
        "not accepted"
    );
    let refused = gold(&town, &[&town.accepted], &["bob"]);
    assert_eq!(refused["made"], 0, "Bob has seen it");
    let nobody = json!({ "tasks": [town.accepted], "users": ["chen"] });
    assert_eq!(town.admin.post(&path, &nobody).status, 400, "a checker labels nothing");
    assert_eq!(gold(&town, &[&town.accepted], &["ann"])["made"], 1);
    assert_eq!(gold(&town, &[&town.accepted], &["ann"])["made"], 0, "once is enough");
    let before = report(&town)["people"][0].clone();
    assert_eq!(
        (&before["done"], &before["standing"], &before["percent"]),
        (&json!(0), &json!("open"), &Value::Null)
    );
    let copy = report(&town)["tasks"][0]["task"].as_str().unwrap().to_owned();
    let coverage =
        || town.admin.get(&format!("/projects/{}/dashboard", town.project)).fine()["coverage"].clone();
    let covered = coverage();
    let mut work = Work::take(&town.ann, &copy);
    work.stage1();
    work.act("lock_stage1", &json!({})).fine();
    work.stage2();
    let other = json!({ "longitudinal": "lead_following", "lateral": null });
    assert_eq!(work.set(&[("/driving_decision", other)]).status, 200);
    work.act("submit", &json!({})).fine();
    let after = report(&town);
    assert_eq!(after["tasks"][0]["differs"], json!(["longitudinal"]));
    let ann = &after["people"][0];
    assert_eq!((&ann["done"], &ann["fields"]["longitudinal"]), (&json!(1), &json!(0.0)));
    // Three or four of the fields agree: scenario, lateral, keyframe, and objects if the answer names one.
    let percent = ann["percent"].as_f64().unwrap();
    assert!((70.0..=80.0).contains(&percent), "{percent}");
    // It is checked like any other, and neither exported nor counted as an additional label.
    Work::take(&chen, &copy).act("accept", &json!({})).fine();
    let export = town.admin.get(&format!("/projects/{}/export", town.project)).text();
    assert_eq!(export.lines().count(), 1);
    assert_eq!(coverage(), covered);
}

/// What a member sees of the whole project: ids are random, so tasks are told apart by their clips.
fn overview(who: &Person, project: &str) -> Value {
    let get = |path: &str| who.get(&format!("/projects/{project}{path}")).fine();
    let plain = |list: &Value, names: &[&str]| {
        let one = |t: &Value| Value::Array(names.iter().map(|n| t[*n].clone()).collect());
        let mut all: Vec<Value> = list.as_array().unwrap().iter().map(one).collect();
        all.sort_by_key(Value::to_string);
        all
    };
    let tasks = get("/tasks?limit=200");
    let names = [
        "clip_id",
        "scenario_id",
        "state",
        "stage",
        "priority",
        "overlap",
        "author",
        "assigned_to",
        "updated",
    ];
    let board = get("/dashboard");
    // Drafts are made in the background: how many are left depends on the moment.
    let mut work = get("/work");
    work.as_object_mut().unwrap().remove("pending");
    json!({
        "tasks": plain(&tasks["items"], &names), "total": tasks["total"], "work": work,
        "by_state": board["by_state"], "coverage": board["coverage"],
        "ageing": plain(&board["ageing"], &["scenario_id", "state", "hours"]),
        "check": get("/queue?kind=check"), "to_choose": board["to_choose"],
    })
}

/// What Ann, who also checks, sees before, during and after Stage I of a task of `drive1`: a gold task or an ordinary
/// one. In both towns Bob's label of `drive2` is accepted.
fn seen_by_a_checker(is_gold: bool) -> Vec<Value> {
    let world = World::on_sqlite(crate::recorded::Future::Brakes);
    let open: &[&str] = if is_gold { &["drive3"] } else { &["drive1", "drive3"] };
    let town = town(&world, "drive2", open, &settings());
    let members = format!("/projects/{}/members", town.project);
    for name in ["ann", "cleo"] {
        if name == "cleo" {
            world.person(&town.admin, &town.project, name, ALL_ROLES);
        }
        let roles = json!({ "user": name, "roles": ["annotator", "checker"] });
        town.admin.post(&members, &roles).fine();
    }
    let task = if is_gold {
        let source = world.tasks(&town.admin, &town.project, &["drive1"], 1)[0].clone();
        Work::label(&world.sign_in("bob"), &source);
        Work::take(&world.sign_in("chen"), &source).act("accept", &json!({})).fine();
        assert_eq!(gold(&town, &[&source], &["ann", "cleo"])["made"], 2);
        let (ann, cleo) = (world.sign_in("ann"), world.sign_in("cleo"));
        let copies = report(&town)["tasks"].clone();
        let of = |user: &str| {
            let one = copies.as_array().unwrap().iter().find(|t| t["user"] == user).unwrap();
            one["task"].as_str().unwrap().to_owned()
        };
        let (own, other) = (of("ann"), of("cleo"));
        // Neither by their addresses, nor from the queue.
        Work::label(&cleo, &other);
        for hidden in [&source, &other] {
            assert_eq!(ann.get(&format!("/tasks/{hidden}")).refusal(), (404, "not_found".into()));
            assert_eq!(ann.get(&format!("/tasks/{hidden}/scene")).status, 404);
            let take = ann.post(&format!("/tasks/{hidden}/lease"), &json!({ "action": "take" }));
            assert_eq!(take.refusal(), (404, "not_found".into()));
        }
        assert!(Work::next(&ann, &town.project, "check").is_none());
        // Who only checks, and leads, see them.
        for who in [&world.sign_in("chen"), &town.admin] {
            assert_eq!(who.get(&format!("/tasks/{source}")).status, 200);
        }
        own
    } else {
        town.open[0].clone()
    };
    let ann = world.sign_in("ann");
    let mut out = Vec::new();
    let mut look = || out.push(overview(&ann, &town.project));
    world.wait(3600);
    look();
    let mut work = Work::take(&ann, &task);
    work.stage1();
    look();
    work.act("lock_stage1", &json!({})).fine();
    work.stage2();
    look();
    work.act("submit", &json!({})).fine();
    if is_gold {
        // Now the comparison is made: nothing is hidden any more.
        assert_eq!(overview(&ann, &town.project)["total"], 5);
    }
    out
}

#[test]
fn who_also_checks_meets_no_source_of_a_gold_task() {
    let (gold, ordinary) = (seen_by_a_checker(true), seen_by_a_checker(false));
    for (a, b) in gold.iter().zip(&ordinary) {
        assert_eq!(a, b);
    }
}
