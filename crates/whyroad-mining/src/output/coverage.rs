//! `coverage.json`: what was looked for and what came of it, for every leaf of the taxonomy.

use crate::engine::MinedLake;
use whyroad_framework::Taxonomy;
use whyroad_model::messages::{Coverage, CoverageState, DriveGap, LeafCoverage};
use whyroad_model::{DriveId, ScenarioId};

/// Coverage of all leaves. `rules` are the classes for which a rule was run.
pub fn coverage(mined: &MinedLake, taxonomy: &Taxonomy, rules: &[ScenarioId]) -> Coverage {
    let leaves = taxonomy.leaves().map(|(l1, l2, l3)| {
        let id = ScenarioId::leaf(&l1.id, &l2.id, &l3.id);
        if rules.contains(&id) { searched(mined, id) } else { without_rule(id) }
    });
    let mut drives: Vec<DriveId> = mined.drives.iter().map(|d| d.drive_id.clone()).collect();
    drives.sort();
    Coverage {
        taxonomy_version: taxonomy.version.clone(),
        drives,
        leaves: leaves.collect(),
        unresolved: rules.iter().filter(|r| !r.is_leaf()).map(|r| searched(mined, r.clone())).collect(),
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

fn searched(mined: &MinedLake, id: ScenarioId) -> LeafCoverage {
    let of_class = || mined.drives.iter().flat_map(|d| &d.episodes).filter(|e| e.record.scenario_id == id);
    let gaps: Vec<DriveGap> = mined
        .drives
        .iter()
        .filter_map(|d| {
            let missing = d.missing.get(&id).filter(|m| !m.is_empty())?;
            Some(DriveGap { drive_id: d.drive_id.clone(), missing_signals: missing.clone() })
        })
        .collect();
    let drives_searched = (mined.drives.len() - gaps.len()) as u64;
    let episodes = of_class().count() as u64;
    let state = match (episodes, drives_searched) {
        (1.., _) => CoverageState::Found,
        (0, 1..) => CoverageState::NotFound,
        // An empty lake was searched, and held nothing.
        (0, 0) if mined.drives.is_empty() => CoverageState::NotFound,
        (0, 0) => CoverageState::NotObservable,
    };
    LeafCoverage {
        state,
        episodes,
        primary_episodes: of_class().filter(|e| e.record.is_primary).count() as u64,
        drives_searched,
        gaps,
        scenario_id: id,
    }
}
