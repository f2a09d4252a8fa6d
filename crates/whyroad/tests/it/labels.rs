//! `whyroad labels import` as a user runs it: drives of the PhysicalAI-AV fixture, texts of four tools, drafts in a
//! store.
#![allow(clippy::unwrap_used)] // in a test a panic is the report

use crate::session::{Run, whyroad_in};
use serde_json::Value;
use std::fs;
use std::path::Path;

const CLIP: &str = "00000001-0000-4000-8000-000000000001";
const SECOND: &str = "00000002-0000-4000-8000-000000000002";

fn run(folder: &Path, line: &str) -> Run {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().display().to_string();
    whyroad_in(folder, &line.replace("CRATES", &crates).split(' ').collect::<Vec<_>>())
}

fn drafts(folder: &Path) -> Vec<Value> {
    let text = fs::read_to_string(folder.join("drafts.jsonl")).unwrap();
    text.lines().map(|l| serde_json::from_str(l).unwrap()).collect()
}

#[test]
fn causal_texts_of_four_tools_become_drafts_that_tasks_take() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    let ingest = run(at, "ingest pai CRATES/whyroad-ingest/tests/fixtures/pai/tree --lake lake");
    // One row of the fixture is in a frame that nobody knows: something was lost.
    assert_eq!(ingest.code, 3, "{}{}", ingest.out, ingest.err);

    let texts = "CRATES/whyroad/tests/fixtures/labels";
    let ood = run(at, &format!("labels import ood-reasoning {texts} --lake lake --out drafts.jsonl"));
    assert_eq!(
        (ood.code, ood.out.as_str()),
        (3, "4 causal texts read; 2 drafts written; 2 errors\n"),
        "{}",
        ood.err
    );
    for said in ["import.time.outside", "import.drive.unknown", "`event_cluster`", "`split`"] {
        assert!(ood.err.contains(said), "{said}: {}", ood.err);
    }
    let labels = drafts(at);
    assert_eq!(labels[1]["coc_trace"], "Yield because a person enters the lane.");
    assert_eq!(labels[1]["clip_id"], format!("{CLIP}_000"));
    // Two frames of the drive are before the clip's time 0.
    assert_eq!(labels[1]["keyframe"]["frame_idx"], 32);
    assert_eq!(labels[1]["keyframe"]["timestamp"], "2026-01-01T00:00:03.000Z");
    assert!(labels[1]["driving_decision"]["longitudinal"].is_null());
    assert_eq!(labels[1]["provenance"]["source"], "model");
    let tasks = run(at, "tasks import drafts.jsonl --project p --lake lake --data store");
    assert_eq!(
        (tasks.code, tasks.out.as_str()),
        (0, "2 tasks created; 0 already present; 0 lines not readable\n"),
        "{}",
        tasks.err
    );

    fs::create_dir_all(at.join("run").join(CLIP)).unwrap();
    fs::create_dir_all(at.join("run/final_outputs")).unwrap();
    let yaml = "results:\n  event_start_timestamp: 1500000\n  coc_prompt_version: v2\n  final_content:\n    ego_behavior_schema:\n      \
                effect_on_ego_behavior: Slow down because of the truck.\n";
    fs::write(at.join("run").join(CLIP).join("cot_1500000.yaml"), yaml).unwrap();
    let action = "GentleDeceleration - Agent:<ego>, Start:0, End:35\n";
    fs::write(at.join("run/final_outputs").join(format!("{CLIP}.txt")), action).unwrap();
    let auto = run(
        at,
        "labels import auto-labeler run --scenario cutin.urgent --by teacher --lake lake --out drafts.jsonl",
    );
    assert_eq!(
        (auto.code, auto.out.as_str()),
        (0, "1 causal text read; 1 draft written; 0 errors\n"),
        "{}",
        auto.err
    );
    assert!(auto.err.contains("meta_action.GentleDeceleration"), "{}", auto.err);
    let label = &drafts(at)[0];
    assert_eq!(label["scenario"]["full_id"], "reactive_agent.cutin.urgent");
    assert_eq!(
        (&label["provenance"]["by"], &label["provenance"]["versions"]["coc_prompt_version"]),
        (&"teacher".into(), &"v2".into())
    );

    let json = format!(
        r#"[{{"clip_id": "{SECOND}", "t0_us": 700000, "chain_of_causation": "Go on.", "critical_components_analysis": "free road"}}]"#
    );
    fs::write(at.join("a2.json"), json).unwrap();
    let two = run(at, "labels import alpamayo2 a2.json --lake lake --out drafts.jsonl");
    assert_eq!(two.code, 0, "{}", two.err);
    assert_eq!(drafts(at)[0]["critical_components"][0]["description"], "free road");

    fs::write(at.join("drives.csv"), format!("clip,drive\nepisode_000000,{CLIP}\nepisode_000001,{SECOND}\n"))
        .unwrap();
    let robot = run(
        at,
        &format!("labels import lerobot {texts}/lerobot --drives drives.csv --lake lake --out drafts.jsonl"),
    );
    assert_eq!(robot.code, 0, "{}", robot.err);
    assert!(robot.err.contains("language.style.motion"), "{}", robot.err);
    let traces: Vec<_> = drafts(at).iter().map(|l| l["coc_trace"].as_str().unwrap().to_owned()).collect();
    assert_eq!(traces, ["Stop because the light is red.", "Turn left at the lights."]);
}
