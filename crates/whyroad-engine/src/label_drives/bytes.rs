//! The memory that a drive and what was derived from it take, about: columns exactly, texts by their number.

use std::mem::size_of;
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::road_map::{Point3, RoadMap};
use whyroad_model::scene::{Ego, EgoBus, Motion, Track};
use whyroad_model::{Column, Drive, SignalTable};

/// A text with what the allocator adds, where there are many short ones.
const TEXT: usize = 64;
/// An episode with its conditions in words.
const EPISODE: usize = 8 << 10;

fn of<T>(values: &[T]) -> usize {
    size_of_val(values)
}

/// Rows with three texts each, about.
fn with_texts<T>(rows: &[T]) -> usize {
    of(rows) + rows.len() * 3 * TEXT
}

pub(super) fn of_drive(drive: &Drive) -> usize {
    let Drive { meta: _, times, ego, tracks, map, lights, context, media } = drive;
    of(times)
        + ego.as_ref().map_or(0, of_ego)
        + tracks.iter().map(of_track).sum::<usize>()
        + map.as_ref().map_or(0, of_map)
        + lights.as_deref().map_or(0, with_texts)
        + context.as_deref().map_or(0, with_texts)
        + media.as_deref().map_or(0, with_texts)
}

fn of_motion(motion: &Motion) -> usize {
    let Motion { x, y, z, heading, vx, vy, accel, yaw_rate, forward } = motion;
    [x, y, z, heading, vx, vy, accel, yaw_rate, forward].into_iter().map(|v| of(v)).sum()
}

fn of_ego(ego: &Ego) -> usize {
    let EgoBus { speed_mps, throttle, route_command, .. } = &ego.bus;
    // The other columns are flags.
    of_motion(&ego.motion) + of(&ego.known_at) + 3 * of(speed_mps) + of(throttle) + 2 * of(route_command)
}

fn of_track(track: &Track) -> usize {
    let numbers =
        [&track.length_m, &track.width_m, &track.height_m, &track.interior_points, &track.visible_share];
    size_of::<Track>()
        + of_motion(&track.motion)
        + numbers.into_iter().map(|v| of(v)).sum::<usize>()
        + of(&track.frames)
        + of(&track.known_at)
        + of(&track.turn_signal)
        + track.occluder.len() * (size_of::<Option<String>>() + TEXT)
        + track.class_changes.len() * TEXT
}

fn of_map(map: &RoadMap) -> usize {
    let points = |lines: &mut dyn Iterator<Item = &Vec<Point3>>| lines.map(|l| of(l)).sum::<usize>();
    let lanes = map.lanes.iter().flat_map(|l| [&l.left, &l.right, &l.center]);
    let areas = [&map.crosswalks, &map.junctions, &map.drivable_areas];
    let rings = areas.into_iter().flatten().map(|a| &a.boundary);
    let lines = map.stop_lines.iter().map(|s| &s.line);
    let facilities = map.facilities.iter().map(|f| &f.boundary);
    points(&mut lanes.chain(rings).chain(lines).chain(facilities))
        + of(&map.lanes)
        + map.lanes.iter().map(|l| (5 + l.successors.len() + l.predecessors.len()) * TEXT).sum::<usize>()
        + 4 * TEXT * (map.signs.len() + map.stop_lines.len() + map.facilities.len())
}

pub(super) fn of_signals(table: &SignalTable) -> usize {
    let column = |c: &Column| match c {
        Column::Number(v) => of(v),
        Column::Flag(v) => of(v),
        Column::Category { codes, .. } => of(codes),
    };
    let all = table.frame_columns.values().chain(table.target_columns.values());
    all.map(|c| column(c) + 2 * TEXT).sum::<usize>()
        + of(&table.times)
        + of(&table.targets)
        + table.targets.len() * TEXT
        + (table.unavailable.len() + table.partial.len()) * 2 * TEXT
}

pub(super) fn of_episodes(episodes: &[EpisodeRecord]) -> usize {
    episodes.len() * EPISODE
}
