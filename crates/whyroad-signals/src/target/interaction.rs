//! What the families on pairs read: the ego, its road and the targets placed around it, found once by `derive`.

use crate::ego::meta_actions::MetaActions;
use crate::target::lanes::TargetLanes;
use crate::target::placement::{Surroundings, Target};
use crate::target::relations::Neighbors;
use whyroad_model::Drive;

/// One drive with all that was found before.
pub struct Interaction<'a> {
    /// The scene tables.
    pub drive: &'a Drive,
    /// Seconds by frame.
    pub times: &'a [f64],
    /// The ego, its path, its lanes, the road.
    pub around: &'a Surroundings<'a>,
    /// Targets in the table's order.
    pub targets: &'a [Target<'a>],
    /// The ego's meta actions.
    pub actions: &'a MetaActions,
    /// Lead and follower by frame.
    pub near: &'a Neighbors,
    /// Lanes of the targets by row; `None` without a map.
    pub lanes: Option<&'a TargetLanes>,
}
