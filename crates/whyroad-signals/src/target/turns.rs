//! Movement of a target through a junction, by its heading integrated over the whole traversal.

use crate::geometry::{p2, unwrap};
use crate::road::junction::{self, MERGE_M, TURN_MARGIN_M};
use crate::road::network::Road;
use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use crate::target::lanes::drives;
use crate::target::placement::Target;
use crate::target::rows::Rows;
use whyroad_model::catalog::{
    id,
    value::{EgoMovement, TargetTurns},
};

/// The value of target.turns for a movement.
fn turn(movement: EgoMovement) -> TargetTurns {
    match movement {
        EgoMovement::Straight => TargetTurns::Straight,
        EgoMovement::Left => TargetTurns::Left,
        EgoMovement::Right => TargetTurns::Right,
        EgoMovement::Uturn => TargetTurns::Uturn,
    }
}

/// Turns of a target by row.
fn turns(road: &Road, target: &Target<'_>) -> Vec<Option<TargetTurns>> {
    let m = &target.track.motion;
    let n = m.len();
    let known = |r: usize| m.x[r].is_finite() && m.y[r].is_finite();
    let mut codes: Vec<Option<TargetTurns>> = (0..n).map(|r| known(r).then_some(TargetTurns::None)).collect();
    if !drives(target.track.class) {
        return codes;
    }
    // Distance traveled; the noise of a stationary target must not add up to a distance.
    let mut traveled = vec![0.0; n];
    for r in 1..n {
        let step = || (p2(m.x[r], m.y[r]) - p2(m.x[r - 1], m.y[r - 1])).norm();
        let step = if target.speed[r] >= 0.3 { step() } else { 0.0 };
        traveled[r] = traveled[r - 1] + if step.is_finite() { step } else { 0.0 };
    }
    let inside: Vec<usize> = (0..n).filter(|&r| known(r) && target.is_in_junction(road, r)).collect();
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for r in inside {
        match runs.last_mut() {
            Some((_, last)) if traveled[r] - traveled[*last] <= MERGE_M => *last = r,
            _ => runs.push((r, r)),
        }
    }
    let headings = unwrap(&m.heading);
    for (first, last) in runs {
        let before = (0..first).rev().take_while(|&r| traveled[first] - traveled[r] <= TURN_MARGIN_M).last();
        let after = (last + 1..n).take_while(|&r| traveled[r] - traveled[last] <= TURN_MARGIN_M).last();
        let angle = headings[after.unwrap_or(last)] - headings[before.unwrap_or(first)];
        let whole = first > 0 && last + 1 < n;
        let code = if angle.is_nan() { None } else { junction::movement(angle, whole).map(turn) };
        codes[first..=last].fill(code);
    }
    codes
}

/// Writes `target.turns`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let Some(road) = scene.around.road else { return };
    let rows = Rows::new(scene.drive, table);
    let codes: Vec<_> = scene.targets.iter().map(|t| turns(road, t)).collect();
    table.category(id::TARGET_TURNS, rows.spread(scene.targets, None, |k, r, _| codes[k][r]));
}
