//! Fields of a mapping in the forms in which recorders write them, and in none of them. JSON messages in MCAP files
//! that are made here; the drive is a car on a straight road at 10 m/s with a lead 20 m ahead.
#![allow(clippy::unwrap_used)]

use serde_json::{Value, json};
use std::fs;
use whyroad_ingest::{Options, SourceReport, mcap};
use whyroad_model::{Drive, Need};

const START: i64 = 1_760_000_000_000_000_000;
/// The recorder writes a message this much later than it was measured.
const LATER: i64 = 500_000_000;
const MAPPING: &str = "topics:\n  /pose: { role: ego, time: t, position: p, heading: yaw }\n  /tracks: { role: objects, \
                       frame: world, time: t, list: list, id: id, class: label, position: p, heading: yaw, size: s, \
                       velocity: v }\n  /can: { role: bus, time: t, speed_mps: v.mps, brake: pedal, turn_signal: \
                       blinker }\n";

/// A message: its topic, the time in ns at which it is made and its content.
type Message = (&'static str, i64, Value);

/// The MCAP specification: each record is an opcode, a length of 8 bytes and its body.
fn file(messages: &[Message]) -> Vec<u8> {
    let text = |s: &str| [&(s.len() as u32).to_le_bytes()[..], s.as_bytes()].concat();
    let record = |op: u8, body: Vec<u8>| [&[op][..], &(body.len() as u64).to_le_bytes(), &body].concat();
    let magic = b"\x89MCAP0\r\n".to_vec();
    let mut out = [magic.clone(), record(1, [text(""), text("")].concat())].concat();
    let mut topics: Vec<&str> = messages.iter().map(|m| m.0).collect();
    topics.sort_unstable();
    topics.dedup();
    for (k, topic) in topics.iter().enumerate() {
        let id = (k as u16 + 1).to_le_bytes();
        out.extend(record(3, [&id[..], &text("fleet"), &text("jsonschema"), &text("{}")].concat()));
        let channel = [&id[..], &id, &text(topic), &text("json"), &0_u32.to_le_bytes()].concat();
        out.extend(record(4, channel));
    }
    for (topic, time, value) in messages {
        let id = (topics.iter().position(|t| t == topic).unwrap() as u16 + 1).to_le_bytes();
        let logged = ((time + LATER) as u64).to_le_bytes();
        let data = value.to_string();
        out.extend(record(5, [&id[..], &[0; 4], &logged, &logged, data.as_bytes()].concat()));
    }
    out.extend(record(15, vec![0; 4]));
    out.extend(record(2, vec![0; 20]));
    [out, magic].concat()
}

fn pose(i: i64) -> Message {
    ("/pose", START + i * 100_000_000, json!({"t": START + i * 100_000_000, "p": {"x": i, "y": 0}, "yaw": 0}))
}

fn tracks(i: i64) -> Message {
    let lead = json!({"id": 1, "label": "car", "p": {"x": i + 20, "y": 0}, "yaw": 0, "s": [4.5, 1.9, 1.5], "v": [10, 0]});
    ("/tracks", START + i * 100_000_000, json!({"t": START + i * 100_000_000, "list": [lead]}))
}

fn can(i: i64) -> Message {
    let value = json!({"t": START + i * 100_000_000, "v": {"mps": 10}, "pedal": false, "blinker": "left"});
    ("/can", START + i * 100_000_000, value)
}

/// 3 s at 10 Hz.
fn messages() -> Vec<Message> {
    (0..31).flat_map(|i| [pose(i), tracks(i), can(i)]).collect()
}

fn changed(topic: &str, change: impl Fn(&mut Value)) -> Vec<Message> {
    let mut all = messages();
    all.iter_mut().filter(|m| m.0 == topic).for_each(|m| change(&mut m.2));
    all
}

fn read_with(messages: &[Message], mapping: &str) -> (Option<Drive>, SourceReport) {
    let dir = tempfile::tempdir().unwrap();
    let (path, yaml) = (dir.path().join("d.mcap"), dir.path().join("m.yaml"));
    fs::write(&path, file(messages)).unwrap();
    fs::write(&yaml, mapping).unwrap();
    let (drive, report) = mcap::read(&path, &Options::default().with(&mcap::MAPPING, yaml));
    assert!(report.tables.iter().all(|t| t.adds_up()), "{:?}", report.tables);
    (drive, report)
}

/// The same as the command reads it, with what is done to drives of all formats.
fn finished(messages: &[Message]) -> (Drive, SourceReport) {
    let dir = tempfile::tempdir().unwrap();
    let (path, yaml) = (dir.path().join("d.mcap"), dir.path().join("m.yaml"));
    fs::write(&path, file(messages)).unwrap();
    fs::write(&yaml, MAPPING).unwrap();
    let (sources, _) = whyroad_ingest::find_sources(None, &[path]);
    let (drive, report) = whyroad_ingest::read(&sources[0], &Options::default().with(&mcap::MAPPING, yaml));
    (drive.unwrap(), report)
}

fn read(messages: &[Message]) -> (Drive, SourceReport) {
    let (drive, report) = read_with(messages, MAPPING);
    (drive.unwrap_or_else(|| panic!("{:?}", report.diagnostics)), report)
}

fn codes(r: &SourceReport) -> Vec<&'static str> {
    r.diagnostics.iter().map(|d| d.code).collect()
}

fn said(r: &SourceReport, code: &str) -> String {
    let d = r.diagnostics.iter().find(|d| d.code == code).unwrap_or_else(|| panic!("{:?}", r.diagnostics));
    format!("{} / {}", d.message.en, d.hint.as_ref().map_or("", |h| h.en.as_str()))
}

/// Distance from the ego to the lead in each frame; 20 m by construction.
fn gaps(drive: &Drive) -> Vec<f64> {
    let (ego, lead) = (&drive.ego.as_ref().unwrap().motion, &drive.tracks[0]);
    lead.frames.iter().zip(&lead.motion.x).map(|(f, x)| x - ego.x[*f as usize]).collect()
}

#[test]
fn the_drive_as_it_is_has_no_findings() {
    let (drive, report) = read(&messages());
    assert!(report.diagnostics.is_empty(), "{:?}", report.diagnostics);
    assert_eq!((drive.times.len(), gaps(&drive).len()), (31, 31));
    let bus = report.tables.iter().find(|t| t.table == "bus").unwrap();
    assert_eq!((bus.read, bus.kept["state"]), (93, 93));
}

/// Objects that are recorded 0.5 s after they were measured: in every form their stamps are used, not the log's time.
#[test]
fn stamps_in_any_form_give_the_same_drive() {
    let ns = |v: &Value| v["t"].as_i64().unwrap();
    let forms: [fn(i64) -> Value; 6] = [
        |t| json!(t as f64),
        |t| json!(t.to_string()),
        |t| json!({"secs": t / 1_000_000_000, "nsecs": t % 1_000_000_000}),
        |t| json!({"sec": t / 1_000_000_000, "nanosec": t % 1_000_000_000}),
        |t| json!(t as f64 / 1e9),
        |t| json!(whyroad_model::Nanos(t).to_string()),
    ];
    for form in forms {
        let (drive, report) = read(&changed("/tracks", |v| v["t"] = form(ns(v))));
        assert!(report.diagnostics.is_empty(), "{:?}", report.diagnostics);
        assert!(gaps(&drive).iter().all(|g| (g - 20.0).abs() < 1e-4), "{:?}", gaps(&drive));
    }
}

#[test]
fn a_time_that_is_not_understood_is_reported_and_its_rows_are_not_used() {
    for wrong in [json!("2025-10-09T08:53:20"), json!("soon"), json!({"sec": 5, "ticks": 1})] {
        let (drive, report) = read(&changed("/tracks", |v| v["t"] = wrong.clone()));
        let text = said(&report, "mcap.field.unreadable");
        assert!(text.contains("/tracks: `time: t`") && text.contains("31 of 31"), "{text}");
        assert!(drive.tracks.is_empty() && report.lost_input());
        let count = report.tables.iter().find(|t| t.table == "objects").unwrap();
        assert_eq!(count.dropped["no_time"], 31);
    }
    let (drive, report) = read(&changed("/tracks", |v| {
        v["stamp"] = v["t"].take();
        v.as_object_mut().unwrap().remove("t");
    }));
    let text = said(&report, "mcap.field.absent");
    assert!(text.contains("/tracks") && text.contains("`time: t`") && text.contains("list, stamp"), "{text}");
    assert!(drive.tracks.is_empty() && report.lost_input());
}

/// A simulation starts at 0; in a log of today 0 is a stamp that was not set.
#[test]
fn a_stamp_of_zero_is_the_start_of_a_simulation() {
    let simulated = |v: &mut Value| {
        let t = v["t"].as_i64().unwrap() - START;
        v["t"] = json!({"sec": t / 1_000_000_000, "nanosec": t % 1_000_000_000});
    };
    let mut all = messages();
    all.iter_mut().for_each(|m| simulated(&mut m.2));
    let (drive, report) = read(&all);
    assert_eq!(
        (drive.times.len(), drive.times[0].0, gaps(&drive).len()),
        (31, 0, 31),
        "{:?}",
        report.diagnostics
    );
    // All of one topic: they are not set, and the log's times are not taken in silence.
    let (_, report) = read(&changed("/tracks", |v| v["t"] = json!(0)));
    assert!(said(&report, "mcap.time.log").contains("/tracks: all 31 stamps are 0"));
    // One of many.
    let mut one = messages();
    one[1].2["t"] = json!(0);
    let (drive, report) = read(&one);
    assert!(codes(&report).contains(&"mcap.rows.dropped") && drive.tracks[0].frames[0] == 1);
}

#[test]
fn vectors_with_other_names_are_read_and_none_is_zero() {
    let renamed = |v: &mut Value, x: &str, y: &str| {
        let p = v["p"].take();
        v["p"] = json!({x: p["x"], y: p["y"]});
    };
    for (x, y) in [("X", "Y"), ("easting", "northing")] {
        let (drive, report) = read(&changed("/pose", |v| renamed(v, x, y)));
        assert!(report.diagnostics.is_empty(), "{:?}", report.diagnostics);
        let m = &drive.ego.unwrap().motion;
        assert!((m.x[30] - 30.0).abs() < 1e-9 && m.z[30].is_nan(), "{:?}", m.x);
    }
    let lonlat =
        |v: &mut Value| v["list"].as_array_mut().unwrap().iter_mut().for_each(|o| renamed(o, "lon", "lat"));
    let (drive, report) = finished(&changed("/tracks", lonlat));
    let text = said(&report, "mcap.field.unreadable");
    assert!(text.contains("`position: p`") && text.contains("projected"), "{text}");
    assert!(drive.tracks.is_empty() && drive.meta.missing.contains(&Need::Objects));
    // Sizes by their names, velocities under another path.
    let (drive, report) = read(&changed("/tracks", |v| {
        for o in v["list"].as_array_mut().unwrap() {
            o["s"] = json!({"length": 4.5, "width": 1.9, "height": 1.5});
            o["vv"] = o["v"].take();
            o.as_object_mut().unwrap().remove("v");
        }
    }));
    assert!((drive.tracks[0].length_m[0] - 4.5).abs() < 1e-9 && drive.tracks[0].motion.vx[0].is_nan());
    let text = said(&report, "mcap.field.absent");
    assert!(text.contains("none of 31 objects has the `velocity: v`") && text.contains("vv"), "{text}");
}

#[test]
fn ids_may_be_uuids_and_others_are_named() {
    let uuid = |v: &mut Value| v["list"][0]["id"] = json!({"uuid": (0..16).collect::<Vec<u8>>()});
    let (drive, report) = read(&changed("/tracks", uuid));
    assert!(report.diagnostics.is_empty(), "{:?}", report.diagnostics);
    assert_eq!(drive.tracks[0].id.0, "00010203-0405-0607-0809-0a0b0c0d0e0f");
    let (_, report) = finished(&changed("/tracks", |v| v["list"][0]["id"] = json!([1, 2])));
    assert!(said(&report, "mcap.field.unreadable").contains("`id: id`"));
    assert!(said(&report, "ingest.objects.unused").contains("check the ids"));
}

#[test]
fn without_usable_poses_the_reason_is_stated() {
    let (drive, report) =
        read_with(&messages(), &MAPPING.replace("heading: yaw }\n  /tracks", "heading: yaww }\n  /tracks"));
    assert!(drive.is_none());
    assert!(said(&report, "mcap.field.absent").contains("`heading: yaww`"));
    assert!(said(&report, "mcap.ego.missing").contains("31 poses read, dropped: no heading 31"));
}

/// An undecodable message is lost like a row.
#[test]
fn messages_that_cannot_be_decoded_are_counted_as_lost() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("d.mcap");
    let mut bytes = file(&messages());
    let at = bytes.windows(7).position(|w| w == b"\"yaw\":0").unwrap();
    bytes[at + 6] = b'N';
    fs::write(&path, bytes).unwrap();
    let yaml = dir.path().join("m.yaml");
    fs::write(&yaml, MAPPING).unwrap();
    let (_, report) = mcap::read(&path, &Options::default().with(&mcap::MAPPING, yaml));
    assert_eq!(report.tables[0].dropped["undecodable"], 1);
    assert!(report.tables[0].adds_up() && report.lost_input());
}

#[test]
fn bus_values_are_accounted_for() {
    // Stages instead of words; a path that is not there.
    let (drive, report) = read(&changed("/can", |v| {
        v["blinker"] = json!(1);
        v["pedall"] = v["pedal"].take();
        v.as_object_mut().unwrap().remove("pedal");
    }));
    assert!(said(&report, "mcap.field.unreadable").contains("/can: `turn_signal: blinker`"));
    assert!(said(&report, "mcap.field.absent").contains("blinker, pedall, t, v"));
    assert!(drive.ego.unwrap().bus.speed_mps.iter().all(|v| *v == 10.0));
    // A clock that is 30 s off.
    let late = |v: &mut Value| v["t"] = json!(v["t"].as_i64().unwrap() + 30_000_000_000);
    let (drive, report) = read(&changed("/can", late));
    assert!(said(&report, "mcap.bus.unused").contains("none of 93 values"));
    assert!(drive.meta.missing.contains(&Need::VehicleBus) && !drive.meta.can && report.lost_input());
}

/// A detector that stops after 1 s, one that pauses, and one that sees nobody.
#[test]
fn where_no_message_is_objects_are_unknown() {
    let without = |gone: std::ops::Range<i64>| -> Vec<Message> {
        let is_gone = |m: &Message| m.0 == "/tracks" && gone.contains(&((m.1 - START) / 100_000_000));
        messages().into_iter().filter(|m| !is_gone(m)).collect()
    };
    let (drive, _) = read(&without(11..31));
    assert_eq!(drive.meta.objects_unknown, [[drive.times[11], drive.times[30]]]);
    let (drive, _) = read(&without(11..23));
    assert_eq!(drive.meta.objects_unknown, [[drive.times[11], drive.times[22]]]);
    let (drive, _) = read(&changed("/tracks", |v| v["list"] = json!([])));
    assert!(drive.tracks.is_empty() && drive.meta.objects_unknown.is_empty());
    assert!(!drive.meta.missing.contains(&Need::Objects));
    // As the command reports it.
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("d.mcap"), file(&without(11..31))).unwrap();
    fs::write(dir.path().join("m.yaml"), MAPPING).unwrap();
    let (sources, _) = whyroad_ingest::find_sources(None, &[dir.path().join("d.mcap")]);
    let options = Options::default().with(&mcap::MAPPING, dir.path().join("m.yaml"));
    let lake = whyroad_lake::Lake::create_or_open(dir.path().join("lake")).unwrap();
    let report = whyroad_ingest::ingest(&sources[0], &options, &lake);
    assert!(said(&report, "ingest.objects.unobserved").contains("2.0 s of 3.1 s (from 1.1 s on)"));
    let stored = lake.read_drive(&report.drive_id.unwrap()).unwrap();
    assert_eq!(stored.meta.objects_unknown.len(), 1);
}
