//! Words that a trace shares with the components, whatever they name. Used only before a finding is reported.

use super::view::View;
use whyroad_framework::LabelWords;
use whyroad_framework::label_words::Compared;

/// Maximum number of units of a trace that are compared: a longer one is reported for its length.
const MOST_UNITS: usize = 200;

/// Number of distinct pairs of Chinese characters, or words of four and more letters, in the ranges `inside` of the
/// trace that are also in the components.
pub(super) fn shared(
    label: &View<'_>,
    text: &str,
    words: &Compared,
    inside: &dyn Fn(usize) -> bool,
) -> usize {
    shared_of(label.parts.iter().filter_map(|c| c.description.get()), text, words, inside)
}

/// The same with one component.
pub(super) fn shared_with(
    component: &str,
    text: &str,
    words: &Compared,
    inside: &dyn Fn(usize) -> bool,
) -> usize {
    shared_of(std::iter::once(component), text, words, inside)
}

fn shared_of<'t>(
    components: impl Iterator<Item = &'t str>,
    text: &str,
    words: &Compared,
    inside: &dyn Fn(usize) -> bool,
) -> usize {
    let mut ours: Vec<String> = Vec::new();
    units(text, words, |at, unit| {
        if ours.len() < MOST_UNITS && inside(at) {
            ours.push(unit);
        }
    });
    ours.sort_unstable();
    ours.dedup();
    let mut theirs: Vec<String> = Vec::new();
    for c in components {
        units(c, words, |_, unit| theirs.push(unit));
    }
    theirs.sort_unstable();
    ours.iter().filter(|u| theirs.binary_search(u).is_ok()).count()
}

/// A Chinese character of the basic block of Unicode.
pub(super) fn is_han(c: char) -> bool {
    matches!(c, '\u{4e00}'..='\u{9fff}')
}

/// Most content characters of a Chinese trace are in the components: "红的。第一辆。线就在前头。停。".
pub(super) fn shares_characters(label: &View<'_>, text: &str, words: &LabelWords) -> bool {
    const ENOUGH: usize = 3;
    let telling = |c: &char| {
        is_han(*c) && !words.compared.of_no_scene.contains(*c) && !words.subjects.common.contains(*c)
    };
    let has = |c: &char| label.parts.iter().filter_map(|p| p.description.get()).any(|t| t.contains(*c));
    let mut all: Vec<char> = text.chars().take(MOST_UNITS).filter(telling).collect();
    all.sort_unstable();
    all.dedup();
    let shared = all.iter().filter(|c| has(c)).count();
    shared >= ENOUGH && 2 * shared >= all.len()
}

/// The component contains a word of the name of a thing; in Chinese two characters, or, unless it `acts`, the last one:
/// "红牌" and "牌子".
pub(super) fn has_word_of(component: &str, name: &str, acts: bool, words: &LabelWords) -> bool {
    if name.is_ascii() {
        let same = |a: &str, b: &str| {
            let stem = |w: &str| w.strip_suffix('s').unwrap_or(w).to_owned();
            stem(a) == stem(b)
        };
        let of = |text: &'_ str| -> Vec<String> {
            let all = text.split(|c: char| !c.is_ascii_alphanumeric());
            let all = all.filter(|w| w.len() >= 3).map(str::to_ascii_lowercase);
            all.filter(|w| !words.compared.is_plain(w) && !words.subjects.common_words.contains(w)).collect()
        };
        let theirs = of(component);
        return of(name).iter().any(|w| theirs.iter().any(|t| same(w, t)));
    }
    if name.chars().nth(1).is_some() && component.contains(name) {
        return true;
    }
    // The last character is the kind of the thing, unless it is in the names of many.
    let head = name.trim_end_matches(['子', '儿']).chars().next_back();
    let chars: Vec<char> = name.chars().collect();
    let telling = |c: &char| !words.subjects.common.contains(*c) && !c.is_ascii();
    // "缺口" for "缺了一段".
    let any_of_two =
        !acts && chars.len() == 2 && chars.iter().filter(|c| telling(c)).any(|c| component.contains(*c));
    any_of_two
        || (!acts && head.filter(telling).is_some_and(|c| component.contains(c)))
        || chars
            .windows(2)
            .filter(|w| w.iter().all(telling))
            .any(|w| component.contains(&String::from_iter(w)))
}

/// The ranges `inside` have content of their own and are no mere repetition.
pub(super) fn says_more(text: &str, words: &Compared, inside: &dyn Fn(usize) -> bool) -> bool {
    if text.is_ascii() {
        let mut all = Vec::new();
        units(text, words, |at, unit| {
            if all.len() < MOST_UNITS && inside(at) && !all.contains(&unit) {
                all.push(unit);
            }
        });
        return all.len() >= 5;
    }
    let mut all: Vec<char> = text
        .char_indices()
        .take(MOST_UNITS)
        .filter(|(at, c)| {
            inside(*at)
                && c.is_alphabetic()
                && !words.of_no_scene.contains(*c)
                && !words.of_deciding.contains(*c)
        })
        .map(|(_, c)| c)
        .collect();
    all.sort_unstable();
    all.dedup();
    all.len() >= 6
}

/// Units of a text with the byte at which each starts.
fn units(text: &str, words: &Compared, mut take: impl FnMut(usize, String)) {
    let mut last: Option<(usize, char)> = None;
    let mut word = (0, String::new());
    let end = std::iter::once((text.len(), ' '));
    for (at, c) in text.char_indices().chain(end) {
        if c.is_ascii_alphabetic() {
            if word.1.is_empty() {
                word.0 = at;
            }
            word.1.push(c.to_ascii_lowercase());
            last = None;
            continue;
        }
        let w = std::mem::take(&mut word.1);
        if w.len() >= 4 && !words.is_plain(&w) {
            let stem = w.strip_suffix('s').filter(|s| s.len() >= 4).unwrap_or(&w).to_owned();
            take(word.0, stem);
        }
        if !c.is_alphabetic() || words.of_no_scene.contains(c) {
            last = None;
            continue;
        }
        if let Some((start, before)) = last {
            take(start, format!("{before}{c}"));
        }
        last = Some((at, c));
    }
}
