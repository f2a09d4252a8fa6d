use crate::language::Checker;
use crate::language::parse::parse;
use whyroad_model::Bilingual;
use whyroad_signals::Catalog;

fn words(text: &str) -> Bilingual {
    let mut checker = Checker::new(Catalog::bundled());
    checker.define("ring", "map.in_roundabout or map.distance_to_roundabout < 5 m").unwrap();
    checker.define("quick", "ego.speed > 20 m/s").unwrap();
    checker.names.insert("ring".into(), Bilingual::new("在环岛处", "at a roundabout"));
    let expr = parse(text).unwrap();
    checker.condition(&expr).unwrap();
    checker.in_words(&expr)
}

fn check(text: &str, zh: &str, en: &str) {
    assert_eq!(words(text), Bilingual::new(zh, en), "{text}");
}

#[test]
fn comparisons_are_of_titles_and_have_signs_of_mathematics() {
    check("target.ttc <= 3 s", "与目标的碰撞时间 TTC ≤ 3 s", "TTC to the target ≤ 3 s");
    check("0 m < target.gap", "与目标的净距 > 0 m", "Gap to the target > 0 m");
    check("abs(ego.accel) < 1 m/s2", "|自车加速度| < 1 m/s²", "|acceleration of the ego| < 1 m/s²");
    check("ego.turn_signal != left", "自车转向灯不为左", "Turn signal of the ego is not left");
    check(
        "light.state in {red, yellow, red_yellow}",
        "信号灯状态为红、黄或红黄",
        "State of the light is red, yellow or red and yellow",
    );
    check("2 m < target.gap <= 5 m", "2 m < 与目标的净距 ≤ 5 m", "2 m < gap to the target ≤ 5 m");
}

#[test]
fn what_is_denied_is_turned_round_where_that_is_plain() {
    check("not ego.speed < 5 m/s", "自车速度 ≥ 5 m/s", "Speed of the ego ≥ 5 m/s");
    check("not quick", "自车速度 ≤ 20 m/s", "Speed of the ego ≤ 20 m/s");
    check("not ring", "并非在环岛处", "Not: at a roundabout");
    check("ego.brake == false", "并非自车踩制动", "Not: the ego brakes");
    check("not (ego.brake == true)", "并非自车踩制动", "Not: the ego brakes");
    check("not (ego.brake == false)", "自车踩制动", "The ego brakes");
    check("light.state is unknown", "信号灯状态未知", "State of the light is unknown");
    check(
        "not previously(ego.standstill, 5 s)",
        "此前 5 s 内并未自车静止",
        "Not in the last 5 s: the ego is stationary",
    );
}

#[test]
fn a_denied_test_of_knowledge_is_said() {
    // True where x is unknown, too.
    check(
        "not (ego.brake is known and ego.brake)",
        "并非（或未知）自车踩制动",
        "Not (or unknown): the ego brakes",
    );
    check(
        "not (target.gap is known and target.gap < 5 m)",
        "与目标的净距 ≥ 5 m（或未知）",
        "Gap to the target ≥ 5 m (or unknown)",
    );
    check(
        "not (ring or (ego.brake is known and ego.brake))",
        "并非“在环岛处，或“自车踩制动已知，且自车踩制动””",
        "Not: (at a roundabout or (the ego brakes is known and the ego brakes))",
    );
    // Without a negation the value is known wherever the condition holds.
    check("ego.brake is known and ego.brake", "自车踩制动", "The ego brakes");
}

#[test]
fn people_read_angles_in_degrees() {
    check(
        "ego.turn_angle > 0.5 rad",
        "自车在路口内的转角 > 28.65°",
        "Angle that the ego turns in the junction > 28.65°",
    );
}

#[test]
fn definitions_are_named_or_written_out_and_what_is_joined_is_quoted() {
    check(
        "(ring and quick) within 3 s",
        "此后 3 s 内“在环岛处，且自车速度 > 20 m/s”",
        "Within the next 3 s: (at a roundabout and speed of the ego > 20 m/s)",
    );
    check(
        "exists(target.is_lead and target.speed < 2 m/s, vehicle)",
        "有机动车满足：“该对象是前车，且该对象速度 < 2 m/s”",
        "A vehicle for which (the object is the lead and speed of the object < 2 m/s)",
    );
}
