//! Statements of texts about things, compared: components with the same meaning in other words, a cause beyond the near
//! one, a decision denied with any verb, a move to the other side, an empty reason. The sentences are written for this
//! test; next to each fault there is a similar true sentence.

use serde_json::{Value, json};
use whyroad_framework::Framework;
use whyroad_label::check::Checker;

/// Codes of the findings, except notes, of a label of this class with these components, all of them its cause.
pub(crate) fn codes(class: [&str; 3], decision: Value, parts: &[&str], trace: &str) -> Vec<&'static str> {
    let times = ["2026-01-15T10:30:09.500Z"];
    let part = |(i, text): (usize, &&str)| json!({ "id": format!("c{i}"), "description": text, "evidence_times": times });
    let ids: Vec<String> = (0..parts.len()).map(|i| format!("c{i}")).collect();
    let channel = if decision["longitudinal"].is_null() { "lateral" } else { "longitudinal" };
    let label = json!({
        "version": "2.1.0",
        "clip_id": "clip_1",
        "scenario": { "l1": class[0], "l2": class[1], "l3": class[2] },
        "time_range": { "start_timestamp": "2026-01-15T10:30:10.000Z", "end_timestamp": "2026-01-15T10:30:14.000Z" },
        "keyframe": { "timestamp": "2026-01-15T10:30:10.000Z", "frame_idx": 100, "type": "reactive" },
        "driving_decision": decision,
        "critical_components": parts.iter().enumerate().map(part).collect::<Vec<_>>(),
        "coc_trace": trace,
        "causes": { channel: { "components": ids } },
        "provenance": { "source": "person" },
    });
    let found = Checker::new(Framework::bundled()).check_text(&label.to_string());
    found.iter().filter(|d| d.severity != whyroad_model::Severity::Note).map(|d| d.code).collect()
}

/// A road user crosses or enters the lane, and the ego yields.
pub(crate) fn yielding(parts: &[&str], trace: &str) -> Vec<&'static str> {
    let decision = json!({ "longitudinal": "yield_to_agent", "lateral": null });
    codes(["reactive_agent", "vru_crossing", "horizontal"], decision, parts, trace)
}

/// The ego follows.
pub(crate) fn following(parts: &[&str], trace: &str) -> Vec<&'static str> {
    let decision = json!({ "longitudinal": "lead_following", "lateral": null });
    codes(["reactive_agent", "following", "follow_stop"], decision, parts, trace)
}

const YIELD_ZH: &str = "老人推着车横穿马路，和自车路线相交，因此自车减速让行。";
const YIELD_EN: &str =
    "An old man is walking across, and our paths meet, so the ego slows down and yields to him.";

const CROSSING_ZH: &[&str] = &["一位老人从左侧横穿马路"];
const CROSSING_EN: &[&str] = &["An old man is walking across from the left"];

#[test]
fn what_is_left_open_is_found_in_a_long_text() {
    let code = "label.text.placeholder";
    for trace in [
        "老人从左侧横穿马路，距自车××米，因此自车减速让行。",
        "老人从左侧横穿马路（此处补充原因），因此自车减速让行。",
        "老人从左侧横穿马路，理由回头再补，自车减速让行。",
    ] {
        assert_eq!(yielding(CROSSING_ZH, trace), [code], "{trace}");
    }
    for trace in [
        "An old man is walking across from the left [add reason], so the ego slows down and yields to him.",
        "An old man is walking across from the left at xx km/h, so the ego slows down and yields to him.",
    ] {
        assert_eq!(yielding(CROSSING_EN, trace), [code], "{trace}");
    }
    let whole = "老人从左侧横穿马路（拄着拐杖，走得慢），和自车路线相交，因此自车减速让行。";
    assert_eq!(yielding(CROSSING_ZH, whole), [""; 0]);
    let whole = "An old man (with a stick, and slow) is walking across from the left, so the ego slows down and yields.";
    assert_eq!(yielding(CROSSING_EN, whole), [""; 0]);
}

#[test]
fn unobserved_says_why_in_its_sentence() {
    let none = "The ego slows down and yields here, cause UNOBSERVED.";
    let why = "The ego slows down and yields here, cause UNOBSERVED: the front camera was covered with mud.";
    assert_eq!(yielding(CROSSING_EN, none), ["label.cause.unobserved"]);
    assert!(!yielding(CROSSING_EN, why).contains(&"label.cause.unobserved"));
    assert_eq!(yielding(CROSSING_ZH, "自车在此减速让行，缘由未观测。"), ["label.cause.unobserved"]);
}

#[test]
fn a_cause_that_is_denied_needs_another() {
    let code = "label.trace.contradicts";
    for trace in [
        "An old man is walking across from the left, but he is no hazard to anyone; the ego slows down and yields.",
        "An old man is walking across, which has no bearing on our driving, and the ego slows down and yields.",
    ] {
        assert_eq!(yielding(CROSSING_EN, trace), [code], "{trace}");
    }
    let denied = "老人从左侧横穿马路，可他跟本车毫无关系，自车减速让行。";
    assert_eq!(yielding(CROSSING_ZH, denied), [code]);
    // Another road user is no cause.
    let parts = ["An old man is walking across from the left", "A van is parked on the right"];
    let other = "The van parked on the right is no hazard; the old man walking across from the left is in our way, so \
                 the ego slows down and yields to him.";
    assert_eq!(yielding(&parts, other), [""; 0]);
    let parts = ["一位老人从左侧横穿马路", "右侧停着一辆面包车"];
    let other = "老人从左侧横穿马路，右侧停着的面包车不影响本车，因此自车减速让行。";
    assert_eq!(yielding(&parts, other), [""; 0]);
}

/// A trace of a stop at a red light is reported to contradict its decision.
fn denies_red(part: &str, trace: &str) -> bool {
    let decision = json!({ "longitudinal": "stop_for_regulation", "lateral": null });
    let found = codes(["reactive_rule", "traffic_light", "red_stop"], decision, &[part], trace);
    found.contains(&"label.trace.contradicts")
}

#[test]
fn a_light_for_others_is_no_cause() {
    let (zh, en) = ("本车道的信号灯是红灯", "The light for our lane is red");
    for (part, trace) in [
        (
            en,
            "The light is red for the trams and does not apply to our lane, so the ego brakes and stops at the line.",
        ),
        (zh, "信号灯是红灯，但管不到我们这个方向，自车减速，在停止线前停下。"),
    ] {
        assert!(denies_red(part, trace), "{trace}");
    }
    // Another light applies.
    for (part, trace) in [
        (
            en,
            "The red light of the trams does not apply to us, but the light for our lane is red too, so the ego brakes and stops at the line.",
        ),
        (zh, "左转的绿灯管不到我们，本车道的信号灯是红灯，因此自车减速，在停止线前停下。"),
    ] {
        assert!(!denies_red(part, trace), "{trace}");
    }
}

#[test]
fn a_cause_is_denied_in_other_words() {
    let code = "label.trace.contradicts";
    for trace in [
        "The old man is sitting on a bench, well clear of our lane, so the ego slows down and yields.",
        "There is no old man on the road and the way ahead is clear, so the ego slows down and yields.",
    ] {
        assert_eq!(yielding(CROSSING_EN, trace), [code], "{trace}");
    }
    for trace in [
        "老人站在人行道里面，没有过马路的意思，自车减速让行。",
        "老人离我们的车道很远，互不影响，自车减速让行。",
    ] {
        assert_eq!(yielding(CROSSING_ZH, trace), [code], "{trace}");
    }
    // Next to a component that calls for the decision it is only surroundings.
    let trace =
        "The oncoming lane is empty, but an old man is walking across from the left, so the ego slows down.";
    assert_eq!(yielding(CROSSING_EN, trace), [""; 0]);
    let trace = "视线很好，对面没有来车，老人从左侧横穿马路，因此自车减速让行。";
    assert_eq!(yielding(CROSSING_ZH, trace), [""; 0]);
}

#[test]
fn a_component_bears_on_the_decision() {
    let code = "label.cause.proximate";
    for idle in ["路边商场的大屏正在放广告", "公园里有人在下棋", "教堂的钟楼正在敲钟"]
    {
        assert_eq!(yielding(&[CROSSING_ZH[0], idle], YIELD_ZH), [code], "{idle}");
    }
    for idle in ["A poster by the road announces a summer sale", "Two anglers are fishing from the bank"] {
        assert_eq!(yielding(&[CROSSING_EN[0], idle], YIELD_EN), [code], "{idle}");
    }
    // A road user comes out of it, it hides something, or the trace uses it.
    for part in ["公园里跑出来一个小孩", "广告牌挡住了右侧的视线"] {
        assert_eq!(yielding(&[CROSSING_ZH[0], part], YIELD_ZH), [""; 0], "{part}");
    }
    let told = "An old man walks across towards the poster for a summer sale, and our paths meet, so the ego slows \
                down and yields to him.";
    let poster = "A poster by the road announces a summer sale";
    assert_eq!(yielding(&[CROSSING_EN[0], poster], told), [""; 0]);
}

#[test]
fn a_time_after_the_response_is_hindsight() {
    let code = "label.text.hindsight";
    for trace in [
        "An old man walks across from the left; once he had reached the other side he waved, so the ego yields.",
        "An old man walks across from the left and after we had stopped he waved, so the ego slows and yields.",
    ] {
        assert_eq!(yielding(CROSSING_EN, trace), [code], "{trace}");
    }
    let trace = "老人从左侧横穿马路，他走到对面以后冲我们挥了挥手，所以自车减速让行。";
    assert_eq!(yielding(CROSSING_ZH, trace), [code]);
    // What the ego waits for, and the last of several.
    for trace in [
        "老人从左侧横穿马路，和自车路线相交，自车减速让行，等他过去以后再走。",
        "老人从左侧横穿马路，他走在最后面，还没过完，自车减速让行。",
    ] {
        assert_eq!(yielding(CROSSING_ZH, trace), [""; 0], "{trace}");
    }
}

#[test]
fn a_reason_of_another_scene_is_unrelated() {
    let code = "label.text.unrelated";
    let trace = "收费站只开了两个口，栏杆没有抬起来，所以自车减速让行。";
    assert_eq!(yielding(CROSSING_ZH, trace), [code]);
    let trace = "Thick fog hangs over the fields and the bends are icy, so the ego slows down and yields.";
    assert_eq!(yielding(CROSSING_EN, trace), [code]);
}

#[test]
fn what_is_only_compared_or_absent_is_no_thing() {
    for trace in [
        "An old man walks across from the left, slow like a tractor, so the ego slows down and yields to him.",
        "Irrespective of traffic an old man is walking across from the left, so the ego slows down and yields to him.",
        "An old man is walking across from the left, and the tires would not hold on a swerve, so the ego slows down \
         and yields to him.",
    ] {
        assert_eq!(yielding(CROSSING_EN, trace), [""; 0], "{trace}");
    }
    let trace = "老人从左侧横穿马路，走路不比自行车快，自车立马减速让行。";
    assert_eq!(yielding(CROSSING_ZH, trace), [""; 0]);
}

#[test]
fn components_say_the_same_in_other_words() {
    let same = [
        (["一位老人从左侧横穿马路", "左边有个大爷正往马路对过走"], YIELD_ZH),
        (["右侧公交车前面窜出一位老人", "老人从公交车前头蹿了出来"], YIELD_ZH),
        (
            [
                "An old man is walking across from the left",
                "From our left a pensioner is making his way across",
            ],
            YIELD_EN,
        ),
    ];
    let other = [
        (["一位老人从左侧横穿马路", "老人离本车二十米"], YIELD_ZH),
        (["一位老人从左侧横穿马路", "右侧有个小孩正往马路对过走"], YIELD_ZH),
        (["一位老人从左侧横穿马路", "老人没有看车"], YIELD_ZH),
        (["An old man is walking across from the left", "The old man is twenty meters away"], YIELD_EN),
        (
            ["An old man is walking across from the left", "A child on the right may step onto the road"],
            YIELD_EN,
        ),
    ];
    let found =
        |(parts, trace): &([&str; 2], &str)| yielding(parts, trace).contains(&"label.component.duplicate");
    let missed: Vec<_> = same.iter().filter(|c| !found(c)).collect();
    let flagged: Vec<_> = other.iter().filter(|c| found(c)).collect();
    assert!(missed.is_empty() && flagged.is_empty(), "missed {missed:#?}, flagged {flagged:#?}");
}

#[test]
fn two_in_two_lanes_are_not_one() {
    let trace = "The van ahead is braking to a stop, so the ego slows down behind it and keeps its distance.";
    let found = |parts: [&str; 2]| following(&parts, trace).contains(&"label.component.duplicate");
    for two in [
        [
            "The car ahead in the ego's lane is slowing down",
            "The car ahead in the right lane is slowing down",
        ],
        ["The car ahead in the left lane is slowing down", "The car ahead in the right lane is slowing down"],
        ["本车道前方的轿车正在减速", "右侧车道前方的轿车正在减速"],
    ] {
        assert!(!found(two), "{two:?}");
    }
    let one =
        ["The car ahead in the ego's lane is slowing down", "The car ahead in our lane is slowing down"];
    assert!(found(one), "{one:?}");
}

#[test]
fn a_cause_beyond_the_near_one_is_distant() {
    let zh = "前面的面包车刹车灯亮起，快要停住，因此自车跟着减速停在它后面。";
    let en = "The van ahead is braking to a stop, so the ego slows down behind it and keeps its distance.";
    let far = [
        (["前面的面包车正在刹车", "面包车前面三百米的路口亮着红灯"], zh),
        (["前面的面包车正在刹车", "两公里外有一起事故，路都堵住了"], zh),
        (["The van ahead is braking", "The light two hundred meters beyond the van is red"], en),
        (["The van ahead is braking", "There are roadworks a mile further on"], en),
    ];
    let near = [
        (["前面的面包车正在刹车", "面包车前面有一个行人"], zh),
        (["前面的面包车正在刹车", "自车离它三百米"], zh),
        (["The van ahead is braking", "The gap to the van is two hundred meters"], en),
    ];
    let found =
        |(parts, trace): &([&str; 2], &str)| following(parts, trace).contains(&"label.cause.proximate");
    let missed: Vec<_> = far.iter().filter(|c| !found(c)).collect();
    let flagged: Vec<_> = near.iter().filter(|c| found(c)).collect();
    assert!(missed.is_empty() && flagged.is_empty(), "missed {missed:#?}, flagged {flagged:#?}");
}

/// The verbs are in no list.
#[test]
fn a_decision_is_denied_with_any_verb() {
    let (zh, en) = (["一位老人从左侧横穿马路"], ["An old man is walking across from the left"]);
    let denied = ["老人正在横穿，离得不远，但自车没有搭理他。", "老人正在横穿，但我们并没有把他当回事。"];
    let denied_en = [
        "An old man is walking across close to us, but we are not budging for him.",
        "An old man is walking across close to us, yet the ego makes no change for his sake.",
    ];
    let open = ["老人正在横穿，离得不远，自车不能贸然闯过去，于是收住了脚步。"];
    let open_en = ["An old man is walking across and we cannot dodge him, so we hang fire."];
    let found = |parts: &[&str], trace: &str| yielding(parts, trace).contains(&"label.trace.contradicts");
    for t in denied {
        assert!(found(&zh, t), "{t}");
    }
    for t in denied_en {
        assert!(found(&en, t), "{t}");
    }
    assert!(!open.iter().any(|t| found(&zh, t)) && !open_en.iter().any(|t| found(&en, t)));
}

#[test]
fn a_reason_that_is_none_is_reported() {
    let (zh, en) = (["一位老人从左侧横穿马路"], ["An old man is walking across from the left"]);
    let codes = ["label.text.unrelated", "label.cause.circular"];
    let none = |parts: &[&str], trace: &str| yielding(parts, trace).iter().any(|c| codes.contains(c));
    assert!(none(&zh, "没什么理由，自车减速让一让老人。"));
    assert!(none(&en, "We slow down for the old man, for no particular reason."));
    assert!(none(
        &en,
        "We slow down for him because the battery needs charging and the seat heater has packed up."
    ));
    assert!(!none(&en, "We slow down for him because the pensioner is walking across from the left."));
    assert!(!none(&zh, YIELD_ZH) && !none(&en, YIELD_EN));
}

/// A road user that is introduced as a cause needs a component; the ego, things that belong to somebody and events that
/// only happen often do not.
#[test]
fn what_is_no_cause_needs_no_component() {
    let unnamed =
        |parts: &[&str], trace: &str| yielding(parts, trace).contains(&"label.trace.unnamed_object");
    for trace in [
        "An old man is walking across in front of the ego vehicle, so the ego vehicle slows down and yields to him.",
        "Cars either side. An old man is walking across, and our paths meet, so the ego slows down and yields to him.",
    ] {
        assert!(!unnamed(CROSSING_EN, trace), "{trace}");
    }
    assert!(unnamed(
        CROSSING_EN,
        "A truck is turning in from the right while an old man is walking across, so the ego vehicle slows and yields."
    ));
    let (often, now) = (
        "这里常有电动车窜出来，老人从左侧横穿马路，因此自车减速让行。",
        "右边一辆电动车窜出来，老人从左侧横穿马路，因此自车减速让行。",
    );
    assert!(!unnamed(CROSSING_ZH, often) && unnamed(CROSSING_ZH, now));
}

#[test]
fn a_reason_that_somebody_else_lacks_is_one_for_the_ego() {
    let code = "label.text.unrelated";
    let parts = ["The sedan ahead brakes hard for no apparent reason"];
    let trace =
        "The sedan ahead brakes hard for no apparent reason, so the ego brakes and follows it to a stop.";
    assert!(!following(&parts, trace).contains(&code));
    let trace = "For no apparent reason the ego brakes and follows to a stop behind it.";
    assert!(following(&parts, trace).contains(&code));
}

#[test]
fn what_only_names_its_field_is_a_placeholder() {
    let found = |part: &str, trace: &str| yielding(&[part], trace).contains(&"label.text.placeholder");
    assert!(found("此处填写关键要素", YIELD_ZH) && found("critical component goes here", YIELD_EN));
    assert!(!found("一位老人从左侧横穿马路", YIELD_ZH));
}

#[test]
fn a_component_does_not_speak_against_the_decision() {
    let code = "label.trace.contradicts";
    for part in ["自车踩着油门冲了过去", "本车继续加速"] {
        assert_eq!(yielding(&[CROSSING_ZH[0], part], YIELD_ZH), [code], "{part}");
    }
    for part in ["自车时速四十公里", "自车来不及停车", "自车还没减速", "右侧车道是空的"]
    {
        assert!(yielding(&[CROSSING_ZH[0], part], YIELD_ZH).is_empty(), "{part}");
    }
    for part in ["the ego does not yield to him", "ego is speeding up towards the crossing"] {
        assert_eq!(yielding(&[CROSSING_EN[0], part], YIELD_EN), [code], "{part}");
    }
    for part in
        ["ego is at 40 km/h", "ego cannot stop in time", "ego has not slowed yet", "the left lane is empty"]
    {
        assert!(yielding(&[CROSSING_EN[0], part], YIELD_EN).is_empty(), "{part}");
    }
}

#[test]
fn a_component_leaves_something_to_respond_to() {
    let code = "label.trace.contradicts";
    let goes_first = ["老人停下来让我们先走", "老人在路边等我们先过"];
    for part in goes_first {
        assert_eq!(yielding(&[CROSSING_ZH[0], part], YIELD_ZH), [code], "{part}");
    }
    assert_eq!(yielding(&[CROSSING_EN[0], "he stops to let us go by"], YIELD_EN), [code]);
    assert_eq!(yielding(&[CROSSING_EN[0], "he does not stop for us"], YIELD_EN), [""; 0]);
    let lead = "前车正在减速停车";
    let trace = "前车正在减速停车，与自车越来越近，因此自车跟着减速停下。";
    assert!(following(&[lead, "本车道前面已经空了出来"], trace).contains(&code));
    assert!(!following(&[lead, "左侧车道前面没车"], trace).contains(&code));
    let exit = |part: &str| {
        let decision = json!({ "longitudinal": null, "lateral": "merge_or_split", "direction": "right" });
        let trace = "导航提示从右侧匝道驶出，匝道口就在前面，因此自车向右驶出主路进入匝道。";
        codes(["proactive", "merge_interaction", "split_exit"], decision, &[part, "匝道口就在前面"], trace)
    };
    assert!(exit("导航要求沿主路直行，不从匝道驶出").contains(&code));
    assert!(!exit("导航提示从右侧匝道驶出，不走主路").contains(&code));
}

#[test]
fn what_is_planned_next_is_no_hindsight() {
    for trace in [
        "老人推着车横穿马路，和自车路线相交，自车减速让行，随后继续右转。",
        "老人刚才停了半天才走，现在横穿马路，和自车路线相交，因此自车减速让行。",
    ] {
        assert!(!yielding(CROSSING_ZH, trace).contains(&"label.text.hindsight"), "{trace}");
    }
    let trace = "老人推着车横穿马路，和自车路线相交，自车减速让行，随后老人走远了。";
    assert!(yielding(CROSSING_ZH, trace).contains(&"label.text.hindsight"));
}

#[test]
fn a_number_or_a_side_that_no_component_gives_differs() {
    let code = "label.trace.object_differs";
    let parts: &[&str] = &["一位老人从左侧横穿马路", "老人距自车20米，自车时速40公里"];
    let told = |side: &str, speed: u32| {
        format!("{side}一位老人横穿马路，只有20米，自车时速{speed}公里，因此自车减速让行。")
    };
    assert!(!yielding(parts, &told("左侧", 40)).contains(&code));
    assert!(yielding(parts, &told("右侧", 40)).contains(&code));
    assert!(yielding(parts, &told("左侧", 60)).contains(&code));
    let parts: &[&str] =
        &["an old man is walking across from the left", "the ego drives at 40 km/h, 20 m from him"];
    let told = |side: &str, speed: u32| {
        format!(
            "An old man walks across from the {side}, 20 m ahead at {speed} km/h, so the ego slows to yield to him."
        )
    };
    assert!(!yielding(parts, &told("left", 40)).contains(&code));
    assert!(yielding(parts, &told("right", 40)).contains(&code));
    assert!(yielding(parts, &told("left", 60)).contains(&code));
}

#[test]
fn a_note_that_the_trace_is_a_draft_is_found() {
    let code = "label.trace.draft";
    for trace in [format!("（初稿，先别审）{YIELD_ZH}"), format!("{YIELD_ZH}【草稿】")] {
        assert_eq!(yielding(CROSSING_ZH, &trace), [code], "{trace}");
    }
    for trace in [format!("(wip, look at the clip again) {YIELD_EN}"), format!("Rough version: {YIELD_EN}")] {
        assert_eq!(yielding(CROSSING_EN, &trace), [code], "{trace}");
    }
    for trace in [
        "(Light rain.) An old man is walking across, and our paths meet, so the ego slows down and yields to him.",
        "Drafty day: an old man is walking across, and our paths meet, so the ego slows down and yields to him.",
    ] {
        assert_eq!(yielding(CROSSING_EN, trace), [""; 0], "{trace}");
    }
}

#[test]
fn a_decision_said_three_times_is_no_reason() {
    let code = "label.cause.circular";
    let parts = ["the tipper truck in front is crawling at walking pace"];
    let circle = "This is a following situation, and in a following situation one follows, which is why following is called for here. I creep along behind it and hold that gap.";
    assert!(following(&parts, circle).contains(&code));
    let reason = "The tipper truck in front is crawling at walking pace, and there is no way round it, so the ego follows it.";
    assert!(!following(&parts, reason).contains(&code));
}

#[test]
fn what_may_come_is_no_hindsight() {
    for trace in [
        "老人推着车横穿马路，人家要过来就让他，自车减速让行。",
        "老人推着车横穿马路，下一刻往哪边走无法判断，自车减速让行。",
        "老人推着车横穿马路，这种时候容不得侥幸，自车减速让行。",
    ] {
        assert_eq!(yielding(CROSSING_ZH, trace), [""; 0], "{trace}");
    }
    let lucky = "老人推着车横穿马路，自车减速让行，侥幸没有碰到他。";
    assert!(yielding(CROSSING_ZH, lucky).contains(&"label.text.hindsight"));
    let ahead = "An old man is walking across, with no room to get by without touching him, so the ego slows down and yields to him.";
    assert_eq!(yielding(CROSSING_EN, ahead), [""; 0]);
}

/// A route is a legal cause that was not observed (LABELING.md 6), and so is what Stage I did not list.
#[test]
fn a_route_and_what_stage_one_did_not_list_are_reasons() {
    let of = |unobserved: &str| {
        let label = json!({
            "version": "2.1.0",
            "clip_id": "clip_1",
            "scenario": { "l1": "proactive", "l2": "turn", "l3": "left_unprotected" },
            "time_range": {
                "start_timestamp": "2026-01-15T10:30:08.000Z", "end_timestamp": "2026-01-15T10:30:16.000Z"
            },
            "keyframe": { "timestamp": "2026-01-15T10:30:10.000Z", "frame_idx": 100, "type": "reactive" },
            "driving_decision": { "longitudinal": "resume", "lateral": "turn", "lateral_direction": "left" },
            "critical_components": [{ "id": "c0", "description": "前方路口内没有其他车" }],
            "coc_trace": "前方路口内没有其他车，导航路线在此路口左转，因此自车起步并左转。",
            "causes": { "longitudinal": { "components": ["c0"] }, "lateral": { "unobserved": unobserved } },
            "provenance": { "source": "person" },
        });
        let found = Checker::new(Framework::bundled()).check_text(&label.to_string());
        let at = |d: &whyroad_model::Diagnostic| d.location.pointer.clone().unwrap_or_default();
        let of = found.iter().filter(|d| at(d).starts_with("/causes/lateral"));
        of.map(|d| d.code).collect::<Vec<_>>()
    };
    for reason in [
        "导航路线在此路口左转",
        "左转取决于对向来车是否通过，阶段一没有列出它",
        "The turn follows the navigation route",
        "It depends on the oncoming car, which is not listed in Stage I",
    ] {
        assert!(of(reason).is_empty(), "{reason}: {:?}", of(reason));
    }
    assert!(of("不太好说").contains(&"label.cause.unobserved"));
}

#[test]
fn what_is_driving_past_the_junction_can_be_seen() {
    let hindsight = |text: &str| {
        following(&[text], "The lead is driving slowly, so the ego follows it.")
            .contains(&"label.text.hindsight")
    };
    for text in ["An oncoming car is slowly driving past the junction", "The lead is past the junction"] {
        assert!(!hindsight(text), "{text}");
    }
    for text in ["The lead stopped at the stop past the junction", "The lead gets past the junction"] {
        assert!(hindsight(text), "{text}");
    }
}

/// SPEC 2.3: an ego that goes on standing has taken no decision, and says so by "继续停在"; "停在" alone is a stop.
#[test]
fn who_goes_on_standing_has_decided_nothing() {
    let unlabelled = |action: &str| {
        let trace = format!(
            "一群行人正从左前方横穿自车前方的道路；行人还没有走过自车前方，此时起步会与行人冲突，因此自车{action}。"
        );
        let decision = json!({ "longitudinal": null, "lateral": null });
        let parts = ["一群行人正从左前方横穿自车前方的道路"];
        codes(["reactive_agent", "vru_crossing", "horizontal"], decision, &parts, &trace)
            .contains(&"label.trace.unlabelled")
    };
    for action in ["继续停在原地等待", "继续停在原地", "保持停在斑马线前", "继续停在路口前让行人先过"]
    {
        assert!(!unlabelled(action), "{action}");
    }
    assert!(unlabelled("停在斑马线前") && unlabelled("减速停在原地"));
}
