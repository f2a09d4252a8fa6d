//! What somebody with bad intent, or a broken tool, sends: each is refused, and nobody else feels it.

use crate::recorded::episode;
use crate::work::{Begin, Work};
use crate::world::World;
use serde_json::{Value, json};

/// So many lists, one in the other.
fn nested(depth: usize) -> Value {
    (0..depth).fold(json!(1), |inner, _| json!([inner]))
}

pub fn a_draft_nested_too_deep_is_refused_and_nobody_else_feels_it(world: &World) {
    let Begin { admin, project, ann, task } = Begin::on(world);
    let mut work = Work::take(&ann, &task);
    // serde_json reads nothing nested more than 128 deep: what is stored deeper is lost for ever. So much comes in just so.
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
    // Inside a draft it is a text like any other: drafts are kept as JSON, where it is escaped.
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
        assert!(made["lost"][0].as_str().unwrap().contains("outside the drive"), "{made}");
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
    // Ids of one project open nothing in another.
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
