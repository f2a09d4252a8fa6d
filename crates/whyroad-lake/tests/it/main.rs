//! One binary for all integration tests of the lake.
#![allow(clippy::unwrap_used)] // in a test a panic is the report

#[path = "../../../whyroad-model/testing/folders.rs"]
mod folders;

mod facts;
mod media;
mod packs;
mod round_trip;
mod signals;
