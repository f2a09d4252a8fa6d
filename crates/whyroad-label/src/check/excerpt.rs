//! Quotations of texts in findings: a label can be as long as its author likes.

/// The beginning of a quoted text.
pub(in crate::check) fn excerpt(text: &str) -> String {
    const LONGEST: usize = 60;
    let text = text.trim().trim_start_matches(['，', ',', ' ']);
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}
