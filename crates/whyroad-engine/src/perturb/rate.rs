//! A log at a lower rate, as ingest resamples it to the frames of the lake: linearly between its samples.

use whyroad_model::scene::Motion;
use whyroad_model::{Drive, Nanos};

/// Keeps the samples of every `every`-th frame and interpolates those between.
pub(super) fn lower(drive: &mut Drive, every: usize) {
    let times = drive.times.clone();
    let seconds = |frame: usize| times[frame].seconds_since(times[0]);
    if let Some(ego) = &mut drive.ego {
        let frames: Vec<u32> = (0..ego.motion.len() as u32).collect();
        interpolate(&mut ego.motion, &frames, every, &seconds);
        ego.known_at = known_at(&times, &frames, every);
    }
    for track in &mut drive.tracks {
        // Observations before the first or after the last sample are not in the log.
        let sampled = |f: &u32| (*f as usize).is_multiple_of(every);
        let first = track.frames.iter().copied().find(sampled);
        let last = track.frames.iter().copied().rev().find(sampled);
        let within = |f: u32| first.is_some_and(|a| f >= a) && last.is_some_and(|b| f <= b);
        let rows: Vec<usize> = (0..track.frames.len()).filter(|&r| within(track.frames[r])).collect();
        *track = super::rows_of(track, &rows);
        let frames = track.frames.clone();
        interpolate(&mut track.motion, &frames, every, &seconds);
        // Where a sample is missing, an object is absent.
        let there: Vec<usize> = (0..frames.len()).filter(|&r| track.motion.x[r].is_finite()).collect();
        *track = super::rows_of(track, &there);
        track.known_at = known_at(&times, &track.frames, every);
    }
    drive.tracks.retain(|t| !t.frames.is_empty());
}

/// When each row was known: with the sample after it.
fn known_at(times: &[Nanos], frames: &[u32], every: usize) -> Vec<Nanos> {
    let at = |f: usize| times.get(f.div_ceil(every) * every).unwrap_or(&times[f]);
    frames.iter().map(|f| *at(*f as usize)).collect()
}

/// Rows of frames between two samples are interpolated between them; where a sample is missing, they are unknown.
fn interpolate(m: &mut Motion, frames: &[u32], every: usize, seconds: &impl Fn(usize) -> f64) {
    let of_frame = |f: usize| frames.binary_search(&(f as u32)).ok();
    let given = m.clone();
    for (row, &frame) in frames.iter().enumerate() {
        let before = frame as usize / every * every;
        if before == frame as usize {
            continue;
        }
        let after = before + every;
        let (a, b) = (of_frame(before), of_frame(after));
        let between = |v: &[f64], angle: bool| {
            let (Some(a), Some(b)) = (a, b) else { return f64::NAN };
            let share = (seconds(frame as usize) - seconds(before)) / (seconds(after) - seconds(before));
            let step = if angle { super::wrapped(v[b] - v[a]) } else { v[b] - v[a] };
            v[a] + share * step
        };
        for (to, from) in [
            (&mut m.x, &given.x),
            (&mut m.y, &given.y),
            (&mut m.z, &given.z),
            (&mut m.vx, &given.vx),
            (&mut m.vy, &given.vy),
            (&mut m.accel, &given.accel),
            (&mut m.yaw_rate, &given.yaw_rate),
            (&mut m.forward, &given.forward),
        ] {
            if let Some(to) = to.get_mut(row) {
                *to = between(from, false);
            }
        }
        m.heading[row] = super::wrapped(between(&given.heading, true));
    }
}
