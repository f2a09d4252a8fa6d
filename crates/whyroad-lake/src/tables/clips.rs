//! `clips.parquet`: clip metadata (DATA_FORMAT.md 3.1), one row per clip, the nested fields as a struct of the
//! same names.

use crate::LakeError;
use crate::columns::{Table, TableBuilder};
use whyroad_model::Nanos;
use whyroad_model::messages::clip::ClipMetadata;

pub(crate) const ROW_ORDER: &str = "clip";

pub(crate) fn to_table(clips: &[ClipMetadata]) -> TableBuilder {
    let sources = TableBuilder::default()
        .text_lists("video", clips.iter().map(|c| c.data_sources.video.as_slice()))
        .text_lists("sensor", clips.iter().map(|c| c.data_sources.sensor.as_slice()))
        .flags("can", clips.iter().map(|c| Some(c.data_sources.can)))
        .flags("map", clips.iter().map(|c| Some(c.data_sources.map)));
    TableBuilder::default()
        .texts("clip_id", clips.iter().map(|c| &c.clip_id))
        .texts("source", clips.iter().map(|c| &c.source))
        .texts("capture_time", clips.iter().map(|c| c.capture_time.to_string()))
        .integers("capture_time_ns", clips.iter().map(|c| c.capture_time.0))
        .numbers("duration_sec", clips.iter().map(|c| c.duration_sec))
        .numbers("frame_rate", clips.iter().map(|c| c.frame_rate))
        .indices("total_frames", clips.iter().map(|c| c.total_frames))
        .group("data_sources", sources)
        .texts_or_null("drive_id", clips.iter().map(|c| c.drive_id.as_ref()))
        .texts_or_null("place", clips.iter().map(|c| c.place.as_ref()))
        .texts_or_null("map_ref", clips.iter().map(|c| c.map_ref.as_ref()))
        .texts_or_null("licence", clips.iter().map(|c| c.licence.as_ref()))
}

/// Id, start and number of frames of each clip: what a listing needs.
pub(crate) fn summaries(t: &Table) -> Result<Vec<(String, Nanos, u32)>, LakeError> {
    let ids = t.texts("clip_id")?;
    let starts = t.integers("capture_time_ns")?;
    let frames = t.indices("total_frames")?;
    Ok(ids
        .iter()
        .flatten()
        .zip(starts)
        .zip(frames)
        .map(|((id, s), n)| (id.to_owned(), Nanos(s), n))
        .collect())
}
