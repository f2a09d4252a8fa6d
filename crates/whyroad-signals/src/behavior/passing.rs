//! Targets beside the ego's path: the distance between them and the area that the ego's body sweeps, and whether the
//! two pass each other in opposite directions.

use crate::table::TableBuilder;
use crate::target::gaps;
use crate::target::interaction::Interaction;
use crate::target::motion::OPPOSITE_RAD;
use crate::target::placement::{Placement, Surroundings};
use crate::target::rows::Rows;
use whyroad_model::catalog::id;
use whyroad_model::{ObjectClass, Tri};

/// Maximum distance ahead of the front bumper at which two pass each other, m.
const AHEAD_M: f64 = 30.0;
/// Maximum distance beside the path for passing, m: center to path.
const BESIDE_M: f64 = 6.0;
/// Minimum closing speed of two that pass each other, m/s.
const CLOSING_LEAST_MPS: f64 = 0.5;

/// Distance from the footprint's nearest edge to the side of the body's band, m; negative inside the band.
fn clearance(p: &Placement, ego_width: f64) -> f64 {
    let half = ego_width / 2.0;
    p.path.low.max(-p.path.high) - half
}

/// Between the ego's rear and 30 m ahead of its front.
fn alongside(p: &Placement, ego_length: f64) -> bool {
    let half = ego_length / 2.0;
    p.same_level && p.far >= -half && p.near <= half + AHEAD_M
}

fn passing(p: &Placement, class: ObjectClass, around: &Surroundings<'_>) -> Tri {
    let ego = around.ego;
    if !class.is_vehicle() {
        return Tri::False;
    }
    let speed = ego.forward_speed[p.frame] - gaps::along_signed(p);
    if speed.is_nan() {
        return Tri::Unknown;
    }
    let faces = p.turned() >= OPPOSITE_RAD - 1e-9;
    let beside = p.path.lateral.abs() <= BESIDE_M && alongside(p, ego.length);
    Tri::from(faces && beside && speed >= CLOSING_LEAST_MPS)
}

/// Writes `target.in_band`, `path_side_distance`, `lateral_gap`, `passing`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let rows = Rows::new(scene.drive, table);
    let (targets, around) = (scene.targets, scene.around);
    let (length, width) = (around.ego.length, around.ego.width);
    let sized = |p: &Placement, value: f64| if p.is_sized() { value } else { f64::NAN };
    let in_band = |p: &Placement| match p.is_sized() {
        true => Tri::from(p.band.is_some() && p.same_level && p.within_reach()),
        false => Tri::Unknown,
    };
    let side = |p: &Placement| sized(p, clearance(p, width).max(0.0));
    let gap =
        |p: &Placement| sized(p, if alongside(p, length) { clearance(p, width) } else { f64::INFINITY });
    let (mut in_bands, mut passes) = (rows.column(Tri::Unknown), rows.column(Tri::Unknown));
    let (mut sides, mut gaps) = (rows.column(f64::NAN), rows.column(f64::NAN));
    rows.each_placed(targets, |row, (k, _), p| {
        in_bands.0[row] = in_band(p);
        sides.0[row] = side(p);
        gaps.0[row] = gap(p);
        if p.is_sized() {
            passes.0[row] = passing(p, targets[k].track.class, around);
        }
    });
    table.flag(id::TARGET_IN_BAND, in_bands);
    table.number(id::TARGET_PATH_SIDE_DISTANCE, sides);
    table.number(id::TARGET_LATERAL_GAP, gaps);
    table.flag(id::TARGET_PASSING, passes);
}
