//! Labels of the service as data sets: people label, return and accept over HTTP, on SQLite and on PostgreSQL; the
//! build reads the store; the export has what a checker returned; a doubtful label goes back to its task.
#![allow(clippy::unwrap_used)] // in a test a panic is the report

use crate::service::http::Client;
use crate::service::{Service, demo};
use crate::session::{Run, whyroad_in, whyroad_with};
use serde_json::{Value, json};
use std::path::Path;
use whyroad_dataset::{Release, Sample};
use whyroad_model::{ClipId, Drive};

const PASSWORD: &str = "a long password";

fn run(folder: &Path, line: &str) -> Run {
    let line = line.replace("DEMO", &demo().display().to_string());
    whyroad_in(folder, &line.split(' ').collect::<Vec<_>>())
}

#[track_caller]
fn good(folder: &Path, line: &str) -> Run {
    let run = run(folder, line);
    assert_eq!(run.code, 0, "{line}: {}{}", run.out, run.err);
    run
}

fn example() -> Value {
    serde_json::from_str(include_str!("../../../../examples/cutin_urgent_example.json")).unwrap()
}

fn drives() -> Vec<Drive> {
    let lake = whyroad_lake::Lake::open(demo().join("lake")).unwrap();
    lake.drive_ids().iter().map(|id| lake.read_drive(id).unwrap()).collect()
}

/// What can be said truly of a moment of a bundled drive.
struct Seen {
    drive: &'static str,
    /// Of the keyframe, after the drive's start.
    seconds: usize,
    scenario: [&'static str; 3],
    longitudinal: &'static str,
    category: &'static str,
    description: &'static str,
    trace: &'static str,
}

/// One moment per drive, in the order in which people label them.
const SEEN: [Seen; 3] = [
    Seen {
        drive: "multilane-ego",
        seconds: 17,
        scenario: ["reactive_agent", "cutin", "urgent"],
        longitudinal: "yield_to_agent",
        category: "critical_objects",
        description: "左前方的轿车正在切入本车道",
        trace: "左前方的轿车正在切入本车道，切入后的车距对当前车速而言过小，因此自车应立即减速让行，与轿车拉开安全距离。",
    },
    Seen {
        drive: "signal_junction-ego",
        seconds: 23,
        scenario: ["reactive_rule", "traffic_light", "resume_follow"],
        longitudinal: "resume",
        category: "traffic_lights",
        description: "本车道的信号灯为绿灯",
        trace: "本车道的信号灯为绿灯，允许自车此时进入路口，因此自车应起步。",
    },
    Seen {
        drive: "back_street-ego",
        seconds: 34,
        scenario: ["reactive_agent", "vru_crossing", "crosswalk"],
        longitudinal: "yield_to_agent",
        category: "critical_objects",
        description: "右前方的行人正在自车前方横穿道路",
        trace: "右前方的行人正在自车前方横穿道路，保持当前车速会与其同时到达交汇处，因此自车应减速让行。",
    },
];

/// A label of the drive's moment `seconds` after its start, inside one clip, with the content of the example.
fn label(drive: &Drive, seconds: usize, leaf: &str) -> Value {
    let at = |offset: f64| drive.times[0].plus_secs(seconds as f64 + offset).to_string();
    let frame = (seconds % 20) * 10;
    let mut label = example();
    label["clip_id"] = ClipId::of(&drive.meta.drive_id, seconds / 20).to_string().into();
    label["scenario"]["l3"] = leaf.into();
    label["scenario"]["full_id"] = format!("reactive_agent.cutin.{leaf}").into();
    label["time_range"] = json!({
        "start_timestamp": at(-1.0), "end_timestamp": at(1.0),
        "start_frame_idx": frame - 10, "end_frame_idx": frame + 10,
    });
    label["keyframe"] = json!({ "timestamp": at(0.0), "frame_idx": frame, "type": "reactive" });
    for component in label["critical_components"].as_array_mut().unwrap() {
        component["evidence_times"] = json!([at(0.0)]);
    }
    label
}

/// What was seen, as an episode.
fn episode(seen: &Seen, drives: &[Drive]) -> Value {
    let drive = drives.iter().find(|d| d.meta.drive_id.as_str() == seen.drive).unwrap();
    let label = label(drive, seen.seconds, "urgent");
    json!({
        "episode_id": format!("e-{}-{}", seen.drive, seen.seconds), "scenario_id": seen.scenario.join("."),
        "drive_id": seen.drive, "clip_id": label["clip_id"], "time_range": label["time_range"],
        "keyframe": label["keyframe"], "score": 1.0, "is_primary": true, "keyframe_rule": {"zh": "", "en": ""},
        "conditions_matched": [], "signals": [],
    })
}

/// Somebody with a task in hand.
struct Held<'c> {
    who: &'c mut Client,
    task: String,
    fence: i64,
    version: i64,
}

impl<'c> Held<'c> {
    fn next(who: &'c mut Client, project: &str, kind: &str) -> Self {
        let task = who.post(&format!("/projects/{project}/tasks:next"), &json!({ "kind": kind })).good();
        let number = |name: &str| task[name].as_i64().unwrap();
        let (fence, version) = (number("fence"), number("version"));
        Self { task: task["task"]["id"].as_str().unwrap().to_owned(), fence, version, who }
    }

    fn draft(&mut self) -> Value {
        self.who.get(&format!("/tasks/{}", self.task)).good()["draft"].clone()
    }

    fn set(&mut self, changes: Value) {
        let body = json!({ "fence": self.fence, "base_version": self.version, "changes": changes });
        let answer = self.who.patch(&format!("/tasks/{}/draft", self.task), &body).good();
        self.version = answer["version"].as_i64().unwrap();
    }

    fn act(&mut self, action: &str, reason: Option<&str>) -> Value {
        let body = json!({ "fence": self.fence, "action": action, "reason": reason });
        let answer = self.who.post(&format!("/tasks/{}/actions", self.task), &body).good();
        self.version = answer["version"].as_i64().unwrap();
        answer["task"]["state"].clone()
    }

    /// Both stages with what was seen, to `submitted`.
    fn label(mut self, seen: &Seen, trace: &str) {
        let draft = self.draft();
        assert_eq!(draft["scenario"]["full_id"], seen.scenario.join("."));
        let components = json!([{
            "id": "c1", "category": seen.category, "description": seen.description, "uncertainty": "low",
            "evidence_times": [draft["keyframe"]["timestamp"]],
        }]);
        self.set(json!([{ "path": "/critical_components", "value": components }]));
        self.act("lock_stage1", None);
        let safe = json!({ "fence": self.fence, "answer": "safe" });
        let answer = self.who.post(&format!("/tasks/{}/safety", self.task), &safe).good();
        self.version = answer["version"].as_i64().unwrap();
        self.set(json!([
            { "path": "/driving_decision", "value": { "longitudinal": seen.longitudinal, "lateral": null } },
            { "path": "/causes", "value": { "longitudinal": { "components": ["c1"] } } },
            { "path": "/coc_trace", "value": trace },
            { "path": "/second_keyframe", "remove": true, "value": null },
        ]));
        assert_eq!(self.act("submit", None), "submitted");
    }
}

/// Three labels, one per drive: the first is returned once, then all but the last are accepted. The store is the one
/// that `store` names; gives the first trace of the returned label.
fn people_label(store: &[&str]) -> String {
    let service = Service::start(store);
    let mut admin = Client::set_up(service.at, "admin");
    let settings = json!({ "audit_min_percent": 0, "audit_max_percent": 0 });
    let project = admin.post("/projects", &json!({ "name": "town", "settings": settings })).good();
    let project = project["id"].as_str().unwrap().to_owned();
    let drives = drives();
    assert_eq!(drives.len(), 3);
    for (priority, seen) in SEEN.iter().rev().enumerate() {
        let tasks = json!({ "episodes": [episode(seen, &drives)], "priority": priority });
        admin.post(&format!("/projects/{project}/tasks:create"), &tasks).good();
    }
    let mut person = |name: &str, role: &str| {
        admin.post("/users", &json!({ "name": name, "display": name, "password": PASSWORD })).good();
        admin.post(&format!("/projects/{project}/members"), &json!({ "user": name, "roles": [role] })).good();
        Client::sign_in(service.at, name)
    };
    let (mut ann, mut chen) = (person("ann", "annotator"), person("chen", "checker"));

    let [cut_in, green, crossing] = &SEEN;
    let better = cut_in.trace;
    let first = better.replace("立即减速让行，与轿车拉开安全距离", "减速让行");
    assert_ne!(first, better);
    Held::next(&mut ann, &project, "label").label(cut_in, &first);
    let mut check = Held::next(&mut chen, &project, "check");
    assert_eq!(check.act("send_back", Some("说明与轿车的距离")), "rework");
    let mut again = Held::next(&mut ann, &project, "label");
    again.set(json!([{ "path": "/coc_trace", "value": better }]));
    assert_eq!(again.act("submit", None), "submitted");
    assert_eq!(Held::next(&mut chen, &project, "check").act("accept", None), "accepted");
    Held::next(&mut ann, &project, "label").label(green, green.trace);
    assert_eq!(Held::next(&mut chen, &project, "check").act("accept", None), "accepted");
    Held::next(&mut ann, &project, "label").label(crossing, crossing.trace);
    first
}

fn samples(release: &Path) -> Vec<Sample> {
    Release::open(release).unwrap().samples(None).map(Result::unwrap).collect()
}

/// Builds from the store at `source` with these environment variables, exports, and checks what must be in it.
fn what_was_accepted_is_released(at: &Path, source: &str, environment: &[(&str, &str)], returned: &str) {
    good(at, "dataset init dataset.yaml");
    let lake = demo().join("lake").display().to_string();
    let build = [
        "dataset",
        "build",
        "--spec",
        "dataset.yaml",
        "--labels",
        source,
        "--lake",
        &lake,
        "--out",
        "release",
    ];
    let built = whyroad_with(at, &build, environment);
    assert_eq!(built.code, 0, "{}{}", built.out, built.err);
    assert!(built.out.starts_with("2 samples"), "{}", built.out);
    assert!(built.out.contains("status not selected 1"), "the third is not accepted yet: {}", built.out);
    let all = samples(&at.join("release"));
    assert!(all.iter().all(|s| s.lineage.checked && s.lineage.label_status == "accepted"));
    assert!(all.iter().all(|s| s.lineage.task_id.is_some() && s.lineage.episode_id.is_some()));
    assert!(all.iter().all(|s| s.lineage.label_by.as_deref() == Some("ann")));
    let rejected: Vec<_> = all.iter().flat_map(|s| &s.rejected).collect();
    assert_eq!(rejected.len(), 1);
    assert_eq!(rejected[0].trace.as_deref(), Some(returned));
    assert_eq!(rejected[0].reason.as_deref(), Some("说明与轿车的距离"));

    let exported = good(at, "dataset export ms-swift release --out swift --format json");
    let summary: Value = serde_json::from_str(&exported.out).unwrap();
    // Per sample one SFT and one GRPO record, and one DPO record for the returned version.
    assert_eq!((&summary["samples"], &summary["records"]), (&json!(2), &json!(5)));
    let lines = |kind: &str| -> Vec<Value> {
        let files = ["train", "val", "test"].map(|s| at.join(format!("swift/{kind}.{s}.jsonl")));
        let text: String = files.iter().filter_map(|f| std::fs::read_to_string(f).ok()).collect();
        text.lines().map(|l| serde_json::from_str(l).unwrap()).collect()
    };
    assert_eq!(lines("sft").len(), 2);
    let dpo = lines("dpo").remove(0);
    let (chosen, rejected) =
        (dpo["messages"][1]["content"].as_str().unwrap(), dpo["rejected_response"].as_str().unwrap());
    assert!(rejected.starts_with(returned), "{rejected}");
    // Both have the same form, so that only what was said differs.
    assert_eq!(chosen.lines().last(), rejected.lines().last());
    assert_ne!(chosen, rejected);
    good(at, "dataset verify release");

    let mined = demo().join("mined").display().to_string();
    let report = [
        "report",
        "--lake",
        &lake,
        "--mined",
        &mined,
        "--labels",
        source,
        "--release",
        "release",
        "--tables",
        "tables",
    ];
    let reported = whyroad_with(at, &report, environment);
    assert_eq!(reported.code, 0, "{}{}", reported.out, reported.err);
    let stages = std::fs::read_to_string(at.join("tables/stages.csv")).unwrap();
    let mut lines = stages.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let of_levels: Vec<Vec<&str>> = lines.filter(|fields| fields[1] == "l1").collect();
    let total = |column: &str| -> u64 {
        let at = header.iter().position(|name| *name == column).unwrap();
        of_levels.iter().filter_map(|fields| fields[at].parse::<u64>().ok()).sum()
    };
    assert_eq!((total("tasked"), total("accepted"), total("released")), (3, 2, 2));
}

#[test]
fn accepted_labels_of_a_sqlite_store_are_released() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    let returned = people_label(&["--data", at.join("data").to_str().unwrap()]);
    what_was_accepted_is_released(at, "data/labels.db", &[], &returned);
}

#[test]
fn accepted_labels_of_a_postgresql_store_are_released() {
    let Some(server) = crate::postgres::Server::start() else { return };
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    let url = server.database();
    let returned = people_label(&["--data", at.join("data").to_str().unwrap(), "--store", &url]);
    // The key is not on the database server.
    let folder = [("WHYROAD_DATA_DIR", "data")];
    what_was_accepted_is_released(at, &url, &folder, &returned);
}

#[test]
fn a_doubtful_label_goes_back_to_its_own_task() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    // Two leaves, six labels each; the store has them accepted, one of a plain file is in no store. At these moments
    // no drive contradicts the decision to yield.
    let drives = drives();
    let moments = [3, 5, 14, 16];
    let all: Vec<(usize, Value)> = (0..12)
        .map(|i| (i, label(&drives[i / 4], moments[i % 4], if i % 2 == 0 { "urgent" } else { "slow" })))
        .collect();
    let write = |name: &str, part: &[(usize, Value)]| {
        let text: String = part.iter().map(|(_, l)| format!("{l}\n")).collect();
        std::fs::write(at.join(name), text).unwrap();
    };
    write("stored.jsonl", &all[..11]);
    write("file.jsonl", &all[11..]);
    good(at, "tasks import stored.jsonl --project town --lake DEMO/lake --data data");
    let store = whyroad_server::store::Store::open(&at.join("data/labels.db")).unwrap();
    store.write(|tx| tx.run("UPDATE tasks SET state = 'accepted'", &[])).unwrap();
    drop(store);
    good(at, "dataset init template.yaml");
    let spec = std::fs::read_to_string(at.join("template.yaml")).unwrap();
    std::fs::write(at.join("dataset.yaml"), spec.replace("near: 0.9 ", "near: null")).unwrap();
    good(
        at,
        "dataset build --spec dataset.yaml --labels data/labels.db --labels file.jsonl --lake DEMO/lake --out release",
    );
    let released = samples(&at.join("release"));
    assert_eq!(released.len(), 12);

    // A model that is sure of every label but two: one of the store, and the one of the file.
    let from_file = released.iter().find(|s| s.lineage.task_id.is_none()).unwrap();
    let of_store =
        released.iter().find(|s| s.lineage.task_id.is_some() && s.scenario_id.ends_with("urgent")).unwrap();
    let doubted = [&from_file.sample_id, &of_store.sample_id];
    let predictions: String = released
        .iter()
        .map(|s| {
            let other = if s.scenario_id.ends_with("urgent") { "slow" } else { "urgent" };
            let own = if doubted.contains(&&s.sample_id) { 0.05 } else { 0.95 };
            let leaf = json!({ &s.scenario_id: own, format!("reactive_agent.cutin.{other}"): 1.0 - own });
            format!("{}\n", json!({ "sample_id": s.sample_id, "probabilities": { "leaf": leaf } }))
        })
        .collect();
    std::fs::write(at.join("p.jsonl"), predictions).unwrap();
    let back =
        "dataset doubtful release --probabilities p.jsonl --to-tasks review --lake DEMO/lake --data data";
    let done = good(at, back);
    assert!(done.out.contains("12 samples checked, 2 doubtful labels"), "{}", done.out);
    assert!(
        done.err.contains("1 labels sent to rework in their tasks; 0 tasks already in work"),
        "{}",
        done.err
    );
    assert!(done.err.contains("project review: 1 review tasks created"), "{}", done.err);
    let rework = good(at, "tasks list --project town --state rework --data data").out;
    assert_eq!(rework.lines().count(), 1);
    assert!(rework.contains(of_store.lineage.task_id.as_deref().unwrap()), "{rework}");
    assert_eq!(good(at, "tasks list --project review --state open --data data").out.lines().count(), 1);
    let tasks = good(at, "tasks export --project town --format tasks --data data").out;
    assert!(tasks.contains("doubtful leaf: reactive_agent.cutin.urgent has probability 0.050"), "{tasks}");
    // Again: it is in work, and nothing is made twice.
    let again = good(at, back);
    assert!(
        again.err.contains("0 labels sent to rework in their tasks; 1 tasks already in work"),
        "{}",
        again.err
    );
    assert!(again.err.contains("0 review tasks created; 1 already present"), "{}", again.err);
}

#[test]
fn two_releases_are_compared_by_moment_and_class() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    let drives = drives();
    let drive = &drives[0];
    good(at, "dataset init template.yaml");
    let spec = std::fs::read_to_string(at.join("template.yaml")).unwrap();
    std::fs::write(at.join("dataset.yaml"), spec.replace("near: 0.9 ", "near: null")).unwrap();
    let build = |labels: &[Value], name: &str| {
        let text: String = labels.iter().map(|l| format!("{l}\n")).collect();
        std::fs::write(at.join(format!("{name}.jsonl")), text).unwrap();
        good(
            at,
            &format!(
                "dataset build --spec dataset.yaml --labels {name}.jsonl --lake DEMO/lake --out {name} --drafts"
            ),
        );
        assert_eq!(samples(&at.join(name)).len(), labels.len());
    };
    let mut later = label(drive, 16, "slow");
    let keyframe = drive.times[0].plus_secs(16.4).to_string();
    later["keyframe"] = json!({ "timestamp": keyframe, "frame_idx": 164, "type": "reactive" });
    build(&[4, 6, 8, 16].map(|s| label(drive, s, "slow")), "before");
    // One class changed, one sample gone, one the same, one keyframe 0.4 s later, one new.
    build(&[label(drive, 4, "urgent"), label(drive, 6, "slow"), later, label(drive, 18, "slow")], "after");

    let compared = good(at, "compare before after --format json");
    let json: Value = serde_json::from_str(&compared.out).unwrap();
    assert_eq!(json["unchanged"], 1, "{json:#}");
    let of = |leaf: &str| json["classes"][format!("reactive_agent.cutin.{leaf}")]["changes"].clone();
    assert_eq!(of("slow"), json!({ "gained": 1, "lost": 1, "moved": 1, "reclassified": 1 }), "{json:#}");
    assert_eq!(of("urgent"), json!({}));
    let mixed = run(at, "compare before DEMO/mined");
    assert_eq!(mixed.code, 1);
    assert!(mixed.err.contains("a release can only be compared with a release"), "{}", mixed.err);
}
