//! Form (DATA_FORMAT.md 4.3, basic): two readers of a label that produce the same view of it, and the format version.

pub(super) mod kept;
pub(super) mod lean;
pub(super) mod placeholder;
pub(super) mod tolerant;
pub(super) mod version;
