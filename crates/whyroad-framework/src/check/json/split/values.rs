//! The [`super::Layout::Values`] half of the splitter: a byte machine that follows quotes and brackets.

use super::piece::{Document, MAX_DOCUMENT_BYTES, Origin, Piece, Problem};

/// After this many pieces in a row that are neither object nor array, the rest of the file is not read.
const MAX_STRAY: usize = 20;

#[derive(Debug)]
pub(super) struct Values {
    // Place of the next byte.
    line: usize,
    column: usize,
    blank_so_far: bool,
    /// Elements seen and whether a comma is due, when inside the file's array.
    array: Option<Array>,
    open: Option<Open>,
    carried: Vec<u8>,
    stray: usize,
}

#[derive(Clone, Copy, Debug, Default)]
struct Array {
    next: usize,
    after: After,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum After {
    #[default]
    Start,
    Element,
    Comma,
}

/// The document that is being read.
#[derive(Debug)]
struct Open {
    origin: Origin,
    brackets: Vec<u8>,
    in_string: bool,
    escaped: bool,
    /// The last byte that was not white space, outside strings.
    last: u8,
    bytes: usize,
}

impl Default for Values {
    fn default() -> Self {
        Self {
            line: 1,
            column: 1,
            blank_so_far: true,
            array: None,
            open: None,
            carried: Vec::new(),
            stray: 0,
        }
    }
}

/// The effect of a byte on the open document.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Step {
    /// It belongs to it.
    Inside,
    /// It is its last byte.
    Last,
    /// The document ended before this byte.
    Before,
    /// The document is broken: this byte starts the next one.
    Cut,
}

impl Values {
    /// Takes the next bytes; true when the rest of the file should not be read.
    pub fn feed(&mut self, chunk: &[u8], sink: &mut dyn FnMut(Piece<'_>)) -> bool {
        let mut start = 0;
        for (i, &b) in chunk.iter().enumerate() {
            if let Some(open) = &mut self.open {
                let step = open.step(b, self.array.is_some());
                match step {
                    Step::Inside => {}
                    Step::Last => self.emit(&chunk[start..=i], sink),
                    Step::Before | Step::Cut => {
                        self.emit(&chunk[start..i], sink);
                        if step == Step::Cut
                            && let Some(a) = &mut self.array
                        {
                            a.after = After::Comma;
                        }
                        self.between(b, i, &mut start, sink);
                    }
                }
            } else {
                self.between(b, i, &mut start, sink);
            }
            if self.stray > MAX_STRAY {
                sink(Piece::Problem(Problem::NotJson, self.here()));
                return true;
            }
            self.advance(b);
        }
        if let Some(open) = &mut self.open {
            let part = &chunk[start..];
            open.bytes += part.len();
            if open.bytes <= MAX_DOCUMENT_BYTES {
                self.carried.extend_from_slice(part);
            } else {
                self.carried = Vec::new();
            }
        }
        false
    }

    pub fn finish(&mut self, sink: &mut dyn FnMut(Piece<'_>)) {
        if self.open.is_some() {
            self.emit(&[], sink);
        }
        if self.array.is_some() {
            sink(Piece::Problem(Problem::ArrayOpen, self.here()));
        }
    }

    fn here(&self) -> Origin {
        Origin {
            line: self.line,
            column: self.column,
            element: self.array.map(|a| a.next),
            indented: self.blank_so_far,
        }
    }

    fn advance(&mut self, b: u8) {
        match b {
            b'\n' => {
                self.line += 1;
                self.column = 1;
                self.blank_so_far = true;
            }
            // Continuation bytes of UTF-8 are not separate characters.
            0x80..=0xBF => {}
            _ => {
                self.column += 1;
                self.blank_so_far &= b.is_ascii_whitespace();
            }
        }
    }

    /// A byte outside any document.
    fn between(&mut self, b: u8, i: usize, start: &mut usize, sink: &mut dyn FnMut(Piece<'_>)) {
        if b.is_ascii_whitespace() {
            return;
        }
        let here = self.here();
        match (&mut self.array, b) {
            (None, b'[') => {
                self.array = Some(Array::default());
                return;
            }
            (Some(a), b']') => {
                if a.after == After::Comma {
                    sink(Piece::Problem(Problem::CommaTooMany, Origin { element: None, ..here }));
                }
                self.array = None;
                return;
            }
            (Some(a), b',') => {
                if a.after == After::Element {
                    a.after = After::Comma;
                } else {
                    sink(Piece::Problem(Problem::CommaTooMany, Origin { element: None, ..here }));
                }
                return;
            }
            (Some(a), _) if a.after == After::Element => {
                sink(Piece::Problem(Problem::CommaMissing, Origin { element: None, ..here.clone() }));
            }
            _ => {}
        }
        *start = i;
        let mut open =
            Open { origin: here, brackets: Vec::new(), in_string: false, escaped: false, last: 0, bytes: 0 };
        let _ = open.step(b, self.array.is_some());
        self.open = Some(open);
    }

    /// The open document ends with `tail`.
    fn emit(&mut self, tail: &[u8], sink: &mut dyn FnMut(Piece<'_>)) {
        let Some(open) = self.open.take() else { return };
        if let Some(a) = &mut self.array {
            a.next += 1;
            a.after = After::Element;
        }
        if open.bytes + tail.len() > MAX_DOCUMENT_BYTES {
            sink(Piece::Problem(Problem::TooLarge, open.origin));
            return;
        }
        let mut carried = std::mem::take(&mut self.carried);
        let bytes = if carried.is_empty() {
            tail
        } else {
            carried.extend_from_slice(tail);
            &carried[..]
        };
        let mut bytes = bytes.trim_ascii_end();
        if !open.brackets.is_empty() {
            bytes = bytes.strip_suffix(b",").unwrap_or(bytes).trim_ascii_end();
        }
        self.stray = if matches!(bytes.first(), Some(b'{' | b'[')) { 0 } else { self.stray + 1 };
        sink(Piece::Document(Document { origin: open.origin, bytes }));
        carried.clear();
        self.carried = carried;
    }
}

impl Open {
    fn step(&mut self, b: u8, in_array: bool) -> Step {
        if self.in_string {
            match b {
                _ if self.escaped => self.escaped = false,
                b'\\' => self.escaped = true,
                // A JSON text never continues over a line's end: its closing quote is missing.
                b'"' | b'\n' => {
                    self.in_string = false;
                    self.last = if b == b'"' { b } else { b',' };
                    if self.brackets.is_empty() {
                        return Step::Last;
                    }
                }
                _ => {}
            }
            return Step::Inside;
        }
        let step = match b {
            b'"' => {
                self.in_string = true;
                Step::Inside
            }
            b'{' if self.brackets.last() == Some(&b'{') && matches!(self.last, b',' | b'}') => {
                return Step::Cut;
            }
            b'{' | b'[' => {
                self.brackets.push(b);
                Step::Inside
            }
            b'}' | b']' => self.close(b, in_array),
            b'\n' if self.brackets.is_empty() => return Step::Before,
            b',' if self.brackets.is_empty() && in_array => return Step::Before,
            _ => Step::Inside,
        };
        if !b.is_ascii_whitespace() {
            self.last = b;
        }
        step
    }

    fn close(&mut self, b: u8, in_array: bool) -> Step {
        let opener = if b == b'}' { b'{' } else { b'[' };
        if let Some(at) = self.brackets.iter().rposition(|&o| o == opener) {
            // Brackets left open inside belong to a broken document; ending it here saves the next one.
            self.brackets.truncate(at);
            return if at == 0 { Step::Last } else { Step::Inside };
        }
        if b == b']' && in_array { Step::Before } else { Step::Inside }
    }
}

/// True when quotes and brackets of `line` close.
pub(super) fn is_balanced(line: &[u8]) -> bool {
    let line = line.trim_ascii();
    let mut open = Open {
        origin: Origin::start(),
        brackets: Vec::new(),
        in_string: false,
        escaped: false,
        last: 0,
        bytes: 0,
    };
    line.iter().map(|&b| open.step(b, false)).position(|s| s != Step::Inside)
        == Some(line.len().saturating_sub(1))
}
