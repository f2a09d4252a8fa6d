//! `whyroad rules check`, `mine --rule` and `explain` as a user runs them, on the bundled simulated drives. That the
//! cut-in at 16.9 s is one is told by the simulator (`examples/drives/multilane/truth.jsonl`).
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::session::{Run, root, whyroad_in};
use std::path::Path;
use tempfile::TempDir;

const BROKEN: &str = "\
version: \"2.0.0\"
l1: reactive_agent
l2: animal
mining:
  roles: { animal: any, ego: vehicle, third: vru }
  parameters:
    near: { value: 20 m, reason: \"as far as it matters\" }
  define:
    close: \"animal.gap < nearr\"
  when:
    - \"close for 1 s gaps 2 m\"
    - \"ego.speed > 5 m/s until ego.standstill since ego.brake\"
    - \"least(target.ttc) < 2 s\"
  require: [\"count(target.gap < 5 m) > 1.5\"]
leaves: { crossing: {}, on_road: {} }
";

fn told(run: &Run) -> String {
    format!("exit code {}\n--- stdout\n{}\n--- stderr\n{}", run.code, run.out, run.err)
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn a_broken_file_is_told_all_that_is_wrong_with_it() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("animal.yaml"), BROKEN).unwrap();
    insta::assert_snapshot!(told(&whyroad_in(dir.path(), &["rules", "check", "animal.yaml"])));
    insta::assert_snapshot!(told(&whyroad_in(
        dir.path(),
        &["--lang", "zh", "rules", "check", "animal.yaml"]
    )));
    let json = whyroad_in(dir.path(), &["rules", "check", "animal.yaml", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&json.out).unwrap();
    let codes: Vec<&str> =
        json["diagnostics"].as_array().unwrap().iter().map(|d| d["code"].as_str().unwrap()).collect();
    // By hand: roles ego and third, nearr, `gaps 2 m`, until with since, least in `when`, a count of 1.5.
    assert_eq!(codes.iter().filter(|c| c.starts_with("rule.")).count(), 7, "{codes:?}");
}

#[test]
fn a_sound_file_is_run_with_the_cases_beside_it() {
    let run = whyroad_in(&root(), &["rules", "check", "scenarios/reactive_agent/cutin.yaml"]);
    assert_eq!((run.code, run.out.as_str()), (0, ""), "{}", run.err);
    assert!(run.err.contains("scenarios/reactive_agent/cutin.yaml: "), "{}", run.err);
    // The same file with a threshold moved: some case beside it must notice.
    let dir = tempfile::tempdir().unwrap();
    let folder = root().join("scenarios/reactive_agent");
    let rules = std::fs::read_to_string(folder.join("cutin.yaml")).unwrap();
    assert!(rules.contains("urgent_ttc: { value: 3 s"));
    let moved = rules.replace("urgent_ttc: { value: 3 s", "urgent_ttc: { value: 1 s");
    std::fs::write(dir.path().join("cutin.yaml"), moved).unwrap();
    std::fs::copy(folder.join("cutin.cases.yaml"), dir.path().join("cutin.cases.yaml")).unwrap();
    let run = whyroad_in(dir.path(), &["rules", "check", "cutin.yaml"]);
    assert!(
        run.code == 1 && run.out.contains("error[rule.case]") && run.out.contains("cutin.cases.yaml:"),
        "{}",
        run.out
    );
}

#[test]
fn a_bare_rule_is_checked() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("mine.yaml"), "target: vehicle\nwhen: \"target.gap < 10 m for 1 s\"\n")
        .unwrap();
    let run = whyroad_in(dir.path(), &["rules", "check", "mine.yaml"]);
    assert_eq!((run.code, run.out.as_str()), (0, ""), "{}", run.err);
}

/// A lake with the drive on the multilane road.
fn lake() -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    let run =
        whyroad_in(&root(), &["ingest", "sumo", "examples/drives/multilane", "--lake", text(dir.path())]);
    assert_eq!(run.code, 0, "{}", run.err);
    dir
}

#[test]
fn explain_shows_a_match_and_the_nearest_miss() {
    let lake = lake();
    let explain = |more: &[&str]| {
        let mut args = vec!["explain", "cutin.urgent", "--lake", text(lake.path())];
        args.extend(more);
        whyroad_in(&root(), &args)
    };
    insta::assert_snapshot!(told(&explain(&["--clip", "multilane-ego_000"])));
    insta::assert_snapshot!(told(&explain(&["--clip", "multilane-ego_001"])));
    insta::assert_snapshot!(told(&explain(&["--clip", "multilane-ego_001", "--lang", "zh"])));
    let picture = lake.path().join("why.svg");
    let run = explain(&["--clip", "multilane-ego_000", "--target", "cutter", "--svg", text(&picture)]);
    assert_eq!(run.code, 0, "{}", run.err);
    let svg = std::fs::read_to_string(picture).unwrap();
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    // In words too, for those who do not tell red from green; and for dark pages.
    assert!(svg.contains(">yes at the keyframe: TTC to the target &lt; 3 s"), "{svg}");
    assert!(svg.contains("prefers-color-scheme: dark"));
    let unknown = explain(&["--clip", "multilane-ego_000", "--target", "nobody"]);
    assert!(
        unknown.code == 1 && unknown.err.starts_with("error: the drive has no track 'nobody'"),
        "{}",
        unknown.err
    );
    let zh = explain(&["--clip", "multilane-ego_000", "--target", "nobody", "--lang", "zh"]);
    assert!(zh.err.starts_with("错误：该行程没有"), "{}", zh.err);
}

#[test]
fn explain_prints_json() {
    let lake = lake();
    let args = ["explain", "cutin.urgent", "--lake", text(lake.path()), "--clip", "multilane-ego_000"];
    let run = whyroad_in(&root(), &[&args[..], &["--format", "json"]].concat());
    assert_eq!(run.code, 0, "{}", run.err);
    let json: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!((&json["outcome"], &json["matched"]), (&"matched".into(), &true.into()), "{}", run.out);
    assert_eq!(json["roles"]["target"], "cutter");
    // The spans of every condition cover the clip's frames, 20 s at 10 Hz, without a gap.
    assert_eq!(json["frames"], 200);
    let conditions = json["conditions"].as_array().unwrap();
    assert!(!conditions.is_empty());
    // A condition is a comparison with its value, or has members.
    let mut todo: Vec<&serde_json::Value> = conditions.iter().collect();
    let mut joins = std::collections::BTreeSet::new();
    while let Some(condition) = todo.pop() {
        assert!(condition["text"].is_string() && condition["course"].is_object(), "{condition:#}");
        match condition["join"].as_str() {
            None => {
                assert!(condition["unit"].is_string() && condition["conditions"].is_null(), "{condition:#}")
            }
            Some(join) => {
                joins.insert(join);
                let members = condition["conditions"].as_array().unwrap();
                assert_eq!(members.is_empty(), condition["listed_above"] == true, "{condition:#}");
                todo.extend(members);
            }
        }
    }
    assert!(joins.contains("any") && joins.contains("all"), "{joins:?}");
    for course in conditions.iter().map(|c| &c["course"]).chain([&json["when"]]) {
        let mut end = serde_json::Value::from(0);
        for span in course["spans"].as_array().unwrap() {
            assert_eq!(span["start"], end);
            end = span["end"].clone();
        }
        assert_eq!(end, 200);
    }
}

/// SUMO writes no weather, and by its FCD the ego drives faster than 18 m/s from 24 s to 34 s, slower at 20 s, 22 s and
/// 36 s. The clip begins at 20 s.
#[test]
fn what_a_log_does_not_tell_is_undecided() {
    let lake = lake();
    let explain = |rule: &str| {
        let args = ["explain", "--lake", text(lake.path()), "--clip", "multilane-ego_001", "--rule", rule];
        let run = whyroad_in(&root(), &[&args[..], &["--format", "json"]].concat());
        serde_json::from_str::<serde_json::Value>(&run.out).unwrap()
    };
    let open = explain("context.weather == rain and ego.speed > 18 m/s");
    assert_eq!((&open["outcome"], &open["matched"]), (&"undecided".into(), &false.into()), "{open:#}");
    let seconds = open["seconds"].as_f64().unwrap();
    assert!((2.0..=16.0).contains(&seconds), "{seconds}");
    // At 50 m/s it never drives, whatever the weather.
    let never = explain("context.weather == rain and ego.speed > 50 m/s");
    assert_eq!(never["outcome"], "not_together", "{never:#}");
}

#[test]
fn a_rule_in_one_line_is_mined() {
    let (lake, out) = (lake(), tempfile::tempdir().unwrap());
    let mine = |rule: &str| {
        let args = ["mine", "--lake", text(lake.path()), "--out", text(out.path()), "--rule", rule];
        whyroad_in(&root(), &[&args[..], &["--target", "vehicle"]].concat())
    };
    // The simulated cutter crosses the line some time before the keyframe that the simulator states.
    let run = mine("target.wheel_over_line and target.ttc < 3 s");
    assert_eq!(run.code, 0, "{}", run.err);
    let episodes = std::fs::read_to_string(out.path().join("episodes.jsonl")).unwrap();
    assert!(episodes.contains("\"target_id\":\"cutter\""), "{episodes}");
    // Where to look is told at once: the clip, the moment in it, the target, the measured value.
    assert!(
        run.out.contains("the best 1 of 1: clip, keyframe (in clip), target, score, values"),
        "{}",
        run.out
    );
    assert!(run.out.contains("multilane-ego_000  16.9 s  cutter"), "{}", run.out);
    // The value that the tutorial names, with its unit.
    assert!(run.out.contains("TTC to the target < 3 s (2.48 s)"), "{}", run.out);
    assert!(
        run.out.contains("1 drive, 1 episode (1 primary)\n"),
        "of classes nothing is reported: {}",
        run.out
    );
    assert!(episodes.contains("\"scenario_id\":\"custom.rule\""), "{episodes}");
    let coverage = std::fs::read_to_string(out.path().join("coverage.json")).unwrap();
    assert!(coverage.contains("\"leaves\": []"), "{coverage}");
    let wrong = mine("target.whel_over_line");
    assert!(wrong.code == 1 && wrong.err.contains("did you mean 'target.wheel_over_line'?"), "{}", wrong.err);
}

#[test]
fn a_rule_file_is_mined_as_its_text_would_be() {
    let (lake, out) = (lake(), tempfile::tempdir().unwrap());
    let file = out.path().join("mine.yaml");
    let rule = "mining:\n  target: vehicle\n  define: { close: \"target.ttc < 3 s\" }\n  when: \"target.wheel_over_line and close\"\n";
    std::fs::write(&file, rule).unwrap();
    let mine = |rule: &str, more: &[&str]| {
        let args = ["mine", "--lake", text(lake.path()), "--out", text(out.path()), "--rule", rule];
        let run = whyroad_in(&root(), &[&args[..], more].concat());
        (run, std::fs::read(out.path().join("episodes.parquet")).unwrap_or_default())
    };
    let (of_file, found) = mine(text(&file), &[]);
    assert_eq!(of_file.code, 0, "{}", of_file.err);
    let line = "target.wheel_over_line and target.ttc < 3 s";
    // The same folder answers another question only when that is said.
    let (refused, kept) = mine(line, &["--target", "vehicle", "--name", "mine"]);
    assert!(refused.code == 1 && kept == found, "{}", refused.err);
    assert!(refused.err.contains("another question") && refused.err.contains("--force"), "{}", refused.err);
    let (of_text, replaced) = mine(line, &["--target", "vehicle", "--name", "mine", "--force"]);
    assert_eq!(of_text.code, 0, "{}", of_text.err);
    assert!(!found.is_empty() && found == replaced);
    let episodes = std::fs::read_to_string(out.path().join("episodes.jsonl")).unwrap();
    assert!(episodes.contains("\"scenario_id\":\"custom.mine\""), "{episodes}");
    let (twice, _) = mine(text(&file), &["--target", "vru"]);
    assert!(twice.code == 1 && twice.err.contains("leave out --target"), "{}", twice.err);
}

#[test]
fn a_rule_of_one_s_own_and_other_are_explained() {
    let lake = lake();
    let explain = |args: &[&str]| {
        let place = ["--lake", text(lake.path()), "--clip", "multilane-ego_000"];
        whyroad_in(&root(), &[&["explain"], args, &place].concat())
    };
    let run = explain(&["--rule", "target_vehicle.wheel_over_line and ttc < 3 s"]);
    assert!(run.code == 0 && run.out.contains("(target cutter): matches, keyframe at 16.9 s"), "{}", run.out);
    let wrong = explain(&["--rule", "target.wheel_over_lin"]);
    assert!(wrong.code == 1 && wrong.err.contains("did you mean 'target.wheel_over_line'?"), "{}", wrong.err);
    let other = explain(&["other"]);
    assert!(
        other.code == 0 && other.out.contains("The ego clearly changes what it does"),
        "{}{}",
        other.out,
        other.err
    );
    assert_eq!(explain(&[]).code, 2);
    assert_eq!(explain(&["cutin", "--rule", "ego.standstill"]).code, 2);
    let broad = explain(&["reactive_agent"]);
    assert!(broad.code == 1 && broad.err.contains("mine.scenario.no_rule"), "{}", broad.err);
    let args = ["explain", "cutin", "--lake", text(lake.path()), "--clip", "multilane-eg"];
    let elsewhere = whyroad_in(&root(), &args);
    assert!(elsewhere.err.contains("begin with multilane-ego_000"), "{}", elsewhere.err);
}

/// A drive of 10 Hz of which 3.2 s are missing, from 6 s on: the ego is at 2 m/s from 15 s to 18 s and from 25 s on,
/// and at 10 m/s otherwise.
fn drive_with_a_gap(folder: &Path) {
    let folder = folder.join("gapped");
    std::fs::create_dir_all(&folder).unwrap();
    let meta = "source: van\nstart_time: 2026-03-01T08:00:00Z\nego: { length_m: 4.8, width_m: 1.9, height_m: 1.5, reference_to_centre_m: 0 }\n";
    std::fs::write(folder.join("drive.yaml"), meta).unwrap();
    let (mut rows, mut x) = ("time_s,x_m,y_m,heading_rad,speed_mps\n".to_owned(), 0.0);
    for frame in 0..300 {
        let speed = if matches!(frame, 150..180 | 250..) { 2.0 } else { 10.0 };
        if !(60..92).contains(&frame) {
            rows += &format!("{},{x},0,0,{speed}\n", f64::from(frame) / 10.0);
        }
        x += speed / 10.0;
    }
    std::fs::write(folder.join("ego.csv"), rows).unwrap();
}

#[test]
fn times_are_measured_where_frames_are_missing() {
    let dir = tempfile::tempdir().unwrap();
    drive_with_a_gap(dir.path());
    let lake = dir.path().join("lake");
    let ingest = whyroad_in(&root(), &["ingest", "table", text(dir.path()), "--lake", text(&lake)]);
    assert_eq!(ingest.code, 0, "{}", ingest.err);
    let (rule, out) = (["--rule", "ego.speed < 5 m/s"], dir.path().join("out"));
    let mine = [&["mine", "--lake", text(&lake), "--out", text(&out)], &rule[..]].concat();
    // The second clip begins with frame 200, 140 frames after the end of the gap at 9.2 s: at 23.2 s.
    let expected = ["gapped_000  15.0 s          ", "gapped_001  25.0 s (1.8 s)  "];
    // Mined, and mined again with the lines of the first run.
    for _ in 0..2 {
        let run = whyroad_in(&root(), &mine);
        assert!(expected.iter().all(|line| run.out.contains(line)), "{}", run.out);
        let json = whyroad_in(&root(), &[&mine[..], &["--format", "json"]].concat());
        let json: serde_json::Value = serde_json::from_str(&json.out).unwrap();
        let best: Vec<(&str, f64, f64)> = json["best"]
            .as_array()
            .unwrap()
            .iter()
            .map(|b| {
                (
                    b["clip_id"].as_str().unwrap(),
                    b["keyframe_s"].as_f64().unwrap(),
                    b["clip_s"].as_f64().unwrap(),
                )
            })
            .collect();
        assert!(
            best.contains(&("gapped_000", 15.0, 15.0)) && best.contains(&("gapped_001", 25.0, 1.8)),
            "{best:?}"
        );
    }
    let svg = dir.path().join("chart.svg");
    let explain =
        [&["explain", "--lake", text(&lake), "--clip", "gapped_000", "--svg", text(&svg)], &rule[..]]
            .concat();
    let run = whyroad_in(&root(), &explain);
    // 60 frames before the gap, and 58 from 9.2 s to 15 s.
    assert!(
        run.out.contains("keyframe at 15.0 s (frame 118)") && run.out.contains("^ 15.0 s"),
        "{}",
        run.out
    );
    assert!(run.out.contains("|0.0 s      |4.8 s      |12.8 s"), "{}", run.out);
    assert!(std::fs::read_to_string(&svg).unwrap().contains(">13.2 s</text>"), "frame 100");
    let json = whyroad_in(&root(), &[&explain[..], &["--format", "json"]].concat());
    let json: serde_json::Value = serde_json::from_str(&json.out).unwrap();
    assert_eq!((&json["seconds"], &json["times_s"][100]), (&15.0.into(), &13.2.into()));
}

#[test]
fn two_runs_do_not_write_into_one_folder() {
    let (lake, dir) = (lake(), tempfile::tempdir().unwrap());
    let out = dir.path().join("out");
    let mine = || {
        whyroad_in(
            &root(),
            &[
                "mine",
                "--lake",
                text(lake.path()),
                "--out",
                text(&out),
                "--force",
                "--rule",
                "ego.speed > 5 m/s",
            ],
        )
    };
    assert_eq!(mine().code, 0);
    let before = std::fs::read(out.join("episodes.jsonl")).unwrap();
    let held = whyroad_lake::mined::FolderLock::take(&out).unwrap();
    let refused = mine();
    assert!(refused.code == 1 && refused.err.contains("another process is writing"), "{}", refused.err);
    assert_eq!(std::fs::read(out.join("episodes.jsonl")).unwrap(), before);
    drop(held);
    assert_eq!(mine().code, 0);
    assert!(!out.join(".lock").exists());
}

#[test]
fn a_pause_of_the_log_is_not_counted_as_driving() {
    let dir = tempfile::tempdir().unwrap();
    drive_with_a_gap(dir.path());
    // The last 100 frames, 10 s, begin an hour later.
    let ego = dir.path().join("gapped/ego.csv");
    let rows = std::fs::read_to_string(&ego).unwrap();
    let later = |line: &str| match line.split_once(',') {
        Some((time, rest)) if time.parse::<f64>().is_ok_and(|t| t >= 20.0) => {
            format!("{},{rest}\n", time.parse::<f64>().unwrap() + 3600.0)
        }
        _ => format!("{line}\n"),
    };
    std::fs::write(&ego, rows.lines().map(later).collect::<String>()).unwrap();
    let lake = dir.path().join("lake");
    assert_eq!(whyroad_in(&root(), &["ingest", "table", text(dir.path()), "--lake", text(&lake)]).code, 0);
    let run = whyroad_in(&root(), &["inspect", "--lake", text(&lake)]);
    assert!(run.out.contains("1 drive, 2 clips, 0.01 h"), "{}", run.out);
    let list = whyroad_in(&root(), &["lake", "list", "--lake", text(&lake)]);
    assert!(list.out.contains("\t26.8 s\t"), "300 frames but 32: {}", list.out);
}
