//! The results of a query for a class (DATA_FORMAT.md 5.1): the episodes of the class's own rules in whose time range
//! the query's conditions hold, of the same target. The conditions run beside the rules, as a separate rule.

use super::record::MinedEpisode;
use crate::mine::MinedDrive;
use whyroad_model::ScenarioId;
use whyroad_model::messages::EpisodeRecord;

/// The class under which the conditions of a query run: not one of the taxonomy.
pub fn conditions_class() -> ScenarioId {
    ScenarioId::custom("query")
}

/// True where both have the same target, or one of them is about the ego alone, and their time ranges overlap.
fn holds_in(conditions: &EpisodeRecord, episode: &EpisodeRecord) -> bool {
    let (a, b) = (&conditions.time_range, &episode.time_range);
    let overlap = a.start_timestamp < b.end_timestamp && b.start_timestamp < a.end_timestamp;
    let one = |c: &EpisodeRecord| c.target_id.is_none();
    overlap && (one(conditions) || one(episode) || conditions.target_id == episode.target_id)
}

/// The drive with the episodes of `class` for which the conditions hold, each with the conditions as they were met; all
/// of them where the query has no conditions. Secondary episodes keep their references to primary ones.
pub fn answer(drive: &MinedDrive, class: &ScenarioId, has_conditions: bool) -> MinedDrive {
    let of_query = conditions_class();
    let (met, found): (Vec<&MinedEpisode>, Vec<&MinedEpisode>) =
        drive.episodes.iter().partition(|e| e.record.scenario_id == of_query);
    let of_class = found.into_iter().filter(|e| e.record.scenario_id.is_within(class));
    let matched = |e: &MinedEpisode| -> Option<MinedEpisode> {
        if !has_conditions {
            return Some(e.clone());
        }
        let by = met.iter().find(|m| holds_in(&m.record, &e.record))?;
        let mut e = e.clone();
        e.record.conditions_matched = by.record.conditions_matched.clone();
        e.pre_label.mining_conditions_matched = by.pre_label.mining_conditions_matched.clone();
        e.record.signals.extend(by.record.signals.iter().cloned());
        e.record.signals.sort();
        e.record.signals.dedup();
        Some(e)
    };
    let mut missing = drive.missing.clone();
    // Signals missing for the conditions are missing for the class in this question.
    if let Some(lacking) = missing.remove(&of_query).filter(|m| !m.is_empty()) {
        for (_, signals) in missing.iter_mut().filter(|(c, _)| c.is_within(class)) {
            signals.extend(lacking.iter().cloned());
            signals.sort();
            signals.dedup();
        }
    }
    MinedDrive {
        drive_id: drive.drive_id.clone(),
        clips: drive.clips.clone(),
        episodes: of_class.filter_map(matched).collect(),
        missing,
    }
}
