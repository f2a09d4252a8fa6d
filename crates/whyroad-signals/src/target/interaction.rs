//! Input of the families on pairs: the ego, its road and the targets placed around it, computed once by `derive`.

use crate::ego::meta_actions::MetaActions;
use crate::table::TableBuilder;
use crate::target::lanes::TargetLanes;
use crate::target::placement::{Surroundings, Target};
use crate::target::relations::Neighbors;
use std::cell::OnceCell;
use whyroad_model::{Drive, SignalId};

/// One drive with the results of the earlier stages.
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
    /// Cache of [`Interaction::lanes`].
    pub assigned: OnceCell<Option<TargetLanes>>,
}

impl Interaction<'_> {
    /// Lanes of the targets by row, assigned at the first call; `None` without a map.
    pub fn lanes(&self) -> Option<&TargetLanes> {
        let assign = || Some(TargetLanes::new(self.around.road?, self.targets));
        self.assigned.get_or_init(assign).as_ref()
    }
}

/// Signals of a family, and the function that writes them.
pub type Family = (&'static [SignalId], fn(&Interaction<'_>, &mut TableBuilder<'_>));

/// Writes these families, in their order, if any of their signals is requested.
pub fn write_asked(families: &[Family], scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    for (signals, write) in families {
        if table.asks(signals) {
            write(scene, table);
        }
    }
}
