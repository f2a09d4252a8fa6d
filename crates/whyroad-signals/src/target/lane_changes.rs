//! Motion of a target relative to its lane: lane changes, weaving, wrong-way driving.

use crate::estimate::{Aside, stated};
use crate::geometry::{P2, Polyline, p2, wrap};
use crate::road::corridor::Corridor;
use crate::road::lane_change;
use crate::road::lanes::{HEADING_LIMIT_RAD, LanePlace};
use crate::road::network::Road;
use crate::series::GAP_S;
use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use crate::target::lanes::drives;
use crate::target::motion::OPPOSITE_RAD;
use crate::target::placement::{MOVING_MPS, Placement, Target};
use crate::target::rows::Rows;
use std::collections::BTreeMap;
use whyroad_model::Tri;
use whyroad_model::catalog::{id, value::TargetLaneChange};
use whyroad_model::road_map::LaneKind;

/// Minimum width of a swing across the lane, m.
const SWING_M: f64 = 0.5;
/// ... and minimum number of standard deviations of the positions.
const SWING_DEVIATIONS: f64 = 5.0;
/// Minimum number of swings for weaving.
const SWINGS: usize = 3;
/// ... within this time, s.
const SWINGS_WITHIN_S: f64 = 8.0;
/// Half lengths of the chords by which a lane's line is smoothed, in addition to half the vehicle's own length, m. No
/// vehicle follows a line drawn with corners exactly: a vehicle that rounds them swings about it.
const CHORDS_M: [f64; 3] = [5.0, 10.0, 20.0];
/// Minimum speed for weaving, m/s: below it, swings are annotation noise.
const WEAVING_LEAST_MPS: f64 = 1.0;
/// Minimum time against the lanes for wrong-way driving, s.
const WRONG_WAY_S: f64 = 2.0;

/// Lane changes of a target, one value per row; empty for objects that do not drive in lanes.
fn changes(
    road: &Road,
    target: &Target<'_>,
    places: &[Option<LanePlace>],
    times: &[f64],
) -> Vec<Option<TargetLaneChange>> {
    if places.is_empty() {
        return Vec::new();
    }
    let m = &target.track.motion;
    let position: Vec<P2> = (0..m.len()).map(|r| p2(m.x[r], m.y[r])).collect();
    let velocity: Vec<P2> = (0..m.len()).map(|r| p2(m.vx[r], m.vy[r])).collect();
    let row_times: Vec<f64> = target.track.frames.iter().map(|&f| times[f as usize]).collect();
    let asides = |sd| (0..m.len()).map(|r| Aside::new(sd, r, m.speed(r))).collect();
    let aside: Vec<Aside> = target.sd.map_or_else(Vec::new, asides);
    let rows = lane_change::Rows {
        times: &row_times,
        position: &position,
        velocity: &velocity,
        places,
        aside: &aside,
    };
    lane_change::changes(road, &rows)
}

/// Lateral movement of a target across the lanes' direction by row, m; NaN where a range ends.
fn sideways(road: &Road, target: &Target<'_>, places: &[Option<LanePlace>], times: &[f64]) -> Vec<f64> {
    let m = &target.track.motion;
    let time = |r: usize| times[target.track.frames[r] as usize];
    let (mut sum, mut last) = (0.0, None);
    (0..m.len())
        .map(|r| {
            let place = places[r].as_ref().filter(|p| !road.lanes[p.lane].in_junction);
            let velocity = p2(m.vx[r], m.vy[r]);
            let joined = last.is_none_or(|l: usize| time(r) - time(l) <= GAP_S);
            let (Some(place), true) = (place, velocity.norm() >= WEAVING_LEAST_MPS && joined) else {
                last = None;
                return f64::NAN;
            };
            let left = P2::from_heading(road.lanes[place.lane].center.smooth_heading_at(place.s, 2.0)).left();
            sum += last.map_or(0.0, |l| (time(r) - time(l)) * velocity.dot(left));
            last = Some(r);
            sum
        })
        .collect()
}

/// Number of alternating swings of at least `least` m in `values`.
fn swings(values: &[f64], least: f64) -> usize {
    let Some(&start) = values.first() else { return 0 };
    let (mut low, mut high, mut rising, mut count) = (start, start, None, 0);
    for &v in values {
        (low, high) = (low.min(v), high.max(v));
        // A swing is counted when it is wide enough; from then on its end moves with it.
        if rising != Some(true) && v - low >= least {
            (rising, count, high) = (Some(true), count + 1, v);
        } else if rising != Some(false) && high - v >= least {
            (rising, count, low) = (Some(false), count + 1, v);
        }
        if rising == Some(true) {
            low = high;
        } else if rising == Some(false) {
            high = low;
        }
    }
    count
}

/// Offsets from the chords of half length `half` along the lane and its continuations by row, m.
fn off_chords(road: &Road, target: &Target<'_>, places: &[Option<LanePlace>], half: f64) -> Vec<f64> {
    let m = &target.track.motion;
    let mut route: Vec<usize> = places.iter().flatten().map(|p| p.lane).collect();
    route.sort_unstable();
    route.dedup();
    let mut lines: BTreeMap<usize, Option<Corridor>> = BTreeMap::new();
    let chord = |line: &Polyline, s: f64| {
        let (from, to) = (line.point_at(s - half), line.point_at(s + half));
        (from, P2::from_heading((to - from).heading()))
    };
    (0..places.len())
        .map(|r| {
            let Some(place) = &places[r] else { return f64::NAN };
            let corridor = lines.entry(place.lane).or_insert_with(|| Corridor::new(road, place.lane, &route));
            let Some(corridor) = corridor else { return f64::NAN };
            let (from, along) = chord(&corridor.line, corridor.s_of(place));
            along.cross(p2(m.x[r], m.y[r]) - from)
        })
        .collect()
}

/// Lateral position in the lanes by row, m, without the step from one lane's center line to the next: a movement across
/// a line is continued with the lateral movement `across`. `offsets` are those in each row's lane.
fn within_lanes(places: &[Option<LanePlace>], offsets: &[f64], across: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    (0..places.len())
        .map(|r| {
            if let (Some(now), Some(before)) = (&places[r], r.checked_sub(1).and_then(|b| places[b].as_ref()))
            {
                let step = across[r] - across[r - 1];
                let moved = if now.lane == before.lane { offsets[r] - offsets[r - 1] } else { step };
                sum += if moved.is_nan() { 0.0 } else { moved };
            }
            sum
        })
        .collect()
}

/// True by row where `swinging` holds enough swings within the last seconds.
fn swings_often(
    across: &[f64],
    swinging: &[f64],
    time: impl Fn(usize) -> f64,
    least: &dyn Fn(usize) -> f64,
) -> Vec<bool> {
    let mut often = vec![false; across.len()];
    let mut start = 0;
    for stretch in across.split(|v| v.is_nan()) {
        let rows = start..start + stretch.len();
        start = rows.end + 1;
        let narrowest = rows.clone().map(least).fold(f64::INFINITY, f64::min);
        // No part of it has more swings than the whole.
        if swings(&swinging[rows.clone()], narrowest) < SWINGS {
            continue;
        }
        let mut first = rows.start;
        for r in rows {
            while time(r) - time(first) > SWINGS_WITHIN_S {
                first += 1;
            }
            often[r] = swings(&swinging[first..=r], least(r)) >= SWINGS;
        }
    }
    often
}

fn weaves(road: &Road, target: &Target<'_>, places: &[Option<LanePlace>], times: &[f64]) -> Vec<Tri> {
    if places.is_empty() {
        return vec![Tri::False; target.places.len()];
    }
    let across = sideways(road, target, places, times);
    let time = |r: usize| times[target.track.frames[r] as usize];
    // A lane that shifts to the side moves its vehicles across its own direction, and a center line with a corner moves
    // them in it for a moment; a weaving vehicle swings in both, and also about the line without its corners.
    let own_half = target.track.length_m.iter().copied().find(|l| l.is_finite()).map(|l| l / 2.0);
    let weaving = |least: &dyn Fn(usize) -> f64| {
        let mut weaving = swings_often(&across, &across, time, least);
        let drawn = places.iter().map(|p| p.as_ref().map_or(f64::NAN, |p| p.lateral)).collect();
        let smoothed = own_half.into_iter().chain(CHORDS_M);
        let references = smoothed.map(|half| move || off_chords(road, target, places, half));
        let mut narrow = |offsets: Vec<f64>| {
            let within = swings_often(&across, &within_lanes(places, &offsets, &across), time, least);
            weaving.iter_mut().zip(within).for_each(|(w, also)| *w = *w && also);
            weaving.contains(&true)
        };
        if narrow(drawn) {
            for offsets in references {
                if !narrow(offsets()) {
                    break;
                }
            }
        }
        weaving
    };
    let seen = weaving(&|_| SWING_M);
    // A vehicle that swings no more than its noise may weave or not.
    let least =
        |r: usize| target.sd.map_or(SWING_M, |sd| SWING_M.max(SWING_DEVIATIONS * stated(sd.position[r])));
    let is_noisy = (0..seen.len()).any(|r| seen[r] && least(r) > SWING_M);
    let certain = if is_noisy { weaving(&least) } else { seen.clone() };
    seen.into_iter().zip(certain).map(|(s, c)| if s && !c { Tri::Unknown } else { Tri::from(s) }).collect()
}

/// Against all lanes for vehicles at its position, outside of junctions. `own` is its place on its lane.
fn against(road: &Road, target: &Target<'_>, row: usize, own: Option<&LanePlace>, p: &Placement) -> bool {
    if p.speed() < MOVING_MPS || target.is_in_junction(road, row) {
        return false;
    }
    let holds = |i: usize| {
        let lane = &road.lanes[i];
        matches!(lane.kind, LaneKind::Vehicle | LaneKind::Bus)
            && lane.area.as_ref().is_some_and(|a| a.contains(p.footprint.center))
    };
    // Its box is turned by no more than that from its own lane: mostly its course is certainly not against it.
    let along_own = wrap(p.course() - p.footprint.heading).abs() + HEADING_LIMIT_RAD + 1e-6 < OPPOSITE_RAD;
    if along_own && own.is_some_and(|own| holds(own.lane)) {
        return false;
    }
    let here = road.lanes_around(p.footprint.center).filter(|&i| holds(i));
    let mut any = false;
    for i in here {
        let center = &road.lanes[i].center;
        let along = center.smooth_heading_at(center.project(p.footprint.center).s, 2.0);
        if wrap(p.course() - along).abs() < OPPOSITE_RAD {
            return false;
        }
        any = true;
    }
    any
}

fn wrong_way(road: &Road, target: &Target<'_>, places: &[Option<LanePlace>], times: &[f64]) -> Vec<Tri> {
    // Of whom neither motion nor heading is known, no way is.
    let is_told = |p: &Option<Placement>| p.as_ref().is_some_and(|p| !(p.course() + p.speed()).is_nan());
    let mut flags: Vec<Tri> =
        target.places.iter().map(|p| if is_told(p) { Tri::False } else { Tri::Unknown }).collect();
    if !drives(target.track.class) {
        return flags;
    }
    let mut run: Vec<usize> = Vec::new();
    let time = |r: usize| times[target.track.frames[r] as usize];
    for r in 0..=flags.len() {
        let own = places.get(r).and_then(Option::as_ref);
        let goes_on = r < flags.len()
            && is_told(&target.places[r])
            && target.places[r].as_ref().is_some_and(|p| against(road, target, r, own, p))
            && run.last().is_none_or(|&l| time(r) - time(l) <= GAP_S);
        if goes_on {
            run.push(r);
            continue;
        }
        if let (Some(&a), Some(&b)) = (run.first(), run.last())
            && time(b) - time(a) > WRONG_WAY_S
        {
            flags[a..=b].fill(Tri::True);
        }
        run.clear();
    }
    flags
}

/// Writes `target.lane_change`, `weaves`, `wrong_way`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let (Some(road), Some(lanes)) = (scene.around.road, scene.lanes()) else { return };
    let rows = Rows::new(scene.drive, table);
    let (targets, times) = (scene.targets, scene.times);
    let each = || targets.iter().zip(&lanes.places);
    let codes: Vec<_> = each().map(|(t, places)| changes(road, t, places, times)).collect();
    table.category(
        id::TARGET_LANE_CHANGE,
        rows.spread(targets, None, |k, r, _| codes[k].get(r).copied().flatten()),
    );
    let weaving: Vec<_> = each().map(|(t, places)| weaves(road, t, places, times)).collect();
    table.flag(id::TARGET_WEAVES, rows.spread(targets, Tri::Unknown, |k, r, _| weaving[k][r]));
    let wrong: Vec<_> = each().map(|(t, places)| wrong_way(road, t, places, times)).collect();
    table.flag(id::TARGET_WRONG_WAY, rows.spread(targets, Tri::Unknown, |k, r, _| wrong[k][r]));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn swings_by_hand() {
        assert_eq!(swings(&[0.0, 0.2, 0.4, 0.2, 0.0], SWING_M), 0, "none is half a meter wide");
        assert_eq!(swings(&[0.0, 1.0, 2.0, 3.5], SWING_M), 1, "a lane change");
        assert_eq!(swings(&[0.0, 0.6, 0.0], SWING_M), 2, "out and back");
        assert_eq!(swings(&[0.0, 0.6, 0.5, 0.7, 0.0, -0.1, 0.5], SWING_M), 3);
        assert_eq!(swings(&[], SWING_M), 0);
        assert_eq!(swings(&[0.0, 0.6, -0.1, 0.7], 1.0), 0, "none is a meter wide");
    }
}
