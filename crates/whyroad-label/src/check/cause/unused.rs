//! An irrelevant component: it is not about road or traffic, or is off the road, and the trace does not use it.

use crate::check::excerpt::excerpt;
use crate::check::overlap;
use crate::check::reading::{Named, TextFacts};
use crate::check::texts::{TextScope, Texts};
use whyroad_framework::LabelWords;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_framework::label_words::GroupSet;
use whyroad_model::label_fields::pointer;

/// Every component is relevant for the decision.
///
/// `about`: the triggers of the class.
pub(in crate::check) fn unused(scope: &TextScope<'_>, sink: &mut dyn Sink) {
    let TextScope { label, texts, words, about, .. } = *scope;
    if label.parts.len() < 2 || words.is_empty() {
        return;
    }
    let Some(trace) = label.trace.get() else { return };
    let parts = label.parts.iter().zip(&texts.components);
    let mut all = parts.filter_map(|(c, f)| Some((c.index, c.description.get()?, f)));
    let is_unused = |(_, text, facts): &(usize, &str, &TextFacts)| {
        bears_on_nothing(text, facts, words, about) && !is_told(text, facts, trace, texts, words)
    };
    let Some((index, text, _)) = all.find(is_unused) else { return };
    let at = pointer::critical_components_item_description(index);
    sink.report(Finding::warning("label.cause.proximate", at), &|| {
        let text = excerpt(text);
        Words::new(
            format!("“{text}”与决策无关：它不在自车要走的路上，因果描述也没有用到它"),
            format!(
                "'{text}' is irrelevant for the decision: it is off the ego's path, and not in the trace"
            ),
        )
        .hint("删去无关的要素，只留引起决策的", "remove it: keep only what causes the decision")
    });
}

/// The component is not about traffic, or is off the road, and describes nothing that reaches the road.
fn bears_on_nothing(text: &str, facts: &TextFacts, words: &LabelWords, about: GroupSet) -> bool {
    let off = facts.apart.is_some() || facts.distant.is_some();
    let idle = facts.idle.is_some();
    // Most components need no further check.
    if !idle && !off && facts.words > 0 {
        return false;
    }
    let named = |n: &Named| words.objects[n.group].own;
    if facts.named.iter().any(|n| named(n).meets(words.known.sight)) || words.subjects.speaks_of_ego(text) {
        return false;
    }
    // A road user comes out of it, or blocks the way.
    if facts.acts.iter().any(|a| !a.denied && a.doing.meets(words.reaching)) {
        return false;
    }
    let speaks_on = || {
        let first = text.split(|c: char| !c.is_ascii_alphanumeric()).next().unwrap_or_default();
        words.subjects.is_pronoun(&first.to_ascii_lowercase()) || words.subjects.has_pronoun(text)
    };
    let empty = || facts.words == 0 && !speaks_on() && !words.is_of_driving(text) && !words.numbers.any(text);
    idle || off && !facts.groups.without(words.known.actor).meets(about) || empty()
}

/// The trace mentions it: by a name of its own, or in other words.
fn is_told(text: &str, facts: &TextFacts, trace: &str, texts: &Texts, words: &LabelWords) -> bool {
    let acts = |f: &TextFacts| {
        let own = f.there().map(|n| words.objects[n.group].own).filter(|g| !g.meets(words.known.no_cause));
        own.filter(|g| !g.meets(words.known.road)).fold(GroupSet::default(), GroupSet::with)
    };
    let elsewhere = facts.idle.is_some() || facts.apart.is_some();
    let same_name = |n: &Named| text.get(n.start..n.end).is_some_and(|name| trace.contains(name));
    if facts.idle.is_none() && facts.named.iter().any(same_name) {
        return true;
    }
    if !elsewhere && acts(facts).meets(acts(&texts.trace)) {
        return true;
    }
    let is_name = |at: usize| texts.trace.named.iter().any(|n| (n.start..n.end).contains(&at));
    let is_common = |at: usize| words.subjects.is_common(trace, at);
    // The location of a thing does not describe the thing.
    let (from, to) = facts.apart.unwrap_or_default();
    [&text[..from], &text[to..]].iter().any(|part| {
        overlap::shared_with(part, trace, &words.compared, &|at| !is_name(at) && !is_common(at)) > 0
    })
}
