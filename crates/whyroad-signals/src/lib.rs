//! Scene tables to signal tables: what each leaf's rule asks about, as named quantities over time.
//!
//! Pure functions of one [`Drive`]; nothing here reads a file, knows an input format or decides what a scenario is.
//! What the log did not measure is estimated first (`estimate`), from the drive that is given and nothing else.
//! Names and meanings are in `schema/signals.yaml`; one file per signal family, in folders by stage (`ego`, `road`,
//! `target`, `conflict`, `behavior`, `sight`, `refav`) in the order in which they build on one another. Signals are
//! derived over the whole drive, before it is cut into clips. `object` derives signals of any object and of pairs, for
//! the rules that ask for them.

pub mod catalog;
pub mod estimate;
pub mod geometry;
mod needs;
mod series;
mod table;
mod wanted;

// Stages in the order in which they build on one another; a test forbids imports against this order.
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
