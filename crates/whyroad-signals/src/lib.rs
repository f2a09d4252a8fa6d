//! Derives signal tables from scene tables: the quantities that the rules of the L3 classes use, by name and over time.
//!
//! Pure functions of one [`Drive`]; nothing here reads a file, depends on an input format or decides what a scenario
//! is. Values that the log did not measure are estimated first (`estimate`), only from the given drive. Names and
//! meanings are in `schema/signals.yaml`; one file per signal family, in folders by stage (`ego`, `road`, `target`,
//! `conflict`, `behavior`, `sight`, `refav`) in the order in which they depend on one another. Signals are derived over
//! the whole drive, before it is cut into clips. `object` derives signals of any object and of pairs, for rules that
//! use them.

pub mod catalog;
pub mod estimate;
pub mod geometry;
mod needs;
mod series;
mod table;
mod wanted;

// Stages in the order in which they depend on one another; a test forbids imports against this order.
mod ego;
mod road;
mod target;

mod conflict;

mod behavior;
mod refav;
mod sight;

mod object;

mod derive;
mod occluders;

pub use catalog::{Catalog, SignalDef, SignalKind, SignalScope, TargetRestriction};
pub use derive::{derive, derive_last_frame, derive_wanted, meta_actions};
pub use ego::meta_actions::MetaActions;
pub use estimate::estimate;
pub use object::{Objects, PairClasses, WithPairs, derive_objects};
pub use occluders::occluders;
pub use road::lane_ids::ego_lane_ids;
pub use sight::Occluder;
pub use wanted::Wanted;

/// Version of the signals: changes with the catalog and with the code that derives them.
pub const VERSION: &str = env!("WHYROAD_SIGNALS_VERSION");
