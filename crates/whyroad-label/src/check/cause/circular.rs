//! A trace that only repeats its decision (LABELING.md 6): checks what remains of its reason without the decision, the
//! road users that the decision is about, and words for deciding.

use crate::check::consistency::text;
use crate::check::consistency::trace::{Mention, Reading};
use crate::check::consistency::trace_rules::{self, Said};
use crate::check::overlap;
use crate::check::reading::Named;
use crate::check::spans::Spans;
use crate::check::texts::{TextScope, Texts};
use crate::check::view::View;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_framework::LabelWords;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_framework::label_words::{Clauses, Divider};
use whyroad_framework::lexicon::Role;
use whyroad_model::label_fields::pointer;

/// The trace gives a reason other than the decision itself.
pub(in crate::check) fn circular(
    scope: &TextScope<'_>,
    reading: &Reading,
    said: Said,
    sink: &mut dyn Sink,
) -> bool {
    let TextScope { label, texts, words, lexicon, .. } = *scope;
    let Some(text) = label.trace.get() else { return false };
    let decision_in = |from: usize, to: usize| {
        trace_rules::states_decision(reading, lexicon, label, from, to)
            && !is_done_by_other(text, from, to, texts, words)
    };
    if words.is_empty() {
        return false;
    }
    let repeated = match said {
        Said::Unread => echoes(text, texts, words),
        _ => repeats(text, scope, reading) || echoes(text, texts, words),
    } || empty_reason(text, scope, reading)
        || said_thrice(text, scope);
    // A decision in words that no list knows may have a reason in such words.
    if !repeated
        && (said == Said::Unread
            || begins_with_cause(text, texts, words, reading)
            || gives_cause(text, texts, words, &decision_in)
            || has_other_words(text, scope, &decision_in)
            || restates_some(scope, text))
    {
        return false;
    }
    sink.report(Finding::warning("label.cause.circular", pointer::COC_TRACE), &|| {
        Words::new(
            "因果描述没有给出原因：只是重复了决策",
            "the trace gives no reason: it only repeats the decision",
        )
        .hint("写出看到了什么、它为什么要求这个决策", "write what was seen and why it calls for the decision")
    });
    true
}

/// The trace has some of the meanings of the components, in its own words, beside its decision.
fn restates_some(scope: &TextScope<'_>, text: &str) -> bool {
    const LEAST: u32 = 2;
    const SHARE: f64 = 0.34;
    let (shared, all) = text::coverage(scope, text.len());
    shared >= LEAST && f64::from(shared) >= SHARE * f64::from(all)
}

/// "Braking by the car in front": the action in the part is by a road user named after it.
fn is_done_by_other(text: &str, from: usize, to: usize, texts: &Texts, words: &LabelWords) -> bool {
    /// Maximum bytes of "by" and of the words between it and the name.
    const NEAR: usize = 16;
    texts.trace.named_in(from, to).iter().filter(|n| n.is_there()).any(|n| {
        let acts = words.objects[n.group].own.meets(words.known.actor);
        // The part may begin inside a character.
        let from = (from..=n.start).find(|at| text.is_char_boundary(*at)).unwrap_or(n.start);
        let before = text[from..n.start].to_ascii_lowercase();
        acts && before.rfind(" by ").is_some_and(|at| before.len() - at <= NEAR)
    })
}

/// A thing that a component names is before everything about the ego: "the stop sign requires a halt". After it, the
/// thing may be the object of the decision.
fn begins_with_cause(text: &str, texts: &Texts, words: &LabelWords, reading: &Reading) -> bool {
    let components = texts.all_components(words);
    let decided = reading.mentions.iter().map(|m| m.start).min().unwrap_or(text.len());
    let is_cause = |n: &Named| {
        let own = words.objects[n.group].own;
        own.meets(components) && !own.meets(words.known.no_cause) && !own.meets(words.known.road)
    };
    let because = reading.because.is_some_and(|at| at < decided);
    // "In the blind spot one has to slow, so it slows in the blind spot".
    let after = texts.trace.there().filter(|m| m.start >= decided).map(|m| m.group);
    let after: BTreeSet<usize> = after.collect();
    let again = |n: &Named| after.contains(&n.group);
    !because && texts.trace.there().any(|n| n.end <= decided && is_cause(n) && !again(n))
}

/// Some part of the text names a cause and is not the decision itself.
fn gives_cause(
    text: &str,
    texts: &Texts,
    words: &LabelWords,
    decision_in: &dyn Fn(usize, usize) -> bool,
) -> bool {
    let part_gives = |from: usize, to: usize| {
        let causes = |n: &Named| !words.objects[n.group].own.meets(words.known.no_cause);
        let names = texts.trace.named_in(from, to).iter().any(causes);
        // "A collision blocks our lane": whatever the words for the thing.
        let acts = texts.trace.acts_in(from, to).iter().any(|a| !a.denied && a.doing.meets(words.reaching));
        (names || acts) && !decision_in(from, to) && !is_own_duty(&text[from..to], &words.clauses)
    };
    let ends = || words.clauses.ends(&texts.units, &[Divider::Sentence, Divider::Clause], text.len());
    let mut from = 0;
    if ends().any(|to| part_gives(std::mem::replace(&mut from, to), to)) {
        return true;
    }
    // Most traces need no further check. Otherwise the reason may be in one part with the decision: "slows because of
    // the bend".
    let bounds = part_bounds(text, texts, &words.clauses);
    bounds.windows(2).any(|w| part_gives(w[0], w[1]))
}

/// A part about what the ego must do or wants.
fn is_own_duty(part: &str, clauses: &Clauses) -> bool {
    let begins =
        |text: &str, word: &str| text.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word));
    let part = part.trim_start_matches(|c: char| !c.is_alphanumeric());
    let because = clauses.because.iter().find(|w| begins(part, w));
    let part = because.map_or(part, |w| part[w.len()..].trim_start());
    clauses.own_duty.iter().any(|w| begins(part, w))
}

/// A cause may be in words that are in no list: words that are also in a component, apart from those of the decision.
fn has_other_words(text: &str, scope: &TextScope<'_>, decision_in: &dyn Fn(usize, usize) -> bool) -> bool {
    let TextScope { label, texts, words, .. } = *scope;
    let names = Spans::of(texts.trace.named.iter().map(|n| (n.start, n.end)));
    let is_name = |at: usize| names.holds(at);
    let apart = |at: usize| !decision_in(at.saturating_sub(6), at + 6) && !is_name(at);
    overlap::shared(label, text, &words.compared, &apart) >= if text.is_ascii() { 1 } else { 2 }
        || overlap::says_more(text, &words.compared, &apart)
}

/// The parts of the trace before and after its last decision contain only that decision: no thing, no state or number,
/// and no word that is not in the decision. The road user that the decision is about is ignored.
fn repeats(text: &str, scope: &TextScope<'_>, reading: &Reading) -> bool {
    let TextScope { label, texts, words, lexicon, .. } = *scope;
    /// A longer trace contains more than its decision.
    const LONGEST: usize = 160;
    if text.len() > LONGEST {
        return false;
    }
    // A sign, a surface or a place is a reason.
    let is_reason = |n: &Named| {
        let own = words.objects[n.group].own;
        !own.meets(words.known.actor) && !own.meets(words.known.no_cause)
    };
    if texts.trace.named.iter().any(is_reason) || text.contains(|c: char| c.is_ascii_digit()) {
        return false;
    }
    let bounds = part_bounds(text, texts, &words.clauses);
    let parts: Vec<(usize, usize)> = bounds.windows(2).map(|w| (w[0], w[1])).filter(|(a, b)| a < b).collect();
    let states =
        |(from, to): &(usize, usize)| trace_rules::states_decision(reading, lexicon, label, *from, *to);
    let Some(last) = parts.iter().rposition(states) else { return false };
    let (from, to) = parts[last];
    // An action of another road user is a reason, unless the decision is about it.
    let phrase = |m: &Mention| text[m.start..m.end].to_ascii_lowercase();
    let decided: Vec<String> =
        reading.mentions.iter().filter(|m| (from..to).contains(&m.start)).map(phrase).collect();
    if reading.mentions.iter().any(|m| m.by_other && !decided.contains(&phrase(m))) {
        return false;
    }
    let mut spoken: Vec<(usize, usize)> = reading.mentions.iter().map(|m| (m.start, m.end)).collect();
    spoken.extend(texts.trace.named.iter().map(|n| (n.start, n.end)));
    lexicon.hits(&texts.units, 0..text.len(), |hit| {
        if !matches!(hit.role, Role::Phrase(_) | Role::Neutral | Role::Hypothesis) {
            spoken.push((hit.start, hit.end));
        }
    });
    let content = |(from, to): (usize, usize)| content(text, from, to, &spoken, words);
    let own = content(parts[last]);
    let others: Vec<String> =
        parts.iter().enumerate().filter(|(i, _)| *i != last).flat_map(|(_, p)| content(*p)).collect();
    parts.len() > 1 && others.iter().all(|w| own.contains(w)) && own.iter().all(|w| others.contains(w))
}

/// A decision in words that are in no list is repeated as its own reason: the text after "because" has the words of the
/// text before it, except for one. It names only the acting road user.
fn echoes(text: &str, texts: &Texts, words: &LabelWords) -> bool {
    let lower = text.to_ascii_lowercase();
    let because = words.clauses.because.iter().chain(&words.clauses.again);
    let Some((at, length)) = because.filter_map(|w| Some((lower.find(w.as_str())?, w.len()))).min() else {
        return false;
    };
    let is_reason = |n: &Named| {
        let own = words.objects[n.group].own;
        n.start > at && !own.meets(words.known.actor) && !own.meets(words.known.no_cause)
    };
    if texts.trace.named.iter().any(is_reason) || text.contains(|c: char| c.is_ascii_digit()) {
        return false;
    }
    let named: Vec<(usize, usize)> = texts.trace.named.iter().map(|n| (n.start, n.end)).collect();
    let first = content(text, 0, at, &named, words);
    let second = content(text, at + length, text.len(), &named, words);
    // "Carries on" and "carrying on".
    let same =
        |a: &str, b: &str| a == b || a.is_ascii() && a.get(..4).is_some_and(|stem| b.starts_with(stem));
    let different: BTreeSet<&str> = first.iter().map(String::as_str).collect();
    let known = |w: &str| different.contains(w) || different.iter().any(|f| same(f, w));
    let said: BTreeSet<&str> = second.iter().map(String::as_str).collect();
    let unknown: BTreeSet<&str> = said.into_iter().filter(|w| !known(w)).collect();
    let new = second.iter().filter(|w| unknown.contains(w.as_str())).count();
    // A Chinese word has two characters.
    if text.is_ascii() { second.len() > new && new <= 1 } else { second.len() >= 2 + 2 * new && new <= 2 }
}

/// The reason that the trace marks as such adds nothing to its decision, whatever comes before: "because giving way is
/// what we are doing". It has no thing except places of the decision, no number, nothing about another road user, and
/// no other word.
fn empty_reason(text: &str, scope: &TextScope<'_>, reading: &Reading) -> bool {
    let TextScope { label, texts, words, lexicon, .. } = *scope;
    let lower = text.to_ascii_lowercase();
    let marks = words.clauses.because.iter().chain(&words.clauses.again);
    let marked = marks.flat_map(|w| lower.match_indices(w.as_str()).map(|(at, w)| at + w.len())).max();
    let Some(from) = marked else { return false };
    let (_, to) = words.clauses.around(&texts.units, from..from, text.len(), &|d| d != Divider::Aside);
    let Some(part) = text.get(from..to) else { return false };
    let inside = |at: usize| (from..to).contains(&at);
    let is_reason = |n: &Named| {
        let own = words.objects[n.group].own;
        inside(n.start) && !own.meets(words.known.no_cause) && !own.meets(words.known.road)
    };
    if texts.trace.named.iter().any(is_reason) || part.contains(|c: char| c.is_ascii_digit()) {
        return false;
    }
    // "Because it is slowing down", where "it" may be another road user.
    let acts = |n: &Named| words.objects[n.group].own.meets(words.known.actor);
    let somebody = || texts.trace.named.iter().any(|n| n.start < from && acts(n));
    let is_pronoun = |w: &str| w.eq_ignore_ascii_case("it") || w.eq_ignore_ascii_case("its");
    let of_it = || part.split(|c: char| !c.is_ascii_alphabetic()).any(is_pronoun);
    if (words.subjects.has_pronoun(part) && !words.subjects.speaks_of_ego(part) || of_it()) && somebody()
        || reading.mentions.iter().any(|m| inside(m.start) && (m.by_other || m.denied))
    {
        return false;
    }
    let decides = trace_rules::states_decision(reading, lexicon, label, from, to)
        || lexicon.stems.find(part, label.longitudinal.get(), label.lateral.get()).is_some();
    let mut spoken: Vec<(usize, usize)> =
        reading.mentions.iter().map(|m| (m.start, m.end)).filter(|m| inside(m.0)).collect();
    spoken.extend(texts.trace.named.iter().map(|n| (n.start, n.end)));
    // "As it is to slow here": the place and time of the ego are no cause.
    let lower_part = part.to_ascii_lowercase();
    let here = words.subjects.here.iter().flat_map(|w| lower_part.match_indices(w.as_str()));
    spoken.extend(here.map(|(at, w)| (from + at, from + at + w.len())));
    let before = content(text, 0, from, &[], words);
    let left = content(text, from, to, &spoken, words);
    let same = |a: &str, b: &str| a == b || a.is_ascii() && a.get(..4).is_some_and(|s| b.starts_with(s));
    // A word that is also in a component belongs to the scene.
    let given = descriptions(label);
    let of_scene = |w: &String| given.iter().any(|text| text.contains(w.as_str()));
    let [before, left] = [before, left].map(|all| all.into_iter().collect::<BTreeSet<String>>());
    decides && left.iter().all(|w| before.iter().any(|b| same(b, w)) && !of_scene(w))
}

/// A trace says one word three times that no component has, and nothing of anybody or of the road: "where one has to
/// slow one slows, this is where one has to slow, so we slow".
fn said_thrice(text: &str, scope: &TextScope<'_>) -> bool {
    /// A longer trace says more than its decision.
    const LONGEST: usize = 400;
    let TextScope { label, texts, words, .. } = *scope;
    let tells = texts.trace.acts.iter().any(|a| !a.denied) || !texts.trace.states.is_empty();
    if text.len() > LONGEST || tells || text.contains(|c: char| c.is_ascii_digit()) {
        return false;
    }
    // A thing is a reason, unless it is what is said three times.
    let again = |n: &Named| texts.trace.named.iter().filter(|m| m.group == n.group).count() >= 3;
    let is_reason = |n: &Named| {
        let own = words.objects[n.group].own;
        !own.meets(words.known.actor)
            && !own.meets(words.known.no_cause)
            && !own.meets(words.known.road)
            && !again(n)
    };
    if texts.trace.named.iter().any(is_reason) {
        return false;
    }
    let compared = &words.compared;
    let inside_name =
        |from: usize, to: usize| texts.trace.named.iter().any(|n| n.start <= from && to <= n.end);
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for (start, word) in latin_words(text) {
        let lower = word.to_ascii_lowercase();
        let is_empty = compared.is_deciding(&lower) || compared.is_plain(&lower) && !compared.is_own(&lower);
        if lower.len() >= 4 && !is_empty && !inside_name(start, start + word.len()) {
            let stem = ["ting", "ing", "ed", "es", "s", "e"].iter().find_map(|end| lower.strip_suffix(end));
            *counts.entry(stem.filter(|s| s.len() >= 3).unwrap_or(&lower).to_owned()).or_default() += 1;
        }
    }
    let is_letter = |c: char| {
        overlap::is_han(c) && !compared.of_no_scene.contains(c) && !words.subjects.counts.contains(c)
    };
    let chars: Vec<(usize, char)> = text.char_indices().collect();
    for w in chars.windows(2) {
        let (from, to) = (w[0].0, w[1].0 + w[1].1.len_utf8());
        if is_letter(w[0].1) && is_letter(w[1].1) && !inside_name(from, to) {
            *counts.entry(text[from..to].to_owned()).or_default() += 1;
        }
    }
    let given = descriptions(label);
    counts.iter().any(|(unit, count)| *count >= 3 && !given.iter().any(|text| text.contains(unit.as_str())))
}

/// Bounds of the parts of a trace: at marks, and before words that join or give a reason.
fn part_bounds(text: &str, texts: &Texts, clauses: &Clauses) -> Vec<usize> {
    let lower = text.to_ascii_lowercase();
    let ends = clauses.ends(&texts.units, &[Divider::Sentence, Divider::Clause], text.len());
    let mut bounds: Vec<usize> = std::iter::once(0).chain(ends).collect();
    for word in clauses.because.iter().chain(&clauses.beside) {
        bounds.extend(lower.match_indices(word.as_str()).map(|(at, _)| at));
    }
    bounds.sort_unstable();
    bounds
}

/// The words of Latin letters of a text, each with its first byte; empty ones between two other characters.
fn latin_words(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut at = 0;
    text.split(|c: char| !c.is_ascii_alphabetic()).map(move |word| {
        let start = at;
        // A separator is one character, of any length in bytes.
        at += word.len();
        at += text[at..].chars().next().map_or(0, char::len_utf8);
        (start, word)
    })
}

/// The texts of the label's components, in lower case.
fn descriptions(label: &View<'_>) -> Vec<String> {
    label.parts.iter().filter_map(|c| c.description.get()).map(str::to_ascii_lowercase).collect()
}

/// Content words (Latin words and Chinese characters) of a part, without those in the ranges `spoken`.
fn content(text: &str, from: usize, to: usize, spoken: &[(usize, usize)], words: &LabelWords) -> Vec<String> {
    let spoken = Spans::of(spoken.iter().copied());
    let hidden = |at: usize| spoken.holds(at);
    let (compared, common) = (&words.compared, &words.subjects.common);
    let mut out = Vec::new();
    for (at, word) in latin_words(&text[from..to]) {
        let lower = word.to_ascii_lowercase();
        if lower.len() >= 3
            && !hidden(from + at)
            && !compared.is_plain(&lower)
            && !compared.is_deciding(&lower)
        {
            out.push(lower);
        }
    }
    for (i, c) in text[from..to].char_indices() {
        let is_empty =
            compared.of_no_scene.contains(c) || compared.of_deciding.contains(c) || common.contains(c);
        if overlap::is_han(c) && !is_empty && !hidden(from + i) {
            out.push(c.to_string());
        }
    }
    out
}
