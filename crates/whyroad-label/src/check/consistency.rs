//! Consistency (DATA_FORMAT.md 4.3): times with each other, and the trace with the decisions.

mod attributes;
pub(super) mod duplicates;
mod ego_at_last;
mod given;
pub(super) mod last_action;
mod meaning;
pub(super) mod moment;
pub(super) mod objects;
pub(super) mod parts;
pub(super) mod plausible;
pub(super) mod records;
mod sequel;
pub(super) mod text;
pub(super) mod trace;
pub(super) mod trace_rules;
mod trace_stems;
mod undecided;
