//! A JSON value and the bytes that it takes in its document.

use std::borrow::Cow;
use std::ops::Range;

/// A value and the bytes that it takes in its document.
#[derive(Clone, Debug, PartialEq)]
pub struct Node<'t> {
    /// The value.
    pub kind: JsonKind<'t>,
    /// Its bytes, brackets and quotes included.
    pub span: Range<usize>,
}

/// What a value is. Numbers stay text, so that `155` and `155.0` remain different.
#[derive(Clone, Debug, PartialEq)]
pub enum JsonKind<'t> {
    /// `null`.
    Null,
    /// `true` or `false`.
    Flag(bool),
    /// A number, as written.
    Number(&'t str),
    /// A text, escapes resolved; borrowed where it has none.
    Text(Cow<'t, str>),
    /// An array.
    List(Vec<Node<'t>>),
    /// An object: every occurrence of a key, in order.
    Map(Vec<Entry<'t>>),
}

/// A key with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry<'t> {
    /// The key, escapes resolved.
    pub key: Cow<'t, str>,
    /// Its bytes, quotes included.
    pub key_span: Range<usize>,
    /// The value.
    pub node: Node<'t>,
}

impl<'t> Node<'t> {
    /// The entries of an object, every writing of a key included.
    pub fn entries(&self) -> Option<&[Entry<'t>]> {
        match &self.kind {
            JsonKind::Map(entries) => Some(entries),
            _ => None,
        }
    }

    /// The value at a JSON pointer (RFC 6901); of a key written twice the first.
    pub fn pointer(&self, pointer: &str) -> Option<&Node<'t>> {
        let mut node = self;
        for step in pointer.split('/').skip(1) {
            let step = step.replace("~1", "/").replace("~0", "~");
            node = match &node.kind {
                JsonKind::Map(entries) => &entries.iter().find(|e| e.key == step)?.node,
                JsonKind::List(items) => items.get(step.parse::<usize>().ok()?)?,
                _ => return None,
            };
        }
        Some(node)
    }

    /// True for JSON's `null`.
    pub fn is_null(&self) -> bool {
        matches!(self.kind, JsonKind::Null)
    }

    /// The span to underline: a scalar whole, of an object or list only its bracket.
    pub fn mark(&self) -> Range<usize> {
        match self.kind {
            JsonKind::List(_) | JsonKind::Map(_) => self.span.start..self.span.start + 1,
            _ => self.span.clone(),
        }
    }
}
