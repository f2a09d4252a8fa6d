//! The messages of DATA_FORMAT.md, as typed values. Each `*Message` type is the document with its outer
//! key; the JSON Schemas in `schema/` are generated from these types.

pub mod clip;
pub mod coverage;
pub mod ego_response;
pub mod episode;
pub mod episode_page;
pub mod label;
pub mod mining;
pub mod query_clause;
pub mod verdict;

pub use clip::*;
pub use coverage::*;
pub use ego_response::*;
pub use episode::*;
pub use episode_page::*;
pub use label::*;
pub use mining::*;
pub use query_clause::*;
pub use verdict::*;
