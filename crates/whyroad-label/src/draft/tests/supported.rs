//! What the beginning or the end of a record, a light, or the ego's own way does not support is not stated: each was
//! wrong in a draft of a recorded drive (`docs/explanation/drafts.md`, *No draft*).

use super::agree::{number, word};
use super::*;

/// The label of an episode of steady following whose target is the lead, 25 m ahead.
fn follows(change: impl FnOnce(&mut SignalTable)) -> CocLabel {
    let made = draft_of("reactive_agent.following.steady", |s| {
        flag(s, "target.is_lead", true);
        of_target(s, "target.longitudinal", 25.0);
        of_target(s, "target.lateral", 0.0);
        of_target(s, "target.heading_difference", 0.0);
        change(s);
    });
    made.label
}

/// Descriptions of the components and the trace.
fn texts(label: &CocLabel) -> String {
    let parts = label.critical_components.iter().map(|c| c.description.as_str());
    parts.chain([label.coc_trace.as_str()]).collect::<Vec<_>>().join("|")
}

#[test]
fn a_speed_that_is_not_known_before_the_keyframe_does_not_change() {
    // It brakes at 1.2 m/s2 in the keyframe's frame; its speed is known for the whole drive, or from 0.3 s before on.
    let leads = |known_from: usize| {
        follows(|s| {
            with_speed(s, |f| 10.0 - 0.08 * f.saturating_sub(42) as f64);
            of_target(s, "target.accel", -1.2);
            of_target(s, "target.relative_speed", 0.0);
            by_frame(s, "target.speed", |f| if f < known_from { f64::NAN } else { 14.8 - 0.12 * f as f64 });
        })
    };
    assert!(texts(&leads(0)).contains("正在减速"), "{}", texts(&leads(0)));
    let seen_late = texts(&leads(37));
    assert!(seen_late.contains("车速与自车相近") && !seen_late.contains("正在减速"), "{seen_late}");
}

#[test]
fn a_lead_of_about_the_same_speed_is_not_said_to_be_faster() {
    let speeds_up = |relative: f64| {
        texts(&follows(|s| {
            with_speed(s, |f| 10.0 + 0.1 * f.saturating_sub(42) as f64);
            of_target(s, "target.relative_speed", relative);
            of_target(s, "target.speed", 10.0 + relative);
            of_target(s, "target.accel", 0.0);
        }))
    };
    let (alike, faster) = (speeds_up(0.6), speeds_up(2.5));
    assert!(!alike.is_empty() && !alike.contains("前车比自车快"), "{alike}");
    assert!(faster.contains("车速高于自车"), "{faster}");
}

#[test]
fn a_class_that_states_a_decision_has_no_draft_without_one() {
    // scenarios/decisions.yaml: following.follow_stop is a decision; this ego keeps its speed.
    let keeps = draft_of("reactive_agent.following.follow_stop", |s| with_motion(s, |_| 2));
    assert_eq!(keeps.doubt, Some(Doubt::Motion));
    // TAXONOMY.md: a narrow road is a reason to slow down.
    let narrow = |after: u16| {
        draft_of("reactive_road.geometry_adaptation.narrow", |s| {
            with_motion(s, |f| if f < 45 { 2 } else { after });
        })
    };
    assert_eq!(narrow(3).doubt, Some(Doubt::Motion));
    assert_eq!(narrow(1).doubt, None);
}

#[test]
fn a_turn_to_the_other_side_is_not_drafted() {
    let turn = |side: &str| {
        draft_of("proactive.turn.right_normal", |s| {
            with_motion(s, |_| 2);
            turns(s, side);
        })
    };
    assert_eq!(turn("left").doubt, Some(Doubt::Motion));
    assert_eq!(turn("right").label.driving_decision.lateral_direction, Some(LateralDirection::Right));
}

#[test]
fn without_a_route_the_cause_of_a_turn_is_unobserved() {
    let d = draft_of("proactive.turn.right_normal", |s| {
        with_motion(s, |_| 2);
        turns(s, "right");
    });
    let lateral = d.label.causes.unwrap().lateral.unwrap();
    assert!(lateral.components.is_empty() && lateral.unobserved.is_some(), "{lateral:?}");
    assert!(!d.label.coc_trace.contains("路线"), "{}", d.label.coc_trace);
}

#[test]
fn nobody_starts_at_a_red_light_but_to_turn_off() {
    let starts = |turned: f64| {
        let mut drive = fixture::drive("d");
        let mut signals = fixture::signals(&drive);
        with_speed(&mut signals, |f| if f < 44 { 0.0 } else { 0.15 * (f - 43) as f64 });
        flag(&mut signals, "target.is_lead", true);
        of_target(&mut signals, "target.longitudinal", 9.0);
        of_target(&mut signals, "target.lateral", 0.0);
        by_frame(&mut signals, "target.speed", |f| 0.15 * f.saturating_sub(36) as f64);
        word(&mut signals, "light.state", "red");
        word(&mut signals, "map.driving_side", "right");
        number(&mut signals, "light.distance_to_stop_line", 5.0);
        let heading = (0..fixture::FRAMES).map(|f| turned * (f as f64 / 100.0).min(1.0));
        drive.ego.as_mut().unwrap().motion.heading = heading.collect();
        let mut episode = fixture::episode(&drive);
        episode.scenario_id = "reactive_agent.following.follow_start".parse().unwrap();
        draft(Framework::bundled(), &drive, &signals, &episode, Lang::Zh)
    };
    assert_eq!(starts(0.0).doubt, Some(Doubt::AgainstRed));
    // A right turn at red, where traffic drives on the right; the light is no reason for it.
    let right = starts(-1.5);
    assert_eq!(right.doubt, None);
    assert!(!texts(&right.label).contains("红灯"), "{}", texts(&right.label));
}

#[test]
fn a_vehicle_beside_the_way_of_a_turn_is_not_followed() {
    let behind = |aside: f64| {
        behind_lead("proactive.turn.right_normal", 20.0, |s| {
            with_motion(s, |f| if f < 44 { 2 } else { 1 });
            turns(s, "right");
            of_target(s, "target.speed", 0.0);
            of_target(s, "target.relative_speed", -10.0);
            flag(s, "target.standstill", true);
            of_target(s, "target.path_side_distance", aside);
        })
    };
    let decided = |label: &CocLabel| label.driving_decision.longitudinal;
    assert_eq!(decided(&behind(0.0)), Some(Longitudinal::LeadFollowing));
    assert_ne!(decided(&behind(6.0)), Some(Longitudinal::LeadFollowing));
}

#[test]
fn a_speed_that_falls_by_three_meters_per_second_in_three_seconds_is_a_decision() {
    // Slowing by 0.4 m/s before the keyframe, by 4 m/s in the 3 s after it (LABELING.md 6, `label.motion.unlabelled`).
    let label = behind_lead("reactive_agent.following.lead_sudden_brake", 30.0, |s| {
        with_speed(s, |f| match f {
            0..30 => 18.0,
            30..40 => 18.0 - 0.05 * (f - 30) as f64,
            _ => (17.5 - 0.133 * (f - 40) as f64).max(9.0),
        });
        by_frame(s, "target.speed", |f| (18.0 - 0.3 * f.saturating_sub(32) as f64).max(6.0));
        of_target(s, "target.accel", -3.0);
        of_target(s, "target.relative_speed", -2.5);
    });
    assert_eq!(label.driving_decision.longitudinal, Some(Longitudinal::LeadFollowing));
}

#[test]
fn an_ego_that_creeps_while_it_waits_has_not_moved_off() {
    // Standing, 0.4 m/s from 0.5 s after the keyframe on, driving from 5 s after it.
    let waits = draft_of("reactive_agent.intersection_interaction.unprotected_left", |s| {
        with_speed(s, |f| match f {
            0..45 => 0.1,
            45..90 => 0.4,
            _ => 0.4 + 0.15 * (f - 89) as f64,
        });
        by_frame(s, "target.heading_difference", |_| std::f64::consts::PI);
        of_target(s, "target.longitudinal", 40.0);
        of_target(s, "target.lateral", 3.0);
    });
    let note = |n: &Bilingual| n.en.contains("after the keyframe the ego moves off");
    let moves = waits.notes.iter().find(|n| note(n)).map(|n| n.en.clone());
    assert!(moves.as_ref().is_none_or(|text| !text.starts_with("0.")), "{moves:?}");
}
