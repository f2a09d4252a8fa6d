//! Fuzz targets for every parser of untrusted bytes, and a mutating harness that runs on stable Rust: seeds that the
//! parsers accept, changed a little, without coverage feedback. `.ci/fuzz` runs every target for a minute; `cargo test`
//! runs each a few times.
//!
//! A run fails when a parser panics, takes longer than [`harness::SLOW`] for one input, or never returns. Memory is
//! limited from outside (`ulimit -v` in `.ci/fuzz`): an allocation beyond it ends the process, and the input is in the
//! work folder.

pub mod harness;
mod mutate;
mod targets;

pub use targets::all;
