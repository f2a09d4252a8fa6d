//! `coverage.json`: search results for every leaf of the taxonomy. Counted drive by drive, so that no drive has to stay
//! in memory.

use crate::mine::MinedDrive;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use whyroad_framework::Taxonomy;
use whyroad_lake::mined::Gaps;
use whyroad_model::messages::{Coverage, CoverageState, DriveGap, DriveList, LeafCoverage};
use whyroad_model::{DriveId, ScenarioId};

/// Source of the rules.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Searched {
    /// The framework: a leaf without a rule is reported as such.
    Framework,
    /// A custom rule: other classes are unknown and left out.
    Question,
}

/// The counts of one class.
#[derive(Clone, Copy, Debug, Default)]
struct Count {
    episodes: u64,
    primary: u64,
}

/// Counts over the drives so far.
#[derive(Clone, Debug)]
pub struct Counts {
    drives: Vec<DriveId>,
    /// By the class of each rule that was run, in the order of the rules.
    classes: Vec<(ScenarioId, Count)>,
    /// Positions in `classes`.
    positions: BTreeMap<ScenarioId, usize>,
    /// Missing signals of drives by class; most drives of a lake lack the same. Numbers are indices into `lacking`.
    gaps: BTreeMap<Gaps, usize>,
    /// Positions in the list of drives, by the number of what they lack.
    lacking: Vec<Vec<u32>>,
}

/// Missing signals of drives, by class; a class that could be decided on all of them is left out.
pub type ClassGaps = BTreeMap<ScenarioId, Vec<DriveGap>>;

/// Lists of drives, by the numbers of what they lack.
type Lists = BTreeMap<Vec<usize>, DriveList>;

/// Of one drive: by class, its episodes and the primary ones among them.
pub type DriveCounts = Vec<(ScenarioId, u64, u64)>;

impl Counts {
    /// Empty counts. `rules` are the classes for which a rule is run.
    pub fn new(rules: &[ScenarioId]) -> Self {
        Self {
            drives: Vec::new(),
            classes: rules.iter().map(|id| (id.clone(), Count::default())).collect(),
            positions: rules.iter().enumerate().map(|(i, id)| (id.clone(), i)).collect(),
            gaps: BTreeMap::new(),
            lacking: Vec::new(),
        }
    }

    /// Adds the results of a drive; drives come in the order of their ids. Returns the number of its missing signals,
    /// and its episodes by class.
    pub fn add(&mut self, drive: &MinedDrive) -> (usize, DriveCounts) {
        let mut counts = BTreeMap::<&ScenarioId, (u64, u64)>::new();
        for episode in &drive.episodes {
            let count = counts.entry(&episode.record.scenario_id).or_default();
            *count = (count.0 + 1, count.1 + u64::from(episode.record.is_primary));
        }
        let counts: DriveCounts = counts.into_iter().map(|(c, (n, p))| (c.clone(), n, p)).collect();
        let number = self.number(&drive.missing);
        self.add_counted(&drive.drive_id, number, &counts);
        (number, counts)
    }

    /// The number of a drive's missing signals.
    pub fn number(&mut self, gaps: &Gaps) -> usize {
        if let Some(number) = self.gaps.get(gaps) {
            return *number;
        }
        self.lacking.push(Vec::new());
        self.gaps.insert(gaps.clone(), self.lacking.len() - 1);
        self.lacking.len() - 1
    }

    /// Adds a drive that was counted before.
    pub fn add_counted(&mut self, id: &DriveId, gaps: usize, counts: &DriveCounts) {
        self.lacking[gaps].push(u32::try_from(self.drives.len()).unwrap_or(u32::MAX));
        self.drives.push(id.clone());
        for (class, episodes, primary) in counts {
            if let Some(at) = self.positions.get(class) {
                let count = &mut self.classes[*at].1;
                count.episodes += episodes;
                count.primary += primary;
            }
        }
    }

    /// How many drives were counted.
    pub fn drives(&self) -> usize {
        self.drives.len()
    }

    /// For each class, the drives on which it could not be decided, by what they lack.
    pub fn gaps(&self) -> ClassGaps {
        let mut lists = Lists::new();
        let of = self.classes.iter().map(|(id, _)| (id.clone(), self.named(id, &mut lists)));
        of.filter(|(_, gaps)| !gaps.is_empty()).collect()
    }

    /// The message.
    pub fn coverage(&self, taxonomy: &Taxonomy, searched: Searched, gaps: &ClassGaps) -> Coverage {
        let leaves = taxonomy.leaves().filter_map(|(l1, l2, l3)| {
            let id = ScenarioId::leaf(&l1.id, &l2.id, &l3.id);
            match self.classes.iter().find(|(class, _)| *class == id) {
                Some((_, count)) => Some(self.leaf_coverage(id, *count, gaps)),
                None => (searched == Searched::Framework).then(|| without_rule(id)),
            }
        });
        let leaves = leaves.collect();
        let upper = self.classes.iter().filter(|(id, _)| !id.is_leaf());
        Coverage {
            taxonomy_version: taxonomy.version.clone(),
            drives: self.drives.clone(),
            left_out: Vec::new(),
            leaves,
            unresolved: upper.map(|(id, count)| self.leaf_coverage(id.clone(), *count, gaps)).collect(),
        }
    }

    /// The drives that lack something for a class, by what they lack. `lists` has those that were requested before.
    fn named(&self, class: &ScenarioId, lists: &mut Lists) -> Vec<DriveGap> {
        let mut by_signals = BTreeMap::<&Vec<String>, Vec<usize>>::new();
        for (gaps, number) in &self.gaps {
            if let Some(missing) = gaps.get(class).filter(|m| !m.is_empty()) {
                by_signals.entry(missing).or_default().push(*number);
            }
        }
        let mut gap = |(missing, numbers): (&Vec<String>, Vec<usize>)| {
            let list = || {
                let mut positions: Vec<u32> =
                    numbers.iter().flat_map(|n| self.lacking[*n].iter().copied()).collect();
                positions.sort_unstable();
                let drives = positions.iter().filter_map(|p| self.drives.get(*p as usize).cloned());
                drives.collect::<Vec<_>>().into()
            };
            let drives = lists.get(&numbers).cloned().unwrap_or_else(list);
            lists.insert(numbers, drives.clone());
            DriveGap { drives, missing_signals: missing.clone() }
        };
        by_signals.into_iter().map(&mut gap).collect()
    }

    fn leaf_coverage(&self, scenario_id: ScenarioId, count: Count, gaps: &ClassGaps) -> LeafCoverage {
        let gaps = gaps.get(&scenario_id).cloned().unwrap_or_default();
        let blind: usize = gaps.iter().map(|g| g.drives.len()).sum();
        let drives_searched = (self.drives.len() - blind) as u64;
        let state = match (count.episodes, drives_searched) {
            (1.., _) => CoverageState::Found,
            (0, 1..) => CoverageState::NotFound,
            // An empty lake was searched, and held nothing.
            (0, 0) if self.drives.is_empty() => CoverageState::NotFound,
            (0, 0) => CoverageState::NotObservable,
        };
        LeafCoverage {
            scenario_id,
            state,
            episodes: count.episodes,
            primary_episodes: count.primary,
            drives_searched,
            gaps,
        }
    }
}

fn without_rule(id: ScenarioId) -> LeafCoverage {
    LeafCoverage {
        scenario_id: id,
        state: CoverageState::NoRule,
        episodes: 0,
        primary_episodes: 0,
        drives_searched: 0,
        gaps: vec![],
    }
}
