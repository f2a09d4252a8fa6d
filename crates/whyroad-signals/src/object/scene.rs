//! What the signals of objects are computed from, and which of them are wanted.

use super::body::Body;
use super::lanes::BodyLanes;
use super::near::PairClasses;
use crate::road::network::Road;
use whyroad_model::Drive;

/// Which objects a table of objects has.
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
    /// Those between objects of these classes. Where nothing is known of them, those of all objects: what a signal
    /// can be known of never depends on who asks.
    Between(PairClasses),
    /// Only objects by themselves.
    No,
}

/// What the signals of objects are computed from.
pub(super) struct Scene<'a> {
    /// The estimated drive.
    pub drive: &'a Drive,
    /// Seconds since the first frame.
    pub times: &'a [f64],
    /// The objects in the table's order.
    pub bodies: &'a [Body],
    /// The map made ready; `None` where it is not needed or not there.
    pub road: Option<&'a Road>,
    /// Lanes of the objects; as `road`.
    pub lanes: Option<&'a BodyLanes>,
}
