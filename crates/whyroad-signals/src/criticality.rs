//! What it takes to avoid contact, and how long the danger lasted: required deceleration, brake and steer threat
//! numbers, deceleration to safety time, time exposed to and integrated under a TTC of 2 s.

use crate::gaps::gap;
use crate::geometry::P2;
use crate::interaction::Interaction;
use crate::placement::{Placement, Surroundings, Target};
use crate::rows::Rows;
use crate::table::TableBuilder;
use crate::ttc::{self, CLOSING_LEAST_MPS};
use crate::ttc_accel::accel_along;

/// What a car can brake, m/s2 (CriMe BTN, from CommonRoad's vehicle).
const BRAKE_MPS2: f64 = 11.5;
/// What it can steer, m/s2 (CriMe STN).
const STEER_MPS2: f64 = 8.0;
/// Safety time of DST, s (CriMe).
const SAFETY_TIME_S: f64 = 2.0;
/// TTC under which a pair is exposed, s (CriMe tau).
const TAU_S: f64 = 2.0;
/// No frame counts for longer than this, s: what happened in a pause is not known.
const LONGEST_FRAME_S: f64 = 0.25;

/// Gap and closing speed of one row; `None` where a part is unknown.
fn closing_pair(p: &Placement, around: &Surroundings<'_>) -> Option<(f64, f64)> {
    let gap = gap(p, around.ego.length);
    let closing = ttc::closing(p, gap, around);
    (!gap.is_nan() && (gap.is_infinite() || !closing.is_nan())).then_some((gap, closing))
}

fn closes(gap: f64, closing: f64) -> bool {
    gap.is_finite() && closing > CLOSING_LEAST_MPS
}

/// Jansson's required longitudinal acceleration, m/s2, never positive.
fn a_long_req(gap: f64, closing: f64, accel: f64) -> f64 {
    if !closes(gap, closing) {
        0.0
    } else if gap <= 0.0 {
        f64::NEG_INFINITY
    } else {
        (accel - closing * closing / (2.0 * gap)).min(0.0)
    }
}

/// Deceleration to safety time, m/s2. `theirs` is the target's speed along the path, m/s.
fn dst(gap: f64, closing: f64, theirs: f64) -> f64 {
    if !closes(gap, closing) {
        return 0.0;
    }
    let room = gap - theirs * SAFETY_TIME_S;
    if room <= 0.0 { f64::INFINITY } else { 3.0 * closing * closing / (2.0 * room) }
}

/// Least lateral acceleration with which the ego (its centre on the path) is beside the target after `ttc`, m/s2. The
/// target keeps its sideways speed.
fn a_lat_req(p: &Placement, ttc: f64, ego_width: f64) -> f64 {
    if ttc.is_nan() || ttc.is_infinite() {
        return if ttc.is_nan() { ttc } else { 0.0 };
    }
    if ttc <= 0.0 {
        return f64::INFINITY;
    }
    let sideways = p.velocity.dot(P2::from_heading(p.path.heading).left());
    let to_left = p.path.high + ego_width / 2.0 + sideways * ttc;
    let to_right = -(p.path.low - ego_width / 2.0 + sideways * ttc);
    2.0 * to_left.min(to_right).max(0.0) / (ttc * ttc)
}

/// Time exposed and time integrated under [`TAU_S`] up to each row, from the TTC of each.
fn exposure(target: &Target<'_>, ttc: impl Fn(&Placement) -> f64, times: &[f64]) -> Vec<(f64, f64)> {
    let (mut exposed, mut integrated) = (0.0, 0.0);
    let mut sums = Vec::with_capacity(target.places.len());
    for place in &target.places {
        if let Some(p) = place {
            let t = ttc(p);
            if t <= TAU_S {
                // A frame lasts until the next one; the last as long as the one before.
                let (now, next) = (times[p.frame], times.get(p.frame + 1));
                let before = p.frame.checked_sub(1).map_or(0.1, |i| now - times[i]);
                let lasts = next.map_or(before, |n| n - now).min(LONGEST_FRAME_S);
                exposed += lasts;
                integrated += (TAU_S - t) * lasts;
            }
        }
        sums.push((exposed, integrated));
    }
    sums
}

/// Writes `target.a_long_req`, `btn`, `stn`, `dst`, `tet`, `tit`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let rows = Rows::new(scene.drive, table);
    let (targets, around) = (scene.targets, scene.around);
    let required = |k: usize, r: usize, p: Option<&Placement>| {
        let pair = p.and_then(|p| Some((p, closing_pair(p, around)?)));
        pair.map_or(f64::NAN, |(p, (gap, closing))| {
            a_long_req(gap, closing, accel_along(p, targets[k].accel[r]))
        })
    };
    let along = rows.spread(targets, f64::NAN, required);
    table.number("target.btn", along.iter().map(|a| (a / -BRAKE_MPS2).max(0.0)).collect());
    table.number("target.a_long_req", along);
    let ttc = |p: &Placement| closing_pair(p, around).map_or(f64::NAN, |(gap, v)| ttc::ttc(gap, v));
    let steer = |p: &Placement| a_lat_req(p, ttc(p), around.ego.width) / STEER_MPS2;
    table.number("target.stn", rows.placed(targets, f64::NAN, steer));
    let safety =
        |p: &Placement| closing_pair(p, around).map_or(f64::NAN, |(gap, v)| dst(gap, v, ttc::along(p)));
    table.number("target.dst", rows.placed(targets, f64::NAN, safety));
    let sums: Vec<Vec<(f64, f64)>> = targets.iter().map(|t| exposure(t, ttc, scene.times)).collect();
    table.number("target.tet", rows.spread(targets, f64::NAN, |k, r, _| sums[k][r].0));
    table.number("target.tit", rows.spread(targets, f64::NAN, |k, r, _| sums[k][r].1));
}
