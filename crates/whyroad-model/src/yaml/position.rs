//! From a part of a scalar's text to its position in the file: quotes, escapes, indentation and folded lines are
//! accounted for by reading the scalar's own characters in step with the file's.

use super::tree::{Mark, Node, Scalar, Style, Value};
use std::ops::Range;

impl Node {
    /// Position of the bytes `part` of this scalar's text. `source` is the file that the node was parsed from. For
    /// anything but a scalar, and for a part outside the text, the position of the node.
    pub fn part(&self, part: Range<usize>, source: &str) -> Mark {
        let Value::Scalar(scalar) = &self.value else { return self.mark };
        if part.start >= part.end || scalar.text.get(part.clone()).is_none() {
            return self.mark;
        }
        let (mut first, mut last) = (None, None);
        align(self.mark, scalar, source, &mut |offset, line, column| {
            // White space is not part of what is underlined at the ends.
            if offset >= part.start {
                first.get_or_insert((line, column));
            }
            if offset < part.end && first.is_some_and(|(row, _)| row == line) {
                last = Some(column);
            }
            offset < part.end
        });
        match (first, last) {
            (Some((line, column)), Some(last)) => Mark { line, column, span: last - column + 1 },
            _ => self.mark,
        }
    }
}

/// Calls `visit` with each character of the scalar that is not white space: its byte offset in the scalar's text, its
/// line and column in the file. Stops when `visit` returns false, or where text and file differ.
fn align(mark: Mark, scalar: &Scalar, source: &str, visit: &mut dyn FnMut(usize, usize, usize) -> bool) {
    let mut cursor = Cursor::new(source, mark);
    let escapes = match (scalar.style, cursor.peek()) {
        (Style::Quoted, Some(quote @ ('"' | '\''))) => {
            cursor.bump();
            Some(quote)
        }
        (Style::Block, Some('|' | '>')) => {
            cursor.end_of_line();
            None
        }
        _ => None,
    };
    for (offset, c) in scalar.text.char_indices().filter(|(_, c)| !c.is_whitespace()) {
        let (line, column) = loop {
            let at = (cursor.line, cursor.column);
            match cursor.next(escapes) {
                None => return,
                Some(written) if written.is_whitespace() => {}
                Some(written) if written == c => break at,
                Some(_) => return,
            }
        };
        if !visit(offset, line, column) {
            return;
        }
    }
}

struct Cursor<'t> {
    rest: std::iter::Peekable<std::str::Chars<'t>>,
    line: usize,
    column: usize,
}

impl<'t> Cursor<'t> {
    fn new(source: &'t str, mark: Mark) -> Self {
        let start: usize = source.split_inclusive('\n').take(mark.line - 1).map(str::len).sum();
        let mut rest = source[start..].chars().peekable();
        for _ in 1..mark.column {
            rest.next();
        }
        Self { rest, line: mark.line, column: mark.column }
    }

    fn peek(&mut self) -> Option<char> {
        self.rest.peek().copied()
    }

    fn bump(&mut self) -> Option<char> {
        let c = self.rest.next()?;
        if c == '\n' {
            (self.line, self.column) = (self.line + 1, 1);
        } else {
            self.column += 1;
        }
        Some(c)
    }

    fn end_of_line(&mut self) {
        while self.peek().is_some_and(|c| c != '\n') {
            self.bump();
        }
    }

    /// The next character of the text: an escape of a quoted scalar is one.
    fn next(&mut self, quote: Option<char>) -> Option<char> {
        let c = self.bump()?;
        match (quote, c) {
            (Some('\''), '\'') => self.bump(),
            (Some('"'), '\\') => {
                let digits = match self.bump()? {
                    'x' => 2,
                    'u' => 4,
                    'U' => 8,
                    'n' | 't' | 'r' | '\n' | 'v' | 'f' | 'N' | 'L' | 'P' | '_' => return Some(' '),
                    other => return Some(other),
                };
                let mut code = 0;
                for _ in 0..digits {
                    code = code * 16 + self.bump()?.to_digit(16)?;
                }
                char::from_u32(code)
            }
            _ => Some(c),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::yaml::parse;

    /// Position of `word` within the value of `key`, and the length.
    fn of(text: &str, key: &str, word: &str) -> (usize, usize, usize) {
        let root = parse(text).unwrap();
        let node = root.get(key).unwrap();
        let start = node.text().unwrap().find(word).unwrap();
        let m = node.part(start..start + word.len(), text);
        (m.line, m.column, m.span)
    }

    #[test]
    fn parts_are_found_in_every_notation() {
        // Lines and columns counted by hand.
        assert_eq!(of("a: ttc < 3 s\n", "a", "3 s"), (1, 10, 3));
        assert_eq!(of("a: 'it''s x > 1'\n", "a", "x > 1"), (1, 11, 5));
        assert_eq!(of("a: \"q \\\"u\\u4e2d x\"\n", "a", "x"), (1, 17, 1));
        assert_eq!(of("a: >\n  ttc < 3 s\n  and gap > 1 m\n", "a", "gap"), (3, 7, 3));
        assert_eq!(of("a: |\n  ttc < 3 s\n    or x\n", "a", "x"), (3, 8, 1));
        assert_eq!(of("b: 1\na: ttc < 3 s\n  and gap > 1 m\n", "a", "gap > 1 m"), (3, 7, 9));
        // Over two lines: the part on the first.
        assert_eq!(of("a: ttc < 3 s\n  and gap > 1 m\n", "a", "3 s and gap"), (1, 10, 3));
        assert_eq!(of("a: 中文 x\n", "a", "x"), (1, 7, 1));
    }
}
