//! Everything on disk between two commands: the lake (scene tables, one folder per drive, one Parquet file per table,
//! plain enough for DuckDB or pandas; `docs/reference/lake.md` lists tables, columns and units), stored signals, mined
//! folders. This crate knows how these are *stored*; it knows no input format and derives nothing.
//!
//! Guarantees for every drive in a lake: it appears whole or not at all (a temporary folder that is then renamed; or
//! many drives in one pack, which the catalog names); rows are ordered by clip, then target, then frame, one row group
//! holds the whole drive, and both are recorded in the file and checked on read; unknown is null on disk and NaN or
//! `None` in memory.

mod chunks;
mod clips;
mod columns;
mod delete;
mod error;
mod facts;
mod file;
mod fingerprints;
mod lake;
mod leftovers;
mod listing;
mod manifest;
mod media;
pub mod mined;
mod outline;
mod packs;
#[doc(hidden)]
pub mod readers;
pub mod sheet;
pub mod signals;
mod size;
mod stamp;
pub mod storage;
mod tables;
mod validity;

pub use clips::{clip_metadata, cut_clip};
pub use error::{CODES, LakeError};
pub use facts::DriveFacts;
pub use file::{check_columns, next_batch};
pub use fingerprints::{Fingerprint, Fingerprints};
pub use lake::{Lake, WriteOutcome};
pub use mined::MinedFolder;
pub use outline::{Outline, StatedContext};
pub use packs::{Compaction, CompactionOptions, DriveEntry};
pub use signals::SignalFile;
pub use size::DriveSize;
pub use stamp::Stamp;

/// Version of the lake's layout. Raised when a reader of the old one would misread the new one. Version 1 had speeds
/// and accelerations in it that were derived, which cannot be distinguished from measured ones: such a drive is
/// ingested again.
pub const LAKE_VERSION: u32 = 2;

/// What `whyroad-lake.json` states once the lake has packs: a build that knows only folders would miss the drives in
/// them. Tables have [`LAKE_VERSION`] in packs, too.
pub(crate) const PACKED_VERSION: u32 = 3;

/// Layouts that this build reads.
pub(crate) const LAYOUTS: [u32; 2] = [LAKE_VERSION, PACKED_VERSION];
