//! Turns, lane changes and lanes.

use super::*;

#[test]
fn the_way_round_a_roundabout_is_no_u_turn() {
    let exit = |inside: bool, driving: &str| {
        draft_of("proactive.roundabout.exit", |s| {
            turns(s, "uturn");
            flag(s, "map.in_roundabout", inside);
            s.frame_columns.insert("map.driving_side".into(), category(&[driving], vec![0; fixture::FRAMES]));
        })
        .label
        .driving_decision
        .lateral_direction
    };
    assert_eq!(exit(true, "left"), Some(LateralDirection::Left));
    assert_ne!(exit(false, "left"), Some(LateralDirection::Left));
    // The heading of the fixture changes to the left; the way round bends to both sides and contradicts neither.
    assert_eq!(exit(true, "right"), Some(LateralDirection::Right));
}

#[test]
fn a_turn_has_its_side_and_a_lane_change_is_no_decision_of_a_cut_in() {
    let turn = draft_of("proactive.turn.left_normal", |s| {
        let codes = (0..fixture::FRAMES).map(|f| if f < 60 { u16::MAX } else { 0 }).collect();
        s.frame_columns.insert("ego.movement".into(), category(&["left"], codes));
    });
    let decision = &turn.label.driving_decision;
    assert_eq!(
        (decision.lateral, decision.lateral_direction),
        (Some(Lateral::Turn), Some(LateralDirection::Left))
    );

    let change = |s: &mut SignalTable| {
        let codes = (0..fixture::FRAMES).map(|f| u16::from(f > 50)).collect();
        s.frame_columns.insert("ego.lane_change".into(), category(&["none", "right"], codes));
        // Somebody ahead holds the ego up.
        of_target(s, "target.longitudinal", 20.0);
        of_target(s, "target.lateral", 0.0);
    };
    let own = draft_of("proactive.lane_change.efficiency", change).label.driving_decision;
    assert_eq!(
        (own.lateral, own.lateral_direction),
        (Some(Lateral::LaneChange), Some(LateralDirection::Right))
    );
    let open = draft_of("proactive.lane_change", change);
    assert_eq!(open.label.driving_decision.lateral, Some(Lateral::LaneChange));
    assert_eq!(open.label.scenario.l3, None);
    assert!(open.notes.iter().any(|n| n.en.contains("variant (L3)")));
    // Not a typical decision for a cut-in (scenarios/decisions.yaml): it is a decision only if it begins within 2 s.
    let cutin = |from: usize| {
        draft_of("reactive_agent.cutin.urgent", |s| {
            let codes = (0..fixture::FRAMES).map(|f| u16::from(f >= from)).collect();
            s.frame_columns.insert("ego.lane_change".into(), category(&["none", "right"], codes));
        })
        .label
        .driving_decision
    };
    let (soon, late) = (cutin(60), cutin(61));
    assert_eq!(
        (soon.lateral, soon.lateral_direction),
        (Some(Lateral::LaneChange), Some(LateralDirection::Right))
    );
    assert_eq!((late.lateral, late.lateral_direction), (None, None));
    // It is not allowed for an animal at all.
    let animal = draft_of("reactive_agent.animal.crossing", change).label.driving_decision;
    assert_eq!((animal.lateral, animal.lateral_direction), (None, None));
}

#[test]
fn a_speed_is_fitted_to_a_gap_only_with_somebody_near_in_the_lane_changed_to() {
    let change = |near: f64| {
        draft_of("proactive.lane_change.navigation", |s| {
            with_speed(s, |f| 12.0 + 0.1 * f.saturating_sub(45) as f64);
            let codes = (0..fixture::FRAMES).map(|f| u16::from(f > 50)).collect();
            s.frame_columns.insert("ego.lane_change".into(), category(&["none", "right"], codes));
            let last = |t: &whyroad_model::signal::TargetSpan| t.first_row + t.frames.end - t.frames.start;
            let rows = s.targets.iter().map(last).max().unwrap_or(0);
            s.target_columns.insert("target.lane_side".into(), category(&["right"], vec![0; rows]));
            s.target_columns.insert("target.longitudinal".into(), Column::Number(vec![near; rows]));
            s.target_columns.insert("target.distance".into(), Column::Number(vec![near; rows]));
        })
        .label
    };
    let (near, far) = (change(20.0), change(80.0));
    assert_eq!(near.driving_decision.longitudinal, Some(Longitudinal::GapMatching));
    let names_it =
        |l: &CocLabel| l.critical_components.iter().any(|c| c.description.contains("右侧车道前方不远有车"));
    assert!(names_it(&near), "{:?}", near.critical_components);
    assert_ne!(far.driving_decision.longitudinal, Some(Longitudinal::GapMatching));
}

#[test]
fn who_turns_the_way_of_its_lane_does_not_leave_it_and_who_stands_at_red_waits() {
    let side = |s: &mut SignalTable, name: &str| {
        let codes = (0..fixture::FRAMES).map(|f| if f > 50 { 1 } else { 0 }).collect();
        s.frame_columns.insert(name.into(), category(&["none", "right"], codes));
    };
    let turn = draft_of("reactive_rule.special_lane.turn_only_right", |s| {
        with_speed(s, |_| 8.0);
        side(s, "ego.lane_change");
        let codes = (0..fixture::FRAMES).map(|f| if f > 50 { 0 } else { u16::MAX }).collect();
        s.frame_columns.insert("ego.movement".into(), category(&["right"], codes));
    });
    assert_eq!(turn.label.driving_decision.lateral, Some(Lateral::Turn));
    assert!(!turn.label.coc_trace.contains("不一致"), "{}", turn.label.coc_trace);
    let waits = draft_of("proactive.turn.left_cut_corner", |s| {
        with_speed(s, |f| 0.1 * f.saturating_sub(60) as f64);
        s.frame_columns.insert("light.state".into(), category(&["red"], vec![0; fixture::FRAMES]));
        let codes = (0..fixture::FRAMES).map(|f| if f < 60 { u16::MAX } else { 0 }).collect();
        s.frame_columns.insert("ego.movement".into(), category(&["left"], codes));
    })
    .label;
    assert_eq!(waits.driving_decision.longitudinal, Some(Longitudinal::Resume));
    assert!(waits.coc_trace.contains("红灯") && waits.coc_trace.contains('等'), "{}", waits.coc_trace);
}

/// What Stage I lists of a turn is the junction: without a word of the side, the route to that side was not observed.
#[test]
fn a_turn_whose_side_no_component_names_has_a_cause_that_was_not_observed() {
    let drive = fixture::drive("d");
    let (mut drive, mut signals) = (drive.clone(), fixture::signals(&drive));
    turns(&mut signals, "left");
    with_speed(&mut signals, |f| 10.0 - 0.15 * f.saturating_sub(45) as f64);
    turn_with(&mut drive, &signals);
    let mut episode = fixture::episode(&drive);
    episode.scenario_id = "proactive.turn.left_normal".parse().unwrap();
    let framework = Framework::bundled();
    let drafted = |description: &str| {
        let mut listed = draft(framework, &drive, &signals, &episode, Lang::Zh).label.critical_components;
        assert_eq!(listed.len(), 1, "{listed:?}");
        listed[0].description = description.to_owned();
        let label = draft_of_listed(framework, &drive, &signals, &episode, Lang::Zh, &listed).label;
        let found = crate::check::Checker::new(framework).check_text(&serde_json::to_string(&label).unwrap());
        assert!(found.iter().all(|d| d.code != "label.cause.kind"), "{found:?}");
        assert!(label.driving_decision.longitudinal.is_some());
        label.causes.unwrap().lateral.unwrap()
    };
    let unnamed = drafted("已经行至一处路口");
    assert!(unnamed.components.is_empty() && unnamed.unobserved.is_some());
    assert_eq!(drafted("自车已经行至路口，要向左转").components, ["c1"]);
}

#[test]
fn a_turn_that_follows_at_once_is_a_decision_whose_cause_is_the_indicator_or_unobserved() {
    let turn = |from: usize, signals_left: bool| {
        draft_of("reactive_agent.vru_crossing.crosswalk", |s| {
            with_speed(s, |f| 10.0 - 0.08 * f.saturating_sub(44) as f64);
            let codes = (0..fixture::FRAMES).map(|f| if f < from { u16::MAX } else { 0 }).collect();
            s.frame_columns.insert("ego.movement".into(), category(&["left"], codes));
            if signals_left {
                s.frame_columns
                    .insert("ego.turn_signal".into(), category(&["left"], vec![0; fixture::FRAMES]));
            }
        })
        .label
    };
    assert_eq!(turn(61, true).driving_decision.lateral, None);
    let (told, untold) = (turn(60, true), turn(60, false));
    for label in [&told, &untold] {
        assert_eq!(label.driving_decision.lateral, Some(Lateral::Turn));
        assert_eq!(label.driving_decision.lateral_direction, Some(LateralDirection::Left));
    }
    let lateral = |label: &CocLabel| label.causes.clone().unwrap().lateral.unwrap();
    let named = lateral(&told).components;
    let intent = told.critical_components.iter().find(|c| c.description.contains("左转向灯")).unwrap();
    assert_eq!(named, [intent.id.clone().unwrap()]);
    assert!(lateral(&untold).components.is_empty() && lateral(&untold).unobserved.is_some());
}

#[test]
fn a_reserved_lane_is_the_one_that_the_ego_is_in_or_goes_to() {
    let tidal = |is_tidal: bool| {
        draft_of("reactive_rule.special_lane.tidal_lane", |s| {
            flag(s, "map.tidal_lane", is_tidal);
            let codes = (0..fixture::FRAMES).map(|f| u16::from(f > 50)).collect();
            s.frame_columns.insert("ego.lane_change".into(), category(&["none", "left"], codes));
        })
        .label
        .coc_trace
    };
    let (leaves, enters) = (tidal(true), tidal(false));
    assert!(leaves.contains("自车所在的车道是潮汐车道") && leaves.contains("相遇"), "{leaves}");
    assert!(enters.contains("旁边的车道是潮汐车道") && !enters.contains("相遇"), "{enters}");
}

#[test]
fn who_turns_needs_no_gap_and_nobody_is_said_to_be_there() {
    let turn = draft_of("reactive_rule.special_lane.turn_only_right", |s| {
        with_speed(s, |f| 10.0 - 0.08 * f.saturating_sub(44) as f64);
        let codes = (0..fixture::FRAMES).map(|f| if f > 50 { 0 } else { u16::MAX }).collect();
        s.frame_columns.insert("ego.movement".into(), category(&["right"], codes));
        s.target_columns.insert("target.lane_side".into(), category(&["right"], vec![0; fixture::FRAMES]));
        of_target(s, "target.longitudinal", 20.0);
        of_target(s, "target.distance", 20.0);
    })
    .label;
    assert_eq!(turn.driving_decision.longitudinal, Some(Longitudinal::RoadSpeedAdaptation));
    let guided = behind_lead("reactive_rule.lane_rule.guidance_line", 200.0, |s| {
        with_speed(s, |_| 8.0);
        let codes = (0..fixture::FRAMES).map(|f| if f > 50 { 0 } else { u16::MAX }).collect();
        s.frame_columns.insert("ego.movement".into(), category(&["left"], codes));
    });
    assert_eq!(guided.driving_decision.lateral, Some(Lateral::Turn));
    assert!(!guided.coc_trace.contains("对方"), "{}", guided.coc_trace);
}
