//! The fast evaluator: all rules of a set on one drive, as one program over packed columns.
//!
//! ```text
//! rules --plan--> one program    signals --signals--> columns
//!                      \             /
//!                       evaluation: truth of each node, 64 rows per word, once for all objects of the drive
//!                           |  runs of true
//!                       search: episodes; margins only for the rows of an episode (margin)
//! ```
//!
//! It must give what the reference (`crate::interpret`, `crate::episode`) gives: same truths on every row, same
//! episodes with the same scores. Property tests keep the two equal. No I/O and no clock: the caller supplies the
//! columns.

pub mod bits;
mod compare;
pub mod evaluation;
pub mod layout;
mod margin;
mod noise;
pub mod numbers;
mod pairs;
pub mod plan;
pub mod search;
pub mod signals;
mod temporal;
mod threshold;
pub mod truth;
mod windows;

pub use evaluation::Evaluation;
pub use plan::Plan;
pub(crate) use search::mine_planned;
pub use search::{Search, find_all, mine_drive};
pub use signals::{Columns, SignalColumn, Signals};

#[cfg(test)]
mod tests;
