//! Times of camera frames. The videos stay where they are: a frame is named by archive, member and frame number.

use super::findings;
use super::tree::{Clip, Tree};
use crate::encodings::columns::read_parquet_bytes;
use crate::report::SourceReport;
use crate::source::ContentHash;
use whyroad_model::Nanos;
use whyroad_model::scene::MediaFrame;

/// The clip's camera frames, by camera, then time. `start` is the clip's time 0.
pub(super) fn frames(
    tree: &mut Tree,
    clip: &Clip,
    start: Nanos,
    hash: &mut ContentHash,
    report: &mut SourceReport,
) -> Vec<MediaFrame> {
    let cameras: Vec<String> = tree.features.keys().filter(|f| f.starts_with("camera_")).cloned().collect();
    let mut out = Vec::new();
    for camera in cameras {
        let Some(member) = tree.member(&camera, "frame_timestamps", clip) else { continue };
        let read = member.content.and_then(|content| {
            let Some(content) = content else { return Ok(Vec::new()) };
            hash.add(&member.uri, &content);
            read_parquet_bytes(content)?.integers("timestamp")
        });
        let times = match read {
            Ok(times) => times,
            Err(reason) => {
                report.diagnostics.push(findings::camera(&report.source, &member.uri, &reason));
                continue;
            }
        };
        if times.is_empty() {
            continue;
        }
        let Some(uri) = tree.member_uri(&camera, "video", clip) else {
            report.diagnostics.push(findings::camera(
                &report.source,
                &camera,
                "the archive has no video of it",
            ));
            continue;
        };
        let mut frames: Vec<MediaFrame> = (0u32..)
            .zip(&times)
            .filter_map(|(index, time)| {
                let time = Nanos(time.as_ref()?.checked_mul(1000)?.checked_add(start.0)?);
                Some(MediaFrame { camera: camera.clone(), time, uri: uri.clone(), index })
            })
            .collect();
        frames.sort_by_key(|f| f.time);
        out.extend(frames);
    }
    out
}
