//! Texts that people write in addition to a label: reasons and comments.

use crate::problem::{Answer, Problem};

/// Maximum length of a comment or reason, characters.
pub(super) const TEXT: usize = 4000;

pub(super) fn is_long(text: &str) -> bool {
    text.chars().count() > TEXT
}

/// A reason in its stored form; `None` if there is only white space.
pub fn reason(given: Option<&str>) -> Answer<Option<&str>> {
    let reason = given.map(str::trim).filter(|r| !r.is_empty());
    if reason.is_some_and(is_long) {
        return Err(Problem::request(
            format!("原因至多 {TEXT} 个字符"),
            format!("a reason may have at most {TEXT} characters"),
        ));
    }
    Ok(reason)
}
