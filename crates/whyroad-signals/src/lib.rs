//! Scene tables to signal tables: what each leaf's rule asks about, as named quantities over time.
//!
//! Pure functions of one [`Drive`]; nothing here reads a file, knows an input format or decides what a
//! scenario is. Names and meanings are in `schema/signals.yaml`; one signal family a module, in the order in
//! which they build on one another. Signals are derived over the whole drive, before it is cut into clips.

pub mod catalogue;
pub mod geometry;
mod needs;
mod series;
mod table;

mod bus;
mod ego_motion;
mod meta_actions;

mod corridor;
mod curvature;
mod ego_lane;
mod junction;
mod lanes;
mod lights;
mod path;
mod road;
mod way;

mod beside_path;
mod context;
mod crossroads;
mod facilities;
mod free_width;
mod junction_arms;
mod lane_rules;
mod merging;
mod on_road;
mod open_area;
mod road_profile;
mod roadside;
mod route;
mod terrain;

mod crosswalk;
mod derive;
mod gaps;
mod lane_change;
mod lane_change_intention;
mod lane_ids;
mod line_crossing;
mod occluders;
mod pet;
mod placement;
mod relations;
mod rows;
mod sight;
mod target_motion;
mod ttc;
mod ttc_lane;

mod conflict_point;
mod criticality;
mod ego_offset;
mod interaction;
mod lane_change_phase;
mod lead;
mod overtaking;
mod passing;
mod refav;
mod responds;
mod stops;
mod swerve;
mod target_behaviour;
mod target_lanes;
mod target_ramp;
mod target_side;
mod target_turns;
mod time_to_line;
mod traffic;
mod ttc_accel;

pub use catalogue::{Catalogue, SignalDef, SignalKind, SignalScope, TargetRestriction};
pub use derive::{MetaActions, derive, meta_actions};
pub use lane_ids::ego_lane_ids;
pub use occluders::{Occluder, occluders};

/// Version of the signals: changes with the catalogue and with the code that derives them.
pub const VERSION: &str = env!("WHYROAD_SIGNALS_VERSION");
