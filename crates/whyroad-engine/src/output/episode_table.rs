//! `episodes.parquet`: one row an episode, for engines and notebooks. Schema version 1:
//!
//! | column | type | |
//! |---|---|---|
//! | episode_id | utf8 | `<clip>_<class>_<target or ego>_<frame>` |
//! | scenario_id | utf8 | leaf, or L2 where the variant is not known |
//! | drive_id, clip_id | utf8 | the clip is the one that the keyframe is in |
//! | target_id | utf8, null | null for rules about the ego alone |
//! | start_ns, keyframe_ns, end_ns | int64 | since the Unix epoch; the time range is half open and may reach beyond the clip |
//! | start_frame_idx, keyframe_frame_idx, end_frame_idx | int32 | in the clip, from 0, clamped to it; half open |
//! | score | double | 0 to 1 |
//! | is_primary | bool | arbitration made it the primary trigger at its keyframe |
//! | primary_episode_id | utf8, null | the episode that it is secondary to |
//!
//! Rows are in the order of drive, keyframe, class, target. Only `target_id` and `primary_episode_id` are nullable.

use super::record::MinedEpisode;
use arrow_array::{ArrayRef, BooleanArray, Float64Array, Int32Array, Int64Array, RecordBatch, StringArray};
use arrow_schema::{ArrowError, DataType, Field, Schema};
use std::sync::Arc;

/// Version of the schema, in the file's metadata under `whyroad.episodes_version`.
pub const EPISODES_VERSION: u32 = 1;

/// The table of these episodes.
pub fn episode_batch(episodes: &[&MinedEpisode]) -> Result<RecordBatch, ArrowError> {
    let records: Vec<_> = episodes.iter().map(|e| &e.record).collect();
    let texts = |of: &dyn Fn(usize) -> String| -> ArrayRef {
        Arc::new(StringArray::from_iter_values((0..records.len()).map(of)))
    };
    let maybe = |of: &dyn Fn(usize) -> Option<String>| -> ArrayRef {
        Arc::new((0..records.len()).map(of).collect::<StringArray>())
    };
    let times = |of: &dyn Fn(usize) -> i64| -> ArrayRef {
        Arc::new(Int64Array::from_iter_values((0..records.len()).map(of)))
    };
    let frames = |of: &dyn Fn(usize) -> u32| -> ArrayRef {
        let value = |i| i32::try_from(of(i)).unwrap_or(i32::MAX);
        Arc::new(Int32Array::from_iter_values((0..records.len()).map(value)))
    };
    let score: ArrayRef = Arc::new(Float64Array::from_iter_values(records.iter().map(|r| r.score)));
    let primary: ArrayRef = Arc::new(records.iter().map(|r| Some(r.is_primary)).collect::<BooleanArray>());
    let columns: Vec<(&str, DataType, bool, ArrayRef)> = vec![
        ("episode_id", DataType::Utf8, false, texts(&|i| records[i].episode_id.clone())),
        ("scenario_id", DataType::Utf8, false, texts(&|i| records[i].scenario_id.to_string())),
        ("drive_id", DataType::Utf8, false, texts(&|i| records[i].drive_id.to_string())),
        ("clip_id", DataType::Utf8, false, texts(&|i| records[i].clip_id.to_string())),
        (
            "target_id",
            DataType::Utf8,
            true,
            maybe(&|i| records[i].target_id.as_ref().map(ToString::to_string)),
        ),
        ("start_ns", DataType::Int64, false, times(&|i| records[i].time_range.start_timestamp.0)),
        ("keyframe_ns", DataType::Int64, false, times(&|i| records[i].keyframe.timestamp.0)),
        ("end_ns", DataType::Int64, false, times(&|i| records[i].time_range.end_timestamp.0)),
        (
            "start_frame_idx",
            DataType::Int32,
            false,
            frames(&|i| records[i].time_range.start_frame_idx.unwrap_or_default()),
        ),
        ("keyframe_frame_idx", DataType::Int32, false, frames(&|i| records[i].keyframe.frame_idx)),
        (
            "end_frame_idx",
            DataType::Int32,
            false,
            frames(&|i| records[i].time_range.end_frame_idx.unwrap_or_default()),
        ),
        ("score", DataType::Float64, false, score),
        ("is_primary", DataType::Boolean, false, primary),
        ("primary_episode_id", DataType::Utf8, true, maybe(&|i| records[i].primary_episode_id.clone())),
    ];
    let fields: Vec<Field> = columns.iter().map(|(n, t, null, _)| Field::new(*n, t.clone(), *null)).collect();
    let arrays = columns.into_iter().map(|(.., a)| a).collect();
    RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::record::write_down;
    use arrow_array::Array;
    use whyroad_mining::{Episode, Rank};
    use whyroad_model::messages::KeyframeType;
    use whyroad_model::{Bilingual, FrameRange, Lang, Nanos};

    /// One episode in the second clip of a drive, whose time range begins in the first.
    fn mined(target: Option<&str>) -> MinedEpisode {
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
            score: 0.75,
            conditions: vec![],
            signals: vec![],
            rank: Rank::Primary,
        };
        let times: Vec<Nanos> = (0..250).map(|i| Nanos(i * 100_000_000)).collect();
        let clips = [FrameRange::new(0, 200), FrameRange::new(200, 250)];
        write_down(&[episode], &"d".into(), &times, &clips, Lang::En).remove(0)
    }

    #[test]
    fn columns_are_those_that_issue_2_names() {
        let (a, b) = (mined(Some("t")), mined(None));
        let batch = episode_batch(&[&a, &b]).unwrap();
        let told: Vec<String> = batch
            .schema()
            .fields()
            .iter()
            .map(|f| format!("{} {}{}", f.name(), f.data_type(), if f.is_nullable() { "?" } else { "" }))
            .collect();
        let expected = "episode_id Utf8, scenario_id Utf8, drive_id Utf8, clip_id Utf8, target_id Utf8?, \
             start_ns Int64, keyframe_ns Int64, end_ns Int64, start_frame_idx Int32, keyframe_frame_idx Int32, \
             end_frame_idx Int32, score Float64, is_primary Boolean, primary_episode_id Utf8?";
        assert_eq!(told.join(", "), expected);
        assert!(batch.column(4).is_valid(0) && batch.column(4).is_null(1));
    }

    #[test]
    fn frames_are_those_of_the_clip_and_times_those_of_the_drive() {
        let record = mined(None).record;
        assert_eq!(record.clip_id.as_str(), "d_001");
        assert_eq!(record.episode_id, "d_001_reactive_agent.cutin.urgent_ego_010");
        // Frame 190 of the drive is in the clip before: clamped to 0. Frame 240 is frame 40 of the clip.
        assert_eq!((record.time_range.start_frame_idx, record.time_range.end_frame_idx), (Some(0), Some(40)));
        assert_eq!(record.time_range.start_timestamp, Nanos(19_000_000_000));
        assert_eq!(record.time_range.end_timestamp, Nanos(24_000_000_000));
        // What a labeller is shown is clamped in time too; 50 frames are the whole second clip.
        let context = mined(None).suggestion.context_range;
        assert_eq!(
            (context.start_timestamp, context.end_timestamp),
            (Nanos(20_000_000_000), Nanos(25_000_000_000))
        );
        assert_eq!((context.start_frame_idx, context.end_frame_idx), (Some(0), Some(50)));
    }
}
