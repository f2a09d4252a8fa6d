//! Texts against what could be known (LABELING.md 3, 6 and 7): no hindsight, no circle, a reason for UNOBSERVED, the
//! proximate cause, and a cause of the kind that the decision has.

use crate::check::consistency::trace_rules::decision_name;
use crate::check::overlap;
use crate::check::reading::{Named, TextFacts};
use crate::check::texts::Texts;
use crate::check::view::View;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_framework::label_words::{GroupSet, SaidState};
use whyroad_framework::{DecisionSets, LabelWords};
use whyroad_model::decision::Longitudinal;
use whyroad_model::label_fields::pointer;

/// What was only known after the keyframe. `after`: bytes of what the trace tells after its decision.
pub(in crate::check) fn hindsight(
    label: &View<'_>,
    texts: &Texts,
    after: Option<(usize, usize)>,
    sink: &mut dyn Sink,
) {
    let report = |sink: &mut dyn Sink, at: String, text: &str, (start, end): (usize, usize)| {
        sink.report(Finding::error("label.text.hindsight", at).part(start, end), &|| {
            let phrase = text[start..end].trim();
            Words::new(
                format!("“{phrase}”说的是关键帧之后才知道的事"),
                format!("'{phrase}' speaks of what was only known after the keyframe"),
            )
            .hint(
                "只写关键帧当时或之前看得到的内容；因果描述以决策结尾",
                "write only what could be seen at or before the keyframe; the trace ends with the decision",
            )
        });
    };
    for (c, facts) in label.parts.iter().zip(&texts.components) {
        let Some(text) = c.description.get() else { continue };
        if let Some(at) = facts.hindsight.or(facts.after_response) {
            return report(sink, pointer::critical_components_item_description(c.index), text, at);
        }
    }
    if let (Some(text), Some(at)) = (label.trace.get(), texts.trace.hindsight.or(after)) {
        report(sink, pointer::COC_TRACE.to_owned(), text, at);
    }
}

/// UNOBSERVED says why.
pub(in crate::check) fn unobserved(label: &View<'_>, words: &LabelWords, sink: &mut dyn Sink) {
    let Slot::Is(causes) = &label.causes else { return };
    let channels = [
        (&causes.longitudinal, pointer::CAUSES_LONGITUDINAL_UNOBSERVED),
        (&causes.lateral, pointer::CAUSES_LATERAL_UNOBSERVED),
    ];
    for (cause, at) in channels {
        let Slot::Is(cause) = cause else { continue };
        let Some(text) = cause.unobserved.get() else { continue };
        if words.is_empty()
            || (words.gives_reason(text) && text.chars().count() >= 5 && !words.is_placeholder(text))
        {
            continue;
        }
        sink.report(Finding::error("label.cause.unobserved", at), &|| {
            Words::new(
                format!("“{text}”没有说明为什么看不到原因"),
                format!("'{text}' does not say why the cause could not be observed"),
            )
            .hint(
                "写明原因在哪里、为何看不到，例如“原因在画面之外，摄像头没有拍到”",
                "say where the cause is and why it cannot be seen, such as \"outside the field of view of the cameras\"",
            )
        });
    }
}

/// A stopped lead stands between the ego and the light (LABELING.md 6, proximate cause).
pub(in crate::check) fn proximate(label: &View<'_>, texts: &Texts, words: &LabelWords, sink: &mut dyn Sink) {
    if label.longitudinal != Slot::Is(Longitudinal::StopForRegulation) {
        return;
    }
    let group = |id: &str| words.kinds.get(id).copied().unwrap_or_default();
    let (lead, queue, vehicle) = (group("lead"), group("queue"), group("vehicle"));
    let elsewhere = group("oncoming").with(group("parked_vehicle")).with(group("broken_down"));
    let holds = |n: &Named| {
        let own = words.objects[n.group].own;
        let is_lead =
            own.meets(lead) || (n.ahead && n.side.is_none() && own.meets(vehicle) && !own.meets(elsewhere));
        own.meets(queue) || (is_lead && matches!(n.state, Some(SaidState::Standing | SaidState::Slowing)))
    };
    let component = texts.components.iter().position(|f| f.there().any(holds));
    let named = texts.trace.there().find(|n| holds(n)).map(|n| (n.start, n.end));
    let (which, at) = match (component, named) {
        (Some(i), _) => (label.parts.get(i).and_then(|c| c.description.get()), None),
        (None, Some(at)) => (label.trace.get().map(|t| &t[at.0..at.1]), Some(at)),
        (None, None) => return,
    };
    let finding = match at {
        None => Finding::warning("label.cause.proximate", pointer::DRIVING_DECISION_LONGITUDINAL),
        Some((start, end)) => Finding::warning("label.cause.proximate", pointer::COC_TRACE).part(start, end),
    };
    sink.report(finding, &|| {
        let which = which.unwrap_or_default();
        Words::new(
            format!("近因是前车（“{which}”），不是它前方的信号灯或停止线"),
            format!("the proximate cause is the lead ('{which}'), not the light or line beyond it"),
        )
        .hint(
            "停在前车之后是“跟车”；自车是头车时，删去前车这一要素",
            "stopping behind a lead is lead following; where the ego is first in line, leave the lead out",
        )
    });
}

/// The trace gives a reason that is not the decision again.
pub(in crate::check) fn circular(
    label: &View<'_>,
    texts: &Texts,
    words: &LabelWords,
    decision_in: &dyn Fn(usize, usize) -> bool,
    sink: &mut dyn Sink,
) -> bool {
    let Some(text) = label.trace.get() else { return false };
    if words.is_empty() || gives_cause(text, &texts.trace, words, decision_in) {
        return false;
    }
    // What no list knows may still be a cause: words that the components have, apart from those of the decision.
    let apart = |at: usize| !decision_in(at.saturating_sub(6), at + 6);
    if overlap::shared(label, text, &apart) >= if text.is_ascii() { 1 } else { 2 }
        || overlap::says_more(text, &apart)
    {
        return false;
    }
    sink.report(Finding::warning("label.cause.circular", pointer::COC_TRACE), &|| {
        Words::new(
            "因果描述没有给出原因：只是把决策又说了一遍",
            "the trace gives no reason: it only states the decision again",
        )
        .hint("写出看到了什么、它为什么要求这个决策", "write what was seen and why it calls for the decision")
    });
    true
}

/// Words that are followed by the reason, wherever they are.
const BECAUSE: [&str; 9] =
    ["因为", "由于", "鉴于", "考虑到", "because", "since ", "due to", "owing to", "given that"];

/// With these a part says what the ego has to do or wants, and no cause of it.
const OWN_DUTY: [&str; 26] = [
    "自车要",
    "自车需",
    "自车应",
    "自车必须",
    "自车得",
    "自车想",
    "自车打算",
    "自车准备",
    "自车判断",
    "自车决定",
    "本车要",
    "本车需",
    "本车应",
    "需要",
    "应该",
    "the ego has to",
    "the ego needs to",
    "the ego must",
    "the ego should",
    "the ego wants to",
    "the ego is going to",
    "the ego intends to",
    "the ego decides to",
    "we have to",
    "we need to",
    "we must",
];

/// Some part of the text names a cause and is not the decision itself.
fn gives_cause(
    text: &str,
    facts: &TextFacts,
    words: &LabelWords,
    decision_in: &dyn Fn(usize, usize) -> bool,
) -> bool {
    let group = |id: &str| words.kinds.get(id).copied().unwrap_or_default();
    let no_cause = group("gap").with(group("lane"));
    let mut bounds: Vec<usize> = vec![0];
    for (at, c) in text.char_indices() {
        if matches!(c, '，' | '。' | '；' | '：' | '！' | ',' | '.' | ';' | ':' | '!') {
            bounds.push(at + c.len_utf8());
        }
    }
    bounds.push(text.len());
    let part_gives = |w: &[usize]| {
        let (from, to) = (w[0], w[1]);
        let names = facts
            .named
            .iter()
            .any(|n| (from..to).contains(&n.start) && !words.objects[n.group].own.meets(no_cause));
        names && !decision_in(from, to) && !is_own_duty(&text[from..to])
    };
    if bounds.windows(2).any(part_gives) {
        return true;
    }
    // Most traces end here. Otherwise the reason may stand in one part with the decision: "slows because of the bend".
    let lower = text.to_ascii_lowercase();
    for word in BECAUSE.iter().chain(&[" and ", " but ", " while "]) {
        bounds.extend(lower.match_indices(word).map(|(at, _)| at));
    }
    bounds.sort_unstable();
    bounds.windows(2).any(part_gives)
}

/// A part that says what the ego has to do or wants.
fn is_own_duty(part: &str) -> bool {
    let begins =
        |text: &str, word: &str| text.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word));
    let part = part.trim_start_matches(|c: char| !c.is_alphanumeric());
    let because = BECAUSE.iter().find(|w| begins(part, w));
    let part = because.map_or(part, |w| part[w.len()..].trim_start());
    OWN_DUTY.iter().any(|w| begins(part, w))
}

/// Kinds of things that bring about a longitudinal decision, by the names of schema/label_words.yaml; none where
/// anything can.
fn kinds_of(decision: Longitudinal) -> &'static [&'static str] {
    match decision {
        Longitudinal::YieldToAgent => &["vehicle", "vru", "animal"],
        Longitudinal::LeadFollowing => &["vehicle", "vru", "weather"],
        Longitudinal::StopForRegulation => &[
            "light",
            "sign",
            "facility",
            "stop_line",
            "crosswalk",
            "waiting_area",
            "route",
            "junction",
            "site",
        ],
        Longitudinal::StopForObstacle => &["obstacle", "site", "vehicle", "animal", "vru", "road_kind"],
        Longitudinal::RoadSpeedAdaptation => &[
            "road_shape",
            "surface",
            "weather",
            "lighting",
            "occlusion",
            "ramp",
            "roundabout",
            "junction",
            "crosswalk",
            "site",
            "sign",
            "facility",
            "route",
            "obstacle",
            "roadside",
        ],
        Longitudinal::AccelerationForPassing => &["vehicle", "vru"],
        _ => &[],
    }
}

/// The components that are named as the cause of the longitudinal decision speak of something that can cause it.
pub(in crate::check) fn kind(
    label: &View<'_>,
    texts: &Texts,
    words: &LabelWords,
    names: &DecisionSets,
    sink: &mut dyn Sink,
) {
    let Some(decision) = label.longitudinal.get() else { return };
    let wanted = kinds_of(decision)
        .iter()
        .filter_map(|k| words.kinds.get(*k))
        .fold(GroupSet::default(), |set, k| set.with(*k));
    if wanted.is_empty() || texts.components.is_empty() {
        return;
    }
    let Slot::Is(causes) = &label.causes else { return };
    let Slot::Is(cause) = &causes.longitudinal else { return };
    let named: Vec<usize> = cause
        .components
        .iter()
        .filter_map(|id| label.parts.iter().position(|c| c.id.get().is_some() && c.id.get() == id.get()))
        .collect();
    let known = |i: usize| !texts.components[i].groups.is_empty();
    // Whoever stands in the way is an obstacle, to go slowly past.
    let stands = |i: usize| {
        decision == Longitudinal::RoadSpeedAdaptation
            && texts.components[i].there().any(|n| n.state == Some(SaidState::Standing))
    };
    let fits = |i: usize| texts.components[i].groups.meets(wanted) || stands(i);
    if named.is_empty() || named.iter().any(|&i| fits(i) || !known(i)) {
        return;
    }
    sink.report(Finding::warning("label.cause.kind", pointer::CAUSES_LONGITUDINAL), &|| {
        let which = label.parts[named[0]].description.get().unwrap_or_default();
        let name = decision_name(decision.id(), names);
        Words::new(
            format!("“{which}”不会引起“{}”", name.zh),
            format!("'{which}' does not bring about '{}'", name.en),
        )
        .hint(
            "关联真正引起该决策的要素，或检查决策",
            "name the component that causes the decision, or check the decision",
        )
    });
}
