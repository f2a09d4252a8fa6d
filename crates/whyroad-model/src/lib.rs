//! What all of Whyroad shares: ids, time, units, scene tables, signal tables, messages, diagnostics.
//!
//! The build script (`build.rs`) generates [`SignalId`], the typed ids and category enums of [`catalog`] and [`Need`]
//! from `schema/signals.yaml` and `schema/needs.yaml`.
//!
//! Nothing here reads a file, knows a format or decides anything about driving. A type is here because at least two
//! crates share it.

pub mod catalog;
mod clip;
pub mod column;
mod component_category;
pub mod decision;
pub mod diagnostic;
pub mod display;
pub mod ids;
pub mod label_fields;
pub mod messages;
mod model_spent;
pub mod names;
mod need;
pub mod object;
pub mod pair;
pub mod random;
pub mod road_map;
pub mod scene;
pub mod serde_text;
pub mod signal;
pub mod suggest;
pub mod text;
pub mod time;
pub mod units;
pub mod vocabulary;
pub mod yaml;

pub use catalog::SignalId;
pub use clip::{ClipCut, clip_of_frames, division, end_time};
pub use column::{Column, Tri};
pub use component_category::ComponentCategory;
pub use diagnostic::{Diagnostic, Location, Severity};
pub use display::Displayed;
pub use ids::{ClipId, DriveId, ScenarioId, TrackId};
pub use model_spent::ModelSpent;
pub use need::Need;
pub use object::ObjectClass;
pub use road_map::RoadMap;
pub use scene::Drive;
pub use signal::SignalTable;
pub use text::{Bilingual, Lang, counted};
pub use time::{FrameRange, Nanos};

/// Version of the exchange format (DATA_FORMAT.md 1.3) that this build writes. It reads every 2.x: the minor step
/// from the given 2.0.0 only adds optional fields.
pub const FORMAT_VERSION: &str = "2.1.0";
