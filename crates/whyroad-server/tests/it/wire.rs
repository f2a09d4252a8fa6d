//! HTTP requests and responses: sizes, ETags, problems, texts that look like markup, the document of the API.

use crate::work::Work;
use crate::world::World;
use serde_json::{Value, json};
use std::io::Read;

pub fn unchanged_answers_are_not_sent_again(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let path = format!("/projects/{project}");
    let first = admin.get(&path);
    let tag = first.header("etag").unwrap().to_owned();
    assert_eq!(first.header("cache-control"), Some("private, no-cache"));
    assert_eq!(first.header("vary"), Some("cookie, authorization"));
    let again = admin.call("GET", &path, None, &[("if-none-match", &tag)]);
    assert_eq!((again.status, again.body.len()), (304, 0));
    assert_eq!(again.header("etag"), Some(tag.as_str()));
    admin.patch(&path, &json!({ "guide": "new" })).fine();
    let third = admin.call("GET", &path, None, &[("if-none-match", &tag)]);
    assert_eq!(third.status, 200);
    assert_ne!(third.header("etag"), Some(tag.as_str()));
    let head = admin.call("HEAD", &path, None, &[]);
    assert_eq!((head.status, head.body.len()), (200, 0));
    let zipped = admin.call("GET", "/framework", None, &[("accept-encoding", "br, gzip")]);
    assert_eq!(zipped.header("content-encoding"), Some("gzip"));
    let mut text = String::new();
    flate2::read::GzDecoder::new(&zipped.body[..]).read_to_string(&mut text).unwrap();
    assert_eq!(text.as_bytes(), admin.get("/framework").body);
}

pub fn what_is_wrong_is_said_as_problem_json(world: &World) {
    let admin = world.admin();
    assert_eq!(admin.get("/no/such").refusal(), (404, "not_found".into()));
    // RFC 9110, 15.5.6: the response names the methods that the path has.
    for method in ["PUT", "DELETE"] {
        let refused = admin.call(method, "/projects", Some(b"{}"), &[]);
        assert_eq!(refused.refusal(), (405, "request.method".into()));
        assert_eq!(refused.header("allow"), Some("GET, HEAD, POST"), "{method}");
    }
    assert_eq!(
        admin.call("POST", "/projects", Some(b"{not json"), &[]).refusal(),
        (400, "request.invalid".into())
    );
    let unknown = admin.post("/projects", &json!({ "name": "x", "colour": 1 }));
    assert_eq!(unknown.refusal(), (400, "request.invalid".into()));
    assert!(unknown.json()["detail_en"].as_str().unwrap().contains("colour"));
    assert_eq!(unknown.json()["type"], "/problems/request.invalid");
    let settings = json!({ "name": "x", "settings": { "lease_s": 1 } });
    assert_eq!(admin.post("/projects", &settings).refusal(), (422, "project.invalid".into()));
    admin.post("/projects", &json!({ "name": "twice" })).fine();
    assert_eq!(
        admin.post("/projects", &json!({ "name": "twice" })).refusal(),
        (409, "project.exists".into())
    );
    // As for display names: what people cannot tell apart is one name.
    for alike in ["Twice", " twice ", "twi\u{200b}ce", "\u{ff54}wice"] {
        let refused = admin.post("/projects", &json!({ "name": alike }));
        assert_eq!(refused.refusal(), (409, "project.exists".into()), "{alike}");
    }
    let other = world.project(&admin, " other  one ", &json!({}));
    let path = format!("/projects/{other}");
    assert_eq!(admin.get(&path).fine()["name"], "other  one");
    assert_eq!(admin.patch(&path, &json!({ "name": "TWICE" })).refusal(), (409, "project.exists".into()));
    assert_eq!(
        admin.patch(&path, &json!({ "name": "Other one" })).fine()["name"],
        "Other one",
        "its own name"
    );
    assert_eq!(admin.get("/projects/%FF").refusal().0, 404, "not UTF-8");
}

pub fn what_is_too_large_is_refused(world: &World) {
    let admin = world.admin();
    let guide = json!({ "name": "p", "guide": "x".repeat(2_000_000) });
    assert_eq!(admin.post("/projects", &guide).refusal(), (413, "request.too_large".into()));
    let guide = json!({ "name": "p", "guide": "x".repeat(300_000) });
    assert_eq!(admin.post("/projects", &guide).refusal(), (422, "project.invalid".into()));
    let project = world.project(&admin, "town", &json!({}));
    // Many tasks at once may be large, if the sender is permitted.
    let mut unauthenticated = world.unauthenticated();
    unauthenticated.hello();
    let bulk = format!("/projects/{project}/tasks:create");
    let large = format!("{{\"episodes\": [], \"mined\": \"{}\"}}", "x".repeat(3_000_000));
    let answer = unauthenticated.call("POST", &bulk, Some(large.as_bytes()), &[]);
    assert_eq!(answer.refusal(), (401, "session.required".into()));
    assert_eq!(admin.call("POST", &bulk, Some(large.as_bytes()), &[]).refusal(), (404, "not_found".into()));
    let many: Vec<Value> = (0..101).map(|_| json!({ "path": "/coc_trace", "value": "x" })).collect();
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    let work = Work::take(&ann, &task);
    let body = json!({ "fence": work.fence, "base_version": work.version, "changes": many });
    assert_eq!(ann.patch(&work.path("/draft"), &body).refusal(), (400, "request.invalid".into()));
    let remark = json!({ "path": "", "text": "字".repeat(4001) });
    assert_eq!(ann.post(&work.path("/comments"), &remark).refusal(), (400, "request.invalid".into()));
    let episodes = json!({ "episodes": [], "mined": "week1", "overlap": 11 });
    let path = format!("/projects/{project}/tasks:create");
    assert_eq!(admin.post(&path, &episodes).refusal(), (400, "request.invalid".into()));
}

pub fn markup_comes_back_as_data(world: &World) {
    let script = "<script>alert(1)</script><img src=x onerror=alert(2)>";
    let admin = world.admin();
    let project = world.project(&admin, script, &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    ann.patch(&format!("/users/{}", ann.id), &json!({ "display": script })).fine();
    let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    let mut work = Work::take(&ann, &task);
    assert_eq!(work.set(&[("/critical_components/0/description", json!(script))]).status, 200);
    ann.post(&work.path("/comments"), &json!({ "path": "", "text": script })).fine();
    for path in ["/projects".to_owned(), "/users".to_owned(), work.path(""), work.path("/history")] {
        let answer = ann.get(&path);
        assert!(answer.text().contains("<script>"), "{path} has the text as it is");
        assert_eq!(answer.header("content-type"), Some("application/json"));
        assert_eq!(answer.header("x-content-type-options"), Some("nosniff"));
        assert!(answer.header("content-security-policy").unwrap().contains("sandbox"));
    }
    let bad = json!({ "name": "<b>", "password": crate::world::PASSWORD });
    assert_eq!(admin.post("/users", &bad).refusal(), (422, "user.name".into()));
}

pub fn tasks_come_from_mined_folders_within_limits(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let folders = admin.get("/mined").fine();
    assert_eq!(folders["items"], json!([{ "name": "week1", "episodes": 2 }]));
    assert_eq!(ann.get("/mined").refusal(), (403, "access.denied".into()));
    let create = |body: Value| admin.post(&format!("/projects/{project}/tasks:create"), &body);
    let made = create(json!({ "mined": "week1", "limit": 1 })).fine();
    assert_eq!((made["tasks"].as_array().unwrap().len(), &made["over_limit"]), (1, &json!(1)));
    let made = create(json!({ "mined": "week1" })).fine();
    assert_eq!((made["tasks"].as_array().unwrap().len(), &made["known"]), (1, &json!(1)));
    assert_eq!(create(json!({ "mined": "../etc" })).refusal().0, 404);
    assert_eq!(create(json!({})).refusal().0, 400);
    let mut lost = serde_json::to_value(crate::recorded::episode("gone", 1, world.future)).unwrap();
    let made = create(json!({ "episodes": [lost.clone()] })).fine();
    let why = json!({ "zh": "行程不可用：没有这个行程", "en": "no such drive" });
    assert_eq!(made["lost"], json!([{ "episode": "gone_e1", "text": why }]));
    lost["scenario_id"] = json!("other");
    let mut second = serde_json::to_value(crate::recorded::episode("drive2", 2, world.future)).unwrap();
    second["is_primary"] = json!(false);
    let [first, next] = [5, 6].map(|n| crate::recorded::episode("drive2", n, world.future));
    let limited = json!({ "episodes": [first, next, lost, second], "limit": 1 });
    let left = create(limited).fine();
    let reasons = ["left_out", "no_class", "secondary", "over_limit"].map(|reason| left[reason].clone());
    assert_eq!(reasons, [json!(3), json!(1), json!(1), json!(1)], "also what is after the limit");
    let left = create(json!({ "episodes": [lost, second], "per_leaf": 0 })).fine();
    let reasons = ["left_out", "no_class", "secondary", "over_limit"].map(|reason| left[reason].clone());
    assert_eq!(reasons, [json!(2), json!(1), json!(1), json!(0)], "each once, by its own reason");
    let primary = crate::recorded::episode("drive2", 3, world.future);
    let left = create(json!({ "episodes": [primary], "per_leaf": 0 })).fine();
    assert_eq!((&left["left_out"], &left["over_limit"]), (&json!(1), &json!(1)));
}

#[test]
fn the_document_of_the_api_is_up_to_date() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/openapi.json");
    let committed = std::fs::read_to_string(path).unwrap();
    assert!(
        committed == whyroad_server::api::openapi::text(whyroad_server::api::table::ROUTES),
        "run: cargo run -q -p whyroad-server --example openapi > crates/whyroad-server/openapi.json"
    );
}
