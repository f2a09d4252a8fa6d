//! The classes (TAXONOMY.md) as validated values, in the order of the file, and how user input finds one.
//! Reading the YAML is in `read`.

mod agreement;
mod lookup;
mod read;
mod resolve;

pub use lookup::{class_ambiguous, class_not_found};
pub use read::read_taxonomy;
pub(crate) use read::{FAMILY, another_id, is_snake_case, optional_bilingual, read_bilingual, read_version};
pub use resolve::Resolution;
pub use whyroad_model::suggest::did_you_mean;
pub(crate) use whyroad_model::suggest::suggestion;

use whyroad_model::decision::{Lateral, Longitudinal};
use whyroad_model::{Bilingual, ScenarioId};

/// All classes. Ids are unique among siblings; L2 ids are unique across L1s (DATA_FORMAT.md 2.1 keys L3 by them).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Taxonomy {
    /// `major.minor.patch` (DATA_FORMAT.md 1.3).
    pub version: String,
    /// Description of the file.
    pub description: Bilingual,
    /// Kinds of trigger, in file order.
    pub l1: Vec<L1>,
}

/// A kind of trigger.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct L1 {
    /// Id, `reactive_agent`.
    pub id: String,
    /// Short name.
    pub name: Bilingual,
    /// What belongs here.
    pub definition: Bilingual,
    /// Triggering events, in file order.
    pub l2: Vec<L2>,
}

/// A triggering event.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct L2 {
    /// Id, `cutin`; unique across L1s.
    pub id: String,
    /// Short name.
    pub name: Bilingual,
    /// What belongs here.
    pub definition: Bilingual,
    /// When it applies, where the definition needs sharpening.
    pub condition: Option<Bilingual>,
    /// Decisions that the ego usually takes.
    pub typical_decisions: TypicalDecisions,
    /// Description of what mining looks for.
    pub mining_conditions: Vec<Bilingual>,
    /// Where the labeling spec is written, as named in the file.
    pub labeling_spec_ref: Option<String>,
    /// Rules against classes of overlapping meaning (LABELING.md 8).
    pub decides: Vec<Decides>,
    /// Variants, in file order.
    pub l3: Vec<L3>,
}

/// A variant: a leaf.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct L3 {
    /// Id, `urgent`.
    pub id: String,
    /// Short name.
    pub name: Bilingual,
    /// What belongs here.
    pub definition: Bilingual,
    /// Condition of this variant (TAXONOMY.md third column).
    pub condition: Bilingual,
    /// Decisions that the ego usually takes; those of the L2 where the leaf states none.
    pub typical_decisions: TypicalDecisions,
    /// Description of what mining looks for; empty where the L2's text suffices.
    pub mining_conditions: Vec<Bilingual>,
    /// Where the labeling spec is written; the L2's where the leaf states none.
    pub labeling_spec_ref: Option<String>,
    /// Rules against classes of overlapping meaning (LABELING.md 8).
    pub decides: Vec<Decides>,
}

/// Decisions that are usual in a class, in file order. A guide for labelers, not a constraint.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct TypicalDecisions {
    /// Along the path.
    pub longitudinal: Vec<Longitudinal>,
    /// Across the path.
    pub lateral: Vec<Lateral>,
}

/// How to decide between this class and another that overlaps it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Decides {
    /// The other class: a leaf or a whole L2.
    pub against: ScenarioId,
    /// Conditions for this class and for the other.
    pub rule: Bilingual,
}

impl Taxonomy {
    /// All leaves in tree order.
    pub fn leaves(&self) -> impl Iterator<Item = (&L1, &L2, &L3)> {
        self.l1.iter().flat_map(|a| a.l2.iter().flat_map(move |b| b.l3.iter().map(move |c| (a, b, c))))
    }

    /// All ids in tree order: each L1, then each of its L2, each followed by its L3.
    pub fn ids(&self) -> Vec<ScenarioId> {
        let mut out = Vec::new();
        for a in &self.l1 {
            out.push(ScenarioId { l1: a.id.clone(), l2: None, l3: None });
            for b in &a.l2 {
                out.push(ScenarioId { l1: a.id.clone(), l2: Some(b.id.clone()), l3: None });
                out.extend(b.l3.iter().map(|c| ScenarioId::leaf(&a.id, &b.id, &c.id)));
            }
        }
        out
    }

    /// The L1 with this id.
    pub fn l1(&self, id: &str) -> Option<&L1> {
        self.l1.iter().find(|a| a.id == id)
    }

    /// The L2 with this id under that L1.
    pub fn l2(&self, l1: &str, l2: &str) -> Option<(&L1, &L2)> {
        let a = self.l1(l1)?;
        Some((a, a.l2.iter().find(|b| b.id == l2)?))
    }

    /// The leaf with this full id; `None` for a prefix or an unknown id.
    pub fn leaf(&self, id: &ScenarioId) -> Option<(&L1, &L2, &L3)> {
        let (a, b) = self.l2(&id.l1, id.l2.as_deref()?)?;
        let l3 = id.l3.as_deref()?;
        Some((a, b, b.l3.iter().find(|c| c.id == l3)?))
    }

    /// True when `id` names an L1, L2 or leaf that exists.
    pub fn contains(&self, id: &ScenarioId) -> bool {
        match (&id.l2, &id.l3) {
            (None, _) => self.l1(&id.l1).is_some(),
            (Some(l2), None) => self.l2(&id.l1, l2).is_some(),
            (Some(_), Some(_)) => self.leaf(id).is_some(),
        }
    }

    /// Numbers of L1, L2 and L3, counted.
    pub fn counts(&self) -> (usize, usize, usize) {
        (self.l1.len(), self.l1.iter().map(|a| a.l2.len()).sum(), self.leaves().count())
    }
}
