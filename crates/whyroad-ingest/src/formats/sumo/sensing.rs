//! What a sensor on the ego would have seen: a range, and line of sight past other vehicles.
//!
//! Sight lines run in the plane from the center of the ego's box to a target's outline, [`SIGHT_LINES`] of them evenly
//! over the angle under which it is seen; one that meets another motor vehicle's box or a building (of an additional
//! file) first is blocked. Heights are ignored: a car hides a truck behind it. A row that no line reaches is removed
//! from the track.

use std::collections::BTreeMap;
use whyroad_model::TrackId;
use whyroad_model::road_map::RoadMap;
use whyroad_model::scene::{Ego, Motion, Track};

/// Sight lines per target.
pub const SIGHT_LINES: usize = 100;

/// How the ego senses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensing {
    /// Objects whose box center is farther than this from the ego's are not in the log, m.
    pub range_m: Option<f64>,
    /// Whether vehicles hide what is behind them.
    pub occlusion: Occlusion,
}

/// Whether vehicles hide what is behind them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Occlusion {
    /// Everything is seen.
    #[default]
    Ignored,
    /// By the boxes of motor vehicles, and buildings.
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

    /// Distance along a line of sight from the origin in direction (cos, sin) to the box; `None` when it misses. 0
    /// inside.
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

    /// Direction of its center and the least and greatest angle of its corners from there, rad.
    fn span(&self) -> (f64, f64, f64) {
        let center = self.y.atan2(self.x);
        let (sin, cos) = self.heading.sin_cos();
        let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(l, w)| {
            let (dx, dy) = (l * self.half_length, w * self.half_width);
            (self.y + dx * sin + dy * cos).atan2(self.x + dx * cos - dy * sin)
        });
        let turned = corners.map(|a| crate::assemble::angles::wrap_angle(a - center));
        (center, turned.into_iter().fold(0.0, f64::min), turned.into_iter().fold(0.0, f64::max))
    }
}

/// A wall of a building, relative to the sensor.
type Wall = [(f64, f64); 2];

/// Distance along a line of sight from the origin to a wall.
fn wall_hit([a, b]: Wall, direction: (f64, f64)) -> Option<f64> {
    let along = (b.0 - a.0, b.1 - a.1);
    let turn = direction.0 * along.1 - direction.1 * along.0;
    if turn.abs() < 1e-12 {
        return None;
    }
    let distance = (a.0 * along.1 - a.1 * along.0) / turn;
    let share = (a.0 * direction.1 - a.1 * direction.0) / turn;
    (distance >= 0.0 && (0.0..=1.0).contains(&share)).then_some(distance)
}

/// What a target's sight lines meet.
struct Sight {
    /// Lines of [`SIGHT_LINES`] that reach it.
    seen: usize,
    /// Index of the vehicle that blocks most of the others; `None` when walls block more.
    occluder: Option<usize>,
}

/// Sight lines from the origin to `target` past the boxes of others (with their indices) and walls.
fn look(target: &Footprint, others: &[(usize, Footprint)], walls: &[Wall]) -> Sight {
    let (center, low, high) = target.span();
    let nearer: Vec<&(usize, Footprint)> = others
        .iter()
        .filter(|(_, o)| o.distance() - o.half_length < target.distance() + target.half_length)
        .filter(|(_, o)| {
            let (other, least, most) = o.span();
            let apart = crate::assemble::angles::wrap_angle(other - center);
            // A sensor inside a box has it all around.
            o.hit((1.0, 0.0)) == Some(0.0) || (apart + least <= high && apart + most >= low)
        })
        .collect();
    let mut stopped: BTreeMap<Option<usize>, usize> = BTreeMap::new();
    for i in 0..SIGHT_LINES {
        let angle = center + low + (high - low) * (i as f64 + 0.5) / SIGHT_LINES as f64;
        let direction = (angle.cos(), angle.sin());
        // Between two corners that are visible, every line meets the box; rounding at its edge does not matter.
        let Some(own) = target.hit(direction) else { continue };
        let boxes = nearer.iter().filter_map(|(k, o)| Some((o.hit(direction)?, Some(*k))));
        let walls = walls.iter().filter_map(|w| Some((wall_hit(*w, direction)?, None)));
        let first = boxes.chain(walls).filter(|(d, _)| *d < own).min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, who)) = first {
            *stopped.entry(who).or_default() += 1;
        }
    }
    let most = stopped.iter().max_by_key(|(_, n)| **n);
    Sight { seen: SIGHT_LINES - stopped.values().sum::<usize>(), occluder: most.and_then(|(who, _)| *who) }
}

/// The walls of the map's buildings; an outline of two points is one wall.
fn walls(map: Option<&RoadMap>) -> Vec<Wall> {
    let buildings = map.into_iter().flat_map(|m| &m.facilities).filter(|f| f.kind == "building");
    let corners = |f: &whyroad_model::road_map::Facility| -> Vec<(f64, f64)> {
        f.boundary.iter().map(|p| (p.x, p.y)).collect()
    };
    buildings
        .map(corners)
        .flat_map(|c| {
            let closing = (c.len() > 2).then(|| [c[c.len() - 1], c[0]]);
            c.windows(2).map(|w| [w[0], w[1]]).chain(closing).collect::<Vec<_>>()
        })
        .collect()
}

/// The walls that reach within `reach` of a place, relative to it.
fn walls_around(walls: &[Wall], (x, y): (f64, f64), reach: f64) -> Vec<Wall> {
    let near = |[a, b]: &Wall| {
        let within = |p: f64, q: f64, c: f64| p.min(q) <= c + reach && p.max(q) >= c - reach;
        within(a.0, b.0, x) && within(a.1, b.1, y)
    };
    walls.iter().filter(|w| near(w)).map(|w| w.map(|(px, py)| (px - x, py - y))).collect()
}

/// What the ego's sensor sees of the rows of one track.
struct Seen {
    rows: Vec<usize>,
    sights: Vec<Sight>,
}

/// Removes from the tracks what the ego's sensor would not have seen, and states how many sight lines reach the rest
/// and what blocks most of the others (only with occlusion).
pub(super) fn apply(sensing: Sensing, ego: &Ego, map: Option<&RoadMap>, tracks: &mut Vec<Track>) -> Unseen {
    let mut unseen = Unseen::default();
    if sensing == Sensing::default() {
        return unseen;
    }
    let at = |frame: usize| (ego.motion.x[frame], ego.motion.y[frame]);
    let around = |track: &Track, row: usize| {
        let f = Footprint::of(track, row);
        let (x, y) = at(track.frames[row] as usize);
        Footprint { x: f.x - x, y: f.y - y, ..f }
    };
    let occludes = sensing.occlusion == Occlusion::ByBoxes;
    let within = |f: &Footprint| sensing.range_m.is_none_or(|r| f.distance() <= r);
    // Which vehicles can hide something, by frame, before anything is taken out; and how far the farthest target is.
    let mut by_frame: Vec<Vec<(usize, Footprint)>> = vec![Vec::new(); ego.motion.len()];
    let mut reach = vec![0.0_f64; ego.motion.len()];
    for (k, track) in tracks.iter().enumerate().filter(|_| occludes) {
        for row in 0..track.frames.len() {
            let (frame, footprint) = (track.frames[row] as usize, around(track, row));
            if within(&footprint) {
                reach[frame] = reach[frame].max(footprint.distance());
            }
            if track.class.is_vehicle() {
                by_frame[frame].push((k, footprint));
            }
        }
    }
    let walls = if occludes { walls(map) } else { Vec::new() };
    let near: Vec<Vec<Wall>> = (0..reach.len()).map(|i| walls_around(&walls, at(i), reach[i])).collect();
    let ids: Vec<TrackId> = tracks.iter().map(|t| t.id.clone()).collect();
    for (k, track) in tracks.iter_mut().enumerate() {
        let mut seen = Seen { rows: Vec::new(), sights: Vec::new() };
        for row in 0..track.frames.len() {
            let target = around(track, row);
            if !within(&target) {
                unseen.out_of_range += 1;
                continue;
            }
            if occludes {
                let frame = track.frames[row] as usize;
                let others: Vec<(usize, Footprint)> =
                    by_frame[frame].iter().filter(|(j, _)| *j != k).copied().collect();
                let sight = look(&target, &others, &near[frame]);
                if sight.seen == 0 {
                    unseen.hidden += 1;
                    continue;
                }
                seen.sights.push(sight);
            }
            seen.rows.push(row);
        }
        if seen.rows.len() < track.frames.len() {
            keep(track, &seen.rows);
        }
        if occludes {
            let id = |s: &Sight| s.occluder.map(|j| ids[j].clone());
            track.interior_points = seen.sights.iter().map(|s| s.seen as f64).collect();
            track.visible_share = seen.sights.iter().map(|s| s.seen as f64 / SIGHT_LINES as f64).collect();
            track.occluder = seen.sights.iter().map(id).collect();
            if track.occluder.iter().all(Option::is_none) {
                track.occluder.clear();
            }
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
    let Motion { x, y, z, heading, vx, vy, accel, yaw_rate, forward } = &mut track.motion;
    for column in [x, y, z, heading, vx, vy, accel, yaw_rate, forward] {
        pick(column, rows);
    }
    for column in [&mut track.length_m, &mut track.width_m, &mut track.height_m, &mut track.interior_points] {
        pick(column, rows);
    }
    pick(&mut track.turn_signal, rows);
    pick(&mut track.known_at, rows);
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

    fn seen_lines(target: &Footprint, others: &[Footprint]) -> usize {
        let others: Vec<(usize, Footprint)> = others.iter().copied().enumerate().collect();
        look(target, &others, &[]).seen
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
        // The near car's left edge lies on y = 0: it hides the right half of the one straight behind it, seen from x =
        // 0.
        let lines = seen_lines(&car(30.0, 0.0), &[car(10.0, -1.0)]);
        assert_eq!(lines, SIGHT_LINES / 2);
    }

    #[test]
    fn a_target_across_the_seam_of_angles_is_seen() {
        assert_eq!(seen_lines(&car(-20.0, 0.0), &[car(20.0, 0.0)]), SIGHT_LINES);
        assert_eq!(seen_lines(&car(-20.0, 0.0), &[car(-8.0, 0.0)]), 0);
    }

    #[test]
    fn a_wall_hides_and_what_stops_most_is_named() {
        let target = car(30.0, 0.0);
        // From y = 0 upwards, half way: the left half is hidden by the wall, so no vehicle is named.
        let wall = [(15.0, 0.0), (15.0, 20.0)];
        let sight = look(&target, &[], &[wall]);
        assert_eq!((sight.seen, sight.occluder), (SIGHT_LINES / 2, None));
        assert_eq!(look(&target, &[], &[[(40.0, -9.0), (40.0, 9.0)]]).seen, SIGHT_LINES, "it stands behind");
        // The near car's top edge at y = -0.2: seen from the eye it hides less than the wall does; alone it is named.
        let sight = look(&target, &[(7, car(10.0, -1.2))], &[wall]);
        assert!(sight.seen > 0 && sight.seen < SIGHT_LINES / 2 && sight.occluder.is_none());
        assert_eq!(look(&target, &[(7, car(10.0, -1.2))], &[]).occluder, Some(7));
    }
}
