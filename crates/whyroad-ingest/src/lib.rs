//! Recorded drives into scene tables: one adapter a format, and what they share. Reads files; knows nothing of
//! signals, rules or labels. A log's format ends here: what leaves this crate is a [`whyroad_model::Drive`].

pub mod av2;
pub mod can;
mod columns;
pub mod comma2k19;
mod feature_map;
mod geodesy;
mod geometry;
mod junctions;
pub mod kinematics;
mod lane_lights;
pub mod mcap;
mod npy;
pub mod nuscenes;
mod pickle;
pub mod plausibility;
mod protobuf;
pub mod report;
mod resample;
mod run;
mod sampled;
pub mod scenarionet;
mod se3;
mod source;
pub mod sumo;
pub mod table;
pub mod waymo;

pub use report::{RowCount, SourceReport};
pub use run::{DEFAULT_START, Format, Options, Source, batches, find_sources, ingest, ingest_each, read};

/// Codes of the diagnostics of all adapters; each has a page in `docs/diagnostics/`.
pub fn codes() -> Vec<&'static str> {
    let shared = [
        "ingest.path.missing",
        "ingest.path.unreadable",
        "ingest.nothing_found",
        "ingest.speed.impossible",
        "ingest.rate.resampled",
    ];
    let of_adapters = [
        av2::findings::CODES,
        av2::motion::CODES,
        comma2k19::CODES,
        mcap::findings::CODES,
        nuscenes::findings::CODES,
        scenarionet::findings::CODES,
        sumo::findings::CODES,
        table::CODES,
        waymo::findings::CODES,
    ];
    shared.into_iter().chain(of_adapters.into_iter().flatten().copied()).collect()
}
