//! A cause that is far from the decision in time or space: a date, a number of days or years, kilometers, the junction
//! after the next. The ego responds to what is near (LABELING.md 6, proximate cause).

use crate::check::texts::TextScope;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_model::decision::Lateral;
use whyroad_model::label_fields::pointer;

/// No text refers to a distant time or place, except for a route. Returns true when one does.
pub(in crate::check) fn remote(scope: &TextScope<'_>, sink: &mut dyn Sink) -> bool {
    let TextScope { label, texts, words, .. } = *scope;
    // A lane change or a turn may be prepared because of a route far ahead.
    let by_route =
        label.lateral.get().is_some_and(|l| !matches!(l, Lateral::LaneKeeping | Lateral::InLaneNudge));
    let parts = label
        .parts
        .iter()
        .zip(&texts.components)
        .map(|(c, f)| (pointer::critical_components_item_description(c.index), c.description.get(), f));
    let trace = std::iter::once((pointer::COC_TRACE.to_owned(), label.trace.get(), &texts.trace));
    let found = parts.chain(trace).find_map(|(at, text, facts)| {
        let text = text?;
        let (start, end) = words.remote.find(text)?;
        (!(by_route && facts.groups.meets(words.known.route))).then_some((at, text, start, end))
    });
    let Some((at, text, start, end)) = found else { return false };
    sink.report(Finding::warning("label.cause.proximate", at).part(start, end), &|| {
        let phrase = &text[start..end];
        Words::new(
            format!("“{phrase}”离决策的时刻或地点太远，不会引起这次决策"),
            format!("'{phrase}' is too far from the time or the place of the decision to cause it"),
        )
        .hint("只写眼前直接引起决策的要素", "write only what is near and causes the decision")
    });
    true
}
