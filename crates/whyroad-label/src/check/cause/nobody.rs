//! Components of which none is about a road user, although the ego responds to one: the light at the far end of the
//! queue, the officer ten cars ahead. Road users in them only say where that is, or are on other lanes (LABELING.md 6,
//! proximate cause).

use crate::check::reading::{Named, TextFacts, starting_in};
use crate::check::subject;
use crate::check::texts::TextScope;
use whyroad_framework::LabelWords;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_framework::label_words::GroupSet;
use whyroad_model::label_fields::pointer;

/// Separate the clauses of a component.
const MARKS: [char; 8] = ['，', '。', '；', '：', ',', ';', ':', '.'];
/// Maximum number of Latin words between a preposition and the name that it belongs to.
const MOST_WORDS: usize = 4;

/// Some component is about a road user of the kind that the class is about. Reported only where all components have
/// been read, and one is about a light, a sign or a place.
pub(in crate::check) fn nobody(scope: &TextScope<'_>, sink: &mut dyn Sink) -> bool {
    let TextScope { label, texts, words, about, .. } = *scope;
    let known = &words.known;
    if !scope.answers_a_road_user() {
        return false;
    }
    let kind = |id: &str| words.kinds.get(id).copied().unwrap_or_default();
    let far =
        known.sign.with(known.light).with(kind("facility")).with(kind("controller")).with(kind("junction"));
    let far = far.without(about);
    let parts = || label.parts.iter().zip(&texts.components);
    let is_open = |text: &str, facts: &TextFacts| {
        subject::is_unread(text, facts, words)
            && !is_about(text, facts, far, scope)
            && !begins_beside(text, words)
            || words.subjects.has_pronoun(text)
            || facts.named.iter().any(|n| n.supposed)
            || is_about(text, facts, about, scope)
    };
    if parts().any(|(c, f)| c.description.get().is_none_or(|t| is_open(t, f))) {
        return false;
    }
    let beyond = parts().filter_map(|(c, f)| Some((c, c.description.get()?, f)));
    let mut beyond = beyond.filter(|(_, t, f)| is_about(t, f, far, scope));
    let Some((part, text, _)) = beyond.next() else { return false };
    let at = pointer::critical_components_item_description(part.index);
    sink.report(Finding::warning("label.cause.proximate", at), &|| {
        Words::new(
            format!("自车响应的是道路使用者，而没有一个关键要素说到自车前方的道路使用者，只有“{text}”"),
            format!(
                "the ego responds to a road user, but no component is about one in its way, only '{text}'"
            ),
        )
        .hint("写出直接引起决策的那一个要素", "name the component that causes the decision")
    });
    true
}

/// The component is about a thing of `kinds`: it is there, is no place of something else, and is not on another lane.
fn is_about(text: &str, facts: &TextFacts, kinds: GroupSet, scope: &TextScope<'_>) -> bool {
    let words = scope.words;
    let own = |n: &Named| words.objects[n.group].own;
    let others: Vec<&Named> = facts.there().filter(|n| !own(n).meets(scope.about)).collect();
    let is_one = |n: &&Named| own(n).meets(kinds) && !n.supposed;
    facts.there().filter(is_one).any(|n| {
        let actor = own(n).meets(scope.about);
        !actor || !(is_place(text, n, &others, scope) || is_beside(text, n, words))
    })
}

/// The name only locates something else: "the light beyond the van", "货车再往前的路口".
fn is_place(text: &str, n: &Named, others: &[&Named], scope: &TextScope<'_>) -> bool {
    let words = scope.words;
    if words.subjects.is_landmark(text, n.start, n.end) {
        return !others.is_empty();
    }
    let before = text[clause_start(text, n.start)..n.start].to_ascii_lowercase();
    if text.is_ascii() {
        return !others.is_empty() && follows_preposition(&before, words);
    }
    if words.forms.between.find(&before).is_some() {
        return !others.is_empty();
    }
    // "前车的行驶路线" belongs to it, "货车后面的路口" does not.
    let end = text[n.end..].find(MARKS).map_or(text.len(), |i| n.end + i);
    starting_in(others, |o| o.start, n.end, end).iter().any(|o| {
        // "有车" of "有车辆的".
        let part = text.get(n.end..o.start).unwrap_or_default().trim_start_matches(['辆', '台']);
        !part.starts_with('的') && part.contains('的')
    })
}

/// A name in Latin letters behind `before` belongs to a preposition: "beyond the", "of a long", "past the van and the".
fn follows_preposition(before: &str, words: &LabelWords) -> bool {
    let is_article = |w: &str| {
        let s = &words.subjects;
        s.articles.iter().chain(&s.introduces).any(|a| a == w) || s.is_determiner(w)
    };
    let mut last = before.split(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty()).rev();
    loop {
        let mut word = last.by_ref().take(MOST_WORDS).find(|w| is_article(w) || words.subjects.ends(w));
        // "The two coaches".
        while word.is_some_and(is_article) {
            word = last.next();
        }
        match word {
            // The name before it decides.
            Some("and" | "or") => {}
            other => return other.is_some_and(|w| words.forms.between.iter().any(|b| b == w)),
        }
    }
}

/// Where the clause begins that contains `at`.
fn clause_start(text: &str, at: usize) -> usize {
    text[..at].rmatch_indices(MARKS).next().map_or(0, |(i, mark)| i + mark.len())
}

/// It is on another lane, or on both sides.
fn is_beside(text: &str, n: &Named, words: &LabelWords) -> bool {
    let clause = &text[clause_start(text, n.start)..n.end];
    words.forms.both_sides.find(&clause.to_ascii_lowercase()).is_some()
}

/// The first clause is about another lane, or about both sides.
fn begins_beside(text: &str, words: &LabelWords) -> bool {
    let end = text.find(MARKS).unwrap_or(text.len());
    words.forms.both_sides.find(&text[..end].to_ascii_lowercase()).is_some()
}
