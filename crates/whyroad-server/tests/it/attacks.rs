//! Malicious or malformed requests: each is refused, and does not affect other users.

use crate::recorded::episode;
use crate::work::{Begin, Work};
use crate::world::{PASSWORD, World};
use serde_json::{Value, json};

/// This many nested lists.
fn nested(depth: usize) -> Value {
    (0..depth).fold(json!(1), |inner, _| json!([inner]))
}

pub fn a_draft_nested_too_deep_is_refused_and_nobody_else_feels_it(world: &World) {
    let Begin { admin, project, ann, task } = Begin::on(world);
    let mut work = Work::take(&ann, &task);
    // serde_json cannot read anything nested more than 128 deep: data that is stored deeper is lost. Requests with
    // these depths can still be read.
    for depth in [40, 110, 120, 121, 122, 123] {
        let set = work.set(&[("/critical_components/0/a/b/c/d/e", nested(depth))]);
        assert_eq!(set.refusal(), (422, "draft.too_deep".into()), "{depth}");
    }
    assert_eq!(work.set(&[("/critical_components/0/x", nested(9))]).status, 200);
    for path in ["tasks", "export?format=tasks", "dashboard"] {
        assert_eq!(admin.get(&format!("/projects/{project}/{path}")).status, 200, "{path}");
    }
    let mut label = work.view()["draft"].clone();
    label["critical_components"][0]["x"] = nested(60);
    let line = json!({ "task": { "episode": episode("drive2", 1, world.future), "draft": label } });
    let import = format!("/projects/{project}/import");
    let told = admin.call("POST", &import, Some(line.to_string().as_bytes()), &[]).fine();
    assert_eq!((&told["tasks"], &told["lost"][0]["line"]), (&json!(0), &json!(1)));
    assert!(told["lost"][0]["text"]["en"].as_str().unwrap().contains("nested"), "{told}");
}

pub fn texts_that_one_of_the_databases_cannot_hold_are_refused_by_both(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    let nul = "a\u{0}b";
    let refused = (422, "text.nul".to_owned());
    let remark = json!({ "path": "", "text": nul });
    assert_eq!(admin.post(&format!("/tasks/{task}/comments"), &remark).refusal(), refused);
    assert_eq!(admin.patch(&format!("/projects/{project}"), &json!({ "guide": nul })).refusal(), refused);
    assert_eq!(admin.patch(&format!("/users/{}", admin.id), &json!({ "display": nul })).refusal(), refused);
    assert_eq!(admin.get(&format!("/projects/{project}/tasks?q=%00")).refusal(), refused);
    assert_eq!(admin.get("/tasks/a%00b").refusal(), refused);
    // Inside a draft it is an ordinary text: drafts are stored as JSON, where it is escaped.
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let mut work = Work::take(&ann, &task);
    assert_eq!(work.set(&[("/critical_components/0/description", json!(nul))]).status, 200);
    assert_eq!(work.view()["draft"]["critical_components"][0]["description"], nul);
}

pub fn an_episode_that_cannot_be_of_its_drive_makes_no_task(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    for moment in ["2262-04-11T23:47:16.854Z", "1677-09-21T00:12:44Z", "2026-01-15T10:29:59.900Z"] {
        let mut odd = serde_json::to_value(episode("drive1", 1, world.future)).unwrap();
        odd["keyframe"]["timestamp"] = json!(moment);
        for end in ["start_timestamp", "end_timestamp"] {
            odd["time_range"][end] = json!(moment);
        }
        let made =
            admin.post(&format!("/projects/{project}/tasks:create"), &json!({ "episodes": [odd] })).fine();
        assert!(made["lost"][0]["text"]["en"].as_str().unwrap().contains("outside the drive"), "{made}");
    }
}

pub fn people_know_whom_they_work_with_and_no_others(world: &World) {
    let admin = world.admin();
    let [town, road] = ["town", "road"].map(|name| world.project(&admin, name, &json!({})));
    let ann = world.person(&admin, &town, "ann", &["annotator"]);
    let lea = world.person(&admin, &road, "lea", &["lead"]);
    let bob = world.person(&admin, "", "bob", &[]);
    let names = |who: &crate::world::Person| {
        let items = who.get("/users").fine()["items"].as_array().unwrap().clone();
        items.iter().map(|u| u["name"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(names(&ann), ["admin", "ann"], "the admin made the project and is in it");
    assert_eq!(names(&bob), ["bob"]);
    assert_eq!(names(&lea), ["admin", "ann", "bob", "lea"], "a lead gives work to anybody");
    // Ids of one project give no access in another.
    let task = world.tasks(&admin, &town, &["drive1"], 1)[0].clone();
    for path in ["", "/scene", "/map", "/history", "/overlap"] {
        assert_eq!(lea.get(&format!("/tasks/{task}{path}")).refusal(), (404, "not_found".into()), "{path}");
    }
    let take = json!({ "action": "take" });
    assert_eq!(lea.post(&format!("/tasks/{task}/lease"), &take).refusal().0, 404);
    let move_away = json!({ "user": "lea", "roles": ["lead"] });
    assert_eq!(lea.post(&format!("/projects/{town}/members"), &move_away).refusal().0, 404);
}

pub fn what_leads_name_has_to_be_there(world: &World) {
    let admin = world.admin();
    let quota = |leaf: &str| json!({ "name": leaf, "quota": { leaf: 5 } });
    assert_eq!(admin.post("/projects", &quota("no.such.leaf")).refusal(), (422, "project.quota".into()));
    let project =
        admin.post("/projects", &quota(crate::recorded::LEAF)).fine()["id"].as_str().unwrap().to_owned();
    let member = json!({ "user": "admin", "roles": ["lead"], "skills": ["cutin"] });
    let path = format!("/projects/{project}/members");
    assert_eq!(admin.post(&path, &member).refusal(), (422, "member.skill".into()));
    let hook = json!({ "url": "http://ci/", "events": ["submitted"] });
    let path = format!("/projects/{project}/webhooks");
    assert_eq!(admin.post(&path, &hook).refusal(), (422, "webhook.event".into()));
}

pub fn many_guesses_at_once_are_judged_like_one_after_another(world: &World) {
    let admin = world.admin();
    world.person(&admin, "", "ann", &[]);
    let guess = |i: usize| {
        let mut p = world.unauthenticated();
        p.hello();
        p.post("/session", &json!({ "name": "ann", "password": format!("wrong horse {i}") })).status
    };
    let outcomes: Vec<u16> = std::thread::scope(|scope| {
        let all: Vec<_> = (0..60).map(|i| scope.spawn(move || guess(i))).collect();
        all.into_iter().map(|t| t.join().unwrap()).collect()
    });
    let judged = outcomes.iter().filter(|s| **s == 401).count();
    assert_eq!((judged, outcomes.iter().filter(|s| **s == 429).count()), (5, 55), "{outcomes:?}");
}

pub fn tokens_end_and_make_no_tokens(world: &World) {
    let admin = world.admin();
    let ann = world.person(&admin, "", "ann", &[]);
    let script = |made: &Value| {
        let mut p = world.unauthenticated();
        p.token = Some(made["token"].as_str().unwrap().to_owned());
        p
    };
    let make = |more: Value| {
        let mut body = json!({ "name": "script" });
        more.as_object().unwrap().iter().for_each(|(k, v)| body[k] = v.clone());
        ann.post("/tokens", &body)
    };
    // No token can create another one, change its user, or sign in permanently.
    let first = script(&make(json!({})).fine());
    assert_eq!(first.post("/tokens", &json!({ "name": "x" })).refusal(), (403, "token.session_only".into()));
    let own = format!("/users/{}", ann.id);
    let change = json!({ "password": "another horse", "present_password": PASSWORD });
    assert_eq!(first.patch(&own, &change).refusal(), (403, "token.session_only".into()));
    // Read-only tokens can read.
    let reads = script(&make(json!({ "scope": "read" })).fine());
    reads.get("/projects").fine();
    let id = make(json!({})).fine()["id"].as_str().unwrap().to_owned();
    let revoke = format!("/tokens/{id}");
    assert_eq!(reads.call("DELETE", &revoke, None, &[]).refusal(), (403, "token.read_only".into()));
    // An admin sees and revokes the tokens of others; other users do not.
    let listed = admin.get(&format!("/tokens?user={}", ann.id)).fine();
    assert_eq!(listed["items"].as_array().unwrap().len(), 3);
    let bob = world.person(&admin, "", "bob", &[]);
    assert_eq!(bob.get(&format!("/tokens?user={}", ann.id)).status, 403);
    assert_eq!(bob.call("DELETE", &revoke, None, &[]).status, 404);
    assert_eq!(admin.call("DELETE", &revoke, None, &[]).status, 200);
    // They expire.
    assert_eq!(make(json!({ "days": 0 })).status, 400);
    assert_eq!(make(json!({ "days": 366 })).status, 400);
    let short = script(&make(json!({ "days": 1 })).fine());
    short.get("/projects").fine();
    world.wait(24 * 3600);
    assert_eq!(short.get("/projects").refusal(), (401, "session.required".into()));
    first.get("/projects").fine();
    // They also end when the password changes or is reset, and with the account.
    ann.patch(&own, &change).fine();
    assert_eq!(first.get("/projects").status, 401);
    for end in [json!({ "password": "third horse" }), json!({ "disabled": true })] {
        let name = if end.get("disabled").is_some() { "dan" } else { "cara" };
        let person = world.person(&admin, "", name, &[]);
        let token = script(&person.post("/tokens", &json!({ "name": "x" })).fine());
        token.get("/projects").fine();
        admin.patch(&format!("/users/{}", person.id), &end).fine();
        assert_eq!(token.get("/projects").status, 401, "{end}");
    }
}

pub fn a_password_that_everybody_guesses_is_refused(world: &World) {
    let admin = world.admin();
    for weak in ["aaaaaaaaaa", "1234567890", "password123"] {
        let made = admin.post("/users", &json!({ "name": "weak", "password": weak }));
        assert_eq!(made.refusal(), (422, "password.weak".into()), "{weak}");
    }
}

pub fn a_field_has_one_path(world: &World) {
    let Begin { admin, task, ann, .. } = Begin::on(world);
    let mut work = Work::take(&ann, &task);
    work.stage1();
    for odd in [
        "/critical_components/00/description",
        "/critical_components/+0/description",
        "//critical_components",
        "/critical_components//0",
        "/critical_components/0/a~2b",
        "/critical_components/0/a~",
        "/critical_components/0/",
        "/",
    ] {
        assert_eq!(work.set(&[(odd, json!("x"))]).refusal(), (422, "draft.path".into()), "{odd}");
    }
    let draft = admin.get(&work.path("")).fine()["draft"].clone();
    assert!(draft.get("").is_none(), "{draft}");
    assert_eq!(work.set(&[("/critical_components/0/a~1b", json!("x"))]).status, 200);
}

pub fn more_values_than_any_label_has_are_refused_at_once(world: &World) {
    let Begin { admin, project, ann, task } = Begin::on(world);
    let bob = world.person(&admin, &project, "bob", &["annotator"]);
    let theirs = world.tasks(&admin, &project, &["drive2"], 1)[0].clone();
    let (mut work, mut other) = (Work::take(&ann, &task), Work::take(&bob, &theirs));
    let many = Value::Array(vec![json!({}); 85_000]);
    std::thread::scope(|scope| {
        let attack = scope.spawn(|| {
            let start = std::time::Instant::now();
            let refusal = work.set(&[("/critical_components", many.clone())]).refusal();
            (refusal, start.elapsed())
        });
        // No other user waits for it.
        let mut n = 0;
        while n < 5 || !attack.is_finished() {
            let start = std::time::Instant::now();
            let text = json!(format!("change {n}"));
            assert_eq!(other.set(&[("/critical_components/0/description", text)]).status, 200);
            assert!(start.elapsed().as_millis() < 1500, "{:?}", start.elapsed());
            n += 1;
        }
        let (refusal, took) = attack.join().unwrap();
        assert_eq!(refusal, (422, "draft.too_many".into()));
        assert!(took.as_millis() < 1500, "{took:?}");
    });
}

pub fn a_text_to_search_for_may_not_be_a_book(world: &World) {
    let Begin { admin, project, .. } = Begin::on(world);
    for name in ["q", "scenario", "assignee"] {
        let path = |n: usize| format!("/projects/{project}/tasks?{name}={}", "a".repeat(n));
        assert_eq!(admin.get(&path(1000)).refusal(), (400, "request.invalid".into()), "{name}");
        assert_eq!(admin.get(&path(60_000)).refusal(), (414, "request.too_long".into()), "{name}");
    }
}
