//! `other`: decision moments (changes of meta action with an effect) that no class explains. A growing `other` shows a
//! framework's owner that a class is missing or a rule misses episodes (LABELING.md 1).
//!
//! It is a rule like any other, run with the framework's; [`crate::episode::arbitrate`] drops explained moments.

use super::{OTHER, Rule, RuleSet};
use crate::episode::Episode;
use crate::language::program::Moment;
use crate::rule::text::compile_text;
use whyroad_model::{Bilingual, Nanos, ScenarioId};
use whyroad_signals::Catalog;

/// True at a decision moment of any kind.
const DECISION_MOMENT: &str = "ego.responds";

/// The time range of a moment whose range no class defines: its cause and its effect (the effect that defines the
/// moment occurs within 3 s).
const BEFORE: Nanos = Nanos(-2_000_000_000);
const AFTER: Nanos = Nanos(3_000_000_000);

/// The class of unexplained moments.
pub fn other() -> ScenarioId {
    ScenarioId { l1: OTHER.to_owned(), l2: None, l3: None }
}

/// True for an episode of the rule for decision moments (a custom question is filed as `other`, too).
pub(crate) fn is_decision_moment(episode: &Episode) -> bool {
    episode.scenario.l1 == OTHER && episode.signals == [DECISION_MOMENT]
}

impl RuleSet {
    /// The same rules, and the one for decision moments that none of them explains. A catalog without the signal for
    /// decision moments leaves the set as it is.
    #[must_use]
    pub fn with_decision_moments(mut self, catalog: &Catalog) -> Self {
        self.rules.extend(decision_moments(catalog));
        self
    }
}

fn decision_moments(catalog: &Catalog) -> Option<Rule> {
    let mut rule = compile_text(DECISION_MOMENT, None, &other(), catalog, OTHER).ok()?;
    rule.merge_gap = Nanos::default();
    rule.timing.at_match_start = Bilingual::new(
        "自车运动状态明显变化，而没有场景能解释",
        "the ego's motion clearly changes, and no class explains it",
    );
    rule.timing.start = vec![Moment::Offset(Box::new(Moment::Keyframe), BEFORE)];
    rule.timing.end = vec![Moment::Offset(Box::new(Moment::Keyframe), AFTER)];
    Some(rule)
}
