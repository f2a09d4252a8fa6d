//! Integration tests of the framework files, their schemas, pages and differences, in one binary.
#![allow(clippy::unwrap_used)]

mod bundled;
mod diff_specs;
mod loader;
mod outside_text;
mod pages;
mod schemas;
