//! Objects of a pickle, in one arena, and what can be wrong with it.

use super::array::{Array, Dtype};
use super::names;
use super::reference::{Bytes, Ref};

/// Why a pickle was not read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum PickleError {
    /// It imports something that is not plain data.
    #[error("it asks for '{0}', which is not plain data")]
    Forbidden(String),
    /// The file ends too early.
    #[error("it ends too early, at byte {0}")]
    Truncated(usize),
    /// Not a pickle, or one that no known writer produces.
    #[error("{what} at byte {at}")]
    Malformed { what: String, at: usize },
    /// More objects than any recording has.
    #[error("it makes more than {0} objects")]
    TooLarge(usize),
}

/// One object.
#[derive(Clone, Debug)]
pub(super) enum Node {
    None,
    Bool(bool),
    Int(i64),
    Float(f64),
    /// UTF-8 where the pickle is sound.
    Text(Bytes),
    Bytes(Bytes),
    /// Lists, tuples and sets.
    List(Vec<Ref>),
    Dict(Vec<(Ref, Ref)>),
    Array(Box<Array>),
    Dtype(Dtype),
    Name(names::Name),
}

/// A pickle that was read.
pub(crate) struct Pickle<'a> {
    pub(super) file: &'a [u8],
    pub(super) decoded: Vec<u8>,
    pub(super) nodes: Vec<Node>,
    pub(super) root: Ref,
}

impl<'a> Pickle<'a> {
    pub(super) fn bytes(&self, b: &Bytes) -> &[u8] {
        let (all, range) = match b {
            Bytes::File(r) => (self.file, r),
            Bytes::Decoded(r) => (self.decoded.as_slice(), r),
        };
        all.get(range.clone()).unwrap_or_default()
    }
}
