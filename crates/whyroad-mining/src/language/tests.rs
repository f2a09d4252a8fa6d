//! Expected readings come from the grammar in `docs/reference/rules.md` and from DATA_FORMAT.md 5.

use super::*;
use crate::language::program::{Atom, Op};
use crate::language::syntax::{ExprKind, Quantity};
use whyroad_model::Lang;
use whyroad_model::diagnostic::render_text;
use whyroad_model::units::Unit;
use whyroad_signals::Catalog;

fn check(text: &str) -> Result<(Program, NodeId), Fault> {
    let mut checker = Checker::new(Catalog::bundled());
    let band = Quantity { value: 7.0, unit: Unit::parse("m").unwrap() };
    checker.parameters.insert("band".to_owned(), band);
    let expr = parse::parse(text)?;
    let id = checker.condition(&expr)?;
    Ok((checker.program, id))
}

fn fault(text: &str) -> Fault {
    check(text).expect_err(text)
}

fn describe(text: &str) -> String {
    let checker = Checker::new(Catalog::bundled());
    checker.describe(&parse::parse(text).unwrap())
}

#[test]
fn and_binds_tighter_than_or_and_for_speaks_of_all_to_its_left() {
    let kind = |text| parse::parse(text).unwrap().kind;
    let ExprKind::Or(all) = kind("ego.brake or ego.aeb and ego.standstill") else { panic!("or on top") };
    assert!(matches!(all[1].kind, ExprKind::And(_)));
    // DESIGN.md "Rules": the duration is that of the whole conjunction, as in DATA_FORMAT.md 5.1.
    let ExprKind::For(of, _) = kind("target.lateral_offset > 0.5 m and ttc < 5 s for 0.5 s") else {
        panic!("for on top")
    };
    assert!(matches!(of.kind, ExprKind::And(_)));
    let ExprKind::Then(_, second, _) = kind("ego.brake then ego.standstill within 3 s") else {
        panic!("then on top")
    };
    assert!(matches!(second.kind, ExprKind::Name(_)), "`within` belongs to the `then`");
}

#[test]
fn what_is_counted_near_an_object_belongs_to_it() {
    let scope = |text: &str| {
        let (program, id) = check(text).unwrap();
        program.node(id).scope
    };
    assert_eq!(scope("exists(target.gap < 5 m)"), ValueScope::Frame);
    assert_eq!(scope("exists(pair.sector == right, bicycle)"), ValueScope::Target);
    assert_eq!(scope("count(other.stopped, vehicle) >= 3"), ValueScope::Target);
    // A node without an own object is the same inside and outside.
    assert_eq!(
        scope("exists(pair.follows and ego.speed > 1 m/s) and object.speed > 2 m/s"),
        ValueScope::Target
    );
    let (program, id) =
        check("exists(pair.sector == right and reverse.distance < 5 m and object.stopped)").unwrap();
    let expected = ["object.stopped", "pair.distance", "pair.sector"].map(str::to_owned);
    assert_eq!(program.signals(id), expected.into());
}

#[test]
fn numbers_arrive_in_base_units() {
    let (program, _) = check("ego.speed > 36 km/h").unwrap();
    assert!(program.nodes.iter().any(|n| matches!(n.op, Op::Constant(v) if (v - 10.0).abs() < 1e-12)));
    let (program, _) = check("abs(ego.yaw_rate) > 180 deg/s").unwrap();
    assert!(
        program
            .nodes
            .iter()
            .any(|n| matches!(n.op, Op::Constant(v) if (v - std::f64::consts::PI).abs() < 1e-12))
    );
}

#[test]
fn equal_parts_are_one_node() {
    let (program, _) = check("rises(ego.speed > 1 m/s) or falls(ego.speed > 1 m/s)").unwrap();
    assert_eq!(program.nodes.iter().filter(|n| matches!(n.op, Op::Compare { .. })).count(), 1);
}

#[test]
fn every_kind_of_fault_has_its_code_and_place() {
    // (text, code, the marked part)
    let cases = [
        ("ego.sped > 5 m/s", "rule.signal.unknown", "ego.sped"),
        ("target_vehicle.lateral_ofset > 0.5 m", "rule.signal.unknown", "target_vehicle.lateral_ofset"),
        ("ego.speed > 5 s", "rule.unit.mismatch", "ego.speed > 5 s"),
        ("ego.speed > 5", "rule.unit.mismatch", "ego.speed > 5"),
        ("ego.speed > 5 kmh", "rule.unit.unknown", "kmh"),
        ("ego.speed + band > 3 m", "rule.unit.mismatch", "ego.speed + band"),
        ("ego.speed", "rule.type", "ego.speed"),
        ("ego.standstill > 3 m", "rule.type", "ego.standstill > 3 m"),
        ("ego.lane_change == lft", "rule.member.unknown", "lft"),
        ("ego.lane_change in {left, up}", "rule.member.unknown", "up"),
        ("ego.speed in {left}", "rule.type", "ego.speed"),
        ("ego.brake for 5 m", "rule.unit.mismatch", "5 m"),
        ("rise(ego.brake)", "rule.call", "rise(ego.brake)"),
        ("abs(ego.speed, 3 s) > 1 m/s", "rule.call", "abs(ego.speed, 3 s)"),
        ("target_vehicle.speed > 1 m/s and target_vru.speed > 1 m/s", "rule.target", "target_vru.speed"),
        ("ego.brake for 1 s and ego.aeb", "rule.syntax", "and"),
        ("ego.brake then ego.aeb", "rule.syntax", ""),
        ("ego.brake since ego.aeb until ego.standstill", "rule.syntax", "until"),
        ("ego.brake until", "rule.syntax", ""),
        ("ego.brake for 1 s gaps 3 m", "rule.unit.mismatch", "3 m"),
        ("exists(ego.brake)", "rule.target", "ego.brake"),
        ("exists(target.gap < 5 m, cat)", "rule.target", "cat"),
        ("pair.distance < 5 m", "rule.target", "pair.distance"),
        ("object.stopped and other.stopped", "rule.target", "other.stopped"),
        ("exists(object.stopped)", "rule.target", "object.stopped"),
        (
            "exists(pair.distance < 5 m and target.gap < 3 m)",
            "rule.target",
            "pair.distance < 5 m and target.gap < 3 m",
        ),
        ("exists(target.gap < 5 m and exists(pair.follows))", "rule.target", "exists(pair.follows)"),
        ("exists(pair.distanc < 5 m)", "rule.signal.unknown", "pair.distanc"),
        ("exists(reverse.distance < 5 s)", "rule.unit.mismatch", "reverse.distance < 5 s"),
        ("count(target.gap < 5 m)", "rule.type", "count(target.gap < 5 m)"),
        ("count(target.gap < 5 m) > 1.5", "rule.type", "1.5"),
        ("count(target.gap < 5 m) > 2 s", "rule.type", "2 s"),
        ("least(target.ttc) < lead.ttc", "rule.type", "lead.ttc"),
        ("least(target.ttc) + 1 s < 3 s", "rule.type", "least(target.ttc)"),
        ("least(target.ttc) < 3 m", "rule.unit.mismatch", "target.ttc) < 3 m"),
        ("first(ego.brake)", "rule.call", "first(ego.brake)"),
        ("obstacle.gap < 5 m", "rule.signal.unknown", "obstacle.gap"),
        ("(ego.brake", "rule.syntax", ""),
        ("ego.brake ego.aeb", "rule.syntax", "ego.aeb"),
        ("ego.speed = 5 m/s", "rule.syntax", "="),
        ("", "rule.syntax", ""),
        ("ego.speed > 1..2 m/s", "rule.syntax", "1..2"),
        // A chain with a fixed value in the middle: its second pair compares two of them.
        ("ego.speed > 10 m/s > 5 m/s", "rule.type", "10 m/s > 5 m/s"),
        ("2 m > 1 m", "rule.type", "2 m > 1 m"),
        ("1 m < 2 s", "rule.unit.mismatch", "1 m < 2 s"),
    ];
    for (text, code, part) in cases {
        let f = fault(text);
        assert_eq!((f.code, &text[f.span.start..f.span.end]), (code, part), "{text}");
    }
    let deep = format!("{}ego.brake{}", "(".repeat(5000), ")".repeat(5000));
    assert_eq!(fault(&deep).code, "rule.syntax", "deep nesting is refused, not a stack overflow");
}

#[test]
fn a_fault_reads_like_rustc() {
    let origin = Location {
        file: Some("scenarios/reactive_agent/cutin.yaml".to_owned()),
        line: Some(40),
        ..Location::default()
    };
    let text = "target.lateral_offset > 0.5 m and ego.sped < 3 m/s";
    insta::assert_snapshot!(render_text(&fault(text).about(text, &origin), Lang::En));
    insta::assert_snapshot!(render_text(&fault(text).about(text, &origin), Lang::Zh));
}

#[test]
fn conditions_are_described_as_data_format_prints_them() {
    // DATA_FORMAT.md 5.2.
    assert_eq!(describe("target_vehicle.lateral_offset   >   0.5 m"), "target_vehicle.lateral_offset > 0.5m");
    assert_eq!(describe("not (ego.brake or ego.aeb)"), "not (ego.brake or ego.aeb)");
}

#[test]
fn a_description_reads_back_as_the_same_program() {
    for text in [
        "abs(target.path_lateral) < band and target.class in {car, bus}",
        "(a_flag or ego.brake) and not ego.aeb for 0.5 s",
        "ego.brake then (ego.speed < 5 km/h for 2 s) within 3 s",
        "-7 m < target.path_lateral <= 7 m",
        "max(ego.speed, 3 s) - 2 * ego.speed > -1.5 m/s",
        "share(ego.brake, 2 s) >= 80 % or ttc is not known",
        "previously(rises(ego.brake), 4 s) within 1 s",
        "ego.brake or ego.aeb for 2 s gaps 0.3 s",
        "ego.brake and ego.aeb since (ego.standstill for 1 s) within 3 s",
        "ego.brake until ego.standstill",
        "count(target_vehicle.gap < band and target.relation == behind) >= 2",
        "exists(target.gap < 5 m, vru) or forall(target.gap > 5 m)",
        "least(target.ttc) < 2 s and target.gap at keyframe > 3 m",
    ] {
        let text = text.replace("a_flag", "ego.standstill");
        let (program, id) = check(&text).unwrap();
        let mut checker = Checker::new(Catalog::bundled());
        let band = Quantity { value: 7.0, unit: Unit::parse("m").unwrap() };
        checker.parameters.insert("band".to_owned(), band);
        let described = checker.describe(&parse::parse(&text).unwrap());
        let again = check(&described).unwrap_or_else(|f| panic!("{described}: {f:?}"));
        assert_eq!((program, id), again, "{text} became {described}");
    }
}

#[test]
fn a_shown_value_is_on_the_side_of_the_threshold_where_the_measured_one_is() {
    let mut checker = Checker::new(Catalog::bundled());
    let mut atom = |text: &str| {
        let expr = parse::parse(text).unwrap();
        checker.condition(&expr).unwrap();
        let mut atoms = Vec::new();
        checker.atoms(&expr, &mut atoms).unwrap();
        atoms.remove(0)
    };
    let shown = |atom: &Atom, base: f64| {
        let value = atom.number(base);
        (value.clone(), atom.value_in_words(&value).unwrap().en)
    };
    let gap = atom("target.gap < 5 m");
    assert_eq!(shown(&gap, 4.97), (4.97.into(), "4.97 m".into()));
    assert_eq!(shown(&gap, 4.998), (4.998.into(), "4.998 m".into()));
    assert_eq!(shown(&gap, 4.999_98), (4.999_98.into(), "4.99998 m".into()));
    assert_eq!(shown(&gap, 5.000_02), (5.000_02.into(), "5.00002 m".into()));
    // Equal but for the last bits.
    assert_eq!(shown(&gap, 5.0 + 1e-12), (5.0.into(), "5 m".into()));
    assert_eq!(shown(&gap, 3.456_78), (3.4568.into(), "3.46 m".into()));
    // In the unit of the rule; angles in radians are shown in degrees.
    let angle = atom("ego.turn_angle > 0.5 rad");
    assert_eq!(shown(&angle, 1.0), (1.0.into(), "57.3°".into()));
    assert_eq!(shown(&atom("ego.speed < 36 km/h"), 9.999), (35.9964.into(), "35.996 km/h".into()));
    // A flag that is compared with false.
    let flag = atom("ego.standstill == false");
    assert_eq!(flag.value_in_words(&false.into()).unwrap().en, "holds");
    assert_eq!(flag.value_in_words(&true.into()).unwrap().en, "does not hold");
}

/// Characters of Chinese keyboards, by their Unicode names.
#[test]
fn characters_of_another_keyboard_have_a_remedy() {
    for (text, at, hint) in [
        ("ego.speed > ３ m/s", 12, "write the half-width character 3"),
        ("（ego.standstill）", 0, "write the half-width character ("),
        ("rises(“ego.standstill”)", 6, "no quotation marks"),
        ("ego.speed in {a、b}", 15, "separated by a comma"),
        ("ego.speed > 1e400 m/s", 12, "1.8e308"),
    ] {
        let found = fault(text);
        assert_eq!((found.code, found.span.start), ("rule.syntax", at), "{text}");
        assert!(found.hint.as_ref().is_some_and(|h| h.en.contains(hint)), "{text}: {found:?}");
    }
}

#[test]
fn conditions_that_exclude_each_other_are_refused() {
    for never in [
        "ego.speed < 0 m/s and ego.speed > 1 m/s",
        "ego.speed > 36 km/h and ego.speed < 10 m/s",
        "5 m/s < ego.speed < 3 m/s",
        "ego.speed == 1 m/s and ego.speed > 1 m/s",
        "ego.accel < -3 m/s2 and (ego.brake and ego.accel > -1 m/s2)",
        "ego.standstill and not ego.standstill",
        "ego.lane_change == left and ego.lane_change == right",
        // Beyond what the number can be: a share of a time, a magnitude, a count, a speed over ground.
        "share(ego.standstill, 3 s) > 50",
        "share(ego.standstill, 3 s) > 1",
        "abs(ego.accel) < 0 m/s2",
        "ego.speed < 0 m/s",
        "-1 km/h >= ego.speed",
        "max(ego.speed, 3 s) < 0 m/s",
        "count(target.gap < 20 m) < 0",
    ] {
        let fault = fault(never);
        assert_eq!(fault.code, "rule.never", "{never}");
        assert!(fault.hint.is_some());
    }
    for possible in [
        "ego.speed < 1 m/s or ego.speed > 2 m/s",
        "ego.speed >= 36 km/h and ego.speed <= 10 m/s",
        "(ego.speed < 1 m/s within 3 s) and ego.speed > 2 m/s",
        "ego.lane_change == left and ego.lane_change in { left, right }",
        "ego.speed != 1 m/s and ego.speed == 2 m/s",
        "share(ego.standstill, 3 s) >= 1",
        "ego.speed <= 0 m/s",
        "ego.forward_speed < 0 m/s",
        "count(target.gap < 20 m) == 0",
        // Where the record begins and ends, as the built-in rules write it.
        "previously(ego.speed < 0 m/s, 2 s) is unknown",
        "(ego.speed < 0 m/s within 2 s) is unknown",
        "min(ego.speed, 3 s) < 1 m/s and ego.speed > 2 m/s",
    ] {
        check(possible).unwrap_or_else(|fault| panic!("{possible}: {fault:?}"));
    }
}
