//! References of a pickle's objects: to each other, and to bytes.

use std::ops::Range;

/// Number of an object in the arena.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Ref(pub(super) u32);

/// Bytes in the file, or in what was decoded from it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Bytes {
    File(Range<usize>),
    Decoded(Range<usize>),
}
