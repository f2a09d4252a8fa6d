//! `whyroad mine` as a user runs it, on the bundled simulated drives. What must be found comes from the
//! simulator's own outputs (`examples/drives/*/truth.jsonl`, made by `truth.py`), never from our signals.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;
use tempfile::TempDir;
use whyroad_framework::Framework;

const DRIVES: [&str; 3] = ["back_street", "multilane", "signal_junction"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn whyroad(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_whyroad")).args(args).env_remove("WHYROAD_LANG").output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// A lake with the bundled drives.
fn lake() -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    for drive in DRIVES {
        let path = root().join("examples/drives").join(drive);
        let out =
            whyroad(&["ingest", "sumo", path.to_str().unwrap(), "--lake", dir.path().to_str().unwrap()]);
        assert!(out.status.success(), "{}", text(&out.stderr));
    }
    dir
}

/// One lake, mined with all rules.
static MINED: LazyLock<(TempDir, TempDir, Output)> = LazyLock::new(|| {
    let (lake, out) = (lake(), tempfile::tempdir().unwrap());
    let output = mine(lake.path(), out.path(), &[]);
    (lake, out, output)
});

fn mine(lake: &Path, out: &Path, more: &[&str]) -> Output {
    let mut args = vec!["mine", "--lake", lake.to_str().unwrap(), "--out", out.to_str().unwrap()];
    args.extend(more);
    whyroad(&args)
}

fn lines(path: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().map(|l| serde_json::from_str(l).unwrap()).collect()
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

struct Span {
    class: String,
    drive: String,
    target: Option<String>,
    start: i64,
    keyframe: i64,
    end: i64,
}

fn nanos(v: &Value) -> i64 {
    whyroad_model::Nanos::parse_iso(v.as_str().unwrap()).unwrap().0
}

fn found(out: &Path) -> Vec<Span> {
    let word = |v: &Value, key: &str| v[key].as_str().map(str::to_owned);
    lines(&out.join("episodes.jsonl"))
        .iter()
        .map(|v| Span {
            class: word(v, "scenario_id").unwrap(),
            drive: word(v, "drive_id").unwrap(),
            target: word(v, "target_id"),
            start: nanos(&v["time_range"]["start_timestamp"]),
            keyframe: nanos(&v["keyframe"]["timestamp"]),
            end: nanos(&v["time_range"]["end_timestamp"]),
        })
        .collect()
}

/// The matching of issue 4: same class and drive, same target where both name one, and keyframes within 1 s or
/// intervals with an IoU of 0.3.
fn same(truth: &Value, e: &Span) -> bool {
    let ns = |key: &str| truth[key].as_i64().unwrap();
    let target = truth["target_id"].as_str();
    let agree = truth["scenario_id"] == e.class.as_str()
        && truth["drive_id"] == e.drive.as_str()
        && target.zip(e.target.as_deref()).is_none_or(|(a, b)| a == b);
    let overlap = (ns("end_ns").min(e.end) - ns("start_ns").max(e.start)).max(0) as f64;
    let union = (ns("end_ns").max(e.end) - ns("start_ns").min(e.start)) as f64;
    agree && ((ns("keyframe_ns") - e.keyframe).abs() <= 1_000_000_000 || overlap / union >= 0.3)
}

#[test]
fn what_happened_in_the_simulator_is_found_and_nothing_else() {
    let (_, out, output) = &*MINED;
    assert!(output.status.success(), "{}", text(&output.stderr));
    let episodes = found(out.path());
    let mut used = vec![false; episodes.len()];
    let (mut missed, mut heads) = (Vec::new(), Vec::new());
    for drive in DRIVES {
        let truth = lines(&root().join("examples/drives").join(drive).join("truth.jsonl"));
        assert!(truth.len() > 1);
        for t in &truth[1..] {
            match (0..episodes.len()).find(|&i| !used[i] && same(t, &episodes[i])) {
                Some(i) => used[i] = true,
                None => missed.push(t.to_string()),
            }
        }
        heads.push(truth[0].clone());
    }
    assert!(missed.is_empty(), "missed:\n{}", missed.join("\n"));
    // Where the truth is complete, what is found beyond it is false.
    let complete = |e: &Span| {
        heads.iter().any(|h| {
            let has = |key: &str, word: &str| h[key].as_array().unwrap().iter().any(|v| v == word);
            has("complete", &e.class) && has("drives", &e.drive)
        })
    };
    let beyond = episodes.iter().zip(&used).filter(|(e, used)| !**used && complete(e)).map(|(e, _)| e);
    let beyond: Vec<String> =
        beyond.map(|e| format!("{} {} {:?} at {}", e.drive, e.class, e.target, e.keyframe)).collect();
    assert!(beyond.is_empty(), "false:\n{}", beyond.join("\n"));
}

#[test]
fn every_message_is_valid() {
    let (_, out, _) = &*MINED;
    let paths = ["mining_results", "pre_labels.jsonl", "keyframe_suggestions.jsonl", "clip_metadata.jsonl"];
    let paths: Vec<String> = paths.iter().map(|p| out.path().join(p).to_str().unwrap().to_owned()).collect();
    let mut args = vec!["validate"];
    args.extend(paths.iter().map(String::as_str));
    let checked = whyroad(&args);
    assert!(checked.status.success(), "{}", text(&checked.stdout));
    assert!(!text(&checked.stdout).contains("warning["), "{}", text(&checked.stdout));
}

#[test]
fn the_files_tell_one_story() {
    let (_, out, output) = &*MINED;
    let episodes = lines(&out.path().join("episodes.jsonl"));
    // What no class explains is for a person to classify: it gets no pre-label.
    let classified = episodes.iter().filter(|e| e["scenario_id"] != "other").count();
    assert_eq!(lines(&out.path().join("pre_labels.jsonl")).len(), classified);
    assert_eq!(lines(&out.path().join("keyframe_suggestions.jsonl")).len(), episodes.len());
    // Three drives of 48 to 64 s: three or four clips each.
    let clips = lines(&out.path().join("clip_metadata.jsonl"));
    assert!((9..=12).contains(&clips.len()), "{}", clips.len());
    let coverage = json(&out.path().join("coverage.json"));
    let leaves = coverage["leaves"].as_array().unwrap();
    assert_eq!(leaves.len(), Framework::bundled().taxonomy.leaves().count());
    let counted: u64 = leaves.iter().map(|l| l["episodes"].as_u64().unwrap()).sum();
    let unresolved = coverage["unresolved"].as_array().unwrap();
    let counted_above: u64 = unresolved.iter().map(|l| l["episodes"].as_u64().unwrap()).sum();
    assert_eq!(counted + counted_above, episodes.len() as u64);
    for e in &episodes {
        let clip = clips.iter().map(|c| &c["clip_metadata"]).find(|c| c["clip_id"] == e["clip_id"]).unwrap();
        let frames = clip["total_frames"].as_u64().unwrap();
        let frame = |v: &Value| v.as_u64().unwrap();
        let (range, key) = (&e["time_range"], frame(&e["keyframe"]["frame_idx"]));
        assert!(frame(&range["start_frame_idx"]) <= key && key < frame(&range["end_frame_idx"]), "{e}");
        assert!(frame(&range["end_frame_idx"]) <= frames, "{e}");
        if e["is_primary"] == false {
            let primary = episodes.iter().find(|p| p["episode_id"] == e["primary_episode_id"]).unwrap();
            assert_eq!(primary["is_primary"], true);
        }
    }
    let table = text(&output.stdout);
    assert!(table.contains("\ncutin.large_vehicle  "), "{table}");
    // A terminal shows all of it, and every line is read at once.
    assert!(table.lines().count() < 40 && table.lines().all(|l| l.chars().count() <= 120), "{table}");
}

#[test]
fn clips_can_be_cut_around_keyframes() {
    let (lake, fixed, _) = &*MINED;
    let out = tempfile::tempdir().unwrap();
    let o = mine(lake.path(), out.path(), &["--clips", "keyframe"]);
    assert!(o.status.success(), "{}", text(&o.stderr));
    let clips = lines(&out.path().join("clip_metadata.jsonl"));
    let clip = |id: &Value| clips.iter().map(|c| &c["clip_metadata"]).find(|c| c["clip_id"] == *id).unwrap();
    let episodes = lines(&out.path().join("episodes.jsonl"));
    let at = |e: &Value| nanos(&e["keyframe"]["timestamp"]);
    // The same moments, in other clips.
    let moments =
        |all: &[Value]| all.iter().map(|e| (e["scenario_id"].to_string(), at(e))).collect::<Vec<_>>();
    assert_eq!(moments(&episodes), moments(&lines(&fixed.path().join("episodes.jsonl"))));
    for e in &episodes {
        let c = clip(&e["clip_id"]);
        let (frames, key) =
            (c["total_frames"].as_i64().unwrap(), e["keyframe"]["frame_idx"].as_i64().unwrap());
        // 2 s before and 6 s after are in the clip, unless the drive (48 to 64 s at 10 Hz) ends there.
        assert_eq!(frames, 200, "{e}");
        let start = nanos(&c["capture_time"]);
        assert!((at(e) - start - key * 100_000_000).abs() < 50_000_000, "{e}");
        let first = clips.iter().map(|c| &c["clip_metadata"]).filter(|o| o["drive_id"] == c["drive_id"]);
        let (begin, end) = first.fold((i64::MAX, i64::MIN), |(a, b), o| {
            let start = nanos(&o["capture_time"]);
            (a.min(start), b.max(start + (o["duration_sec"].as_f64().unwrap() * 1e9) as i64))
        });
        assert!(key >= 20 || start == begin, "{e}");
        assert!(key < 140 || start + 20_000_000_000 >= end - 50_000_000, "{e}");
        // The pre-label is that of the primary episode.
        if e["is_primary"] == true && e["scenario_id"] != "other" {
            let of_clip = episodes.iter().filter(|o| o["clip_id"] == e["clip_id"] && o["is_primary"] == true);
            if of_clip.count() == 1 {
                let pre = &c["pre_labels"]["scenario"];
                let id: Vec<&str> = ["l1", "l2", "l3"].iter().filter_map(|k| pre[k].as_str()).collect();
                assert_eq!(id.join("."), e["scenario_id"].as_str().unwrap());
            }
        } else if e["is_primary"] == false {
            let primary = episodes.iter().find(|p| p["episode_id"] == e["primary_episode_id"]).unwrap();
            assert_eq!(primary["clip_id"], e["clip_id"]);
        }
    }
    // The clips of the division stay, without pre-labels, so that lengths add up; `explain` knows the others.
    let fixed_clips = lines(&fixed.path().join("clip_metadata.jsonl")).len();
    let (own, rest): (Vec<&Value>, Vec<&Value>) = clips
        .iter()
        .map(|c| &c["clip_metadata"])
        .partition(|c| c["clip_id"].as_str().unwrap().contains("_k"));
    assert_eq!(rest.len(), fixed_clips);
    assert!(!own.is_empty() && rest.iter().all(|c| c["pre_labels"].is_null()));
    let first = &episodes[0];
    let (class, clip) = (first["scenario_id"].as_str().unwrap(), first["clip_id"].as_str().unwrap());
    let o = whyroad(&["explain", class, "--lake", lake.path().to_str().unwrap(), "--clip", clip]);
    assert!(o.status.success() && text(&o.stdout).contains(clip), "{}", text(&o.stderr));
}

#[test]
fn one_thread_or_many_write_the_same_bytes() {
    let (lake, out, _) = &*MINED;
    let single = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_whyroad"))
        .args(["mine", "--lake", lake.path().to_str().unwrap(), "--out", single.path().to_str().unwrap()])
        .env("RAYON_NUM_THREADS", "1")
        .env_remove("WHYROAD_LANG")
        .output()
        .unwrap();
    assert!(output.status.success());
    for file in
        ["episodes.parquet", "episodes.jsonl", "clip_metadata.jsonl", "coverage.json", "pre_labels.jsonl"]
    {
        let read = |dir: &Path| std::fs::read(dir.join(file)).unwrap();
        assert_eq!(read(out.path()), read(single.path()), "{file}");
    }
}

/// DATA_FORMAT.md 5.1, as printed there.
const PRINTED: &str = r#"{
  "mining_query": {
    "scenario_id": "reactive_agent.cutin",
    "conditions": [
      { "field": "target_vehicle.lateral_offset", "operator": ">", "value": 0.5, "unit": "m" },
      { "field": "ttc", "operator": "<", "value": 5, "unit": "s" }
    ],
    "time_constraints": {
      "condition_duration_min": 0.5,
      "condition_duration_max": null
    },
    "output_limit": 1000
  }
}"#;

fn ask(query: &str) -> (Output, Option<Value>) {
    let (lake, ..) = &*MINED;
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("query.json");
    std::fs::write(&file, query).unwrap();
    let out = mine(lake.path(), &dir.path().join("out"), &["--query", file.to_str().unwrap()]);
    let result = dir.path().join("out/mining_result.json");
    let result = result.exists().then(|| json(&result)["mining_result"].clone());
    (out, result)
}

#[test]
fn a_query_with_a_byte_order_mark_is_the_same_query() {
    let (out, result) = ask(&format!("\u{feff}{PRINTED}"));
    assert!(out.status.success(), "{}", text(&out.stderr));
    assert_eq!(result, ask(PRINTED).1);
}

#[test]
fn the_printed_query_answers_with_measured_values() {
    let (out, result) = ask(PRINTED);
    assert!(out.status.success(), "{}", text(&out.stderr));
    let result = result.unwrap();
    // The lead of `signal_junction` stops in the ego's lane: over the line by 0.5 m and more, and approached. It does
    // not cut in: conditions choose among the episodes of the class (DATA_FORMAT.md 5.1).
    assert!(result["clips"].as_array().unwrap().iter().all(|c| c["target_id"] != "lead"), "{result:#}");
    // The cutter of `multilane` comes in 23 m ahead and 7 m/s slower: TTC 3.3 s. The simulated ego brakes so hard that
    // it is under 5 s for 0.3 s only.
    let shorter = ask(&PRINTED.replace("0.5,\n", "0.3,\n")).1.unwrap();
    let clips = shorter["clips"].as_array().unwrap();
    assert!(clips.iter().any(|c| c["target_id"] == "cutter"), "{shorter:#}");
    for clip in clips {
        let conditions = clip["conditions_matched"].as_array().unwrap();
        let names: Vec<_> = conditions.iter().map(|c| c["condition"].as_str().unwrap()).collect();
        assert_eq!(names, ["target_vehicle.lateral_offset > 0.5m", "ttc < 5s"]);
        assert!(conditions[0]["actual_value"].as_f64().unwrap() > 0.5);
        assert!(conditions[1]["actual_value"].as_f64().unwrap() < 5.0);
    }
    assert_eq!(scored(&shorter), clips.len() as u64);
}

/// How many clips the distribution of scores counts.
fn scored(result: &Value) -> u64 {
    let counts = result["statistics"]["score_distribution"].as_object().unwrap();
    counts.values().map(|v| v.as_u64().unwrap()).sum()
}

#[test]
fn the_values_of_a_query_are_those_at_the_keyframe() {
    // The gap is always known and less than 1 km: the condition holds at every keyframe of car following.
    let query = r#"{ "mining_query": { "scenario_id": "reactive_agent.following", "conditions": [
        { "field": "target.gap", "operator": "<", "value": 1000, "unit": "m" },
        { "rule": "not (ego.in_junction == true)" } ] } }"#;
    let (out, result) = ask(query);
    let (shown, result) = (text(&out.stdout), result.unwrap());
    assert!(shown.contains("Gap to the target < 1000 m ("), "{shown}");
    assert!(shown.contains("; Not: the ego is in a junction\n"), "{shown}");
    let lake = whyroad_lake::Lake::open(MINED.0.path()).unwrap();
    let clips = result["clips"].as_array().unwrap();
    let mut later = 0;
    for clip in clips {
        let id = whyroad_model::ClipId(clip["clip_id"].as_str().unwrap().to_owned());
        let drive = whyroad_model::DriveId(id.0.rsplit_once('_').unwrap().0.to_owned());
        let table = whyroad_engine::drives::signals_of(&lake, &drive).unwrap();
        let start = id.frames(&drive, &table.times).unwrap().start;
        let keyframe = clip["keyframe_suggestion"]["frame_idx"].as_u64().unwrap() as usize;
        let span = table.targets.iter().find(|t| clip["target_id"] == t.id.as_str()).unwrap();
        let row = span.first_row + start + keyframe - span.frames.start;
        let gap = table.target_columns["target.gap"].number(row).unwrap();
        let actual = clip["conditions_matched"][0]["actual_value"].as_f64().unwrap();
        assert!((actual - gap).abs() < 1e-4, "{actual} and not {gap}: {clip:#}");
        later += usize::from(keyframe > 0);
    }
    assert!(later > 0, "no keyframe after the start of a clip: {clips:#?}");
}

#[test]
fn the_limit_keeps_the_best_and_the_total() {
    // Without conditions the whole class is asked for: three cut-ins.
    let mut query: Value = serde_json::from_str(PRINTED).unwrap();
    query["mining_query"]["conditions"] = serde_json::json!([]);
    query["mining_query"].as_object_mut().unwrap().remove("time_constraints");
    let all = ask(&query.to_string()).1.unwrap();
    assert!(all["returned"].as_u64() > Some(1), "{all:#}");
    query["mining_query"]["output_limit"] = serde_json::json!(1);
    let one = ask(&query.to_string()).1.unwrap();
    assert_eq!(one["total_matched"], all["total_matched"]);
    assert_eq!((one["returned"].as_u64(), one["clips"].as_array().unwrap().len()), (Some(1), 1));
    assert_eq!(one["clips"][0], all["clips"][0]);
    let scores: Vec<f64> =
        all["clips"].as_array().unwrap().iter().map(|c| c["match_score"].as_f64().unwrap()).collect();
    assert!(scores.is_sorted_by(|a, b| a >= b), "{scores:?}");
    // The distribution counts what was returned (DATA_FORMAT.md 5.2).
    assert_eq!((scored(&one), scored(&all)), (1, scores.len() as u64));
}

#[test]
fn durations_bound_the_matches() {
    let with = |min: &str, max: &str| {
        let text = PRINTED.replace("0.5,\n", &format!("{min},\n")).replace("null", max);
        ask(&text).1.unwrap()["total_matched"].as_u64().unwrap()
    };
    let any = with("null", "null");
    let (short, long) = (with("null", "0.95"), with("1.05", "null"));
    assert!(any > 0 && short + long <= any);
    assert_eq!(with("1000", "null"), 0);
}

#[test]
fn a_wrong_query_is_refused() {
    for (from, to, code) in [
        ("lateral_offset", "lateral_ofset", "rule.signal.unknown"),
        ("reactive_agent.cutin", "reactive_agent.cutn", "mine.query.scenario"),
        ("\"unit\": \"s\"", "\"unit\": \"m\"", "rule.unit.mismatch"),
        ("{\n  \"mining_query\"", "{\n  mining_query", "mine.query.syntax"),
    ] {
        let (out, result) = ask(&PRINTED.replacen(from, to, 1));
        assert_eq!(out.status.code(), Some(1));
        assert!(text(&out.stderr).contains(code), "{}", text(&out.stderr));
        assert!(result.is_none());
    }
}

#[test]
fn one_class_can_be_asked_for() {
    let (lake, everything, _) = &*MINED;
    let out = tempfile::tempdir().unwrap();
    let output = mine(lake.path(), out.path(), &["--scenario", "cutin"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let result = &json(&out.path().join("mining_result.json"))["mining_result"];
    assert_eq!(result["scenario_id"], "reactive_agent.cutin");
    let ours = lines(&out.path().join("episodes.jsonl"));
    let all = lines(&everything.path().join("episodes.jsonl"));
    let cutins: Vec<_> =
        all.into_iter().filter(|e| e["scenario_id"].as_str().unwrap().contains(".cutin")).collect();
    assert_eq!(ours, cutins, "asking for less changes nothing in what is found");
    // All rules were run: what is known of other classes is reported as it is, not as "nothing found".
    assert_eq!(json(&out.path().join("coverage.json")), json(&everything.path().join("coverage.json")));
    let unknown = mine(lake.path(), out.path(), &["--scenario", "cutn"]);
    assert_eq!(unknown.status.code(), Some(1));
    assert!(text(&unknown.stderr).contains("reactive_agent.cutin"), "{}", text(&unknown.stderr));
}

/// Only `signal_junction` has lights (examples/drives/README.md).
#[test]
fn what_is_missing_is_said_with_the_drives_that_lack_it() {
    let (lake, _, _) = &*MINED;
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let list = |name: &str| at(name).to_str().unwrap().to_owned();
    let run = |out: &str, more: &[&str]| {
        let o = mine(lake.path(), &at(out), &[&["--scenario", "traffic_light"], more].concat());
        assert!(o.status.success(), "{}", text(&o.stderr));
        // Without the breaks of long lines.
        text(&o.stdout).replace("\n    ", " ")
    };
    let shown = run("a", &["--missing", "--missing-list", &list("list.csv")]);
    let coverage = json(&at("a/coverage.json"));
    let dark: Vec<&str> = coverage["drives"]
        .as_array()
        .unwrap()
        .iter()
        .map(|d| d.as_str().unwrap())
        .filter(|d| !d.starts_with("signal_junction"))
        .collect();
    assert_eq!(dark.len(), 2, "{coverage:#}");
    let named = format!("2 drives ({})", dark.join(", "));
    let line = shown.lines().find(|l| l.starts_with(&format!("  {named}: "))).unwrap();
    assert!(line.contains("traffic lights ("), "{shown}");
    assert!(shown.contains("traffic_light.red_stop: 1 of 3 drives searched\n"), "{shown}");
    assert!(
        shown.contains(&format!(
            "  {named}: missing distance to the light's stop line (light.distance_to_stop_line), state of the \
             light (light.state)\n"
        )),
        "{shown}"
    );
    // Every drive of every gap is a line; the same as JSON.
    let classes = coverage["leaves"].as_array().unwrap().iter();
    let of_light = classes.filter(|l| l["scenario_id"].as_str().unwrap().contains(".traffic_light."));
    let gaps = of_light.flat_map(|l| l["gaps"].as_array().cloned().unwrap_or_default());
    let rows: usize = gaps.map(|g| g["drives"].as_array().unwrap().len()).sum();
    let csv = std::fs::read_to_string(at("list.csv")).unwrap();
    assert_eq!(csv.lines().count(), rows + 1, "{csv}");
    let red = format!(
        "{},reactive_rule.traffic_light.red_stop,light.distance_to_stop_line; light.state,traffic lights",
        dark[0]
    );
    assert!(csv.lines().any(|l| l == red), "{csv}");
    let zh = run("b", &["--missing", "--missing-list", &list("list.json"), "--lang", "zh"]);
    let line = zh.lines().find(|l| l.starts_with(&format!("  2 个行程（{}）：", dark.join(", ")))).unwrap();
    assert!(line.contains("交通信号灯（") && zh.contains("信号灯状态（light.state）"), "{zh}");
    assert_eq!(json(&at("list.json")).as_array().unwrap().len(), rows);
    let o = mine(lake.path(), &at("c"), &["--missing-list", "list.txt"]);
    assert_eq!(o.status.code(), Some(2), "{}", text(&o.stderr));
}

#[test]
fn a_class_whose_rules_are_taken_out_has_no_rule() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in Framework::bundled_files() {
        let path = folder.path().join(&name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        // Each `mining:` block ends at the next line with the same or less indentation.
        let mut block = None;
        let indent = |l: &str| l.len() - l.trim_start().len();
        let kept = text.lines().filter(|l| {
            if block.is_some_and(|b| !l.trim().is_empty() && indent(l) <= b) {
                block = None;
            }
            if name.ends_with("/animal.yaml") && l.trim() == "mining:" {
                block = Some(indent(l));
            }
            block.is_none()
        });
        std::fs::write(path, kept.collect::<Vec<_>>().join("\n")).unwrap();
    }
    let (lake, _, _) = &*MINED;
    let out = tempfile::tempdir().unwrap();
    let framework = folder.path().to_str().unwrap();
    let args = ["--scenario", "reactive_agent.animal", "--framework", framework];
    let without = mine(lake.path(), out.path(), &args);
    assert!(text(&without.stderr).contains("mine.scenario.no_rule"), "{}", text(&without.stderr));
}

#[test]
fn a_damaged_drive_does_not_stop_the_others() {
    let (lake, out) = (lake(), tempfile::tempdir().unwrap());
    let table = lake.path().join("drives/multilane-ego/tracks.parquet");
    let bytes = std::fs::read(&table).unwrap();
    std::fs::write(&table, &bytes[..bytes.len() / 2]).unwrap();
    let output = mine(lake.path(), out.path(), &[]);
    assert_eq!(output.status.code(), Some(3));
    let said = text(&output.stderr);
    assert!(said.contains("mine.drive.unreadable") && said.contains("multilane-ego"), "{said}");
    let drives: std::collections::BTreeSet<_> = found(out.path()).into_iter().map(|e| e.drive).collect();
    assert_eq!(drives.into_iter().collect::<Vec<_>>(), ["back_street-ego", "signal_junction-ego"]);
}

/// A framework whose `cutin.yaml` has a colon too few, and whose `animal.yaml` is in another encoding.
fn faulty_framework() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in Framework::bundled_files() {
        let path = folder.path().join(&name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        if name.ends_with("/cutin.yaml") {
            std::fs::write(path, text.replacen("leaves:", "leaves", 1)).unwrap();
        } else if name.ends_with("/animal.yaml") {
            // "动物" in GB18030.
            std::fs::write(path, [text.as_bytes(), &b"# \xB6\xAF\xCE\xEF\n"[..]].concat()).unwrap();
        } else {
            std::fs::write(path, text).unwrap();
        }
    }
    folder
}

/// The number before `word` in a line of totals.
pub(crate) fn number_before(line: &str, word: &str) -> u64 {
    let before = line.split(word).next().unwrap().trim_end();
    before
        .rsplit(|c: char| !c.is_ascii_digit())
        .next()
        .unwrap()
        .parse()
        .unwrap_or_else(|_| panic!("{word}: {line}"))
}

#[test]
fn leaves_with_a_faulty_rule_are_counted_as_such_and_nothing_else_is_lost() {
    let framework = faulty_framework();
    let (lake, _, _) = &*MINED;
    let out = tempfile::tempdir().unwrap();
    let run = mine(lake.path(), out.path(), &["--framework", framework.path().to_str().unwrap()]);
    assert_eq!(run.status.code(), Some(1));
    let said = text(&run.stderr);
    assert!(said.contains("error[spec.yaml]") && said.contains("error[framework.encoding]"), "{said}");
    assert!(said.contains("animal.yaml:") && !said.contains("spec.file.missing"), "{said}");
    let shown = text(&run.stdout).replace("\n  ", " ");
    let totals = shown.lines().find(|l| l.contains("leaves: ")).unwrap().split("leaves: ").nth(1).unwrap();
    let taxonomy = &Framework::bundled().taxonomy;
    let words = [" found,", " searched and not found", " not observable", " without a rule"];
    let sum: u64 = words.iter().map(|w| number_before(totals, w)).sum();
    assert_eq!(sum as usize, taxonomy.leaves().count(), "{totals}");
    // Counted in the taxonomy, not by the miner: the leaves of the two files.
    let lost = taxonomy.leaves().filter(|(_, l2, _)| ["cutin", "animal"].contains(&l2.id.as_str())).count();
    assert_eq!(number_before(totals, " without a rule") as usize, lost, "{totals}");
    assert!(totals.contains(&format!("({lost} of them with a faulty rule: ")), "{totals}");
    let coverage = json(&out.path().join("coverage.json"));
    let states = coverage["leaves"].as_array().unwrap().iter().filter(|l| l["state"] == "no_rule");
    assert_eq!(states.count(), lost);
    assert!(found(out.path()).iter().any(|e| !e.class.contains("cutin")), "the other rules were run");
}

#[test]
fn the_rows_of_a_class_add_up_to_its_total() {
    let (lake, everything, _) = &*MINED;
    let all = found(everything.path());
    let class = all.iter().map(|e| &e.class).find(|c| c.matches('.').count() == 2).unwrap();
    let out = tempfile::tempdir().unwrap();
    let run = mine(lake.path(), out.path(), &["--scenario", class, "--format", "json"]);
    let result: Value = serde_json::from_slice(&run.stdout).unwrap();
    let rows: u64 =
        result["classes"].as_array().unwrap().iter().map(|c| c["episodes"].as_u64().unwrap()).sum();
    let counted = all.iter().filter(|e| e.class == *class).count() as u64;
    assert_eq!((rows, result["episodes"].as_u64()), (counted, Some(counted)), "{result:#}");
}

#[test]
fn folders_with_different_questions_are_compared_where_both_asked() {
    let (lake, everything, _) = &*MINED;
    let out = tempfile::tempdir().unwrap();
    mine(lake.path(), out.path(), &["--scenario", "cutin"]);
    let [all, some] = [everything.path(), out.path()].map(|p| p.to_str().unwrap());
    let run = whyroad(&["compare", all, some, "--format", "json"]);
    assert!(run.status.success(), "{}", text(&run.stderr));
    let result: Value = serde_json::from_slice(&run.stdout).unwrap();
    let cutins = found(out.path()).len();
    assert_eq!(result["unchanged"], cutins);
    assert_eq!(result["classes_of_both"]["compared"], serde_json::json!(["reactive_agent.cutin"]));
    assert_eq!(result["classes_of_both"]["left_out_before"], found(everything.path()).len() - cutins);
    for (lang, words) in [("en", "different classes"), ("zh", "查询的类别不同")] {
        let said = text(&whyroad(&["--lang", lang, "compare", all, some]).stdout);
        assert!(said.contains(words) && said.contains("reactive_agent.cutin"), "{said}");
    }
}

#[test]
fn an_empty_lake_and_no_lake() {
    let (dir, out) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    assert_eq!(mine(dir.path(), out.path(), &[]).status.code(), Some(1));
    whyroad_lake::Lake::create_or_open(dir.path()).unwrap();
    let output = mine(dir.path(), out.path(), &[]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(lines(&out.path().join("episodes.jsonl")).is_empty());
}
