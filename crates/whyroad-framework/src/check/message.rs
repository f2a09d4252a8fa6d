//! The messages that are not labels (DATA_FORMAT.md 2.2, 3 and 5). A fast path is not needed: there are never
//! gigabytes of them.

mod kind;
mod query;
mod result;
mod task;
mod values;

pub use kind::{MessageKind, kind_of, unknown};

use super::class_index::ClassIndex;
use super::scenario;
use super::walk::{LABEL, MESSAGE, Walk};
use kind::OUTER;
use whyroad_model::Severity;

/// Checks a message with an outer key.
pub fn check(walk: &mut Walk<'_>, kind: MessageKind, classes: &ClassIndex) {
    let Some((key, _)) = OUTER.iter().find(|(_, k)| *k == kind) else { return };
    walk.family = if kind == MessageKind::ScenarioLabel { &LABEL } else { &MESSAGE };
    let root = walk.root;
    let Some(mut outer) = walk.object(root, String::new()) else { return };
    let inner = walk.need(&mut outer, key);
    if matches!(kind, MessageKind::ScenarioPreLabel | MessageKind::KeyframeSuggestion) {
        // In a file of many, which episode and clip a proposal is about.
        for key in ["episode_id", "clip_id"] {
            let (n, at) = (outer.get(key), outer.at(key));
            walk.text(n, &at);
        }
    }
    walk.close(outer, Severity::Warning);
    let Some(inner) = inner else { return };
    match kind {
        MessageKind::ScenarioLabel => {
            let s = scenario::read(walk, inner, "/scenario_label");
            scenario::check(&s, classes, "/scenario_label", walk);
        }
        MessageKind::ClipMetadata => task::clip_metadata(walk, inner, classes),
        MessageKind::ScenarioPreLabel => task::scenario_pre_label(walk, inner, classes),
        MessageKind::KeyframeSuggestion => task::keyframe_suggestion(walk, inner),
        MessageKind::MiningQuery => query::query(walk, inner, classes),
        MessageKind::MiningResult => result::result(walk, inner, classes),
        MessageKind::CocLabel => {}
    }
}
