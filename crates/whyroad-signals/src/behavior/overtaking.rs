//! Targets that the ego has passed: completely ahead a while ago, completely behind now, moving in the same direction.

use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use crate::target::placement::{MOVING_MPS, Placement, Target};
use crate::target::rows::Rows;
use std::f64::consts::FRAC_PI_4;
use whyroad_model::Tri;
use whyroad_model::catalog::id;

/// Maximum duration of passing, s.
const WITHIN_S: f64 = 10.0;
/// It is reported for this long, s.
const PULSE_S: f64 = 2.0;
/// A target farther beside the path than this was on another road, m.
const BESIDE_M: f64 = 8.0;

/// Times at which the target is completely behind for the first time, s.
fn passed(target: &Target<'_>, ego_length: f64, times: &[f64]) -> Vec<f64> {
    let half = ego_length / 2.0;
    // When it was last completely ahead, and whether it has moved since.
    let mut ahead: Option<(f64, bool)> = None;
    let mut moments = Vec::new();
    for p in target.places.iter().flatten() {
        let beside = p.path.lateral.abs() <= BESIDE_M && p.same_level && p.within_reach();
        let same_way = p.turned() <= FRAC_PI_4;
        if !beside || !same_way {
            ahead = None;
            continue;
        }
        let moves = p.speed() >= MOVING_MPS;
        if p.near > half {
            ahead = Some((times[p.frame], moves));
        } else if let Some((since, moved)) = ahead {
            if p.far < -half {
                if (moved || moves) && times[p.frame] - since <= WITHIN_S {
                    moments.push(times[p.frame]);
                }
                ahead = None;
            } else {
                ahead = Some((since, moved || moves));
            }
        }
    }
    moments
}

/// Writes `target.overtaken`, `ego.passed_slower`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let rows = Rows::new(scene.drive, table);
    let (targets, ego, times) = (scene.targets, scene.around.ego, scene.times);
    let moments: Vec<Vec<f64>> = targets.iter().map(|t| passed(t, ego.length, times)).collect();
    let told = |k: usize, now: f64| moments[k].iter().any(|m| (0.0..PULSE_S - 1e-6).contains(&(now - m)));
    let flag = |k: usize, p: Option<&Placement>| {
        p.filter(|p| p.is_sized()).map_or(Tri::Unknown, |p| Tri::from(told(k, times[p.frame])))
    };
    table.flag(id::TARGET_OVERTAKEN, rows.spread(targets, Tri::Unknown, |k, _, p| flag(k, p)));
    let any = |i: usize| match ego.is_known(i) {
        true => Tri::from((0..targets.len()).any(|k| told(k, times[i]))),
        false => Tri::Unknown,
    };
    table.flag(id::EGO_PASSED_SLOWER, (0..times.len()).map(any).collect());
}
