//! Data of the page besides the label itself: lists with totals and orders, changes of many tasks, pending work,
//! thumbnails, questions to the lead, values before a change, merged labels, drafts created in the background.

use crate::recorded::episode;
use crate::work::{Begin, Work};
use crate::world::{Person, World};
use serde_json::{Value, json};
use whyroad_server::service::retention::sweep;

fn list(who: &Person, project: &str, query: &str) -> Value {
    who.get(&format!("/projects/{project}/tasks?{query}")).fine()
}

fn ids(page: &Value) -> Vec<String> {
    page["items"].as_array().unwrap().iter().map(|t| t["id"].as_str().unwrap().to_owned()).collect()
}

pub fn lists_have_a_total_and_an_order_that_pages_keep(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let made = world.tasks(&admin, &project, &["drive3", "drive1", "drive5", "drive2", "drive4"], 1);
    assert_eq!(made.len(), 5);
    for (sort, descending) in
        [("clip", false), ("-clip", true), ("updated", false), ("-updated", true), ("state", false)]
    {
        let (mut all, mut clips, mut cursor) = (Vec::new(), Vec::new(), String::new());
        loop {
            let page = list(&admin, &project, &format!("sort={sort}&limit=2{cursor}"));
            assert_eq!(page["total"], if cursor.is_empty() { json!(5) } else { Value::Null }, "{sort}");
            all.extend(ids(&page));
            clips.extend(
                page["items"].as_array().unwrap().iter().map(|t| t["clip_id"].as_str().unwrap().to_owned()),
            );
            let Some(next) = page["next"].as_str() else { break };
            cursor = format!("&cursor={next}");
        }
        let mut each = all.clone();
        each.sort();
        each.dedup();
        assert_eq!(each.len(), 5, "{sort}: each once");
        if sort.ends_with("clip") {
            let mut sorted = clips.clone();
            sorted.sort();
            if descending {
                sorted.reverse();
            }
            assert_eq!(clips, sorted);
        }
    }
    let wrong = admin.get(&format!("/projects/{project}/tasks?sort=nonsense"));
    assert_eq!(wrong.status, 400);
    let wrong = admin.get(&format!("/projects/{project}/tasks?sort=updated&cursor=x"));
    assert_eq!(wrong.status, 400);
    assert_eq!(list(&admin, &project, "state=accepted")["total"], 0);
}

pub fn many_tasks_are_changed_at_once_and_each_refusal_is_named(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let chen = world.person(&admin, &project, "chen", &["checker"]);
    let other = world.project(&admin, "village", &json!({}));
    let made = world.tasks(&admin, &project, &["drive1", "drive2"], 1);
    let foreign = world.tasks(&admin, &other, &["drive3"], 1);
    let change = |who: &Person, body: Value| who.post(&format!("/projects/{project}/tasks:change"), &body);
    let all = [made[0].clone(), made[1].clone(), foreign[0].clone()];
    let done = change(&admin, json!({ "tasks": all, "assign": { "user": "ann" }, "priority": 7 })).fine();
    assert_eq!(done["changed"], 2);
    assert_eq!(done["refused"][0]["task"], foreign[0].as_str(), "a task of another project is not found");
    for task in list(&admin, &project, "")["items"].as_array().unwrap() {
        assert_eq!((&task["assigned_to"], &task["priority"]), (&json!("ann"), &json!(7)));
    }
    let done = change(&admin, json!({ "tasks": made, "assign": { "user": "chen" } })).fine();
    assert_eq!((&done["changed"], done["refused"].as_array().unwrap().len()), (&json!(0), 2), "no annotator");
    change(&admin, json!({ "tasks": made, "assign": { "user": null } })).fine();
    assert_eq!(list(&admin, &project, "")["items"][0]["assigned_to"], Value::Null);
    assert_eq!(change(&ann, json!({ "tasks": made, "priority": 1 })).status, 403);
    assert_eq!(change(&chen, json!({ "tasks": made, "priority": 1 })).status, 403);
    assert_eq!(change(&admin, json!({ "tasks": [], "priority": 1 })).status, 400);
}

pub fn the_work_to_do_is_counted_for_staff_and_for_oneself(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({ "audit_min_percent": 0, "audit_max_percent": 0 }));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let chen = world.person(&admin, &project, "chen", &["checker"]);
    let made = world.tasks(&admin, &project, &["drive1", "drive2", "drive3"], 1);
    let work = |who: &Person| who.get(&format!("/projects/{project}/work")).fine();
    Work::label(&ann, &made[0]);
    Work::label(&ann, &made[1]);
    let mut check = Work::take(&chen, &made[0]);
    check.act("send_back", &json!({ "reason": "the gap is missing" })).fine();
    let mine = work(&ann);
    assert_eq!(mine["mine"]["returned"], 1);
    assert_eq!((&mine["mine"]["waiting"], &mine["mine"]["submitted_today"]), (&json!(1), &json!(2)));
    assert_eq!((&mine["total"], &mine["by_state"]), (&json!(0), &json!({})), "not for annotators");
    let all = work(&admin);
    assert_eq!(all["total"], 3);
    assert_eq!(all["by_state"], json!({ "open": 1, "rework": 1, "submitted": 1 }));
    assert_eq!(all["mine"]["returned"], 0);
}

pub fn a_question_to_the_lead_marks_the_task_until_it_is_answered(world: &World) {
    let Begin { admin, project, ann, task } = Begin::on(world);
    Work::take(&ann, &task);
    let ask = json!({ "path": "", "text": "Is this a cut-in?", "to_lead": true });
    let comment = ann.post(&format!("/tasks/{task}/comments"), &ask).fine();
    assert_eq!(comment["to_lead"], true);
    assert_eq!(ids(&list(&admin, &project, "asks=lead")), [task.as_str()]);
    assert_eq!(list(&admin, &project, "")["items"][0]["asks_lead"], true);
    assert_eq!(admin.get(&format!("/projects/{project}/work")).fine()["asked"], 1);
    // A comment to everybody is not a question to the lead.
    ann.post(&format!("/tasks/{task}/comments"), &json!({ "path": "", "text": "dark" })).fine();
    // A lead who does not label reads it at once, and nothing else of Stage I; another annotator reads nothing.
    let lead = world.person(&admin, &project, "lea", &["lead"]);
    let bob = world.person(&admin, &project, "bob", &["checker"]);
    let read = |who: &Person| who.get(&format!("/tasks/{task}")).fine()["comments"].clone();
    let (asked, hidden) = (read(&lead), read(&bob));
    assert_eq!((&asked[0]["text"], asked.as_array().unwrap().len()), (&json!("Is this a cut-in?"), 1));
    assert_eq!(hidden, json!([]));
    let id = comment["id"].as_str().unwrap();
    assert_eq!(bob.post(&format!("/comments/{id}/resolve"), &json!({})).status, 404);
    lead.post(&format!("/comments/{id}/resolve"), &json!({})).fine();
    assert_eq!(list(&admin, &project, "asks=lead")["total"], 0);
}

pub fn a_picture_is_for_those_who_cannot_do_stage_one_or_have_opened_the_task(world: &World) {
    let Begin { admin, project, ann, task } = Begin::on(world);
    let picture = |who: &Person| who.get(&format!("/tasks/{task}/thumbnail"));
    // An administrator leads every project, and labels in those where they are an annotator: here in all roles.
    admin
        .post(&format!("/projects/{project}/members"), &json!({ "user": "admin", "roles": ["lead"] }))
        .fine();
    // It is created with the draft, in the background.
    for _ in 0..200 {
        if admin.get(&format!("/projects/{project}/work")).fine()["pending"] == 0 {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    let shown = picture(&admin);
    assert_eq!(
        (shown.status, shown.header("content-type")),
        (200, Some("image/svg+xml")),
        "{}",
        shown.text()
    );
    assert!(shown.text().starts_with("<svg"), "{}", shown.text());
    assert_eq!(
        list(&admin, &project, "")["items"][0]["thumbnail"],
        format!("/api/v1/tasks/{task}/thumbnail")
    );
    assert_eq!(picture(&ann).status, 404, "not ann's task yet");
    let both = world.person(&admin, &project, "bo", &["annotator", "checker"]);
    assert_eq!(picture(&both).status, 404, "bo may yet do Stage I of an earlier task");
    assert!(list(&both, &project, "")["items"][0].get("thumbnail").is_none());
    Work::take(&ann, &task);
    assert_eq!(picture(&ann).status, 200);
}

pub fn the_history_has_the_values_before_each_change(world: &World) {
    let Begin { admin, ann, task, .. } = Begin::on(world);
    let mut work = Work::take(&ann, &task);
    let before = work.view()["draft"]["critical_components"].clone();
    work.stage1();
    let now = work.view()["draft"]["critical_components"].clone();
    work.act("lock_stage1", &json!({})).fine();
    work.safe();
    work.set(&[("/coc_trace", json!("first"))]).fine();
    work.set(&[("/coc_trace", json!("second"))]).fine();
    let history = admin.get(&format!("/tasks/{task}/history")).fine();
    let edits: Vec<(&Value, &Value)> = history["items"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|e| e["changes"].as_array().unwrap().iter().zip(e["before"].as_array().unwrap()))
        .collect();
    let of = |path: &str| {
        edits
            .iter()
            .filter(|(c, _)| c["path"] == path)
            .map(|(c, b)| (c["value"].clone(), (*b).clone()))
            .collect::<Vec<_>>()
    };
    assert_eq!(of("/coc_trace").last(), Some(&(json!("second"), json!("first"))));
    if before != now {
        assert_eq!(of("/critical_components").first().map(|(_, b)| b), Some(&before));
    }
}

pub fn a_label_put_together_from_a_group_is_checked_again(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({ "audit_min_percent": 0, "audit_max_percent": 0 }));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let bob = world.person(&admin, &project, "bob", &["annotator"]);
    let chen = world.person(&admin, &project, "chen", &["checker"]);
    let made = world.tasks(&admin, &project, &["drive1"], 2);
    Work::label(&ann, &made[0]);
    Work::label(&bob, &made[1]);
    let group = admin.get(&format!("/tasks/{}/overlap", made[0])).fine();
    let mut label = group["items"][0]["label"].clone();
    label["coc_trace"] = json!(format!("{} ", label["coc_trace"].as_str().unwrap()));
    label["clip_id"] = json!("another clip");
    let act = |label: &Value| {
        admin.post(&format!("/tasks/{}/actions", made[0]), &json!({ "action": "adjudicate", "label": label }))
    };
    let mut broken = label.clone();
    broken["coc_trace"] = json!("");
    assert_eq!(act(&broken).refusal(), (422, "label.findings".into()));
    assert_eq!(act(&json!([])).status, 400);
    let view = act(&label).fine();
    assert_eq!(
        (&view["task"]["adjudication"], &view["task"]["state"]),
        (&json!("chosen"), &json!("submitted"))
    );
    assert_eq!(view["draft"]["coc_trace"], label["coc_trace"]);
    assert_ne!(view["draft"]["clip_id"], "another clip", "the clip is that of the task");
    assert_eq!(view["draft"]["provenance"]["by"], "admin");
    assert_eq!(admin.get(&format!("/tasks/{}", made[1])).fine()["task"]["adjudication"], "superseded");
    // The author stays its author; the person who merged it has written in it and does not check it.
    assert_eq!(view["task"]["author"], "ann");
    admin
        .post(
            &format!("/projects/{project}/members"),
            &json!({ "user": "admin", "roles": ["lead", "checker"] }),
        )
        .fine();
    let take = json!({ "action": "take" });
    assert_eq!(
        admin.post(&format!("/tasks/{}/lease", made[0]), &take).refusal(),
        (403, "task.own_work".into())
    );
    Work::take(&chen, &made[0]).act("accept", &json!({})).fine();
}

pub fn overlap_groups_that_disagree_are_listed_until_one_label_is_chosen(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let [ann, bob, chen] = [("ann", "annotator"), ("bob", "annotator"), ("chen", "checker")]
        .map(|(name, role)| world.person(&admin, &project, name, &[role]));
    let made = world.tasks(&admin, &project, &["drive1", "drive2", "drive3"], 2);
    let listed = |who: &Person| list(who, &project, "overlap=disagreeing");
    let count = |who: &Person| who.get(&format!("/projects/{project}/work")).fine()["disagreeing"].clone();
    // The labels of the first episode agree, those of the second do not; the other label of the third is still missing.
    for task in [&made[0], &made[2], &made[4]] {
        Work::label(&ann, task);
    }
    Work::label(&bob, &made[1]);
    let mut other = Work::take(&bob, &made[3]);
    let moment = "2026-01-15T10:30:08.800Z";
    other.stage1_at(moment);
    other.set(&[("/keyframe/timestamp", json!(moment)), ("/keyframe/frame_idx", json!(88))]).fine();
    other.act("lock_stage1", &json!({})).fine();
    other.stage2();
    assert_eq!(count(&admin), 0, "a label is yet to come");
    other.act("submit", &json!({})).fine();
    let page = listed(&admin);
    let mut found = ids(&page);
    found.sort();
    let mut wanted = [made[2].as_str(), &made[3]];
    wanted.sort_unstable();
    assert_eq!(
        (found.iter().map(String::as_str).collect::<Vec<_>>(), &page["total"]),
        (wanted.to_vec(), &json!(2))
    );
    assert!(page["items"].as_array().unwrap().iter().all(|t| t["disagrees"] == true));
    assert_eq!(count(&admin), 2);
    // Hidden from users who do not choose; annotators do not learn whether somebody disagrees with them.
    for who in [&ann, &chen] {
        assert_eq!(who.get(&format!("/projects/{project}/tasks?overlap=disagreeing")).status, 403);
        assert_eq!(count(who), 0);
    }
    assert!(list(&chen, &project, "")["items"].as_array().unwrap().iter().all(|t| t["disagrees"] == false));
    assert_eq!(ann.get(&format!("/tasks/{}", made[2])).fine()["task"]["disagrees"], false);
    assert_eq!(admin.get(&format!("/tasks/{}", made[2])).fine()["task"]["disagrees"], true);
    let choose = json!({ "action": "adjudicate" });
    admin.post(&format!("/tasks/{}/actions", made[3]), &choose).fine();
    assert_eq!((&listed(&admin)["total"], count(&admin)), (&json!(0), json!(0)));
}

pub fn findings_side_by_side_are_those_of_each_label_alone(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let bob = world.person(&admin, &project, "bob", &["annotator"]);
    let made = world.tasks(&admin, &project, &["drive1"], 2);
    Work::label(&ann, &made[0]);
    Work::label(&bob, &made[1]);
    let group = admin.get(&format!("/tasks/{}/overlap", made[0])).fine();
    for item in group["items"].as_array().unwrap() {
        let id = item["task"]["id"].as_str().unwrap();
        let alone = admin.get(&format!("/tasks/{id}")).fine();
        assert_eq!(item["findings"], alone["findings"]);
        let body = json!({ "label": item["label"] });
        assert_eq!(admin.post(&format!("/tasks/{id}/validate"), &body).fine()["findings"], alone["findings"]);
        // Without an author it still counts as drafted by the program.
        let mut drafted = item["label"].clone();
        drafted["coc_trace"] = json!("[DRAFT] a car cuts in.");
        let found = admin.post(&format!("/tasks/{id}/validate"), &json!({ "label": drafted })).fine();
        let codes: Vec<&Value> = found["findings"].as_array().unwrap().iter().map(|f| &f["code"]).collect();
        assert!(codes.contains(&&json!("label.trace.draft")), "{codes:?}");
    }
}

pub fn why_a_task_cannot_be_taken_fits_the_case(world: &World) {
    let Begin { admin, project, ann, task } = Begin::on(world);
    let why = |who: &Person| {
        who.get(&format!("/tasks/{task}")).fine()["take_refused"]["en"].as_str().map(str::to_owned)
    };
    Work::label(&ann, &task);
    assert_eq!(why(&ann).unwrap(), "this is your label; it waits for its check");
    let chen = world.person(&admin, &project, "chen", &["checker"]);
    assert_eq!(why(&chen), None);
    let dora = world.person(&admin, &project, "dora", &["checker"]);
    Work::take(&chen, &task);
    assert_eq!(why(&ann).unwrap(), "this is your label; it is being checked");
    assert_eq!(why(&dora).unwrap(), "somebody else holds this task");
    assert_eq!(why(&chen), None, "who holds it");
    admin
        .post(&format!("/projects/{project}/members"), &json!({ "user": "admin", "roles": ["lead"] }))
        .fine();
    // A lead who does not label is told what can be done, not which role is missing.
    let queue = "it waits in the queue for an annotator who has not seen what comes after its keyframe; to choose one, \
                 assign it in the task list";
    let back = json!({ "action": "reopen", "reason": "wrong keyframe" });
    admin.post(&format!("/tasks/{task}/actions"), &back).fine();
    assert_eq!(why(&admin).unwrap(), queue);
    assert_eq!(why(&chen).unwrap(), "it waits for an annotator");
    assert_eq!(ann.get(&format!("/tasks/{task}")).status, 404, "it is not ann's any more");
}

pub fn tasks_are_there_at_once_and_their_drafts_follow(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let names: Vec<String> = (0..40).map(|n| format!("drive{n}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let made = world.tasks(&admin, &project, &names, 1);
    assert_eq!(made.len(), 40);
    // Opened before or after its turn: the draft exists.
    let last = admin.get(&format!("/tasks/{}", made[39])).fine();
    assert!(!last["draft"]["critical_components"].as_array().unwrap().is_empty());
    let left = || admin.get(&format!("/projects/{project}/work")).fine()["pending"].as_i64().unwrap();
    for _ in 0..600 {
        if left() == 0 {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    assert_eq!(left(), 0, "all drafts were made in the background");
    let export = format!("/projects/{project}/export?format=tasks");
    let lines = admin.get(&export).text();
    assert_eq!((lines.lines().count(), admin.lines(&export)), (40, 40));
    for line in lines.lines() {
        let task: Value = serde_json::from_str(line).unwrap();
        let initial = &task["task"]["initial"];
        assert!(!initial["critical_components"].as_array().unwrap().is_empty(), "{initial}");
        assert_eq!(initial, &task["task"]["draft"]);
    }
}

pub fn a_place_is_given_as_precisely_as_the_project_says(world: &World) {
    let Begin { admin, project, ann, task } = Begin::on(world);
    Work::take(&ann, &task);
    let x = |who: &Person| who.get(&format!("/tasks/{task}/scene")).fine()["ego"]["x"].clone();
    let lane = |who: &Person| who.get(&format!("/tasks/{task}/map")).fine()["lanes"][0]["centre"][0].clone();
    let number = |v: &Value| v.as_f64().unwrap();
    let (exact, exact_lane) = (x(&ann), lane(&ann));
    let set = |meters: i64| {
        admin.patch(&format!("/projects/{project}"), &json!({ "settings": { "place_precision_m": meters } }))
    };
    assert_eq!(set(7).status, 422, "a square of 7 m says where it is");
    set(100).fine();
    let (shown, shown_lane) = (x(&ann), lane(&ann));
    let last = |v: &Value| number(v.as_array().unwrap().last().unwrap());
    // At the keyframe the ego is in the first square; road and objects are shifted by the same vector.
    let by = (last(&exact) / 100.0).floor() * 100.0;
    assert!((last(&shown) - (last(&exact) - by)).abs() < 1e-6, "{by}");
    assert!((0.0..100.0).contains(&last(&shown)));
    assert!((number(&shown_lane[0]) - (number(&exact_lane[0]) - by)).abs() < 1e-6);
}

pub fn finished_tasks_go_when_their_project_keeps_them_no_longer(world: &World) {
    let admin = world.admin();
    let project = world.project(
        &admin,
        "town",
        &json!({ "retention_days": 30, "audit_min_percent": 0, "audit_max_percent": 0 }),
    );
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let chen = world.person(&admin, &project, "chen", &["checker"]);
    let made = world.tasks(&admin, &project, &["drive1", "drive2", "drive3"], 1);
    Work::label(&ann, &made[0]);
    Work::take(&chen, &made[0]).act("accept", &json!({})).fine();
    Work::label(&ann, &made[1]);
    world.wait(29 * 86_400);
    assert_eq!(sweep(&world.app).unwrap(), 0);
    world.wait(2 * 86_400);
    assert_eq!(sweep(&world.app).unwrap(), 1, "the accepted one; what is not finished stays");
    let admin = world.sign_in("admin");
    let left = list(&admin, &project, "");
    assert_eq!(left["total"], 2);
    assert_eq!(admin.get(&format!("/tasks/{}", made[0])).status, 404);
    let seen =
        world.app.store.read(|tx| tx.rows("SELECT 1 FROM seen WHERE drive_id = 'drive1'", &[])).unwrap();
    assert!(!seen.is_empty(), "who has seen it does no Stage I of it");
    // docs/how-to/manage-tasks.md: never a second task for an episode.
    let body = json!({ "episodes": [serde_json::to_value(episode("drive1", 1, world.future)).unwrap()] });
    let again = admin.post(&format!("/projects/{project}/tasks:create"), &body).fine();
    assert_eq!((&again["tasks"], &again["known"]), (&json!([]), &json!(1)));
}

/// docs/reference/service.md, *retention_days*: overruled labels go with the chosen one, not before it, and not never.
pub fn overruled_labels_go_with_the_chosen_one(world: &World) {
    let admin = world.admin();
    let settings = json!({ "retention_days": 30, "audit_min_percent": 0, "audit_max_percent": 0 });
    let project = world.project(&admin, "town", &settings);
    let people = ["ann", "bob", "dee"].map(|name| world.person(&admin, &project, name, &["annotator"]));
    world.person(&admin, &project, "chen", &["checker"]);
    let made = world.tasks(&admin, &project, &["drive1"], 3);
    people.iter().zip(&made).for_each(|(person, task)| drop(Work::label(person, task)));
    let choose = json!({ "action": "adjudicate" });
    admin.post(&format!("/tasks/{}/actions", made[1]), &choose).fine();
    world.wait(10 * 86_400);
    let chen = world.sign_in("chen");
    Work::take(&chen, &made[1]).act("accept", &json!({})).fine();
    world.wait(21 * 86_400);
    assert_eq!(sweep(&world.app).unwrap(), 0, "the choice is 31 days old, the acceptance 21");
    world.wait(10 * 86_400);
    assert_eq!(sweep(&world.app).unwrap(), 3);
    let admin = world.sign_in("admin");
    for task in &made {
        assert_eq!(admin.get(&format!("/tasks/{task}")).status, 404);
    }
}

/// openapi.json, `PATCH /projects/{p}`: "changes the fields that are given".
pub fn a_change_of_one_setting_leaves_the_others(world: &World) {
    let admin = world.admin();
    let settings = json!({ "place_precision_m": 1000, "retention_days": 180, "history": "episode", "lang": "en",
        "utc_offset_min": 480, "hourly_rate": 30.0 });
    let project = world.project(&admin, "town", &settings);
    let path = format!("/projects/{project}");
    let mut before = admin.get(&path).fine()["settings"].clone();
    let after = admin.patch(&path, &json!({ "settings": { "lease_s": 600, "hourly_rate": null } })).fine();
    (before["lease_s"], before["hourly_rate"]) = (json!(600), json!(null));
    assert_eq!((&after["settings"], &admin.get(&path).fine()["settings"]), (&before, &before));
    let unknown = admin.patch(&path, &json!({ "settings": { "lease": 600 } }));
    assert_eq!(unknown.refusal(), (400, "request.invalid".into()));
}
