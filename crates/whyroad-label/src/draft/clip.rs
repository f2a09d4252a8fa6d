//! An episode may extend beyond the clip that contains its keyframe; a label may not. The part outside is cut off.

use whyroad_model::messages::{EpisodeRecord, Keyframe, TimeRange};
use whyroad_model::scene::FRAME_RATE_HZ;
use whyroad_model::{Bilingual, Drive, Nanos};

/// Time range and keyframe inside the clip; a note if something was cut.
pub(super) fn inside(
    drive: &Drive,
    episode: &EpisodeRecord,
    notes: &mut Vec<Bilingual>,
) -> (TimeRange, Keyframe) {
    let (mut range, mut keyframe) = (episode.time_range.clone(), episode.keyframe.clone());
    let own = episode.clip_id.frames(&drive.meta.drive_id, &drive.times);
    let Some(frames) = own else { return (range, keyframe) };
    let first = drive.times[frames.start];
    // The last frame lasts one nominal frame period (as in clip_metadata's duration).
    let end = drive.times[frames.end - 1].plus_secs(1.0 / FRAME_RATE_HZ);

    let mut cut = false;
    let mut clamp = |t: &mut Nanos| {
        let inside = (*t).clamp(first, end);
        cut |= inside != *t;
        *t = inside;
    };
    clamp(&mut range.start_timestamp);
    clamp(&mut range.end_timestamp);
    keyframe.range_start.iter_mut().for_each(&mut clamp);
    keyframe.range_end.iter_mut().for_each(&mut clamp);
    if cut {
        notes.push(Bilingual::new(
            format!(
                "该片段超出剪辑范围（{} 至 {}），起止已截到剪辑边界",
                episode.time_range.start_timestamp, episode.time_range.end_timestamp
            ),
            format!(
                "the episode extends beyond the clip ({} to {}); the label ends at the clip's edge",
                episode.time_range.start_timestamp, episode.time_range.end_timestamp
            ),
        ));
    }
    (range, keyframe)
}
