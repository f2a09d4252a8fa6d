//! `whyroad other` as a miner runs it, on simulated drives of the repository: groups, nearest classes, page, tasks.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn whyroad(args: &[&str]) -> Output {
    let o = Command::new(env!("CARGO_BIN_EXE_whyroad"))
        .args(args)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .env_remove("WHYROAD_FRAMEWORK")
        .env_remove("WHYROAD_LANG")
        .output()
        .unwrap();
    assert!(matches!(o.status.code(), Some(0 | 1)), "{args:?}: {}", String::from_utf8_lossy(&o.stderr));
    o
}

/// A framework without the class that explains the lane changes of the drive.
fn without_following(dir: &Path) {
    for (name, mut text) in whyroad_framework::Framework::bundled_files() {
        if name == "scenarios/reactive_agent/following.yaml" {
            // Its rules are asked for something that never is.
            text = text.replace("when: \"", "when: \"ego.time_standing > 99999 s and ");
        }
        let path = dir.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
}

#[test]
fn what_no_class_explains_is_grouped_and_proposed() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let (lake, mined, page) = (at("lake"), at("mined"), at("other.html"));
    for drive in ["examples/drives/multilane", "examples/drives/signal_junction"] {
        whyroad(&["ingest", "sumo", "--lake", &lake, drive]);
    }
    let framework = at("framework");
    without_following(Path::new(&framework));
    whyroad(&["mine", "--framework", &framework, "--lake", &lake, "--out", &mined]);
    let ask = ["other", "--framework", &framework, "--episodes", &mined, "--lake", &lake];
    let o = whyroad(&[&ask[..], &["--format", "json", "--page", &page]].concat());
    let found: Value = serde_json::from_slice(&o.stdout).unwrap();
    let groups = found["groups"].as_array().unwrap();
    assert!(!groups.is_empty(), "{found:#}");
    let episodes = std::fs::read_to_string(Path::new(&mined).join("episodes.jsonl")).unwrap();
    let others = episodes.lines().filter(|l| l.contains("\"scenario_id\":\"other\"")).count();
    assert_eq!(found["moments"], others);
    let grouped: usize = groups.iter().map(|g| g["episode_ids"].as_array().unwrap().len()).sum();
    assert_eq!(grouped, others, "each moment is in one group");
    for g in groups {
        let nearest = g["example"]["nearest"].as_array().unwrap();
        assert!((1..=5).contains(&nearest.len()), "{g:#}");
        for c in nearest {
            let (held, all) = (c["held"].as_u64().unwrap(), c["conditions"].as_u64().unwrap());
            let failed = c["failed"].as_u64().unwrap();
            assert!(
                held + failed <= all && (failed > 0) != c["unmet"].as_array().unwrap().is_empty(),
                "{c:#}"
            );
            assert!(held <= all && (held == all) <= c["unmet"].as_array().unwrap().is_empty(), "{c:#}");
        }
    }
    // The same moments by `explain other`, clip by clip.
    let line = episodes.lines().find(|l| l.contains("\"scenario_id\":\"other\"")).unwrap();
    let episode: Value = serde_json::from_str(line).unwrap();
    let clip = episode["clip_id"].as_str().unwrap();
    let of_clip = episodes.lines().filter(|l| {
        let e: Value = serde_json::from_str(l).unwrap();
        e["scenario_id"] == "other" && e["clip_id"] == clip
    });
    let explain = ["explain", "other", "--framework", &framework, "--lake", &lake, "--clip", clip];
    let json: Value =
        serde_json::from_slice(&whyroad(&[&explain[..], &["--format", "json"]].concat()).stdout).unwrap();
    let unexplained = json["moments"]["unexplained"].as_array().unwrap();
    let keyframes: Vec<&Value> = unexplained.iter().map(|m| &m["keyframe"]).collect();
    let expected: Vec<Value> =
        of_clip.map(|l| serde_json::from_str::<Value>(l).unwrap()["keyframe"]["timestamp"].clone()).collect();
    assert_eq!(keyframes, expected.iter().collect::<Vec<_>>());
    // The headline names the moments that are left to it, and the first is the one that is explained.
    let times: Vec<String> =
        unexplained.iter().map(|m| format!("{:.1} s", m["clip_s"].as_f64().unwrap())).collect();
    assert_eq!(format!("{:.1} s", json["seconds"].as_f64().unwrap()), times[0]);
    let shown = String::from_utf8(whyroad(&explain).stdout).unwrap();
    let head = shown.lines().next().unwrap();
    assert!(head.contains(&format!("that no class explains: {}", times.join(", "))), "{head}");
    for (lang, words) in [("en", "Moments that no class explains: "), ("zh", "没有类别能解释的时刻：")]
    {
        let shown = String::from_utf8(whyroad(&[&explain[..], &["--lang", lang]].concat()).stdout).unwrap();
        let near = unexplained[0]["nearest"][0]["scenario_id"].as_str().unwrap();
        assert!(shown.contains(words) && shown.contains(&format!("({near})")), "{shown}");
    }
    let html = std::fs::read_to_string(&page).unwrap();
    assert_eq!(html.matches("<svg").count(), groups.len(), "a scene for each group");
    // The same again; and a task for each group, once.
    let again = whyroad(&[&ask[..], &["--format", "json"]].concat());
    assert_eq!(again.stdout, o.stdout);
    let data = at("data");
    let to_tasks = [&ask[..], &["--to-tasks", "open", "--data", &data]].concat();
    let made = String::from_utf8(whyroad(&to_tasks).stderr).unwrap();
    assert!(made.contains(&format!("{} tasks created", groups.len())), "{made}");
    let made = String::from_utf8(whyroad(&to_tasks).stderr).unwrap();
    assert!(made.contains(&format!("0 tasks created; {} already present", groups.len())), "{made}");
}

#[test]
fn a_value_that_an_option_cannot_have_is_refused_in_the_language_that_is_asked_for() {
    let place = ["other", "--lake", "l", "--episodes", "m", "--similarity", "2"];
    for (lang, expected) in [
        ("zh", "错误：'--similarity <SHARE>' 的值 '2' 无效：应在 0 与 1 之间"),
        ("en", "error: invalid value '2' for '--similarity <SHARE>': must be between 0 and 1"),
    ] {
        let o =
            Command::new(env!("CARGO_BIN_EXE_whyroad")).args(place).args(["--lang", lang]).output().unwrap();
        let err = String::from_utf8_lossy(&o.stderr);
        assert!(o.status.code() == Some(2) && err.contains(expected), "{err}");
    }
}
