//! Length, repetition and small changes of a draft's text.

use std::ops::RangeInclusive;
use whyroad_model::Lang;

/// Length of a run of words that is noticed when it is repeated: characters in Chinese, words in English.
const REPEATED_ZH: usize = 4;
const REPEATED_EN: usize = 3;

/// Places and maneuvers that a text names once.
const ONCE_ZH: [&str; 8] = ["环岛", "路口", "汇入", "匝道", "主路", "斑马线", "闸机", "收费"];
const ONCE_EN: [&str; 8] =
    ["roundabout", "junction", "merg", "ramp", "main road", "crosswalk", "gate", "toll"];

/// Preferred length in characters (LABELING.md 7: 50 to 100 in Chinese; in English about 25 to 60 words).
pub(super) fn wanted(lang: Lang) -> RangeInclusive<usize> {
    match lang {
        Lang::Zh => 50..=100,
        Lang::En => 120..=330,
    }
}

/// Maximum number of words of an English trace.
const MOST_WORDS: usize = 60;

pub(super) fn fits(text: &str, lang: Lang) -> bool {
    wanted(lang).contains(&text.chars().count())
        && (lang == Lang::Zh || text.split_whitespace().count() <= MOST_WORDS)
}

/// The text names a place or a maneuver twice.
pub(super) fn names_twice(text: &str, lang: Lang) -> bool {
    let text = text.to_ascii_lowercase();
    let once = if lang == Lang::Zh { &ONCE_ZH } else { &ONCE_EN };
    once.iter().any(|word| text.matches(word).count() > 1)
}

/// A run of words of the reason or the decision occurs twice. The first `state` bytes are the state, in which
/// components may repeat each other.
pub(super) fn repeats(text: &str, state: usize, lang: Lang) -> bool {
    let (state, rest) = text.split_at_checked(state).unwrap_or(("", text));
    let before = runs(state, lang);
    let mut all = runs(rest, lang);
    all.sort_unstable();
    all.windows(2).any(|pair| pair[0] == pair[1]) || all.iter().any(|run| before.contains(run))
}

/// Runs of words within the clauses of a text, in lower case.
fn runs(text: &str, lang: Lang) -> Vec<String> {
    let text = text.to_ascii_lowercase();
    let clauses = text.split(|c: char| c.is_ascii_punctuation() || "，。；".contains(c));
    let of = |clause: &str| -> Vec<String> {
        match lang {
            Lang::Zh => {
                let chars: Vec<char> = clause.chars().collect();
                chars.windows(REPEATED_ZH).map(String::from_iter).collect()
            }
            Lang::En => {
                let words: Vec<&str> = clause.split_whitespace().collect();
                words.windows(REPEATED_EN).map(|run| run.join(" ")).collect()
            }
        }
    };
    clauses.flat_map(of).collect()
}

/// The text of an action whose side is not known yet; a person adds it.
pub(super) fn without_side(text: &str) -> String {
    let parts = [
        ("向{side}偏移", "向一侧偏移"),
        ("向{side}", ""),
        ("从{side}侧", ""),
        ("{side}转", "转弯"),
        (" to the {side} lane", " lanes"),
        (" to the {side}", ""),
        (" {side}", ""),
    ];
    parts.iter().fold(text.to_owned(), |text, (with, without)| text.replace(with, without))
}

/// The text of a turn that leads back.
pub(super) fn backwards(text: &str) -> String {
    let parts = [("向{side}转弯", "掉头"), ("{side}转", "掉头"), ("turns {side}", "makes a U-turn")];
    let text = parts.iter().fold(text.to_owned(), |text, (with, without)| text.replace(with, without));
    without_side(&text)
}

pub(super) fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |c| c.to_uppercase().chain(chars).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_that_is_named_twice_is_found() {
        assert!(names_twice("前方道路通向环岛；自车要绕环岛行驶，因此自车右转驶入。", Lang::Zh));
        assert!(!names_twice("前方道路通向环岛；自车要绕着它通过，因此自车右转驶入。", Lang::Zh));
        assert!(names_twice("The ego drives in the roundabout. It leaves the roundabout here.", Lang::En));
        assert!(!names_twice("The ego merges; a junction lies ahead.", Lang::En));
    }

    #[test]
    fn a_run_of_words_that_occurs_twice_is_found() {
        assert!(repeats("自车要从这个路口直行通过，因此自车直行通过路口", 0, Lang::Zh));
        assert!(!repeats("前方为路口，自车已打右转向灯，因此向右转弯", 0, Lang::Zh));
        assert!(repeats("The car ahead is slow; the car ahead stops", 0, Lang::En));
        assert!(!repeats("The car ahead is slow; the ego follows it", 0, Lang::En));
        // "车道前方" occurs twice, but only in the state.
        let state = "本车道前方的轿车较慢，左侧车道前方比较空";
        assert!(!repeats(&format!("{state}；因此向左变道"), state.len(), Lang::Zh));
    }
}
