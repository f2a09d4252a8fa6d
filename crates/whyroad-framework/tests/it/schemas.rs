//! The JSON Schemas against the Rust types, both ways: what the specification prints is accepted by both, what
//! breaks its rules is rejected by both, and the committed files are what the types generate.

use jsonschema::Validator;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use whyroad_framework::Framework;
use whyroad_framework::schemas::schemas;
use whyroad_model::messages::{
    ClipMetadataMessage, CocLabel, KeyframeSuggestionMessage, MiningQueryMessage, MiningResultMessage,
    ScenarioLabelMessage, ScenarioPreLabelMessage,
};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn validator(name: &str) -> Validator {
    let file =
        schemas(Framework::bundled()).into_iter().find(|s| s.name == format!("{name}_schema.json")).unwrap();
    jsonschema::options().should_validate_formats(true).build(&file.schema).unwrap()
}

fn complaints(validator: &Validator, value: &Value) -> Vec<String> {
    validator.iter_errors(value).map(|e| format!("{}: {e}", e.instance_path())).collect()
}

/// A sample message of DATA_FORMAT.md, copied from its text.
fn sample(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/data/messages/{name}.json"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// A label that follows DATA_FORMAT.md 4.2, with every conditional field present.
fn label() -> Value {
    json!({
        "clip_id": "c", "scenario": { "l1": "proactive", "l2": "lane_change", "l3": "navigation" },
        "time_range": { "start_timestamp": "2026-01-15T10:30:00.000Z", "end_timestamp": "2026-01-15T10:30:08.000Z" },
        "keyframe": { "timestamp": "2026-01-15T10:30:02.000Z", "frame_idx": 20, "type": "proactive",
            "range_start": "2026-01-15T10:30:02.000Z", "range_end": "2026-01-15T10:30:06.000Z" },
        "driving_decision": { "longitudinal": null, "lateral": "lane_change", "lateral_direction": "left" },
        "critical_components": [{ "description": "the exit is 300 m ahead on the left" }],
        "coc_trace": "The exit is near and on the left, so the ego changes to the left lane.",
        "records": { "remaining_distance": 300 },
    })
}

fn with(mut value: Value, pointer: &str, to: Value) -> Value {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match value.pointer_mut(parent).unwrap() {
        Value::Array(items) => items[key.parse::<usize>().unwrap()] = to,
        parent => parent[key] = to,
    }
    value
}

fn without(mut value: Value, pointer: &str) -> Value {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    value.pointer_mut(parent).unwrap().as_object_mut().unwrap().remove(key).unwrap();
    value
}

#[test]
fn committed_schemas_are_what_the_types_generate() {
    for file in schemas(Framework::bundled()) {
        let path = root().join("schema").join(&file.name);
        let committed = std::fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
        assert!(committed == file.text(), "schema/{} is stale: run `whyroad taxonomy schemas`", file.name);
        assert!(jsonschema::meta::is_valid(&file.schema), "{} is no draft 2020-12 schema", file.name);
        for key in ["$schema", "$id", "title", "description", "version"] {
            assert!(file.schema[key].is_string(), "{}: {key}", file.name);
        }
    }
    // DATA_FORMAT.md 1.4 and the list of messages in its sections 2 to 5.
    assert_eq!(schemas(Framework::bundled()).len(), 8);
}

fn accepted_by_both<T: DeserializeOwned + serde::Serialize>(name: &str) {
    let (value, validator) = (sample(name), validator(name));
    assert_eq!(complaints(&validator, &value), Vec::<String>::new(), "{name}");
    let typed: T = serde_json::from_value(value.clone()).unwrap();
    let again = serde_json::to_value(&typed).unwrap();
    assert_eq!(complaints(&validator, &again), Vec::<String>::new(), "{name}, written by us");
    assert_nothing_lost(&value, &again, name);
}

/// Everything of `before` is in `after`; nulls that mean "absent" may go.
fn assert_nothing_lost(before: &Value, after: &Value, at: &str) {
    match (before, after) {
        (Value::Object(b), Value::Object(a)) => {
            for (key, value) in b.iter().filter(|(_, v)| !v.is_null()) {
                assert_nothing_lost(value, a.get(key).unwrap_or(&Value::Null), &format!("{at}/{key}"));
            }
        }
        (Value::Number(b), Value::Number(a)) => assert_eq!(b.as_f64(), a.as_f64(), "{at}"),
        (b, a) => assert_eq!(b, a, "{at}"),
    }
}

#[test]
fn the_messages_of_the_specification_are_accepted_by_both() {
    accepted_by_both::<ScenarioLabelMessage>("scenario_label");
    accepted_by_both::<ClipMetadataMessage>("clip_metadata");
    accepted_by_both::<ScenarioPreLabelMessage>("scenario_pre_label");
    accepted_by_both::<KeyframeSuggestionMessage>("keyframe_suggestion");
    accepted_by_both::<MiningQueryMessage>("mining_query");
    accepted_by_both::<MiningResultMessage>("mining_result");
}

#[test]
fn labels_and_the_examples_are_accepted_by_both() {
    let validator = validator("coc_output");
    let mut all = vec![("label".to_owned(), label())];
    for entry in std::fs::read_dir(root().join("examples")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "json") {
            let value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
            all.push((path.file_name().unwrap().to_string_lossy().into_owned(), value));
        }
    }
    // The four that DATA_FORMAT.md 6 names, and the label above.
    assert!(all.len() >= 5, "{}", all.len());
    for (name, value) in all {
        assert_eq!(complaints(&validator, &value), Vec::<String>::new(), "{name}");
        let typed: CocLabel = serde_json::from_value(value.clone()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let again = serde_json::to_value(&typed).unwrap();
        assert_eq!(complaints(&validator, &again), Vec::<String>::new(), "{name}, written by us");
        assert_nothing_lost(&value, &again, &name);
    }
}

fn rejected_by_both<T: DeserializeOwned>(name: &str, whole: &Value, broken: &[(&str, Option<Value>)]) {
    let validator = validator(name);
    assert!(validator.is_valid(whole), "{name}: the unbroken message must be valid");
    assert!(serde_json::from_value::<T>(whole.clone()).is_ok(), "{name}");
    for (pointer, to) in broken {
        let value = match to {
            Some(to) => with(whole.clone(), pointer, to.clone()),
            None => without(whole.clone(), pointer),
        };
        assert!(!validator.is_valid(&value), "{name}: the schema accepts {pointer} = {to:?}");
        assert!(serde_json::from_value::<T>(value).is_err(), "{name}: the type accepts {pointer} = {to:?}");
    }
}

#[test]
fn broken_messages_are_rejected_by_both() {
    let set = |v: Value| Some(v);
    rejected_by_both::<ScenarioLabelMessage>(
        "scenario_label",
        &sample("scenario_label"),
        &[("/scenario_label", None), ("/scenario_label/l1", None), ("/scenario_label/l2", set(json!(3)))],
    );
    rejected_by_both::<ClipMetadataMessage>(
        "clip_metadata",
        &sample("clip_metadata"),
        &[
            ("/clip_metadata/clip_id", None),
            ("/clip_metadata/capture_time", set(json!("2026-01-15 10:30:00"))),
            ("/clip_metadata/capture_time", set(json!("2026-02-30T10:30:00.000Z"))),
            ("/clip_metadata/duration_sec", set(json!("20"))),
            ("/clip_metadata/total_frames", set(json!(-1))),
            ("/clip_metadata/total_frames", set(json!(1.5))),
            ("/clip_metadata/data_sources/can", set(json!("yes"))),
            ("/clip_metadata/pre_labels/mining_score", None),
        ],
    );
    rejected_by_both::<ScenarioPreLabelMessage>(
        "scenario_pre_label",
        &sample("scenario_pre_label"),
        &[
            ("/scenario_pre_label/confidence", set(json!("high"))),
            ("/scenario_pre_label/mining_conditions_matched", set(json!("TTC < 5s"))),
            ("/scenario_pre_label/l2", None),
        ],
    );
    rejected_by_both::<KeyframeSuggestionMessage>(
        "keyframe_suggestion",
        &sample("keyframe_suggestion"),
        &[
            ("/keyframe_suggestion/type", set(json!("active"))),
            ("/keyframe_suggestion/suggested_timestamp", set(json!(1768473015))),
            ("/keyframe_suggestion/context_range/end_timestamp", None),
        ],
    );
    rejected_by_both::<MiningQueryMessage>(
        "mining_query",
        &sample("mining_query"),
        &[
            ("/mining_query/scenario_id", set(json!("Reactive Agent"))),
            ("/mining_query/scenario_id", set(json!("a.b.c.d"))),
            ("/mining_query/conditions/0/operator", set(json!("=>"))),
            ("/mining_query/conditions/0/threshold", set(json!(1))),
            ("/mining_query/time_constraints/condition_duration_min", set(json!("0.5 s"))),
            ("/mining_query/output_limit", set(json!(-5))),
        ],
    );
    rejected_by_both::<MiningResultMessage>(
        "mining_result",
        &sample("mining_result"),
        &[
            ("/mining_result/total_matched", set(json!(-1))),
            ("/mining_result/clips/0/keyframe_suggestion/frame_idx", set(json!("155"))),
            ("/mining_result/clips/0/match_score", None),
            ("/mining_result/statistics", None),
        ],
    );
    rejected_by_both::<CocLabel>(
        "coc_output",
        &label(),
        &[
            ("/clip_id", None),
            ("/scenario", set(json!("proactive.lane_change.navigation"))),
            ("/keyframe/timestamp", set(json!("10:30:02"))),
            ("/keyframe/type", set(json!("both"))),
            ("/keyframe/frame_idx", set(json!(-1))),
            ("/driving_decision/longitudinal", None),
            ("/driving_decision/lateral", None),
            ("/driving_decision/longitudinal", set(json!("brake"))),
            ("/driving_decision/lateral", set(json!(["lane_change", "turn"]))),
            ("/driving_decision/lateral_direction", set(json!("up"))),
            ("/critical_components", set(json!({}))),
            ("/critical_components/0/description", None),
            ("/critical_components/0/uncertainty", set(json!("medium"))),
            ("/coc_trace", None),
            ("/time_range/start_timestamp", set(Value::Null)),
        ],
    );
}

#[test]
fn the_label_schema_holds_the_rules_between_fields() {
    // DATA_FORMAT.md 4.3 "业务校验", LABELING.md 2 and 3, TAXONOMY.md last column. The Rust types alone accept these.
    let v = validator("coc_output");
    let leaf = |l1: &str, l2: &str, l3: &str| json!({ "l1": l1, "l2": l2, "l3": l3 });
    let high = json!([{ "description": "a parked van hides the pavement", "uncertainty": "high" }]);
    let set = |pointer: &str, to: Value| with(label(), pointer, to);
    let blind = set("/scenario", leaf("reactive_road", "blind_spot_slowdown", "curve"));
    let cutout = set("/scenario", leaf("reactive_agent", "vehicle_abnormal", "cutout_reveal"));
    let nudge = with(
        set("/scenario", leaf("proactive", "obstacle_avoidance", "in_lane")),
        "/driving_decision/lateral",
        json!("in_lane_nudge"),
    );
    let no_lateral =
        without(set("/driving_decision/lateral", Value::Null), "/driving_decision/lateral_direction");

    for good in [
        with(blind.clone(), "/critical_components", high.clone()),
        with(cutout.clone(), "/critical_components", high),
        set("/scenario", leaf("reactive_agent", "vehicle_abnormal", "reversing")),
        nudge.clone(),
        no_lateral.clone(),
        set("/driving_decision/lateral_direction", json!("right")),
        // LABELING.md 1: what fits nowhere goes to `other` under its L2 or L1.
        set("/scenario", leaf("proactive", "lane_change", "other")),
        set("/scenario", json!({ "l1": "proactive", "l2": "other" })),
    ] {
        assert_eq!(complaints(&v, &good), Vec::<String>::new(), "{good:#}");
    }
    for broken in [
        without(label(), "/driving_decision/lateral_direction"),
        set("/driving_decision/lateral_direction", Value::Null),
        set("/driving_decision/lateral_direction", json!("uturn")),
        set("/driving_decision/lateral", json!("lane_keeping")),
        set("/driving_decision/lateral", Value::Null),
        without(label(), "/keyframe/range_start"),
        set("/keyframe/range_end", Value::Null),
        blind,
        cutout,
        with(nudge, "/driving_decision/lateral", json!("out_of_lane_nudge")),
        set("/critical_components", json!([])),
        set("/critical_components/0/description", json!("")),
        set("/coc_trace", json!("")),
        set("/clip_id", json!("")),
        set("/scenario/l1", json!("proactiv")),
        set("/scenario/l2", json!("cutin")),
        set("/scenario/l3", json!("urgent")),
    ] {
        assert!(!v.is_valid(&broken), "{broken:#}");
    }
}

#[test]
fn messages_of_mining_name_classes_that_exist() {
    // The classes are those of the tree in the specification; the unbroken samples are printed there (DATA_FORMAT.md
    // 3.1, 3.2).
    let clip = validator("clip_metadata");
    let at = |field: &str| format!("/clip_metadata/pre_labels/scenario/{field}");
    let sample_clip = with(sample("clip_metadata"), &at("l1"), json!("reactive_agent"));
    let sample_clip = with(sample_clip, &at("l2"), json!("cutin"));
    for l3 in [json!("urgent"), json!("other"), Value::Null] {
        assert!(clip.is_valid(&with(sample_clip.clone(), &at("l3"), l3.clone())), "{l3}");
    }
    for (field, to) in [("l1", "reactive"), ("l2", "cut_in"), ("l2", "lane_change"), ("l3", "red_stop")] {
        assert!(!clip.is_valid(&with(sample_clip.clone(), &at(field), json!(to))), "{field} = {to}");
    }
    let pre_label = validator("scenario_pre_label");
    let proposal = json!({ "scenario_pre_label": {
        "l1": "reactive_agent", "l2": "cutin", "l3": null, "confidence": 0.9,
        "mining_conditions_matched": ["TTC < 3 s"], "suggested_l3": "urgent",
    } });
    assert_eq!(complaints(&pre_label, &proposal), Vec::<String>::new());
    for (field, to) in
        [("l1", "agent"), ("l2", "turn"), ("l3", "hov_lane"), ("suggested_l3", "red_stop"), ("l2", "")]
    {
        let broken = with(proposal.clone(), &format!("/scenario_pre_label/{field}"), json!(to));
        assert!(!pre_label.is_valid(&broken), "{field} = {to}");
    }
}

#[test]
fn the_format_is_a_minor_step_from_the_given_one() {
    // DATA_FORMAT.md 1.3 of the specification: 2.0.0 is the given version, added optional fields are a minor step.
    for file in schemas(Framework::bundled()) {
        assert_eq!(file.schema["version"], "2.1.0", "{}", file.name);
    }
    let v = validator("coc_output");
    for version in [None, Some("2.0.0"), Some("2.1.0")] {
        let mut document = label();
        if let Some(version) = version {
            document["version"] = json!(version);
        }
        assert_eq!(complaints(&v, &document), Vec::<String>::new(), "{version:?}");
    }
}

#[test]
fn every_labelling_spec_follows_its_schema() {
    let validator = validator("labeling_spec");
    let mut checked = 0;
    for (path, text) in Framework::bundled_files() {
        // The tables beside the specs have readers of their own.
        let table = ["scenarios/decisions.yaml", "scenarios/records.yaml"].contains(&path.as_str());
        if !path.starts_with("scenarios/") || path.ends_with(".cases.yaml") || table {
            continue;
        }
        let value: Value = whyroad_model::yaml::from_str(&text).unwrap();
        assert_eq!(complaints(&validator, &value), Vec::<String>::new(), "{path}");
        checked += 1;
    }
    // One file an L1 and one an L2: LABELING.md 8 counts 5 and 31.
    assert_eq!(checked, 36);
}
