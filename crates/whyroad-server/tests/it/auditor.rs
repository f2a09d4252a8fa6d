//! What an auditor may do, route by route, with requests that are valid: reads the project, answers comments, audits;
//! changes nothing else.

use crate::work::{Work, example};
use crate::world::{PASSWORD, World};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use whyroad_server::store::Tx;

/// Rows that only the work and the administration of a project change.
const WATCHED: [&str; 9] = [
    "SELECT id, draft, state, version, seq, priority, assigned, holder, adjudication FROM tasks ORDER BY id",
    "SELECT project_id, user_id, roles, skills FROM members ORDER BY project_id, user_id",
    "SELECT id, name, guide, quota, settings FROM projects ORDER BY id",
    "SELECT id, name, display, admin, disabled FROM users ORDER BY id",
    "SELECT id, url FROM webhooks ORDER BY id",
    "SELECT task_id FROM gold ORDER BY task_id",
    "SELECT id FROM model_runs ORDER BY id",
    "SELECT project_id, verdict FROM verdicts ORDER BY project_id, verdict",
    "SELECT task_id, judge FROM judgements ORDER BY task_id, judge",
];

fn watched(world: &World) -> String {
    let read = |tx: &mut dyn Tx| {
        WATCHED.iter().map(|sql| Ok(format!("{:?}", tx.rows(sql, &[])?))).collect::<Result<Vec<_>, _>>()
    };
    world.app.store.read(read).unwrap().join("\n")
}

/// Routes for anyone, which do not ask for a role: `session`, `setup`, `oidc`, `healthz`, `openapi.json`.
const FOR_ANYONE: usize = 8;

/// Route, a valid body (null for none), and the expected status.
fn table(task: &str) -> Vec<(&'static str, &'static str, Value, u16)> {
    let none = Value::Null;
    let mut all: Vec<(&str, &str, Value, u16)> = Vec::new();
    for path in [
        "/framework",
        "/identities",
        "/projects",
        "/projects/{p}",
        "/projects/{p}/dashboard",
        "/projects/{p}/judge",
        "/projects/{p}/members",
        "/projects/{p}/queue",
        "/projects/{p}/tasks",
        "/projects/{p}/work",
        "/tasks/{t}",
        "/tasks/{t}/history",
        "/tasks/{t}/history/{seq}",
        "/tasks/{t}/map",
        "/tasks/{t}/media/{camera}/{index}",
        "/tasks/{t}/scene",
        "/tasks/{t}/thumbnail",
        "/tokens",
        "/users",
    ] {
        all.push(("get", path, none.clone(), 200));
    }
    for path in [
        "/mined",
        "/projects/{p}/analytics",
        "/projects/{p}/export",
        "/projects/{p}/gold",
        "/projects/{p}/mined/{m}/episode",
        "/projects/{p}/mined/{m}/episodes",
        "/projects/{p}/mined/{m}/media/{camera}/{index}",
        "/projects/{p}/mined/{m}/similar",
        "/projects/{p}/model-runs",
        "/projects/{p}/verdicts",
        "/projects/{p}/webhooks",
        "/tasks/{t}/overlap",
        "/webhooks/paused",
    ] {
        all.push(("get", path, none.clone(), 403));
    }
    let (name, everybody) = (json!({ "name": "x" }), json!({ "user": "aud", "roles": ["lead"] }));
    let episode =
        json!({ "drive": "drive1", "scenario": "reactive_agent.cutin.urgent", "episode": "drive1_e1" });
    let verdict = json!({ "mined": "week1", "drive": "drive1", "scenario": "reactive_agent.cutin.urgent",
        "episode": "drive1_e1", "verdict": "right" });
    all.extend([
        ("post", "/projects", name.clone(), 403),
        ("patch", "/projects/{p}", name, 403),
        ("post", "/projects/{p}/gold", json!({ "tasks": [task], "users": ["ann"] }), 403),
        ("post", "/projects/{p}/import", example(), 403),
        ("post", "/projects/{p}/members", everybody, 403),
        ("post", "/projects/{p}/model-runs", json!({ "kind": "draft", "tasks": [task] }), 403),
        ("post", "/projects/{p}/model-runs:stop", json!({ "run": "none" }), 403),
        ("post", "/projects/{p}/tasks:change", json!({ "tasks": [task], "priority": 9 }), 403),
        ("post", "/projects/{p}/tasks:create", json!({ "mined": "week1" }), 403),
        ("post", "/projects/{p}/verdicts", verdict, 403),
        ("post", "/projects/{p}/webhooks", json!({ "url": "http://127.0.0.1:9/y" }), 403),
        ("delete", "/webhooks/{w}", none.clone(), 403),
        ("post", "/users", json!({ "name": "eve", "password": PASSWORD }), 403),
        ("patch", "/users/{u}", json!({ "display": "Somebody" }), 403),
        ("post", "/tasks/{t}/assign", json!({ "user": "ann" }), 403),
        ("post", "/tasks/{t}/reclass", json!({ "scenario": "reactive_agent.cutin.slow" }), 403),
        ("post", "/projects/{p}/mined/{m}/tasks", episode, 403),
        // The queue has nothing for them, whatever they ask for.
        ("post", "/projects/{p}/tasks:next", json!({ "kind": "audit" }), 204),
        ("post", "/projects/{p}/tasks:next", json!({ "kind": "check" }), 204),
        ("post", "/projects/{p}/tasks:next", json!({ "kind": "label" }), 204),
        ("post", "/tasks/{t}/lease", json!({ "action": "take" }), 403),
        ("post", "/tasks/{t}/lease", json!({ "action": "release", "fence": 1 }), 409),
        ("post", "/tasks/{t}/safety", json!({ "fence": 1, "answer": "safe" }), 409),
        ("post", "/tasks/{t}/judgement", json!({ "fence": 1, "answers": { "q": true } }), 409),
        (
            "patch",
            "/tasks/{t}/draft",
            json!({ "fence": 1, "base_version": 1, "changes": [{ "path": "/coc_trace", "value": "x" }] }),
            409,
        ),
        // What is their own, or talk.
        ("post", "/tasks/{t}/validate", json!({ "label": example() }), 200),
        ("post", "/tasks/{t}/comments", json!({ "path": "/coc_trace", "text": "which car?" }), 200),
        ("post", "/comments/{c}/resolve", none.clone(), 200),
        ("post", "/tokens", json!({ "name": "mine", "scope": "read" }), 200),
        ("delete", "/tokens/{id}", none.clone(), 404),
        ("delete", "/identities/{id}", none, 404),
    ]);
    for (action, status) in [
        ("lock_stage1", 409),
        ("submit", 409),
        ("skip", 409),
        ("reject", 409),
        ("accept", 409),
        ("send_back", 409),
        ("reopen", 403),
        ("adjudicate", 403),
        ("restore", 409),
    ] {
        let body = json!({ "action": action, "fence": 1, "reason": "no", "seq": 1 });
        all.push(("post", "/tasks/{t}/actions", body, status));
    }
    all
}

pub fn an_auditor_reads_the_project_and_changes_nothing(world: &World) {
    let admin = world.admin();
    let project =
        world.project(&admin, "town", &json!({ "audit_min_percent": 100, "audit_max_percent": 100 }));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let chen = world.person(&admin, &project, "chen", &["checker"]);
    let aud = world.person(&admin, &project, "aud", &["auditor"]);
    let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    let work = Work::label(&ann, &task);
    let remark = json!({ "path": "/coc_trace", "text": "see" });
    let comment = ann.post(&work.path("/comments"), &remark).fine()["id"].as_str().unwrap().to_owned();
    let hook = json!({ "url": "http://127.0.0.1:9/x" });
    let hook =
        admin.post(&format!("/projects/{project}/webhooks"), &hook).fine()["id"].as_str().unwrap().to_owned();
    let before = watched(world);
    let mut asked: BTreeSet<(String, String)> = BTreeSet::new();
    for (verb, path, body, status) in table(&task) {
        let full = path
            .replace("{p}", &project)
            .replace("{t}", &task)
            .replace("{c}", &comment)
            .replace("{w}", &hook)
            .replace("{u}", &ann.id)
            .replace("{id}", "none")
            .replace("{m}", "week1")
            .replace("{seq}", "1")
            .replace("{camera}", "front%20left")
            .replace("{index}", "0");
        let text = body.to_string();
        let answer = aud.call(&verb.to_uppercase(), &full, (!body.is_null()).then_some(text.as_bytes()), &[]);
        assert_eq!(answer.status, status, "{verb} {path} {body}: {}", answer.text());
        asked.insert((verb.to_owned(), path.to_owned()));
        assert_eq!(watched(world), before, "{verb} {path} {body}");
    }
    // Every route is in the table.
    let document = admin.get("/openapi.json").fine();
    let mut open = 0;
    for (path, operations) in document["paths"].as_object().unwrap() {
        for (verb, operation) in operations.as_object().unwrap() {
            if operation["x-access"] == "anyone" {
                open += 1;
            } else {
                assert!(asked.remove(&(verb.clone(), path.clone())), "{verb} {path} is not in the table");
            }
        }
    }
    assert_eq!((open, asked.len()), (FOR_ANYONE, 0), "{asked:?}");
    // Their own work: what was checked by somebody else.
    Work::take(&chen, &task).act("accept", &json!({})).fine();
    let mut audit = Work::next(&aud, &project, "audit").unwrap();
    assert_eq!(
        audit.set(&[("/coc_trace", json!("x"))]).status,
        403,
        "an auditor returns a label, and edits none"
    );
    assert_eq!(audit.act("accept", &json!({})).fine()["task"]["state"], "accepted");
}
