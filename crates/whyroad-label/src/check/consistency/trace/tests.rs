//! Sentences and their verdicts. Every expected value is a person's reading of the sentence against the decision: "ok"
//! where a fair checker of labels would accept it, and a verdict only where they would not.

use super::*;
use whyroad_framework::lexicon::Lexicon;
use whyroad_framework::lexicon::units::Units;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};

fn lexicon() -> Lexicon {
    Lexicon::parse("lexicon", include_str!("../../../../../../schema/decision_lexicon.yaml"), &[]).0
}

/// The verdicts on `text` for `longitudinal/lateral[/direction]` (`-` is null), as text.
fn verdicts(lexicon: &Lexicon, decision: &str, text: &str) -> String {
    let mut parts = decision.split('/');
    let along = parts.next().and_then(Longitudinal::from_id);
    let across = parts.next().and_then(Lateral::from_id);
    let side = parts.next().and_then(LateralDirection::from_id);
    let expected = usize::from(along.is_some()) + usize::from(across.is_some()) + usize::from(side.is_some());
    assert_eq!(expected, decision.split('/').filter(|p| *p != "-").count(), "{decision}");
    let mut out = Vec::new();
    judge(&read(text, &Units::of(text), lexicon), lexicon, along, across, side, &mut |v| {
        out.push(match v {
            TraceVerdict::OtherDecision { label, start, end, .. } => {
                format!("other {label}: {}", &text[start..end])
            }
            TraceVerdict::Denied { label, .. } => format!("denied {label}"),
            TraceVerdict::Against { label, .. } => format!("against {label}"),
            TraceVerdict::OtherSide { says, .. } => format!("side {says}"),
            TraceVerdict::Unlabelled { says, .. } => format!("unlabeled {says}"),
            TraceVerdict::NotStated { .. } => "none".to_owned(),
        });
    });
    if out.is_empty() { "ok".to_owned() } else { out.join("; ") }
}

/// decision, trace, verdict.
const SENTENCES: &[(&str, &str, &str)] = &[
    // What the page writes for a decision (web/src/label/decision_words.ts).
    ("set_speed_tracking/-", "斑马线上没有行人，需要时马上能停住，因此自车保持目标车速。", "ok"),
    (
        "set_speed_tracking/-",
        "Nobody is on the crosswalk, and there is room to stop, therefore the ego keeps its set speed.",
        "ok",
    ),
    // Plain agreement.
    ("yield_to_agent/-", "左前方行人正走上斑马线，没有停步，与自车路径相交，因此减速让行。", "ok"),
    (
        "yield_to_agent/lane_keeping",
        "右侧电动车突然向左靠近本车道，间距变小，因此自车减速让行，保持车道居中。",
        "ok",
    ),
    ("lead_following/-", "前车匀速行驶，车距稳定，因此继续跟车。", "ok"),
    ("lead_following/-", "前车减速，车距缩短，自车跟随前车减速。", "ok"),
    ("stop_for_regulation/-", "前方路口信号灯由黄变红，自车为头车，因此在停止线前停车等待。", "ok"),
    ("stop_for_obstacle/-", "前方车道有倒下的锥桶，两侧均无空间，因此减速停车。", "ok"),
    ("resume/-", "信号灯变绿，前方路口已清空，因此自车起步通过路口。", "ok"),
    (
        "gap_matching/lane_change/left",
        "导航提示左转，需进入左侧车道，左后方货车后面有空档，因此先减速匹配空档，再向左变道。",
        "ok",
    ),
    (
        "acceleration_for_passing/lane_change/left",
        "前方货车缓慢，左侧车道空闲，因此加速超车，向左变道。",
        "ok",
    ),
    ("road_speed_adaptation/-", "前方弯道曲率大，视距受限，因此提前减速过弯。", "ok"),
    ("-/in_lane_nudge/left", "右侧路边停有货车，占用部分车道，因此在车道内向左偏移通过。", "ok"),
    ("-/out_of_lane_nudge/left", "前方故障车占道，对向无来车，因此向左借道绕行后回到本车道。", "ok"),
    ("yield_to_agent/turn/left", "自车左转，对向直行车接近，因此停车让行，待其通过后左转。", "ok"),
    ("-/pull_over", "到达目的地，右侧有空位，因此靠边停车。", "ok"),
    ("-/maneuver_abort", "自车向左变道途中，左后方车辆快速接近，因此中止变道，回到原车道。", "ok"),
    ("-/turn/uturn", "路口允许掉头，对向无来车，因此左转掉头。", "ok"),
    ("-/merge_or_split", "加速车道即将结束，主路后方有空档，因此汇入主路。", "ok"),
    ("-/reverse", "前方道路被堵死，后方无车，因此倒车退出。", "ok"),
    // Negation.
    ("yield_to_agent/-", "前方行人横穿，右侧车道有车，无需变道，因此减速让行即可。", "ok"),
    ("yield_to_agent/lane_keeping", "前方行人横穿，因此无需变道，保持车道减速让行。", "ok"),
    ("-/lane_change/left", "前车缓慢但车距充足，因此无需变道。", "denied lane_change"),
    ("-/lane_change/left", "前车缓慢但车距充足，因此没有必要向左变道，继续跟车。", "denied lane_change"),
    ("-/lane_change/left", "前方货车缓慢，右侧无法变道，因此向左变道。", "ok"),
    (
        "stop_for_obstacle/-",
        "前方障碍物已移开，因此不必停车，保持车速通过。",
        "other stop_for_obstacle: 保持车速",
    ),
    ("yield_to_agent/-", "行人已通过，不再需要让行，因此加速通过路口。", "other yield_to_agent: 加速通过"),
    ("stop_for_regulation/-", "前方黄灯变红，不得不在停止线前停车。", "ok"),
    ("yield_to_agent/-", "行人未减速，与自车路径相交，因此自车减速让行，避免碰撞。", "ok"),
    ("yield_to_agent/-", "骑行者切入，为避免追尾，因此减速让行。", "ok"),
    ("yield_to_agent/-", "行人不断靠近车道，因此提前减速，让行人先通过。", "ok"),
    ("lead_following/-", "右侧变道空间不足，换道条件不满足，因此继续跟车。", "ok"),
    ("lead_following/lane_change/right", "左侧有空档，但变道不安全，因此继续跟车。", "none"),
    ("lead_following/lane_change/right", "左侧有空档，因此考虑后认为变道不安全。", "ok"),
    ("lead_following/lane_change/right", "右侧货车并行，因此变道不可行，继续跟车。", "denied lane_change"),
    ("-/turn/left", "对向无车，无保护左转条件满足，因此左转通过路口。", "ok"),
    // Other agents' maneuvers.
    ("yield_to_agent/lane_keeping", "左侧车辆打转向灯，变道切入本车道，自车减速让行。", "ok"),
    ("yield_to_agent/lane_keeping", "前车变道离开后露出静止障碍，因此减速让行。", "ok"),
    ("lead_following/lane_keeping", "因此前车变道离开，自车继续跟车行驶。", "ok"),
    ("yield_to_agent/-", "因此减速让行正在左转的货车。", "ok"),
    ("yield_to_agent/lane_keeping", "右前方公交车起步，向左并线，因此减速让行，保持车道。", "ok"),
    ("lead_following/-", "前车起步，车距拉大，因此跟随前车起步。", "ok"),
    ("resume/-", "前车起步驶离，因此自车跟随起步。", "ok"),
    ("yield_to_agent/-", "减速让行，因为左侧货车正在变道切入本车道，距离很近。", "ok"),
    ("yield_to_agent/-", "对向车辆停车让行，行人仍在横穿，因此自车停车等待。", "ok"),
    (
        "lead_following/lane_keeping",
        "右侧车道的货车向左变道，随后与自车拉开距离，因此自车继续跟随前车，保持居中。",
        "ok",
    ),
    ("yield_to_agent/-", "左转车辆抢行，因此刹车减速。", "ok"),
    ("-/lane_keeping", "等待左转的车队占用左侧车道，因此自车保持本车道行驶。", "ok"),
    ("stop_for_regulation/-", "自车位于左转车道，左转红灯亮起，因此在停止线前停车。", "ok"),
    // Hypotheses, intentions, later steps.
    ("yield_to_agent/-", "若不减速将与行人碰撞，因此减速让行。", "ok"),
    ("lead_following/lane_keeping", "若向左变道将与后车冲突，因此保持车道跟车。", "ok"),
    (
        "-/lane_change/left",
        "自车计划变道，但左后方车辆快速接近，因此保持本车道。",
        "other lane_change: 保持本车道",
    ),
    ("yield_to_agent/-", "行人横穿，因此停车让行，行人通过后再起步。", "ok"),
    ("gap_matching/lane_keeping", "自车需要换道，左侧车流密集，因此减速为变道创造间隙，暂时保持车道。", "ok"),
    ("road_speed_adaptation/-", "路口右侧被围墙遮挡，因此减速慢行，随时准备停车让行。", "ok"),
    // Contradictions.
    ("yield_to_agent/-", "行人距离较远且已停步，因此加速通过。", "other yield_to_agent: 加速通过"),
    (
        "acceleration_for_passing/-",
        "前方行人横穿，因此减速让行。",
        "other acceleration_for_passing: 减速让行",
    ),
    ("resume/-", "前方信号灯转红，因此在停止线前停车。", "other resume: 在停止线前停车"),
    (
        "lead_following/lane_keeping",
        "前方货车缓慢，左侧空闲，因此向左变道超越货车。",
        "other lane_keeping: 向左变道",
    ),
    ("-/turn/left", "导航提示直行，因此向右变道。", "other turn: 向右变道"),
    ("stop_for_regulation/-", "前方绿灯，因此保持车速通过路口。", "other stop_for_regulation: 保持车速"),
    ("set_speed_tracking/-", "前方无车，因此靠边停车。", "unlabeled pull_over"),
    // Sides.
    ("-/lane_change/left", "前方货车缓慢，右侧空闲，因此向右变道。", "side right"),
    ("-/lane_change/right", "左侧车道有车，右侧空闲，因此变道至右侧车道。", "ok"),
    ("-/turn/right", "导航提示左转，路口绿灯，因此左转。", "side left"),
    ("-/in_lane_nudge/right", "左侧大车压线，因此在车道内向右偏移，避让左侧大车。", "ok"),
    ("-/in_lane_nudge/left", "左侧大车压线，因此在车道内向右偏移。", "side right"),
    // Null channels.
    ("yield_to_agent/-", "行人横穿，因此向左变道并减速让行。", "unlabeled lane_change"),
    ("-/lane_keeping", "道路通畅，因此沿车道匀速行驶。", "ok"),
    // No decision.
    ("yield_to_agent/-", "前方有行人，右侧有货车，道路湿滑，能见度较低。", "none"),
    ("-/-", "前方道路通畅，天气晴朗，没有需要应对的目标。", "ok"),
    // English.
    (
        "yield_to_agent/-",
        "A pedestrian steps onto the crosswalk ahead without looking, so the ego slows down and yields.",
        "ok",
    ),
    ("yield_to_agent/-", "Yield to the pedestrian because she is crossing ahead of the stopped bus.", "ok"),
    (
        "lead_following/-",
        "The lead vehicle brakes gently and the gap shrinks; therefore keep following it at a safe distance.",
        "ok",
    ),
    (
        "yield_to_agent/lane_keeping",
        "The van changes lanes into our lane with little gap, so we brake to give way and stay in our lane.",
        "ok",
    ),
    (
        "-/lane_change/left",
        "The lead truck is slow and the left lane is clear, therefore change lanes to the left.",
        "ok",
    ),
    (
        "-/lane_change/left",
        "The lead truck is slow and the right lane is clear, therefore change lanes to the right.",
        "side right",
    ),
    (
        "-/lane_change/left",
        "The lead truck speeds up, so there is no need to change lanes.",
        "denied lane_change",
    ),
    (
        "lead_following/lane_keeping",
        "The gap on the left is too small, so the ego keeps its lane without changing lanes and follows the lead.",
        "ok",
    ),
    (
        "stop_for_regulation/-",
        "The light turns red and the ego is first in line, so it stops at the stop line.",
        "ok",
    ),
    (
        "stop_for_regulation/-",
        "The light is green and the junction is clear, therefore accelerate through.",
        "other stop_for_regulation: accelerate through",
    ),
    ("resume/-", "The light turns green and the lead pulls away; therefore the ego starts off.", "ok"),
    (
        "resume/-",
        "The light turns green, but pedestrians still cross; therefore the ego yields and stays stopped.",
        "other resume: yields",
    ),
    ("-/-", "The car from the right is there first, therefore the ego stays nearly stopped.", "ok"),
    ("-/-", "右侧来车先到路口，因此自车保持几乎停住。", "ok"),
    ("-/-", "右侧来车先到路口，因此自车仍停着不动。", "ok"),
    ("-/-", "右侧来车先到路口，因此自车停住。", "unlabeled yield_to_agent"),
    ("-/turn/right", "The route turns right here and the crosswalk is clear, hence turn right.", "ok"),
    ("-/turn/right", "The route goes left here and the crosswalk is clear, hence turn left.", "side left"),
    (
        "yield_to_agent/turn/left",
        "Oncoming traffic has priority, so the ego stops to yield before it turns left.",
        "ok",
    ),
    (
        "stop_for_obstacle/-",
        "Debris blocks the lane and both sides are occupied, so the ego stops rather than changing lanes.",
        "ok",
    ),
    ("road_speed_adaptation/-", "The bend ahead is sharp, therefore slow down for the bend.", "ok"),
    ("-/in_lane_nudge/left", "A parked van sticks out on the right, so nudge left within the lane.", "ok"),
    (
        "-/out_of_lane_nudge/left",
        "A broken-down truck blocks the lane, so cross the lane line to go around it.",
        "ok",
    ),
    (
        "gap_matching/lane_change/right",
        "The exit is near and the gray SUV leaves a gap behind it; therefore slow down to match the gap, then change lanes to the right.",
        "ok",
    ),
    (
        "lead_following/-",
        "If the ego changed lanes it would cut off the van; therefore keep following the lead.",
        "ok",
    ),
    (
        "yield_to_agent/-",
        "The cyclist does not slow down, therefore the ego should not accelerate but yield.",
        "ok",
    ),
    (
        "acceleration_for_passing/-",
        "The lead is slow and the road is clear, therefore do not accelerate, and keep following the lead.",
        "other acceleration_for_passing: keep following",
    ),
    // Written after the lexicon was finished, as annotators might write, to test sentences for which it was not made.
    (
        "yield_to_agent/-",
        "右前方一辆外卖电动车突然从路边停放的车辆间窜出，横在自车前方，距离很近，需立即制动避免碰撞。",
        "ok",
    ),
    ("yield_to_agent/-", "前方斑马线上有老人缓慢通过，尚未走完，自车应停在斑马线前等待其通过。", "ok"),
    ("lead_following/-", "前方车流拥堵，前车走走停停，自车与前车保持安全距离，缓慢跟随。", "ok"),
    (
        "lead_following/lane_keeping",
        "前方大货车行驶平稳，左侧车道有车辆并行，不具备变道条件，因此保持跟车。",
        "ok",
    ),
    (
        "road_speed_adaptation/-",
        "前方为连续下坡急弯，右侧山体遮挡视线，看不到对向来车，应降低车速平稳过弯。",
        "ok",
    ),
    ("road_speed_adaptation/-", "隧道出口光线突然变亮，前方情况看不清，因此适当降低车速。", "ok"),
    ("road_speed_adaptation/-", "路面积水较深，轮胎可能打滑，故减速慢行，避免急打方向。", "ok"),
    ("stop_for_regulation/-", "信号灯剩余黄灯时间不足以通过路口，故在停止线前平稳刹停。", "ok"),
    ("stop_for_regulation/-", "路口设有停车让行标志，左右视线被绿化带遮挡，应在停止线前停车观察。", "ok"),
    ("resume/-", "红灯转绿，自车位于停止线第一位，路口内无冲突车辆，可以起步。", "ok"),
    ("resume/-", "闸机栏杆已抬起，前方无障碍，自车起步通过闸机。", "ok"),
    (
        "gap_matching/merge_or_split",
        "加速车道剩余长度有限，主路后方白车较远，因此加速调整至空档后汇入主路。",
        "ok",
    ),
    ("gap_matching/lane_change/left", "前方右侧车道施工封闭，左后方车流间有空档，因此提速并向左变道。", "ok"),
    (
        "acceleration_for_passing/out_of_lane_nudge/left",
        "前方三轮车速度很慢，对向车道无来车且为虚线，因此加速从左侧借道超越。",
        "ok",
    ),
    (
        "-/in_lane_nudge/right",
        "左侧大客车贴近车道线行驶，横向间距不足，因此稍向右侧偏移以拉开横向距离。",
        "ok",
    ),
    (
        "-/maneuver_abort",
        "自车正向右变道，右后方轿车突然加速逼近，横向空间不足，因此放弃变道并回到原车道。",
        "ok",
    ),
    (
        "stop_for_obstacle/-",
        "前车突然变道驶离，露出前方静止的故障车，两侧车道均被占用，只能紧急制动停车。",
        "ok",
    ),
    (
        "yield_to_agent/lane_keeping",
        "左侧车道的出租车为避让前方公交车强行并入本车道，因此自车减速让其先行，不变道。",
        "ok",
    ),
    ("set_speed_tracking/-", "限速标志由60降为40，前方无车，因此减速至限速并匀速行驶。", "ok"),
    ("-/turn/uturn", "导航指示前方掉头，对向来车已通过，因此完成掉头。", "ok"),
    ("yield_to_agent/-", "救护车鸣笛从后方接近，因此靠右减速让行。", "ok"),
    (
        "yield_to_agent/-",
        "The cyclist on the right wobbles around a parked car and enters our lane; there is no room to pass safely, so the ego brakes and waits behind.",
        "ok",
    ),
    (
        "lead_following/-",
        "Traffic ahead is dense and the lead car brakes repeatedly, so the ego slows and keeps a safe distance.",
        "ok",
    ),
    (
        "stop_for_regulation/-",
        "The stop sign applies to our approach and the cross street is hidden by a hedge, therefore come to a complete stop at the line.",
        "ok",
    ),
    (
        "road_speed_adaptation/-",
        "A speed bump lies just ahead and the road narrows, so reduce speed before it.",
        "ok",
    ),
    (
        "-/lane_change/right",
        "The route exits in a short distance and the right lane has a clear gap, so move to the right lane.",
        "ok",
    ),
    (
        "-/maneuver_abort",
        "While changing lanes to the left, a motorcycle speeds up from behind, so the ego aborts the lane change and returns to its lane.",
        "ok",
    ),
    (
        "stop_for_obstacle/-",
        "A fallen ladder blocks the lane and oncoming traffic leaves no way around, so the ego stops.",
        "ok",
    ),
    (
        "resume/-",
        "The pedestrians have cleared the crosswalk and the way is free, so the ego proceeds from standstill.",
        "ok",
    ),
    (
        "-/out_of_lane_nudge/left",
        "A delivery van is double-parked and oncoming traffic is clear, so the ego nudges left over the line and returns to its lane.",
        "ok",
    ),
    (
        "yield_to_agent/-",
        "对向车辆较远，路口空闲，因此无需让行，直接左转通过。",
        "denied yield_to_agent; unlabeled turn",
    ),
    (
        "lead_following/-",
        "前车已停稳且打双闪，判断为故障车，因此不再跟车，向左变道绕行。",
        "denied lead_following; unlabeled lane_change",
    ),
    (
        "stop_for_regulation/-",
        "路口为绿灯且无行人，因此加速通过路口，不停车。",
        "other stop_for_regulation: 加速通过",
    ),
    ("-/lane_change/left", "右侧车道空闲，导航提示右转，因此向右侧车道变道。", "side right"),
    (
        "-/lane_keeping",
        "The left lane is free and the lead is slow, so the ego changes lanes to the left.",
        "other lane_keeping: changes lanes to the left",
    ),
];

#[test]
fn sentences_are_read_as_a_person_reads_them() {
    let lexicon = lexicon();
    let wrong: Vec<String> = SENTENCES
        .iter()
        .filter_map(|(decision, text, expected)| {
            let found = verdicts(&lexicon, decision, text);
            (found != *expected).then(|| {
                format!(
                    "{decision}: {text}\n  expected {expected}\n  found    {found}\n  {:?}",
                    read(text, &Units::of(text), &lexicon)
                )
            })
        })
        .collect();
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), SENTENCES.len(), wrong.join("\n"));
    assert!(SENTENCES.len() >= 127, "{}", SENTENCES.len());
}

#[test]
fn an_empty_lexicon_says_nothing() {
    assert_eq!(verdicts(&Lexicon::default(), "yield_to_agent/-", "因此加速通过。"), "ok");
}

#[test]
fn lengths_and_numbers_are_counted_as_a_reader_would() {
    let limits = lexicon().limits;
    let of = |t| form(t, &limits);
    assert_eq!(of("前车减速，自车让行。"), Form { length: 8, numbers: 0 });
    assert_eq!(of("The van slows."), Form { length: 6, numbers: 0 });
    // 50 m, 3.2 s, 12:30; G6 and SUV2 are names; `don't` is one word.
    assert_eq!(of("前方50m，3.2s 后 12:30 到 G6，SUV2").numbers, 3);
    assert_eq!(of("don't stop").length, 4);
}

#[test]
fn identifiers_are_seen() {
    let lexicon = lexicon();
    let text = "前方行人横穿，因此让行（yield_to_agent）。";
    let (s, e) = read(text, &Units::of(text), &lexicon).decision_id.unwrap();
    assert_eq!(&text[s..e], "yield_to_agent");
    assert_eq!(read("resume and turn", &Units::of("resume and turn"), &lexicon).decision_id, None);
}

#[test]
fn the_names_of_decisions_are_understood() {
    // A draft made by a program names the decision as schema/driving_decisions.yaml does.
    let lexicon = lexicon();
    let decisions = &whyroad_framework::Framework::bundled().decisions;
    let mut wrong = Vec::new();
    for d in &decisions.longitudinal {
        for (name, so) in
            [(&d.text.name.zh, "前方情况变化，因此"), (&d.text.name.en, "The scene changes, therefore: ")]
        {
            let found = verdicts(&lexicon, &format!("{}/-", d.id), &format!("{so}{name}"));
            wrong.extend((found != "ok").then(|| format!("{name}: {found}")));
        }
    }
    for d in &decisions.lateral {
        for (name, so) in
            [(&d.text.name.zh, "前方情况变化，因此"), (&d.text.name.en, "The scene changes, therefore: ")]
        {
            let found = verdicts(&lexicon, &format!("-/{}", d.id), &format!("{so}{name}"));
            wrong.extend((found != "ok").then(|| format!("{name}: {found}")));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
