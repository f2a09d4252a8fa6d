//! Stage 6: the files of a release. Each is a function of the build alone: no clock, no hash order, no thread order.

pub(crate) mod card;
pub(crate) mod checksums;
pub(crate) mod croissant;
pub mod manifest;
pub(crate) mod shards;
pub(crate) mod tables;

/// Samples.
pub const DATA: &str = "data";
/// Tables of the stages.
pub const STAGES: &str = "stages";
/// Mining queries for the shortfalls.
pub const QUERIES: &str = "queries";
/// Charts of the card.
pub const CHARTS: &str = "charts";
/// The manifest.
pub const MANIFEST: &str = "manifest.json";
/// The spec as it was given.
pub const SPEC: &str = "spec.yaml";
/// The card.
pub const CARD: &str = "README.md";
/// Metadata for machines (Croissant 1.1).
pub const CROISSANT: &str = "croissant.json";
/// SHA-256 of every other file, as `sha256sum -c` reads it.
pub const CHECKSUMS: &str = "checksums.sha256";
