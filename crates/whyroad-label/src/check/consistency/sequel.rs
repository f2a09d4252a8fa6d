//! A second action of the ego behind its decision: "gives way, then reverses". The decision is the first action after the
//! keyframe (LABELING.md 2), so that a trace ends with it.

use crate::check::consistency::trace::{Force, Mention, Reading};
use crate::check::consistency::trace_rules;
use crate::check::texts::TextScope;
use whyroad_framework::DecisionSets;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_framework::decision_table::{ClassDecisions, Fit};
use whyroad_model::decision::Lateral;
use whyroad_model::label_fields::pointer;

/// Nothing stands behind the decision that the ego does next and that no part of the class is: a maneuver of another
/// kind. To go back to one's lane, or on with the turn of the class, is part of what was decided. True when there is one.
pub(super) fn second_action(
    scope: &TextScope<'_>,
    reading: &Reading,
    class: Option<&ClassDecisions>,
    names: &DecisionSets,
    sink: &mut dyn Sink,
) -> bool {
    let TextScope { label, lexicon, .. } = *scope;
    let Some(text) = label.trace.get() else { return false };
    let says = |m: &Mention| trace_rules::says_label(m, lexicon, label);
    let decides = |m: &&Mention| !m.later && matches!(m.force, Force::Asserted | Force::Doubtful) && says(m);
    let Some(decided) = reading.mentions.iter().find(decides).map(|m| m.end) else { return false };
    let own = label.lateral.get();
    let is_other = |m: &Mention| {
        let phrase = &lexicon.phrases[m.phrase];
        let part = |d: &Lateral| {
            Some(*d) == own
                || matches!(d, Lateral::LaneKeeping | Lateral::ManeuverAbort)
                || class.is_some_and(|c| c.lateral_fit(Some(*d)) == Fit::Usual)
        };
        // "Swings left behind it": the turn of the class.
        let turns = class.is_some_and(|c| c.lateral_fit(Some(Lateral::Turn)) == Fit::Usual);
        !(turns && m.side.is_some())
            && !phrase.supports_only
            && phrase.longitudinal.is_empty()
            && !phrase.lateral.iter().any(part)
    };
    let is_second = |m: &&Mention| m.later && m.start >= decided && !says(m) && is_other(m);
    let Some(m) = reading.mentions.iter().find(is_second) else { return false };
    let says = lexicon.phrases[m.phrase].lateral[0];
    sink.report(Finding::warning("label.trace.unlabelled", pointer::COC_TRACE).part(m.start, m.end), &|| {
        let (phrase, name) = (&text[m.start..m.end], names.name(says.id()));
        Words::new(
            format!("因果描述在决策之后又说“{phrase}”（{}）：标注只写关键帧之后的第一个动作", name.zh),
            format!(
                "behind the decision the trace goes on to '{phrase}' ({}): a label has the first action only",
                name.en
            ),
        )
        .hint("删去后面的动作", "leave the later action out")
    });
    true
}
