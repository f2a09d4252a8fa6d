//! What several adapters need to turn rows into scene tables: frames, maps, plausibility.

pub mod angles;
pub(crate) mod arms;
pub(crate) mod checks;
pub(crate) mod class_names;
pub(crate) mod coverage;
pub(crate) mod datum;
pub(crate) mod feature_map;
pub(crate) mod finish;
pub(crate) mod frames;
pub(crate) mod geodesy;
pub(crate) mod geometry;
pub(crate) mod junctions;
pub(crate) mod key_frames;
pub(crate) mod lane_lights;
pub(crate) mod layers;
pub(crate) mod licences;
pub(crate) mod neighbors;
pub(crate) mod plausibility;
pub(crate) mod projection;
pub(crate) mod resample;
pub(crate) mod rings;
pub(crate) mod se3;
