//! The whole path: setup, project, tasks, Stage I and II, check, rework, accept, export.

use crate::work::{Begin, Work};
use crate::world::World;
use serde_json::{Value, json};

pub fn the_whole_path_from_setup_to_export(world: &World) {
    let admin = world.admin();
    // Audits are covered by another test.
    let project = world.project(&admin, "town", &json!({ "audit_min_percent": 0, "audit_max_percent": 0 }));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let chen = world.person(&admin, &project, "chen", &["checker"]);
    let ids = world.tasks(&admin, &project, &["drive1"], 1);
    assert_eq!(ids.len(), 1);

    let mut work = Work::next(&ann, &project, "label").unwrap();
    assert_eq!(work.task, ids[0]);
    let view = work.view();
    assert_eq!((&view["stage"], &view["task"]["state"]), (&json!("stage1"), &json!("stage1")));
    assert!(view["draft"].get("coc_trace").is_none());
    let scene = ann.get(&work.path("/scene")).fine();
    assert_eq!(scene["hidden_until"], "stage2");
    assert_eq!(scene["times"].as_array().unwrap().last().unwrap(), "2026-01-15T10:30:09.400Z");
    assert_eq!(scene["clip_frames"].as_array().unwrap().last().unwrap(), 94);
    // A mean over the drive as far as it is shown: the ego has 10 m/s up to the keyframe, then brakes.
    let means = |scene: &Value| {
        let mut all = scene["signals"]["ego.mean_speed"].as_array().unwrap().clone();
        all.dedup();
        all
    };
    assert_eq!(means(&scene), [json!(10.0)]);

    assert_eq!(work.act("submit", &json!({})).refusal(), (409, "task.wrong_state".into()));
    work.stage1();
    let view = work.act("lock_stage1", &json!({})).fine();
    assert_eq!((&view["stage"], &view["task"]["state"]), (&json!("stage2"), &json!("stage2")));
    assert!(view["draft"]["coc_trace"].as_str().unwrap().starts_with("[DRAFT]"));
    let scene = ann.get(&work.path("/scene")).fine();
    assert!(scene["hidden_until"].is_null());
    // Six seconds after the end of the range, or the duration in the spec: here 3 s after 10:30:13, and at least 6 s.
    let last = scene["times"].as_array().unwrap().last().unwrap().as_str().unwrap();
    assert!(last >= "2026-01-15T10:30:15.400Z", "{last}");
    // One curve, that which the rule measured: it has no jump at the keyframe.
    let means = means(&scene);
    assert!(means.len() == 1 && means[0].as_f64().unwrap() < 10.0, "{means:?}");

    work.safe();
    let refused = work.act("submit", &json!({}));
    assert_eq!(refused.refusal(), (422, "label.findings".into()));
    let codes: Vec<Value> =
        refused.json()["more"]["findings"].as_array().unwrap().iter().map(|f| f["code"].clone()).collect();
    assert!(codes.contains(&json!("label.trace.draft")), "{codes:?}");
    assert_eq!(work.set(&[("/critical_components", json!([]))]).refusal(), (422, "draft.frozen".into()));
    work.stage2();
    let view = work.act("submit", &json!({})).fine();
    assert_eq!(view["task"]["state"], "submitted");
    assert_eq!(view["findings"], json!([]), "no error and no warning");

    assert!(Work::next(&chen, &project, "label").is_none(), "a checker does not label");
    let mut check = Work::next(&chen, &project, "check").unwrap();
    assert_eq!(check.act("send_back", &json!({})).refusal(), (422, "action.reason".into()));
    let back =
        check.act("send_back", &json!({ "comments": [{ "path": "/coc_trace", "text": "说明间距" }] })).fine();
    assert_eq!(back["task"]["state"], "rework");

    let mut again = Work::next(&ann, &project, "label").unwrap();
    let view = again.view();
    assert_eq!(view["task"]["state"], "rework");
    let comment = &view["comments"][0];
    assert_eq!((&comment["path"], &comment["text"]), (&json!("/coc_trace"), &json!("说明间距")));
    ann.post(&format!("/comments/{}/resolve", comment["id"].as_str().unwrap()), &json!({})).fine();
    let better = format!("{}两车间距不足十米。", view["draft"]["coc_trace"].as_str().unwrap());
    assert_eq!(again.set(&[("/coc_trace", json!(better))]).status, 200);
    again.act("submit", &json!({})).fine();
    let mut check = Work::next(&chen, &project, "check").unwrap();
    let view = check.act("accept", &json!({})).fine();
    assert_eq!(view["task"]["state"], "accepted");

    let export = admin.get(&format!("/projects/{project}/export?format=labels"));
    assert_eq!(export.header("content-type"), Some("application/x-ndjson"));
    // The name says what it is; RFC 6266 with RFC 8187 for a name that is not ASCII.
    let file = |query: &str| {
        let answer = admin.get(&format!("/projects/{project}/export?{query}"));
        answer.header("content-disposition").unwrap().to_owned()
    };
    assert!(file("format=labels").contains("-labels-accepted-2.1.jsonl"), "{}", file("format=labels"));
    assert!(file("version=2.0&state=submitted,accepted").contains("-labels-submitted+accepted-2.0.jsonl"));
    assert!(file("format=tasks").contains("-tasks.jsonl"));
    let label: Value = serde_json::from_slice(&export.body).unwrap();
    assert_eq!(label["coc_trace"], better);
    assert_eq!(label["provenance"]["source"], "person");
    assert_eq!(label["provenance"]["by"], "ann");
    let checker = whyroad_label::check::Checker::new(whyroad_framework::Framework::bundled());
    assert!(checker.is_clean_label(&label.to_string()), "{:?}", checker.check_text(&label.to_string()));

    let history = admin.get(&format!("/tasks/{}/history", ids[0])).fine();
    let actions: Vec<&str> =
        history["items"].as_array().unwrap().iter().map(|e| e["action"].as_str().unwrap()).collect();
    let expected = [
        "create",
        "take",
        "edit",
        "lock_stage1",
        "safety",
        "edit",
        "edit",
        "submit",
        "take",
        "send_back",
        "take",
        "edit",
        "submit",
        "take",
        "accept",
    ];
    assert_eq!(actions, expected);
    // Every version can be restored: the draft after the first submission is the one before the rework.
    let first = admin.get(&format!("/tasks/{}/history/8", ids[0])).fine();
    assert_ne!(first["draft"]["coc_trace"], json!(better));
    assert_eq!(first["draft"]["provenance"]["by"], "ann");
}

pub fn a_label_made_here_names_a_cause_of_each_decision(world: &World) {
    let Begin { ann, task, .. } = Begin::on(world);
    let mut work = Work::take(&ann, &task);
    work.stage1();
    work.act("lock_stage1", &json!({})).fine();
    work.stage2();
    let made = work.view()["draft"]["causes"].clone();
    // Removed, null and empty: as in a label of format 2.0, or when a user clears the field.
    let body = json!({ "fence": work.fence, "base_version": work.version,
        "changes": [{ "path": "/causes", "remove": true }] });
    work.version = ann.patch(&work.path("/draft"), &body).fine()["version"].as_i64().unwrap();
    for causes in [None, Some(Value::Null), Some(json!({}))] {
        if let Some(causes) = causes {
            assert_eq!(work.set(&[("/causes", causes)]).status, 200);
        }
        let refused = work.act("submit", &json!({}));
        assert_eq!(refused.refusal(), (422, "label.findings".into()));
        let found = refused.json()["more"]["findings"].clone();
        let missing = |f: &&Value| f["code"] == "label.cause.missing" && f["severity"] == "error";
        assert!(found.as_array().unwrap().iter().any(|f| missing(&f)), "{found}");
    }
    assert_eq!(work.set(&[("/causes", made)]).status, 200);
    work.act("submit", &json!({})).fine();
}
