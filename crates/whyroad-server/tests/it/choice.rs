//! Overlap groups from the last submission to the choice: who is told, what waits, what is exported.

use crate::recorded::episode;
use crate::work::Work;
use crate::world::{Person, World};
use serde_json::{Value, json};
use whyroad_server::values;

const NO_AUDITS: &str = r#"{ "audit_min_percent": 0, "audit_max_percent": 0 }"#;

/// A project with two annotators who label both copies of an episode, and a checker.
struct Pair {
    admin: Person,
    project: String,
    ann: Person,
    bob: Person,
    chen: Person,
    ids: Vec<String>,
}

impl Pair {
    fn on(world: &World) -> Self {
        let admin = world.admin();
        let project = world.project(&admin, "town", &serde_json::from_str(NO_AUDITS).unwrap());
        let ann = world.person(&admin, &project, "ann", &["annotator"]);
        let bob = world.person(&admin, &project, "bob", &["annotator"]);
        let chen = world.person(&admin, &project, "chen", &["checker"]);
        let ids = world.tasks(&admin, &project, &["drive1"], 2);
        Self { admin, project, ann, bob, chen, ids }
    }

    fn act(&self, id: &str, action: &str) -> Value {
        let body = json!({ "action": action, "reason": "for the test" });
        self.admin.post(&format!("/tasks/{id}/actions"), &body).fine()
    }

    /// Tasks to choose from: in the list, and as counted for `who`.
    fn to_choose(&self) -> (Value, Value) {
        let listed = self.admin.get(&format!("/projects/{}/tasks?overlap=to_choose", self.project)).fine();
        assert!(listed["items"].as_array().unwrap().iter().all(|t| t["to_choose"] == true));
        (listed["total"].clone(), self.work(&self.admin)["to_choose"].clone())
    }

    fn work(&self, who: &Person) -> Value {
        who.get(&format!("/projects/{}/work", self.project)).fine()
    }

    fn dashboard(&self) -> Value {
        self.chen.get(&format!("/projects/{}/dashboard", self.project)).fine()
    }

    /// Lines of the export, and the episodes that it leaves out.
    fn export(&self) -> (usize, String) {
        let answer = self.admin.get(&format!("/projects/{}/export?format=labels", self.project));
        (answer.text().lines().count(), answer.header("x-whyroad-not-chosen").unwrap().to_owned())
    }
}

fn two() -> (Value, Value) {
    (json!(2), json!(2))
}

fn none() -> (Value, Value) {
    (json!(0), json!(0))
}

pub fn a_group_without_a_choice_is_neither_checked_nor_exported(world: &World) {
    let pair = Pair::on(world);
    Work::label(&pair.ann, &pair.ids[0]);
    assert_eq!(pair.to_choose(), none(), "the other label is still missing");
    Work::label(&pair.bob, &pair.ids[1]);
    assert_eq!((pair.to_choose(), &pair.dashboard()["to_choose"]), (two(), &json!(1)));
    // Leads alone choose, and are told of it.
    assert_eq!(pair.work(&pair.chen)["to_choose"], 0);
    let filtered = format!("/projects/{}/tasks?overlap=to_choose", pair.project);
    assert_eq!(pair.chen.get(&filtered).status, 403);
    assert!(Work::next(&pair.chen, &pair.project, "check").is_none());
    assert_eq!(pair.work(&pair.chen)["to_check"], 0, "what the queue has, not what is submitted");
    let take = json!({ "action": "take" });
    for id in &pair.ids {
        let taken = pair.chen.post(&format!("/tasks/{id}/lease"), &take);
        assert_eq!(taken.refusal(), (409, "task.not_chosen".into()));
        let view = pair.chen.get(&format!("/tasks/{id}")).fine();
        assert!(view["take_refused"]["en"].as_str().unwrap().contains("after a lead has chosen it"));
        assert!(!view["permissions"].as_array().unwrap().contains(&json!("take")));
    }
    assert_eq!(pair.export(), (0, "1".into()));
    // Both were accepted before a choice was required.
    world
        .app
        .store
        .write(|tx| {
            tx.run("UPDATE tasks SET state = 'accepted', checked = 1 WHERE overlap_count > 1", values![])
        })
        .unwrap();
    assert_eq!((pair.export(), pair.to_choose()), ((0, "1".into()), two()));
    assert_eq!(pair.act(&pair.ids[1], "adjudicate")["task"]["adjudication"], "chosen");
    assert_eq!((pair.export(), pair.to_choose()), ((1, "0".into()), none()));
    // Agreement counts all labels.
    assert_eq!(
        (&pair.dashboard()["agreement"]["pairs"], &pair.dashboard()["to_choose"]),
        (&json!(1), &json!(0))
    );
}

pub fn only_the_chosen_label_waits_for_a_check(world: &World) {
    let pair = Pair::on(world);
    Work::label(&pair.ann, &pair.ids[0]);
    Work::label(&pair.bob, &pair.ids[1]);
    pair.act(&pair.ids[0], "adjudicate");
    assert_eq!(
        (&pair.work(&pair.chen)["to_check"], &pair.work(&pair.ann)["to_check"]),
        (&json!(1), &json!(0))
    );
    let submitted = || pair.admin.get(&format!("/projects/{}/tasks?state=submitted", pair.project)).fine();
    assert_eq!((&submitted()["total"], &submitted()["items"][0]["id"]), (&json!(1), &json!(pair.ids[0])));
    let states = &pair.work(&pair.chen)["by_state"];
    assert_eq!(states["submitted"], 1, "the copy that was not chosen waits for nothing: {states}");
    // Taken, it is still what the button gives.
    assert!(Work::next(&pair.chen, &pair.project, "check").is_some());
    assert_eq!(pair.work(&pair.chen)["to_check"], 1);
}

pub fn a_choice_is_open_again_when_the_chosen_label_is_gone(world: &World) {
    let pair = Pair::on(world);
    Work::label(&pair.ann, &pair.ids[0]);
    Work::label(&pair.bob, &pair.ids[1]);
    pair.act(&pair.ids[0], "adjudicate");
    assert_eq!(pair.to_choose(), none());
    let mut check = Work::next(&pair.chen, &pair.project, "check").unwrap();
    assert_eq!(check.task, pair.ids[0]);
    check.act("send_back", &json!({ "reason": "the cause is another" })).fine();
    assert_eq!(pair.to_choose(), none(), "it is still the chosen one");
    // The author finds it unsafe: the other label can stand for the episode.
    let work = Work::take(&pair.ann, &pair.ids[0]);
    let unsafe_ =
        json!({ "fence": work.fence, "answer": "unsafe", "reasons": ["other"], "note": "red light" });
    pair.ann.post(&work.path("/safety"), &unsafe_).fine();
    assert_eq!(pair.to_choose(), (json!(1), json!(1)));
    assert_eq!(pair.act(&pair.ids[1], "adjudicate")["task"]["adjudication"], "chosen");
    let mut check = Work::next(&pair.chen, &pair.project, "check").unwrap();
    assert_eq!(check.task, pair.ids[1]);
    check.act("accept", &json!({})).fine();
    assert_eq!(pair.export(), (1, "0".into()));
    // An accepted label that is returned stays chosen; one that is then skipped does not.
    pair.act(&pair.ids[1], "reopen");
    assert_eq!(pair.export(), (0, "0".into()));
    pair.act(&pair.ids[1], "skip");
    let view = pair.admin.get(&format!("/tasks/{}", pair.ids[1])).fine();
    assert_eq!(view["task"]["adjudication"], Value::Null);
}

pub fn a_label_whose_group_was_left_by_others_can_be_chosen(world: &World) {
    let pair = Pair::on(world);
    Work::label(&pair.ann, &pair.ids[0]);
    pair.act(&pair.ids[1], "skip");
    assert_eq!(pair.to_choose(), (json!(1), json!(1)));
    // Retention removes what was skipped long ago.
    let other = pair.ids[1].clone();
    world
        .app
        .store
        .write(move |tx| {
            tx.run("DELETE FROM history WHERE task_id = $1", values![&other])?;
            tx.run("DELETE FROM thumbnails WHERE task_id = $1", values![&other])?;
            tx.run("DELETE FROM tasks WHERE id = $1", values![&other])
        })
        .unwrap();
    pair.act(&pair.ids[0], "adjudicate");
    Work::next(&pair.chen, &pair.project, "check").unwrap().act("accept", &json!({})).fine();
    assert_eq!(pair.export(), (1, "0".into()));
}

pub fn an_added_copy_is_waited_for(world: &World) {
    let pair = Pair::on(world);
    Work::label(&pair.ann, &pair.ids[0]);
    Work::label(&pair.bob, &pair.ids[1]);
    assert_eq!(pair.to_choose(), two());
    let whole = pair.admin.get(&format!("/projects/{}/export?format=tasks", pair.project)).text();
    let import = |index: i64| {
        let mut line: Value = serde_json::from_str(whole.lines().next().unwrap()).unwrap();
        line["task"]["episode"] = serde_json::to_value(episode("drive1", 1, world.future)).unwrap();
        (line["task"]["overlap_index"], line["task"]["overlap_count"]) = (json!(index), json!(4));
        let import = format!("/projects/{}/import", pair.project);
        let made = pair.admin.call("POST", &import, Some(line.to_string().as_bytes()), &[]).fine();
        assert_eq!(made["tasks"], 1, "{made}");
    };
    let listed = |filter: &str| {
        pair.admin.get(&format!("/projects/{}/tasks?{filter}", pair.project)).fine()["items"].clone()
    };
    import(2);
    let third = listed("state=open")[0]["id"].as_str().unwrap().to_owned();
    assert_eq!(pair.to_choose(), none());
    let choose = json!({ "action": "adjudicate" });
    let early = pair.admin.post(&format!("/tasks/{}/actions", pair.ids[0]), &choose);
    assert_eq!(early.refusal(), (409, "overlap.not_ready".into()));
    Work::label(&world.person(&pair.admin, &pair.project, "dee", &["annotator"]), &third);
    assert_eq!(pair.to_choose(), (json!(3), json!(3)));
    pair.act(&third, "adjudicate");
    // One that comes after the choice is closed like the copies that were not chosen: nobody has to label it.
    import(3);
    assert_eq!(listed("state=open"), json!([]));
    let all = listed("limit=50");
    let known = |id: &Value| *id == json!(third) || pair.ids.iter().any(|i| id == i);
    let late = all.as_array().unwrap().iter().find(|t| !known(&t["id"])).unwrap();
    assert_eq!(late["adjudication"], "superseded");
    let eli = world.person(&pair.admin, &pair.project, "eli", &["annotator"]);
    let path = format!("/tasks/{}/lease", late["id"].as_str().unwrap());
    assert_eq!(eli.post(&path, &json!({ "action": "take" })).refusal(), (409, "task.superseded".into()));
    assert_eq!(pair.to_choose(), none());
    Work::next(&pair.chen, &pair.project, "check").unwrap().act("accept", &json!({})).fine();
    assert!(Work::next(&pair.chen, &pair.project, "check").is_none());
    assert_eq!(pair.export(), (1, "0".into()));
}
