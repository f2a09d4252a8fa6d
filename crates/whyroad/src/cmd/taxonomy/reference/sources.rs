//! Sources of the pages of the leaves.

use super::cases::ClassCases;
use std::collections::BTreeMap;
use whyroad_framework::Framework;
use whyroad_mining::RuleSet;
use whyroad_model::ScenarioId;
use whyroad_signals::Catalog;

/// The framework, its rules, and the drawn cases of each class.
pub(super) struct Sources<'a> {
    pub framework: &'a Framework,
    pub catalog: &'a Catalog,
    pub rules: RuleSet,
    pub cases: BTreeMap<ScenarioId, ClassCases>,
}
