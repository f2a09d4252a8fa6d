use super::*;
use std::path::Path;
use whyroad_ingest::{Options, find_sources, read};

/// The lake with the demo's drives.
fn lake(dir: &Path) -> Lake {
    let lake = Lake::create_or_open(dir.join("lake")).unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/drives");
    let folders = ["back_street", "multilane", "signal_junction"].map(|n| root.join(n));
    for source in find_sources(None, &folders).0 {
        lake.write_drive(&read(&source, &Options::default()).0.unwrap()).unwrap();
    }
    lake
}

#[test]
fn what_is_kept_changes_no_answer() {
    let dir = tempfile::tempdir().unwrap();
    let lake = lake(dir.path());
    let ids = lake.drive_ids();
    assert_eq!(ids.len(), 3);
    let drives = |bytes| LabelDrives::keeping(bytes, lake.clone(), Framework::bundled());
    let (all, none) = (drives(KEPT_BYTES), drives(0));
    // Each drive and moment twice, in an order in which no two neighbors are of one drive.
    for round in 0..2 {
        for step in 1..5 {
            for id in &ids {
                let clip = format!("{id}_000");
                let whole = lake.read_drive(id).unwrap();
                let keyframe = whole.times[whole.times.len() * step / 5];
                let [a, b] = [&all, &none].map(|d| d.of_clip(&clip).unwrap());
                assert_eq!(format!("{a:?}"), format!("{b:?}"), "{clip}, round {round}");
                assert!(Arc::ptr_eq(&a, &all.of_clip(&clip).unwrap()), "read once");
                assert!(!a.episodes.is_empty());
                let [a, b] = [&all, &none].map(|d| d.until(&clip, keyframe).unwrap());
                let cut = history(&whole, keyframe).unwrap();
                assert_eq!(format!("{a:?}"), format!("{b:?}"), "{clip} until {keyframe}");
                assert_eq!(format!("{a:?}"), format!("{cut:?}"), "{clip} until {keyframe}");
            }
        }
    }
}

#[test]
fn a_drive_that_is_replaced_is_read_again() {
    let dir = tempfile::tempdir().unwrap();
    let lake = lake(dir.path());
    let drives = LabelDrives::new(lake.clone(), Framework::bundled());
    let id = &lake.drive_ids()[0];
    let clip = format!("{id}_000");
    assert!(drives.of_clip("nothing_000").is_none() && drives.until("nothing_000", Nanos(0)).is_none());
    let before = drives.of_clip(&clip).unwrap().drive.times.len();
    let mut shorter = lake.read_drive(id).unwrap().until_frame(before / 2);
    shorter.meta.content_hash = "other".into();
    lake.write_drive(&shorter).unwrap();
    assert_eq!(drives.of_clip(&clip).unwrap().drive.times.len(), before / 2);
}
