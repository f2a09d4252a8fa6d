//! The kinds of documents, distinguished by their outer key.

use crate::check::finding::{Finding, Sink, Words};
use crate::check::json::Node;
use crate::check::walk::Walk;
use crate::taxonomy::did_you_mean;

/// The kinds of document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MessageKind {
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

pub(super) const OUTER: &[(&str, MessageKind)] = &[
    ("scenario_label", MessageKind::ScenarioLabel),
    ("clip_metadata", MessageKind::ClipMetadata),
    ("scenario_pre_label", MessageKind::ScenarioPreLabel),
    ("keyframe_suggestion", MessageKind::KeyframeSuggestion),
    ("mining_query", MessageKind::MiningQuery),
    ("mining_result", MessageKind::MiningResult),
];

impl MessageKind {
    /// Its outer key; a label has none and is called `coc_label`.
    pub fn id(self) -> &'static str {
        OUTER.iter().find(|(_, k)| *k == self).map_or("coc_label", |(key, _)| key)
    }
}

/// Any of these makes a document a label, even if all other fields are missing. A clip and a time alone do not: other
/// tables have those too.
const LABEL_KEYS: &[&str] = &["coc_trace", "driving_decision", "critical_components", "scenario"];

/// What kind of document this is, by its keys.
pub fn kind_of(root: &Node<'_>) -> Option<MessageKind> {
    let entries = root.entries()?;
    let has = |key: &str| entries.iter().any(|e| e.key == key);
    OUTER
        .iter()
        .find(|(key, _)| has(key))
        .map(|(_, kind)| *kind)
        .or_else(|| LABEL_KEYS.iter().any(|k| has(k)).then_some(MessageKind::CocLabel))
}

/// The suggested outer key for an unknown key with an object in it.
fn meant(root: &Node<'_>) -> Option<&'static str> {
    let outer = root.entries().unwrap_or_default().iter().filter(|e| e.node.entries().is_some());
    outer.filter_map(|e| did_you_mean(&e.key, OUTER.iter().map(|(o, _)| *o))).next()
}

/// Reports a document of no known kind; true when it does not even resemble one.
pub fn unknown(walk: &mut Walk<'_>) -> bool {
    let root = walk.root;
    let meant = meant(root);
    walk.report(Finding::error("message.kind", ""), &|| {
        let words = match root.entries() {
            Some([]) => Words::new("空对象，不是任何一种消息", "an empty object is not a message"),
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
