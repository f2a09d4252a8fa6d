//! The ego among the objects, as trackers and simulators write it: a track that stays at the ego's own center.

use super::{FIRST_FRAMES, warning};
use whyroad_model::Diagnostic;
use whyroad_model::scene::Drive;

/// The centers of two vehicles are never this near, m.
const SAME_M: f64 = 0.5;
/// Fewer common frames, of the first ones, are no evidence.
const LEAST: usize = 5;

/// Leaves such tracks out.
pub(super) fn drop(drive: &mut Drive) -> Option<Diagnostic> {
    let ego = &drive.ego.as_ref()?.motion;
    let mut out = Vec::new();
    drive.tracks.retain(|track| {
        if track.class.is_vru() {
            return true;
        }
        let rows = track.frames.iter().enumerate().take_while(|(_, f)| (**f as usize) < FIRST_FRAMES);
        let apart = rows.map(|(row, &f)| {
            let (m, f) = (&track.motion, f as usize);
            (m.x[row] - ego.x[f]).hypot(m.y[row] - ego.y[f])
        });
        let known: Vec<f64> = apart.filter(|d| d.is_finite()).collect();
        let is_ego = known.len() >= LEAST && known.iter().all(|d| *d <= SAME_M);
        if is_ego {
            out.push(track.id.to_string());
        }
        !is_ego
    });
    (!out.is_empty()).then(|| {
        let ids = out.join(", ");
        warning(
            "ingest.ego.among_objects",
            format!("轨迹 {ids} 始终位于自车中心：即自车本身，已去掉"),
            format!("track {ids} stays at the ego's own center: it is the ego, and is left out"),
        )
    })
}
