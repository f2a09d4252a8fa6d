//! Coverage over the whole taxonomy: mining's `coverage.json` mapped onto the tree, with counts at every level.
//! A leaf that mining does not mention is one without a rule; it is shown as that, never left out.

use std::collections::BTreeMap;
use whyroad_framework::{L1, L2, L3, Taxonomy};
use whyroad_model::ids::OTHER;
use whyroad_model::messages::{Coverage, CoverageState, DriveGap, LeafCoverage};
use whyroad_model::{Bilingual, ScenarioId};

/// One leaf with its position in the tree and its state.
#[derive(Clone, Debug)]
pub struct LeafRow<'a> {
    /// Full id.
    pub id: ScenarioId,
    /// Kind of trigger.
    pub l1: &'a L1,
    /// Triggering event.
    pub l2: &'a L2,
    /// The leaf.
    pub l3: &'a L3,
    /// The state over all drives.
    pub state: CoverageState,
    /// Episodes, primary and secondary.
    pub episodes: u64,
    /// Episodes for which this leaf was the primary one.
    pub primary_episodes: u64,
    /// Drives on which the rule could be decided.
    pub drives_searched: u64,
    /// Drives on which it could not.
    pub gaps: &'a [DriveGap],
}

/// Episodes of an L2 whose variant is unknown: the recording does not show it.
#[derive(Clone, Debug)]
pub struct UnresolvedRow<'a> {
    /// Kind of trigger.
    pub l1: &'a L1,
    /// Triggering event.
    pub l2: &'a L2,
    /// Mining results for it.
    pub found: &'a LeafCoverage,
}

/// The L2s with their own rule, in mining's order.
pub fn unresolved<'a>(taxonomy: &'a Taxonomy, coverage: &'a Coverage) -> Vec<UnresolvedRow<'a>> {
    coverage
        .unresolved
        .iter()
        .filter_map(|found| {
            let (l1, l2) = taxonomy.l2(&found.scenario_id.l1, found.scenario_id.l2.as_deref()?)?;
            Some(UnresolvedRow { l1, l2, found })
        })
        .collect()
}

/// Decision moments that no class explains; `None` when mining did not look for them.
pub fn unexplained(coverage: &Coverage) -> Option<&LeafCoverage> {
    coverage.unresolved.iter().find(|l| l.scenario_id.l1 == OTHER)
}

/// The displayed name of a class: `L2 · L3`, or the L2 with a note that its variant is not known.
pub fn class_title(taxonomy: &Taxonomy, id: &ScenarioId) -> Bilingual {
    if let Some((_, l2, l3)) = taxonomy.leaf(id) {
        return Bilingual::new(
            format!("{} · {}", l2.name.zh, l3.name.zh),
            format!("{} · {}", l2.name.en, l3.name.en),
        );
    }
    match id.l2.as_deref().and_then(|l2| taxonomy.l2(&id.l1, l2)) {
        Some((_, l2)) => Bilingual::new(
            format!("{}（变体未定）", l2.name.zh),
            format!("{} (variant not known)", l2.name.en),
        ),
        None if id.l1 == OTHER => Bilingual::new("其他（没有类别能解释）", "Other (no class explains it)"),
        None => Bilingual::same(id.to_string()),
    }
}

/// How many leaves are in each state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StateCounts {
    /// With at least one episode.
    pub found: usize,
    /// Searched, nothing found.
    pub not_found: usize,
    /// Never decidable on these drives.
    pub not_observable: usize,
    /// Without a rule.
    pub no_rule: usize,
}

impl StateCounts {
    /// The number for one state.
    pub fn get(self, state: CoverageState) -> usize {
        match state {
            CoverageState::Found => self.found,
            CoverageState::NotFound => self.not_found,
            CoverageState::NotObservable => self.not_observable,
            CoverageState::NoRule => self.no_rule,
        }
    }

    /// All leaves counted.
    pub fn total(self) -> usize {
        CoverageState::ALL.iter().map(|s| self.get(*s)).sum()
    }

    fn add(&mut self, state: CoverageState) {
        match state {
            CoverageState::Found => self.found += 1,
            CoverageState::NotFound => self.not_found += 1,
            CoverageState::NotObservable => self.not_observable += 1,
            CoverageState::NoRule => self.no_rule += 1,
        }
    }
}

/// Every leaf of `taxonomy` in its order. Leaves that only `coverage` knows belong to another taxonomy
/// version and are in [`unknown_leaves`].
pub fn rows<'a>(taxonomy: &'a Taxonomy, coverage: &'a Coverage) -> Vec<LeafRow<'a>> {
    let known: BTreeMap<&ScenarioId, usize> =
        coverage.leaves.iter().enumerate().map(|(i, l)| (&l.scenario_id, i)).collect();
    taxonomy
        .leaves()
        .map(|(l1, l2, l3)| {
            let id = ScenarioId::leaf(&l1.id, &l2.id, &l3.id);
            let found = known.get(&id).map(|&i| &coverage.leaves[i]);
            LeafRow {
                l1,
                l2,
                l3,
                state: found.map_or(CoverageState::NoRule, |l| l.state),
                episodes: found.map_or(0, |l| l.episodes),
                primary_episodes: found.map_or(0, |l| l.primary_episodes),
                drives_searched: found.map_or(0, |l| l.drives_searched),
                gaps: found.map_or(&[], |l| &l.gaps),
                id,
            }
        })
        .collect()
}

/// Classes in `coverage` that `taxonomy` does not have.
pub fn unknown_leaves<'a>(taxonomy: &Taxonomy, coverage: &'a Coverage) -> Vec<&'a ScenarioId> {
    let found = coverage.leaves.iter().chain(&coverage.unresolved);
    found.map(|l| &l.scenario_id).filter(|id| id.l1 != OTHER && !taxonomy.contains(id)).collect()
}

/// Leaves by state.
pub fn counts(rows: &[LeafRow<'_>]) -> StateCounts {
    let mut out = StateCounts::default();
    for row in rows {
        out.add(row.state);
    }
    out
}

impl LeafRow<'_> {
    /// Drives on which the rule could be decided, and all drives, where these differ: an absent find is then unknown
    /// for the other drives.
    pub fn searched_in_part(&self) -> Option<(u64, u64)> {
        let blind: usize = self.gaps.iter().map(|g| g.drives.len()).sum();
        let all = self.drives_searched + blind as u64;
        (self.drives_searched > 0 && blind > 0).then_some((self.drives_searched, all))
    }

    /// Signals that some drive lacked for this leaf, sorted, each once.
    pub fn missing_signals(&self) -> Vec<&str> {
        let mut out: Vec<&str> =
            self.gaps.iter().flat_map(|g| g.missing_signals.iter().map(String::as_str)).collect();
        out.sort_unstable();
        out.dedup();
        out
    }
}

/// The displayed name of a state.
pub fn state_name(state: CoverageState) -> Bilingual {
    match state {
        CoverageState::Found => Bilingual::new("已找到", "found"),
        CoverageState::NotFound => Bilingual::new("已搜索，未找到", "searched, not found"),
        CoverageState::NotObservable => {
            Bilingual::new("不可观测（缺信号）", "not observable (signals missing)")
        }
        CoverageState::NoRule => Bilingual::new("尚无规则", "no rule yet"),
    }
}

#[cfg(test)]
mod tests;
