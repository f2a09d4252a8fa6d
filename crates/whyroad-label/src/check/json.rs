//! JSON with places, for explaining: a tree in which every key and value knows its bytes, duplicate keys kept,
//! and syntax errors said in words. The fast path never comes here; serde_json decides there.

mod error;
mod locate;
mod parse;
mod split;

pub(crate) use error::SyntaxError;
pub(crate) use locate::Locator;
pub(crate) use parse::parse;
pub use split::{Document, Layout, MAX_DOCUMENT_BYTES, Origin, Piece, Problem, Splitter};

use std::borrow::Cow;
use std::ops::Range;

/// A value and the bytes that it takes in its document.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Node<'t> {
    pub kind: Kind<'t>,
    pub span: Range<usize>,
}

/// What a value is. Numbers stay text, so that `155` and `155.0` remain different.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Kind<'t> {
    Null,
    Flag(bool),
    Number(&'t str),
    Text(Cow<'t, str>),
    List(Vec<Node<'t>>),
    Map(Vec<Entry<'t>>),
}

/// A key with its value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Entry<'t> {
    pub key: Cow<'t, str>,
    pub key_span: Range<usize>,
    pub node: Node<'t>,
}

impl<'t> Node<'t> {
    /// The entries of an object, every writing of a key included.
    pub fn entries(&self) -> Option<&[Entry<'t>]> {
        match &self.kind {
            Kind::Map(entries) => Some(entries),
            _ => None,
        }
    }

    /// True for JSON's `null`.
    pub fn is_null(&self) -> bool {
        matches!(self.kind, Kind::Null)
    }

    /// The span to underline: a scalar whole, of an object or list only its bracket.
    pub fn mark(&self) -> Range<usize> {
        match self.kind {
            Kind::List(_) | Kind::Map(_) => self.span.start..self.span.start + 1,
            _ => self.span.clone(),
        }
    }
}
