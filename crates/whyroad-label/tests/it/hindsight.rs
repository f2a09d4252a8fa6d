//! Hindsight by grammar, not by phrase: clauses after the decision that report an event, and clauses in the same place
//! that give a reason, a purpose, a condition or a plan. The sentences are written for this test and quote no list.

#![allow(clippy::print_stdout)] // the sentences are what a reader wants to see

use serde_json::{Value, json};
use whyroad_framework::Framework;
use whyroad_label::check::Checker;

/// A label of a crossing with one component, `part`, and this trace; `decision` as in the message.
fn label(decision: Value, part: &str, trace: &str) -> Value {
    json!({
        "version": "2.1.0",
        "clip_id": "clip_1",
        "scenario": { "l1": "reactive_agent", "l2": "vru_crossing", "l3": "horizontal" },
        "time_range": { "start_timestamp": "2026-01-15T10:30:10.000Z", "end_timestamp": "2026-01-15T10:30:14.000Z" },
        "keyframe": { "timestamp": "2026-01-15T10:30:10.000Z", "frame_idx": 100, "type": "reactive" },
        "driving_decision": decision,
        "critical_components": [{ "id": "c1", "description": part, "evidence_times": ["2026-01-15T10:30:09.500Z"] }],
        "coc_trace": trace,
        "causes": { "longitudinal": { "components": ["c1"] } },
        "provenance": { "source": "person" },
    })
}

/// A label of a crossing pedestrian to whom the ego yields, with this trace, has a hindsight finding.
fn found(trace: &str) -> bool {
    let part = if trace.is_ascii() {
        "A pedestrian steps into our lane from the right, close to us"
    } else {
        "一名行人从右侧路边走上车道，离自车很近"
    };
    let label = label(json!({ "longitudinal": "yield_to_agent", "lateral": null }), part, trace);
    let checker = Checker::new(Framework::bundled());
    checker.check_text(&label.to_string()).iter().any(|d| d.code == "label.text.hindsight")
}

const AFTER: [&str; 44] = [
    "行人从右侧走上车道，自车减速让行，他小跑着过去了。",
    "右边行人走进车道，赶紧踩刹车让他，他冲自车点了点头。",
    "行人走上车道，因此自车减速让行，行人退回了路边。",
    "行人从右边过来，减速让他先走，过了大概五秒车道才空出来。",
    "行人离得近，自车刹车让他，离他还有一米的时候停稳了。",
    "行人走上车道，自车让行，后面的车跟着按了好几声喇叭。",
    "行人走进车道，减速让行，等他上了对面的人行道，车又提起速来了。",
    "行人从右侧走上来，于是减速让行，两个人谁也没伤着谁，没出事。",
    "行人走上车道，自车减速让行，视频放到末尾他都没走完，是自车绕开了。",
    "行人从右侧走入车道，故自车减速避让，此后行人安全通过了马路。",
    "行人走进车道，自车减速让行，结果他只是捡了个东西。",
    "行人从路边走进来，刹车让他，没成想他扭头往回走了。",
    "行人走上车道，减速让行。他接了个电话，站住不走了。",
    "行人从右侧走来，自车减速让行，好在刹得早。",
    "行人走上车道，因此减速让行，整个过程用了三秒多。",
    "行人走进车道，自车减速让行，最后平稳停在他前面。",
    "右侧行人走上车道，减速让行，他前脚刚走，后脚又来了一个。",
    "行人走上来，自车踩刹车让他，副驾的水杯都倒了。",
    "行人走上车道，因此自车减速让行，这次处理得很及时，没有发生碰撞。",
    "行人走进车道，自车减速让他，直到他离开车道才重新加速。",
    "A pedestrian steps into our lane, so we brake for him and he hurried across.",
    "A pedestrian steps into our lane, so the ego yields; he raised a hand in thanks.",
    "A pedestrian steps into our lane from the right, so we slow down to let him cross, which took a while because he limped.",
    "A pedestrian steps into our lane, so the ego slows down. The man turned around halfway.",
    "A pedestrian steps into our lane and we yield to him. The next car did the same.",
    "A pedestrian steps into our lane, so we slow and let him go, and the bus behind us nearly did not see it.",
    "A pedestrian steps into our lane, so we brake, coming to rest two feet from him.",
    "A pedestrian steps into our lane, so we yield, until he reached the far curb.",
    "A pedestrian steps into our lane, so the ego gives way, but he never looked up.",
    "A pedestrian steps into our lane, so we slow down for him, though he waited in the end.",
    "A pedestrian steps into our lane, so the ego slows; everybody was fine.",
    "A pedestrian steps into our lane, so we brake to let him pass and then carried on to the lights.",
    "A pedestrian steps into our lane, so we slow down, and with that the danger was over.",
    "A pedestrian steps into our lane, so we yield. He dropped his phone and bent down for it.",
    "A pedestrian steps into our lane, so the ego brakes, and stopped with room to spare.",
    "A pedestrian steps into our lane, so we brake for her, only to see her jump back.",
    "A pedestrian steps into our lane, so we yield to her, a decision that paid off.",
    "A pedestrian steps into our lane; we give way and she crossed unharmed.",
    "A pedestrian steps into our lane. We slow to let him cross. It worked.",
    "A pedestrian steps into our lane, so we slow down and avoided hitting him.",
    "A pedestrian steps into our lane so we stop for him, and four seconds passed before we rolled again.",
    "A pedestrian steps into our lane, so we give way; he had dropped something and came back for it.",
    "A pedestrian steps into our lane, so the ego yields to him, and he ended up on the median.",
    "A pedestrian steps into our lane, so we brake early, which kept everyone safe.",
];

const WITH: [&str; 44] = [
    "行人从右侧走上车道，离得很近，自车减速让行，以免与他发生碰撞。",
    "行人走上车道，自车减速让行，等他过去之后再加速。",
    "行人走进车道，自车踩下刹车让他先走，因为再往前就来不及了。",
    "行人刚才还在路边站着，现在已经走到车道上了，因此自车减速让行。",
    "自车减速让行，因为行人已经从右侧走进了车道。",
    "行人走进了车道，自车松了油，踩了一脚刹车，给他让了路。",
    "行人从右侧走了出来，离自车没几米了，于是自车赶紧减速让他。",
    "行人走上车道，自车减速让行，待其通过后继续行驶。",
    "行人走进来了，自车减速让行，确保他能安全走过去。",
    "行人从右侧走上车道，需要减速让他先过，否则就撞上了。",
    "行人走上车道，于是减速让行，给他留足了通过的时间。",
    "行人走上车道，自车减速让行，同时留意他后面有没有别人跟着。",
    "行人离自车太近了，减速让行。",
    "行人先是停了一下，又继续往车道里走，因此自车减速让行。",
    "行人走了两步又停下看车，随后继续横穿，所以自车减速让他先走。",
    "行人走到了车道中间，自车减速，让他走完再走。",
    "行人从右侧走上车道，自车该减速了，减速让行。",
    "行人从右侧路边走上车道，刹车让行，不能抢。",
    "行人横穿，距离近，自车要先减速让行，再视情况起步。",
    "行人走上了车道，照这个速度两秒后就会碰上，因此减速让行。",
    "行人走进车道，自车减速让行，如果他停下来再慢慢通过。",
    "行人走上车道，减速让行，免得把他吓着了。",
    "A pedestrian steps into our lane from the right, so we brake to avoid hitting him.",
    "A pedestrian stepped into our lane, so the ego slowed down and yielded to him.",
    "The pedestrian was waiting at the curb and has now stepped into our lane, so we slow down to let him cross.",
    "We slow down and yield because the pedestrian stepped into our lane.",
    "A pedestrian has stepped into our lane, so we brake and wait until he is across.",
    "A pedestrian steps into our lane, so the ego yields, keeping a safe distance to him.",
    "A pedestrian steps into our lane, so we brake now; otherwise we would hit him.",
    "A pedestrian steps into our lane, so we slow down, since he has not seen us.",
    "A pedestrian who had been standing at the curb walked into our lane, so we give way.",
    "A pedestrian steps into our lane, so we have to yield, and there is no room to go around him.",
    "A pedestrian steps into our lane, so we let him cross before moving on.",
    "A pedestrian steps into our lane, so we brake gently and stay ready to stop.",
    "A pedestrian steps into our lane, so the ego should slow down and let him pass, then continue.",
    "A pedestrian stepped off the curb a moment ago and is in our lane, so we yield to him.",
    "A pedestrian steps into our lane; he looked at us but kept walking, so we slow down for him.",
    "A pedestrian stepped out and we slowed to let him go first.",
    "A pedestrian steps into our lane, so we slow down so that he can cross safely.",
    "A pedestrian is in our lane, hence the ego reduces its speed and gives way as required.",
    "A pedestrian steps into our lane, so we brake in order not to be caught out if he stops.",
    "The ego yields, given that a pedestrian stepped into its lane and did not stop.",
    "A pedestrian steps into our lane, so we yield, as he was there first.",
    "A pedestrian steps into our lane, so we ease off and let him finish crossing.",
];

/// Before the decision, the road user to which the ego responds is out of the way.
const RESOLVED: [&str; 8] = [
    "行人走到一半退回了路边，因此自车减速让行。",
    "行人改了主意不过了，所以自车减速让行。",
    "行人让自车先走了，于是自车减速让行。",
    "行人从自车前面跑过去了，因此减速让行。",
    "She changed her mind and went back to the curb, so the ego yields to her.",
    "The pedestrian reached the other side, so we slow down for him.",
    "The man waved us through, so we give way to him.",
    "The man got out of our way, hence the ego brakes for him.",
];

/// The same words, where that road user is not out of the way, or another one comes.
const NOT_RESOLVED: [&str; 6] = [
    "行人停在路边没有退回去，正要继续走，因此自车减速让行。",
    "上一个行人退回了路边，又有一个小孩走上车道，因此减速让行。",
    "行人可能退回路边，也可能继续走，自车减速让行。",
    "A first man went back to the curb, but a child follows him into our lane, so we slow down.",
    "The pedestrian has not reached the other side yet, so we give way to him.",
    "If he went back to the curb we could go on, but he keeps walking, so we yield to him.",
];

/// Times that are predicted.
const PREDICTED: [&str; 4] = [
    "行人走上车道，预测轨迹与自车路径在约两秒后相交，因此自车减速让行。",
    "按当前速度，三秒后自车就会到行人跟前，因此减速让行。",
    "At this pace we meet the pedestrian a moment later, so we slow down for him.",
    "The predicted paths cross two seconds later, so the ego yields to the pedestrian.",
];

#[test]
fn whoever_is_out_of_the_way_is_hindsight_and_a_predicted_time_is_not() {
    let missed: Vec<_> = RESOLVED.iter().filter(|t| !found(t)).collect();
    let flagged: Vec<_> = NOT_RESOLVED.iter().chain(&PREDICTED).filter(|t| found(t)).collect();
    assert!(missed.is_empty() && flagged.is_empty(), "missed {missed:#?}, flagged {flagged:#?}");
}

#[test]
fn what_follows_the_decision_is_an_event_or_is_not() {
    let missed: Vec<_> = AFTER.iter().filter(|t| !found(t)).collect();
    let flagged: Vec<_> = WITH.iter().filter(|t| found(t)).collect();
    println!(
        "missed {} of {}: {missed:#?}\nflagged {} of {}: {flagged:#?}",
        missed.len(),
        AFTER.len(),
        flagged.len(),
        WITH.len()
    );
    assert!(missed.len() <= 2 && flagged.is_empty());
}

/// A later event is reported in the first sentence, and the last one states no decision: every combination of decisions
/// is checked to its end.
#[test]
fn hindsight_may_precede_the_last_sentence() {
    let checker = Checker::new(Framework::bundled());
    for along in ["yield_to_agent", "stop_for_obstacle", "lead_following", "resume"] {
        let decision =
            json!({ "longitudinal": along, "lateral": "in_lane_nudge", "lateral_direction": "left" });
        let trace = "赶紧刹停，自车加速抢着会过去。前头一个大坑，";
        let label = label(decision, "前头一个大坑，占了半条车道", trace);
        assert!(!checker.check_text(&label.to_string()).is_empty(), "{along}");
    }
}
