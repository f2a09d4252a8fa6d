//! What a sensor on the ego would have seen: a range, and line of sight past other vehicles.
//!
//! Sight lines run in the plane from the centre of the ego's box to a target's outline, [`SIGHT_LINES`] of them evenly
//! over the angle under which it is seen; one that meets another motor vehicle's box first is blocked. Heights play no
//! part: a car hides a lorry behind it. Buildings are not in a log of SUMO. A row that no line reaches is taken out of the track.

use whyroad_model::scene::{Ego, Track};

/// Sight lines a target.
pub const SIGHT_LINES: usize = 100;

/// How the ego senses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensing {
    /// Objects whose box centre is farther than this from the ego's are not in the log, m.
    pub range_m: Option<f64>,
    /// Whether vehicles hide what is behind them.
    pub occlusion: Occlusion,
}

/// Whether vehicles hide what is behind them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Occlusion {
    /// All is seen.
    #[default]
    Ignored,
    /// By the boxes of motor vehicles.
    ByBoxes,
}

/// Rows taken out of tracks, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Unseen {
    pub out_of_range: usize,
    pub hidden: usize,
}

/// A box on the ground.
#[derive(Clone, Copy, Debug)]
struct Footprint {
    x: f64,
    y: f64,
    heading: f64,
    half_length: f64,
    half_width: f64,
}

impl Footprint {
    fn of(track: &Track, row: usize) -> Self {
        let m = &track.motion;
        let (half_length, half_width) = (track.length_m[row] / 2.0, track.width_m[row] / 2.0);
        Self { x: m.x[row], y: m.y[row], heading: m.heading[row], half_length, half_width }
    }

    /// Into the box's own axes.
    fn local(&self, dx: f64, dy: f64) -> (f64, f64) {
        let (sin, cos) = self.heading.sin_cos();
        (dx * cos + dy * sin, dy * cos - dx * sin)
    }

    /// Distance along a line of sight from the origin in direction (cos, sin) to the box; `None` when it misses. 0 inside.
    fn hit(&self, direction: (f64, f64)) -> Option<f64> {
        let (ox, oy) = self.local(-self.x, -self.y);
        let (dx, dy) = self.local(direction.0, direction.1);
        let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
        for (o, d, half) in [(ox, dx, self.half_length), (oy, dy, self.half_width)] {
            if d.abs() < 1e-12 {
                if o.abs() > half {
                    return None;
                }
                continue;
            }
            let (a, b) = ((-half - o) / d, (half - o) / d);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        (enter <= leave).then_some(enter)
    }

    fn distance(&self) -> f64 {
        self.x.hypot(self.y)
    }

    /// Direction of its centre and the least and greatest angle of its corners from there, rad.
    fn span(&self) -> (f64, f64, f64) {
        let centre = self.y.atan2(self.x);
        let (sin, cos) = self.heading.sin_cos();
        let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(l, w)| {
            let (dx, dy) = (l * self.half_length, w * self.half_width);
            (self.y + dx * sin + dy * cos).atan2(self.x + dx * cos - dy * sin)
        });
        let turned = corners.map(|a| crate::kinematics::wrap_angle(a - centre));
        (centre, turned.into_iter().fold(0.0, f64::min), turned.into_iter().fold(0.0, f64::max))
    }
}

/// How many of [`SIGHT_LINES`] reach `target`; boxes are relative to the sensor.
fn seen_lines(target: &Footprint, others: &[Footprint]) -> usize {
    let (centre, low, high) = target.span();
    let nearer: Vec<&Footprint> = others
        .iter()
        .filter(|o| o.distance() - o.half_length < target.distance() + target.half_length)
        .collect();
    (0..SIGHT_LINES)
        .filter(|i| {
            let angle = centre + low + (high - low) * (*i as f64 + 0.5) / SIGHT_LINES as f64;
            let direction = (angle.cos(), angle.sin());
            // Between two corners that the eye sees, every line meets the box; rounding at its edge does not matter.
            let Some(own) = target.hit(direction) else { return true };
            !nearer.iter().any(|o| o.hit(direction).is_some_and(|d| d < own))
        })
        .count()
}

/// Takes out of the tracks what the ego's sensor would not have seen, and states how many sight lines reach the rest
/// (`interior_points`; only with occlusion).
pub(super) fn apply(sensing: Sensing, ego: &Ego, tracks: &mut Vec<Track>) -> Unseen {
    let mut unseen = Unseen::default();
    if sensing == Sensing::default() {
        return unseen;
    }
    let around = |track: &Track, row: usize| {
        let frame = track.frames[row] as usize;
        let f = Footprint::of(track, row);
        Footprint { x: f.x - ego.motion.x[frame], y: f.y - ego.motion.y[frame], ..f }
    };
    // Who can hide something, by frame, before anything is taken out.
    let mut by_frame: Vec<Vec<(usize, Footprint)>> = vec![Vec::new(); ego.motion.len()];
    if sensing.occlusion == Occlusion::ByBoxes {
        for (k, track) in tracks.iter().enumerate().filter(|(_, t)| t.class.is_vehicle()) {
            for row in 0..track.frames.len() {
                by_frame[track.frames[row] as usize].push((k, around(track, row)));
            }
        }
    }
    for (k, track) in tracks.iter_mut().enumerate() {
        let mut kept = Vec::with_capacity(track.frames.len());
        for row in 0..track.frames.len() {
            let target = around(track, row);
            if sensing.range_m.is_some_and(|r| target.distance() > r) {
                unseen.out_of_range += 1;
                continue;
            }
            if sensing.occlusion == Occlusion::ByBoxes {
                let others = &by_frame[track.frames[row] as usize];
                let others: Vec<Footprint> =
                    others.iter().filter(|(j, _)| *j != k).map(|(_, f)| *f).collect();
                let lines = seen_lines(&target, &others);
                if lines == 0 {
                    unseen.hidden += 1;
                    continue;
                }
                track.interior_points[row] = lines as f64;
            }
            kept.push(row);
        }
        if kept.len() < track.frames.len() {
            keep(track, &kept);
        }
    }
    tracks.retain(|t| !t.frames.is_empty());
    unseen
}

/// Only these rows.
fn keep(track: &mut Track, rows: &[usize]) {
    fn pick<T: Copy>(values: &mut Vec<T>, rows: &[usize]) {
        if !values.is_empty() {
            *values = rows.iter().map(|&r| values[r]).collect();
        }
    }
    pick(&mut track.frames, rows);
    let m = &mut track.motion;
    for column in
        [&mut m.x, &mut m.y, &mut m.z, &mut m.heading, &mut m.vx, &mut m.vy, &mut m.accel, &mut m.yaw_rate]
    {
        pick(column, rows);
    }
    for column in [&mut track.length_m, &mut track.width_m, &mut track.height_m, &mut track.interior_points] {
        pick(column, rows);
    }
    pick(&mut track.turn_signal, rows);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn car(x: f64, y: f64) -> Footprint {
        Footprint { x, y, heading: 0.0, half_length: 2.0, half_width: 1.0 }
    }

    #[test]
    fn a_line_meets_the_near_face() {
        assert_eq!(car(10.0, 0.0).hit((1.0, 0.0)), Some(8.0));
        assert_eq!(car(10.0, 2.0).hit((1.0, 0.0)), None);
        let across = Footprint { heading: std::f64::consts::FRAC_PI_2, ..car(10.0, 0.0) };
        assert!(across.hit((1.0, 0.0)).is_some_and(|d| (d - 9.0).abs() < 1e-12));
        assert_eq!(car(0.5, 0.0).hit((1.0, 0.0)), Some(0.0), "the sensor is inside");
    }

    #[test]
    fn the_same_size_behind_is_hidden_and_beside_is_not() {
        let behind = car(30.0, 0.0);
        assert_eq!(seen_lines(&behind, &[car(10.0, 0.0)]), 0);
        assert_eq!(seen_lines(&behind, &[car(10.0, 6.0)]), SIGHT_LINES);
        assert_eq!(seen_lines(&car(10.0, 0.0), &[behind]), SIGHT_LINES, "what is behind hides nothing");
    }

    #[test]
    fn half_hidden_is_half() {
        // The near car's left edge lies on y = 0: it hides the right half of the one straight behind it, seen from x = 0.
        let lines = seen_lines(&car(30.0, 0.0), &[car(10.0, -1.0)]);
        assert_eq!(lines, SIGHT_LINES / 2);
    }

    #[test]
    fn a_target_across_the_seam_of_angles_is_seen() {
        assert_eq!(seen_lines(&car(-20.0, 0.0), &[car(20.0, 0.0)]), SIGHT_LINES);
        assert_eq!(seen_lines(&car(-20.0, 0.0), &[car(-8.0, 0.0)]), 0);
    }
}
