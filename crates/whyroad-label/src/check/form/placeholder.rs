//! Texts that say nothing: placeholders, and words that have to do with no road.

use crate::check::rulebook::Texts;
use crate::check::view::View;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_framework::{LabelWords, Lexicon};
use whyroad_model::label_fields::pointer;
use whyroad_model::messages::ProvenanceSource;

/// Marks with which the drafts of this program opened up to version 0.1; a trace that has one was not written by a
/// person.
const DRAFT_MARKS: [&str; 2] = ["【草稿】", "[DRAFT]"];

/// Each component says something. True when one does not.
pub(in crate::check) fn components(
    label: &View<'_>,
    texts: &Texts,
    words: &LabelWords,
    lexicon: &Lexicon,
    sink: &mut dyn Sink,
) {
    if words.is_empty() {
        return;
    }
    for (c, facts) in label.parts.iter().zip(&texts.components) {
        let Some(text) = c.description.get() else { continue };
        let at = pointer::critical_components_item_description(c.index);
        if words.is_placeholder(text) {
            placeholder(at, text, sink);
        } else if facts.words == 0 && !says_something(text, lexicon) {
            sink.report(Finding::warning("label.text.unrelated", at), &|| {
                Words::new(
                    format!("“{text}”没有提到任何与驾驶有关的事物"),
                    format!("'{text}' names nothing that has to do with driving"),
                )
                .hint("写看到了什么、在哪里、在做什么", "write what was seen, where, and what it does")
            });
        }
    }
}

fn says_something(text: &str, lexicon: &Lexicon) -> bool {
    let mut any = false;
    lexicon.hits(text, |hit| {
        use whyroad_framework::lexicon::Role;
        any |= matches!(hit.role, Role::Agent | Role::Phrase(_));
    });
    any
}

/// The trace is no placeholder. True when it is one.
pub(in crate::check) fn trace(label: &View<'_>, words: &LabelWords, sink: &mut dyn Sink) -> bool {
    let Some(text) = label.trace.get().filter(|t| !t.trim().is_empty()) else { return false };
    if words.is_empty() || !words.is_placeholder(text) {
        return false;
    }
    placeholder(pointer::COC_TRACE.to_owned(), text, sink);
    true
}

fn placeholder(at: String, text: &str, sink: &mut dyn Sink) {
    sink.report(Finding::error("label.text.placeholder", at), &|| {
        Words::new(format!("“{text}”是占位文字"), format!("'{text}' is a placeholder"))
            .hint("写实际内容；没有内容时删去该项", "write what is meant, or leave the item out")
    });
}

/// The trace is still what the program wrote.
pub(in crate::check) fn draft(label: &View<'_>, sink: &mut dyn Sink) -> bool {
    let Some(text) = label.trace.get() else { return false };
    // A draft that says it is one is no fault.
    if matches!(label.source, Slot::Is(ProvenanceSource::Rule | ProvenanceSource::Model)) {
        return false;
    }
    let marked = DRAFT_MARKS.iter().any(|m| text.trim_start().starts_with(m));
    if marked {
        sink.report(Finding::error("label.trace.draft", pointer::COC_TRACE), &|| {
            Words::new("因果描述仍是程序生成的草稿", "the trace is still the program's draft").hint(
                "改写为：状态、原因、决策，并删去草稿标记",
                "write state, reason and decision, and delete the draft mark",
            )
        });
    }
    marked
}
