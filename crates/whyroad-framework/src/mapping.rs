//! A mapping of classes from one version of the taxonomy to the next: renamed, merged and split classes. Read from YAML
//! with positions and checked; `whyroad_label::carry` applies it to labels.
//!
//! ```yaml
//! from: 1.0.0
//! to: 2.0.0
//! changes:
//!   - rename: reactive_agent.cutin          # with everything below it
//!     to: reactive_agent.cut_in
//!   - merge: [reactive_agent.cutin.urgent, reactive_agent.cutin.slow]
//!     to: reactive_agent.cutin.any
//!   - split: reactive_agent.cutin.ramp
//!     into:
//!       - to: reactive_agent.cutin.ramp_yield
//!         when: { /driving_decision/longitudinal: [yield_to_agent, lead_following] }
//!       - to: reactive_agent.cutin.ramp_other
//! ```

mod read;

pub use read::{MAPPING_CODES, read_mapping};

use crate::{Framework, ResolvedSpec};
use std::collections::BTreeMap;
use whyroad_model::ScenarioId;

/// A mapping, checked.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ClassMapping {
    /// Version of the taxonomy before.
    pub from: String,
    /// Version of the taxonomy after.
    pub to: String,
    /// Change of each class; a class that is not listed stays, unless a class above it is renamed.
    pub changes: BTreeMap<ScenarioId, ClassChange>,
    /// 16 hexadecimal digits of a hash of the changes: labels that were migrated by them state it.
    pub mark: String,
    /// Ids of the records that a label of each class after the change has to have (the last column of TAXONOMY.md);
    /// a class that is not listed requires none. [`ClassMapping::requiring`] fills it.
    pub records: BTreeMap<ScenarioId, Vec<String>>,
}

/// Change of a class.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ClassChange {
    /// It has another id, alone or together with other classes.
    To(ScenarioId),
    /// Its labels go to several classes.
    Split(Vec<SplitPart>),
}

/// One class that a class is split into.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SplitPart {
    /// The class.
    pub to: ScenarioId,
    /// Conditions on a label of it: for each field, one of these values; `None` means null or an absent field. Empty:
    /// the label does not decide it, a person decides.
    pub when: BTreeMap<String, Vec<Option<String>>>,
}

impl ClassMapping {
    /// With the records that the classes of `framework`, the one after the change, require.
    #[must_use]
    pub fn requiring(mut self, framework: &Framework) -> Self {
        let ids = |spec: &ResolvedSpec| spec.records.iter().map(|r| r.id.clone()).collect();
        self.records = framework.specs.iter().map(|(id, spec)| (id.clone(), ids(spec))).collect();
        self
    }

    /// The change of `id`: its own change, or that of the nearest class above it that is renamed.
    pub fn change(&self, id: &ScenarioId) -> Option<ClassChange> {
        if let Some(change) = self.changes.get(id) {
            return Some(change.clone());
        }
        let above = [ScenarioId { l3: None, ..id.clone() }, ScenarioId { l2: None, l3: None, ..id.clone() }];
        above.iter().filter(|a| *a != id).find_map(|a| match self.changes.get(a)? {
            ClassChange::To(to) if to.is_leaf() => None,
            ClassChange::To(to) => Some(ClassChange::To(below(id, a, to))),
            ClassChange::Split(_) => None,
        })
    }
}

/// `id`, which lies below `old`, at the same position below `new`.
fn below(id: &ScenarioId, old: &ScenarioId, new: &ScenarioId) -> ScenarioId {
    match (&old.l2, &new.l2) {
        (None, None) => ScenarioId { l1: new.l1.clone(), ..id.clone() },
        _ => ScenarioId { l3: id.l3.clone(), ..new.clone() },
    }
}

#[cfg(test)]
mod tests;
