//! Checks for impossible values in a drive of any format. A value is repaired where only one reading is possible;
//! otherwise it becomes unknown. Decisions use single rows or the first seconds only: what is known at a moment must
//! not depend on later data.

use crate::assemble::angles::wrap_angle;
use crate::assemble::frames::median;
use crate::assemble::geometry::distance;
use std::collections::BTreeMap;
use whyroad_model::road_map::{Lane, LayerState, MapLayer, Point3};
use whyroad_model::scene::{Drive, FrameOfReference, Motion};
use whyroad_model::{Bilingual, Diagnostic, Nanos, Need, RoadMap, counted};

/// Codes of this module.
pub(crate) const CODES: &[&str] = &[
    "ingest.size.swapped",
    "ingest.size.impossible",
    "ingest.ego.among_objects",
    "ingest.height.heading",
    "ingest.velocity.last_zero",
    "ingest.accel.impossible",
    "ingest.accel.contradicts",
    "ingest.pose.impossible",
    "ingest.map.off",
    "ingest.map.shifted",
    "ingest.map.turned",
    "ingest.position.far",
    "ingest.limit.connector",
    "ingest.limit.impossible",
    "ingest.lights.unused",
    "ingest.position.degrees",
    "ingest.map.against",
    "ingest.date.implausible",
    "ingest.speed.contradicts",
    "ingest.vertical_accel.gravity",
    "ingest.yaw_rate.contradicts",
    "ingest.heading.contradicts",
    "ingest.heading.impossible",
    "ingest.heading.backwards",
    "ingest.heading.standing",
];

/// A vehicle that is wider than long by more than this factor has its sizes swapped or a bad box.
const WIDER: f64 = 1.05;
/// Lengths and widths of cars, vans, trucks and buses, m: a swap is repaired when it gives these.
const LENGTH_M: std::ops::RangeInclusive<f64> = 3.0..=19.0;
const WIDTH_M: std::ops::RangeInclusive<f64> = 1.3..=3.1;
/// A stated velocity of exactly 0 after one above this value, in the last row, is a gap in the source, m/s.
const MOVING_MPS: f64 = 2.0;
/// Highest plausible acceleration, m/s2: the grip of tires on dry asphalt is about 1 g.
const MAX_ACCEL_MPS2: f64 = 15.0;
/// Positions farther than this from the start of the drive are not in its frame, m; the start is the median of so many
/// rows of the ego.
const FAR_M: f64 = 1e6;
const START_ROWS: usize = 10;
/// The ego drives on the map when at least this share of its first frames is this near to a lane, m.
const ON_MAP_SHARE: f64 = 0.5;
const ON_MAP_M: f64 = 15.0;
const FIRST_FRAMES: usize = 100;
/// An ego this far outside of its map's extent is in another frame or at another location, m.
const ANOTHER_FRAME_M: f64 = 1000.0;
/// A lane's heights are headings when they agree with them within this, rad, at this share of its points.
const SAME_RAD: f64 = 0.02;
const SAME_SHARE: f64 = 0.9;
/// 2000-01-01 and 2100-01-01, ns.
const PLAUSIBLE: std::ops::Range<i64> = 946_684_800_000_000_000..4_102_444_800_000_000_000;

/// Checks a drive.
pub(crate) fn check(drive: &mut Drive) -> Vec<Diagnostic> {
    let mut out = Vec::new();
    // Where positions are relative to a moving ego, what a parked car passes is not its own motion.
    let is_over_ground = drive.meta.frame_of_reference == FrameOfReference::World;
    out.extend(far_positions(drive));
    out.extend(degrees::positions(drive));
    out.extend(headings::jumps(drive));
    if is_over_ground {
        out.extend(headings::backwards(drive));
    }
    out.extend(standing::check(drive));
    out.extend(poses::steps_back(drive));
    out.extend(own_box::drop(drive));
    out.extend(impossible_sizes(drive));
    out.extend(swapped_sizes(drive));
    out.extend(last_zero(drive));
    out.extend(accelerations(drive));
    out.extend(agreement::of_ego(drive));
    if is_over_ground {
        out.extend(agreement::of_objects(drive));
    }
    out.extend(rates::check(drive));
    if let Some(map) = &mut drive.map {
        out.extend(headings_as_heights(map));
        out.extend(limits::in_another_unit(map));
        out.extend(limits_on_connectors(map));
    }
    out.extend(off_the_map(drive));
    out.extend(shifted::check(drive));
    out.extend(lights::unused(drive));
    out.extend(date(drive));
    out
}

fn warning(code: &'static str, zh: String, en: String) -> Diagnostic {
    Diagnostic::warning(code, Bilingual::new(zh, en))
}

fn far_positions(drive: &mut Drive) -> Option<Diagnostic> {
    let ego = drive.ego.as_ref().map(|e| &e.motion)?;
    // Coordinates of a projected frame such as UTM are that large from the start.
    let start = |of: &[f64]| {
        let first: Vec<f64> = of.iter().copied().filter(|v| v.is_finite()).take(START_ROWS).collect();
        (!first.is_empty()).then(|| median(&first))
    };
    let (x0, y0) = (start(&ego.x)?, start(&ego.y)?);
    let far = |m: &Motion, i: usize| (m.x[i] - x0).abs() >= FAR_M || (m.y[i] - y0).abs() >= FAR_M;
    let mut rows = 0;
    let motions =
        drive.ego.iter_mut().map(|e| &mut e.motion).chain(drive.tracks.iter_mut().map(|t| &mut t.motion));
    for m in motions {
        for i in 0..m.len() {
            if far(m, i) {
                (m.x[i], m.y[i], m.vx[i], m.vy[i]) = (f64::NAN, f64::NAN, f64::NAN, f64::NAN);
                rows += 1;
            }
        }
    }
    (rows > 0).then(|| {
        warning(
            "ingest.position.far",
            format!("{rows} 行的位置距行程起点 1000 km 以上，与其余位置不属于同一坐标系；记为未知"),
            format!(
                "{rows} positions are 1000 km and more from the start of the drive; they are set to unknown"
            ),
        )
    })
}

/// Longest road vehicle, m: road trains of 53.5 m (Australian National Heavy Vehicle Regulator); and widest, m.
const LONGEST_M: f64 = 60.0;
const WIDEST_M: f64 = 8.0;

/// Sizes in another unit: nothing on the road is that large.
fn impossible_sizes(drive: &mut Drive) -> Option<Diagnostic> {
    let mut rows = 0;
    let mut check = |length: &mut f64, width: &mut f64| {
        // `min` passes over an unknown side.
        let is_wide = *length > WIDEST_M && *width > WIDEST_M;
        if length.max(*width) > LONGEST_M || is_wide {
            (*length, *width) = (f64::NAN, f64::NAN);
            rows += 1;
        }
    };
    if let Some(ego) = &mut drive.ego {
        check(&mut ego.length_m, &mut ego.width_m);
    }
    for track in &mut drive.tracks {
        track.length_m.iter_mut().zip(&mut track.width_m).for_each(|(l, w)| check(l, w));
    }
    (rows > 0).then(|| {
        warning(
            "ingest.size.impossible",
            format!("{rows} 个框长于 {LONGEST_M:.0} m 或宽于 {WIDEST_M:.0} m；长宽记为未知"),
            format!(
                "{rows} boxes are longer than {LONGEST_M:.0} m or wider than {WIDEST_M:.0} m; their sizes are set to unknown"
            ),
        )
        .with_hint(Bilingual::new("检查尺寸的单位（m）", "check the unit of sizes (m)"))
    })
}

fn swapped_sizes(drive: &mut Drive) -> Option<Diagnostic> {
    let (mut repaired, mut unknown, mut vehicles) = (0, 0, 0);
    // `rows` boxes have this size.
    let mut check = |length: &mut f64, width: &mut f64, rows: usize| {
        if *width <= *length * WIDER || length.is_nan() || width.is_nan() {
            return false;
        }
        if LENGTH_M.contains(width) && WIDTH_M.contains(length) {
            std::mem::swap(length, width);
            repaired += rows;
        } else {
            (*length, *width) = (f64::NAN, f64::NAN);
            unknown += rows;
        }
        true
    };
    if let Some(ego) = &mut drive.ego {
        vehicles += usize::from(check(&mut ego.length_m, &mut ego.width_m, ego.motion.len()));
    }
    for track in drive.tracks.iter_mut().filter(|t| t.class.is_vehicle()) {
        let sizes = track.length_m.iter_mut().zip(&mut track.width_m);
        vehicles += usize::from(sizes.fold(false, |any, (l, w)| check(l, w, 1) || any));
    }
    (repaired + unknown > 0).then(|| {
        warning(
            "ingest.size.swapped",
            format!(
                "{vehicles} 辆车的 {} 个框宽大于长：{repaired} 个已交换长宽，{unknown} 个记为未知",
                repaired + unknown
            ),
            format!(
                "{} boxes of {} are wider than long: length and width were swapped back in {repaired}, {unknown} are set to \
                 unknown",
                repaired + unknown,
                counted(vehicles, "vehicle")
            ),
        )
    })
}

/// A source that pads its arrays with zeros ends on a velocity of 0. Only the last row: a recording that continues has
/// a measured value there.
fn last_zero(drive: &mut Drive) -> Option<Diagnostic> {
    let mut rows = 0;
    let motions =
        drive.ego.iter_mut().map(|e| &mut e.motion).chain(drive.tracks.iter_mut().map(|t| &mut t.motion));
    for m in motions {
        let Some(last) = m.len().checked_sub(1).filter(|&last| last > 0) else { continue };
        let zero = m.vx[last] == 0.0 && m.vy[last] == 0.0;
        if zero && m.speed(last - 1) > MOVING_MPS {
            (m.vx[last], m.vy[last]) = (f64::NAN, f64::NAN);
            rows += 1;
        }
    }
    (rows > 0).then(|| {
        warning(
            "ingest.velocity.last_zero",
            format!("{rows} 条轨迹在行驶中以速度 0 结束；最后一行的速度记为未知"),
            format!(
                "{rows} tracks end with a velocity of 0 while moving; it is set to unknown in their last row"
            ),
        )
    })
}

fn accelerations(drive: &mut Drive) -> Option<Diagnostic> {
    let mut rows = 0;
    let motions =
        drive.ego.iter_mut().map(|e| &mut e.motion).chain(drive.tracks.iter_mut().map(|t| &mut t.motion));
    for a in motions.flat_map(|m| &mut m.accel) {
        if a.abs() > MAX_ACCEL_MPS2 {
            *a = f64::NAN;
            rows += 1;
        }
    }
    (rows > 0).then(|| {
        warning(
            "ingest.accel.impossible",
            format!("{rows} 行给出的加速度超过 {MAX_ACCEL_MPS2} m/s2；记为未知"),
            format!(
                "{rows} rows state accelerations of more than {MAX_ACCEL_MPS2} m/s2; they are set to unknown"
            ),
        )
    })
}

/// True when the heights along a lane are its headings.
fn is_heading(line: &[Point3]) -> bool {
    let steps = line.windows(2).filter(|w| distance(w[0], w[1]) > 1e-3);
    let (mut all, mut same) = (0_usize, 0_usize);
    for w in steps {
        let heading = (w[1].y - w[0].y).atan2(w[1].x - w[0].x);
        all += 1;
        same += usize::from([w[0].z, w[1].z].iter().any(|z| wrap_angle(z - heading).abs() <= SAME_RAD));
    }
    all >= 2 && same as f64 >= SAME_SHARE * all as f64
}

fn headings_as_heights(map: &mut RoadMap) -> Option<Diagnostic> {
    let sloped = |l: &&Lane| l.center.iter().any(|p| p.z != 0.0 && !p.z.is_nan());
    let (all, same) = map
        .lanes
        .iter()
        .filter(sloped)
        .fold((0_usize, 0_usize), |(all, same), l| (all + 1, same + usize::from(is_heading(&l.center))));
    if all < 3 || (same as f64) < SAME_SHARE * all as f64 {
        return None;
    }
    let lines = map.lanes.iter_mut().flat_map(|l| [&mut l.left, &mut l.right, &mut l.center]);
    let areas = map.crosswalks.iter_mut().chain(&mut map.junctions).chain(&mut map.drivable_areas);
    let lines =
        lines.chain(areas.map(|a| &mut a.boundary)).chain(map.stop_lines.iter_mut().map(|s| &mut s.line));
    lines.flatten().for_each(|p| p.z = f64::NAN);
    map.layers.insert(MapLayer::Heights, LayerState::Absent);
    Some(warning(
        "ingest.height.heading",
        "地图折线的第三个坐标是航向而不是高度；高度记为未知".to_owned(),
        "the third coordinate of the map's lines is their heading and not a height; heights are set to unknown".to_owned(),
    ))
}

/// Lanes inside junctions are often given a default limit, lower than before and behind.
fn limits_on_connectors(map: &mut RoadMap) -> Option<Diagnostic> {
    let limits: BTreeMap<&str, f64> =
        map.lanes.iter().filter_map(|l| Some((l.id.as_str(), l.speed_limit_mps?))).collect();
    let lower = |lane: &Lane| {
        let own = lane.speed_limit_mps?;
        let least = |ids: &[String]| {
            let known = ids.iter().filter_map(|id| limits.get(id.as_str()));
            known.copied().reduce(f64::min)
        };
        let (before, behind) = (least(&lane.predecessors)?, least(&lane.successors)?);
        (lane.in_junction && own < before.min(behind) - 0.1).then_some(())
    };
    let found: Vec<usize> = (0..map.lanes.len()).filter(|&i| lower(&map.lanes[i]).is_some()).collect();
    let n = found.len();
    for i in found {
        map.lanes[i].speed_limit_mps = None;
    }
    (n > 0).then(|| {
        warning(
            "ingest.limit.connector",
            format!("{n} 条路口内车道的限速低于其前后车道（多为默认值）；记为未知"),
            format!(
                "{n} lanes inside junctions have a limit below those before and behind (mostly a default); it is set to \
                 unknown"
            ),
        )
    })
}

/// A map on which the ego does not drive belongs to another location.
fn off_the_map(drive: &mut Drive) -> Option<Diagnostic> {
    let (map, ego) = (drive.map.as_ref()?, drive.ego.as_ref()?);
    let m = &ego.motion;
    let known: Vec<(f64, f64)> = (0..m.len().min(FIRST_FRAMES))
        .map(|i| (m.x[i], m.y[i]))
        .filter(|p| p.0.is_finite() && p.1.is_finite())
        .collect();
    if known.is_empty() || map.lanes.is_empty() {
        return None;
    }
    let near = |&(x, y): &(f64, f64)| {
        let p = Point3 { x, y, z: f64::NAN };
        let areas = || map.drivable_areas.iter().chain(&map.junctions);
        map.lanes.iter().any(|l| l.center.windows(2).any(|w| to_segment(w[0], w[1], p) <= ON_MAP_M))
            || areas().any(|a| crate::assemble::geometry::contains(&a.boundary, p))
    };
    // A moment each second is enough.
    let probes: Vec<&(f64, f64)> = known.iter().step_by(10).collect();
    let on = probes.iter().filter(|p| near(p)).count();
    if on as f64 >= ON_MAP_SHARE * probes.len() as f64 {
        return None;
    }
    let apart = apart(map, *probes[0]);
    (drive.map, drive.lights, drive.meta.map_ref) = (None, None, None);
    for need in [Need::Map, Need::TrafficLights] {
        drive.meta.lacks(need);
    }
    Some(
        Diagnostic::error(
            "ingest.map.off",
            Bilingual::new(
                format!(
                    "自车不在该地图上：前 10 s 中 {} 个位置只有 {on} 个在车道 15 m 以内；不使用此地图{}",
                    probes.len(),
                    apart.zh
                ),
                format!(
                    "the ego is not on this map: of {} positions in its first 10 s, {on} lie within 15 m of a lane; the map \
                     is not used{}",
                    probes.len(),
                    apart.en
                ),
            ),
        )
        .with_hint(Bilingual::new(
            "请给出该行程自己的地图（SUMO：--net；其他：--map），坐标系须与位姿一致",
            "give the map of this drive (SUMO: --net, others: --map) in the frame of its poses",
        )),
    )
}

/// Where map and ego are, when the ego is so far outside that both cannot be of one frame.
fn apart(map: &RoadMap, ego: (f64, f64)) -> Bilingual {
    let points = map.lanes.iter().flat_map(|l| &l.center);
    let [x0, y0, x1, y1] = points.fold([f64::MAX, f64::MAX, f64::MIN, f64::MIN], |m, p| {
        [m[0].min(p.x), m[1].min(p.y), m[2].max(p.x), m[3].max(p.y)]
    });
    let outside = |v: f64, low: f64, high: f64| (low - v).max(v - high).max(0.0);
    if outside(ego.0, x0, x1).hypot(outside(ego.1, y0, y1)) < ANOTHER_FRAME_M {
        return Bilingual::new("", "");
    }
    let (x, y) = ego;
    Bilingual::new(
        format!(
            "：地图位于 x {x0:.0} 至 {x1:.0} m、y {y0:.0} 至 {y1:.0} m，自车位于 ({x:.0}, {y:.0})，二者坐标系或地点不同"
        ),
        format!(
            ": it spans x {x0:.0} to {x1:.0} m and y {y0:.0} to {y1:.0} m, the ego is at ({x:.0}, {y:.0}): another frame or \
             another place"
        ),
    )
}

fn to_segment(a: Point3, b: Point3, p: Point3) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let share = (((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy).max(1e-12)).clamp(0.0, 1.0);
    (p.x - a.x - share * dx).hypot(p.y - a.y - share * dy)
}

fn date(drive: &mut Drive) -> Option<Diagnostic> {
    let start: Nanos = *drive.times.first()?;
    if PLAUSIBLE.contains(&start.0) {
        return None;
    }
    drive.meta.lacks(Need::Date);
    let day: String = start.to_string().chars().take(10).collect();
    Some(Diagnostic::note(
        "ingest.date.implausible",
        Bilingual::new(
            format!("日志的时间始于 {day}，不是录制日期；日期与时刻未知，时间间隔不受影响"),
            format!(
                "the log's times begin on {day}, which is not when it was recorded; its date is unknown, intervals are right"
            ),
        ),
    ))
}

mod agreement;
mod degrees;
mod fit;
mod headings;
mod lights;
mod limits;
mod own_box;
mod poses;
mod rates;
mod shifted;
mod standing;
#[cfg(test)]
mod tests;
mod turned;
