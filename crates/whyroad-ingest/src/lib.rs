//! Recorded drives into scene tables: one adapter a format, and what they share. Reads files; knows nothing of
//! signals, rules or labels. A log's format ends here: what leaves this crate is a [`whyroad_model::Drive`].

pub mod av2;
mod geometry;
pub mod kinematics;
pub mod plausibility;
pub mod report;
mod run;
mod source;
pub mod sumo;

pub use report::{RowCount, SourceReport};
pub use run::{DEFAULT_START, Format, Options, Source, find_sources, ingest, read};

/// Codes of the diagnostics of all adapters; each has a page in `docs/diagnostics/`.
pub fn codes() -> Vec<&'static str> {
    let shared =
        ["ingest.path.missing", "ingest.path.unreadable", "ingest.nothing_found", "ingest.speed.impossible"];
    shared.iter().chain(av2::findings::CODES).chain(sumo::findings::CODES).copied().collect()
}
