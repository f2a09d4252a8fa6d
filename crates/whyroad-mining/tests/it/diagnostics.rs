//! Every code has its page, in both languages; and what a person sees when a rule or a query is wrong.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;
use whyroad_framework::Framework;
use whyroad_mining::rule::query::{compile_query, parse_query};
use whyroad_mining::{CODES, RuleSet};
use whyroad_model::{Diagnostic, Lang, diagnostic};
use whyroad_signals::Catalog;

#[test]
fn every_code_has_its_page() {
    let pages = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/diagnostics");
    for code in CODES {
        let page = std::fs::read_to_string(pages.join(format!("{code}.md"))).unwrap_or_default();
        assert!(page.starts_with(&format!("# {code}\n")) && page.contains("\n## 中文\n"), "{code}");
    }
}

/// The built-in framework with one file changed.
fn faults(file: &str, from: &str, to: &str) -> Vec<Diagnostic> {
    let mut files = Framework::bundled_files();
    let text = files.get_mut(file).unwrap();
    assert!(text.contains(from), "{from}");
    *text = text.replacen(from, to, 1);
    let (framework, found) = Framework::from_files(&files);
    assert!(found.is_empty(), "{found:?}");
    RuleSet::of_framework(&framework.unwrap(), Catalog::bundled()).1
}

const CUTIN: &str = "scenarios/reactive_agent/cutin.yaml";

#[test]
fn a_wrong_rule_is_shown_where_it_stands() {
    let cases = [
        (CUTIN, "target.wheel_over_line and", "target.weel_over_line and", "rule.signal.unknown"),
        (CUTIN, "target.speed > moving", "target.speed > 3 s", "rule.unit.mismatch"),
        (CUTIN, "for briefly) within settle", "for briefly) within inward", "rule.unit.mismatch"),
        (CUTIN, "value: 50 m,", "value: 50 metres,", "rule.unit.unknown"),
        (CUTIN, "reason: \"TAXONOMY.md, cutin.urgent\"", "reason: \"\"", "rule.block"),
        (CUTIN, "  merge_gap: 2 s\n", "  merge_gap: 2 m\n", "rule.unit.mismatch"),
        (CUTIN, "  min_duration: 0.2 s\n", "  min_duration: 2 s\n  max_duration: 1 s\n", "rule.block"),
        (CUTIN, "is_near: \"target", "is_near: \"concerns or target", "rule.name"),
        (CUTIN, "  merge_gap: 2 s\n", "  mergegap: 2 s\n", "rule.block"),
        (CUTIN, "      target: large_vehicle", "      target: lorry", "rule.target"),
        (
            CUTIN,
            "target.turn_signal in {left, right}",
            "target.turn_signal in {left, rigt}",
            "rule.member.unknown",
        ),
        (
            CUTIN,
            "expr: \"rises(target.wheel_over_line)\"",
            "expr: \"rise(target.wheel_over_line)\"",
            "rule.call",
        ),
        (
            "scenarios/proactive/lane_change.yaml",
            "lane_change in {left, right} and",
            "lane_change in {left, right and",
            "rule.syntax",
        ),
        ("schema/precedence.yaml", "- safety.aeb", "- safety.aebs", "rule.precedence"),
        ("schema/precedence.yaml", "neighbourhood: 1 s", "neighbourhood: soon", "rule.precedence"),
    ];
    for (file, from, to, code) in cases {
        let found = faults(file, from, to);
        let text: String = found.iter().map(|d| diagnostic::render_text(d, Lang::En)).collect();
        assert!(!found.is_empty() && found.iter().all(|d| d.code == code), "{from} -> {to}: {text}");
        assert!(found.iter().all(|d| d.location.file.as_deref() == Some(file)), "{text}");
    }
}

#[test]
fn the_line_and_column_are_those_of_the_file() {
    let found = faults(CUTIN, "target.wheel_over_line and", "target.weel_over_line and");
    let text = &Framework::bundled_files()[CUTIN];
    let line = text.lines().position(|l| l.contains("enters: ")).unwrap();
    let column = text.lines().nth(line).unwrap().find("target.wheel_over_line").unwrap() + 1;
    // One fault, although three leaves inherit it.
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((found[0].location.line, found[0].location.column), (Some(line + 1), Some(column)));
}

/// DATA_FORMAT.md 5.1, as printed there.
const PRINTED: &str = r#"{
  "mining_query": {
    "scenario_id": "reactive_agent.cutin",
    "conditions": [
      { "field": "target_vehicle.lateral_offset", "operator": ">", "value": 0.5, "unit": "m" },
      { "field": "ttc", "operator": "<", "value": 5, "unit": "s" }
    ],
    "time_constraints": {
      "condition_duration_min": 0.5,
      "condition_duration_max": null
    },
    "output_limit": 1000
  }
}"#;

fn query_faults(text: &str) -> String {
    let found = match parse_query(text, "query.json", Framework::bundled()) {
        Err(found) => found,
        Ok(q) => compile_query(&q, Catalog::bundled(), text, "query.json").err().unwrap_or_default(),
    };
    found.iter().map(|d| diagnostic::render_text(d, Lang::En)).collect()
}

#[test]
fn the_printed_query_is_a_rule() {
    let query = parse_query(PRINTED, "query.json", Framework::bundled()).unwrap();
    let rule = compile_query(&query, Catalog::bundled(), PRINTED, "query.json").unwrap().unwrap();
    let texts: Vec<&str> = rule.atoms.iter().map(|a| a.text.as_str()).collect();
    // The first is printed in DATA_FORMAT.md 5.2.
    assert_eq!(texts, ["target_vehicle.lateral_offset > 0.5m", "ttc < 5s"]);
    assert_eq!(rule.min_duration.0, 500_000_000);
    assert_eq!(rule.max_duration, None);
}

#[test]
fn a_wrong_query_says_what_and_where() {
    let wrong = |from: &str, to: &str| {
        assert!(PRINTED.contains(from), "{from}");
        query_faults(&PRINTED.replacen(from, to, 1))
    };
    insta::assert_snapshot!(
        [
            wrong("target_vehicle.lateral_offset", "target_vehicle.lateral_ofset"),
            wrong("\"unit\": \"s\"", "\"unit\": \"m\""),
            wrong("\"unit\": \"s\"", "\"unit\": \"sec\""),
            wrong("\"value\": 5", "\"value\": [5]"),
            wrong("reactive_agent.cutin", "reactive_agent.cutn"),
            wrong("\"operator\": \"<\"", "\"operator\": \"~\""),
            wrong("0.5,\n", "-1,\n"),
        ]
        .join("\n")
    );
}
