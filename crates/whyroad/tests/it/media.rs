//! `whyroad media add` as a user runs it, and the pictures as `whyroad serve` gives them: never one after the keyframe
//! in Stage I.
#![allow(clippy::unwrap_used)] // in a test a panic is the report

use crate::service::http::Client;
use crate::service::storm::Annotator;
use crate::service::{Service, crew, demo};
use crate::session::{Run, whyroad_in, whyroad_with};
use serde_json::{Value, json};
use std::path::Path;

/// Frames a second of the pictures made here.
const RATE_HZ: f64 = 5.0;

/// A picture of its own for each number: PNG's signature, then the number. The service gives bytes and decodes none.
fn png(number: usize) -> Vec<u8> {
    [b"\x89PNG\r\n\x1a\n".as_slice(), format!("picture {number}").as_bytes()].concat()
}

fn jpeg(number: usize) -> Vec<u8> {
    [b"\xff\xd8\xff\xe0".as_slice(), format!("picture {number}").as_bytes()].concat()
}

/// A lake of its own with the bundled drives.
fn lake(at: &Path) {
    copy_folder(&demo().join("lake"), &at.join("lake"));
}

pub(crate) fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let to = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy_folder(&entry.path(), &to);
        } else {
            std::fs::copy(entry.path(), to).unwrap();
        }
    }
}

fn drives(at: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(at.join("lake/drives")).unwrap().map(Result::unwrap);
    entries.map(|e| e.file_name().into_string().unwrap()).filter(|n| !n.starts_with('.')).collect()
}

fn add(at: &Path, line: &str) -> Run {
    let arguments: Vec<&str> = "media add --lake lake".split(' ').chain(line.split(' ')).collect();
    whyroad_in(at, &arguments)
}

fn media_table(at: &Path, drive: &str) -> Vec<whyroad_model::scene::MediaFrame> {
    let lake = whyroad_lake::Lake::open(at.join("lake")).unwrap();
    lake.read_drive(&drive.into()).unwrap().media.unwrap_or_default()
}

#[test]
fn pictures_after_the_keyframe_are_kept_back_in_stage_one() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    lake(at);
    std::fs::create_dir(at.join("front")).unwrap();
    // Longer than the bundled drives: what is taken after a drive's end is left out.
    let count = 1000;
    for n in 0..count {
        std::fs::write(at.join(format!("front/{n}.png")), png(n)).unwrap();
    }
    for drive in drives(at) {
        let run = add(at, &format!("--drive {drive} --camera front --pictures front --rate {RATE_HZ}"));
        assert_eq!(run.code, 3, "{}{}", run.out, run.err);
        assert!(run.err.contains("serve --media"), "{}", run.err);
        let whole =
            whyroad_lake::Lake::open(at.join("lake")).unwrap().read_drive(&drive.as_str().into()).unwrap();
        let lasts = (whole.times[whole.times.len() - 1] - whole.times[0]).as_secs_f64();
        assert_eq!(whole.media.unwrap().len(), (lasts * RATE_HZ + 1e-6) as usize + 1, "{drive}");
        assert!(!whole.meta.missing.contains(&whyroad_model::Need::CameraPictures));
    }
    let data = at.join("data");
    let folders = ["--data", data.to_str().unwrap(), "--media", at.to_str().unwrap()];
    let service = Service::start_on(&at.join("lake"), &folders);
    let (_, _, mut crew) = crew(service.at, 1);
    let mut annotator = crew.remove(0);
    let task = format!("/tasks/{}", annotator.task);

    let first = frames(&mut annotator.client, &task);
    let last = first.last().unwrap();
    assert!(first.iter().all(|f| seconds(f) <= 1e-6), "nothing after the keyframe: {last}");
    assert!(seconds(last) > -1.0 / RATE_HZ - 1e-3, "and all before it: {last}");
    let shown = picture(&mut annotator.client, last);
    assert_eq!(shown.header("content-type"), Some("image/png"));
    let next = format!("{task}/media/front/{}", first.len());
    assert_eq!(annotator.client.get(&next).status, 404, "the one after it is not given");
    for beyond in 1..50 {
        let path = format!("{task}/media/front/{}", first.len() + beyond);
        assert_eq!(annotator.client.get(&path).status, 404, "{path}");
    }
    // Bytes are those of the picture that was taken at that moment.
    let numbers: Vec<usize> = first.iter().map(|f| number(&picture(&mut annotator.client, f).body)).collect();
    assert!(numbers.windows(2).all(|w| w[1] == w[0] + 1), "{numbers:?}");

    lock(&mut annotator, &task);
    let second = frames(&mut annotator.client, &task);
    assert!(second.len() > first.len() && second.iter().any(|f| seconds(f) > 0.0));
    assert_eq!(&second[..first.len()], &first[..], "what was seen stays what it was");
    let after = annotator.client.get(&next);
    assert_eq!(after.status, 200, "Stage II has it");
    assert_eq!(number(&after.body), numbers.last().unwrap() + 1);
}

fn frames(client: &mut Client, task: &str) -> Vec<Value> {
    let scene = client.get(&format!("{task}/scene")).good();
    assert_eq!(scene["cameras"].as_array().unwrap().len(), 1, "{}", scene["cameras"]);
    assert_eq!(scene["cameras"][0]["camera"], "front");
    scene["cameras"][0]["frames"].as_array().unwrap().clone()
}

fn seconds(frame: &Value) -> f64 {
    frame["t_s"].as_f64().unwrap()
}

fn picture(client: &mut Client, frame: &Value) -> crate::service::http::Answer {
    let answer = client.get(frame["url"].as_str().unwrap().strip_prefix("/api/v1").unwrap());
    assert_eq!(answer.status, 200, "{frame}");
    answer
}

fn number(body: &[u8]) -> usize {
    let text = body.strip_prefix(b"\x89PNG\r\n\x1a\npicture ").unwrap();
    std::str::from_utf8(text).unwrap().parse().unwrap()
}

pub(crate) fn lock(annotator: &mut Annotator, task: &str) {
    assert!(annotator.save(), "{:?}", annotator.refused);
    let body = json!({"fence": annotator.fence, "action": "lock_stage1"});
    annotator.client.post(&format!("{task}/actions"), &body).good();
}

#[test]
fn what_is_no_picture_of_the_drive_is_named_and_left_out() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    lake(at);
    let drive = drives(at).remove(0);
    std::fs::create_dir_all(at.join("log/sub")).unwrap();
    let put = |name: &str, bytes: &[u8]| std::fs::write(at.join("log").join(name), bytes).unwrap();
    put("a.jpg", &jpeg(1));
    put("sub/b.PNG", &png(2));
    put("text.jpg", b"not a picture");
    put("really.jpg", &png(3));
    let list = "name,time\nsub/b.PNG,2\na.jpg,1.5\ntext.jpg,3\nreally.jpg,4\nnone.jpg,5\na.jpg,-1\na.jpg,1e6\na.jpg,soon\na.jpg,2\n";
    put("times.csv", list.as_bytes());
    let line = format!("--drive {drive} --camera left --times log/times.csv");
    let run = add(at, &line);
    assert_eq!(run.code, 3, "{}{}", run.out, run.err);
    assert_eq!(run.out, format!("{drive}, camera left: 2 images; 0 replaced, 7 rejected\n"));
    for said in [
        "text.jpg: is not a JPEG, PNG or WebP",
        "really.jpg: is png by content",
        "none.jpg: cannot be read",
        "is not within the drive",
        "'soon' is not a time",
        "already",
    ] {
        assert!(run.err.contains(said), "{said}: {}", run.err);
    }
    let once = media_table(at, &drive);
    assert_eq!(once.len(), 2);
    assert!(once[0].uri.ends_with("a.jpg") && once[1].uri.ends_with("b.PNG"), "by time: {once:?}");
    assert_eq!((once[1].time - once[0].time).0, 500_000_000);

    // Again, and another camera: each camera's pictures are there once.
    assert_eq!(add(at, &line).out, format!("{drive}, camera left: 2 images; 2 replaced, 7 rejected\n"));
    assert_eq!(media_table(at, &drive), once);
    put("times.csv", b"name,time\na.jpg,1\n");
    let other = add(at, &format!("--drive {drive} --camera right --times log/times.csv --copy"));
    assert_eq!((other.code, other.err.as_str()), (0, ""));
    let both = media_table(at, &drive);
    assert_eq!(&both[..2], &once[..]);
    let copied = at.join("lake/media").join(&drive).join(&both[2].uri);
    assert_eq!((both[2].camera.as_str(), std::fs::read(copied).unwrap()), ("right", jpeg(1)));

    // Nothing usable: refused, and the lake stays.
    put("times.csv", b"name,time\na.jpg,-1\n");
    let none = add(at, &line);
    assert!(none.code == 1 && none.err.contains("the lake is unchanged"), "{}", none.err);
    let unknown = add(at, "--drive nowhere --camera left --times log/times.csv");
    assert!(unknown.code == 1 && unknown.err.contains("drive 'nowhere' not found"), "{}", unknown.err);
    assert_eq!(add(at, &format!("--drive {drive} --camera ../x --times log/times.csv")).code, 2);
    assert_eq!(add(at, &format!("--drive {drive} --camera left --pictures log")).code, 2, "a rate is needed");
    assert_eq!(media_table(at, &drive), both);
    let zh = whyroad_in(
        at,
        &[
            "--lang",
            "zh",
            "media",
            "add",
            "--lake",
            "lake",
            "--drive",
            &drive,
            "--camera",
            "left",
            "--times",
            "log/times.csv",
        ],
    );
    assert!(zh.err.contains("不在行程内") && zh.err.contains("数据湖未改动"), "{}", zh.err);
}

#[test]
fn frames_of_a_video_are_attached_where_ffmpeg_is_installed() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    lake(at);
    let drive = drives(at).remove(0);
    let missing = add(at, &format!("--drive {drive} --camera front --video no.mp4"));
    assert!(missing.code == 1 && missing.err.contains("no file no.mp4"), "{}", missing.err);
    // Without ffmpeg it says what to do, in the user's language.
    std::fs::write(at.join("a.mp4"), "not looked at").unwrap();
    let line = format!("media add --lake lake --drive {drive} --camera front --video a.mp4");
    for (lang, text) in [("en", "ffmpeg is not installed: install it"), ("zh", "没有安装 ffmpeg")] {
        let arguments: Vec<&str> = ["--lang", lang].into_iter().chain(line.split(' ')).collect();
        let without = whyroad_with(at, &arguments, &[("PATH", "/no/such/folder")]);
        assert!(without.code == 1 && without.err.contains(text), "{}", without.err);
    }
    let video = std::process::Command::new("ffmpeg")
        .args("-v error -f lavfi -i testsrc=duration=2:size=64x36:rate=25 v.mp4".split(' '))
        .current_dir(at)
        .status();
    if !video.is_ok_and(|s| s.success()) {
        let told = add(at, &format!("--drive {drive} --camera front --video {}", file!()));
        crate::require::skipped("ffmpeg", "no ffmpeg");
        assert_ne!(told.code, 0);
        return;
    }
    let run = add(at, &format!("--drive {drive} --camera front --video v.mp4 --rate 5 --offset 1"));
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    let whole =
        whyroad_lake::Lake::open(at.join("lake")).unwrap().read_drive(&drive.as_str().into()).unwrap();
    let media = media_table(at, &drive);
    // Two seconds at five images per second, the first one a second after the start; copied into the lake.
    assert_eq!(media.len(), 10);
    assert!(((media[0].time - whole.times[0]).as_secs_f64() - 1.0).abs() < 1e-6);
    assert!(((media[9].time - media[0].time).as_secs_f64() - 1.8).abs() < 1e-6);
    assert!(at.join(format!("lake/media/{drive}/front")).read_dir().unwrap().count() == 10);
    // At half the rate: the images that are replaced are removed from the lake.
    let run = add(at, &format!("--drive {drive} --camera front --video v.mp4 --rate 2.5 --offset 1.01"));
    assert_eq!((run.code, media_table(at, &drive).len()), (0, 5), "{}", run.err);
    assert!(at.join(format!("lake/media/{drive}/front")).read_dir().unwrap().count() == 5);
    // A file that breaks off: what can be decoded is attached, and the loss is reported.
    let whole = std::process::Command::new("ffmpeg")
        .args(
            "-v error -f lavfi -i testsrc=duration=4:size=320x240:rate=25 -movflags +faststart f.mp4"
                .split(' '),
        )
        .current_dir(at)
        .status();
    assert!(whole.unwrap().success());
    let bytes = std::fs::read(at.join("f.mp4")).unwrap();
    std::fs::write(at.join("cut.mp4"), &bytes[..bytes.len() * 3 / 5]).unwrap();
    let cut = add(at, &format!("--drive {drive} --camera side --video cut.mp4 --rate 5"));
    assert!(cut.code == 3 && cut.err.contains("the video is damaged"), "{}{}", cut.out, cut.err);
    // Text is no video, and nothing is attached.
    std::fs::write(at.join("text.mp4"), "text").unwrap();
    let broken = add(at, &format!("--drive {drive} --camera side --video text.mp4"));
    assert!(broken.code == 1 && broken.err.contains("ffmpeg"), "{}", broken.err);
}
