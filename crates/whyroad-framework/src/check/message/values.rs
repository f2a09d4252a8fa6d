//! Values that several messages have: shares, ranges of time, ids of classes.

use crate::check::class_index::{ClassIndex, OTHER};
use crate::check::closed_set::keyframe_type;
use crate::check::finding::{Finding, Sink, Words};
use crate::check::json::Node;
use crate::check::scenario::{self, ScenarioView};
use crate::check::slot::Slot;
use crate::check::walk::Walk;
use whyroad_model::Nanos;
use whyroad_model::messages::KeyframeType;

/// A number between 0 and 1.
pub(super) fn share<'d>(walk: &mut Walk<'d>, node: Option<&'d Node<'d>>, pointer: &str) {
    if let Slot::Is(v) = walk.number(node, pointer)
        && !(0.0..=1.0).contains(&v)
    {
        out_of_range(walk, pointer, &format!("{v}"), "0 至 1", "0 to 1");
    }
}

pub(super) fn out_of_range(walk: &mut Walk<'_>, pointer: &str, found: &str, zh: &str, en: &str) {
    walk.report(Finding::error("message.range", pointer.to_owned()), &|| {
        Words::new(format!("{found} 超出范围（{zh}）"), format!("{found} is out of range ({en})"))
    });
}

/// The ids of a class that may be less than a leaf: L1 and L2 there, L3 perhaps.
pub(super) fn partial_class<'d>(s: ScenarioView<'d>, base: &str, classes: &ClassIndex, walk: &mut Walk<'d>) {
    scenario::check(&s, classes, base, walk);
}

/// A full or partial id in one text, such as `reactive_agent.cutin`; or `other`, where its L1 is not decided yet:
/// mining counts decision moments that no class explains this way.
pub(super) fn scenario_id<'d>(
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
                format!("'{text}' is not a scenario id, which has at most three parts (l1.l2.l3)"),
            )
        });
        return;
    }
    let view = ScenarioView { l1: l1.into(), l2: l2.into(), l3: l3.into(), full_id: Slot::Absent };
    let mut aside = At { pointer, walk };
    scenario::check(&view, classes, "", &mut aside);
}

/// Moves findings about parts of an id to the text that holds the whole id.
struct At<'w, 'd> {
    pointer: &'static str,
    walk: &'w mut Walk<'d>,
}

impl Sink for At<'_, '_> {
    fn report(&mut self, finding: Finding, words: &dyn Fn() -> Words) {
        self.walk.report(Finding { pointer: self.pointer.into(), ..finding }, words);
    }
}

/// True when start is before end; reports them otherwise.
pub(super) fn ordered(walk: &mut Walk<'_>, pointer: &str, start: Slot<Nanos>, end: Slot<Nanos>) -> bool {
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

pub(super) fn suggested_type<'d>(
    walk: &mut Walk<'d>,
    node: Option<&'d Node<'d>>,
    pointer: &str,
) -> Slot<KeyframeType> {
    node.map_or(Slot::Broken, |n| keyframe_type(walk, n, pointer, "message.enum"))
}
