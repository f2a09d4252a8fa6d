//! Steps of people on a task, for tests that need one in some state.

use crate::world::{Person, Reply, World};
use serde_json::{Value, json};

/// A project with one task and an annotator.
pub struct Begin {
    pub admin: Person,
    pub project: String,
    pub ann: Person,
    pub task: String,
}

impl Begin {
    pub fn on(world: &World) -> Self {
        let admin = world.admin();
        let project = world.project(&admin, "town", &json!({}));
        let ann = world.person(&admin, &project, "ann", &["annotator"]);
        let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
        Self { admin, project, ann, task }
    }
}

/// A task held by a person.
pub struct Work<'p> {
    pub who: &'p Person,
    pub task: String,
    pub fence: i64,
    pub version: i64,
}

impl<'p> Work<'p> {
    /// Takes the task.
    pub fn take(who: &'p Person, task: &str) -> Self {
        let lease = who.post(&format!("/tasks/{task}/lease"), &json!({ "action": "take" })).fine();
        let version = who.get(&format!("/tasks/{task}")).fine()["version"].as_i64().unwrap();
        Self { who, task: task.to_owned(), fence: lease["fence"].as_i64().unwrap(), version }
    }

    /// Takes the next of the queue.
    pub fn next(who: &'p Person, project: &str, kind: &str) -> Option<Self> {
        let answer = who.post(&format!("/projects/{project}/tasks:next"), &json!({ "kind": kind }));
        if answer.status == 204 {
            return None;
        }
        let task = answer.fine();
        Some(Self {
            who,
            task: task["task"]["id"].as_str().unwrap().to_owned(),
            fence: task["fence"].as_i64().unwrap(),
            version: task["version"].as_i64().unwrap(),
        })
    }

    pub fn path(&self, rest: &str) -> String {
        format!("/tasks/{}{rest}", self.task)
    }

    pub fn view(&self) -> Value {
        self.who.get(&self.path("")).fine()
    }

    /// Sets fields.
    pub fn set(&mut self, fields: &[(&str, Value)]) -> Reply {
        let changes: Vec<Value> = fields.iter().map(|(p, v)| json!({ "path": p, "value": v })).collect();
        let body = json!({ "fence": self.fence, "base_version": self.version, "changes": changes });
        let answer = self.who.patch(&self.path("/draft"), &body);
        if answer.status == 200 {
            self.version = answer.json()["version"].as_i64().unwrap();
        }
        answer
    }

    pub fn act(&mut self, action: &str, more: &Value) -> Reply {
        let mut body = json!({ "fence": self.fence, "action": action });
        for (key, value) in more.as_object().into_iter().flatten() {
            body[key] = value.clone();
        }
        let answer = self.who.post(&self.path("/actions"), &body);
        if answer.status == 200 {
            self.version = answer.json()["version"].as_i64().unwrap();
        }
        answer
    }

    /// Stage I as in the example label.
    pub fn stage1(&mut self) {
        let answer = self.set(&[("/critical_components", components())]);
        assert_eq!(answer.status, 200, "{}", answer.text());
    }

    /// Stage I with all evidence at one moment.
    pub fn stage1_at(&mut self, moment: &str) {
        let mut components = components();
        for c in components.as_array_mut().unwrap() {
            c["evidence_times"] = json!([moment]);
        }
        let answer = self.set(&[("/critical_components", components)]);
        assert_eq!(answer.status, 200, "{}", answer.text());
    }

    /// Answers the safety filter.
    pub fn safe(&mut self) {
        let body = json!({ "fence": self.fence, "answer": "safe" });
        self.version = self.who.post(&self.path("/safety"), &body).fine()["version"].as_i64().unwrap();
    }

    /// Stage II as in the example label.
    pub fn stage2(&mut self) {
        if self.view()["draft"]["safety_filter"].is_null() {
            self.safe();
        }
        let example: Value = example();
        let answer = self.set(&[
            ("/driving_decision", example["driving_decision"].clone()),
            ("/causes", example["causes"].clone()),
            ("/coc_trace", example["coc_trace"].clone()),
            ("/second_keyframe", Value::Null),
        ]);
        assert_eq!(answer.status, 200, "{}", answer.text());
        let body = json!({ "fence": self.fence, "base_version": self.version,
            "changes": [{ "path": "/second_keyframe", "remove": true }] });
        self.version = self.who.patch(&self.path("/draft"), &body).fine()["version"].as_i64().unwrap();
    }

    /// All steps to `submitted`.
    pub fn label(who: &'p Person, task: &str) -> Self {
        let mut work = Self::take(who, task);
        work.stage1();
        work.act("lock_stage1", &json!({})).fine();
        work.stage2();
        work.act("submit", &json!({})).fine();
        work
    }
}

/// The example label in the format's own document (DATA_FORMAT.md 4).
pub fn example() -> Value {
    let text = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/cutin_urgent_example.json");
    serde_json::from_slice(&std::fs::read(text).unwrap()).unwrap()
}

pub fn components() -> Value {
    example()["critical_components"].clone()
}
