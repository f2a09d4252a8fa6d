//! A second action of the ego after its decision: "gives way, then reverses". The decision is the first action after
//! the keyframe (LABELING.md 2), so a trace ends with it.

use crate::check::consistency::trace::{Force, Mention, Reading};
use crate::check::reading::Named;
use crate::check::texts::TextScope;
use whyroad_framework::DecisionSets;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_framework::decision_table::{ClassDecisions, Fit};
use whyroad_framework::label_words::Divider;
use whyroad_model::decision::{Lateral, LateralDirection};
use whyroad_model::label_fields::pointer;

/// No further action of the ego follows the decision, unless it is part of the class: a maneuver of another kind.
/// Returning to the lane, or continuing the turn of the class, is part of the decision. Returns true when there is one.
pub(super) fn second_action(
    scope: &TextScope<'_>,
    reading: &Reading,
    class: Option<&ClassDecisions>,
    names: &DecisionSets,
    says: &dyn Fn(&Mention) -> bool,
    sink: &mut dyn Sink,
) -> bool {
    let TextScope { label, lexicon, .. } = *scope;
    let Some(text) = label.trace.get() else { return false };
    let decides = |m: &&Mention| !m.later && matches!(m.force, Force::Asserted | Force::Doubtful) && says(m);
    // "Off the power first": by a stem, if no phrase matches.
    let later = reading.mentions.iter().find(|m| m.later).map_or(0, |m| m.start);
    let by_stem = || lexicon.stems.find(text.get(..later)?, label.longitudinal.get(), label.lateral.get());
    let Some(decided) = reading.mentions.iter().find(decides).map(|m| m.end).or_else(by_stem) else {
        return beside_driving(scope, reading, sink);
    };
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
        let of_the_class = turns && m.side.is_some();
        // Pulling over is a movement to the side, too.
        let pulls_over = own == Some(Lateral::PullOver) && phrase.lateral.len() > 1;
        let of_a_lane = !pulls_over && phrase.longitudinal.is_empty() && !phrase.lateral.iter().any(part);
        of_a_lane && !of_the_class && !phrase.supports_only
    };
    let is_second = |m: &&Mention| m.later && m.start >= decided && !says(m) && is_other(m);
    let Some(m) = reading.mentions.iter().find(is_second) else {
        return beside_driving(scope, reading, sink);
    };
    let says = lexicon.phrases[m.phrase].lateral[0];
    sink.report(Finding::warning("label.trace.unlabelled", pointer::COC_TRACE).part(m.start, m.end), &|| {
        let (phrase, name) = (&text[m.start..m.end], names.name(says.id()));
        Words::new(
            format!("因果描述在决策之后又说“{phrase}”（{}）：标注只写关键帧之后的第一个动作", name.zh),
            format!(
                "after the decision the trace continues with '{phrase}' ({}): a label has only the first action",
                name.en
            ),
        )
        .hint("删去后面的动作", "remove the later action")
    });
    true
}

/// The trace states that the ego sounds its horn, flashes its lights or switches its engine off: in its last clause, or
/// in one that names no other road user.
fn beside_driving(scope: &TextScope<'_>, reading: &Reading, sink: &mut dyn Sink) -> bool {
    let TextScope { label, texts, words, lexicon, .. } = *scope;
    let Some(text) = label.trace.get() else { return false };
    let lower = text.to_ascii_lowercase();
    let end = reading.end.min(text.len());
    let begin = reading.decision_from.min(end);
    let all = lexicon.beside_driving.everywhere(&lower);
    let of_ego = |(at, w): &(usize, &str)| {
        let (from, _) = words.clauses.around(&texts.units, *at..*at + w.len(), text.len(), &|d| {
            d != Divider::Aside && d != Divider::Item
        });
        let acts = |n: &Named| words.objects[n.group].own.meets(words.known.actor);
        let other = texts.trace.named.iter().any(|n| (from..*at).contains(&n.start) && acts(n));
        let denied = ["不", "没", "别", "without", "not ", "no "];
        let before = &lower[from..*at];
        // "A van that has its hazards on".
        let is_kind = text[*at + w.len()..].starts_with('的');
        // "Sounding the horn would only scare them": what it would do.
        let is_topic = text[*at + w.len()..]
            .starts_with(['也', '反', '又', '怕', '会', '就', '更', '只', '没', '不', '都', '是']);
        // "In passing it also shifts a little to the left": the label's decision.
        let to = words.clauses.clause_end(&texts.units, *at + w.len(), text.len());
        let only_adds = ["顺", "捎", "on the side", "while "].iter().any(|a| w.starts_with(a));
        let rest = &text[*at + w.len()..to];
        let side = match label.direction.get() {
            Some(LateralDirection::Left) => ["左", "left"],
            Some(LateralDirection::Right) => ["右", "right"],
            _ => ["掉头", "u-turn"],
        };
        let decided = |rest: &str| {
            let stem = lexicon.stems.find(rest, label.longitudinal.get(), label.lateral.get());
            stem.is_some() || label.lateral.get().is_some() && side.iter().any(|s| rest.contains(s))
        };
        let own = only_adds && decided(rest);
        *at >= begin && !other && !is_kind && !is_topic && !own && !denied.iter().any(|d| before.contains(d))
    };
    let Some((start, word)) = all.into_iter().find(of_ego) else { return false };
    sink.report(
        Finding::warning("label.trace.unlabelled", pointer::COC_TRACE).part(start, start + word.len()),
        &|| {
            Words::new(
                format!("因果描述说自车“{word}”，这不是任何驾驶决策"),
                format!("the trace says '{word}' about the ego, which is not a driving decision"),
            )
            .hint(
                "因果描述以决策结尾，删去别的动作",
                "the trace ends with the decision: remove other actions",
            )
        },
    );
    true
}
