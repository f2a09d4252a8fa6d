//! JSON with spans, for explaining: a tree in which every key and value knows its bytes, duplicate keys kept,
//! and syntax errors with explanations. The fast path of labels does not use it; serde_json decides there.

mod error;
mod locate;
mod node;
mod parse;
mod problem;
mod split;

pub use error::SyntaxError;
pub use locate::Locator;
pub use node::{Entry, JsonKind, Node};
pub use parse::parse;
pub use problem::problem;
pub use split::{Document, Layout, MAX_DOCUMENT_BYTES, Origin, Piece, Problem, Splitter};
