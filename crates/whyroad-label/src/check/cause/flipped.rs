//! A clause of an English trace that denies what a component states, by the same word: "the branch does not poke out of
//! the hedge", "there is no deer". Words are compared by their stems, and the sense of each by the negation before it.

use crate::check::consistency::last_action::last_sentence;
use crate::check::texts::TextScope;
use std::collections::BTreeSet;

/// Words before a word of a component within which a negation is about it.
const NEAR: usize = 3;
/// Maximum words of a clause that is read.
const LONGEST: usize = 60;
/// Nothing is compared by these.
const EMPTY: [&str; 44] = [
    "a", "an", "the", "is", "are", "was", "be", "been", "being", "has", "have", "had", "to", "of", "in",
    "on", "at", "by", "for", "with", "and", "or", "but", "so", "as", "it", "its", "our", "we", "us", "i",
    "that", "this", "there", "here", "now", "up", "down", "out", "any", "all", "yet", "still", "just",
];

/// A word, its first byte and its end.
type Word<'t> = (&'t str, usize, usize);

fn words(text: &str) -> Vec<Word<'_>> {
    let inside = |c: char| c.is_ascii_alphabetic() || c == '\'';
    let mut out = Vec::new();
    let mut from = None;
    for (at, c) in text.char_indices().chain([(text.len(), ' ')]) {
        match (inside(c), from) {
            (true, None) => from = Some(at),
            (false, Some(begin)) => {
                out.push((&text[begin..at], begin, at));
                from = None;
            }
            _ => {}
        }
    }
    out
}

fn denies(word: &str) -> bool {
    word.ends_with("n't")
        || ["not", "no", "never", "nor", "none", "nobody", "nothing", "without"].contains(&word)
}

/// The word without an ending: "pokes", "poking" and "poked" are "pok".
fn stem(word: &str) -> String {
    const LEAST: usize = 3;
    let word = word.strip_suffix("'s").unwrap_or(word);
    let cut = ["ing", "ied", "ed", "es", "s"].iter().filter_map(|e| word.strip_suffix(e));
    let mut out = cut.filter(|rest| rest.len() >= LEAST).map(str::to_owned).next().unwrap_or(word.to_owned());
    let twice = out.len() > LEAST && out.as_bytes()[out.len() - 1] == out.as_bytes()[out.len() - 2];
    if twice {
        out.pop();
    }
    out.trim_end_matches('e').to_owned()
}

fn counts(word: &str) -> bool {
    !EMPTY.contains(&word) && !denies(word)
}

/// Bytes of the clause. Not where the same is asserted elsewhere in the trace, or denied in a component.
pub(super) fn flipped(scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let text = scope.label.trace.get()?;
    let lower = text.to_ascii_lowercase();
    let until = last_sentence(&lower).0;
    let denies_some = ["n't ", " not ", " no "].iter().any(|w| lower[..until].contains(w));
    if !denies_some || !lower[..until].is_ascii() {
        return None;
    }
    let (mut stated, mut denied, mut all) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    for part in scope.label.parts.iter().filter_map(|c| c.description.get()) {
        let part = part.to_ascii_lowercase();
        let own = words(&part);
        for (i, (word, ..)) in own.iter().enumerate().filter(|(_, w)| counts(w.0)) {
            let is_denied = own[i.saturating_sub(NEAR)..i].iter().any(|w| denies(w.0));
            if is_denied {
                denied.insert(stem(word))
            } else {
                stated.insert(stem(word))
            };
            all.insert(stem(word));
        }
    }
    let (mut found, mut asserted) = (Vec::new(), BTreeSet::new());
    let mut from = 0;
    for clause in lower[..until].split_inclusive([',', ';', ':', '.', '!', '?']) {
        let own = words(clause);
        let read = if own.len() > LONGEST { 0 } else { own.len() };
        for (i, (word, ..)) in own[..read].iter().enumerate().filter(|(_, w)| counts(w.0)) {
            let Some(negation) = negation_before(&own, i) else {
                asserted.insert(stem(word));
                continue;
            };
            let subject = |w: &Word<'_>| counts(w.0) && all.contains(&stem(w.0));
            if own[negation].0 == "no" || own[..negation].iter().any(subject) {
                found.push((stem(word), from, from + clause.trim_end().len()));
            }
        }
        from += clause.len();
    }
    let hit = found
        .into_iter()
        .find(|(s, ..)| !s.is_empty() && stated.contains(s) && !denied.contains(s) && !asserted.contains(s));
    hit.map(|(_, start, end)| (start + (lower[start..end].len() - lower[start..end].trim_start().len()), end))
}

/// Place of what denies the word `i`: "is not flashing", "doesn't poke", "there is no deer".
fn negation_before(own: &[Word<'_>], i: usize) -> Option<usize> {
    const SHORT: [&str; 6] = ["isn't", "aren't", "hasn't", "haven't", "doesn't", "don't"];
    const LONG: [&str; 6] = ["is", "are", "has", "have", "does", "do"];
    let word = |back: usize| i.checked_sub(back).map_or("", |at| own[at].0);
    if SHORT.contains(&word(1)) {
        return Some(i - 1);
    }
    if word(1) == "not" && LONG.contains(&word(2)) {
        return Some(i - 1);
    }
    let no = if word(1) == "no" { 1 } else { 2 };
    let there = word(no + 1) == "there's" || ["is", "are"].contains(&word(no + 1)) && word(no + 2) == "there";
    let doing = own[i].0.ends_with("ing") || no == 2 && word(1).ends_with("ing");
    (word(no) == "no" && there && !doing).then(|| i - no)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_is_compared_by_its_stem() {
        for word in ["poke", "pokes", "poked", "poking"] {
            assert_eq!(stem(word), "pok", "{word}");
        }
        assert_eq!(stem("stopped"), stem("stops"));
    }

    #[test]
    fn what_denies_a_word_stands_right_before_it() {
        let at = |text: &str| {
            let all = words(text);
            negation_before(&all, all.len() - 1)
        };
        assert_eq!(at("the branch does not poke"), Some(3));
        assert_eq!(at("the light isn't flashing"), Some(2));
        assert_eq!(at("there is no deer"), Some(2));
        assert_eq!(at("there is no stopping"), None);
        assert_eq!(at("we can't tell"), None);
    }
}
