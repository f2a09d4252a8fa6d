//! A rule about any object, its result in the form of the Argoverse 2 scenario-mining challenge, against the official
//! truth of the prompt "stopped car" on a recorded log. Without the recordings the test says so and passes.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may panic, and says when it is skipped")]

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

const LOG: &str = "3bffdcff-c3a7-38b6-a0f2-64196d130958";

fn data() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let data = std::env::var_os("WHYROAD_DATA").map_or(beside, PathBuf::from);
    data.join("av2/scenario_mining_truth_3bffdcff.jsonl").is_file().then_some(data)
}

fn whyroad(args: &[&str]) -> Vec<u8> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whyroad"));
    let output =
        command.args(args).env_remove("WHYROAD_FRAMEWORK").env_remove("WHYROAD_LANG").output().unwrap();
    // 1: there are findings about the log, which is fine here.
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(matches!(output.status.code(), Some(0 | 1)), "{args:?}: {said}");
    output.stdout
}

#[test]
fn a_stopped_car_is_what_the_challenge_calls_so() {
    let Some(data) = data() else {
        crate::require::skipped("recorded", "no recorded data");
        return;
    };
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let (lake, found) = (at("lake"), at("found.jsonl"));
    let log = data.join("av2/sensor_logs").join(LOG);
    whyroad(&["ingest", "--lake", &lake, log.to_str().unwrap()]);
    let mine = |out: &str, file: &str| {
        // The truth refers to a car that ever stops in all its frames; the log is shorter than 100 s.
        let stops = "object.speed < 0.5 m/s";
        let rule = format!("(({stops} within 100 s) or previously({stops}, 100 s)) and not object.is_ego");
        let asked = ["mine", "--lake", &lake, "--target", "car", "--rule", &rule, "--prompt", "stopped car"];
        whyroad(&[&asked[..], &["--out", &at(out), "--sequences", file]].concat());
    };
    mine("mined", &found);
    let truth = data.join("av2/scenario_mining_truth_3bffdcff.jsonl");
    let metric = ["evaluate", "--metric", "av2-scenario-mining", "--format", "json", "--predictions", &found];
    let scores = whyroad(&[&metric[..], &["--truth", truth.to_str().unwrap()]].concat());
    let scores: Value = serde_json::from_slice(&scores).unwrap();
    let of = |name: &str| scores["prompts"]["stopped car"][name].as_f64().unwrap();
    println!("HOTA-Temporal {:.3}, HOTA-Track {:.3}", of("hota_temporal"), of("hota_track"));
    // 0.943: nothing false; three cars that the truth refers to are never slower than 0.5 m/s.
    assert!(of("hota_temporal") > 0.94, "{scores}");
    assert!(of("hota_track") > 0.94, "{scores}");
    assert_eq!(of("timestamp_balanced_accuracy"), 1.0);

    // The same for the challenge's evaluator: a pickle of NumPy arrays, and nothing that runs code.
    let pickle = at("found.pkl");
    mine("again", &pickle);
    let bytes = std::fs::read(&pickle).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    for part in [LOG, "stopped car", "ego_translation_m", "REFERRED_OBJECT"] {
        let plain = text.contains(part);
        let wide: Vec<u8> = part.chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
        assert!(plain || bytes.windows(wide.len()).any(|w| w == wide), "{part}");
    }
    let named: std::collections::BTreeSet<&str> =
        text.split("cnumpy\n").skip(1).filter_map(|rest| rest.split('\n').next()).collect();
    assert!(named.iter().all(|f| ["array", "reshape", "frombuffer", "zeros"].contains(f)), "{named:?}");
}
