//! The two paths agree, every accepted document can be read with the shared types, and every code has its page.

use super::*;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::sync::OnceLock;
use whyroad_model::messages as typed;

const EXAMPLES: &[&str] = &[
    include_str!("../../../../examples/cutin_urgent_example.json"),
    include_str!("../../../../examples/cutin_urgent_example.en.json"),
    include_str!("../../../../examples/lane_change_example.json"),
    include_str!("../../../../examples/vru_crossing_example.json"),
    include_str!("../../../../examples/blind_spot_example.json"),
];

fn checker() -> &'static Checker<'static> {
    static CHECKER: OnceLock<Checker<'static>> = OnceLock::new();
    CHECKER.get_or_init(|| Checker::new(Framework::bundled()))
}

fn known(code: &str) -> bool {
    CODES.iter().chain(whyroad_framework::check::CODES).any(|c| *c == code)
}

/// Findings of the slow path alone.
fn slowly(text: &str) -> (Verdict, Vec<Diagnostic>) {
    let mut out = Vec::new();
    let verdict = checker().explain(text, None, &Origin::start(), &mut out);
    (verdict, out)
}

#[test]
fn the_examples_take_the_fast_path() {
    for text in EXAMPLES {
        assert!(checker().is_clean_label(text), "{:#?}", checker().check_text(text));
        assert_eq!(slowly(text).1, []);
    }
}

/// All pointers of a value, except its own.
fn pointers(v: &Value, at: &str, out: &mut Vec<String>) {
    match v {
        Value::Object(o) => {
            for (k, v) in o {
                out.push(format!("{at}/{k}"));
                pointers(v, &format!("{at}/{k}"), out);
            }
        }
        Value::Array(a) => {
            for (i, v) in a.iter().enumerate() {
                out.push(format!("{at}/{i}"));
                pointers(v, &format!("{at}/{i}"), out);
            }
        }
        _ => {}
    }
}

/// Values that labels have, and values that they must not have.
fn values() -> Vec<Value> {
    let mut all: Vec<Value> = serde_json::from_value(json!([
        null, true, 0, -1, 94, 94.5, 200, 4_294_967_296_u64, 1e300, "", " ", "x", "left", "right", "uturn", "high", "low",
        "reactive", "proactive", "yield_to_agent", "gap_matching", "resume", "lane_change", "lane_keeping", "turn",
        "in_lane_nudge", "lane_chang", "reactive_agent", "proactive", "cutin", "urgent", "slow", "crosswalk", "other",
        "reactive_agent.cutin.urgent", "2.0.0", "2.1.0", "2.2.0", "3.0.0", "v2", "2026-01-15T10:30:09.400Z",
        "2026-01-15T18:30:09.4+08:00", "2026-01-15T10:30:15.000Z", "2026-01-15 10:30:09Z", "2026-01-15T10:30:09",
        "前方行人横穿，因此加速通过路口，继续向前行驶。", "前方行人横穿，速度较慢，因此减速让行，保持车道居中。", "减速",
        [], {}, [1], {"a": 1}, {"reactive": null}, {"description": "x", "uncertainty": "high"}
    ]))
    .unwrap();
    all.push(json!("yield_to_agent"));
    all
}

#[derive(Clone, Debug)]
enum Edit {
    Set(prop::sample::Index, prop::sample::Index),
    Remove(prop::sample::Index),
    Add(prop::sample::Index, &'static str, prop::sample::Index),
    Splice(prop::sample::Index, usize, &'static str),
}

fn edit() -> impl Strategy<Value = Edit> {
    let key = prop::sample::select(vec![
        "l3",
        "range_start",
        "range_end",
        "lateral_direction",
        "records",
        "version",
        "extra",
        "uncertainty",
    ]);
    let piece = prop::sample::select(vec![
        "",
        "\"",
        ",",
        "{",
        "}",
        ":",
        "0",
        "\\u4e2d",
        "\\n",
        " ",
        "\"l1\":\"x\",",
        "\t",
        "\u{0}",
    ]);
    prop_oneof![
        4 => (any::<prop::sample::Index>(), any::<prop::sample::Index>()).prop_map(|(a, b)| Edit::Set(a, b)),
        2 => any::<prop::sample::Index>().prop_map(Edit::Remove),
        3 => (any::<prop::sample::Index>(), key, any::<prop::sample::Index>()).prop_map(|(a, k, b)| Edit::Add(a, k, b)),
        1 => (any::<prop::sample::Index>(), 0usize..3, piece).prop_map(|(a, n, s)| Edit::Splice(a, n, s)),
    ]
}

fn apply(text: &str, edits: &[Edit]) -> String {
    let mut text = text.to_owned();
    let pool = values();
    for e in edits {
        if let Edit::Splice(at, n, piece) = e {
            let mut chars: Vec<char> = text.chars().collect();
            let at = at.index(chars.len());
            let end = (at + n).min(chars.len());
            chars.splice(at..end, piece.chars());
            text = chars.into_iter().collect();
            continue;
        }
        let Ok(mut v) = serde_json::from_str::<Value>(&text) else { continue };
        let mut all = Vec::new();
        pointers(&v, "", &mut all);
        if all.is_empty() {
            continue;
        }
        match e {
            Edit::Set(at, value) => {
                *v.pointer_mut(&all[at.index(all.len())]).unwrap() = value.get(&pool).clone()
            }
            Edit::Remove(at) => {
                let (parent, key) = all[at.index(all.len())].rsplit_once('/').unwrap();
                match v.pointer_mut(parent).unwrap() {
                    Value::Object(o) => drop(o.remove(key)),
                    Value::Array(a) => drop(a.remove(key.parse().unwrap())),
                    _ => {}
                }
            }
            Edit::Add(at, key, value) => {
                if let Some(Value::Object(o)) = v.pointer_mut(&all[at.index(all.len())]) {
                    o.insert((*key).to_owned(), value.get(&pool).clone());
                }
            }
            Edit::Splice(..) => {}
        }
        text = v.to_string();
    }
    text
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn the_paths_agree(base in prop::sample::select(EXAMPLES.to_vec()), edits in prop::collection::vec(edit(), 1..4)) {
        let text = apply(base, &edits);
        let fast = checker().is_clean_label(&text);
        let (verdict, found) = slowly(&text);
        // The fast path may leave records with structure to the slow path; never the other way round.
        let nested = serde_json::from_str::<Value>(&text).is_ok_and(|v| {
            v["records"].as_object().is_some_and(|r| r.values().any(|v| v.is_array() || v.is_object()))
        });
        let clean = found.is_empty() && verdict.kind == Some(MessageKind::CocLabel);
        prop_assert!(fast == clean || (nested && clean), "fast {fast}, slow {found:#?}\n{text}");
        for d in &found {
            prop_assert!(known(d.code), "{}", d.code);
            prop_assert!(d.location.line.is_some() && d.location.column.is_some() && d.location.snippet.is_some());
        }
        // An accepted document can be read with the shared types.
        if verdict.valid {
            let label = serde_json::from_str::<typed::CocLabel>(&text);
            prop_assert!(label.is_ok(), "{:?}\n{text}", label.err());
        }
    }
}

#[test]
fn null_is_no_list_for_every_reader() {
    // Found by `the_paths_agree`: what the checker accepts, the typed reader must read.
    for pointer in [
        "/critical_components/1/evidence_times",
        "/critical_components/0/linked_objects",
        "/secondary_scenarios",
    ] {
        let mut v: Value = serde_json::from_str(EXAMPLES[0]).unwrap();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        v.pointer_mut(parent).unwrap().as_object_mut().unwrap().insert(key.to_owned(), Value::Null);
        let text = v.to_string();
        assert_eq!(checker().check_text(&text), [], "{pointer}");
        assert!(serde_json::from_str::<typed::CocLabel>(&text).is_ok(), "{pointer}");
    }
}

/// DATA_FORMAT.md 2.2, 3.1-3.3, 5.1, 5.2 as printed there (the result's list is an excerpt: one warning).
const SAMPLES: &[(&str, MessageKind)] = &[
    (
        r#"{"scenario_label":{"l1":"reactive_agent","l2":"cutin","l3":"urgent","full_id":"reactive_agent.cutin.urgent"}}"#,
        MessageKind::ScenarioLabel,
    ),
    (
        r#"{"clip_metadata":{"clip_id":"clip_20260115_103000_001","source":"vehicle_001","capture_time":"2026-01-15T10:30:00.000Z","duration_sec":20.0,"frame_rate":10,"total_frames":200,"data_sources":{"video":["front_camera","left_camera","right_camera"],"sensor":["lidar","radar"],"can":true,"map":true},"pre_labels":{"scenario":{"l1":"reactive_agent","l2":"cutin"},"mining_score":0.85,"mining_method":"rule_based"}}}"#,
        MessageKind::ClipMetadata,
    ),
    (
        r#"{"scenario_pre_label":{"l1":"reactive_agent","l2":"cutin","l3":null,"confidence":0.85,"mining_conditions_matched":["他车横向位移 > 0.5m","TTC < 5s"],"suggested_l3":"urgent"}}"#,
        MessageKind::ScenarioPreLabel,
    ),
    (
        r#"{"keyframe_suggestion":{"type":"reactive","suggested_timestamp":"2026-01-15T10:30:15.500Z","suggested_frame_idx":155,"detection_rule":"他车车轮越过车道线","context_range":{"start_timestamp":"2026-01-15T10:30:10.000Z","end_timestamp":"2026-01-15T10:30:20.000Z","start_frame_idx":100,"end_frame_idx":200}}}"#,
        MessageKind::KeyframeSuggestion,
    ),
    (
        r#"{"mining_query":{"scenario_id":"reactive_agent.cutin","conditions":[{"field":"target_vehicle.lateral_offset","operator":">","value":0.5,"unit":"m"},{"field":"ttc","operator":"<","value":5,"unit":"s"}],"time_constraints":{"condition_duration_min":0.5,"condition_duration_max":null},"output_limit":1000}}"#,
        MessageKind::MiningQuery,
    ),
    (
        r#"{"mining_result":{"query_id":"query_20260115_001","scenario_id":"reactive_agent.cutin","total_matched":1523,"returned":1000,"clips":[{"clip_id":"clip_20260115_103000_001","match_score":0.95,"keyframe_suggestion":{"timestamp":"2026-01-15T10:30:15.500Z","frame_idx":155},"conditions_matched":[{"condition":"target_vehicle.lateral_offset > 0.5m","actual_value":0.8}]}],"statistics":{"score_distribution":{"0.9-1.0":523,"0.8-0.9":312,"0.7-0.8":165}}}}"#,
        MessageKind::MiningResult,
    ),
];

/// A query with every clause that docs/reference/rules.md adds to 5.1.
const CLAUSES: &str = r#"{"mining_query":{"scenario_id":"reactive_agent.cutin","conditions":[{"any":[{"field":"ttc","operator":"<","value":5,"unit":"s"},{"not":{"rule":"ego.standstill"}}]},{"all":[{"field":"light.state","operator":"in","value":["red"]}]},{"temporal":"for","seconds":2,"condition":{"rule":"ego.standstill"}},{"temporal":"within","seconds":2,"condition":{"rule":"ego.standstill"}},{"temporal":"previously","condition":{"rule":"ego.standstill"}},{"temporal":"rises","condition":{"rule":"ego.standstill"}},{"temporal":"falls","condition":{"rule":"ego.standstill"}},{"temporal":"then","seconds":1.5,"first":{"rule":"ego.standstill"},"second":{"rule":"ego.moves_off"}},{"temporal":"since","first":{"rule":"ego.standstill"},"second":{"rule":"ego.brake"}},{"temporal":"until","seconds":3,"first":{"rule":"ego.standstill"},"second":{"rule":"ego.brake"}}]}}"#;

#[test]
fn a_query_of_clauses_passes_and_what_is_wrong_with_one_is_told() {
    assert_eq!(slowly(CLAUSES).1, vec![]);
    let wrong = [
        (r#""temporal":"for""#, r#""temporal":"fro""#, vec!["message.enum"]),
        (r#""temporal":"for","seconds":2,"#, r#""temporal":"for","#, vec!["message.required"]),
        (r#""temporal":"rises","#, r#""temporal":"rises","seconds":2,"#, vec!["message.unknown_field"]),
        (r#""seconds":1.5,"#, r#""seconds":-1.5,"#, vec!["message.range"]),
        (
            r#""second":{"rule":"ego.moves_off"}"#,
            "\"secnd\":1",
            vec!["message.required", "message.unknown_field"],
        ),
        (
            r#"{"not":{"rule":"ego.standstill"}}"#,
            r#"{"not":{"rule":1},"any":[]}"#,
            vec!["message.query.clause"],
        ),
        (
            r#"{"all":[{"field":"light.state","operator":"in","value":["red"]}]}"#,
            r#"{"all":[]}"#,
            vec!["message.query.clause"],
        ),
        (r#""operator":"in""#, r#""operator":"=>""#, vec!["message.enum", "message.query.value"]),
    ];
    for (from, to, codes) in wrong {
        assert!(CLAUSES.contains(from), "{from}");
        let found = slowly(&CLAUSES.replacen(from, to, 1)).1;
        let mut said: Vec<&str> = found.iter().map(|d| d.code).collect();
        said.sort_unstable();
        assert_eq!(said, codes, "{from} -> {to}: {found:#?}");
        let line = |d: &Diagnostic| {
            d.location.pointer.as_ref().is_some_and(|p| p.starts_with("/mining_query/conditions/"))
        };
        assert!(found.iter().all(line), "{found:#?}");
    }
}

/// Whether the shared types accept a message of this kind.
fn typed_reads(kind: MessageKind, text: &str) -> bool {
    match kind {
        MessageKind::CocLabel => serde_json::from_str::<typed::CocLabel>(text).is_ok(),
        MessageKind::ScenarioLabel => serde_json::from_str::<typed::ScenarioLabelMessage>(text).is_ok(),
        MessageKind::ClipMetadata => serde_json::from_str::<typed::ClipMetadataMessage>(text).is_ok(),
        MessageKind::ScenarioPreLabel => serde_json::from_str::<typed::ScenarioPreLabelMessage>(text).is_ok(),
        MessageKind::KeyframeSuggestion => {
            serde_json::from_str::<typed::KeyframeSuggestionMessage>(text).is_ok()
        }
        MessageKind::MiningQuery => serde_json::from_str::<typed::MiningQueryMessage>(text).is_ok(),
        MessageKind::MiningResult => serde_json::from_str::<typed::MiningResultMessage>(text).is_ok(),
    }
}

#[test]
fn the_specification_s_own_samples_pass() {
    for (text, kind) in SAMPLES {
        let (verdict, found) = slowly(text);
        assert_eq!(verdict, Verdict { kind: Some(*kind), valid: true, foreign: false }, "{found:#?}");
        assert_eq!(found.len(), usize::from(*kind == MessageKind::MiningResult), "{found:#?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn messages_that_pass_can_be_read(sample in prop::sample::select([SAMPLES, &[(CLAUSES, MessageKind::MiningQuery)]].concat()), edits in prop::collection::vec(edit(), 1..4)) {
        let text = apply(sample.0, &edits);
        let (verdict, found) = slowly(&text);
        for d in &found {
            prop_assert!(known(d.code), "{}", d.code);
        }
        if let Verdict { kind: Some(kind), valid: true, .. } = verdict {
            prop_assert!(typed_reads(kind, &text), "{kind:?} {found:#?}\n{text}");
        }
    }
}

/// DATA_FORMAT.md: documents of 2.0 lack what 2.1 added and stay valid. A label that passes is written as 2.0.
#[test]
fn a_label_written_as_2_0_is_not_asked_for_what_2_0_lacks() {
    let codes = |label: &typed::CocLabel, version: &str| -> Vec<String> {
        let mut value = serde_json::to_value(label.clone().to_2_0()).unwrap();
        value["version"] = version.into();
        let found = checker().check_text(&value.to_string());
        found.into_iter().map(|d| d.code.to_string()).collect()
    };
    let mut asked = 0;
    for text in EXAMPLES {
        let label: typed::CocLabel = serde_json::from_str(text).unwrap();
        assert_eq!(codes(&label, "2.0.0"), Vec::<String>::new(), "{text}");
        asked += codes(&label, "2.1.0").iter().filter(|code| *code == "label.record.missing").count();
    }
    assert!(asked > 0, "a document that states 2.1 is asked for the records of its class");
}

#[test]
fn other_is_a_class_everywhere() {
    // LABELING.md 1: an episode that fits no class gets `other` under its L2 or L1.
    for (l2, l3, good) in [
        ("cutin", "other", true),
        ("other", "other", true),
        ("other", "urgent", false),
        ("cutin", "others", false),
    ] {
        let text = format!(r#"{{"scenario_label":{{"l1":"reactive_agent","l2":"{l2}","l3":"{l3}"}}}}"#);
        assert_eq!(checker().check_text(&text).is_empty(), good, "{l2}.{l3}");
    }
    // A mining result may have no L1 (`every_message_is_valid` of the binary's tests has one); a label must state its
    // L1.
    let bare = r#"{"scenario_label":{"l1":"other","l2":"other","l3":"other"}}"#;
    assert!(!checker().check_text(bare).is_empty());
}

#[test]
fn a_class_without_leaf_keeps_what_all_its_leaves_prescribe() {
    // All classes of blind_spot_slowdown must mark uncertainty (LABELING.md 3), so the L2 alone must too.
    let mut v: Value = serde_json::from_str(EXAMPLES[4]).unwrap();
    v["scenario"] = json!({ "l1": "reactive_road", "l2": "blind_spot_slowdown" });
    assert_eq!(checker().check_text(&v.to_string()), []);
    v["critical_components"][0]["uncertainty"] = json!("low");
    assert_eq!(checker().check_text(&v.to_string())[0].code, "label.uncertainty.missing");
}

#[test]
fn places_are_those_of_the_file() {
    // Line and column counted by hand; the document starts at line 7, column 3 of its file.
    let text = "{\"clip_id\": \"中文\", \"scenario\": 1}";
    let origin = Origin { line: 7, column: 3, element: Some(4), indented: true };
    let mut out = Vec::new();
    checker().check(&Document { origin, bytes: text.as_bytes() }, &mut out);
    let d = out.iter().find(|d| d.code == "label.type").unwrap();
    assert_eq!(
        (d.location.line, d.location.column, d.location.pointer.as_deref()),
        (Some(7), Some(33), Some("/4/scenario"))
    );
    assert_eq!(d.location.snippet.as_deref(), Some("  {\"clip_id\": \"中文\", \"scenario\": 1}"));
}

#[test]
fn every_code_has_a_page_in_both_languages() {
    let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/diagnostics");
    let mut wrong = Vec::new();
    for code in CODES.iter().chain(whyroad_framework::check::CODES) {
        let page = std::fs::read_to_string(docs.join(format!("{code}.md"))).unwrap_or_default();
        let (en, zh) = page.split_once("## 中文").unwrap_or_default();
        if !en.starts_with(&format!("# {code}\n")) || en.lines().count() < 5 || zh.trim().chars().count() < 20
        {
            wrong.push(*code);
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
    let all = [CODES, whyroad_framework::check::CODES].concat();
    let mut sorted = all.clone();
    sorted.sort_unstable();
    sorted.dedup();
    assert_eq!(sorted.len(), all.len());
}
