//! `whyroad demo` from end to end. What must be found comes from `examples/drives/*/truth.jsonl`, which is made
//! from the simulator's outputs alone.
#![allow(clippy::unwrap_used)] // in a test a panic is the report

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use whyroad_framework::Framework;
use whyroad_model::Nanos;

struct Run {
    code: i32,
    out: String,
    err: String,
}

fn whyroad(args: &[&str]) -> Run {
    let output = Command::new(env!("CARGO_BIN_EXE_whyroad"))
        .args(args)
        .env_remove("WHYROAD_FRAMEWORK")
        .env_remove("WHYROAD_LANG")
        .output()
        .unwrap();
    Run {
        code: output.status.code().unwrap(),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}

/// One demo for all tests: its folder and what it said.
fn demo() -> &'static (tempfile::TempDir, Run) {
    static DEMO: OnceLock<(tempfile::TempDir, Run)> = OnceLock::new();
    DEMO.get_or_init(|| {
        let dir = tempfile::tempdir().unwrap();
        let run = whyroad(&["demo", "--out", dir.path().to_str().unwrap()]);
        (dir, run)
    })
}

fn lines(path: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().map(|l| serde_json::from_str(l).unwrap()).collect()
}

fn episodes() -> Vec<Value> {
    lines(&demo().0.path().join("mined/episodes.jsonl"))
}

fn truth_files() -> Vec<PathBuf> {
    let drives = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/drives");
    let files: Vec<PathBuf> =
        ["back_street", "multilane", "signal_junction"].map(|d| drives.join(d).join("truth.jsonl")).to_vec();
    assert!(files.iter().all(|f| f.is_file()));
    files
}

/// Start, keyframe, end in seconds since the epoch's start of the drives.
fn span_of_truth(t: &Value) -> [f64; 3] {
    ["start_ns", "keyframe_ns", "end_ns"].map(|k| seconds(Nanos(t[k].as_i64().unwrap())))
}

fn span_of_episode(e: &Value) -> [f64; 3] {
    let time = |v: &Value| seconds(Nanos::parse_iso(v.as_str().unwrap()).unwrap());
    [
        time(&e["time_range"]["start_timestamp"]),
        time(&e["keyframe"]["timestamp"]),
        time(&e["time_range"]["end_timestamp"]),
    ]
}

fn seconds(t: Nanos) -> f64 {
    t.seconds_since(Nanos::parse_iso("2026-01-01T00:00:00Z").unwrap())
}

/// Same class, drive and target, and keyframes within 1 s or time ranges that overlap by 0.3 of their union.
fn is_match(truth: &Value, episode: &Value) -> bool {
    let same = |k: &str| truth[k] == episode[k];
    let target = truth["target_id"].is_null() || episode["target_id"].is_null() || same("target_id");
    let (a, b) = (span_of_truth(truth), span_of_episode(episode));
    let overlap = (a[2].min(b[2]) - a[0].max(b[0])).max(0.0) / (a[2].max(b[2]) - a[0].min(b[0]));
    same("scenario_id") && same("drive_id") && target && ((a[1] - b[1]).abs() <= 1.0 || overlap >= 0.3)
}

#[test]
fn everything_that_the_simulator_did_is_found_and_nothing_is_invented() {
    let episodes = episodes();
    let mut checked = 0;
    for file in truth_files() {
        let truth = lines(&file);
        let (head, happened) = truth.split_first().unwrap();
        for t in happened {
            assert!(episodes.iter().any(|e| is_match(t, e)), "not found: {t}");
            checked += 1;
        }
        let drive = &head["drives"][0];
        for leaf in head["complete"].as_array().unwrap() {
            for e in episodes.iter().filter(|e| e["scenario_id"] == *leaf && e["drive_id"] == *drive) {
                assert!(happened.iter().any(|t| is_match(t, e)), "did not happen: {e}");
            }
        }
    }
    // As many as the three files list; fewer would mean that they were not read.
    assert_eq!(checked, 14);
}

#[test]
fn the_comparison_can_fail() {
    let episodes = episodes();
    let truth = lines(&truth_files()[1]);
    let cutin = truth.iter().find(|t| t["scenario_id"] == "reactive_agent.cutin.urgent").unwrap();
    assert!(episodes.iter().any(|e| is_match(cutin, e)));
    let mut late = cutin.clone();
    for k in ["start_ns", "keyframe_ns", "end_ns"] {
        late[k] = (late[k].as_i64().unwrap() + 10_000_000_000).into();
    }
    assert!(!episodes.iter().any(|e| is_match(&late, e)), "ten seconds late");
    let mut other = cutin.clone();
    other["target_id"] = "lorry".into();
    assert!(!episodes.iter().any(|e| is_match(&other, e)), "another vehicle");
}

#[test]
fn it_ends_with_a_table_and_the_path_of_the_report() {
    let (dir, run) = demo();
    assert_eq!(run.code, 0, "{}", run.err);
    let page = dir.path().join("report.html");
    let mut last = run.out.trim_end().lines().rev().take(3);
    assert!(last.any(|l| l.contains(page.to_str().unwrap())), "{}", run.out);
    let leaves = format!("{} leaves", Framework::bundled().taxonomy.leaves().count());
    for words in ["Urgent cut-in", "紧急Cutin", "multilane-ego_000", &leaves] {
        assert!(run.out.contains(words), "{words}");
    }
    // Every class that has episodes has a line with their number.
    let mut count: BTreeMap<String, usize> = BTreeMap::new();
    for e in episodes() {
        *count.entry(e["scenario_id"].as_str().unwrap().to_owned()).or_default() += 1;
    }
    let table = run.out.lines().filter(|l| l.ends_with(" s")).count();
    assert_eq!(table, count.len());
}

#[test]
fn a_primary_episode_has_a_draft_unless_it_is_refused_and_the_demo_says_what_the_checker_says() {
    let (dir, run) = demo();
    let drafts = dir.path().join("draft_labels.jsonl");
    let labels = lines(&drafts);
    // What no class explains (`other`) is for a person to classify.
    let primary =
        episodes().iter().filter(|e| e["is_primary"] == true && e["scenario_id"] != "other").count();
    let written = labels.len();
    assert_eq!(lines(&dir.path().join("draft_notes.jsonl")).len(), written);
    let path = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let again = folder.path().join("again.jsonl");
    let (lake, mined) = (path("lake"), path("mined"));
    let line =
        ["draft", "--lake", &lake, "--from", &mined, "--out", again.to_str().unwrap(), "--format", "json"];
    let told: Value = serde_json::from_str(&whyroad(&line).out).unwrap();
    let refused: u64 = told["doubts"].as_object().unwrap().values().filter_map(|n| n.as_u64()).sum();
    assert!(refused * 5 <= primary as u64, "{told}");
    assert_eq!((written as u64 + refused, &told["written"]), (primary as u64, &written.into()), "{told}");

    let clips = dir.path().join("mined/clip_metadata.jsonl");
    let checked = whyroad(&[
        "validate",
        drafts.to_str().unwrap(),
        "--clips",
        clips.to_str().unwrap(),
        "--format",
        "json",
    ]);
    // Records such as "is there a light at the crosswalk" are the annotator's: the drafts cannot all be clean.
    assert_eq!(checked.code, 1);
    let findings = checked.out.matches("\"severity\": \"error\"").count()
        + checked.out.matches("\"severity\":\"error\"").count();
    let reported: usize = run
        .err
        .lines()
        .filter_map(|l| l.trim().split_once(" × label."))
        .map(|(n, _)| n.trim().parse::<usize>().unwrap())
        .sum();
    assert_eq!(reported, findings, "{}", run.err);
    assert!(
        labels
            .iter()
            .all(|l| l["provenance"]["source"] == "rule" && l["coc_trace"].as_str().unwrap().is_ascii())
    );
    let cutin = labels.iter().find(|l| l["scenario"]["l3"] == "urgent").unwrap();
    // The ego brakes from 19 to 11 m/s for the car that cuts in.
    assert_eq!(cutin["driving_decision"]["longitudinal"], "yield_to_agent");
}

#[test]
fn it_goes_on_to_a_release_and_an_export_that_agree_with_each_other() {
    let (dir, run) = demo();
    let release = whyroad_dataset::Release::open(dir.path().join("release")).unwrap();
    let samples: Vec<_> = release.samples(None).map(Result::unwrap).collect();
    // Primary episodes with a whole window, at most as many as there are drafts; all are marked as drafts.
    let drafts = lines(&dir.path().join("draft_labels.jsonl")).len();
    assert!((5..=drafts).contains(&samples.len()), "{} of {drafts}", samples.len());
    assert!(samples.iter().all(|s| s.lineage.label_status == "draft" && !s.lineage.checked));
    assert!(samples.iter().all(|s| s.images.len() == 4));
    let splits: BTreeSet<&str> = samples.iter().map(|s| s.split.as_str()).collect();
    assert_eq!(splits.len(), 3, "a drive each");
    let export = dir.path().join("export-ms-swift");
    let mut records = 0;
    for split in ["train", "val", "test"] {
        let file = export.join(format!("sft.{split}.jsonl"));
        let all = if file.is_file() { lines(&file) } else { vec![] };
        for record in &all {
            for image in record["images"].as_array().unwrap() {
                assert!(export.join(image.as_str().unwrap()).is_file(), "{image}");
            }
        }
        records += all.len();
    }
    assert_eq!(records, samples.len(), "one language per draft");
    assert!(run.err.contains("dataset ") && run.err.contains("ms-swift"), "{}", run.err);
    assert!(run.out.contains("whyroad dataset build --spec "), "{}", run.out);
    let checked = whyroad(&["dataset", "verify", dir.path().join("release").to_str().unwrap()]);
    assert_eq!(checked.code, 0, "{}{}", checked.out, checked.err);
}

#[test]
fn the_report_has_a_card_for_each_episode_and_fetches_nothing() {
    let page = std::fs::read_to_string(demo().0.path().join("report.html")).unwrap();
    for e in episodes() {
        let id = e["episode_id"].as_str().unwrap();
        assert_eq!(page.matches(&format!("id=\"episode-{id}\"")).count(), 1, "{id}");
    }
    assert_eq!(page.matches("class=\"bev\"").count(), episodes().len());
    for what in ["http:", "https:", "src=", "@import", "<link"] {
        assert!(!page.contains(what), "{what}");
    }
    assert!(page.len() < 3_000_000);
}

#[test]
fn conditions_on_cards_are_in_words_in_both_languages() {
    let page = std::fs::read_to_string(demo().0.path().join("report.html")).unwrap();
    let tables: Vec<&str> = page.split("<table class=\"conditions\">").skip(1).collect();
    assert!(tables.len() > 10, "{}", tables.len());
    for table in tables {
        let (table, _) = table.split_once("</table>").unwrap();
        // Between the marks of HTML: what people read, comparisons escaped as `&lt;`.
        let shown: String =
            table.split('<').filter_map(|part| part.split_once('>')).map(|(_, t)| format!("{t}\n")).collect();
        assert!(!table.contains("<code>") && !table.contains("title="), "{table}");
        for syntax in
            ["_", "==", "&lt;=", "&gt;=", "{", "previously", "is known", "target.", "ego.", "True", "null"]
        {
            assert!(!shown.contains(syntax), "{syntax}: {shown}");
        }
    }
}

#[test]
fn a_second_run_into_the_same_folder_gives_the_same_bytes() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().to_str().unwrap();
    let files = [
        "report.html",
        "draft_labels.jsonl",
        "mined/episodes.jsonl",
        "mined/coverage.json",
        "release/checksums.sha256",
        "export-ms-swift/sft.train.jsonl",
    ];
    let contents = || files.map(|f| std::fs::read(dir.path().join(f)).unwrap());
    assert_eq!(whyroad(&["demo", "--out", out]).code, 0);
    let first = contents();
    assert_eq!(whyroad(&["demo", "--out", out]).code, 0);
    assert!(first == contents());
}

#[test]
fn in_chinese_the_demo_speaks_and_drafts_chinese() {
    let dir = tempfile::tempdir().unwrap();
    let run = whyroad(&["demo", "--lang", "zh", "--out", dir.path().to_str().unwrap()]);
    assert_eq!(run.code, 0);
    assert!(run.out.contains("个 L3 场景：已找到") && run.err.contains("个标注草稿"));
    let labels = lines(&dir.path().join("draft_labels.jsonl"));
    assert!(
        labels
            .iter()
            .all(|l| l["provenance"]["source"] == "rule" && l["coc_trace"].as_str().unwrap().ends_with('。'))
    );
    let page = std::fs::read_to_string(dir.path().join("report.html")).unwrap();
    assert!(page.starts_with("<!doctype html>\n<html lang=\"zh\">"));
}

#[test]
fn report_alone_writes_the_same_page_and_names_what_it_cannot_read() {
    let dir = demo().0.path();
    let other = tempfile::tempdir().unwrap();
    let page = other.path().join("page.html");
    let args = |mined: &Path| {
        [
            "report",
            "--lake",
            dir.join("lake").to_str().unwrap(),
            "--mined",
            mined.to_str().unwrap(),
            "--out",
            page.to_str().unwrap(),
        ]
        .map(String::from)
    };
    let call = |mined: &Path| {
        let args = args(mined);
        whyroad(&args.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let run = call(&dir.join("mined"));
    assert_eq!((run.code, run.out.trim()), (0, page.to_str().unwrap()), "{}", run.err);
    assert_eq!(std::fs::read(&page).unwrap(), std::fs::read(dir.join("report.html")).unwrap());

    let mined = other.path().join("mined");
    std::fs::create_dir(&mined).unwrap();
    assert_eq!(call(&mined).code, 1, "nothing was mined there");
    std::fs::copy(dir.join("mined/coverage.json"), mined.join("coverage.json")).unwrap();
    let text = std::fs::read_to_string(dir.join("mined/episodes.jsonl")).unwrap();
    let kept: BTreeSet<&str> = text.lines().skip(1).collect();
    std::fs::write(
        mined.join("episodes.jsonl"),
        format!("{{\"episode_id\":\n{}\n", kept.iter().copied().collect::<Vec<_>>().join("\n")),
    )
    .unwrap();
    let broken = call(&mined);
    assert_eq!(broken.code, 3);
    assert!(broken.err.contains("report.episode.unreadable") && broken.err.contains("episodes.jsonl:1"));
    assert_eq!(std::fs::read_to_string(&page).unwrap().matches("<article").count(), kept.len());
}
