//! A drive as it was at a moment: nothing in it is from later.

use whyroad_model::scene::{DriveMeta, Ego, EgoBus, Motion, Track};
use whyroad_model::{Drive, Nanos};

/// `drive` up to and with `until`. Tracks that were not seen by then are not in it.
pub fn cut(drive: &Drive, until: Nanos) -> Drive {
    let n = drive.times.partition_point(|t| *t <= until);
    Drive {
        // The hash of the content and the list of what is missing speak of the whole drive.
        meta: DriveMeta { content_hash: String::new(), missing: vec![], ..drive.meta.clone() },
        times: drive.times[..n].to_vec(),
        ego: drive.ego.as_ref().map(|e| Ego { motion: motion(&e.motion, n), bus: bus(&e.bus, n), ..*e }),
        tracks: drive.tracks.iter().filter_map(|t| track(t, n)).collect(),
        map: drive.map.clone(),
        lights: drive.lights.as_ref().map(|l| l.iter().filter(|s| s.time <= until).cloned().collect()),
        context: drive.context.as_ref().map(|c| c.iter().filter(|s| s.time <= until).cloned().collect()),
        media: drive.media.as_ref().map(|m| m.iter().filter(|f| f.time <= until).cloned().collect()),
    }
}

/// The first `n`; of what the log has not, nothing.
fn first<T: Clone>(values: &[T], n: usize) -> Vec<T> {
    values[..n.min(values.len())].to_vec()
}

fn motion(m: &Motion, n: usize) -> Motion {
    Motion {
        x: first(&m.x, n),
        y: first(&m.y, n),
        z: first(&m.z, n),
        heading: first(&m.heading, n),
        vx: first(&m.vx, n),
        vy: first(&m.vy, n),
        accel: first(&m.accel, n),
        yaw_rate: first(&m.yaw_rate, n),
    }
}

fn bus(b: &EgoBus, n: usize) -> EgoBus {
    EgoBus {
        speed_mps: first(&b.speed_mps, n),
        steering: first(&b.steering, n),
        brake: first(&b.brake, n),
        throttle: first(&b.throttle, n),
        gear: first(&b.gear, n),
        turn_signal: first(&b.turn_signal, n),
        aeb: first(&b.aeb, n),
        cruise: first(&b.cruise, n),
        route_command: first(&b.route_command, n),
    }
}

fn track(t: &Track, n: usize) -> Option<Track> {
    let rows = t.frames.partition_point(|f| (*f as usize) < n);
    (rows > 0).then(|| Track {
        id: t.id.clone(),
        class: t.class,
        source_class: t.source_class.clone(),
        frames: first(&t.frames, rows),
        motion: motion(&t.motion, rows),
        length_m: first(&t.length_m, rows),
        width_m: first(&t.width_m, rows),
        height_m: first(&t.height_m, rows),
        interior_points: first(&t.interior_points, rows),
        turn_signal: first(&t.turn_signal, rows),
        visible_share: first(&t.visible_share, rows),
        occluder: first(&t.occluder, rows),
    })
}
