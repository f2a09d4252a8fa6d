//! What the last clauses of a trace say that the ego does, whatever the phrase; causes that are denied by the words of
//! the components; components that say that the cause has gone. The sentences are written for this test; next to each
//! fault there is a similar true sentence.

use crate::facts::{codes, following, yielding};
use serde_json::json;

const ZH: &[&str] = &["一位老人推着小车从左侧横穿马路"];
const EN: &[&str] = &["an old man is pushing a cart across the road from the left"];

#[test]
fn who_gives_way_does_not_go_on() {
    for trace in [
        "老人推着小车从左侧横穿马路，还差两步到我车道，我一脚油门踩深，抢在他前头过了。",
        "老人推着小车从左侧横穿马路，我补一脚油，从他跟前冲过去。",
    ] {
        assert!(yielding(ZH, trace).contains(&"label.trace.contradicts"), "{trace}");
    }
    for trace in [
        "An old man is pushing a cart across the road from the left. There is just enough time, so we speed up and go first.",
        "An old man is pushing a cart across the road from the left. He will have to mind us, and we carry on at this pace.",
    ] {
        assert!(yielding(EN, trace).contains(&"label.trace.contradicts"), "{trace}");
    }
    for (parts, trace) in [
        (ZH, "老人推着小车从左侧横穿马路，抢在他前头过太险，我踩刹车让他先过去。"),
        (
            EN,
            "An old man is pushing a cart across the road from the left. He goes first, so we brake and let him across.",
        ),
    ] {
        assert_eq!(yielding(parts, trace), [""; 0], "{trace}");
    }
}

#[test]
fn a_movement_to_the_side_is_a_decision() {
    let code = "label.trace.unlabelled";
    for (parts, trace) in [
        (ZH, "老人推着小车从左侧横穿马路，我踩刹车让他先过，车身朝右边贴过去。"),
        (
            EN,
            "An old man is pushing a cart across the road from the left, so we brake, let him across and hug the right edge.",
        ),
        (
            EN,
            "An old man is pushing a cart across the road from the left, so we brake for him and give the wheel a tug to the right.",
        ),
    ] {
        assert_eq!(yielding(parts, trace), [code], "{trace}");
    }
    for (parts, trace) in [
        (ZH, "老人推着小车从左侧横穿马路，我踩刹车，等他从左边走到右边。"),
        (
            EN,
            "An old man is pushing a cart across the road from the left, so we brake and let him move to the right edge.",
        ),
    ] {
        assert_eq!(yielding(parts, trace), [""; 0], "{trace}");
    }
}

#[test]
fn slowing_is_a_decision() {
    let class = ["proactive", "obstacle_avoidance", "in_lane"];
    let nudge = || json!({ "longitudinal": null, "lateral": "in_lane_nudge", "lateral_direction": "left" });
    let (zh, en) = (&["本车道右侧倒着一只垃圾桶"], &["a dustbin lies on the right side of our lane"]);
    let slows = ["label.trace.unlabelled"];
    assert_eq!(
        codes(class, nudge(), zh, "本车道右侧倒着一只垃圾桶，我先收点油，在道内往左偏一点绕过去。"),
        slows
    );
    let trace = "A dustbin lies on the right side of our lane, so we shed some speed and shift to the left inside the lane.";
    assert_eq!(codes(class, nudge(), en, trace), slows);
    assert_eq!(
        codes(class, nudge(), zh, "本车道右侧倒着一只垃圾桶，不用减速，我在道内往左偏一点。"),
        [""; 0]
    );
    let trace = "A dustbin lies on the right side of our lane. There is no need to slow, we shift to the left inside the lane.";
    assert_eq!(codes(class, nudge(), en, trace), [""; 0]);
}

#[test]
fn a_forecast_or_a_description_is_no_decision() {
    let code = "label.trace.decision_missing";
    let zh = "老人推着小车从左侧横穿马路，已经到我车道边上，再照这个速度开，肯定要撞上。";
    assert_eq!(yielding(ZH, zh), [code]);
    let zh = "老人推着小车从左侧横穿马路，已经到我车道边上，再照这个速度开，肯定要撞上，我赶紧刹车让他。";
    assert_eq!(yielding(ZH, zh), [""; 0]);
    let en = "An old man is pushing a cart across the road from the left. That is as far as he can be from us, and the cart won't be any faster.";
    assert_eq!(yielding(EN, en), [code]);
    let en = "An old man is pushing a cart across the road from the left. The cart won't be any faster, so we brake and let him across.";
    assert_eq!(yielding(EN, en), [""; 0]);
}

#[test]
fn the_lane_of_before_is_no_decision() {
    let class = ["reactive_road", "surface_adaptation", "speed_bump"];
    let keeps = || json!({ "longitudinal": "road_speed_adaptation", "lateral": "lane_keeping" });
    let parts = &["前方横着一道减速带"];
    let trace = "前方横着一道减速带，我收油降速，横向与方才一样居中。";
    assert!(codes(class, keeps(), parts, trace).contains(&"label.decision.unchanged"));
}

#[test]
fn what_a_component_states_is_not_denied() {
    let code = "label.trace.contradicts";
    let parts = &["a trailer has tipped over into the field", "its load blocks our lane"];
    let stop = || json!({ "longitudinal": "stop_for_obstacle", "lateral": null });
    let class = ["reactive_agent", "vehicle_abnormal", "cutout_reveal"];
    let denied = "The load does not block our lane at all. So we brake and stop.";
    let told = "The load blocks our lane, and the trailer does not move. So we brake and stop.";
    assert!(codes(class, stop(), parts, denied).contains(&code));
    assert!(!codes(class, stop(), parts, told).contains(&code));
}

#[test]
fn the_cause_has_not_gone() {
    let code = "label.trace.contradicts";
    for (parts, trace) in [
        (
            ["前面的货车刹车灯亮起，正在停下", "货车已经拐进右边的岔路"],
            "前面的货车刹车灯亮起，正在停下，我跟着减速，停在它后面。",
        ),
        (
            ["the van ahead has its brake lights on", "the van has pulled off into a yard"],
            "The van ahead has its brake lights on and is coming to a stop, so we slow down and stop behind it.",
        ),
    ] {
        assert!(following(&parts, trace).contains(&code), "{trace}");
    }
    for (parts, trace) in [
        (
            ["前面的货车刹车灯亮起，正在停下", "旁边的轿车已经拐进右边的岔路"],
            "前面的货车刹车灯亮起，正在停下，我跟着减速，停在它后面。",
        ),
        (
            ["the van ahead has its brake lights on", "a coach beside it has pulled off into a yard"],
            "The van ahead has its brake lights on and is coming to a stop, so we slow down and stop behind it.",
        ),
    ] {
        assert!(!following(&parts, trace).contains(&code), "{trace}");
    }
}
