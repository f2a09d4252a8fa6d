//! What is written is what is read: random drives, and the lake's promises about folders, order and versions.

use proptest::prelude::*;
use std::fs;
use whyroad_lake::{Lake, LakeError, WriteOutcome};
use whyroad_model::road_map::{
    Area, Facility, Lane, LaneKind, LaneMark, LayerState, MapLayer, Point3, Sign, StopLine, TurnKind,
};
use whyroad_model::scene::{
    ContextState, DriveMeta, Ego, EgoBus, FrameOfReference, LightColor, LightState, MediaFrame, Motion,
    Track, TurnSignal,
};
use whyroad_model::{Drive, DriveId, Nanos, Need, ObjectClass, RoadMap, TrackId};

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -1e4..1e4f64,
        1 => any::<f64>().prop_map(|v| if v.is_nan() { f64::NAN } else { v }),
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(-0.0),
    ]
}

fn numbers(n: usize) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(number(), n)
}

fn motion(n: usize) -> impl Strategy<Value = Motion> {
    (prop::collection::vec(numbers(n), 8), bus_column(n, 7.5)).prop_map(|(mut c, forward)| {
        let mut next = || c.pop().unwrap();
        Motion {
            x: next(),
            y: next(),
            z: next(),
            heading: next(),
            vx: next(),
            vy: next(),
            accel: next(),
            yaw_rate: next(),
            forward: forward.into_iter().map(|v| v.unwrap_or(f64::NAN)).collect(),
        }
    })
}

fn signal() -> impl Strategy<Value = Option<TurnSignal>> {
    prop::option::of(prop::sample::select(vec![
        TurnSignal::Off,
        TurnSignal::Left,
        TurnSignal::Right,
        TurnSignal::Hazard,
    ]))
}

fn word() -> impl Strategy<Value = String> {
    prop_oneof!["[a-z]{0,6}", Just("雨天 \"x\"\n".to_owned())]
}

/// A column of the vehicle bus as the model allows it: empty, or one value a frame of which one at least is known.
fn bus_column<T: Clone + std::fmt::Debug + 'static>(
    n: usize,
    known: T,
) -> impl Strategy<Value = Vec<Option<T>>> {
    prop::option::of((0..n, prop::collection::vec(any::<bool>(), n))).prop_map(move |c| {
        c.map_or(Vec::new(), |(sure, flags)| {
            flags.iter().enumerate().map(|(i, &f)| (f || i == sure).then(|| known.clone())).collect()
        })
    })
}

fn ego(n: usize) -> impl Strategy<Value = Ego> {
    let bus = (
        bus_column(n, 0.25),
        bus_column(n, true),
        bus_column(n, 'D'),
        bus_column(n, TurnSignal::Left),
        bus_column(n, false),
        bus_column(n, "left".to_owned()),
    );
    (motion(n), [number(), number(), number(), number()], bus).prop_map(|(motion, size, b)| {
        let numbers = |v: &[Option<f64>]| v.iter().map(|x| x.unwrap_or(f64::NAN)).collect::<Vec<_>>();
        Ego {
            length_m: size[0],
            width_m: size[1],
            height_m: size[2],
            reference_to_centre_m: size[3],
            motion,
            bus: EgoBus {
                speed_mps: numbers(&b.0),
                steering: numbers(&b.0),
                throttle: numbers(&b.0),
                vertical_accel: numbers(&b.0),
                wipers: b.1.clone(),
                brake: b.1,
                gear: b.2,
                turn_signal: b.3,
                aeb: b.4.clone(),
                cruise: b.4,
                route_command: b.5,
            },
            known_at: Vec::new(),
        }
    })
}

fn track(index: usize, frames: usize) -> impl Strategy<Value = Track> {
    let seen = prop::collection::btree_set(0..frames as u32, 1..=frames.min(40));
    seen.prop_flat_map(move |seen| {
        let n = seen.len();
        (
            Just(seen),
            motion(n),
            prop::collection::vec(numbers(n), 4),
            prop::collection::vec(signal(), n),
            word(),
            bus_column(n, 0.25),
            bus_column(n, TrackId::from("t00")),
        )
            .prop_map(move |(seen, motion, mut c, turn_signal, source_class, share, occluder)| {
                Track {
                    id: TrackId(format!("t{index:02}")),
                    class: ObjectClass::ALL[index % ObjectClass::ALL.len()],
                    source_class,
                    frames: seen.into_iter().collect(),
                    motion,
                    length_m: c.pop().unwrap(),
                    width_m: c.pop().unwrap(),
                    height_m: c.pop().unwrap(),
                    interior_points: c.pop().unwrap(),
                    turn_signal: if turn_signal.iter().any(Option::is_some) {
                        turn_signal
                    } else {
                        Vec::new()
                    },
                    visible_share: share.into_iter().map(|s| s.unwrap_or(f64::NAN)).collect(),
                    occluder,
                    ..Track::default()
                }
            })
    })
}

fn line() -> impl Strategy<Value = Vec<Point3>> {
    prop::collection::vec([number(), number(), number()].prop_map(|[x, y, z]| Point3 { x, y, z }), 0..5)
}

fn lane(id: String) -> impl Strategy<Value = Lane> {
    let marks = vec![LaneMark::Unknown, LaneMark::None, LaneMark::DoubleSolid, LaneMark::SolidDashed];
    let kinds =
        vec![LaneKind::Vehicle, LaneKind::Bus, LaneKind::Bike, LaneKind::Sidewalk, LaneKind::Shoulder];
    (
        (line(), line(), line()),
        prop::collection::vec(prop::sample::select(marks), 2),
        prop::sample::select(kinds),
        prop::collection::vec(prop::option::of(word()), 3),
        prop::collection::vec(word(), 0..3),
        any::<bool>(),
        prop::option::of(0.0..50.0f64),
        prop::option::of(prop::sample::select(vec![TurnKind::Left, TurnKind::Uturn])),
    )
        .prop_map(move |(l, m, kind, t, links, in_junction, speed, turn)| Lane {
            id: id.clone(),
            left: l.0,
            right: l.1,
            center: l.2,
            left_mark: m[0],
            right_mark: m[1],
            left_neighbor: t[0].clone(),
            right_neighbor: t[1].clone(),
            successors: links.clone(),
            predecessors: links,
            kind,
            in_junction,
            speed_limit_mps: speed,
            width_m: speed,
            junction_id: t[2].clone(),
            turn,
            tags: t[2].iter().cloned().collect(),
        })
}

fn road_map() -> impl Strategy<Value = RoadMap> {
    (lane("1".into()), lane("2".into()), line(), word(), prop::option::of(1.0..9.0f64), any::<bool>())
        .prop_map(|(a, b, boundary, kind, value, empty)| {
            if empty {
                return RoadMap::default();
            }
            let area = |id: &str| vec![Area { id: id.into(), boundary: boundary.clone() }];
            RoadMap {
                lanes: vec![a, b],
                crosswalks: area("c"),
                junctions: area("j"),
                drivable_areas: area("d"),
                stop_lines: vec![StopLine {
                    id: "s".into(),
                    line: boundary.clone(),
                    lane_ids: vec!["1".into()],
                }],
                signs: vec![Sign {
                    id: "g".into(),
                    kind: kind.clone(),
                    position: Point3 { x: 1.0, y: f64::NAN, z: 0.0 },
                    lane_ids: vec![],
                    value,
                    facing: value,
                }],
                facilities: vec![Facility { id: "f".into(), kind: kind.clone(), boundary: boundary.clone() }],
                complete_for: vec![kind],
                layers: MapLayer::ALL.into_iter().zip([LayerState::Complete, LayerState::Derived]).collect(),
            }
        })
}

type States = (Option<Vec<LightState>>, Option<Vec<ContextState>>, Option<Vec<MediaFrame>>);

fn states(n: usize) -> impl Strategy<Value = States> {
    prop::collection::vec(prop::option::of(prop::collection::vec((any::<i64>(), word()), 0..n)), 3).prop_map(
        |mut v| {
            let mut next = || v.pop().unwrap();
            let lights = next().map(|v| {
                let state = |(t, w): (i64, String)| LightState {
                    to_lane_id: (!w.is_empty()).then(|| w.clone()),
                    lane_id: w,
                    time: Nanos(t),
                    color: if t % 2 == 0 { LightColor::GreenYield } else { LightColor::Red },
                    countdown_s: (t % 3 == 0).then_some(4.5),
                };
                v.into_iter().map(state).collect()
            });
            let context = next().map(|v| {
                let state = |(t, w): (i64, String)| ContextState {
                    time: Nanos(t),
                    kind: "weather".into(),
                    value: w,
                    source: "log".into(),
                    confidence: (t % 3 == 0).then_some(0.75),
                };
                v.into_iter().map(state).collect()
            });
            let media = next().map(|v| {
                let frame = |(t, w): (i64, String)| MediaFrame {
                    camera: "front".into(),
                    time: Nanos(t),
                    uri: w,
                    index: 7,
                };
                v.into_iter().map(frame).collect()
            });
            (lights, context, media)
        },
    )
}

pub(crate) fn drive() -> impl Strategy<Value = Drive> {
    // Up to three clips, so that a track's rows lie apart in the file.
    (1usize..450, 0usize..4).prop_flat_map(|(n, tracks)| {
        let tracks: Vec<_> = (0..tracks).map(|i| track(i, n)).collect();
        (
            prop::collection::vec(1i64..300_000_000, n),
            prop::option::of(ego(n)),
            tracks,
            prop::option::of(road_map()),
            states(5),
            (word(), prop::option::of(word()), any::<bool>()),
        )
            .prop_map(
                |(steps, ego, tracks, map, (lights, context, media), (source, place, flag))| {
                    let mut t = 315_966_253_660_357_000_i64;
                    let times = steps
                        .iter()
                        .map(|s| {
                            t += s;
                            Nanos(t)
                        })
                        .collect();
                    let meta = DriveMeta {
                        drive_id: DriveId::from("drive-1"),
                        format: "av2".into(),
                        source,
                        place: place.clone(),
                        map_ref: place.clone(),
                        licence: place,
                        frame_of_reference: if flag {
                            FrameOfReference::Ego
                        } else {
                            FrameOfReference::World
                        },
                        content_hash: "h".into(),
                        video: vec!["front".into()],
                        sensors: vec![],
                        can: flag,
                        missing: vec![Need::EgoPose],
                        ..DriveMeta::default()
                    };
                    Drive { meta, times, ego, tracks, map, lights, context, media }
                },
            )
    })
}

/// Exact and NaN-proof: Rust's debug form of f64 is the shortest that reads back to the same bits, and NaN prints as
/// itself.
pub(crate) fn shown(d: &Drive) -> String {
    format!("{d:#?}")
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn a_drive_is_read_as_it_was_written(drive in drive()) {
        let dir = tempfile::tempdir().unwrap();
        let lake = Lake::create_or_open(dir.path()).unwrap();
        prop_assert_eq!(lake.write_drive(&drive).unwrap(), WriteOutcome::Written);
        let read = Lake::open(dir.path()).unwrap().read_drive(&drive.meta.drive_id).unwrap();
        prop_assert_eq!(shown(&read), shown(&drive));
        let clips = lake.clip_summaries(&drive.meta.drive_id).unwrap();
        prop_assert_eq!(clips.len(), drive.clips().len());
        prop_assert_eq!(clips.iter().map(|c| c.2 as usize).sum::<usize>(), drive.times.len());
    }
}

pub(crate) fn small_drive(hash: &str) -> Drive {
    let n = 250;
    Drive {
        meta: DriveMeta { drive_id: "d".into(), content_hash: hash.into(), ..DriveMeta::default() },
        times: (0..n).map(|i| Nanos(i * 100_000_000)).collect(),
        tracks: ["a", "b"]
            .map(|id| Track {
                id: id.into(),
                frames: (190..210).collect(),
                motion: Motion::unknown(20),
                length_m: vec![4.5; 20],
                width_m: vec![1.8; 20],
                height_m: vec![f64::NAN; 20],
                interior_points: vec![3.0; 20],
                ..Track::default()
            })
            .into(),
        ..Drive::default()
    }
}

#[test]
fn the_same_content_is_not_written_twice_and_other_content_replaces() {
    let dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(dir.path()).unwrap();
    assert_eq!(lake.write_drive(&small_drive("1")).unwrap(), WriteOutcome::Written);
    assert_eq!(lake.write_drive(&small_drive("1")).unwrap(), WriteOutcome::Unchanged);
    let mut other = small_drive("2");
    other.tracks.pop();
    assert_eq!(lake.write_drive(&other).unwrap(), WriteOutcome::Replaced);
    assert_eq!(lake.drive_ids(), vec![DriveId::from("d")]);
    assert_eq!(lake.read_drive(&"d".into()).unwrap().tracks.len(), 1);
    // Nothing is left of the writing.
    assert_eq!(fs::read_dir(dir.path().join("drives")).unwrap().count(), 1);
}

#[test]
fn equal_drives_make_equal_files() {
    let bytes = |_| {
        let dir = tempfile::tempdir().unwrap();
        Lake::create_or_open(dir.path()).unwrap().write_drive(&small_drive("1")).unwrap();
        fs::read(dir.path().join("drives/d/tracks.parquet")).unwrap()
    };
    assert_eq!(bytes(1), bytes(2));
}

#[test]
fn clip_metadata_counts_200_frames_as_twenty_seconds() {
    // DATA_FORMAT.md 3.1: 200 frames at 10 Hz are 20.0 s; the rest of 250 frames is 5 s.
    let dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(dir.path()).unwrap();
    let clips = lake.clips(&small_drive("1"));
    let shown: Vec<_> = clips.iter().map(|c| (c.clip_id.as_str(), c.duration_sec, c.total_frames)).collect();
    assert_eq!(shown, [("d_000", 20.0, 200), ("d_001", 5.0, 50)]);
    assert_eq!(clips[1].capture_time, Nanos(20_000_000_000));
}

/// A logger pauses for 600 s behind frame 120: 250 frames were recorded, 25 s, and no clip is of both sides.
#[test]
fn no_clip_counts_a_pause() {
    let dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(dir.path()).unwrap();
    let mut drive = small_drive("1");
    drive.times[120..].iter_mut().for_each(|t| t.0 += 600_000_000_000);
    let clips = lake.clips(&drive);
    let shown: Vec<_> = clips.iter().map(|c| (c.clip_id.as_str(), c.duration_sec, c.total_frames)).collect();
    assert_eq!(shown, [("d_000", 12.0, 120), ("d_001", 13.0, 130)]);
    assert_eq!(clips[1].capture_time, Nanos(612_000_000_000));
    lake.write_drive(&drive).unwrap();
    let back = lake.read_drive(&"d".into()).unwrap();
    let frames = |d: &Drive| d.tracks.iter().map(|t| t.frames.clone()).collect::<Vec<_>>();
    assert_eq!((&back.times, frames(&back)), (&drive.times, frames(&drive)));
}

#[test]
fn what_is_broken_is_named() {
    let dir = tempfile::tempdir().unwrap();
    assert!(matches!(Lake::open(dir.path()), Err(LakeError::NotALake(_))));
    let lake = Lake::create_or_open(dir.path()).unwrap();
    assert!(matches!(lake.read_drive(&"nope".into()), Err(LakeError::DriveMissing(_))));
    assert!(matches!(lake.read_drive(&"../..".into()), Err(LakeError::DriveMissing(_))));

    let invalid = |change: fn(&mut Drive)| {
        let mut d = small_drive("1");
        change(&mut d);
        matches!(lake.write_drive(&d), Err(LakeError::DriveInvalid { .. }))
    };
    assert!(invalid(|d| d.meta.drive_id = "../out".into()));
    assert!(invalid(|d| d.times.clear()));
    assert!(invalid(|d| d.times.swap(0, 1)));
    assert!(invalid(|d| d.tracks.swap(0, 1)));
    assert!(invalid(|d| d.tracks[0].frames[19] = 250));
    assert!(invalid(|d| {
        d.tracks[0].width_m.pop();
    }));
    assert!(lake.drive_ids().is_empty());

    lake.write_drive(&small_drive("1")).unwrap();
    let tracks = dir.path().join("drives/d/tracks.parquet");
    let bytes = fs::read(&tracks).unwrap();
    fs::write(&tracks, &bytes[..bytes.len() / 2]).unwrap();
    assert_eq!(lake.read_drive(&"d".into()).unwrap_err().code(), "lake.table_broken");
    fs::remove_file(&tracks).unwrap();
    assert_eq!(lake.read_drive(&"d".into()).unwrap_err().code(), "lake.table_broken");

    let marker = dir.path().join("whyroad-lake.json");
    fs::write(&marker, fs::read_to_string(&marker).unwrap().replace(": 2", ": 99")).unwrap();
    let refused = Lake::open(dir.path()).unwrap_err();
    // Layouts without packs (2) and with packs (3).
    assert!(refused.code() == "lake.version" && refused.to_string().ends_with("reads 2 and 3"), "{refused}");
    assert!(refused.diagnostic().message.zh.ends_with("2 与 3"), "{refused:?}");
}

#[test]
fn classes_by_time_and_when_rows_were_known_are_kept() {
    let dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(dir.path()).unwrap();
    let mut drive = small_drive("1");
    let at = |frame: usize, ms: i64| Nanos(drive.times[frame].0 + ms * 1_000_000);
    let ego_known_at: Vec<Nanos> =
        (0..drive.times.len()).map(|i| at(i, if i % 2 == 0 { 0 } else { 30 })).collect();
    let rows = drive.tracks[0].frames.clone();
    let track_known_at: Vec<Nanos> = rows.iter().map(|&f| at(f as usize, 400)).collect();
    drive.ego =
        Some(Ego { motion: Motion::unknown(drive.times.len()), known_at: ego_known_at, ..Ego::default() });
    drive.tracks[0].known_at = track_known_at;
    let class = |row: usize| match row {
        0 => (ObjectClass::Unknown, "?"),
        1..9 => (ObjectClass::Car, "car"),
        _ => (ObjectClass::Truck, "box truck"),
    };
    drive.tracks[0].state_classes((0..rows.len()).map(class));
    assert_eq!(drive.tracks[0].class_changes.len(), 3);
    lake.write_drive(&drive).unwrap();
    let back = lake.read_drive(&drive.meta.drive_id).unwrap();
    assert_eq!(back.ego.unwrap().known_at, drive.ego.unwrap().known_at);
    let (a, b) = (&back.tracks[0], &drive.tracks[0]);
    assert_eq!((a.class, &a.source_class, &a.known_at), (b.class, &b.source_class, &b.known_at));
    assert_eq!(a.class_changes, b.class_changes);
}

/// Makes a lake one of version 1, whose tables this build refuses.
fn age(lake: &std::path::Path) {
    let older = |path: std::path::PathBuf, key: &str| {
        let text = fs::read_to_string(&path).unwrap();
        let aged =
            text.replace(&format!("\"{key}\": {}", whyroad_lake::LAKE_VERSION), &format!("\"{key}\": 1"));
        assert_ne!(text, aged);
        fs::write(path, aged).unwrap();
    };
    older(lake.join("whyroad-lake.json"), "version");
    older(lake.join("drives/d/drive.json"), "lake_version");
}

#[test]
fn an_older_lake_is_refused_with_the_command_and_ingesting_into_it_again_keeps_what_was_stated() {
    let dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(dir.path()).unwrap();
    let mut drive = small_drive("1");
    drive.meta.format = "sumo".into();
    lake.write_drive(&drive).unwrap();
    let facts = whyroad_lake::DriveFacts { session: Some("morning".into()), ..Default::default() };
    lake.state_facts(&"d".into(), facts).unwrap();
    age(dir.path());
    let manifest = dir.path().join("drives/d/drive.json");
    let aged = fs::read(&manifest).unwrap();

    // The command is named also where only the marker is older.
    fs::write(
        &manifest,
        String::from_utf8(aged.clone()).unwrap().replace(r#""lake_version": 1"#, r#""lake_version": 2"#),
    )
    .unwrap();
    let hint = Lake::open(dir.path()).unwrap_err().diagnostic().hint.unwrap();
    assert!(hint.en.contains("whyroad ingest sumo PATH"), "{hint:?}");
    fs::write(&manifest, aged).unwrap();

    let refused = Lake::open(dir.path()).unwrap_err();
    assert_eq!(refused.code(), "lake.version");
    let hint = refused.diagnostic().hint.unwrap();
    let command = format!("whyroad ingest sumo PATH --lake {}", dir.path().display());
    assert!(hint.en.contains(&command) && hint.zh.contains(&command), "{hint:?}");

    // Ingest opens it, readers refuse the drive until it is there again.
    let lake = Lake::create_or_open(dir.path()).unwrap();
    let refused = lake.read_drive(&"d".into()).unwrap_err();
    assert_eq!(refused.code(), "lake.version");
    assert!(refused.diagnostic().hint.unwrap().en.contains(&command));
    assert_eq!(lake.write_drive(&drive).unwrap(), WriteOutcome::Replaced);
    let back = Lake::open(dir.path()).unwrap().read_drive(&"d".into()).unwrap();
    assert_eq!(back.meta.session.as_deref(), Some("morning"));
}

#[test]
fn every_code_has_a_page() {
    let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/diagnostics");
    let missing: Vec<_> =
        whyroad_lake::CODES.iter().filter(|c| !docs.join(format!("{c}.md")).is_file()).collect();
    assert!(missing.is_empty(), "no page for {missing:?}");
}
