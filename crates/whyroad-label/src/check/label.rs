//! The slow path for labels: the basic level of DATA_FORMAT.md 4.3, field by field, into a [`View`].

use super::view::{CauseView, CausesView, Components, KeyframeView, LinkedComponent, View};
use whyroad_framework::DecisionSets;
use whyroad_framework::check::Slot;
use whyroad_framework::check::closed_set::{ClosedSet, choose, keyframe_type};
use whyroad_framework::check::json::{JsonKind, Node};
use whyroad_framework::check::scenario::{self, ScenarioView};
use whyroad_framework::check::walk::{Object, Walk};
use whyroad_model::Severity;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::messages::{ProvenanceSource, Uncertainty};

/// Reads a label. What is missing or of the wrong form is reported and becomes a hole in the view.
pub(super) fn read<'d>(walk: &mut Walk<'d>, decisions: &DecisionSets) -> View<'d> {
    let mut v = View::default();
    let Some(mut o) = walk.object(walk.root, String::new()) else { return v };
    let version = o.get("version");
    v.version = walk.text(version, "/version");
    v.clip_id = required(walk.need(&mut o, "clip_id").map(|n| walk.text(Some(n), "/clip_id")));
    v.scenario = match walk.need(&mut o, "scenario") {
        Some(n) => scenario::read(walk, n, "/scenario"),
        None => ScenarioView::BROKEN,
    };
    time_range(walk, &mut o, &mut v);
    keyframe(walk, &mut o, &mut v);
    decision(walk, &mut o, decisions, &mut v);
    v.components = match walk.need(&mut o, "critical_components") {
        Some(n) => components(walk, n, &mut v.linked),
        None => Slot::Broken,
    };
    // A blank trace has a rule of its own.
    v.trace = required(walk.need(&mut o, "coc_trace").map(|n| walk.any_text(Some(n), "/coc_trace")));
    v.records = records(walk, &mut o);
    v.causes = causes(walk, &mut o);
    v.second = match o.get("second_keyframe") {
        Some(n) => Slot::Is(one_keyframe(walk, n, "/second_keyframe")),
        None => Slot::Absent,
    };
    if let Slot::Is(items) = walk.list(o.get("secondary_scenarios"), "/secondary_scenarios") {
        let at = |i: usize| format!("/secondary_scenarios/{i}");
        v.secondary = items.iter().enumerate().map(|(i, n)| walk.text(Some(n), &at(i))).collect();
    }
    provenance(walk, &mut o);
    walk.close(o, Severity::Warning);
    v
}

fn required<T>(slot: Option<Slot<T>>) -> Slot<T> {
    slot.unwrap_or(Slot::Broken)
}

fn time_range<'d>(walk: &mut Walk<'d>, parent: &mut Object<'d>, v: &mut View<'d>) {
    (v.start, v.end, v.start_frame, v.end_frame) = (Slot::Broken, Slot::Broken, Slot::Broken, Slot::Broken);
    let Some(node) = walk.need(parent, "time_range") else { return };
    let Some(mut o) = walk.object(node, "/time_range".into()) else { return };
    v.start = required(
        walk.need(&mut o, "start_timestamp").map(|n| walk.time(Some(n), "/time_range/start_timestamp")),
    );
    v.end =
        required(walk.need(&mut o, "end_timestamp").map(|n| walk.time(Some(n), "/time_range/end_timestamp")));
    v.start_frame = walk.frame(o.get("start_frame_idx"), "/time_range/start_frame_idx");
    v.end_frame = walk.frame(o.get("end_frame_idx"), "/time_range/end_frame_idx");
    walk.close(o, Severity::Warning);
}

fn keyframe<'d>(walk: &mut Walk<'d>, parent: &mut Object<'d>, v: &mut View<'d>) {
    v.keyframe = match walk.need(parent, "keyframe") {
        Some(node) => one_keyframe(walk, node, "/keyframe"),
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
    let at = |key: &str| format!("{base}/{key}");
    k.timestamp = required(walk.need(&mut o, "timestamp").map(|n| walk.time(Some(n), &at("timestamp"))));
    k.frame = required(walk.need(&mut o, "frame_idx").map(|n| walk.frame(Some(n), &at("frame_idx"))));
    k.kind = required(
        walk.need(&mut o, "type").map(|n| keyframe_type(walk, n, &at("type"), "label.enum.keyframe_type")),
    );
    k.range_start = walk.time(o.get("range_start"), &at("range_start"));
    k.range_end = walk.time(o.get("range_end"), &at("range_end"));
    walk.close(o, Severity::Warning);
    k
}

fn decision<'d>(walk: &mut Walk<'d>, parent: &mut Object<'d>, decisions: &DecisionSets, v: &mut View<'d>) {
    (v.longitudinal, v.lateral, v.direction) = (Slot::Broken, Slot::Broken, Slot::Broken);
    let Some(node) = walk.need(parent, "driving_decision") else { return };
    let Some(mut o) = walk.object(node, "/driving_decision".into()) else { return };
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
    // The key must be written even when its value is null: null is a decision too (LABELING.md 2).
    v.longitudinal = required(walk.nullable(&mut o, "longitudinal").map(|n| {
        choose(walk, Some(n).filter(|n| !n.is_null()), "/driving_decision/longitudinal", &longitudinal)
    }));
    v.lateral = required(
        walk.nullable(&mut o, "lateral")
            .map(|n| choose(walk, Some(n).filter(|n| !n.is_null()), "/driving_decision/lateral", &lateral)),
    );
    v.direction = choose(walk, o.get("lateral_direction"), "/driving_decision/lateral_direction", &direction);
    walk.close(o, Severity::Warning);
}

fn both(name: &whyroad_model::Bilingual, id: &'static str) -> [(String, &'static str); 2] {
    [(name.zh.clone(), id), (name.en.to_lowercase(), id)]
}

fn components<'d>(
    walk: &mut Walk<'d>,
    node: &'d Node<'d>,
    linked: &mut Vec<LinkedComponent<'d>>,
) -> Slot<Components> {
    let Slot::Is(items) = walk.list(Some(node), "/critical_components") else { return Slot::Broken };
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
        let base = format!("/critical_components/{i}");
        let Some(mut o) = walk.object(item, base) else {
            out.any_high = true;
            continue;
        };
        let category = o.get("category");
        walk.any_text(category, &o.at("category"));
        let at = o.at("description");
        if let Some(n) = walk.need(&mut o, "description") {
            walk.text(Some(n), &at);
        }
        let at = o.at("uncertainty");
        let uncertainty = choose(walk, o.get("uncertainty"), &at, &set);
        out.any_high |= !matches!(uncertainty, Slot::Absent | Slot::Is(Uncertainty::Low));
        let at = o.at("id");
        let id = walk.text(o.get("id"), &at);
        let at = o.at("evidence_times");
        let mut evidence = Vec::new();
        if let Slot::Is(times) = walk.list(o.get("evidence_times"), &at) {
            evidence.extend(times.iter().enumerate().map(|(k, n)| walk.time(Some(n), &format!("{at}/{k}"))));
        }
        let at = o.at("linked_objects");
        if let Slot::Is(objects) = walk.list(o.get("linked_objects"), &at) {
            for (k, n) in objects.iter().enumerate() {
                walk.text(Some(n), &format!("{at}/{k}"));
            }
        }
        if !id.is_absent() || !evidence.is_empty() {
            linked.push(LinkedComponent { index: i, id, evidence });
        }
        walk.close(o, Severity::Warning);
    }
    Slot::Is(out)
}

fn records<'d>(walk: &mut Walk<'d>, parent: &mut Object<'d>) -> Slot<Vec<&'d str>> {
    let Some(node) = parent.get("records") else { return Slot::Absent };
    let Some(o) = walk.object(node, "/records".into()) else { return Slot::Broken };
    let mut filled = Vec::new();
    for e in o.entries() {
        walk.free(&e.node, &o.at(&e.key));
        let blank = match &e.node.kind {
            JsonKind::Null => true,
            JsonKind::Text(t) => t.trim().is_empty(),
            _ => false,
        };
        if !blank {
            filled.push(&*e.key);
        }
    }
    Slot::Is(filled)
}

fn causes<'d>(walk: &mut Walk<'d>, parent: &mut Object<'d>) -> Slot<CausesView<'d>> {
    let Some(node) = parent.get("causes") else { return Slot::Absent };
    let Some(mut o) = walk.object(node, "/causes".into()) else { return Slot::Broken };
    let mut channel = |walk: &mut Walk<'d>, key: &'static str| match o.get(key) {
        Some(n) => cause(walk, n, &format!("/causes/{key}")),
        None => Slot::Absent,
    };
    let view = CausesView { longitudinal: channel(walk, "longitudinal"), lateral: channel(walk, "lateral") };
    walk.close(o, Severity::Warning);
    Slot::Is(view)
}

fn cause<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>, base: &str) -> Slot<CauseView<'d>> {
    let Some(mut o) = walk.object(node, base.to_owned()) else { return Slot::Broken };
    let mut view = CauseView::default();
    let at = format!("{base}/components");
    match walk.list(o.get("components"), &at) {
        Slot::Is(ids) => {
            let text = |(i, n): (usize, &'d Node<'d>)| walk.text(Some(n), &format!("{at}/{i}"));
            view.components = ids.iter().enumerate().map(text).collect();
        }
        Slot::Broken => view.components.push(Slot::Broken),
        Slot::Absent => {}
    }
    view.unobserved = walk.text(o.get("unobserved"), &format!("{base}/unobserved"));
    walk.close(o, Severity::Warning);
    Slot::Is(view)
}

fn provenance<'d>(walk: &mut Walk<'d>, parent: &mut Object<'d>) {
    let Some(node) = parent.get("provenance") else { return };
    let Some(mut o) = walk.object(node, "/provenance".into()) else { return };
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
    if let Some(n) = walk.need(&mut o, "source") {
        choose(walk, Some(n), "/provenance/source", &set);
    }
    for key in ["by", "tool"] {
        let at = o.at(key);
        walk.text(o.get(key), &at);
    }
    walk.time(o.get("at"), "/provenance/at");
    if let Some(n) = o.get("versions")
        && let Some(versions) = walk.object(n, "/provenance/versions".into())
    {
        for e in versions.entries() {
            walk.text(Some(&e.node), &versions.at(&e.key));
        }
    }
    walk.close(o, Severity::Warning);
}
