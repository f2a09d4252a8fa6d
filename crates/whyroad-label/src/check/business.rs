//! Business rules (DATA_FORMAT.md 4.3): what the class prescribes, and which decisions go together.

pub(super) mod class;
pub(super) mod combination;
pub(super) mod decision;
pub(super) mod records;
