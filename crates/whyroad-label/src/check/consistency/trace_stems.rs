//! The decision of a trace in words that match no phrase: by their stems they may still state the label's decision,
//! deny it, or contradict it for the ego. Used only where no phrase states the decision.

use crate::check::consistency::trace::{Force, Reading};
use crate::check::reading::Named;
use crate::check::spans::Spans;
use crate::check::texts::Texts;
use whyroad_framework::LabelWords;
use whyroad_framework::label_words::{Divider, GroupSet};
use whyroad_framework::lexicon::{Lexicon, Role};
use whyroad_model::decision::{Lateral, Longitudinal};

/// Maximum number of clauses that are read.
const MOST_CLAUSES: usize = 24;

/// Relation of the deciding words to the label's decision.
pub(super) enum ByStem {
    /// They state it. `contested`: words of the ego in the same clause contradict it.
    Stated { contested: bool },
    /// They deny it: bytes of the trace.
    Denied(usize, usize),
    /// They contradict it.
    Against(usize, usize),
    /// They are not recognized.
    Unread,
}

/// Reads the deciding clauses of the trace for these decisions of the label. The byte ranges `apart` of the trace are
/// left out.
pub(super) fn read(
    text: &str,
    reading: &Reading,
    lexicon: &Lexicon,
    (along, across): (Option<Longitudinal>, Option<Lateral>),
    texts: &Texts,
    words: &LabelWords,
    apart: Option<(usize, usize)>,
) -> ByStem {
    // Keeping the speed or the lane is nothing that "does not" would deny.
    let changes = along.filter(|d| *d != Longitudinal::SetSpeedTracking);
    let moves = across.filter(|d| *d != Lateral::LaneKeeping);
    let end = reading.end.min(text.len());
    let begin = reading.decision_from.min(end);
    let begin = begin + text[begin..end].find(char::is_alphanumeric).unwrap_or(0);
    let kinds = [Divider::Sentence, Divider::Clause, Divider::Item, Divider::Aside];
    let ends = words.clauses.ends(&texts.units, &kinds, end).filter(|to| *to > begin && *to <= end);
    let (mut found, mut is_ego, mut from) = (ByStem::Unread, false, begin);
    for to in ends.take(MOST_CLAUSES) {
        let Some(clause) = text.get(from..to) else { break };
        let (ego, other, mut hidden) = subjects(text, lexicon, texts, words, from, to);
        hidden.extend(apart);
        let clause = without(clause, from, &hidden);
        // After "therefore" a named road user is the object.
        let marked = reading.marked && from == begin;
        let can_act = |n: &&Named| n.is_there() && words.objects[n.group].named;
        let named = texts.trace.named_in(from, to).iter().find(can_act).map(|n| n.start);
        let acts = |at: usize| !marked && named.is_some_and(|n| n < from + at);
        // "Slower than us" is a comparison, not slowing.
        let compares = |at: usize| clause[..at].contains('比');
        let stem = lexicon
            .stems
            .find(&clause, along, across)
            .filter(|at| !describes(&clause[..*at], &clause[*at..], words) && !compares(*at));
        let denied = reading.mentions_in(from, to).iter().any(|m| m.force == Force::Negated);
        if stem.is_some_and(|at| !acts(at)) && !denied {
            let contested = lexicon.stems.against(&clause, along, across).is_some();
            return ByStem::Stated { contested };
        }
        // The ego is the actor until another road user is.
        let other = other.into_iter().chain(named).min();
        is_ego = marked || (is_ego && other.is_none()) || ego.is_some();
        let by_ego = |(at, _): &(usize, usize)| {
            let at = from + at;
            is_ego && (marked || ego.is_some_and(|e| e < at) || other.is_none_or(|o| at <= o))
        };
        // "Without changing lanes we miss it".
        let follows = |(_, at): &(usize, usize)| !clause[*at..].starts_with(['就', '则', '便', '准', '会']);
        if matches!(found, ByStem::Unread) {
            if let Some((a, b)) = lexicon.stems.denied(&clause, changes, moves).filter(by_ego).filter(follows)
            {
                found = ByStem::Denied(from + a, from + b);
            } else if let Some((a, b)) = lexicon.stems.against(&clause, along, across).filter(by_ego) {
                found = ByStem::Against(from + a, from + b);
            }
        }
        from = to;
    }
    found
}

/// A Latin word in the past tense after an article is an attribute: "the followed van".
fn describes(before: &str, from: &str, words: &LabelWords) -> bool {
    let word = from.split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
    let last = before.trim_end().rsplit(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
    word.ends_with("ed") && words.subjects.articles.iter().any(|a| a.eq_ignore_ascii_case(last))
}

/// Position in a part of the trace where it first names the ego, and where another road user; and ranges in it that are
/// names of things: "the stop line" is no stop.
fn subjects(
    text: &str,
    lexicon: &Lexicon,
    texts: &Texts,
    words: &LabelWords,
    from: usize,
    to: usize,
) -> (Option<usize>, Option<usize>, Vec<(usize, usize)>) {
    let (mut ego, mut other, mut hidden) = (None, None, Vec::new());
    lexicon.hits(&texts.units, from..to, |hit| match hit.role {
        // "Far slower than us" describes the location or manner of another road user.
        Role::Ego if lexicon.is_place_of_ego(text, hit.start, hit.end) => {}
        // "So the ego" is one word.
        Role::Ego | Role::DecisionMarker => drop(ego.get_or_insert(hit.start)),
        Role::Agent => drop(other.get_or_insert(hit.start)),
        Role::Neutral => hidden.push((hit.start, hit.end)),
        _ => {}
    });
    let things = texts.trace.named_in(from, to).iter();
    // "With a headway of a second": a measure is the ego's decision only where the ego acts, or in the last clause.
    let is_last = to >= texts.units.all().last().map_or(0, |u| u.start);
    let measure = if ego.is_some() || is_last { GroupSet::default() } else { words.known.gap };
    let named = words.known.sign.with(words.known.actor).with(measure);
    let is_name = |n: &&Named| words.objects[n.group].own.meets(named);
    hidden.extend(things.filter(is_name).filter(|n| n.end <= to).map(|n| (n.start, n.end)));
    (ego, other, hidden)
}

/// `clause`, which starts at `from`, with the ranges `hidden` replaced by spaces.
fn without(clause: &str, from: usize, hidden: &[(usize, usize)]) -> String {
    let hidden = Spans::of(hidden.iter().copied());
    let mut out = String::with_capacity(clause.len());
    for (at, c) in clause.char_indices() {
        match hidden.holds(from + at) {
            true => out.extend(std::iter::repeat_n(' ', c.len_utf8())),
            false => out.push(c),
        }
    }
    out
}
