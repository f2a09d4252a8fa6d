//! A release whose classes are renamed or split: checked by the same `verify` as any other, with the new framework.

use crate::fleet::{Fleet, content};
use std::collections::{BTreeMap, BTreeSet};
use whyroad_dataset::carry::{UNDECIDED, carry_release};
use whyroad_dataset::licence::{BUNDLED, LicenceTable};
use whyroad_dataset::verify::verify;
use whyroad_dataset::{DatasetError, Release, Sample};
use whyroad_framework::Framework;
use whyroad_framework::mapping::{ClassChange, ClassMapping, SplitPart};
use whyroad_model::ScenarioId;

fn id(text: &str) -> ScenarioId {
    text.parse().unwrap()
}

fn samples(release: &Release) -> Vec<Sample> {
    release.samples(None).map(Result::unwrap).collect()
}

/// `urgent` is called `imminent` now.
fn renamed() -> (Framework, ClassMapping) {
    let mut files = Framework::bundled_files();
    let taxonomy = files.get_mut("schema/scenario_taxonomy.yaml").unwrap();
    *taxonomy = taxonomy.replace("id: \"urgent\"", "id: \"imminent\"");
    let change = ClassChange::To(id("reactive_agent.cutin.imminent"));
    let mapping = ClassMapping {
        from: "2.0.0".into(),
        to: "3.0.0".into(),
        changes: [(id("reactive_agent.cutin.urgent"), change)].into(),
        mark: "00000000000000aa".into(),
        ..ClassMapping::default()
    };
    (Framework::from_files(&files).0.unwrap(), mapping)
}

#[test]
fn a_renamed_class_gives_a_release_that_verifies() {
    let fleet = Fleet::town();
    let (old, new) = (fleet.out("old"), fleet.out("new"));
    fleet.build(&old).unwrap();
    let before = content(&old);
    let release = Release::open(&old).unwrap();
    let (framework, mapping) = renamed();
    let dry = carry_release(&release, &mapping, None).unwrap();
    let done = carry_release(&release, &mapping, Some(&new)).unwrap();
    assert_eq!(dry, done);
    assert_eq!(content(&old), before, "the old release is not touched");
    let urgent = samples(&release).iter().filter(|s| s.l3.as_deref() == Some("urgent")).count() as u64;
    assert!(urgent > 0);
    let moved = &done.moved["reactive_agent.cutin.urgent"];
    assert_eq!(moved, &BTreeMap::from([("reactive_agent.cutin.imminent".to_owned(), urgent)]));
    assert_eq!(done.samples, 16);
    let table = LicenceTable::read(BUNDLED, "licences.yaml").unwrap();
    let checked = verify(&new, &framework, &table).unwrap();
    assert_eq!(checked.diagnostics, []);
    let carried = Release::open(&new).unwrap();
    assert_eq!(carried.manifest.versions["taxonomy"], "3.0.0");
    let class = &carried.manifest.counts.by_class["reactive_agent.cutin.imminent"];
    assert_eq!(class.values().sum::<usize>() as u64, urgent);
    // Everything but the class is as it was: split, motion, drive.
    let key = |s: &Sample| (s.lineage.drive_id.clone(), s.lineage.keyframe_time_ns, s.split.clone());
    let all = |r: &Release| samples(r).iter().map(key).collect::<BTreeSet<_>>();
    assert_eq!(all(&carried), all(&release));
    // Again: nothing to do, and an existing folder is not written into.
    let again = carry_release(&carried, &mapping, None).unwrap();
    assert!(again.moved.is_empty() && again.undecided.is_empty());
    assert!(matches!(carry_release(&release, &mapping, Some(&new)), Err(DatasetError::Exists(_))));
}

#[test]
fn what_a_split_leaves_open_is_left_out_and_listed() {
    let fleet = Fleet::town();
    let (old, new) = (fleet.out("old"), fleet.out("new"));
    fleet.build(&old).unwrap();
    let release = Release::open(&old).unwrap();
    let (_, mut mapping) = renamed();
    let part = |to: &str| SplitPart { to: id(to), when: BTreeMap::new() };
    let parts = vec![part("reactive_agent.cutin.slow"), part("reactive_agent.cutin.ramp")];
    mapping.changes = [(id("reactive_agent.cutin.urgent"), ClassChange::Split(parts))].into();
    let done = carry_release(&release, &mapping, Some(&new)).unwrap();
    let urgent = samples(&release).iter().filter(|s| s.l3.as_deref() == Some("urgent")).count();
    assert_eq!((done.undecided.len(), done.samples), (urgent, 16 - urgent));
    let carried = Release::open(&new).unwrap();
    assert_eq!(samples(&carried).len(), 16 - urgent);
    assert_eq!(carried.manifest.split.samples, carried.manifest.counts.by_split);
    assert_eq!(carried.manifest.counts.dropped["6-migrate"]["undecided"], urgent);
    let listed = std::fs::read_to_string(new.join(UNDECIDED)).unwrap();
    assert_eq!(listed.lines().count(), urgent);
    let table = LicenceTable::read(BUNDLED, "licences.yaml").unwrap();
    assert_eq!(verify(&new, Framework::bundled(), &table).unwrap().diagnostics, []);
}
