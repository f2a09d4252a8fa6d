//! One line of an import: an episode as `whyroad mine` writes it, a task as the export writes it, or a label.

use crate::secret;
use crate::service::copies;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use whyroad_label::episode_of::{self, MADE};
use whyroad_label::merge::{self, MAX_DRAFT};
use whyroad_model::label_fields::name;
use whyroad_model::messages::{CocLabel, EpisodeRecord};
use whyroad_model::{Bilingual, ClipId, ScenarioId};

/// A task to create.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Incoming {
    /// Its episode.
    pub episode: EpisodeRecord,
    /// The episode was made from the label: whether it is a known one is still to be seen.
    pub is_made: bool,
    /// Its initial draft; `None` for the rule's draft.
    pub draft: Option<Value>,
    /// Higher values come first.
    pub priority: i64,
    /// Number in its overlap group, and the group's size.
    pub overlap: (i64, i64),
}

/// Reads a line; an error text if that fails.
pub(super) fn read_line(line: &str) -> Result<Incoming, Bilingual> {
    if line.len() > 16 * MAX_DRAFT {
        return Err(Bilingual::new("该行过长", "the line is too long"));
    }
    let value: Value = serde_json::from_str(line).map_err(|e| {
        Bilingual::new(format!("不是 JSON：第 {} 列有误", e.column()), format!("not JSON: {e}"))
    })?;
    if value.get("task").is_some() {
        return of_task(&value["task"]);
    }
    if value.get("episode_id").is_some() {
        let episode = serde_json::from_value(value)
            .map_err(|e| Bilingual::new(format!("不是事件：{e}"), format!("not an episode: {e}")))?;
        return Ok(Incoming { episode, is_made: false, draft: None, priority: 0, overlap: (0, 1) });
    }
    if value.get(name::CLIP_ID).is_some() {
        return of_label(&value);
    }
    Err(Bilingual::new("既不是任务、事件，也不是标注", "neither a task, an episode nor a label"))
}

fn of_task(task: &Value) -> Result<Incoming, Bilingual> {
    let episode = episode_of::of_task(&task["episode"])
        .map_err(|e| Bilingual::new(format!("任务的事件：{e}"), format!("its episode: {e}")))?;
    let number = |name: &str, default: i64| task[name].as_i64().unwrap_or(default);
    let draft = task["draft"].as_object().map(|d| Value::Object(d.clone()));
    draft.as_ref().map_or(Ok(()), merge::bounded).map_err(|e| e.text())?;
    let count = number("overlap_count", 1).clamp(1, 10);
    let index = number("overlap_index", 0).clamp(0, count - 1);
    let is_made = episode_of::is_made(&episode.episode_id)
        && copies::mined_of(&episode.episode_id) == episode.episode_id;
    Ok(Incoming { episode, is_made, draft, priority: number("priority", 0), overlap: (index, count) })
}

/// A label has no episode: one is made from its content. Its id is the same for every label of the same moment, class
/// and objects, whatever the language of its text. Its score is not known ([`episode_of::score`]).
fn of_label(value: &Value) -> Result<Incoming, Bilingual> {
    merge::bounded(value).map_err(|e| e.text())?;
    let label: CocLabel = serde_json::from_value(value.clone())
        .map_err(|e| Bilingual::new(format!("不是标注：{e}"), format!("not a label: {e}")))?;
    let Some(drive) = ClipId(label.clip_id.clone()).drive() else {
        return Err(Bilingual::new(
            format!("无法从 clip '{}' 得知行程", label.clip_id),
            format!("the drive cannot be determined from clip '{}'", label.clip_id),
        ));
    };
    let scenario_id = ScenarioId {
        l1: label.scenario.l1.clone(),
        l2: Some(label.scenario.l2.clone()),
        l3: label.scenario.l3.clone(),
    };
    let objects = episode_of::linked(value).into_iter().collect::<Vec<_>>();
    let same = json!([drive, scenario_id, label.keyframe.timestamp.0, objects]).to_string();
    let episode = EpisodeRecord {
        episode_id: format!("{MADE}{}", &secret::hash(&same)[..20]),
        scenario_id,
        drive_id: drive,
        clip_id: ClipId(label.clip_id.clone()),
        target_id: None,
        roles: BTreeMap::new(),
        time_range: label.time_range.clone(),
        keyframe: label.keyframe.clone(),
        second_keyframe: label.second_keyframe.clone(),
        // A number is required; nobody reads it.
        score: 1.0,
        is_primary: true,
        primary_episode_id: None,
        ego_response: None,
        margin_score: None,
        calibrated: None,
        keyframe_rule: Bilingual::new("取自导入的标注", "taken from an imported label"),
        conditions_matched: vec![],
        signals: vec![],
        rule_version: None,
    };
    Ok(Incoming { episode, is_made: true, draft: Some(value.clone()), priority: 0, overlap: (0, 1) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn label() -> Value {
        json!({
            "version": "2.1.0", "clip_id": "drive_a_002",
            "scenario": {"l1": "reactive_agent", "l2": "cutin", "l3": "normal"},
            "time_range": {"start_timestamp": "2026-01-01T00:00:01.000Z", "end_timestamp": "2026-01-01T00:00:05.000Z"},
            "keyframe": {"timestamp": "2026-01-01T00:00:02.000Z", "frame_idx": 10, "type": "reactive"},
            "driving_decision": {"longitudinal": null, "lateral": null},
            "critical_components": [], "coc_trace": "t",
        })
    }

    #[test]
    fn a_label_tells_its_drive_and_class_and_keeps_its_id() {
        let read = read_line(&label().to_string()).unwrap();
        assert_eq!(read.episode.drive_id.as_str(), "drive_a");
        assert_eq!(read.episode.scenario_id.to_string(), "reactive_agent.cutin.normal");
        assert_eq!(read.episode.keyframe.frame_idx, 10);
        assert_eq!(read.draft, Some(label()));
        assert_eq!(read, read_line(&label().to_string()).unwrap());
    }

    /// `whyroad draft --lang zh` and `--lang en` write drafts of the same episodes.
    #[test]
    fn labels_of_one_moment_class_and_object_are_of_one_episode() {
        let id = |object: &str, trace: &str, class: &str| {
            let mut label = label();
            label["coc_trace"] = json!(trace);
            label["scenario"]["l3"] = json!(class);
            label["critical_components"] = json!([{"description": trace, "linked_objects": [object]}]);
            read_line(&label.to_string()).unwrap().episode.episode_id
        };
        let zh = id("car7", "前车切入", "normal");
        assert_eq!(zh, id("car7", "A car cuts in", "normal"));
        assert_ne!(zh, id("car8", "前车切入", "normal"));
        assert_ne!(zh, id("car7", "前车切入", "urgent"));
    }

    #[test]
    fn what_is_none_of_the_three_is_refused_in_words() {
        for (line, why) in [
            ("{", "not JSON"),
            ("[1]", "neither"),
            (r#"{"clip_id": "x"}"#, "not a label"),
            (r#"{"episode_id": 1}"#, "not an episode"),
            (r#"{"task": {}}"#, "episode"),
        ] {
            let error = read_line(line).unwrap_err().en;
            assert!(error.contains(why), "{line}: {error}");
        }
        let mut odd = label();
        odd["clip_id"] = json!("nodrive");
        assert!(read_line(&odd.to_string()).unwrap_err().en.contains("drive cannot be determined"));
    }
}
