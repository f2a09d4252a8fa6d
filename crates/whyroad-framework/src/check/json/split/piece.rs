//! The results of cutting a stream: documents, their positions, and errors between them.

/// The largest document that is taken into memory. A label has about 1.3 kB.
pub const MAX_DOCUMENT_BYTES: usize = 64 << 20;

/// Position of a document in its file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Line of its first character, from 1.
    pub line: usize,
    /// Column of its first character, in characters, from 1.
    pub column: usize,
    /// Its place in the file's array, where there is one.
    pub element: Option<usize>,
    /// Only white space precedes it in its line.
    pub indented: bool,
}

impl Origin {
    /// The start of a file.
    pub fn start() -> Self {
        Self { line: 1, column: 1, element: None, indented: true }
    }
}

/// A document cut out of a file. Its bytes may be broken in any way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Document<'b> {
    /// Its position.
    pub origin: Origin,
    /// Its bytes, without the white space around it.
    pub bytes: &'b [u8],
}

/// An error between documents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Problem {
    /// The file starts with a byte order mark; it is skipped.
    ByteOrderMark,
    /// The file is UTF-16; nothing in it is read.
    Utf16,
    /// Two elements of the array without a comma between them.
    CommaMissing,
    /// A comma in the array with no element before or after it.
    CommaTooMany,
    /// The file ends inside its array.
    ArrayOpen,
    /// The document is larger than [`MAX_DOCUMENT_BYTES`]; it is skipped.
    TooLarge,
    /// Too much text that is not JSON: the rest of the file is not read.
    NotJson,
}

/// Output of a [`super::Splitter`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Piece<'b> {
    /// A document.
    Document(Document<'b>),
    /// An error between documents, with its position.
    Problem(Problem, Origin),
}
