//! Business rules (DATA_FORMAT.md 4.3): requirements of the class, and which decisions can be combined.

pub(super) mod class;
pub(super) mod combination;
pub(super) mod decision;
pub(super) mod records;
