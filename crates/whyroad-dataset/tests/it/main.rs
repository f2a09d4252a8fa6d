//! Releases built from drives that are made by hand here, and faults that are put into them.

mod build;
mod faults;
mod fleet;
