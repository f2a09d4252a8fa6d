//! `mining_result` (DATA_FORMAT.md 5.2): what was found for one question, the best first, with figures over
//! everything that matches.

use super::record::MinedEpisode;
use crate::engine::MinedLake;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::ScenarioId;
use whyroad_model::messages::{
    MinedClip, MinedKeyframe, MiningResult, MiningResultMessage, MiningStatistics, NotObservable,
};

/// The result for a class: its episodes and those of everything below it.
pub fn mining_result(
    mined: &MinedLake,
    query_id: &str,
    scenario: &ScenarioId,
    limit: Option<u32>,
) -> MiningResultMessage {
    let mut all: Vec<&MinedEpisode> = mined
        .drives
        .iter()
        .flat_map(|d| &d.episodes)
        .filter(|e| e.record.scenario_id.is_within(scenario))
        .collect();
    all.sort_by(|a, b| {
        let (a, b) = (&a.record, &b.record);
        b.score.total_cmp(&a.score).then_with(|| a.episode_id.cmp(&b.episode_id))
    });
    let mut distribution = BTreeMap::new();
    for e in &all {
        *distribution.entry(tenth(e.record.score)).or_insert(0u64) += 1;
    }
    let take = limit.map_or(all.len(), |l| usize::try_from(l).unwrap_or(usize::MAX).min(all.len()));
    let clips: Vec<MinedClip> = all[..take].iter().map(|e| clip(e, scenario)).collect();
    MiningResultMessage {
        mining_result: MiningResult {
            query_id: query_id.to_owned(),
            scenario_id: scenario.clone(),
            total_matched: all.len() as u64,
            returned: clips.len() as u64,
            clips,
            statistics: MiningStatistics { score_distribution: distribution },
            not_observable: not_observable(mined, scenario),
        },
    }
}

fn clip(e: &MinedEpisode, asked: &ScenarioId) -> MinedClip {
    let r = &e.record;
    MinedClip {
        clip_id: r.clip_id.to_string(),
        match_score: r.score,
        keyframe_suggestion: MinedKeyframe {
            timestamp: r.keyframe.timestamp,
            frame_idx: r.keyframe.frame_idx,
        },
        conditions_matched: r.conditions_matched.clone(),
        scenario_id: (r.scenario_id != *asked).then(|| r.scenario_id.clone()),
        episode_id: Some(r.episode_id.clone()),
        target_id: r.target_id.as_ref().map(ToString::to_string),
    }
}

/// `0.8-0.9` holds scores from 0.8 up to but not 0.9; the last tenth holds 1 as well.
fn tenth(score: f64) -> String {
    let lower = ((score * 10.0).floor() as i64).clamp(0, 9);
    format!("{:.1}-{:.1}", lower as f64 / 10.0, (lower + 1) as f64 / 10.0)
}

fn not_observable(mined: &MinedLake, scenario: &ScenarioId) -> Vec<NotObservable> {
    let mut by_class: BTreeMap<&ScenarioId, (Vec<String>, BTreeSet<String>)> = BTreeMap::new();
    for drive in &mined.drives {
        for (class, missing) in &drive.missing {
            if class.is_within(scenario) && !missing.is_empty() {
                let (drives, signals) = by_class.entry(class).or_default();
                drives.push(drive.drive_id.to_string());
                signals.extend(missing.iter().cloned());
            }
        }
    }
    let row = |(class, (drives, signals)): (&ScenarioId, (Vec<String>, BTreeSet<String>))| NotObservable {
        scenario_id: class.clone(),
        drives,
        missing_signals: signals.into_iter().collect(),
    };
    by_class.into_iter().map(row).collect()
}
