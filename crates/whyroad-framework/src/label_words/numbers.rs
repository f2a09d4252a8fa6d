//! Words for numbers (`numbers` of `schema/label_words.yaml`).

use super::{CharSet, Words};
use serde::Deserialize;

/// Counts and distances.
#[derive(Clone, Debug, Default)]
pub struct Numbers {
    /// More than one, in Chinese.
    chars: CharSet,
    /// The same in Latin letters, in lower case.
    words: Vec<String>,
    /// One, in Chinese.
    one: CharSet,
    /// Chinese number characters that indicate a long distance.
    long: CharSet,
}

impl Numbers {
    /// True when `text` has a number.
    pub fn any(&self, text: &str) -> bool {
        text.contains(|c: char| c.is_ascii_digit() || self.chars.contains(c))
            || text.split(' ').any(|t| self.words.iter().any(|w| t.eq_ignore_ascii_case(w)))
    }

    /// True when `text` begins with a long distance in Chinese: "两百米的路口".
    pub fn begins_long_distance(&self, text: &str) -> bool {
        let chinese = |c: char| self.chars.contains(c) || self.one.contains(c) || self.long.contains(c);
        let is_number = |c: char| c.is_ascii_digit() || chinese(c);
        let unit = text.trim_start().trim_start_matches(is_number);
        let number = &text.trim_start()[..text.trim_start().len() - unit.len()];
        let is_long = number.contains(|c| self.long.contains(c)) || number.len() >= 3 && number.is_ascii();
        let many = ["米", "多米", "来米"].iter().any(|u| unit.starts_with(u));
        !number.is_empty() && (is_long && many || unit.starts_with("公里"))
    }
}

/// The lists as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawNumbers {
    some: Words,
    one: Words,
    long: Words,
}

impl RawNumbers {
    pub(super) fn compile(&self) -> Numbers {
        let chars = |w: &Words| CharSet::of(w.zh.iter().map(String::as_str));
        Numbers {
            chars: chars(&self.some),
            words: self.some.en.clone(),
            one: chars(&self.one),
            long: chars(&self.long),
        }
    }
}
