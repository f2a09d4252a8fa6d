//! A drive made by hand, for tests of several crates (included by path): the ego at 10 m/s on the right of two lanes, a
//! car that comes in from the left.
#![allow(dead_code)]

use std::sync::Arc;
use whyroad_model::messages::*;
use whyroad_model::road_map::{Area, Lane, LaneMark, Point3, RoadMap};
use whyroad_model::scene::{DriveMeta, Ego, Motion, Track};
use whyroad_model::signal::TargetSpan;
use whyroad_model::{Bilingual, Column, Drive, FrameRange, Nanos, Need, ObjectClass, SignalTable, Tri};

pub(crate) const FRAMES: usize = 120;

fn motion(x: impl Fn(f64) -> f64, y: impl Fn(f64) -> f64, vx: f64) -> Motion {
    let t = || (0..FRAMES).map(|i| i as f64 * 0.1);
    Motion {
        x: t().map(&x).collect(),
        y: t().map(&y).collect(),
        z: vec![0.0; FRAMES],
        heading: vec![0.0; FRAMES],
        vx: vec![vx; FRAMES],
        vy: vec![0.0; FRAMES],
        accel: vec![0.0; FRAMES],
        yaw_rate: vec![0.0; FRAMES],
        forward: vec![],
    }
}

fn lane(id: &str, y: f64) -> Lane {
    let line = |dy: f64| vec![Point3 { x: -50.0, y: y + dy, z: 0.0 }, Point3 { x: 300.0, y: y + dy, z: 0.0 }];
    Lane {
        id: id.to_owned(),
        left: line(1.6),
        right: line(-1.6),
        center: line(0.0),
        left_mark: LaneMark::Solid,
        right_mark: LaneMark::Dashed,
        ..Lane::default()
    }
}

pub(crate) fn drive(name: &str) -> Drive {
    let crossing = |x: f64, y: f64| Point3 { x, y, z: 0.0 };
    Drive {
        meta: DriveMeta {
            drive_id: name.into(),
            format: "hand".into(),
            place: Some(name.into()),
            ..DriveMeta::default()
        },
        times: (0..FRAMES).map(|i| Nanos(i as i64 * 100_000_000)).collect(),
        ego: Some(Ego {
            length_m: 4.8,
            width_m: 1.9,
            height_m: 1.5,
            motion: motion(|t| 10.0 * t, |_| 0.0, 10.0),
            ..Ego::default()
        }),
        tracks: vec![Track {
            id: name.into(),
            class: ObjectClass::Car,
            frames: (0..FRAMES as u32).collect(),
            motion: motion(|t| 30.0 + 7.0 * t, |t| (3.2 - 0.5 * t).max(0.0), 7.0),
            length_m: vec![4.5; FRAMES],
            width_m: vec![1.8; FRAMES],
            height_m: vec![1.5; FRAMES],
            ..Track::default()
        }],
        map: Some(RoadMap {
            lanes: vec![lane("left", 3.2), lane("right", 0.0)],
            crosswalks: vec![Area {
                id: "c".into(),
                boundary: vec![
                    crossing(60.0, -2.0),
                    crossing(64.0, -2.0),
                    crossing(64.0, 5.0),
                    crossing(60.0, 5.0),
                ],
            }],
            ..RoadMap::default()
        }),
        ..Drive::default()
    }
}

pub(crate) fn signals(drive: &Drive) -> SignalTable {
    let id = drive.tracks[0].id.clone();
    let n = FRAMES;
    SignalTable {
        drive_id: drive.meta.drive_id.clone(),
        times: drive.times.clone(),
        frame_columns: [("ego.speed".to_owned(), Column::Number(vec![10.0; n]))].into(),
        targets: vec![TargetSpan {
            id,
            class: ObjectClass::Car,
            first_row: 0,
            frames: FrameRange::new(0, n),
        }],
        target_columns: [
            (
                "target.ttc".to_owned(),
                Column::Number(
                    (0..n)
                        .map(|i| {
                            if i < 20 {
                                f64::NAN
                            } else if i > 100 {
                                f64::INFINITY
                            } else {
                                5.0 - 0.02 * i as f64
                            }
                        })
                        .collect(),
                ),
            ),
            ("target.in_ego_lane".to_owned(), Column::Flag((0..n).map(|i| Tri::from(i > 40)).collect())),
            (
                "target.relation".to_owned(),
                Column::Category {
                    codes: (0..n).map(|i| u16::from(i > 40)).collect(),
                    names: Arc::from(["left".to_owned(), "lead".to_owned()]),
                },
            ),
        ]
        .into(),
        unavailable: [("light.state".to_owned(), vec![Need::TrafficLights])].into(),
        partial: [].into(),
        without_boxes: [].into(),
        pairs: None,
    }
}

pub(crate) fn episode(drive: &Drive) -> EpisodeRecord {
    let at = |f: usize| drive.times[f];
    EpisodeRecord {
        episode_id: format!("{}_e1", drive.meta.drive_id),
        scenario_id: "reactive_agent.cutin.urgent".parse().unwrap(),
        drive_id: drive.meta.drive_id.clone(),
        clip_id: whyroad_model::ClipId::of(&drive.meta.drive_id, 0),
        target_id: Some(drive.tracks[0].id.clone()),
        roles: [].into(),
        second_keyframe: None,
        time_range: TimeRange {
            start_timestamp: at(20),
            end_timestamp: at(70),
            start_frame_idx: Some(20),
            end_frame_idx: Some(70),
        },
        keyframe: Keyframe {
            timestamp: at(40),
            frame_idx: 40,
            kind: KeyframeType::Reactive,
            range_start: None,
            range_end: None,
        },
        score: 0.87,
        is_primary: true,
        primary_episode_id: None,
        ego_response: None,
        margin_score: None,
        calibrated: None,
        keyframe_rule: Bilingual::new(
            "他车车轮越过车道线",
            "a wheel of the other vehicle crosses the lane line",
        ),
        conditions_matched: vec![MatchedCondition {
            condition: "target.ttc < 5 s".into(),
            actual_value: serde_json::json!(4.2),
            description: None,
            actual_words: None,
        }],
        signals: ["ego.speed", "light.state", "target.in_ego_lane", "target.relation", "target.ttc"]
            .map(String::from)
            .to_vec(),
        rule_version: None,
    }
}

pub(crate) fn coverage() -> Coverage {
    let leaf = |id: &str, state, episodes| LeafCoverage {
        scenario_id: id.parse().unwrap(),
        state,
        episodes,
        primary_episodes: episodes,
        drives_searched: 1,
        gaps: Vec::new(),
    };
    let mut red = leaf("reactive_rule.traffic_light.red_stop", CoverageState::NotObservable, 0);
    red.gaps =
        vec![DriveGap { drives: vec!["d".into()].into(), missing_signals: vec!["light.state".into()] }];
    Coverage {
        taxonomy_version: "2.0.0".into(),
        drives: vec!["d".into()],
        left_out: vec![],
        leaves: vec![
            leaf("reactive_agent.cutin.urgent", CoverageState::Found, 1),
            leaf("reactive_agent.cutin.slow", CoverageState::NotFound, 0),
            red,
        ],
        unresolved: vec![leaf("proactive.lane_change", CoverageState::Found, 2)],
    }
}
