//! `coverage.json`: what was searched for and what was found, for every leaf of the taxonomy. Counted drive by drive,
//! so that no drive has to be kept.

use crate::mine::MinedDrive;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use whyroad_framework::Taxonomy;
use whyroad_model::messages::{Coverage, CoverageState, DriveGap, LeafCoverage};
use whyroad_model::{DriveId, ScenarioId};

/// Whose rules were run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Searched {
    /// Those of the framework: a leaf without one is reported as that.
    Framework,
    /// A custom rule: nothing is known of other classes, and they are left out.
    Question,
}

/// The counts of one class.
#[derive(Clone, Debug, Default)]
struct Count {
    episodes: u64,
    primary: u64,
    /// Places in the list of drives, by what they lack.
    gaps: BTreeMap<Vec<String>, Vec<u32>>,
}

/// Counts over the drives so far.
#[derive(Clone, Debug)]
pub struct Counts {
    drives: Vec<DriveId>,
    /// By the class of each rule that was run, in the order of the rules.
    classes: Vec<(ScenarioId, Count)>,
}

impl Counts {
    /// Nothing counted yet. `rules` are the classes for which a rule is run.
    pub fn new(rules: &[ScenarioId]) -> Self {
        Self { drives: Vec::new(), classes: rules.iter().map(|id| (id.clone(), Count::default())).collect() }
    }

    /// Adds the results of a drive; drives come in the order of their ids.
    pub fn add(&mut self, drive: &MinedDrive) {
        let place = u32::try_from(self.drives.len()).unwrap_or(u32::MAX);
        self.drives.push(drive.drive_id.clone());
        for (class, count) in &mut self.classes {
            if let Some(missing) = drive.missing.get(class).filter(|m| !m.is_empty()) {
                match count.gaps.get_mut(missing) {
                    Some(drives) => drives.push(place),
                    None => {
                        count.gaps.insert(missing.clone(), vec![place]);
                    }
                }
            }
            let found = drive.episodes.iter().filter(|e| e.record.scenario_id == *class);
            for episode in found {
                count.episodes += 1;
                count.primary += u64::from(episode.record.is_primary);
            }
        }
    }

    /// How many drives were counted.
    pub fn drives(&self) -> usize {
        self.drives.len()
    }

    /// Drives, by what they lack, on which nothing within `scenario` could be decided for that reason.
    pub fn gaps(&self, scenario: &ScenarioId) -> Vec<(ScenarioId, Vec<DriveGap>)> {
        let within =
            self.classes.iter().filter(|(id, count)| id.is_within(scenario) && !count.gaps.is_empty());
        within.map(|(id, count)| (id.clone(), self.named(count))).collect()
    }

    /// The message.
    pub fn coverage(&self, taxonomy: &Taxonomy, searched: Searched) -> Coverage {
        let leaves = taxonomy.leaves().filter_map(|(l1, l2, l3)| {
            let id = ScenarioId::leaf(&l1.id, &l2.id, &l3.id);
            match self.classes.iter().find(|(class, _)| *class == id) {
                Some((_, count)) => Some(self.leaf_coverage(id, count)),
                None => (searched == Searched::Framework).then(|| without_rule(id)),
            }
        });
        let upper = self.classes.iter().filter(|(id, _)| !id.is_leaf());
        Coverage {
            taxonomy_version: taxonomy.version.clone(),
            drives: self.drives.clone(),
            leaves: leaves.collect(),
            unresolved: upper.map(|(id, count)| self.leaf_coverage(id.clone(), count)).collect(),
        }
    }

    fn named(&self, count: &Count) -> Vec<DriveGap> {
        let gap = |(missing, places): (&Vec<String>, &Vec<u32>)| DriveGap {
            drives: places.iter().filter_map(|p| self.drives.get(*p as usize).cloned()).collect(),
            missing_signals: missing.clone(),
        };
        count.gaps.iter().map(gap).collect()
    }

    fn leaf_coverage(&self, scenario_id: ScenarioId, count: &Count) -> LeafCoverage {
        let blind: usize = count.gaps.values().map(Vec::len).sum();
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
            gaps: self.named(count),
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
