//! Texts without content: placeholders, and words that are unrelated to the road.

use super::kept::{Kept, kept, without_draft_mark};
use crate::check::consistency::trace::form;
use crate::check::excerpt::excerpt;
use crate::check::overlap;
use crate::check::reading::TextFacts;
use crate::check::texts::TextScope;
use crate::check::view::{ComponentView, View};
use crate::draft::{has_beginning, is_draft, may_be_draft};
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_framework::lexicon::units::Units;
use whyroad_framework::{Framework, LabelWords, Lexicon};
use whyroad_model::ScenarioId;
use whyroad_model::label_fields::pointer;
use whyroad_model::messages::{CriticalComponent, DrivingDecision, ProvenanceSource};

/// A component that is this many times as long as a trace may be was not written by anybody.
const PASTED_TIMES: usize = 5;

/// Each component has content. Returns true when one does not.
pub(in crate::check) fn components(scope: &TextScope<'_>, sink: &mut dyn Sink) {
    let TextScope { label, texts, words, lexicon, .. } = *scope;
    if words.is_empty() {
        return;
    }
    for (c, facts) in label.parts.iter().zip(&texts.components) {
        let Some(text) = c.description.get() else { continue };
        let at = pointer::critical_components_item_description(c.index);
        if too_long(at.clone(), text, lexicon, sink) {
            continue;
        }
        if says_nothing(text, facts, words) {
            placeholder(at, text, sink);
        } else if let Some(open) = left_open(text, facts, words) {
            unfinished(at, text, open, sink);
        } else if is_one_word(text) {
            sink.report(Finding::warning("label.component.too_short", at), &|| {
                Words::new(
                    format!("“{text}”太短，没有说明看到了什么"),
                    format!("'{text}' is too short to say what was seen"),
                )
                .hint("写看到了什么、在哪里、在做什么", "write what was seen, where, and what it was doing")
            });
        } else if facts.words == 0 && !says_something(text, lexicon) && !words.is_of_driving(text) {
            // In a few words this is empty; in more, it may be something in words that are in no list.
            let is_told = || {
                label
                    .trace
                    .get()
                    .is_some_and(|t| overlap::shared_with(text, t, &words.compared, &|_| true) > 0)
            };
            // "It is ten past eight now, within the hours": of what another component names.
            let shares = || {
                let others = label.parts.iter().filter(|o| o.index != c.index);
                others
                    .filter_map(|o| o.description.get())
                    .any(|o| overlap::shared_with(o, text, &words.compared, &|_| true) > 0)
            };
            // A text that refers to something named before, or counts, may use any words.
            let speaks_on = || {
                let first = text.split(' ').next().unwrap_or_default().to_ascii_lowercase();
                words.subjects.has_pronoun(text)
                    || words.subjects.is_pronoun(&first)
                    || text.is_ascii() && words.numbers.any(text)
            };
            // An irrelevant component is found by the check of its use.
            let is_idle = facts.idle.is_some() || facts.apart.is_some();
            // "Nobody is herding them": of what another component names.
            let refers = || label.parts.len() > 1 && refers_back(text, words);
            let finding =
                match is_short(text) && !refers() || !is_idle && !speaks_on() && !is_told() && !shares() {
                    true => Finding::warning("label.text.unrelated", at),
                    false => Finding::note("label.text.unrelated", at),
                };
            sink.report(finding, &|| {
                Words::new(
                    format!("“{}”没有提到任何与驾驶有关的事物", excerpt(text)),
                    format!("'{}' names nothing related to driving", excerpt(text)),
                )
                .hint("写看到了什么、在哪里、在做什么", "write what was seen, where, and what it was doing")
            });
        }
    }
}

/// A component says one thing, so it is no longer than a whole trace may be. One of several times that length was
/// pasted by mistake: nothing else is said of it. Returns true for such a one.
fn too_long(at: String, text: &str, lexicon: &Lexicon, sink: &mut dyn Sink) -> bool {
    let limit = lexicon.limits.too_long_above;
    // Most are short: then nothing is counted.
    if limit == 0 || text.len() <= limit {
        return false;
    }
    let length = form(text, &lexicon.limits).length;
    if length <= limit {
        return false;
    }
    let is_pasted = length > PASTED_TIMES * limit;
    let code = "label.component.too_long";
    let finding = if is_pasted { Finding::error(code, at) } else { Finding::warning(code, at) };
    sink.report(finding, &|| {
        Words::new(
            format!("关键要素过长（约 {length} 字）：“{}”", excerpt(text)),
            format!("the component is too long (about {} words): '{}'", length / 2, excerpt(text)),
        )
        .hint(
            "一个要素只写一件事：看到了什么、在哪里、在做什么；别的事另写一个要素",
            "one thing per component: what was seen, where, and what it was doing; write others separately",
        )
    });
    is_pasted
}

/// The whole text is a placeholder, or a part of it is.
fn says_nothing(text: &str, facts: &TextFacts, words: &LabelWords) -> bool {
    facts.unfinished || words.is_placeholder(text) || words.is_unfinished(text)
}

/// One Latin word, or at most two Chinese characters: a name without a statement about it.
fn is_one_word(text: &str) -> bool {
    let mut letters = text.chars().filter(|c| c.is_alphanumeric());
    if text.is_ascii() { text.split_whitespace().nth(1).is_none() } else { letters.nth(2).is_none() }
}

/// It has a pronoun for others than the ego, behind its first word in Latin letters: "nobody is herding them".
fn refers_back(text: &str, words: &LabelWords) -> bool {
    let rest = if text.is_ascii() { text.split_once(' ').map_or("", |(_, rest)| rest) } else { text };
    words.subjects.has_pronoun(rest) && !words.subjects.speaks_of_ego(text)
}

/// At most four Latin words, or five Chinese characters.
fn is_short(text: &str) -> bool {
    let mut letters = text.chars().filter(|c| c.is_alphanumeric());
    if text.is_ascii() { text.split_whitespace().nth(4).is_none() } else { letters.nth(5).is_none() }
}

fn says_something(text: &str, lexicon: &Lexicon) -> bool {
    let mut any = false;
    lexicon.hits(&Units::of(text), 0..text.len(), |hit| {
        use whyroad_framework::lexicon::Role;
        any |= matches!(hit.role, Role::Agent | Role::Ego | Role::Phrase(_));
    });
    any
}

/// The trace is not a placeholder. Returns true when it is one.
pub(in crate::check) fn trace(scope: &TextScope<'_>, sink: &mut dyn Sink) -> bool {
    let TextScope { label, texts, words, .. } = *scope;
    let Some(text) = label.trace.get().filter(|t| !t.trim().is_empty()) else { return false };
    if words.is_empty() {
        return false;
    }
    let at = pointer::COC_TRACE.to_owned();
    if says_nothing(text, &texts.trace, words) {
        placeholder(at, text, sink);
        return true;
    }
    // If it has no other content, the trace is about something else.
    let says = texts.trace.words > 0 || words.is_of_driving(text);
    let Some(open) = left_open(text, &texts.trace, words).filter(|_| says) else { return false };
    unfinished(at, text, open, sink);
    true
}

/// Bytes of a part that is still to be written, in a text that has other content.
fn left_open(text: &str, facts: &TextFacts, words: &LabelWords) -> Option<(usize, usize)> {
    facts.unwritten.or_else(|| words.left_open(text))
}

fn unfinished(at: String, text: &str, (start, end): (usize, usize), sink: &mut dyn Sink) {
    sink.report(Finding::error("label.text.placeholder", at).part(start, end), &|| {
        let part = &text[start..end];
        Words::new(
            format!("“{part}”是没有写完的占位文字"),
            format!("'{part}' is a placeholder that was not filled in"),
        )
        .hint("写出实际内容，或删去这一处", "write the content, or remove it")
    });
}

fn placeholder(at: String, text: &str, sink: &mut dyn Sink) {
    sink.report(Finding::error("label.text.placeholder", at), &|| {
        let text = excerpt(text);
        Words::new(format!("“{text}”是占位文字"), format!("'{text}' is a placeholder"))
            .hint("写实际内容；没有内容时删去该项", "write the content, or remove the item")
    });
}

/// The trace is still the text of the program: of the one that drafted it, `drafted` where that is known.
pub(in crate::check) fn draft(
    label: &View<'_>,
    framework: &Framework,
    drafted: Option<&str>,
    sink: &mut dyn Sink,
) -> bool {
    let Some(text) = label.trace.get() else { return false };
    // A draft that is marked as one is not an error.
    if matches!(label.source, Slot::Is(ProvenanceSource::Rule | ProvenanceSource::Model)) {
        return false;
    }
    let kept = drafted.and_then(|drafted| kept(drafted, text));
    let marked =
        without_draft_mark(text) != text || kept == Some(Kept::Trace) || is_unchanged(label, text, framework);
    // "(draft, re-watch the clip)": a note of the author.
    if let Some((start, end)) = framework.label_words().draft_note(text).filter(|_| !marked) {
        sink.report(Finding::error("label.trace.draft", pointer::COC_TRACE).part(start, end), &|| {
            let note = text[start..end].trim_matches(|c: char| !c.is_alphanumeric());
            Words::new(
                format!("因果描述注明“{note}”，还没有定稿"),
                format!("the trace is marked as a draft: '{note}'"),
            )
            .hint("定稿后删去这条备注", "finish the trace and remove the note")
        });
        return true;
    }
    if marked {
        sink.report(Finding::error("label.trace.draft", pointer::COC_TRACE), &|| {
            Words::new("因果描述仍是程序生成的草稿", "the trace is still the program's draft").hint(
                "用自己的话改写为：状态、原因、决策",
                "write state, reason and decision in your own words",
            )
        });
    } else if kept == Some(Kept::Reason) {
        sink.report(Finding::error("label.trace.draft", pointer::COC_TRACE), &|| {
            Words::new(
                "因果描述的原因仍是程序生成的草稿",
                "the reason of the trace is still the program's draft",
            )
            .hint("用自己的话改写原因", "write the reason in your own words")
        });
    }
    marked
}

/// Equal to a draft for the same components and decisions.
fn is_unchanged(label: &View<'_>, trace: &str, framework: &Framework) -> bool {
    let Some(first) = label.parts.first().and_then(|c| c.description.get()) else { return false };
    // A draft contains its first component; the first letter may have been made a capital.
    if !has_beginning(trace, first) {
        return false;
    }
    let component = |c: &ComponentView<'_>| CriticalComponent {
        category: None,
        description: c.description.get().unwrap_or_default().to_owned(),
        uncertainty: None,
        id: None,
        evidence_times: Vec::new(),
        linked_objects: Vec::new(),
    };
    let decision = DrivingDecision {
        longitudinal: label.longitudinal.get(),
        lateral: label.lateral.get(),
        lateral_direction: label.direction.get(),
    };
    let s = &label.scenario;
    let class = ScenarioId {
        l1: s.l1.get().unwrap_or_default().to_owned(),
        l2: s.l2.get().map(str::to_owned),
        l3: s.l3.get().map(str::to_owned),
    };
    if !may_be_draft(framework, &class, &decision, trace) {
        return false;
    }
    let components: Vec<_> = label.parts.iter().map(component).collect();
    is_draft(framework, &class, &components, &decision, trace)
}
