//! Names that a rule gives: each means one thing, and reading a rule always ends. And nesting beyond sense is refused,
//! in a rule's text as in what its definitions add up to. Expected: docs/reference/rules.md, "Names".

use std::fmt::Write as _;
use whyroad_framework::Framework;
use whyroad_mining::RuleSet;
use whyroad_mining::rule::file::check_file;
use whyroad_mining::rule::lint::lint;
use whyroad_mining::rule::origin::SourceFile;
use whyroad_mining::rule::query::{compile_query, parse_query};
use whyroad_mining::rule::text::compile_text;
use whyroad_model::diagnostic::Severity;
use whyroad_model::{Diagnostic, ScenarioId};
use whyroad_signals::Catalog;

fn check(text: &str) -> Vec<Diagnostic> {
    let file = SourceFile { name: "mine.yaml", text };
    check_file(file, None, &Framework::bundled_files(), Catalog::bundled()).found
}

/// Code and marked text of each fault.
fn faults(text: &str) -> Vec<(&'static str, String)> {
    let marked = |d: &Diagnostic| {
        let line = d.location.snippet.clone().unwrap_or_default();
        line.chars().skip(d.location.column.unwrap_or(1) - 1).take(d.location.span).collect()
    };
    check(text).iter().map(|d| (d.code, marked(d))).collect()
}

/// What people are shown of a condition has no ids and no operators of the rule language: docs/reference/rules.md,
/// "Names for people".
#[test]
fn no_condition_that_people_are_shown_has_syntax() {
    let (rules, found) = RuleSet::of_framework(Framework::bundled(), Catalog::bundled());
    assert!(found.is_empty(), "{found:?}");
    let mut count = 0;
    for rule in &rules.rules {
        let parts = rule.parts.iter().map(|p| (&p.text, &p.words));
        for (text, words) in rule.atoms.iter().map(|a| (&a.text, &a.words)).chain(parts) {
            count += 1;
            for said in [&words.zh, &words.en] {
                assert!(!said.is_empty(), "{text}");
                for syntax in ["_", "==", "<=", ">=", "!=", "{", "abs(", "previously(", "exists("] {
                    assert!(!said.contains(syntax), "{}: {text}: {said}", rule.scenario);
                }
                let dotted =
                    said.split(|c: char| c.is_whitespace()).any(|w| Catalog::bundled().get(w).is_some());
                assert!(!dotted, "{}: {text}: {said}", rule.scenario);
            }
        }
    }
    assert!(count > 2000, "{count}");
}

#[test]
fn a_long_definition_without_a_name_is_noted_and_a_name_of_nothing_is_a_fault() {
    let mut files = Framework::bundled_files();
    let text = files.get_mut("scenarios/reactive_road/blind_spot_slowdown.yaml").unwrap();
    let name = "    seen_crossing: { zh: 有可见的横穿车辆, en: a crossing vehicle is seen }\n";
    assert_eq!(text.matches(name).count(), 1);
    *text = text.replace(name, "");
    let noted = lint(&Framework::from_files(&files).0.unwrap(), Catalog::bundled());
    let [note] = noted.as_slice() else { panic!("{noted:?}") };
    assert_eq!((note.code, note.severity), ("rule.words", Severity::Note));
    let line = note.location.snippet.clone().unwrap();
    assert!(line.trim_start().starts_with("seen_crossing:"), "{line}");

    let rule = "mining:\n  define: { fast: \"ego.speed > 20 m/s\" }\n  names: { fsat: { zh: 快, en: fast } }\n  when: fast\n";
    assert_eq!(faults(rule), [("rule.name", "fsat".to_owned())]);
    let rule =
        "mining:\n  define: { fast: \"ego.speed > 20 m/s\" }\n  names: { fast: { zh: 快 } }\n  when: fast\n";
    assert_eq!(faults(rule), [("rule.block", "fast".to_owned())]);
}

#[test]
fn a_leaf_that_writes_a_definition_in_another_way_does_not_inherit_its_name() {
    let mut files = Framework::bundled_files();
    let text = files.get_mut("scenarios/reactive_agent/cutin.yaml").unwrap();
    let at = "      define:\n        rolls:";
    assert_eq!(text.matches(at).count(), 1);
    *text = text.replace(at, "      define:\n        over_the_line: \"target.wheel_over_line and ego.speed < 1 m/s within 2 s\"\n        rolls:");
    let (rules, found) = RuleSet::of_framework(&Framework::from_files(&files).0.unwrap(), Catalog::bundled());
    assert!(found.is_empty(), "{found:?}");
    let words = |leaf: &str| {
        let rule = rules.rules.iter().find(|r| r.scenario.to_string() == leaf).unwrap();
        rule.parts.iter().map(|p| p.words.en.clone()).collect::<Vec<_>>()
    };
    let own = "Within the next 2 s: (the target is over the ego's lane line and speed of the ego < 1 m/s)";
    assert!(
        words("reactive_agent.cutin.congestion").iter().any(|w| w == own),
        "{:?}",
        words("reactive_agent.cutin.congestion")
    );
    assert!(words("reactive_agent.cutin.urgent").iter().all(|w| w != own));
}

#[test]
fn a_name_means_one_thing() {
    let target = "target: vehicle\n";
    let cases = [
        // The value of a category that the definition itself asks for: this once ran until the stack was full.
        ("define:\n  across: \"target.moves_along == across\"\nwhen: \"across\"\n", vec!["across"]),
        ("define:\n  across: \"target.moves_along in {still, across}\"\nwhen: \"across\"\n", vec!["across"]),
        // The same by way of another definition, in either order.
        (
            "define:\n  still: \"target.speed < 1 m/s\"\n  slow: \"target.moves_along == still\"\nwhen: \"slow\"\n",
            vec!["still"],
        ),
        (
            "define:\n  slow: \"target.moves_along == still\"\n  still: \"slow and target.speed < 1 m/s\"\nwhen: \"still\"\n",
            vec!["still"],
        ),
        ("define:\n  slow: \"not slow\"\nwhen: \"target.gap < 3 m\"\n", vec!["slow"]),
        ("define:\n  ttc: \"target.gap < 3 m\"\nwhen: \"target.gap < 3 m\"\n", vec!["ttc"]),
        ("define:\n  keyframe: \"target.gap < 3 m\"\nwhen: \"target.gap < 3 m\"\n", vec!["keyframe"]),
        (
            "parameters:\n  near: { value: 3 m, reason: a test }\ndefine:\n  near: \"target.gap < 3 m\"\nwhen: \"target.gap < near\"\n",
            vec!["near"],
        ),
        (
            "parameters:\n  left: { value: 3 m, reason: a test }\nwhen: \"target.gap < left and target.side == left\"\n",
            vec!["left"],
        ),
    ];
    for (text, expected) in cases {
        let found = faults(&format!("{target}{text}"));
        let expected: Vec<_> = expected.into_iter().map(|w| ("rule.name", w.to_owned())).collect();
        assert_eq!(found, expected, "{text}");
    }
    // Other names for the same are fine.
    let fine = "define:\n  sideways: \"target.moves_along == across\"\nwhen: \"sideways\"\n";
    assert_eq!(faults(&format!("{target}{fine}")), []);
}

fn one_line(text: &str) -> Option<&'static str> {
    let class: ScenarioId = "proactive.turn.straight".parse().unwrap();
    compile_text(text, None, &class, Catalog::bundled(), "--rule").err().map(|d| d.code)
}

#[test]
fn nesting_beyond_sense_is_refused() {
    let slow = "ego.speed < 3 m/s";
    let within = |open: &str, close: &str, n: usize| format!("{}{slow}{}", open.repeat(n), close.repeat(n));
    for (open, close, few) in [
        ("(", ")", 40),
        ("not ", "", 60),
        ("rises(", ")", 40),
        ("", " for 1 s", 60),
        ("previously(", ")", 40),
    ] {
        assert_eq!(one_line(&within(open, close, few)), None, "{open}..{close}");
        for many in [300, 3_000, 200_000] {
            assert_eq!(one_line(&within(open, close, many)), Some("rule.syntax"), "{many} {open}..{close}");
        }
    }
    let minus = format!("{}ego.speed < 3 m/s", "-".repeat(100_000));
    let sum = format!("ego.speed{} < 3 m/s", " + ego.speed".repeat(100_000));
    let then = format!("{slow}{}", format!(" then {slow} within 1 s").repeat(100_000));
    for text in [minus, sum, then] {
        assert_eq!(one_line(&text), Some("rule.syntax"));
    }
    // A conjunction is as long as one likes, within reason.
    assert_eq!(one_line(&vec![slow; 100].join(" and ")), None);
}

#[test]
fn definitions_do_not_add_up_to_what_is_refused() {
    // Each names the one before: as deep as there are definitions.
    let chain = |n: usize, of: &dyn Fn(usize) -> String| {
        let mut text = "define:\n  d0: \"ego.speed < 3 m/s\"\n".to_owned();
        (1..n).for_each(|i| writeln!(text, "  d{i}: \"{}\"", of(i - 1)).unwrap());
        writeln!(text, "when: \"d{}\"", n - 1).unwrap();
        check(&text)
    };
    let deep = |i: usize| format!("not d{i}");
    assert_eq!(chain(40, &deep), vec![]);
    assert_eq!(chain(400, &deep)[0].code, "rule.syntax");
    let alias = |i: usize| format!("d{i}");
    assert_eq!(chain(400, &alias)[0].code, "rule.syntax");
    // Each names the one before twice: two to the power of the number of definitions.
    let doubled = |i: usize| format!("d{i} or d{i}");
    assert_eq!(chain(10, &doubled), vec![]);
    assert_eq!(chain(80, &doubled)[0].code, "rule.syntax");
}

#[test]
fn a_query_is_not_nested_beyond_sense_either() {
    let query = |n: usize| {
        let inner = r#"{"field": "ttc", "operator": "<", "value": 5, "unit": "s"}"#;
        let clause = format!("{}{inner}{}", r#"{"not": "#.repeat(n), "}".repeat(n));
        format!(
            r#"{{"mining_query": {{"scenario_id": "reactive_agent.cutin", "conditions": [{clause}], "output_limit": 3}}}}"#
        )
    };
    let found = |n: usize| {
        let text = query(n);
        match parse_query(&text, "q.json", Framework::bundled()) {
            Err(found) => found.len(),
            Ok(q) => compile_query(&q, Catalog::bundled(), &text, "q.json").err().unwrap_or_default().len(),
        }
    };
    assert_eq!(found(20), 0);
    assert!(found(95) > 0 || found(200) > 0);
    assert_eq!(found(100_000), 1);
}
