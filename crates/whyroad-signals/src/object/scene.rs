//! Inputs of the signals of objects, and the requested signals.

use super::body::Body;
use super::lanes::BodyLanes;
use super::near::PairClasses;
use crate::road::network::Road;
use whyroad_model::Drive;

/// Objects in a table of objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Objects {
    /// The tracks, in the rows of [`crate::derive`]: for rules that read `target.` signals as well.
    Tracks,
    /// The tracks, and the ego as the last one.
    WithEgo,
}

/// Whether a table of objects has pairs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WithPairs {
    /// Those of all objects.
    Yes,
    /// Pairs between objects of these classes. If nothing is known about the classes, pairs of all objects: whether a
    /// signal can be known never depends on the request.
    Between(PairClasses),
    /// Only objects by themselves.
    No,
}

/// Inputs of the signals of objects.
pub(super) struct Scene<'a> {
    /// The estimated drive.
    pub drive: &'a Drive,
    /// Seconds since the first frame.
    pub times: &'a [f64],
    /// The objects in the table's order.
    pub bodies: &'a [Body],
    /// The prepared map; `None` if it is not needed or missing.
    pub road: Option<&'a Road>,
    /// Lanes of the objects; as `road`.
    pub lanes: Option<&'a BodyLanes>,
}
