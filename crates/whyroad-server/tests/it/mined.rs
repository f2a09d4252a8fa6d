//! Mined episodes: browsed and judged by leads without labeling.

use crate::work::Work;
use crate::world::{Person, World};
use serde_json::{Value, json};

const DRIVE1: &str = "drive=drive1&scenario=reactive_agent.cutin.urgent&episode=drive1_e1";

fn verdict(who: &Person, project: &str, more: Value) -> crate::world::Reply {
    let mut body = json!({ "mined": "week1", "drive": "drive1", "scenario": "reactive_agent.cutin.urgent",
        "episode": "drive1_e1" });
    for (key, value) in more.as_object().unwrap() {
        body[key] = value.clone();
    }
    who.post(&format!("/projects/{project}/verdicts"), &body)
}

pub fn mined_episodes_are_browsed_and_judged(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let lead = world.person(&admin, &project, "lea", &["lead", "annotator"]);
    let chen = world.person(&admin, &project, "chen", &["checker"]);
    let path = format!("/projects/{project}/mined/week1");
    assert_eq!(chen.get(&format!("{path}/episodes")).status, 403);
    let page = lead.get(&format!("{path}/episodes?limit=1")).fine();
    assert_eq!((&page["total"], page["items"].as_array().unwrap().len()), (&json!(2), 1));
    // The keyframe is 10:30:09.4 of a drive that begins at 10:30.
    assert_eq!(page["items"][0]["keyframe_s"], 9.4);
    let next = page["next"].as_str().unwrap();
    let second = lead.get(&format!("{path}/episodes?limit=1&cursor={next}")).fine();
    assert_eq!((&second["items"][0]["episode_id"], &second["next"]), (&json!("drive2_e1"), &Value::Null));
    assert_eq!(lead.get(&format!("{path}/episodes?scenario=proactive")).fine()["items"], json!([]));
    assert_eq!(lead.get(&format!("/projects/{project}/mined/none/episodes")).status, 404);

    let shown = lead.get(&format!("{path}/episode?{DRIVE1}")).fine();
    assert_eq!(shown["task"]["task"]["scenario_id"], "reactive_agent.cutin.urgent");
    assert_eq!(shown["task"]["permissions"], json!([]));
    assert_eq!(shown["keyframe_rule"]["en"], "crosses the line");
    assert!(shown["scene"]["times"].as_array().unwrap().len() > 100, "also what comes after");
    assert!(shown["scene"]["signals"]["target.gap"].is_array());
    // Its images have separate addresses, for leads only.
    let cameras = shown["scene"]["cameras"].as_array().unwrap();
    let front = cameras.iter().find(|c| c["camera"] == "front left").unwrap();
    let frames = front["frames"].as_array().unwrap();
    let url = frames.last().unwrap()["url"].as_str().unwrap().strip_prefix("/api/v1").unwrap();
    let image = lead.get(url);
    assert_eq!((image.status, image.body.starts_with(b"picture of frame ")), (200, true), "{url}");
    assert_eq!(chen.get(url).status, 403);
    let beyond = url.replace(&format!("/{}?", frames.len() - 1), &format!("/{}?", frames.len()));
    assert_eq!(lead.get(&beyond).status, 404);
    // A user who has seen it cannot do its Stage I.
    let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    let take = lead.post(&format!("/tasks/{task}/lease"), &json!({ "action": "take" }));
    assert_eq!(take.refusal(), (403, "task.future_seen".into()));

    assert_eq!(verdict(&lead, &project, json!({ "verdict": "right" })).fine()["by"], "lea");
    assert_eq!(
        lead.get(&format!("{path}/episodes?unjudged=true")).fine()["items"].as_array().unwrap().len(),
        1
    );
    assert_eq!(verdict(&chen, &project, json!({ "verdict": "right" })).status, 403);
    assert_eq!(verdict(&lead, &project, json!({ "verdict": "keyframe_moved" })).status, 400);
    assert_eq!(verdict(&lead, &project, json!({ "verdict": "wrong_leaf", "leaf": "no.such" })).status, 400);
    assert_eq!(verdict(&lead, &project, json!({ "verdict": "nothing", "episode": "gone" })).status, 404);
    let moved = json!({ "verdict": "keyframe_moved", "keyframe": "2026-01-15T10:30:09.900Z", "note": "=1+1, \"late\"" });
    verdict(&lead, &project, moved).fine();
    let said = lead.get(&format!("{path}/episode?{DRIVE1}")).fine()["verdict"].clone();
    assert_eq!(
        said["right_keyframe_ns"].as_i64().unwrap() - said["keyframe_ns"].as_i64().unwrap(),
        500_000_000
    );
    // A second lead has another verdict on it: both are exported.
    let wrong = json!({ "verdict": "wrong_leaf", "leaf": "reactive_agent.cutin.slow" });
    verdict(&admin, &project, wrong).fine();
    let lines = lead.get(&format!("/projects/{project}/verdicts")).text();
    let lines: Vec<Value> = lines.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let mut kinds: Vec<&str> = lines.iter().map(|l| l["verdict"].as_str().unwrap()).collect();
    kinds.sort_unstable();
    assert_eq!(kinds, ["keyframe_moved", "wrong_leaf"], "the first verdict of Lea's was replaced");
    assert!(lines.iter().all(|l| l["score"] == 0.9 && l["drive_id"] == "drive1"));
    let csv = lead.get(&format!("/projects/{project}/verdicts?format=csv")).text();
    assert_eq!(csv.lines().count(), 3);
    assert!(csv.starts_with("verdict,mined,episode_id,"));
    assert!(csv.contains("\"'=1+1, \"\"late\"\"\""), "{csv}");
    assert_eq!(verdict(&admin, &project, json!({ "verdict": null })).status, 204, "taken back");
    assert_eq!(lead.get(&format!("/projects/{project}/verdicts")).text().lines().count(), 1);

    let like = lead.get(&format!("{path}/similar?{DRIVE1}")).fine();
    assert_eq!(
        (&like["items"][0]["episode"]["episode_id"], &like["compared"]),
        (&json!("drive2_e1"), &json!(1))
    );
}

pub fn moments_without_a_class_are_listed_apart(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let list = |query: &str| {
        let page = admin.get(&format!("/projects/{project}/mined/unexplained/episodes?{query}")).fine();
        let classes: Vec<String> = page["items"]
            .as_array()
            .unwrap()
            .iter()
            .map(|i| i["scenario_id"].as_str().unwrap().into())
            .collect();
        (page["total"].as_u64(), classes, page["next"].is_null())
    };
    let urgent = "reactive_agent.cutin.urgent".to_owned();
    assert_eq!(list(""), (Some(2), vec!["other".into(), urgent.clone()], true));
    assert_eq!(list("explained=true"), (Some(1), vec![urgent.clone()], true));
    assert_eq!(list("explained=true&limit=1"), (Some(1), vec![urgent.clone()], true), "a page is full");
    assert_eq!(list("scenario=other"), (Some(1), vec!["other".into()], true));
    assert_eq!(list("scenario=reactive_agent&explained=true"), (Some(1), vec![urgent], true));
}

pub fn who_is_in_stage_one_is_not_shown_the_episode(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let lead = world.person(&admin, &project, "lea", &["lead", "annotator"]);
    let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    Work::take(&lead, &task);
    let shown = lead.get(&format!("/projects/{project}/mined/week1/episode?{DRIVE1}"));
    assert_eq!(shown.refusal(), (409, "task.stage1_first".into()));
    let image = lead.get(&format!("/projects/{project}/mined/week1/media/front%20left/0?{DRIVE1}"));
    assert_eq!(image.refusal(), (409, "task.stage1_first".into()));
}
