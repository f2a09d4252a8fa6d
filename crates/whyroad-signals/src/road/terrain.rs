//! Speed constraints from road geometry: speed of the next bend, stopping distance, length of the current slope, bends
//! and grades around the ego. Computed from the driven path: the signals of each frame at the ego's position. Nothing
//! beyond the recording is known here.

use crate::geometry::wrap;
use crate::road::path::DrivenPath;
use crate::table::TableBuilder;
use whyroad_model::catalog::{Number, PerFrame, Signal, id};

/// Maximum lateral acceleration in a bend, above which it limits speed, m/s2 (taxonomy, high_curvature).
const BEND_ACCEL: f64 = 2.0;
/// Reaction time, s, and deceleration, m/s2, of a stop (taxonomy, blind_spot_slowdown.curve).
const REACTION_S: f64 = 2.0;
const STOPPING: f64 = 3.0;
/// Minimum grade of a slope (taxonomy, slope_up).
const SLOPE: f64 = 0.04;
/// Minimum curvature of a bend, 1/m (taxonomy, high_curvature).
const BEND: f64 = 0.01;
/// Bends in one direction with a smaller distance are merged, m: the middle of a bend made of two arcs is not a
/// straight.
const BEND_MERGE_M: f64 = 10.0;
/// Minimum change of direction of a bend, rad: 15 deg; less is a variation of the driven path.
const LEAST_TURN_RAD: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// Half of the 500 m over which a mountain road is determined, m.
const AROUND_M: f64 = 250.0;
/// Number of bends that is sufficient although not all of the 500 m was driven (taxonomy, mountain).
const ENOUGH_BENDS: usize = 3;
/// Minimum length for a mean grade, m.
const LEAST_MEAN_M: f64 = 100.0;
/// At standstill and very low speed many frames are at one position; positions within this distance are merged, m.
const SAME_PLACE_M: f64 = 0.2;

/// Speed at which a curvature gives 2 m/s2, m/s.
fn bend_speed(curvature: f64) -> f64 {
    // Lines of maps are accurate to about 0.1 mm, so they are straight above a radius of 100 km.
    if curvature < 1e-5 { f64::INFINITY } else { (BEND_ACCEL / curvature).sqrt() }
}

fn stopping_distance(speed: f64) -> f64 {
    REACTION_S * speed + speed * speed / (2.0 * STOPPING)
}

/// A position on the driven path.
struct PathPoint {
    s: f64,
    curvature: f64,
    grade: f64,
    in_junction: bool,
}

/// Part of the path, arc lengths in m.
struct PathPart {
    from: f64,
    to: f64,
    /// Sign of the grade, or of the turn.
    sign: f64,
}

/// Numbers of a frame column; all unknown if the table does not have it.
fn numbers(table: &TableBuilder<'_>, id: Signal<PerFrame, Number>, frames: usize) -> Vec<f64> {
    table.numbers(id).map_or_else(|| vec![f64::NAN; frames], <[f64]>::to_vec)
}

/// Positions of the ego, in order of arc length.
fn places(path: &DrivenPath, table: &TableBuilder<'_>) -> Vec<PathPoint> {
    let frames = path.ego_s.len();
    let (curvature, grade) =
        (numbers(table, id::MAP_CURVATURE, frames), numbers(table, id::MAP_GRADE, frames));
    let junction = table.flags(id::EGO_IN_JUNCTION);
    let mut places: Vec<PathPoint> = (0..frames)
        .filter(|&i| path.ego_s[i].is_finite())
        .map(|i| PathPoint {
            s: path.ego_s[i],
            curvature: curvature[i],
            grade: grade[i],
            in_junction: junction.is_some_and(|flags| flags[i].is_true()),
        })
        .collect();
    places.sort_by(|a, b| a.s.total_cmp(&b.s));
    places.dedup_by(|b, a| b.s - a.s < SAME_PLACE_M);
    places
}

/// Maximal runs of positions with the same `sign`; 0 belongs to none.
fn runs(places: &[PathPoint], sign: impl Fn(&PathPoint) -> f64) -> Vec<PathPart> {
    let mut parts: Vec<PathPart> = Vec::new();
    let mut before = 0.0;
    for place in places {
        let now = sign(place);
        match parts.last_mut() {
            Some(part) if now != 0.0 && now == before => part.to = place.s,
            _ if now != 0.0 => parts.push(PathPart { from: place.s, to: place.s, sign: now }),
            _ => {}
        }
        before = now;
    }
    parts
}

fn slopes(places: &[PathPoint]) -> Vec<PathPart> {
    runs(places, |p| if p.grade.abs() >= SLOPE { p.grade.signum() } else { 0.0 })
}

fn bends(places: &[PathPoint], path: &DrivenPath) -> Vec<PathPart> {
    let curved = |p: &PathPoint| if p.curvature >= BEND && !p.in_junction { 1.0 } else { 0.0 };
    let mut parts: Vec<PathPart> = Vec::new();
    for mut part in runs(places, curved) {
        let turned = wrap(path.heading_at(part.to + 1.0) - path.heading_at(part.from - 1.0));
        part.sign = turned.signum();
        match parts.last_mut() {
            Some(last) if last.sign == part.sign && part.from - last.to < BEND_MERGE_M => last.to = part.to,
            _ => parts.push(part),
        }
    }
    parts.retain(|p| {
        wrap(path.heading_at(p.to + 1.0) - path.heading_at(p.from - 1.0)).abs() >= LEAST_TURN_RAD
    });
    parts
}

/// Number of bends around `s`; NaN where too little was driven.
fn bends_around(bends: &[PathPart], driven: (f64, f64), s: f64) -> f64 {
    let (from, to) = (s - AROUND_M, s + AROUND_M);
    let count = bends.iter().filter(|b| b.to >= from && b.from <= to).count();
    let all_driven = driven.0 <= from && to <= driven.1;
    if all_driven || count >= ENOUGH_BENDS { count as f64 } else { f64::NAN }
}

/// Mean of the absolute grade around `s` by the trapezoid rule; NaN over less than 100 m.
fn mean_grade(places: &[PathPoint], s: f64) -> f64 {
    let (mut sum, mut length) = (0.0, 0.0);
    for pair in places.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        if a.s < s - AROUND_M || b.s > s + AROUND_M || a.grade.is_nan() || b.grade.is_nan() {
            continue;
        }
        sum += (b.s - a.s) * (a.grade.abs() + b.grade.abs()) / 2.0;
        length += b.s - a.s;
    }
    if length >= LEAST_MEAN_M { sum / length } else { f64::NAN }
}

/// Writes `map.bend_speed`, `ego.stopping_distance`, `map.slope_length`, `map.bends_around`, `map.mean_grade`.
pub fn write(path: &DrivenPath, table: &mut TableBuilder<'_>) {
    let frames = path.ego_s.len();
    let speed = numbers(table, id::EGO_SPEED, frames);
    let ahead = numbers(table, id::MAP_CURVATURE_AHEAD, frames);
    let grade = numbers(table, id::MAP_GRADE, frames);
    let of_bend = |&k: &f64| if k.is_nan() { k } else { bend_speed(k) };
    table.number(id::MAP_BEND_SPEED, ahead.iter().map(of_bend).collect());
    table.number(id::EGO_STOPPING_DISTANCE, speed.into_iter().map(stopping_distance).collect());

    let places = places(path, table);
    let driven = (places.first().map_or(f64::NAN, |p| p.s), places.last().map_or(f64::NAN, |p| p.s));
    let bends = bends(&places, path);
    let winding = path.ego_s.iter().map(|&s| if s.is_nan() { s } else { bends_around(&bends, driven, s) });
    table.number(id::MAP_BENDS_AROUND, winding.collect());
    if grade.iter().all(|g| g.is_nan()) {
        return;
    }
    let slopes = slopes(&places);
    let on_slope = |i: usize| {
        let s = path.ego_s[i];
        let part = slopes.iter().find(|p| p.from - SAME_PLACE_M <= s && s <= p.to + SAME_PLACE_M);
        if grade[i].is_nan() { f64::NAN } else { part.map_or(0.0, |p| p.to - p.from) }
    };
    table.number(id::MAP_SLOPE_LENGTH, (0..frames).map(on_slope).collect());
    table.number(id::MAP_MEAN_GRADE, path.ego_s.iter().map(|&s| mean_grade(&places, s)).collect());
}
