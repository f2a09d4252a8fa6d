//! Names as people see them: two that look the same have the same [`appearance`].

use unicode_normalization::UnicodeNormalization;

/// A text without what does not tell names apart: letter case, width and other compatible forms (Unicode NFKC), kind
/// and number of spaces, and characters that are not visible. Letters of different scripts that look alike stay
/// different.
pub fn appearance(text: &str) -> String {
    let folded: String = text.nfkc().collect::<String>().to_uppercase().to_lowercase().nfkc().collect();
    let visible: String = folded.chars().filter(|c| c.is_whitespace() || !is_invisible(*c)).collect();
    visible.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Control characters, and those that are ignored when text is shown (DerivedCoreProperties.txt,
/// Default_Ignorable_Code_Point), as far as NFKC leaves them; and the braille blank.
fn is_invisible(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{ad}' | '\u{34f}' | '\u{61c}' | '\u{115f}'..='\u{1160}' | '\u{17b4}'..='\u{17b5}'
            | '\u{180b}'..='\u{180f}' | '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}' | '\u{2800}' | '\u{3164}' | '\u{fe00}'..='\u{fe0f}' | '\u{feff}' | '\u{ffa0}'
            | '\u{fff0}'..='\u{fff8}' | '\u{1bca0}'..='\u{1bca3}' | '\u{1d173}'..='\u{1d17a}'
            | '\u{e0000}'..='\u{e0fff}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_look_the_same_are_the_same() {
        for (one, other) in [
            ("Ann Li", "ann li"),
            // Full-width letters and an ideographic space.
            ("Ann Li", "\u{ff21}\u{ff4e}\u{ff4e}\u{3000}\u{ff2c}\u{ff49}"),
            // No-break space, thin space, two spaces, spaces around.
            ("Ann Li", "Ann\u{a0}Li"),
            ("Ann Li", " Ann\u{2009} Li\t"),
            // Zero-width space and joiner, soft hyphen, right-to-left override, variation selector, tag.
            ("Ann Li", "An\u{200b}n \u{200d}L\u{ad}i"),
            ("Ann Li", "\u{202e}Ann Li\u{fe0f}\u{e0041}"),
            // Composed and decomposed.
            ("Zo\u{eb}", "zoe\u{308}"),
            ("Stra\u{df}e", "STRASSE"),
            // Half-width katakana.
            ("\u{30ab}\u{30ca}", "\u{ff76}\u{ff85}"),
        ] {
            assert_eq!(appearance(one), appearance(other), "{one} {other}");
        }
        for (one, other) in [("Ann Li", "AnnLi"), ("Ann", "Anna"), ("王伟", "王玮"), ("Ann", "Ann 2")] {
            assert_ne!(appearance(one), appearance(other));
        }
        for nothing in ["", " ", "\u{3164}", "\u{200b}\u{2800}", "\u{3000}"] {
            assert_eq!(appearance(nothing), "", "{nothing:?}");
        }
    }
}
