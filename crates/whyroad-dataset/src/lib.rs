//! Data sets: from labels and a lake to an immutable release that a trainer reads. Stages in order:
//! select, cut ([`sample`]), split, de-duplicate, balance, freeze; each writes what it kept and dropped, with
//! reasons. [`build`] runs them, [`Release`] reads the result, [`verify`] checks it. `docs/reference/release.md`
//! describes the spec and the files.
//!
//! It derives nothing itself: speeds, accelerations and classes come from [`whyroad_engine::states`]. It opens no
//! store of the labeling service: labels come as lines of its export.

pub mod baseline;
pub mod build;
pub mod carry;
pub mod diff;
pub mod doubtful;
pub mod export;
pub mod release;
pub mod sample;
pub mod score;
pub mod similar;
pub mod spec;
pub mod verify;

mod aside;
mod balance;
mod cut;
pub mod dedup;
mod descriptor;
mod error;
mod freeze;
mod item;
mod labels;
pub mod licence;
mod place;
mod pose;
mod records;
mod select;
mod split;

pub use balance::{BalanceReport, Shortfall};
pub use build::{Built, Inputs, Step, build};
pub use cut::{Blurring, Media};
pub use dedup::DedupReport;
pub use error::{CODES, DatasetError};
pub use freeze::manifest::Manifest;
pub use item::{BYTES_PER_SAMPLE, SplitName, Stage, reason_in_words};
pub use labels::{DRAFT, IMPORTED, LabelStream};
pub use release::Release;
pub use sample::Sample;
pub use spec::Spec;
pub use split::{Distance, KeptSplits, SplitReport};
