//! The results of a query for a class (DATA_FORMAT.md 5.1): the episodes of the class's own rules in whose time range
//! the query's conditions hold, of the same target. The conditions run beside the rules, as a separate rule.

use super::record::{MinedEpisode, words};
use crate::drives::derived_signals;
use crate::mine::MinedDrive;
use crate::objects::signals_for;
use std::cell::LazyCell;
use whyroad_lake::{Lake, LakeError};
use whyroad_mining::RuleSet;
use whyroad_mining::episode::conditions_at;
use whyroad_mining::rule::Rule;
use whyroad_model::messages::{EpisodeRecord, MatchedCondition};
use whyroad_model::{DriveId, FrameRange, Lang, Nanos, ScenarioId, SignalTable};

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

/// A query for a class.
pub struct ClassQuery<'a> {
    class: &'a ScenarioId,
    /// Its conditions as a rule; all episodes of the class match without any.
    conditions: Option<&'a Rule>,
    /// The lake that is mined.
    lake: &'a Lake,
    lang: Lang,
}

impl<'a> ClassQuery<'a> {
    /// The query for a class whose conditions, where it has any, are among the rules that are run.
    pub fn new(class: &'a ScenarioId, rules: &'a RuleSet, lake: &'a Lake, lang: Lang) -> Self {
        let of_query = conditions_class();
        Self { class, conditions: rules.rules.iter().find(|r| r.scenario == of_query), lake, lang }
    }

    /// The signals of a drive for the conditions. They are not stored, as `mine --once` requires.
    fn signals(&self, rule: &Rule, drive: &DriveId) -> Result<SignalTable, LakeError> {
        let whole = || match self.lake.signals(drive, whyroad_signals::VERSION)?.map(|f| f.read_table(0)) {
            Some(Ok(table)) => Ok(table),
            _ => derived_signals(self.lake, drive),
        };
        signals_for(rule, || self.lake.read_drive(drive), whole)
    }
}

/// Time between a keyframe and the match that has these conditions; zero within it.
fn apart(conditions: &EpisodeRecord, keyframe: Nanos) -> Nanos {
    let range = &conditions.time_range;
    let before = (range.start_timestamp - keyframe).max(Nanos::default());
    before.max(keyframe - range.end_timestamp)
}

/// The conditions with their values at the keyframe of `of`, or, where they do not hold there, at the nearest frame of
/// their match `by`.
fn at_keyframe(
    rule: &Rule,
    table: &SignalTable,
    by: &EpisodeRecord,
    of: &EpisodeRecord,
) -> Option<Vec<MatchedCondition>> {
    let frame = |time: Nanos| table.times.partition_point(|t| *t < time);
    let range = &by.time_range;
    let matched = FrameRange::new(frame(range.start_timestamp), frame(range.end_timestamp));
    let last = matched.end.checked_sub(1).filter(|last| *last >= matched.start)?;
    let at = frame(of.keyframe.timestamp).clamp(matched.start, last);
    conditions_at(rule, table, by.target_id.as_ref(), (at, matched))
}

/// The drive with the episodes of the class for which the conditions hold, each with the conditions and their values at
/// its keyframe ([`at_keyframe`]); all episodes of the class where the query has no conditions. Secondary episodes keep
/// their references to primary ones.
pub fn answer(drive: &MinedDrive, query: &ClassQuery<'_>) -> MinedDrive {
    let (class, of_query) = (query.class, conditions_class());
    let (met, found): (Vec<&MinedEpisode>, Vec<&MinedEpisode>) =
        drive.episodes.iter().partition(|e| e.record.scenario_id == of_query);
    let of_class = found.into_iter().filter(|e| e.record.scenario_id.is_within(class));
    let table = LazyCell::new(|| {
        let rule = query.conditions?;
        // Without signals the conditions are listed as at the start of their match.
        query.signals(rule, &drive.drive_id).ok().map(|table| (rule, table))
    });
    let matched = |e: &MinedEpisode| -> Option<MinedEpisode> {
        if query.conditions.is_none() {
            return Some(e.clone());
        }
        let holding = met.iter().filter(|m| holds_in(&m.record, &e.record));
        let by = holding.min_by_key(|m| apart(&m.record, e.record.keyframe.timestamp))?;
        let mut e = e.clone();
        let (mut matched, mut said) =
            (by.record.conditions_matched.clone(), by.pre_label.mining_conditions_matched.clone());
        if let Some((rule, table)) = &*table
            && let Some(at) = at_keyframe(rule, table, &by.record, &e.record)
        {
            said = at.iter().map(|c| words(c, query.lang)).collect();
            matched = at;
        }
        e.record.conditions_matched = matched;
        e.pre_label.mining_conditions_matched = said;
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
