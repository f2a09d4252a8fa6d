//! Whatever the text, readers answer: nobody's typing error ends the program. Texts are random, made of the readers'
//! own words in random order, or sound ones with a random part replaced.

use proptest::prelude::*;
use std::collections::BTreeMap;
use std::sync::LazyLock;
use whyroad_framework::Framework;
use whyroad_framework::taxonomy::read_taxonomy;
use whyroad_label::check::Checker;
use whyroad_mining::rule::file::check_file;
use whyroad_mining::rule::origin::SourceFile;
use whyroad_mining::rule::query::{compile_query, parse_query};
use whyroad_mining::rule::text::compile_text;
use whyroad_mining::{Rule, RuleSet, mine_drive};
use whyroad_model::{Diagnostic, Lang, Nanos, ScenarioId, SignalTable, diagnostic};
use whyroad_signals::Catalog;

static FILES: LazyLock<BTreeMap<String, String>> = LazyLock::new(Framework::bundled_files);

/// What is found can be printed, with its location.
fn printed(found: &[Diagnostic]) {
    for d in found {
        assert!(
            !diagnostic::render_text(d, Lang::En).is_empty()
                && !diagnostic::render_text(d, Lang::Zh).is_empty()
        );
    }
}

const WORDS: &[&str] = &[
    "and",
    "or",
    "not",
    "in",
    "is",
    "for",
    "within",
    "then",
    "at",
    "since",
    "until",
    "known",
    "keyframe",
    "gaps",
    "(",
    ")",
    "{",
    "}",
    ",",
    "<",
    "<=",
    "==",
    "!=",
    ">",
    "+",
    "-",
    "*",
    "1 s",
    "0.5 m",
    "3",
    "60 km/h",
    "1/m",
    "%",
    "ego.speed",
    "ego.standstill",
    "target.gap",
    "target_vru.gap",
    "target.moves_along",
    "across",
    "left",
    "rises",
    "count",
    "exists",
    "least",
    "greatest",
    "share",
    "min",
    "previously",
    "true",
    "ego",
    ".",
    "\"",
    "速度",
    "≤",
    "1e",
    "9e999",
    "\n",
    "first",
];

fn of_words() -> impl Strategy<Value = String> {
    prop::collection::vec(prop::sample::select(WORDS), 0..24).prop_map(|w| w.join(" "))
}

fn any_text() -> impl Strategy<Value = String> {
    prop_oneof![3 => of_words(), 1 => "\\PC{0,80}", 1 => any::<String>()]
}

/// Replaces the part from `at` of `len` characters.
fn spliced(text: &str, at: prop::sample::Index, len: usize, by: &str) -> String {
    let from = at.index(text.chars().count() + 1);
    text.chars().take(from).chain(by.chars()).chain(text.chars().skip(from + len)).collect()
}

fn splice() -> impl Strategy<Value = (prop::sample::Index, usize, String)> {
    (any::<prop::sample::Index>(), 0usize..60, prop_oneof![any_text(), "[\\[\\]{}\",:0-9a-z\\\\u-]{0,6}"])
}

/// A rule that could be made can be run.
fn run(rule: Rule) {
    let times = (0..20).map(|i| Nanos(i * 100_000_000)).collect();
    let table = SignalTable { times, ..SignalTable::default() };
    let rules = RuleSet { rules: vec![rule], ..RuleSet::default() };
    assert_eq!(
        mine_drive(&rules, &table).episodes.len(),
        whyroad_mining::fast::mine_drive(&rules, &table).episodes.len()
    );
}

const QUERY: &str = r#"{"mining_query": {"scenario_id": "reactive_agent.cutin", "conditions": [
  {"field": "target_vehicle.lateral_offset", "operator": ">", "value": 0.5, "unit": "m"},
  {"any": [{"rule": "rises(ego.standstill)"}, {"not": {"field": "ttc", "operator": "<", "value": 5, "unit": "s"}}]},
  {"temporal": "within", "seconds": 3, "condition": {"rule": "target.moves_along in {across}"}}],
  "time_constraints": {"condition_duration_min": 0.5, "condition_duration_max": null}, "output_limit": 1000}}"#;

const LABEL: &str = include_str!("../../../../examples/cutin_urgent_example.en.json");

fn query(text: &str) {
    match parse_query(text, "q.json", Framework::bundled()) {
        Err(found) => printed(&found),
        Ok(q) => match compile_query(&q, Catalog::bundled(), text, "q.json") {
            Err(found) => printed(&found),
            Ok(rule) => rule.into_iter().for_each(run),
        },
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn a_rule_in_one_line(text in any_text()) {
        let class: ScenarioId = "proactive.turn.straight".parse().unwrap();
        match compile_text(&text, None, &class, Catalog::bundled(), "--rule") {
            Err(d) => printed(&[*d]),
            Ok(rule) => run(rule),
        }
    }

    #[test]
    fn a_query(text in prop_oneof![any::<String>(), any_text()], (at, len, by) in splice()) {
        query(&text);
        query(&spliced(QUERY, at, len, &by));
    }

    #[test]
    fn a_label(text in prop_oneof![any::<String>(), any_text()], (at, len, by) in splice()) {
        let checker = Checker::new(Framework::bundled());
        printed(&checker.check_text(&text));
        printed(&checker.check_text(&spliced(LABEL, at, len, &by)));
    }
}

proptest! {
    // A whole framework is read each time.
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn a_file_of_rules(text in any_text(), (at, len, by) in splice()) {
        let check = |text: &str| printed(&check_file(SourceFile { name: "mine.yaml", text }, None, &FILES, Catalog::bundled()).found);
        check(&text);
        check(&format!("target: any\nwhen: {text}\n"));
        check(&spliced(&FILES["scenarios/reactive_agent/cutin.yaml"], at, len, &by));
    }

    #[test]
    fn a_taxonomy(text in any_text(), (at, len, by) in splice(), file in any::<prop::sample::Index>()) {
        let yaml = &FILES["schema/scenario_taxonomy.yaml"];
        for text in [text, spliced(yaml, at, len, &by)] {
            let (taxonomy, found) = read_taxonomy("schema/scenario_taxonomy.yaml", &text);
            prop_assert!(taxonomy.is_some() || !found.is_empty());
            printed(&found);
        }
        let mut files = FILES.clone();
        let name = file.get(&files.keys().cloned().collect::<Vec<_>>()).clone();
        let changed = spliced(&files[&name], at, len, &by);
        files.insert(name, changed);
        printed(&Framework::from_files(&files).1);
    }
}
