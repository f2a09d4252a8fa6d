//! A trace that was completely read and states no decision: every clause describes a fact about something other than
//! the ego, or a hypothesis. If a clause may be an action of the ego in words that are in no list, nothing is reported.

use crate::check::consistency::trace::Reading;
use crate::check::reading::Named;
use crate::check::texts::Texts;
use whyroad_framework::LabelWords;
use whyroad_framework::label_words::{ClauseMood, Divider};

/// Maximum number of clauses that are read.
const MOST_CLAUSES: usize = 24;

/// Whether the ego may act in Chinese before the last clause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Strict {
    /// It may not.
    Yes,
    /// It may: what it is about.
    No,
}

/// No part of the trace is an action of the ego.
pub(super) fn is_undecided(
    text: &str,
    reading: &Reading,
    texts: &Texts,
    words: &LabelWords,
    strict: Strict,
) -> bool {
    // A part marked by "therefore" is a decision, whatever its words; in English, unless it describes a fact.
    if reading.marked && (!text.is_ascii() || acts_when_marked(text, reading)) {
        return false;
    }
    let kinds = [Divider::Sentence, Divider::Clause];
    let end = text.trim_end().trim_end_matches(['.', '。', '!', '！']).len();
    let ends = words.clauses.ends(&texts.units, &kinds, end).filter(|to| *to <= end);
    let mut clauses: Vec<(usize, usize)> = Vec::new();
    for to in ends.take(MOST_CLAUSES) {
        let mut from = clauses.last().map_or(0, |c| c.1);
        // "A gap is going and there is little time": two clauses.
        while let Some(joint) = text.get(from..to).and_then(|part| {
            let next = words.clauses.clause_end(&texts.units, from + 1, to);
            (next > from + 1 && next < to && !part.is_empty()).then_some(next)
        }) {
            clauses.push((from, joint));
            from = joint;
        }
        clauses.push((from, to));
    }
    clauses.retain(|(from, to)| text[*from..*to].contains(char::is_alphanumeric));
    let Some(&(last, _)) = clauses.last() else { return false };
    let marks = texts.units.marks();
    let sentences = marks.iter().filter(|m| words.clauses.divides(**m) == Some(Divider::Sentence));
    let last_sentence = sentences.map(|m| m.end()).rfind(|at| *at < end).unwrap_or(0);
    let is_thing = |n: &&Named| !words.objects[n.group].own.meets(words.known.no_cause);
    clauses.iter().all(|&(from, to)| {
        let begin = text[from..to].find(char::is_alphanumeric).map_or(from, |i| from + i);
        let inside = texts.trace.named.iter().filter(|n| (begin..to).contains(&n.start)).filter(is_thing);
        let names: Vec<usize> = inside.map(|n| n.start - begin).collect();
        match words.undecided.mood(&text[begin..to], &names) {
            ClauseMood::State => true,
            // In Chinese the decision comes last; in English the last sentence states it.
            ClauseMood::Open if text.is_ascii() => begin < last_sentence,
            ClauseMood::Acts if strict == Strict::Yes => false,
            _ => from < last && !text.is_ascii(),
        }
    })
}

/// After "so" and similar words "it" is the ego, unless the clause describes a fact: "so it leaves the road".
fn acts_when_marked(text: &str, reading: &Reading) -> bool {
    let part = text.get(reading.decision_from..).unwrap_or_default().to_ascii_lowercase();
    let all: Vec<&str> = part.split(|c: char| !c.is_ascii_alphabetic()).filter(|w| !w.is_empty()).collect();
    let Some(at) = all.iter().take(5).position(|w| ["it", "they"].contains(w)) else { return false };
    let is = ["is", "are", "was", "were", "has", "had", "will", "would", "can", "could", "may", "might", "s"];
    !all.get(at + 1).is_some_and(|w| is.contains(w))
}
