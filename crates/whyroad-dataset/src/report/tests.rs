//! A drive made by hand: the ego at 10 m/s on the right of two lanes, a car that comes in from the left.

use super::*;
use std::sync::Arc;
use whyroad_framework::Taxonomy;
use whyroad_model::messages::*;
use whyroad_model::road_map::{Area, Lane, LaneMark, Point3, RoadMap};
use whyroad_model::scene::{DriveMeta, Ego, Motion, Track};
use whyroad_model::signal::TargetSpan;
use whyroad_model::{Column, FrameRange, Nanos, ObjectClass, Tri};

pub(crate) const FRAMES: usize = 120;

pub(crate) fn taxonomy() -> Taxonomy {
    let text = include_str!("../../../../schema/scenario_taxonomy.yaml");
    whyroad_framework::taxonomy::read_taxonomy("scenario_taxonomy.yaml", text).0.unwrap()
}

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
    }
}

fn lane(id: &str, y: f64) -> Lane {
    let line = |dy: f64| vec![Point3 { x: -50.0, y: y + dy, z: 0.0 }, Point3 { x: 300.0, y: y + dy, z: 0.0 }];
    Lane {
        id: id.to_owned(),
        left: line(1.6),
        right: line(-1.6),
        centre: line(0.0),
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
        unavailable: [("light.state".to_owned(), vec!["traffic lights".to_owned()])].into(),
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
        keyframe_rule: Bilingual::new(
            "他车车轮越过车道线",
            "a wheel of the other vehicle crosses the lane line",
        ),
        conditions_matched: vec![MatchedCondition {
            condition: "target.ttc < 5 s".into(),
            actual_value: serde_json::json!(4.2),
        }],
        signals: ["ego.speed", "light.state", "target.in_ego_lane", "target.relation", "target.ttc"]
            .map(String::from)
            .to_vec(),
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
    red.gaps = vec![DriveGap { drives: vec!["d".into()], missing_signals: vec!["light.state".into()] }];
    Coverage {
        taxonomy_version: "2.0.0".into(),
        drives: vec!["d".into()],
        leaves: vec![
            leaf("reactive_agent.cutin.urgent", CoverageState::Found, 1),
            leaf("reactive_agent.cutin.slow", CoverageState::NotFound, 0),
            red,
        ],
        unresolved: vec![leaf("proactive.lane_change", CoverageState::Found, 2)],
    }
}

pub(crate) fn infos() -> BTreeMap<String, SignalInfo> {
    let info = |unit: &str, zh: &str, en: &str| SignalInfo {
        unit: unit.into(),
        meaning: Bilingual::new(zh, en),
        scale: 1.0,
    };
    [
        ("ego.speed".to_owned(), info("m/s", "自车对地速度", "speed over ground")),
        ("target.ttc".to_owned(), info("s", "碰撞时间", "time to collision along the path")),
    ]
    .into()
}

fn page(name: &str, max_cards: usize) -> String {
    let (coverage, infos) = (coverage(), infos());
    let drive = drive(name);
    let mut report = ReportBuilder::new(ReportContext {
        framework: Framework::bundled(),
        coverage: &coverage,
        signals: &infos,
        lang: Lang::En,
        max_cards,
    });
    report.add_drive(&drive, &signals(&drive), &[episode(&drive)]);
    report.finish()
}

#[test]
fn all_leaves_are_in_the_map_and_in_the_table() {
    let page = page("d", 10);
    let taxonomy = taxonomy();
    assert_eq!(taxonomy.leaves().count(), 122);
    for (l1, l2, l3) in taxonomy.leaves() {
        let id = format!("{}.{}.{}", l1.id, l2.id, l3.id);
        assert_eq!(page.matches(&format!("data-leaf=\"{id}\" data-state=")).count(), 1, "{id} in the map");
        assert_eq!(page.matches(&format!("<tr id=\"leaf-{id}\"")).count(), 1, "{id} in the table");
    }
}

#[test]
fn the_four_states_have_their_own_fill_and_mark() {
    let page = page("d", 10);
    for (state, cells) in [("found", 1), ("not_found", 1), ("not_observable", 1), ("no_rule", 119)] {
        let count = page.matches(&format!("\" data-state=\"{state}\"><title>")).count();
        assert_eq!(count, cells, "{state}");
        assert!(page.contains(&format!(".st-{state} {{ fill: ")), "{state} has a fill");
    }
    assert!(page.contains("<code>light.state</code>"), "what is missing is named");
}

#[test]
fn what_has_no_variant_is_shown_with_its_l2_and_counted_as_no_leaf() {
    let page = page("d", 10);
    assert!(page.contains("<tspan class=\"more\"> +2</tspan>"));
    assert_eq!(page.matches("<tr class=\"unresolved\">").count(), 1);
    assert!(page.contains("<dd>1<small> / 122</small></dd>"));
}

#[test]
fn the_page_fetches_nothing() {
    let page = page("d", 10);
    for what in [
        "http:",
        "https:",
        "src=",
        "@import",
        "url(\"",
        "url('",
        "//cdn",
        "<link",
        "<iframe",
        "fetch(",
        "XMLHttpRequest",
        "import(",
    ] {
        assert!(!page.contains(what), "{what}");
    }
    assert!(page.contains("default-src 'none'"));
    // The only references are to places in the page itself.
    for reference in page.split("href=\"").skip(1) {
        assert!(reference.starts_with('#'), "{}", &reference[..reference.len().min(40)]);
    }
}

#[test]
fn names_from_logs_cannot_become_markup() {
    let nasty = "<script>alert('x')</script>\"onload=\"y";
    let page = page(nasty, 10);
    assert!(!page.contains("<script>alert"));
    assert!(!page.contains("\"onload="));
    assert!(page.contains("&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;&quot;onload=&quot;y"));
}

#[test]
fn a_card_has_picture_conditions_and_a_plot_of_each_signal() {
    let page = page("d", 10);
    let card = page.split("<article").nth(1).unwrap().split("</article>").next().unwrap();
    assert_eq!(card.matches("<figure class=\"plot\">").count(), 5);
    assert!(card.contains("target.ttc &lt; 5 s</code></td><td>4.2</td>"));
    assert!(card.contains("他车车轮越过车道线") && card.contains("a wheel of the other vehicle crosses"));
    assert!(card.contains("class=\"vehicle target\""), "the target stands out");
    assert!(card.contains("way-ego before") && card.contains("way-ego after"));
    assert!(card.contains("class=\"zebra\"") && card.contains(">10 m</text>"));
    // light.state has no column: it says what the log lacks instead of drawing a flat line.
    assert!(card.contains(
        "not observable, needs: </span><span lang=\"zh\">信号灯</span><span lang=\"en\">traffic lights"
    ));
    assert!(card.contains("Label draft (needs a person)"));
    // At the keyframe, 4 s in: ego at x = 40, the car at x = 58 and y = 1.2, so 18 m up and 1.2 m to the left.
    assert!(card.contains("<title>d · 轿车 / car · 7 m/s</title>"));
    // Its front right corner: (58 + 2.25 - 40, 1.2 - 0.9) is 20.25 m ahead, 0.3 m left: (-3, -203) in decimetres.
    assert!(card.contains("L-3 -203") || card.contains("L-3 -202"));
}

#[test]
fn unknown_is_a_gap_and_infinite_is_not_drawn_as_a_number() {
    let page = page("d", 10);
    let plot = page.split("<code>target.ttc</code>").nth(1).unwrap().split("</figure>").next().unwrap();
    let line = plot.split("class=\"line\" d=\"").nth(1).unwrap().split('"').next().unwrap();
    // Frames 10 to 99 are shown (3 s around 20..70); 10 to 19 are unknown.
    assert_eq!(line.matches('M').count(), 1);
    assert_eq!(line.matches('L').count(), 99 - 20);
}

#[test]
fn episodes_that_the_page_cannot_hold_are_counted() {
    let page = page("d", 0);
    assert!(page.contains("left out: </span>1</p>"));
    assert!(!page.contains("<article"));
}
