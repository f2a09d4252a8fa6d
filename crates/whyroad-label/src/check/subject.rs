//! Whether the thing that a component speaks of has been read. Where it stands in words that no list knows, what the
//! component names is not known, however many other words of it are. Only asked before a finding is made.

use super::reading::{Named, TextFacts};
use whyroad_framework::LabelWords;
use whyroad_framework::label_words::GroupSet;

/// The component's own thing is in words that no list knows. `background`: groups that say where something is.
pub(super) fn is_unread(text: &str, facts: &TextFacts, words: &LabelWords, background: GroupSet) -> bool {
    if text.is_ascii() {
        is_unread_latin(text, facts, words)
    } else {
        is_unread_chinese(text, facts, words, background)
    }
}

/// "A horsebox stands half on the verge": no thing is named up to the verb. Of a road and the like anything may be said.
fn is_unread_latin(text: &str, facts: &TextFacts, words: &LabelWords) -> bool {
    let mut end = text.len();
    let mut is_first = true;
    let mut at = 0;
    for word in text.split(|c: char| !c.is_ascii_alphanumeric() && c != '\'' && c != '-') {
        let start = at;
        at += word.len() + 1;
        let lower = word.to_ascii_lowercase();
        if lower.is_empty() || (is_first && matches!(lower.as_str(), "a" | "an" | "the")) {
            continue;
        }
        if is_first && (words.subjects.is_pronoun(&lower) || lower.starts_with(|c: char| c.is_ascii_digit()))
        {
            return false;
        }
        // A second article or pronoun begins what the thing does something to.
        let divides =
            is_determiner(&lower) || start > 0 && text[..start].trim_end().ends_with([',', ';', '.', ':']);
        if !is_first && (divides || words.subjects.ends(&lower)) {
            end = start;
            break;
        }
        is_first = false;
    }
    !facts.named.iter().any(|n| n.start < end)
}

/// Begins the words for a thing in Latin letters.
fn is_determiner(word: &str) -> bool {
    matches!(word, "a" | "an" | "the" | "our" | "its" | "his" | "her" | "their" | "us" | "it")
}

/// "胡同里来了一台小货": nothing is named behind the word that counts; or nothing at all but a place.
fn is_unread_chinese(text: &str, facts: &TextFacts, words: &LabelWords, background: GroupSet) -> bool {
    let subjects = &words.subjects;
    let chars: Vec<(usize, char)> = text.char_indices().collect();
    let counted =
        chars.windows(2).filter(|w| subjects.counts.contains(w[0].1) && subjects.counters.contains(w[1].1));
    let mut counted = counted.map(|w| w[1].0 + w[1].1.len_utf8()).peekable();
    let clause_end = |from: usize| {
        text[from..].find(['，', '。', '；', '、', '：', '！']).map_or(text.len(), |i| from + i)
    };
    // "从公交车前": where somebody comes from.
    let is_origin =
        |n: &Named| text[..n.start].ends_with(['从', '自', '由', '被', '把', '往', '向', '朝', '沿']);
    let within = |from: usize, to: usize| {
        facts.named.iter().any(|n| n.end > from && n.start < to && !(n.start > from && is_origin(n)))
    };
    if counted.peek().is_some() {
        return counted.any(|from| !within(from, clause_end(from)));
    }
    let is_place = |n: &Named| text[n.end..].starts_with(|c| subjects.places.contains(c));
    let is_thing = |n: &&Named| !words.objects[n.group].own.without(background).is_empty() && !is_place(n);
    !facts.named.iter().any(|n| is_thing(&n))
}
