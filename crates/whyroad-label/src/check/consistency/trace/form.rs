//! Length of a trace and the numbers in it, in one pass.

use whyroad_framework::lexicon::Limits;

/// Measures of a trace.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::check) struct Form {
    /// In Chinese characters; a Latin word counts as several (lexicon file, `limits`).
    pub length: usize,
    /// Different numbers written in digits; `G6` and `SUV2` are names, not numbers.
    pub numbers: usize,
}

/// A Chinese character, which is counted individually. Uses ranges, because Unicode's own tables take longer than all
/// the rest of this pass.
fn is_ideograph(c: char) -> bool {
    matches!(c, '\u{3400}'..='\u{4DBF}' | '\u{4E00}'..='\u{9FFF}' | '\u{F900}'..='\u{FAFF}' | '\u{20000}'..='\u{3FFFF}')
}

pub(in crate::check) fn form(text: &str, limits: &Limits) -> Form {
    let mut out = Form::default();
    let (mut in_word, mut in_number) = (false, false);
    let mut numbers: Vec<&str> = Vec::new();
    for (at, c) in text.char_indices() {
        if is_ideograph(c) {
            (in_word, in_number) = (false, false);
            out.length += 1;
        } else if c.is_ascii_digit() {
            if !in_word && !in_number {
                in_number = true;
                out.length += 1;
                let end =
                    text[at..].find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len() - at);
                let number = text[at..at + end].trim_end_matches('.');
                if !numbers.contains(&number) {
                    numbers.push(number);
                }
            }
        } else if c.is_ascii_alphabetic() || (c < '\u{2E80}' && c.is_alphabetic()) {
            // `12.5m`: the unit belongs to its number.
            if !in_word && !in_number {
                out.length += limits.latin_word_counts_as;
            }
            (in_word, in_number) = (true, false);
        } else {
            // `12.5` and `don't` continue.
            in_number &= matches!(c, '.' | ':' | ',');
            in_word &= matches!(c, '\'' | '’' | '-');
        }
    }
    out.numbers = numbers.len();
    out
}
