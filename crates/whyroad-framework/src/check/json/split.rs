//! Cuts a stream of bytes into documents, without ever holding more than one of them: JSON Lines by line, other
//! JSON into its top-level values or, when that is an array, the array's elements. Reads nothing itself:
//! bytes are fed in, documents come out. Whether a document is valid JSON is not decided here; brackets and
//! quotes are followed only as far as needed to find where a document ends, and after a broken one the next.

mod piece;
mod values;

pub use piece::{Document, MAX_DOCUMENT_BYTES, Origin, Piece, Problem};

use values::Values;

/// How documents are arranged in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// One document per line (`.jsonl`, `.ndjson`).
    Lines,
    /// Values one after the other, or elements of one array, over any number of lines.
    Values,
}

impl Layout {
    /// The layout that the first bytes of a file show. A file's name is not evidence: people name JSON Lines `.json`
    /// and vice versa.
    pub fn guess(head: &[u8]) -> Layout {
        let head = head.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(head);
        let mut lines = head.split_inclusive(|&b| b == b'\n').filter(|l| !l.trim_ascii().is_empty());
        let Some(first) = lines.next() else { return Layout::Lines };
        let second = lines.next();
        if !first.trim_ascii().starts_with(b"{") {
            // A scalar or junk on its own line is best reported line by line.
            return if first.trim_ascii().starts_with(b"[") { Layout::Values } else { Layout::Lines };
        }
        let starts_flush = |l: &[u8]| l.starts_with(b"{");
        match second {
            Some(second) if starts_flush(first) && starts_flush(second) => Layout::Lines,
            _ if first.ends_with(b"\n") && values::is_balanced(first) => Layout::Lines,
            _ => Layout::Values,
        }
    }
}

/// Cuts the bytes of one file. Feed it chunk by chunk, then [`Splitter::finish`].
#[derive(Debug)]
pub struct Splitter {
    layout: Layout,
    started: bool,
    given_up: bool,
    line: usize,
    /// The part of the current document that came with earlier chunks.
    carried: Vec<u8>,
    too_large: bool,
    values: Values,
}

impl Splitter {
    /// A splitter for one file.
    pub fn new(layout: Layout) -> Self {
        Self {
            layout,
            started: false,
            given_up: false,
            line: 1,
            carried: Vec::new(),
            too_large: false,
            values: Values::default(),
        }
    }

    /// Takes the next bytes. The first chunk must hold the first three bytes of the file, if it has that many.
    pub fn feed(&mut self, mut chunk: &[u8], sink: &mut dyn FnMut(Piece<'_>)) {
        if !self.started {
            self.started = true;
            if let Some(rest) = chunk.strip_prefix(b"\xEF\xBB\xBF") {
                chunk = rest;
                sink(Piece::Problem(Problem::ByteOrderMark, Origin::start()));
            } else if chunk.starts_with(b"\xFF\xFE") || chunk.starts_with(b"\xFE\xFF") {
                self.given_up = true;
                sink(Piece::Problem(Problem::Utf16, Origin::start()));
            }
        }
        if self.given_up {
            return;
        }
        match self.layout {
            Layout::Lines => self.feed_lines(chunk, sink),
            Layout::Values => self.given_up = self.values.feed(chunk, sink),
        }
    }

    /// The file has ended.
    pub fn finish(mut self, sink: &mut dyn FnMut(Piece<'_>)) {
        if self.given_up {
            return;
        }
        match self.layout {
            Layout::Lines => {
                let last = std::mem::take(&mut self.carried);
                self.line_done(&last, sink);
            }
            Layout::Values => self.values.finish(sink),
        }
    }

    fn feed_lines(&mut self, chunk: &[u8], sink: &mut dyn FnMut(Piece<'_>)) {
        let mut rest = chunk;
        while let Some(end) = memchr::memchr(b'\n', rest) {
            let (line, after) = (&rest[..end], &rest[end + 1..]);
            if self.carried.is_empty() {
                self.line_done(line, sink);
            } else {
                let mut whole = std::mem::take(&mut self.carried);
                whole.extend_from_slice(line);
                self.line_done(&whole, sink);
                whole.clear();
                self.carried = whole;
            }
            self.line += 1;
            rest = after;
        }
        if self.carried.len() + rest.len() <= MAX_DOCUMENT_BYTES && !self.too_large {
            self.carried.extend_from_slice(rest);
        } else {
            self.too_large = true;
            self.carried.clear();
        }
    }

    fn line_done(&mut self, line: &[u8], sink: &mut dyn FnMut(Piece<'_>)) {
        let origin = |column| Origin { line: self.line, column, element: None, indented: true };
        if std::mem::take(&mut self.too_large) {
            sink(Piece::Problem(Problem::TooLarge, origin(1)));
            return;
        }
        let bytes = line.trim_ascii_start();
        let column = line.len() - bytes.len() + 1;
        let bytes = bytes.trim_ascii_end();
        if !bytes.is_empty() {
            sink(Piece::Document(Document { origin: origin(column), bytes }));
        }
    }
}

#[cfg(test)]
mod tests;
