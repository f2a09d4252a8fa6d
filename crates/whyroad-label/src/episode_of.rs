//! The episode that a label is about. The format has no place for it (DATA_FORMAT.md 4), so a label is recognized by
//! what both state: drive, class and keyframe, and the objects that the label links. A label of which no episode is
//! known gets one made from its content, whose score is not known.

use serde_json::Value;
use std::collections::BTreeSet;
use whyroad_model::label_fields::name;
use whyroad_model::messages::EpisodeRecord;

/// Beginning of the ids of episodes that were made from a label.
pub const MADE: &str = "label-";

/// True for the id of an episode that was made from a label, and of what comes from it.
pub fn is_made(episode_id: &str) -> bool {
    episode_id.starts_with(MADE)
}

/// The match score of the episode, where mining measured it: of an episode that a person gave another class, the score
/// is that of the class as mined (`<mined>^<class>`).
pub fn score(episode: &EpisodeRecord) -> Option<f64> {
    let id = &episode.episode_id;
    let is_other = id.ends_with(&format!("^{}", episode.scenario_id));
    (!is_made(id) && !is_other).then_some(episode.score)
}

/// An episode as a task of an export states it: its score is null where it is not known, and is then not to be read.
///
/// # Errors
/// When it is no episode.
pub fn of_task(episode: &Value) -> Result<EpisodeRecord, serde_json::Error> {
    let mut episode = episode.clone();
    if let Some(score) = episode.get_mut("score").filter(|s| s.is_null()) {
        *score = 1.0.into();
    }
    serde_json::from_value(episode)
}

/// Ids of the objects that the components of a label link, sorted.
pub fn linked(label: &Value) -> BTreeSet<String> {
    let components = label.get(name::CRITICAL_COMPONENTS).and_then(Value::as_array).into_iter().flatten();
    let objects = components.filter_map(|c| c.get("linked_objects")?.as_array()).flatten();
    objects.filter_map(Value::as_str).map(str::to_owned).collect()
}

/// Whether a label that links these objects may be about the target of `episode`; class, drive and keyframe are equal.
pub fn fits(linked: &BTreeSet<String>, episode: &EpisodeRecord) -> bool {
    let target = episode.target_id.as_ref();
    linked.is_empty() || target.is_none_or(|id| linked.contains(&id.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn episode(id: &str, target: Option<&str>) -> EpisodeRecord {
        let time = "2026-01-01T00:00:02Z";
        serde_json::from_value(json!({
            "episode_id": id, "scenario_id": "reactive_agent.cutin.urgent", "drive_id": "d", "clip_id": "d_000",
            "target_id": target, "time_range": {"start_timestamp": time, "end_timestamp": time},
            "keyframe": {"timestamp": time, "frame_idx": 20, "type": "reactive"}, "score": 0.7, "is_primary": true,
            "keyframe_rule": {"zh": "", "en": ""}, "conditions_matched": [], "signals": [],
        }))
        .unwrap()
    }

    /// docs/reference/release.md, *Samples*: null is unknown.
    #[test]
    fn only_a_mined_episode_has_a_score() {
        let of = |id: &str| score(&episode(id, None));
        assert_eq!(of("d_000_reactive_agent.cutin.urgent_car7_020"), Some(0.7));
        assert_eq!(of("d_000_reactive_agent.cutin.urgent_car7_020~copy"), Some(0.7));
        assert_eq!(of("label-0123456789abcdef0123"), None);
        assert_eq!(of("d_000_reactive_agent.cutin.slow_car7_020^reactive_agent.cutin.urgent"), None);
    }

    #[test]
    fn a_label_fits_the_episode_whose_target_it_links() {
        let of = |label: Value, target| fits(&linked(&label), &episode("e", target));
        let one =
            |object| json!({"critical_components": [{"linked_objects": [object]}, {"description": "x"}]});
        assert!(of(one("car7"), Some("car7")) && of(one("car7"), None) && of(json!({}), Some("car7")));
        assert!(!of(one("car8"), Some("car7")));
    }
}
