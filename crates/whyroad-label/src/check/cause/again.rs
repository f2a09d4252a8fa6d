//! A trace that says the same again, in whatever words: most of what it says, or of what its last clauses say, stands
//! in it twice. True traces name a thing once and go on. A number is no repetition.

use crate::check::texts::Texts;
use whyroad_framework::LabelWords;
use whyroad_framework::label_words::{Divider, hashed};

/// Shares of repeated units, of Chinese and of Latin letters: in the whole trace, and between its last clauses.
const WHOLE: [f64; 2] = [0.65, 0.55];
const BETWEEN: [f64; 2] = [0.65, 0.6];
/// Fewer units may be repeated by chance.
const LEAST_WHOLE: usize = 3;
const LEAST_BETWEEN: usize = 5;
const LEAST_REPEATED: usize = 4;
/// Letters of a word that are compared.
const STEM: usize = 5;
/// Clauses that are read.
const MOST_CLAUSES: usize = 24;

/// Most of what the trace says stands in it twice.
pub(super) fn repeats_itself(text: &str, texts: &Texts, words: &LabelWords) -> bool {
    if text.contains(|c: char| c.is_ascii_digit()) {
        return false;
    }
    let all = units(text, words);
    let latin = usize::from(text.is_ascii());
    if all.len() < LEAST_WHOLE {
        return false;
    }
    let mut sorted: Vec<u64> = all.iter().map(|u| u.1).collect();
    sorted.sort_unstable();
    let repeated = count_repeated(&sorted);
    if repeated < LEAST_REPEATED {
        return false;
    }
    repeated as f64 >= WHOLE[latin] * all.len() as f64 || between_clauses(text, &all, texts, words)
}

/// From some clause on, most units stand in more than one clause.
fn between_clauses(text: &str, all: &[(usize, u64)], texts: &Texts, words: &LabelWords) -> bool {
    let latin = usize::from(text.is_ascii());
    let kinds = [Divider::Sentence, Divider::Clause, Divider::Item, Divider::Aside];
    let lower = text.to_ascii_lowercase();
    let because = words.clauses.because.iter().flat_map(|w| lower.match_indices(w.as_str()).map(|m| m.0));
    let mut ends: Vec<usize> = words.clauses.ends(&texts.units, &kinds, text.len()).chain(because).collect();
    ends.sort_unstable();
    let clause = |at: usize| ends.partition_point(|e| *e <= at);
    let clauses = ends.len().min(MOST_CLAUSES);
    (0..clauses).any(|first| {
        let tail = &all[all.partition_point(|u| clause(u.0) < first)..];
        if tail.len() < LEAST_BETWEEN {
            return false;
        }
        // Each once for a clause.
        let mut own: Vec<(usize, u64)> = tail.iter().map(|u| (clause(u.0), u.1)).collect();
        own.sort_unstable();
        own.dedup();
        let mut units: Vec<u64> = own.into_iter().map(|u| u.1).collect();
        units.sort_unstable();
        let again =
            |unit: u64| units.partition_point(|u| *u <= unit) - units.partition_point(|u| *u < unit) > 1;
        let repeated = tail.iter().filter(|u| again(u.1)).count();
        repeated as f64 >= BETWEEN[latin] * tail.len() as f64
    })
}

/// How many of the sorted units stand there more than once.
fn count_repeated(sorted: &[u64]) -> usize {
    sorted.chunk_by(|a, b| a == b).filter(|run| run.len() > 1).map(<[u64]>::len).sum()
}

/// Chinese characters and stems of words that say something, hashed, with the byte at which each starts.
fn units(text: &str, words: &LabelWords) -> Vec<(usize, u64)> {
    let compared = &words.compared;
    let mut out = Vec::new();
    let mut at = 0;
    for word in text.split(|c: char| !c.is_ascii_alphabetic()) {
        let start = at;
        at += word.len();
        at += text[at..].chars().next().map_or(0, char::len_utf8);
        if word.len() < 3 || compared.is_empty_word(word.chars().fold(0, hashed)) {
            continue;
        }
        let lower = word.to_ascii_lowercase();
        if !compared.is_plain(&lower) && !compared.is_deciding(&lower) {
            out.push((start, stem(&lower).chars().fold(0, hashed)));
        }
    }
    for (start, c) in text.char_indices() {
        let is_empty = compared.particles.contains(c)
            || compared.of_no_scene.contains(c)
            || compared.of_deciding.contains(c);
        if ('\u{4e00}'..='\u{9fff}').contains(&c) && !is_empty {
            out.push((start, u64::from(c) | 1 << 40));
        }
    }
    out.sort_unstable();
    out
}

/// "Braking" and "brakes" are one.
fn stem(word: &str) -> &str {
    let start = word.get(..STEM).unwrap_or(word);
    let endings = ["ing", "ed", "s", "e"];
    endings.iter().find_map(|e| start.strip_suffix(e)).filter(|s| !s.is_empty()).unwrap_or(start)
}

#[cfg(test)]
mod tests {
    use super::*;
    use whyroad_framework::Framework;
    use whyroad_framework::lexicon::units::Units;

    #[test]
    fn what_is_said_twice_is_said_again() {
        let words = Framework::bundled().label_words();
        let again = |text: &str| {
            let texts = Texts {
                components: Vec::new(),
                trace: crate::check::reading::TextFacts::default(),
                units: Units::of(text),
            };
            repeats_itself(text, &texts, words)
        };
        for text in [
            "之所以刹停，是因为该刹停的时候就得刹停",
            "Ego halts at the barrier, halting at the barrier being what the barrier halt is for.",
            "前面有一处弯道。自车收油降速，理由就是需要收油降速。",
        ] {
            assert!(again(text), "{text}");
        }
        for text in [
            "左侧货车打灯切入，车距很快变小，因此自车减速让货车先走",
            "A van is cutting in from the left, the gap to the van is closing, so the ego slows to let the van in.",
        ] {
            assert!(!again(text), "{text}");
        }
    }
}
