//! A map that is turned against the road that is driven: the angle between the motion of vehicles and the lanes beside
//! them. A map in another projection is turned by the convergence of its grid, up to some degrees; so is one whose
//! origin has another heading.

use super::fit::{LEAST, LaneLine, Moment, distance_to, lanes};
use super::warning;
use crate::assemble::angles::wrap_angle;
use crate::assemble::frames::median;
use whyroad_model::{Bilingual, Diagnostic, RoadMap};

/// Lanes within this distance, m, that run within this angle of the motion, rad (25 deg), are compared.
const BESIDE_M: f64 = 15.0;
const SAME_WAY_RAD: f64 = 0.436;
/// A median angle from this up, rad (1.8 deg), with this share of all angles on its side. Of nine recordings whose maps
/// are right the median is 0.8 degrees at most; turned by 3 degrees, six of them are found, and by 5 degrees eight.
const TURNED_RAD: f64 = 0.031_4;
const SHARE: f64 = 0.75;

/// Reports a map that is turned.
pub(super) fn check(vehicles: &[Vec<Moment>], map: &RoadMap) -> Option<Diagnostic> {
    let lanes = lanes(map);
    let angles: Vec<f64> = vehicles.iter().flatten().filter_map(|m| angle(m, &lanes)).collect();
    if angles.len() < LEAST {
        return None;
    }
    let turned = median(&angles);
    let same_side = angles.iter().filter(|a| **a * turned > 0.0).count();
    if turned.abs() < TURNED_RAD || (same_side as f64) < SHARE * angles.len() as f64 {
        return None;
    }
    let degrees = turned.to_degrees().abs();
    // The lanes have to turn as the motion is turned against them.
    let (zh, en) = if turned > 0.0 { ("顺时针", "clockwise") } else { ("逆时针", "counter-clockwise") };
    let d = warning(
        "ingest.map.turned",
        format!(
            "地图可能旋转了：相对车辆的行驶方向，其车道{zh}转了约 {degrees:.1} 度；车道与转弯的结果可能有误"
        ),
        format!(
            "the map seems to be turned: its lanes lie about {degrees:.1} degrees {en} of the ways that vehicles drive; lanes \
             and turns may be wrong"
        ),
    );
    Some(d.with_hint(Bilingual::new(
        "检查地图与位姿的投影：UTM 与切平面之间相差子午线收敛角（`--map-projection`），以及日志坐标系的朝向",
        "check the projections of map and poses: UTM and a tangent plane differ by the convergence of the grid \
         (`--map-projection`), and where x of the log's frame points",
    )))
}

/// From the nearest lane to the motion, rad.
fn angle(moment: &Moment, lanes: &[LaneLine<'_>]) -> Option<f64> {
    let mut best: Option<(f64, f64)> = None;
    moment.each_near(lanes, BESIDE_M, &mut |start, unit, length| {
        let away = distance_to(moment.at, start, unit, length);
        let angle = wrap_angle(moment.unit[1].atan2(moment.unit[0]) - unit[1].atan2(unit[0]));
        if away <= BESIDE_M && angle.abs() <= SAME_WAY_RAD && best.is_none_or(|(least, _)| away < least) {
            best = Some((away, angle));
        }
    });
    best.map(|(_, angle)| angle)
}
