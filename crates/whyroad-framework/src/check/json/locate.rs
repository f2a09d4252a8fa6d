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
    /// Computed on first use.
    index: std::cell::OnceCell<TextIndex>,
}

/// Where lines start and how many characters there are up to here: a document of one line with many findings would
/// otherwise be counted from its start for each of them.
struct TextIndex {
    /// Byte at which each line of the document starts.
    lines: Vec<usize>,
    /// Characters before each block of [`BLOCK`] bytes.
    chars: Vec<usize>,
}

/// Bytes of a block.
const BLOCK: usize = 1024;

/// Bytes that start a character.
fn count_chars(bytes: &[u8]) -> usize {
    bytes.iter().filter(|b| (**b & 0xC0) != 0x80).count()
}

impl TextIndex {
    fn of(text: &str) -> Self {
        let lines = std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1)).collect();
        let mut sum = 0;
        let mut chars = Vec::with_capacity(text.len() / BLOCK + 1);
        for block in text.as_bytes().chunks(BLOCK) {
            chars.push(sum);
            sum += count_chars(block);
        }
        Self { lines, chars }
    }

    /// Characters before byte `at`.
    fn chars_before(&self, text: &str, at: usize) -> usize {
        let block = (at / BLOCK).min(self.chars.len().saturating_sub(1));
        self.chars.get(block).copied().unwrap_or(0) + count_chars(&text.as_bytes()[block * BLOCK..at])
    }
}

impl<'t> Locator<'t> {
    /// Of a document that starts at `origin` in its file.
    pub fn new(text: &'t str, origin: &'t Origin) -> Self {
        Self { text, origin, index: std::cell::OnceCell::new() }
    }

    /// The place of `span`, called `pointer` within the document.
    pub fn place(&self, span: Range<usize>, pointer: &str) -> Location {
        let index = self.index.get_or_init(|| TextIndex::of(self.text));
        let starts = &index.lines;
        let row = starts.partition_point(|&s| s <= span.start).saturating_sub(1);
        let from = starts[row];
        let to = starts.get(row + 1).map_or(self.text.len(), |next| next - 1);
        let chars_before = index.chars_before(self.text, span.start) - index.chars_before(self.text, from);
        // Characters of the file's line before the document.
        let lead = if row == 0 { self.origin.column - 1 } else { 0 };

        let dropped = chars_before.saturating_sub(BEFORE);
        // Back from the span by the characters that are shown before it.
        let shown = chars_before.min(BEFORE);
        let head = self.text[from..span.start]
            .char_indices()
            .rev()
            .take(shown)
            .last()
            .map_or(span.start - from, |(i, _)| i);
        let line = self.text[from + head..to].trim_end_matches('\r');
        let mut snippet: String = line.chars().take(shown + AFTER).collect();
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
