//! The slow path for labels: the basic level of DATA_FORMAT.md 4.3, field by field, into a [`View`].

use crate::check::view::{CauseView, CausesView, ComponentView, Components, KeyframeView, View};
use whyroad_framework::DecisionSets;
use whyroad_framework::check::Slot;
use whyroad_framework::check::closed_set::{ClosedSet, choose, keyframe_type};
use whyroad_framework::check::json::{JsonKind, Node};
use whyroad_framework::check::scenario::{self, ScenarioView};
use whyroad_framework::check::walk::{Object, Walk};
use whyroad_framework::record_types::RecordValue;
use whyroad_model::Severity;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::label_fields::{name, pointer};
use whyroad_model::messages::{ProvenanceSource, SafetyAnswer, Uncertainty};

/// Reads a label. A value that is missing or malformed is reported and left empty in the view.
pub(in crate::check) fn read<'d>(walk: &mut Walk<'d>, decisions: &DecisionSets) -> View<'d> {
    let mut v = View::default();
    let Some(mut o) = walk.object(walk.root, String::new()) else { return v };
    v.version = text(walk, &mut o, name::VERSION);
    v.clip_id = needed(walk, &mut o, name::CLIP_ID, Walk::text);
    v.scenario = match walk.need(&mut o, name::SCENARIO) {
        Some(n) => scenario::read(walk, n, pointer::SCENARIO),
        None => ScenarioView::BROKEN,
    };
    time_range(walk, &mut o, &mut v);
    keyframe(walk, &mut o, &mut v);
    decision(walk, &mut o, decisions, &mut v);
    v.components = match walk.need(&mut o, name::CRITICAL_COMPONENTS) {
        Some(n) => components(walk, n, &mut v.parts),
        None => Slot::Broken,
    };
    // A blank trace has a separate rule.
    v.trace = needed(walk, &mut o, name::COC_TRACE, Walk::any_text);
    v.records = records(walk, &mut o);
    v.causes = causes(walk, &mut o);
    v.second = match o.get(name::SECOND_KEYFRAME) {
        Some(n) => Slot::Is(one_keyframe(walk, n, pointer::SECOND_KEYFRAME)),
        None => Slot::Absent,
    };
    if let Slot::Is(items) = walk.list(o.get(name::SECONDARY_SCENARIOS), pointer::SECONDARY_SCENARIOS) {
        let at = pointer::secondary_scenarios_item;
        v.secondary = items.iter().enumerate().map(|(i, n)| walk.text(Some(n), &at(i))).collect();
    }
    safety_filter(walk, &mut o);
    v.source = provenance(walk, &mut o);
    walk.close(o, Severity::Warning);
    v
}

/// Reads a value at its pointer: [`Walk::text`], [`Walk::time`], ...
type Read<'d, T> = fn(&mut Walk<'d>, Option<&'d Node<'d>>, &str) -> Slot<T>;

/// A field that must be present.
fn needed<'d, T>(walk: &mut Walk<'d>, o: &mut Object<'d>, name: &'static str, read: Read<'d, T>) -> Slot<T> {
    let at = o.at(name);
    walk.need(o, name).map_or(Slot::Broken, |n| read(walk, Some(n), &at))
}

/// A field that may be absent; null is the same.
fn optional<'d, T>(
    walk: &mut Walk<'d>,
    o: &mut Object<'d>,
    name: &'static str,
    read: Read<'d, T>,
) -> Slot<T> {
    let at = o.at(name);
    read(walk, o.get(name), &at)
}

fn text<'d>(walk: &mut Walk<'d>, o: &mut Object<'d>, name: &'static str) -> Slot<&'d str> {
    optional(walk, o, name, Walk::text)
}

fn time_range<'d>(walk: &mut Walk<'d>, parent: &mut Object<'d>, v: &mut View<'d>) {
    (v.start, v.end, v.start_frame, v.end_frame) = (Slot::Broken, Slot::Broken, Slot::Broken, Slot::Broken);
    let Some(node) = walk.need(parent, name::TIME_RANGE) else { return };
    let Some(mut o) = walk.object(node, pointer::TIME_RANGE.into()) else { return };
    v.start = needed(walk, &mut o, name::START_TIMESTAMP, Walk::time);
    v.end = needed(walk, &mut o, name::END_TIMESTAMP, Walk::time);
    v.start_frame = optional(walk, &mut o, name::START_FRAME_IDX, Walk::frame);
    v.end_frame = optional(walk, &mut o, name::END_FRAME_IDX, Walk::frame);
    walk.close(o, Severity::Warning);
}

fn keyframe<'d>(walk: &mut Walk<'d>, parent: &mut Object<'d>, v: &mut View<'d>) {
    v.keyframe = match walk.need(parent, name::KEYFRAME) {
        Some(node) => one_keyframe(walk, node, pointer::KEYFRAME),
        None => BROKEN_KEYFRAME,
    };
}

const BROKEN_KEYFRAME: KeyframeView = KeyframeView {
    timestamp: Slot::Broken,
    frame: Slot::Broken,
    kind: Slot::Broken,
    range_start: Slot::Broken,
    range_end: Slot::Broken,
};

fn one_keyframe<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>, base: &str) -> KeyframeView {
    let mut k = BROKEN_KEYFRAME;
    let Some(mut o) = walk.object(node, base.to_owned()) else { return k };
    k.timestamp = needed(walk, &mut o, name::TIMESTAMP, Walk::time);
    k.frame = needed(walk, &mut o, name::FRAME_IDX, Walk::frame);
    let at = o.at(name::TYPE);
    k.kind = walk
        .need(&mut o, name::TYPE)
        .map_or(Slot::Broken, |n| keyframe_type(walk, n, &at, "label.enum.keyframe_type"));
    k.range_start = optional(walk, &mut o, name::RANGE_START, Walk::time);
    k.range_end = optional(walk, &mut o, name::RANGE_END, Walk::time);
    walk.close(o, Severity::Warning);
    k
}

fn decision<'d>(walk: &mut Walk<'d>, parent: &mut Object<'d>, decisions: &DecisionSets, v: &mut View<'d>) {
    (v.longitudinal, v.lateral, v.direction) = (Slot::Broken, Slot::Broken, Slot::Broken);
    let Some(node) = walk.need(parent, name::DRIVING_DECISION) else { return };
    let Some(mut o) = walk.object(node, pointer::DRIVING_DECISION.into()) else { return };
    let longitudinal = ClosedSet {
        code: "label.enum.longitudinal",
        zh: "纵向决策",
        en: "a longitudinal decision",
        all: Longitudinal::ALL,
        id: Longitudinal::id,
        names: decisions.longitudinal.iter().flat_map(|d| both(&d.text.name, d.id.id())).collect(),
    };
    let lateral = ClosedSet {
        code: "label.enum.lateral",
        zh: "横向决策",
        en: "a lateral decision",
        all: Lateral::ALL,
        id: Lateral::id,
        names: decisions.lateral.iter().flat_map(|d| both(&d.text.name, d.id.id())).collect(),
    };
    let direction = ClosedSet {
        code: "label.enum.lateral_direction",
        zh: "横向方向",
        en: "a lateral direction",
        all: LateralDirection::ALL,
        id: LateralDirection::id,
        names: [
            ("左", "left"),
            ("向左", "left"),
            ("右", "right"),
            ("向右", "right"),
            ("掉头", "uturn"),
            ("u-turn", "uturn"),
        ]
        .map(|(n, id)| (n.to_owned(), id))
        .to_vec(),
    };
    // The key must be present even when its value is null: null is a decision, too (LABELING.md 2).
    v.longitudinal = nullable(walk, &mut o, name::LONGITUDINAL, &longitudinal);
    v.lateral = nullable(walk, &mut o, name::LATERAL, &lateral);
    let at = o.at(name::LATERAL_DIRECTION);
    v.direction = choose(walk, o.get(name::LATERAL_DIRECTION), &at, &direction);
    walk.close(o, Severity::Warning);
}

/// A member of a closed set whose key must be present; null means absent.
fn nullable<'d, T: Copy>(
    walk: &mut Walk<'d>,
    o: &mut Object<'d>,
    name: &'static str,
    set: &ClosedSet<T>,
) -> Slot<T> {
    let at = o.at(name);
    match walk.nullable(o, name) {
        Some(n) => choose(walk, Some(n).filter(|n| !n.is_null()), &at, set),
        None => Slot::Broken,
    }
}

fn both(name: &whyroad_model::Bilingual, id: &'static str) -> [(String, &'static str); 2] {
    [(name.zh.clone(), id), (name.en.to_lowercase(), id)]
}

fn components<'d>(
    walk: &mut Walk<'d>,
    node: &'d Node<'d>,
    parts: &mut Vec<ComponentView<'d>>,
) -> Slot<Components> {
    let Slot::Is(items) = walk.list(Some(node), pointer::CRITICAL_COMPONENTS) else { return Slot::Broken };
    let mut out = Components { count: items.len(), any_high: false };
    let set = ClosedSet {
        code: "label.enum.uncertainty",
        zh: "不确定度",
        en: "an uncertainty",
        all: Uncertainty::ALL,
        id: Uncertainty::id,
        names: [("高", "high"), ("低", "low")].map(|(n, id)| (n.to_owned(), id)).to_vec(),
    };
    for (i, item) in items.iter().enumerate() {
        let Some(mut o) = walk.object(item, pointer::critical_components_item(i)) else {
            out.any_high = true;
            continue;
        };
        optional(walk, &mut o, name::CATEGORY, Walk::any_text);
        let description = needed(walk, &mut o, name::DESCRIPTION, Walk::text);
        let at = o.at(name::UNCERTAINTY);
        let uncertainty = choose(walk, o.get(name::UNCERTAINTY), &at, &set);
        out.any_high |= !matches!(uncertainty, Slot::Absent | Slot::Is(Uncertainty::Low));
        let id = text(walk, &mut o, name::ID);
        let mut evidence = Vec::new();
        if let Slot::Is(times) = optional(walk, &mut o, name::EVIDENCE_TIMES, Walk::list) {
            let at = |k| pointer::critical_components_item_evidence_times_item(i, k);
            evidence.extend(times.iter().enumerate().map(|(k, n)| walk.time(Some(n), &at(k))));
        }
        let mut objects = Vec::new();
        if let Slot::Is(ids) = optional(walk, &mut o, name::LINKED_OBJECTS, Walk::list) {
            let at = |k| pointer::critical_components_item_linked_objects_item(i, k);
            objects.extend(ids.iter().enumerate().filter_map(|(k, n)| walk.text(Some(n), &at(k)).get()));
        }
        parts.push(ComponentView { index: i, description, id, evidence: evidence.into(), objects });
        walk.close(o, Severity::Warning);
    }
    Slot::Is(out)
}

fn records<'d>(walk: &mut Walk<'d>, parent: &mut Object<'d>) -> Slot<Vec<(&'d str, RecordValue<'d>)>> {
    let Some(node) = parent.get(name::RECORDS) else { return Slot::Absent };
    let Some(o) = walk.object(node, pointer::RECORDS.into()) else { return Slot::Broken };
    let mut filled = Vec::new();
    for e in o.entries() {
        walk.free(&e.node, &o.at(&e.key));
        let value = match &e.node.kind {
            JsonKind::Null => continue,
            JsonKind::Text(t) if t.trim().is_empty() => continue,
            JsonKind::Text(t) => RecordValue::Text(t),
            JsonKind::Flag(b) => RecordValue::Flag(*b),
            JsonKind::Number(n) => RecordValue::Number(n.parse().unwrap_or(f64::NAN)),
            _ => RecordValue::Nested,
        };
        filled.push((&*e.key, value));
    }
    Slot::Is(filled)
}

fn causes<'d>(walk: &mut Walk<'d>, parent: &mut Object<'d>) -> Slot<CausesView<'d>> {
    let Some(node) = parent.get(name::CAUSES) else { return Slot::Absent };
    let Some(mut o) = walk.object(node, pointer::CAUSES.into()) else { return Slot::Broken };
    let mut channel = |walk: &mut Walk<'d>, key: &'static str, base: &str| match o.get(key) {
        Some(n) => cause(walk, n, base),
        None => Slot::Absent,
    };
    let view = CausesView {
        longitudinal: channel(walk, name::LONGITUDINAL, pointer::CAUSES_LONGITUDINAL),
        lateral: channel(walk, name::LATERAL, pointer::CAUSES_LATERAL),
    };
    walk.close(o, Severity::Warning);
    Slot::Is(view)
}

fn cause<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>, base: &str) -> Slot<CauseView<'d>> {
    let Some(mut o) = walk.object(node, base.to_owned()) else { return Slot::Broken };
    let mut view = CauseView::default();
    let at = o.at(name::COMPONENTS);
    match walk.list(o.get(name::COMPONENTS), &at) {
        Slot::Is(ids) => {
            let text = |(i, n): (usize, &'d Node<'d>)| walk.text(Some(n), &format!("{at}/{i}"));
            view.components = ids.iter().enumerate().map(text).collect();
        }
        Slot::Broken => view.components.push(Slot::Broken),
        Slot::Absent => {}
    }
    view.unobserved = text(walk, &mut o, name::UNOBSERVED);
    walk.close(o, Severity::Warning);
    Slot::Is(view)
}

/// No rule uses it: only its form is checked.
fn safety_filter<'d>(walk: &mut Walk<'d>, parent: &mut Object<'d>) {
    let Some(node) = parent.get(name::SAFETY_FILTER) else { return };
    let Some(mut o) = walk.object(node, pointer::SAFETY_FILTER.into()) else { return };
    let set = ClosedSet {
        code: "label.enum.safety_answer",
        zh: "安全过滤的结论",
        en: "an answer of the safety filter",
        all: SafetyAnswer::ALL,
        id: SafetyAnswer::id,
        names: [("合法且安全", "safe"), ("违法或不安全", "unsafe")]
            .map(|(n, id)| (n.to_owned(), id))
            .to_vec(),
    };
    if let Some(n) = walk.need(&mut o, name::ANSWER) {
        choose(walk, Some(n), pointer::SAFETY_FILTER_ANSWER, &set);
    }
    if let Slot::Is(reasons) = walk.list(o.get(name::REASONS), pointer::SAFETY_FILTER_REASONS) {
        for (i, n) in reasons.iter().enumerate() {
            walk.text(Some(n), &format!("{}/{i}", pointer::SAFETY_FILTER_REASONS));
        }
    }
    text(walk, &mut o, name::NOTE);
    walk.close(o, Severity::Warning);
}

fn provenance<'d>(walk: &mut Walk<'d>, parent: &mut Object<'d>) -> Slot<ProvenanceSource> {
    let Some(node) = parent.get(name::PROVENANCE) else { return Slot::Absent };
    let Some(mut o) = walk.object(node, pointer::PROVENANCE.into()) else { return Slot::Broken };
    let set = ClosedSet {
        code: "label.enum.provenance_source",
        zh: "标签来源",
        en: "a source of labels",
        all: ProvenanceSource::ALL,
        id: ProvenanceSource::id,
        names: [("规则", "rule"), ("模型", "model"), ("人工", "person")]
            .map(|(n, id)| (n.to_owned(), id))
            .to_vec(),
    };
    let source = match walk.need(&mut o, name::SOURCE) {
        Some(n) => choose(walk, Some(n), pointer::PROVENANCE_SOURCE, &set),
        None => Slot::Broken,
    };
    for key in [name::BY, name::TOOL] {
        text(walk, &mut o, key);
    }
    optional(walk, &mut o, name::AT, Walk::time);
    if let Some(n) = o.get(name::VERSIONS)
        && let Some(versions) = walk.object(n, pointer::PROVENANCE_VERSIONS.into())
    {
        for e in versions.entries() {
            walk.text(Some(&e.node), &versions.at(&e.key));
        }
    }
    walk.close(o, Severity::Warning);
    source
}
