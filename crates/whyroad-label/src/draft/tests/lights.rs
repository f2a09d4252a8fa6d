//! The light that the ego faces, in classes that are not about it, and words about speed and limits.

use super::agree::{number, says, word};
use super::*;

/// Traces of one episode without a target in the phrasings of 60 runs, in both languages.
fn traces(leaf: &str, change: impl Fn(&mut SignalTable)) -> Vec<String> {
    let drive = fixture::drive("d");
    let mut signals = fixture::signals(&drive);
    change(&mut signals);
    let mut episode = fixture::episode(&drive);
    episode.scenario_id = leaf.parse().unwrap();
    episode.target_id = None;
    let of = |(lang, run)| draft_with_seed(Framework::bundled(), &drive, &signals, &episode, lang, run);
    let all = [Lang::Zh, Lang::En].into_iter().flat_map(|lang| (0..60).map(move |run| (lang, run)));
    all.map(of).filter(|d| d.doubt.is_none()).map(|d| d.label.coc_trace).collect()
}

/// An ego with these speeds, `line_m` before the stop line of its light, at a dead end.
fn at_light(light: &str, line_m: f64, speed: impl Fn(usize) -> f64 + Copy) -> Vec<String> {
    traces("reactive_road.geometry_adaptation.dead_end", move |s| {
        with_speed(s, speed);
        word(s, "light.state", light);
        number(s, "light.distance_to_stop_line", line_m);
    })
}

#[test]
fn a_red_light_is_why_an_ego_stands() {
    let (red, green) = (at_light("red", 3.0, |_| 0.0), at_light("green", 3.0, |_| 0.0));
    assert!(!red.is_empty());
    assert_eq!(says(&red, &["红灯", "light for the ego's lane is red"]), red.len(), "{red:?}");
    assert_eq!(
        says(&red, &["灯没有放行", "灯还没有放行", "lets it go", "let the ego go"]),
        red.len(),
        "{red:?}"
    );
    assert_eq!(says(&red, &["还没有完全明朗", "没有必要急着起步", "no hurry"]), 0, "{red:?}");
    assert_eq!(says(&green, &["灯没有放行", "灯还没有放行", "until the light lets it go"]), 0, "{green:?}");
}

#[test]
fn a_red_light_far_away_is_not_mentioned() {
    // At 10 m/s two seconds and 3 m/s2 take 36.7 m: within 40 m the light concerns the ego, at 120 m it does not yet.
    let slows = |f: usize| 10.0 - 0.1 * f.saturating_sub(42) as f64;
    let (near, far) = (at_light("red", 30.0, slows), at_light("red", 120.0, slows));
    let named = |all: &[String]| says(all, &["红灯", "is red"]);
    assert!(!near.is_empty() && named(&near) == near.len(), "{near:?}");
    assert!(!far.is_empty() && named(&far) == 0, "{far:?}");
}

#[test]
fn a_speed_does_not_suit_a_red_light() {
    let (near, far) = (at_light("red", 30.0, |_| 10.0), at_light("red", 120.0, |_| 10.0));
    let free = ["适合这一段路", "不需要急刹", "suits the road", "without braking"];
    assert_eq!(says(&near, &free), 0, "{near:?}");
    assert!(says(&far, &free) > 0, "{far:?}");
}

#[test]
fn a_slow_speed_is_given_in_whole_numbers() {
    // 0.6 m/s are 2.2 km/h; 9.7 m/s are 34.9 km/h, "about 35".
    let crawls = at_light("none", f64::INFINITY, |_| 0.6);
    assert!(
        says(&crawls, &["2公里", "2 km/h"]) > 0 && says(&crawls, &["5公里", "5 km/h"]) == 0,
        "{crawls:?}"
    );
    let drives = at_light("none", f64::INFINITY, |_| 9.7);
    assert!(says(&drives, &["35公里", "35 km/h"]) > 0, "{drives:?}");
}

#[test]
fn an_ego_that_goes_over_the_limit_is_not_said_to_keep_to_it() {
    // 13 m/s where 13.9 m/s (50 km/h) are allowed; 1 m/s2 lead to 19 m/s in 6 s.
    let gains = |mps2: f64| {
        traces("reactive_rule.speed_limit", move |s| {
            with_speed(s, |f| 13.0 + mps2 * 0.1 * f.saturating_sub(44) as f64);
            number(s, "map.speed_limit", 13.9);
            number(s, "map.speed_limit_ahead", 13.9);
        })
    };
    let within =
        ["不会超速", "符合规定", "不超过限速", "within the limit", "up to the limit", "is within that limit"];
    let (over, steady) = (gains(1.0), gains(0.0));
    assert_eq!(says(&over, &within), 0, "{over:?}");
    assert!(says(&steady, &within) > 0, "{steady:?}");
}

#[test]
fn a_limit_that_the_ego_does_not_come_down_to_is_not_said_to_be_kept() {
    // From 25 m/s at 1.5 m/s2, or to 23 m/s only, before a limit of 16.7 m/s (60 km/h).
    let slows = |least: f64| {
        traces("reactive_rule.speed_limit", move |s| {
            with_speed(s, |f| (25.0 - 0.15 * f.saturating_sub(42) as f64).max(least));
            number(s, "map.speed_limit", 25.0);
            number(s, "map.speed_limit_ahead", 16.7);
            number(s, "map.distance_to_limit_change", 150.0);
        })
    };
    let reaches = ["到限速以内", "slows down to the limit", "its speed to the limit"];
    let (down, not) = (slows(16.0), slows(23.0));
    assert!(says(&down, &reaches) > 0, "{down:?}");
    assert!(!not.is_empty() && says(&not, &reaches) == 0, "{not:?}");
}
