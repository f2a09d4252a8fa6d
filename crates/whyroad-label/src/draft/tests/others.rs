//! Leads and other road users: near or far, their positions, and whether they do what the class states.

use super::*;

#[test]
fn a_lead_that_is_near_is_the_nearest_cause() {
    // LABELING.md 6, proximate cause: the stopped lead before the junction behind it. From 8 m/s to a standstill.
    let turn = |ahead: f64| {
        behind_lead("proactive.turn.left_normal", ahead, |s| {
            with_speed(s, |f| (8.0 - 0.15 * f.saturating_sub(44) as f64).max(0.0));
            of_target(s, "target.speed", 0.0);
            flag(s, "target.standstill", true);
        })
    };
    // 2 s at 8 m/s are 16 m.
    let near = turn(20.6);
    assert_eq!(near.driving_decision.longitudinal, Some(Longitudinal::LeadFollowing));
    assert!(near.coc_trace.contains("前车") && near.coc_trace.contains("轿车静止不动"), "{}", near.coc_trace);
    let cause = near.causes.unwrap().longitudinal.unwrap().components;
    let lead = near.critical_components.iter().find(|c| !c.linked_objects.is_empty()).unwrap();
    assert_eq!(
        (cause, lead.linked_objects.as_slice()),
        (vec![lead.id.clone().unwrap()], &["d".to_owned()][..])
    );
    // Farther away it is if the ego would reach it within 7 s: 56 m to a standing lead.
    assert_eq!(turn(60.6).driving_decision.longitudinal, Some(Longitudinal::LeadFollowing));
    let far = turn(60.7);
    assert_eq!(far.driving_decision.longitudinal, Some(Longitudinal::RoadSpeedAdaptation));
    assert!(!far.coc_trace.contains("前车"), "{}", far.coc_trace);
    // An ego that stands behind a stationary lead remains stationary because of it.
    let stays = behind_lead("proactive.turn.straight", 8.0, |s| {
        with_speed(s, |_| 0.0);
        of_target(s, "target.speed", 0.0);
        flag(s, "target.standstill", true);
    });
    assert_eq!(stays.driving_decision.longitudinal, None);
    assert!(stays.coc_trace.contains("前车"), "{}", stays.coc_trace);
    // An ego that speeds up behind a lead that drives on follows it.
    let follows = behind_lead("proactive.turn.straight", 12.0, |s| {
        with_speed(s, |f| 6.0 + 0.1 * f.saturating_sub(44) as f64);
        of_target(s, "target.speed", 7.0);
    });
    assert_eq!(follows.driving_decision.longitudinal, Some(Longitudinal::LeadFollowing));
}

#[test]
fn stage_one_lists_a_near_lead_in_both_languages() {
    // LABELING.md 3: what is known at the keyframe. A lead that keeps the ego's 8 m/s is near up to 2 s, 16 m; the gap
    // is 4.65 m less than the distance of the centers.
    let listed = |ahead: f64, lang: Lang| {
        let drive = fixture::drive("d");
        let mut signals = fixture::signals(&drive);
        with_speed(&mut signals, |_| 8.0);
        flag(&mut signals, "target.is_lead", true);
        of_target(&mut signals, "target.longitudinal", ahead);
        of_target(&mut signals, "target.lateral", 0.0);
        of_target(&mut signals, "target.speed", 8.0);
        let mut episode = fixture::episode(&drive);
        episode.scenario_id = "proactive.turn.left_normal".parse().unwrap();
        episode.target_id = None;
        components(Framework::bundled(), &drive, &signals, &episode, lang)
    };
    let leads = |ahead: f64, lang: Lang| {
        let all = listed(ahead, lang);
        (all.len(), all.iter().filter(|c| c.linked_objects == ["d"]).count())
    };
    for lang in [Lang::Zh, Lang::En] {
        assert_eq!((leads(20.6, lang), leads(20.7, lang)), ((2, 1), (1, 0)), "{lang:?}");
    }
}

/// LABELING.md 3: only what could be observed at or before the keyframe. Of a car that is seen for the first time in
/// the keyframe's frame nobody knows whether it moves, nor where to.
#[test]
fn nothing_is_said_of_the_motion_of_somebody_just_seen() {
    let said = |leaf: &str, speed: f64, lang: Lang| {
        let drive = fixture::drive("d");
        let mut signals = fixture::signals(&drive);
        signals.target_columns.remove("target.standstill");
        of_target(&mut signals, "target.longitudinal", 20.0);
        of_target(&mut signals, "target.lateral", -8.0);
        of_target(&mut signals, "target.speed", speed);
        let mut episode = fixture::episode(&drive);
        episode.scenario_id = leaf.parse().unwrap();
        components(Framework::bundled(), &drive, &signals, &episode, lang)[0].description.clone()
    };
    for leaf in ["reactive_agent.intersection_interaction.cross_conflict", "reactive_agent.following.steady"]
    {
        let [zh, en] = [Lang::Zh, Lang::En].map(|lang| said(leaf, f64::NAN, lang));
        assert!(zh.ends_with("前方有轿车") && !zh.contains('正'), "{zh}");
        assert!(en.starts_with("the car is ahead"), "{en}");
        assert!(!said(leaf, 5.0, Lang::Zh).ends_with("有轿车"));
    }
}

/// Stage I reads the last frame of a drive that ends at the keyframe; distances of boxes are not known there.
#[test]
fn who_comes_from_the_opposite_direction_is_seen_in_the_last_frame_too() {
    let free = |ahead: f64| {
        let drive = fixture::drive("d");
        let mut signals = fixture::signals(&drive);
        with_speed(&mut signals, |_| 5.0);
        of_target(&mut signals, "target.longitudinal", ahead);
        of_target(&mut signals, "target.lateral", 3.0);
        of_target(&mut signals, "target.heading_difference", 3.1);
        of_target(&mut signals, "target.distance", f64::NAN);
        let right = category(&["right"], vec![0; fixture::FRAMES]);
        signals.frame_columns.insert("map.driving_side".into(), right);
        let mut episode = fixture::episode(&drive);
        episode.scenario_id = "proactive.turn.left_unprotected".parse().unwrap();
        episode.target_id = None;
        let all = components(Framework::bundled(), &drive, &signals, &episode, Lang::Zh);
        all.iter().any(|c| c.description.contains("没有来车"))
    };
    assert_eq!((free(79.0), free(81.0)), (false, true));
}

#[test]
fn no_vehicle_is_made_up_for_a_lane_change() {
    let change = |leaf: &str, ahead: f64| {
        behind_lead(leaf, ahead, |s| {
            of_target(s, "target.speed", 7.0);
            of_target(s, "target.relative_speed", -3.0);
        })
    };
    for leaf in ["proactive.lane_change", "proactive.lane_change.efficiency"] {
        // A gap of 49.9 m, and of 50.1 m.
        let (near, far) = (change(leaf, 54.55), change(leaf, 54.75));
        assert_eq!(near.critical_components[0].linked_objects, ["d"], "{leaf}");
        assert!(near.coc_trace.contains("轿车开得比自车慢"), "{}", near.coc_trace);
        // LABELING.md 6: a decision without a cause has no trace that makes one up.
        assert!(far.coc_trace.is_empty() && far.critical_components.is_empty(), "{leaf}: {}", far.coc_trace);
    }
    // A lead that is faster does not hold the ego up.
    let faster = draft_of("proactive.lane_change", |s| of_target(s, "target.relative_speed", 3.0));
    assert_eq!(faster.doubt, Some(Doubt::NoReason));
    // Nobody is in the lane from which the ego returns.
    let abort = change("proactive.lane_change.abort", 100.0);
    assert!(!abort.coc_trace.contains("对方") && abort.coc_trace.contains("没有"), "{}", abort.coc_trace);
    assert_eq!(abort.critical_components[0].uncertainty, Some(Uncertainty::High));
}

#[test]
fn a_junction_is_not_ahead_of_who_is_in_it() {
    for (inside, said, unsaid) in [(true, "路口内", "前方为路口"), (false, "前方为路口", "路口内")]
    {
        let label = draft_of("proactive.turn.left_normal", |s| {
            with_speed(s, |_| 6.0);
            turns(s, "left");
            flag(s, "ego.in_junction", inside);
            s.frame_columns.insert("route.command".into(), category(&["left"], vec![0; fixture::FRAMES]));
        })
        .label;
        let said = if inside { said } else { "前方路口" };
        assert!(label.coc_trace.contains(said) && !label.coc_trace.contains(unsaid), "{}", label.coc_trace);
        let straight = draft_of("proactive.turn.straight", |s| flag(s, "ego.in_junction", inside)).label;
        assert_eq!(straight.coc_trace.contains("已经驶入路口"), inside, "{}", straight.coc_trace);
        assert_eq!(straight.coc_trace.contains("行至一处路口"), !inside, "{}", straight.coc_trace);
    }
}

#[test]
fn place_and_phase_are_those_of_the_boxes() {
    let said = |ahead: f64, inside: bool| {
        draft_of("reactive_agent.intersection_interaction.cross_conflict", |s| {
            of_target(s, "target.longitudinal", ahead);
            of_target(s, "target.lateral", 3.0);
            of_target(s, "target.heading_difference", 0.0);
            flag(s, "target.in_junction", inside);
        })
        .label
        .critical_components[0]
            .description
            .clone()
    };
    // Boxes of 4.8 m and 4.5 m overlap up to 4.65 m.
    assert!(said(4.6, false).starts_with("左侧的") && said(4.7, false).starts_with("左前方的"));
    assert!(said(-4.6, true).starts_with("左侧的") && said(-4.7, true).starts_with("左后方的"));
    assert!(said(9.0, false).contains("驶向路口") && said(9.0, true).contains("通过路口"));
    assert!(!said(-6.0, false).contains("路口"));
}

#[test]
fn whom_a_class_is_about_does_what_it_says_or_there_is_no_draft() {
    // A pedestrian walking across gets onto the path 3 s after the keyframe, 10 m ahead of the ego, or 10 m behind it.
    let crossing = |along: f64, way: &str| {
        draft_of("reactive_agent.vru_crossing.horizontal", |s| {
            with_speed(s, |f| 10.0 - 0.1 * f.saturating_sub(44) as f64);
            of_target(s, "target.longitudinal", 20.0);
            by_frame(s, "target.path_lateral", |f| 1.3 * (7.0 - 0.1 * f as f64));
            by_frame(s, "target.path_longitudinal", |f| if f < 50 { 20.0 } else { along });
            s.target_columns.insert("target.moves_along".into(), category(&[way], vec![0; fixture::FRAMES]));
        })
    };
    let first = crossing(10.0, "across");
    assert_eq!(
        (first.doubt, first.label.driving_decision.longitudinal),
        (None, Some(Longitudinal::YieldToAgent))
    );
    assert_eq!(crossing(-10.0, "across").doubt, Some(Doubt::EgoFirst));
    // An oncoming road user does not cross.
    assert_eq!(crossing(10.0, "against").doubt, Some(Doubt::NotCrossing));
    // A road user that drove at 12 m/s all the time has not just started.
    let starts = |speed: fn(usize) -> f64| {
        draft_of("reactive_agent.cutin.from_stationary", |s| {
            with_speed(s, |f| 10.0 - 0.1 * f.saturating_sub(44) as f64);
            by_frame(s, "target.speed", speed);
        })
        .doubt
    };
    assert_eq!(starts(|_| 12.0), Some(Doubt::NotStarting));
    assert_eq!(starts(|f| 0.1 * f.saturating_sub(20) as f64), None);
    // Braking that begins 2.5 s after the lead brakes hard is no response to it, nor is speeding up.
    let brakes = |from: usize, by: f64| {
        draft_of("reactive_agent.following.lead_sudden_brake", |s| {
            with_speed(s, |f| (12.0 + by * f.saturating_sub(from) as f64).max(0.0));
            flag(s, "target.is_lead", true);
            of_target(s, "target.longitudinal", 20.0);
            of_target(s, "target.lateral", 0.0);
            by_frame(s, "target.accel", |f| if (40..50).contains(&f) { -4.0 } else { 0.0 });
        })
        .doubt
    };
    assert_eq!((brakes(50, -0.2), brakes(65, -0.2)), (None, Some(Doubt::Motion)));
    // Nor does an ego respond that keeps its speed.
    assert_eq!(brakes(999, -0.2), Some(Doubt::Motion));
    assert_eq!(brakes(50, 0.2), Some(Doubt::Motion));
    // The ego cannot yield if nobody is there.
    let nobody = behind_lead("proactive.merge_interaction.zipper_merge", 100.0, |s| {
        with_speed(s, |f| 17.0 - 0.1 * f.saturating_sub(44) as f64);
    });
    assert_ne!(nobody.driving_decision.longitudinal, Some(Longitudinal::YieldToAgent));
}

/// LABELING.md 3: a cause is visible at the keyframe. What lets a waiting ego go is not, if it moves off later.
#[test]
fn what_lets_a_waiting_ego_go_comes_after_the_keyframe() {
    // It stands at the keyframe and moves off at 1 m/s2, 4 s later.
    let waits = draft_of("proactive.turn", |s| with_speed(s, |f| 0.1 * f.saturating_sub(80) as f64));
    assert_eq!(waits.doubt, Some(Doubt::WaitsFirst));
}

/// The nearest cause comes first (LABELING.md 6, *proximate cause*).
#[test]
fn who_stops_behind_a_lead_or_at_red_does_not_stop_for_anything_farther() {
    // The ego brakes at 2 m/s2 from 10 m/s and stands 25 m on.
    let brakes = |s: &mut SignalTable| with_speed(s, |f| (10.0 - 0.2 * f.saturating_sub(44) as f64).max(0.0));
    // The lead slows too, from 4 m/s, and both stand 2 m apart.
    let leaf = "reactive_agent.intersection_interaction.unprotected_left";
    let behind = behind_lead(leaf, 20.0, |s| {
        brakes(s);
        by_frame(s, "target.speed", |f| (4.0 - 0.1 * f.saturating_sub(44) as f64).max(0.0));
        by_frame(s, "target.longitudinal", |f| (20.0 - 0.2 * f.saturating_sub(44) as f64).max(6.65));
    });
    assert_eq!(
        behind.driving_decision.longitudinal,
        Some(Longitudinal::LeadFollowing),
        "{}",
        behind.coc_trace
    );
    // Nor does it stop for cones at a red light.
    let cones = "reactive_rule.road_change.cone";
    let drafted = |state: Option<&str>| {
        draft_of(cones, |s| {
            brakes(s);
            if let Some(state) = state {
                let light = category(&[state], vec![0; fixture::FRAMES]);
                s.frame_columns.insert("light.state".into(), light);
            }
        })
    };
    assert_eq!(drafted(None).doubt, None);
    assert_eq!(drafted(Some("red")).doubt, Some(Doubt::RedLight));
    assert_eq!(drafted(Some("green")).doubt, None);
}

/// LABELING.md 6, *causal correctness*: a cyclist in the ego's lane whom it follows down to his 4 m/s is the cause, and
/// not a car that stands on the other side 100 m on.
#[test]
fn there_is_no_draft_where_something_else_holds_the_ego() {
    let drafted = |cyclist: bool| {
        let mut drive = fixture::drive("d");
        let mut signals = fixture::signals(&drive);
        // At 1.5 m/s2 from 10 m/s at 4 s to 4 m/s at 8 s.
        let speed = |f: usize| (10.0 - 0.15 * f.saturating_sub(40) as f64).max(4.0);
        with_speed(&mut signals, speed);
        let x = (0..fixture::FRAMES).scan(0.0, |at, f| {
            let here = *at;
            *at += 0.1 * speed(f);
            Some(here)
        });
        drive.ego.as_mut().unwrap().motion.x = x.collect();
        let stands = |track: &mut whyroad_model::scene::Track, x: f64, y: f64, mps: f64| {
            track.motion.x = (0..fixture::FRAMES).map(|f| x + 0.1 * mps * f as f64).collect();
            track.motion.y = vec![y; fixture::FRAMES];
            track.motion.vx = vec![mps; fixture::FRAMES];
        };
        let mut rider = drive.tracks[0].clone();
        stands(&mut drive.tracks[0], 140.0, 3.5, 0.0);
        if cyclist {
            rider.id = "rider".into();
            rider.class = whyroad_model::ObjectClass::Bicycle;
            rider.length_m = vec![1.8; fixture::FRAMES];
            rider.width_m = vec![0.6; fixture::FRAMES];
            // 25 m ahead of the ego, which is at 40 m, at 4 s.
            stands(&mut rider, 49.0, 0.0, 4.0);
            drive.tracks.push(rider);
        }
        let mut episode = fixture::episode(&drive);
        episode.scenario_id = "reactive_agent.intersection_interaction.unprotected_left".parse().unwrap();
        draft(Framework::bundled(), &drive, &signals, &episode, Lang::Zh).doubt
    };
    assert_eq!((drafted(false), drafted(true)), (None, Some(Doubt::OtherCause)));
}

#[test]
fn who_walks_does_not_stand() {
    // The standstill of the signal ends later than the person's.
    let at = |speed: f64| {
        draft_of("reactive_agent.vru_crossing.horizontal", |s| {
            with_speed(s, |f| 8.0 - 0.12 * f.saturating_sub(44) as f64);
            flag(s, "target.standstill", true);
            of_target(s, "target.speed", speed);
            of_target(s, "target.longitudinal", 15.0);
            of_target(s, "target.lateral", -4.0);
        })
        .label
        .coc_trace
    };
    let (stands, walks) = (at(0.1), at(0.9));
    assert!(stands.contains("停着不动") && !walks.contains("停着不动"), "{stands} {walks}");
    assert!(!stands.contains("停步") && !stands.contains("碰上"), "{stands}");
}

#[test]
fn who_is_in_the_lane_does_not_come_into_it() {
    // A wide truck behind the ego, a wheel over the line, drifting at 0.08 m/s: `target.in_ego_lane` and the sign of
    // `target.lane_lateral_speed` (towards the middle) are as schema/signals.yaml defines them.
    let told = |inside: bool, follows: bool, towards_mps: f64| {
        let drive = fixture::drive("d");
        let mut signals = fixture::signals(&drive);
        flag(&mut signals, "target.wheel_over_line", true);
        flag(&mut signals, "target.in_ego_lane", inside);
        flag(&mut signals, "target.is_follower", follows);
        flag(&mut signals, "target.is_lead", false);
        of_target(&mut signals, "target.longitudinal", -12.0);
        of_target(&mut signals, "target.lateral", 0.2);
        of_target(&mut signals, "target.heading_difference", 0.0);
        of_target(&mut signals, "target.speed", 8.0);
        of_target(&mut signals, "target.lane_lateral_speed", towards_mps);
        let mut episode = fixture::episode(&drive);
        episode.scenario_id = "reactive_agent.following.steady".parse().unwrap();
        let all = components(Framework::bundled(), &drive, &signals, &episode, Lang::En);
        all.iter().map(|c| c.description.clone()).collect::<Vec<_>>().join("|")
    };
    let comes = |told: &str| told.contains("is coming into the ego's lane");
    assert!(!comes(&told(true, true, 0.08)), "{}", told(true, true, 0.08));
    assert!(!comes(&told(true, false, 0.08)), "{}", told(true, false, 0.08));
    assert!(!comes(&told(false, false, -0.5)), "who moves away from the middle leaves");
    assert!(comes(&told(false, false, 0.5)), "{}", told(false, false, 0.5));
    assert!(comes(&told(true, false, 0.5)), "the rest of it is still coming");
}

/// LABELING.md 3: only what could be observed at or before the keyframe. A log without a route shows none before the
/// ego has driven; a command of the navigation does.
#[test]
fn stage_one_states_a_route_only_where_the_log_has_one() {
    let routes = |command: Option<&str>| {
        let drive = fixture::drive("d");
        let mut signals = fixture::signals(&drive);
        if let Some(command) = command {
            let codes = vec![0; fixture::FRAMES];
            signals.frame_columns.insert("route.command".into(), category(&[command], codes));
        }
        let mut episode = fixture::episode(&drive);
        episode.scenario_id = "proactive.lane_change.navigation".parse().unwrap();
        episode.target_id = None;
        let all = components(Framework::bundled(), &drive, &signals, &episode, Lang::En);
        all.iter().filter(|c| is_route(c)).count()
    };
    assert_eq!(routes(None), 0);
    assert!(routes(Some("right")) > 0);
}

/// Somebody who stood up to the keyframe, according to Stage I, and walks in the whole drive: a text that says both is
/// written by nobody.
#[test]
fn a_draft_does_not_say_that_somebody_stands_and_comes_over() {
    let drive = fixture::drive("d");
    let mut signals = fixture::signals(&drive);
    // A pedestrian walking across gets onto the path 3 s after the keyframe, 10 m ahead of the ego.
    with_speed(&mut signals, |f| 10.0 - 0.1 * f.saturating_sub(44) as f64);
    of_target(&mut signals, "target.longitudinal", 20.0);
    by_frame(&mut signals, "target.path_lateral", |f| 1.3 * (7.0 - 0.1 * f as f64));
    by_frame(&mut signals, "target.path_longitudinal", |f| if f < 50 { 20.0 } else { 10.0 });
    signals
        .target_columns
        .insert("target.moves_along".into(), category(&["across"], vec![0; fixture::FRAMES]));
    let mut episode = fixture::episode(&drive);
    episode.scenario_id = "reactive_agent.vru_crossing.horizontal".parse().unwrap();
    let framework = Framework::bundled();
    let mut listed = draft(framework, &drive, &signals, &episode, Lang::En).label.critical_components;
    let drafted = |listed: &[CriticalComponent]| {
        draft_of_listed(framework, &drive, &signals, &episode, Lang::En, listed).doubt
    };
    assert!(!listed.is_empty() && drafted(&listed).is_none(), "{listed:?}");
    listed[0].description = "the pedestrian ahead on the right is standing still".into();
    assert_eq!(drafted(&listed), Some(Doubt::Words));
}
