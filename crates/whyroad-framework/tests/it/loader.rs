//! What the loader says of broken frameworks: every mistake, each with its code and line, and the rest still read.

use std::collections::{BTreeMap, BTreeSet};
use whyroad_framework::codes::{FILES, SPEC, TAXONOMY};
use whyroad_framework::taxonomy::read_taxonomy;
use whyroad_framework::{Framework, FrameworkFiles};
use whyroad_model::{Diagnostic, ScenarioId};

/// One L1, one L2, two leaves; hand-made, correct.
const SMALL: &str = r#"version: "1.0.0"
description: 小例子
description_en: A small example
l1_categories:
  - id: reactive_agent
    name_zh: 交互响应
    name_en: Reactive to Agent
    definition: 动态目标触发
    definition_en: A moving road user
l2_scenarios:
  reactive_agent:
    - id: cutin
      name_zh: 切入
      name_en: Cut-in
      definition: 他车切入
      definition_en: Another vehicle cuts in
      typical_decisions: { longitudinal: [yield_to_agent], lateral: [] }
l3_variants:
  cutin:
    - id: urgent
      name_zh: 紧急
      name_en: Urgent
      definition: 接近快
      definition_en: Closing fast
      condition: TTC < 3s
      condition_en: TTC < 3 s
      decides:
        - { against: reactive_agent.cutin.slow, rule: 看 TTC, rule_en: By TTC }
    - id: slow
      name_zh: 缓慢
      name_en: Slow
      definition: 接近慢
      definition_en: Closing slowly
      condition: TTC >= 3s
      condition_en: TTC >= 3 s
      decides:
        - { against: reactive_agent.cutin.urgent, rule: 看 TTC, rule_en: By TTC }
"#;

const L1_SPEC: &str = r#"version: "1.0.0"
l1: reactive_agent
labeling:
  keyframe:
    type: reactive
    rule: { zh: 外部事件, en: the external event }
    expr: "rises(target.ttc < 5 s)"
    fallback: { rule: { zh: 首次, en: first moment } }
  start: { rule: { zh: 前 2 s, en: 2 s before }, expr: keyframe - 2 s }
  end: { rule: { zh: 后 3 s, en: 3 s after }, expr: keyframe + 3 s }
  pack: { before_s: 3, after_s: 3 }
"#;

const L2_SPEC: &str = r#"version: "1.0.0"
l1: reactive_agent
l2: cutin
labeling:
  keyframe:
    rule: { zh: 越线, en: a wheel crosses the line }
  records:
    - { id: place, name: { zh: 位置, en: place } }
leaves:
  urgent:
    labeling:
      keyframe: { type: proactive }
      start: { expr: keyframe - 1 s }
      records: [{ id: gap, name: { zh: 间距, en: gap }, unit: m }]
      uncertainty: high
      lateral: lane_keeping
    mining: { when: "ttc < 3 s" }
  slow: {}
"#;

fn small() -> BTreeMap<String, String> {
    let mut files = Framework::bundled_files();
    // Its texts of drafts are those of other classes.
    files.retain(|path, _| path.starts_with("schema/") && path != "schema/draft_texts.yaml");
    files.insert("schema/scenario_taxonomy.yaml".into(), SMALL.into());
    files.insert("scenarios/reactive_agent.yaml".into(), L1_SPEC.into());
    files.insert("scenarios/reactive_agent/cutin.yaml".into(), L2_SPEC.into());
    files
}

/// The findings after `from` became `to` in `file`, as `code:line`.
fn findings(file: &str, from: &str, to: &str) -> Vec<Diagnostic> {
    let mut files = small();
    let text = files.get_mut(file).unwrap();
    assert!(text.contains(from), "{from}");
    *text = text.replacen(from, to, 1);
    let mut found = Framework::from_files(&files).1;
    // What a mistake in one of the two classes leaves of their deciding rule is shown by the tests of `agreement`.
    found.retain(|d| d.code != "taxonomy.decides.differs");
    found
}

fn short(found: &[Diagnostic]) -> Vec<String> {
    found.iter().map(|d| format!("{}:{}", d.code, d.location.line.unwrap_or(0))).collect()
}

const T: &str = "schema/scenario_taxonomy.yaml";
const D: &str = "schema/driving_decisions.yaml";
const S1: &str = "scenarios/reactive_agent.yaml";
const S2: &str = "scenarios/reactive_agent/cutin.yaml";

/// File, text, its replacement, the findings with the line where a person would fix it (counted in the texts above;
/// no line where the file is the real one, which may change).
const BROKEN: &[(&str, &str, &str, &[&str])] = &[
    (T, "version: \"1.0.0\"", "version: 1.0", &["taxonomy.version:1"]),
    (T, "l1_categories:", "l1_categories: [", &["taxonomy.yaml:4"]),
    (T, "    name_en: Reactive to Agent\n", "", &["taxonomy.text.untranslated:6"]),
    (T, "      name_zh: 切入\n", "", &["taxonomy.field.missing:12"]),
    (T, "definition: 他车切入", "definition: \"\"", &["taxonomy.text.empty:15"]),
    (
        T,
        "definition_en: Another",
        "defintion_en: Another",
        &["taxonomy.text.untranslated:15", "taxonomy.field.unknown:16"],
    ),
    (
        T,
        "      definition: 接近慢\n      definition_en: Closing slowly\n",
        "",
        &["taxonomy.definition.none:29"],
    ),
    (T, "[yield_to_agent]", "[yield]", &["taxonomy.decision.unknown:17"]),
    (T, "lateral: []", "lateral: none", &["taxonomy.field.type:17"]),
    (
        T,
        "      condition: TTC < 3s\n",
        "      condition: TTC < 3s\n      condition: TTC < 2s\n",
        &["taxonomy.field.duplicate:26"],
    ),
    (
        T,
        "    - id: slow",
        "    - id: urgent",
        &[
            "taxonomy.id.duplicate:29",
            "taxonomy.against.self:37",
            "taxonomy.against.unknown:28",
            "spec.class.unknown:18",
        ],
    ),
    (T, "    - id: slow", "    - id: Slow", &["taxonomy.id.malformed:29"]),
    (
        T,
        "against: reactive_agent.cutin.slow",
        "against: reactive_agent.cutin.urgent",
        &["taxonomy.against.self:28"],
    ),
    (T, "against: reactive_agent.cutin.slow", "against: cutin slow", &["taxonomy.id.malformed:28"]),
    (
        T,
        "  cutin:\n",
        "  cut_in:\n",
        &[
            "taxonomy.parent.unknown:19",
            "taxonomy.children.none:12",
            "spec.class.unknown:10",
            "spec.class.unknown:18",
        ],
    ),
    (
        T,
        "      typical_decisions",
        "      mining_conditions: [a, b]\n      mining_conditions_en: [a]\n      typical_decisions",
        &["taxonomy.conditions.unpaired:18"],
    ),
    (D, "directions: [\"left\", \"right\"]", "directions: [\"left\"]", &["taxonomy.decisions.set"]),
    (D, "id: \"lead_following\"", "id: \"following\"", &["taxonomy.decisions.set", "taxonomy.decisions.set"]),
    (S1, "version: \"1.0.0\"", "version: v1", &["spec.version:1"]),
    (
        S1,
        "pack: { before_s: 3",
        "pack: { before_s: -3",
        &["spec.seconds:11", "spec.incomplete:10", "spec.incomplete:18"],
    ),
    (S1, "    type: reactive", "    type: moment", &["spec.keyframe.type:5", "spec.incomplete:18"]),
    (S1, "en: the external event", "en: ''", &["spec.text.empty:6"]),
    (S1, "l1: reactive_agent\n", "l1: reactive_agent\nleaves: { x: {} }\n", &["spec.field.unknown:3"]),
    (S2, "l2: cutin", "l2: cut_in", &["spec.path:3"]),
    (S2, "leaves:", "leafs:", &["spec.field.missing:1", "spec.field.unknown:9"]),
    (S2, "rule: { zh: 越线, en: a wheel crosses the line }", "rule: 越线", &["spec.field.type:6"]),
    (S2, "l2: cutin\n", "l2: cutin\nl2: cutin\n", &["spec.field.duplicate:4"]),
    (S2, "  slow: {}\n", "", &["spec.class.missing:10"]),
    (S2, "  slow: {}\n", "  slow: {}\n  fast: {}\n", &["spec.class.unknown:19"]),
    (S2, "leaves:\n", "leaves:\n  slow: {}\n", &["spec.field.duplicate:19", "spec.order:10"]),
    (S2, "uncertainty: high", "uncertainty: yes", &["spec.uncertainty.unknown:15"]),
    (S2, "lateral: lane_keeping", "lateral: keep", &["spec.lateral.unknown:16"]),
    (S2, "id: gap", "id: Gap", &["spec.record.id:14"]),
    (S2, "version: \"1.0.0\"", "version: \"1.0.0", &["spec.yaml:1"]),
];

#[test]
fn the_small_framework_is_right() {
    let (framework, found) = Framework::from_files(&small());
    assert_eq!(short(&found), Vec::<String>::new());
    assert_eq!(framework.unwrap().taxonomy.counts(), (1, 1, 2));
}

#[test]
fn each_mistake_is_found_where_it_is() {
    let mut wrong = Vec::new();
    for (file, from, to, expected) in BROKEN {
        let found = findings(file, from, to);
        let mut found_short = short(&found);
        if *file == D {
            found_short.iter_mut().for_each(|s| s.truncate(s.find(':').unwrap_or(s.len())));
        }
        let mut sorted: Vec<&str> = found_short.iter().map(String::as_str).collect();
        sorted.sort_unstable();
        let mut expected = expected.to_vec();
        expected.sort_unstable();
        if sorted != expected {
            wrong.push(format!("{file}: {from:?} -> {to:?}: found {sorted:?}, expected {expected:?}"));
        }
        for d in &found {
            assert!(!d.message.zh.is_empty() && !d.message.en.is_empty());
            assert!(TAXONOMY.contains(&d.code) || SPEC.contains(&d.code), "'{}' is not listed", d.code);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_leaf_without_an_entry_is_told_which_one_to_add() {
    let hint = |from: &str| findings(S2, from, "")[0].hint.as_ref().unwrap().en.clone();
    assert!(hint("  slow: {}\n").starts_with("add `slow: {}` to 'leaves', after 'urgent';"));
}

#[test]
fn every_code_of_the_loader_is_shown_by_a_mistake() {
    let mut shown: BTreeSet<&str> =
        BROKEN.iter().flat_map(|b| b.3.iter().map(|s| s.split(':').next().unwrap())).collect();
    // Shown by the tests below and by those of the lint and the command line.
    shown.extend(["taxonomy.file.missing", "spec.file.missing", "taxonomy.generated.stale"]);
    shown.extend(["taxonomy.class.unknown", "taxonomy.class.ambiguous"]);
    // Shown by the tests of `decision_table` and `record_types`.
    shown.extend(["spec.decisions", "spec.record_types", "spec.record.type"]);
    // Shown by those of `taxonomy::agreement`.
    shown.extend(["taxonomy.decides.differs", "taxonomy.text.class"]);
    let missing: Vec<_> = TAXONOMY
        .iter()
        .chain(SPEC)
        .filter(|c| !shown.contains(**c) && !c.starts_with("taxonomy.md."))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn several_mistakes_are_all_reported_and_the_rest_is_read() {
    let text = SMALL
        .replace("\"1.0.0\"", "\"one\"")
        .replace("[yield_to_agent]", "[yeild_to_agent]")
        .replace("against: reactive_agent.cutin.slow", "against: reactive_agent.cutin.slwo")
        .replace("      condition_en: TTC >= 3 s\n", "");
    let (taxonomy, found) = read_taxonomy("t.yaml", &text);
    let mut codes: Vec<&str> = found.iter().map(|d| d.code).collect();
    codes.sort_unstable();
    assert_eq!(
        codes,
        [
            "taxonomy.against.unknown",
            "taxonomy.decides.differs",
            "taxonomy.decision.unknown",
            "taxonomy.text.untranslated",
            "taxonomy.version"
        ]
    );
    assert_eq!(taxonomy.unwrap().counts(), (1, 1, 2));
    let hint = |code: &str| found.iter().find(|d| d.code == code).unwrap().hint.clone().unwrap().en;
    assert_eq!(hint("taxonomy.against.unknown"), "did you mean 'reactive_agent.cutin.slow'?");
    assert_eq!(hint("taxonomy.decision.unknown"), "did you mean 'yield_to_agent'?");
}

/// Text of a class that does not exist is never used; the position is counted in the text.
#[test]
fn texts_of_drafts_for_no_class_are_reported() {
    let mut files = Framework::bundled_files();
    let text = files.get_mut("schema/draft_texts.yaml").unwrap();
    let at = text.find("  reactive_agent.cutin.urgent:").unwrap();
    let line = text[..at].matches('\n').count() + 1;
    *text = text.replacen("  reactive_agent.cutin.urgent:", "  reactive_agent.cutin.urgnt:", 1);
    let found = Framework::from_files(&files).1;
    assert_eq!(short(&found), [format!("lexicon.class:{line}")]);
    assert_eq!(found[0].hint.as_ref().unwrap().en, "did you mean 'reactive_agent.cutin.urgent'?");
}

/// "跟车" in GB18030 (0xB8FA 0xB3B5): 0xB8 cannot begin a character in UTF-8. Bytes and columns are counted by hand.
#[test]
fn a_file_in_another_encoding_costs_that_file_only() {
    let texts = small();
    let mut files = FrameworkFiles::default();
    for (path, text) in &texts {
        let bytes = if path == S2 {
            b"version: 1\nname: \xB8\xFA\xB3\xB5\n".to_vec()
        } else {
            text.clone().into_bytes()
        };
        files.add(path.clone(), bytes);
    }
    let (framework, found) = files.load();
    assert_eq!(short(&found), ["framework.encoding:2"], "not also missing");
    assert_eq!((found[0].location.column, found[0].location.snippet.as_deref()), (Some(7), Some("name: ")));
    assert!(found[0].message.en.contains("byte 18 (0xB8)") && found[0].message.zh.contains("第 18 字节"));
    let hint = found[0].hint.as_ref().unwrap();
    assert!(hint.en.contains("save it as UTF-8") && hint.zh.contains("另存为 UTF-8"));
    let framework = framework.unwrap();
    assert_eq!(framework.l1_specs.len(), 1, "the other files are read");
    let without: BTreeMap<_, _> = texts.into_iter().filter(|(path, _)| path != S2).collect();
    assert_eq!(framework.specs.len(), Framework::from_files(&without).0.unwrap().specs.len());
    assert!(FILES.contains(&found[0].code));
}

#[test]
fn a_repeated_id_names_the_line_of_the_first() {
    let text = SMALL.replacen("id: slow", "id: urgent", 1);
    let first = SMALL[..SMALL.find("id: urgent").unwrap()].matches('\n').count() + 1;
    let found = read_taxonomy("t.yaml", &text).1;
    let repeated = found.iter().find(|d| d.code == "taxonomy.id.duplicate").unwrap();
    assert!(repeated.message.en.contains(&format!("first on line {first}")), "{repeated:?}");
    assert!(repeated.message.zh.contains(&format!("第 {first} 行")), "{repeated:?}");
}

#[test]
fn missing_files_are_named() {
    for path in ["schema/driving_decisions.yaml", S1, S2] {
        let mut files = small();
        files.remove(path);
        let (framework, found) = Framework::from_files(&files);
        assert!(framework.is_some());
        let named: Vec<_> = found.iter().filter(|d| d.code.ends_with(".file.missing")).collect();
        assert_eq!(named.len(), 1, "{path}");
        assert!(named[0].message.en.contains(path));
    }
    let (none, found) = Framework::from_files(&BTreeMap::new());
    assert!(none.is_none());
    assert_eq!(short(&found), ["taxonomy.file.missing:0"]);
}

#[test]
fn a_leaf_inherits_field_by_field() {
    // By hand from L1_SPEC, L2_SPEC and the rules in `spec/inherit.rs`.
    let f = Framework::from_files(&small()).0.unwrap();
    let spec = |leaf: &str| f.specs.get(&ScenarioId::leaf("reactive_agent", "cutin", leaf)).unwrap().clone();
    let slow = spec("slow");
    assert_eq!(slow.keyframe.rule.en, "a wheel crosses the line");
    // The L2 restated the rule, so the L1's expression, which says something else, is gone; the fallback stays.
    assert_eq!(slow.keyframe.expr, None);
    assert!(slow.keyframe.fallback.is_some());
    assert_eq!(slow.start.expr.as_deref(), Some("keyframe - 2 s"));
    assert_eq!(slow.records.iter().map(|r| r.id.as_str()).collect::<Vec<_>>(), ["place"]);
    assert!(!slow.uncertainty_high && slow.lateral.is_none());

    let urgent = spec("urgent");
    assert_eq!(urgent.keyframe.kind.id(), "proactive");
    // The type changed: a moment's fallback does not serve a range.
    assert!(urgent.keyframe.fallback.is_none());
    // Only the expression was given: it goes with the inherited words.
    assert_eq!(
        (urgent.start.rule.en.as_str(), urgent.start.expr.as_deref()),
        ("2 s before", Some("keyframe - 1 s"))
    );
    assert_eq!(urgent.records.iter().map(|r| r.id.as_str()).collect::<Vec<_>>(), ["place", "gap"]);
    assert!(urgent.uncertainty_high);
    assert_eq!(urgent.lateral.map(|l| l.id()), Some("lane_keeping"));

    assert_eq!(f.rules.len(), 1);
    assert_eq!((f.rules[0].file.as_str(), f.rules[0].mark.line), (S2, 17));
    assert_eq!(f.rules[0].rule.get("when").and_then(|w| w.text()), Some("ttc < 3 s"));
}

#[test]
fn every_code_has_a_page_in_both_languages() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/diagnostics");
    for code in TAXONOMY.iter().chain(SPEC).chain(FILES) {
        let page = std::fs::read_to_string(folder.join(format!("{code}.md"))).unwrap_or_default();
        assert!(page.starts_with(&format!("# {code}\n")), "docs/diagnostics/{code}.md");
        assert!(page.contains("\n## 中文\n"), "{code}: no Chinese section");
    }
    for entry in std::fs::read_dir(folder).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let code = name.trim_end_matches(".md");
        if code.starts_with("taxonomy.") || code.starts_with("spec.") || code.starts_with("framework.") {
            assert!(
                TAXONOMY.contains(&code) || SPEC.contains(&code) || FILES.contains(&code),
                "a page for '{code}', which nothing emits"
            );
        }
    }
}
