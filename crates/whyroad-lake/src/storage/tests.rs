//! The protocol with several processes on one store, and with a store that fails at every possible call.

use super::cache::Cache;
use super::mirror::Mirror;
use super::testing::MemoryObjects;
use crate::packs::CompactionOptions;
use crate::{Lake, LakeError};
use std::collections::BTreeSet;
use std::path::Path;
use tempfile::TempDir;
use whyroad_model::scene::{DriveMeta, GeoPosition};
use whyroad_model::{Drive, DriveId, Nanos};

/// In memory where that is possible: hundreds of lakes are written, each file to the disk.
fn folder() -> TempDir {
    let memory = Path::new("/dev/shm");
    if memory.is_dir() { tempfile::tempdir_in(memory).unwrap() } else { tempfile::tempdir().unwrap() }
}

fn drive(id: &str, content: &str) -> Drive {
    let times: Vec<Nanos> = (0..5).map(|i| Nanos(i * 100_000_000)).collect();
    let meta = DriveMeta {
        drive_id: DriveId::from(id),
        content_hash: content.to_owned(),
        format: "test".to_owned(),
        ..DriveMeta::default()
    };
    Drive { meta, times, ..Drive::default() }
}

/// A process: its own cache, the store of all.
fn process(store: &MemoryObjects, cache: &TempDir) -> Result<Lake, LakeError> {
    let cache = Cache::at(cache.path().to_owned(), u64::MAX)?;
    Lake::over(Mirror::create_or_open_with(std::sync::Arc::new(store.clone()), cache)?)
}

fn ids(lake: &Lake) -> Vec<String> {
    lake.drive_ids().into_iter().map(|id| id.0).collect()
}

/// What a new process on another machine reads, each drive whole: id and content.
fn read(store: &MemoryObjects) -> Vec<(String, String)> {
    let cache = folder();
    let lake = process(store, &cache).unwrap();
    let one = |id: DriveId| {
        let drive = lake.read_drive(&id).unwrap();
        assert_eq!(drive.times.len(), 5);
        (id.0, drive.meta.content_hash)
    };
    lake.drive_ids().into_iter().map(one).collect()
}

fn pairs(list: &[(&str, &str)]) -> Vec<(String, String)> {
    list.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect()
}

/// Objects that the manifest does not name, without those that it will remove.
fn unnamed(store: &MemoryObjects) -> Vec<String> {
    let text = store.shared.lock().unwrap().objects["manifest.json"].0.clone();
    let text = String::from_utf8(text).unwrap();
    store.keys().into_iter().filter(|k| k != "manifest.json" && !text.contains(k.as_str())).collect()
}

/// The objects in a cache: path and content.
fn cached(cache: &TempDir) -> Vec<(std::path::PathBuf, Vec<u8>)> {
    let folders = std::fs::read_dir(cache.path().join("objects")).unwrap();
    let files = folders.flat_map(|folder| std::fs::read_dir(folder.unwrap().path()).unwrap());
    files.map(|file| file.unwrap().path()).map(|path| (path.clone(), std::fs::read(path).unwrap())).collect()
}

#[test]
fn two_writers_at_once_lose_nothing() {
    let (store, caches) = (MemoryObjects::new(), [(); 2].map(|()| folder()));
    let writer = |n: usize| {
        let lake = process(&store, &caches[n]).unwrap();
        for i in 0..8 {
            lake.write_drive(&drive(&format!("d{n}-{i}"), "c")).unwrap();
            lake.publish().unwrap();
        }
        // Each has seen what the other had published before its own last read.
        assert!(lake.drive_ids().len() >= 8);
    };
    std::thread::scope(|s| (0..2).for_each(|n| drop(s.spawn(move || writer(n)))));
    assert_eq!(read(&store).len(), 16);
    assert_eq!(unnamed(&store), Vec::<String>::new());
}

#[test]
fn doing_it_again_changes_nothing() {
    let (store, cache) = (MemoryObjects::new(), folder());
    let ingest = |cache: &TempDir| {
        let lake = process(&store, cache).unwrap();
        for id in ["a", "b"] {
            lake.write_drive(&drive(id, "c")).unwrap();
        }
        lake.publish().unwrap();
    };
    ingest(&cache);
    let before = store.shared.lock().unwrap().objects.clone();
    ingest(&cache);
    ingest(&folder());
    assert_eq!(store.shared.lock().unwrap().objects, before);
}

#[test]
fn the_same_drive_with_other_content_is_a_conflict_and_nothing_else_is_lost() {
    let store = MemoryObjects::new();
    let caches = [(); 2].map(|()| folder());
    let [a, b] = [0, 1].map(|n| process(&store, &caches[n]).unwrap());
    a.write_drive(&drive("x", "of a")).unwrap();
    b.write_drive(&drive("x", "of b")).unwrap();
    b.write_drive(&drive("y", "of b")).unwrap();
    a.publish().unwrap();
    let Err(LakeError::ChangedMeanwhile { what, .. }) = b.publish() else { panic!("no conflict") };
    assert_eq!(what, ["drives/x"]);
    assert_eq!(read(&store), pairs(&[("x", "of a"), ("y", "of b")]));
    // The loser continues with what is published, and does not report it twice.
    assert_eq!(b.read_drive(&"x".into()).unwrap().meta.content_hash, "of a");
    b.publish().unwrap();
    // Run again, as the message advises.
    b.write_drive(&drive("x", "of b")).unwrap();
    b.publish().unwrap();
    assert_eq!(read(&store), pairs(&[("x", "of b"), ("y", "of b")]));
}

/// Everything that writes, one after the other.
fn work(lake: &Lake) -> Result<(), LakeError> {
    lake.write_drive(&drive("a", "2"))?;
    lake.write_drive(&drive("b", "1"))?;
    lake.publish()?;
    lake.write_note(&"b".into(), "found.json", b"{}")?;
    lake.publish()?;
    lake.compact(&CompactionOptions::default(), |_, _| ())?;
    lake.remove_drives(&BTreeSet::from([DriveId::from("a")]))?;
    lake.publish_removal()
}

#[test]
fn cut_at_any_call_the_lake_is_whole_and_doing_it_again_finishes() {
    let first = || {
        let (store, cache) = (MemoryObjects::new(), folder());
        let lake = process(&store, &cache).unwrap();
        lake.write_drive(&drive("a", "1")).unwrap();
        lake.publish().unwrap();
        store
    };
    let whole = first();
    *whole.calls.lock().unwrap() = 0;
    work(&process(&whole, &folder()).unwrap()).unwrap();
    let calls = *whole.calls.lock().unwrap();
    assert!(calls > 20, "{calls}");
    let states: Vec<Vec<(String, String)>> =
        vec![pairs(&[("a", "1")]), pairs(&[("a", "2"), ("b", "1")]), pairs(&[("b", "1")])];
    for loses_answers in [false, true] {
        let mut seen = BTreeSet::new();
        for cut in 0..calls {
            let (store, cache) = (first(), folder());
            let failing = store.failing_after(cut, loses_answers);
            // Killed: what it was doing is not finished, and its folder is left.
            let done = process(&failing, &cache).and_then(|lake| {
                let done = work(&lake);
                std::mem::forget(lake);
                done
            });
            let now = read(&store);
            assert!(states.contains(&now), "cut at {cut}: {now:?}");
            assert!(done.is_err() || now == states[2], "cut at {cut}");
            seen.insert(now);
            work(&process(&store, &cache).unwrap()).unwrap();
            assert_eq!(read(&store), states[2], "again after a cut at {cut}");
        }
        assert!(seen.len() >= 2, "{seen:?}");
    }
}

#[test]
fn a_store_that_fails_for_a_moment_costs_nothing() {
    // The manifest is put, and only the answer is lost.
    let store = MemoryObjects::new();
    let cache = folder();
    drop(process(&store, &cache).unwrap());
    let failing = MemoryObjects { left: std::sync::Arc::default(), loses_answers: true, ..store.clone() };
    let lake = process(&failing, &cache).unwrap();
    lake.write_drive(&drive("a", "1")).unwrap();
    let uploads = lake.mirror.as_ref().unwrap().changes().unwrap().1.len() as u64;
    *failing.left.lock().unwrap() = Some(uploads);
    let healed = failing.clone();
    std::thread::scope(|s| {
        s.spawn(move || {
            while *healed.left.lock().unwrap() != Some(0) || *healed.calls.lock().unwrap() <= uploads {
                std::thread::yield_now();
            }
            *healed.left.lock().unwrap() = None;
        });
        lake.publish().unwrap();
    });
    assert_eq!(read(&store), pairs(&[("a", "1")]));
    assert_eq!(unnamed(&store), Vec::<String>::new());
}

#[test]
fn packs_are_one_writer_at_a_time_and_drives_that_come_meanwhile_stay() {
    let (store, caches) = (MemoryObjects::new(), [(); 3].map(|()| folder()));
    let [a, b, c] = [0, 1, 2].map(|n| process(&store, &caches[n]).unwrap());
    a.write_drive(&drive("a", "1")).unwrap();
    a.publish().unwrap();
    let [one, two] = [1, 2].map(|n| process(&store, &caches[n]).unwrap());
    c.write_drive(&drive("c", "1")).unwrap();
    c.publish().unwrap();
    one.compact(&CompactionOptions::default(), |_, _| ()).unwrap();
    assert_eq!(ids(&one), ["a", "c"]);
    let e = two.compact(&CompactionOptions::default(), |_, _| ()).unwrap_err();
    assert_eq!(e.code(), "lake.changed_meanwhile");
    assert_eq!(read(&store), pairs(&[("a", "1"), ("c", "1")]));
    let packed = one.entries().filter(|(_, e)| e.as_ref().unwrap().pack.is_some()).count();
    assert_eq!(packed, 1);
    // A process that began before continues to write.
    b.write_drive(&drive("a", "2")).unwrap();
    assert_eq!(b.publish().map_err(|e| e.code()), Ok(()));
    assert_eq!(read(&store), pairs(&[("a", "2"), ("c", "1")]));
}

#[test]
fn a_deleted_drive_leaves_no_object() {
    let (store, cache) = (MemoryObjects::new(), folder());
    let lake = process(&store, &cache).unwrap();
    for (id, content) in [("gone", "1"), ("kept", "1"), ("gone", "2")] {
        lake.write_drive(&drive(id, content)).unwrap();
        lake.publish().unwrap();
    }
    let image = lake.media_dir().join("gone/front/1.jpg");
    std::fs::create_dir_all(image.parent().unwrap()).unwrap();
    std::fs::write(&image, "image").unwrap();
    lake.publish().unwrap();
    assert!(store.keys().contains(&"media/gone/front/1.jpg".to_owned()));
    assert!(!image.exists());
    for packed in [false, true] {
        if packed {
            lake.write_drive(&drive("gone", "3")).unwrap();
            lake.publish().unwrap();
            lake.compact(&CompactionOptions::default(), |_, _| ()).unwrap();
        }
        assert!(lake.holds(&"gone".into()));
        lake.remove_drive(&"gone".into()).unwrap();
        lake.publish_removal().unwrap();
        let left = store.shared.lock().unwrap().objects.clone();
        for (key, (content, _)) in left {
            let names = |text: &[u8]| text.windows(4).any(|w| w == b"gone");
            assert!(!names(key.as_bytes()) && !names(&content), "{key}");
        }
        // Nor does the cache of this machine hold one: what is left there is what the lake has.
        let cached = cached(&cache);
        assert!(cached.iter().all(|file| !file.1.windows(4).any(|w| w == b"gone")), "{cached:?}");
        assert!(!cached.is_empty(), "the other drive stays");
        assert_eq!(read(&store), pairs(&[("kept", "1")]));
        assert!(!process(&store, &cache).unwrap().holds(&"gone".into()));
    }
}

#[test]
fn only_what_is_used_is_fetched_and_the_cache_is_used_again() {
    let (store, cache) = (MemoryObjects::new(), folder());
    let lake = process(&store, &cache).unwrap();
    for id in ["a", "b"] {
        lake.write_drive(&drive(id, "1")).unwrap();
    }
    lake.publish().unwrap();
    let own = folder();
    let other = process(&store, &own).unwrap();
    assert_eq!(other.entries().filter(|(_, e)| e.as_ref().unwrap().frames == 5).count(), 2);
    let here = |lake: &Lake, file: &str| lake.dir().join(file).exists();
    assert!(here(&other, "drives/a/frames.parquet") && !here(&other, "drives/a/tracks.parquet"));
    other.read_drive(&"a".into()).unwrap();
    assert!(here(&other, "drives/a/tracks.parquet") && !here(&other, "drives/b/tracks.parquet"));
    let listed = other.entry(&"a".into()).unwrap().bytes;
    assert_eq!(listed, lake.entry(&"a".into()).unwrap().bytes);
    // Reading publishes nothing.
    let before = store.keys();
    other.publish().unwrap();
    assert_eq!(store.keys(), before);
    drop(other);
    assert_eq!(
        std::fs::read_dir(own.path().join("open")).unwrap().count(),
        0,
        "the folder goes with the process"
    );
    // Without the store: a drive that was read once is in the cache.
    let offline = process(&store, &own).unwrap();
    store.shared.lock().unwrap().objects.retain(|key, _| key == "manifest.json");
    assert!(offline.read_drive(&"a".into()).is_ok());
    assert_eq!(offline.read_drive(&"b".into()).unwrap_err().code(), "lake.changed_meanwhile");
}

#[test]
fn facts_and_findings_of_two_processes_meet() {
    let (store, caches) = (MemoryObjects::new(), [(); 2].map(|()| folder()));
    let a = process(&store, &caches[0]).unwrap();
    a.write_drive(&drive("x", "1")).unwrap();
    a.publish().unwrap();
    let b = process(&store, &caches[1]).unwrap();
    b.write_note(&"x".into(), "found.json", b"old").unwrap();
    a.write_note(&"x".into(), "other.json", b"a").unwrap();
    let position = GeoPosition { latitude_deg: 1.0, longitude_deg: 2.0 };
    a.publish().unwrap();
    b.publish().unwrap();
    let own = folder();
    let both = process(&store, &own).unwrap();
    assert_eq!(both.note(&"x".into(), "found.json"), Some(b"old".to_vec()));
    assert_eq!(both.note(&"x".into(), "other.json"), Some(b"a".to_vec()));
    let facts = crate::DriveFacts { position: Some(position), ..crate::DriveFacts::default() };
    assert!(both.state_facts(&"x".into(), facts).unwrap());
    both.publish().unwrap();
    let meta = process(&store, &caches[0]).unwrap().read_drive(&"x".into()).unwrap().meta;
    assert_eq!(meta.position, Some(position));
}

#[test]
fn a_service_sees_what_others_publish() {
    let (store, caches) = (MemoryObjects::new(), [(); 2].map(|()| folder()));
    let writer = process(&store, &caches[0]).unwrap();
    writer.write_drive(&drive("a", "1")).unwrap();
    writer.publish().unwrap();
    let service = process(&store, &caches[1]).unwrap();
    let before = service.stamp(&"a".into()).unwrap();
    writer.write_drive(&drive("a", "2")).unwrap();
    writer.write_drive(&drive("b", "1")).unwrap();
    writer.publish().unwrap();
    assert_ne!(service.stamp(&"a".into()).unwrap(), before);
    assert_eq!(service.read_drive(&"a".into()).unwrap().meta.content_hash, "2");
    assert_eq!(ids(&service), ["a", "b"]);
    assert!(service.stamp(&"b".into()).is_ok());
}

#[test]
fn a_store_without_conditions_is_refused() {
    let store = MemoryObjects { unconditional: true, ..MemoryObjects::new() };
    let e = process(&store, &folder()).unwrap_err();
    assert_eq!(e.code(), "lake.conditional_writes");
}

#[test]
fn the_cache_is_bounded_and_a_killed_process_leaves_nothing() {
    let (store, cache) = (MemoryObjects::new(), folder());
    let lake = process(&store, &cache).unwrap();
    lake.write_drive(&drive("a", "1")).unwrap();
    lake.publish().unwrap();
    let count = |dir: &Path| -> usize {
        let below = |d: &Path| std::fs::read_dir(d).into_iter().flatten().flatten().collect::<Vec<_>>();
        below(dir).iter().map(|e| if e.path().is_dir() { below(&e.path()).len() } else { 1 }).sum()
    };
    assert!(count(&cache.path().join("objects")) > 2);
    // Another process with a small limit: what this one uses stays readable.
    Cache::at(cache.path().to_owned(), 0).unwrap();
    assert_eq!(count(&cache.path().join("objects")), 0);
    assert!(lake.read_drive(&"a".into()).is_ok());
    let left = lake.dir().to_owned();
    std::fs::write(left.with_extension("lock"), "").unwrap();
    assert!(left.is_dir());
}
