//! Attacks on Stage I: data that an annotator can get before the lock, by any route, must not depend on anything after
//! the keyframe, nor on texts of other people.
//!
//! The strongest form: two services that differ only in the future of the drive (and in other people's work) receive
//! the same requests; every response must be equal, byte for byte and header for header. Random ids are replaced by
//! their order of appearance.

use crate::recorded::{Future, episode};
use crate::work::{Work, components};
use crate::world::{Person, Reply, World};
use serde_json::{Value, json};
use std::collections::HashMap;
use whyroad_server::api::route::Verb;
use whyroad_server::api::table::ROUTES;

/// Replaces random hexadecimal texts (ids, tokens, ETags) by numbers in order of appearance.
#[derive(Default)]
struct Names(HashMap<String, usize>);

impl Names {
    fn plain(&mut self, text: &str) -> String {
        let mut out = String::new();
        let mut run = String::new();
        for c in text.chars().chain(['\u{0}']) {
            if c.is_ascii_digit() || ('a'..='f').contains(&c) {
                run.push(c);
                continue;
            }
            if run.len() >= 20 {
                let next = self.0.len();
                let number = *self.0.entry(run.clone()).or_insert(next);
                // Keeps the length, because lengths are compared too.
                out.push_str(&format!("{number:#>width$}", width = run.len()));
            } else {
                out.push_str(&run);
            }
            run.clear();
            out.push(c);
        }
        out
    }

    fn reply(&mut self, r: &Reply) -> String {
        let mut headers: Vec<String> = r.headers.iter().map(|(n, v)| format!("{n}: {v}")).collect();
        headers.retain(|h| !h.starts_with("date:"));
        headers.sort();
        self.plain(&format!("{}\n{}\n\n{}", r.status, headers.join("\n"), r.text()))
    }
}

/// Every reading route with every parameter that might return something.
fn readings(project: &str, task: &str, user: &str) -> Vec<String> {
    let mut out = Vec::new();
    for route in ROUTES.iter().filter(|r| r.verb == Verb::Get) {
        let path = route
            .path
            .replace("{p}", project)
            .replace("{t}", task)
            .replace("{u}", user)
            .replace("{m}", "week1");
        let mut paths = vec![path];
        let mut fill = |name: &str, values: Vec<String>| {
            let old = std::mem::take(&mut paths);
            for path in old {
                if path.contains(name) {
                    paths.extend(values.iter().map(|v| path.replace(name, v)));
                } else {
                    paths.push(path);
                }
            }
        };
        fill("{seq}", (0..12).map(|i| i.to_string()).collect());
        fill("{camera}", vec!["front%20left".into(), "rear".into()]);
        fill("{index}", (0..140).step_by(2).map(|i| i.to_string()).collect());
        for (name, _) in route.query {
            let values: &[&str] = match *name {
                "state" => &["stage2,submitted,accepted"],
                "kind" => &["label", "check", "audit", "none"],
                "limit" | "cursor" => &["1", "2"],
                "q" => &["drive"],
                "scenario" => &["reactive_agent", "reactive_agent.following", SUDDEN, STEADY],
                "sort" => &["scenario", "-scenario"],
                "assignee" => &["admin"],
                "mine" => &["true"],
                // Parameters of the export, to which annotators have no access.
                _ => &[],
            };
            let first = paths[0].clone();
            paths.extend(values.iter().map(|v| format!("{first}?{name}={v}")));
        }
        out.extend(paths);
    }
    out
}

/// All data that an annotator in Stage I can get, as one text.
pub fn all_answers(project: &str, work: &Work<'_>, ann: &Person) -> Vec<(String, String)> {
    let mut names = Names::default();
    let mut out = Vec::new();
    for path in readings(project, &work.task, &ann.id) {
        // The document of the API is always the same, and long.
        if path == "/openapi.json" {
            continue;
        }
        let answer = ann.get(&path);
        out.push((names.plain(&path), names.reply(&answer)));
        let zipped = ann.call("GET", &path, None, &[("accept-encoding", "gzip")]);
        let length = zipped.header("content-length").map(str::to_owned);
        // The compressed length of a text with random ids varies by a few bytes; the uncompressed length does not.
        if zipped.header("content-encoding").is_none() {
            out.push((format!("{} length", names.plain(&path)), format!("{length:?}")));
        }
        if let Some(tag) = answer.header("etag") {
            let known = ann.call("GET", &path, None, &[("if-none-match", tag)]);
            out.push((names.plain(&path), names.reply(&known)));
        }
    }
    // Calls that write or query by POST.
    let later = json!({ "timestamp": "2026-01-15T10:30:11.000Z", "frame_idx": 110, "type": "reactive" });
    let earlier = json!({ "timestamp": "2026-01-15T10:30:09.000Z", "frame_idx": 90, "type": "reactive" });
    let change = |path: &str, value: Value| json!({ "fence": work.fence, "base_version": work.version, "changes": [{ "path": path, "value": value }] });
    let stale = json!({ "fence": work.fence, "base_version": 0,
        "changes": [{ "path": "/keyframe", "value": earlier }, { "path": "/critical_components", "value": [] }] });
    let label = json!({ "label": work.view()["draft"] });
    let tries: Vec<(&str, String, Value)> = vec![
        ("PATCH", work.path("/draft"), change("/coc_trace", json!("x"))),
        ("PATCH", work.path("/draft"), change("/driving_decision", json!(null))),
        (
            "PATCH",
            work.path("/draft"),
            change("/time_range/end_timestamp", json!("2026-01-15T10:30:20.000Z")),
        ),
        ("PATCH", work.path("/draft"), change("/second_keyframe", json!(null))),
        ("PATCH", work.path("/draft"), change("/keyframe", later)),
        ("PATCH", work.path("/draft"), change("/keyframe/range_end", json!(null))),
        ("PATCH", work.path("/draft"), change("/keyframe", json!(null))),
        ("PATCH", work.path("/draft"), change("/keyframe", earlier.clone())),
        ("PATCH", work.path("/draft"), stale),
        ("POST", work.path("/lease"), json!({ "action": "heartbeat", "fence": work.fence })),
        ("POST", work.path("/validate"), label),
        ("POST", work.path("/comments"), json!({ "path": "/coc_trace", "text": "what is it?" })),
        ("POST", work.path("/assign"), json!({ "user": "ann" })),
        ("POST", work.path("/actions"), json!({ "fence": work.fence, "action": "submit" })),
        ("POST", work.path("/actions"), json!({ "fence": work.fence, "action": "accept" })),
        ("POST", work.path("/actions"), json!({ "fence": work.fence, "action": "restore", "seq": 1 })),
        ("POST", work.path("/actions"), json!({ "fence": work.fence, "action": "adjudicate" })),
        ("POST", format!("/projects/{project}/tasks:next"), json!({ "kind": "check" })),
        ("POST", format!("/projects/{project}/tasks:next"), json!({ "kind": "label" })),
        ("GET", work.path(""), Value::Null),
        ("GET", work.path("/history"), Value::Null),
    ];
    for (verb, path, body) in tries {
        let body = body.to_string();
        let answer = ann.call(verb, &path, (verb != "GET").then_some(body.as_bytes()), &[]);
        out.push((names.plain(&format!("{verb} {path} {body}")), names.reply(&answer)));
    }
    out
}

/// Ann is in Stage I of one copy of an episode; `elsewhere` are the actions of others on the other copy, and on the
/// project.
fn stage1(future: Future, elsewhere: impl Fn(&World, &Person, &str, &str)) -> Vec<(String, String)> {
    let world = World::on_sqlite(future);
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let ids = world.tasks(&admin, &project, &["drive1"], 2);
    world.wait(60);
    elsewhere(&world, &admin, &project, &ids[1]);
    let mut work = Work::take(&ann, &ids[0]);
    work.set(&[("/critical_components/0/description", json!("a car on the left"))]);
    let out = all_answers(&project, &work, &ann);
    assert!(out.len() > 100, "only {} answers", out.len());
    // The attack must have reached the existing data.
    let seen = out.iter().filter(|(_, answer)| answer.starts_with("200")).count();
    assert!(seen > 30, "only {seen} answers with something in them");
    out
}

pub fn same(a: &[(String, String)], b: &[(String, String)]) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        assert_eq!(a.0, b.0);
        assert_eq!(a.1, b.1, "{} differs", a.0);
    }
}

#[test]
fn drives_that_differ_only_after_the_keyframe_answer_alike() {
    let nobody = |_: &World, _: &Person, _: &str, _: &str| {};
    same(&stage1(Future::Brakes, nobody), &stage1(Future::DrivesOn, nobody));
}

#[test]
fn what_others_write_about_the_same_episode_changes_no_answer() {
    let others = |world: &World, admin: &Person, project: &str, copy: &str| {
        let bob = world.person(admin, project, "bob", &["annotator"]);
        let mut work = Work::take(&bob, copy);
        work.stage1();
        work.act("lock_stage1", &json!({})).fine();
        work.stage2();
        let remark = json!({ "path": "/coc_trace", "text": "the car then stops" });
        bob.post(&work.path("/comments"), &remark).fine();
        work.act("submit", &json!({})).fine();
    };
    let idle = |world: &World, admin: &Person, project: &str, _: &str| {
        world.person(admin, project, "bob", &["annotator"]);
    };
    same(&stage1(Future::Brakes, others), &stage1(Future::Brakes, idle));
}

#[test]
fn the_test_sees_a_difference_where_there_is_one() {
    // In Stage II the two futures must be visible: otherwise the comparison above could not fail.
    let answers = |future| {
        let world = World::on_sqlite(future);
        let admin = world.admin();
        let project = world.project(&admin, "town", &json!({}));
        let ann = world.person(&admin, &project, "ann", &["annotator"]);
        let ids = world.tasks(&admin, &project, &["drive1"], 1);
        let mut work = Work::take(&ann, &ids[0]);
        work.stage1();
        work.act("lock_stage1", &json!({})).fine();
        let mut names = Names::default();
        let ask = |p: &String| (p.replace(&work.task, "T").replace(&project, "P"), names.reply(&ann.get(p)));
        readings(&project, &work.task, &ann.id).iter().map(ask).collect::<Vec<_>>()
    };
    let (a, b) = (answers(Future::Brakes), answers(Future::DrivesOn));
    let differ: Vec<&str> = a.iter().zip(&b).filter(|(a, b)| a.1 != b.1).map(|(a, _)| a.0.as_str()).collect();
    for path in ["/tasks/T", "/tasks/T/scene", "/tasks/T/history/1", "/tasks/T/media/front%20left/114"] {
        assert!(differ.contains(&path), "{path} does not differ: {differ:?}");
    }
}

/// Two L3 classes of one L2; the name of the first reveals the lead's behavior after the keyframe.
const SUDDEN: &str = "reactive_agent.following.lead_sudden_brake";
const STEADY: &str = "reactive_agent.following.steady";

/// Ann is in Stage I of an episode of `leaf`, in a project with these settings.
fn of_leaf(leaf: &str, settings: &Value) -> Vec<(String, String)> {
    let world = World::on_sqlite(Future::Brakes);
    let admin = world.admin();
    let project = world.project(&admin, "town", settings);
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let mut one = serde_json::to_value(episode("drive1", 1, world.future)).unwrap();
    let parts: Vec<&str> = leaf.split('.').collect();
    one["scenario_id"] = json!(leaf);
    if parts[2] == "steady" {
        // Other differences between L3 classes: range, type of keyframe, signals, target.
        one["time_range"]["start_timestamp"] = json!("2026-01-15T10:30:04.000Z");
        one["keyframe"]["type"] = json!("proactive");
        one["keyframe"]["range_start"] = json!("2026-01-15T10:30:05.000Z");
        one["keyframe"]["range_end"] = json!("2026-01-15T10:30:12.000Z");
        one["signals"] = json!(["ego.forward_speed"]);
        one["target_id"] = Value::Null;
        one["second_keyframe"] = Value::Null;
    }
    let made = admin.post(&format!("/projects/{project}/tasks:create"), &json!({ "episodes": [one] })).fine();
    world.wait(60);
    let mut work = Work::take(&ann, made["tasks"][0].as_str().unwrap());
    assert_eq!(work.set(&[("/critical_components", components())]).status, 200);
    all_answers(&project, &work, &ann)
}

#[test]
fn leaves_of_an_l2_answer_alike_where_only_the_l2_is_shown() {
    let settings = json!({ "stage1_class": "l2" });
    same(&of_leaf(SUDDEN, &settings), &of_leaf(STEADY, &settings));
    let text: String = of_leaf(SUDDEN, &settings).into_iter().map(|(_, answer)| answer).collect();
    let told = text.matches("lead_sudden_brake").count();
    // The framework contains all classes; no other response contains this one.
    let framework =
        of_leaf(STEADY, &settings).into_iter().map(|(_, a)| a.matches("lead_sudden_brake").count());
    assert_eq!(told, framework.sum::<usize>());
}

#[test]
fn leaves_answer_differently_where_they_are_shown() {
    let (a, b) = (of_leaf(SUDDEN, &json!({})), of_leaf(STEADY, &json!({})));
    let differ: Vec<&str> = a.iter().zip(&b).filter(|(a, b)| a.1 != b.1).map(|(a, _)| a.0.as_str()).collect();
    for part in ["/scene", "/thumbnail", "?sort=scenario", "/lease"] {
        assert!(part == "/lease" || differ.iter().any(|path| path.contains(part)), "{part}: {differ:?}");
    }
}

pub fn the_leaf_is_shown_when_stage_one_is_locked(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let mut one = serde_json::to_value(episode("drive1", 1, world.future)).unwrap();
    one["scenario_id"] = json!(SUDDEN);
    let made = admin.post(&format!("/projects/{project}/tasks:create"), &json!({ "episodes": [one] })).fine();
    let task = made["tasks"][0].as_str().unwrap().to_owned();
    // Drafted before the project required it: the draft for the L3 class is removed when somebody starts.
    admin.get(&format!("/tasks/{task}")).fine();
    admin.patch(&format!("/projects/{project}"), &json!({ "settings": { "stage1_class": "l2" } })).fine();
    let listed = admin.get(&format!("/projects/{project}/tasks?scenario={SUDDEN}")).fine();
    assert_eq!(listed["items"], json!([]), "not even a filter reveals it");
    let mut work = Work::take(&ann, &task);
    let view = work.view();
    assert_eq!(view["task"]["scenario_id"], "reactive_agent.following");
    assert_eq!(view["draft"]["scenario"], json!({ "l1": "reactive_agent", "l2": "following" }));
    assert_eq!(view["draft"]["critical_components"], json!([]));
    assert_eq!((&view["spec"], &view["suggestion"]["target_id"]), (&Value::Null, &Value::Null));
    assert_eq!(view["task"]["target_id"], Value::Null);
    let kind = work.set(&[("/keyframe/range_start", json!("2026-01-15T10:30:08.000Z"))]);
    assert_eq!(kind.refusal(), (422, "draft.hidden".into()));
    let moment = json!({ "timestamp": "2026-01-15T10:30:09.400Z", "frame_idx": 94, "type": "proactive" });
    assert_eq!(work.set(&[("/keyframe", moment)]).status, 200);
    work.stage1();
    work.act("lock_stage1", &json!({})).fine();
    let view = work.view();
    assert_eq!(view["task"]["scenario_id"], SUDDEN);
    assert_eq!(view["task"]["target_id"], view["suggestion"]["target_id"]);
    assert!(view["task"]["target_id"].is_string());
    assert_eq!(view["draft"]["keyframe"]["type"], "reactive", "only the moment was set");
    assert!(view["spec"].is_object());
    // The requirement of an L3 class on uncertainty could not be known before.
    assert_eq!(work.set(&[("/critical_components/0/uncertainty", json!("high"))]).status, 200);
    let words = work.set(&[("/critical_components/0/description", json!("x"))]);
    assert_eq!(words.refusal(), (422, "draft.frozen".into()));
}

/// Words that occur only in the future.
const SECRETS: [&str; 6] =
    ["secret_pedestrian", "[DRAFT]", "second_keyframe", "green", "end_timestamp", "range_end\":\"2"];

pub fn nothing_of_the_future_is_in_any_answer_of_stage_one(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let ids = world.tasks(&admin, &project, &["drive1"], 1);
    let mut work = Work::take(&ann, &ids[0]);
    // Staff see no more of a task in Stage I than its annotator.
    for who in [&ann, &admin] {
        for path in readings(&project, &work.task, &ann.id) {
            // The document contains field names, the framework its own words, an export is only for leads.
            if ["/openapi.json", "/framework"].contains(&path.as_str()) || path.contains("/export") {
                continue;
            }
            let text = who.get(&path).text();
            for secret in SECRETS {
                assert!(!text.contains(secret), "{path} has {secret}: {text}");
            }
        }
    }
    let task = work.view();
    assert_eq!(task["suggestion"]["range_end"], Value::Null);
    assert_eq!(task["suggestion"]["conditions"], json!([]));
    // Computed from the drive cut at the keyframe: 95 frames, the car 3 m beside, no condition with a later value.
    let first = &task["draft"]["critical_components"][0]["description"];
    assert_eq!(first, "a car, least gap 8 m in 95 frames, 0 conditions");
    let map = ann.get(&work.path("/map")).fine();
    let crosswalks: Vec<&Value> = map["crosswalks"].as_array().unwrap().iter().map(|c| &c["id"]).collect();
    assert_eq!(crosswalks, ["here"], "how far the map reaches ahead is not told");
    let frames = ann.get(&work.path("/scene")).fine()["cameras"][0]["frames"].as_array().unwrap().clone();
    let last = frames.last().unwrap();
    assert_eq!(last["t_s"], 0.0);
    let picture = ann.raw("GET", last["url"].as_str().unwrap(), None, &[]);
    assert_eq!((picture.status, picture.text()), (200, "picture of frame 94".to_owned()));
    let next = format!("/media/front%20left/{}", frames.len());
    assert_eq!(ann.get(&work.path(&next)).status, 404);
    // After the lock everything is visible: the rule's second keyframe, and the camera without an image.
    work.stage1();
    work.act("lock_stage1", &json!({})).fine();
    let second = serde_json::to_value(episode("drive1", 1, world.future)).unwrap()["second_keyframe"].clone();
    assert_eq!(work.view()["suggestion"]["second_keyframe"], second);
    let cameras = ann.get(&work.path("/scene")).fine()["cameras"].clone();
    let names: Vec<&Value> = cameras.as_array().unwrap().iter().map(|c| &c["camera"]).collect();
    if world.future == Future::Brakes {
        assert_eq!(names, ["roof", "front left"], "in the order of the drive's list");
        assert_eq!(cameras[0]["frames"], json!([]));
    }
}

pub fn who_has_seen_the_future_of_a_drive_gets_no_stage_one_of_it(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let both = world.person(&admin, &project, "both", &["annotator", "checker"]);
    // Two episodes of one drive with the same keyframe, and one of another drive.
    let ids = world.tasks(&admin, &project, &["drive1"], 1);
    let other = json!({ "episodes": [episode("drive1", 2, Future::Brakes)] });
    let made = admin.post(&format!("/projects/{project}/tasks:create"), &other).fine();
    let second = made["tasks"][0].as_str().unwrap().to_owned();
    let work = Work::label(&ann, &ids[0]);
    let take =
        |who: &Person, task: &str| who.post(&format!("/tasks/{task}/lease"), &json!({ "action": "take" }));
    assert_eq!(take(&ann, &second).refusal(), (403, "task.future_seen".into()));
    assert!(Work::next(&ann, &project, "label").is_none(), "the queue does not give it either");

    // While she is in Stage I of the second one, checking the first would show its future.
    let mine = Work::take(&both, &second);
    assert_eq!(take(&both, &work.task).refusal(), (409, "task.stage1_first".into()));
    assert_eq!(both.get(&work.path("/scene")).refusal(), (409, "task.stage1_first".into()));
    assert_eq!(both.get(&work.path("")).refusal(), (409, "task.stage1_first".into()));
    both.post(&mine.path("/lease"), &json!({ "action": "release", "fence": mine.fence })).fine();
    both.get(&work.path("/scene")).fine();
    assert_eq!(take(&both, &second).refusal(), (403, "task.future_seen".into()));

    // If the project allows it, only the same episode excludes.
    let path = format!("/projects/{project}");
    admin.patch(&path, &json!({ "settings": { "history": "episode" } })).fine();
    take(&ann, &second).fine();
}

pub fn a_second_person_begins_stage_one_with_the_suggestion(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let bob = world.person(&admin, &project, "bob", &["annotator"]);
    let ids = world.tasks(&admin, &project, &["drive1"], 1);
    let mut work = Work::take(&ann, &ids[0]);
    let suggested = work.view()["draft"].clone();
    work.stage1();
    ann.post(&work.path("/comments"), &json!({ "path": "", "text": "odd" })).fine();
    ann.post(&work.path("/lease"), &json!({ "action": "release", "fence": work.fence })).fine();
    let again = Work::take(&ann, &ids[0]);
    assert_eq!(again.view()["draft"]["critical_components"], components(), "the annotator's own words stay");
    world.wait(3600);
    let theirs = Work::take(&bob, &ids[0]);
    let view = theirs.view();
    assert_eq!(view["draft"], suggested, "not somebody else's words");
    assert_eq!((&view["comments"], &view["history_count"]), (&json!([]), &json!(1)));
    let seen = bob.get(&theirs.path("/history")).fine()["items"].as_array().unwrap().len();
    assert_eq!(seen, 1, "only what bob did");
    assert_eq!(bob.get(&theirs.path("/history/3")).status, 404);
    let all =
        bob.post(&theirs.path("/actions"), &json!({ "fence": theirs.fence, "action": "restore", "seq": 3 }));
    assert_eq!(all.status, 404);
}
