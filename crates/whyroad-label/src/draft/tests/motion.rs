//! Decisions that a draft derives from the ego's speed.

use super::*;

#[test]
fn slowing_for_a_cut_in_is_yielding() {
    let d = draft_of("reactive_agent.cutin.urgent", |s| with_motion(s, |f| if f < 45 { 2 } else { 1 }));
    assert_eq!(d.label.driving_decision.longitudinal, Some(Longitudinal::YieldToAgent));
    assert!(d.notes.iter().any(|n| n.en.contains("0.5 s after the keyframe the ego slows")));
}

#[test]
fn slowing_behind_a_lead_is_following_and_so_is_stopping_behind_it() {
    let slow =
        draft_of("reactive_agent.following.steady", |s| with_motion(s, |f| if f < 45 { 2 } else { 1 }));
    assert_eq!(slow.label.driving_decision.longitudinal, Some(Longitudinal::LeadFollowing));
    let stop = draft_of("reactive_agent.following.follow_stop", |s| {
        with_motion(s, |f| {
            if f < 45 {
                2
            } else if f < 80 {
                1
            } else {
                0
            }
        });
    });
    assert_eq!(stop.label.driving_decision.longitudinal, Some(Longitudinal::LeadFollowing));
}

#[test]
fn moving_off_is_resuming() {
    let d =
        draft_of("reactive_agent.following.follow_start", |s| with_motion(s, |f| if f < 60 { 0 } else { 3 }));
    assert_eq!(d.label.driving_decision.longitudinal, Some(Longitudinal::Resume));
}

#[test]
fn no_change_is_null_and_so_is_a_motion_that_the_class_does_not_explain() {
    let keeps = draft_of("reactive_agent.cutin.urgent", |s| with_motion(s, |_| 2));
    assert_eq!(keeps.label.driving_decision.longitudinal, None);
    let speeds_up =
        draft_of("reactive_agent.cutin.urgent", |s| with_motion(s, |f| if f < 45 { 2 } else { 3 }));
    assert_eq!(speeds_up.label.driving_decision.longitudinal, None);
}

#[test]
fn a_twitch_of_four_frames_is_no_action_and_what_comes_after_six_seconds_is_too_late() {
    let twitch = draft_of("reactive_agent.cutin.urgent", |s| {
        with_motion(s, |f| if (45..49).contains(&f) { 1 } else { 2 })
    });
    assert_eq!(twitch.label.driving_decision.longitudinal, None);
    let late = draft_of("reactive_agent.cutin.urgent", |s| with_motion(s, |f| if f < 98 { 2 } else { 1 }));
    assert_eq!(late.label.driving_decision.longitudinal, None);
}

#[test]
fn what_the_ego_was_already_doing_is_no_answer_to_the_keyframe() {
    // Speeding up long before and until 1 s after, then slowing: the slowing is the response.
    let after = draft_of("reactive_agent.cutin.urgent", |s| with_motion(s, |f| if f < 50 { 3 } else { 1 }));
    assert_eq!(after.label.driving_decision.longitudinal, Some(Longitudinal::YieldToAgent));
    // Slowing from 2 s before and all the time: no new decision. If it begins 0.3 s before, it is the response,
    // slightly early.
    let all_along =
        draft_of("reactive_agent.cutin.urgent", |s| with_motion(s, |f| if f < 20 { 2 } else { 1 }));
    assert_eq!(all_along.label.driving_decision.longitudinal, None);
    let early = |from: usize| {
        draft_of("reactive_agent.cutin.urgent", |s| with_motion(s, |f| if f < from { 2 } else { 1 }))
    };
    assert_eq!(early(37).label.driving_decision.longitudinal, Some(Longitudinal::YieldToAgent));
    // The same if it begins 0.8 s before, and most of it comes after the keyframe.
    assert_eq!(early(32).label.driving_decision.longitudinal, Some(Longitudinal::YieldToAgent));
    // An ego that slows for its turn, and goes on slowing by 2.4 m/s, has not decided to speed up.
    let corner =
        |f: usize| 10.0 - 0.2 * f.clamp(20, 52).saturating_sub(20) as f64 + 0.2 * f.saturating_sub(52) as f64;
    let turn = draft_of("proactive.turn.right_normal", |s| {
        with_speed(s, corner);
        turns(s, "right");
    });
    let decided = turn.label.driving_decision;
    assert_eq!((decided.longitudinal, decided.lateral), (None, Some(Lateral::Turn)));
}

#[test]
fn a_class_that_exists_because_the_ego_slows_has_a_decision_though_it_slowed_before() {
    // scenarios/decisions.yaml: follow_stop is a decision. Its keyframe is the lead's stop, which the ego expects.
    let slowing = |f: usize| u16::from(f < 70);
    let d = draft_of("reactive_agent.following.follow_stop", |s| with_motion(s, slowing));
    assert_eq!(d.label.driving_decision.longitudinal, Some(Longitudinal::LeadFollowing));
    let other = draft_of("reactive_agent.following.steady", |s| with_motion(s, slowing));
    assert_eq!(other.label.driving_decision.longitudinal, None);
}

#[test]
fn slowing_that_ends_at_standstill_after_the_six_seconds_is_a_stop() {
    // From 50 km/h at 2 m/s2 it takes 7 s: braking from 0.5 s after the keyframe, standing from 7 s after it.
    let red = "reactive_rule.traffic_light.red_stop";
    let motion = |stands: usize| move |f: usize| if f < 45 { 2 } else { u16::from(f < stands) };
    let stops = draft_of(red, |s| with_motion(s, motion(110)));
    assert_eq!(stops.label.driving_decision.longitudinal, Some(Longitudinal::StopForRegulation));
    // An ego that speeds up again and stops later has not stopped for it.
    let goes = |f: usize| if (60..80).contains(&f) { 3 } else { motion(110)(f) };
    let later = draft_of(red, |s| with_motion(s, goes));
    assert_eq!(later.label.driving_decision.longitudinal, None);
}

#[test]
fn a_clear_change_of_speed_is_a_decision_though_it_began_before() {
    // From 133 to 111 km/h in 2 s, begun 1 s before the keyframe: 37 m/s to 31 m/s.
    let falls = |f: usize| (37.0 - 0.3 * f.saturating_sub(30) as f64).max(28.0);
    let limit = draft_of("reactive_rule.speed_limit", |s| with_speed(s, falls));
    // LABELING.md 2: road_speed_adaptation is not "because of a rule".
    assert_eq!(limit.label.driving_decision.longitudinal, Some(Longitudinal::SetSpeedTracking));
    assert!(limit.label.coc_trace.contains("减速") || limit.label.coc_trace.contains('降'));
    // From 15 to 42 km/h.
    let rises = |f: usize| (4.0 + 0.14 * f.saturating_sub(20) as f64).min(11.7);
    let crosswalk = draft_of("reactive_rule.speed_limit.crosswalk_limit", |s| with_speed(s, rises));
    assert_eq!(crosswalk.label.driving_decision.longitudinal, Some(Longitudinal::SetSpeedTracking));
    // Nobody has slowed for an object that appears only now: braking by 2 m/s2 since 1.5 s is no response to it
    // (LABELING.md 2, the first action *after* the keyframe).
    let stops = |by: f64| {
        move |f: usize| {
            let late = if f > 40 { (f - 40) as f64 * by } else { 0.0 };
            (8.0 - 0.2 * f.saturating_sub(25) as f64 - late).max(0.0)
        }
    };
    let emergence = "reactive_agent.vru_emergence.dynamic_occlusion";
    let emerges = draft_of(emergence, |s| with_speed(s, stops(0.0)));
    assert_eq!(emerges.label.driving_decision.longitudinal, None);
    let says = |w: &str| emerges.label.coc_trace.contains(w);
    assert!(says("在下降") || says("不再另作调整"), "{}", emerges.label.coc_trace);
    // An increase from 2 to 4 m/s2 is a response.
    let harder = draft_of(emergence, |s| with_speed(s, stops(0.2)));
    assert_eq!(harder.label.driving_decision.longitudinal, Some(Longitudinal::YieldToAgent));
    // 1 m/s in 3 s is not a change that must be stated again.
    let eases = |f: usize| 12.0 - 0.06 * f.saturating_sub(20) as f64;
    let slight = draft_of("reactive_agent.vru_emergence.dynamic_occlusion", |s| with_speed(s, eases));
    assert_eq!(slight.label.driving_decision.longitudinal, None);
    assert!(!slight.label.coc_trace.contains("为此减速"), "{}", slight.label.coc_trace);
}

#[test]
fn the_target_speed_is_returned_to_only_where_the_speed_rises_soon() {
    let straight = "proactive.turn.straight";
    let from = |frame: usize| move |f: usize| 8.0 + 0.1 * f.saturating_sub(frame) as f64;
    let soon = draft_of(straight, |s| with_speed(s, from(45)));
    assert_eq!(soon.label.driving_decision.longitudinal, Some(Longitudinal::SetSpeedTracking));
    // 3 s after the keyframe.
    let late = draft_of(straight, |s| with_speed(s, from(70)));
    assert_eq!(late.label.driving_decision.longitudinal, None);
    // 0.6 m/s and back.
    let twitch = |f: usize| 27.8 + if (45..55).contains(&f) { 0.06 * (f - 45) as f64 } else { 0.0 };
    let exit = draft_of("proactive.merge_interaction.split_exit", |s| with_speed(s, twitch));
    assert_ne!(exit.label.driving_decision.longitudinal, Some(Longitudinal::SetSpeedTracking));
}

#[test]
fn what_the_ego_plainly_does_is_a_decision() {
    let along = |leaf: &str, speed: fn(usize) -> f64| {
        draft_of(leaf, |s| with_speed(s, speed)).label.driving_decision.longitudinal
    };
    let crossing = "reactive_agent.intersection_interaction.cross_conflict";
    let narrow = "reactive_road.geometry_adaptation.narrow";
    // LABELING.md 2: to resume is to start from a standstill. An ego that stood 2 s before and rolls at 0.9 m/s moves
    // off, one that only rolled does not; at 1.1 m/s it is already driving.
    let rolls = |f: usize| 0.9 + 0.1 * f.saturating_sub(44) as f64;
    let stood = |f: usize| if f < 25 { 0.0 } else { 0.9 + 0.1 * f.saturating_sub(44) as f64 };
    assert_eq!(along(crossing, stood), Some(Longitudinal::Resume));
    assert_eq!(along(crossing, rolls), None);
    assert_eq!(
        along(narrow, |f| 1.1 + 0.1 * f.saturating_sub(44) as f64),
        Some(Longitudinal::SetSpeedTracking)
    );
    // 8 km/h are 2.22 m/s: changes of 2.25 m/s and 2.1 m/s within 3 s, begun 2 s before the keyframe.
    // Speeding up is no answer to a narrow road before which the ego had not slowed (TAXONOMY.md).
    assert_eq!(along(narrow, |f| 5.0 + 0.075 * f.saturating_sub(20) as f64), None);
    let bend = "reactive_road.geometry_adaptation.high_curvature";
    assert_eq!(
        along(bend, |f| 15.0 - 0.075 * f.saturating_sub(20) as f64),
        Some(Longitudinal::RoadSpeedAdaptation)
    );
}

#[test]
fn a_change_of_speed_is_told_by_its_sign_and_not_held() {
    let cut_in =
        |speed: fn(usize) -> f64| draft_of("reactive_agent.cutin.slow", |s| with_speed(s, speed)).label;
    // From 4.8 to 7.5 m/s in 3 s: more than a tenth, and no class of cut-ins has the decision to speed up.
    let rises = cut_in(|f| 4.8 + 0.09 * (f as f64 - 40.0));
    assert_eq!(rises.driving_decision.longitudinal, None);
    assert!(rises.coc_trace.contains("提速") || rises.coc_trace.contains("上升"), "{}", rises.coc_trace);
    assert!(!rises.coc_trace.contains("保持") && !rises.coc_trace.contains("不变"), "{}", rises.coc_trace);
    // From 24.0 to 23.4 m/s, a fortieth: the speed is constant.
    let holds = cut_in(|f| 24.0 - 0.02 * f.saturating_sub(40) as f64);
    assert_eq!(holds.driving_decision.longitudinal, None);
    assert!(
        !holds.coc_trace.contains("减速慢行") && !holds.coc_trace.contains("继续下降"),
        "{}",
        holds.coc_trace
    );
    // From 3.1 to 1.2 m/s in the first second, and back: the first action is slowing down.
    let dips = cut_in(|f| match f {
        0..=40 => 3.1,
        41..=50 => 3.1 - 0.19 * (f - 40) as f64,
        _ => (1.2 + 0.1 * (f - 50) as f64).min(6.0),
    });
    assert_eq!(dips.driving_decision.longitudinal, Some(Longitudinal::YieldToAgent));
    // At 20 m/s, 0.6 m/s in 3 s is not slowing for a slope; 3 m/s is.
    let slope = |by: f64| {
        let speed = move |f: usize| 20.0 - by * f.saturating_sub(44) as f64;
        let made = draft_of("reactive_road.geometry_adaptation.slope_down", |s| with_speed(s, speed));
        made.label.driving_decision.longitudinal
    };
    assert_eq!((slope(0.02), slope(0.1)), (None, Some(Longitudinal::RoadSpeedAdaptation)));
}
