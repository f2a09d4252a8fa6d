//! Faults that are put into inputs and finished releases: each must be refused or found.

use crate::fleet::{Fleet, content, plan};
use std::path::Path;
use whyroad_dataset::DatasetError;
use whyroad_dataset::licence::{BUNDLED, LicenceTable};
use whyroad_dataset::verify::verify;
use whyroad_framework::Framework;
use whyroad_model::Severity;

fn codes(release: &Path) -> Vec<&'static str> {
    let table = LicenceTable::read(BUNDLED, "licences.yaml").unwrap();
    let mut codes: Vec<&str> =
        verify(release, Framework::bundled(), &table).unwrap().diagnostics.iter().map(|d| d.code).collect();
    codes.sort_unstable();
    codes.dedup();
    codes
}

fn refusal(fleet: &Fleet) -> Vec<&'static str> {
    match fleet.build(&fleet.out("refused")) {
        Err(DatasetError::Refused(found)) => found.iter().map(|d| d.code).collect(),
        other => panic!("not refused: {other:?}"),
    }
}

#[test]
fn unknown_and_forbidden_licences_are_refused() {
    let with = |licence: Option<&str>, spec: &str| {
        let mut plans = vec![plan("a", 0.0, 10.0), plan("b", 500.0, 15.0)];
        plans[1].licence = licence.map(str::to_owned);
        let mut fleet = Fleet::new(&plans);
        fleet.spec_text = spec.into();
        fleet
    };
    assert_eq!(refusal(&with(None, "")), ["dataset.licence.unknown"]);
    assert_eq!(refusal(&with(Some("Beerware"), "")), ["dataset.licence.unknown"]);
    let commercial = "licences: {purpose: commercial}\n";
    assert_eq!(refusal(&with(Some("CC-BY-NC-SA-4.0"), commercial)), ["dataset.licence.forbidden"]);
    // What allow leaves out is a matter of selection, not of refusal.
    let fleet = with(Some("CC-BY-NC-SA-4.0"), "licences: {allow: [Apache-2.0]}\n");
    let built = fleet.build(&fleet.out("r")).unwrap();
    assert_eq!(built.manifest.counts.dropped["1-select"]["licence"], 2);
    assert_eq!(built.manifest.licence, "Apache-2.0");
}

#[test]
fn a_changed_missing_or_extra_file_is_found() {
    let fleet = Fleet::town();
    let out = fleet.out("release");
    fleet.build(&out).unwrap();
    let data = content(&out).into_keys().find(|name| name.starts_with("data/train")).unwrap();
    let mut bytes = std::fs::read(out.join(&data)).unwrap();
    let whole = bytes.clone();
    // One bit in the middle: the file may still be readable, its hash is another.
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(out.join(&data), &bytes).unwrap();
    assert!(codes(&out).contains(&"dataset.file.hash"));
    std::fs::remove_file(out.join(&data)).unwrap();
    assert_eq!(codes(&out), ["dataset.file.missing"]);
    std::fs::write(out.join(&data), &whole).unwrap();
    std::fs::write(out.join("data/train-more.parquet"), &whole).unwrap();
    assert_eq!(codes(&out), ["dataset.file.extra"]);
    std::fs::remove_file(out.join("data/train-more.parquet")).unwrap();
    assert_eq!(codes(&out), [""; 0]);
    let card = std::fs::read_to_string(out.join("manifest.json")).unwrap();
    std::fs::write(out.join("manifest.json"), card.replace("\"seed\": 0", "\"seed\": 1")).unwrap();
    assert_eq!(codes(&out), ["dataset.file.hash"]);
}

#[test]
fn a_file_damaged_anywhere_is_found_and_reading_it_ends() {
    let fleet = Fleet::town();
    let out = fleet.out("release");
    fleet.build(&out).unwrap();
    let data = content(&out).into_keys().find(|name| name.starts_with("data/train")).unwrap();
    let whole = std::fs::read(out.join(&data)).unwrap();
    for position in (100..whole.len()).step_by(whole.len() / 40) {
        let mut bytes = whole.clone();
        bytes[position] = !bytes[position];
        std::fs::write(out.join(&data), &bytes).unwrap();
        let found = codes(&out);
        assert!(found.contains(&"dataset.file.hash"), "byte {position}: {found:?}");
        // Besides, the file that cannot be read and the samples that it lacks, each said once.
        assert!(found.len() <= 4, "byte {position}: {found:?}");
    }
}

#[test]
fn a_draft_of_a_class_that_the_framework_does_not_have_is_found() {
    let mut fleet = Fleet::new(&[plan("a", 0.0, 10.0), plan("b", 500.0, 16.0)]);
    // Drafts by a model, without causes: they need not be complete.
    let lines = std::mem::take(&mut fleet.labels);
    for line in lines.lines() {
        let mut label: serde_json::Value = serde_json::from_str(line).unwrap();
        label["provenance"]["source"] = "model".into();
        label["causes"]["longitudinal"] = serde_json::json!({});
        fleet.labels += &format!("{label}\n");
    }
    fleet.spec_text = "labels: {drafts: true}\n".into();
    let out = fleet.out("release");
    fleet.build(&out).unwrap();
    let table = LicenceTable::read(BUNDLED, "licences.yaml").unwrap();
    let found = verify(&out, Framework::bundled(), &table).unwrap();
    assert_eq!((found.samples, found.labels, found.drafts), (4, 0, 4));
    assert_eq!(found.diagnostics, []);
    // The framework loses one leaf, of which every drive has a draft.
    let mut framework = Framework::bundled().clone();
    for l1 in &mut framework.taxonomy.l1 {
        for l2 in l1.l2.iter_mut().filter(|l2| l2.id == "cutin") {
            l2.l3.retain(|l3| l3.id != "urgent");
        }
    }
    let found = verify(&out, &framework, &table).unwrap();
    let codes: Vec<&str> = found.diagnostics.iter().map(|d| d.code).collect();
    assert_eq!(codes, ["dataset.label.stale"; 2]);
}

#[test]
fn a_leak_between_splits_is_found() {
    // A release whose test file is a copy of its training file, with a manifest that agrees: only reading finds it.
    let fleet = Fleet::town();
    let out = fleet.out("release");
    fleet.build(&out).unwrap();
    let names: Vec<String> = content(&out).into_keys().filter(|n| n.starts_with("data/")).collect();
    let of = |split: &str| names.iter().find(|n| n.starts_with(&format!("data/{split}-"))).unwrap().clone();
    std::fs::copy(out.join(of("train")), out.join(of("test"))).unwrap();
    let found = codes(&out);
    for code in
        ["dataset.split.leak", "dataset.sample.repeated", "dataset.split.near", "dataset.duplicate.across"]
    {
        assert!(found.contains(&code), "{code} is not in {found:?}");
    }
}

#[test]
fn a_near_duplicate_across_splits_never_reaches_training() {
    // Two drives alike in all but their street, far apart, with room for each to be in another split.
    let mut plans: Vec<_> = (0..8).map(|i| plan(&format!("d{i}"), f64::from(i) * 300.0, 12.0)).collect();
    plans[7].speed_mps = 30.0;
    let mut fleet = Fleet::new(&plans);
    fleet.spec_text = "split: {train: 0.5, val: 0.25, test: 0.25}\ndeduplicate: {exact: false}\n".into();
    let built = fleet.build(&fleet.out("r")).unwrap();
    let dropped = &built.manifest.counts.dropped["4-deduplicate"];
    assert!(dropped.get("duplicate_across").is_some_and(|n| *n > 0), "{dropped:?}");
    assert_eq!(codes(&fleet.out("r")), [""; 0]);
    fleet.spec_text = "split: {train: 0.5, val: 0.25, test: 0.25}\n".into();
    let built = fleet.build(&fleet.out("exact")).unwrap();
    assert!(built.manifest.deduplicate.exact >= 10, "{:?}", built.manifest.deduplicate);
}

#[test]
fn a_split_that_loses_all_its_samples_as_duplicates_is_reported() {
    let mut fleet = Fleet::new(&[plan("a", 0.0, 12.0), plan("b", 300.0, 12.0)]);
    fleet.spec_text = "split: {train: 0.5, val: 0.5, test: 0, by: [drive]}\n".into();
    let built = fleet.build(&fleet.out("r")).unwrap();
    assert_eq!(built.manifest.counts.by_split.get("train"), Some(&0));
    let empty: Vec<_> = built.diagnostics.iter().filter(|d| d.code == "dataset.split.empty").collect();
    assert!(matches!(empty[..], [d] if d.message.en.starts_with("split train is empty: its")), "{empty:?}");
}

#[test]
fn a_label_that_no_longer_validates_is_found() {
    let fleet = Fleet::town();
    let out = fleet.out("release");
    fleet.build(&out).unwrap();
    // The framework moves on: the leaf is called something else now.
    let mut files = Framework::bundled_files();
    let taxonomy = files.get_mut("schema/scenario_taxonomy.yaml").unwrap();
    *taxonomy = taxonomy.replace("id: \"urgent\"", "id: \"imminent\"");
    let (framework, _) = Framework::from_files(&files);
    let table = LicenceTable::read(BUNDLED, "licences.yaml").unwrap();
    let found = verify(&out, &framework.unwrap(), &table).unwrap();
    let codes: Vec<&str> = found.diagnostics.iter().map(|d| d.code).collect();
    assert!(!codes.is_empty() && codes.iter().all(|c| *c == "dataset.label.stale"), "{codes:?}");
}

#[test]
fn invalid_lines_are_dropped_with_their_reason() {
    let mut fleet = Fleet::town();
    fleet.labels += "{not json\n{\"foo\": 1}\n";
    fleet.labels = fleet.labels.replacen("\"yield_to_agent\"", "\"yield\"", 1);
    let built = fleet.build(&fleet.out("r")).unwrap();
    let dropped = &built.manifest.counts.dropped["1-select"];
    assert_eq!((dropped["unreadable"], dropped["invalid_label"]), (2, 1));
    assert_eq!(built.diagnostics.iter().filter(|d| d.code == "dataset.labels.line").count(), 2);
    // As for other losses, with place and remedy (docs/diagnostics/dataset.labels.invalid.md).
    let invalid: Vec<_> = built.diagnostics.iter().filter(|d| d.code == "dataset.labels.invalid").collect();
    let [d] = invalid[..] else { panic!("{invalid:?}") };
    assert_eq!(d.location.file.as_deref(), Some("labels.jsonl:1"));
    assert!(d.hint.as_ref().unwrap().en.contains("whyroad validate"));
}

/// Unknown is not fine: a lake without the drives says nothing about the labels.
#[test]
fn labels_without_a_recording_are_counted_as_not_compared() {
    struct Nothing;
    impl whyroad_label::check::Recordings for Nothing {
        fn of_clip(&self, _: &str) -> Option<std::sync::Arc<whyroad_label::check::Recorded>> {
            None
        }
    }
    let fleet = Fleet::town();
    fleet.build(&fleet.out("r")).unwrap();
    let table = LicenceTable::read(BUNDLED, "licences.yaml").unwrap();
    let none = std::sync::Arc::new(Nothing);
    let checked = whyroad_dataset::verify::verify_with;
    let found = checked(&fleet.out("r"), Framework::bundled(), &table, Some(none)).unwrap();
    assert_eq!((found.labels, found.compared), (16, Some([0, 16])));
    let codes: Vec<&str> = found.diagnostics.iter().map(|d| d.code).collect();
    assert_eq!(codes, ["dataset.label.uncompared"]);
    assert!(found.diagnostics[0].message.en.contains("8 drives"), "{:?}", found.diagnostics);
    let found = checked(&fleet.out("r"), Framework::bundled(), &table, None).unwrap();
    assert_eq!((found.compared, found.diagnostics.len()), (None, 0));
}

/// Of a release with a missing file the rest is checked, and nothing is said to be zero.
#[test]
fn a_release_with_a_missing_file_is_read_as_far_as_it_is_there() {
    let mut fleet = Fleet::town();
    fleet.spec_text = "samples_per_shard: 4\nsplit: {train: 1, val: 0, test: 0}\n".into();
    let out = fleet.out("r");
    fleet.build(&out).unwrap();
    let data = content(&out).into_keys().find(|name| name.starts_with("data/train")).unwrap();
    std::fs::remove_file(out.join(&data)).unwrap();
    let table = LicenceTable::read(BUNDLED, "licences.yaml").unwrap();
    let found = verify(&out, Framework::bundled(), &table).unwrap();
    assert_eq!((found.samples, found.stated, found.labels), (12, 16, 12));
    let codes: Vec<&str> = found.diagnostics.iter().map(|d| d.code).collect();
    assert_eq!(codes, ["dataset.file.missing"]);
    assert!(found.diagnostics[0].hint.is_some());
}

/// `diff` names what `lineage` says of a label, not only its content: a release from an export lost its checks.
#[test]
fn releases_with_other_facts_about_their_labels_differ() {
    let mut fleet = Fleet::town();
    fleet.build(&fleet.out("plain")).unwrap();
    let task = |(i, label): (usize, &str)| {
        let label: serde_json::Value = serde_json::from_str(label).unwrap();
        let task = serde_json::json!({ "id": format!("t{i}"), "state": "accepted", "draft": label });
        format!("{}\n", serde_json::json!({ "task": task }))
    };
    fleet.labels = fleet.labels.lines().enumerate().map(task).collect();
    fleet.build(&fleet.out("tasks")).unwrap();
    let open = |name: &str| whyroad_dataset::Release::open(fleet.out(name)).unwrap();
    let d = whyroad_dataset::diff::diff(&open("tasks"), &open("plain")).unwrap();
    assert_eq!((d.relabelled.len(), d.restated.len()), (0, 16));
    assert!(d.restated.iter().all(|(_, a, b)| (a.as_str(), b.as_str()) == ("accepted", "imported")));
    assert_eq!((d.facts["checked"], d.facts["task_id"], d.facts.get("score")), (16, 16, None));
}

/// Reading a pipe or a device does not end, and a link to a folder may lead out of the release or in a circle.
#[cfg(unix)]
#[test]
fn what_is_no_file_is_not_read() {
    let fleet = Fleet::town();
    let out = fleet.out("release");
    fleet.build(&out).unwrap();
    std::os::unix::fs::symlink("/", out.join("data/root")).unwrap();
    assert_eq!(codes(&out), ["dataset.file.extra"]);
    std::fs::remove_file(out.join("data/root")).unwrap();
    let data = content(&out).into_keys().find(|name| name.starts_with("data/train")).unwrap();
    std::fs::remove_file(out.join(&data)).unwrap();
    std::os::unix::fs::symlink("/dev/zero", out.join(&data)).unwrap();
    assert_eq!(codes(&out), ["dataset.file.missing"]);
    std::fs::remove_file(out.join("checksums.sha256")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", out.join("checksums.sha256")).unwrap();
    assert_eq!(codes(&out), ["dataset.file.hash", "dataset.file.missing"]);
    // A path that leads out of the release is refused before anything is read.
    let manifest = out.join("manifest.json");
    let text = std::fs::read_to_string(&manifest).unwrap().replace(&data, "../../../dev/zero");
    std::fs::write(&manifest, text).unwrap();
    let table = LicenceTable::read(BUNDLED, "licences.yaml").unwrap();
    assert!(matches!(verify(&out, Framework::bundled(), &table), Err(DatasetError::Broken { .. })));
    std::fs::remove_file(&manifest).unwrap();
    std::os::unix::fs::symlink("/dev/zero", &manifest).unwrap();
    assert!(verify(&out, Framework::bundled(), &table).is_err());
}

#[test]
fn a_second_build_into_the_same_folder_is_refused_while_the_first_one_works() {
    let fleet = Fleet::town();
    let out = fleet.out("release");
    let first = std::sync::OnceLock::new();
    let built = fleet.build_with(&out, &|_, done, _| {
        // Once in the middle of the first build.
        first.get_or_init(|| (done, fleet.build(&out)));
        true
    });
    assert!(matches!(first.get(), Some((_, Err(DatasetError::Busy(_))))), "{first:?}");
    assert_eq!(built.unwrap().manifest.counts.samples, 16, "the first one is not disturbed");
    assert_eq!(codes(&out), [""; 0]);
}

#[test]
fn lines_that_are_no_text_are_reported_and_the_others_are_built() {
    let mut fleet = Fleet::town();
    fleet.more_lines = b"\xff\xfe{}\n".to_vec();
    let built = fleet.build(&fleet.out("r")).unwrap();
    assert_eq!(built.manifest.counts.samples, 16);
    let found: Vec<_> = built.diagnostics.iter().filter(|d| d.code == "dataset.labels.line").collect();
    assert!(matches!(found[..], [d] if d.message.en.starts_with("not UTF-8")), "{found:?}");
}

#[test]
fn a_release_without_samples_is_refused() {
    let mut fleet = Fleet::town();
    fleet.spec_text = "sample: {future_s: 60}\n".into();
    assert_eq!(refusal(&fleet), ["dataset.window.incomplete", "dataset.samples.none"]);
    assert!(!fleet.out("refused").exists());
    fleet.labels.clear();
    assert_eq!(refusal(&fleet), ["dataset.labels.none"]);
}

#[test]
fn a_spec_that_names_what_does_not_exist_is_refused_or_warned_of() {
    let mut fleet = Fleet::town();
    fleet.spec_text = "licences: {allow: [Apache-2.0, Beerware]}\n".into();
    assert_eq!(refusal(&fleet), ["dataset.licence.unknown"]);
    // Sources and places of the fleet are `fleet` and `town`.
    fleet.spec_text = "select: {sources: [fleat], places: [town, nowhere]}\n".into();
    let Err(DatasetError::Refused(found)) = fleet.build(&fleet.out("refused")) else { panic!("not refused") };
    let said: Vec<_> = found.iter().map(|d| (d.code, d.hint.as_ref().unwrap().en.as_str())).collect();
    let code = "dataset.select.unknown";
    assert_eq!(said, [(code, "did you mean 'fleet'?")]);
    // Beside a name that is known: a spec for several lakes.
    fleet.spec_text = "select: {sources: [fleet], places: [town, nowhere, unknown]}\n".into();
    let built = fleet.build(&fleet.out("selected")).unwrap();
    assert_eq!(built.manifest.counts.samples, 16);
    let warned: Vec<_> = built.diagnostics.iter().filter(|d| d.code == code).collect();
    assert_eq!(warned.len(), 1);
    assert_eq!(
        (warned[0].severity, warned[0].hint.as_ref().unwrap().en.as_str()),
        (Severity::Warning, "known: town")
    );
    let unused = |spec: &str| {
        let mut fleet = Fleet::town();
        fleet.spec_text = spec.into();
        let built = fleet.build(&fleet.out("r")).unwrap();
        built.diagnostics.iter().filter(|d| d.code == "dataset.polygon.unused").count()
    };
    let square = "points: [[-1000, -1000], [9000, -1000], [9000, 250], [-1000, 250]]";
    assert_eq!(unused(&format!("split: {{polygons: [{{name: south, place: town, {square}}}]}}\n")), 0);
    assert_eq!(unused(&format!("split: {{polygons: [{{name: south, place: twon, {square}}}]}}\n")), 1);
    assert_eq!(
        unused(&format!("split: {{by: [drive], polygons: [{{name: south, place: town, {square}}}]}}\n")),
        1
    );
}
