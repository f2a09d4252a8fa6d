//! The safety filter: answered before any decision is saved, kept with the label, counted.

use crate::work::{Begin, Work, example};
use crate::world::World;
use serde_json::{Value, json};

pub fn decisions_wait_for_the_safety_filter(world: &World) {
    let Begin { admin, project, ann, task } = Begin::on(world);
    let settings = json!({ "settings": { "audit_min_percent": 0, "audit_max_percent": 0 } });
    admin.patch(&format!("/projects/{project}"), &settings).fine();
    let chen = world.person(&admin, &project, "chen", &["checker"]);
    let mut work = Work::take(&ann, &task);
    let answer = |work: &Work<'_>, body: Value| ann.post(&work.path("/safety"), &body);
    let safe = |fence: i64| json!({ "fence": fence, "answer": "safe" });
    assert_eq!(answer(&work, safe(work.fence)).refusal(), (409, "task.wrong_state".into()), "Stage I");
    work.stage1();
    work.act("lock_stage1", &json!({})).fine();
    for field in ["driving_decision", "causes", "coc_trace"] {
        let refused = work.set(&[(&format!("/{field}"), example()[field].clone())]);
        assert_eq!(refused.refusal(), (422, "safety.unanswered".into()), "{field}");
    }
    assert_eq!(work.act("submit", &json!({})).refusal(), (422, "safety.unanswered".into()));
    let own = work.set(&[("/safety_filter", json!({ "answer": "safe" }))]);
    assert_eq!(own.refusal(), (422, "draft.safety".into()), "only by its own call");
    assert_eq!(answer(&work, safe(work.fence + 1)).status, 409, "only who holds it");
    assert!(work.view()["permissions"].as_array().unwrap().contains(&json!("safety")));
    work.stage2();
    work.act("submit", &json!({})).fine();
    let late = chen.post(&work.path("/safety"), &safe(work.fence));
    assert_ne!(late.status, 200, "who checks does not answer");
    Work::take(&chen, &task).act("accept", &json!({})).fine();
    let export = |version: &str| {
        let text = admin.get(&format!("/projects/{project}/export?version={version}")).text();
        serde_json::from_str::<Value>(text.trim()).unwrap()
    };
    assert_eq!(export("2.1")["safety_filter"], json!({ "answer": "safe" }));
    assert_eq!(export("2.0")["safety_filter"], Value::Null);
    let board = admin.get(&format!("/projects/{project}/dashboard")).fine();
    assert_eq!(board["safety"], json!({ "safe": 1, "unsafe": 0, "reasons": {} }));
    // An imported label has no answer: it is a proposal like any other.
    let other = world.project(&admin, "village", &json!({}));
    let line = export("2.1").to_string();
    let path = format!("/projects/{other}/import");
    let media = [("content-type", "application/x-ndjson")];
    let taken = admin.call("POST", &path, Some(line.as_bytes()), &media);
    if taken.fine()["tasks"] == 1 {
        let list = admin.get(&format!("/projects/{other}/tasks")).fine();
        let id = list["items"][0]["id"].as_str().unwrap().to_owned();
        assert!(!admin.get(&format!("/tasks/{id}")).text().contains("safety_filter"));
    }
}

pub fn unsafe_driving_is_rejected_with_its_reasons(world: &World) {
    let Begin { admin, project, ann, task } = Begin::on(world);
    let mut work = Work::take(&ann, &task);
    work.stage1();
    work.act("lock_stage1", &json!({})).fine();
    let answer = |more: Value| {
        let mut body = json!({ "fence": work.fence, "answer": "unsafe" });
        for (key, value) in more.as_object().unwrap() {
            body[key] = value.clone();
        }
        ann.post(&work.path("/safety"), &body)
    };
    assert_eq!(answer(json!({})).refusal(), (422, "safety.reason".into()));
    assert_eq!(answer(json!({ "reasons": ["other"] })).refusal(), (422, "safety.reason".into()));
    assert_eq!(answer(json!({ "reasons": ["bad mood"] })).status, 400);
    let reasons = json!({ "reasons": ["unsafe_gap", "speeding", "speeding"], "note": "80 in a 50 zone" });
    let done = answer(reasons).fine();
    assert_eq!(done["task"]["state"], "rejected");
    let board = || admin.get(&format!("/projects/{project}/dashboard")).fine()["safety"].clone();
    assert_eq!(board(), json!({ "safe": 0, "unsafe": 1, "reasons": { "speeding": 1, "unsafe_gap": 1 } }));
    let text = admin.get(&format!("/projects/{project}/export?format=tasks")).text();
    let line: Value = serde_json::from_str(text.trim()).unwrap();
    let filter =
        json!({ "answer": "unsafe", "reasons": ["speeding", "unsafe_gap"], "note": "80 in a 50 zone" });
    assert_eq!(line["task"]["draft"]["safety_filter"], filter);
    let history = line["task"]["history"].as_array().unwrap();
    let last: Vec<&str> = history.iter().rev().take(2).map(|e| e["action"].as_str().unwrap()).collect();
    assert_eq!(last, ["reject", "safety"]);
    assert!(history.last().unwrap()["note"].as_str().unwrap().contains("speeding"));
    // After reopening, the question is asked again.
    let reopen = json!({ "action": "reopen", "reason": "the limit was 80" });
    admin.post(&work.path("/actions"), &reopen).fine();
    assert_eq!(board(), json!({ "safe": 0, "unsafe": 0, "reasons": {} }));
}
