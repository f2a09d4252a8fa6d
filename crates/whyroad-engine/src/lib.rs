//! One drive in, record batches out: the same calls for the binary, the service, Python, Ray and Spark.
//!
//! What a step computes is in the crate of that step (ingest, signals, mining); this crate reads the inputs of the step
//! from the lake, runs it on all cores, keeps reusable results, and returns results in the order of drive ids.

pub mod again;
pub mod drives;
pub mod inspect;
pub mod label_drives;
pub mod media;
pub mod memory;
pub mod mine;
pub mod objects;
pub mod output;
pub mod parts;
pub mod perturb;
pub mod recordings;
mod states;

pub use states::{ObjectStates, States, estimated, states};
pub use whyroad_signals::{MetaActions, VERSION as SIGNALS_VERSION, meta_actions};

#[cfg(test)]
use whyroad_mining::{language, rule};
