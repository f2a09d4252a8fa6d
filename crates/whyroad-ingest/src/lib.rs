//! Recorded drives into scene tables: `formats/` has one adapter per format, `encodings/` reads file formats,
//! `assemble/` is what adapters share, `maps/` reads map files beside any log. Reads files; knows nothing of signals,
//! rules or labels. A log's format ends here: what leaves this crate is a [`whyroad_model::Drive`].

mod adapter;
mod assemble;
mod encodings;
mod file_reader;
pub mod formats;
mod leftover;
mod mapping_file;
mod maps;
mod options;
mod origin;
mod phrases;
#[doc(hidden)]
pub mod readers;
pub mod report;
pub mod rows;
mod run;
mod source;

pub use adapter::{Adapter, AdapterRef, DriveSink, FilesInMemory, FormatAbout, Located, SkipReason, Source};
pub use assemble::angles;
pub use assemble::datum::Datum;
pub use encodings::can;
pub use formats::{
    av2, av2_motion, comma2k19, mcap, nuscenes, openlabel, pai, rosbag, scenarionet, sumo, table, waymo,
};
pub use maps::{
    MAP, MAP_COMPLETE, MAP_DATUM, MAP_OFFSET, MAP_ORIGIN, MAP_PROJECTION, OPTIONS as MAP_OPTIONS,
};
pub use options::{DEFAULT_START, LICENCE, OptionSpec, OptionType, OptionValue, Options, START};
pub use report::{RowCount, SourceReport};
pub use run::{batches, find_sources, find_sources_with, ingest, ingest_each, read, read_files};

/// Codes of the diagnostics of all adapters; each has a page in `docs/diagnostics/`.
pub fn codes() -> Vec<&'static str> {
    let of_adapters = formats::ALL.iter().flat_map(|a| a.0.about().codes.iter().copied());
    run::CODES
        .iter()
        .chain(leftover::CODES)
        .chain(origin::CODES)
        .chain(source::CODES)
        .chain(maps::CODES)
        .chain(assemble::checks::CODES)
        .copied()
        .chain(of_adapters)
        .collect()
}

#[cfg(test)]
#[path = "../../whyroad-model/testing/require.rs"]
mod require;
