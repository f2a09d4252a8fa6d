//! Texts against what could be known (LABELING.md 3, 6 and 7): no hindsight, no circular reason, a reason for
//! UNOBSERVED, the proximate cause, and a cause of a kind that the decision can have.

use super::{disowned, flipped, grounds};
use crate::check::consistency::trace::Reading;
use crate::check::consistency::trace_rules;
use crate::check::excerpt::excerpt;
use crate::check::overlap;
use crate::check::reading::{Named, TextFacts};
use crate::check::subject;
use crate::check::texts::{TextScope, Texts};
use crate::check::view::{ComponentView, View};
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_framework::decision_table::ClassDecisions;
use whyroad_framework::label_words::{Divider, GroupSet, KnownKinds, SaidState};
use whyroad_framework::{Framework, LabelWords, Lexicon};
use whyroad_model::decision::{Lateral, Longitudinal};
use whyroad_model::label_fields::pointer;

/// Maximum number of Latin words before a road user that is only mentioned as a location: "way past the".
const MOST_WORDS_BEFORE: usize = 4;

/// Facts that became known only after the keyframe. `after`: bytes of the trace's text after its decision.
/// `reading`: the decisions that the trace names.
pub(in crate::check) fn hindsight(
    scope: &TextScope<'_>,
    reading: Option<&Reading>,
    after: Option<(usize, usize)>,
    sink: &mut dyn Sink,
) {
    let TextScope { label, texts, words, lexicon, .. } = *scope;
    let report = |sink: &mut dyn Sink, at: String, text: &str, (start, end): (usize, usize)| {
        sink.report(Finding::error("label.text.hindsight", at).part(start, end), &|| {
            let phrase = text[start..end].trim();
            Words::new(
                format!("“{phrase}”说的是关键帧之后才知道的事"),
                format!("'{phrase}' describes something that was only known after the keyframe"),
            )
            .hint(
                "只写关键帧当时或之前看得到的内容；因果描述以决策结尾",
                "write only what could be seen at or before the keyframe; the trace ends with the decision",
            )
        });
    };
    for (c, facts) in label.parts.iter().zip(&texts.components) {
        let Some(text) = c.description.get() else { continue };
        if let Some(at) = facts
            .hindsight
            .or(facts.after_response)
            .or_else(|| after_decision(text, facts, label, words, lexicon))
            .or_else(|| told_later(text, words))
        {
            return report(sink, pointer::critical_components_item_description(c.index), text, at);
        }
    }
    // "The light has turned green at last, so we set off": what somebody waited for was there before the decision.
    let awaited = |text: &str, (start, end): (usize, usize)| {
        const RELIEF: [&str; 3] = ["总算", "终于", "at last"];
        let word = text[start..end].to_ascii_lowercase();
        let decides = |r: &Reading| trace_rules::states_decision(r, lexicon, label, end, text.len());
        RELIEF.contains(&word.as_str()) && reading.is_some_and(decides)
    };
    let is_known = |at: &(usize, usize)| {
        label.trace.get().is_some_and(|t| !is_ahead(t, *at, texts, words) && !awaited(t, *at))
    };
    let known = texts.trace.hindsight.filter(is_known);
    if let (Some(text), Some(at)) = (label.trace.get(), known.or(after)) {
        report(sink, pointer::COC_TRACE.to_owned(), text, at);
    }
}

/// "It reaches the junction four seconds later, as we do": a time in Chinese without a sign of what is completed behind
/// it, in its sentence. "To get by without touching the line": behind an infinitive in English.
fn is_ahead(text: &str, (start, end): (usize, usize), texts: &Texts, words: &LabelWords) -> bool {
    let (from, to) = words.clauses.around(&texts.units, start..end, text.len(), &|d| d == Divider::Sentence);
    let word = &text[start..end];
    if word.is_ascii() {
        return word.to_ascii_lowercase().starts_with("without ") && text[from..start].contains(" to ");
    }
    word.contains('秒')
        && word.ends_with('后')
        && !text[end..to].contains(|c: char| words.aftermath.completed.contains(c))
}

/// Bytes of a component that tells in the past tense what came later: "then drove on", "after 200 m it turned off".
/// What is seen stands in the present or the perfect.
fn told_later(text: &str, words: &LabelWords) -> Option<(usize, usize)> {
    let lower = text.to_ascii_lowercase();
    let find =
        |all: &[String]| all.iter().filter_map(|w| lower.find(w.as_str()).map(|at| (at, at + w.len()))).min();
    let (start, end) = find(&words.aftermath.later)?;
    if !text.is_ascii() {
        return text[end..].contains('了').then_some((start, end));
    }
    let is_past = |w: &str| {
        w.len() >= 5 && w.ends_with("ed") && !w.ends_with("eed")
            || words.aftermath.told.iter().any(|t| t == w)
    };
    let mut all = lower.split(|c: char| !c.is_ascii_alphabetic()).filter(|w| !w.is_empty()).peekable();
    let mut last = "";
    let told = std::iter::from_fn(|| all.next()).any(|w| {
        let is_participle = words.aftermath.participle.iter().any(|p| p == last);
        last = w;
        is_past(w) && !is_participle
    });
    told.then_some((start, end))
}

/// Bytes of a component about what comes after the label's own decision: "after merging" in any words, where no other
/// road user is named before it.
fn after_decision(
    text: &str,
    facts: &TextFacts,
    label: &View<'_>,
    words: &LabelWords,
    lexicon: &Lexicon,
) -> Option<(usize, usize)> {
    let behind =
        lexicon.behind_decision.iter().filter_map(|w| Some((text.find(w.as_str())?, w.len()))).min()?;
    let (at, length) = behind;
    let from = text[..at].rfind(['，', '。', '；']).map_or(0, |i| i + '，'.len_utf8());
    // "Off the throttle, the speed still rises": the reason of the ego's decision.
    let is_measure = words.subjects.measures.iter().any(|w| text[at + length..].starts_with(w.as_str()));
    if is_measure && !text[at..].contains('了') {
        return None;
    }
    let other = facts.named.iter().any(|n| (from..at).contains(&n.start));
    let decided = lexicon.stems.find(&text[from..at], label.longitudinal.get(), label.lateral.get());
    (!other && decided.is_some()).then_some((from, at + length))
}

/// UNOBSERVED has a reason.
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
            let text = excerpt(text);
            Words::new(
                format!("“{text}”没有说明为什么看不到原因"),
                format!("'{text}' does not state why the cause could not be observed"),
            )
            .hint(
                "写明原因在哪里、为何看不到，例如“原因在画面之外，摄像头没有拍到”",
                "state where it is and why it cannot be seen, such as \"outside the field of view of the cameras\"",
            )
        });
    }
}

/// A trace that states that the cause was not observed states the reason in the same sentence. Returns true when it
/// does not.
pub(in crate::check) fn unobserved_in_trace(scope: &TextScope<'_>, sink: &mut dyn Sink) -> bool {
    let TextScope { label, texts, words, .. } = *scope;
    let (Some((start, end)), Some(text)) = (texts.trace.unobserved, label.trace.get()) else { return false };
    // After it, or in the clause before it: "outside the field of view, hence UNOBSERVED".
    let (_, to) = words.clauses.around(&texts.units, start..end, text.len(), &|d| d == Divider::Sentence);
    let (from, _) = words.clauses.around(&texts.units, start..end, text.len(), &|d| d != Divider::Aside);
    let (before, _) = match text[..from].trim_end().len() {
        0 => (0, 0),
        n => words.clauses.around(&texts.units, n - 1..n - 1, text.len(), &|d| d != Divider::Aside),
    };
    let says_why = |from: usize, to: usize| text.get(from..to).is_some_and(|part| words.gives_reason(part));
    if says_why(end, to) || says_why(from, start) || says_why(before, from) {
        return false;
    }
    sink.report(Finding::error("label.cause.unobserved", pointer::COC_TRACE).part(start, end), &|| {
        let mark = &text[start..end];
        Words::new(
            format!("因果描述写了“{mark}”，却没有说明为什么看不到原因"),
            format!("the trace says '{mark}', but not why the cause could not be observed"),
        )
        .hint(
            "在同一句里写明为何看不到，例如“右侧摄像头被泥糊住”",
            "state in the same sentence why it could not be seen, such as \"the camera on the right is iced over\"",
        )
    });
    true
}

/// A stopped lead is between the ego and the light (LABELING.md 6, proximate cause).
pub(in crate::check) fn proximate(scope: &TextScope<'_>, sink: &mut dyn Sink) {
    let TextScope { label, texts, words, .. } = *scope;
    if label.longitudinal != Slot::Is(Longitudinal::StopForRegulation) {
        return;
    }
    let KnownKinds { lead, queue, vehicle, elsewhere, .. } = words.known;
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
            "stopping behind a lead is lead following; if the ego is first in line, remove the lead",
        )
    });
}

/// A component that is far away, or beyond a road user that it names, causes no response to a nearer road user: "the
/// light two hundred meters beyond the van" (LABELING.md 6, proximate cause).
pub(in crate::check) fn distant(scope: &TextScope<'_>, sink: &mut dyn Sink) -> bool {
    let TextScope { label, texts, words, about, .. } = *scope;
    let wanted = match label.longitudinal.get() {
        Some(Longitudinal::YieldToAgent | Longitudinal::LeadFollowing | Longitudinal::StopForObstacle) => {
            words.known.actor
        }
        Some(Longitudinal::StopForRegulation) => words.known.sign.with(words.known.light),
        // A road user that moves off lets the ego go.
        Some(Longitudinal::Resume) if !about.is_empty() && about.without(words.known.actor).is_empty() => {
            words.known.actor
        }
        None if matches!(
            label.lateral.get(),
            Some(Lateral::LaneChange | Lateral::InLaneNudge | Lateral::OutOfLaneNudge)
        ) =>
        {
            words.known.actor
        }
        _ => return false,
    };
    let acts = |n: &&Named| words.objects[n.group].own.meets(wanted);
    let near = |f: &&TextFacts| f.distant.is_none() && f.there().any(|n| acts(&n));
    let parts = || label.parts.iter().zip(&texts.components);
    // A lead stops because of what is beyond it, and moves off for its own reasons.
    let moves = !matches!(
        label.longitudinal.get(),
        Some(Longitudinal::YieldToAgent | Longitudinal::LeadFollowing | Longitudinal::StopForObstacle)
    );
    let is_far = |c: &ComponentView<'_>, f: &TextFacts| {
        f.distant.or_else(|| beyond_somebody(c.description.get().filter(|_| moves)?, f, words))
    };
    let Some((far, (start, end))) = parts().find_map(|(c, f)| Some((c, is_far(c, f)?))) else {
        return false;
    };
    let nearer = parts().find(|(_, f)| near(f)).and_then(|(c, _)| c.description.get());
    let nearer = nearer.or_else(|| {
        let n = texts.trace.there().find(acts)?;
        label.trace.get()?.get(n.start..n.end)
    });
    let Some(nearer) = nearer else { return false };
    let at = pointer::critical_components_item_description(far.index);
    sink.report(Finding::warning("label.cause.proximate", at).part(start, end), &|| {
        let text = far.description.get().unwrap_or_default();
        let phrase = &text[start..end];
        Words::new(
            format!("近因是“{nearer}”；“{text}”（“{phrase}”）太远，不是本次决策的原因"),
            format!("the proximate cause is '{nearer}'; '{text}' is too far away ('{phrase}') to be one"),
        )
        .hint("删去远处的要素，只留引起决策的那一个", "remove the distant component")
    });
    true
}

/// Bytes of the words that place something beyond a road user that the component names first, only as a location: "past
/// the truck, the light is red", "the bus, farther on from it". Not what the road user hides, nor somebody who comes
/// from there.
fn beyond_somebody(text: &str, facts: &TextFacts, words: &LabelWords) -> Option<(usize, usize)> {
    let first = facts.named.first()?;
    let own = |n: &Named| words.objects[n.group].own;
    let begins = match text.is_ascii() {
        true => {
            words
                .subjects
                .beyond
                .iter()
                .any(|w| text[..first.start].to_ascii_lowercase().trim().ends_with(w.as_str()))
                && text[..first.start].split_whitespace().count() <= MOST_WORDS_BEFORE
        }
        false => words.subjects.beyond.iter().any(|w| text[first.end..].starts_with(w.as_str())),
    };
    let reaches = facts.acts.iter().any(|a| !a.denied && a.doing.meets(words.reaching));
    let hides = facts.named.iter().any(|n| own(n).meets(words.known.sight));
    (own(first).meets(words.known.actor) && begins && !reaches && !hides).then_some((0, first.end))
}

/// A trace whose reason is only the surroundings of the road user to which the ego responds, not the road user itself:
/// the school, and not the child that runs out of it. The trace is not judged where the road user is in words that are
/// in no list, or is a pronoun.
pub(in crate::check) fn around(scope: &TextScope<'_>, decision_from: usize, sink: &mut dyn Sink) -> bool {
    let TextScope { label, texts, words, about, .. } = *scope;
    let main = match label.longitudinal.get() {
        Some(Longitudinal::LeadFollowing) => words.known.vehicle,
        // The class is about road users only, so one of them lets the ego go.
        Some(Longitudinal::Resume) if !about.is_empty() && about.without(words.known.actor).is_empty() => {
            words.known.vehicle.without(words.known.queue)
        }
        Some(Longitudinal::YieldToAgent | Longitudinal::StopForObstacle) => words.known.actor,
        _ => return false,
    };
    // The road users that the class is about, where it states them.
    let main = match main.only(about) {
        own if own.is_empty() => main,
        own => own,
    };
    let Some(text) = label.trace.get().filter(|_| decision_from > 0) else { return false };
    let is_main = |n: &Named| words.objects[n.group].own.meets(main);
    if texts.trace.named.iter().any(is_main) || words.subjects.has_pronoun(text) {
        return false;
    }
    let parts = || {
        let all = label.parts.iter().zip(&texts.components);
        all.filter_map(|(c, f)| Some((c.description.get()?, f)))
    };
    let acts = |t: &str, f: &TextFacts| {
        f.there().find(|n| !words.subjects.is_landmark(t, n.start, n.end)).is_some_and(is_main)
    };
    let is_common = |at: usize| words.subjects.is_common(text, at);
    let inside = |at: usize| at < decision_from && !is_common(at);
    // By a word, or by a thing beside the acting road user.
    let beside = texts.trace.there().filter(|n| n.start < decision_from && !is_main(n));
    let beside = beside.fold(GroupSet::default(), |set, n| set.with(words.objects[n.group].own));
    let beside = beside.without(words.known.no_cause).without(words.known.road);
    let shared = |t: &str| overlap::shared_with(t, text, &words.compared, &inside);
    let given = parts().filter(|(t, f)| acts(t, f)).map(|(t, _)| t).next();
    let Some(given) = given else { return false };
    if parts().any(|(t, f)| acts(t, f) && shared(t) > 0)
        || !parts().any(|(t, f)| !acts(t, f) && (shared(t) > 0 || f.groups.meets(beside)))
    {
        return false;
    }
    sink.report(Finding::warning("label.cause.proximate", pointer::COC_TRACE).part(0, decision_from), &|| {
        Words::new(
            format!("因果描述的理由没有提到近因“{given}”，只说了它周围的情形"),
            format!("the reason in the trace does not mention the proximate cause, '{given}', only what is around it"),
        )
        .hint("写出直接引起决策的那一个要素", "name the component that causes the decision")
    });
    true
}

/// A trace that says of everything it names that it is irrelevant for the decision; or that contradicts the components
/// about it, or calls it harmless, and gives no reason for its decision.
pub(in crate::check) fn denied(scope: &TextScope<'_>, reading: &Reading, sink: &mut dyn Sink) -> bool {
    let TextScope { label, texts, words, .. } = *scope;
    let restricts = matches!(
        label.longitudinal.get(),
        Some(
            Longitudinal::YieldToAgent
                | Longitudinal::LeadFollowing
                | Longitudinal::StopForObstacle
                | Longitudinal::StopForRegulation
                | Longitudinal::RoadSpeedAdaptation
        )
    );
    let Some(text) = label.trace.get() else { return false };
    let by_itself = || irrelevant(text, texts, words, restricts);
    // A lane change or a turn has its own cause, which may be the route or the road.
    let stays = label.lateral.get().is_none_or(|l| matches!(l, Lateral::LaneKeeping | Lateral::InLaneNudge));
    let clauses = || (stays && restricts).then(|| grounds::against(scope, reading)).flatten();
    let route = || (!stays).then(|| grounds::route_denied(scope)).flatten();
    let missing = || grounds::sign_is_missing(scope);
    let found = by_itself().or_else(|| disowned::disowned(scope)).or_else(clauses).or_else(missing);
    let Some((start, end)) = found.or_else(route).or_else(|| flipped::flipped(scope)) else {
        return false;
    };
    sink.report(Finding::warning("label.trace.contradicts", pointer::COC_TRACE).part(start, end), &|| {
        let phrase = &text[start..end];
        Words::new(
            format!("因果描述说“{phrase}”，与决策的理由相反，又没有给出别的原因"),
            format!("the trace says '{phrase}', which contradicts its decision, and gives no other cause"),
        )
        .hint(
            "写出真正引起决策的是什么，或删去这句否认",
            "state what causes the decision, or remove the denial",
        )
    });
    true
}

/// Bytes of the statement that everything the trace names is irrelevant for the decision.
///
/// `restricts`: the decision responds to something; the reason for another decision may be the absence of something.
fn irrelevant(text: &str, texts: &Texts, words: &LabelWords, restricts: bool) -> Option<(usize, usize)> {
    let (start, end) = texts.trace.irrelevant?;
    // "No threat, but the road is wet".
    let behind = text[end..].to_ascii_lowercase();
    if words.clauses.contrast.iter().any(|w| behind.contains(w.as_str())) {
        return None;
    }
    let (from, _) = words.clauses.around(&texts.units, start..end, text.len(), &|d| d != Divider::Aside);
    let is_cause = |n: &&Named| {
        let own = words.objects[n.group].own;
        !own.meets(words.known.no_cause) && !own.meets(words.known.road)
    };
    let own: Vec<&Named> = texts.trace.there().filter(|n| (from..start).contains(&n.start)).collect();
    let said = own.iter().fold(GroupSet::default(), |set, n| set.with(words.objects[n.group].near));
    // Other things in the same component belong together, except for road users.
    let beside = texts.components.iter().filter(|f| !own.is_empty() && f.groups.meets(said));
    let beside = beside.flat_map(TextFacts::there);
    let about = beside
        .filter(|n| !words.objects[n.group].own.meets(words.known.actor))
        .fold(said, |set, n| set.with(words.objects[n.group].near));
    // Without a name in its clause, the statement applies to everything before.
    let is_other = |n: &Named| {
        if own.is_empty() { n.start >= end } else { !words.objects[n.group].own.meets(about) }
    };
    // If it applies to the thing of the first component, only the things named after it remain.
    let first = texts.components.first().map(|f| {
        let there = f.there().filter(is_cause);
        there.fold(GroupSet::default(), |set, n| set.with(words.objects[n.group].own))
    });
    let of_first =
        own.iter().any(|n| is_cause(n) && first.is_some_and(|f| words.objects[n.group].near.meets(f)));
    // "..., which does not matter": in Latin text this refers to what the sentence named before.
    let (sentence, _) =
        words.clauses.around(&texts.units, start..end, text.len(), &|d| d == Divider::Sentence);
    let named_before = || {
        let mut before = texts.trace.there().filter(|n| (sentence..from).contains(&n.start));
        before.any(|n| first.is_some_and(|f| words.objects[n.group].near.meets(f)))
    };
    let of_first = of_first
        || own.is_empty()
            && (words.subjects.has_pronoun(&text[from..end]) || text.is_ascii() && named_before());
    let is_other = |n: &Named| if of_first { n.start >= end } else { is_other(n) };
    // Components about the same thing are no other cause.
    let mut same = about;
    for f in texts.components.iter().filter(|f| f.groups.meets(about)) {
        same = f.there().fold(same, |set, n| set.with(words.objects[n.group].near));
    }
    let given = texts.components.iter().filter(|f| !f.groups.meets(about));
    let given = given
        .flat_map(TextFacts::there)
        .fold(GroupSet::default(), |set, n| set.with(words.objects[n.group].own));
    let is_given = |n: &&Named| {
        let own = words.objects[n.group].own;
        own.meets(given) && !own.meets(same) || n.start >= end
    };
    let only_same = restricts && !own.is_empty();
    let another = texts.trace.there().filter(is_cause).filter(|n| !only_same || is_given(n)).any(is_other);
    (!another && (of_first || restricts)).then_some((start, end))
}

/// The components that are linked as the cause of a decision are about something that can cause it: by the table of
/// causes, or because the class is about it. Checked only if every one of them has been read. Returns true when one
/// cannot.
pub(in crate::check) fn kind(
    label: &View<'_>,
    class: Option<&ClassDecisions>,
    texts: &Texts,
    framework: &Framework,
    sink: &mut dyn Sink,
) -> bool {
    let Slot::Is(causes) = &label.causes else { return false };
    let (words, table) = (framework.label_words(), framework.decision_table());
    let about = class.map(|c| c.about).unwrap_or_default();
    let channels = [
        (label.longitudinal.get().map(|d| d.id()), &causes.longitudinal, pointer::CAUSES_LONGITUDINAL),
        (label.lateral.get().map(|d| d.id()), &causes.lateral, pointer::CAUSES_LATERAL),
    ];
    for (decision, cause, at) in channels {
        let (Some(decision), Slot::Is(cause)) = (decision, cause) else { continue };
        let Some(wanted) = table.causes.of(decision) else { continue };
        let by_id = |id| label.parts.iter().position(|c| c.id.get().is_some() && c.id.get() == id);
        let named: Vec<usize> = cause.components.iter().filter_map(|id| by_id(id.get())).collect();
        let fits = |facts: &TextFacts| {
            let in_state = |n: &Named| {
                let own = words.objects[n.group].own;
                wanted.in_state.iter().any(|(kinds, state)| own.meets(*kinds) && n.state == Some(*state))
            };
            facts.groups.meets(wanted.kinds) || facts.groups.meets(about) || facts.there().any(in_state)
        };
        // The action of a road user in words that are in no list may be the cause.
        let read = |facts: &TextFacts| {
            !facts.groups.without(table.causes.background).is_empty() && facts.states.is_empty()
        };
        let parts = || named.iter().map(|i| &texts.components[*i]);
        let unread = |i: &usize| {
            let text = label.parts[*i].description.get();
            text.is_none_or(|t| subject::is_unread(t, &texts.components[*i], words))
        };
        if wanted.anything
            || named.is_empty()
            || parts().any(fits)
            || !parts().all(read)
            || named.iter().any(unread)
        {
            continue;
        }
        sink.report(Finding::warning("label.cause.kind", at), &|| {
            let which = label.parts[named[0]].description.get().unwrap_or_default();
            let name = framework.decisions.name(decision);
            Words::new(
                format!("“{which}”不会引起“{}”", name.zh),
                format!("'{which}' does not cause '{}'", name.en),
            )
            .hint(
                "关联真正引起该决策的要素，或检查决策",
                "name the component that causes the decision, or check the decision",
            )
        });
        return true;
    }
    false
}
