//! Clip metadata (DATA_FORMAT.md 3.1) of a drive's clips. Pure: all of it follows from the drive.

use whyroad_model::messages::clip::{ClipMetadata, DataSources};
use whyroad_model::scene::{DriveMeta, FRAME_RATE_HZ};
use whyroad_model::{ClipId, Drive, FrameRange, Nanos, division};

/// One entry per clip, in the order of time, without pre-labels (those are mining's).
///
/// A clip's length reaches from its first frame to one nominal frame period after its last, so 200 frames
/// at exactly 10 Hz are 20.0 s and the last frame's time lies inside. Rounded to 1 ms.
pub fn clip_metadata(drive: &Drive) -> Vec<ClipMetadata> {
    let meta = &drive.meta;
    let sources = DataSources {
        video: meta.video.clone(),
        sensor: meta.sensors.clone(),
        can: meta.can,
        map: drive.map.is_some(),
    };
    metadata(meta, &drive.times, &sources)
}

/// The same from what is known of a drive without its tables.
pub(crate) fn metadata(meta: &DriveMeta, times: &[Nanos], sources: &DataSources) -> Vec<ClipMetadata> {
    division(times)
        .into_iter()
        .enumerate()
        .map(|(index, frames)| {
            let any = ClipMetadata {
                clip_id: String::new(),
                source: meta.source.clone(),
                capture_time: Nanos::default(),
                duration_sec: 0.0,
                frame_rate: FRAME_RATE_HZ,
                total_frames: 0,
                data_sources: sources.clone(),
                pre_labels: None,
                drive_id: Some(meta.drive_id.0.clone()),
                place: meta.place.clone(),
                map_ref: meta.map_ref.clone(),
                licence: meta.licence.clone(),
            };
            cut_clip(&any, times, &ClipId::of(&meta.drive_id, index), frames)
        })
        .collect()
}

/// A clip of these frames, which are not empty, of the drive that `any` is a clip of; without pre-labels.
pub fn cut_clip(any: &ClipMetadata, times: &[Nanos], id: &ClipId, frames: FrameRange) -> ClipMetadata {
    let (first, last) = (times[frames.start], times[frames.end - 1]);
    let duration_s = last.seconds_since(first) + 1.0 / FRAME_RATE_HZ;
    ClipMetadata {
        clip_id: id.0.clone(),
        capture_time: first,
        duration_sec: (duration_s * 1e3).round() / 1e3,
        total_frames: u32::try_from(frames.len()).unwrap_or(u32::MAX),
        pre_labels: None,
        ..any.clone()
    }
}
