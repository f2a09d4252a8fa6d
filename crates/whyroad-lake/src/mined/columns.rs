//! `episodes.parquet`: one row per episode, for engines and notebooks, and the index of `episodes.jsonl`. Version 2:
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
//! | ego_response | utf8, null | observed, absent or unknown: whether the ego answered the trigger |
//! | margin_score | double, null | how far the conditions are exceeded, 0.5 to 1 |
//! | calibrated | bool, null | the score is the share of such episodes that is right; else it is the margin score |
//! | line_start, line_bytes | int64 | where the episode's line is in `episodes.jsonl` |
//!
//! Rows are in the order of drive, keyframe, class, target. Only `target_id`, `primary_episode_id`,
//! `ego_response`, `margin_score` and `calibrated` are nullable.

use super::LineSpan;
use arrow_array::{ArrayRef, BooleanArray, Float64Array, Int32Array, Int64Array, RecordBatch, StringArray};
use arrow_schema::{ArrowError, DataType, Field, Schema};
use std::sync::Arc;
use whyroad_model::messages::EpisodeRecord;

/// Version of the schema, in the file's metadata under [`VERSION_KEY`]. Version 1 had no `line_start` and `line_bytes`.
pub const EPISODES_VERSION: u32 = 2;
/// Where the file's metadata state the version.
pub(super) const VERSION_KEY: &str = "whyroad.episodes_version";

pub(super) const EPISODE_ID: &str = "episode_id";
pub(super) const SCENARIO_ID: &str = "scenario_id";
pub(super) const DRIVE_ID: &str = "drive_id";
pub(super) const SCORE: &str = "score";
pub(super) const IS_PRIMARY: &str = "is_primary";
pub(super) const LINE_START: &str = "line_start";
pub(super) const LINE_BYTES: &str = "line_bytes";

/// A column: name, type, nullable, values.
type EpisodeColumn = (&'static str, DataType, bool, ArrayRef);

/// The table of these episodes, with the positions of their lines.
pub(super) fn episode_batch(rows: &[(EpisodeRecord, LineSpan)]) -> Result<RecordBatch, ArrowError> {
    let records: Vec<&EpisodeRecord> = rows.iter().map(|(r, _)| r).collect();
    let lines = |of: &dyn Fn(&LineSpan) -> Option<i64>| -> ArrayRef {
        Arc::new(Int64Array::from_iter_values(rows.iter().map(|(_, l)| of(l).unwrap_or(i64::MAX))))
    };
    let mut columns = record_columns(&records);
    columns.push((LINE_START, DataType::Int64, false, lines(&|l| i64::try_from(l.start).ok())));
    columns.push((LINE_BYTES, DataType::Int64, false, lines(&|l| i64::try_from(l.len).ok())));
    batch(columns)
}

/// The table of these episodes, as in `episodes.parquet` but without the positions of lines, which do not exist in
/// memory.
///
/// # Errors
/// Never for records whose columns fit into memory.
pub fn episode_table(records: &[&EpisodeRecord]) -> Result<RecordBatch, ArrowError> {
    batch(record_columns(records))
}

fn record_columns(rows: &[&EpisodeRecord]) -> Vec<EpisodeColumn> {
    use DataType::{Boolean, Float64, Int32, Int64, Utf8};
    let texts = |of: &dyn Fn(&EpisodeRecord) -> String| -> ArrayRef {
        Arc::new(StringArray::from_iter_values(rows.iter().map(|r| of(r))))
    };
    let maybe = |of: &dyn Fn(&EpisodeRecord) -> Option<String>| -> ArrayRef {
        Arc::new(rows.iter().map(|r| of(r)).collect::<StringArray>())
    };
    let times = |of: &dyn Fn(&EpisodeRecord) -> i64| -> ArrayRef {
        Arc::new(Int64Array::from_iter_values(rows.iter().map(|r| of(r))))
    };
    let frames = |of: &dyn Fn(&EpisodeRecord) -> u32| -> ArrayRef {
        let value = |r: &EpisodeRecord| i32::try_from(of(r)).unwrap_or(i32::MAX);
        Arc::new(Int32Array::from_iter_values(rows.iter().map(|r| value(r))))
    };
    let scores: ArrayRef = Arc::new(Float64Array::from_iter_values(rows.iter().map(|r| r.score)));
    let primary: ArrayRef = Arc::new(rows.iter().map(|r| Some(r.is_primary)).collect::<BooleanArray>());
    let margins: ArrayRef = Arc::new(rows.iter().map(|r| r.margin_score).collect::<Float64Array>());
    let calibrated: ArrayRef = Arc::new(rows.iter().map(|r| r.calibrated).collect::<BooleanArray>());
    let start_frame = |r: &EpisodeRecord| r.time_range.start_frame_idx.unwrap_or_default();
    let end_frame = |r: &EpisodeRecord| r.time_range.end_frame_idx.unwrap_or_default();
    vec![
        (EPISODE_ID, Utf8, false, texts(&|r| r.episode_id.clone())),
        (SCENARIO_ID, Utf8, false, texts(&|r| r.scenario_id.to_string())),
        (DRIVE_ID, Utf8, false, texts(&|r| r.drive_id.to_string())),
        ("clip_id", Utf8, false, texts(&|r| r.clip_id.to_string())),
        ("target_id", Utf8, true, maybe(&|r| r.target_id.as_ref().map(ToString::to_string))),
        ("start_ns", Int64, false, times(&|r| r.time_range.start_timestamp.0)),
        ("keyframe_ns", Int64, false, times(&|r| r.keyframe.timestamp.0)),
        ("end_ns", Int64, false, times(&|r| r.time_range.end_timestamp.0)),
        ("start_frame_idx", Int32, false, frames(&start_frame)),
        ("keyframe_frame_idx", Int32, false, frames(&|r| r.keyframe.frame_idx)),
        ("end_frame_idx", Int32, false, frames(&end_frame)),
        (SCORE, Float64, false, scores),
        (IS_PRIMARY, Boolean, false, primary),
        ("primary_episode_id", Utf8, true, maybe(&|r| r.primary_episode_id.clone())),
        ("ego_response", Utf8, true, maybe(&|r| r.ego_response.map(|e| e.name().to_owned()))),
        ("margin_score", Float64, true, margins),
        ("calibrated", Boolean, true, calibrated),
    ]
}

fn batch(columns: Vec<EpisodeColumn>) -> Result<RecordBatch, ArrowError> {
    let fields: Vec<Field> = columns.iter().map(|(n, t, null, _)| Field::new(*n, t.clone(), *null)).collect();
    let arrays = columns.into_iter().map(|(.., a)| a).collect();
    RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mined::testing::record;
    use arrow_array::Array;

    #[test]
    fn columns_are_those_that_the_documentation_names() {
        let (mut a, b) = (record("d", 0), record("d", 1));
        a.target_id = Some("t".into());
        let span = LineSpan { start: 7, len: 9 };
        let batch = episode_batch(&[(a, span), (b, LineSpan::default())]).unwrap();
        let named: Vec<String> = batch
            .schema()
            .fields()
            .iter()
            .map(|f| format!("{} {}{}", f.name(), f.data_type(), if f.is_nullable() { "?" } else { "" }))
            .collect();
        let expected = "episode_id Utf8, scenario_id Utf8, drive_id Utf8, clip_id Utf8, target_id Utf8?, \
             start_ns Int64, keyframe_ns Int64, end_ns Int64, start_frame_idx Int32, keyframe_frame_idx Int32, \
             end_frame_idx Int32, score Float64, is_primary Boolean, primary_episode_id Utf8?, ego_response Utf8?, \
             margin_score Float64?, calibrated Boolean?, line_start Int64, line_bytes Int64";
        assert_eq!(named.join(", "), expected);
        assert!(batch.column(4).is_valid(0) && batch.column(4).is_null(1));
    }
}
