//! Faces and plates: `--blur PROGRAM` of `dataset build` and of `serve`. The program of these tests changes the bytes
//! of each image and fails for some; no byte of an image that it was not given, or that it failed for, may come out.
#![cfg(unix)]

use crate::dataset_images::{RATE_HZ, lake_with_images};
use crate::folders::files;
use crate::service::http::{Answer, Client};
use crate::service::{Service, demo, first_project};
use crate::session::whyroad_in;
use serde_json::Value;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use whyroad_dataset::Release;

/// What the program adds to an image.
const MARK: &[u8] = b"blurred";

/// A program that fails for inputs that match the shell pattern `fails`, after it has written some of the image.
fn program(at: &Path, fails: &str) -> PathBuf {
    let path = at.join("blur.sh");
    let mark = String::from_utf8_lossy(MARK);
    let script = format!(
        "#!/bin/sh\ncase \"$1\" in {fails}) cp \"$1\" \"$2\"; exit 7;; esac\ncat \"$1\" > \"$2\" && printf {mark} >> \"$2\"\n"
    );
    std::fs::write(&path, script).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    path
}

fn build(at: &Path, out: &str) -> crate::session::Run {
    let mined = demo().join("mined").display().to_string();
    let line = format!(
        "dataset build --spec dataset.yaml --drafts --labels {mined} --lake lake --out {out} --blur ./blur.sh"
    );
    whyroad_in(at, &line.split(' ').collect::<Vec<_>>())
}

#[test]
fn a_release_has_blurred_images_only() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    let lake = lake_with_images(at);
    // It fails for the image at the keyframe of one episode.
    let mined = whyroad_lake::MinedFolder::open(demo().join("mined")).unwrap();
    let episode = mined.episodes().unwrap().next().unwrap().unwrap();
    let start = lake.read_drive(&episode.drive_id).unwrap().times[0];
    let number = ((episode.keyframe.timestamp - start).as_secs_f64() * RATE_HZ + 1e-3).floor() as usize;
    // Copied images are named by their time, ns.
    let time = start.0 + (number as f64 / RATE_HZ * 1e9).round() as i64;
    program(at, &format!("*/{}/*/{time}.png", episode.drive_id));
    let run = build(at, "release");
    assert_eq!(run.code, 3, "{}{}", run.out, run.err);
    assert!(run.err.contains("dataset.image.blur") && run.err.contains("exit status: 7"), "{}", run.err);

    let release = Release::open(at.join("release")).unwrap();
    let samples: Vec<_> = release.samples(None).map(Result::unwrap).collect();
    assert!(samples.len() >= 4, "{}", samples.len());
    for s in &samples {
        assert!(!s.images.is_empty() && s.images.iter().all(|i| i.bytes.ends_with(MARK)), "{}", s.sample_id);
        let lineage = &s.lineage;
        assert!(
            (lineage.drive_id.as_str(), lineage.keyframe_time_ns)
                != (episode.drive_id.as_str(), episode.keyframe.timestamp.0),
            "the sample whose image failed is left out"
        );
    }
    // And so has what is exported from it. Nothing is left beside the release.
    let run = whyroad_in(at, &["dataset", "export", "ms-swift", "release", "--out", "swift"]);
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    let exported = files(&at.join("swift"));
    let images: Vec<_> = exported.iter().filter(|(p, _)| p.extension().is_some_and(|e| e == "png")).collect();
    assert!(images.len() >= samples.len());
    assert!(images.iter().all(|(_, bytes)| bytes.ends_with(MARK)));
    assert!(!at.join("release.blurred").exists());
}

#[test]
fn a_program_that_always_fails_lets_no_image_out() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    lake_with_images(at);
    program(at, "*");
    let run = build(at, "release");
    assert_ne!(run.code, 0, "{}{}", run.out, run.err);
    assert!(run.err.contains("dataset.image.blur"), "{}", run.err);
    for (path, bytes) in
        files(at).into_iter().filter(|(p, _)| !p.starts_with("lake") && !p.starts_with("front"))
    {
        assert!(!bytes.starts_with(b"\x89PNG"), "{}", path.display());
    }
    let samples = Release::open(at.join("release")).map(|r| r.samples(None).count());
    assert_eq!(samples.unwrap_or(0), 0);
    // Neither does one that is not there.
    std::fs::remove_file(at.join("blur.sh")).unwrap();
    assert!(build(at, "other").err.contains("dataset.image.blur"));
}

fn get(client: &mut Client, url: &str) -> Answer {
    client.get(url.strip_prefix("/api/v1").unwrap())
}

/// Asks for every image of a scene: blurred or refused. The number of each.
fn images(client: &mut Client, scene: &Value) -> (usize, usize) {
    let (mut shown, mut refused) = (0, 0);
    let frames = scene["cameras"][0]["frames"].as_array().unwrap();
    for url in frames.iter().map(|f| f["url"].as_str().unwrap()) {
        let answer = get(client, url);
        if answer.status == 200 {
            assert!(answer.body.ends_with(MARK), "{url}");
            shown += 1;
        } else {
            assert_eq!((answer.status, &answer.json()["code"]), (503, &Value::from("media.blur")), "{url}");
            refused += 1;
        }
    }
    (shown, refused)
}

#[test]
fn the_service_shows_blurred_images_only() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    lake_with_images(at);
    // Two of the ten images of a second, which are named by their time in ns.
    let program = program(at, "*[05]00000000.png").display().to_string();
    let data = at.join("data").display().to_string();
    let service = Service::start_on(&at.join("lake"), &["--data", &data, "--blur", &program]);
    let mut admin = Client::set_up(service.at, "admin");
    let project = first_project(&mut admin);
    let mined = admin.get("/mined").good()["items"][0]["name"].as_str().unwrap().to_owned();
    let folder = format!("/projects/{project}/mined/{mined}");
    let card = admin.get(&format!("{folder}/episodes?limit=1")).good()["items"][0].clone();
    let of = |key: &str| card[key].as_str().unwrap().to_owned();
    let query =
        format!("drive={}&scenario={}&episode={}", of("drive_id"), of("scenario_id"), of("episode_id"));
    let episode = admin.get(&format!("{folder}/episode?{query}")).good();
    let (shown, refused) = images(&mut admin, &episode["scene"]);
    assert!(shown > 20 && refused > 2, "{shown} {refused}");
    // All tasks: which one is listed first is chance, and one early in its drive has few images.
    let tasks = admin.get(&format!("/projects/{project}/tasks")).good();
    let (mut shown, mut refused) = (0, 0);
    for task in tasks["items"].as_array().unwrap() {
        let scene = admin.get(&format!("/tasks/{}/scene", task["id"].as_str().unwrap())).good();
        let counts = images(&mut admin, &scene);
        (shown, refused) = (shown + counts.0, refused + counts.1);
    }
    assert!(shown > 20 && refused > 2, "{shown} {refused}");
    // What is kept of images that failed is nothing.
    for (path, bytes) in files(&at.join("data")) {
        let image = bytes.starts_with(b"\x89PNG");
        assert!(!image || bytes.ends_with(MARK), "{}", path.display());
    }
}
