//! Whether a changed text has the same meaning. A program cannot know this; these rules err towards "meaning".
//!
//! 1. Texts that differ only in blanks, punctuation, letter case or full-width forms are the same.
//! 2. The *hard parts* are the parts by which a labeler measures or excludes: numbers, comparison signs, words of
//!    negation, and words of comparison or bound ("over", "at most", "至少"). Other hard parts: another meaning.
//! 3. With equal hard parts, a text that changed in one language only was reworded: the other language fixes the
//!    meaning. If it changed in both, it was reworded when each is still close to the old text; otherwise the meaning
//!    changed.

use whyroad_model::Bilingual;

/// Minimum similarity of close texts, 0 to 1. One changed word in ten gives about this.
const CLOSE: f64 = 0.8;

/// Judgment on a pair of texts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Wording {
    /// No relevant difference.
    Same,
    /// Said differently.
    Reworded,
    /// Changed meaning, as far as can be determined.
    Meaning,
}

/// Compares two bilingual texts; a language that one side leaves empty is not compared.
pub(super) fn compare_text(before: &Bilingual, after: &Bilingual) -> Wording {
    let pairs = [(&before.zh, &after.zh), (&before.en, &after.en)];
    let stated: Vec<_> = pairs.into_iter().filter(|(x, y)| !x.is_empty() && !y.is_empty()).collect();
    let changed: Vec<_> =
        stated.iter().filter(|(x, y)| bare(x) != bare(y) || hard_parts(x) != hard_parts(y)).collect();
    if changed.is_empty() {
        return Wording::Same;
    }
    if changed.iter().any(|(x, y)| hard_parts(x) != hard_parts(y)) {
        return Wording::Meaning;
    }
    let pinned = changed.len() < stated.len();
    let close = |x: &str, y: &str| strsim::normalized_levenshtein(&bare(x), &bare(y)) >= CLOSE;
    if pinned || changed.iter().all(|(x, y)| close(x, y)) { Wording::Reworded } else { Wording::Meaning }
}

/// Full-width ASCII to ASCII, lower case.
fn fold(text: &str) -> String {
    let narrow = |c: char| match c as u32 {
        n @ 0xFF01..=0xFF5E => char::from_u32(n - 0xFEE0).unwrap_or(c),
        0x3000 => ' ',
        _ => c,
    };
    text.chars().map(narrow).flat_map(char::to_lowercase).collect()
}

/// Letters and digits only.
fn bare(text: &str) -> String {
    fold(text).chars().filter(|c| c.is_alphanumeric()).collect()
}

/// Words that negate or limit a statement. Chinese ones are looked for anywhere, English ones as whole words.
const TURNS_ZH: &[&str] = &[
    "不", "无", "未", "没", "非", "除", "至少", "至多", "以上", "以下", "大于", "小于", "超过", "低于", "仅",
    "或",
];
const TURNS_EN: &[&str] = &[
    "not", "no", "never", "without", "unless", "except", "only", "or", "over", "under", "above", "below",
    "least", "most", "more", "less", "than", "before", "after",
];

/// The hard parts of the text, in order.
fn hard_parts(text: &str) -> Vec<String> {
    let text = fold(text).replace('≥', ">=").replace('≤', "<=");
    let chars: Vec<char> = text.chars().collect();
    let mut out = Vec::new();
    let mut i = 0;
    while i < chars.len() {
        let run = |ok: fn(char) -> bool| chars[i..].iter().take_while(|c| ok(**c)).collect::<String>();
        let c = chars[i];
        if c.is_ascii_digit() {
            let number = run(|c| c.is_ascii_digit() || c == '.');
            i += number.chars().count();
            out.push(number.trim_end_matches('.').to_owned());
        } else if matches!(c, '<' | '>' | '=') {
            let sign = run(|c| matches!(c, '<' | '>' | '='));
            i += sign.chars().count();
            out.push(sign);
        } else if c.is_ascii_alphabetic() {
            let word = run(|c| c.is_ascii_alphanumeric() || c == '_');
            i += word.chars().count();
            // An id such as `traffic_light` names a class or decision.
            if TURNS_EN.contains(&word.as_str()) || word.contains('_') {
                out.push(word);
            }
        } else {
            let rest: String = chars[i..].iter().take(2).collect();
            match TURNS_ZH.iter().find(|w| rest.starts_with(**w)) {
                Some(word) => {
                    out.push((*word).to_owned());
                    i += word.chars().count();
                }
                None => i += 1,
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judge(before: (&str, &str), after: (&str, &str)) -> Wording {
        compare_text(&Bilingual::new(before.0, before.1), &Bilingual::new(after.0, after.1))
    }

    #[test]
    fn thresholds_and_negations_are_meaning() {
        // Expected values by how a labeler would apply each text.
        let before = ("TTC < 3s", "TTC < 3 s");
        assert_eq!(judge(before, ("TTC < 4s", "TTC < 4 s")), Wording::Meaning);
        assert_eq!(judge(before, ("TTC >= 3s", "TTC >= 3 s")), Wording::Meaning);
        assert_eq!(judge(before, ("ＴＴＣ＜3s。", "ttc <3 s.")), Wording::Same);
        assert_eq!(judge(("停车等待", "stops and waits"), ("不停车等待", "does not stop")), Wording::Meaning);
        // One language alone is enough when its hard parts change.
        assert_eq!(judge(before, ("TTC < 3s", "TTC < 5 s")), Wording::Meaning);
    }

    #[test]
    fn the_unchanged_language_pins_the_meaning() {
        let before = ("前车突然急刹", "The lead brakes hard");
        assert_eq!(
            judge(before, ("前车突然急刹", "The vehicle ahead suddenly brakes sharply")),
            Wording::Reworded
        );
        assert_eq!(judge(before, ("旁车缓慢靠近", "A neighbor drifts closer")), Wording::Meaning);
    }

    #[test]
    fn what_one_side_does_not_state_is_not_compared() {
        assert_eq!(judge(("路口内切入", ""), ("路口内切入", "Cut-in inside a junction")), Wording::Same);
        assert_eq!(judge(("", ""), ("路口", "junction")), Wording::Same);
    }
}
