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
mod bus;

mod road;
mod lanes;
mod corridor;
mod ego_lane;
mod path;
mod junction;
mod curvature;
mod lights;

mod placement;
mod rows;
mod target_motion;
mod line_crossing;
mod gaps;
mod relations;
mod ttc;
mod pet;
mod crosswalk;
mod lane_change;
mod derive;
mod lane_ids;

pub use catalogue::{Catalogue, Scope, SignalDef, SignalKind, TargetRestriction};
pub use derive::derive;
pub use lane_ids::ego_lane_ids;
