//! Statements of texts about their causes, by structure: nobody in the ego's way, a reason that the trace itself
//! disowns, another thing of the same kind. The sentences are written for this test; next to each fault there is a
//! similar true sentence.

use crate::facts::{codes, following, yielding};
use serde_json::json;

#[test]
fn somebody_is_in_the_way_of_who_follows() {
    let code = "label.cause.proximate";
    let zh = "前面的车慢下来停住，我跟着减速，在它后面停下。";
    let en = "The traffic ahead is slowing to a halt, so the ego slows down and stops behind it.";
    for (parts, trace) in [
        (["大货车再往前两百米的路口亮着红灯"], zh),
        (["隔着四五辆车，交警在路口抬手示意停下"], zh),
        (["the signal beyond the van and the two coaches is red"], en),
        (["the traffic light at the head of the long queue shows red"], en),
    ] {
        assert!(following(&parts, trace).contains(&code), "{parts:?}");
    }
    for (parts, trace) in [
        (["前面的大货车在路口红灯前停下"], zh),
        (["大货车的刹车灯亮了，路口是红灯"], zh),
        (["路口内有车辆的行驶路线与自车相交"], zh),
        (["the van ahead has stopped at the red light"], en),
        (["the light is red and the van in front is slowing to a halt"], en),
        (["at the end of the street a coach is stopping in our lane"], en),
    ] {
        assert!(!following(&parts, trace).contains(&code), "{parts:?}");
    }
}

#[test]
fn the_reason_is_not_disowned() {
    let code = "label.trace.contradicts";
    let (zh, en) = (&["一位老人从左侧横穿马路"], &["An old man is walking across from the left"]);
    for trace in [
        "老人正从左侧横穿马路，但这并不是减速的理由，自车减速让行。",
        "老人正从左侧横穿马路，他其实不碍事，自车减速让行。",
    ] {
        assert_eq!(yielding(zh, trace), [code], "{trace}");
    }
    for trace in [
        "An old man is walking across from the left, but he isn't why we act; the ego slows down and yields to him.",
        "An old man is walking across from the left and makes no odds to us. The ego slows down and yields to him.",
    ] {
        assert_eq!(yielding(en, trace), [code], "{trace}");
    }
    for (parts, trace) in [
        (zh, "老人正从左侧横穿马路，离自车很近，这就是减速的理由，自车减速让行。"),
        (
            en,
            "An old man is walking across from the left, and that is why the ego slows down and yields to him.",
        ),
    ] {
        assert_eq!(yielding(parts, trace), [""; 0], "{trace}");
    }
}

#[test]
fn another_thing_of_the_same_kind_is_found() {
    let stops = |parts: &[&str], trace: &str| {
        let decision = json!({ "longitudinal": "stop_for_obstacle", "lateral": null });
        let found = codes(["safety", "aeb", "large_vehicle"], decision, parts, trace);
        found.iter().any(|c| ["label.trace.object_differs", "label.trace.unnamed_object"].contains(c))
    };
    // "The trailer" refers to the flatbed; the flow of cars is not it.
    let parts = ["一辆平板拖车横在车道上", "离拖车已经很近，左侧车道车流不断"];
    assert!(stops(&parts, "一辆水泥罐车横在车道上，离得很近，自车停在罐车跟前。"));
    assert!(!stops(&parts, "一辆平板拖车横在车道上，离得很近，自车停在拖车跟前。"));
    let parts = ["a minibus taxi lies on its side across our lane"];
    assert!(!stops(&parts, "A minibus taxi lies across our lane, so we stop before the taxi."));
    assert!(stops(&parts, "A cement mixer lies across our lane, so we stop before it."));
    // Counts stand before an adjective, too.
    let parts = ["a brown estate car stands across our lane"];
    assert!(stops(&parts, "Two brown estates stand across our lane, so we stop before them."));
    assert!(!stops(&parts, "A brown estate stands across our lane, so we stop before it."));
}
