//! Releases built from drives that are made by hand here, and faults that are put into them.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod build;
mod carry;
mod faults;
mod fleet;
