//! Causes (LABELING.md 6): each decision has one that could be observed.

pub(super) mod circular;
mod disowned;
pub(super) mod far_reason;
mod flipped;
mod grounds;
pub(super) mod links;
pub(super) mod nobody;
pub(super) mod ordinary;
pub(super) mod remote;
pub(crate) mod side;
pub(super) mod text;
pub(super) mod unused;
