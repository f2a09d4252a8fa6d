//! An episode as messages: the record, the pre-label, the keyframe suggestion. Here drive frames become clip
//! frames: an episode belongs to the clip that its keyframe is in; times stay those of the drive where a
//! message allows, frames are clamped to the clip.

use serde::{Deserialize, Serialize};
use whyroad_mining::episode::{Episode, Rank};
use whyroad_model::messages::{
    EpisodeRecord, Keyframe, KeyframeSuggestion, KeyframeType, MatchedCondition, ScenarioPreLabel, TimeRange,
};
use whyroad_model::{ClipCut, ClipId, DriveId, FrameRange, Lang, Nanos, end_time};

/// An episode with all its messages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MinedEpisode {
    /// The episode.
    pub record: EpisodeRecord,
    /// Proposal for the labeler: class.
    pub pre_label: ScenarioPreLabel,
    /// Proposal for the labeler: moment and context.
    pub suggestion: KeyframeSuggestion,
}

/// The episodes of one drive, in their order, each in the clip that its keyframe is in, or that was cut around the
/// keyframe of the primary episode at its moment.
pub fn write_down(
    episodes: &[Episode],
    drive: &DriveId,
    times: &[Nanos],
    cut: ClipCut,
    lang: Lang,
) -> Vec<MinedEpisode> {
    let clips: Vec<(ClipId, FrameRange)> = episodes
        .iter()
        .map(|e| match (cut, e.rank) {
            (ClipCut::Fixed, _) => ClipId::holding(drive, e.keyframe, times),
            (ClipCut::Keyframe, Rank::Primary) => ClipId::around(drive, e.keyframe, times),
            (ClipCut::Keyframe, Rank::SecondaryTo(p)) => ClipId::around(drive, episodes[p].keyframe, times),
        })
        .collect();
    let ids: Vec<String> = ids(episodes, &clips);
    let one = |(i, e): (usize, &Episode)| {
        let (clip_id, clip) = (clips[i].0.clone(), clips[i].1);
        let record = EpisodeRecord {
            episode_id: ids[i].clone(),
            scenario_id: e.scenario.clone(),
            drive_id: drive.clone(),
            clip_id,
            target_id: e.target.clone(),
            roles: e.roles.clone(),
            time_range: TimeRange {
                start_timestamp: times[e.range.start],
                end_timestamp: end_time(times, e.range.end),
                start_frame_idx: Some(frame_in(clip, e.range.start)),
                end_frame_idx: Some(frame_in(clip, e.range.end)),
            },
            keyframe: Keyframe {
                timestamp: times[e.keyframe],
                frame_idx: frame_in(clip, e.keyframe),
                kind: e.kind,
                range_start: (e.kind == KeyframeType::Proactive).then(|| times[e.keyframe]),
                range_end: (e.kind == KeyframeType::Proactive).then(|| end_time(times, e.range.end)),
            },
            second_keyframe: e.second_keyframe.map(|frame| Keyframe {
                timestamp: times[frame],
                frame_idx: frame_in(clip, frame),
                kind: KeyframeType::Reactive,
                range_start: None,
                range_end: None,
            }),
            score: rounded(e.share.unwrap_or(e.score)),
            margin_score: Some(rounded(e.score)),
            calibrated: Some(e.share.is_some()),
            is_primary: e.rank == Rank::Primary,
            primary_episode_id: match e.rank {
                Rank::Primary => None,
                Rank::SecondaryTo(p) => Some(ids[p].clone()),
            },
            ego_response: Some(e.response),
            keyframe_rule: e.keyframe_rule.clone(),
            conditions_matched: e.conditions.clone(),
            signals: e.signals.clone(),
            // The caller, which knows the rule, states it.
            rule_version: None,
        };
        let context = e.context.intersect(clip);
        let suggestion = KeyframeSuggestion {
            kind: e.kind,
            suggested_timestamp: times[e.keyframe],
            suggested_frame_idx: frame_in(clip, e.keyframe),
            detection_rule: e.keyframe_rule.get(lang).to_owned(),
            // A labeler can open only the clip, so here the times are clamped like the frames.
            context_range: TimeRange {
                start_timestamp: times[context.start],
                end_timestamp: end_time(times, context.end),
                start_frame_idx: Some(frame_in(clip, context.start)),
                end_frame_idx: Some(frame_in(clip, context.end)),
            },
        };
        let pre_label = ScenarioPreLabel {
            l1: e.scenario.l1.clone(),
            l2: e.scenario.l2.clone().unwrap_or_default(),
            // A person confirms the variant; mining suggests it.
            l3: None,
            confidence: rounded(e.share.unwrap_or(e.score)),
            mining_conditions_matched: e.conditions.iter().map(|c| words(c, lang)).collect(),
            suggested_l3: e.scenario.l3.clone(),
        };
        MinedEpisode { record, pre_label, suggestion }
    };
    episodes.iter().enumerate().map(one).collect()
}

/// A condition in words; as written where it has none.
pub(super) fn words(condition: &MatchedCondition, lang: Lang) -> String {
    let described = condition.description.as_ref();
    described.map_or_else(|| condition.condition.clone(), |d| d.get(lang).to_owned())
}

/// `<clip>_<class>_<target or ego>_<frame>`: the same whenever the same episode is found again. Should two
/// matches of one rule share a keyframe, the later ones are numbered.
fn ids(episodes: &[Episode], clips: &[(ClipId, FrameRange)]) -> Vec<String> {
    let mut out: Vec<String> = Vec::with_capacity(episodes.len());
    for (e, (clip_id, clip)) in episodes.iter().zip(clips) {
        let target = e.target.as_ref().map_or("ego", |t| t.as_str());
        let frame = frame_in(*clip, e.keyframe);
        let id = format!("{clip_id}_{}_{target}_{frame:03}", e.scenario);
        let numbered = (2..).map(|n| format!("{id}_{n}"));
        let free = std::iter::once(id.clone()).chain(numbered).find(|id| !out.contains(id));
        out.push(free.unwrap_or(id));
    }
    out
}

/// Frame of the drive as an index in the clip, clamped; the clip's length is its end.
fn frame_in(clip: FrameRange, frame: usize) -> u32 {
    u32::try_from(frame.clamp(clip.start, clip.end) - clip.start).unwrap_or(u32::MAX)
}

/// Scores have four decimals, so that a result does not differ by the last bit of a sum.
fn rounded(score: f64) -> f64 {
    (score * 1e4).round() / 1e4
}

#[cfg(test)]
mod tests {
    use super::*;
    use whyroad_model::Bilingual;
    use whyroad_model::messages::EgoResponse;

    /// One episode in the second clip of a drive, whose time range begins in the first.
    fn mined(target: Option<&str>, cut: ClipCut) -> MinedEpisode {
        let episode = Episode {
            scenario: "reactive_agent.cutin.urgent".parse().unwrap(),
            target: target.map(Into::into),
            roles: [].into(),
            matched: FrameRange::new(210, 230),
            kind: KeyframeType::Reactive,
            keyframe: 210,
            second_keyframe: None,
            range: FrameRange::new(190, 240),
            context: FrameRange::new(160, 250),
            keyframe_rule: Bilingual::default(),
            response: EgoResponse::Observed,
            score: 0.75,
            share: Some(0.875),
            conditions: vec![],
            signals: vec![],
            rank: Rank::Primary,
        };
        let times: Vec<Nanos> = (0..250).map(|i| Nanos(i * 100_000_000)).collect();
        write_down(&[episode], &"d".into(), &times, cut, Lang::En).remove(0)
    }

    #[test]
    fn frames_are_those_of_the_clip_and_times_those_of_the_drive() {
        let record = mined(None, ClipCut::Fixed).record;
        assert_eq!(record.clip_id.as_str(), "d_001");
        assert_eq!(record.episode_id, "d_001_reactive_agent.cutin.urgent_ego_010");
        // Frame 190 of the drive is in the clip before: clamped to 0. Frame 240 is frame 40 of the clip.
        assert_eq!((record.time_range.start_frame_idx, record.time_range.end_frame_idx), (Some(0), Some(40)));
        assert_eq!(record.time_range.start_timestamp, Nanos(19_000_000_000));
        assert_eq!(record.time_range.end_timestamp, Nanos(24_000_000_000));
        // The context for a labeler is clamped in time too; 50 frames are the whole second clip.
        let context = mined(None, ClipCut::Fixed).suggestion.context_range;
        assert_eq!(
            (context.start_timestamp, context.end_timestamp),
            (Nanos(20_000_000_000), Nanos(25_000_000_000))
        );
        assert_eq!((context.start_frame_idx, context.end_frame_idx), (Some(0), Some(50)));
    }

    #[test]
    fn a_clip_around_the_keyframe_holds_what_the_division_cuts() {
        // Keyframe 210 of 250 frames: the clip begins at 50, the last frame with which it is whole.
        let record = mined(None, ClipCut::Keyframe).record;
        assert_eq!(record.clip_id.as_str(), "d_k000050");
        assert_eq!(record.episode_id, "d_k000050_reactive_agent.cutin.urgent_ego_160");
        assert_eq!((record.time_range.start_frame_idx, record.keyframe.frame_idx), (Some(140), 160));
        let context = mined(None, ClipCut::Keyframe).suggestion.context_range;
        assert_eq!((context.start_timestamp, context.start_frame_idx), (Nanos(16_000_000_000), Some(110)));
    }

    #[test]
    fn a_calibrated_score_is_the_share() {
        let record = mined(None, ClipCut::Fixed).record;
        assert_eq!((record.score, record.margin_score, record.calibrated), (0.875, Some(0.75), Some(true)));
        assert_eq!(mined(None, ClipCut::Fixed).pre_label.confidence, 0.875);
    }
}
