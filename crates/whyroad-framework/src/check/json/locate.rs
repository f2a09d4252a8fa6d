//! From bytes of a document to line, column and snippet in its file.

use super::split::Origin;
use std::ops::Range;
use whyroad_model::Location;

/// Characters of context that a snippet keeps on each side; terminals show about a hundred.
const BEFORE: usize = 100;
const AFTER: usize = 200;

/// Position of a document in its file.
pub struct Locator<'t> {
    text: &'t str,
    origin: &'t Origin,
    /// Byte at which each line of the document starts; found out with the first question.
    lines: std::cell::OnceCell<Vec<usize>>,
}

impl<'t> Locator<'t> {
    /// Of a document that starts at `origin` in its file.
    pub fn new(text: &'t str, origin: &'t Origin) -> Self {
        Self { text, origin, lines: std::cell::OnceCell::new() }
    }

    /// The place of `span`, called `pointer` within the document.
    pub fn place(&self, span: Range<usize>, pointer: &str) -> Location {
        let starts = self.lines.get_or_init(|| {
            std::iter::once(0).chain(self.text.match_indices('\n').map(|(i, _)| i + 1)).collect()
        });
        let row = starts.partition_point(|&s| s <= span.start).saturating_sub(1);
        let from = starts[row];
        let before = &self.text[from..span.start];
        let line = self.text[from..].split('\n').next().unwrap_or_default().trim_end_matches('\r');
        let chars_before = before.chars().count();
        // Characters of the file's line that stand before the document.
        let lead = if row == 0 { self.origin.column - 1 } else { 0 };

        let dropped = chars_before.saturating_sub(BEFORE);
        let mut snippet: String = line.chars().skip(dropped).take(BEFORE.min(chars_before) + AFTER).collect();
        let mut snippet_start = lead + dropped;
        if dropped == 0 && lead > 0 && self.origin.indented {
            snippet = " ".repeat(lead) + &snippet;
            snippet_start = 0;
        }
        let underlined = self.text[span.clone()].split('\n').next().unwrap_or_default();
        let pointer = match self.origin.element {
            Some(i) => format!("/{i}{pointer}"),
            None => pointer.to_owned(),
        };
        Location {
            file: None,
            line: Some(self.origin.line + row),
            column: Some(lead + chars_before + 1),
            pointer: Some(pointer),
            snippet: Some(snippet),
            snippet_start,
            span: underlined.chars().count().max(1),
        }
    }
}
