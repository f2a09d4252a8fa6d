//! The parts of a text agree with each other, with the map, and with what the ego does next.

use super::*;

/// Drafts of one episode in the phrasings of 60 runs, in both languages.
fn drafts(leaf: &str, change: impl Fn(&mut SignalTable)) -> Vec<Draft> {
    let mut drive = fixture::drive("d");
    let mut signals = fixture::signals(&drive);
    change(&mut signals);
    turn_with(&mut drive, &signals);
    let mut episode = fixture::episode(&drive);
    episode.scenario_id = leaf.parse().unwrap();
    let of = |(lang, run)| draft_with_seed(Framework::bundled(), &drive, &signals, &episode, lang, run);
    [Lang::Zh, Lang::En].iter().flat_map(|lang| (0..60).map(|run| (*lang, run))).map(of).collect()
}

fn traces(leaf: &str, change: impl Fn(&mut SignalTable)) -> Vec<String> {
    drafts(leaf, change).into_iter().filter(|d| d.doubt.is_none()).map(|d| d.label.coc_trace).collect()
}

pub(super) fn says(all: &[String], words: &[&str]) -> usize {
    all.iter().filter(|t| words.iter().any(|w| t.contains(w))).count()
}

/// A signal with the same number in every frame.
pub(super) fn number(signals: &mut SignalTable, name: &str, value: f64) {
    signals.frame_columns.insert(name.into(), Column::Number(vec![value; fixture::FRAMES]));
}

pub(super) fn word(signals: &mut SignalTable, name: &str, value: &str) {
    signals.frame_columns.insert(name.into(), category(&[value], vec![0; fixture::FRAMES]));
}

#[test]
fn an_ego_that_brakes_to_a_stand_does_not_go_on_as_it_is() {
    // At 2 m/s2 from 6 m/s at the keyframe it stands after 3 s.
    let stops = traces("reactive_agent.vru_crossing.horizontal", |s| {
        with_speed(s, |f| (6.0 - 0.2 * (f as f64 - 40.0)).clamp(0.0, 12.0));
    });
    let unchanged =
        ["不再另作调整", "按现在的状态继续行驶", "no further change", "goes on like this for now"];
    assert_eq!(says(&stops, &unchanged), 0, "{stops:?}");
}

#[test]
fn an_ego_that_has_braked_for_seconds_does_not_brake_at_once() {
    // At 3 m/s2 for 3.5 s before the keyframe; or from the keyframe on.
    let near_miss = |from: f64| {
        traces("safety.near_miss.general", move |s| {
            with_speed(s, move |f| (14.0 - 0.3 * (f as f64 - from).max(0.0)).max(0.0));
            of_target(s, "target.longitudinal", 12.0);
            of_target(s, "target.lateral", 0.0);
        })
    };
    let at_once = ["立即", "马上", "at once"];
    let (late, now) = (near_miss(5.0), near_miss(40.0));
    assert!(!late.is_empty() && says(&late, &at_once) == 0, "{late:?}");
    assert!(says(&now, &at_once) > 0, "{now:?}");
}

#[test]
fn a_speed_that_falls_first_does_not_rise() {
    // 6 m/s at the keyframe, 5 m/s 1 s later, 6.2 m/s after 3 s: it has gained 0.2 m/s.
    let dips = drafts("proactive.turn.right_normal", |s| {
        with_speed(s, |f| {
            let t = (f as f64 - 40.0) / 10.0;
            if t < 1.0 { 6.0 - t.max(0.0) } else { (5.0 + 0.6 * (t - 1.0)).min(8.0) }
        });
        turns(s, "right");
    });
    let decided = dips.iter().filter_map(|d| d.label.driving_decision.longitudinal);
    assert!(
        decided.clone().all(|d| d != Longitudinal::SetSpeedTracking),
        "{:?}",
        decided.collect::<Vec<_>>()
    );
}

#[test]
fn no_indicator_is_named_where_the_ego_goes_straight_on() {
    let straight = traces("proactive.turn.straight", |s| {
        with_speed(s, |f| 8.0 + 0.1 * f.saturating_sub(40) as f64);
        word(s, "ego.turn_signal", "right");
        flag(s, "ego.in_junction", true);
    });
    assert!(!straight.is_empty() && says(&straight, &["转向灯", "signals right"]) == 0, "{straight:?}");
}

#[test]
fn a_junction_is_named_only_where_one_is_near() {
    let changing = |junction: f64| {
        traces("proactive.lane_change.navigation", move |s| {
            with_speed(s, |_| 12.0);
            number(s, "map.distance_to_junction", junction);
            flag(s, "ego.in_junction", false);
            let codes = (0..fixture::FRAMES).map(|f| if f < 45 { u16::MAX } else { 0 }).collect();
            s.frame_columns.insert("ego.lane_change".into(), category(&["left"], codes));
        })
    };
    let (far, near) = (changing(f64::INFINITY), changing(60.0));
    assert!(!far.is_empty() && says(&far, &["路口", "junction"]) == 0, "{far:?}");
    assert!(says(&near, &["路口"]) > 0, "{near:?}");
}

#[test]
fn the_way_out_of_a_roundabout_does_not_leave_a_main_road() {
    let exit = |inside: bool| {
        traces("proactive.merge_interaction.split_exit", move |s| {
            with_speed(s, |_| 8.0);
            flag(s, "map.in_roundabout", inside);
        })
    };
    let (inside, outside) = (exit(true), exit(false));
    assert!(!inside.is_empty() && says(&inside, &["主路", "main road"]) == 0, "{inside:?}");
    assert_eq!(says(&inside, &["环岛", "roundabout"]), inside.len(), "{inside:?}");
    assert_eq!(says(&outside, &["环岛", "roundabout"]), 0, "{outside:?}");
}

#[test]
fn who_changes_lanes_to_the_same_side_is_not_overtaken() {
    let overtakes = |side: &'static str| {
        draft_of("proactive.lane_change.overtake", move |s| {
            with_speed(s, |_| 15.0);
            of_target(s, "target.speed", 12.0);
            of_target(s, "target.relative_speed", -3.0);
            of_target(s, "target.longitudinal", 40.0);
            of_target(s, "target.lateral", 0.0);
            s.target_columns.insert("target.lane_change".into(), category(&[side], vec![0; fixture::FRAMES]));
            let codes = (0..fixture::FRAMES).map(|f| if f < 45 { u16::MAX } else { 0 }).collect();
            s.frame_columns.insert("ego.lane_change".into(), category(&["left"], codes));
        })
        .doubt
    };
    assert_eq!((overtakes("left"), overtakes("right")), (Some(Doubt::NotInLane), None));
}

#[test]
fn who_meets_the_ego_in_its_own_lane_is_no_near_miss() {
    // Two lanes of 3.2 m: the centers are 3.2 m apart when both meet.
    let meets = |aside: f64| {
        draft_of("safety.near_miss.general", move |s| {
            with_speed(s, |_| 8.0);
            s.target_columns
                .insert("target.moves_along".into(), category(&["against"], vec![0; fixture::FRAMES]));
            of_target(s, "target.distance", 1.2);
            of_target(s, "target.longitudinal", 10.0);
            of_target(s, "target.lateral", aside);
            of_target(s, "target.path_lateral", aside);
        })
        .doubt
    };
    assert_eq!(meets(3.2), Some(Doubt::NotComing));
    assert_ne!(meets(0.5), Some(Doubt::NotComing));
}

#[test]
fn a_steady_speed_is_said_only_where_it_is_steady() {
    // A component has a number, so the opening has none. At 1.5 m/s2 it loses 1.5 m/s in the second before.
    let opening = |slows: f64| {
        traces("reactive_rule.speed_limit", move |s| {
            with_speed(s, |f| 18.0 - slows * (f as f64 - 40.0) / 10.0);
            number(s, "map.speed_limit", 20.0);
            number(s, "map.speed_limit_ahead", 20.0);
        })
    };
    let words = ["车速平稳", "匀速行驶", "steady"];
    let (steady, slowing) = (opening(0.0), opening(1.5));
    assert!(says(&steady, &words) > 0, "{steady:?}");
    assert_eq!(says(&slowing, &words), 0, "{slowing:?}");
}

#[test]
fn a_junction_is_named_once() {
    let turning = drafts("reactive_agent.intersection_interaction.unprotected_left", |s| {
        with_speed(s, |f| (10.0 - 0.1 * f.saturating_sub(40) as f64).max(3.0));
        of_target(s, "target.longitudinal", 40.0);
        of_target(s, "target.lateral", 3.0);
        of_target(s, "target.heading_difference", 3.1);
        of_target(s, "target.speed", 10.0);
        word(s, "ego.turn_signal", "left");
        turns(s, "left");
    });
    let twice = |t: &&String| t.matches("路口").count() > 1 || t.matches("junction").count() > 1;
    assert!(turning.iter().all(|d| d.doubt.is_none()), "{:?}", turning.first());
    let turning: Vec<String> = turning.into_iter().map(|d| d.label.coc_trace).collect();
    assert_eq!(turning.iter().find(twice), None);
}

#[test]
fn an_ego_over_the_limit_is_not_said_to_drive_as_usual() {
    // 25 m/s where 20 m/s are allowed.
    let over = traces("reactive_rule.speed_limit", |s| {
        with_speed(s, |f| 25.0 - 0.15 * f.saturating_sub(42) as f64);
        number(s, "map.speed_limit", 20.0);
        number(s, "map.speed_limit_ahead", 20.0);
    });
    assert!(
        !over.is_empty() && over.iter().all(|t| !(t.contains("超过") && t.contains("正常行驶"))),
        "{over:?}"
    );
}

#[test]
fn an_ego_that_slows_behind_a_junction_does_not_watch_its_sides() {
    // It leaves the junction 1 s after the keyframe, or 4 s after it.
    let through = |frames: usize| {
        traces("proactive.turn.straight", move |s| {
            with_speed(s, |f| 15.0 - 0.15 * f.saturating_sub(45) as f64);
            let inside = (0..fixture::FRAMES).map(|f| Tri::from((35..40 + frames).contains(&f))).collect();
            s.frame_columns.insert("ego.in_junction".into(), Column::Flag(inside));
        })
    };
    let sides = ["还没有走出去", "里面可能有车横穿", "until it is through"];
    assert_eq!(says(&through(10), &sides), 0);
    assert!(says(&through(40), &sides) > 0);
}

#[test]
fn who_brakes_before_a_red_light_does_not_slow_for_the_road() {
    // From 16 m/s at 3.4 m/s2: half of the speed is lost after 2.4 s, 40 m before the line.
    let slows = |light: &'static str| {
        draft_of("reactive_road.geometry_adaptation.dead_end", move |s| {
            with_speed(s, |f| (16.0 - 0.34 * f.saturating_sub(40) as f64).max(3.0));
            number(s, "map.distance_to_junction", 47.0);
            word(s, "light.state", light);
        })
        .doubt
    };
    assert_eq!(slows("red"), Some(Doubt::RedLight));
    assert_ne!(slows("green"), Some(Doubt::RedLight));
}

#[test]
fn an_episode_is_drafted_in_both_languages_or_in_none() {
    let leaves = [
        "reactive_rule.speed_limit",
        "reactive_agent.cutin.urgent",
        "reactive_agent.following.steady",
        "reactive_agent.intersection_interaction.cross_conflict",
        "reactive_rule.traffic_light.green_pass",
        "proactive.turn.straight",
    ];
    for leaf in leaves {
        for (speed, slows) in [(1.0, 0.0), (8.0, 0.4), (8.0, -0.4), (20.0, 2.0), (20.0, 0.0)] {
            let made = drafts(leaf, |s| {
                with_speed(s, |f| (speed - slows * (f as f64 - 40.0) / 10.0).max(0.0));
                number(s, "map.speed_limit", 10.0);
                number(s, "lead.gap", 4.0);
                of_target(s, "target.relative_speed", 3.0);
                of_target(s, "target.path_side_distance", 0.0);
                of_target(s, "target.distance", 3.0);
            });
            let (zh, en) = made.split_at(60);
            let doubts = zh.iter().zip(en).map(|(zh, en)| (zh.doubt, en.doubt));
            let differ = doubts.filter(|(zh, en)| zh != en).collect::<Vec<_>>();
            assert!(differ.is_empty(), "{leaf} at {speed} m/s: {differ:?}");
        }
    }
}

#[test]
fn a_lead_that_has_stopped_is_not_followed_at_a_crawl() {
    let queue = |speed: f64| {
        traces("reactive_agent.following.creeping", move |s| {
            with_speed(s, |f| (2.0 - 0.08 * f.saturating_sub(42) as f64).max(0.5));
            flag(s, "target.is_lead", true);
            flag(s, "target.standstill", speed == 0.0);
            for (name, value) in [
                ("target.speed", speed),
                ("target.relative_speed", speed - 2.0),
                ("target.longitudinal", 9.0),
                ("target.lateral", 0.0),
                ("target.heading_difference", 0.0),
                ("target.distance", 4.4),
            ] {
                of_target(s, name, value);
            }
        })
    };
    let (stands, creeps) = (queue(0.0), queue(1.0));
    let crawls = ["at a crawl", "at low speed", "on bit by bit", "低速跟车", "往前挪"];
    assert!(says(&stands, &["has stopped", "停了下来"]) == stands.len() && !stands.is_empty());
    assert_eq!(says(&stands, &crawls), 0, "{:?}", stands.first());
    assert!(says(&creeps, &crawls) > 0, "{:?}", creeps.first());
}

#[test]
fn a_lead_in_a_bend_is_ahead_and_on_no_side() {
    // It is 14 m ahead and 6 m to the left, turned by 50 degrees, and in the ego's lane.
    let place = |leaf: &str, is_lead: fn(usize) -> bool, from_center: f64, over_line: bool| {
        let made = draft_of(leaf, |s| {
            with_speed(s, |f| 8.0 - 0.1 * f.saturating_sub(42) as f64);
            let leads = (0..fixture::FRAMES).map(|f| Tri::from(is_lead(f))).collect();
            s.target_columns.insert("target.is_lead".into(), Column::Flag(leads));
            flag(s, "target.wheel_over_line", over_line);
            for (name, value) in [
                ("target.longitudinal", 14.0),
                ("target.lateral", 6.0),
                ("target.heading_difference", 0.87),
                ("target.lane_centre_distance", from_center),
                ("target.speed", 6.0),
                ("target.relative_speed", -2.0),
            ] {
                of_target(s, name, value);
            }
        });
        made.label.critical_components.first().map(|c| c.description.clone()).unwrap_or_default()
    };
    let (enters, follows) = ("reactive_agent.cutin.slow", "reactive_agent.following.steady");
    for (leaf, is_lead, from_center, over_line, begins) in [
        (enters, (|_| true) as fn(usize) -> bool, 0.4, false, "前方的轿车"),
        (enters, |_| true, 0.4, true, "前方的轿车"),
        // One that is still coming in does so from a side.
        (enters, |_| true, 1.4, true, "左前方的轿车"),
        // Whom the ego follows may be no lead for a moment.
        (follows, |f| f < 38, 0.4, false, "前方的轿车"),
    ] {
        let text = place(leaf, is_lead, from_center, over_line);
        assert!(text.starts_with(begins), "{leaf} {from_center}: {text}");
    }
}

#[test]
fn the_gap_that_the_speed_fits_is_caused_by_who_makes_it() {
    let merged = draft_of("proactive.lane_change.navigation", |s| {
        with_speed(s, |f| 12.0 + 0.1 * f.saturating_sub(45) as f64);
        let codes = (0..fixture::FRAMES).map(|f| u16::from(f > 50)).collect();
        s.frame_columns.insert("ego.lane_change".into(), category(&["none", "right"], codes));
        let last = |t: &whyroad_model::signal::TargetSpan| t.first_row + t.frames.end - t.frames.start;
        let rows = s.targets.iter().map(last).max().unwrap_or(0);
        s.target_columns.insert("target.lane_side".into(), category(&["right"], vec![0; rows]));
        s.target_columns.insert("target.longitudinal".into(), Column::Number(vec![20.0; rows]));
        s.target_columns.insert("target.distance".into(), Column::Number(vec![20.0; rows]));
    })
    .label;
    assert_eq!(merged.driving_decision.longitudinal, Some(Longitudinal::GapMatching));
    let cause = merged.causes.unwrap().longitudinal.unwrap().components;
    let of = merged.critical_components.iter().find(|c| c.id.as_ref() == cause.first()).unwrap();
    assert!(of.description.contains("右侧车道") && !of.linked_objects.is_empty(), "{of:?}");
}

#[test]
fn nothing_that_stands_in_the_lane_makes_the_ego_faster() {
    let passes = |leaf: &str, stands: bool| {
        draft_of(leaf, |s| {
            with_speed(s, |f| 4.0 + 0.15 * f.saturating_sub(42).min(40) as f64);
            of_target(s, "target.longitudinal", 20.0);
            of_target(s, "target.lateral", -1.5);
            of_target(s, "target.speed", if stands { 0.0 } else { 3.0 });
            flag(s, "target.standstill", stands);
            let codes = (0..fixture::FRAMES).map(|f| if f < 45 { u16::MAX } else { 0 }).collect();
            s.frame_columns.insert("ego.lane_change".into(), category(&["left"], codes));
            number(s, "ego.lane_offset", 0.0);
        })
        .label
        .driving_decision
        .longitudinal
    };
    for leaf in ["proactive.obstacle_avoidance.in_lane", "proactive.lane_change.efficiency"] {
        assert_ne!(passes(leaf, true), Some(Longitudinal::SetSpeedTracking), "{leaf}");
    }
    assert_eq!(passes("proactive.lane_change.efficiency", false), Some(Longitudinal::SetSpeedTracking));
}

#[test]
fn braking_that_goes_on_is_no_reason_for_itself() {
    for leaf in ["reactive_agent.following.steady", "reactive_agent.vru_crossing.crosswalk"] {
        let slowing = traces(leaf, |s| {
            with_speed(s, |f| 12.0 - 0.1 * f as f64);
            flag(s, "target.is_lead", leaf.contains("following"));
            of_target(s, "target.longitudinal", 25.0);
            of_target(s, "target.lateral", 0.0);
            of_target(s, "target.speed", 7.0);
            of_target(s, "target.relative_speed", -1.8);
        });
        let circle = ["so the speed of the ego goes on falling", "因此自车的车速继续下降"];
        assert!(!slowing.is_empty() && says(&slowing, &circle) == 0, "{leaf}: {:?}", slowing.first());
    }
}
