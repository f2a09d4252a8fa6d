//! `whyroad validate` from outside: the examples pass, every broken twin is rejected with its own code, and the
//! output reads as it should. Everything runs the real program.

#![allow(clippy::unwrap_used)] // a test may

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// Runs `whyroad validate` in `dir`.
fn validate(dir: &Path, args: &[&str], stdin: &[u8]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_whyroad"))
        .arg("validate")
        .args(args)
        .current_dir(dir)
        .env_remove("WHYROAD_LANG")
        .env_remove("WHYROAD_FRAMEWORK")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(stdin).unwrap();
    child.wait_with_output().unwrap()
}

fn code(o: &Output) -> i32 {
    o.status.code().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn codes(o: &Output) -> Vec<String> {
    let all: Value = serde_json::from_slice(&o.stdout).unwrap_or_else(|e| panic!("{e}: {}", text(&o.stdout)));
    let mut codes: Vec<String> = all["diagnostics"]
        .as_array()
        .unwrap()
        .iter()
        .map(|d| d["code"].as_str().unwrap().to_owned())
        .collect();
    codes.sort();
    codes.dedup();
    codes
}

mod twins {
    use super::*;

    #[derive(serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Table {
        messages: BTreeMap<String, Value>,
        twins: Vec<Twin>,
    }

    #[derive(serde::Deserialize, Clone)]
    #[serde(deny_unknown_fields)]
    struct Twin {
        base: String,
        #[serde(flatten)]
        edit: Edit,
        #[serde(default)]
        then: Option<Edit>,
        code: String,
        #[serde(default)]
        also: Vec<String>,
        #[serde(default)]
        warns: bool,
        #[serde(default)]
        clips: bool,
        why: String,
    }

    #[derive(serde::Deserialize, Clone, Default)]
    struct Edit {
        set: Option<String>,
        #[serde(default)]
        to: Value,
        remove: Option<String>,
        replace: Option<String>,
        by: Option<String>,
    }

    impl Edit {
        /// Applies the edit; an edit that changes nothing is a mistake of the table.
        fn apply(&self, text: &str) -> String {
            let mut out = text.to_owned();
            if let (Some(from), Some(by)) = (&self.replace, &self.by) {
                assert!(out.contains(from), "nothing to replace: {from}");
                out = out.replacen(from, by, 1);
            }
            if let Some(pointer) = self.set.as_ref().or(self.remove.as_ref()) {
                let mut v: Value = serde_json::from_str(&out).unwrap();
                let (parent, key) = pointer.rsplit_once('/').unwrap();
                match v.pointer_mut(parent).unwrap_or_else(|| panic!("no {parent}")) {
                    Value::Object(o) if self.set.is_some() => {
                        o.insert(key.to_owned(), self.to.clone());
                    }
                    Value::Object(o) => {
                        o.remove(key).unwrap_or_else(|| panic!("no {pointer}"));
                    }
                    other => panic!("{pointer} is in no object but in {other}"),
                }
                out = serde_json::to_string_pretty(&v).unwrap();
            }
            assert_ne!(out, text, "the edit changes nothing");
            out
        }
    }

    fn table() -> Table {
        let file = root().join("crates/whyroad/tests/fixtures/broken_labels/twins.yaml");
        whyroad_model::yaml::from_str(&std::fs::read_to_string(file).unwrap()).unwrap()
    }

    fn base(table: &Table, name: &str) -> String {
        match table.messages.get(name) {
            Some(v) => serde_json::to_string_pretty(v).unwrap(),
            None => std::fs::read_to_string(root().join("examples").join(name)).unwrap(),
        }
    }

    /// Codes found in one twin, and whether any is an error.
    type Found = BTreeMap<String, (BTreeSet<String>, bool)>;

    /// Checks all twins in one run of the program (a run for each would take a minute), with or without clips.
    fn check(twins: &[(String, &Twin)], table: &Table, clips: bool) -> Found {
        let dir = tempfile::tempdir().unwrap();
        std::fs::create_dir(dir.path().join("t")).unwrap();
        std::fs::write(dir.path().join("clips.json"), base(table, "clip")).unwrap();
        for (name, twin) in twins {
            let mut document = twin.edit.apply(&base(table, &twin.base));
            if let Some(then) = &twin.then {
                document = then.apply(&document);
            }
            std::fs::write(dir.path().join("t").join(name), document).unwrap();
        }
        let mut args = vec!["t", "--format", "json"];
        if clips {
            args.extend(["--clips", "clips.json"]);
        }
        let o = validate(dir.path(), &args, b"");
        assert_eq!(code(&o), 1);
        let all: Value = serde_json::from_slice(&o.stdout).unwrap();
        let mut found = Found::new();
        for d in all["diagnostics"].as_array().unwrap() {
            let name = d["place"]["file"].as_str().unwrap().trim_start_matches("t/").to_owned();
            let entry = found.entry(name).or_default();
            entry.0.insert(d["code"].as_str().unwrap().to_owned());
            entry.1 |= d["severity"] == "error";
        }
        found
    }

    /// What is wrong with the answer to one twin; nothing when it is as the table says.
    fn judge(twin: &Twin, found: Option<&(BTreeSet<String>, bool)>) -> Option<String> {
        let wanted: BTreeSet<String> = twin.also.iter().chain([&twin.code]).cloned().collect();
        let (codes, is_error) = found.cloned().unwrap_or_default();
        let right = codes == wanted && is_error != twin.warns;
        (!right).then(|| {
            format!("{} of {} ({}): found {codes:?}, error: {is_error}", twin.code, twin.base, twin.why)
        })
    }

    #[test]
    fn every_twin_is_rejected_with_its_own_code() {
        let table = table();
        let dir = tempfile::tempdir().unwrap();
        for name in table.messages.keys() {
            std::fs::write(dir.path().join(format!("{name}.json")), base(&table, name)).unwrap();
        }
        let o = validate(dir.path(), &[".", "--format", "json"], b"");
        assert!(codes(&o).is_empty() && code(&o) == 0, "{}", text(&o.stdout));

        let mut wrong = Vec::new();
        let mut ran = 0;
        let mut first = None;
        for clips in [false, true] {
            let twins: Vec<(String, &Twin)> = (0..)
                .zip(&table.twins)
                .filter(|(_, t)| t.clips == clips)
                .map(|(i, t)| (format!("{i:03}.json"), t))
                .collect();
            let found = check(&twins, &table, clips);
            ran += twins.len();
            wrong.extend(twins.iter().filter_map(|(name, t)| judge(t, found.get(name))));
            first = first.or_else(|| twins.first().map(|(name, t)| ((*t).clone(), found.get(name).cloned())));
        }
        assert!(wrong.is_empty(), "{} of {ran}:\n{}", wrong.len(), wrong.join("\n"));
        // So that a table that shrank, or was not read, does not pass.
        assert_eq!(ran, 111);

        // One wrong expectation must be seen.
        let (twin, found) = first.unwrap();
        assert!(judge(&twin, found.as_ref()).is_none());
        assert!(judge(&Twin { code: "label.type".into(), ..twin.clone() }, found.as_ref()).is_some());
        assert!(judge(&Twin { warns: true, ..twin }, found.as_ref()).is_some());
    }

    #[test]
    fn the_twins_cover_the_codes() {
        // Not reachable by editing one document: these have tests of their own below.
        let elsewhere = [
            "label.file.unreadable",
            "label.input.empty",
            "label.input.foreign",
            "label.input.nothing",
            "label.json.bom",
            "label.json.encoding",
            "label.json.too_large",
            "lexicon.syntax",
            "lexicon.pattern",
            "lexicon.class",
        ];
        // Of labels beside a lake: `labels_of_drives_that_the_lake_lacks_are_named` below.
        let elsewhere = [&elsewhere[..], &["label.clip.unrecorded"]].concat();
        // Faults of text are shown by the corpus of whyroad-label (`tests/it/corpus`), those against a recording by
        // `label_checks` of whyroad-engine, those of migration by its own tests.
        let corpus = [
            "label.text.",
            "label.motion.",
            "label.object.",
            "label.decision.impossible",
            "label.record.value",
            "label.evidence.before_history",
            "label.cause.circular",
            "label.cause.kind",
            "label.cause.no_effect",
            "label.cause.proximate",
            "label.cause.unobserved",
            "label.component.duplicate",
            "label.component.too_short",
            "label.decision.unchanged",
            "label.time_range.implausible",
            "label.time_range.start",
            "label.keyframe.range_outside",
            "label.keyframe.moment",
            "label.class.motion",
            "label.class.rule",
            "label.migrate.lost",
            "label.trace.draft",
            "label.trace.object_differs",
            "label.trace.unnamed_object",
        ];
        let elsewhere = |c: &str| elsewhere.contains(&c) || corpus.iter().any(|p| c.starts_with(p));
        let twins = table().twins;
        let tested = |c: &str| twins.iter().any(|t| t.code == c || t.also.iter().any(|a| a == c));
        let missing: Vec<_> = whyroad_label::check::CODES
            .iter()
            .chain(whyroad_framework::check::CODES)
            .filter(|c| !elsewhere(c) && !tested(c))
            .collect();
        assert!(missing.is_empty(), "{missing:?}");
    }
}

/// A label that passes, on one line, with its clip renamed.
fn label(clip: &str) -> String {
    let file = std::fs::read_to_string(root().join("examples/cutin_urgent_example.json")).unwrap();
    let mut v: Value = serde_json::from_str(&file).unwrap();
    v["clip_id"] = clip.into();
    v.to_string()
}

#[test]
fn the_examples_are_valid() {
    let o = validate(&root(), &["examples", "--format", "json"], b"");
    assert_eq!(code(&o), 0);
    // The drives' own tables lie in there too.
    assert!(codes(&o).iter().all(|c| c == "label.input.foreign"), "{}", text(&o.stdout));
    assert!(text(&o.stderr).starts_with("checked 5 documents, 5 valid: 0 errors"), "{}", text(&o.stderr));
    for name in ["cutin_urgent", "lane_change", "vru_crossing", "blind_spot"] {
        assert!(root().join(format!("examples/{name}_example.json")).is_file(), "{name}");
    }
}

/// A label of which no drive is there was not compared, and does not count as if it were.
#[test]
fn labels_of_drives_that_the_lake_lacks_are_named() {
    let dir = tempfile::tempdir().unwrap();
    let lake = dir.path().join("lake");
    let ingest = Command::new(env!("CARGO_BIN_EXE_whyroad"))
        .args(["ingest", "table", "examples/table/following", "--lake"])
        .arg(&lake)
        .current_dir(root())
        .output()
        .unwrap();
    assert!(ingest.status.success(), "{}", text(&ingest.stderr));
    let example = "examples/cutin_urgent_example.json";
    let args = [example, "--format", "json", "--lake", lake.to_str().unwrap()];
    let o = validate(&root(), &args, b"");
    assert_eq!((code(&o), codes(&o)), (0, vec!["label.clip.unrecorded".to_owned()]));
    assert!(codes(&validate(&root(), &args[..3], b"")).is_empty());
}

#[test]
fn a_broken_line_does_not_stop_the_rest() {
    let dir = tempfile::tempdir().unwrap();
    let good = label("a");
    let bad = label("b").replace("\"reactive\"", "\"instant\"");
    std::fs::write(dir.path().join("x.jsonl"), format!("{good}\n{{\"clip_id\": \n\n{bad}\n{good}")).unwrap();
    let o = validate(dir.path(), &["x.jsonl", "--format", "json"], b"");
    let all: Value = serde_json::from_slice(&o.stdout).unwrap();
    let places: Vec<(String, u64)> = all["diagnostics"]
        .as_array()
        .unwrap()
        .iter()
        .map(|d| (d["code"].as_str().unwrap().to_owned(), d["place"]["line"].as_u64().unwrap()))
        .collect();
    assert_eq!(places, [("label.json.syntax".to_owned(), 2), ("label.enum.keyframe_type".to_owned(), 4)]);
    assert_eq!((&all["documents"], &all["valid"]), (&4.into(), &2.into()));
}

#[test]
fn all_errors_of_a_document_are_said_at_once() {
    let broken = label("a")
        .replace("\"yield_to_agent\"", "\"brake\"")
        .replace("\"frame_idx\":94", "\"frame_idx\":\"x\"")
        .replace("\"urgent\"", "\"urgnt\"")
        .replace("2026-01-15T10:30:11.200Z", "yesterday");
    let o = validate(&root(), &["-", "--format", "json"], broken.as_bytes());
    assert_eq!(
        codes(&o),
        ["label.enum.longitudinal", "label.scenario.unknown", "label.time.format", "label.type"]
    );
}

#[test]
fn standard_input_arrays_and_folders_are_read() {
    let array = format!("[\n  {},\n  {}\n]\n", label("a"), label("b").replace("\"reactive\"", "\"instant\""));
    let o = validate(&root(), &["-", "--format", "json"], array.as_bytes());
    let all: Value = serde_json::from_slice(&o.stdout).unwrap();
    let place = &all["diagnostics"][0]["place"];
    assert_eq!(
        (&place["file"], &place["line"], &place["pointer"]),
        (&"<stdin>".into(), &3.into(), &"/1/keyframe/type".into())
    );

    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(dir.path().join("d/e")).unwrap();
    std::fs::write(dir.path().join("d/e/b.ndjson"), label("b")).unwrap();
    std::fs::write(dir.path().join("d/a.json"), label("a")).unwrap();
    std::fs::write(dir.path().join("d/notes.txt"), "not json").unwrap();
    let o = validate(dir.path(), &["d"], b"");
    assert_eq!((code(&o), text(&o.stderr).trim()), (0, "checked 2 documents, 2 valid: 0 errors, 0 warnings"));
}

#[test]
fn nothing_to_check_is_not_fine() {
    let dir = tempfile::tempdir().unwrap();
    let json = ["--format", "json"];
    for (args, expected) in [
        (vec!["."], vec!["label.input.empty", "label.input.nothing"]),
        (vec!["absent.json"], vec!["label.file.unreadable", "label.input.nothing"]),
        (vec!["-"], vec!["label.input.empty", "label.input.nothing"]),
    ] {
        let o = validate(dir.path(), &[&args[..], &json[..]].concat(), b" \n");
        assert_eq!(
            (codes(&o), code(&o)),
            (expected.iter().map(|s| (*s).to_owned()).collect(), 1),
            "{args:?}"
        );
    }
    // What cannot be read does not stop the rest.
    std::fs::write(dir.path().join("a.json"), label("a")).unwrap();
    let o = validate(dir.path(), &["absent.json", "a.json", "--format", "json"], b"");
    assert_eq!((codes(&o), code(&o)), (vec!["label.file.unreadable".to_owned()], 1));
    assert_eq!(code(&validate(dir.path(), &[], b"")), 2);
}

#[test]
fn foreign_files_in_a_folder_are_left_alone_but_not_among_labels() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("d")).unwrap();
    let foreign = "{\"rows\": 1}\n";
    std::fs::write(dir.path().join("d/table.jsonl"), foreign.repeat(3)).unwrap();
    let json = ["--format", "json"];
    let all = |o: &Output| -> Value { serde_json::from_slice(&o.stdout).unwrap() };
    // Alone in the folder: nothing was checked.
    let o = validate(dir.path(), &["d", json[0], json[1]], b"");
    assert_eq!(
        (codes(&o), code(&o)),
        (vec!["label.input.foreign".into(), "label.input.nothing".to_owned()], 1)
    );
    // Beside labels: a note. Named: errors.
    std::fs::write(dir.path().join("d/a.json"), label("a")).unwrap();
    let o = validate(dir.path(), &["d", json[0], json[1]], b"");
    assert_eq!(
        (codes(&o), code(&o), &all(&o)["documents"]),
        (vec!["label.input.foreign".to_owned()], 0, &1.into())
    );
    let o = validate(dir.path(), &["d/table.jsonl", json[0], json[1]], b"");
    assert_eq!((codes(&o), code(&o), &all(&o)["errors"]), (vec!["message.kind".to_owned()], 1, &3.into()));
    // Among labels in one file: errors.
    std::fs::write(dir.path().join("d/table.jsonl"), format!("{foreign}{}\n{foreign}", label("a"))).unwrap();
    let o = validate(dir.path(), &["d", json[0], json[1]], b"");
    assert_eq!(
        (codes(&o), &all(&o)["errors"], &all(&o)["documents"]),
        (vec!["message.kind".to_owned()], &2.into(), &4.into())
    );
}

#[test]
fn warnings_fail_only_when_denied() {
    let warned = label("a").replacen('{', "{\"weather\":\"rain\",", 1);
    assert_eq!(code(&validate(&root(), &["-"], warned.as_bytes())), 0);
    assert_eq!(code(&validate(&root(), &["-", "--deny-warnings"], warned.as_bytes())), 1);
}

#[test]
fn foreign_encodings_are_named() {
    let bom = format!("\u{FEFF}{}", label("a"));
    let o = validate(&root(), &["-", "--format", "json"], bom.as_bytes());
    assert_eq!((codes(&o), code(&o)), (vec!["label.json.bom".to_owned()], 0));
    // 0xB1EA is GBK (a character of "label"), and no UTF-8: a sequence cannot start with 0xB1.
    let gbk = label("@@").into_bytes();
    let at = gbk.iter().position(|b| *b == b'@').unwrap();
    let gbk = [&gbk[..at], &[0xB1, 0xEA], &gbk[at + 2..]].concat();
    let o = validate(&root(), &["-", "--format", "json"], &gbk);
    assert_eq!((codes(&o), code(&o)), (vec!["label.json.encoding".to_owned()], 1));
    let utf16: Vec<u8> =
        [0xFF, 0xFE].into_iter().chain(label("a").encode_utf16().flat_map(u16::to_le_bytes)).collect();
    let o = validate(&root(), &["-", "--format", "json"], &utf16);
    assert_eq!(codes(&o), ["label.input.empty", "label.input.nothing", "label.json.encoding"]);
}

/// What an annotator reads, in both languages and for machines.
mod snapshots {
    use super::*;

    fn broken() -> String {
        let file =
            std::fs::read_to_string(root().join("crates/whyroad/tests/fixtures/broken_labels/session.json"));
        file.unwrap()
    }

    fn session(args: &[&str]) -> String {
        let o = validate(&root(), &[&["-"], args].concat(), broken().as_bytes());
        format!("{}--- stderr\n{}--- exit {}\n", text(&o.stdout), text(&o.stderr), code(&o))
    }

    #[test]
    fn text_zh() {
        insta::assert_snapshot!(session(&["--lang", "zh"]));
    }

    #[test]
    fn text_en() {
        insta::assert_snapshot!(session(&["--lang", "en"]));
    }

    #[test]
    fn json() {
        insta::assert_snapshot!(session(&["--format", "json", "--lang", "zh"]));
    }

    #[test]
    fn sarif() {
        let out = session(&["--format", "sarif"]);
        let body = out.split("--- stderr").next().unwrap();
        let v: Value = serde_json::from_str(body).unwrap();
        assert_eq!((&v["version"], v["runs"].as_array().unwrap().len()), (&"2.1.0".into(), 1));
        insta::assert_snapshot!(out.replace(env!("CARGO_PKG_VERSION"), "[version]"));
    }
}
