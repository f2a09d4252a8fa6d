//! Camera images in object storage as the labeling service hands them out: a link to one image each, none of a later
//! one in Stage I, and never to a video.

use super::store::{Fault, Proxy, Store};
use crate::dataset_images::lake_with_images;
use crate::media::lock;
use crate::service::http::{Answer, Client};
use crate::service::storm::Annotator;
use crate::service::{Service, annotators, crew, demo, first_project};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::sync::{Arc, Mutex};
use whyroad_lake::{Lake, MinedFolder};
use whyroad_model::scene::MediaFrame;

/// Of the images of the lake, every fifth: two in a second.
const EVERY: usize = 5;
const STEP_NS: i64 = 500_000_000;
const CAMERA: &str = "front_wide_120fov";

/// A lake in a folder whose images are in the store, below `logs/<drive>`, each with a video of the whole drive.
fn images_in_store(at: &Path, store: &Store) {
    let lake = lake_with_images(at);
    for id in lake.drive_ids() {
        // Fewer: each is a request to the store.
        let mut frames: Vec<MediaFrame> = lake.media(&id).unwrap().into_iter().step_by(EVERY).collect();
        for frame in &frames {
            let image = std::fs::read(lake.media_dir().join(id.as_str()).join(&frame.uri)).unwrap();
            store.put(&format!("logs/{id}/{}", frame.uri), &image);
        }
        store.put(&format!("logs/{id}/whole.mp4"), b"the whole drive");
        let first = frames[0].time;
        frames.push(MediaFrame { camera: "video".into(), time: first, uri: "whole.mp4".into(), index: 0 });
        lake.write_media(&id, &frames).unwrap();
    }
    std::fs::remove_dir_all(lake.media_dir()).unwrap();
}

fn frames(client: &mut Client, task: &str) -> Vec<Value> {
    let scene = client.get(&format!("{task}/scene")).good();
    let cameras = scene["cameras"].as_array().unwrap();
    let camera = cameras.iter().find(|c| c["camera"] == CAMERA).unwrap();
    camera["frames"].as_array().unwrap().clone()
}

/// An annotator with the task whose keyframe is latest in its drive. In the order of their creation, the first one may
/// have its keyframe half a second after the start, before which there is hardly an image.
fn with_the_latest_keyframe(at: SocketAddr) -> Annotator {
    let mut admin = Client::set_up(at, "admin");
    let project = first_project(&mut admin);
    let lake = Lake::open(demo().join("lake")).unwrap();
    let mut keyframes: BTreeMap<(String, String), f64> = BTreeMap::new();
    for episode in MinedFolder::open(demo().join("mined")).unwrap().episodes().unwrap().map(Result::unwrap) {
        let start = lake.read_drive(&episode.drive_id).unwrap().times[0];
        let after = (episode.keyframe.timestamp - start).as_secs_f64();
        let key = (episode.drive_id.to_string(), episode.scenario_id.to_string());
        let earliest = keyframes.entry(key).or_insert(after);
        *earliest = earliest.min(after);
    }
    let (latest, after) = keyframes.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    assert!(after > 2.0, "{latest:?} at {after} s");
    let all = admin.get(&format!("/projects/{project}/tasks?limit=200")).good();
    let of = |t: &&Value| t["drive_id"] == latest.0 && t["scenario_id"] == latest.1;
    let task = all["items"].as_array().unwrap().iter().find(of).unwrap()["id"].clone();
    let first = json!({ "tasks": [task], "priority": 9 });
    assert_eq!(admin.post(&format!("/projects/{project}/tasks:change"), &first).good()["changed"], 1);
    let tokens = annotators(&mut admin, at, &project, 0..1);
    let annotator = Annotator::begin(at, &tokens[0], &project);
    assert_eq!(json!(annotator.task), task);
    annotator
}

fn get(client: &mut Client, url: &str) -> Answer {
    client.get(url.strip_prefix("/api/v1").unwrap())
}

/// The time of an image by its link, ns.
fn time(link: &str) -> i64 {
    let (_, name) = link.split_once(&format!("/{CAMERA}/")).unwrap();
    name.split_once(".png?").unwrap().0.parse().unwrap()
}

#[test]
fn links_are_short_lived_for_one_image_and_never_for_the_future() {
    let Some(store) = Store::start() else { return };
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    images_in_store(at, &store);
    // What the service itself asks the store for.
    let asked: Arc<Mutex<Vec<String>>> = Arc::default();
    let seen = Arc::clone(&asked);
    let watching = Proxy::before(&store, move |_, line| {
        seen.lock().unwrap().push(line.to_owned());
        Fault::Pass
    });
    let data = at.join("data").display().to_string();
    let environment = store.environment(watching.port, &at.join("cache"));
    let arguments = ["--data", &data, "--media", "s3://fleet/logs", "--media-link-seconds", "45"];
    let service = Service::start_in(&at.join("lake"), &arguments, &environment);
    let mut annotator = with_the_latest_keyframe(service.at);
    let task = format!("/tasks/{}", annotator.task);

    let first = frames(&mut annotator.client, &task);
    assert!(first.len() > 3);
    assert!(first.iter().all(|f| f["t_s"].as_f64().unwrap() <= 1e-6));
    let follow = |link: &str| {
        let (_, path) = link.split_once(&format!("127.0.0.1:{}", watching.port)).unwrap();
        store.follow(&format!("http://127.0.0.1:{}{path}", store.port))
    };
    let mut times = Vec::new();
    for frame in &first {
        let answer = get(&mut annotator.client, frame["url"].as_str().unwrap());
        assert_eq!((answer.status, answer.body.len()), (307, 0), "{frame}");
        assert_eq!(answer.header("cache-control"), Some("no-store"));
        let link = answer.header("location").unwrap();
        assert!(link.contains("/fleet/logs/") && link.contains(&format!("/{CAMERA}/")), "{link}");
        assert!(link.contains("X-Amz-Expires=45&") && link.contains("X-Amz-Signature="), "{link}");
        assert!(!link.contains(super::store::SECRET));
        assert!(follow(link).contains("PNG"));
        times.push(time(link));
    }
    assert!(times.windows(2).all(|w| w[1] - w[0] == STEP_NS), "{times:?}");
    let next = format!("{task}/media/{CAMERA}/{}", first.len());
    for beyond in 0..20 {
        let path = format!("{task}/media/{CAMERA}/{}", first.len() + beyond);
        let answer = annotator.client.get(&path);
        assert_eq!((answer.status, answer.header("location")), (404, None), "{path}");
    }
    let video = annotator.client.get(&format!("{task}/media/video/0"));
    assert_eq!((video.status, video.header("location")), (404, None));
    // Not even whether a later image exists was asked.
    let last = times.last().unwrap();
    let asked_for = asked.lock().unwrap().clone();
    assert!(asked_for.iter().all(|line| !line.contains("mp4")), "{asked_for:?}");
    assert!(asked_for.iter().filter(|line| line.starts_with("HEAD")).count() <= first.len() + 1);

    lock(&mut annotator, &task);
    let answer = annotator.client.get(&next);
    assert_eq!(answer.status, 307, "Stage II has it");
    assert_eq!(time(answer.header("location").unwrap()), last + STEP_NS);
    assert_eq!(
        annotator.client.get(&format!("{task}/media/video/0")).status,
        404,
        "no video in Stage II either"
    );

    // The page may load images from there, and from nowhere else.
    let mut stream = TcpStream::connect(service.at).unwrap();
    write!(stream, "GET / HTTP/1.1\r\nhost: {}\r\nconnection: close\r\n\r\n", service.at).unwrap();
    let mut page = String::new();
    stream.read_to_string(&mut page).unwrap();
    let allowed = format!("img-src 'self' blob: data: http://127.0.0.1:{};", watching.port);
    assert!(page.contains(&allowed), "{}", page.lines().take(20).collect::<Vec<_>>().join("\n"));
}

#[cfg(unix)]
#[test]
fn blurred_images_are_sent_and_not_linked() {
    use std::os::unix::fs::PermissionsExt as _;
    let Some(store) = Store::start() else { return };
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    images_in_store(at, &store);
    let program = at.join("blur.sh");
    std::fs::write(&program, "#!/bin/sh\ncat \"$1\" > \"$2\" && printf blurred >> \"$2\"\n").unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    let (data, program) = (at.join("data").display().to_string(), program.display().to_string());
    let environment = store.environment(store.port, &at.join("cache"));
    let arguments = ["--data", &data, "--media", "s3://fleet/logs", "--blur", &program];
    let service = Service::start_in(&at.join("lake"), &arguments, &environment);
    let (_, _, mut crew) = crew(service.at, 1);
    let mut annotator = crew.remove(0);
    let task = format!("/tasks/{}", annotator.task);
    for frame in frames(&mut annotator.client, &task).iter().take(3) {
        let answer = get(&mut annotator.client, frame["url"].as_str().unwrap());
        assert_eq!((answer.status, answer.header("location")), (200, None));
        assert!(answer.body.ends_with(b"blurred"));
    }
    // As they were, they are not kept.
    for (path, bytes) in crate::folders::files(&at.join("data")) {
        assert!(!bytes.starts_with(b"\x89PNG") || bytes.ends_with(b"blurred"), "{}", path.display());
    }
}
