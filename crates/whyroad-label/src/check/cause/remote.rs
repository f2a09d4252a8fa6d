//! A cause that is far from the decision in time or space: a date, a number of days or years, kilometers, the junction
//! after the next. The ego responds to what is near (LABELING.md 6, proximate cause).

use crate::check::consistency::trace::Reading;
use crate::check::consistency::trace_rules;
use crate::check::overlap;
use crate::check::texts::TextScope;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_framework::label_words::Divider;
use whyroad_model::decision::Lateral;
use whyroad_model::label_fields::pointer;

/// No text refers to a distant time or place, except for a route. Returns true when one does.
/// `reading`: the decisions that the trace names.
pub(in crate::check) fn remote(
    scope: &TextScope<'_>,
    reading: Option<&Reading>,
    sink: &mut dyn Sink,
) -> bool {
    let TextScope { label, texts, words, lexicon, .. } = *scope;
    // A lane change or a turn may be prepared because of a route far ahead.
    let by_route =
        label.lateral.get().is_some_and(|l| !matches!(l, Lateral::LaneKeeping | Lateral::InLaneNudge));
    let parts = label.parts.iter().zip(&texts.components).map(|(c, f)| {
        (pointer::critical_components_item_description(c.index), c.description.get(), f, false)
    });
    let trace = std::iter::once((pointer::COC_TRACE.to_owned(), label.trace.get(), &texts.trace, true));
    let found = parts.chain(trace).find_map(|(at, text, facts, is_trace)| {
        let text = text?;
        let (start, end) = words.remote.find(text)?;
        // "Last night a gale blew, a tree is down across our lane": how what the components name came about.
        if is_trace && is_past(&text[start..]) {
            let clause =
                |at: usize| words.clauses.around(&texts.units, at..at, text.len(), &|d| d != Divider::Aside);
            let (from, to) = clause(start);
            let decides = |at: usize| {
                let (from, to) = clause(at);
                reading.is_some_and(|r| trace_rules::states_decision(r, lexicon, label, from, to))
            };
            let is_common = |at: usize| words.subjects.is_common(text, at);
            let near = |at: usize| !(from..to).contains(&at) && !is_common(at) && !decides(at);
            let least = if text.is_ascii() { 1 } else { 2 };
            if overlap::shared(label, text, &words.compared, &near) >= least {
                return None;
            }
        }
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

/// A time that has passed, rather than a distance: "ten miles ago", "昨晚".
fn is_past(text: &str) -> bool {
    let lower = text.to_ascii_lowercase();
    let mut words = lower.split(|c: char| !c.is_ascii_alphabetic()).filter(|w| !w.is_empty()).take(3);
    text.starts_with(['昨', '前', '去', '上', '年', '天', '周', '月', '早'])
        || words.any(|w| ["ago", "yesterday", "last", "since"].contains(&w))
}
