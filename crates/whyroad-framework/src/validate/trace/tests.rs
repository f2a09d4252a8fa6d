//! Sentences and what they say. Every expected value is a person's reading of the sentence against the
//! decision: "ok" where a fair checker of labels would let it pass, and a verdict only where he would not.

use super::*;
use crate::validate::lexicon::Lexicon;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};

fn lexicon() -> Lexicon {
    Lexicon::parse("lexicon", include_str!("../../../../../schema/decision_lexicon.yaml")).0
}

/// The verdicts on `text` for `longitudinal/lateral[/direction]` (`-` is null), as words.
fn verdicts(lexicon: &Lexicon, decision: &str, text: &str) -> String {
    let mut parts = decision.split('/');
    let along = parts.next().and_then(Longitudinal::from_id);
    let across = parts.next().and_then(Lateral::from_id);
    let side = parts.next().and_then(LateralDirection::from_id);
    let expected = usize::from(along.is_some()) + usize::from(across.is_some()) + usize::from(side.is_some());
    assert_eq!(expected, decision.split('/').filter(|p| *p != "-").count(), "{decision}");
    let mut out = Vec::new();
    judge(&read(text, lexicon), lexicon, along, across, side, &mut |v| {
        out.push(match v {
            TraceVerdict::OtherDecision { label, start, end, .. } => format!("other {label}: {}", &text[start..end]),
            TraceVerdict::Denied { label, .. } => format!("denied {label}"),
            TraceVerdict::OtherSide { says, .. } => format!("side {says}"),
            TraceVerdict::Unlabelled { says, .. } => format!("unlabelled {says}"),
            TraceVerdict::NoDecision => "none".to_owned(),
        });
    });
    if out.is_empty() { "ok".to_owned() } else { out.join("; ") }
}

/// decision, trace, verdict.
const SENTENCES: &[(&str, &str, &str)] = &[
    // Plain agreement.
    ("yield_to_agent/-", "左前方行人正走上斑马线，没有停步，与自车路径相交，因此减速让行。", "ok"),
    ("yield_to_agent/lane_keeping", "右侧电动车突然向左靠近本车道，间距变小，因此自车减速让行，保持车道居中。", "ok"),
    ("lead_following/-", "前车匀速行驶，车距稳定，因此继续跟车。", "ok"),
    ("lead_following/-", "前车减速，车距缩短，自车跟随前车减速。", "ok"),
    ("stop_for_regulation/-", "前方路口信号灯由黄变红，自车为头车，因此在停止线前停车等待。", "ok"),
    ("stop_for_obstacle/-", "前方车道有倒下的锥桶，两侧均无空间，因此减速停车。", "ok"),
    ("resume/-", "信号灯变绿，前方路口已清空，因此自车起步通过路口。", "ok"),
    ("gap_matching/lane_change/left", "导航提示左转，需进入左侧车道，左后方货车后面有空档，因此先减速匹配空档，再向左变道。", "ok"),
    ("acceleration_for_passing/lane_change/left", "前方货车缓慢，左侧车道空闲，因此加速超车，向左变道。", "ok"),
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
    ("stop_for_obstacle/-", "前方障碍物已移开，因此不必停车，保持车速通过。", "other stop_for_obstacle: 保持车速"),
    ("yield_to_agent/-", "行人已通过，不再需要让行，因此加速通过路口。", "other yield_to_agent: 加速通过"),
    ("stop_for_regulation/-", "前方黄灯变红，不得不在停止线前停车。", "ok"),
    ("yield_to_agent/-", "行人未减速，与自车路径相交，因此自车减速让行，避免碰撞。", "ok"),
    ("yield_to_agent/-", "骑行者切入，为避免追尾，因此减速让行。", "ok"),
    ("yield_to_agent/-", "行人不断靠近车道，因此提前减速，让行人先通过。", "ok"),
    ("lead_following/-", "右侧变道空间不足，换道条件不满足，因此继续跟车。", "ok"),
    ("lead_following/lane_change/right", "左侧有空档，但变道不安全，因此继续跟车。", "ok"),
    ("lead_following/lane_change/right", "左侧有空档，因此考虑后认为变道不安全。", "ok"),
    ("lead_following/lane_change/right", "右侧货车并行，因此变道不可行，继续跟车。", "denied lane_change"),
    ("-/turn/left", "对向无车，无保护左转条件满足，因此左转通过路口。", "ok"),
    // Other agents' manoeuvres.
    ("yield_to_agent/lane_keeping", "左侧车辆打转向灯，变道切入本车道，自车减速让行。", "ok"),
    ("yield_to_agent/lane_keeping", "前车变道离开后露出静止障碍，因此减速让行。", "ok"),
    ("lead_following/lane_keeping", "因此前车变道离开，自车继续跟车行驶。", "ok"),
    ("yield_to_agent/-", "因此减速让行正在左转的货车。", "ok"),
    ("yield_to_agent/lane_keeping", "右前方公交车起步，向左并线，因此减速让行，保持车道。", "ok"),
    ("lead_following/-", "前车起步，车距拉大，因此跟随前车起步。", "ok"),
    ("resume/-", "前车起步驶离，因此自车跟随起步。", "ok"),
    ("yield_to_agent/-", "减速让行，因为左侧货车正在变道切入本车道，距离很近。", "ok"),
    ("yield_to_agent/-", "对向车辆停车让行，行人仍在横穿，因此自车停车等待。", "ok"),
    ("lead_following/lane_keeping", "右侧车道的货车向左变道，随后与自车拉开距离，因此自车继续跟随前车，保持居中。", "ok"),
    ("yield_to_agent/-", "左转车辆抢行，因此刹车减速。", "ok"),
    ("-/lane_keeping", "等待左转的车队占用左侧车道，因此自车保持本车道行驶。", "ok"),
    ("stop_for_regulation/-", "自车位于左转车道，左转红灯亮起，因此在停止线前停车。", "ok"),
    // Hypotheses, intentions, later steps.
    ("yield_to_agent/-", "若不减速将与行人碰撞，因此减速让行。", "ok"),
    ("lead_following/lane_keeping", "若向左变道将与后车冲突，因此保持车道跟车。", "ok"),
    ("-/lane_change/left", "自车计划变道，但左后方车辆快速接近，因此保持本车道。", "other lane_change: 保持本车道"),
    ("yield_to_agent/-", "行人横穿，因此停车让行，行人通过后再起步。", "ok"),
    ("gap_matching/lane_keeping", "自车需要换道，左侧车流密集，因此减速为变道创造间隙，暂时保持车道。", "ok"),
    ("road_speed_adaptation/-", "路口右侧被围墙遮挡，因此减速慢行，随时准备停车让行。", "ok"),
    // Contradictions.
    ("yield_to_agent/-", "行人距离较远且已停步，因此加速通过。", "other yield_to_agent: 加速通过"),
    ("acceleration_for_passing/-", "前方行人横穿，因此减速让行。", "other acceleration_for_passing: 减速让行"),
    ("resume/-", "前方信号灯转红，因此在停止线前停车。", "other resume: 在停止线前停车"),
    ("lead_following/lane_keeping", "前方货车缓慢，左侧空闲，因此向左变道超越货车。", "other lane_keeping: 向左变道"),
    ("-/turn/left", "导航提示直行，因此向右变道。", "other turn: 向右变道"),
    ("stop_for_regulation/-", "前方绿灯，因此保持车速通过路口。", "other stop_for_regulation: 保持车速"),
    ("set_speed_tracking/-", "前方无车，因此靠边停车。", "unlabelled pull_over"),
    // Sides.
    ("-/lane_change/left", "前方货车缓慢，右侧空闲，因此向右变道。", "side right"),
    ("-/lane_change/right", "左侧车道有车，右侧空闲，因此变道至右侧车道。", "ok"),
    ("-/turn/right", "导航提示左转，路口绿灯，因此左转。", "side left"),
    ("-/in_lane_nudge/right", "左侧大车压线，因此在车道内向右偏移，避让左侧大车。", "ok"),
    ("-/in_lane_nudge/left", "左侧大车压线，因此在车道内向右偏移。", "side right"),
    // Null channels.
    ("yield_to_agent/-", "行人横穿，因此向左变道并减速让行。", "unlabelled lane_change"),
    ("-/lane_keeping", "道路通畅，因此沿车道匀速行驶。", "ok"),
    // No decision.
    ("yield_to_agent/-", "前方有行人，右侧有货车，道路湿滑，能见度较低。", "none"),
    ("-/-", "前方道路通畅，天气晴朗，没有需要应对的目标。", "ok"),
    // English.
    ("yield_to_agent/-", "A pedestrian steps onto the crosswalk ahead without looking, so the ego slows down and yields.", "ok"),
    ("yield_to_agent/-", "Yield to the pedestrian because she is crossing ahead of the stopped bus.", "ok"),
    ("lead_following/-", "The lead vehicle brakes gently and the gap shrinks; therefore keep following it at a safe distance.", "ok"),
    ("yield_to_agent/lane_keeping", "The van changes lanes into our lane with little gap, so we brake to give way and stay in our lane.", "ok"),
    ("-/lane_change/left", "The lead truck is slow and the left lane is clear, therefore change lanes to the left.", "ok"),
    ("-/lane_change/left", "The lead truck is slow and the right lane is clear, therefore change lanes to the right.", "side right"),
    ("-/lane_change/left", "The lead truck speeds up, so there is no need to change lanes.", "denied lane_change"),
    ("lead_following/lane_keeping", "The gap on the left is too small, so the ego keeps its lane without changing lanes and follows the lead.", "ok"),
    ("stop_for_regulation/-", "The light turns red and the ego is first in line, so it stops at the stop line.", "ok"),
    ("stop_for_regulation/-", "The light is green and the junction is clear, therefore accelerate through.", "other stop_for_regulation: accelerate"),
    ("resume/-", "The light turns green and the lead pulls away; therefore the ego starts off.", "ok"),
    ("resume/-", "The light turns green, but pedestrians still cross; therefore the ego yields and stays stopped.", "other resume: yields"),
    ("-/turn/right", "The route turns right here and the crosswalk is clear, hence turn right.", "ok"),
    ("-/turn/right", "The route goes left here and the crosswalk is clear, hence turn left.", "side left"),
    ("yield_to_agent/turn/left", "Oncoming traffic has priority, so the ego stops to yield before it turns left.", "ok"),
    ("stop_for_obstacle/-", "Debris blocks the lane and both sides are occupied, so the ego stops rather than changing lanes.", "ok"),
    ("road_speed_adaptation/-", "The bend ahead is sharp, therefore slow down for the bend.", "ok"),
    ("-/in_lane_nudge/left", "A parked van sticks out on the right, so nudge left within the lane.", "ok"),
    ("-/out_of_lane_nudge/left", "A broken-down truck blocks the lane, so cross the lane line to go around it.", "ok"),
    ("gap_matching/lane_change/right", "The exit is near and the gray SUV leaves a gap behind it; therefore slow down to match the gap, then change lanes to the right.", "ok"),
    ("lead_following/-", "If the ego changed lanes it would cut off the van; therefore keep following the lead.", "ok"),
    ("yield_to_agent/-", "The cyclist does not slow down, therefore the ego should not accelerate but yield.", "ok"),
    ("acceleration_for_passing/-", "The lead is slow and the road is clear, therefore do not accelerate, and keep following the lead.", "other acceleration_for_passing: keep following"),
];

#[test]
fn sentences_are_read_as_a_person_reads_them() {
    let lexicon = lexicon();
    let wrong: Vec<String> = SENTENCES
        .iter()
        .filter_map(|(decision, text, expected)| {
            let found = verdicts(&lexicon, decision, text);
            (found != *expected).then(|| format!("{decision}: {text}\n  expected {expected}\n  found    {found}\n  {:?}", read(text, &lexicon)))
        })
        .collect();
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), SENTENCES.len(), wrong.join("\n"));
    assert!(SENTENCES.len() >= 90, "{}", SENTENCES.len());
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
    let (s, e) = read(text, &lexicon).decision_id.unwrap();
    assert_eq!(&text[s..e], "yield_to_agent");
    assert_eq!(read("resume and turn", &lexicon).decision_id, None);
}
