//! Effort for avoiding contact, and duration of the danger: required deceleration, brake and steer threat numbers,
//! deceleration to safety time, time exposed to and integrated under a TTC of 2 s.

use crate::conflict::ttc::ttc;
use crate::conflict::ttc_accel::accel_along;
use crate::geometry::P2;
use crate::table::TableBuilder;
use crate::target::approach::{CLOSING_LEAST_MPS, along};
use crate::target::interaction::Interaction;
use crate::target::placement::{Approach, Placement, Target};
use crate::target::rows::Rows;
use whyroad_model::catalog::id;

/// Maximum braking of a car, m/s2 (CriMe BTN, from CommonRoad's vehicle).
const BRAKE_MPS2: f64 = 11.5;
/// Maximum lateral acceleration of a car, m/s2 (CriMe STN).
const STEER_MPS2: f64 = 8.0;
/// Safety time of DST, s (CriMe).
const SAFETY_TIME_S: f64 = 2.0;
/// TTC under which a pair is exposed, s (CriMe tau).
const TAU_S: f64 = 2.0;
/// Maximum duration that is counted for a frame, s: the motion during a pause is not known.
const LONGEST_FRAME_S: f64 = 0.25;

/// Gap and closing speed of one row; `None` where a part is unknown.
fn closing_pair(p: &Placement) -> Option<Approach> {
    let Approach { gap, closing } = p.approach;
    (!gap.is_nan() && (gap.is_infinite() || !closing.is_nan())).then_some(p.approach)
}

fn closes(gap: f64, closing: f64) -> bool {
    gap.is_finite() && closing > CLOSING_LEAST_MPS
}

/// Jansson's required longitudinal acceleration, m/s2, never positive.
fn a_long_req(Approach { gap, closing }: Approach, accel: impl FnOnce() -> f64) -> f64 {
    if !closes(gap, closing) {
        0.0
    } else if gap <= 0.0 {
        f64::NEG_INFINITY
    } else {
        let needed = accel() - closing * closing / (2.0 * gap);
        // `min` would turn NaN into 0.
        if needed.is_nan() { f64::NAN } else { needed.min(0.0) }
    }
}

/// Deceleration to safety time, m/s2. `theirs` gives the target's speed along the path, m/s.
fn dst(Approach { gap, closing }: Approach, theirs: impl FnOnce() -> f64) -> f64 {
    if !closes(gap, closing) {
        return 0.0;
    }
    let room = gap - theirs() * SAFETY_TIME_S;
    if room <= 0.0 { f64::INFINITY } else { 3.0 * closing * closing / (2.0 * room) }
}

/// Minimum lateral acceleration with which the ego (its center on the path) is beside the target after `ttc`, m/s2. The
/// target keeps its lateral speed.
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
        if let Some(p) = place
            && let t = ttc(p)
            && t <= TAU_S
        {
            // A frame lasts until the next one; the last one as long as the one before.
            let (now, next) = (times[p.frame], times.get(p.frame + 1));
            let before = p.frame.checked_sub(1).map_or(0.1, |i| now - times[i]);
            let lasts = next.map_or(before, |n| n - now).min(LONGEST_FRAME_S);
            exposed += lasts;
            integrated += (TAU_S - t) * lasts;
        }
        sums.push((exposed, integrated));
    }
    sums
}

/// Writes `target.a_long_req`, `btn`, `stn`, `dst`, `tet`, `tit`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let rows = Rows::new(scene.drive, table);
    let (targets, around) = (scene.targets, scene.around);
    let [needed, brake, steer, safety] = rows.placed_columns(targets, |k, r, p| {
        let Some(pair) = closing_pair(p) else { return [f64::NAN; 4] };
        let needed = a_long_req(pair, || accel_along(p, targets[k].accel[r]));
        let aside = a_lat_req(p, ttc(pair), around.ego.width);
        [needed, needed.abs() / BRAKE_MPS2, aside / STEER_MPS2, dst(pair, || along(p))]
    });
    table.number(id::TARGET_A_LONG_REQ, needed);
    table.number(id::TARGET_BTN, brake);
    table.number(id::TARGET_STN, steer);
    table.number(id::TARGET_DST, safety);
    let ttc_of = |p: &Placement| closing_pair(p).map_or(f64::NAN, ttc);
    let sums: Vec<Vec<(f64, f64)>> = targets.iter().map(|t| exposure(t, ttc_of, scene.times)).collect();
    let [exposed, integrated] = rows.columns(|k, r, _| sums[k][r].into());
    table.number(id::TARGET_TET, exposed);
    table.number(id::TARGET_TIT, integrated);
}
