//! `whyroad dataset` as a user runs it, on the bundled drives: drafts to a release, from the store and from mined
//! folders.
#![allow(clippy::unwrap_used)] // in a test a panic is the report

use crate::service::demo;
use crate::session::{Run, whyroad_in};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

fn run(folder: &Path, line: &str) -> Run {
    let line = line.replace("DEMO", &demo().display().to_string());
    whyroad_in(folder, &line.split(' ').collect::<Vec<_>>())
}

#[track_caller]
fn good(folder: &Path, line: &str) -> Run {
    let run = run(folder, line);
    assert_eq!(run.code, 0, "{line}: {}{}", run.out, run.err);
    run
}

fn manifest(folder: &Path, release: &str) -> Value {
    let text = std::fs::read_to_string(folder.join(release).join("manifest.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// A spec from the template with some values changed.
fn spec(folder: &Path, changes: &[(&str, &str)]) {
    good(folder, "dataset init template.yaml");
    let mut text = std::fs::read_to_string(folder.join("template.yaml")).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    std::fs::write(folder.join("dataset.yaml"), text).unwrap();
}

#[test]
fn a_release_is_built_checked_shown_and_compared() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    spec(
        at,
        &[
            ("floor_leaf: 0", "floor_leaf: 30"),
            ("floor_l2: 0", "floor_l2: 30"),
            ("images: none", "images: bev"),
        ],
    );
    let build = "dataset build --spec dataset.yaml --labels DEMO/mined --lake DEMO/lake --out r1";
    let refused = run(at, build);
    assert_eq!(refused.code, 1);
    assert!(
        refused.err.contains("dataset.labels.none") && refused.err.contains("--drafts"),
        "{}",
        refused.err
    );

    let zh = run(at, &format!("--lang zh {build}"));
    assert!(zh.err.contains("未质检的草稿 ") && !zh.err.contains("draft "), "{}", zh.err);

    let built = good(at, &format!("{build} --drafts"));
    assert!(built.out.contains("samples: train"), "{}", built.out);
    let first = manifest(at, "r1");
    let n = first["counts"]["samples"].as_u64().unwrap();
    assert!(n >= 5, "{n}");
    assert_eq!(first["counts"]["by_status"]["draft"].as_u64(), Some(n), "all are drafts, and marked");
    assert_eq!(first["licence"], "Apache-2.0");
    assert_eq!(first["counts"]["images"].as_u64(), Some(4 * n));
    let checked = good(at, "dataset verify r1");
    assert!(checked.out.contains("0 findings"), "{}", checked.out);

    // What is missing becomes queries that mining takes.
    let queries: Vec<_> =
        std::fs::read_dir(at.join("r1/queries")).unwrap().flatten().map(|e| e.path()).collect();
    assert!(queries.len() > 90, "{}", queries.len());
    for query in queries.iter().step_by(9) {
        let out = query.file_stem().unwrap().to_string_lossy().into_owned();
        good(at, &format!("mine --query {} --lake DEMO/lake --out {out}", query.display()));
    }
    let card = std::fs::read_to_string(at.join("r1/README.md")).unwrap();
    assert!(card.contains("| `safety.aeb` | 0 | 30 | `queries/safety.aeb.json` |"), "{card}");
    // Leaves count for the floor of their L2: its query finds them, as the command that mines the class does.
    let episodes = |folder: &str| -> BTreeSet<String> {
        let text = std::fs::read_to_string(at.join(folder).join("episodes.jsonl")).unwrap();
        let id = |line: &str| serde_json::from_str::<Value>(line).unwrap()["episode_id"].to_string();
        text.lines().map(id).collect()
    };
    good(at, "mine --query r1/queries/reactive_agent.cutin.json --lake DEMO/lake --out more");
    good(at, "mine --scenario reactive_agent.cutin --lake DEMO/lake --out all");
    assert_eq!(episodes("more"), episodes("all"));
    assert!(!episodes("more").is_empty());

    let again = build.replace("--out r1", "--out r2");
    good(at, &format!("{again} --drafts"));
    assert_eq!(good(at, "dataset diff r1 r2").out.lines().filter(|l| l.ends_with(" 0")).count(), 6);
    let sums = |r: &str| std::fs::read_to_string(at.join(r).join("checksums.sha256")).unwrap();
    assert_eq!(sums("r1"), sums("r2"));

    assert_eq!(run(at, "dataset show r1 no-such-sample").code, 1);
    let shown = good(at, &format!("dataset show r1 {}", first_sample(&at.join("r1"))));
    for line in ["drive", "episode", "label", "rule version", "taxonomy version"] {
        assert!(shown.out.lines().any(|l| l.starts_with(line)), "{line}: {}", shown.out);
    }
}

/// Drafts that went through a file, where a person may correct them, give the release that the episodes give: the same
/// labels, and with the mined folder beside them the same lineage. Without it the score is unknown, which is no pass.
#[test]
fn drafts_of_a_file_are_traced_back_to_their_episodes() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    good(at, "draft --lake DEMO/lake --from DEMO/mined --out drafts.jsonl");
    let text = std::fs::read_to_string(at.join("drafts.jsonl")).unwrap();
    let mined = std::fs::read_to_string(demo().join("mined/episodes.jsonl")).unwrap();
    let parsed = |line: &str| serde_json::from_str::<Value>(line).unwrap();
    let versions: BTreeSet<String> = mined.lines().map(|l| parsed(l)["rule_version"].to_string()).collect();
    for draft in text.lines().map(parsed) {
        let rules = draft["provenance"]["versions"]["rules"].to_string();
        assert!(versions.contains(&rules) && rules != "null", "{rules} {versions:?}");
    }

    good(at, "dataset init dataset.yaml");
    let build = "dataset build --spec dataset.yaml --lake DEMO/lake --drafts";
    good(at, &format!("{build} --labels DEMO/mined --out r1"));
    good(at, &format!("{build} --labels drafts.jsonl --labels DEMO/mined --out r2"));
    let lineage = |release: &str| {
        let all = whyroad_dataset::Release::open(at.join(release)).unwrap();
        let mut all: Vec<_> = all.samples(None).map(|s| s.unwrap()).collect();
        all.sort_by(|a, b| a.sample_id.cmp(&b.sample_id));
        all.into_iter()
            .map(|s| {
                (
                    s.sample_id,
                    s.lineage.episode_id,
                    s.lineage.target_id,
                    s.lineage.rule_version,
                    s.lineage.score,
                )
            })
            .collect::<Vec<_>>()
    };
    assert_eq!(lineage("r1"), lineage("r2"));
    assert!(lineage("r2").iter().all(|(_, episode, ..)| episode.is_some()));
    let differences = good(at, "dataset diff r1 r2").out;
    assert_eq!(differences.lines().filter(|l| l.ends_with(" 0")).count(), 6, "{differences}");

    spec(at, &[("# min_score: 0.5 ", "min_score: 0.0   ")]);
    let alone = run(at, &format!("{build} --labels drafts.jsonl --out r3"));
    assert_eq!(alone.code, 1);
    assert!(alone.err.contains("dataset.score.unknown"), "{}", alone.err);
    good(at, &format!("{build} --labels drafts.jsonl --labels DEMO/mined --out r3"));
}

/// The id of some sample, read without the commands under test.
fn first_sample(release: &Path) -> String {
    let release = whyroad_dataset::Release::open(release).unwrap();
    release.samples(None).next().unwrap().unwrap().sample_id
}

#[test]
fn facts_about_drives_are_read_from_csv() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    let drives = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/drives/back_street");
    std::fs::write(
        at.join("meta.csv"),
        "drive_id,session,vehicle,latitude,longitude,licence\nDRIVE,s1,v1,40.0,116.3,MIT\nother,s2,,,,\nDRIVE,,,91,0,\n",
    )
    .unwrap();
    good(at, &format!("ingest sumo {drives} --lake lake"));
    let id = std::fs::read_dir(at.join("lake/drives")).unwrap().flatten().next().unwrap();
    let id = id.file_name().to_string_lossy().into_owned();
    let text = std::fs::read_to_string(at.join("meta.csv")).unwrap().replace("DRIVE", &id);
    std::fs::write(at.join("meta.csv"), text).unwrap();
    let stated = run(at, &format!("ingest sumo {drives} --lake lake --meta meta.csv"));
    assert_eq!(stated.code, 3, "one line is wrong and one names no drive: {}", stated.err);
    assert!(stated.err.contains("ingest.meta.line") && stated.err.contains("meta.csv:4"), "{}", stated.err);
    assert!(stated.err.contains("ingest.meta.drive"), "{}", stated.err);
    let manifest = std::fs::read_to_string(at.join("lake/drives").join(&id).join("drive.json")).unwrap();
    let meta: Value = serde_json::from_str(&manifest).unwrap();
    assert_eq!((&meta["meta"]["session"], &meta["meta"]["licence"]), (&"s1".into(), &"MIT".into()));
    assert_eq!(meta["meta"]["position"]["longitude_deg"], 116.3);
    good(at, "inspect --lake lake");

    // The published GCJ-02 pair of Beijing (eviltransform); declared it is converted, any other datum leaves it alone.
    let position = |datum: &str| {
        let line =
            format!("drive_id,latitude,longitude,datum\n{id},39.91334545536069,116.38404722455657,{datum}\n");
        std::fs::write(at.join("meta.csv"), line).unwrap();
        let stated = run(at, &format!("ingest sumo {drives} --lake lake --meta meta.csv"));
        let manifest = std::fs::read_to_string(at.join("lake/drives").join(&id).join("drive.json")).unwrap();
        let meta: Value = serde_json::from_str(&manifest).unwrap();
        let degrees = |key: &str| meta["meta"]["position"][key].as_f64().unwrap();
        (degrees("latitude_deg"), degrees("longitude_deg"), stated.err)
    };
    // 1e-6 deg is 0.1 m.
    let (lat, lon, _) = position("GCJ-02");
    assert!((lat - 39.911954).abs() < 1e-6 && (lon - 116.377817).abs() < 1e-6, "{lat} {lon}");
    for (datum, reported) in [("", false), ("wgs84", false), ("bd09", true)] {
        let (lat, lon, err) = position(datum);
        assert_eq!((lat, lon), (39.91334545536069, 116.38404722455657), "{datum}");
        assert_eq!(err.contains("ingest.meta.datum"), reported, "{datum}: {err}");
    }
}
