//! Access to each route: the OpenAPI document is read, every route is called by every kind of caller, and responses are
//! compared with a hand-written table.

use crate::work::Work;
use crate::world::{Person, World};
use serde_json::{Value, json};

/// Kinds of callers, in the order of the table.
const KINDS: [&str; 9] =
    ["nobody", "outsider", "other_lead", "annotator", "holder", "checker", "auditor", "lead", "admin"];

/// For each value of `x-access` the permitted callers: one letter per kind, in the order above. `y` passes, `-` does
/// not (401 without a session, else 403 or 404).
fn table(access: &str) -> &'static str {
    match access {
        "anyone" => "yyyyyyyyy",
        "signed_in" => "-yyyyyyyy",
        "admin" => "--------y",
        "member" => "---yyyyyy",
        "staff" => "-----yyyy",
        "lead" => "-------yy",
        "task_reader" | "task_worker" | "comment_reader" => "----yyyyy",
        "task_lead" => "-------yy",
        "webhook_lead" => "-------yy",
        other => panic!("x-access '{other}' is not in the table of this test"),
    }
}

pub fn every_route_lets_in_only_whom_it_should(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let elsewhere = world.project(&admin, "elsewhere", &json!({}));
    let person = |name: &str, roles: &[&str]| world.person(&admin, &project, name, roles);
    let other_lead = world.person(&admin, &elsewhere, "oz", &["lead", "annotator", "checker", "auditor"]);
    let callers: Vec<(&str, Person)> = vec![
        ("nobody", {
            let mut p = world.unauthenticated();
            p.hello();
            p
        }),
        ("outsider", person("olga", &[])),
        ("other_lead", other_lead),
        ("annotator", person("ann", &["annotator"])),
        ("holder", person("hans", &["annotator"])),
        ("checker", person("chen", &["checker"])),
        ("auditor", person("aud", &["auditor"])),
        ("lead", person("lea", &["lead"])),
        // Not a member of any project: only the rights of an admin.
        ("admin", {
            let mut second = json!({ "name": "root2", "password": crate::world::PASSWORD, "admin": true });
            second["lang"] = json!("en");
            admin.post("/users", &second).fine();
            world.sign_in("root2")
        }),
    ];
    assert_eq!(callers.iter().map(|(k, _)| *k).collect::<Vec<_>>(), KINDS);
    let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    let holder = &callers[4].1;
    let mut work = Work::take(holder, &task);
    work.stage1();
    let remark = json!({ "path": "", "text": "see" });
    let comment = holder.post(&work.path("/comments"), &remark).fine()["id"].as_str().unwrap().to_owned();
    let hook = json!({ "url": "http://127.0.0.1:9/x" });
    let hook =
        admin.post(&format!("/projects/{project}/webhooks"), &hook).fine()["id"].as_str().unwrap().to_owned();

    let document = admin.get("/openapi.json").fine();
    let mut asked = 0;
    for (path, operations) in document["paths"].as_object().unwrap() {
        for (verb, operation) in operations.as_object().unwrap() {
            let access = operation["x-access"].as_str().unwrap();
            let expected = table(access);
            for ((kind, caller), passes) in callers.iter().zip(expected.chars()) {
                // Signing out would end the session under test.
                if path == "/session" && verb == "delete" {
                    continue;
                }
                let full = path
                    .replace("{p}", &project)
                    .replace("{t}", &task)
                    .replace("{c}", &comment)
                    .replace("{w}", &hook)
                    .replace("{u}", "none")
                    .replace("{id}", "none")
                    .replace("{m}", "week1")
                    .replace("{seq}", "1")
                    .replace("{camera}", "front%20left")
                    .replace("{index}", "0");
                // A body that no handler accepts: a call that passes the access check changes nothing.
                let body = (verb != "get").then_some(&b"{\"no such field\": 1"[..]);
                // These take no body, so they are called last, with effect.
                if path.contains("{w}") || path.ends_with("/resolve") {
                    continue;
                }
                let answer = caller.call(&verb.to_uppercase(), &full, body, &[]);
                asked += 1;
                check(kind, verb, path, access, passes, answer.status);
                if passes == '-' {
                    let text = answer.text();
                    for secret in ["drive1", "town", "hans", "critical"] {
                        assert!(!text.contains(secret), "{kind} {verb} {path}: {text}");
                    }
                }
            }
        }
    }
    assert!(asked > 350, "{asked}");
    for (path, kinds) in [
        (format!("/comments/{comment}/resolve"), "comment_reader"),
        (format!("/webhooks/{hook}"), "webhook_lead"),
    ] {
        let verb = if kinds == "webhook_lead" { "DELETE" } else { "POST" };
        for ((kind, caller), passes) in callers.iter().zip(table(kinds).chars()) {
            // Only the first caller that passes finds a webhook; the comment of another user is hidden in Stage I.
            if passes == '-' {
                check(kind, verb, &path, kinds, '-', caller.call(verb, &path, None, &[]).status);
            }
        }
    }
    assert_eq!(holder.post(&format!("/comments/{comment}/resolve"), &json!({})).status, 200);
    assert_eq!(callers[7].1.call("DELETE", &format!("/webhooks/{hook}"), None, &[]).status, 200);
}

fn check(kind: &str, verb: &str, path: &str, access: &str, passes: char, status: u16) {
    let refused = match kind {
        "nobody" => vec![401],
        _ => vec![403, 404],
    };
    if passes == '-' {
        assert!(refused.contains(&status), "{kind} {verb} {path} ({access}): {status}");
        return;
    }
    // A handler may be stricter than the access check, but must not fail.
    assert!(status < 500, "{kind} {verb} {path} ({access}): {status}");
    let stricter = [
        "/mined",
        "/users/{u}",
        "/tokens/{id}",
        "/tasks/{t}/overlap",
        "/session",
        "/identities/{id}",
        "/setup",
        "/tasks/{t}/media/{camera}/{index}",
        "/tasks/{t}/history/{seq}",
    ];
    if !stricter.contains(&path) {
        assert!(![401, 403, 404].contains(&status), "{kind} {verb} {path} ({access}): {status}");
    }
}

pub fn the_roles_of_a_project_bound_its_work(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let lead = world.person(&admin, &project, "lea", &["lead"]);
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let aud = world.person(&admin, &project, "aud", &["auditor"]);
    let task = world.tasks(&lead, &project, &["drive1"], 1)[0].clone();
    let take = |who: &Person| who.post(&format!("/tasks/{task}/lease"), &json!({ "action": "take" }));
    assert_eq!(take(&lead).refusal(), (403, "task.role_missing".into()), "a lead is no annotator");
    assert_eq!(take(&aud).refusal(), (403, "task.role_missing".into()));
    let work = Work::label(&ann, &task);
    assert_eq!(take(&ann).refusal(), (403, "task.role_missing".into()), "an annotator is no checker");
    let roles = json!({ "user": "ann", "roles": ["annotator", "checker", "auditor", "lead"] });
    admin.post(&format!("/projects/{project}/members"), &roles).fine();
    assert_eq!(
        take(&ann).refusal(),
        (403, "task.own_work".into()),
        "you cannot check your own work, whatever your roles"
    );
    let accept = json!({ "action": "accept", "fence": work.fence });
    assert_ne!(ann.post(&work.path("/actions"), &accept).status, 200);
    // A user removed from the project has no access to its tasks.
    lead.post(&format!("/projects/{project}/members"), &json!({ "user": "ann", "roles": [] })).fine();
    assert_eq!(ann.get(&work.path("")).refusal(), (404, "not_found".into()));
    assert_eq!(ann.get(&format!("/projects/{project}")).refusal().0, 404);
    let projects = ann.get("/projects").fine();
    assert_eq!(projects["items"], Value::Array(vec![]));
}
