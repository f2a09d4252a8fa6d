//! One fault per label: those written in the corpus, and structural ones.

use super::build::{self, Base, at, component, decide, keyframe, label, start_s};
use serde_json::{Value, json};
use whyroad_model::messages::KeyframeType;

/// A label with one fault.
pub(super) struct Fault {
    pub kind: &'static str,
    pub label: Value,
    /// The change, for the reader of the table.
    pub what: String,
}

/// Kinds, and the codes (or their prefixes) that name the fault.
const KINDS: &[(&str, &[&str])] = &[
    ("hindsight_trace", &["label.text.hindsight"]),
    ("hindsight_component", &["label.text.hindsight"]),
    ("circular", &["label.cause.circular", "label.text.unrelated", "label.trace.too_short"]),
    ("unnamed_object", &["label.trace.unnamed_object", "label.trace.object_differs"]),
    ("object_differs", &["label.trace.object_differs", "label.trace.unnamed_object"]),
    (
        "cause_denied",
        &[
            "label.trace.contradicts",
            "label.cause.denied",
            "label.cause.circular",
            "label.trace.decision_missing",
        ],
    ),
    ("negated", &["label.trace.contradicts", "label.trace.decision_missing"]),
    ("paraphrased", &["label.trace.contradicts", "label.trace.unlabelled", "label.trace.decision_missing"]),
    ("action_other", &["label.trace.contradicts", "label.trace.unlabelled"]),
    // The class may forbid the direction as well.
    ("direction", &["label.trace.direction", "label.trace.contradicts", "label.decision.impossible"]),
    ("text_direction", &["label.trace.direction", "label.trace.contradicts"]),
    ("unstated", &["label.trace.decision_missing", "label.trace.contradicts"]),
    ("unrelated", &["label.text.unrelated", "label.trace.decision_missing"]),
    ("near_duplicate", &["label.component.duplicate"]),
    ("placeholder", &["label.text.placeholder", "label.text.unrelated", "label.component.too_short"]),
    ("other_class", &["label.text.class", "label.cause.kind", "label.text.unrelated"]),
    ("proximate", &["label.cause.proximate"]),
    // A far cause instead of the near one is also a reason unrelated to the components.
    ("distant", &["label.cause.proximate", "label.text.unrelated"]),
    // A second maneuver without a cause: by the text, by the class, or by the causes.
    (
        "minimality",
        &[
            "label.decision.unchanged",
            "label.decision.impossible",
            "label.trace.unlabelled",
            "label.cause.kind",
        ],
    ),
    ("impossible_decision", &["label.decision.impossible"]),
    ("impossible_lateral", &["label.decision.impossible", "label.lateral.mandated"]),
    (
        "impossible_direction",
        &["label.decision.impossible", "label.direction.invalid", "label.direction.unexpected"],
    ),
    ("null_decision", &["label.decision.impossible", "label.lateral.mandated", "label.trace.unlabelled"]),
    ("null_channel", &["label.trace.unlabelled", "label.decision.impossible"]),
    ("evidence_early", &["label.evidence.before_history"]),
    ("evidence_late", &["label.evidence.after_keyframe"]),
    ("range_hours", &["label.time_range.implausible"]),
    ("range_outside", &["label.keyframe.range_outside"]),
    ("start_shifted", &["label.time_range.start"]),
    ("record_value", &["label.record.value"]),
    ("record_missing", &["label.record.missing"]),
    ("duplicate", &["label.component.duplicate"]),
    ("draft", &["label.trace.draft", "label.text.placeholder"]),
    // By the causes, or by a trace without any reason.
    ("cause_missing", &["label.cause.missing", "label.cause.circular", "label.text.unrelated"]),
    ("unobserved", &["label.cause.unobserved"]),
    // An additional action of the ego.
    ("unstated_action", &["label.trace.unlabelled", "label.trace.contradicts"]),
    // A component that contradicts the decision.
    ("part_contradicts", &["label.trace.contradicts"]),
    ("trace_placeholder", &["label.text.placeholder", "label.trace.too_short", "label.text.unrelated"]),
    ("uncertainty", &["label.uncertainty.missing"]),
    ("keyframe_outside", &["label.keyframe."]),
];

pub(super) fn codes(kind: &str) -> &'static [&'static str] {
    KINDS.iter().find(|(k, _)| *k == kind).unwrap_or_else(|| panic!("{kind} has no codes")).1
}

fn known(kind: &str) -> &'static str {
    KINDS.iter().find(|(k, _)| *k == kind).unwrap_or_else(|| panic!("{kind} is not a kind")).0
}

/// All faulty labels of a base: the written and the structural ones.
pub(super) fn of(base: &Base, language: &str) -> Vec<Fault> {
    let mut out = written(base, language);
    structure(base, language, &mut |kind, what, change| out.push(fault(base, kind, what, change)));
    out
}

fn fault(base: &Base, kind: &str, what: &str, change: &dyn Fn(&mut Value)) -> Fault {
    let mut label = label(base);
    change(&mut label);
    Fault { kind: known(kind), label, what: what.to_owned() }
}

/// The faulty labels in the corpus.
pub(super) fn written(base: &Base, language: &str) -> Vec<Fault> {
    let mut out = Vec::new();
    let ids: Vec<String> = (0..base.parts.len()).map(|i| format!("c{}", i + 1)).collect();
    let mut add =
        |kind: &str, what: &str, change: &dyn Fn(&mut Value)| out.push(fault(base, kind, what, change));
    for (kind, traces) in &base.faults {
        for trace in traces {
            add(kind, trace, &|l| l["coc_trace"] = json!(trace));
        }
    }
    for (kind, parts) in &base.parts_faults {
        for part in parts {
            add(kind, part, &|l| {
                let list = l["critical_components"].as_array_mut().unwrap();
                // A component of another class replaces all; others are added or replace the last one.
                match kind.as_str() {
                    "other_class" => *list = vec![component(0, part)],
                    "near_duplicate" | "distant" | "part_contradicts" => {
                        list.push(component(base.parts.len(), part))
                    }
                    "proximate" => *list.last_mut().unwrap() = component(base.parts.len() - 1, part),
                    _ => {
                        let i = list.len() - 1;
                        list[i]["description"] = json!(part);
                    }
                }
                if kind == "other_class" {
                    l["coc_trace"] = json!(part);
                    let trace = if language == "zh" {
                        format!("{part}，因此自车减速让行，保持安全距离。")
                    } else {
                        format!("{part}, so the ego slows down and yields to it.")
                    };
                    l["coc_trace"] = json!(trace);
                    decide(l, &base.decision, &["c1".to_owned()]);
                }
            });
        }
    }
    for (kind, decisions) in &base.decision_faults {
        for decision in decisions {
            add(kind, decision, &|l| decide(l, decision, &ids));
        }
    }
    for (kind, all) in &base.whole_faults {
        for whole in all {
            let what = if whole.parts.is_empty() { &whole.decision } else { &whole.trace };
            add(kind, what, &|l| {
                l["coc_trace"] = json!(whole.trace);
                if whole.parts.is_empty() {
                    return decide(l, &whole.decision, &ids);
                }
                let parts: Vec<Value> =
                    whole.parts.iter().enumerate().map(|(i, p)| component(i, p)).collect();
                let ids: Vec<String> = (0..parts.len()).map(|i| format!("c{}", i + 1)).collect();
                l["critical_components"] = json!(parts);
                decide(l, &whole.decision, &ids);
            });
        }
    }
    for (kind, all) in &base.record_faults {
        for (id, value) in all.iter().flatten() {
            add(kind, id, &|l| l["records"][id] = value.clone());
        }
    }
    for (kind, all) in &base.evidence_faults {
        for evidence in all {
            let times = json!([at(evidence.at)]);
            add(kind, &format!("{} s", evidence.at), &|l| {
                l["critical_components"][evidence.part]["evidence_times"] = times.clone();
            });
        }
    }
    out
}

/// Adds a faulty label: kind, text of the fault, and the change to a true label.
type Add<'a> = dyn FnMut(&str, &str, &dyn Fn(&mut Value)) + 'a;

fn structure(base: &Base, language: &str, add: &mut Add<'_>) {
    add("evidence_early", "90 minutes", &|l| {
        l["critical_components"][0]["evidence_times"] = json!([at(-5400.0)])
    });
    add("evidence_late", "1 s", &|l| l["critical_components"][0]["evidence_times"] = json!([at(1.0)]));
    add("range_hours", "4 h", &|l| {
        l["time_range"] = json!({ "start_timestamp": l["time_range"]["start_timestamp"], "end_timestamp": at(4.0 * 3600.0) });
    });
    if build::kind(base) == KeyframeType::Proactive {
        add("range_outside", "3 s", &|l| l["keyframe"]["range_end"] = at(7.0));
    }
    if let Some(s) = start_s(base) {
        add("start_shifted", "6 s early", &|l| {
            l["time_range"]["start_timestamp"] = at(s - 3.0);
            l["time_range"]["start_frame_idx"] = json!((100.0 + 10.0 * (s - 3.0)) as u32);
        });
    }
    for (id, value) in &base.records {
        let wrong = match value {
            Value::Bool(_) => json!("香蕉"),
            Value::Number(_) => json!(-90_000),
            _ => json!(["a", "b"]),
        };
        add("record_value", id, &|l| l["records"][id] = wrong.clone());
        add("record_missing", id, &|l| {
            l["records"].as_object_mut().unwrap().remove(id);
        });
    }
    add("duplicate", "the first component twice", &|l| {
        let mut again = l["critical_components"][0].clone();
        again["id"] = json!("again");
        l["critical_components"].as_array_mut().unwrap().push(again);
    });
    add("draft", "mark", &|l| {
        let mark = if language == "zh" { "【草稿】" } else { "[DRAFT] " };
        l["coc_trace"] = json!(format!("{mark}{}", base.trace));
    });
    let first = base.decision.split('/').next().unwrap() != "-";
    let channel = if first { "longitudinal" } else { "lateral" };
    add("cause_missing", channel, &|l| {
        l["causes"].as_object_mut().unwrap().remove(channel);
    });
    let nothing: &[&str] = if language == "zh" {
        &["无", "不知道为什么", "未观测到"]
    } else {
        &["unknown", "no idea", "not visible"]
    };
    for text in nothing {
        add("unobserved", text, &|l| l["causes"][channel] = json!({ "unobserved": text }));
    }
    let nothing: &[&str] =
        if language == "zh" { &["测试测试测试测试", "待补充"] } else { &["test", "TODO TODO"] };
    for text in nothing {
        add("trace_placeholder", text, &|l| l["coc_trace"] = json!(text));
    }
    if base.parts.iter().any(|p| p.starts_with('?')) {
        add("uncertainty", "low", &|l| {
            for c in l["critical_components"].as_array_mut().unwrap() {
                c["uncertainty"] = json!("low");
            }
        });
    }
    // Keeping a speed or following a lead is no change that a null decision would deny.
    if first && !base.decision.starts_with("set_speed") && !base.decision.starts_with("lead_following") {
        // The trace still states it.
        let rest = base.decision.split_once('/').unwrap().1;
        add("null_channel", rest, &|l| decide(l, &format!("-/{rest}"), &["c1".to_owned()]));
    }
    add("keyframe_outside", "9 s", &|l| {
        l["keyframe"]["timestamp"] = json!(keyframe().plus_secs(9.0).to_string());
        l["keyframe"]["frame_idx"] = json!(190);
        for c in l["critical_components"].as_array_mut().unwrap() {
            c["evidence_times"] = json!([]);
        }
    });
}
