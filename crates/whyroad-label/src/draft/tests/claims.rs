//! What a draft's words claim is what the signals show (`claims` of `schema/draft_texts.yaml`).

use super::*;

/// Traces of one episode in the phrasings of 60 runs; without a draft none.
fn traces(leaf: &str, lang: Lang, change: impl Fn(&mut SignalTable)) -> Vec<String> {
    let drive = fixture::drive("d");
    let mut signals = fixture::signals(&drive);
    change(&mut signals);
    let mut episode = fixture::episode(&drive);
    episode.scenario_id = leaf.parse().unwrap();
    let of = |run| draft_with_seed(Framework::bundled(), &drive, &signals, &episode, lang, run);
    (0..60).map(of).filter(|d| d.doubt.is_none()).map(|d| d.label.coc_trace).collect()
}

#[test]
fn an_ego_at_fifty_kmh_is_not_said_to_stop_at_once() {
    // From 14 m/s, 50 km/h, braking at 5 m/s2 takes 20 m; at 4 m/s it takes 1.6 m.
    let slowing = |speed: f64| {
        traces("reactive_agent.vru_crossing.crosswalk", Lang::Zh, move |s| {
            with_speed(s, |f| speed - 0.1 * (f as f64 - 40.0) / 2.0);
        })
    };
    let says = |all: &[String]| all.iter().filter(|t| t.contains("随时可以停下")).count();
    let (fast, slow) = (slowing(14.0), slowing(4.0));
    assert!(!fast.is_empty() && says(&fast) == 0, "{fast:?}");
    assert!(says(&slow) > 0, "{slow:?}");
}

#[test]
fn a_speed_that_changes_is_not_said_to_be_kept() {
    // 20 m/s at the keyframe, up to 21 m/s before 0.5 s and 18.2 m/s within 3 s, then back: not held within 6 %.
    let following = |dip: f64| {
        traces("reactive_agent.following.steady", Lang::En, move |s| {
            with_speed(s, |f| 20.0 - dip * (1.0 - ((f as f64 - 55.0) / 15.0).abs()).max(0.0));
            of_target(s, "target.longitudinal", 40.0);
            of_target(s, "target.distance", 40.0);
            of_target(s, "target.speed", 20.0);
            of_target(s, "target.relative_speed", 0.0);
            flag(s, "target.is_lead", true);
        })
    };
    let says = |all: &[String]| all.iter().filter(|t| t.contains("keeps its speed")).count();
    let (steady, dips) = (following(0.0), following(2.5));
    assert!(says(&steady) > 0, "{steady:?}");
    assert_eq!(says(&dips), 0, "{dips:?}");
}

#[test]
fn a_lead_that_slows_only_after_the_keyframe_is_not_said_to_slow() {
    // LABELING.md 6: nothing that is known only after the keyframe. The acceleration of a smoothed track is negative
    // shortly before the speed falls.
    let lead = |falls_from: f64| {
        let change = move |s: &mut SignalTable| {
            with_speed(s, |f| 15.0 - 0.1 * f.saturating_sub(44) as f64);
            by_frame(s, "target.speed", |f| 15.0 - 0.2 * (f as f64 - falls_from).max(0.0));
            of_target(s, "target.accel", -1.2);
            of_target(s, "target.relative_speed", -0.2);
            of_target(s, "target.longitudinal", 20.0);
            of_target(s, "target.lateral", 0.0);
            of_target(s, "target.heading_difference", 0.0);
            flag(s, "target.is_lead", true);
        };
        traces("reactive_agent.following.steady", Lang::Zh, change)
    };
    let says = |t: &String| ["正在减速", "正在慢下来", "车速在下降"].iter().any(|w| t.contains(w));
    let (before, after) = (lead(30.0), lead(41.0));
    assert!(!before.is_empty() && before.iter().all(says), "{before:?}");
    assert!(!after.iter().any(says), "{after:?}");
}

#[test]
fn an_ego_that_goes_at_red_has_no_draft_unless_it_turns_to_its_own_side() {
    // Turning right at a red round light is allowed in China and, after a stop, in most of the United States.
    let doubt = |leaf: &str, side: &str, light: &str| {
        draft_of(leaf, |s| {
            with_speed(s, |f| 2.0 + 0.15 * f.saturating_sub(40) as f64);
            let codes = (0..fixture::FRAMES).map(|f| if f < 50 { u16::MAX } else { 0 }).collect();
            s.frame_columns.insert("ego.movement".into(), category(&[side], codes));
            s.frame_columns.insert("light.state".into(), category(&[light], vec![0; fixture::FRAMES]));
            s.frame_columns.insert("map.driving_side".into(), category(&["right"], vec![0; fixture::FRAMES]));
        })
        .doubt
    };
    assert_eq!(doubt("proactive.turn.left_unprotected", "left", "red"), Some(Doubt::AgainstRed));
    assert_eq!(doubt("proactive.turn.left_unprotected", "left", "green"), None);
    assert_eq!(doubt("proactive.turn.right_normal", "right", "red"), None);
}

#[test]
fn no_ramp_is_named_where_there_is_none() {
    // `map.merge_zone` in signals.yaml: an acceleration lane lies behind a ramp.
    let merging = |ramp: bool, zone: &'static str| {
        traces("proactive.merge_interaction.normal_merge", Lang::Zh, move |s| {
            with_speed(s, |f| 12.0 - 0.12 * f.saturating_sub(40) as f64);
            flag(s, "map.on_ramp", ramp);
            s.frame_columns.insert("map.merge_zone".into(), category(&[zone], vec![0; fixture::FRAMES]));
        })
    };
    let named = |all: &[String]| all.iter().filter(|t| t.contains("匝道") || t.contains("加速车道")).count();
    let comes_to_it = |t: &String| t.contains("接近要汇入的道路");
    let neither = merging(false, "none");
    assert!(neither.iter().any(comes_to_it) && named(&neither) == 0, "{neither:?}");
    for on_it in [merging(true, "none"), merging(false, "acceleration")] {
        assert!(named(&on_it) > 0 && !on_it.iter().any(comes_to_it), "{on_it:?}");
    }
}
