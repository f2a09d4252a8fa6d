use super::*;
use std::fs;
use whyroad_lake::mined::{Existing, MinedFolderWriter, MiningQuestion};
use whyroad_model::Nanos;

fn frame(uri: &str) -> MediaFrame {
    MediaFrame { camera: "front".into(), time: Nanos(0), uri: uri.into(), index: 0 }
}

fn empty_results(dir: &Path) {
    let question = MiningQuestion::Framework { scenarios: vec![] };
    MinedFolderWriter::create(dir, question, Existing::default()).unwrap().finish().unwrap();
}

#[test]
fn images_are_found_below_the_opened_folders_and_nowhere_else() {
    let dir = tempfile::tempdir().unwrap();
    let at = |p: &str| dir.path().join(p);
    for (path, text) in [
        ("logs/d1/cam/1.jpg", "a"),
        ("logs/samples/2.PNG", "b"),
        ("secret.jpg", "c"),
        ("logs/d1/notes.txt", "d"),
    ] {
        fs::create_dir_all(at(path).parent().unwrap()).unwrap();
        fs::write(at(path), text).unwrap();
    }
    let lake = Lake::create_or_open(at("lake")).unwrap();
    let recordings = LakeRecordings::open(lake, &[], &[at("logs")]).unwrap();
    let text = |uri: &str| {
        let path = recordings.media(&DriveId::from("d1"), &frame(uri))?;
        Some(fs::read_to_string(path).unwrap())
    };
    assert_eq!(text("cam/1.jpg").as_deref(), Some("a"));
    assert_eq!(text("samples/2.PNG").as_deref(), Some("b"));
    let absolute = at("secret.jpg").display().to_string();
    for outside in ["../secret.jpg", "../../secret.jpg", &absolute, "notes.txt", "cam/none.jpg", "cam", ""] {
        assert_eq!(text(outside), None, "{outside}");
    }
}

#[test]
fn what_comes_while_the_service_runs_is_seen() {
    let dir = tempfile::tempdir().unwrap();
    let at = |p: &str| dir.path().join(p);
    empty_results(&at("mined/week1"));
    let lake = Lake::create_or_open(at("lake")).unwrap();
    let recordings = LakeRecordings::open(lake.clone(), &[at("mined")], &[]).unwrap();
    let id = DriveId::from("d1");
    assert!(recordings.drive(&id).unwrap_err().to_string().contains("d1"));

    let mut drive = Drive { times: vec![Nanos(0), Nanos(100_000_000)], ..Drive::default() };
    drive.meta.drive_id = id.clone();
    lake.write_drive(&drive).unwrap();
    let first = recordings.drive(&id).unwrap();
    assert!(first.media.is_none());
    assert!(Arc::ptr_eq(&first, &recordings.drive(&id).unwrap()), "read once");

    let before = recordings.version(&id);
    fs::create_dir_all(lake.dir().join("media/d1")).unwrap();
    fs::write(lake.dir().join("media/d1/1.jpg"), "image").unwrap();
    let image = MediaFrame { time: drive.times[0], ..frame("1.jpg") };
    lake.write_media(&id, std::slice::from_ref(&image)).unwrap();
    assert_ne!(recordings.version(&id), before);
    assert_eq!(recordings.drive(&id).unwrap().media.as_deref(), Some(&[image.clone()][..]));
    assert!(recordings.media(&id, &image).is_some(), "the lake's own folder came later");

    assert_eq!(recordings.mined(), ["week1"]);
    empty_results(&at("mined/week2"));
    assert_eq!(recordings.mined(), ["week1", "week2"]);
    let all = EpisodeFilter::default();
    assert_eq!(recordings.episode_count("week2", &all).unwrap().unwrap(), 0);
    assert_eq!(recordings.episodes("week2", &all, None, 5).unwrap().unwrap(), EpisodePage::default());
    assert!(recordings.episode_count("week3", &all).is_none());
}

#[test]
fn a_folder_without_results_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let lake = || Lake::create_or_open(dir.path().join("lake")).unwrap();
    fs::create_dir_all(dir.path().join("empty")).unwrap();
    let open = |name: &str| LakeRecordings::open(lake(), &[dir.path().join(name)], &[]).err().unwrap();
    assert!(open("empty").to_string().contains("episodes.jsonl"));
    assert!(matches!(open("missing"), MinedFolderError::Io { .. }));
}
