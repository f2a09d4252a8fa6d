//! Input of the families on visibility, and objects that can hide a target.

use crate::ego::motion::EgoMotion;
use crate::road::network::Road;
use crate::road::path::DrivenPath;
use crate::target::placement::Target;
use crate::target::relations::Neighbors;
use whyroad_model::{Drive, TrackId};

/// Input of the family.
pub struct Scene<'a> {
    /// The drive.
    pub drive: &'a Drive,
    /// The ego.
    pub ego: &'a EgoMotion,
    /// Its path.
    pub path: &'a DrivenPath,
    /// The road, when there is a map.
    pub road: Option<&'a Road>,
    /// The targets in row order.
    pub targets: &'a [Target<'a>],
    /// Lead and follower.
    pub near: &'a Neighbors,
    /// Seconds by frame.
    pub times: &'a [f64],
}

/// An object that hides a target.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Occluder {
    /// Another track.
    Track(TrackId),
    /// A building of the map, by its id there.
    Facility(String),
}
