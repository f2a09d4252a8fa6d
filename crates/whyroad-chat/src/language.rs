//! Checks that a text is in the requested language.

use whyroad_model::{Bilingual, Diagnostic, Lang, Location};

/// This many consecutive letters of the other script are a word.
const WORD: usize = 2;

fn is_han(c: char) -> bool {
    matches!(c, '\u{3400}'..='\u{9fff}' | '\u{f900}'..='\u{faff}')
}

/// The first piece of `text` that is not of `lang`; the whole text where no part of it is.
pub(crate) fn foreign(text: &str, lang: Lang) -> Option<&str> {
    match lang {
        Lang::En => text.char_indices().find(|(_, c)| is_han(*c)).map(|(at, _)| piece(&text[at..], is_han)),
        Lang::Zh if !text.chars().any(is_han) => Some(text),
        Lang::Zh => {
            let latin = |c: char| c.is_alphabetic() && !is_han(c);
            let mut rest = text;
            while let Some(at) = rest.find(latin) {
                let word = piece(&rest[at..], latin);
                let is_unit = rest[..at].trim_end().ends_with(|c: char| c.is_ascii_digit());
                if word.chars().count() >= WORD && !is_unit {
                    return Some(word);
                }
                rest = &rest[at + word.len()..];
            }
            None
        }
    }
}

fn piece(text: &str, is_part: impl Fn(char) -> bool) -> &str {
    &text[..text.find(|c| !is_part(c)).unwrap_or(text.len())]
}

/// A finding for each of these texts that is not in `lang`.
pub(crate) fn findings<'t>(texts: impl Iterator<Item = (String, &'t str)>, lang: Lang) -> Vec<Diagnostic> {
    texts
        .filter_map(|(pointer, text)| {
            let word: String = foreign(text, lang)?.chars().take(40).collect();
            let message = Bilingual::new(
                format!("“{word}”不是{}", if lang == Lang::Zh { "中文" } else { "英文" }),
                format!("'{word}' is not {}", if lang == Lang::Zh { "Chinese" } else { "English" }),
            );
            let location = Location { pointer: Some(pointer), ..Location::default() };
            Some(Diagnostic::error("draft.language", message).at(location))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_the_other_language_are_found_and_units_are_none() {
        assert_eq!(foreign("前车减速", Lang::Zh), None);
        assert_eq!(foreign("前车在 18 m 处以 30 km/h 行驶", Lang::Zh), None);
        assert_eq!(foreign("前车 brakes 减速", Lang::Zh), Some("brakes"));
        assert_eq!(foreign("The lead brakes.", Lang::Zh), Some("The lead brakes."));
        assert_eq!(foreign("The lead brakes.", Lang::En), None);
        assert_eq!(foreign("The lead 减速 now", Lang::En), Some("减速"));
    }
}
