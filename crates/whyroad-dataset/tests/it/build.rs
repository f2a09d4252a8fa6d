//! What a build makes of labels and drives.

use crate::fleet::{Fleet, Plan, content, label, plan};
use std::collections::{BTreeMap, BTreeSet};
use std::str::FromStr;
use std::sync::Arc;
use whyroad_dataset::licence::{BUNDLED, LicenceTable};
use whyroad_dataset::verify::{verify, verify_with};
use whyroad_dataset::{DatasetError, Release, Sample, SplitName};
use whyroad_engine::label_drives::LabelDrives;
use whyroad_framework::Framework;
use whyroad_label::check::Recordings;
use whyroad_model::ScenarioId;

fn samples(release: &Release) -> Vec<Sample> {
    release.samples(None).map(Result::unwrap).collect()
}

#[test]
fn samples_are_what_the_drives_say() {
    let fleet = Fleet::town();
    let out = fleet.out("release");
    let built = fleet.build(&out).unwrap();
    assert_eq!(built.manifest.counts.samples, 16);
    let release = Release::open(&out).unwrap();
    let all = samples(&release);
    assert_eq!(all.len(), 16);
    for s in &all {
        let i: f32 = s.lineage.drive_id.trim_start_matches("drive").parse().unwrap();
        let start = 6.0 + 3.7 * i;
        let speed = start + 0.3 * if s.l3.as_deref() == Some("urgent") { 5.0 } else { 15.0 };
        // By hand: v t + a t^2 / 2 with a = 0.3 m/s2, one second ahead and two seconds back.
        assert_eq!((s.history.t_s.len(), s.future.t_s.len()), (21, 60));
        assert!((s.future.x[9].unwrap() - (speed + 0.15)).abs() < 1e-3);
        assert!((s.history.x[0].unwrap() - (0.6 - 2.0 * speed)).abs() < 1e-3);
        assert_eq!(s.ego.reference, "rear_axle");
        // The lead is 20 m plus one second at the start ahead of the ego's box center, 1.4 m more from the rear axle.
        let lead = &s.objects[0];
        let now = lead.t_s.iter().position(|t| *t == 0.0).unwrap();
        assert!((lead.x[now].unwrap() - (20.0 + start + 1.4)).abs() < 1e-3);
        assert_eq!(lead.t_s.len(), 81);
        // Its center is 0.1 m above the ego's.
        assert!((lead.z[now].unwrap() - 0.1).abs() < 1e-6 && lead.z.len() == 81);
        assert_eq!(s.map.as_ref().unwrap()[0].kind, "lane");
        assert_eq!((s.lights.as_ref(), s.route.as_ref(), s.context.as_ref()), (None, None, None));
        assert_eq!((s.lineage.label_status.as_str(), s.lineage.checked), ("imported", false));
        assert_eq!(s.groups.date.as_deref(), Some("2026-01-15"));
        assert!(s.trace_en.is_some() && s.trace_zh.is_none());
    }
    let checked = verify(&out, Framework::bundled(), &LicenceTable::read(BUNDLED, "l").unwrap()).unwrap();
    assert_eq!(checked.diagnostics, [], "a fresh release has no finding");
    assert_eq!((checked.samples, checked.labels), (16, 16));
}

#[test]
fn two_builds_and_an_interrupted_one_have_equal_bytes() {
    let fleet = Fleet::town();
    let (a, b, c) = (fleet.out("a"), fleet.out("b"), fleet.out("c"));
    fleet.build(&a).unwrap();
    fleet.build(&b).unwrap();
    let first = content(&a);
    assert!(first.len() >= 12, "{:?}", first.keys());
    assert_eq!(first, content(&b));
    // Stopped after three drives, then after the files had been begun, then done.
    assert!(matches!(fleet.build_until(&c, 3), Err(DatasetError::Stopped)));
    assert!(matches!(fleet.build_until(&c, 9), Err(DatasetError::Stopped)));
    assert!(!c.exists(), "nothing appears before it is whole");
    let built = fleet.build(&c).unwrap();
    assert_eq!(built.resumed, 8);
    assert_eq!(content(&c), first);
    assert!(!fleet.out(".c.partial").exists());
    assert!(matches!(fleet.build(&c), Err(DatasetError::Exists(_))));
}

#[test]
fn work_of_other_inputs_is_not_mixed_in() {
    let mut fleet = Fleet::town();
    let out = fleet.out("release");
    assert!(fleet.build_until(&out, 3).is_err());
    let spec = std::mem::replace(&mut fleet.spec_text, "seed: 7\n".into());
    assert!(matches!(fleet.build(&out), Err(DatasetError::OtherWork(_))));
    // The same version of the framework with another text: drafts would say something else.
    fleet.spec_text = spec;
    let class = ScenarioId::from_str("reactive_agent.cutin.urgent").unwrap();
    fleet.framework.specs.remove(&class).unwrap();
    assert!(matches!(fleet.build(&out), Err(DatasetError::OtherWork(_))));
}

#[test]
fn a_release_does_not_depend_on_where_its_inputs_lie() {
    let mut fleet = Fleet::town();
    fleet.labels += "{not json\n";
    let (a, b) = (fleet.out("a"), fleet.out("b"));
    fleet.source = "/somewhere/labels.jsonl".into();
    fleet.build(&a).unwrap();
    fleet.source = "标签/labels.jsonl".into();
    fleet.build(&b).unwrap();
    assert_eq!(content(&a), content(&b));
}

#[test]
fn groups_are_never_separated_and_near_places_count_as_one() {
    // Pairs of drives share a session; streets of drive 6 and 7 are 3 m apart; all others are far apart.
    let mut plans: Vec<_> =
        (0..12).map(|i| plan(&format!("d{i}"), f64::from(i) * 200.0, 5.0 + 2.0 * f64::from(i))).collect();
    plans[7].street_m = plans[6].street_m + 3.0;
    for (i, p) in plans.iter_mut().enumerate().take(6) {
        p.session = Some(format!("s{}", i / 2));
    }
    let mut fleet = Fleet::new(&plans);
    // The same spot on both streets: at 5 s drive 6 is at x = 88.75 m, drive 7 at 4.5 s at 88.5 m.
    fleet.labels += &format!("{}\n", label(&plans[7], 4.5, "intersection"));
    fleet.spec_text = "split: {train: 0.5, val: 0.25, test: 0.25}\n".into();
    let built = fleet.build(&fleet.out("r")).unwrap();
    let release = Release::open(fleet.out("r")).unwrap();
    let mut of_drive: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for s in samples(&release) {
        of_drive.entry(s.lineage.drive_id).or_default().insert(s.split);
    }
    for pair in [["d0", "d1"], ["d2", "d3"], ["d4", "d5"], ["d6", "d7"]] {
        let both: BTreeSet<&String> = pair.iter().flat_map(|d| &of_drive[*d]).collect();
        assert_eq!(both.len(), 1, "{pair:?}: {both:?}");
    }
    let report = built.manifest.split;
    assert_eq!(report.components, 8);
    let without = samples(&release).iter().filter(|s| s.groups.session.is_none()).count();
    assert_eq!(report.unknown["session"], without);
    assert!(report.samples.values().all(|n| *n > 0), "{:?}", report.samples);
    let near: Vec<_> = report.distances.iter().filter(|d| d.within_m == 5.0).map(|d| d.share).collect();
    assert_eq!(near, [Some(0.0); 3]);
}

/// Every other drive repeats the drive before it: half of the samples are dropped as duplicates after the split.
#[test]
fn the_split_is_reported_of_the_release_and_not_of_the_stage() {
    let plans: Vec<_> =
        (0..8).map(|i| plan(&format!("d{i}"), f64::from(i) * 300.0, 6.0 + 4.0 * f64::from(i / 2))).collect();
    let fleet = Fleet::new(&plans);
    let built = fleet.build(&fleet.out("r")).unwrap();
    let manifest = built.manifest;
    assert_eq!(manifest.counts.samples, 8);
    let (split, by_split) = (&manifest.split, &manifest.counts.by_split);
    assert_eq!(&split.samples, by_split);
    assert!(split.shares.iter().all(|(s, share)| (share - by_split[s] as f64 / 8.0).abs() < 1e-9));
    let mut of_group: BTreeMap<u32, usize> = BTreeMap::new();
    for s in samples(&Release::open(fleet.out("r")).unwrap()) {
        *of_group.entry(s.groups.component).or_default() += 1;
    }
    assert_eq!(split.unknown["session"], 8);
    assert_eq!(split.components, of_group.len());
    assert_eq!(Some(&split.largest_component), of_group.values().max());
    let card = std::fs::read_to_string(fleet.out("r/README.md")).unwrap();
    assert!(card.contains(&format!(
        "| train | {} | {:.1} % |",
        by_split["train"],
        12.5 * by_split["train"] as f64
    )));
    let unknown = built.diagnostics.iter().find(|d| d.code == "dataset.group.unknown").unwrap();
    assert!(unknown.message.en.starts_with("8 samples"), "{}", unknown.message.en);
}

/// Two drives of one default clock share no day.
#[test]
fn drives_without_a_date_are_not_grouped_by_their_clock() {
    let plans: Vec<_> = [("a", true), ("b", true), ("c", false), ("d", false)]
        .into_iter()
        .enumerate()
        .map(|(i, (id, dated))| Plan { dated, ..plan(id, i as f64 * 200.0, 6.0 + 3.0 * i as f64) })
        .collect();
    let mut fleet = Fleet::new(&plans);
    fleet.spec_text = "split: {by: [date]}\n".into();
    let split = fleet.build(&fleet.out("r")).unwrap().manifest.split;
    assert_eq!((split.components, split.unknown["date"]), (3, 4));
    for s in samples(&Release::open(fleet.out("r")).unwrap()) {
        let dated = ["a", "b"].contains(&s.lineage.drive_id.as_str());
        assert_eq!(s.groups.date.as_deref(), dated.then_some("2026-01-15"));
    }
}

#[test]
fn without_place_groups_the_leak_of_places_is_reported() {
    // Two drives through the same street at speeds that bring them to the same spot at their keyframes.
    let mut fleet = Fleet::new(&[plan("a", 0.0, 10.0), plan("b", 0.5, 10.5)]);
    fleet.spec_text =
        "split: {train: 0.5, val: 0.5, test: 0, by: [drive]}\ndeduplicate: {near: null}\n".into();
    let built = fleet.build(&fleet.out("r")).unwrap();
    let near = built.manifest.split.distances.iter().find(|d| d.within_m == 5.0).unwrap();
    // At 5 s they are 2.5 m apart along the street, at 15 s 7.5 m, and always 0.5 m across.
    assert_eq!((near.samples, near.near), (2, 1));
}

#[test]
fn windows_beyond_the_drive_are_reported_and_never_padded() {
    let mut fleet = Fleet::new(&[plan("a", 0.0, 10.0)]);
    fleet.labels += &format!("{}\n", label(&plan("a", 0.0, 10.0), 1.0, "intersection"));
    fleet.labels += &format!("{}\n", label(&plan("a", 0.0, 10.0), 27.0, "congestion"));
    let built = fleet.build(&fleet.out("r")).unwrap();
    let dropped = &built.manifest.counts.dropped["2-sample"];
    assert_eq!((dropped["history"], dropped["future"]), (1, 1));
    assert!(built.diagnostics.iter().any(|d| d.code == "dataset.window.incomplete"));
    fleet.spec_text = "sample: {incomplete: keep}\ndeduplicate: {near: null}\n".into();
    fleet.build(&fleet.out("kept")).unwrap();
    let kept = samples(&Release::open(fleet.out("kept")).unwrap());
    assert_eq!(kept.len(), 4);
    let short = kept.iter().find(|s| s.l3.as_deref() == Some("intersection")).unwrap();
    assert!(!short.history.complete && short.history.x[0].is_none() && short.future.complete);
}

#[test]
fn drafts_are_taken_only_when_asked_for_and_marked() {
    let mut fleet = Fleet::town();
    let mut draft = label(&plan("drive0", 0.0, 6.0), 10.0, "intersection");
    draft["provenance"]["source"] = "model".into();
    fleet.labels += &format!("{draft}\n");
    let built = fleet.build(&fleet.out("without")).unwrap();
    assert_eq!(built.manifest.counts.dropped["1-select"]["draft"], 1);
    fleet.spec_text = "labels: {drafts: true}\n".into();
    let built = fleet.build(&fleet.out("with")).unwrap();
    assert_eq!(built.manifest.counts.by_status["draft"], 1);
    let release = Release::open(fleet.out("with")).unwrap();
    let marked: Vec<Sample> =
        samples(&release).into_iter().filter(|s| s.lineage.label_status == "draft").collect();
    assert_eq!(marked.len(), 1);
    assert!(!marked[0].lineage.checked);
}

/// A label of a plain file has no score: it is neither good nor bad, and the user is told.
#[test]
fn labels_without_a_score_do_not_pass_a_minimum_unnoticed() {
    let mut fleet = Fleet::town();
    let scored = |seconds: f64, score: f64| {
        let plan = plan("drive0", 0.0, 6.0);
        let label = label(&plan, seconds, "intersection");
        let episode = serde_json::json!({
            "episode_id": "e", "scenario_id": "reactive_agent.cutin.intersection", "drive_id": "drive0",
            "clip_id": label["clip_id"], "time_range": label["time_range"], "keyframe": label["keyframe"],
            "score": score, "is_primary": true, "keyframe_rule": {"zh": "", "en": ""}, "conditions_matched": [],
            "signals": [],
        });
        serde_json::json!({ "task": { "id": "t", "state": "accepted", "draft": label, "episode": episode } })
    };
    fleet.labels += &format!("{}\n{}\n", scored(10.0, 0.9), scored(12.0, 0.3));
    fleet.spec_text = "select: {min_score: 0.5}\n".into();
    let built = fleet.build(&fleet.out("r")).unwrap();
    let dropped = &built.manifest.counts.dropped["1-select"];
    assert_eq!((built.manifest.counts.samples, dropped["score"], dropped["score_unknown"]), (1, 1, 16));
    let warned = built.diagnostics.iter().find(|d| d.code == "dataset.score.unknown").unwrap();
    assert!(warned.message.en.starts_with("16 labels"), "{}", warned.message.en);
    // Without a minimum nothing is missed.
    fleet.spec_text.clear();
    let built = fleet.build(&fleet.out("all")).unwrap();
    assert!(!built.diagnostics.iter().any(|d| d.code == "dataset.score.unknown"));
}

/// What `whyroad dataset verify --lake` objects to in a fresh release is left out of it and counted: the ego of these
/// drives keeps its speed, and the labels say that it yields.
#[test]
fn labels_that_contradict_their_drives_are_left_out() {
    let mut fleet = Fleet::town();
    let drives: Arc<dyn Recordings> = Arc::new(LabelDrives::new(fleet.lake.clone(), &fleet.framework));
    fleet.spec_text = "deduplicate: {near: null}\n".into();
    let unchecked = fleet.build(&fleet.out("unchecked")).unwrap().manifest.counts.samples;
    let table = LicenceTable::read(BUNDLED, "licences.yaml").unwrap();
    let release = fleet.out("unchecked");
    let found = verify_with(&release, &fleet.framework, &table, Some(Arc::clone(&drives))).unwrap();
    let stale = found.diagnostics.iter().filter(|d| d.code == "dataset.label.stale");
    assert!(stale.count() > 0);
    fleet.recordings = Some(drives);
    let found = fleet.build(&fleet.out("checked")).unwrap_err().diagnostics();
    let said = |text: &str| found.iter().any(|d| d.message.en.contains(text));
    assert!(said(&format!("{unchecked} labels contradict the recording")), "{found:?}");
    assert!(said(&format!("contradicts_recording {unchecked}")), "{found:?}");
}

#[test]
fn caps_thin_the_training_split_but_not_below_a_floor() {
    let mut fleet = Fleet::town();
    fleet.spec_text =
        "split: {train: 1, val: 0, test: 0}\nbalance: {cap_leaf: 2, floor_leaf: 5, weight_exponent: 1}\n"
            .into();
    let built = fleet.build(&fleet.out("floor")).unwrap();
    let by = |class: &str| built.manifest.counts.by_class[&format!("reactive_agent.cutin.{class}")]["train"];
    assert_eq!((by("urgent"), by("slow")), (5, 5), "the floor holds against the cap");
    let short = &built.manifest.balance.shortfalls;
    assert!(
        short.iter().any(|s| s.scenario_id == "reactive_agent.cutin.ramp" && s.present == 0 && s.wanted == 5)
    );
    let release = Release::open(fleet.out("floor")).unwrap();
    let weights: Vec<f64> = samples(&release).iter().map(|s| s.weight).collect();
    let mean = weights.iter().sum::<f64>() / weights.len() as f64;
    assert!((mean - 1.0).abs() < 1e-9);
}

/// docs/reference/release.md, stage 5: a cell is leaf x decisions x place; all drives are in the place `town`, at
/// samples of two leaves with one decision, 8 and 4 of them in training.
#[test]
fn cells_are_of_the_place_and_not_of_the_grid_of_the_split() {
    let mut fleet = Fleet::town();
    let lines: Vec<String> = fleet.labels.lines().map(str::to_owned).collect();
    // 8 urgent, 4 slow.
    let kept = lines.iter().enumerate().filter(|(i, _)| i % 2 == 0 || *i < 8).map(|(_, l)| format!("{l}\n"));
    fleet.labels = kept.collect();
    // By hand: every cell weighs the same, 6 of 12 in sum. With a limit of 1.2 the smaller has 4.8 of 12, and the other
    // the rest; with one of 1 all weigh the same.
    for (limit, urgent, slow) in [(10.0, 0.75, 1.5), (1.2, 0.9, 1.2), (1.0, 1.0, 1.0)] {
        fleet.spec_text = format!(
            "split: {{train: 1, val: 0, test: 0}}\ndeduplicate: {{near: null}}\n\
             balance: {{weight_exponent: 1, max_weight: {limit}}}\n"
        );
        let out = fleet.out(&format!("limit-{limit}"));
        let built = fleet.build(&out).unwrap();
        assert_eq!(built.manifest.balance.cells, 2);
        for s in samples(&Release::open(out).unwrap()) {
            let expected = if s.l3.as_deref() == Some("urgent") { urgent } else { slow };
            assert!((s.weight - expected).abs() < 1e-9, "{limit}: {:?} {}", s.l3, s.weight);
        }
    }
    fleet.spec_text =
        "split: {train: 1, val: 0, test: 0}\ndeduplicate: {near: null}\nbalance: {cap_cell: 3}\n".into();
    let built = fleet.build(&fleet.out("capped")).unwrap();
    let by = |class: &str| built.manifest.counts.by_class[&format!("reactive_agent.cutin.{class}")]["train"];
    assert_eq!((by("urgent"), by("slow")), (3, 3));
}

/// docs/reference/release.md, *Spec*: with `split.keep` nothing of the earlier release changes its split, and what is
/// at a place of it is in the split of that place.
#[test]
fn the_splits_of_an_earlier_release_are_kept() {
    let shares = "split: {train: 0.5, val: 0.25, test: 0.25";
    let plans: Vec<_> =
        (0..12).map(|i| plan(&format!("d{i}"), f64::from(i) * 200.0, 5.0 + 2.0 * f64::from(i))).collect();
    let mut fleet = Fleet::new(&plans[..6]);
    fleet.spec_text = format!("{shares}}}\ndeduplicate: {{near: null}}\n");
    fleet.build(&fleet.out("first")).unwrap();
    let split_of = |name: &str| -> BTreeMap<String, String> {
        let all = samples(&Release::open(fleet.out(name)).unwrap());
        all.into_iter().map(|s| (s.sample_id, s.split)).collect()
    };
    let drive_of = |name: &str| -> BTreeMap<String, String> {
        let all = samples(&Release::open(fleet.out(name)).unwrap());
        all.into_iter().map(|s| (s.lineage.drive_id, s.split)).collect()
    };
    let (first, drives) = (split_of("first"), drive_of("first"));
    // Six drives more; `near` drives 2 m beside d0.
    let mut more = Fleet::new(&plans);
    let mut near = plan("near", plans[0].street_m + 2.0, plans[0].speed_mps);
    near.session = Some("new".into());
    more.lake.write_drive(&crate::fleet::drive(&near)).unwrap();
    more.labels += &format!("{}\n", label(&near, 5.0, "slow"));
    more.spec_text =
        format!("{shares}, keep: {}}}\ndeduplicate: {{near: null}}\n", fleet.out("first").display());
    let built = more.build(&more.out("second")).unwrap();
    let second: BTreeMap<String, String> = samples(&Release::open(more.out("second")).unwrap())
        .into_iter()
        .map(|s| (s.sample_id, s.split))
        .collect();
    assert!(second.len() > first.len() + 8, "{}", second.len());
    for (id, split) in &first {
        assert_eq!(second.get(id), Some(split), "{id}");
    }
    let all = samples(&Release::open(more.out("second")).unwrap());
    let near = all.iter().find(|s| s.lineage.drive_id == "near").unwrap();
    assert_eq!(near.split, drives["d0"]);
    let kept = built.manifest.split.kept.unwrap();
    assert_eq!((kept.name.as_str(), kept.samples, kept.between), ("release", 13, 0));
    let card = std::fs::read_to_string(more.out("second/README.md")).unwrap();
    assert!(card.contains(&kept.manifest_sha256), "the card states which release");

    // A drive half-way between two streets of different splits, 100 m from each, where 150 m are one place.
    let split = |i: usize| &drives[&format!("d{i}")];
    let i = (0..5).find(|&i| split(i) != split(i + 1)).unwrap();
    let bridge = plan("bridge", plans[i].street_m + 100.0, 9.0);
    let mut joined = Fleet::new(&plans[..6]);
    joined.lake.write_drive(&crate::fleet::drive(&bridge)).unwrap();
    joined.labels += &format!("{}\n", label(&bridge, 5.0, "slow"));
    joined.spec_text = format!(
        "{shares}, min_distance_m: 150, by: [drive, place], keep: {}}}\ndeduplicate: {{near: null}}\n",
        fleet.out("first").display()
    );
    let built = joined.build(&joined.out("r")).unwrap();
    let kept = built.manifest.split.kept.unwrap();
    assert_eq!((kept.between, built.manifest.counts.dropped["3-split"]["between_kept"]), (1, 1));
    assert!(built.diagnostics.iter().any(|d| d.code == "dataset.split.keep"));
    // Groups that join splits of the earlier release are an error: nothing can hold them.
    joined.spec_text = format!("split: {{by: [date], keep: {}}}\n", fleet.out("first").display());
    let refused = joined.build(&joined.out("torn")).unwrap_err();
    assert_eq!(refused.diagnostics().iter().map(|d| d.code).collect::<Vec<_>>(), ["dataset.split.keep"]);
}

#[test]
fn shards_are_equal_and_bev_images_are_in_them() {
    let mut fleet = Fleet::town();
    fleet.spec_text = "samples_per_shard: 5\nsplit: {train: 1, val: 0, test: 0}\n\
        sample: {images: bev, bev_size_px: 64, bev_m_per_px: 1}\n"
        .into();
    let built = fleet.build(&fleet.out("r")).unwrap();
    let sizes: Vec<usize> = built.manifest.files.iter().filter_map(|f| f.samples).collect();
    assert_eq!(sizes, [4, 4, 4, 4]);
    let release = Release::open(fleet.out("r")).unwrap();
    for s in release.samples(Some(SplitName::Train)) {
        let s = s.unwrap();
        assert_eq!(s.images.iter().map(|i| i.t_s).collect::<Vec<_>>(), [-0.3, -0.2, -0.1, 0.0]);
        assert!(s.images.iter().all(|i| i.camera == "bev" && i.bytes.starts_with(b"\x89PNG")));
    }
}

/// A keyframe 1 s after the start of its drive has no image of 1.5 s before it: no folder of images helps.
#[test]
fn an_image_time_before_the_drive_is_said_to_be_that() {
    let mut fleet = Fleet::new(&[plan("a", 0.0, 10.0)]);
    fleet.labels += &format!("{}\n", label(&plan("a", 0.0, 10.0), 1.0, "intersection"));
    fleet.spec_text = "sample: {images: bev, image_times_s: [-1.5, 0], bev_size_px: 64, bev_m_per_px: 1, \
        incomplete: keep}\n"
        .into();
    let built = fleet.build(&fleet.out("r")).unwrap();
    assert_eq!(built.manifest.counts.dropped["2-sample"]["image_before_drive"], 1);
    let found: Vec<_> = built.diagnostics.iter().filter(|d| d.code == "dataset.image.missing").collect();
    let [d] = found[..] else { panic!("{found:?}") };
    let hint = d.hint.as_ref().unwrap();
    assert!(d.message.en.contains("before the start") && hint.en.contains("image_times_s"), "{d:?}");
    assert!(!hint.en.contains("--media"), "{}", hint.en);
}

#[test]
fn every_code_has_a_page() {
    let pages = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/diagnostics");
    let codes: Vec<&str> =
        whyroad_dataset::CODES.iter().chain(whyroad_dataset::spec::CODES).copied().collect();
    assert!(codes.len() > 30);
    for code in codes {
        assert!(pages.join(format!("{code}.md")).is_file(), "{code} has no page");
    }
}
