//! Conditions that a drive must fulfill before it may be written. Readers rely on them without checking again.

use whyroad_model::Drive;
use whyroad_model::scene::{Motion, Track};

/// Description of the first broken condition.
pub(crate) fn broken_promise(drive: &Drive) -> Option<String> {
    if !drive.meta.drive_id.is_folder_safe() {
        return Some(
            "the id is not safe as a folder name (letters, digits, '-', '_', '.'; at most 128; not starting with '.')".into(),
        );
    }
    let frames = drive.times.len();
    if frames == 0 {
        return Some("it has no frame".into());
    }
    if let Some(i) = drive.times.windows(2).position(|w| w[0] >= w[1]) {
        return Some(format!("frame {} is not later than the frame before it", i + 1));
    }
    if let Some(ego) = &drive.ego {
        let bus = &ego.bus;
        let bus_ok = [
            bus.speed_mps.len(),
            bus.steering.len(),
            bus.brake.len(),
            bus.throttle.len(),
            bus.gear.len(),
            bus.turn_signal.len(),
            bus.aeb.len(),
            bus.cruise.len(),
            bus.wipers.len(),
            bus.vertical_accel.len(),
            bus.route_command.len(),
        ]
        .iter()
        .all(|&n| n == 0 || n == frames);
        let known_at_ok = ego.known_at.is_empty() || ego.known_at.len() == frames;
        if !motion_has_len(&ego.motion, frames) || !bus_ok || !known_at_ok {
            return Some("the ego's columns differ in length from the frames".into());
        }
    }
    if let Some(w) = drive.tracks.windows(2).find(|w| w[0].id >= w[1].id) {
        return Some(format!("track '{}' is not ordered after '{}'", w[1].id, w[0].id));
    }
    drive.tracks.iter().find_map(|t| broken_track(t, frames))
}

fn broken_track(t: &Track, frames: usize) -> Option<String> {
    let n = t.frames.len();
    if n == 0 {
        return Some(format!("track '{}' has no row", t.id));
    }
    if t.frames.windows(2).any(|w| w[0] >= w[1]) || t.frames[n - 1] as usize >= frames {
        return Some(format!("track '{}' has frames out of order or beyond the drive", t.id));
    }
    let columns_ok = [&t.length_m, &t.width_m, &t.height_m, &t.interior_points].iter().all(|c| c.len() == n)
        && [t.turn_signal.len(), t.visible_share.len(), t.occluder.len(), t.known_at.len()]
            .iter()
            .all(|&m| m == 0 || m == n)
        && t.class_changes.windows(2).all(|w| w[0].row < w[1].row)
        && t.class_changes.first().is_none_or(|c| c.row == 0)
        && motion_has_len(&t.motion, n);
    (!columns_ok).then(|| format!("track '{}' has columns of unequal length", t.id))
}

fn motion_has_len(m: &Motion, n: usize) -> bool {
    [&m.x, &m.y, &m.z, &m.heading, &m.vx, &m.vy, &m.accel, &m.yaw_rate].iter().all(|c| c.len() == n)
        && (m.forward.is_empty() || m.forward.len() == n)
}
