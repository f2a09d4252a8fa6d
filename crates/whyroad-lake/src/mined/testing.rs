//! Episodes for the tests of this module.

use whyroad_model::messages::EpisodeRecord;

/// The `index`-th episode of a drive; every third is secondary, and classes alternate.
pub(super) fn record(drive: &str, index: usize) -> EpisodeRecord {
    let leaf =
        if index.is_multiple_of(2) { "reactive_agent.cutin.urgent" } else { "reactive_agent.cutout.slow" };
    let second = index % 60;
    let time = format!("2026-01-01T{:02}:{:02}:{second:02}.000Z", index / 3600 % 24, index / 60 % 60);
    serde_json::from_value(serde_json::json!({
        "episode_id": format!("{drive}_{index:06}"),
        "scenario_id": leaf,
        "drive_id": drive,
        "clip_id": format!("{drive}_000"),
        "time_range": {"start_timestamp": time, "end_timestamp": time},
        "keyframe": {"timestamp": time, "frame_idx": 3, "type": "reactive"},
        "score": (index % 10) as f64 / 10.0,
        "is_primary": !index.is_multiple_of(3),
        "keyframe_rule": {"zh": "车轮越线", "en": "a wheel crosses the line"},
        "conditions_matched": [],
        "signals": []
    }))
    .unwrap()
}
