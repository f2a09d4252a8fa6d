//! The messages of DATA_FORMAT.md, as typed values. Each `*Message` type is the document with its outer
//! key; the JSON Schemas in `schema/` are generated from these types.

pub mod clip;
pub mod coverage;
pub mod episode;
pub mod label;
pub mod mining;

pub use clip::*;
pub use coverage::*;
pub use episode::*;
pub use label::*;
pub use mining::*;
