//! Output of a mining run: the messages of DATA_FORMAT.md 3 and 5, `episodes.parquet`, coverage.
//! `docs/reference/rules.md` lists the files.

pub mod coverage;
pub mod folder;
pub mod query;
pub mod record;
pub mod removal;
pub mod result;

pub use coverage::Searched;
pub use folder::{EpisodeExample, FolderWriter, KnownDrive, SameDrive, Summary, write_folder};
pub use record::MinedEpisode;
pub use result::{BestMatch, KeyframeSeconds, Question};
