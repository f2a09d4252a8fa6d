//! Stage I from files to answers: recordings that are equal up to a moment are ingested by the binary and served by it;
//! what an annotator gets of a task with its keyframe at that moment is the same, byte for byte.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::service::{Service, crew};
use crate::session::whyroad_in;
use serde_json::json;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use whyroad_lake::MinedFolder;
use whyroad_lake::mined::{Existing, MinedFolderWriter};
use whyroad_model::messages::EpisodeRecord;

/// When the recordings start to differ, s, and its frame.
const SAME_S: f64 = 4.0;
const KEYFRAME: usize = 40;

/// What comes after that.
#[derive(Clone, Copy, PartialEq)]
enum Future {
    Steady,
    /// The ego and the object brake, the object turns out to be a truck, the ego's brake light goes on, it rains.
    Eventful,
    /// One frame more, and the recording ends.
    Short,
}

/// How a recording is sampled.
#[derive(Clone, Copy)]
struct Rates {
    ego_step_s: f64,
    object_step_s: f64,
    /// Whether the log states the object's velocity.
    with_speeds: bool,
}

/// Writes a recording in the table layout.
fn write_log(dir: &Path, rates: Rates, future: Future) {
    let after = |t: f64| t > SAME_S + 1e-9;
    let eventful = |t: f64| future == Future::Eventful && after(t);
    let end_s = if future == Future::Short { SAME_S + 0.1 } else { 8.0 };
    let x = |t: f64| 10.0 * t - if eventful(t) { 2.0 * (t - SAME_S).powi(2) } else { 0.0 };
    let times = |step: f64| (0..).map(move |i| f64::from(i) * step).take_while(move |t| *t <= end_s + 1e-9);
    let mut ego = "time_s,x_m,y_m,heading_rad,steering_rad,brake\n".to_owned();
    for t in times(rates.ego_step_s) {
        let brake = if eventful(t) { "true" } else { "" };
        writeln!(ego, "{t:.3},{:.6},0,0,{},{brake}", x(t), 0.01 * x(t)).unwrap();
    }
    let mut objects = "time_s,track_id,class,x_m,y_m,heading_rad,length_m,width_m,height_m".to_owned();
    objects += if rates.with_speeds { ",vx_mps,vy_mps\n" } else { "\n" };
    for t in times(rates.object_step_s) {
        let class = match t {
            _ if eventful(t) => "truck",
            _ if t < 1.0 => "unknown",
            _ => "car",
        };
        write!(objects, "{t:.3},a,{class},{:.6},0,0,4.5,1.8,1.5", 25.0 + x(t)).unwrap();
        if rates.with_speeds {
            let slower = if eventful(t) { 4.0 * (t - SAME_S) } else { 0.0 };
            write!(objects, ",{:.6},0", 10.0 - slower).unwrap();
        }
        objects.push('\n');
    }
    let mut context = "time_s,kind,value\n".to_owned();
    if eventful(5.0) {
        writeln!(context, "{:.3},weather,rain", SAME_S + 0.5).unwrap();
    }
    let meta = r#"{"source": "test", "ego": {"length_m": 4.8, "width_m": 1.9, "height_m": 1.5,
        "reference_to_centre_m": 0}}"#;
    fs::create_dir_all(dir).unwrap();
    for (name, text) in
        [("drive.json", meta), ("ego.csv", &ego), ("objects.csv", &objects), ("context.csv", &context)]
    {
        fs::write(dir.join(name), text).unwrap();
    }
}

/// One episode with its keyframe at the moment in question; what it says of the time after differs.
fn episode(start: whyroad_model::Nanos, future: Future) -> EpisodeRecord {
    let at = |frame: usize| start.plus_secs(frame as f64 / 10.0).to_string();
    let (end, score) = if future == Future::Eventful { (60, 0.9) } else { (41, 0.6) };
    let keyframe = json!({"timestamp": at(KEYFRAME), "frame_idx": KEYFRAME, "type": "reactive"});
    let episode = json!({
        "episode_id": "d_e1", "scenario_id": "reactive_agent.following.lead_sudden_brake", "drive_id": "d",
        "clip_id": "d_000", "target_id": "a", "keyframe": keyframe, "score": score, "is_primary": true,
        "time_range": {"start_timestamp": at(30), "end_timestamp": at(end), "start_frame_idx": 30,
            "end_frame_idx": end},
        "keyframe_rule": {"zh": "前车急刹", "en": "the lead brakes"}, "conditions_matched": [], "signals": [],
    });
    serde_json::from_value(episode).unwrap()
}

/// All that the service gives of the task in Stage I.
fn stage_one(rates: Rates, future: Future) -> Vec<(String, String)> {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    write_log(&at.join("log"), rates, future);
    let run = whyroad_in(at, &["ingest", "table", "--lake", "lake", "--drive-id", "d", "log"]);
    assert!(run.code <= 1, "{}{}", run.out, run.err);
    let run = whyroad_in(at, &["mine", "--lake", "lake", "--out", "mined"]);
    assert!(run.code <= 1, "{}{}", run.out, run.err);
    let mined = MinedFolder::open(at.join("mined")).unwrap();
    let question = mined.question().unwrap();
    let start = whyroad_lake::Lake::open(at.join("lake")).unwrap().read_drive(&"d".into()).unwrap().times[0];
    let mut one = MinedFolderWriter::create(mined.dir(), question, Existing::default()).unwrap();
    one.episode(&episode(start, future)).unwrap();
    one.finish().unwrap();

    let service = Service::start_mined(
        &at.join("lake"),
        &at.join("mined"),
        &["--data", at.join("data").to_str().unwrap()],
    );
    let (_, project, mut crew) = crew(service.at, 1);
    let mut annotator = crew.remove(0);
    let task = annotator.task.clone();
    let plain = |text: String| text.replace(&task, "TASK").replace(&project, "PROJECT");
    let mut out: Vec<(String, String)> = ["scene", "map", "thumbnail"]
        .into_iter()
        .map(|what| {
            let answer = annotator.client.get(&format!("/tasks/{task}/{what}"));
            let text = format!("{} {}", answer.status, String::from_utf8_lossy(&answer.body));
            (what.to_owned(), plain(text))
        })
        .collect();
    let view = annotator.client.get(&format!("/tasks/{task}")).good();
    out.push(("draft".to_owned(), plain(view["draft"].to_string())));
    out
}

fn assert_blind(rates: Rates) {
    let seen = stage_one(rates, Future::Steady);
    let (what, scene) = &seen[0];
    assert!(
        what == "scene" && scene.starts_with("200 ") && scene.contains("\"a\""),
        "the object is there: {scene}"
    );
    assert!(scene.contains("ego.accel") || scene.contains("ego.speed"), "signals are there: {scene}");
    for future in [Future::Eventful, Future::Short] {
        for ((what, one), (_, other)) in seen.iter().zip(stage_one(rates, future)) {
            assert!(*one == other, "{what} depends on what comes after the keyframe:\n{one}\n{other}");
        }
    }
}

#[test]
fn poses_and_objects_at_ten_hertz() {
    assert_blind(Rates { ego_step_s: 0.1, object_step_s: 0.1, with_speeds: false });
}

#[test]
fn objects_twice_a_second_and_poses_at_odd_times() {
    assert_blind(Rates { ego_step_s: 0.03, object_step_s: 0.5, with_speeds: true });
}
