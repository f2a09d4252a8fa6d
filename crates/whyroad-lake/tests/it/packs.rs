//! Packed drives are read as loose ones are; whatever happens to a compaction, every drive is there once.

use crate::folders::{copy, files};
use crate::round_trip::{drive, shown, small_drive};
use crate::signals::{SHARED, one, same_columns, shared, table, with_equal_columns};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use whyroad_lake::{CompactionOptions, DriveFacts, Lake, WriteOutcome};
use whyroad_model::scene::MediaFrame;
use whyroad_model::{Drive, DriveId, Nanos, Need, SignalTable};

const VERSION: &str = "v1";

fn options(drives: usize) -> CompactionOptions {
    CompactionOptions { pack_drives: drives, ..CompactionOptions::default() }
}

fn compact(lake: &Lake, drives: usize) -> whyroad_lake::Compaction {
    let done = lake.compact(&options(drives), |_, _| ()).unwrap();
    assert!(done.left.is_empty(), "{:?}", done.left);
    done
}

fn small(id: &str, hash: &str) -> Drive {
    let mut drive = small_drive(hash);
    drive.meta.drive_id = id.into();
    drive
}

/// Signals of a drive, other ones for each.
fn signals(id: &str, unavailable: bool) -> SignalTable {
    let mut table = SignalTable { drive_id: id.into(), ..one() };
    if unavailable {
        let name = table.frame_columns.keys().next().unwrap().clone();
        table.frame_columns.remove(&name);
        table.unavailable.insert(name, vec![Need::EgoPose]);
    }
    table
}

/// A lake of these drives, each with signals and a note.
fn lake_of(dir: &Path, ids: &[&str]) -> Lake {
    let lake = Lake::create_or_open(dir).unwrap();
    for (i, id) in ids.iter().enumerate() {
        lake.write_drive_with(&small(id, "1"), &[("source.hash", id.as_bytes())]).unwrap();
        lake.write_signals(&(*id).into(), VERSION, &signals(id, i % 2 == 1)).unwrap();
        lake.write_note(&(*id).into(), "found.json", format!("found {id}").as_bytes()).unwrap();
    }
    lake
}

/// Every drive is read whole, with its signals and notes, by a lake that is opened now.
#[track_caller]
fn complete(dir: &Path, ids: &[&str]) {
    let lake = Lake::open(dir).unwrap();
    assert_eq!(lake.drive_ids(), ids.iter().map(|id| DriveId::from(*id)).collect::<Vec<_>>());
    for id in ids {
        let drive = lake.read_drive(&(*id).into()).unwrap();
        assert_eq!(shown(&drive), shown(&small(id, "1")), "{id}");
        let file = lake.signals(&(*id).into(), VERSION).unwrap().expect("signals");
        assert_eq!(file.read_table(0).unwrap().drive_id, (*id).into());
        assert_eq!(lake.note(&(*id).into(), "found.json").unwrap(), format!("found {id}").as_bytes());
        assert_eq!(lake.note(&(*id).into(), "source.hash").unwrap(), id.as_bytes());
    }
    assert_eq!(lake.entries().filter(|(_, e)| e.is_ok()).count(), ids.len());
}

fn folders(dir: &Path) -> usize {
    fs::read_dir(dir.join("drives")).unwrap().count()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn packed_drives_are_read_as_they_were_written(
        drives in prop::collection::vec((drive(), prop::option::of(table())), 1..6),
        per_pack in 1usize..5,
    ) {
        let dir = tempfile::tempdir().unwrap();
        let lake = Lake::create_or_open(dir.path()).unwrap();
        let mut written = Vec::new();
        for (i, (mut drive, signals)) in drives.into_iter().enumerate() {
            let id = DriveId(format!("d{i}"));
            drive.meta.drive_id = id.clone();
            lake.write_drive(&drive).unwrap();
            let signals = signals.map(|s| SignalTable { drive_id: id.clone(), ..s });
            if let Some(table) = &signals {
                lake.write_signals(&id, VERSION, table).unwrap();
            }
            let before = (lake.outline(&id).unwrap(), lake.media(&id).unwrap(), lake.stated_context(&id).unwrap(),
                lake.size(&id).unwrap(), lake.entry(&id).unwrap());
            written.push((drive, signals, before));
        }
        let loose = lake.drive_ids();
        compact(&lake, per_pack);
        prop_assert_eq!(folders(dir.path()), 0);
        prop_assert_eq!(lake.drive_ids(), loose);
        for (drive, signals, (outline, media, context, size, entry)) in &written {
            let id = &drive.meta.drive_id;
            prop_assert_eq!(shown(&lake.read_drive(id).unwrap()), shown(drive));
            prop_assert_eq!(format!("{:?}", lake.outline(id).unwrap()), format!("{outline:?}"));
            prop_assert_eq!(&lake.media(id).unwrap(), media);
            prop_assert_eq!(&lake.stated_context(id).unwrap(), context);
            prop_assert_eq!(&lake.size(id).unwrap(), size);
            let now = lake.entry(id).unwrap();
            prop_assert!(now.pack.is_some());
            prop_assert_eq!((now.start, now.end, now.place, now.frames),
                (entry.start, entry.end, entry.place.clone(), entry.frames));
            let stored = lake.signals(id, VERSION).unwrap();
            prop_assert_eq!(stored.is_some(), signals.is_some());
            if let (Some(file), Some(table)) = (stored, signals) {
                let read = file.read_table(0).unwrap();
                prop_assert_eq!(&read.targets, &table.targets);
                same_columns(&read.frame_columns, &table.frame_columns);
                same_columns(&read.target_columns, &table.target_columns);
                prop_assert_eq!(&read.unavailable, &table.unavailable);
            }
        }
        // Again, and packed in larger packs: the same drives.
        let before = files(dir.path());
        compact(&lake, per_pack);
        prop_assert!(files(dir.path()) == before, "a second compaction changes nothing");
        compact(&lake, 100);
        for (drive, ..) in &written {
            prop_assert_eq!(shown(&lake.read_drive(&drive.meta.drive_id).unwrap()), shown(drive));
        }
    }
}

#[test]
fn packs_are_bounded_and_small_ones_are_merged_with_what_is_new() {
    let dir = tempfile::tempdir().unwrap();
    let lake = lake_of(dir.path(), &["a", "b", "c", "d", "e"]);
    let done = compact(&lake, 4);
    assert_eq!((done.packed, done.drives, done.packs, done.written), (5, 5, 2, 2));
    lake.write_drive_with(&small("f", "1"), &[("source.hash", b"f")]).unwrap();
    lake.write_signals(&"f".into(), VERSION, &signals("f", false)).unwrap();
    lake.write_note(&"f".into(), "found.json", b"found f").unwrap();
    complete(dir.path(), &["a", "b", "c", "d", "e", "f"]);
    // The pack of one drive is written again with the new drive; the full one is not touched.
    let done = compact(&lake, 4);
    assert_eq!((done.packed, done.drives, done.packs, done.written, done.removed), (1, 6, 2, 1, 1));
    complete(dir.path(), &["a", "b", "c", "d", "e", "f"]);
    let by_size = CompactionOptions { pack_bytes: 1, ..options(4) };
    assert_eq!(lake.compact(&by_size, |_, _| ()).unwrap().written, 0, "a smaller bound divides no pack");
}

#[test]
fn a_packed_drive_is_replaced_changed_and_deleted_like_any_other() {
    let dir = tempfile::tempdir().unwrap();
    let lake = lake_of(dir.path(), &["a", "b", "c"]);
    compact(&lake, 10);
    let [a, b, c]: [DriveId; 3] = ["a", "b", "c"].map(DriveId::from);
    assert_eq!(lake.write_drive(&small("a", "1")).unwrap(), WriteOutcome::Unchanged);
    assert_eq!(folders(dir.path()), 0);

    // New findings and signals lie over the pack until the next compaction.
    lake.write_note(&b, "found.json", b"new").unwrap();
    lake.write_signals(&b, "v2", &signals("b", false)).unwrap();
    let check = || {
        assert_eq!(lake.note(&b, "found.json").unwrap(), b"new");
        assert_eq!(lake.note(&b, "source.hash").unwrap(), b"b");
        assert!(lake.signals(&b, "v2").unwrap().is_some() && lake.signals(&b, VERSION).unwrap().is_none());
        assert!(lake.signals(&c, VERSION).unwrap().is_some(), "versions are of a drive");
    };
    assert_eq!(lake.drive_ids().len(), 3);
    assert!(lake.signals(&b, VERSION).unwrap().is_some(), "the pack still has the older version");
    assert_eq!(compact(&lake, 10).packed, 1);
    check();
    assert_eq!(folders(dir.path()), 0);

    // Other content replaces all of it: what was derived from the old is gone.
    let mut other = small("a", "2");
    other.tracks.pop();
    assert_eq!(lake.write_drive(&other).unwrap(), WriteOutcome::Replaced);
    for _ in 0..2 {
        assert_eq!(lake.read_drive(&a).unwrap().tracks.len(), 1);
        assert!(lake.signals(&a, VERSION).unwrap().is_none() && lake.note(&a, "found.json").is_none());
        assert_eq!(lake.content_hash(&a).unwrap(), "2");
        assert_eq!(lake.drive_ids().len(), 3);
        compact(&lake, 10);
    }

    // Facts and images change a table: the drive is loose then, with all that it had.
    let stamp = lake.stamp(&c).unwrap();
    assert!(lake.state_facts(&c, DriveFacts { place: Some("Ulm".into()), ..DriveFacts::default() }).unwrap());
    assert_ne!(lake.stamp(&c).unwrap(), stamp);
    let image = MediaFrame { camera: "front".into(), time: Nanos(5), uri: "x.jpg".into(), index: 0 };
    lake.write_media(&c, std::slice::from_ref(&image)).unwrap();
    for _ in 0..2 {
        let read = lake.read_drive(&c).unwrap();
        assert_eq!(
            (read.meta.place.as_deref(), read.media.as_deref()),
            (Some("Ulm"), Some(std::slice::from_ref(&image)))
        );
        assert_eq!(lake.note(&c, "source.hash").unwrap(), b"c");
        assert!(lake.signals(&c, VERSION).unwrap().is_some());
        compact(&lake, 10);
    }
    assert_eq!(lake.entry(&c).unwrap().place.as_deref(), Some("Ulm"));

    // Nothing of a deleted drive remains; the others do.
    lake.write_note(&b, "found.json", b"new").unwrap();
    assert!(lake.holds(&a) && lake.holds(&b));
    lake.remove_drives(&BTreeSet::from([a.clone(), b.clone()])).unwrap();
    assert!(!lake.holds(&a) && !lake.holds(&b) && lake.holds(&c));
    assert_eq!(Lake::open(dir.path()).unwrap().drive_ids(), std::slice::from_ref(&c));
    assert_eq!(lake.read_drive(&c).unwrap().tracks.len(), 2);
    let packs = fs::read_dir(dir.path().join("packs")).unwrap().count();
    assert_eq!(packs, 2, "the catalog and the pack written again");
    lake.remove_drive(&c).unwrap();
    assert!(lake.drive_ids().is_empty());
    // A number is not used again: another process may have the old pack in mind.
    lake.write_drive(&small("a", "1")).unwrap();
    compact(&lake, 10);
    assert!(lake.entry(&a).unwrap().pack.unwrap().as_str() > "00000004");
}

#[test]
fn whatever_a_killed_compaction_leaves_every_drive_is_there_once() {
    let ids = ["a", "b", "c"];
    let made = tempfile::tempdir().unwrap();
    lake_of(&made.path().join("loose"), &ids);
    copy(&made.path().join("loose"), &made.path().join("packed"));
    compact(&Lake::open(made.path().join("packed")).unwrap(), 2);
    let packs = made.path().join("packed/packs");

    type State<'a> = (&'a str, &'a dyn Fn(&Path));
    let states: [State<'_>; 5] = [
        ("packs written in part", &|lake| {
            fs::create_dir_all(lake.join("packs/00000001")).unwrap();
            fs::write(lake.join("packs/00000001/tracks.parquet"), "PAR1").unwrap();
        }),
        ("packs written, not published", &|lake| {
            copy(&packs.join("00000001"), &lake.join("packs/00000001"));
            fs::write(lake.join("packs/.catalogue.parquet-7"), "PAR1").unwrap();
        }),
        ("published, folders still there", &|lake| copy(&packs, &lake.join("packs"))),
        ("published, one folder removed, one being removed", &|lake| {
            copy(&packs, &lake.join("packs"));
            fs::remove_dir_all(lake.join("drives/a")).unwrap();
            fs::create_dir(lake.join("unfinished")).unwrap();
            fs::rename(lake.join("drives/b"), lake.join("unfinished/.gone-7-b")).unwrap();
            fs::remove_file(lake.join("unfinished/.gone-7-b/tracks.parquet")).unwrap();
        }),
        ("published over an older pack", &|lake| {
            copy(&packs, &lake.join("packs"));
            fs::remove_dir_all(lake.join("drives")).unwrap();
            fs::create_dir(lake.join("drives")).unwrap();
            copy(&packs.join("00000001"), &lake.join("packs/00000000"));
        }),
    ];
    for (what, make) in states {
        let dir = tempfile::tempdir().unwrap();
        copy(&made.path().join("loose"), dir.path());
        make(dir.path());
        println!("{what}");
        complete(dir.path(), &ids);
        let lake = Lake::open(dir.path()).unwrap();
        compact(&lake, 2);
        complete(dir.path(), &ids);
        assert_eq!(fs::read_dir(dir.path().join("drives")).unwrap().count(), 0, "{what}");
        let named: BTreeSet<String> =
            ids.iter().map(|id| lake.entry(&(*id).into()).unwrap().pack.unwrap()).collect();
        let there = fs::read_dir(dir.path().join("packs")).unwrap().flatten().filter(|e| e.path().is_dir());
        assert_eq!(
            there.map(|e| e.file_name().into_string().unwrap()).collect::<BTreeSet<_>>(),
            named,
            "{what}"
        );
    }
}

#[test]
fn columns_that_share_their_place_share_it_in_a_pack() {
    let dir = tempfile::tempdir().unwrap();
    let lake = lake_of(dir.path(), &["a", "b"]);
    for id in ["a", "b"] {
        let table = SignalTable { drive_id: id.into(), ..with_equal_columns() };
        lake.write_signals(&id.into(), VERSION, &table).unwrap();
    }
    compact(&lake, 10);
    let pack = lake.entry(&"a".into()).unwrap().pack.unwrap();
    assert_eq!(shared(&dir.path().join("packs").join(pack).join("signals")), [SHARED, SHARED]);
    for id in ["a", "b"] {
        let file = lake.signals(&id.into(), VERSION).unwrap().unwrap();
        same_columns(&file.read_table(0).unwrap().target_columns, &with_equal_columns().target_columns);
    }
}

#[test]
fn folders_that_are_in_packs_already_are_removed_and_not_packed_again() {
    let ids = ["a", "b", "c"];
    let dir = tempfile::tempdir().unwrap();
    let (lake, kept) = (lake_of(&dir.path().join("lake"), &ids), dir.path().join("kept"));
    let drives = lake.dir().join("drives");
    // Hard links keep length, time and number of a file: the folders as a killed compaction leaves them.
    let link = |from: &Path, to: &Path| {
        for path in files(from).into_keys() {
            fs::create_dir_all(to.join(&path).parent().unwrap()).unwrap();
            fs::hard_link(from.join(&path), to.join(&path)).unwrap();
        }
    };
    link(&drives, &kept);
    compact(&lake, 10);
    link(&kept, &drives);
    // One of them was changed after it had been packed.
    lake.write_note(&"c".into(), "found.json", b"new").unwrap();
    let done = compact(&lake, 10);
    assert_eq!((done.packed, done.written), (1, 1), "only the one that has changed");
    assert_eq!(folders(lake.dir()), 0);
    assert_eq!(lake.note(&"c".into(), "found.json").unwrap(), b"new");
    lake.write_note(&"c".into(), "found.json", b"found c").unwrap();
    complete(lake.dir(), &ids);
}

#[test]
fn a_change_during_a_compaction_is_kept() {
    let dir = tempfile::tempdir().unwrap();
    let lake = lake_of(dir.path(), &["a", "b"]);
    // The callback runs when a pack is written, before the catalog names it.
    let mut other = small("a", "2");
    other.tracks.pop();
    lake.compact(&options(10), |_, _| {
        lake.write_drive(&other).unwrap();
        lake.write_note(&"b".into(), "found.json", b"new").unwrap();
    })
    .unwrap();
    for _ in 0..2 {
        assert_eq!(lake.drive_ids().len(), 2);
        assert_eq!(lake.read_drive(&"a".into()).unwrap().tracks.len(), 1);
        assert_eq!(lake.note(&"b".into(), "found.json").unwrap(), b"new");
        compact(&lake, 10);
    }
    assert_eq!(folders(dir.path()), 0);
}

#[test]
fn a_reader_that_began_before_a_compaction_goes_on() {
    let dir = tempfile::tempdir().unwrap();
    let (writer, reader) = (lake_of(dir.path(), &["a", "b"]), Lake::open(dir.path()).unwrap());
    compact(&writer, 10);
    assert_eq!(reader.drive_ids().len(), 2);
    assert_eq!(reader.read_drive(&"a".into()).unwrap().tracks.len(), 2);
    // The pack that the reader has open is replaced.
    writer.write_note(&"b".into(), "found.json", b"new").unwrap();
    compact(&writer, 10);
    assert_eq!(reader.read_drive(&"a".into()).unwrap().tracks.len(), 2);
    assert_eq!(reader.note(&"b".into(), "found.json").unwrap(), b"new");
}

#[test]
fn what_cannot_be_read_stays_where_it_is_and_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let lake = lake_of(dir.path(), &["a", "b", "c", "d"]);
    fs::write(dir.path().join("drives/a/tracks.parquet"), "PAR1").unwrap();
    fs::create_dir(dir.path().join("drives/b/mine")).unwrap();
    let done = lake.compact(&options(10), |_, _| ()).unwrap();
    let left: Vec<&str> = done.left.iter().map(|(id, _)| id.as_str()).collect();
    assert_eq!((left, done.packed, done.drives), (vec!["a", "b"], 2, 2));
    assert_eq!(lake.drive_ids().len(), 4);
    assert!(dir.path().join("drives/a").is_dir() && dir.path().join("drives/b/mine").is_dir());
    assert_eq!(lake.read_drive(&"b".into()).unwrap().tracks.len(), 2);
    // A catalog that cannot be read: the lake is refused rather than read without its packs.
    fs::write(dir.path().join("packs/catalogue.parquet"), "PAR1").unwrap();
    assert_eq!(Lake::open(dir.path()).unwrap_err().code(), "lake.table_broken");
    assert!(lake.ready().is_err());
}

#[test]
fn signals_are_left_out_on_request_and_nothing_else_is() {
    let dir = tempfile::tempdir().unwrap();
    let lake = lake_of(dir.path(), &["a", "b"]);
    compact(&lake, 10);
    let without = CompactionOptions { keep_signals: false, ..options(10) };
    assert_eq!(lake.compact(&without, |_, _| ()).unwrap().written, 1);
    assert_eq!(lake.compact(&without, |_, _| ()).unwrap().written, 0);
    assert!(lake.signals(&"a".into(), VERSION).unwrap().is_none());
    assert_eq!(lake.note(&"a".into(), "found.json").unwrap(), b"found a");
}

#[test]
fn a_build_without_packs_refuses_the_lake() {
    let dir = tempfile::tempdir().unwrap();
    let lake = lake_of(dir.path(), &["a"]);
    let version = || {
        let marker = fs::read_to_string(dir.path().join("whyroad-lake.json")).unwrap();
        serde_json::from_str::<serde_json::Value>(&marker).unwrap()["version"].clone()
    };
    assert_eq!(version(), 2);
    compact(&lake, 10);
    assert_eq!(version(), 3);
    Lake::create_or_open(dir.path()).unwrap();
    assert_eq!(version(), 3);
}
