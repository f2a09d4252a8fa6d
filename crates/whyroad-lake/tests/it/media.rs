//! Pictures attached to a drive that is in the lake already.

use std::fs;
use whyroad_lake::Lake;
use whyroad_model::scene::{DriveMeta, MediaFrame};
use whyroad_model::{Drive, DriveId, Nanos, Need};

fn drive() -> Drive {
    let meta = DriveMeta {
        drive_id: DriveId::from("d"),
        missing: vec![Need::Map, Need::CameraPictures],
        ..DriveMeta::default()
    };
    Drive { meta, times: (0..10).map(|i| Nanos(i * 100_000_000)).collect(), ..Drive::default() }
}

fn frame(camera: &str, time: i64) -> MediaFrame {
    MediaFrame { camera: camera.into(), time: Nanos(time), uri: format!("{camera}/{time}.jpg"), index: 0 }
}

#[test]
fn pictures_are_stored_by_camera_and_time_and_the_rest_stays() {
    let dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(dir.path()).unwrap();
    let id = DriveId::from("d");
    lake.write_drive(&drive()).unwrap();
    assert_eq!(lake.media(&id).unwrap(), []);
    lake.write_media(&id, &[frame("rear", 1), frame("front", 9), frame("front", 2)]).unwrap();
    let sorted = vec![frame("front", 2), frame("front", 9), frame("rear", 1)];
    let read = lake.read_drive(&id).unwrap();
    assert_eq!((read.media.as_ref(), &read.times), (Some(&sorted), &drive().times));
    assert_eq!(read.meta, DriveMeta { missing: vec![Need::Map], ..drive().meta });
    // Fewer than before: the manifest's number of rows follows.
    lake.write_media(&id, &sorted[..1]).unwrap();
    assert_eq!(lake.read_drive(&id).unwrap().media.as_deref(), Some(&sorted[..1]));
    let names = |at: &str| {
        fs::read_dir(dir.path().join(at)).unwrap().map(|e| e.unwrap().file_name()).collect::<Vec<_>>()
    };
    assert_eq!(names("drives"), ["d"], "nothing is left aside");
}

#[test]
fn a_replacement_that_was_killed_leaves_the_drive_readable_and_the_old_pictures_known() {
    let dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(dir.path()).unwrap();
    let id = DriveId::from("d");
    lake.write_drive(&drive()).unwrap();
    let manifest = dir.path().join("drives/d/drive.json");
    let without = fs::read_to_string(&manifest).unwrap();
    lake.write_media(&id, &[frame("front", 2)]).unwrap();
    // As after the first of the three steps: the file is there, the manifest does not name it.
    fs::write(&manifest, without).unwrap();
    assert_eq!(lake.read_drive(&id).unwrap().media, None);
    assert_eq!(lake.media(&id).unwrap(), [frame("front", 2)]);
    lake.write_media(&id, &[frame("front", 2), frame("rear", 3)]).unwrap();
    assert_eq!(lake.read_drive(&id).unwrap().media.map(|m| m.len()), Some(2));
}
