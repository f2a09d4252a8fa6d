//! The slow path for the messages that are no labels (DATA_FORMAT.md 2.2, 3 and 5): told apart by their outer
//! key. There is no fast path; nobody checks gigabytes of these.

mod query;
mod result;
mod task;

use super::class_index::{ClassIndex, OTHER};
use super::json::Node;
use super::label;
use super::rules::{self, Finding, Sink, Words};
use super::view::{ScenarioView, Slot};
use super::walk::{LABEL, MESSAGE, Walk};
use whyroad_framework::taxonomy::did_you_mean;
use whyroad_model::messages::KeyframeType;
use whyroad_model::{Nanos, Severity};

/// The kinds of document that are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A CoC label (DATA_FORMAT.md 4), the only one without an outer key.
    CocLabel,
    /// `scenario_label` (2.2).
    ScenarioLabel,
    /// `clip_metadata` (3.1).
    ClipMetadata,
    /// `scenario_pre_label` (3.2).
    ScenarioPreLabel,
    /// `keyframe_suggestion` (3.3).
    KeyframeSuggestion,
    /// `mining_query` (5.1).
    MiningQuery,
    /// `mining_result` (5.2).
    MiningResult,
}

const OUTER: &[(&str, Kind)] = &[
    ("scenario_label", Kind::ScenarioLabel),
    ("clip_metadata", Kind::ClipMetadata),
    ("scenario_pre_label", Kind::ScenarioPreLabel),
    ("keyframe_suggestion", Kind::KeyframeSuggestion),
    ("mining_query", Kind::MiningQuery),
    ("mining_result", Kind::MiningResult),
];

/// Any of these makes a document a label, however much else is missing. A clip and a time alone do not: other
/// tables speak of those too.
const LABEL_KEYS: &[&str] = &["coc_trace", "driving_decision", "critical_components", "scenario"];

/// What kind of document this is, by its keys.
pub(super) fn kind_of(root: &Node<'_>) -> Option<Kind> {
    let entries = root.entries()?;
    let has = |key: &str| entries.iter().any(|e| e.key == key);
    OUTER
        .iter()
        .find(|(key, _)| has(key))
        .map(|(_, kind)| *kind)
        .or_else(|| LABEL_KEYS.iter().any(|k| has(k)).then_some(Kind::CocLabel))
}

/// The outer key that a key with an object in it was probably meant to be.
fn meant(root: &Node<'_>) -> Option<&'static str> {
    let outer = root.entries().unwrap_or_default().iter().filter(|e| e.node.entries().is_some());
    outer.filter_map(|e| did_you_mean(&e.key, OUTER.iter().map(|(o, _)| *o))).next()
}

/// Reports a document of no known kind; true when it does not even resemble one.
pub(super) fn unknown(walk: &mut Walk<'_>) -> bool {
    let root = walk.root;
    let meant = meant(root);
    walk.report(Finding::error("message.kind", ""), &|| {
        let words = match root.entries() {
            Some([]) => Words::new("空对象，不是任何一种消息", "an empty object is no message"),
            Some(_) => Words::new(
                "无法识别的文档：既不是 CoC 标注，也没有已知的外层键",
                "not a known document: neither a CoC label nor a message with a known outer key",
            ),
            None => Words::new("文档应为一个 JSON 对象", "a document is one JSON object"),
        };
        let all = || OUTER.iter().map(|(o, _)| *o).collect::<Vec<_>>();
        match meant {
            Some(near) => words.meant(near),
            None => words.hint(
                format!("已知的外层键：{}", all().join("、")),
                format!("known outer keys: {}", all().join(", ")),
            ),
        }
    });
    meant.is_none()
}

/// Checks a message with an outer key.
pub(super) fn check(walk: &mut Walk<'_>, kind: Kind, classes: &ClassIndex) {
    let Some((key, _)) = OUTER.iter().find(|(_, k)| *k == kind) else { return };
    walk.family = if kind == Kind::ScenarioLabel { &LABEL } else { &MESSAGE };
    let root = walk.root;
    let Some(mut outer) = walk.object(root, String::new()) else { return };
    let inner = walk.need(&mut outer, key);
    if matches!(kind, Kind::ScenarioPreLabel | Kind::KeyframeSuggestion) {
        // In a file of many, which episode and clip a proposal is about.
        for key in ["episode_id", "clip_id"] {
            let (n, at) = (outer.get(key), outer.at(key));
            walk.text(n, &at);
        }
    }
    walk.close(outer, Severity::Warning);
    let Some(inner) = inner else { return };
    match kind {
        Kind::ScenarioLabel => {
            let s = label::scenario(walk, inner, "/scenario_label");
            rules::scenario(&s, classes, "/scenario_label", walk);
        }
        Kind::ClipMetadata => task::clip_metadata(walk, inner, classes),
        Kind::ScenarioPreLabel => task::scenario_pre_label(walk, inner, classes),
        Kind::KeyframeSuggestion => task::keyframe_suggestion(walk, inner),
        Kind::MiningQuery => query::query(walk, inner, classes),
        Kind::MiningResult => result::result(walk, inner, classes),
        Kind::CocLabel => {}
    }
}

/// A number between 0 and 1.
fn share<'d>(walk: &mut Walk<'d>, node: Option<&'d Node<'d>>, pointer: &str) {
    if let Slot::Is(v) = walk.number(node, pointer)
        && !(0.0..=1.0).contains(&v)
    {
        out_of_range(walk, pointer, &format!("{v}"), "0 至 1", "0 to 1");
    }
}

fn out_of_range(walk: &mut Walk<'_>, pointer: &str, found: &str, zh: &str, en: &str) {
    walk.report(Finding::error("message.range", pointer.to_owned()), &|| {
        Words::new(format!("{found} 超出范围（{zh}）"), format!("{found} is out of range ({en})"))
    });
}

/// The ids of a class that may be less than a leaf: L1 and L2 there, L3 perhaps.
fn partial_class<'d>(s: ScenarioView<'d>, base: &'static str, classes: &ClassIndex, walk: &mut Walk<'d>) {
    rules::scenario(&s, classes, base, walk);
}

/// A full or partial id in one text, such as `reactive_agent.cutin`; or `other`, where nobody has said yet under which L1 it
/// belongs: mining counts decision moments that no class explains so.
fn scenario_id<'d>(
    walk: &mut Walk<'d>,
    node: Option<&'d Node<'d>>,
    pointer: &'static str,
    classes: &ClassIndex,
) {
    let Slot::Is(text) = walk.text(node, pointer) else { return };
    if text == OTHER {
        return;
    }
    let mut parts = text.split('.');
    let (l1, l2, l3, more) = (parts.next(), parts.next(), parts.next(), parts.next());
    if more.is_some() {
        walk.report(Finding::error("label.scenario.unknown", pointer), &|| {
            Words::new(
                format!("'{text}' 不是场景 ID：最多三段（l1.l2.l3）"),
                format!("'{text}' is no scenario id, which has at most three parts (l1.l2.l3)"),
            )
        });
        return;
    }
    let view = ScenarioView { l1: l1.into(), l2: l2.into(), l3: l3.into(), full_id: Slot::Absent };
    let mut aside = At { pointer, walk };
    rules::scenario(&view, classes, "", &mut aside);
}

/// Moves findings about parts of an id to the text that holds the whole of it.
struct At<'w, 'd> {
    pointer: &'static str,
    walk: &'w mut Walk<'d>,
}

impl Sink for At<'_, '_> {
    fn report(&mut self, finding: Finding, words: &dyn Fn() -> Words) {
        self.walk.report(Finding { pointer: self.pointer.into(), ..finding }, words);
    }
}

/// A list of clip or a suggestion's times: start before end, moment inside.
fn ordered(walk: &mut Walk<'_>, pointer: &str, start: Slot<Nanos>, end: Slot<Nanos>) -> bool {
    let (Some(start), Some(end)) = (start.get(), end.get()) else { return false };
    if start < end {
        return true;
    }
    walk.report(Finding::error("message.order", pointer.to_owned()), &|| {
        Words::new(
            format!("结束 {end} 不晚于开始 {start}"),
            format!("the end {end} is not after the start {start}"),
        )
    });
    false
}

fn suggested_type<'d>(walk: &mut Walk<'d>, node: Option<&'d Node<'d>>, pointer: &str) -> Slot<KeyframeType> {
    node.map_or(Slot::Broken, |n| label::keyframe_type(walk, n, pointer, "message.enum"))
}
