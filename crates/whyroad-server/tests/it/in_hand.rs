//! Attacks on Stage I by users with several roles, or by several requests at once: while a Stage I is in their hands,
//! no list, export, checker or thumbnail shows what comes after its keyframe.

use crate::later_task::{give_back, take, two_moments};
use crate::postgres_server::Server;
use crate::recorded::{Future, Recorded, Watched, episode};
use crate::work::{Work, example};
use crate::world::{Person, World};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::sync::{Arc, Barrier, Mutex};
use whyroad_framework::Framework;
use whyroad_server::App;

/// The ids in a list, with its total.
fn listed(who: &Person, project: &str, query: &str) -> (BTreeSet<String>, i64) {
    let page = who.get(&format!("/projects/{project}/tasks?{query}")).fine();
    let ids = page["items"].as_array().unwrap().iter().map(|t| t["id"].as_str().unwrap().to_owned());
    (ids.collect(), page["total"].as_i64().unwrap())
}

pub fn lists_leave_out_what_comes_after_the_keyframe_in_hand(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let both = world.person(&admin, &project, "both", &["annotator", "checker"]);
    let (early, late) = two_moments(world, &admin, &project, "drive1");
    let other = world.tasks(&admin, &project, &["drive2"], 1)[0].clone();
    let ids = |ids: &[&String]| ids.iter().map(|id| (*id).clone()).collect::<BTreeSet<_>>();
    let queries = [
        "",
        "q=drive",
        "sort=keyframe",
        "sort=-updated",
        "state=open,stage1,submitted",
        "scenario=reactive_agent",
    ];
    for query in queries {
        assert_eq!(listed(&both, &project, query), (ids(&[&early, &late, &other]), 3), "{query}");
    }
    let held = Work::take(&both, &early);
    // The class and the moment of the later task are in the future of the one in hand, and so is their number.
    for query in queries {
        assert_eq!(listed(&both, &project, query), (ids(&[&early, &other]), 2), "{query}");
    }
    // Others see all, and so does she when she has given it back.
    assert_eq!(listed(&admin, &project, "").1, 3);
    give_back(&held);
    assert_eq!(listed(&both, &project, "").1, 3);
    // The order in time: an earlier one stays.
    Work::take(&both, &late);
    assert_eq!(listed(&both, &project, "").1, 3);
}

pub fn an_earlier_task_whose_label_reaches_further_is_left_out(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let both = world.person(&admin, &project, "both", &["annotator", "auditor"]);
    let (early, late) = two_moments(world, &admin, &project, "drive1");
    Work::take(&both, &late);
    assert_eq!(listed(&both, &project, "").1, 2);
    // Its decision is about what comes after the later keyframe.
    Work::label(&ann, &early);
    assert_eq!(listed(&both, &project, ""), ([late].into(), 1));
}

pub fn exports_and_mined_lists_wait_for_the_stage_one_in_hand(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let elsewhere = world.project(&admin, "elsewhere", &json!({}));
    for p in [&project, &elsewhere] {
        let roles = json!({ "user": "admin", "roles": ["annotator", "lead"] });
        admin.post(&format!("/projects/{p}/members"), &roles).fine();
    }
    let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    world.tasks(&admin, &elsewhere, &["drive2"], 1);
    let named = "drive=drive1&scenario=reactive_agent.cutin.urgent&episode=drive1_e1";
    let judge = |verdict: Value| {
        let body = json!({ "mined": "week1", "drive": "drive1", "scenario": "reactive_agent.cutin.urgent",
            "episode": "drive1_e1", "verdict": verdict });
        admin.post(&format!("/projects/{project}/verdicts"), &body)
    };
    judge(json!("right")).fine();
    let paths = [
        format!("/projects/{project}/export?format=labels&state=open"),
        format!("/projects/{project}/export?format=tasks"),
        format!("/projects/{project}/verdicts"),
        format!("/projects/{project}/verdicts?format=csv"),
        format!("/projects/{project}/mined/week1/episodes"),
        format!("/projects/{project}/mined/week1/episodes?drive=drive1"),
        format!("/projects/{elsewhere}/mined/week1/episodes?scenario=reactive_agent"),
        format!("/projects/{project}/mined/week1/similar?{named}"),
    ];
    for path in &paths {
        assert_eq!(admin.get(path).status, 200, "{path}");
    }
    let held = Work::take(&admin, &task);
    let refused = (409, "task.stage1_first".to_owned());
    for path in &paths {
        let answer = admin.get(path);
        assert_eq!(answer.refusal(), refused, "{path}");
        assert_eq!(answer.json()["more"]["task"], task.as_str(), "{path}");
    }
    assert_eq!(
        judge(json!("right")).refusal(),
        refused,
        "its answer has the end of the episode and its score"
    );
    // What is about other drives only stays.
    for path in [
        format!("/projects/{elsewhere}/export?format=tasks"),
        format!("/projects/{elsewhere}/verdicts"),
        format!("/projects/{project}/mined/week1/episodes?drive=drive2"),
    ] {
        assert_eq!(admin.get(&path).status, 200, "{path}");
    }
    give_back(&held);
    for path in &paths {
        assert_eq!(admin.get(path).status, 200, "{path}");
    }
}

pub fn what_was_seen_before_is_not_opened_again_during_stage_one(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({ "history": "episode" }));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let both = world.person(&admin, &project, "both", &["annotator", "checker"]);
    let (early, late) = two_moments(world, &admin, &project, "drive1");
    Work::label(&ann, &late);
    both.get(&format!("/tasks/{late}/scene")).fine();
    // Only the same episode excludes here, but what comes after the keyframe is not shown beside it.
    let held = Work::take(&both, &early);
    for path in ["", "/scene", "/map", "/history", "/media/front%20left/0"] {
        let answer = both.get(&format!("/tasks/{late}{path}"));
        assert_eq!(answer.refusal(), (409, "task.stage1_first".into()), "{path}");
    }
    let label = json!({ "label": example() });
    let checked = both.post(&format!("/tasks/{late}/validate"), &label);
    assert_eq!(checked.refusal(), (409, "task.stage1_first".into()));
    give_back(&held);
    both.get(&format!("/tasks/{late}/scene")).fine();
}

pub fn a_thumbnail_counts_as_seen(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let lea = world.person(&admin, &project, "lea", &["lead"]);
    let (early, late) = two_moments(world, &admin, &project, "drive1");
    admin.get(&format!("/tasks/{late}")).fine();
    assert_eq!(lea.get(&format!("/tasks/{late}/thumbnail")).status, 200);
    // Of the later moment she has seen the picture.
    let roles = json!({ "user": "lea", "roles": ["annotator"] });
    admin.post(&format!("/projects/{project}/members"), &roles).fine();
    assert_eq!(take(&lea, &early).refusal(), (403, "task.future_seen".into()));
    take(&lea, &late).fine();
}

pub fn a_label_stays_with_its_clip(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    let mut work = Work::take(&ann, &task);
    work.stage1();
    work.act("lock_stage1", &json!({})).fine();
    work.stage2();
    for path in ["/clip_id", "/clip_id/0"] {
        assert_eq!(work.set(&[(path, json!("drive2_000"))]).refusal(), (422, "draft.clip".into()), "{path}");
    }
    let body = json!({ "fence": work.fence, "base_version": work.version,
        "changes": [{ "path": "/clip_id", "remove": true }] });
    assert_eq!(ann.patch(&work.path("/draft"), &body).refusal(), (422, "draft.clip".into()));
    work.act("submit", &json!({})).fine();
    assert_eq!(work.view()["draft"]["clip_id"], "drive1_000");
}

/// Findings compare a label with its recording: of another clip than the task's, or at a moment that the task does not
/// show, they would tell what happens there.
pub fn findings_compare_only_what_the_task_shows(world: &World) {
    let clips = Arc::new(Mutex::new(Vec::new()));
    let asked = Arc::clone(&clips);
    let world = world.beside(move |app| {
        let store = app.store.clone();
        let drives = Recorded { future: Future::Brakes, pictures: std::env::temp_dir() };
        let watched = Watched { drives, before_signals: || (), clips: asked };
        let clock = Arc::clone(&app.clock);
        *app = App::new(store, Framework::bundled(), Arc::new(watched)).unwrap();
        app.clock = clock;
        app.lease_clock = whyroad_server::app::LeaseClock::Service;
    });
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let ids = world.tasks(&admin, &project, &["drive1", "drive2"], 1);
    Work::take(&ann, &ids[0]);
    // Of the second drive she may know everything: her label of it is submitted.
    let mut work = Work::take(&ann, &ids[1]);
    work.stage1();
    work.act("lock_stage1", &json!({})).fine();
    let own = work.view()["draft"].clone();
    let validate = |label: &Value| {
        clips.lock().unwrap().clear();
        ann.post(&work.path("/validate"), &json!({ "label": label })).fine();
        clips.lock().unwrap().clone()
    };
    assert!(validate(&own).contains(&"drive2_000".to_owned()), "a label of the task is compared");
    let mut other = own.clone();
    other["clip_id"] = json!("drive1_000");
    assert_eq!(validate(&other), Vec::<String>::new());
    // 10:31 is within the drive, but the task shows it until 10:30:15 or a little later.
    let mut late = own.clone();
    late["keyframe"]["timestamp"] = json!("2026-01-15T10:31:00.000Z");
    assert_eq!(validate(&late), Vec::<String>::new());
    let mut early = own;
    early["keyframe"]["timestamp"] = json!("2026-01-15T10:30:00.000Z");
    assert_eq!(validate(&early), Vec::<String>::new());
}

/// On PostgreSQL two transactions run side by side: what each of them does not see yet must not let both through.
#[test]
fn two_requests_at_once_show_no_future() {
    let Some(server) = Server::start() else { return };
    let world = World::on_server(&server.database(), Future::Brakes);
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let both = world.person(&admin, &project, "both", &["annotator", "checker"]);
    let take = json!({ "action": "take" });
    for round in 0..40 {
        let (early, late) = two_moments(&world, &admin, &project, &format!("drive{round}"));
        let copies =
            json!({ "episodes": [episode(&format!("drive9{round}"), 1, world.future)], "overlap": 2 });
        let copies =
            admin.post(&format!("/projects/{project}/tasks:create"), &copies).fine()["tasks"].clone();
        let second = match round % 3 {
            // A label of the later moment is opened.
            0 => {
                Work::label(&ann, &late);
                ("GET", format!("/tasks/{late}"))
            }
            // Its Stage I is begun.
            1 => ("POST", format!("/tasks/{late}/lease")),
            // Another copy of the same episode is begun.
            _ => ("POST", format!("/tasks/{}/lease", copies[1].as_str().unwrap())),
        };
        let first = if round % 3 == 2 { copies[0].as_str().unwrap() } else { early.as_str() };
        let gate = Barrier::new(2);
        let body = take.to_string();
        let (a, b) = std::thread::scope(|scope| {
            let begins = scope.spawn(|| {
                gate.wait();
                both.post(&format!("/tasks/{first}/lease"), &take).status
            });
            let sees = scope.spawn(|| {
                gate.wait();
                let body = (second.0 == "POST").then_some(body.as_bytes());
                both.call(second.0, &second.1, body, &[]).status
            });
            (begins.join().unwrap(), sees.join().unwrap())
        });
        assert!(a.min(b) == 200 && [403, 409].contains(&a.max(b)), "round {round}: {a} {b} {second:?}");
    }
}
