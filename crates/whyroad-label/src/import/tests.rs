//! Hand-written entries in the format that the sources' code writes and reads.

use super::*;
use serde_json::json;
use whyroad_model::DriveId;
use whyroad_model::messages::{ProvenanceSource, ScenarioLabel};

fn row(value: Value) -> Row {
    value.as_object().unwrap().clone()
}

fn codes(reading: &Reading) -> Vec<&str> {
    reading.diagnostics.iter().map(|d| d.code).collect()
}

#[test]
fn every_event_is_read_under_either_key_and_in_either_form() {
    let text = json!([
        {"event_start_timestamp": 5_000_000, "event_start_frame": 150, "coc": "Yield to the van."},
        {"event_start_timestamp": 9_000_000, "cot": "Stop for the cone."},
        {"event_start_timestamp": 9_500_000, "cot": "a", "coc": "b", "weather": "fog"},
        {"event_start_timestamp": 1, "cot": " "},
        {"coc": "no time"},
    ]);
    let rows = [
        row(json!({"clip_id": "a", "events": text.to_string(), "event_cluster": "works", "split": "train"})),
        row(
            json!({"__index_level_0__": "b", "events": [{"event_start_timestamp": 2, "coc": "c"}], "split": null}),
        ),
        row(json!({"events": "[]"})),
        row(json!({"clip_id": "d", "events": "{"})),
    ];
    let r = read_rows(&rows);
    let found: Vec<_> = r.found.iter().map(|f| (f.clip.as_str(), f.at_us, f.text.as_str())).collect();
    assert_eq!(
        found,
        [
            ("a", 5_000_000, "Yield to the van."),
            ("a", 9_000_000, "Stop for the cone."),
            ("a", 9_500_000, "b"),
            ("b", 2, "c")
        ]
    );
    assert_eq!(
        r.left_out,
        [("event_cluster", 1), ("events.weather", 1), ("split", 1)].map(|(k, n)| (k.to_owned(), n)).into()
    );
    let expected = [
        "import.text.conflict",
        "import.text.missing",
        "import.entry.invalid",
        "import.entry.invalid",
        "import.entry.invalid",
    ];
    assert_eq!(codes(&r), expected);
}

fn read_rows(rows: &[Row]) -> Reading {
    ood_reasoning::read("ood.parquet", rows)
}

#[test]
fn auto_labeler_text_and_meta_actions() {
    let yaml = "results:\n  event_start_frame: 52\n  event_start_timestamp: 5200000\n  coc_prompt_version: v3\n  final_content:\n    \
                ego_behavior_schema:\n      effect_on_ego_behavior: Slow down because the bus brakes.\n      visibility: good\n  prompt: long\n";
    let r = auto_labeler::read_text("run/c/cot_5200000.yaml", "c", "cot_5200000", yaml);
    let one = &r.found[0];
    assert_eq!(
        (one.at_us, one.clip.as_str(), one.text.as_str()),
        (5_200_000, "c", "Slow down because the bus brakes.")
    );
    assert_eq!(one.versions["coc_prompt_version"], "v3");
    let left: Vec<_> = r.left_out.keys().map(String::as_str).collect();
    assert_eq!(left, ["results.final_content.ego_behavior_schema.visibility", "results.prompt"]);
    // If it has no time of its own, the file's name has it.
    let bare = "results:\n  final_content:\n    ego_behavior_schema:\n      effect_on_ego_behavior: x\n";
    assert_eq!(auto_labeler::read_text("f", "c", "cot_700000", bare).found[0].at_us, 700_000);
    assert_eq!(codes(&auto_labeler::read_text("f", "c", "cot_7", "a: [")), ["import.file.unreadable"]);
    let meta = auto_labeler::read_meta_actions(
        "c.txt",
        "GentleAcceleration - Agent:<ego>, Start:0, End:35\nnothing\n",
    );
    assert_eq!(meta.left_out["meta_action.GentleAcceleration"], 1);
    assert_eq!(codes(&meta), ["import.entry.invalid"]);
}

#[test]
fn alpamayo2_as_object_list_and_lines() {
    let one = json!({
        "clip_id": "c", "t0_us": 3_000_000, "chain_of_causation": "Keep distance to the truck.",
        "critical_components_analysis": "- a truck ahead\n- wet road", "trajectory_analysis": null,
        "ego_vehicle_motion_analysis": "steady",
    });
    for content in [one.to_string(), json!([one]).to_string(), format!("{one}\n{{\"broken\n")] {
        let r = alpamayo2::read("f.json", "stem", &content);
        assert_eq!(r.found.len(), 1, "{content}");
        assert_eq!(r.found[0].components, ["a truck ahead", "wet road"]);
        assert_eq!(r.left_out, [("ego_vehicle_motion_analysis".to_owned(), 1)].into());
    }
    assert_eq!(codes(&alpamayo2::read("f", "s", "{")), ["import.file.unreadable"]);
    assert_eq!(codes(&alpamayo2::read("f", "s", r#"{"cot": "x"}"#)), ["import.entry.invalid"]);
}

#[test]
fn lerobot_language_rows_are_one_text_and_tasks_fill_in() {
    let plan =
        json!({"role": "assistant", "content": "Wait for the cyclist.", "style": "plan", "timestamp": 1.5});
    let motion = json!({"role": "assistant", "content": "stop", "style": "motion", "timestamp": 1.5});
    let frame = |episode: i64, t: f64, language: Value| {
        row(
            json!({"episode_index": episode, "timestamp": t, "task_index": 3, "language_persistent": language}),
        )
    };
    let rows = [
        frame(0, 1.5, json!([plan, motion])),
        frame(0, 1.600000023841858, json!([plan, motion])),
        frame(1, 0.0, json!([])),
        frame(1, 0.1, json!([])),
    ];
    let tasks = [(3, "Turn left at the lights.".to_owned())].into();
    let r = lerobot::read("d", &rows, &tasks);
    let found: Vec<_> = r.found.iter().map(|f| (f.clip.as_str(), f.at_us, f.text.as_str())).collect();
    assert_eq!(
        found,
        [
            ("episode_000000", 1_500_000, "Wait for the cyclist."),
            ("episode_000001", 0, "Turn left at the lights.")
        ]
    );
    assert_eq!(r.left_out, [("language.style.motion".to_owned(), 1)].into());
}

#[test]
fn a_draft_is_at_the_nearest_frame_of_its_clip_and_no_decision_is_made_up() {
    let zero = Nanos(1_767_225_600_000_000_000);
    // 25 s, two frames before time 0.
    let times: Vec<Nanos> = (-2..250).map(|i| zero.plus_secs(f64::from(i) / 10.0)).collect();
    let class = ScenarioLabel { l1: "other".into(), l2: "other".into(), l3: None, full_id: None };
    let drive = DriveId::from("d");
    assert_eq!(time_zero(&times, None, zero), Some(zero));
    assert_eq!(time_zero(&times[5..], None, zero), Some(times[5]));
    let place = Place { drive: &drive, times: &times, zero, scenario: &class, by: "ood-reasoning" };
    let mut r = Reasoning {
        origin: "f#1".into(),
        clip: "d".into(),
        at_us: 20_040_000,
        until_us: None,
        text: "Yield.".into(),
        components: vec!["a van".into()],
        versions: BTreeMap::new(),
    };
    let label = draft(&r, &place).unwrap();
    // Frame 200 + 2: the second clip's third.
    assert_eq!((label.clip_id.as_str(), label.keyframe.frame_idx), ("d_001", 2));
    assert_eq!(label.keyframe.timestamp, zero.plus_secs(20.0));
    assert_eq!((label.time_range.start_frame_idx, label.time_range.end_frame_idx), (Some(0), Some(52)));
    assert_eq!(label.time_range.end_timestamp, zero.plus_secs(25.0));
    assert_eq!((label.driving_decision.longitudinal, label.driving_decision.lateral), (None, None));
    assert_eq!(label.provenance.as_ref().map(|p| p.source), Some(ProvenanceSource::Model));
    assert_eq!(label.critical_components[0].id.as_deref(), Some("c1"));
    for at_us in [25_200_000, -400_000, i64::MAX] {
        r.at_us = at_us;
        assert_eq!(draft(&r, &place).unwrap_err().code, "import.time.outside");
    }
}

#[test]
fn every_code_has_a_page() {
    let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/diagnostics");
    for code in CODES {
        assert!(docs.join(format!("{code}.md")).is_file(), "docs/diagnostics/{code}.md is missing");
    }
}
