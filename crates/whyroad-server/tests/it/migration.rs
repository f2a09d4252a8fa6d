//! Classes that are renamed or split, in a store with an accepted label, a submitted one and an open task.

use crate::work::Work;
use crate::world::World;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use whyroad_framework::mapping::{ClassChange, ClassMapping, SplitPart};
use whyroad_model::ScenarioId;
use whyroad_server::service::facts;
use whyroad_server::service::migration::{MigrationRun, migrate};

fn id(text: &str) -> ScenarioId {
    text.parse().unwrap()
}

fn mapping(of: &str, change: ClassChange, mark: &str) -> ClassMapping {
    ClassMapping {
        from: "1.0.0".into(),
        to: "2.0.0".into(),
        changes: [(id(of), change)].into(),
        mark: mark.into(),
        ..ClassMapping::default()
    }
}

const URGENT: &str = "reactive_agent.cutin.urgent";
const FAST: &str = "reactive_agent.cutin.fast";

pub fn classes_are_carried_along_and_what_is_undecided_goes_to_people(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({ "audit_min_percent": 0, "audit_max_percent": 0 }));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let chen = world.person(&admin, &project, "chen", &["checker"]);
    let quota = json!({ "quota": { URGENT: 7 } });
    assert_eq!(admin.patch(&format!("/projects/{project}"), &quota).status, 200);
    let tasks = world.tasks(&admin, &project, &["drive1", "drive2", "drive3"], 1);
    Work::label(&ann, &tasks[0]);
    Work::next(&chen, &project, "check").unwrap().act("accept", &json!({})).fine();
    Work::label(&ann, &tasks[1]);
    let class = |task: &str| -> (String, String, String) {
        let view = admin.get(&format!("/tasks/{task}")).fine();
        let text = |v: &Value| v.as_str().unwrap_or_default().to_owned();
        let of_label = text(&view["draft"]["scenario"]["l3"]);
        (text(&view["task"]["scenario_id"]), of_label, text(&view["task"]["state"]))
    };
    let original = admin.get(&format!("/tasks/{}", tasks[0])).fine()["draft"].clone();
    let store = &world.app.store;

    // Opening a task creates its draft.
    assert_eq!(class(&tasks[2]), (URGENT.into(), "urgent".into(), "open".into()));

    // A dry run reports the changes of a run, and writes nothing.
    let rename = mapping(URGENT, ClassChange::To(id(FAST)), "00000000000000aa");
    let dry = migrate(store, &rename, MigrationRun::Dry, world.app.now()).unwrap();
    assert_eq!(dry.moved, BTreeMap::from([((URGENT.to_owned(), FAST.to_owned()), 3)]));
    assert_eq!(class(&tasks[0]).0, URGENT);
    let done = migrate(store, &rename, MigrationRun::Write, world.app.now()).unwrap();
    assert_eq!((&done.moved, &done.undecided, done.settings), (&dry.moved, &dry.undecided, 1));
    assert_eq!(class(&tasks[0]), (FAST.into(), "fast".into(), "accepted".into()));
    assert_eq!(class(&tasks[1]), (FAST.into(), "fast".into(), "submitted".into()));
    assert_eq!(class(&tasks[2]).0, FAST);
    assert_eq!(admin.get(&format!("/projects/{project}")).fine()["quota"], json!({ FAST: 7 }));

    // The complete original is in the history, and the author of the label is unchanged.
    let history = admin.get(&format!("/tasks/{}/history", tasks[0])).fine();
    let items = history["items"].as_array().unwrap();
    let before = items.iter().rfind(|e| e["action"] == "before_migration").unwrap();
    let kept = admin.get(&format!("/tasks/{}/history/{}", tasks[0], before["seq"])).fine();
    assert_eq!(kept["draft"], original);
    assert_eq!(admin.get(&format!("/tasks/{}", tasks[0])).fine()["task"]["author"], "ann");

    // Repeated: no changes.
    let again = migrate(store, &rename, MigrationRun::Write, world.app.now()).unwrap();
    assert!(again.moved.is_empty() && again.undecided.is_empty() && again.settings == 0, "{again:?}");
    let longer = admin.get(&format!("/tasks/{}/history", tasks[0])).fine();
    assert_eq!(longer["items"].as_array().unwrap().len(), history["items"].as_array().unwrap().len());

    // A record that the new class requires: a label submitted without it is returned to its author.
    let owing = mapping(FAST, ClassChange::To(id(URGENT)), "00000000000000cc");
    let owing = ClassMapping { records: [(id(URGENT), vec!["grade".to_owned()])].into(), ..owing };
    let dry = migrate(store, &owing, MigrationRun::Dry, world.app.now()).unwrap();
    assert_eq!(dry.undecided.iter().map(|u| (&u.task, u.rework)).collect::<Vec<_>>(), {
        let mut back = [(&tasks[0], true), (&tasks[1], true)];
        back.sort();
        back
    });

    // A split that no label determines: a submitted label is returned to its author, others keep their state.
    let part = |to: &str| SplitPart { to: id(to), when: BTreeMap::new() };
    let parts = vec![part("reactive_agent.cutin.a"), part("reactive_agent.cutin.b")];
    let split = mapping(FAST, ClassChange::Split(parts), "00000000000000bb");
    let done = migrate(store, &split, MigrationRun::Write, world.app.now()).unwrap();
    assert_eq!(done.undecided.len(), 3);
    assert_eq!(done.undecided.iter().filter(|u| u.rework).count(), 2);
    assert_eq!(done.left, [("town".to_owned(), "quota", FAST.to_owned())]);
    assert_eq!(class(&tasks[0]), ("reactive_agent.cutin".into(), String::new(), "rework".into()));
    assert_eq!(class(&tasks[2]).2, "open");
    let mut again = Work::next(&ann, &project, "label").unwrap();
    assert!(tasks[..2].contains(&again.task), "what is to be decided comes first");
    let urgent = json!({ "l1": "reactive_agent", "l2": "cutin", "l3": "urgent", "full_id": URGENT });
    assert_eq!(again.set(&[("/scenario", urgent)]).status, 200);
    again.act("submit", &json!({})).fine();
    let nothing = migrate(store, &split, MigrationRun::Write, world.app.now()).unwrap();
    assert!(nothing.moved.is_empty() && nothing.undecided.is_empty(), "{nothing:?}");
}

pub fn facts_are_those_of_the_history(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({ "audit_min_percent": 0, "audit_max_percent": 0 }));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let chen = world.person(&admin, &project, "chen", &["checker"]);
    let tasks = world.tasks(&admin, &project, &["drive1", "drive2"], 1);
    let mut work = Work::take(&ann, &tasks[0]);
    world.wait(60);
    work.stage1();
    work.act("lock_stage1", &json!({})).fine();
    world.wait(30);
    work.stage2();
    work.act("submit", &json!({})).fine();
    world.wait(3600);
    let mut check = Work::next(&chen, &project, "check").unwrap();
    world.wait(10);
    check.act("accept", &json!({})).fine();
    let found = world.app.store.read(|tx| facts::of(tx, &project)).unwrap();
    assert_eq!(found.len(), 2);
    let done = found.iter().find(|t| t.task == tasks[0]).unwrap();
    assert_eq!(done.stage, whyroad_label::facts::LabelStage::Accepted);
    // 60 s and 30 s of Ann, 10 s of Chen; the hour between counts for nobody.
    assert!((done.worked_s - 100.0).abs() < 1e-6, "{}", done.worked_s);
    assert_eq!(done.author.as_deref(), Some("ann"));
    let revision = done.revision.as_ref().unwrap();
    assert!(revision.changed.contains(&"/critical_components") && revision.changed.contains(&"/coc_trace"));
    assert_eq!(revision.keyframe_shift_s, Some(0.0), "nobody moved the keyframe");
    assert_eq!(done.accepted.unwrap().seconds_since(done.submitted.unwrap()), 3610.0);
    // Facts from the cache are the same, and only changed tasks are read again.
    let kept = || facts::kept(&world.app.store, &world.app.facts, &project).unwrap();
    assert_eq!(kept(), (found.clone(), 2));
    assert_eq!(kept(), (found.clone(), 0));
    Work::take(&ann, &tasks[1]);
    let after = kept();
    assert_eq!((after.1, after.0 == found), (1, false));
    assert_eq!(after.0, world.app.store.read(|tx| facts::of(tx, &project)).unwrap());
    let open = found.iter().find(|t| t.task == tasks[1]).unwrap();
    assert!(open.label.is_none() && open.revision.is_none() && open.submitted.is_none());
}

pub fn the_analytics_page_is_for_leads(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator", "checker"]);
    let lead = world.person(&admin, &project, "lea", &["lead"]);
    world.tasks(&admin, &project, &["drive1", "drive2"], 1);
    let path = format!("/projects/{project}/analytics");
    assert_eq!(lead.get(&format!("{path}?utc_offset=8")).fine()["html"], "<p>town 2 8</p>");
    assert_eq!(ann.get(&path).status, 403);
    assert_eq!(lead.get(&format!("{path}?utc_offset=99")).status, 400);
    let broken = world.project(&admin, "broken", &json!({ "hourly_rate": 60.5, "currency": "EUR" }));
    let refused = admin.get(&format!("/projects/{broken}/analytics")).refusal();
    assert_eq!(refused, (422, "analytics.unreadable".into()));
    let odd = admin.post("/projects", &json!({ "name": "odd", "settings": { "hourly_rate": -1 } }));
    assert_eq!(odd.refusal(), (422, "project.invalid".into()));
}
