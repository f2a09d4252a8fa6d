//! Scene tables to signal tables: what each leaf's rule asks about, as named quantities over time.
//!
//! Pure functions of one [`Drive`]; nothing here reads a file, knows an input format or decides what a
//! scenario is. Names and meanings are in `schema/signals.yaml`; one signal family a module, in the order in
//! which they build on one another. Signals are derived over the whole drive, before it is cut into clips.

pub mod catalogue;
pub mod geometry;
mod series;
mod table;

mod ego_motion;
mod meta_actions;

pub use catalogue::{Catalogue, Scope, SignalDef, SignalKind, TargetRestriction};

use ego_motion::EgoMotion;
use table::TableBuilder;
use whyroad_model::{Drive, SignalTable};

/// All signals that `drive` supports; the others are in `unavailable` with what the log lacks.
pub fn derive(drive: &Drive) -> SignalTable {
    let missing = table::missing(drive);
    let mut table = TableBuilder::new(Catalogue::bundled(), drive);
    let start = drive.times.first().copied().unwrap_or_default();
    let times: Vec<f64> = drive.times.iter().map(|t| t.seconds_since(start)).collect();
    if let Some(ego) = drive.ego.as_ref().filter(|_| !missing.contains("ego pose")) {
        let ego = EgoMotion::new(ego, &times);
        ego_motion::write(&ego, &times, &mut table);
        meta_actions::write(&ego, &times, &mut table);
    }
    table.finish(&missing)
}
