//! Overlap groups, the queue, audits, and actions of leads on tasks.

use crate::recorded::episode;
use crate::work::{Begin, Work};
use crate::world::{Person, World};
use serde_json::{Value, json};

fn state(who: &Person, task: &str) -> Value {
    who.get(&format!("/tasks/{task}")).fine()["task"]["state"].clone()
}

pub fn overlaps_are_blind_until_all_are_in_then_one_is_chosen(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({ "audit_min_percent": 0, "audit_max_percent": 0 }));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let bob = world.person(&admin, &project, "bob", &["annotator", "lead"]);
    let chen = world.person(&admin, &project, "chen", &["checker"]);
    let ids = world.tasks(&admin, &project, &["drive1"], 2);
    assert_eq!(ids.len(), 2);
    let first = Work::next(&ann, &project, "label").unwrap();
    // Ann's own copy again, never the second one.
    assert_eq!(Work::next(&ann, &project, "label").unwrap().task, first.task);
    let other = ids.iter().find(|id| **id != first.task).unwrap();
    let take = json!({ "action": "take" });
    assert_eq!(
        ann.post(&format!("/tasks/{other}/lease"), &take).refusal(),
        (403, "task.overlap_twice".into())
    );
    Work::label(&ann, &first.task);
    assert_eq!(admin.get(&format!("/tasks/{other}/overlap")).refusal(), (409, "overlap.not_ready".into()));
    let choose = json!({ "action": "adjudicate", "reason": "clearer" });
    let adjudicate = |who: &Person, id: &str| who.post(&format!("/tasks/{id}/actions"), &choose);
    assert_eq!(adjudicate(&admin, &first.task).refusal(), (409, "overlap.not_ready".into()));
    Work::label(&bob, other);
    let group = admin.get(&format!("/tasks/{other}/overlap")).fine();
    assert_eq!(group["items"].as_array().unwrap().len(), 2);
    assert_eq!(group["items"][0]["label"]["provenance"]["by"], "ann");
    assert_eq!(ann.get(&format!("/tasks/{}/overlap", first.task)).refusal().0, 403, "not for annotators");
    assert_eq!(adjudicate(&bob, &first.task).refusal(), (403, "task.own_work".into()));
    assert_eq!(adjudicate(&admin, &first.task).fine()["task"]["adjudication"], "chosen");
    assert_eq!(admin.get(&format!("/tasks/{other}")).fine()["task"]["adjudication"], "superseded");
    // Only the chosen one is checked and exported.
    let mut check = Work::next(&chen, &project, "check").unwrap();
    assert_eq!(check.task, first.task);
    check.act("accept", &json!({})).fine();
    assert!(Work::next(&chen, &project, "check").is_none());
    assert_eq!(chen.post(&format!("/tasks/{other}/lease"), &take).refusal(), (409, "task.superseded".into()));
    let out = admin.get(&format!("/projects/{project}/export?format=labels")).text();
    assert_eq!(out.lines().count(), 1);
}

pub fn what_cannot_be_labelled_is_left_out_with_a_reason_and_comes_back(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let bob = world.person(&admin, &project, "bob", &["annotator"]);
    let ids = world.tasks(&admin, &project, &["drive1", "drive2", "drive3"], 1);
    let mut work = Work::take(&ann, &ids[0]);
    work.stage1();
    assert_eq!(work.act("skip", &json!({})).refusal(), (422, "action.reason".into()));
    work.act("skip", &json!({ "reason": "too dark" })).fine();
    assert_eq!(state(&admin, &ids[0]), "skipped");
    let mut work = Work::take(&ann, &ids[1]);
    work.stage1();
    work.act("lock_stage1", &json!({})).fine();
    work.act("reject", &json!({ "reason": "the ego drives unsafely" })).fine();
    assert_eq!(state(&admin, &ids[1]), "rejected");
    let act = |who: &Person, id: &str, action: &str| {
        who.post(&format!("/tasks/{id}/actions"), &json!({ "action": action, "reason": "again" }))
    };
    assert_eq!(act(&ann, &ids[1], "reopen").refusal(), (403, "task.role_missing".into()));
    let view = act(&admin, &ids[1], "reopen").fine();
    assert_eq!((&view["task"]["state"], &view["stage"]), (&json!("open"), &json!("stage1")));
    let take = json!({ "action": "take" });
    let retake = ann.post(&format!("/tasks/{}/lease", ids[1]), &take);
    assert_eq!(retake.refusal(), (403, "task.future_seen".into()), "ann has seen its future");
    let fresh = Work::take(&bob, &ids[1]);
    let first = &fresh.view()["draft"]["critical_components"][0]["description"];
    assert!(first.as_str().unwrap().starts_with("a car, least gap"), "bob begins with the suggestion");
    // A lead ends a task that another user holds; the holder's token is invalid then.
    let mut held = Work::take(&ann, &ids[2]);
    act(&admin, &ids[2], "skip").fine();
    assert_eq!(held.set(&[("/critical_components", json!([]))]).refusal(), (409, "lease.lost".into()));
    // An accepted label is reopened into rework, with its text.
    let project2 = world.project(&admin, "two", &json!({ "audit_min_percent": 0, "audit_max_percent": 0 }));
    for (user, roles) in [("ann", ["annotator"]), ("bob", ["checker"])] {
        admin.post(&format!("/projects/{project2}/members"), &json!({ "user": user, "roles": roles })).fine();
    }
    let id = world.tasks(&admin, &project2, &["drive9"], 1)[0].clone();
    Work::label(&ann, &id);
    let mut check = Work::take(&bob, &id);
    check.act("accept", &json!({})).fine();
    let view = act(&admin, &id, "reopen").fine();
    assert_eq!(view["task"]["state"], "rework");
    assert_eq!(view["draft"]["provenance"]["by"], "ann");
}

pub fn audits_follow_the_share_and_the_record(world: &World) {
    let admin = world.admin();
    let always = json!({ "audit_min_percent": 100, "audit_max_percent": 100 });
    let project = world.project(&admin, "town", &always);
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let chen = world.person(&admin, &project, "chen", &["checker", "auditor"]);
    let aud = world.person(&admin, &project, "aud", &["auditor"]);
    let ids = world.tasks(&admin, &project, &["drive1"], 1);
    Work::label(&ann, &ids[0]);
    let mut check = Work::take(&chen, &ids[0]);
    assert_eq!(check.act("accept", &json!({})).fine()["task"]["state"], "checked");
    assert!(Work::next(&chen, &project, "audit").is_none(), "nobody audits what they checked");
    let mut audit = Work::next(&aud, &project, "audit").unwrap();
    audit.act("send_back", &json!({ "reason": "the cause is another" })).fine();
    let dashboard = admin.get(&format!("/projects/{project}/dashboard")).fine();
    let record = &dashboard["audit"][0];
    assert_eq!((&record["audited"], &record["failed"]), (&json!(1), &json!(1)));
    let mut again = Work::take(&ann, &ids[0]);
    again.act("submit", &json!({})).fine();
    assert!(Work::next(&aud, &project, "audit").is_none(), "no audit without a new check");
    let mut check = Work::take(&chen, &ids[0]);
    check.act("accept", &json!({})).fine();
    let mut audit = Work::next(&aud, &project, "audit").unwrap();
    assert_eq!(audit.act("accept", &json!({})).fine()["task"]["state"], "accepted");
}

fn why_nothing(who: &Person, project: &str, kind: &str) -> Vec<String> {
    let told = who.get(&format!("/projects/{project}/queue?kind={kind}")).fine();
    told["reasons"].as_array().unwrap().iter().map(|r| r.as_str().unwrap().to_owned()).collect()
}

pub fn an_empty_queue_says_why(world: &World) {
    let admin = world.admin();
    let project =
        world.project(&admin, "town", &json!({ "audit_min_percent": 100, "audit_max_percent": 100 }));
    let ann = world.person(&admin, &project, "ann", &["annotator", "checker"]);
    let bob = world.person(&admin, &project, "bob", &["annotator", "checker", "auditor"]);
    assert_eq!(why_nothing(&ann, &project, "label"), ["no_tasks"]);
    let ids = world.tasks(&admin, &project, &["drive1"], 2);
    assert_eq!(why_nothing(&ann, &project, "label"), [""; 0], "there is something");
    assert_eq!(why_nothing(&ann, &project, "audit"), ["role"]);
    assert_eq!(why_nothing(&ann, &project, "check"), ["finished"], "nothing is submitted yet");
    let before = admin.get(&format!("/tasks/{}", ids[0])).fine();
    Work::take(&ann, &ids[0]);
    assert_eq!(why_nothing(&bob, &project, "label"), [""; 0]);
    assert_eq!(
        admin.get(&format!("/tasks/{}", ids[1])).fine()["version"],
        before["version"],
        "asking takes nothing"
    );
    admin.post(&format!("/tasks/{}/assign", ids[1]), &json!({ "user": "admin" })).fine();
    assert_eq!(why_nothing(&bob, &project, "label"), ["held", "assigned"]);
    admin.post(&format!("/tasks/{}/assign", ids[1]), &json!({ "user": null })).fine();
    Work::label(&ann, &ids[0]);
    // Both are of one episode: a user who was shown the end of the first has seen what comes after the second's
    // keyframe.
    assert_eq!(why_nothing(&ann, &project, "label"), ["future_seen"]);
    assert_eq!(why_nothing(&bob, &project, "check"), ["not_chosen"]);
    let act = |id: &str, action: &str| {
        admin
            .post(&format!("/tasks/{id}/actions"), &json!({ "action": action, "reason": "one is enough" }))
            .fine()
    };
    act(&ids[1], "skip");
    act(&ids[0], "adjudicate");
    assert_eq!(why_nothing(&ann, &project, "check"), ["own_work"]);
    let mut check = Work::take(&bob, &ids[0]);
    check.act("accept", &json!({})).fine();
    assert_eq!(why_nothing(&bob, &project, "audit"), ["own_check"]);
    assert_eq!(bob.get(&format!("/projects/{project}/queue?kind=sleep")).refusal().0, 400);
}

pub fn the_queue_goes_by_hand_skill_language_and_priority(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let members = format!("/projects/{project}/members");
    let make = |drive: &str, more: Value| {
        let mut body = json!({ "episodes": [episode(drive, 1, world.future)] });
        for (k, v) in more.as_object().unwrap() {
            body[k] = v.clone();
        }
        let made = admin.post(&format!("/projects/{project}/tasks:create"), &body).fine();
        made["tasks"][0].as_str().unwrap().to_owned()
    };
    let plain = make("drive1", json!({}));
    let soon = make("drive2", json!({ "priority": 5 }));
    let english = make("drive3", json!({ "priority": 9, "lang": "en" }));
    let next = |who: &Person| {
        let work = Work::next(who, &project, "label")?;
        who.post(&work.path("/lease"), &json!({ "action": "release", "fence": work.fence })).fine();
        Some(work.task)
    };
    let skills = |list: Value| {
        admin.post(&members, &json!({ "user": "ann", "roles": ["annotator"], "skills": list })).fine();
    };
    skills(json!(["proactive"]));
    assert_eq!(next(&ann), None, "not her classes");
    assert_eq!(why_nothing(&ann, &project, "label"), ["language", "classes"]);
    skills(json!(["reactive_agent.cutin"]));
    assert_eq!(next(&ann), Some(soon.clone()), "by priority, in her language");
    ann.patch(&format!("/users/{}", ann.id), &json!({ "lang": "en" })).fine();
    assert_eq!(next(&ann), Some(english.clone()), "the English one is hers now");
    // An annotator with both languages gets both, whatever the language of her page; a change without languages keeps
    // them.
    ann.patch(&format!("/users/{}", ann.id), &json!({ "lang": "zh" })).fine();
    assert_eq!(next(&ann), Some(soon.clone()));
    let speaks = |list: Value| {
        admin.post(&members, &json!({ "user": "ann", "roles": ["annotator"], "languages": list }))
    };
    assert_eq!(speaks(json!(["fr"])).refusal(), (400, "request.invalid".into()));
    let all = speaks(json!(["zh", "en", "zh"])).fine();
    let hers = all["items"].as_array().unwrap().iter().find(|m| m["user"]["name"] == "ann").unwrap();
    assert_eq!(hers["languages"], json!(["en", "zh"]));
    skills(json!([]));
    assert_eq!(next(&ann), Some(english.clone()));
    speaks(json!(["zh"])).fine();
    assert_eq!(next(&ann), Some(soon.clone()));
    // Assigned tasks come first, and nobody else gets them.
    let bob = world.person(&admin, &project, "bob", &["annotator"]);
    let assign =
        |task: &str, user: Value| admin.post(&format!("/tasks/{task}/assign"), &json!({ "user": user }));
    assert_eq!(assign(&plain, json!("admin2")).refusal().0, 404);
    assign(&plain, json!("bob")).fine();
    assert_eq!(next(&bob), Some(plain.clone()));
    assign(&soon, json!("ann")).fine();
    assert_eq!(next(&bob), Some(plain.clone()), "bob's own first");
    let by_link = bob.post(&format!("/tasks/{soon}/lease"), &json!({ "action": "take" }));
    assert_eq!(by_link.refusal(), (403, "task.assigned".into()));
    let list = bob.get(&format!("/projects/{project}/tasks")).fine();
    let mine: Vec<&Value> = list["items"].as_array().unwrap().iter().map(|t| &t["id"]).collect();
    assert_eq!(mine, [&json!(plain)], "an annotator's list has only their own");
}

pub fn lists_come_page_by_page_and_filtered(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let drives: Vec<String> = (1..=7).map(|i| format!("drive{i}")).collect();
    let drives: Vec<&str> = drives.iter().map(String::as_str).collect();
    let mut ids = world.tasks(&admin, &project, &drives, 1);
    let mut seen = Vec::new();
    let mut cursor = String::new();
    let mut pages = 0;
    loop {
        let page = admin.get(&format!("/projects/{project}/tasks?limit=3&cursor={cursor}")).fine();
        seen.extend(page["items"].as_array().unwrap().iter().map(|t| t["id"].as_str().unwrap().to_owned()));
        pages += 1;
        // A task that is added in between does not shift the pages.
        if pages == 1 {
            world.wait(1);
            world.tasks(&admin, &project, &["drive8"], 1);
        }
        match page["next"].as_str() {
            Some(next) => cursor = next.to_owned(),
            None => break,
        }
    }
    assert_eq!((pages, seen.len()), (3, 8));
    seen.pop();
    ids.sort_unstable();
    seen.sort_unstable();
    assert_eq!(seen, ids);
    let count = |query: &str| {
        let page = admin.get(&format!("/projects/{project}/tasks?{query}")).fine();
        page["items"].as_array().unwrap().len()
    };
    assert_eq!(count("state=open"), 8);
    assert_eq!(count("state=accepted,rework"), 0);
    assert_eq!(count("scenario=reactive_agent.cutin"), 8);
    assert_eq!(count("scenario=reactive_agent.cut"), 0, "a part of a name is no class");
    assert_eq!(count("q=drive3"), 1);
    assert_eq!(count("q=drive_"), 0, "an underscore is an underscore");
    assert_eq!(count("q=%25"), 0, "a percent sign is a percent sign");
    assert_eq!(count("mine=true"), 0);
    assert_eq!(count("assignee=admin"), 0);
    for bad in ["limit=0", "limit=201", "limit=x", "state=none", "cursor=zz"] {
        assert_eq!(admin.get(&format!("/projects/{project}/tasks?{bad}")).refusal().0, 400, "{bad}");
    }
}

pub fn what_is_given_back_says_why_and_the_history_comes_in_pages(world: &World) {
    let Begin { admin, ann, task, .. } = Begin::on(world);
    let work = Work::take(&ann, &task);
    let give_back = |reason: &str| json!({ "action": "release", "fence": work.fence, "reason": reason });
    let lease = work.path("/lease");
    assert_eq!(ann.post(&lease, &give_back(&"x".repeat(4001))).refusal(), (400, "request.invalid".into()));
    ann.post(&lease, &give_back(" the camera is dark ")).fine();
    let history = |query: &str| admin.get(&format!("/tasks/{task}/history{query}"));
    // An admin sees only their own entries of a Stage I: they created the task.
    assert_eq!(history("").fine()["items"].as_array().unwrap().len(), 1);
    Work::label(&ann, &task);
    let all = history("").fine();
    let all = all["items"].as_array().unwrap();
    let given_back = all.iter().find(|e| e["action"] == "release").unwrap();
    assert_eq!(given_back["comment"], "the camera is dark");
    let (mut paged, mut cursor) = (vec![], String::new());
    loop {
        let page = history(&format!("?limit=2{cursor}")).fine();
        assert!(page["items"].as_array().unwrap().len() <= 2);
        paged.extend(page["items"].as_array().unwrap().clone());
        let Some(next) = page["next"].as_str() else { break };
        cursor = format!("&cursor={next}");
    }
    assert_eq!(&paged, all);
    for odd in ["?limit=0", "?cursor=x", "?limit=-1"] {
        assert_eq!(history(odd).refusal(), (400, "request.invalid".into()), "{odd}");
    }
}
