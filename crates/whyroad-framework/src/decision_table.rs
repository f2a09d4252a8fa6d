//! Decisions that fit each class (`scenarios/decisions.yaml`, which documents each part); leaves inherit from their L2.

mod causes;
mod read;

pub use causes::{CauseKinds, Causes};
pub use read::parse;

use crate::label_words::GroupSet;
use std::collections::BTreeMap;
use whyroad_model::ScenarioId;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};

/// Relation of a decision to a class.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fit {
    /// Usual.
    Usual,
    /// Seen and allowed.
    Possible,
    /// Contradicts the class.
    Impossible,
}

/// A lateral decision as the table writes it: with a direction, only that direction matches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LateralEntry {
    /// The decision; `None` means no change.
    pub lateral: Option<Lateral>,
    /// The only direction; `None`: every direction.
    pub direction: Option<LateralDirection>,
}

/// The decisions of one class.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ClassDecisions {
    /// Along the path; `None` means no change. The usual ones first.
    pub longitudinal: Vec<(Option<Longitudinal>, Fit)>,
    /// Across the path. The usual ones first.
    pub lateral: Vec<(LateralEntry, Fit)>,
    /// At least one channel has a decision.
    pub decides: bool,
    /// Things that the texts must mention; empty where nothing is required.
    pub about: GroupSet,
    /// The same by name, for messages.
    pub about_names: Vec<String>,
    /// The leaf's name reveals what happened after the keyframe.
    pub reveals: bool,
}

impl ClassDecisions {
    /// How `decision` fits.
    pub fn longitudinal_fit(&self, decision: Option<Longitudinal>) -> Fit {
        let found = self.longitudinal.iter().find(|(d, _)| *d == decision);
        found.map_or(Fit::Impossible, |(_, fit)| *fit)
    }

    /// How `lateral` fits, in any direction.
    pub fn lateral_fit(&self, lateral: Option<Lateral>) -> Fit {
        let fits = self.lateral.iter().filter(|(e, _)| e.lateral == lateral).map(|(_, fit)| *fit);
        fits.min().unwrap_or(Fit::Impossible)
    }

    /// How `direction` fits a lateral decision that fits; a direction that is not given fits.
    pub fn direction_fit(&self, lateral: Lateral, direction: Option<LateralDirection>) -> Fit {
        let Some(direction) = direction else { return Fit::Usual };
        let entries = self.lateral.iter().filter(|(e, _)| e.lateral == Some(lateral));
        let fits = entries.filter(|(e, _)| e.direction.is_none_or(|d| d == direction)).map(|(_, fit)| *fit);
        fits.min().unwrap_or(Fit::Impossible)
    }

    /// What either of two classes allows: for a label with only the L2.
    #[must_use]
    pub fn or(&self, other: &ClassDecisions) -> ClassDecisions {
        let mut out = self.clone();
        for (d, fit) in &other.longitudinal {
            match out.longitudinal.iter_mut().find(|(e, _)| e == d) {
                Some((_, f)) => *f = (*f).min(*fit),
                None => out.longitudinal.push((*d, *fit)),
            }
        }
        for (e, fit) in &other.lateral {
            match out.lateral.iter_mut().find(|(o, _)| o == e) {
                Some((_, f)) => *f = (*f).min(*fit),
                None => out.lateral.push((*e, *fit)),
            }
        }
        out.decides &= other.decides;
        let open = out.about.is_empty() || other.about.is_empty();
        out.about = if open { GroupSet::default() } else { out.about.with(other.about) };
        let news: Vec<String> =
            other.about_names.iter().filter(|n| !out.about_names.contains(n)).cloned().collect();
        out.about_names.extend(news);
        out.reveals |= other.reveals;
        out
    }
}

/// The whole table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DecisionTable {
    /// By leaf.
    pub leaves: BTreeMap<ScenarioId, ClassDecisions>,
    /// Possible causes of decisions.
    pub causes: Causes,
    /// Decisions that cannot be combined in any class.
    pub impossible_pairs: Vec<(Longitudinal, Lateral)>,
}
